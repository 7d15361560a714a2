//! Reads a haptic device for two seconds and prints where its handle is. Without a name it lists the drivers. It sends no force.
//!
//!     cargo run --release -p feeler-devices --example read -- spacemouse

use feeler_devices::machine::MonotonicClock;
use feeler_devices::{open, Options, DRIVERS};
use feeler_haptics::device::DeviceError;

fn main() -> Result<(), DeviceError> {
    let Some(name) = std::env::args().nth(1) else {
        println!("name a driver:");
        for (name, what) in DRIVERS {
            println!("  {name:12} {what}");
        }
        return Ok(());
    };
    // Each driver has its options: a library's path, a service's address, limits.
    let mut device = open(&name, &Options::default())?;
    let info = device.info().clone();
    println!("{}: {} buttons, at most {} N", info.name, info.buttons, info.limits.force_n);
    let clock = MonotonicClock::new();
    let begin = clock.now();
    for tick in 0..20 {
        clock.sleep_until(begin + 0.1 * f64::from(tick));
        // `read` never waits: a thread of the driver keeps the newest state.
        let state = device.read(clock.now())?;
        println!("at {:.3?} m, buttons {:b}", state.pose.translation(), state.buttons);
    }
    device.release();
    Ok(())
}
