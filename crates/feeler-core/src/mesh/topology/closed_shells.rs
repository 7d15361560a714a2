//! The winding of closed surfaces: outward normals of each shell, also if a part is several solids, some of them
//! mirrored, and some with hollows.
//!
//! The volume of a single shell shows its winding. A shell inside the material of others is a hollow or a solid in a
//! solid, and is wound like the one around it; one inside a hollow is again on its own. A ray from each shell, with
//! exact signs, finds the nesting.

use bytemuck::{Pod, Zeroable};

use crate::constants::{NONE, SENSE_GRID_SIDE, SENSE_LARGE_CELLS, SENSE_RAYS};
use crate::geometry::bounds::{Aabb, Point};
use crate::geometry::predicates::Signs;
use crate::geometry::vectors::{along, cross, dot, sub};
use crate::mesh::topology::disjoint_sets::DisjointSets;
use crate::mesh::triangle_mesh::Mesh;

/// The connected surface of each triangle, by number; [`NONE`] of one that is not queried.
pub struct Surfaces {
    /// The first triangle of each.
    pub first: Vec<u32>,
    /// The surface of each triangle.
    pub of: Vec<u32>,
}

impl Surfaces {
    /// The connected surfaces across edges.
    pub fn new(mesh: &Mesh, neighbours: &[[u32; 3]]) -> Surfaces {
        let (mut first, mut of, mut next) = (Vec::new(), vec![NONE; neighbours.len()], Vec::new());
        for t in mesh.queried() {
            if of[t as usize] != NONE {
                continue;
            }
            let number = first.len() as u32;
            of[t as usize] = number;
            first.push(t);
            next.push(t);
            while let Some(t) = next.pop() {
                for n in neighbours[t as usize].into_iter().filter(|n| *n != NONE) {
                    if of[n as usize] == NONE {
                        of[n as usize] = number;
                        next.push(n);
                    }
                }
            }
        }
        Surfaces { first, of }
    }

    /// The shell of each surface: across a crack neighbours need not be mutual, and what hangs together one way is one shell.
    fn shells(&self, neighbours: &[[u32; 3]], has_cracks: bool) -> Vec<u32> {
        let mut shells = DisjointSets((0..self.first.len() as u32).collect());
        if has_cracks {
            for (of, around) in self.of.iter().zip(neighbours).filter(|(of, _)| **of != NONE) {
                around.iter().filter(|n| **n != NONE).for_each(|n| shells.join(*of, self.of[*n as usize]));
            }
        }
        (0..self.first.len() as u32).map(|surface| shells.of(surface)).collect()
    }
}

/// A connected surface that bounds a solid or a hollow.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct ClosedShell {
    /// Its part.
    pub part: u32,
    /// The first of its triangles.
    pub first: u32,
    /// The box around it, metres, in the mesh's own frame.
    pub bounds: Aabb,
}

/// A closed surface.
#[derive(Debug, Clone, Copy)]
struct Shell {
    part: u32,
    first: u32,
    bounds: Aabb,
    /// Six times the volume by its winding, from a corner of its own: with cracks the sum depends on the origin, the more the
    /// farther it is.
    volume: f64,
    corner: Option<Point>,
    /// 1 where its winding gives the outward normal, -1 where the inward one.
    sense: i8,
}

impl Shell {
    const NONE: Shell = Shell { part: 0, first: NONE, bounds: Aabb::EMPTY, volume: 0.0, corner: None, sense: 1 };
}

