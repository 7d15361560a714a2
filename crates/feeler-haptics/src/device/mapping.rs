//! From the device's frame to the world, and back: scale, clutch, and the border of the workspace.
//!
//! - **Motion.** The handle is where the hand holds the tool, at its centre: `place of the centre = at + scale * B * handle`,
//!   `rotation = B * handle * H`. `B`, the rotation of the device's axes into the world, is given; the clutch changes `at` and `H`.
//! - **Clutch.** While its button is pressed the tool stays, and the hand moves the handle to where it has room. After
//!   the release the tool follows again from where it is, turned about the world's axes as the hand turns about the
//!   device's. A wrench during the re-indexing would let the hand gain energy for nothing, so there is none: pass
//!   [`Mapped::is_clutched`] to [`ForceInput::in_doubt`](crate::ForceInput::in_doubt), and the force then returns
//!   gently.
//! - **Force.** The transpose of the motion, divided by the scale: the force is *unscaled*, so that a part weighs the
//!   same at any scale, and the torque is divided by the scale, because arms are in the hand's world. All six powers
//!   are then one factor of the tool's (`1 / scale`), and a passive tool is passive at the hand. The hand feels `scale`
//!   times the stiffness; therefore the coupling is limited to [`Mapping::info_in_world`].
//! - **Rate control.** A device whose cap springs back reports velocities, and its pose is their sum. That pose stays as near to the proxy
//!   as the velocity moves it in 10 ms: after a long push into a wall, the tool comes back at once.
//! - **Border.** A soft wall inside the workspace's border pushes the hand back gently, before the mechanism does it
//!   hard. Nothing drifts: the tool moves only when the hand does, which users rely on when they judge clearances; the
//!   clutch gives room.

use feeler_core::geometry::twist::{
    displaced, displacement, pose_of, product, times, transposed, Matrix, Twist, Wrench,
};
use feeler_core::geometry::vectors::{add, length, scaled, sub};
use feeler_core::{Point, Pose};

use super::{DeviceInfo, DeviceState};
use crate::constants::{LEAD_S, SCALES, WALL_DEPTH, WALL_FORCE_SHARE, WALL_SHARE};
use crate::error::{Error, Result};
use crate::saturation::{added_within, saturated};

/// A device's state in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mapped {
    /// Where the hand wants the tool.
    pub world_from_tool: Pose,
    /// Velocity where the hand holds the tool, world axes, if the device reports one. Zero while clutched.
    pub twist: Option<Twist>,
    /// The clutch is held.
    pub is_clutched: bool,
    /// Buttons that are held, a bit each.
    pub held: u32,
    /// Buttons that were not held the last time, and are.
    pub pressed: u32,
    /// Buttons that were held the last time, and are not.
    pub released: u32,
}

/// Puts a device into the tool's world, and wrenches back into the device's.
#[derive(Debug, Clone, PartialEq)]
pub struct Mapping {
    info: DeviceInfo,
    scale: f64,
    clutch: u32,
    world_from_device: Matrix,
    /// Where the device's origin is in the world.
    at: Point,
    /// Where the hand holds the tool, tool frame.
    centre: Point,
    handle_from_tool: Matrix,
    /// Where the tool stays while the clutch is held.
    kept: Option<Pose>,
    handle: Pose,
    held: u32,
    walls: [Wall; 3],
}

/// The soft wall across one axis, on both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Wall {
    /// Where it begins, metres from the middle.
    from: f64,
    stiffness: f64,
    most: f64,
}

