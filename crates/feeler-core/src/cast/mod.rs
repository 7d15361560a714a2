//! Continuous collision: when, on its way from one pose to another, a tool first meets the mock-up.
//!
//! The time given is never late: at no earlier time does any pair of triangles meet. It is early by at most a tolerance in
//! metres: at the pose given the pair named is at most that far apart.

pub mod brute;
pub mod impact;
mod pair;
pub mod path;
pub mod query;
mod sweep;
