//! The default store: blocks of 32 boxes close together, under a shallow tree.
//!
//! A wide bounding volume hierarchy of quantised boxes, as there are for rays (H. Ylitie, T. Karras and S. Laine, *Efficient
//! incoherent ray traversal on GPUs through compressed wide BVHs*, 2017), with leaves that hold corners as well.
//!
//! Triangles are cut into pieces (for the index only), pieces are ordered by medians ([`crate::mesh::median`]), and 32 consecutive
//! ones make a block, in which they are in order along its longest side. A block keeps its pieces' boxes as bytes relative to its
//! own box, and their corners as steps within those. Blocks of blocks make the tree: the children of node `i` are the entries
//! `32 i` to `32 i + 31` of the level below, so there are no lists and no pointers.
//!
//! Boxes are compared after rounding to float32 and then to bytes. Both steps are monotone functions applied to both
//! sides alike, and `x <= y` implies `f(x) <= f(y)`: overlapping boxes never appear apart, whatever the rounding. Where
//! numbers are unpacked instead, their uncertainty is added.

mod block_parts;
mod build;
mod cells;
mod collide;
mod edge_planes;
mod nearest;
mod nearest_leaf;
mod node;
mod piece_scan;
mod pieces;
mod plane_cull;
mod ray;
mod scan;
mod self_descent;
mod self_meeting;
mod self_near;
mod separating_planes;
mod sweep;
mod swept_bounds;
mod tree;

pub use block_parts::BlockParts;
pub use collide::BlocksScratch;
pub use nearest::NearScratch;
pub use self_descent::{SelfSearch, SelfTask};
pub use self_meeting::{MeetingBlocks, MeetingScratch};
pub use self_near::{NearBlocks, SelfNearScratch};
pub use sweep::SweepScratch;
pub use tree::Blocks;
