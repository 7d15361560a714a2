//! Adjacency: which triangles share an edge, which surfaces are closed, and their smooth regions. Computed once for a
//! mesh, at the first contact query.

use std::cell::OnceCell;

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use crate::constants::{EDGES_PER_OPEN_EDGE, LOOSE_EDGES_TRIED, NONE, WELD_SHARE};
use crate::error::Result;
use crate::geometry::bounds::{Aabb, Point, Triangle};
use crate::geometry::triangle_normals::is_thin;
use crate::geometry::vectors::{add, cross, dot, length, scaled, sub};
use crate::mesh::topology::closed_shells::{closed_shells, ClosedShell, Surfaces};
use crate::mesh::topology::convex_bodies::convex_bodies;
use crate::mesh::topology::crack_stitching::close_cracks;
use crate::mesh::topology::disjoint_sets::DisjointSets;
use crate::mesh::topology::edges::{inside_out, pair_around, take_copies, take_doubles, Corner, Edge, Edges};
use crate::mesh::topology::smooth_regions::{smooth_regions, SmoothRegion};
use crate::mesh::triangle_mesh::Mesh;
use crate::mesh::weld::weld_vertices;
use crate::saved::{check, Reader, Sections};
use feeler_lanes::{prefetch_at, Column};

/// Neighbours across edges, and the sense of each triangle's winding.
#[derive(Debug)]
pub struct Adjacency {
    /// `neighbours[t][k]` lies across the edge from corner `k` to corner `k + 1` of `t`, within the same part; [`NONE`] at a
    /// border, and where more than two triangles share the edge and not as many run one way along it as the other. Across a crack it
    /// is the nearest of several.
    pub neighbours: Column<[u32; 3]>,
    /// 1: the triangle belongs to a closed surface and its winding gives the outward normal; -1: the inward one; 0: the
    /// surface is open, or doubled, and the winding has no meaning.
    pub outward: Column<i8>,
    /// The region of each triangle.
    pub smooth_regions: Column<SmoothRegion>,
    /// The convex body of each smooth region: the number of the region that founded it.
    bodies: Column<u32>,
    /// The centre of the surface's area, metres, in the mesh's own frame.
    pub centre: Point,
    /// For each connected surface that is open its part and its first triangle; sorted.
    open_surfaces: Vec<[u32; 2]>,
    /// The parts with a torn surface: one whose edges do not all meet others; sorted.
    torn_parts: Vec<u32>,
    /// The closed ones, sorted by part. Across a crack two surfaces are one shell.
    shells: Vec<ClosedShell>,
    /// Whether there are cracks: across these, adjacency need not be mutual.
    pub has_cracks: bool,
    /// Whether there are seams whose corners do not coincide: closed surfaces may have gaps of that width.
    pub has_loose_seams: bool,
}

impl Adjacency {
    /// Prefetches all about a triangle.
    #[inline]
    pub fn prefetch(&self, triangle: u32) {
        prefetch_at(&self.neighbours, triangle as usize);
        prefetch_at(&self.outward, triangle as usize);
        prefetch_at(&self.smooth_regions, triangle as usize);
    }

    /// From given neighbours, all closed, with nothing else known; for tests of traversals.
    #[doc(hidden)]
    pub fn of_neighbours(neighbours: Vec<[u32; 3]>) -> Adjacency {
        Adjacency {
            outward: vec![1; neighbours.len()].into(),
            neighbours: neighbours.into(),
            smooth_regions: Column::default(),
            bodies: Column::default(),
            centre: [0.0; 3],
            open_surfaces: Vec::new(),
            torn_parts: Vec::new(),
            shells: Vec::new(),
            has_cracks: false,
            has_loose_seams: false,
        }
    }

    /// Of a mesh that is one part.
    pub fn of_one_part(mesh: &Mesh) -> Adjacency {
        Adjacency::new(mesh, |_| 0, &[mesh.bounds()])
    }

    /// The adjacency of a mesh in parts, with the box around each.
    ///
    /// Edges are matched by the positions of their ends, so triangles need not share vertices. Those without a partner are matched
    /// again by ends that nearly coincide, as at seams that were computed from both sides, and then across cracks.
    pub fn new(mesh: &Mesh, part_of_face: impl Fn(u32) -> u32, bounds: &[Aabb]) -> Adjacency {
        let mut adjacency = Adjacency::without_regions(mesh, &part_of_face, bounds);
        let Adjacency { neighbours, outward, .. } = &adjacency;
        let thin = |t: u32| WELD_SHARE * bounds[part_of_face(t) as usize].longest();
        let smooth_regions = smooth_regions(mesh, neighbours, outward, |t, triangle| is_thin(triangle, thin(t)));
        adjacency.bodies = convex_bodies(mesh, neighbours, outward, &smooth_regions).into();
        adjacency.smooth_regions = smooth_regions.into();
        adjacency
    }

    /// Of a mesh that is one part, without smooth regions and convex bodies.
    pub(crate) fn of_surfaces(mesh: &Mesh) -> Adjacency {
        Adjacency::without_regions(mesh, &|_| 0, &[mesh.bounds()])
    }

