//! The core against the oracle: one pair in several ways, and a whole scene in every store.

use std::sync::Arc;

use feeler_core::geometry::intersect_lanes::prove;
use feeler_core::geometry::predicates::is_collinear;
use feeler_core::{
    intersect_triangle_triangle, BatchOptions, Error, Filters, Level, Mockup, PairKind, Point, Pose, Scene,
    SceneOptions, Storage, Tool, Triangle,
};

use crate::corpus::word;
use crate::oracle;
use crate::scenes::Setup;

/// Pairs and kinds as a query reports them.
pub type Found = Vec<([u32; 2], PairKind)>;

/// All three stores.
pub const STORES: [Storage; 3] = [Storage::Blocks, Storage::Dense, Storage::Hashed { level: 0.7 }];

/// The core's error on a pair whose true answer is known; `None` where it is right.
pub fn fault_of_pair(p: &Triangle, q: &Triangle, truth: Option<PairKind>) -> Option<String> {
    for (what, a, b) in [("first against second", p, q), ("second against first", q, p)] {
        let answer = intersect_triangle_triangle(a, b);
        if answer != truth {
            return Some(format!("{what}: {}, in truth {}", word(answer), word(truth)));
        }
        for lanes in Level::available() {
            let verdict = prove(lanes, &[(*a, *b)]);
            if verdict.apart == 1 && truth.is_some() || verdict.crossing == 1 && truth != Some(PairKind::Crossing) {
                return Some(format!("{what}: {} proves {verdict:?}, in truth {}", lanes.name(), word(truth)));
            }
        }
    }
    for (what, t) in [("first", p), ("second", q)] {
        let [a, b, c] = t;
        if is_collinear(a, b, c) == oracle::has_area(t) {
            return Some(format!("whether the {what} triangle has an area"));
        }
    }
    None
}

/// A built tool and mock-up with the truth at each pose.
#[derive(Debug)]
pub struct Checked {
    mockup: Arc<Mockup>,
    tool: Tool,
    poses: Vec<Pose>,
    /// The true pairs at each pose, sorted.
    pub truth: Vec<Found>,
}

/// Unconnected triangles as vertices and faces.
pub fn arrays_of(triangles: &[Triangle]) -> (Vec<Point>, Vec<[u32; 3]>) {
    let faces = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    (triangles.iter().flatten().copied().collect(), faces)
}

impl Checked {
    /// Takes a scene and decides, with the oracle, all pairs whose boxes meet; `judged` receives each with its answer. `None`
    /// when the mock-up or the tool has no triangle that can be queried.
    pub fn new(setup: &Setup, mut judged: impl FnMut(&Triangle, &Triangle, Option<PairKind>)) -> Option<Checked> {
        let (vertices, faces) = arrays_of(&setup.mockup);
        let mockup = Arc::new(Mockup::new(vertices, faces, Vec::new(), 1).ok()?);
        let (vertices, faces) = arrays_of(&setup.tool);
        let tool = Tool::new(vertices, faces).ok()?;
        let mut truth = Vec::new();
        for pose in &setup.poses {
            let mut found = Found::new();
            for i in tool.mesh().queried() {
                let p = pose.apply_triangle(&setup.tool[i as usize]);
                for j in mockup.mesh().queried() {
                    let q = &setup.mockup[j as usize];
                    if oracle::is_meeting_boxes(&p, q) {
                        let answer = oracle::kind_of_pair(&p, q);
                        judged(&p, q, answer);
                        found.extend(answer.map(|kind| ([i, j], kind)));
                    }
                }
            }
            truth.push(found);
        }
        Some(Checked { mockup, tool, poses: setup.poses.clone(), truth })
    }

    /// The longest side of the box around the mock-up, metres.
    pub fn extent(&self) -> f64 {
        self.mockup.mesh().bounds().extent().iter().fold(0.0, |m, x| m.max(*x))
    }

    /// Builds a scene and runs every query. The first pose with a wrong answer and the error, or `None`.
    ///
    /// Errors when the scene would need more memory than a test should take.
    pub fn fault(&self, storage: Storage, voxel_size: Option<f64>) -> Result<Option<(Pose, String)>, Error> {
        let options =
            SceneOptions::default().with_storage(storage).with_voxel_size(voxel_size).with_memory_limit(1 << 26);
        let mut scene = Scene::build(Arc::clone(&self.mockup), &options)?;
        let batch = scene.collide_batch(&self.tool, &self.poses, &BatchOptions::default())?;
        for (i, (pose, truth)) in self.poses.iter().zip(&self.truth).enumerate() {
            let fault = |what: &str, found: &Found| -> Result<Option<(Pose, String)>, Error> {
                Ok(Some((*pose, format!("{what}: {} pairs found, in truth {}", found.len(), truth.len()))))
            };
            let bare = Filters { repeats: false, boxes: false };
            let mut ways = vec![(Level::best(), bare)];
            ways.extend(Level::available().into_iter().map(|lanes| (lanes, Filters::default())));
            for (lanes, filters) in ways {
                scene.set_lanes(lanes);
                let collision = scene.collide_filtered(&self.tool, pose, filters);
                let found: Found = collision.pairs.into_iter().zip(collision.kinds).collect();
                if found != *truth {
                    return fault(
                        &format!("{storage:?}, voxel size {voxel_size:?}, {}, {filters:?}", lanes.name()),
                        &found,
                    );
                }
            }
            let range = batch.offsets[i] as usize..batch.offsets[i + 1] as usize;
            let found: Found =
                batch.pairs[range.clone()].iter().copied().zip(batch.kinds[range].iter().copied()).collect();
            if found != *truth {
                return fault(&format!("{storage:?}, voxel size {voxel_size:?}, in a batch"), &found);
            }
            if scene.is_colliding(&self.tool, pose) == truth.is_empty() {
                return fault(&format!("{storage:?}, voxel size {voxel_size:?}, is_colliding"), &found);
            }
        }
        Ok(None)
    }
}
