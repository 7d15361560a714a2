//! The corners of a part, split where one corner cannot move inwards with all faces at it.
//!
//! Where two blocks of a part meet at an edge or a corner alone, or where a saddle has faces that look opposite ways, the faces at a
//! vertex need several corners, each of which moves with its own. Between those of one sheet narrow faces keep the surface closed.

use std::collections::BTreeMap;

use feeler_core::geometry::vectors::{cross, dot, length, scaled, sub, unit};
use feeler_core::{wedges, Point};

use super::inwards::inwards;
use crate::constants::{FACE_ANGLE_COS, LEAST_INWARDS, MOST_ARCS, SAME_FACE_ANGLE};

/// Faces by their corners.
#[derive(Debug)]
pub struct Fans {
    /// Those of the part, and behind them the narrow ones, without area, between corners of one vertex.
    pub faces: Vec<[u32; 3]>,
    /// By corner: its vertex.
    pub vertices: Vec<u32>,
}

/// Splits the corners of faces. `normals`: outwards, unit, `None` of faces without area.
pub fn fans(places: &[Point], faces: &[[u32; 3]], normals: &[Option<Point>]) -> Fans {
    let mut found = Fans { faces: faces.to_vec(), vertices: (0..places.len() as u32).collect() };
    let mut at = vec![Vec::new(); places.len()];
    for (face, corners) in (0..).zip(faces) {
        corners.iter().for_each(|v| at[*v as usize].push(face));
    }
    let torn: Vec<u32> = (0..places.len() as u32).filter(|v| is_torn(&at[*v as usize], normals)).collect();
    if torn.is_empty() {
        return found;
    }
    let sheets = Sheets::new(places, faces, normals);
    let mut holes = Vec::new();
    for v in torn {
        let groups: Vec<Vec<Vec<u32>>> =
            sheets.around(v, &at[v as usize]).iter().map(|fan| sheets.groups(v, fan)).collect();
        let mut is_first = true;
        for of_fan in groups {
            let mut corners = Vec::with_capacity(of_fan.len());
            for group in of_fan {
                let corner = if is_first { v } else { found.vertices.len() as u32 };
                if !is_first {
                    found.vertices.push(v);
                }
                is_first = false;
                corners.push(corner);
                for face in group {
                    found.faces[face as usize].iter_mut().filter(|own| **own == v).for_each(|own| *own = corner);
                }
            }
            holes.extend((2..corners.len()).map(|k| [corners[0], corners[k], corners[k - 1]]));
        }
    }
    let narrow = sheets.narrow(&found.faces);
    found.faces.extend(narrow.into_iter().chain(holes));
    found
}

/// Whether no way leads inwards from all faces at a vertex.
fn is_torn(at: &[u32], normals: &[Option<Point>]) -> bool {
    let mut own: Vec<Point> = Vec::new();
    for normal in at.iter().filter_map(|face| normals[*face as usize].as_ref()) {
        if !own.iter().any(|known| dot(known, normal) >= FACE_ANGLE_COS) {
            own.push(*normal);
        }
    }
    !leads_inwards(&own)
}

/// Whether a corner can move inwards with all faces of some normals.
fn leads_inwards(normals: &[Point]) -> bool {
    let way = inwards(&normals.iter().map(|normal| (*normal, 1.0)).collect::<Vec<_>>());
    normals.iter().all(|normal| dot(normal, &way) >= LEAST_INWARDS)
}

/// How faces continue each other across their edges.
struct Sheets<'a> {
    places: &'a [Point],
    faces: &'a [[u32; 3]],
    normals: &'a [Option<Point>],
    /// By face and edge (from that corner to the next): the face that bounds the same solid.
    beside: Vec<[Option<u32>; 3]>,
}

impl<'a> Sheets<'a> {
    fn new(places: &'a [Point], faces: &'a [[u32; 3]], normals: &'a [Option<Point>]) -> Sheets<'a> {
        let mut edges: BTreeMap<[u32; 2], Vec<(u32, usize)>> = BTreeMap::new();
        for (face, corners) in (0..).zip(faces) {
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                edges.entry([a.min(b), a.max(b)]).or_default().push((face, k));
            }
        }
        let mut sheets = Sheets { places, faces, normals, beside: vec![[None; 3]; faces.len()] };
        for (edge, at) in &edges {
            for [(f, i), (g, j)] in sheets.pairs(*edge, at) {
                (sheets.beside[f as usize][i], sheets.beside[g as usize][j]) = (Some(g), Some(f));
            }
        }
        sheets
    }

