//! Whether colliding triangles only touch, or whether a body enters another: by kinds, and by sides if the kind does
//! not decide.
//!
//! Crossing pairs enter. Coplanar ones do if they overlap in more than a line and both bodies lie on the same side. A
//! triangle that touches the inside of another, or one of its edges, enters if it continues behind it, into the
//! material. Sheets have no material: a surface that touches one from both sides goes through it. All signs are exact.
//! Pairs that share only corners of both count as touching.

use std::collections::BTreeMap;

use super::hits::Hit;
use crate::constants::NONE;
use crate::geometry::bounds::{Point, Triangle};
use crate::geometry::intersect_triangle_triangle::PairKind;
use crate::geometry::predicates::{Sign, Signs};
use crate::mesh::topology::adjacency::Adjacency;

/// A triangle of either surface, with its known surroundings.
struct Face<'a> {
    corners: Triangle,
    /// 1 or -1 where its surface bounds a solid: times the normal by the winding it is the outward one. 0 for a sheet.
    sense: i8,
    /// The triangle across each edge.
    beyond: &'a dyn Fn(usize) -> Option<Triangle>,
}

/// Where a triangle touches another in the other's plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    /// Within, at least at one point.
    Within,
    /// On this edge, not only at its ends.
    Edge(usize),
    /// At corners, if at all.
    Corner,
}

/// The two surfaces of a query at a pose.
pub(crate) struct Surfaces<'a> {
    /// A tool's triangle at the pose.
    pub tool: &'a dyn Fn(u32) -> Triangle,
    /// A mock-up's triangle.
    pub mockup: &'a dyn Fn(u32) -> Triangle,
    /// How each hangs together.
    pub adjacency: [&'a Adjacency; 2],
    /// Whether of each that is closed the material is taken to be outside.
    pub is_turned: [bool; 2],
}

impl Surfaces<'_> {
    /// A pair at which one body enters the other, of all that meet; `None` where they only touch.
    pub(crate) fn entering(&self, hits: impl Iterator<Item = Hit>) -> Option<[u32; 2]> {
        // Sheets, by side and number, and what touches them from which side.
        let mut sides: BTreeMap<(usize, u32, u32), Sign> = BTreeMap::new();
        for hit in hits {
            let [t, m] = hit.pair();
            let enters = match hit.kind() {
                PairKind::Crossing => true,
                PairKind::Coplanar => self.overlap_on_one_side(t, m),
                PairKind::Touching => self.enters(0, t, m, &mut sides) || self.enters(1, m, t, &mut sides),
            };
            if enters {
                return Some([t, m]);
            }
        }
        self.through_a_sheet(&sides)
    }

    fn triangle(&self, surface: usize, id: u32) -> Triangle {
        if surface == 0 {
            (self.tool)(id)
        } else {
            (self.mockup)(id)
        }
    }

    fn sense(&self, surface: usize, id: u32) -> i8 {
        let sense = self.adjacency[surface].outward[id as usize];
        if self.is_turned[surface] {
            -sense
        } else {
            sense
        }
    }

    fn overlap_on_one_side(&self, t: u32, m: u32) -> bool {
        let senses = [self.sense(0, t), self.sense(1, m)];
        if senses.contains(&0) {
            return false;
        }
        let (p, q) = ((self.tool)(t), (self.mockup)(m));
        let Some(flat) = Flat::of(&q) else { return false };
        let turns = [&p, &q].map(|t| flat.turn(&t[0], &t[1], &t[2]));
        let same_side = turns[0] * senses[0] == turns[1] * senses[1];
        same_side && !flat.is_beyond_an_edge(&p, &q) && !flat.is_beyond_an_edge(&q, &p)
    }

    /// Whether triangle `id` of a surface goes on behind the other surface's triangle that it touches. Notes the side of a sheet.
    fn enters(&self, surface: usize, id: u32, other: u32, sides: &mut BTreeMap<(usize, u32, u32), Sign>) -> bool {
        let (p, q) = (self.triangle(surface, id), self.triangle(1 - surface, other));
        let neighbours = self.adjacency[1 - surface].neighbours[other as usize];
        let beyond = |edge: usize| {
            let n = neighbours[edge];
            (n != NONE).then(|| self.triangle(1 - surface, n))
        };
        let face = Face { corners: q, sense: self.sense(1 - surface, other), beyond: &beyond };
        if face.sense != 0 {
            return face.is_entered_by(&p);
        }
        let heights = face.heights(&p);
        let side = heights.iter().copied().find(|s| *s != 0).unwrap_or(0);
        if side != 0 && !heights.contains(&-side) && face.place(&p, heights) == Place::Within {
            sides.insert((surface, other, id), side);
        }
        false
    }

    /// A sheet that two neighbours touch from its two sides.
    fn through_a_sheet(&self, sides: &BTreeMap<(usize, u32, u32), Sign>) -> Option<[u32; 2]> {
        for ((surface, sheet, id), side) in sides {
            let neighbours = self.adjacency[*surface].neighbours[*id as usize];
            if neighbours.iter().any(|n| sides.get(&(*surface, *sheet, *n)) == Some(&-side)) {
                return Some(if *surface == 0 { [*id, *sheet] } else { [*sheet, *id] });
            }
        }
        None
    }
}

