//! The numbers among the options of drivers: a range for each name, whichever driver has it.

use feeler_haptics::device::DeviceError;

/// What a number must be.
struct Range {
    name: &'static str,
    /// In words, with its unit.
    words: &'static str,
    least: f64,
    most: f64,
    /// Whether it may be the least itself.
    with_least: bool,
}

const fn from(name: &'static str, least: f64, most: f64, words: &'static str) -> Range {
    Range { name, words, least, most, with_least: true }
}

const fn above(name: &'static str, least: f64, most: f64, words: &'static str) -> Range {
    Range { name, words, least, most, with_least: false }
}

const RANGES: [Range; 9] = [
    from("force_n", 0.0, 1e3, "newtons, 0 to 1000"),
    from("torque_nm", 0.0, 1e3, "newton metres, 0 to 1000"),
    above("stiffness_n_per_m", 0.0, 1e6, "newtons per metre, more than 0, at most 1e6"),
    above("speed_m_per_s", 0.0, 100.0, "metres per second, more than 0, at most 100"),
    above("turn_rad_per_s", 0.0, 100.0, "radians per second, more than 0, at most 100"),
    above("full_deflection_counts", 0.0, 1e6, "a number, more than 0, at most 1e6"),
    from("dead_zone", 0.0, 0.99, "a number, 0 to 0.99"),
    above("reach_m", 0.0, 1e3, "metres, more than 0, at most 1000"),
    above("silence_s", 0.0, f64::INFINITY, "seconds, more than 0"),
];

fn range_of(name: &str) -> Option<&'static Range> {
    RANGES.iter().find(|range| range.name == name)
}

/// The range of a driver's option in words, such as "newtons, 0 to 1000"; `None` for an option that is no number.
pub fn option_range(name: &str) -> Option<&'static str> {
    range_of(name).map(|range| range.words)
}

/// Errors for the first of these options that is given and out of its range.
pub(crate) fn check<const N: usize>(options: [(&'static str, Option<f64>); N]) -> Result<(), DeviceError> {
    for (name, given) in options {
        let (Some(range), Some(value)) = (range_of(name), given) else { continue };
        if !(value >= range.least && value <= range.most) || (value == range.least && !range.with_least) {
            return Err(DeviceError::Option { name, value, range: range.words });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{open, Options, DRIVERS};

    /// Each driver with one of its numbers changed.
    fn with(driver: &str, name: &str, value: f64) -> Option<Options> {
        let mut options = Options::default();
        match (driver, name) {
            ("spacemouse", "speed_m_per_s") => options.spacemouse.speed_m_per_s = value,
            ("spacemouse", "turn_rad_per_s") => options.spacemouse.turn_rad_per_s = value,
            ("spacemouse", "full_deflection_counts") => options.spacemouse.full_deflection_counts = value,
            ("spacemouse", "dead_zone") => options.spacemouse.dead_zone = value,
            ("spacemouse", "reach_m") => options.spacemouse.reach_m = value,
            ("spacemouse", "silence_s") => options.spacemouse.silence_s = value,
            ("haply", "force_n") => options.haply.force_n = Some(value),
            ("haply", "stiffness_n_per_m") => options.haply.stiffness_n_per_m = Some(value),
            ("dhd", "force_n") => options.dhd.force_n = Some(value),
            ("dhd", "torque_nm") => options.dhd.torque_nm = Some(value),
            ("dhd", "stiffness_n_per_m") => options.dhd.stiffness_n_per_m = Some(value),
            ("openhaptics", "force_n") => options.openhaptics.force_n = Some(value),
            ("openhaptics", "stiffness_n_per_m") => options.openhaptics.stiffness_n_per_m = Some(value),
            _ => return None,
        }
        Some(options)
    }

    #[test]
    fn every_driver_refuses_numbers_out_of_range_before_it_looks_for_a_device() {
        let mut asked = Vec::new();
        for (driver, _) in DRIVERS {
            for range in &RANGES {
                let outside = [range.least - 1e-9, f64::NAN, f64::NEG_INFINITY].into_iter();
                let beyond = [range.most * 1.01, f64::INFINITY].into_iter().filter(|_| range.most.is_finite());
                for value in outside.chain(beyond).chain((!range.with_least).then_some(range.least)) {
                    let Some(options) = with(driver, range.name, value) else { continue };
                    match open(driver, &options).err() {
                        Some(DeviceError::Option { name, range: words, .. }) => {
                            assert_eq!((name, words), (range.name, range.words))
                        }
                        other => panic!("{driver}, {} = {value}: {other:?}", range.name),
                    }
                    asked.push((driver, range.name));
                }
            }
        }
        asked.dedup();
        assert_eq!(asked.len(), 13);
    }

    #[test]
    fn both_ends_of_a_range_are_numbers_that_may_be_given() {
        for range in &RANGES {
            let least = if range.with_least { range.least } else { f64::MIN_POSITIVE };
            assert!(check([(range.name, Some(least)), (range.name, Some(range.most)), (range.name, None)]).is_ok());
        }
    }
}
