//! `feeler._core.Contacts`, `ContactPlane`, `Penetration` and `ContactTracker`.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use feeler_contacts as contacts;
use feeler_core as core;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyIterator, PyList};

use crate::arguments::{PoseArgument, ToolArgument};
use crate::arrays::{view, view_blocks, view_rows};
use crate::errors::to_py;
use crate::scene::{pose_array, Scene};

/// The contact planes of a tool at a pose.
#[pyclass(frozen, module = "feeler._core")]
pub struct Contacts {
    points: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
    gaps: Vec<f64>,
    parts: Vec<u32>,
    ids: Vec<u64>,
    /// The tool's and the mock-up's triangles of all planes one after the other, and where each plane's begin.
    triangles: [Vec<u32>; 2],
    offsets: [Vec<u64>; 2],
    omitted: usize,
    meeting: bool,
    asked: Asked,
    planes: Vec<contacts::ContactPlane>,
    footing: OnceLock<Footing>,
}

/// What was asked of which scene; footings are found with it.
pub struct Asked {
    pub solver: Arc<contacts::ContactSolver>,
    pub tool: Arc<core::Tool>,
    pub pose: core::Pose,
}

/// The points that carry each plane, the last of fewer than four again and again, and how many there are.
struct Footing {
    points: Vec<[[f64; 3]; 4]>,
    counts: Vec<u32>,
}

impl Contacts {
    pub fn new(core: contacts::Contacts, asked: Asked) -> Contacts {
        let planes = core.planes;
        let joined = |of: &dyn Fn(&contacts::ContactPlane) -> &Vec<u32>| {
            let mut offsets = vec![0];
            let mut ids = Vec::new();
            for plane in &planes {
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
            ids: planes.iter().map(|p| p.id).collect(),
            triangles: [tool, mockup],
            offsets: [tool_offsets, mockup_offsets],
            omitted: core.omitted,
            meeting: core.is_meeting,
            asked,
            planes,
            footing: OnceLock::new(),
        }
    }

    /// Found when first asked for, without the interpreter's lock.
    fn footings(&self, py: Python<'_>) -> &Footing {
        py.detach(|| {
            self.footing.get_or_init(|| {
                let mut footing = Footing { points: Vec::new(), counts: Vec::new() };
                for plane in &self.planes {
                    let found = self.asked.solver.footing(&self.asked.tool, &self.asked.pose, plane);
                    let points = found.points();
                    footing.points.push(std::array::from_fn(|i| points[i.min(points.len() - 1)]));
                    footing.counts.push(points.len() as u32);
                }
                footing
            })
        })
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
    fn ids<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u64>> {
        // SAFETY: as for the points.
        unsafe { view(slf.as_any(), &slf.get().ids) }
    }

    #[getter]
    fn footing<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray3<f64>> {
        // SAFETY: as for the points; once found, footings stay where they are.
        unsafe { view_blocks(slf.as_any(), &slf.get().footings(slf.py()).points) }
    }

    #[getter]
    fn footing_counts<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the footing.
        unsafe { view(slf.as_any(), &slf.get().footings(slf.py()).counts) }
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

    fn __getitem__(slf: &Bound<'_, Self>, index: isize) -> PyResult<ContactPlane> {
        let count = slf.get().planes.len();
        let plane = if index < 0 { index.checked_add_unsigned(count) } else { Some(index) };
        let plane = plane.and_then(|i| usize::try_from(i).ok()).filter(|i| *i < count);
        let plane = plane.ok_or_else(|| PyIndexError::new_err(format!("plane {index} of {count}")))?;
        Ok(ContactPlane { contacts: slf.clone().unbind(), plane })
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        let planes = 0..slf.get().planes.len();
        let planes = planes.map(|plane| ContactPlane { contacts: slf.clone().unbind(), plane }.into_pyobject(slf.py()));
        PyList::new(slf.py(), planes.collect::<PyResult<Vec<_>>>()?)?.try_iter()
    }

    fn __repr__(&self) -> String {
        match self.gaps.first() {
            Some(gap) => format!("Contacts({} planes, least gap {gap:.4e} m)", self.gaps.len()),
            None => "Contacts(0 planes)".into(),
        }
    }
}

/// One plane of a tool's contacts.
#[pyclass(frozen, module = "feeler._core")]
pub struct ContactPlane {
    contacts: Py<Contacts>,
    plane: usize,
}

impl ContactPlane {
    fn core(&self) -> &contacts::ContactPlane {
        &self.contacts.get().planes[self.plane]
    }
}

#[pymethods]
impl ContactPlane {
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.core().point.to_vec().into_pyarray(py)
    }

    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.core().normal.to_vec().into_pyarray(py)
    }

    #[getter]
    fn gap(&self) -> f64 {
        self.core().gap
    }

    #[getter]
    fn part(&self) -> u32 {
        self.core().part
    }

    #[getter]
    fn id(&self) -> u64 {
        self.core().id
    }

    #[getter]
    fn footing<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let footing = self.contacts.get().footings(py);
        let points = &footing.points[self.plane][..footing.counts[self.plane] as usize];
        Array2::from_shape_fn((points.len(), 3), |(i, a)| points[i][a]).into_pyarray(py)
    }

    #[getter]
    fn tool_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.core().tool_triangles.clone().into_pyarray(py)
    }

    #[getter]
    fn mockup_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.core().mockup_triangles.clone().into_pyarray(py)
    }

    fn __repr__(&self) -> String {
        let contacts::ContactPlane { gap, part, id, .. } = self.core();
        format!("ContactPlane(gap {gap:.4e} m, part {part}, id {id:#018x})")
    }
}

/// A translation that frees a tool.
#[pyclass(frozen, module = "feeler._core")]
pub struct Penetration {
    core: contacts::Penetration,
    contacts: Py<Contacts>,
}

impl Penetration {
    pub fn new(py: Python<'_>, mut core: contacts::Penetration, asked: Asked) -> PyResult<Penetration> {
        let contacts = Py::new(py, Contacts::new(std::mem::take(&mut core.contacts), asked))?;
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
        let (solver, tool) = (Arc::clone(scene.solver()), Arc::clone(&self.tool));
        found.map(|c| Contacts::new(c, Asked { solver, tool, pose: world_from_tool.0 })).map_err(to_py)
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
