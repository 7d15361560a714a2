//! `feeler._core.World`: a tool, and all that it may meet.

use std::sync::{Arc, Mutex, PoisonError};

use feeler_world::{PutDown, SeatKind, Seated, World as CoreWorld};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pyo3::prelude::*;

use crate::arguments::{PoseArgument, ToolArgument};
use crate::errors::{raise, to_py};
use crate::pools::{find_topology, on_pool};
use crate::scene::Scene;
use crate::travel::stays;

/// The name of a kind of seat.
pub fn kind_name(kind: SeatKind) -> &'static str {
    match kind {
        SeatKind::Near => "near",
        SeatKind::Flush => "touching",
        SeatKind::Fit => "fit",
        SeatKind::Sunk => "sunk",
    }
}

fn world_to_py(error: feeler_world::Error) -> PyErr {
    match error {
        feeler_world::Error::Core(error) => to_py(error),
        other => raise("SessionError", other.to_string()),
    }
}

/// See the module.
#[pyclass(frozen, module = "feeler._core")]
pub struct World {
    world: Mutex<(CoreWorld, Option<Arc<Seated>>)>,
}

/// Where a walk ends; the part of the mock-up, and the tool's where it is known, that end it; and whether that is a seat.
type Stopped<'py> = (Bound<'py, PyArray2<f64>>, f64, Option<(u32, i64, bool)>);

#[pymethods]
impl World {
    /// `put_down`: parts of the scene's mock-up that lie elsewhere, each with the scene of it alone.
    #[new]
    fn new(
        py: Python<'_>,
        scene: PyRef<'_, Scene>,
        tool: ToolArgument<'_, '_>,
        put_down: Vec<(u32, PyRef<'_, Scene>)>,
    ) -> PyResult<World> {
        let (scene, tool) = (scene.core(), Arc::clone(tool.core()));
        let put_down: Vec<PutDown> =
            put_down.iter().map(|(part, scene)| PutDown { part: *part, scene: scene.core() }).collect();
        py.detach(|| {
            let mut scenes = std::iter::once(&scene).chain(put_down.iter().map(|part| &part.scene));
            scenes.try_for_each(|scene| find_topology(scene.mockup(), &tool, true))
        })?;
        let world = CoreWorld::new(scene, tool, &put_down).map_err(world_to_py)?;
        Ok(World { world: Mutex::new((world, None)) })
    }

    /// The tool begins at a pose: what it meets there is a seat.
    fn begin(&self, py: Python<'_>, pose: PoseArgument) -> PyResult<()> {
        let begun = py.detach(|| {
            on_pool(None, || {
                let mut world = self.world.lock().unwrap_or_else(PoisonError::into_inner);
                world.0.move_to(&pose.0)?;
                world.1 = Some(world.0.around().seated_at_start());
                Ok(())
            })
        })?;
        begun.map_err(world_to_py)
    }

    /// What it is still seated on: part of the tool, part of the mock-up, kind, and depth at the start (metres).
    fn seats(&self) -> Vec<(u32, u32, &'static str, f64)> {
        let world = self.world.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(seated) = &world.1 else { return Vec::new() };
        let seats = seated.of(world.0.around().seats());
        seats.iter().map(|seat| (seat.tool_part, seat.part, kind_name(seat.kind), seat.depth)).collect()
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("World", "make it anew from its scene and tool"))
    }

    /// From a pose towards another, as far as that is free, and `off` metres before what stops it.
    fn stop<'py>(
        &self,
        py: Python<'py>,
        start: PoseArgument,
        end: PoseArgument,
        tolerance: f64,
        off: f64,
    ) -> PyResult<Stopped<'py>> {
        let walk = py.detach(|| {
            let mut world = self.world.lock().unwrap_or_else(PoisonError::into_inner);
            let (around, seated) = (world.0.around(), world.1.clone());
            let seated = seated.unwrap_or_else(|| around.seated_at_start());
            let walk = around.stop_short(&seated, (&start.0, &end.0), tolerance, off)?;
            world.1 = Some(walk.seated.clone());
            Ok(walk)
        });
        let walk = walk.map_err(world_to_py)?;
        let matrix = walk.pose.matrix();
        let pose = Array2::from_shape_fn((4, 4), |(i, j)| matrix[i][j]).into_pyarray(py);
        let world = self.world.lock().unwrap_or_else(PoisonError::into_inner);
        let stop = walk.stop.map(|stop| {
            let ours = stop.pair.map_or(-1, |pair| i64::from(world.0.tool().part_of_face(pair.tool_triangle)));
            (stop.part, ours, stop.is_seat)
        });
        Ok((pose, walk.fraction, stop))
    }
}
