//! Continuous collision detection: when a tool that moves from one pose to another first collides with the mock-up.
//!
//! The time is never late: no pair of triangles collides before it. It is early by at most a tolerance in metres: at
//! the given pose the given pair is at most that far apart. If touching is free, the time is when one body first enters
//! the other, and the tolerance is how far it may by then.

pub mod brute;
pub mod impact;
pub mod options;
mod pair;
pub mod path;
pub mod query;
mod shadow;
mod sliding;
mod sweep;