impl Face<'_> {
    /// For each corner of a triangle -1 where it lies behind the plane, towards the material, 1 where before it, 0 where in it. Of a
    /// sheet, by its winding.
    fn heights(&self, p: &Triangle) -> [Sign; 3] {
        let [a, b, c] = &self.corners;
        let sense = if self.sense < 0 { -1 } else { 1 };
        p.map(|x| -sense * Signs::default().orient3d(a, b, c, &x))
    }

    /// Whether a triangle that touches this one goes on into the material.
    fn is_entered_by(&self, p: &Triangle) -> bool {
        let heights = self.heights(p);
        if !heights.contains(&-1) {
            return false;
        }
        match self.place(p, heights) {
            Place::Within => true,
            Place::Edge(edge) => self.is_entered_over(edge, p, heights),
            Place::Corner => false,
        }
    }

    /// The same where they touch on an edge. Beside a hollow edge what is behind either face is in the material, else what is behind
    /// both.
    fn is_entered_over(&self, edge: usize, p: &Triangle, heights: [Sign; 3]) -> bool {
        let Some(next) = (self.beyond)(edge) else { return false };
        // Its corner off the edge.
        let is_hollow = self.heights(&next).contains(&1);
        let [a, b, c] = &next;
        // The neighbour is wound alike: its surface is closed.
        let sense = if self.sense < 0 { -1 } else { 1 };
        let behind_next = |x: &Point| sense * Signs::default().orient3d(a, b, c, x) > 0;
        p.iter().zip(heights).any(|(x, height)| height < 0 && (is_hollow || behind_next(x)))
    }

    /// Where in this triangle's plane a triangle touches it.
    fn place(&self, p: &Triangle, heights: [Sign; 3]) -> Place {
        let q = &self.corners;
        let Some(flat) = Flat::of(q) else { return Place::Corner };
        let turn = flat.turn(&q[0], &q[1], &q[2]);
        // How a point of the plane lies to each edge: 1 on the inner side.
        let around = |x: &Point| [0, 1, 2].map(|k| turn * flat.turn(&q[k], &q[(k + 1) % 3], x));
        let mut place = Place::Corner;
        for i in 0..3 {
            let j = (i + 1) % 3;
            if heights[i] == 0 {
                place = place.or(Place::of_point(around(&p[i])));
            }
            if heights[i] == 0 && heights[j] == 0 {
                place = place.or(flat.place_of_segment(&p[i], &p[j], q, [around(&p[i]), around(&p[j])]));
            }
            if heights[i] * heights[j] < 0 {
                // Through the plane at a point between: the signs of volumes tell how that lies to each edge.
                let sides = [0, 1, 2].map(|k| Signs::default().orient3d(&p[i], &p[j], &q[k], &q[(k + 1) % 3]));
                let inner = sides.iter().copied().find(|s| *s != 0).unwrap_or(0);
                if !sides.contains(&-inner) {
                    place = place.or(Place::of_point(sides.map(|s| s * inner)));
                }
            }
        }
        place
    }
}

impl Place {
    /// Of a point, by how it lies to each edge.
    fn of_point(around: [Sign; 3]) -> Place {
        let on: Vec<usize> = (0..3).filter(|k| around[*k] == 0).collect();
        match on[..] {
            _ if around.contains(&-1) => Place::Corner,
            [] => Place::Within,
            [edge] => Place::Edge(edge),
            _ => Place::Corner,
        }
    }