    // By reference, so that all of this is compiled once: it is 30 kB of code.
    fn without_regions(mesh: &Mesh, part_of_face: &dyn Fn(u32) -> u32, bounds: &[Aabb]) -> Adjacency {
        let mut joined = Joined::new(mesh, part_of_face, bounds);
        let (unique, welded) = weld_vertices(mesh.vertices());
        let corners = |t: u32| mesh.faces()[t as usize].map(|v| welded[v as usize]);
        let mut by_part: Vec<(u32, Edge)> = Vec::new();
        let third = |edge: &Edge| corners(edge.triangle)[usize::from(edge.side + 2) % 3];
        for same in Edges::new(mesh, unique.len(), corners).iter() {
            by_part.clear();
            by_part.extend(same.iter().map(|edge| (part_of_face(edge.triangle), *edge)));
            by_part.sort_by_key(|(part, _)| *part);
            for same in by_part.chunk_by(|x, y| x.0 == y.0) {
                // A single edge is a border, whatever its third corner.
                let third = |edge: &Edge| if same.len() > 1 { third(edge) } else { NONE };
                joined.join(same.iter().map(|(_, edge)| (*edge, third(edge))), false);
            }
        }
        joined.close_gaps((&unique, corners));
        let Joined { neighbours, mut closed, mut copies, torn, has_cracks, has_loose_seams, .. } = joined;
        copies.sort_unstable();
        let mut torn_parts: Vec<u32> = torn.into_iter().map(part_of_face).collect();
        torn_parts.sort_unstable();
        torn_parts.dedup();
        spread_openness(&neighbours, &mut closed);
        let connected = Surfaces::new(mesh, &neighbours);
        let (outward, shells) = closed_shells(mesh, (&connected, &neighbours, has_cracks), &closed, part_of_face);
        let is_copy = |t: &u32| copies.binary_search(t).is_ok();
        let open = connected.first.into_iter().filter(|t| outward[*t as usize] == 0 && !is_copy(t));
        let mut open_surfaces: Vec<[u32; 2]> = open.map(|t| [part_of_face(t), t]).collect();
        open_surfaces.sort_unstable();
        Adjacency {
            neighbours: neighbours.into(),
            outward: outward.into(),
            smooth_regions: Column::default(),
            bodies: Column::default(),
            centre: centre_of_area(mesh),
            open_surfaces,
            torn_parts,
            shells,
            has_cracks,
            has_loose_seams,
        }
    }

    /// Of a mesh in which some parts are moved, each as a whole: shared, but for what has a place.
    pub(crate) fn moved(&self, (mesh, part_bounds): (&Mesh, &[Aabb]), is_moved: impl Fn(u32) -> bool) -> Adjacency {
        let mut shells = self.shells.clone();
        for shell in shells.iter_mut().filter(|shell| is_moved(shell.part)) {
            // Across a crack two surfaces are one shell, and neighbours one way: nowhere is it larger than the part.
            let of_part = &part_bounds[shell.part as usize];
            shell.bounds = if self.has_cracks { *of_part } else { self.bounds_around(mesh, shell.first) };
        }
        Adjacency {
            neighbours: self.neighbours.clone(),
            outward: self.outward.clone(),
            smooth_regions: self.smooth_regions.clone(),
            bodies: self.bodies.clone(),
            centre: centre_of_area(mesh),
            open_surfaces: self.open_surfaces.clone(),
            torn_parts: self.torn_parts.clone(),
            shells,
            ..*self
        }
    }

    /// The box around the surface of a triangle.
    fn bounds_around(&self, mesh: &Mesh, triangle: u32) -> Aabb {
        let (mut bounds, mut next) = (Aabb::EMPTY, vec![triangle]);
        let mut seen = std::collections::HashSet::from([triangle]);
        while let Some(t) = next.pop() {
            mesh.triangle(t).iter().for_each(|corner| bounds.grow(corner));
            next.extend(self.neighbours[t as usize].iter().filter(|n| **n != NONE && seen.insert(**n)));
        }
        bounds
    }

    /// Of one part alone, as a mesh whose triangle `i` is this one's `faces[i]`; these are all of the part that are queried, ascending.
    pub(crate) fn of_part(&self, mesh: &Mesh, part: u32, faces: &[u32]) -> Adjacency {
        let own = |face: u32| faces.partition_point(|f| *f < face) as u32;
        let own_or_none = |face: u32| if face == NONE { NONE } else { own(face) };
        // Regions are numbered by their first triangles, and so are those of the part alone.
        let mut numbers: Vec<u32> = faces.iter().map(|face| self.smooth_regions[*face as usize].number()).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let number = |of_all: u32| numbers.partition_point(|n| *n < of_all) as u32;
        let regions = faces.iter().map(|face| self.smooth_regions[*face as usize]);
        let bodies = numbers.iter().map(|n| self.bodies.get(*n as usize).map_or(NONE, |body| number(*body)));
        let neighbours = faces.iter().map(|face| self.neighbours[*face as usize].map(own_or_none));
        let outward = faces.iter().map(|face| self.outward[*face as usize]);
        let shells = self.shells_of(part).iter();
        Adjacency {
            neighbours: neighbours.collect::<Vec<_>>().into(),
            outward: outward.collect::<Vec<_>>().into(),
            smooth_regions: regions.map(|region| region.numbered(number(region.number()))).collect::<Vec<_>>().into(),
            bodies: bodies.collect::<Vec<_>>().into(),
            centre: centre_of_area(mesh),
            open_surfaces: self.open_surfaces_of(part).iter().map(|[_, face]| [0, own(*face)]).collect(),
            torn_parts: if self.is_torn(part) { vec![0] } else { Vec::new() },
            shells: shells.map(|shell| ClosedShell { part: 0, first: own(shell.first), ..*shell }).collect(),
            has_cracks: self.has_cracks,
            has_loose_seams: self.has_loose_seams,
        }
    }