/// For each triangle of a closed surface 1 where its winding gives the outward normal, -1 where the inward one, 0 of others; and the
/// closed surfaces, sorted by part.
pub fn closed_shells(
    mesh: &Mesh,
    (surfaces, neighbours, has_cracks): (&Surfaces, &[[u32; 3]], bool),
    closed: &[bool],
    part_of_face: impl Fn(u32) -> u32,
) -> (Vec<i8>, Vec<ClosedShell>) {
    let shell_of_surface = surfaces.shells(neighbours, has_cracks);
    let shell_of = |t: u32| match surfaces.of[t as usize] {
        surface if surface != NONE && closed[t as usize] => Some(shell_of_surface[surface as usize] as usize),
        _ => None,
    };
    let mut shells = vec![Shell::NONE; surfaces.first.len()];
    for t in mesh.queried() {
        let Some(shell) = shell_of(t) else { continue };
        let shell = &mut shells[shell];
        let [a, b, c] = mesh.triangle(t);
        let normal = cross(&sub(&b, &a), &sub(&c, &a));
        shell.part = part_of_face(t);
        shell.first = shell.first.min(t);
        [a, b, c].iter().for_each(|p| shell.bounds.grow(p));
        shell.volume += dot(&sub(&a, shell.corner.get_or_insert(a)), &normal);
    }
    shells.iter_mut().for_each(|shell| shell.sense = if shell.volume < 0.0 { -1 } else { 1 });
    set_nested(mesh, &mut shells, shell_of);
    let senses = (0..mesh.faces().len() as u32).map(|t| shell_of(t).map_or(0, |shell| shells[shell].sense)).collect();
    shells.retain(|shell| shell.corner.is_some());
    shells.sort_by_key(|shell| shell.part);
    (
        senses,
        shells.iter().map(|shell| ClosedShell { part: shell.part, first: shell.first, bounds: shell.bounds }).collect(),
    )
}

/// Sets the senses of shells inside others, in parts whose shells are not all wound alike.
fn set_nested(mesh: &Mesh, shells: &mut [Shell], shell_of: impl Fn(u32) -> Option<usize>) {
    let parts = shells.iter().map(|shell| shell.part as usize + 1).max().unwrap_or(0);
    let mut senses = vec![[false; 2]; parts];
    for shell in shells.iter().filter(|shell| shell.corner.is_some()) {
        senses[shell.part as usize][usize::from(shell.sense > 0)] = true;
    }
    let is_mixed = |shell: &Shell| shell.corner.is_some() && senses[shell.part as usize] == [true; 2];
    let mut mixed: Vec<usize> = (0..shells.len()).filter(|i| is_mixed(&shells[*i])).collect();
    if mixed.is_empty() {
        return;
    }
    // Part by part, the larger before the smaller: what holds another is larger.
    mixed.sort_by(|i, j| {
        let ([a, b], larger) =
            ([&shells[*i], &shells[*j]], shells[*j].volume.abs().total_cmp(&shells[*i].volume.abs()));
        a.part.cmp(&b.part).then(larger).then(i.cmp(j))
    });
    let mut rank = vec![NONE; shells.len()];
    (0..).zip(&mixed).for_each(|(at, shell)| rank[*shell] = at);
    let mut triangles: Vec<(u32, u32)> = mesh.queried().filter_map(|t| Some((rank[shell_of(t)?], t))).collect();
    triangles.retain(|(rank, _)| *rank != NONE);
    triangles.sort_unstable();
    let part: Vec<u32> = shells.iter().map(|shell| shell.part).collect();
    for of_part in mixed.chunk_by(|i, j| part[*i] == part[*j]) {
        let ranks = rank[of_part[0]]..rank[of_part[of_part.len() - 1]] + 1;
        let own = |ranks: std::ops::Range<u32>| {
            let [from, to] = [ranks.start, ranks.end].map(|r| triangles.partition_point(|(rank, _)| *rank < r));
            &triangles[from..to]
        };
        let columns = Columns::new(mesh, own(ranks.clone()));
        for at in ranks {
            let shell = mixed[at as usize];
            let Some(windings) = columns.windings(mesh, own(at..at + 1), at) else { continue };
            let holding = windings.iter().filter(|(rank, winding)| *rank < at && *winding != 0);
            let sense = |rank: u32| shells[mixed[rank as usize]].sense;
            let material: i32 = holding.clone().map(|(rank, winding)| i32::from(sense(*rank)) * winding).sum();
            if let Some((innermost, _)) = holding.max().filter(|_| material != 0) {
                shells[shell].sense = sense(*innermost);
            }
        }
    }
}