    /// The one of two that tells more.
    fn or(self, other: Place) -> Place {
        match (self, other) {
            (Place::Within, _) | (_, Place::Within) => Place::Within,
            (Place::Edge(edge), _) | (_, Place::Edge(edge)) => Place::Edge(edge),
            _ => Place::Corner,
        }
    }
}

/// A plane without one of its axes: signs in it are those of the coordinates as they are.
struct Flat([usize; 2]);

impl Flat {
    /// One in which a triangle keeps an area.
    fn of(q: &Triangle) -> Option<Flat> {
        [[0, 1], [1, 2], [2, 0]].map(Flat).into_iter().find(|flat| flat.turn(&q[0], &q[1], &q[2]) != 0)
    }

    fn turn(&self, a: &Point, b: &Point, c: &Point) -> Sign {
        let [a, b, c] = [a, b, c].map(|p| [p[self.0[0]], p[self.0[1]]]);
        Signs::default().orient2d(a, b, c)
    }

    /// Whether all of `p` lies on an edge of `q` or beyond it, both in one plane.
    fn is_beyond_an_edge(&self, p: &Triangle, q: &Triangle) -> bool {
        let turn = self.turn(&q[0], &q[1], &q[2]);
        (0..3).any(|k| p.iter().all(|x| turn * self.turn(&q[k], &q[(k + 1) % 3], x) <= 0))
    }

    /// Where a segment in the plane of `q` lies in it; `around` are its ends' sides.
    fn place_of_segment(&self, a: &Point, b: &Point, q: &Triangle, around: [[Sign; 3]; 2]) -> Place {
        let beyond = (0..3).find(|k| around.iter().all(|sides| sides[*k] <= 0));
        if let Some(edge) = beyond {
            // Along the edge's line, over more than an end.
            let along = around.iter().all(|sides| sides[edge] == 0);
            let ends = [edge, (edge + 1) % 3].map(|k| q[k]);
            return if along && self.overlaps([a, b], [&ends[0], &ends[1]]) {
                Place::Edge(edge)
            } else {
                Place::Corner
            };
        }
        let sides = q.map(|x| self.turn(a, b, &x));
        let is_split = sides.contains(&1) && sides.contains(&-1);
        if is_split {
            Place::Within
        } else {
            Place::Corner
        }
    }

