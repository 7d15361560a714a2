//! `feeler._core.Contacts`, `ContactPlane`, `Penetration` and `ContactTracker`.

use std::sync::{Arc, Mutex, PoisonError};

use feeler_contacts as contacts;
use feeler_core as core;
use numpy::ndarray::Array2;
use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use once_cell::race::OnceBox;
use pyo3::prelude::*;
use pyo3::types::{PyIterator, PyList, PyTuple};

use crate::arguments::{PoseArgument, ToolArgument};
use crate::arrays::{at, pose_array, read_only, view, view_blocks, view_rows, Index, IntoReadOnly};
use crate::errors::to_py;
use crate::scene::Scene;
use crate::selection::Ignore;
use crate::signals::stoppable;
use crate::topology::find_topology;
use crate::travel::{check_lengths, check_offsets, damaged, list, reduced, rows_of};
use crate::words::{counted, metres};

/// Contact planes, deepest first; false when there are none. `contacts[i]` is one. All arrays are read-only.
#[pyclass(frozen, module = "feeler._core")]
pub struct Contacts {
    points: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
    gaps: Vec<f64>,
    parts: Vec<u32>,
    tool_parts: Vec<u32>,
    ids: Vec<u64>,
    /// The tool's and the mock-up's triangles of all planes one after the other, and where each plane's begin.
    triangles: [Vec<u32>; 2],
    offsets: [Vec<u64>; 2],
    omitted: usize,
    meeting: bool,
    /// None of what travelled: its footings came with it.
    asked: Option<Asked>,
    /// Found when first asked for; by everyone who asks meanwhile, since nobody may wait for a thread that a fork leaves behind.
    footing: OnceBox<Footing>,
}

/// Who was asked, about which tool, at which pose.
pub type Question = (Arc<contacts::ContactSolver>, Arc<core::Tool>, core::Pose);

/// What was asked of which scene, and the answer; footings are found with it.
struct Asked {
    solver: Arc<contacts::ContactSolver>,
    tool: Arc<core::Tool>,
    pose: core::Pose,
    planes: Vec<contacts::ContactPlane>,
}

impl Asked {
    fn footings(&self) -> impl Iterator<Item = contacts::Footing> + '_ {
        self.planes.iter().map(|plane| self.solver.footing(&self.tool, &self.pose, plane))
    }
}

/// The points that carry each plane, the last of fewer than four again and again, and how many there are.
struct Footing {
    points: Vec<[[f64; 3]; 4]>,
    counts: Vec<u32>,
}

impl Footing {
    fn new<'a>(found: impl Iterator<Item = &'a contacts::Footing>) -> Footing {
        let mut footing = Footing { points: Vec::new(), counts: Vec::new() };
        for points in found.map(contacts::Footing::points) {
            footing.points.push(std::array::from_fn(|i| points[i.min(points.len() - 1)]));
            footing.counts.push(points.len() as u32);
        }
        footing
    }
}

impl Contacts {
    pub fn new(core: contacts::Contacts, (solver, tool, pose): Question) -> Contacts {
        let planes = core.planes.clone();
        let told = Contacts::told(core, &tool, OnceBox::new());
        Contacts { asked: Some(Asked { solver, tool, pose, planes }), ..told }
    }

    /// With footings that are known.
    pub fn with_footings(core: contacts::Contacts, tool: &core::Tool, footings: &[contacts::Footing]) -> Contacts {
        Contacts::told(core, tool, OnceBox::with_value(Box::new(Footing::new(footings.iter()))))
    }

