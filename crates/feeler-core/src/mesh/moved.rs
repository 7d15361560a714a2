//! Mock-ups with some parts moved: they share what does not move.

use std::sync::{Arc, Mutex};

use once_cell::race::OnceBox;

use crate::error::{Error, Result};
use crate::geometry::bounds::{Aabb, Point};
use crate::geometry::pose::Pose;
use crate::mesh::mockup::Mockup;
use crate::mesh::triangle_mesh::Mesh;

/// Where the triangles and vertices of each part are in the arrays; found when parts are first moved.
#[derive(Debug)]
pub struct PartPlaces {
    /// Triangles of one part that follow each other: their part, and the first; ascending. The last entry ends the list.
    runs: Vec<(u32, u32)>,
    /// By part the first of its vertices and one more than the last; empty where it has none.
    vertices: Vec<[u32; 2]>,
    /// By part whether no vertex between these belongs to another.
    is_alone: Vec<bool>,
}

impl PartPlaces {
    fn new(mockup: &Mockup) -> PartPlaces {
        let (mesh, parts) = (mockup.mesh(), mockup.part_bounds().len());
        let count = mesh.vertices().len() as u32;
        let mut runs = Vec::new();
        let mut vertices = vec![[u32::MAX, 0]; parts];
        let mut last = u32::MAX;
        for (face, corners) in (0..).zip(mesh.faces()) {
            let part = mockup.part_of_face(face);
            if part != last {
                runs.push((part, face));
                last = part;
            }
            let [from, to] = &mut vertices[part as usize];
            for corner in corners.iter().filter(|corner| **corner < count) {
                *from = (*from).min(*corner);
                *to = (*to).max(corner + 1);
            }
        }
        runs.push((u32::MAX, mesh.faces().len() as u32));
        let mut order: Vec<u32> = (0..parts as u32).filter(|p| vertices[*p as usize][0] < u32::MAX).collect();
        order.sort_unstable_by_key(|part| vertices[*part as usize]);
        let mut is_alone = vec![true; parts];
        let mut reaching: Option<u32> = None;
        for part in order {
            let [from, to] = vertices[part as usize];
            match reaching {
                Some(other) if from < vertices[other as usize][1] => {
                    is_alone[part as usize] = false;
                    is_alone[other as usize] = false;
                    if to > vertices[other as usize][1] {
                        reaching = Some(part);
                    }
                }
                _ => reaching = Some(part),
            }
        }
        PartPlaces { runs, vertices, is_alone }
    }

    /// The triangles of some parts, ascending.
    fn triangles(&self, is_in: impl Fn(u32) -> bool) -> impl Iterator<Item = u32> {
        let runs = self.runs.windows(2).filter(move |two| is_in(two[0].0));
        runs.map(|two| two[0].1..two[1].1).collect::<Vec<_>>().into_iter().flatten()
    }
}

/// A buffer of vertices that a moved mock-up no longer needs, and which of them are not where they are modelled.
type Spare = Option<(Vec<Point>, Vec<[u32; 2]>)>;

/// What a mock-up keeps for those with parts moved.
#[derive(Debug, Default)]
pub struct MovedOfThis {
    places: OnceBox<PartPlaces>,
    /// Nobody waits for the lock, as for the working memory of queries.
    spare: Mutex<Spare>,
}

/// What a mock-up with moved parts knows of the one that it is made of.
#[derive(Debug)]
pub struct Rest {
    pub mockup: Arc<Mockup>,
    /// The moved vertices; `None` where there are more of them than in the other.
    changed: Option<Vec<[u32; 2]>>,
    /// By part whether it moved.
    pub is_moved: Vec<bool>,
    /// The triangles of these that are queried where they are modelled, ascending.
    pub asked: Vec<u32>,
    /// Those of them that are still queried; fewer where rounding left one without area.
    pub triangles: Vec<u32>,
}

impl Rest {
    /// Whether as many triangles are queried as where the parts are modelled.
    pub fn are_all_queried(&self) -> bool {
        self.asked.len() == self.triangles.len()
    }