    /// Whether two segments on one line share more than a point.
    fn overlaps(&self, one: [&Point; 2], other: [&Point; 2]) -> bool {
        self.0.iter().any(|axis| {
            let [[a, b], [c, d]] = [one, other].map(|ends| {
                let [x, y] = ends.map(|p| p[*axis]);
                [x.min(y), x.max(y)]
            });
            a.max(c) < b.min(d)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::pose::Pose;
    use crate::mesh::mockup::Mockup;
    use crate::scene::{Scene, SceneOptions};
    use crate::tool::moving_tool::Tool;
    use feeler_shapes::{box_mesh, joined, sheet, Arrays};

    fn is_entering(mockup: Arrays, tool: Arrays) -> bool {
        let mockup = Mockup::new(mockup.0, mockup.1, Vec::new(), 1).unwrap();
        let scene = Scene::build(mockup.into(), &SceneOptions::default()).unwrap();
        let tool = Tool::new(tool.0, tool.1).unwrap();
        assert!(scene.is_colliding(&tool, &Pose::IDENTITY));
        scene.is_entering(&tool, &Pose::IDENTITY)
    }

    fn inverted((vertices, faces): Arrays) -> Arrays {
        (vertices, faces.into_iter().map(|[a, b, c]| [a, c, b]).collect())
    }

    fn block(lower: Point, upper: Point, cells: usize) -> Arrays {
        let middle = std::array::from_fn(|a| 0.5 * (lower[a] + upper[a]));
        box_mesh(middle, std::array::from_fn(|a| upper[a] - lower[a]), cells)
    }

    /// A block [0, 4]^3 against blocks, whether they enter it, with each cut so finely.
    #[test]
    fn blocks_on_a_lattice_touch_or_enter() {
        for (lower, upper, enters) in [
            // Face on face: as large, smaller, larger, over an edge, over a corner.
            ([4.0, 0.0, 0.0], [8.0, 4.0, 4.0], false),
            ([4.0, 1.0, 1.0], [6.0, 2.0, 2.0], false),
            ([-1.0, -2.0, -4.0], [9.0, 5.0, 0.0], false),
            ([4.0, 2.0, 2.0], [6.0, 6.0, 6.0], false),
            ([2.0, 2.0, 4.0], [6.0, 6.0, 8.0], false),
            // Edge on face's edge, corner on corner, edge along edge with one shared.
            ([4.0, 4.0, 1.0], [5.0, 5.0, 2.0], false),
            ([4.0, 4.0, 4.0], [5.0, 5.0, 5.0], false),
            // The same block, a larger and a smaller one with shared faces.
            ([0.0, 0.0, 0.0], [4.0, 4.0, 4.0], true),
            ([0.0, 0.0, 0.0], [4.0, 4.0, 2.0], true),
            ([0.0, 0.0, 0.0], [8.0, 4.0, 4.0], true),
            ([1.0, 1.0, 2.0], [3.0, 3.0, 4.0], true),
            // Through a face, a corner region, and shifted by lattice steps: edges run along edges of the mesh.
            ([1.0, 1.0, 2.0], [2.0, 2.0, 6.0], true),
            ([1.0, 1.0, 1.0], [5.0, 5.0, 5.0], true),
            ([2.0, 0.0, 0.0], [6.0, 4.0, 4.0], true),
            ([2.0, 2.0, 0.0], [6.0, 6.0, 4.0], true),
            ([-2.0, 1.0, 1.0], [6.0, 3.0, 3.0], true),
            ([1.5, -1.0, 1.5], [2.5, 5.0, 2.5], true),
        ] {
            for cells in [1, 2, 4] {
                for other in [1, 2, 4] {
                    let (mockup, tool) = (block([0.0; 3], [4.0; 3], cells), block(lower, upper, other));
                    let what = format!("{lower:?} {upper:?} {cells} {other}");
                    assert_eq!(is_entering(mockup.clone(), tool.clone()), enters, "{what}");
                    assert_eq!(is_entering(tool.clone(), mockup.clone()), enters, "{what}, swapped");
                    // Inside out is the same solid.
                    assert_eq!(is_entering(inverted(mockup), tool.clone()), enters, "{what}, inverted");
                    assert_eq!(
                        is_entering(block([0.0; 3], [4.0; 3], cells), inverted(tool)),
                        enters,
                        "{what}, inverted"
                    );
                }
            }
        }
    }

    #[test]
    fn a_seated_block_touches_and_a_wedged_one_enters() {
        // A hole [1, 3]^2 through a plate of thickness 2, of four walls.
        let walls = joined([
            block([0.0, 0.0, 0.0], [1.0, 4.0, 2.0], 2),
            block([3.0, 0.0, 0.0], [4.0, 4.0, 2.0], 1),
            block([1.0, 0.0, 0.0], [3.0, 1.0, 2.0], 3),
            block([1.0, 3.0, 0.0], [3.0, 4.0, 2.0], 1),
        ]);
        for cells in 1..4 {
            for z in [-1.0, 0.0, 0.5, 1.0, 2.0] {
                let pin = block([1.0, 1.0, z], [3.0, 3.0, z + 1.5], cells);
                assert!(!is_entering(walls.clone(), pin), "{cells} {z}");
            }
            let thick = block([1.0, 1.0, 0.5], [3.0 + 1e-12, 3.0, 3.0], cells);
            assert!(is_entering(walls.clone(), thick), "{cells}");
        }
    }

    #[test]
    fn sheets_are_touched_from_one_side_and_passed_from_two() {
        // Cut at the sheet's height: no triangle crosses it.
        let square = sheet(3, 3, |s, t| [4.0 * s - 2.0, 4.0 * t - 2.0, 0.0]);
        let standing = block([-0.5, -0.5, 0.0], [0.5, 0.5, 1.0], 2);
        let through = block([-0.5, -0.5, -0.5], [0.5, 0.5, 0.5], 2);
        assert!(!is_entering(square.clone(), standing.clone()));
        assert!(!is_entering(standing, square.clone()));
        assert!(is_entering(square.clone(), through.clone()));
        assert!(is_entering(through, square));
    }
}