    fn told(core: contacts::Contacts, asked_tool: &core::Tool, footing: OnceBox<Footing>) -> Contacts {
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
            tool_parts: planes.iter().map(|p| p.tool_part(asked_tool)).collect(),
            ids: planes.iter().map(|p| p.id).collect(),
            triangles: [tool, mockup],
            offsets: [tool_offsets, mockup_offsets],
            omitted: core.omitted,
            meeting: core.is_meeting,
            asked: None,
            footing,
        }
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<Contacts> {
        type Planes<'py> = (
            PyReadonlyArray2<'py, f64>,
            PyReadonlyArray2<'py, f64>,
            PyReadonlyArray1<'py, f64>,
            PyReadonlyArray1<'py, u32>,
            PyReadonlyArray1<'py, u32>,
            PyReadonlyArray1<'py, u64>,
        );
        type Lists<'py> = (PyReadonlyArray1<'py, u32>, PyReadonlyArray1<'py, u64>);
        type Footings<'py> = (PyReadonlyArray3<'py, f64>, PyReadonlyArray1<'py, u32>);
        type State<'py> = (Planes<'py>, Lists<'py>, Lists<'py>, Footings<'py>, usize, bool);
        let (planes, tool, mockup, footings, omitted, meeting): State<'_> = state.extract()?;
        let (points, normals) = (rows_of(&planes.0)?, rows_of(&planes.1)?);
        let (gaps, parts, tool_parts, ids) = (list(&planes.2), list(&planes.3), list(&planes.4), list(&planes.5));
        let count = gaps.len();
        let blocks = footings.0.as_array();
        if blocks.shape()[1..] != [4, 3] {
            return Err(damaged("its footings are not four points each"));
        }
        let block = |n| std::array::from_fn(|i| std::array::from_fn(|a| blocks[[n, i, a]]));
        let footing = Footing { points: (0..blocks.shape()[0]).map(block).collect(), counts: list(&footings.1) };
        let of_planes = [points.len(), normals.len(), parts.len(), tool_parts.len(), ids.len()];
        for length in of_planes.into_iter().chain([footing.points.len(), footing.counts.len()]) {
            check_lengths("entries of a plane's", length, count)?;
        }
        if footing.counts.iter().any(|n| !(1..=4).contains(n)) {
            return Err(damaged("a footing has no points, or more than four"));
        }
        let triangles = [list(&tool.0), list(&mockup.0)];
        let offsets = [list(&tool.1), list(&mockup.1)];
        for (triangles, offsets) in triangles.iter().zip(&offsets) {
            check_lengths("offsets", offsets.len(), count + 1)?;
            check_offsets(offsets, triangles.len())?;
        }
        let footing = OnceBox::with_value(Box::new(footing));
        Ok(Contacts {
            points,
            normals,
            gaps,
            parts,
            tool_parts,
            ids,
            triangles,
            offsets,
            omitted,
            meeting,
            asked: None,
            footing,
        })
    }

    /// Found when first asked for, without the interpreter's lock.
    fn footings(&self, py: Python<'_>) -> &Footing {
        py.detach(|| {
            self.footing.get_or_init(|| {
                let found: Vec<_> = self.asked.iter().flat_map(Asked::footings).collect();
                Box::new(Footing::new(found.iter()))
            })
        })
    }
}

#[pymethods]
impl Contacts {
    /// `(k, 3)`: a point of each plane on the mock-up's surface, world, metres.
    #[getter]
    fn points<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<f64>> {
        // SAFETY: the result is frozen and owns its points; the array keeps it alive.
        unsafe { view_rows(slf.as_any(), &slf.get().points) }
    }

    /// `(k, 3)`: unit, from the mock-up to the tool, world.
    #[getter]
    fn normals<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<f64>> {
        // SAFETY: as for the points.
        unsafe { view_rows(slf.as_any(), &slf.get().normals) }
    }

