//! `feeler._core.World`, the surroundings of a tool, and `GuardedMove`, a tool in it that contact stops.

use std::sync::{Arc, Mutex, PoisonError};

use feeler_core as core;
use feeler_world as world;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arguments::{PoseArgument, PosesArgument, ToolArgument};
use crate::arrays::{pose_array, IntoReadOnly};
use crate::collision::Collision;
use crate::contacts::{Contacts, Penetration};
use crate::errors::{raise, to_py};
use crate::mockup::Mockup;
use crate::pools::on_pool;
use crate::proximity::{Clearance, Distance};
use crate::scene::Scene;
use crate::topology::find_topology;
use crate::travel::{check_lengths, kinds_of, rows_of, stays};
use crate::ways::WayArgument;

/// The name of a kind of seat.
pub fn kind_name(kind: world::SeatKind) -> &'static str {
    match kind {
        world::SeatKind::Near => "near",
        world::SeatKind::Flush => "touching",
        world::SeatKind::Fit => "fit",
        world::SeatKind::Sunk => "sunk",
    }
}

fn world_to_py(error: world::Error) -> PyErr {
    match error {
        world::Error::Core(error) => to_py(error),
        other => raise("SessionError", other.to_string()),
    }
}

/// A scene, and parts of its mock-up that lie elsewhere, queried as one; indices are the mock-up's.
#[pyclass(subclass, frozen, module = "feeler._core")]
pub struct World {
    environment: world::Environment,
    mockup: Py<Mockup>,
}

impl World {
    /// How the meshes hang together is found first, outside of the interpreter's lock.
    fn asked<T: Send>(
        &self,
        py: Python<'_>,
        tool: &Arc<core::Tool>,
        ask: impl FnOnce(&world::Environment) -> world::Result<T> + Send,
    ) -> PyResult<T> {
        py.detach(|| {
            for body in &self.environment.bodies {
                find_topology(body.solver.scene().mockup(), tool, true)?;
            }
            ask(&self.environment).map_err(world_to_py)
        })
    }
}

