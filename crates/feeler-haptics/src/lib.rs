//! A hand that feels: a tool held by a haptic device, kept out of a large static triangle mock-up, and the force of that on the hand.
//!
//! A [`Session`] is made of a [`Scene`](feeler_core::Scene) and a tool, begun where the hand is, and stepped:
//!
//! ```
//! use std::sync::Arc;
//!
//! use feeler_core::{Mockup, Pose, Scene, SceneOptions, Tool};
//! use feeler_haptics::{Session, SessionOptions, Start};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A square plate of 20 cm, and a spike of 2 cm with its tip at the tool's origin.
//! let plate = vec![[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [-0.1, 0.1, 0.0]];
//! let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
//! let spike = vec![[0.0, 0.0, 0.0], [0.01, 0.0, 0.02], [-0.01, 0.01, 0.02], [-0.01, -0.01, 0.02]];
//! let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
//! let scene = Scene::build(Arc::new(mockup), &SceneOptions::default())?;
//!
//! let options = SessionOptions::default();
//! let mut session = Session::new(Arc::new(scene), Arc::new(tool), options)?;
//! let at = |z: f64| Pose::IDENTITY.translated(&[0.03, -0.02, z]);
//! assert_eq!(session.start(&at(0.01)?)?, Start::Free);
//!
//! // Down at 10 cm/s to 5 mm below the plate, where the hand holds still.
//! let mut step = session.step(Some(&at(0.01)?), 0.001)?;
//! for tick in 1..=400 {
//!     step = session.step(Some(&at((0.01 - 1e-4 * tick as f64).max(-0.005))?), 0.001)?;
//! }
//! // The tip stays on the plate, its skin of 20 um off, and the coupling's spring pushes the hand back.
//! let tip = step.proxy.translation()[2];
//! assert!(tip > 0.0 && tip < 5e-5);
//! let expected = options.coupling.stiffness_n_per_m * 0.005;
//! assert!((step.wrench.force[2] / expected - 1.0).abs() < 0.05);
//! # Ok(())
//! # }
//! ```
//!
//! Lengths are metres, angles radians, forces newtons; poses are `world_from_tool`. Time is passed in, in seconds: nothing here reads
//! a clock but the one that a [`Runner`] is given.

mod clock;
mod constants;
mod constraint_set;
mod coupling;
pub mod device;
mod error;
mod force;
mod guide;
#[doc(hidden)]
pub mod internals;
mod passivity;
mod proxy;
mod runner;
mod saturation;
mod servo;
mod session;
mod shading;
mod shading_budget;
mod smooth_surface;
mod stability;
mod statistics;
mod velocity;

pub use clock::Clock;
pub use coupling::Coupling;
pub use error::{Error, Result};
pub use feeler_core::{Twist, Wrench};
pub use feeler_world::{Plane, PutDown, Release, Seat, SeatKind, World};
pub use guide::Guide;
pub use proxy::ProxyOptions;
pub use runner::{
    AroundWork, CollisionSide, MappingOptions, OnThreadStart, Refused, Runner, RunnerOptions, ServoSide, Sides,
    Stopped, ThreadKind, TraceTick, View, Watch,
};
pub use servo::Mode;
pub use session::{Seating, Session, SessionOptions, Start, Step};
pub use stability::Limitations;
pub use statistics::{Distribution, Statistics};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