    /// Adds it to the sections of a saved scene.
    pub(crate) fn save<'a>(&'a self, sections: &mut Sections<'a>) {
        sections.add("topology.neighbours", &self.neighbours);
        sections.add("topology.outward", &self.outward);
        sections.add("topology.regions", &self.smooth_regions);
        sections.add("topology.bodies", &self.bodies);
        sections.add("topology.open", &self.open_surfaces);
        sections.add("topology.torn", &self.torn_parts);
        sections.add("topology.shells", &self.shells);
        let [cracks, seams] = [self.has_cracks, self.has_loose_seams].map(u32::from);
        sections.add_made("topology.facts", &[Facts { centre: self.centre, cracks, seams }]);
    }

    /// Read from a saved scene, for a mesh with this number of faces and parts.
    pub(crate) fn of_saved(saved: Reader<'_>, mesh: &Mesh, parts: usize) -> Result<Adjacency> {
        let triangles = mesh.faces().len();
        let Facts { centre, cracks, seams } = saved.one("topology.facts")?;
        let adjacency = Adjacency {
            neighbours: saved.column_of("topology.neighbours", triangles)?,
            outward: saved.column_of("topology.outward", triangles)?,
            smooth_regions: saved.column_of("topology.regions", triangles)?,
            bodies: saved.column("topology.bodies")?,
            centre,
            open_surfaces: saved.column("topology.open")?.to_vec(),
            torn_parts: saved.column("topology.torn")?.to_vec(),
            shells: saved.column("topology.shells")?.to_vec(),
            has_cracks: cracks != 0,
            has_loose_seams: seams != 0,
        };
        if saved.is_checked {
            adjacency.check(mesh, parts)?;
        }
        Ok(adjacency)
    }

    /// Every number is one of a queried triangle, a part or a body that there is, and the lists are sorted.
    fn check(&self, mesh: &Mesh, parts: usize) -> Result<()> {
        let triangles = mesh.faces().len();
        let is_triangle = |t: u32| (t as usize) < triangles && mesh.is_queried(t);
        let is_part = |part: u32| (part as usize) < parts;
        let neighbours = |around: &[u32; 3]| around.iter().all(|t| *t == NONE || is_triangle(*t));
        check(self.neighbours.par_iter().all(neighbours), || "topology.neighbours".into())?;
        check(self.outward.par_iter().all(|sense| sense.abs() <= 1), || "topology.outward".into())?;
        let bodies = self.bodies.len();
        let is_region = |region: &SmoothRegion| {
            (region.number() as usize) < bodies || region.number() == SmoothRegion::NONE.number()
        };
        check(bodies <= triangles && self.smooth_regions.par_iter().all(is_region), || "topology.regions".into())?;
        let is_body = |body: &u32| *body == NONE || (*body as usize) < bodies;
        check(self.bodies.par_iter().all(is_body), || "topology.bodies".into())?;
        let open = self.open_surfaces.iter().all(|[part, t]| is_part(*part) && is_triangle(*t));
        check(open && self.open_surfaces.is_sorted(), || "topology.open".into())?;
        let torn = self.torn_parts.iter().all(|part| is_part(*part));
        check(torn && self.torn_parts.is_sorted(), || "topology.torn".into())?;
        let shells = self.shells.iter().all(|shell| is_part(shell.part) && is_triangle(shell.first));
        check(shells && self.shells.is_sorted_by_key(|shell| shell.part), || "topology.shells".into())
    }

    /// The convex body of a triangle; [`NONE`] of one that is not queried. Numbers are the same for the same mesh.
    pub fn body_of(&self, triangle: u32) -> u32 {
        let region = self.smooth_regions[triangle as usize].number();
        self.bodies.get(region as usize).copied().unwrap_or(NONE)
    }

    /// Whether a part is not closed: it has no closed surface, or a torn one beside those. Triangles that coincide tear nothing.
    pub fn is_open(&self, part: u32) -> bool {
        self.is_torn(part) || self.shells_of(part).is_empty()
    }

    fn is_torn(&self, part: u32) -> bool {
        self.torn_parts.binary_search(&part).is_ok()
    }

    /// Whether closed surfaces may have gaps, in seams and cracks.
    pub fn is_loose(&self) -> bool {
        self.has_cracks || self.has_loose_seams
    }

    /// The corners of a triangle in the order that winds it outwards; `None` of an open surface.
    pub fn wound_outward(&self, t: u32, [a, b, c]: Triangle) -> Option<Triangle> {
        match self.outward[t as usize] {
            1 => Some([a, b, c]),
            -1 => Some([b, a, c]),
            _ => None,
        }
    }

    /// The open surfaces of one part: the part, and the first triangle of each.
    pub fn open_surfaces_of(&self, part: u32) -> &[[u32; 2]] {
        let from = self.open_surfaces.partition_point(|[of, _]| *of < part);
        let count = self.open_surfaces[from..].partition_point(|[of, _]| *of == part);
        &self.open_surfaces[from..from + count]
    }

    /// The closed surfaces of one part.
    pub fn shells_of(&self, part: u32) -> &[ClosedShell] {
        let from = self.shells.partition_point(|shell| shell.part < part);
        let count = self.shells[from..].partition_point(|shell| shell.part == part);
        &self.shells[from..from + count]
    }

    /// Bytes held.
    pub fn memory(&self) -> usize {
        self.neighbours.memory()
            + self.outward.memory()
            + self.smooth_regions.memory()
            + self.bodies.memory()
            + self.open_surfaces.capacity() * size_of::<[u32; 2]>()
            + self.torn_parts.capacity() * size_of::<u32>()
            + self.shells.capacity() * size_of::<ClosedShell>()
    }
}

