//! Erosion: a part of the tool made smaller by its depth in a neighbour, so that the pair can be cast exactly.
//!
//! Each corner moves inwards so that all faces at it move by the same distance: the depth at the start plus a play. The eroded part is
//! free of the neighbour at the start. While it stays free, the part itself gets no deeper than at the start by more than the play.

use std::collections::BTreeMap;
use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::geometry::vectors::{add, cross, dot, length, scaled, sub, unit};
use feeler_core::{weld_vertices, Point, Pose, Tool};

use crate::constants::{
    EROSION_SHARE, FACE_ANGLE_COS, FIT_DEPTH, FLUSH_PLAY, LONGEST_MITRE, MITRE_ADDED, SEAT_TOLERANCE,
};
use crate::error::Result;

/// An eroded part of a tool.
#[derive(Debug, Clone)]
pub struct Eroded {
    /// The eroded part alone, with the tool's pivot.
    pub tool: Arc<Tool>,
    /// How deep the part is at the start, metres; 0 if it touches.
    pub depth: f64,
}

/// Makes eroded parts of a tool, each only once.
pub struct Erosion<'a> {
    tool: &'a Tool,
    corners: BTreeMap<u32, Corners>,
    made: BTreeMap<(u32, u64), Arc<Tool>>,
}

impl<'a> Erosion<'a> {
    pub fn new(tool: &'a Tool) -> Erosion<'a> {
        Erosion { tool, corners: BTreeMap::new(), made: BTreeMap::new() }
    }

    /// The part eroded just enough to be free at `start`, by at least `least` metres. `solver`: of the neighbour alone. `size`: the tool's
    /// diagonal, metres. `None`: the part is deeper than a fit.
    pub fn free_part(
        &mut self,
        solver: &ContactSolver,
        part: u32,
        start: &Pose,
        least: f64,
        size: f64,
    ) -> Result<Option<Eroded>> {
        let most = least.max(FIT_DEPTH * size);
        // Of an open surface nobody knows which side is out.
        let signs = if self.tool.adjacency().is_open(part) { &[1.0, -1.0][..] } else { &[1.0] };
        for sign in signs {
            let mut is_free = |by: f64| -> Result<bool> { Ok(solver.is_free(&*self.by(part, sign * by)?, start)) };
            if least == 0.0 && is_free(0.5 * FLUSH_PLAY)? {
                return Ok(Some(Eroded { tool: self.by(part, sign * FLUSH_PLAY)?, depth: 0.0 }));
            }
            if !is_free(most)? {
                continue;
            }
            let (mut low, mut high) = (least.max(0.5 * FLUSH_PLAY), most);
            if least > 0.0 && is_free(least)? {
                high = least;
            }
            while high > EROSION_SHARE * low {
                let middle = (low * high).sqrt();
                if is_free(middle)? {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            return Ok(Some(Eroded { tool: self.by(part, sign * (high + SEAT_TOLERANCE))?, depth: high }));
        }
        Ok(None)
    }

    /// The part eroded by a distance, metres.
    fn by(&mut self, part: u32, by: f64) -> Result<Arc<Tool>> {
        if let Some(made) = self.made.get(&(part, by.to_bits())) {
            return Ok(made.clone());
        }
        let corners = self.corners.entry(part).or_insert_with(|| Corners::new(self.tool, part));
        let made = Arc::new(corners.moved(self.tool, -by)?);
        self.made.insert((part, by.to_bits()), made.clone());
        Ok(made)
    }
}

/// The corners of a part, and where each moves.
struct Corners {
    /// By vertex of the part.
    places: Vec<Point>,
    faces: Vec<[u32; 3]>,
    /// Outwards, for a distance of 1 of all faces.
    outward: Vec<Point>,
}

impl Corners {
    fn new(tool: &Tool, part: u32) -> Corners {
        let (mesh, outward) = (tool.mesh(), &tool.adjacency().outward);
        let own: Vec<u32> = mesh.queried().filter(|t| tool.part_of_face(*t) == part).collect();
        let all: Vec<Point> = own.iter().flat_map(|t| mesh.triangle(*t)).collect();
        let (places, numbers) = weld_vertices(&all);
        let faces: Vec<[u32; 3]> = numbers.chunks(3).map(|corner| [corner[0], corner[1], corner[2]]).collect();
        // The normals that meet at each corner, those alike once.
        let mut normals: Vec<Vec<Point>> = vec![Vec::new(); places.len()];
        for (t, face) in own.iter().zip(&faces) {
            let [a, b, c] = face.map(|v| places[v as usize]);
            let Some(normal) = unit(&cross(&sub(&b, &a), &sub(&c, &a))) else { continue };
            let normal = if outward[*t as usize] < 0 { scaled(&normal, -1.0) } else { normal };
            for v in face {
                let known = &mut normals[*v as usize];
                if known.iter().all(|other| dot(other, &normal) < FACE_ANGLE_COS) {
                    known.push(normal);
                }
            }
        }
        Corners { places, faces, outward: normals.iter().map(|normals| mitre(normals)).collect() }
    }

    /// The part with all faces moved outwards by so much, metres.
    fn moved(&self, tool: &Tool, by: f64) -> Result<Tool> {
        let vertices = self.places.iter().zip(&self.outward).map(|(p, out)| add(p, &scaled(out, by))).collect();
        Ok(Tool::new(vertices, self.faces.clone())?.with_pivot(*tool.pivot()))
    }
}

/// The shortest vector whose component along each normal is 1, or as nearly as can be; no longer than the longest mitre.
fn mitre(normals: &[Point]) -> Point {
    // Least squares: the sum of n nᵀ times the vector is the sum of n. What is added keeps flat corners from being singular.
    let sum = normals.iter().fold([0.0; 3], |sum, n| add(&sum, n));
    let rows: [Point; 3] = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            normals.iter().map(|n| n[i] * n[j]).sum::<f64>() + if i == j { MITRE_ADDED } else { 0.0 }
        })
    });
    let determinant = dot(&rows[0], &cross(&rows[1], &rows[2]));
    let with = |at: usize| {
        let column = |k: usize| rows.map(|row| row[k]);
        let columns: [Point; 3] = std::array::from_fn(|k| if k == at { sum } else { column(k) });
        dot(&columns[0], &cross(&columns[1], &columns[2])) / determinant
    };
    let out: Point = std::array::from_fn(with);
    if !out.iter().all(|x| x.is_finite()) {
        return [0.0; 3];
    }
    scaled(&out, (LONGEST_MITRE / length(&out).max(f64::MIN_POSITIVE)).min(1.0))
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
            let smaller = Corners::new(&tool, 0).moved(&tool, -0.001).unwrap();
            let off = sub(&sub(&extent(&tool), &extent(&smaller)), &[0.002; 3]);
            assert!(length(&off) < 1e-11, "{off:?}");
            assert_eq!(smaller.pivot(), tool.pivot());
        }
    }

    #[test]
    fn all_facets_of_a_cylinder_move_by_the_same() {
        let (vertices, faces) = cylinder(0.01, 0.05, 24, 3);
        let tool = Tool::new(vertices, faces).unwrap();
        let smaller = Corners::new(&tool, 0).moved(&tool, -0.0005).unwrap();
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
}
