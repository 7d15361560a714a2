//! Drivers of haptic devices for `feeler-haptics`, and what real-time threads need of the machine.
//!
//! Each driver is a [`Device`](feeler_haptics::device::Device) whose `read` and `write` never wait: a thread of its own talks to the
//! device and keeps the newest pose and the newest wrench. Forces are clipped to what the device can, and become nothing where a number
//! is not finite, when the servo has not written for 50 ms, and when the device is released or dropped.
//!
//! | driver | devices | talks to | moves the hand |
//! |---|---|---|---|
//! | [`spacemouse`] | SpaceMouse | spacenavd's socket | no |
//! | [`haply`] | Haply Inverse3, VerseGrip | the Inverse Service's websocket | force |
//! | [`dhd`] | Force Dimension, Novint Falcon | `libdhd`, loaded when opened | force; torque with an active wrist |
//! | [`openhaptics`] | 3D Systems Touch, Phantom | `libHD`, loaded when opened | force |
//!
//! ```no_run
//! use feeler_devices::{machine::MonotonicClock, open, Options};
//!
//! let mut device = open("spacemouse", &Options::default())?;
//! let clock = MonotonicClock::new();
//! let state = device.read(clock.now())?;
//! println!("{}: {:?}", device.info().name, state.pose.translation());
//! # Ok::<(), feeler_haptics::device::DeviceError>(())
//! ```

mod clip;
#[cfg_attr(not(unix), allow(dead_code, reason = "those of spacenavd, which is for Unix only"))]
mod constants;
pub mod dhd;
mod exchange;
mod figures;
pub mod haply;
pub mod machine;
mod numbers;
mod open;
pub mod openhaptics;
#[cfg_attr(not(unix), allow(dead_code, reason = "the daemon's messages are tested everywhere, but read on Unix only"))]
pub mod spacemouse;
mod vendor_library;

#[cfg(test)]
mod tests;

pub use figures::{Figures, FIGURES};
pub use numbers::option_range;
pub use open::{open, Options, DRIVERS};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
