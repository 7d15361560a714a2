//! A [`Mouse`] that another thread steers, through a triple buffer: neither waits for the other.

use feeler_core::geometry::twist::Wrench;
use feeler_core::Pose;
use triple_buffer::{triple_buffer, Input, Output};

use super::mouse::Mouse;
use super::{Device, DeviceError, DeviceInfo, DeviceState};

/// The pose and the buttons requested.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Wish {
    pose: Pose,
    buttons: u32,
}

/// See the [module](self).
#[derive(Debug)]
pub struct Steered {
    mouse: Mouse,
    wishes: Output<Wish>,
}

/// The end that steers.
#[derive(Debug)]
pub struct Steering {
    wish: Wish,
    wishes: Input<Wish>,
}

/// A mouse at rest at a pose, and its steering.
pub fn steered(mouse: Mouse, at: Pose) -> (Steered, Steering) {
    let wish = Wish { pose: at, buttons: 0 };
    let (input, output) = triple_buffer(&wish);
    (Steered { mouse, wishes: output }, Steering { wish, wishes: input })
}

impl Steering {
    /// Where to go from now on, `device_from_handle`. It goes there smoothly.
    pub fn set_target(&mut self, pose: Pose) {
        self.wish.pose = pose;
        self.wishes.write(self.wish);
    }

    /// Which buttons are held from now on, a bit each.
    pub fn set_buttons(&mut self, buttons: u32) {
        self.wish.buttons = buttons;
        self.wishes.write(self.wish);
    }
}

impl Device for Steered {
    fn info(&self) -> &DeviceInfo {
        self.mouse.info()
    }

    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
        if self.wishes.update() {
            let Wish { pose, buttons } = *self.wishes.output_buffer();
            self.mouse.set_target(pose, now);
            self.mouse.set_buttons(buttons);
        }
        self.mouse.read(now)
    }

    fn write(&mut self, wrench: &Wrench, now: f64) -> Result<(), DeviceError> {
        self.mouse.write(wrench, now)
    }

    fn release(&mut self) {
        self.mouse.release();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_goes_to_the_newest_target() {
        let (mut device, mut steering) = steered(Mouse::new(Pose::IDENTITY), Pose::IDENTITY);
        assert_eq!(device.read(0.0).unwrap().pose, Pose::IDENTITY);
        for x in [0.3, 0.1] {
            steering.set_target(Pose::IDENTITY.translated(&[x, 0.0, 0.0]).unwrap());
        }
        steering.set_buttons(2);
        let mut last = 0.0;
        for k in 1..1000 {
            let state = device.read(f64::from(k) * 1e-3).unwrap();
            let x = state.pose.translation()[0];
            assert!(x >= last && x <= 0.1, "{k}: {x}");
            assert_eq!(state.buttons, 2);
            last = x;
        }
        assert!((last - 0.1).abs() < 1e-9, "{last}");
    }
}
