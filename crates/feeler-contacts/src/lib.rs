//! Contact planes, penetration and containment of a moving tool in a large static triangle mock-up.

mod constants;
mod contact_plane;
mod containers;
mod context;
mod contour;
mod depth;
mod escape;
mod footing;
mod identity;
mod patch;
mod proximity;
mod query;
mod solver;
mod surface;
#[cfg(test)]
mod tests;
mod tracker;

pub use constants::{FEW_DEEP, MANY_DEEP, MOST_PLANES};
pub use contact_plane::{ContactPlane, Contacts};
pub use escape::penetration::{Penetration, PenetrationKind};
pub use footing::Footing;
pub use solver::ContactSolver;
pub use tracker::ContactTracker;