    /// Keeps the vertices for the next mock-up with parts moved.
    pub fn take_back(&mut self, vertices: Option<Vec<Point>>) {
        if let (Some(changed), Some(vertices)) = (self.changed.take(), vertices) {
            if let Ok(mut spare) = self.mockup.for_moved().spare.try_lock() {
                *spare = Some((vertices, changed));
            }
        }
    }
}

/// The mock-up with parts at poses, each counted from where they are modelled: by part the pose's number, `NONE` where it stays.
pub fn moved(rest: &Arc<Mockup>, pose_of_part: &[Option<u32>], poses: &[Pose]) -> Result<Mockup> {
    let kept = rest.for_moved();
    let places = kept.places.get_or_init(|| Box::new(PartPlaces::new(rest)));
    let is_moved: Vec<bool> = pose_of_part.iter().map(Option::is_some).collect();
    let pose_of = |part: u32| pose_of_part.get(part as usize).copied().flatten().map(|pose| &poses[pose as usize]);
    let own: Vec<u32> = places.triangles(|part| pose_of(part).is_some()).collect();
    let moving = || (0..is_moved.len()).filter(|part| is_moved[*part]);
    let (mesh, changed) = if moving().all(|part| places.is_alone[part]) {
        let ranges: Vec<[u32; 2]> = moving().map(|part| places.vertices[part]).filter(|[a, b]| a < b).collect();
        let mut vertices = spare(rest);
        for part in moving() {
            let [from, to] = places.vertices[part].map(|v| v as usize);
            let Some(pose) = pose_of(part as u32) else { continue };
            if from < to {
                vertices[from..to].iter_mut().for_each(|p| *p = pose.apply(p));
            }
        }
        (rest.mesh().with_vertices(vertices), Some(ranges))
    } else {
        (apart(rest, &own, &pose_of)?, None)
    };
    let was_queried = |face: &u32| rest.mesh().is_queried(*face);
    let asked: Vec<u32> = own.into_iter().filter(was_queried).collect();
    let (mesh, triangles) = mesh.without_defects_of(&asked)?;
    let mut bounds = rest.part_bounds().to_vec();
    moving().for_each(|part| bounds[part] = Aabb::EMPTY);
    for &face in &triangles {
        let b = &mut bounds[rest.part_of_face(face) as usize];
        mesh.triangle(face).iter().for_each(|corner| b.grow(corner));
    }
    let all = bounds.iter().fold(Aabb::EMPTY, |all, b| all.union(b));
    let link = Rest { mockup: Arc::clone(rest), changed, is_moved, asked, triangles };
    Ok(rest.with_moved(mesh.with_bounds(all), bounds, link))
}

/// The vertices where they are modelled, in memory of their own.
fn spare(rest: &Mockup) -> Vec<Point> {
    let own = rest.mesh().vertices();
    let left = rest.for_moved().spare.try_lock().ok().and_then(|mut spare| spare.take());
    match left {
        Some((mut vertices, changed)) => {
            for [from, to] in changed.into_iter().map(|ends| ends.map(|v| v as usize)) {
                vertices[from..to].copy_from_slice(&own[from..to]);
            }
            vertices
        }
        None => own.to_vec(),
    }
}

/// Vertices that moved parts may share with others get copies behind the rest, one for each pose.
fn apart<'a>(rest: &Mockup, own: &[u32], pose_of: &impl Fn(u32) -> Option<&'a Pose>) -> Result<Mesh> {
    let (old, mut faces) = (rest.mesh().vertices(), rest.mesh().faces().to_vec());
    let mut vertices = old.to_vec();
    let key = |pose: &Pose| std::ptr::from_ref(pose) as usize;
    let mut copies = std::collections::HashMap::new();
    for &face in own {
        let Some(pose) = pose_of(rest.part_of_face(face)) else { continue };
        for corner in &mut faces[face as usize] {
            let Some(p) = old.get(*corner as usize) else { continue };
            *corner = *copies.entry((*corner, key(pose))).or_insert_with(|| {
                vertices.push(pose.apply(p));
                vertices.len() as u32 - 1
            });
        }
    }
    if vertices.len() as u64 > u64::from(u32::MAX) {
        let (what, limit) = ("vertices", u64::from(u32::MAX));
        return Err(Error::TooMany { what, count: vertices.len() as u64, limit });
    }
    Ok(rest.mesh().with_arrays(vertices, faces))
}
