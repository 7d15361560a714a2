//! The exchange between the threads, through triple buffers: nobody waits, and everybody has the newest data.

use feeler_core::geometry::twist::Wrench;
use feeler_core::Pose;

use crate::constants::VIEW_PLANES;
use crate::constraint_set::{ConstraintSet, Plane};
use crate::guide::Guide;
use crate::servo::Mode;

/// From the servo side to the collision side: where the device wants the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// `world_from_tool`.
    pub pose: Pose,
    /// Counts the device's states; 0: there was none yet.
    pub number: u64,
    /// Of which start: a target from before the last one is not followed.
    pub start: u64,
}

/// From the collision side to the servo side.
#[derive(Debug, Clone, Copy)]
pub struct Handed {
    /// The newest constraints.
    pub set: ConstraintSet,
    /// Whether there is a proxy; without, the constraints say nothing.
    pub has_proxy: bool,
    /// Counts the starts.
    pub start: u64,
    /// Where the tool was put by the last start, `world_from_tool`.
    pub start_pose: Pose,
}

/// From a third thread to the servo side: where a guide draws the tool; `None`: nowhere.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Told {
    /// See [`Guide`].
    pub guide: Option<Guide>,
}

/// For the picture: one tick of the servo side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Counts the ticks; 0: there was none yet.
    pub number: u64,
    /// When, seconds on the caller's clock.
    pub time: f64,
    /// Where the collision side has the proxy, `world_from_tool`: free by the exact test. Where there is none, the device's pose.
    pub proxy: Pose,
    /// Where the servo side has it: ahead of that, as far as the last constraints allow, and not checked yet.
    pub ahead: Pose,
    /// Where the device wants the tool, `world_from_tool`.
    pub device: Pose,
    /// On the hand, world axes, the torque about where it holds the tool; as sent to the device, without its own bounds and soft
    /// walls.
    pub wrench: Wrench,
    /// Of the constraints, seconds.
    pub age: f64,
    /// The state of the proxy.
    pub mode: Mode,
    /// Buttons that are held, a bit each.
    pub buttons: u32,
    /// Whether the clutch is held.
    pub is_clutched: bool,
    /// Share of the coupling's stiffness in use: below 1 where the servo or the device is slower than the coupling is
    /// limited for.
    pub stiffness_share: f64,
    /// Mean of the last ticks, and of the times between the device's reports, seconds.
    pub(super) periods_s: [f64; 2],
    /// Mean age of the device's reports when they come, seconds.
    pub(super) late_s: f64,
    pub(super) held: [Plane; VIEW_PLANES],
    pub(super) held_count: usize,
}

impl View {
    /// Before the first tick.
    pub(super) fn new(pose: &Pose) -> View {
        View {
            number: 0,
            time: 0.0,
            proxy: *pose,
            ahead: *pose,
            device: *pose,
            wrench: Wrench::ZERO,
            age: 0.0,
            mode: Mode::Doubt,
            buttons: 0,
            is_clutched: false,
            stiffness_share: 1.0,
            periods_s: [0.0; 2],
            late_s: 0.0,
            held: [Plane::default(); VIEW_PLANES],
            held_count: 0,
        }
    }

    /// The planes that hold the proxy.
    pub fn held(&self) -> &[Plane] {
        &self.held[..self.held_count]
    }
}