    /// `(k,)`: metres, ascending. Negative: the depth of the tool behind the plane or, where both surfaces are
    /// concave, their overlap along the normal.
    #[getter]
    fn gaps<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        // SAFETY: as for the points.
        unsafe { view(slf.as_any(), &slf.get().gaps) }
    }

    /// `(k,)`: indices into `mockup.parts`.
    #[getter]
    fn parts<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the points.
        unsafe { view(slf.as_any(), &slf.get().parts) }
    }

    /// `(k,)`: indices into `tool.parts`.
    #[getter]
    fn tool_parts<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the points.
        unsafe { view(slf.as_any(), &slf.get().tool_parts) }
    }

    /// `(k,)`: identify the pair of surfaces of tool and mock-up, the same at every pose and in every call, thread
    /// and run. Unique within one answer.
    #[getter]
    fn ids<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u64>> {
        // SAFETY: as for the points.
        unsafe { view(slf.as_any(), &slf.get().ids) }
    }

    /// `(k, 4, 3)`: the points of the tool that carry each contact, tool frame, metres, in order around the normal.
    ///
    /// Plane `i` has the first `footing_counts[i]`; the rest repeat the last. If these points stay in front of the
    /// plane during a turn of up to one degree, so does the part of the tool that lies there, but for 1 % of the
    /// distance by which the turn moves it. Computed at the first access.
    #[getter]
    fn footing<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray3<f64>> {
        // SAFETY: as for the points; once found, footings stay where they are.
        unsafe { view_blocks(slf.as_any(), &slf.get().footings(slf.py()).points) }
    }

    /// `(k,)`: 1 for a corner, 2 for an edge, 3 or 4 for flat and round surfaces.
    #[getter]
    fn footing_counts<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the footing.
        unsafe { view(slf.as_any(), &slf.get().footings(slf.py()).counts) }
    }

    /// Tool triangles behind the planes; plane `i` has those from `tool_offsets[i]` to `tool_offsets[i + 1]`.
    #[getter]
    fn tool_triangles<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the points.
        unsafe { view(slf.as_any(), &slf.get().triangles[0]) }
    }

    /// `(k + 1,)`: into `tool_triangles`.
    #[getter]
    fn tool_offsets<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u64>> {
        // SAFETY: as for the points.
        unsafe { view(slf.as_any(), &slf.get().offsets[0]) }
    }

    /// Triangles of the mock-up behind the planes, as `tool_triangles`.
    #[getter]
    fn mockup_triangles<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the points.
        unsafe { view(slf.as_any(), &slf.get().triangles[1]) }
    }

    /// `(k + 1,)`: into `mockup_triangles`.
    #[getter]
    fn mockup_offsets<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u64>> {
        // SAFETY: as for the points.
        unsafe { view(slf.as_any(), &slf.get().offsets[1]) }
    }

    /// Number of planes left out beyond 32: the least deep or the farthest.
    #[getter]
    fn omitted(&self) -> usize {
        self.omitted
    }

    /// Whether any triangles collide.
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

    fn __getitem__<'py>(slf: &Bound<'py, Self>, index: Index<'py>) -> PyResult<Bound<'py, PyAny>> {
        let plane = |plane| Ok(ContactPlane { contacts: slf.clone().unbind(), plane });
        at(slf.py(), &index, (slf.get().gaps.len(), "plane"), plane)
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        let planes = 0..slf.get().gaps.len();
        let planes = planes.map(|plane| ContactPlane { contacts: slf.clone().unbind(), plane }.into_pyobject(slf.py()));
        PyList::new(slf.py(), planes.collect::<PyResult<Vec<_>>>()?)?.try_iter()
    }

    fn __repr__(&self) -> String {
        match self.gaps.first() {
            Some(gap) => format!("Contacts({}, least gap {})", counted(self.gaps.len(), "plane"), metres(*gap)),
            None => "Contacts(0 planes)".into(),
        }
    }

    /// Its footings are found for it: where it goes there is no scene.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let this = slf.get();
        let parts = (Self::parts(slf), Self::tool_parts(slf));
        let planes = (Self::points(slf), Self::normals(slf), Self::gaps(slf), parts.0, parts.1, Self::ids(slf));
        let tool = (Self::tool_triangles(slf), Self::tool_offsets(slf));
        let mockup = (Self::mockup_triangles(slf), Self::mockup_offsets(slf));
        let footings = (Self::footing(slf), Self::footing_counts(slf));
        reduced(slf.py(), "Contacts", (planes, tool, mockup, footings, this.omitted, this.meeting))
    }
}

