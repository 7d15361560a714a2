//! The points of the tool that carry a contact: of a plane that [`contacts`](crate::ContactSolver::contacts) found, and at a free pose
//! of all planes at once.

pub(crate) mod find;
pub(crate) mod manifold;
mod polygon;