/// What a saved scene says of an adjacency beside its arrays.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Facts {
    centre: Point,
    cracks: u32,
    seams: u32,
}

/// The centre of a surface's area, metres.
fn centre_of_area(mesh: &Mesh) -> Point {
    let (mut centre, mut area) = ([0.0; 3], 0.0);
    let middle = scaled(&add(&mesh.bounds().lower, &mesh.bounds().upper), 0.5);
    for t in mesh.queried() {
        let [a, b, c] = mesh.triangle(t).map(|p| sub(&p, &middle));
        let normal = cross(&sub(&b, &a), &sub(&c, &a));
        let weight = length(&normal);
        area += weight;
        centre = add(&centre, &scaled(&add(&add(&a, &b), &c), weight / 3.0));
    }
    let shift = if area > 0.0 && area.is_finite() { scaled(&centre, 1.0 / area) } else { [0.0; 3] };
    add(&middle, &shift)
}

/// The adjacency so far, while edges are matched.
struct Joined<'a> {
    mesh: &'a Mesh,
    part_of_face: &'a dyn Fn(u32) -> u32,
    /// Around each part.
    bounds: &'a [Aabb],
    /// For each part whether it is wound inside out as a whole; known once an edge has more than two triangles.
    inside_out: OnceCell<Vec<bool>>,
    neighbours: Vec<[u32; 3]>,
    /// For each triangle whether all its edges are closed so far; an open one opens its whole surface.
    closed: Vec<bool>,
    /// Half-edges without a partner.
    border: Vec<Edge>,
    /// Triangles at whose edges a surface ends.
    torn: Vec<u32>,
    /// Triangles that repeat another one.
    copies: Vec<u32>,
    has_cracks: bool,
    has_loose_seams: bool,
    /// Working memory.
    same: Vec<(Edge, Corner)>,
}

