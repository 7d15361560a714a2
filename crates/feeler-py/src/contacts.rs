//! `feeler._core.Contacts`, `Penetration` and `ContactTracker`.

use std::sync::{Arc, Mutex, PoisonError};

use feeler_contacts as contacts;
use feeler_core as core;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arguments::{PoseArgument, ToolArgument};
use crate::arrays::{view, view_rows};
use crate::errors::to_py;
use crate::scene::{pose_array, Scene};

/// The contact planes of a tool at a pose.
#[pyclass(frozen, module = "feeler._core")]
pub struct Contacts {
    points: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
    gaps: Vec<f64>,
    parts: Vec<u32>,
    /// The tool's and the mock-up's triangles of all planes one after the other, and where each plane's begin.
    triangles: [Vec<u32>; 2],
    offsets: [Vec<u64>; 2],
    omitted: usize,
    meeting: bool,
}

impl Contacts {
    pub fn new(core: &contacts::Contacts) -> Contacts {
        let planes = &core.planes;
        let joined = |of: &dyn Fn(&contacts::ContactPlane) -> &Vec<u32>| {
            let mut offsets = vec![0];
            let mut ids = Vec::new();
            for plane in planes {
                ids.extend_from_slice(of(plane));
                offsets.push(ids.len() as u64);
            }
            (ids, offsets)
        };
        let (tool, tool_offsets) = joined(&|p| &p.tool_triangles);
        let (mockup, mockup_offsets) = joined(&|p| &p.mockup_triangles);
        Contacts {
            points: planes.iter().map(|p| p.point).collect(),
            normals: planes.iter().map(|p| p.normal).collect(),
            gaps: planes.iter().map(|p| p.gap).collect(),
            parts: planes.iter().map(|p| p.part).collect(),
            triangles: [tool, mockup],
            offsets: [tool_offsets, mockup_offsets],
            omitted: core.omitted,
            meeting: core.is_meeting,
        }
    }
}

#[pymethods]
impl Contacts {
    #[getter]
    fn points<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<f64>> {
        // SAFETY: the result is frozen and owns its points; the array keeps it alive.
        unsafe { view_rows(slf.as_any(), &slf.get().points) }
    }

    #[getter]
    fn normals<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<f64>> {
        // SAFETY: as for the points.
        unsafe { view_rows(slf.as_any(), &slf.get().normals) }
    }

    #[getter]
    fn gaps<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        // SAFETY: as for the points.
        unsafe { view(slf.as_any(), &slf.get().gaps) }
    }

    #[getter]
    fn parts<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the points.
        unsafe { view(slf.as_any(), &slf.get().parts) }
    }

    #[getter]
    fn tool_triangles<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the points.
        unsafe { view(slf.as_any(), &slf.get().triangles[0]) }
    }

    #[getter]
    fn tool_offsets<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u64>> {
        // SAFETY: as for the points.
        unsafe { view(slf.as_any(), &slf.get().offsets[0]) }
    }

    #[getter]
    fn mockup_triangles<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the points.
        unsafe { view(slf.as_any(), &slf.get().triangles[1]) }
    }

    #[getter]
    fn mockup_offsets<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u64>> {
        // SAFETY: as for the points.
        unsafe { view(slf.as_any(), &slf.get().offsets[1]) }
    }

    #[getter]
    fn omitted(&self) -> usize {
        self.omitted
    }

    #[getter]
    fn is_meeting(&self) -> bool {
        self.meeting
    }

    fn __len__(&self) -> usize {
        self.gaps.len()
    }

    fn __bool__(&self) -> bool {
        !self.gaps.is_empty()
    }

    fn __repr__(&self) -> String {
        match self.gaps.first() {
            Some(gap) => format!("Contacts({} planes, least gap {gap:.4e} m)", self.gaps.len()),
            None => "Contacts(0 planes)".into(),
        }
    }
}

/// A translation that frees a tool.
#[pyclass(frozen, module = "feeler._core")]
pub struct Penetration {
    core: contacts::Penetration,
    contacts: Py<Contacts>,
}

impl Penetration {
    pub fn new(py: Python<'_>, core: contacts::Penetration) -> PyResult<Penetration> {
        let contacts = Py::new(py, Contacts::new(&core.contacts))?;
        Ok(Penetration { core, contacts })
    }
}

#[pymethods]
impl Penetration {
    #[getter]
    fn translation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.core.translation.to_vec().into_pyarray(py)
    }

    #[getter]
    fn depth(&self) -> f64 {
        self.core.depth
    }

    #[getter]
    fn kind(&self) -> &'static str {
        match self.core.kind {
            contacts::PenetrationKind::Exact => "exact",
            contacts::PenetrationKind::Bound => "bound",
            contacts::PenetrationKind::Estimate => "estimate",
        }
    }

    #[getter]
    fn contacts(&self, py: Python<'_>) -> Py<Contacts> {
        self.contacts.clone_ref(py)
    }

    fn __repr__(&self) -> String {
        format!("Penetration({:.4e} m, {})", self.core.depth, self.kind())
    }
}

/// A tool that moves in a scene, and where it was last free. `feeler.ContactTracker` checks what it is given.
#[pyclass(subclass, frozen, module = "feeler._core")]
pub struct ContactTracker {
    scene: Py<Scene>,
    tool: Arc<core::Tool>,
    core: Mutex<contacts::ContactTracker>,
}

#[pymethods]
impl ContactTracker {
    #[new]
    fn new(scene: Py<Scene>, tool: ToolArgument<'_, '_>) -> ContactTracker {
        ContactTracker { scene, tool: Arc::clone(tool.core()), core: Mutex::default() }
    }

    fn contacts(&self, py: Python<'_>, world_from_tool: PoseArgument, margin: f64) -> PyResult<Contacts> {
        let scene = self.scene.get();
        let found = py.detach(|| {
            // The lock is not held meanwhile: a second thread asks with what was known, and does not wait.
            let mut tracker = *self.core.lock().unwrap_or_else(PoisonError::into_inner);
            let found = tracker.contacts(scene.solver(), &self.tool, &world_from_tool.0, margin)?;
            if !found.is_meeting {
                *self.core.lock().unwrap_or_else(PoisonError::into_inner) = tracker;
            }
            Ok(found)
        });
        found.map(|c| Contacts::new(&c)).map_err(to_py)
    }

    #[getter]
    fn last_free<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray2<f64>>> {
        let tracker = *self.core.lock().unwrap_or_else(PoisonError::into_inner);
        tracker.last_free().map(|pose| pose_array(py, pose))
    }

    fn set_last_free(&self, world_from_tool: Option<PoseArgument>) {
        let pose = world_from_tool.map(|pose| pose.0);
        self.core.lock().unwrap_or_else(PoisonError::into_inner).set_last_free(pose);
    }
}
