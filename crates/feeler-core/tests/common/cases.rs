//! The scenes of [`feeler_shapes::cases`] as meshes.

use std::sync::Arc;

use feeler_core::{Mockup, Pose, Tool};

use super::tool_of;

pub struct Case {
    pub name: &'static str,
    pub mockup: Arc<Mockup>,
    pub tool: Tool,
    pub poses: Vec<Pose>,
}

impl Case {
    /// The largest side of the mock-up, metres.
    pub fn extent(&self) -> f64 {
        self.mockup.mesh().bounds().extent().iter().fold(0.0, |m, x| m.max(*x))
    }
}

pub fn cases() -> Vec<Case> {
    let held = |case: feeler_shapes::cases::Case| {
        let (vertices, faces) = case.mockup;
        Case {
            name: case.name,
            mockup: Arc::new(Mockup::new(vertices, faces, case.part_of_face, case.parts).unwrap()),
            tool: tool_of(case.tool),
            poses: case.poses.iter().map(|m| Pose::new(m).unwrap()).collect(),
        }
    };
    feeler_shapes::cases::cases().into_iter().map(held).collect()
}