/// One contact plane of `Contacts`.
#[pyclass(frozen, module = "feeler._core")]
pub struct ContactPlane {
    contacts: Py<Contacts>,
    plane: usize,
}

impl ContactPlane {
    /// Its triangles of the tool (0) or of the mock-up (1).
    fn triangles(&self, of: usize) -> Vec<u32> {
        let Contacts { triangles, offsets, .. } = self.contacts.get();
        triangles[of][offsets[of][self.plane] as usize..offsets[of][self.plane + 1] as usize].to_vec()
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<ContactPlane> {
        let (contacts, plane): (Py<Contacts>, usize) = state.extract()?;
        let count = contacts.get().gaps.len();
        if plane >= count {
            return Err(damaged(format!("it is plane {plane} of {count}")));
        }
        Ok(ContactPlane { contacts, plane })
    }
}

#[pymethods]
impl ContactPlane {
    /// `(3,)`: on the mock-up's surface, world, metres.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.contacts.get().points[self.plane].to_vec().into_read_only(py)
    }

    /// `(3,)`: unit, from the mock-up to the tool, world.
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.contacts.get().normals[self.plane].to_vec().into_read_only(py)
    }

    /// Metres; negative: depth.
    #[getter]
    fn gap(&self) -> f64 {
        self.contacts.get().gaps[self.plane]
    }

    /// Index into `mockup.parts`.
    #[getter]
    fn part(&self) -> u32 {
        self.contacts.get().parts[self.plane]
    }

    /// Index into `tool.parts`.
    #[getter]
    fn tool_part(&self) -> u32 {
        self.contacts.get().tool_parts[self.plane]
    }

    /// As in `Contacts.ids`.
    #[getter]
    fn id(&self) -> u64 {
        self.contacts.get().ids[self.plane]
    }

    /// `(n, 3)`, n from 1 to 4: as in `Contacts.footing`.
    #[getter]
    fn footing<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let footing = self.contacts.get().footings(py);
        let points = &footing.points[self.plane][..footing.counts[self.plane] as usize];
        Array2::from_shape_fn((points.len(), 3), |(i, a)| points[i][a]).into_read_only(py)
    }

    /// `(t,)`: triangles of the tool behind it, ascending.
    #[getter]
    fn tool_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.triangles(0).into_read_only(py)
    }

    /// `(m,)`: triangles of the mock-up behind it, ascending.
    #[getter]
    fn mockup_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.triangles(1).into_read_only(py)
    }

    fn __repr__(&self) -> String {
        let (gap, part, id) = (metres(self.gap()), self.part(), self.id());
        format!("ContactPlane(gap {gap}, part {part}, id {id:#018x})")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        reduced(py, "ContactPlane", (&self.contacts, self.plane))
    }
}

/// A translation that frees the tool.
#[pyclass(frozen, module = "feeler._core")]
pub struct Penetration {
    translation: core::Point,
    depth: f64,
    kind: contacts::PenetrationKind,
    contacts: Py<Contacts>,
}

/// What a kind is called; its number in arrays is its place.
pub const KINDS: [(contacts::PenetrationKind, &str); 3] = [
    (contacts::PenetrationKind::Exact, "exact"),
    (contacts::PenetrationKind::Bound, "bound"),
    (contacts::PenetrationKind::Estimate, "estimate"),
];

impl Penetration {
    pub fn new(py: Python<'_>, core: contacts::Penetration, asked: Question) -> PyResult<Penetration> {
        let contacts::Penetration { translation, depth, kind, contacts, .. } = core;
        Ok(Penetration { translation, depth, kind, contacts: Py::new(py, Contacts::new(contacts, asked))? })
    }