    /// The faces at an edge in pairs that bound one wedge of the solid.
    fn pairs(&self, [a, b]: [u32; 2], at: &[(u32, usize)]) -> Vec<[(u32, usize); 2]> {
        if let [one, other] = at {
            return vec![[*one, *other]];
        }
        let from = self.places[a as usize];
        let Some(axis) = unit(&sub(&self.places[b as usize], &from)).filter(|_| at.len() > 2) else {
            return Vec::new();
        };
        let mut base: Option<Point> = None;
        // The angle of each face about the edge, and whether the solid follows.
        let (mut around, mut own) = (Vec::new(), Vec::new());
        for (face, k) in at {
            let apex = self.places[self.faces[*face as usize][(k + 2) % 3] as usize];
            let off = sub(&apex, &from);
            let off = sub(&off, &scaled(&axis, dot(&axis, &off)));
            let (Some(off), Some(normal)) = (unit(&off), self.normals[*face as usize]) else { continue };
            let base = *base.get_or_insert(off);
            let angle = dot(&axis, &cross(&base, &off)).atan2(dot(&base, &off));
            around.push((angle, dot(&normal, &cross(&axis, &off)) < 0.0));
            own.push((*face, *k));
        }
        wedges(&around, SAME_FACE_ANGLE).into_iter().map(|pair| pair.map(|i| own[i])).collect()
    }

    /// The faces at a vertex, by sheet, each in its order around the vertex.
    fn around(&self, v: u32, at: &[u32]) -> Vec<Vec<u32>> {
        let place = |face: u32| self.faces[face as usize].iter().position(|own| *own == v);
        let out = |face: u32| place(face).and_then(|k| self.beside[face as usize][k]);
        let back = |face: u32| place(face).and_then(|k| self.beside[face as usize][(k + 2) % 3]);
        let mut left = at.to_vec();
        let mut fans = Vec::new();
        while let Some(first) = left.pop() {
            let mut fan = std::collections::VecDeque::from([first]);
            let mut take = |next: Option<u32>| {
                let found = left.iter().position(|face| Some(*face) == next)?;
                Some(left.swap_remove(found))
            };
            let mut last = first;
            while let Some(face) = take(out(last)) {
                fan.push_back(face);
                last = face;
            }
            last = first;
            while let Some(face) = take(back(last)) {
                fan.push_front(face);
                last = face;
            }
            fans.push(fan.into());
        }
        fans
    }

    /// A sheet at a vertex in as few groups as have a way inwards each, cut at concave edges alone.
    fn groups(&self, v: u32, fan: &[u32]) -> Vec<Vec<u32>> {
        let mut arcs: Vec<Vec<u32>> = Vec::new();
        let concave: Vec<usize> =
            (0..fan.len()).filter(|i| self.is_concave(v, [fan[(i + fan.len() - 1) % fan.len()], fan[*i]])).collect();
        for (i, from) in concave.iter().enumerate() {
            let to = concave.get(i + 1).map_or(concave[0] + fan.len(), |to| *to);
            arcs.push((*from..to).map(|k| fan[k % fan.len()]).collect());
        }
        if arcs.len() < 2 || arcs.len() > MOST_ARCS {
            return vec![fan.to_vec()];
        }
        let normals = |group: &[u32]| group.iter().filter_map(|f| self.normals[*f as usize]).collect::<Vec<Point>>();
        let from = |first: usize| {
            let mut groups: Vec<Vec<u32>> = Vec::new();
            for k in 0..arcs.len() {
                let arc = &arcs[(first + k) % arcs.len()];
                let joined = groups.last().map(|last| [&last[..], arc].concat());
                match joined.filter(|joined| leads_inwards(&normals(joined))) {
                    Some(joined) => *groups.last_mut().unwrap_or(&mut Vec::new()) = joined,
                    None => groups.push(arc.clone()),
                }
            }
            groups
        };
        (0..arcs.len()).map(from).min_by_key(Vec::len).unwrap_or_default()
    }

    /// Whether two faces that follow each other around a vertex meet at a concave edge.
    fn is_concave(&self, v: u32, [one, other]: [u32; 2]) -> bool {
        let Some(normal) = self.normals[one as usize] else { return false };
        let from = self.places[v as usize];
        let off = self.faces[other as usize].map(|p| sub(&self.places[p as usize], &from));
        off.iter().any(|off| dot(&normal, off) > 1e-6 * length(off))
    }