impl<'a> Joined<'a> {
    fn new(mesh: &'a Mesh, part_of_face: &'a dyn Fn(u32) -> u32, bounds: &'a [Aabb]) -> Joined<'a> {
        let count = mesh.faces().len();
        Joined {
            mesh,
            part_of_face,
            bounds,
            inside_out: OnceCell::new(),
            neighbours: vec![[NONE; 3]; count],
            closed: vec![true; count],
            border: Vec::new(),
            torn: Vec::new(),
            copies: Vec::new(),
            has_cracks: false,
            has_loose_seams: false,
            same: Vec::new(),
        }
    }

    /// Links the half-edges of one edge, all of one part, each with the number of its triangle's third corner. Where they do not match
    /// they are left for the seams, or, where those are sought already, open.
    fn join(&mut self, edges: impl Iterator<Item = (Edge, Corner)>, is_seam: bool) {
        let mut same = std::mem::take(&mut self.same);
        same.clear();
        same.extend(edges);
        match same[..] {
            [(edge, _)] => self.border.push(edge),
            [(edge, _), (other, _)] if edge.up != other.up => self.link(&edge, &other),
            _ => self.join_many(&mut same, is_seam),
        }
        self.same = same;
    }

    fn join_many(&mut self, same: &mut Vec<(Edge, Corner)>, is_seam: bool) {
        let is_balanced = |some: &[(Edge, Corner)]| 2 * some.iter().filter(|(edge, _)| edge.up).count() == some.len();
        if is_balanced(same) {
            // Doubled triangles have nothing between them: they bound no solid.
            let doubles = take_doubles(same);
            self.pair(&doubles);
            doubles.iter().for_each(|(edge, _)| self.closed[edge.triangle as usize] = false);
        }
        // Triangles that repeat others bound nothing more. They are a surface of their own, or none.
        let copies = take_copies(same);
        if is_balanced(same) || is_seam && same.len() == 1 {
            match same[..] {
                [(edge, _)] => self.border.push(edge),
                _ => self.pair(same),
            }
            self.copies.extend(copies.iter().map(|(edge, _)| edge.triangle));
            if is_balanced(&copies) {
                self.pair(&copies);
            } else {
                copies.iter().for_each(|(edge, _)| self.closed[edge.triangle as usize] = false);
            }
            return;
        }
        same.extend(copies);
        if is_balanced(same) {
            self.pair(same);
        } else if !is_seam {
            self.border.extend(same.iter().map(|(edge, _)| *edge));
        } else {
            if let [(edge, _), (other, _)] = same[..] {
                self.link(&edge, &other);
            }
            same.iter().for_each(|(edge, _)| self.tear(edge));
        }
    }

    fn pair(&mut self, some: &[(Edge, Corner)]) {
        let edges: Vec<Edge> = some.iter().map(|(edge, _)| *edge).collect();
        let part = edges.first().map_or(0, |edge| (self.part_of_face)(edge.triangle));
        let inside_out = self.inside_out.get_or_init(|| inside_out(self.mesh, self.part_of_face, self.bounds));
        for [i, j] in pair_around(self.mesh, &edges, inside_out.get(part as usize) == Some(&true)) {
            self.link(&edges[i], &edges[j]);
        }
    }

    fn link(&mut self, edge: &Edge, other: &Edge) {
        self.neighbours[edge.triangle as usize][usize::from(edge.side)] = other.triangle;
        self.neighbours[other.triangle as usize][usize::from(other.side)] = edge.triangle;
    }

    fn tear(&mut self, edge: &Edge) {
        self.closed[edge.triangle as usize] = false;
        self.torn.push(edge.triangle);
    }

    /// Links half-edges without a partner by ends that nearly coincide, then across cracks; what is left is open. An edge whose own ends
    /// coincide opens nothing. In large parts of loose triangles cracks are not sought. `places` are the corners' positions by number.
    fn close_gaps(&mut self, (places, corners): (&[Point], impl Fn(u32) -> [Corner; 3])) {
        let (part_of_face, bounds) = (self.part_of_face, self.bounds);
        let part_of = |edge: &Edge| part_of_face(edge.triangle);
        let mut tried = std::mem::take(&mut self.border);
        tried.sort_by_key(part_of);
        let mut numbers = vec![NONE; if tried.is_empty() { 0 } else { places.len() }];
        for of_part in tried.chunk_by(|x, y| part_of(x) == part_of(y)) {
            self.close_seams(
                of_part,
                (places, &corners),
                bounds[part_of(&of_part[0]) as usize].longest(),
                &mut numbers,
            );
        }
        self.open_pairs();
        let (mut edges, mut open) = (vec![0; bounds.len()], vec![0; bounds.len()]);
        self.mesh.queried().for_each(|t| edges[part_of_face(t) as usize] += 3);
        self.border.iter().for_each(|edge| open[part_of(edge) as usize] += 1);
        let is_tried = |edge: &Edge| {
            let (all, open) = (edges[part_of(edge) as usize], open[part_of(edge) as usize]);
            open <= LOOSE_EDGES_TRIED || EDGES_PER_OPEN_EDGE * open <= all
        };
        let (mut border, mut left): (Vec<Edge>, Vec<Edge>) =
            std::mem::take(&mut self.border).into_iter().partition(is_tried);
        self.has_cracks =
            close_cracks(self.mesh, &self.closed, &mut self.neighbours, &mut border, part_of_face, bounds);
        left.append(&mut border);
        left.iter().for_each(|edge| self.tear(edge));
    }

    /// Links half-edges of a part of that length. `numbers` is working memory, [`NONE`] for each place.
    fn close_seams(
        &mut self,
        border: &[Edge],
        (places, corners): (&[Point], impl Fn(u32) -> [Corner; 3]),
        longest: f64,
        numbers: &mut [u32],
    ) {
        let own = |edge: &Edge| {
            let (corners, side) = (corners(edge.triangle), usize::from(edge.side));
            [side, side + 1, side + 2].map(|k| corners[k % 3] as usize)
        };
        let mut own_places = Vec::new();
        for at in border.iter().flat_map(own) {
            if numbers[at] == NONE {
                numbers[at] = own_places.len() as u32;
                own_places.push(at);
            }
        }
        // `near_points` joins points nearer than half a unit.
        let unit = (2.0 * WELD_SHARE * longest).max(f64::MIN_POSITIVE);
        let points: Vec<Point> = own_places.iter().map(|at| places[*at].map(|x| x / unit)).collect();
        let near = near_points(&points);
        self.has_loose_seams |= (0..).zip(&near).any(|(i, near)| i != *near);
        let mut seams: Vec<(Corner, Edge, Corner)> = Vec::with_capacity(border.len());
        for edge in border {
            let [from, to, third] = own(edge).map(|at| near[numbers[at] as usize]);
            if from != to {
                seams.push((from.min(to), Edge { end: from.max(to), up: from < to, ..*edge }, third));
            }
        }
        seams.sort_unstable_by_key(|(lower, edge, _)| (*lower, edge.end, edge.triangle, edge.side));
        for same in seams.chunk_by(|x, y| (x.0, x.1.end) == (y.0, y.1.end)) {
            self.join(same.iter().map(|(_, edge, third)| (*edge, *third)), true);
        }
        own_places.iter().for_each(|at| numbers[*at] = NONE);
    }

    /// Opens pairs of triangles that share two edges, and so all corners: nothing is between them.
    fn open_pairs(&mut self) {
        for (closed, [a, b, c]) in self.closed.iter_mut().zip(&self.neighbours) {
            *closed &= !((a == b || a == c) && *a != NONE || b == c && *b != NONE);
        }
    }
}

/// Single-linkage clusters of points that are less than 0.5 apart along each axis: for each point the number of its cluster.
///
/// Along an axis two such points lie in one cell of the integer grid, or of that grid shifted by half. So in one of eight grids they
/// lie in one cell.
fn near_points(points: &[Point]) -> Vec<u32> {
    let some = not_alone(points);
    let mut roots = DisjointSets((0..points.len() as u32).collect());
    for grid in 0..8 {
        let cell = |i: &u32| std::array::from_fn(|a| (points[*i as usize][a] + 0.5 * f64::from(grid >> a & 1)).floor());
        let (cells, cell_of) = weld_vertices(&some.iter().map(cell).collect::<Vec<Point>>());
        let mut first = vec![NONE; cells.len()];
        for (i, cell) in some.iter().zip(cell_of) {
            match &mut first[cell as usize] {
                first if *first == NONE => *first = *i,
                first => roots.join(*first, *i),
            }
        }
    }
    (0..points.len() as u32).map(|i| roots.of(i)).collect()
}

/// The points that lie in one cell of such a grid with another, and few others: of loose triangles hardly any. By a sweep across a
/// direction that is along no usual plane.
fn not_alone(points: &[Point]) -> Vec<u32> {
    const ACROSS: Point = [0.8191725133961645, 0.6710436067037893, 0.5497004779019703];
    let mut swept: Vec<(f64, u32, &Point)> = (0..).zip(points).map(|(i, p)| (dot(p, &ACROSS), i, p)).collect();
    swept.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
    let is_near = |x: &(f64, u32, &Point), y: &(f64, u32, &Point)| (0..3).all(|a| (x.2[a] - y.2[a]).abs() < 1.0);
    let reach = ACROSS.iter().sum::<f64>();
    let mut some: Vec<u32> = Vec::new();
    for (at, point) in swept.iter().enumerate() {
        let within = |other: &&(f64, u32, &Point)| (other.0 - point.0).abs() <= reach;
        let is_beside = |other: &(f64, u32, &Point)| is_near(point, other);
        let after = swept[at + 1..].iter().take_while(within).any(is_beside);
        if after || swept[..at].iter().rev().take_while(within).any(is_beside) {
            some.push(point.1);
        }
    }
    some.sort_unstable();
    some
}

/// Marks every triangle that is connected to an open one.
fn spread_openness(neighbours: &[[u32; 3]], closed: &mut [bool]) {
    let mut open: Vec<u32> = (0..closed.len() as u32).filter(|t| !closed[*t as usize]).collect();
    while let Some(t) = open.pop() {
        for n in neighbours[t as usize] {
            if n != NONE && closed[n as usize] {
                closed[n as usize] = false;
                open.push(n);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::f64::consts::{PI, TAU};

    use super::*;
    use feeler_shapes::random::Random;
    use feeler_shapes::{box_mesh, joined, sheet, Arrays};
    use proptest::prelude::*;

    #[test]
    fn a_box_is_closed_whether_or_not_its_triangles_share_vertices() {
        let (vertices, faces) = box_mesh([0.0; 3], [1.0, 2.0, 3.0], 3);
        let soup: Vec<Point> = faces.iter().flatten().map(|v| vertices[*v as usize]).collect();
        let soup_faces = (0..faces.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        for mesh in [Mesh::new("tool", vertices, faces).unwrap(), Mesh::new("tool", soup, soup_faces).unwrap()] {
            let adjacency = Adjacency::of_one_part(&mesh);
            assert!(adjacency.outward.iter().all(|o| *o == 1));
            assert!(adjacency.neighbours.iter().flatten().all(|n| *n != NONE));
            assert!((0..3).all(|a| adjacency.centre[a].abs() < 1e-12));
        }
    }

    proptest! {
        #[test]
        fn neighbours_are_those_of_every_edge_with_every_other(
            faces in prop::collection::vec((prop::array::uniform3(0..9u32), 0..2u32), 1..60),
        ) {
            // Points 7 and 8 coincide with 0 and 1; some triangles have no area.
            let place = |v: u32| f64::from(v % 7);
            let vertices = (0..9).map(|v| [place(v), place(v) * place(v), place(v).powi(3)]).collect();
            let parts: Vec<u32> = faces.iter().map(|(_, part)| *part).collect();
            let given = faces.iter().map(|(face, _)| *face).collect();
            // None where no triangle has an area.
            let Ok(mesh) = Mesh::new("mockup", vertices, given) else { return Ok(()) };
            let adjacency = Adjacency::new(&mesh, |t| parts[t as usize], &[mesh.bounds(); 2]);
            let ends = |t: usize, k: usize| [mesh.faces()[t][k] % 7, mesh.faces()[t][(k + 1) % 3] % 7];
            let all = || (0..faces.len()).filter(|t| mesh.is_queried(*t as u32)).flat_map(|t| (0..3).map(move |k| (t, k)));
            for (t, k) in (0..faces.len()).flat_map(|t| (0..3).map(move |k| (t, k))) {
                let [a, b] = ends(t, k);
                let is_beside = |(u, l): &(usize, usize)| {
                    (*u, *l) != (t, k) && parts[*u] == parts[t] && ([a, b] == ends(*u, *l) || [b, a] == ends(*u, *l))
                };
                let others: Vec<_> = all().filter(is_beside).collect();
                let n = adjacency.neighbours[t][k];
                let against = others.iter().filter(|(u, l)| ends(*u, *l) == [b, a]);
                let is_mutual =
                    |(u, l): &&(usize, usize)| *u as u32 == n && adjacency.neighbours[*u][*l] == t as u32;
                let thirds: BTreeSet<u32> =
                    others.iter().chain([&(t, k)]).map(|(u, l)| mesh.faces()[*u][(l + 2) % 3] % 7).collect();
                if thirds.len() <= others.len() {
                    // Triangles that coincide are taken out first.
                    prop_assert!(n == NONE || others.iter().filter(is_mutual).count() == 1, "{} {}", t, k);
                } else if !mesh.is_queried(t as u32) || others.is_empty() {
                    prop_assert_eq!(n, NONE, "{} {}", t, k);
                } else if let [(other, _)] = others[..] {
                    prop_assert_eq!(n, other as u32, "{} {}", t, k);
                } else if 2 * against.clone().count() != others.len() + 1 {
                    prop_assert_eq!(n, NONE, "{} {}", t, k);
                } else {
                    // One of those that run the other way, and mutual.
                    prop_assert_eq!(against.filter(is_mutual).count(), 1, "{} {}", t, k);
                }
            }
        }
    }

    fn outward((vertices, faces): Arrays) -> Vec<i8> {
        Adjacency::of_one_part(&Mesh::new("tool", vertices, faces).unwrap()).outward.to_vec()
    }

    #[test]
    fn solids_that_touch_are_closed() {
        let cube = |x: f64, y: f64| box_mesh([x, y, 0.0], [2.0; 3], 2);
        // Along an edge: no neighbour is of the other cube.
        let (vertices, faces) = joined([cube(0.0, 0.0), cube(2.0, 2.0)]);
        let (half, mesh) = (faces.len() / 2, Mesh::new("tool", vertices, faces).unwrap());
        let adjacency = Adjacency::of_one_part(&mesh);
        assert!(adjacency.outward.iter().all(|o| *o == 1));
        for (t, neighbours) in adjacency.neighbours.iter().enumerate() {
            assert!(neighbours.iter().all(|n| *n as usize / half == t / half), "{t}");
        }
        // Along a face: the doubled triangles between them are open, and the rest is one solid.
        let (vertices, faces) = joined([cube(0.0, 0.0), cube(2.0, 0.0)]);
        let is_between = |face: &[u32; 3]| face.iter().all(|v| vertices[*v as usize][0] == 1.0);
        let expected: Vec<i8> = faces.iter().map(|face| i8::from(!is_between(face))).collect();
        assert_eq!(expected.iter().filter(|o| **o == 0).count(), 16);
        assert_eq!(outward((vertices, faces)), expected);
    }

    #[test]
    fn what_is_twice_in_one_place_is_open() {
        // A sheet with both its sides, of one square and of several.
        for cells in [1, 3] {
            let (vertices, faces) = sheet(cells, cells, |s, t| [s, t, 0.1 * s * t]);
            let both = faces.iter().copied().chain(faces.iter().map(|[a, b, c]| [*b, *a, *c])).collect();
            assert!(outward((vertices, both)).iter().all(|o| *o == 0), "{cells}");
        }
    }

    #[test]
    fn seams_are_closed_and_gaps_are_not() {
        for n in [4, 7, 12, 31] {
            // A ball with rounded sines: each pole is many points, and the seam is there twice, once a little larger.
            let ball = |larger: f64| {
                sheet(n, n, |s, t| {
                    let (around, down, r) = (TAU * s, PI * t, if s == 1.0 { 1.0 + larger } else { 1.0 });
                    [r * down.sin() * around.cos(), r * down.sin() * around.sin(), r * down.cos()]
                })
            };
            let is_closed = |arrays: Arrays| {
                let mesh = Mesh::new("tool", arrays.0.clone(), arrays.1.clone()).unwrap();
                let found = outward(arrays);
                let sense = found[1];
                let is_right = |t: u32| found[t as usize] == if mesh.is_queried(t) { sense } else { 0 };
                sense != 0 && (0..found.len() as u32).all(is_right)
            };
            assert_ne!(ball(0.0).0[1], ball(0.0).0[n * (n + 1) + 1], "the seam is one");
            // Larger by rounding only, and by a step of float32.
            assert!(is_closed(ball(0.0)) && is_closed(ball(1e-7)), "{n}");
            assert!(outward(ball(1e-4)).iter().all(|o| *o == 0), "{n}");
        }
    }

    #[test]
    fn seams_are_closed_however_many_corners_are_off() {
        let mut r = Random::new(3);
        let (vertices, faces) = box_mesh([0.0; 3], [1.0, 0.6, 0.8], 1);
        let corners: Vec<Point> = faces.iter().flatten().map(|v| vertices[*v as usize]).collect();
        let loose: Vec<[u32; 3]> = (0..12).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        for far in [0.0, 65e3] {
            for (by, is_closed) in [(1e-16, true), (1e-9, true), (5e-7, true), (3e-3, false)] {
                for share in [0.1, 0.5, 1.0] {
                    let mut moved = |p: &Point| -> Point {
                        let by = if r.real(0.0, 1.0) < share { by } else { 0.0 };
                        p.map(|x| x + far + r.real(-by, by))
                    };
                    let corners = corners.iter().map(&mut moved).collect();
                    let found = outward((corners, loose.clone()));
                    assert!(!is_closed || found.iter().all(|o| *o == 1), "{far} {by} {share}: {found:?}");
                    assert!(is_closed || share < 1.0 || found.contains(&0), "{far} {by} {share}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn triangles_listed_twice_enclose_nothing_more() {
        let (vertices, faces) = box_mesh([0.0; 3], [1.0; 3], 2);
        for count in [1, 5, 24, 47] {
            let twice: Vec<[u32; 3]> = faces.iter().chain(&faces[..count]).map(|[a, b, c]| [*b, *c, *a]).collect();
            let mesh = Mesh::new("tool", vertices.clone(), twice).unwrap();
            let adjacency = Adjacency::of_one_part(&mesh);
            let (once, copies) = adjacency.outward.split_at(faces.len());
            assert!(once.iter().all(|o| *o == 1) && copies.iter().all(|o| *o == 0), "{count}");
            assert!(!adjacency.is_open(0) && adjacency.open_surfaces_of(0).is_empty(), "{count}");
        }
        // All of them are two surfaces in one place.
        let twice = [&faces[..], &faces[..]].concat();
        assert!(outward((vertices, twice)).iter().all(|o| *o == 1));
    }

    #[test]
    fn a_torn_surface_opens_its_part() {
        let at = |x: f64| box_mesh([x, 0.0, 0.0], [1.0; 3], 2);
        let mut torn = at(5.0);
        torn.1.pop();
        for (arrays, is_open) in [
            (joined([at(0.0), torn.clone()]), true),
            (torn, true),
            (joined([at(0.0), at(5.0)]), false),
            // The triangles between them coincide.
            (joined([at(0.0), at(1.0)]), false),
        ] {
            let mesh = Mesh::new("mockup", arrays.0, arrays.1).unwrap();
            let adjacency = Adjacency::of_one_part(&mesh);
            let faces: Vec<u32> = (0..mesh.faces().len() as u32).collect();
            assert_eq!([adjacency.is_open(0), adjacency.of_part(&mesh, 0, &faces).is_open(0)], [is_open; 2]);
        }
    }

    proptest! {
        #[test]
        fn near_points_have_one_number_and_far_ones_their_own(
            places in prop::collection::vec(prop::array::uniform3(-40i32..40), 1..30),
            shifts in prop::collection::vec(prop::array::uniform3(-0.249..0.249f64), 1..60),
        ) {
            // Clusters three units apart, of several points each.
            let place = |i: usize| places[i % places.len()];
            let points: Vec<Point> = (0..).zip(&shifts)
                .map(|(i, shift)| std::array::from_fn(|a| 3.1 * f64::from(place(i)[a]) + shift[a]))
                .collect();
            let numbers = near_points(&points);
            for (i, j) in (0..points.len()).flat_map(|i| (0..i).map(move |j| (i, j))) {
                prop_assert_eq!(numbers[i] == numbers[j], place(i) == place(j), "{} {}", i, j);
            }
        }
    }

    #[test]
    fn inside_out_and_open_surfaces_are_told() {
        let (vertices, mut faces) = box_mesh([0.0; 3], [1.0; 3], 2);
        faces.iter_mut().for_each(|f| f.swap(0, 1));
        let inverted = Mesh::new("tool", vertices.clone(), faces.clone()).unwrap();
        assert!(Adjacency::of_one_part(&inverted).outward.iter().all(|o| *o == -1));
        faces.pop();
        let open = Mesh::new("tool", vertices, faces).unwrap();
        assert!(Adjacency::of_one_part(&open).outward.iter().all(|o| *o == 0));
    }
}
