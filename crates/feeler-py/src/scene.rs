//! `feeler._core.Scene` and the voxel-size function.

use std::sync::Arc;
use std::time::Instant;

use feeler_contacts as contacts;
use feeler_contacts::ContactSolver;
use feeler_core as core;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::along::ClearanceAlong;
use crate::arguments::{
    end_pose_or_none, reference_pose_or_none, start_pose, PoseArgument, PosesArgument, Switch, ToolArgument, Touching,
};
use crate::arrays::IntoReadOnly;
use crate::cast::{Cast, PathCheck};
use crate::collision::{Batch, Collision};
use crate::contacts::{Contacts, Penetration};
use crate::containment::Containment;
use crate::errors::{raise, to_py};
use crate::mockup::{Mockup, MovedMockup};
use crate::pools::{on_pool, Pool};
use crate::proximity::{Clearance, ClearanceBatch, Distance, DistanceBatch};
use crate::rays::{Rays, SectionOutline};
use crate::reporter::Reporter;
use crate::selection::{ignored_of, lanes_of, Ignore, SceneSource, Selected};
use crate::signals::stoppable;
use crate::topology::find_topology;
use crate::travel::rows_of;
use crate::ways::{PathArgument, WayArgument};

/// A mock-up with its index. `feeler.Scene` adds defaults.
#[pyclass(subclass, frozen, module = "feeler._core")]
pub struct Scene {
    core: Arc<core::Scene>,
    solver: Arc<ContactSolver>,
    mockup: Py<Mockup>,
    /// `None`: the pool of the process.
    pool: Option<Arc<Pool>>,
}

impl Scene {
    pub(crate) fn core(&self) -> Arc<core::Scene> {
        Arc::clone(&self.core)
    }

    pub(crate) fn solver(&self) -> &Arc<ContactSolver> {
        &self.solver
    }

    pub(crate) fn pool(&self) -> Option<&Arc<Pool>> {
        self.pool.as_ref()
    }

    /// The solver of the scene, or of one that ignores pairs of parts.
    pub(crate) fn asked(&self, tool: &ToolArgument<'_, '_>, ignore: &Ignore<'_>) -> PyResult<Arc<ContactSolver>> {
        let Some(ignore) = ignore else { return Ok(Arc::clone(&self.solver)) };
        let pairs = ignored_of(ignore, tool, &self.mockup)?;
        Ok(Arc::new(self.solver.with_scene(Arc::new(self.core.ignoring(pairs)))))
    }

    /// The first impact along a leg from a pose.
    fn cast_along(
        &self,
        py: Python<'_>,
        tool: &ToolArgument<'_, '_>,
        (start, leg): (PoseArgument, core::Leg),
        (tolerance, touching): (f64, core::Touching),
        ignore: &Ignore<'_>,
    ) -> PyResult<Option<Cast>> {
        let asked = self.asked(tool, ignore)?;
        let tool = tool.core();
        let found = stoppable(py, |go_on| {
            if touching != core::Touching::Ends {
                find_topology(self.core.mockup(), tool, false)?;
            }
            let motion = core::Motion::of_legs(tool, &start.0, &[leg]).map_err(to_py)?.remove(0);
            let options = core::CastOptions::default().with_tolerance(tolerance).with_touching(touching);
            let options = options.with_go_on(go_on.function());
            asked.scene().cast_along(tool, &motion, &options).map_err(to_py)
        });
        Ok(found?.map(|cast| Cast::new(cast, self.core.mockup(), tool)))
    }

