//! Stretches of ways.

use super::chain::Chain;
use super::screw::Screw;
use crate::geometry::pose::Pose;

/// One stretch of a way, from where the one before ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Leg {
    /// To a pose, as [`Motion::new`](crate::Motion::new).
    To(Pose),
    /// About an axis, as [`Motion::screw`](crate::Motion::screw).
    Screw(Screw),
    /// By several joints at once, as [`Motion::chain`](crate::Motion::chain).
    Chain(Chain),
}
