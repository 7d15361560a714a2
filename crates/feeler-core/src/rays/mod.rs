//! Rays: the first triangle that each hits, decided exactly.

pub mod brute;
mod meeting;
pub mod query;
mod ratio;
pub mod ray;
mod span;