    /// The scene with other parts there.
    fn selected(&self, py: Python<'_>, core: core::Result<core::Scene>) -> PyResult<Selected> {
        let core = Arc::new(core.map_err(to_py)?);
        let solver = Arc::new(self.solver.with_scene(Arc::clone(&core)));
        Ok(Selected { core, solver, mockup: self.mockup.clone_ref(py), pool: self.pool.clone() })
    }
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (mockup, voxel_size = None, storage = "blocks", hashing = 0.0, tool = None, threads = None,
                        progress = None, memory_limit = u64::MAX, simd = None))]
    #[allow(clippy::too_many_arguments, reason = "the Python signature")]
    fn new(
        py: Python<'_>,
        mockup: SceneSource<'_>,
        voxel_size: Option<f64>,
        storage: &str,
        hashing: f64,
        tool: Option<ToolArgument<'_, '_>>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
        memory_limit: u64,
        simd: Option<&str>,
    ) -> PyResult<Scene> {
        let mockup = match mockup {
            SceneSource::Mockup(mockup) => mockup,
            SceneSource::Selected(made) => {
                let Selected { core, solver, mockup, pool } = &*made;
                let (core, solver) = (Arc::clone(core), Arc::clone(solver));
                return Ok(Scene { core, solver, mockup: mockup.clone_ref(py), pool: pool.clone() });
            }
        };
        let lanes = lanes_of(simd)?;
        let storage = match storage {
            "hashed" => core::Storage::Hashed { level: hashing },
            "dense" => core::Storage::Dense,
            "blocks" => core::Storage::Blocks,
            other => {
                return Err(raise("OptionError", format!("storage is {other:?}: choose 'blocks', 'dense' or 'hashed'")))
            }
        };
        if hashing != 0.0 && !matches!(storage, core::Storage::Hashed { .. }) {
            return Err(to_py(core::Error::HashingUnused { value: hashing }));
        }
        let pool = threads.map(|threads| Arc::new(Pool::new(threads)));
        let core_mockup = Arc::clone(&mockup.get().core);
        let core_tool = tool.as_ref().map(|t| Arc::clone(t.core()));
        let options = core::SceneOptions::default()
            .with_voxel_size(voxel_size)
            .with_storage(storage)
            .with_tool(core_tool.as_deref())
            .with_memory_limit(memory_limit);
        let reporter = Reporter::new(progress);
        let built = py.detach(|| {
            reporter.watch(pool.as_deref(), || {
                let tell = |done: f64, stage: &str| reporter.tell(done, stage);
                let goes_on = || !reporter.has_raised();
                core::Scene::build(core_mockup, &options.with_progress(&tell).with_go_on(&goes_on))
            })
        });
        reporter.finish()?;
        let mut core = built?.map_err(to_py)?;
        core.set_lanes(lanes);
        let core = Arc::new(core);
        Ok(Scene { solver: Arc::new(ContactSolver::new(Arc::clone(&core))), core, mockup, pool })
    }

    /// The mock-up.
    #[getter]
    pub(crate) fn mockup(&self, py: Python<'_>) -> Py<Mockup> {
        self.mockup.clone_ref(py)
    }

    /// Edge of the voxels, or the piece size of blocks, metres.
    #[getter]
    fn voxel_size(&self) -> f64 {
        self.core.voxel_size()
    }

    /// `"blocks"`, `"dense"` or `"hashed"`.
    #[getter]
    fn storage(&self) -> &'static str {
        self.core.storage().name()
    }

    /// The hashing level; 0 unless hashed.
    #[getter]
    fn hashing(&self) -> f64 {
        match self.core.storage() {
            core::Storage::Hashed { level } => level,
            _ => 0.0,
        }
    }

    /// The instruction set of its queries: `"avx512"`, `"avx2"`, `"neon"` or `"portable"`.
    #[getter]
    fn simd(&self) -> &'static str {
        self.core.lanes().name()
    }

    #[pyo3(name = "_save")]
    fn save(
        &self,
        py: Python<'_>,
        path: std::path::PathBuf,
        extras: Vec<(String, Vec<u8>)>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        crate::saved::save(py, &self.core, self.pool.as_deref(), (path, extras), progress)
    }

    /// The scene without parts, and with no parts but these, by number: an argument for `Scene`.
    #[pyo3(name = "_selected_without")]
    fn selected_without(&self, py: Python<'_>, parts: Vec<u32>) -> PyResult<Selected> {
        let core = py.detach(|| self.core.without(&parts));
        self.selected(py, core)
    }

    #[pyo3(name = "_selected_only")]
    fn selected_only(&self, py: Python<'_>, parts: Vec<u32>) -> PyResult<Selected> {
        let core = py.detach(|| self.core.only(&parts));
        self.selected(py, core)
    }

    /// The scene with parts at poses: by part the number of its pose, or -1. `mockup_of` makes a mock-up of a `MovedMockup`.
    #[pyo3(name = "_selected_moved")]
    fn selected_moved(
        &self,
        py: Python<'_>,
        pose_of_part: Vec<i64>,
        poses: PosesArgument,
        mockup_of: Bound<'_, PyAny>,
    ) -> PyResult<Selected> {
        let pose_of_part: Vec<Option<u32>> = pose_of_part.into_iter().map(|pose| u32::try_from(pose).ok()).collect();
        let moved = || self.core.moved(&pose_of_part, &poses.0);
        let core = py.detach(|| on_pool(self.pool.as_deref(), moved))?.map_err(to_py)?;
        let holder = MovedMockup { core: Arc::clone(core.mockup()) };
        let mockup = mockup_of.call1((holder,))?.cast_into::<Mockup>()?.unbind();
        let core = Arc::new(core);
        let solver = Arc::new(self.solver.with_scene(Arc::clone(&core)));
        Ok(Selected { core, solver, mockup, pool: self.pool.clone() })
    }

    /// `(parts,)`: true for the parts present in the scene; all of them unless it was made by `without` or
    /// `only`.
    #[getter]
    fn part_mask<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        let parts = self.core.mockup().part_bounds().len() as u32;
        (0..parts).map(|part| self.core.has_part(part)).collect::<Vec<bool>>().into_read_only(py)
    }

    /// Bytes by structure, and their `"total"`: all that stays in memory for the index.
    ///
    /// `"triangles"` and `"parts"` are the mock-up's own arrays, which the index reads and does not copy.
    fn memory<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let mut total = 0;
        for (name, bytes) in self.core.memory() {
            dict.set_item(name, bytes)?;
            total += bytes;
        }
        dict.set_item("total", total)?;
        Ok(dict)
    }

    /// Raises `FeelerError` if an invariant of the index does not hold; for tests.
    fn validate(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| self.core.validate()).map_err(|why| raise("FeelerError", why))
    }

    /// Every colliding pair of triangles, with the tool at a pose `(4, 4)`; exact.
    ///
    /// The filters skip repeated pairs and compare boxes first. They never change the answer; switch one off to measure
    /// its effect. Raises `PoseError` for a pose that is not rigid.
    #[pyo3(signature = (tool, world_from_tool, *, repeat_filter = Switch(true), box_filter = Switch(true), ignore = None),
           text_signature = "($self, tool, world_from_tool, *, repeat_filter=True, box_filter=True, ignore=None)")]
    fn collide(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        repeat_filter: Switch,
        box_filter: Switch,
        ignore: Ignore<'_>,
    ) -> PyResult<Collision> {
        let filters = core::Filters { repeats: repeat_filter.0, boxes: box_filter.0 };
        let asked = self.asked(&tool, &ignore)?;
        let tool = tool.core();
        let collision = stoppable(py, |go_on| {
            asked.scene().stoppable(go_on).collide_filtered(tool, &world_from_tool.0, filters).map_err(to_py)
        });
        Ok(Collision::new(collision?, self.mockup.clone_ref(py), Arc::clone(tool)))
    }

    /// Whether any two triangles collide, with the tool at a pose `(4, 4)`; stops at the first pair.
    ///
    /// With `touching="free"`, whether one body enters the other: surfaces in contact and a pin seated without play are
    /// free. Crossing pairs enter. Coplanar and touching pairs are decided by exact side tests on the connectivity of
    /// both meshes, which is computed once. An open sheet has no inside: a tool that touches it from both sides goes
    /// through it. Pairs that share only corners of both triangles count as touching.
    #[pyo3(signature = (tool, world_from_tool, *, touching = Touching(core::Touching::Ends), ignore = None),
           text_signature = "($self, tool, world_from_tool, *, touching='counts', ignore=None)")]
    fn is_colliding(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        touching: Touching,
        ignore: Ignore<'_>,
    ) -> PyResult<bool> {
        let asked = self.asked(&tool, &ignore)?;
        let tool = tool.core();
        py.detach(|| {
            if touching.0 == core::Touching::Ends {
                return Ok(asked.scene().is_colliding(tool, &world_from_tool.0));
            }
            find_topology(self.core.mockup(), tool, false)?;
            Ok(asked.scene().is_entering(tool, &world_from_tool.0))
        })
    }

    /// Whether the tool at a pose `(4, 4)` neither collides nor contains anything, nor is contained
    /// (`containment`).
    #[pyo3(signature = (tool, world_from_tool, *, ignore = None))]
    fn is_free(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        ignore: Ignore<'_>,
    ) -> PyResult<bool> {
        let asked = self.asked(&tool, &ignore)?;
        let tool = tool.core();
        stoppable(py, |go_on| {
            find_topology(self.core.mockup(), tool, true)?;
            asked.stoppable(go_on).is_free(tool, &world_from_tool.0).map_err(to_py)
        })
    }

    /// Which closed parts contain the tool, and which parts the tool contains, at a pose `(4, 4)`.
    ///
    /// Exact, by winding numbers, for each connected surface separately. One solid of a part may contain the tool; the
    /// inside of a hollow counts as outside. A surface that crosses a part is not inside it; one that touches it can
    /// be.
    #[pyo3(signature = (tool, world_from_tool, *, ignore = None))]
    fn containment(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        ignore: Ignore<'_>,
    ) -> PyResult<Containment> {
        let asked = self.asked(&tool, &ignore)?;
        let tool = tool.core();
        let found = stoppable(py, |go_on| {
            find_topology(self.core.mockup(), tool, true)?;
            asked.stoppable(go_on).containment(tool, &world_from_tool.0).map_err(to_py)
        });
        Ok(Containment::new(found?))
    }

    #[pyo3(signature = (tool, poses, progress, *, ignore = None))]
    fn collide_batch(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        poses: PosesArgument,
        progress: Option<Py<PyAny>>,
        ignore: Ignore<'_>,
    ) -> PyResult<Batch> {
        let asked = self.asked(&tool, &ignore)?;
        let tool = tool.core();
        let reporter = Reporter::new(progress);
        let batch = py.detach(|| {
            reporter.watch(self.pool.as_deref(), || {
                let tell = |done: f64, stage: &str| reporter.tell(done, stage);
                let goes_on = || !reporter.has_raised();
                let options = core::BatchOptions::default().with_progress(&tell).with_go_on(&goes_on);
                asked.scene().collide_batch(tool, &poses.0, &options)
            })
        });
        reporter.finish()?;
        Ok(Batch::new(batch?.map_err(to_py)?))
    }

    #[pyo3(signature = (tool, world_from_tool, within, triangles, *, ignore = None))]
    fn clearance(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        within: f64,
        triangles: bool,
        ignore: Ignore<'_>,
    ) -> PyResult<Clearance> {
        let asked = self.asked(&tool, &ignore)?;
        let tool = tool.core();
        let gaps = stoppable(py, |go_on| {
            let scene = asked.scene().stoppable(go_on);
            let gaps = if triangles {
                scene.near_pairs(tool, &world_from_tool.0, within)
            } else {
                scene.clearance(tool, &world_from_tool.0, within)
            };
            gaps.map_err(to_py)
        });
        Ok(Clearance::new(gaps?))
    }

    #[pyo3(signature = (tool, world_from_tool, within, reference, *, ignore = None))]
    fn contacts(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        within: f64,
        #[pyo3(from_py_with = reference_pose_or_none)] reference: Option<PoseArgument>,
        ignore: Ignore<'_>,
    ) -> PyResult<Contacts> {
        let reference = reference.map(|pose| pose.0);
        let asked = self.asked(&tool, &ignore)?;
        let tool = tool.core();
        let found = stoppable(py, |go_on| {
            find_topology(self.core.mockup(), tool, false)?;
            asked.stoppable(go_on).contacts(tool, &world_from_tool.0, within, reference.as_ref()).map_err(to_py)
        });
        Ok(Contacts::new(found?, (asked, Arc::clone(tool), world_from_tool.0)))
    }

    #[pyo3(signature = (tool, world_from_tool, within, reference, *, ignore = None))]
    fn penetration(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        within: f64,
        #[pyo3(from_py_with = reference_pose_or_none)] reference: Option<PoseArgument>,
        ignore: Ignore<'_>,
    ) -> PyResult<Penetration> {
        let reference = reference.map(|pose| pose.0);
        let asked = self.asked(&tool, &ignore)?;
        let tool = tool.core();
        let found = stoppable(py, |go_on| {
            find_topology(self.core.mockup(), tool, true)?;
            asked.stoppable(go_on).penetration(tool, &world_from_tool.0, within, reference.as_ref()).map_err(to_py)
        });
        Penetration::new(py, found?, (asked, Arc::clone(tool), world_from_tool.0))
    }

    /// Columns: parts, parts of the tool, numbers (depth, error, the point of the tool, that of the part), whether it is an estimate;
    /// none if it takes longer than some seconds.
    #[pyo3(signature = (tool, world_from_tool, seconds, *, ignore = None))]
    #[allow(clippy::type_complexity, reason = "a tuple of arrays")]
    fn _depths<'py>(
        &self,
        py: Python<'py>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        seconds: f64,
        ignore: Ignore<'_>,
    ) -> PyResult<Option<(Bound<'py, PyArray2<u32>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<bool>>)>> {
        let asked = self.asked(&tool, &ignore)?;
        let tool = tool.core();
        let start = Instant::now();
        let is_late = || start.elapsed().as_secs_f64() > seconds;
        let found = stoppable(py, |go_on| {
            find_topology(self.core.mockup(), tool, true)?;
            let goes_on = || !is_late() && go_on.goes_on();
            match asked.stoppable(core::GoOn::new(&goes_on)).depths(tool, &world_from_tool.0) {
                Err(core::Error::Cancelled) => Ok(None),
                found => found.map(Some).map_err(to_py),
            }
        })?;
        let Some(found) = found else { return Ok(None) };
        let parts = Array2::from_shape_fn((found.len(), 2), |(n, i)| [found[n].part, found[n].tool_part][i]);
        let numbers = Array2::from_shape_fn((found.len(), 8), |(n, i)| match i {
            0 => found[n].depth,
            1 => found[n].error,
            _ => found[n].points[(i - 2) / 3][(i - 2) % 3],
        });
        let is_estimate: Vec<bool> = found.iter().map(|row| row.kind == contacts::DepthKind::Estimate).collect();
        Ok(Some((parts.into_pyarray(py), numbers.into_pyarray(py), is_estimate.into_pyarray(py))))
    }

    #[pyo3(signature = (tool, world_from_tool, within, *, ignore = None))]
    fn distance(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        within: f64,
        ignore: Ignore<'_>,
    ) -> PyResult<Distance> {
        let asked = self.asked(&tool, &ignore)?;
        let tool = tool.core();
        let gap = stoppable(py, |go_on| {
            asked.scene().stoppable(go_on).distance(tool, &world_from_tool.0, within).map_err(to_py)
        });
        Ok(Distance::new(gap?))
    }

    #[pyo3(signature = (tool, world_from_tool, within, k, *, ignore = None))]
    #[pyo3(name = "_distances")]
    fn distances(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        within: f64,
        k: usize,
        ignore: Ignore<'_>,
    ) -> PyResult<Vec<Distance>> {
        let asked = self.asked(&tool, &ignore)?;
        let tool = tool.core();
        let gaps = stoppable(py, |go_on| {
            asked.scene().stoppable(go_on).nearest(tool, &world_from_tool.0, k, within).map_err(to_py)
        });
        Ok(gaps?.into_iter().map(|gap| Distance::new(Some(gap))).collect())
    }

    #[pyo3(signature = (tool, poses, within, progress, *, ignore = None))]
    fn distance_batch(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        poses: PosesArgument,
        within: f64,
        progress: Option<Py<PyAny>>,
        ignore: Ignore<'_>,
    ) -> PyResult<DistanceBatch> {
        let asked = self.asked(&tool, &ignore)?;
        let tool = tool.core();
        let reporter = Reporter::new(progress);
        let gaps = py.detach(|| {
            reporter.watch(self.pool.as_deref(), || {
                let tell = |done: f64, stage: &str| reporter.tell(done, stage);
                let goes_on = || !reporter.has_raised();
                let options = core::BatchOptions::default().with_progress(&tell).with_go_on(&goes_on);
                asked.scene().distance_batch(tool, &poses.0, within, &options)
            })
        });
        reporter.finish()?;
        Ok(DistanceBatch::new(gaps?.map_err(to_py)?))
    }

    #[pyo3(signature = (tool, poses, within, triangles, progress, *, ignore = None))]
    #[allow(clippy::too_many_arguments, reason = "the Python signature")]
    fn clearance_batch(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        poses: PosesArgument,
        within: f64,
        triangles: bool,
        progress: Option<Py<PyAny>>,
        ignore: Ignore<'_>,
    ) -> PyResult<ClearanceBatch> {
        let asked = self.asked(&tool, &ignore)?;
        let tool = tool.core();
        let reporter = Reporter::new(progress);
        let batch = py.detach(|| {
            reporter.watch(self.pool.as_deref(), || {
                let tell = |done: f64, stage: &str| reporter.tell(done, stage);
                let goes_on = || !reporter.has_raised();
                let options = core::BatchOptions::default().with_progress(&tell).with_go_on(&goes_on);
                if triangles {
                    asked.scene().near_pairs_batch(tool, &poses.0, within, &options)
                } else {
                    asked.scene().clearance_batch(tool, &poses.0, within, &options)
                }
            })
        });
        reporter.finish()?;
        Ok(ClearanceBatch::new(batch?.map_err(to_py)?))
    }

    #[pyo3(signature = (tool, pose, way, *, within, error, ignore = None))]
    #[allow(clippy::too_many_arguments, reason = "the Python signature")]
    fn clearance_along(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        pose: PoseArgument,
        way: WayArgument<true>,
        within: f64,
        error: f64,
        ignore: Ignore<'_>,
    ) -> PyResult<ClearanceAlong> {
        let asked = self.asked(&tool, &ignore)?;
        let tool = tool.core();
        let found = stoppable(py, |go_on| {
            let motion = core::Motion::of_legs(tool, &pose.0, &[way.0]).map_err(to_py)?.remove(0);
            asked.scene().clearance_along(tool, &motion, (within, error), go_on).map_err(to_py)
        });
        Ok(ClearanceAlong::new(found?))
    }

    #[pyo3(signature = (tool, start, end = None, *, screw = None, tolerance, touching, ignore = None))]
    #[allow(clippy::too_many_arguments, reason = "the Python signature")]
    fn cast(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        #[pyo3(from_py_with = start_pose)] start: PoseArgument,
        #[pyo3(from_py_with = end_pose_or_none)] end: Option<PoseArgument>,
        screw: Option<WayArgument<false>>,
        tolerance: f64,
        touching: Touching,
        ignore: Ignore<'_>,
    ) -> PyResult<Option<Cast>> {
        let leg = match (end, screw) {
            (Some(end), None) => core::Leg::To(end.0),
            (None, Some(screw)) => screw.0,
            _ => return Err(raise("OptionError", "a cast needs either a second pose or a screw".into())),
        };
        self.cast_along(py, &tool, (start, leg), (tolerance, touching.0), &ignore)
    }

    /// As a cast with `touching="free"`, and at the given poses, too, what enters is decided within the tolerance.
    #[pyo3(name = "_cast_within", signature = (tool, start, screw, *, tolerance, ignore = None))]
    fn cast_within(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        #[pyo3(from_py_with = start_pose)] start: PoseArgument,
        screw: WayArgument<false>,
        tolerance: f64,
        ignore: Ignore<'_>,
    ) -> PyResult<Option<Cast>> {
        self.cast_along(py, &tool, (start, screw.0), (tolerance, core::Touching::Within), &ignore)
    }

    #[pyo3(signature = (tool, poses, *, tolerance, touching, inside, progress, ignore = None))]
    #[allow(clippy::too_many_arguments, reason = "the Python signature")]
    fn check_path(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        poses: PathArgument,
        tolerance: f64,
        touching: Touching,
        inside: bool,
        progress: Option<Py<PyAny>>,
        ignore: Ignore<'_>,
    ) -> PyResult<PathCheck> {
        let asked = self.asked(&tool, &ignore)?;
        let tool = tool.core();
        let inside = stoppable(py, |go_on| {
            if touching.0 == core::Touching::Free || inside {
                find_topology(self.core.mockup(), tool, inside)?;
            }
            let start = poses.start().filter(|_| inside);
            start.map(|pose| asked.stoppable(go_on).containment(tool, pose).map_err(to_py)).transpose()
        })?;
        let reporter = Reporter::new(progress);
        let check = py.detach(|| {
            reporter.watch(self.pool.as_deref(), || {
                let tell = |done: f64, stage: &str| reporter.tell(done, stage);
                let scene = asked.scene();
                let options = core::PathOptions::default().with_tolerance(tolerance).with_touching(touching.0);
                let goes_on = || !reporter.has_raised();
                let options = options.with_progress(&tell).with_go_on(&goes_on);
                match &poses {
                    PathArgument::Legs(start, legs) => scene.check_legs(tool, start, legs, &options),
                    PathArgument::Poses(poses) => scene.check_path(tool, poses, &options),
                }
            })
        });
        reporter.finish()?;
        Ok(PathCheck::new(check?.map_err(to_py)?, self.core.mockup(), tool, inside.map(Containment::new)))
    }

    #[pyo3(signature = (origins, directions, *, within, sections))]
    fn rays(
        &self,
        py: Python<'_>,
        origins: PyReadonlyArray2<'_, f64>,
        directions: PyReadonlyArray2<'_, f64>,
        within: f64,
        sections: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Rays> {
        let (origins, directions) = (rows_of(&origins)?, rows_of(&directions)?);
        let rays: Vec<core::Ray> =
            origins.into_iter().zip(directions).map(|(origin, direction)| core::Ray { origin, direction }).collect();
        let sections: Vec<core::HalfSpace> = rows_of::<f64, 4>(&sections)?
            .into_iter()
            .map(|[x, y, z, offset]| core::HalfSpace { normal: [x, y, z], offset })
            .collect();
        let found = py.detach(|| match &rays[..] {
            // Less work than to wake another thread.
            [ray] => Ok(self.core.ray(ray, within, &sections).map(|hit| vec![hit])),
            rays => on_pool(self.pool.as_deref(), || self.core.rays(rays, within, &sections)),
        })?;
        Ok(Rays::new(found.map_err(to_py)?))
    }

    fn section(&self, py: Python<'_>, point: [f64; 3], normal: [f64; 3]) -> PyResult<SectionOutline> {
        let cut = py.detach(|| on_pool(self.pool.as_deref(), || self.core.section(&point, &normal)))?;
        Ok(SectionOutline::new(cut.map_err(to_py)?))
    }
}

/// Metres; estimator "area", "diagonal" or "side".
#[pyfunction]
pub fn optimal_voxel_size(
    py: Python<'_>,
    mockup: &Bound<'_, Mockup>,
    tool: ToolArgument<'_, '_>,
    estimator: &str,
) -> PyResult<f64> {
    let estimator = match estimator {
        "area" => core::Estimator::Area,
        "diagonal" => core::Estimator::Diagonal,
        "side" => core::Estimator::Side,
        other => {
            return Err(raise(
                "OptionError",
                format!("estimator is {other:?}: choose 'calibrated', 'area', 'diagonal' or 'side'"),
            ))
        }
    };
    let (mockup, tool) = (&mockup.get().core, tool.core());
    py.detach(|| on_pool(None, || core::optimal_voxel_size(mockup.mesh(), tool, estimator)))
}
