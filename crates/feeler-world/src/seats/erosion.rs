//! Erosion: a part of the tool made smaller by its depth in a neighbour, so that the pair can be cast exactly.
//!
//! Each surface moves inwards by its own depth at the start plus a play, and each corner moves with the faces at it. So
//! a flush collar stays flush while the shaft beside it crosses its bore by facets. The eroded part is free of the
//! neighbour at the start. While it stays free, no surface gets deeper than at the start by more than its play.

use std::collections::BTreeMap;
use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::geometry::vectors::{cross, dot, length, scaled, sub, unit};
use feeler_core::{weld_vertices, Aabb, Point, Pose, Tool};

use super::fans::{fans, Fans};
use super::inwards::inwards;
use crate::constants::{
    EROSION_SHARE, EROSION_STEP, FACE_ANGLE_COS, FIT_DEPTH, FLUSH_PLAY, LONGEST_MITRE, MOST_EROSIONS, SEAT_TOLERANCE,
};
use crate::error::Result;
use crate::surfaces::Surfaces;

/// An eroded part of a tool.
#[derive(Debug, Clone)]
pub struct Eroded {
    /// The eroded part alone, with the tool's pivot.
    pub tool: Arc<Tool>,
    /// How deep the part is at the start, metres; 0 if it touches.
    pub depth: f64,
}

/// Makes eroded parts of a tool.
pub struct Erosion<'a> {
    tool: &'a Tool,
    corners: BTreeMap<u32, Arc<Corners>>,
    /// Of parts all of whose surfaces move by the same: these several neighbours ask for.
    made: BTreeMap<(u32, u64), Arc<Tool>>,
}

