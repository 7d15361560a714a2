//! Ways out: removal of a part from a large triangle mock-up, and the volume that a motion sweeps.
//!
//! ```
//! use std::sync::Arc;
//!
//! use feeler_contacts::ContactSolver;
//! use feeler_core::{Mockup, Pose, Scene, SceneOptions, Tool};
//! use feeler_plan::{removal, swept, Method, RemovalOptions, RemovalTask, SweptOptions};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A square plate of 20 cm, and a spike of 2 cm with its tip on it.
//! let plate = vec![[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [-0.1, 0.1, 0.0]];
//! let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
//! let spike = vec![[0.0, 0.0, 0.0], [0.01, 0.0, 0.02], [-0.01, 0.01, 0.02], [-0.01, -0.01, 0.02]];
//! let tool = Arc::new(Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?);
//! let solver = ContactSolver::new(Arc::new(Scene::build(Arc::new(mockup), &SceneOptions::default())?));
//!
//! // What touches at the start may part. The way out is straight, and up.
//! let task = RemovalTask::new(tool.clone(), Pose::IDENTITY);
//! let found = removal(&solver, &task, &RemovalOptions::default())?;
//! assert_eq!(found.method, Some(Method::Straight));
//! assert!(found.poses[1].translation()[2] > 0.0);
//!
//! // The room that it needs: a closed mesh that contains the motion, and nothing farther than 2 mm from it.
//! let room = swept(&tool, &found.poses, 0.002, &SweptOptions::default())?;
//! assert!(room.vertices.iter().all(|p| p[2] > -0.0021));
//! # Ok(())
//! # }
//! ```
//!
//! Lengths are metres, angles radians; poses are `world_from_tool`, and the world is the mock-up's frame. Nothing here reads a clock:
//! a time limit is a function that is asked whether to go on.

mod blocked;
mod constants;
mod eigen;
mod error;
mod linear_program;
mod random;
mod removal;
mod swept;

pub use blocked::Blocker;
pub use error::{Error, Result};
pub use feeler_world::Allowed;
pub use removal::{removal, Held, Method, Removal, RemovalOptions, RemovalTask};
pub use swept::sweep::{swept, Swept, SweptOptions};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
