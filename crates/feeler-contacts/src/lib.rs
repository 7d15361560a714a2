//! Contact planes, penetration and containment of a moving tool in a large static triangle mock-up.
//!
//! A [`ContactSolver`] is made of a [`Scene`](feeler_core::Scene) and asked for the contact planes of a tool at a pose, or for the
//! shortest translation that frees it:
//!
//! ```
//! use std::sync::Arc;
//!
//! use feeler_contacts::{ContactSolver, ContactTracker, PenetrationKind};
//! use feeler_core::{Mockup, Pose, Scene, SceneOptions, Tool};
//!
//! # fn main() -> feeler_core::Result<()> {
//! // A square plate of 2 m, and a spike of 20 cm with its tip at the tool's origin.
//! let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
//! let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
//! let spike = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [-0.1, 0.1, 0.2], [-0.1, -0.1, 0.2]];
//! let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
//! let scene = Scene::build(Arc::new(mockup), &SceneOptions::default())?;
//! let solver = ContactSolver::new(Arc::new(scene));
//!
//! // The tip 1 cm below the plate: one plane, that deep.
//! let pose = Pose::IDENTITY.translated(&[0.3, -0.3, -0.01])?;
//! let contacts = solver.contacts(&tool, &pose, 0.002, None)?;
//! assert_eq!(contacts.planes.len(), 1);
//! assert!((contacts.planes[0].gap + 0.01).abs() < 1e-9);
//! assert!((contacts.planes[0].normal[2] - 1.0).abs() < 1e-9);
//!
//! // Up by 1 cm, and it is free.
//! let way_out = solver.penetration(&tool, &pose, 0.002, None)?;
//! assert!((way_out.translation[2] - 0.01).abs() < 1e-6);
//!
//! // A tool that moves came from where it was last free: also where it is nearly through by now.
//! let mut tracker = ContactTracker::new();
//! tracker.contacts(&solver, &tool, &Pose::IDENTITY.translated(&[0.3, -0.3, 0.1])?, 0.002)?;
//! let through = Pose::IDENTITY.translated(&[0.3, -0.3, -0.19])?;
//! let deep = tracker.contacts(&solver, &tool, &through, 0.002)?;
//! assert!((deep.depth() - 0.19).abs() < 1e-9);
//! # Ok(())
//! # }
//! ```
//!
//! Lengths are metres; points and normals are in the world, the mock-up's frame; normals point from the mock-up to the tool, and
//! a gap is negative where the tool is that deep behind the plane.

mod body_depth;
mod clash;
mod constants;
mod contact_plane;
mod containers;
mod containment;
mod context;
mod contour;
mod convex_depth;
mod copies;
mod depth;
mod escape;
mod footing;
mod identity;
mod patch;
mod point_depth;
mod proximity;
mod query;
mod solver;
mod surface;
#[cfg(test)]
mod tests;
mod tracker;

pub use body_depth::{body_depth, deepest, BodyDepth};
pub use clash::row::{Clash, Verdict};
pub use clash::search::{clash, ClashCounts, ClashOptions, ClashSearch, Clashes};
pub use constants::{FEW_DEEP, MANY_DEEP, MOST_MANIFOLD_POINTS, MOST_PLANES};
pub use contact_plane::{ContactPlane, Contacts};
pub use containment::find::Containment;
pub use escape::penetration::{Penetration, PenetrationKind};
pub use footing::find::Footing;
pub use footing::manifold::{Manifold, ManifoldPoint, Manifolds};
pub use point_depth::depth::DepthKind;
pub use point_depth::of_tool::PartDepth;
pub use solver::{ContactSolver, StoppableSolver};
pub use tracker::ContactTracker;

// For plans: where a point lies to a tool.
#[doc(hidden)]
pub use containment::tool_solid::ToolSolid;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
