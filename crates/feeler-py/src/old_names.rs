//! Attributes that have other names now.

use pyo3::prelude::*;

/// What `__getattr__` of a class with the table `_RENAMED` answers: `feeler.renamed` has the rule for all classes.
pub fn old_attribute<'py, T>(held: &Bound<'py, T>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    held.py().import("feeler.renamed")?.call_method1("old_attribute", (held.as_any(), name))
}