#[pymethods]
impl World {
    /// `put_down`: parts of the scene's mock-up that lie elsewhere, each with a scene of it at its new place.
    #[new]
    fn new(py: Python<'_>, scene: PyRef<'_, Scene>, put_down: Vec<(u32, PyRef<'_, Scene>)>) -> PyResult<World> {
        let put_down: Vec<_> = put_down.iter().map(|(part, scene)| world::PutDown::new(*part, scene.core())).collect();
        let (scene, mockup) = (scene.core(), scene.mockup(py));
        let made = py.detach(|| world::Environment::new(&scene, &put_down));
        Ok(World { environment: made.map_err(world_to_py)?, mockup })
    }

    /// Every colliding pair of triangles.
    fn collide(&self, py: Python<'_>, tool: ToolArgument<'_, '_>, world_from_tool: PoseArgument) -> Collision {
        let tool = Arc::clone(tool.core());
        let found = py.detach(|| self.environment.collide(&tool, &world_from_tool.0));
        Collision::new(found, self.mockup.clone_ref(py), tool)
    }

    /// The `Collision` of known pairs `(k, 2)` of tool and mock-up triangles and their kinds.
    fn collision_of(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        pairs: PyReadonlyArray2<'_, u32>,
        kinds: PyReadonlyArray1<'_, u8>,
    ) -> PyResult<Collision> {
        let mut known = core::Collision::default();
        (known.pairs, known.kinds) = (rows_of(&pairs)?, kinds_of(&kinds)?);
        check_lengths("kinds", known.kinds.len(), known.pairs.len())?;
        let (tool, faces) = (tool.core(), self.mockup.get().core.mesh().faces().len());
        let is_there = |[t, m]: &[u32; 2]| (*t as usize) < tool.mesh().faces().len() && (*m as usize) < faces;
        if !known.pairs.iter().all(is_there) {
            return Err(raise("OptionError", "pairs are of triangles that tool or mock-up do not have".into()));
        }
        Ok(Collision::new(known, self.mockup.clone_ref(py), Arc::clone(tool)))
    }

    /// Whether any triangles collide.
    fn is_colliding(&self, py: Python<'_>, tool: ToolArgument<'_, '_>, world_from_tool: PoseArgument) -> bool {
        let tool = tool.core();
        py.detach(|| self.environment.is_colliding(tool, &world_from_tool.0))
    }

    /// The first impact between two poses, as `Scene.cast`; None if the motion is free.
    fn cast(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        start: PoseArgument,
        end: PoseArgument,
        tolerance: f64,
    ) -> PyResult<Option<Impact>> {
        let tool = tool.core();
        let found = py.detach(|| self.environment.cast(tool, (&start.0, &end.0), tolerance)).map_err(world_to_py)?;
        Ok(found.map(|(hit, part)| Impact { core: world::Impact::new(&hit, part) }))
    }

    /// The smallest distance; infinite if no part is within `within`.
    fn distance(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        within: f64,
    ) -> PyResult<Distance> {
        let tool = tool.core();
        let found = py.detach(|| self.environment.distance(tool, &world_from_tool.0, within));
        Ok(Distance::new(found.map_err(world_to_py)?))
    }

    /// The parts within `within`, nearest first.
    fn clearance(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        within: f64,
    ) -> PyResult<Clearance> {
        let tool = tool.core();
        let found = py.detach(|| self.environment.clearance(tool, &world_from_tool.0, within));
        Ok(Clearance::new(found.map_err(world_to_py)?))
    }

    /// The contact planes, deepest first.
    #[pyo3(signature = (tool, world_from_tool, within, reference = None))]
    fn contacts(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        within: f64,
        reference: Option<PoseArgument>,
    ) -> PyResult<Contacts> {
        let (tool, pose) = (tool.core(), world_from_tool.0);
        let reference = reference.map(|pose| pose.0);
        let ask = |all: &world::Environment| all.contacts(tool, &pose, within, reference.as_ref());
        let (found, footings) = self.asked(py, tool, ask)?;
        Ok(Contacts::with_footings(found, tool, &footings))
    }

    /// The shortest translation found that frees the tool from the body it is deepest in; None if it is in none.
    fn penetration(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
        within: f64,
    ) -> PyResult<Option<Penetration>> {
        let (tool, pose) = (tool.core(), world_from_tool.0);
        let found = self.asked(py, tool, |all| all.penetration(tool, &pose, within))?;
        found.map(|(found, footings)| Penetration::with_footings(py, found, tool, &footings)).transpose()
    }

    /// Whether the tool is inside a part, or contains one.
    fn is_containing(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
    ) -> PyResult<bool> {
        let tool = tool.core();
        self.asked(py, tool, |all| Ok(all.is_containing(tool, &world_from_tool.0)))
    }

    /// The seats, as pairs of tool part and mock-up part in contact: unique, sorted.
    fn seated_parts<'py>(
        &self,
        py: Python<'py>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
    ) -> PyResult<Vec<(u32, u32)>> {
        let tool = tool.core();
        let pairs = py.detach(|| self.environment.seated_parts(tool, &world_from_tool.0)).map_err(world_to_py)?;
        Ok(pairs.into_iter().map(<(u32, u32)>::from).collect())
    }

    /// The smallest distance along poses `(n, 4, 4)`, at most `within`; ignores the given pairs of parts.
    fn least_distance(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        way: PosesArgument,
        within: f64,
        ignore: Vec<[u32; 2]>,
    ) -> PyResult<f64> {
        let tool = tool.core();
        let least = py.detach(|| self.environment.ignoring(tool, &ignore).least_distance(tool, &way.0, within));
        least.map_err(world_to_py)
    }

    /// The parts of some triangles of the mock-up.
    fn part_of<'py>(&self, py: Python<'py>, triangles: PyReadonlyArray1<'py, u32>) -> Bound<'py, PyArray1<u32>> {
        let mockup = &self.mockup.get().core;
        let parts: Vec<u32> = triangles.as_array().iter().map(|triangle| mockup.part_of_face(*triangle)).collect();
        parts.into_read_only(py)
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("World", "make it anew from its scenes"))
    }
}

/// An impact: the free fraction of the motion, point and unit normal `(3,)` (mock-up to tool), world; the part.
#[pyclass(frozen, module = "feeler._core")]
pub struct Impact {
    core: world::Impact,
}

#[pymethods]
impl Impact {
    #[new]
    fn new(fraction: f64, point: core::Point, normal: core::Point, part: u32) -> Impact {
        Impact { core: world::Impact { fraction, point, normal, part } }
    }

