//! The exchange between the servo and the thread of a device: newest poses one way, newest wrenches the other, each
//! through a triple buffer, so that neither waits for the other.
//!
//! The thread releases the force by itself if the servo has not written for [`WATCHDOG`], and the servo reports the
//! device as lost if the thread has sent no pose for [`SILENCE`]. Times are passed in, so that both can be tested
//! without waiting.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::time::{Duration, Instant};

use feeler_core::Pose;
use feeler_haptics::device::{DeviceError, DeviceInfo, DeviceState};
use feeler_haptics::{Twist, Wrench};
use triple_buffer::{triple_buffer, Input, Output};

use crate::clip::clipped;
use crate::constants::{FIRST_POSE_WAIT, LOOK_AGAIN, RELEASE_WAIT, SILENCE, WATCHDOG};

/// One measurement, device frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Measured {
    pub pose: Pose,
    pub twist: Option<Twist>,
    pub buttons: u32,
    /// When.
    pub at: Instant,
}

#[derive(Debug, Clone, PartialEq)]
enum Told {
    Nothing,
    Measured(Measured),
    Failed(DeviceError),
}

/// A wrench, and when it was written; never if the servo has written none yet.
#[derive(Debug, Clone, Copy)]
struct Ordered {
    wrench: Wrench,
    at: Option<Instant>,
}

#[derive(Debug, Default)]
struct Flags {
    /// The servo wants the thread to end.
    is_released: AtomicBool,
    /// The thread has ended; the force is off.
    has_let_go: AtomicBool,
}

/// The servo's end.
pub(crate) struct ServoEnd {
    info: DeviceInfo,
    told: Output<Told>,
    ordered: Input<Ordered>,
    flags: Arc<Flags>,
    /// When the newest measurement was made, by this machine's clock and by the caller's.
    newest: Option<(Instant, f64)>,
}

/// The end of the thread that talks to the device. Dropping it says that the thread has ended and the force is off.
pub(crate) struct DeviceEnd {
    name: String,
    told: Input<Told>,
    ordered: Output<Ordered>,
    flags: Arc<Flags>,
}

/// Both ends, of a device with this name. The servo's end is complete when the device is known: [`ServoEnd::describe`].
pub(crate) fn exchange(info: DeviceInfo) -> (ServoEnd, DeviceEnd) {
    let (told_in, told_out) = triple_buffer(&Told::Nothing);
    let (ordered_in, ordered_out) = triple_buffer(&Ordered { wrench: Wrench::ZERO, at: None });
    let flags = Arc::new(Flags::default());
    let name = info.name.clone();
    let servo = ServoEnd { info, told: told_out, ordered: ordered_in, flags: flags.clone(), newest: None };
    (servo, DeviceEnd { name, told: told_in, ordered: ordered_out, flags })
}

impl ServoEnd {
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// Waits for the first measurement, for opening a device. Errors: the thread's error, or none within the time.
    pub fn wait_for_first(&mut self) -> Result<(), DeviceError> {
        let started = Instant::now();
        loop {
            match self.told.read() {
                Told::Measured(_) => return Ok(()),
                Told::Failed(error) => return Err(error.clone()),
                Told::Nothing if started.elapsed() > FIRST_POSE_WAIT => {
                    return Err(self.lost(format!("it told no pose within {} s", FIRST_POSE_WAIT.as_secs_f64())));
                }
                Told::Nothing => std::thread::sleep(LOOK_AGAIN),
            }
        }
    }

    /// The newest state, its time on the caller's clock. `at`: this machine's time at `now`.
    pub fn read(&mut self, now: f64, at: Instant) -> Result<DeviceState, DeviceError> {
        if self.flags.is_released.load(Ordering::Acquire) {
            return Err(self.lost("it is released".to_string()));
        }
        let measured = match self.told.read() {
            Told::Measured(measured) => *measured,
            Told::Failed(error) => return Err(error.clone()),
            Told::Nothing => return Err(self.lost("it has told no pose yet".to_string())),
        };
        let age = at.saturating_duration_since(measured.at);
        if age > SILENCE {
            return Err(self.lost(format!("its newest pose is {:.0} ms old", 1e3 * age.as_secs_f64())));
        }
        let time = match self.newest {
            Some((same, time)) if same == measured.at => time,
            Some((_, before)) => before.max(now - age.as_secs_f64()),
            None => now - age.as_secs_f64(),
        };
        self.newest = Some((measured.at, time));
        Ok(DeviceState::new(measured.pose, time).with_twist(measured.twist).with_buttons(measured.buttons))
    }

    /// Hands the thread a wrench, clipped to the device. `at`: this machine's time.
    pub fn write(&mut self, wrench: &Wrench, at: Instant) -> Result<(), DeviceError> {
        if self.flags.is_released.load(Ordering::Acquire) {
            return Err(self.lost("it is released".to_string()));
        }
        let wrench = clipped(wrench, &self.info);
        self.ordered.write(Ordered { wrench, at: Some(at) });
        Ok(())
    }

    /// Takes the force away and ends the thread; waits for it, but no longer than [`RELEASE_WAIT`]. True if it has ended.
    pub fn release(&mut self) -> bool {
        self.ordered.write(Ordered { wrench: Wrench::ZERO, at: None });
        self.flags.is_released.store(true, Ordering::Release);
        let started = Instant::now();
        while !self.flags.has_let_go.load(Ordering::Acquire) {
            if started.elapsed() > RELEASE_WAIT {
                return false;
            }
            std::thread::sleep(LOOK_AGAIN);
        }
        true
    }

    fn lost(&self, why: String) -> DeviceError {
        DeviceError::Lost { device: self.info.name.clone(), why }
    }
}