impl<'a> Erosion<'a> {
    pub fn new(tool: &'a Tool) -> Erosion<'a> {
        Erosion { tool, corners: BTreeMap::new(), made: BTreeMap::new() }
    }

    /// The part eroded just enough to be free at `start`, by at least `least` metres. `solver`: of the neighbour alone, and its number.
    /// `size`: the tool's diagonal, metres. `None`: the part is deeper than a fit.
    pub fn free_part(
        &mut self,
        (solver, neighbour): (&ContactSolver, u32),
        part: u32,
        start: &Pose,
        least: f64,
        size: f64,
    ) -> Result<Option<Eroded>> {
        let most = least.max(FIT_DEPTH * size);
        let first = least.max(0.5 * FLUSH_PLAY);
        let corners = self.corners_of(part).clone();
        let (surfaces, scene) = (corners.surfaces, solver.scene());
        // Triangles farther from the neighbour's box than corners move do not meet it: tries take near ones alone. Containment is
        // tested with the whole.
        let own = &scene.mockup().part_bounds()[neighbour as usize];
        let mut nearby: BTreeMap<u64, Vec<[u32; 3]>> = BTreeMap::new();
        let mut near = |by: &[f64]| {
            let most = by.iter().fold(first, |most, by| most.max(by.abs()));
            let far =
                LONGEST_MITRE * EROSION_STEP.powf((most / first).log(EROSION_STEP).ceil()) * first + SEAT_TOLERANCE;
            let reach = Aabb { lower: own.lower.map(|x| x - far), upper: own.upper.map(|x| x + far) };
            nearby.entry(far.to_bits()).or_insert_with(|| corners.near(start, &reach)).clone()
        };
        // Of an open surface nobody knows which side is out.
        let signs = if self.tool.adjacency().is_open(part) { &[1.0, -1.0][..] } else { &[1.0] };
        for sign in signs {
            let inwards = |by: &[f64]| by.iter().map(|by| sign * by).collect::<Vec<f64>>();
            let mut is_clear = |by: &[f64]| -> Result<bool> {
                let near = near(by);
                if near.is_empty() {
                    return Ok(true);
                }
                let tool = corners.moved(self.tool, &near, &inwards(by))?;
                Ok(!scene.is_colliding(&tool, start))
            };
            let alike = vec![first; surfaces];
            if is_clear(&alike)? && solver.is_free(&*self.by(part, &inwards(&alike))?, start) {
                let play = if least == 0.0 { FLUSH_PLAY } else { least + SEAT_TOLERANCE };
                return Ok(Some(Eroded { tool: self.by(part, &vec![sign * play; surfaces])?, depth: least }));
            }
            let Some((low, high)) = depths(surfaces, first, most, &mut is_clear)? else { continue };
            // No deeper than it was by more than the play, where the depth is known so well.
            let play = |(low, high): (&f64, &f64)| match *low < *high {
                true => (high + FLUSH_PLAY).max(low + SEAT_TOLERANCE),
                false if least == 0.0 => FLUSH_PLAY,
                false => high + SEAT_TOLERANCE,
            };
            let by: Vec<f64> = low.iter().zip(&high).map(play).collect();
            let depth = high.iter().copied().fold(0.0, f64::max);
            // Triangles of a flat face whose corners are almost in a line can fold over by the way: then all surfaces move alike, or less.
            let most = by.iter().copied().fold(0.0, f64::max);
            for by in [by, vec![most; surfaces], vec![depth + FLUSH_PLAY; surfaces], vec![depth; surfaces], high] {
                if is_clear(&by)? {
                    let tool = self.by(part, &inwards(&by))?;
                    if solver.is_free(&tool, start) {
                        return Ok(Some(Eroded { tool, depth }));
                    }
                }
            }
        }
        Ok(None)
    }

    /// The part smaller by [`FLUSH_PLAY`] on all sides, whatever it meets.
    pub fn part_with_play(&mut self, part: u32) -> Result<Arc<Tool>> {
        let surfaces = self.corners_of(part).surfaces;
        self.by(part, &vec![FLUSH_PLAY; surfaces])
    }

    fn corners_of(&mut self, part: u32) -> &Arc<Corners> {
        self.corners.entry(part).or_insert_with(|| Arc::new(Corners::new(self.tool, part)))
    }

    /// The part with each surface eroded by a distance, metres.
    fn by(&mut self, part: u32, by: &[f64]) -> Result<Arc<Tool>> {
        let same = by.first().filter(|first| by.iter().all(|other| other == *first));
        let key = same.map(|by| (part, by.to_bits()));
        if let Some(made) = key.and_then(|key| self.made.get(&key)) {
            return Ok(made.clone());
        }
        let tool = self.tool;
        let corners = self.corners_of(part);
        let made = Arc::new(corners.moved(tool, &corners.faces, by)?);
        if let Some(key) = key {
            self.made.insert(key, made.clone());
        }
        Ok(made)
    }
}

/// Between which depths each surface is: not free at the lower, free at the higher, both `first` of those that are only flush. `None`: up
/// to `most` they are not free.
fn depths(
    surfaces: usize,
    first: f64,
    most: f64,
    is_free: &mut impl FnMut(&[f64]) -> Result<bool>,
) -> Result<Option<(Vec<f64>, Vec<f64>)>> {
    // From below: a sheet that is made smaller by more than half its thickness is none.
    let (mut low, mut high) = (first, first);
    while high == low {
        high = (EROSION_STEP * low).min(most);
        if is_free(&vec![high; surfaces])? {
            // Where the first is the most already, its surface is free, and it is inside all the same.
            if high == low {
                break;
            }
        } else if high >= most {
            return Ok(None);
        } else {
            low = high;
        }
    }
    while high > EROSION_SHARE * low {
        let middle = (low * high).sqrt();
        let side = if is_free(&vec![middle; surfaces])? { &mut high } else { &mut low };
        *side = middle;
    }
    let (mut low, mut high) = (vec![low; surfaces], vec![high; surfaces]);
    // Which are flush, in groups: where one is not, its halves may be.
    let mut groups: Vec<Vec<usize>> = vec![(0..surfaces).collect()];
    let (mut deep, mut tries) = (Vec::new(), MOST_EROSIONS);
    while let Some(group) = groups.pop().filter(|_| tries > 0) {
        tries -= 1;
        let mut by = high.clone();
        group.iter().for_each(|s| by[*s] = first);
        if is_free(&by)? {
            group.iter().for_each(|s| low[*s] = first);
            high = by;
        } else if let [one] = group[..] {
            deep.push(one);
        } else {
            let (some, others) = group.split_at(group.len() / 2);
            groups.extend([some.to_vec(), others.to_vec()]);
        }
    }
    // The deepest has its depth; of others it may be less.
    for s in deep.iter().filter(|_| deep.len() > 1) {
        let mut least = first;
        while high[*s] > EROSION_SHARE * least && tries > 0 {
            tries -= 1;
            let mut by = high.clone();
            by[*s] = (least * high[*s]).sqrt();
            if is_free(&by)? {
                high = by;
            } else {
                least = by[*s];
            }
        }
        low[*s] = least.min(high[*s]);
    }
    Ok(Some((low, high)))
}

/// The corners of a part, and the faces that meet at each.
struct Corners {
    /// By corner: those of a vertex that needs several are split.
    places: Vec<Point>,
    faces: Vec<[u32; 3]>,
    surfaces: usize,
    /// By corner: normals outwards, those alike once, with their surfaces.
    normals: Vec<Vec<(Point, Vec<u32>)>>,
}

impl Corners {
    fn new(tool: &Tool, part: u32) -> Corners {
        let (mesh, adjacency) = (tool.mesh(), tool.adjacency());
        let own: Vec<u32> = mesh.queried().filter(|t| tool.part_of_face(*t) == part).collect();
        let numbers = Surfaces::new(mesh, adjacency, &own, |_| part).numbers;
        let surface: Vec<u32> = own.iter().map(|t| numbers.of(*t).unwrap_or_default()).collect();
        let all: Vec<Point> = own.iter().flat_map(|t| mesh.triangle(*t)).collect();
        let (places, corners) = weld_vertices(&all);
        let faces: Vec<[u32; 3]> = corners.chunks(3).map(|corner| [corner[0], corner[1], corner[2]]).collect();
        let outward = |(t, face): (&u32, &[u32; 3])| {
            let [a, b, c] = face.map(|v| places[v as usize]);
            let normal = unit(&cross(&sub(&b, &a), &sub(&c, &a)))?;
            Some(if adjacency.outward[*t as usize] < 0 { scaled(&normal, -1.0) } else { normal })
        };
        let of_faces: Vec<Option<Point>> = own.iter().zip(&faces).map(outward).collect();
        let Fans { faces, vertices } = fans(&places, &faces, &of_faces);
        let places: Vec<Point> = vertices.iter().map(|v| places[*v as usize]).collect();
        let mut normals: Vec<Vec<(Point, Vec<u32>)>> = vec![Vec::new(); places.len()];
        for ((normal, face), surface) in of_faces.iter().zip(&faces).zip(&surface) {
            let Some(normal) = normal else { continue };
            for v in face {
                let known = &mut normals[*v as usize];
                match known.iter_mut().find(|(other, _)| dot(other, normal) >= FACE_ANGLE_COS) {
                    Some((_, of)) => of.push(*surface),
                    None => known.push((*normal, vec![*surface])),
                }
            }
        }
        let surfaces = surface.iter().max().map_or(0, |last| *last as usize + 1);
        Corners { places, faces, surfaces, normals }
    }

