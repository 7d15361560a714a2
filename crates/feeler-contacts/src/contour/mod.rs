//! Contours: where the tool cuts a part, on which side of each other's surface corners are, and what the contours enclose.

mod connect;
pub(crate) mod contact_region;
pub(crate) mod find;
mod flood_fill;
mod segments;
mod vertex_side;
mod vertex_side_degenerate;