impl Drop for ServoEnd {
    fn drop(&mut self) {
        self.release();
    }
}

impl DeviceEnd {
    /// The name in errors.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Tells a measurement, or why there is none.
    pub fn tell(&mut self, told: Result<Measured, DeviceError>) {
        self.told.write(match told {
            Ok(measured) => Told::Measured(measured),
            Err(error) => Told::Failed(error),
        });
    }

    /// The wrench that the device should have at a time: none after a release, none when the servo has not written for [`WATCHDOG`].
    pub fn wrench(&mut self, at: Instant) -> Wrench {
        let ordered = *self.ordered.read();
        let age = ordered.at.map_or(Duration::MAX, |written| at.saturating_duration_since(written));
        if self.is_released() || age > WATCHDOG {
            return Wrench::ZERO;
        }
        ordered.wrench
    }

    /// Whether the thread has to end.
    pub fn is_released(&self) -> bool {
        self.flags.is_released.load(Ordering::Acquire)
    }

    /// That the connection is lost.
    pub fn lost(&self, why: impl ToString) -> DeviceError {
        DeviceError::Lost { device: self.name.clone(), why: why.to_string() }
    }
}

impl Drop for DeviceEnd {
    fn drop(&mut self) {
        self.flags.has_let_go.store(true, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::device;

    fn measured(at: Instant) -> Measured {
        Measured { pose: Pose::IDENTITY, twist: None, buttons: 3, at }
    }

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn a_pose_has_the_time_of_its_measurement_on_the_callers_clock() {
        let (mut servo, mut end) = exchange(device(5.0, 0.0));
        let start = Instant::now();
        end.tell(Ok(measured(start)));
        let first = servo.read(100.0, start + 4 * MS).unwrap();
        assert!((first.time - 99.996).abs() < 1e-9, "{first:?}");
        assert_eq!(first.buttons, 3);
        // Nothing new: the same time, whatever the clock says meanwhile.
        assert_eq!(servo.read(100.01, start + 15 * MS).unwrap().time, first.time);
        end.tell(Ok(measured(start + 20 * MS)));
        assert!(servo.read(100.02, start + 20 * MS).unwrap().time > first.time);
    }

    #[test]
    fn a_silent_device_is_lost_and_comes_back() {
        let (mut servo, mut end) = exchange(device(5.0, 0.0));
        let start = Instant::now();
        assert!(matches!(servo.read(0.0, start), Err(DeviceError::Lost { .. })));
        end.tell(Ok(measured(start)));
        assert!(servo.read(0.1, start + SILENCE).is_ok());
        assert!(matches!(servo.read(0.2, start + SILENCE + MS), Err(DeviceError::Lost { .. })));
        end.tell(Ok(measured(start + 2 * SILENCE)));
        assert!(servo.read(0.3, start + 2 * SILENCE).is_ok());
    }

    #[test]
    fn errors_are_told_until_there_is_a_pose_again() {
        let (mut servo, mut end) = exchange(device(5.0, 0.0));
        let start = Instant::now();
        let error = DeviceError::Nonsense { device: "test".to_string(), what: "NaN".to_string() };
        end.tell(Err(error.clone()));
        assert_eq!(servo.read(0.0, start), Err(error.clone()));
        assert_eq!(servo.read(0.1, start), Err(error));
        end.tell(Ok(measured(start)));
        assert!(servo.read(0.2, start).is_ok());
    }

    #[test]
    fn a_wrench_is_clipped_and_holds_only_as_long_as_the_watchdog() {
        let (mut servo, mut end) = exchange(device(5.0, 0.0));
        let start = Instant::now();
        assert_eq!(end.wrench(start), Wrench::ZERO);
        servo.write(&Wrench { force: [0.0, 10.0, 0.0], torque: [1.0; 3] }, start).unwrap();
        let given = Wrench { force: [0.0, 5.0, 0.0], torque: [0.0; 3] };
        assert_eq!(end.wrench(start), given);
        assert_eq!(end.wrench(start + WATCHDOG), given);
        assert_eq!(end.wrench(start + WATCHDOG + MS), Wrench::ZERO);
        servo.write(&Wrench { force: [0.0, 10.0, 0.0], torque: [0.0; 3] }, start + 3 * WATCHDOG).unwrap();
        assert_eq!(end.wrench(start + 3 * WATCHDOG), given);
    }

    #[test]
    fn a_released_device_has_no_force_and_takes_none() {
        let (mut servo, mut end) = exchange(device(5.0, 0.0));
        let start = Instant::now();
        servo.write(&Wrench { force: [1.0, 0.0, 0.0], torque: [0.0; 3] }, start).unwrap();
        let thread = std::thread::spawn(move || {
            while !end.is_released() {
                std::thread::sleep(MS);
            }
            end.wrench(start)
        });
        assert!(servo.release());
        assert_eq!(thread.join().unwrap(), Wrench::ZERO);
        assert!(servo.read(0.0, start).is_err());
        assert!(servo.write(&Wrench::ZERO, start).is_err());
    }

    #[test]
    fn a_thread_that_hangs_does_not_hold_up_a_release() {
        let (mut servo, end) = exchange(device(5.0, 0.0));
        assert!(!servo.release());
        assert!(end.is_released());
    }

    #[test]
    fn dropping_the_servos_end_ends_the_thread() {
        let (servo, mut end) = exchange(device(5.0, 0.0));
        let thread = std::thread::spawn(move || {
            while !end.is_released() {
                std::thread::sleep(MS);
            }
            end.wrench(Instant::now())
        });
        drop(servo);
        assert_eq!(thread.join().unwrap(), Wrench::ZERO);
    }
}
