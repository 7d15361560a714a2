//! Contacts of known surfaces.

mod behaviours;
mod convex;
mod dirty;
mod near;
mod piercing;
mod planes;
mod ways_out;

use std::ops::Deref;
use std::sync::Arc;

use feeler_core::distance::query::{near_candidates, DistanceScratch};
use feeler_core::distance::wanted::Candidate;
use feeler_core::index::sink::Divider;
use feeler_core::{GoOn, Level, Mockup, Point, Pose, Result, Scene, SceneOptions, Tool};
use feeler_shapes::Arrays;

use crate::{ContactSolver, Contacts, Penetration};

/// A scene with its contacts.
pub(crate) struct Held(ContactSolver);

impl Deref for Held {
    type Target = Scene;

    fn deref(&self) -> &Scene {
        self.0.scene()
    }
}

impl Held {
    pub fn of(mockup: Mockup) -> Held {
        Held::with(Arc::new(mockup), &SceneOptions::default(), Level::best())
    }

    pub fn with(mockup: Arc<Mockup>, options: &SceneOptions<'_>, level: Level) -> Held {
        let mut scene = Scene::build(mockup, options).unwrap();
        scene.set_lanes(level);
        Held(ContactSolver::new(Arc::new(scene)))
    }

    /// What may be near, unless it is more than `most`.
    pub fn near_candidates(
        &self,
        tool: &Tool,
        pose: &Pose,
        within: f64,
        dividers: &[Divider],
        most: usize,
    ) -> Option<Vec<Candidate>> {
        let mut scratch = DistanceScratch::default();
        near_candidates(self.index(), tool, pose, within, dividers, most, GoOn::default(), &mut scratch).unwrap()
    }

    pub fn solver(&self) -> &ContactSolver {
        &self.0
    }

    pub fn contacts(&self, tool: &Tool, pose: &Pose, margin: f64, reference: Option<&Pose>) -> Result<Contacts> {
        self.0.contacts(tool, pose, margin, reference)
    }

    pub fn penetration(&self, tool: &Tool, pose: &Pose, margin: f64, reference: Option<&Pose>) -> Result<Penetration> {
        self.0.penetration(tool, pose, margin, reference)
    }
}

pub(crate) fn scene(mesh: Arrays) -> Held {
    Held::of(Mockup::new(mesh.0, mesh.1, Vec::new(), 1).unwrap())
}

pub(crate) fn tool(mesh: Arrays) -> Tool {
    Tool::new(mesh.0, mesh.1).unwrap()
}

pub(crate) fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::IDENTITY.translated(&[x, y, z]).unwrap()
}

/// A turn about the axis (1, 2, 3).
pub(crate) fn turned(angle: f64, place: Point) -> Pose {
    Pose::new(&feeler_shapes::turned(angle, place)).unwrap()
}

pub(crate) fn moved(mesh: Arrays, pose: &Pose) -> Arrays {
    (mesh.0.iter().map(|p| pose.apply(p)).collect(), mesh.1)
}
