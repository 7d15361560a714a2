//! The points of the tool that carry a contact: for one plane found by [`contacts`](crate::ContactSolver::contacts),
//! and for all planes of a free pose at once.

pub(crate) mod find;
pub(crate) mod manifold;
mod polygon;
