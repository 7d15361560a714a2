//! Intersection contours: the segments along which tool and part intersect, the side of the other surface for each
//! vertex, and the triangles that contours enclose.

mod connect;
pub(crate) mod contact_region;
pub(crate) mod find;
mod flood_fill;
mod segments;
mod vertex_side;
mod vertex_side_degenerate;