impl Mapping {
    /// `scale`: how far the tool moves in the world for a metre of the handle. `world_from_device`: which way the device looks, and
    /// where the tool's frame is at the beginning while the handle is at the origin of its own, not turned. `clutch_button`: number of
    /// the button (0 is the first), `None` for no clutch. `centre`: where the hand holds the tool, tool frame. Errors where the scale is not between 1/1000 and 1000, the device has no such
    /// button, or its limits are out of their ranges.
    pub fn new(
        info: &DeviceInfo,
        scale: f64,
        world_from_device: &Pose,
        clutch_button: Option<u32>,
        centre: Point,
    ) -> Result<Mapping> {
        let [least, most] = SCALES;
        if !(least..=most).contains(&scale) {
            return Err(Error::Option { what: "scale", value: scale, range: "between 0.001 and 1000" });
        }
        let clutch = match clutch_button {
            Some(button) if button >= info.buttons.min(32) => {
                let range = "less than the device's number of buttons";
                return Err(Error::Option { what: "clutch button", value: button.into(), range });
            }
            Some(button) => 1 << button,
            None => 0,
        };
        let limits = &info.limits;
        limits.check()?;
        let own_rate_hz = limits.own_rate_hz();
        let slowed = limits.slowed(own_rate_hz);
        let held = match (limits.damping_n_s_per_m, limits.stiffness_n_per_m) {
            (0.0, 0.0) => f64::INFINITY,
            (0.0, stiffness) => WALL_SHARE * slowed * stiffness,
            (damping, _) => WALL_SHARE * damping / limits.hold_s(own_rate_hz),
        };
        let softened = if held.is_finite() { 1.0 } else { slowed };
        let walls = info.workspace.map(|half| {
            let depth = WALL_DEPTH * half;
            let is_there = info.driven.translation && half.is_finite() && half > 0.0;
            let most = WALL_FORCE_SHARE * limits.force_n;
            Wall { from: half - depth, stiffness: if is_there { held.min(softened * most / depth) } else { 0.0 }, most }
        });
        Ok(Mapping {
            info: info.clone(),
            scale,
            clutch,
            world_from_device: *world_from_device.rotation(),
            at: world_from_device.apply(&centre),
            centre,
            handle_from_tool: *Pose::IDENTITY.rotation(),
            kept: None,
            handle: Pose::IDENTITY,
            held: 0,
            walls,
        })
    }

    /// The device's limits, as felt in the tool's world: a coupling there is limited to them.
    pub fn info_in_world(&self) -> DeviceInfo {
        let s = self.scale;
        let mut info = self.info.clone();
        info.workspace = info.workspace.map(|half| half * s);
        let limits = &mut info.limits;
        // The same force over s times the way, and s times the torque over the same turn.
        limits.stiffness_n_per_m /= s;
        limits.damping_n_s_per_m /= s;
        limits.resolution_m *= s;
        limits.torque_nm *= s;
        limits.rotational_stiffness_nm_per_rad *= s;
        limits.rotational_damping_nm_s_per_rad *= s;
        limits.rotational_friction_nm *= s;
        info
    }

    /// The device's state in the world. Call it once for each state, in their order. Errors where the tool would be
    /// beyond the coordinate limit.
    pub fn update(&mut self, state: &DeviceState) -> Result<Mapped> {
        let before = self.held;
        let was_clutched = self.kept.is_some();
        let is_clutched = state.buttons & self.clutch != 0;
        if is_clutched && !was_clutched {
            // Where the tool was when the button was not yet held.
            self.kept = Some(self.tool()?);
        }
        self.handle = state.pose;
        self.held = state.buttons;
        if !is_clutched {
            if let Some(kept) = self.kept.take() {
                self.set_tool(&kept);
            }
        }
        let world_from_tool = match &self.kept {
            Some(kept) => *kept,
            None => self.tool()?,
        };
        let twist = state.twist.map(|twist| match is_clutched {
            true => Twist::ZERO,
            false => Twist {
                linear: scaled(&times(&self.world_from_device, &twist.linear), self.scale),
                angular: times(&self.world_from_device, &twist.angular),
            },
        });
        Ok(Mapped {
            world_from_tool,
            twist,
            is_clutched,
            held: state.buttons,
            pressed: state.buttons & !before,
            released: before & !state.buttons,
        })
    }

