//! Continuous collision: when, on its way from one pose to another, a tool first meets the mock-up.
//!
//! The time given is never late: at no earlier time does any pair of triangles meet. It is early by at most a tolerance in
//! metres: at the pose given the pair named is at most that far apart. Where touching is free the time is when one body first enters
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