    /// The faces in a box (world) at a pose, and those beside them.
    fn near(&self, pose: &Pose, bounds: &Aabb) -> Vec<[u32; 3]> {
        let places: Vec<Point> = self.places.iter().map(|p| pose.apply(p)).collect();
        let is_in = |face: &&[u32; 3]| Aabb::of_triangle(&face.map(|v| places[v as usize])).is_overlapping(bounds);
        let mut has = vec![false; places.len()];
        self.faces.iter().filter(is_in).flatten().for_each(|v| has[*v as usize] = true);
        self.faces.iter().filter(|face| face.iter().any(|v| has[*v as usize])).copied().collect()
    }

    /// Some faces of the part with each surface moved inwards by so much, metres.
    fn moved(&self, tool: &Tool, faces: &[[u32; 3]], by: &[f64]) -> Result<Tool> {
        let farther = |of: &[u32]| {
            of.iter().map(|s| by[*s as usize]).fold(0.0, |most: f64, by| if by.abs() > most.abs() { by } else { most })
        };
        let mut number = vec![u32::MAX; self.places.len()];
        let (mut moved, mut vertices) = (self.places.clone(), Vec::new());
        for v in faces.as_flattened() {
            let at = *v as usize;
            if number[at] == u32::MAX {
                number[at] = vertices.len() as u32;
                let ways: Vec<(Point, f64)> = self.normals[at].iter().map(|(n, of)| (*n, farther(of))).collect();
                moved[at] = sub(&self.places[at], &mitre(&ways));
                vertices.push(moved[at]);
            }
        }
        let faces = self.unfolded(faces, &moved).into_iter().map(|face| face.map(|v| number[v as usize])).collect();
        Ok(Tool::new(vertices, faces)?.with_pivot(*tool.pivot()))
    }