/// Where rays begin on triangles: shares of two sides. Not in the middle, which lies on a diagonal of what is cut likewise.
const RAY_SHARES: [[f64; 2]; 5] = [[0.31, 0.27], [0.22, 0.41], [0.47, 0.19], [0.17, 0.53], [0.39, 0.24]];

/// Triangles by where they lie across the first axis, for rays along it.
struct Columns<'a> {
    /// Shell and triangle.
    triangles: &'a [(u32, u32)],
    bounds: Aabb,
    side: usize,
    /// Places in `triangles` of each cell, from `offsets[cell]` on.
    entries: Vec<u32>,
    offsets: Vec<u32>,
    /// Of those that lie in very many cells.
    large: Vec<u32>,
}

impl Columns<'_> {
    fn new<'a>(mesh: &Mesh, triangles: &'a [(u32, u32)]) -> Columns<'a> {
        let mut bounds = Aabb::EMPTY;
        triangles.iter().for_each(|(_, t)| mesh.triangle(*t).iter().for_each(|p| bounds.grow(p)));
        let side = (triangles.len() as f64).sqrt().ceil().clamp(1.0, SENSE_GRID_SIDE as f64) as usize;
        let mut columns = Columns {
            triangles,
            bounds,
            side,
            entries: Vec::new(),
            offsets: vec![0; side * side + 1],
            large: Vec::new(),
        };
        let mut cells: Vec<(u32, u32)> = Vec::new();
        for (at, (_, t)) in (0..).zip(triangles) {
            let mut around = Aabb::EMPTY;
            mesh.triangle(*t).iter().for_each(|p| around.grow(p));
            let [low, high] = [around.lower, around.upper].map(|p| columns.cell(&p));
            if (high[0] - low[0] + 1) * (high[1] - low[1] + 1) > SENSE_LARGE_CELLS {
                columns.large.push(at);
                continue;
            }
            for i in low[0]..=high[0] {
                cells.extend((low[1]..=high[1]).map(|j| ((i * side + j) as u32, at)));
            }
        }
        cells.sort_unstable();
        for (cell, _) in &cells {
            columns.offsets[*cell as usize + 1] += 1;
        }
        for cell in 0..side * side {
            columns.offsets[cell + 1] += columns.offsets[cell];
        }
        columns.entries = cells.into_iter().map(|(_, at)| at).collect();
        columns
    }

    /// Where a point lies across the first axis.
    fn cell(&self, p: &Point) -> [usize; 2] {
        [1, 2].map(|a| {
            let share = (p[a] - self.bounds.lower[a]) / (self.bounds.upper[a] - self.bounds.lower[a]);
            // A cast from float saturates, and NaN gives 0.
            ((share * self.side as f64) as usize).min(self.side - 1)
        })
    }

    /// Winding numbers of the shells around a shell, by their rank: what most of a few rays say. `None` where no ray could tell.
    fn windings(&self, mesh: &Mesh, own: &[(u32, u32)], rank: u32) -> Option<Vec<(u32, i32)>> {
        let mut found: Vec<Vec<(u32, i32)>> = Vec::new();
        // From triangles all over the shell, of those that a ray does not lie in.
        let is_across = |t: &u32| {
            let [a, b, c] = mesh.triangle(*t);
            let (ab, ac) = (sub(&b, &a), sub(&c, &a));
            ab[1] * ac[2] != ab[2] * ac[1]
        };
        let across: Vec<u32> = own.iter().map(|(_, t)| *t).filter(is_across).collect();
        let rays = SENSE_RAYS.min(across.len());
        for i in 0..rays {
            let [a, b, c] = mesh.triangle(across[i * across.len() / rays]);
            let [u, v] = RAY_SHARES[i % RAY_SHARES.len()];
            let p = along(&along(&a, u, &sub(&b, &a)), v, &sub(&c, &a));
            found.extend(self.along_ray(mesh, &p, rank));
        }
        found.sort();
        let most = found.chunk_by(|x, y| x == y).max_by_key(|same| same.len())?;
        Some(most[0].clone())
    }

    /// Winding numbers of other shells around a point, sorted by their rank; `None` where the ray meets a border of a triangle.
    fn along_ray(&self, mesh: &Mesh, p: &Point, rank: u32) -> Option<Vec<(u32, i32)>> {
        let [i, j] = self.cell(p);
        let cell = i * self.side + j;
        let entries = &self.entries[self.offsets[cell] as usize..self.offsets[cell + 1] as usize];
        let mut windings: Vec<(u32, i32)> = Vec::new();
        for at in entries.iter().chain(&self.large) {
            let (shell, t) = self.triangles[*at as usize];
            let winding = if shell == rank { 0 } else { crossing(p, &mesh.triangle(t))? };
            if winding != 0 {
                windings.push((shell, winding));
            }
        }
        windings.sort_unstable();
        let sum = |same: &[(u32, i32)]| (same[0].0, same.iter().map(|(_, winding)| winding).sum());
        Some(windings.chunk_by(|x, y| x.0 == y.0).map(sum).filter(|(_, winding)| *winding != 0).collect())
    }
}

