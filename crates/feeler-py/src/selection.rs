//! `feeler._core.IgnoredPairs`, and scenes without some parts.

use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core as core;
use numpy::PyReadonlyArray2;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arguments::ToolArgument;
use crate::errors::raise;
use crate::mockup::Mockup;
use crate::pools::Pool;
use crate::saved::SavedScene;
use crate::travel::{rows_of, stays};

/// Pairs of parts that queries leave out. `feeler.IgnoredPairs` knows them by name.
#[pyclass(subclass, frozen, module = "feeler._core")]
pub struct IgnoredPairs {
    core: Arc<core::IgnoredPairs>,
    tool_parts: usize,
    parts: usize,
}

#[pymethods]
impl IgnoredPairs {
    #[new]
    fn new(tool_parts: usize, parts: usize, pairs: PyReadonlyArray2<'_, u32>) -> PyResult<IgnoredPairs> {
        let core = Arc::new(core::IgnoredPairs::new(tool_parts, parts, rows_of(&pairs)?));
        Ok(IgnoredPairs { core, tool_parts, parts })
    }
}

/// What is given to a query for `ignore`: `None`, `IgnoredPairs`, or what `feeler.ignored` makes these of.
pub type Ignore<'py> = Option<Bound<'py, PyAny>>;

/// The pairs that a query is to leave out; an error where they are of another tool or mock-up.
pub fn ignored_of(
    ignore: &Bound<'_, PyAny>,
    tool: &ToolArgument<'_, '_>,
    mockup: &Py<Mockup>,
) -> PyResult<Arc<core::IgnoredPairs>> {
    let made = match ignore.cast::<IgnoredPairs>() {
        Ok(pairs) => pairs.clone(),
        Err(_) => {
            let of_names = ignore.py().import("feeler.ignored")?.getattr("ignored")?;
            of_names.call1((ignore, tool.object(), mockup))?.cast_into::<IgnoredPairs>()?
        }
    };
    let pairs = made.get();
    let own = [tool.core().parts(), mockup.get().core.part_bounds().len()];
    let given = [pairs.tool_parts, pairs.parts];
    if own == given {
        return Ok(Arc::clone(&pairs.core));
    }
    Err(raise(
        "OptionError",
        format!(
            "ignore is of a tool with {} parts and a mock-up with {}, but these have {} and {}: make it for this tool",
            given[0], given[1], own[0], own[1]
        ),
    ))
}

/// The core of a scene that shares another scene's index, or that of a file.
#[pyclass(frozen, module = "feeler._core")]
pub struct Selected {
    pub core: Arc<core::Scene>,
    pub solver: Arc<ContactSolver>,
    pub mockup: Py<Mockup>,
    pub pool: Option<Arc<Pool>>,
}

/// The instruction set of that name; the best one for `None`.
pub fn lanes_of(simd: Option<&str>) -> PyResult<core::Level> {
    let Some(name) = simd else { return Ok(core::Level::best()) };
    let levels = core::Level::available();
    let named = levels.iter().find(|level| level.name() == name);
    named.copied().ok_or_else(|| {
        let names: Vec<&str> = levels.iter().map(|level| level.name()).collect();
        raise("OptionError", format!("simd is {name:?}: this CPU has {}", names.join(", ")))
    })
}

#[pymethods]
impl Selected {
    /// The index of a saved scene with all parts, for a scene of its mock-up.
    #[new]
    fn new(
        saved: PyRef<'_, SavedScene>,
        mockup: Py<Mockup>,
        threads: Option<usize>,
        memory_limit: u64,
        simd: Option<&str>,
    ) -> PyResult<Selected> {
        if !Arc::ptr_eq(&mockup.get().core, &saved.mockup()) {
            return Err(PyValueError::new_err("the mock-up is not that of the saved scene"));
        }
        let mut scene = saved.whole().clone();
        scene.set_lanes(lanes_of(simd)?);
        scene.set_memory_limit(memory_limit);
        let core = Arc::new(scene);
        let solver = Arc::new(ContactSolver::new(Arc::clone(&core)));
        Ok(Selected { core, solver, mockup, pool: threads.map(|threads| Arc::new(Pool::new(threads))) })
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("Selected", "pickle the scene that is made of it"))
    }
}

/// What a scene is made of.
#[derive(FromPyObject)]
pub enum SceneSource<'py> {
    /// To be indexed.
    Mockup(Py<Mockup>),
    /// Of an index.
    Selected(PyRef<'py, Selected>),
}