    /// The faces between those that continue each other and have corners of their own at a vertex.
    fn narrow(&self, split: &[[u32; 3]]) -> Vec<[u32; 3]> {
        let mut found = Vec::new();
        for (f, beside) in (0u32..).zip(&self.beside) {
            for (k, g) in beside.iter().enumerate() {
                let Some(g) = g.filter(|g| f < *g) else { continue };
                let (own, other) = (&self.faces[f as usize], &self.faces[g as usize]);
                let corner = |v: u32| other.iter().position(|w| *w == v).map(|at| split[g as usize][at]);
                let (Some(a), Some(b)) = (corner(own[k]), corner(own[(k + 1) % 3])) else { continue };
                let (from, to) = (split[f as usize][k], split[f as usize][(k + 1) % 3]);
                if from != a {
                    found.push([to, from, a]);
                }
                if to != b {
                    found.push([to, a, b]);
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use feeler_core::weld_vertices;
    use feeler_shapes::{box_mesh, joined};

    use super::*;

    /// The surface of cubes of side 1 at places of a grid, each face in two triangles.
    fn cubes(at: &[[i32; 3]]) -> (Vec<Point>, Vec<[u32; 3]>, Vec<Option<Point>>) {
        let sides = at.iter().map(|at| box_mesh(at.map(f64::from), [1.0; 3], 1));
        let (vertices, faces) = joined(sides);
        let middle = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|v| vertices[v as usize]);
            // Of the diagonal, the longest edge: the middle of the side.
            let pairs = [[a, b], [b, c], [c, a]];
            let long = pairs.into_iter().max_by(|[a, b], [c, d]| length(&sub(a, b)).total_cmp(&length(&sub(c, d))));
            long.map_or([0; 3], |[a, b]| std::array::from_fn(|k| (2.0 * (a[k] + b[k])).round() as i32))
        };
        let middles: Vec<[i32; 3]> = faces.iter().map(middle).collect();
        let is_outer = |face: &usize| middles.iter().filter(|other| **other == middles[*face]).count() == 2;
        let outer: Vec<[u32; 3]> = (0..faces.len()).filter(is_outer).map(|face| faces[face]).collect();
        let all: Vec<Point> = outer.iter().flatten().map(|v| vertices[*v as usize]).collect();
        let (places, numbers) = weld_vertices(&all);
        let faces: Vec<[u32; 3]> = numbers.chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
        let normal = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|v| places[v as usize]);
            unit(&cross(&sub(&b, &a), &sub(&c, &a)))
        };
        let normals = faces.iter().map(normal).collect();
        (places, faces, normals)
    }

    /// Whether each edge has as many faces one way as the other.
    fn is_closed(faces: &[[u32; 3]]) -> bool {
        let mut edges: BTreeMap<[u32; 2], i32> = BTreeMap::new();
        for face in faces {
            for k in 0..3 {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
            }
        }
        edges.values().all(|sum| *sum == 0)
    }

    #[test]
    fn corners_are_split_where_no_way_leads_inwards_and_the_surface_stays_closed() {
        let ell = vec![[0, 0, 0], [1, 0, 0], [0, 1, 0]];
        let edge = vec![[0, 0, 0], [1, 1, 0]];
        let corner = vec![[0, 0, 0], [1, 1, 1]];
        let saddle = vec![[0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1]];
        // Corners more than vertices, and narrow faces.
        for (at, more, narrow) in [(ell, 0, 0), (edge, 2, 0), (corner, 1, 0), (saddle, 1, 2)] {
            let (places, faces, normals) = cubes(&at);
            let found = fans(&places, &faces, &normals);
            let counts = (found.vertices.len() - places.len(), found.faces.len() - faces.len());
            assert_eq!(counts, (more, narrow), "{at:?}");
            assert!(is_closed(&found.faces), "{at:?}");
            // Each corner has a way inwards.
            for corner in 0..found.vertices.len() as u32 {
                let own = found.faces.iter().zip(&normals).filter(|(face, _)| face.contains(&corner));
                assert!(leads_inwards(&own.filter_map(|(_, normal)| *normal).collect::<Vec<_>>()), "{at:?}");
            }
        }
    }

    #[test]
    fn blocks_that_share_a_side_are_split_in_any_turn() {
        let mut random = feeler_shapes::random::Random::new(7);
        for case in 0..200 {
            let turn = feeler_core::Pose::new(&random.motion(2.0)).unwrap();
            let rough = if case % 2 == 0 { 0.0 } else { 1e-6 };
            let (vertices, faces) = joined([0.0, 1.0].map(|z| box_mesh([0.0, 0.0, z], [1.0; 3], 1)));
            let rounded = |x: f64| if rough > 0.0 { (x / rough).round() * rough } else { x };
            let all: Vec<Point> =
                faces.iter().flatten().map(|v| turn.apply(&vertices[*v as usize]).map(rounded)).collect();
            let (places, numbers) = weld_vertices(&all);
            let faces: Vec<[u32; 3]> = numbers.chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
            let normals: Vec<Option<Point>> = faces
                .iter()
                .map(|face| {
                    let [a, b, c] = face.map(|v| places[v as usize]);
                    unit(&cross(&sub(&b, &a), &sub(&c, &a)))
                })
                .collect();
            let found = fans(&places, &faces, &normals);
            // The four corners that both have.
            assert_eq!((found.vertices.len(), found.faces.len()), (16, faces.len()), "{case}");
        }
    }

    #[test]
    fn the_corners_of_random_blocks_have_ways_inwards() {
        let mut random = feeler_shapes::random::Random::new(5);
        for _ in 0..200 {
            let at: Vec<[i32; 3]> =
                (0..27).map(|i| [i / 9, i / 3 % 3, i % 3]).filter(|_| random.below(2) == 0).collect();
            let (places, faces, normals) = cubes(&at);
            let found = fans(&places, &faces, &normals);
            assert!(is_closed(&found.faces), "{at:?}");
            for corner in 0..found.vertices.len() as u32 {
                let own = found.faces.iter().zip(&normals).filter(|(face, _)| face.contains(&corner));
                assert!(leads_inwards(&own.filter_map(|(_, normal)| *normal).collect::<Vec<_>>()), "{at:?}");
            }
        }
    }
}
