//! Opens devices by the name of their driver.

use feeler_haptics::device::{Device, DeviceError};

use crate::dhd::{Dhd, DhdOptions};
use crate::haply::{Haply, HaplyOptions};
use crate::openhaptics::{OpenHaptics, OpenHapticsOptions};
use crate::spacemouse::{SpaceMouse, SpaceMouseOptions};

/// Options of all drivers; each takes its own.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Options {
    /// Of `spacemouse`.
    pub spacemouse: SpaceMouseOptions,
    /// Of `haply`.
    pub haply: HaplyOptions,
    /// Of `dhd`.
    pub dhd: DhdOptions,
    /// Of `openhaptics`.
    pub openhaptics: OpenHapticsOptions,
}

impl Options {
    feeler_core::setters! {
        with_spacemouse: spacemouse: SpaceMouseOptions,
        with_haply: haply: HaplyOptions,
        with_dhd: dhd: DhdOptions,
        with_openhaptics: openhaptics: OpenHapticsOptions,
    }
}

/// Names that [`open`] knows, with what each is for.
pub const DRIVERS: [(&str, &str); 4] = [
    ("spacemouse", "a SpaceMouse, through spacenavd"),
    ("haply", "Haply Inverse3 with or without a VerseGrip, through the Inverse Service"),
    ("dhd", "Force Dimension omega, delta, sigma, lambda and Novint Falcon, through libdhd"),
    ("openhaptics", "3D Systems Touch and Phantom, through OpenHaptics"),
];

/// Opens a device by the name of its driver. Errors where no driver has that name, with those that there are, and as the driver does.
///
/// ```
/// let error = feeler_devices::open("joystick", &Default::default()).err().unwrap();
/// assert!(error.to_string().contains("spacemouse, haply, dhd, openhaptics"));
/// ```
pub fn open(name: &str, options: &Options) -> Result<Box<dyn Device>, DeviceError> {
    Ok(match name {
        "spacemouse" => Box::new(SpaceMouse::open(&options.spacemouse)?),
        "haply" => Box::new(Haply::open(&options.haply)?),
        "dhd" => Box::new(Dhd::open(&options.dhd)?),
        "openhaptics" => Box::new(OpenHaptics::open(&options.openhaptics)?),
        _ => {
            let names = DRIVERS.map(|(name, _)| name).join(", ");
            let why = format!("no driver has this name; there are {names}");
            return Err(DeviceError::NotFound { device: name.to_string(), why });
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_driver_that_is_listed_is_known() {
        // None of these devices exists: each driver is reached, and names what it misses.
        let nowhere = std::path::PathBuf::from("/nowhere/at-all");
        let mut options = Options::default();
        options.spacemouse.socket = Some(nowhere.clone());
        options.haply.address = "127.0.0.1:1".to_string();
        options.dhd.library = Some(nowhere.clone());
        options.openhaptics.library = Some(nowhere);
        for (name, _) in DRIVERS {
            match open(name, &options).err() {
                Some(DeviceError::NotFound { device, why }) => {
                    assert!(device != name && why.len() > 30, "{device}: {why}")
                }
                other => panic!("{name}: {other:?}"),
            }
        }
    }

    #[test]
    fn an_unknown_name_says_which_exist() {
        let error = open("mouse", &Options::default()).err().unwrap().to_string();
        assert!(DRIVERS.iter().all(|(name, _)| error.contains(name)), "{error}");
    }
}