    /// Faces for moved corners. A triangle whose corners are almost in a line folds over where the middle one moves past the line: it
    /// and the one beside its longest edge get the other diagonal.
    fn unfolded(&self, faces: &[[u32; 3]], moved: &[Point]) -> Vec<[u32; 3]> {
        let mut faces = faces.to_vec();
        let normal = |face: &[u32; 3], places: &[Point]| {
            let [a, b, c] = face.map(|v| places[v as usize]);
            cross(&sub(&b, &a), &sub(&c, &a))
        };
        // Those between corners of one vertex have no side.
        let is_narrow = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|v| self.places[v as usize]);
            a == b || b == c || c == a
        };
        for at in 0..faces.len() {
            let face = faces[at];
            if is_narrow(&face) {
                continue;
            }
            if dot(&normal(&face, moved), &normal(&face, &self.places)) > 0.0 {
                continue;
            }
            let long =
                |k: usize| length(&sub(&self.places[face[k] as usize], &self.places[face[(k + 1) % 3] as usize]));
            let Some(k) = (0..3).max_by(|i, j| long(*i).total_cmp(&long(*j))) else { continue };
            let [a, c, middle] = [face[k], face[(k + 1) % 3], face[(k + 2) % 3]];
            let has = |other: &[u32; 3]| (0..3).any(|i| [other[i], other[(i + 1) % 3]] == [c, a]);
            let is_beside = |other: &[u32; 3]| has(other) && !is_narrow(other);
            let Some(beside) = faces.iter().position(is_beside) else { continue };
            let Some(far) = faces[beside].into_iter().find(|v| *v != a && *v != c) else { continue };
            (faces[at], faces[beside]) = ([a, far, middle], [far, c, middle]);
        }
        faces
    }
}

/// The way of a corner whose faces move inwards, no longer than the longest mitre of the farthest.
fn mitre(faces: &[(Point, f64)]) -> Point {
    let most = faces.iter().map(|(_, by)| by.abs()).fold(0.0, f64::max);
    let moved = inwards(faces);
    scaled(&moved, (LONGEST_MITRE * most / length(&moved).max(f64::MIN_POSITIVE)).min(1.0))
}

#[cfg(test)]
mod tests {
    use feeler_shapes::{box_mesh, cylinder};

    use super::*;

    fn extent(tool: &Tool) -> Point {
        tool.mesh().bounds().extent()
    }

    #[test]
    fn a_box_shrinks_by_the_same_on_all_sides() {
        for cells in [1, 4] {
            let (vertices, faces) = box_mesh([0.3, 0.0, -0.1], [0.03, 0.04, 0.05], cells);
            let tool = Tool::new(vertices, faces).unwrap();
            let corners = Corners::new(&tool, 0);
            let smaller = corners.moved(&tool, &corners.faces, &vec![0.001; corners.surfaces]).unwrap();
            let off = sub(&sub(&extent(&tool), &extent(&smaller)), &[0.002; 3]);
            assert!(length(&off) < 1e-11, "{off:?}");
            assert_eq!(smaller.pivot(), tool.pivot());
        }
    }

