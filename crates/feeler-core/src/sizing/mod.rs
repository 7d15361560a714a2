//! The best voxel size: by the paper's cost function, or by predictions from samples of both meshes.

pub mod choice;
pub mod cost;
pub mod cost_constants;
mod crowd;
pub mod piece_predictor;
mod place;
pub mod predictor;
mod random;
mod sample;
mod spread;
mod statics;
#[cfg(test)]
mod tests;
pub mod work;
