//! The Python module `feeler._core`: classes that convert arrays and map errors, and decide nothing.

mod along;
mod arguments;
mod arrays;
mod bodies;
mod cast;
mod chain;
mod clash;
mod collision;
mod contacts;
mod containment;
mod errors;
mod haptics;
mod haptics_answers;
mod haptics_device;
mod haptics_own;
mod haptics_run;
mod huge_pages;
mod mockup;
mod old_names;
mod packed;
mod pools;
mod predict;
mod proximity;
mod rays;
mod removal;
mod reporter;
mod restore;
mod saved;
mod scene;
mod screw;
mod selection;
mod signals;
mod swept;
mod tool;
mod topology;
mod travel;
mod ways;
mod words;
mod world;

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

#[global_allocator]
static ALLOCATOR: huge_pages::HugePages = huge_pages::HugePages;

/// Vertices and indices into them.
type Welded<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<u32>>);

/// Distinct vertices in order of first appearance, `(k, 3)`, and each given vertex's index among them, `(n,)`.
///
/// Equal means equal coordinates, with 0.0 equal to -0.0.
#[pyfunction]
fn weld_vertices<'py>(py: Python<'py>, vertices: PyReadonlyArray2<'py, f64>) -> PyResult<Welded<'py>> {
    let rows = arrays::rows("vertices", &vertices)?;
    if rows.len() as u64 > u64::from(u32::MAX) {
        return Err(errors::raise("LimitError", format!("{} vertices are more than 32-bit ids can name", rows.len())));
    }
    let (unique, index) = py.detach(|| feeler_core::weld_vertices(&rows));
    let count = unique.len();
    let flat: Vec<f64> = unique.into_flattened();
    let unique = numpy::ndarray::Array2::from_shape_vec((count, 3), flat)
        .map_err(|e| errors::raise("FeelerError", e.to_string()))?;
    Ok((unique.into_pyarray(py), index.into_pyarray(py)))
}

#[pymodule]
mod _core {
    #[pymodule_export]
    use super::along::ClearanceAlong;
    #[pymodule_export]
    use super::bodies::{Bodies, Shape};
    #[pymodule_export]
    use super::cast::{Cast, PathCheck};
    #[pymodule_export]
    use super::chain::{Chain, Slide};
    #[pymodule_export]
    use super::clash::{clash, ClashRows};
    #[pymodule_export]
    use super::collision::{Batch, Collision};
    #[pymodule_export]
    use super::contacts::{ContactPlane, ContactTracker, Contacts, Penetration};
    #[pymodule_export]
    use super::containment::Containment;
    #[pymodule_export]
    use super::haptics::HapticsSession;
    #[pymodule_export]
    use super::haptics_answers::{
        DistributionAnswer, GrantedAnswer, RunEnd, StartAnswer, StatisticsAnswer, StepAnswer, TickAnswer, TraceAnswer,
    };
    #[pymodule_export]
    use super::haptics_device::HapticsDevice;
    #[pymodule_export]
    use super::haptics_run::HapticsRun;
    #[pymodule_export]
    use super::mockup::{Mockup, MovedMockup};
    #[pymodule_export]
    use super::packed::{Packed, PackedPiece};
    #[pymodule_export]
    use super::predict::{PiecePredictor, Predictor};
    #[pymodule_export]
    use super::proximity::{Clearance, ClearanceBatch, Distance, DistanceBatch};
    #[pymodule_export]
    use super::rays::{Rays, SectionOutline};
    #[pymodule_export]
    use super::removal::{removal, RemovalAnswer};
    #[pymodule_export]
    use super::restore::restore;
    #[pymodule_export]
    use super::saved::SavedScene;
    #[pymodule_export]
    use super::scene::{optimal_voxel_size, Scene};
    #[pymodule_export]
    use super::screw::Screw;
    #[pymodule_export]
    use super::selection::{IgnoredPairs, Selected};
    #[pymodule_export]
    use super::swept::swept;
    #[pymodule_export]
    use super::tool::Tool;
    #[pymodule_export]
    use super::weld_vertices;
    #[pymodule_export]
    use super::world::{GuardedMove, Impact, MoveAnswer, SeatAnswer, World};

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(_module: &Bound<'_, PyModule>) -> PyResult<()> {
        super::pools::watch_forks();
        // Found once, while nobody forks: a forked process would wait for a thread that was about to find it.
        feeler_core::Level::best();
        Ok(())
    }
}