    #[test]
    fn all_facets_of_a_cylinder_move_by_the_same() {
        let (vertices, faces) = cylinder(0.01, 0.05, 24, 3);
        let tool = Tool::new(vertices, faces).unwrap();
        let corners = Corners::new(&tool, 0);
        let smaller = corners.moved(&tool, &corners.faces, &vec![0.0005; corners.surfaces]).unwrap();
        for t in smaller.mesh().queried() {
            let [a, b, c] = smaller.mesh().triangle(t);
            let normal = unit(&cross(&sub(&b, &a), &sub(&c, &a))).unwrap();
            let was = tool.mesh().queried().map(|t| tool.mesh().triangle(t)).any(|[p, q, r]| {
                let other = unit(&cross(&sub(&q, &p), &sub(&r, &p))).unwrap();
                dot(&normal, &other) > 1.0 - 1e-9 && (dot(&sub(&p, &a), &normal) - 0.0005).abs() < 1e-8
            });
            assert!(was, "{t}");
        }
    }

    #[test]
    fn each_surface_moves_by_its_own() {
        let (vertices, faces) = box_mesh([0.0, 0.0, 0.0], [0.03, 0.04, 0.05], 2);
        let tool = Tool::new(vertices, faces).unwrap();
        let corners = Corners::new(&tool, 0);
        assert_eq!(corners.surfaces, 6);
        let by: Vec<f64> = (1..=6).map(|n| 1e-4 * f64::from(n)).collect();
        let smaller = corners.moved(&tool, &corners.faces, &by).unwrap();
        let off = sub(&extent(&tool), &extent(&smaller));
        assert!((off.iter().sum::<f64>() - 21e-4).abs() < 1e-10, "{off:?}");
    }

    #[test]
    fn a_flat_triangle_does_not_fold_over() {
        // A section of an L whose diagonal passes its inner corner by a little.
        let outline = [[0.0, 0.0], [0.02, 0.0], [0.02, 0.01], [0.01001, 0.01001], [0.01, 0.02], [0.0, 0.02]];
        let mut vertices: Vec<Point> = outline.iter().map(|[x, y]| [*x, *y, 0.0]).collect();
        vertices.extend(outline.iter().map(|[x, y]| [*x, *y, 0.03]));
        let cap = [[0u32, 1, 5], [1, 3, 5], [1, 2, 3], [3, 4, 5]];
        let mut faces: Vec<[u32; 3]> = cap.iter().map(|[a, b, c]| [*c, *b, *a]).collect();
        faces.extend(cap.iter().map(|face| face.map(|v| v + 6)));
        for i in 0..6u32 {
            let j = (i + 1) % 6;
            faces.extend([[i, j, j + 6], [i, j + 6, i + 6]]);
        }
        let tool = Tool::new(vertices, faces).unwrap();
        let corners = Corners::new(&tool, 0);
        let by: Vec<f64> = (0..corners.surfaces).map(|s| if s == 0 { 1e-6 } else { 1e-4 + 1e-5 * s as f64 }).collect();
        let smaller = corners.moved(&tool, &corners.faces, &by).unwrap();
        for t in smaller.mesh().queried() {
            let [a, b, c] = smaller.mesh().triangle(t);
            let normal = unit(&cross(&sub(&b, &a), &sub(&c, &a))).unwrap();
            let middle: Point = std::array::from_fn(|k| (a[k] + b[k] + c[k]) / 3.0);
            // Caps look out, whatever their corners did.
            if normal[2].abs() > 0.5 {
                assert_eq!(normal[2] > 0.0, middle[2] > 0.015);
            }
        }
    }

    #[test]
    fn a_corner_within_a_flat_face_moves_across_it_alone() {
        for normal in [[0.36, 0.48, 0.8], [-0.6, 0.64, 0.48], [0.123, -0.456, 0.881_438]] {
            let normal = unit(&normal).unwrap();
            let moved = mitre(&[(normal, 1e-3)]);
            assert!(length(&sub(&moved, &scaled(&normal, 1e-3))) < 1e-9, "{moved:?}");
        }
    }
}
