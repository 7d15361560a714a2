//! `feeler._core.IgnoredPairs`, and scenes without some parts.

use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core as core;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::errors::raise;
use crate::mockup::Mockup;
use crate::pools::Pool;
use crate::travel::rows_of;

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

/// Those given to a query, if any.
pub type Ignored<'py> = Option<PyRef<'py, IgnoredPairs>>;

/// The pairs that a query of this tool and mock-up is to leave out; an error where they are of another.
pub fn ignored_of(
    ignore: &Ignored<'_>,
    tool: &core::Tool,
    mockup: &core::Mockup,
) -> PyResult<Option<Arc<core::IgnoredPairs>>> {
    let Some(pairs) = ignore else { return Ok(None) };
    let own = [tool.parts(), mockup.part_bounds().len()];
    if own == [pairs.tool_parts, pairs.parts] {
        return Ok(Some(Arc::clone(&pairs.core)));
    }
    let given = [pairs.tool_parts, pairs.parts];
    Err(raise(
        "OptionError",
        format!(
            "ignore is of a tool with {} parts and a mock-up with {}, but these have {} and {}: make it for this tool",
            given[0], given[1], own[0], own[1]
        ),
    ))
}

/// A scene made of another: what `Scene.__new__` is given then.
#[pyclass(frozen, module = "feeler._core")]
pub struct Selected {
    pub core: Arc<core::Scene>,
    pub solver: Arc<ContactSolver>,
    pub mockup: Py<Mockup>,
    pub pool: Option<Arc<Pool>>,
}

/// What a scene is made of.
#[derive(FromPyObject)]
pub enum SceneSource<'py> {
    /// To be indexed.
    Mockup(Py<Mockup>),
    /// Of an index.
    Selected(PyRef<'py, Selected>),
}