/// The signed crossing of the ray from `p` along the first axis with a triangle: 1 where it leaves along the winding's normal, -1
/// where it enters against it, 0 where it misses; `None` where it meets the border or begins on the triangle.
fn crossing(p: &Point, t: &[Point; 3]) -> Option<i32> {
    if (1..3).any(|a| t.iter().all(|q| q[a] < p[a]) || t.iter().all(|q| q[a] > p[a])) {
        return Some(0);
    }
    if t.iter().all(|q| q[0] < p[0]) {
        return Some(0);
    }
    let mut signs = Signs::default();
    let flat = |q: &Point| [q[1], q[2]];
    let [a, b, c] = t;
    let around = [(a, b), (b, c), (c, a)].map(|(q, r)| signs.orient2d(flat(q), flat(r), flat(p)));
    if around.contains(&1) && around.contains(&-1) {
        return Some(0);
    }
    if around.contains(&0) {
        return None;
    }
    // Positive behind the triangle.
    let behind = signs.orient3d(a, b, c, p);
    match behind {
        0 => None,
        _ if behind == around[0] => Some(i32::from(behind)),
        _ => Some(0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::topology::adjacency::Adjacency;
    use feeler_shapes::{ball, box_mesh, joined, Arrays};

    fn inverted((vertices, faces): Arrays) -> Arrays {
        (vertices, faces.into_iter().map(|[a, b, c]| [a, c, b]).collect())
    }

    /// The sense of the first triangle of each shell, of shells joined to one part; all triangles of a shell have the same.
    fn senses(shells: Vec<Arrays>) -> Vec<i8> {
        let counts: Vec<usize> = shells.iter().map(|(_, faces)| faces.len()).collect();
        let (vertices, faces) = joined(shells);
        let mesh = Mesh::new("tool", vertices, faces).unwrap();
        let outward = Adjacency::of_one_part(&mesh).outward;
        let mut rest = &outward[..];
        let mut first = Vec::new();
        for count in counts {
            let (own, others) = rest.split_at(count);
            assert!(own.iter().all(|sense| *sense == own[0]));
            first.push(own[0]);
            rest = others;
        }
        first
    }

    fn cube(x: f64, size: f64, cells: usize) -> Arrays {
        box_mesh([x, 0.0, 0.0], [size; 3], cells)
    }

    #[test]
    fn each_shell_has_its_own_sense() {
        // Solids beside each other, one or most of them inside out.
        assert_eq!(senses(vec![cube(0.0, 1.0, 1), inverted(cube(2.0, 1.0, 2))]), [1, -1]);
        assert_eq!(
            senses(vec![inverted(cube(0.0, 5.0, 1)), cube(9.0, 1.0, 1), inverted(cube(20.0, 2.0, 2))]),
            [-1, 1, -1]
        );
        let mirrored: Arrays =
            (cube(3.0, 1.0, 2).0.into_iter().map(|[x, y, z]| [-x, y, z]).collect(), cube(3.0, 1.0, 2).1);
        assert_eq!(senses(vec![cube(3.0, 1.0, 2), mirrored]), [1, -1]);
    }

    #[test]
    fn a_hollow_on_the_lattice_of_its_solid_is_one_however_that_is_cut() {
        let mirrored =
            |(vertices, faces): Arrays| inverted((vertices.into_iter().map(|[x, y, z]| [x, -y, z]).collect(), faces));
        // All cut along the same lines, each side along the one diagonal or the other.
        for (solid, hollow) in [(4, 2), (8, 4)].map(|(n, m)| (cube(0.0, 48.0, n), cube(0.0, 24.0, m))) {
            for (solid, hollow) in [(solid.clone(), hollow.clone()), (mirrored(solid), hollow)] {
                assert_eq!(senses(vec![solid.clone(), inverted(hollow.clone())]), [1, 1]);
                assert_eq!(senses(vec![inverted(solid), hollow]), [-1, -1]);
            }
        }
    }

    #[test]
    fn hollows_are_wound_as_what_holds_them() {
        for cells in 1..4 {
            let (outer, hollow) = (cube(0.0, 4.0, cells), inverted(cube(0.1, 2.0, cells)));
            assert_eq!(senses(vec![outer.clone(), hollow.clone()]), [1, 1]);
            assert_eq!(senses(vec![hollow.clone(), outer.clone()]), [1, 1]);
            // The same inside out.
            assert_eq!(senses(vec![inverted(outer.clone()), inverted(hollow.clone())]), [-1, -1]);
            // A solid in the hollow stands alone, whichever way it is wound; so does a hollow one.
            let inner = cube(0.2, 1.0, cells);
            assert_eq!(senses(vec![outer.clone(), hollow.clone(), inner.clone()]), [1, 1, 1]);
            assert_eq!(senses(vec![inverted(inner.clone()), outer.clone(), hollow.clone()]), [-1, 1, 1]);
            let core = cube(0.25, 0.5, cells);
            assert_eq!(senses(vec![inverted(inner.clone()), outer.clone(), hollow.clone(), core]), [-1, 1, 1, -1]);
            // Beside the whole, a mirrored solid with a hollow of its own.
            let beside = [inverted(cube(10.0, 3.0, cells)), cube(10.1, 1.0, cells)];
            assert_eq!(senses([vec![outer, hollow], beside.to_vec()].concat()), [1, 1, -1, -1]);
        }
    }

    #[test]
    fn many_shells_of_one_part() {
        // Balls in a row within a long box, every other one hollow, every third one inside out, and one that is a hollow of the box.
        let mut shells = vec![
            box_mesh([50.0, 0.0, 0.0], [120.0, 9.0, 9.0], 2),
            inverted(box_mesh([50.0, 0.0, 0.0], [110.0, 8.0, 8.0], 3)),
        ];
        let mut expected = vec![1, 1];
        let at = |x: f64, r: f64| {
            let (vertices, faces) = ball(r, 6);
            (vertices.into_iter().map(|p| [p[0] + x, p[1], p[2]]).collect::<Vec<Point>>(), faces)
        };
        for i in 0..40 {
            let (x, turned) = (2.5 * f64::from(i), i % 3 == 0);
            let sense = |shell: Arrays| if turned { inverted(shell) } else { shell };
            shells.push(sense(at(x, 1.0)));
            expected.push(if turned { -1 } else { 1 });
            if i % 2 == 0 {
                shells.push(sense(inverted(at(x, 0.5))));
                expected.push(if turned { -1 } else { 1 });
            }
        }
        assert_eq!(senses(shells), expected);
    }
}
