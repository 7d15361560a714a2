//! `feeler._core.IgnoredPairs`, and scenes without some parts.

use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core as core;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::arguments::ToolArgument;
use crate::errors::raise;
use crate::mockup::Mockup;
use crate::pools::Pool;
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

/// The core of a scene that shares another scene's index.
#[pyclass(frozen, module = "feeler._core")]
pub struct Selected {
    pub core: Arc<core::Scene>,
    pub solver: Arc<ContactSolver>,
    pub mockup: Py<Mockup>,
    pub pool: Option<Arc<Pool>>,
}

#[pymethods]
impl Selected {
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
