//! Penetration depth by points: how far the deepest point of one surface lies inside the other body (M. Tang, M. Lee
//! and Y. J. Kim, *Interactive Hausdorff distance computation for general polygonal models*, SIGGRAPH 2009, whose
//! one-sided distances it takes between the part of each surface that is inside the other body, and the other surface).
//!
//! `D(A, B) = max(sup d(p, dB) over p on dA inside B, sup d(p, dA) over p on dB inside A)`. It is a property of the
//! solids: it does not depend on how their surfaces are cut into triangles, and a motion changes it by at most the
//! motion.

pub mod bodies;
pub mod body;
mod border;
#[cfg(test)]
pub mod brute;
mod corners;
pub mod crossing;
pub mod depth;
mod distances;
mod farthest;
pub mod of_tool;
mod off_surface;
mod outline;
mod piece;
mod shared_line;
mod tree;
pub mod walls;
