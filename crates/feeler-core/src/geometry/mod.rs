//! Points, boxes, poses, and pairs of triangles: whether they collide, exactly, and their distance.

pub mod bounds;
pub mod distance_lanes;
pub mod distance_triangle_triangle;
pub mod intersect_lanes;
pub mod intersect_triangle_triangle;
pub mod least_distance;
pub mod pose;
pub mod predicates;
pub mod ray_crossings;
pub mod triangle_normals;
pub mod twist;
pub mod vectors;
