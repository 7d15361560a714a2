//! Sections: the cut of a plane, as segments.

pub mod cut;
pub mod outline;
mod plane;
