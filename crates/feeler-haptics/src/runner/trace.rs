//! The ticks of a run, sent through a queue of fixed length for which the servo side never waits.

use feeler_core::geometry::twist::Wrench;
use feeler_core::Pose;

use crate::servo::Mode;

/// One tick of the servo side.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct TraceTick {
    /// Seconds on the caller's clock.
    pub time: f64,
    /// The pose of the device, `world_from_tool`; the last known one if it reported none.
    pub device: Pose,
    /// Where the collision side had the proxy, `world_from_tool`.
    pub proxy: Pose,
    /// On the hand, world axes, the torque about where it holds the tool.
    pub wrench: Wrench,
    /// The state of the proxy.
    pub mode: Mode,
    /// Whether the device reported a valid pose.
    pub has_device: bool,
}
