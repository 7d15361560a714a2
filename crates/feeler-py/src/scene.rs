//! `feeler._core.Scene` and the voxel-size function.

use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core as core;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments::{PoseArgument, PosesArgument, Switch, ToolArgument};
use crate::cast::{Cast, PathCheck};
use crate::collision::{Batch, Collision};
use crate::contacts::{Contacts, Penetration, Question};
use crate::errors::{raise, to_py};
use crate::mockup::Mockup;
use crate::pools::{find_topology, on_pool, Pool};
use crate::proximity::{Clearance, ClearanceBatch, Distance, DistanceBatch};
use crate::reporter::Reporter;

/// A mock-up with its index. `feeler.Scene` adds defaults.
#[pyclass(subclass, frozen, module = "feeler._core")]
pub struct Scene {
    core: Arc<core::Scene>,
    solver: Arc<ContactSolver>,
    mockup: Py<Mockup>,
    /// `None`: the pool of the process.
    pool: Option<Pool>,
}

impl Scene {
    pub(crate) fn solver(&self) -> &Arc<ContactSolver> {
        &self.solver
    }

    fn asked(&self, tool: &Arc<core::Tool>, pose: core::Pose) -> Question {
        (Arc::clone(&self.solver), Arc::clone(tool), pose)
    }
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (mockup, voxel_size, storage, hashing, tool, threads, progress, memory_limit, simd))]
    #[allow(clippy::too_many_arguments, reason = "the Python signature")]
    fn new(
        py: Python<'_>,
        mockup: Py<Mockup>,
        voxel_size: Option<f64>,
        storage: &str,
        hashing: f64,
        tool: Option<ToolArgument<'_, '_>>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
        memory_limit: u64,
        simd: Option<&str>,
    ) -> PyResult<Scene> {
        let lanes = match simd {
            None => core::Level::best(),
            Some(name) => {
                let levels = core::Level::available();
                let named = levels.iter().find(|level| level.name() == name);
                *named.ok_or_else(|| {
                    let names: Vec<&str> = levels.iter().map(|level| level.name()).collect();
                    raise("OptionError", format!("simd is {name:?}: this CPU has {}", names.join(", ")))
                })?
            }
        };
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
        let pool = threads.map(Pool::new);
        let core_mockup = Arc::clone(&mockup.get().core);
        let core_tool = tool.as_ref().map(|t| Arc::clone(t.core()));
        let options = core::SceneOptions { voxel_size, storage, tool: core_tool.as_deref(), memory_limit };
        let reporter = Reporter::new(progress);
        let built = py.detach(|| {
            reporter.watch(pool.as_ref(), || {
                core::Scene::build(core_mockup, &options, &|done, stage| reporter.tell(done, stage))
            })
        });
        reporter.finish()?;
        let mut core = built?.map_err(to_py)?;
        core.set_lanes(lanes);
        let core = Arc::new(core);
        Ok(Scene { solver: Arc::new(ContactSolver::new(Arc::clone(&core))), core, mockup, pool })
    }

    #[getter]
    fn mockup(&self, py: Python<'_>) -> Py<Mockup> {
        self.mockup.clone_ref(py)
    }

    #[getter]
    fn voxel_size(&self) -> f64 {
        self.core.voxel_size()
    }

    #[getter]
    fn storage(&self) -> &'static str {
        self.core.storage().name()
    }

    #[getter]
    fn hashing(&self) -> f64 {
        match self.core.storage() {
            core::Storage::Hashed { level } => level,
            _ => 0.0,
        }
    }

    #[getter]
    fn simd(&self) -> &'static str {
        self.core.lanes().name()
    }

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

    /// Every pair of triangles that meets, with the tool at a pose `(4, 4)`; exact.
    ///
    /// The filters (skip pairs met before; compare boxes first) never change the answer: switch one off to measure what
    /// it brings. Raises `PoseError` for a pose that is not rigid.
    #[pyo3(signature = (tool, world_from_tool, *, repeat_filter = Switch(true), box_filter = Switch(true)),
           text_signature = "($self, tool, world_from_tool, *, repeat_filter=True, box_filter=True)")]
    fn collide(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        repeat_filter: Switch,
        box_filter: Switch,
    ) -> Collision {
        let filters = core::Filters { repeats: repeat_filter.0, boxes: box_filter.0 };
        let tool = tool.core();
        let collision = py.detach(|| self.core.collide_filtered(tool, &world_from_tool.0, filters));
        Collision::new(collision, self.mockup.clone_ref(py))
    }

    /// Whether any two triangles meet, with the tool at a pose `(4, 4)`; stops at the first pair.
    fn is_colliding(&self, py: Python<'_>, tool: ToolArgument<'_, '_>, world_from_tool: PoseArgument) -> bool {
        let tool = tool.core();
        py.detach(|| self.core.is_colliding(tool, &world_from_tool.0))
    }

    #[pyo3(signature = (tool, poses, progress))]
    fn collide_batch(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        poses: PosesArgument,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Batch> {
        let tool = tool.core();
        let reporter = Reporter::new(progress);
        let batch = py.detach(|| {
            reporter.watch(self.pool.as_ref(), || {
                self.core.collide_batch(tool, &poses.0, &|done, stage| reporter.tell(done, stage))
            })
        });
        reporter.finish()?;
        Ok(Batch::new(batch?.map_err(to_py)?))
    }

    #[pyo3(signature = (tool, world_from_tool, within, triangles))]
    fn clearance(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        within: f64,
        triangles: bool,
    ) -> PyResult<Clearance> {
        let tool = tool.core();
        let gaps = py.detach(|| {
            if triangles {
                self.core.near_pairs(tool, &world_from_tool.0, within)
            } else {
                self.core.clearance(tool, &world_from_tool.0, within)
            }
        });
        Ok(Clearance::new(gaps.map_err(to_py)?))
    }

    #[pyo3(signature = (tool, world_from_tool, margin, reference))]
    fn contacts(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        margin: f64,
        reference: Option<PoseArgument>,
    ) -> PyResult<Contacts> {
        let reference = reference.map(|pose| pose.0);
        let tool = tool.core();
        let found = py.detach(|| {
            find_topology(self.core.mockup(), tool, false)?;
            self.solver.contacts(tool, &world_from_tool.0, margin, reference.as_ref()).map_err(to_py)
        });
        Ok(Contacts::new(found?, self.asked(tool, world_from_tool.0)))
    }

    #[pyo3(signature = (tool, world_from_tool, margin, reference))]
    fn penetration(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        margin: f64,
        reference: Option<PoseArgument>,
    ) -> PyResult<Penetration> {
        let reference = reference.map(|pose| pose.0);
        let tool = tool.core();
        let found = py.detach(|| {
            find_topology(self.core.mockup(), tool, true)?;
            // On a pool, since whether one is inside the other is found with tools of a triangle, which are made on one.
            let ask = || self.solver.penetration(tool, &world_from_tool.0, margin, reference.as_ref());
            on_pool(self.pool.as_ref(), ask)?.map_err(to_py)
        });
        Penetration::new(py, found?, self.asked(tool, world_from_tool.0))
    }

    #[pyo3(signature = (tool, world_from_tool, max))]
    fn distance(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        max: f64,
    ) -> PyResult<Distance> {
        let tool = tool.core();
        Ok(Distance::new(py.detach(|| self.core.closest(tool, &world_from_tool.0, max)).map_err(to_py)?))
    }

    #[pyo3(signature = (tool, world_from_tool, max, k))]
    fn distances(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        max: f64,
        k: usize,
    ) -> PyResult<Vec<Distance>> {
        let tool = tool.core();
        let gaps = py.detach(|| self.core.distance(tool, &world_from_tool.0, max, k)).map_err(to_py)?;
        Ok(gaps.into_iter().map(|gap| Distance::new(Some(gap))).collect())
    }

    #[pyo3(signature = (tool, poses, max, progress))]
    fn distance_batch(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        poses: PosesArgument,
        max: f64,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<DistanceBatch> {
        let tool = tool.core();
        let reporter = Reporter::new(progress);
        let gaps = py.detach(|| {
            reporter.watch(self.pool.as_ref(), || {
                self.core.distance_batch(tool, &poses.0, max, &|done, stage| reporter.tell(done, stage))
            })
        });
        reporter.finish()?;
        Ok(DistanceBatch::new(gaps?.map_err(to_py)?))
    }

    #[pyo3(signature = (tool, poses, within, triangles, progress))]
    fn clearance_batch(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        poses: PosesArgument,
        within: f64,
        triangles: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<ClearanceBatch> {
        let tool = tool.core();
        let reporter = Reporter::new(progress);
        let batch = py.detach(|| {
            reporter.watch(self.pool.as_ref(), || {
                self.core.clearance_batch(tool, &poses.0, within, triangles, &|done, stage| reporter.tell(done, stage))
            })
        });
        reporter.finish()?;
        Ok(ClearanceBatch::new(batch?.map_err(to_py)?))
    }

    #[pyo3(signature = (tool, pose0, pose1, *, tolerance))]
    fn cast(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        pose0: PoseArgument,
        pose1: PoseArgument,
        tolerance: f64,
    ) -> PyResult<Option<Cast>> {
        let tool = tool.core();
        let found = py.detach(|| self.core.cast(tool, &pose0.0, &pose1.0, tolerance)).map_err(to_py)?;
        Ok(found.map(|cast| Cast::new(cast, self.core.mockup())))
    }

    #[pyo3(signature = (tool, poses, *, tolerance, progress))]
    fn check_path(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        poses: PosesArgument,
        tolerance: f64,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<PathCheck> {
        let tool = tool.core();
        let reporter = Reporter::new(progress);
        let check = py.detach(|| {
            reporter.watch(self.pool.as_ref(), || {
                self.core.check_path(tool, &poses.0, tolerance, &|done, stage| reporter.tell(done, stage))
            })
        });
        reporter.finish()?;
        Ok(PathCheck::new(check?.map_err(to_py)?, Arc::clone(self.core.mockup())))
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

/// A pose as `(4, 4) float64`.
pub(crate) fn pose_array<'py>(py: Python<'py>, pose: &core::Pose) -> Bound<'py, PyArray2<f64>> {
    let entry = |i: usize, j: usize| match (i, j) {
        (3, 3) => 1.0,
        (3, _) => 0.0,
        (_, 3) => pose.translation()[i],
        _ => pose.rotation()[i][j],
    };
    Array2::from_shape_fn((4, 4), |(i, j)| entry(i, j)).into_pyarray(py)
}
