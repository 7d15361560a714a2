//! What the fuzz targets in Rust make of their bytes, and what must hold then.
//!
//! `fuzz_targets/` hands these to libFuzzer; a test of `feeler-exact` runs them on the seeds and on random changes of these.

pub mod collide;
pub mod contacts;
pub mod distance;
pub mod mesh;
pub mod saved_scene;
pub mod shapes;