    /// With footings that are known.
    pub fn with_footings(
        py: Python<'_>,
        core: contacts::Penetration,
        tool: &core::Tool,
        footings: &[contacts::Footing],
    ) -> PyResult<Penetration> {
        let contacts::Penetration { translation, depth, kind, contacts, .. } = core;
        let contacts = Py::new(py, Contacts::with_footings(contacts, tool, footings))?;
        Ok(Penetration { translation, depth, kind, contacts })
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<Penetration> {
        let (translation, depth, called, contacts): (core::Point, f64, String, Py<Contacts>) = state.extract()?;
        let kind = KINDS.iter().find(|(_, name)| *name == called);
        let (kind, _) = *kind.ok_or_else(|| damaged(format!("no penetration is {called:?}")))?;
        Ok(Penetration { translation, depth, kind, contacts })
    }
}

#[pymethods]
impl Penetration {
    /// `(3,)`: metres, world; add it to the pose's translation.
    #[getter]
    fn translation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.translation.to_vec().into_read_only(py)
    }

    /// Its length, metres.
    #[getter]
    fn depth(&self) -> f64 {
        self.depth
    }

    /// `"bound"` (it frees the tool, a shorter one may exist), `"estimate"` (it does not free the tool), or
    /// `"exact"` (the tool does not collide, or only touches).
    #[getter]
    fn kind(&self) -> &'static str {
        KINDS.iter().find(|(kind, _)| *kind == self.kind).map_or("estimate", |(_, name)| name)
    }

    /// The contact planes at the pose.
    #[getter]
    fn contacts(&self, py: Python<'_>) -> Py<Contacts> {
        self.contacts.clone_ref(py)
    }

    fn __repr__(&self) -> String {
        format!("Penetration({}, {})", metres(self.depth), self.kind())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        reduced(py, "Penetration", (self.translation, self.depth, self.kind(), &self.contacts))
    }
}

/// A tool that moves in a scene, and where it was last free. `feeler.ContactTracker` checks what it is given.
#[pyclass(subclass, frozen, module = "feeler._core")]
pub struct ContactTracker {
    solver: Arc<contacts::ContactSolver>,
    tool: Arc<core::Tool>,
    core: Mutex<contacts::ContactTracker>,
}

#[pymethods]
impl ContactTracker {
    #[new]
    #[pyo3(signature = (scene, tool, *, ignore = None))]
    fn new(scene: Py<Scene>, tool: ToolArgument<'_, '_>, ignore: Ignore<'_>) -> PyResult<ContactTracker> {
        let solver = scene.get().asked(&tool, &ignore)?;
        Ok(ContactTracker { solver, tool: Arc::clone(tool.core()), core: Mutex::default() })
    }

    fn contacts(&self, py: Python<'_>, world_from_tool: PoseArgument, within: f64) -> PyResult<Contacts> {
        // The lock is not held meanwhile: a second thread queries with the earlier state, and does not wait. It is held with the
        // interpreter's alone, so that no thread holds it while another forks.
        let mut tracker = *self.core.lock().unwrap_or_else(PoisonError::into_inner);
        let found = stoppable(py, |go_on| {
            find_topology(self.solver.scene().mockup(), &self.tool, false)?;
            tracker.contacts_while(&self.solver, &self.tool, &world_from_tool.0, within, go_on).map_err(to_py)
        })?;
        if !found.is_meeting {
            *self.core.lock().unwrap_or_else(PoisonError::into_inner) = tracker;
        }
        let (solver, tool) = (Arc::clone(&self.solver), Arc::clone(&self.tool));
        Ok(Contacts::new(found, (solver, tool, world_from_tool.0)))
    }

    /// The last pose without a collision, `(4, 4)`.
    #[getter]
    fn last_free<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray2<f64>>> {
        let tracker = *self.core.lock().unwrap_or_else(PoisonError::into_inner);
        tracker.last_free().map(|pose| read_only(pose_array(py, pose)))
    }

    /// Sets the last free pose, or forgets it.
    #[pyo3(name = "_set_last_free")]
    fn set_last_free(&self, world_from_tool: Option<PoseArgument>) {
        let pose = world_from_tool.map(|pose| pose.0);
        self.core.lock().unwrap_or_else(PoisonError::into_inner).set_last_free(pose);
    }
}
