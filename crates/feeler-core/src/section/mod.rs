//! Sections: what a plane cuts, as segments.

pub mod cut;
pub mod outline;
mod plane;