    #[getter]
    fn fraction(&self) -> f64 {
        self.core.fraction
    }

    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.core.point.to_vec().into_read_only(py)
    }

    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.core.normal.to_vec().into_read_only(py)
    }

    #[getter]
    fn part(&self) -> u32 {
        self.core.part
    }

    fn __repr__(&self) -> String {
        format!("Impact(fraction={:?}, part={})", self.core.fraction, self.core.part)
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("Impact", "send its part and its point"))
    }
}

/// A part of the tool and one of the mock-up in contact at the start.
#[pyclass(frozen, get_all, module = "feeler._core")]
pub struct SeatAnswer {
    /// Index into `tool.parts`.
    tool_part: u32,
    /// Index into `mockup.parts`.
    part: u32,
    /// `touching`, `fit` or `sunk`.
    kind: &'static str,
    /// Metres.
    depth: f64,
}

impl SeatAnswer {
    pub fn new(seat: &world::Seat) -> SeatAnswer {
        SeatAnswer { tool_part: seat.tool_part, part: seat.part, kind: kind_name(seat.kind), depth: seat.depth }
    }
}

#[pymethods]
impl SeatAnswer {
    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("SeatAnswer", "send its fields"))
    }
}

/// Where a guarded move ended.
#[pyclass(frozen, get_all, module = "feeler._core")]
pub struct MoveAnswer {
    /// `(4, 4)` world_from_tool.
    pose: Py<PyArray2<f64>>,
    /// The impact that stopped the tool, if any.
    impact: Option<Py<Impact>>,
}

#[pymethods]
impl MoveAnswer {
    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("MoveAnswer", "send its pose"))
    }
}

/// A tool that stops at contact. Parts in contact at the start are seats: it may slide along them and separate.
#[pyclass(frozen, module = "feeler._core")]
pub struct GuardedMove {
    core: Mutex<world::GuardedMove>,
}

impl GuardedMove {
    fn lock(&self) -> std::sync::MutexGuard<'_, world::GuardedMove> {
        self.core.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl GuardedMove {
    #[new]
    fn new(
        py: Python<'_>,
        world: PyRef<'_, World>,
        tool: ToolArgument<'_, '_>,
        world_from_tool: PoseArgument,
    ) -> PyResult<GuardedMove> {
        let tool = tool.core();
        let begun = world.asked(py, tool, |all| {
            let all = world::Environment { bodies: all.bodies.clone() };
            Ok(on_pool(None, || world::GuardedMove::new(all, Arc::clone(tool), &world_from_tool.0)))
        })?;
        Ok(GuardedMove { core: Mutex::new(begun?.map_err(world_to_py)?) })
    }

    /// The remaining seats, with their depths at the start.
    fn seats(&self) -> Vec<SeatAnswer> {
        self.lock().seats().iter().map(SeatAnswer::new).collect()
    }

    /// Moves from a pose towards another as far as possible.
    ///
    /// `tolerance`: of the casts. `off`: the distance before an impact at which it stops. Metres.
    fn go(
        &self,
        py: Python<'_>,
        start: PoseArgument,
        end: PoseArgument,
        tolerance: f64,
        off: f64,
    ) -> PyResult<MoveAnswer> {
        let moved = py.detach(|| self.lock().go(&start.0, &end.0, tolerance, off)).map_err(world_to_py)?;
        let impact = moved.impact.map(|core| Py::new(py, Impact { core })).transpose()?;
        Ok(MoveAnswer { pose: pose_array(py, &moved.pose).unbind(), impact })
    }

    /// Moves from a pose along a screw, slide or chain, or to another pose, exactly, as far as possible; it stays
    /// where it is. The pose, the impact if any, and the free fraction of the motion.
    ///
    /// Contacts may be as deep as at the pose it was made at, wherever the motion starts. `tolerance`: of the casts,
    /// metres.
    fn along(
        &self,
        py: Python<'_>,
        tool: ToolArgument<'_, '_>,
        start: PoseArgument,
        way: WayArgument<true>,
        tolerance: f64,
    ) -> PyResult<(MoveAnswer, f64)> {
        let motion = core::Motion::of_legs(tool.core(), &start.0, &[way.0]).map_err(to_py)?.remove(0);
        let (moved, fraction) = py.detach(|| self.lock().along(&motion, tolerance)).map_err(world_to_py)?;
        let impact = moved.impact.map(|core| Py::new(py, Impact { core })).transpose()?;
        Ok((MoveAnswer { pose: pose_array(py, &moved.pose).unbind(), impact }, fraction))
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("GuardedMove", "make it anew from its world and tool"))
    }
}