    /// Re-indexes, so that the tool is at a pose with the handle at its last reported place; the clutch does the same.
    pub fn set_tool(&mut self, world_from_tool: &Pose) {
        let turned = product(&self.world_from_device, self.handle.rotation());
        self.handle_from_tool = product(&transposed(&turned), world_from_tool.rotation());
        let way = scaled(&times(&self.world_from_device, self.handle.translation()), self.scale);
        self.at = sub(&world_from_tool.apply(&self.centre), &way);
        if self.kept.is_some() {
            self.kept = Some(*world_from_tool);
        }
    }

    /// Re-indexes if the tool is farther from the proxy than its velocity (`twist`, as of [`Mapped`]) moves it in 10
    /// ms.
    pub fn keep_near(&mut self, proxy: &Pose, twist: &Twist) -> Result<()> {
        let ahead = displacement(proxy, &self.tool()?, &self.centre);
        let share = |ahead: &Point, speed: &Point| (LEAD_S * length(speed) / length(ahead)).min(1.0);
        let (linear, angular) = (share(&ahead.linear, &twist.linear), share(&ahead.angular, &twist.angular));
        // Nothing ahead is no share.
        if linear < 1.0 || angular < 1.0 {
            let left = |ahead: &Point, share: f64| if share < 1.0 { scaled(ahead, share) } else { *ahead };
            let near = Twist { linear: left(&ahead.linear, linear), angular: left(&ahead.angular, angular) };
            self.set_tool(&displaced(proxy, &near, &self.centre)?);
        }
        Ok(())
    }

    /// The wrench for the device, at the handle's origin, device axes, within the device's bounds, from a wrench where the
    /// hand holds the tool, world axes. It includes the soft wall, and nothing else while the clutch is pressed. Values
    /// that are not finite become zero.
    pub fn wrench_on_hand(&self, wrench: &Wrench) -> Wrench {
        self.wrench_with_wall(wrench, &self.wall())
    }

    /// The same with a soft wall of a given force, device axes.
    pub(crate) fn wrench_with_wall(&self, wrench: &Wrench, wall: &Point) -> Wrench {
        if !wrench.is_finite() {
            return Wrench::ZERO;
        }
        let limits = &self.info.limits;
        let back = transposed(&self.world_from_device);
        let force = times(&back, &wrench.force);
        let torque = scaled(&times(&back, &wrench.torque), 1.0 / self.scale);
        let driven = self.info.driven;
        let kept = |is: bool, v: Point| if is && self.kept.is_none() { v } else { [0.0; 3] };
        let felt = Wrench { force: kept(driven.translation, force), torque: kept(driven.rotation, torque) };
        let felt = saturated(&felt, limits.force_n, limits.torque_nm);
        let wall = Wrench { force: *wall, torque: [0.0; 3] };
        added_within(&felt, &wall, limits.force_n, limits.torque_nm)
    }

    /// The handle's pose as reported last, `device_from_handle`.
    pub(crate) fn handle(&self) -> &Pose {
        &self.handle
    }

    /// The soft wall's force on the hand, device axes.
    pub(crate) fn wall(&self) -> Point {
        let place = self.handle.translation();
        std::array::from_fn(|axis| {
            let Wall { from, stiffness, most } = self.walls[axis];
            let inside = (place[axis].abs() - from).max(0.0);
            if stiffness == 0.0 || inside == 0.0 {
                return 0.0;
            }
            -(stiffness * inside).min(most) * place[axis].signum()
        })
    }

    fn tool(&self) -> Result<Pose> {
        let rotation = product(&product(&self.world_from_device, self.handle.rotation()), &self.handle_from_tool);
        let way = scaled(&times(&self.world_from_device, self.handle.translation()), self.scale);
        let place = sub(&add(&self.at, &way), &times(&rotation, &self.centre));
        Ok(pose_of(&rotation, &place)?)
    }
}
