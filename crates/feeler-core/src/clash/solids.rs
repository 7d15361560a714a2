//! The parts of a mock-up one by one: their triangles, their connectivity, and their insides; each computed on demand.

use feeler_lanes::mixed;
use once_cell::race::OnceBox;

use super::gap_filling::fillings;
use crate::error::Result;
use crate::geometry::bounds::{Aabb, Point, Triangle};
use crate::mesh::mockup::Mockup;
use crate::mesh::topology::adjacency::Adjacency;
use crate::mesh::topology::closed_shells::ClosedShell;
use crate::mesh::topology::disjoint_sets::DisjointSets;
use crate::mesh::triangle_mesh::Mesh;
use crate::tool::moving_tool::Tool;

/// Corners of a connected surface that are kept.
const MOST_CORNERS: usize = 6;

/// The triangles of each part that can be queried.
#[derive(Debug)]
pub struct PartFaces {
    starts: Vec<u32>,
    faces: Vec<u32>,
}

impl PartFaces {
    /// Of all parts.
    pub fn new(mockup: &Mockup) -> PartFaces {
        let mut starts = vec![0u32; mockup.part_bounds().len() + 1];
        for face in mockup.mesh().queried() {
            starts[mockup.part_of_face(face) as usize + 1] += 1;
        }
        for part in 1..starts.len() {
            starts[part] += starts[part - 1];
        }
        let mut faces = vec![0; starts[starts.len() - 1] as usize];
        let mut next = starts.clone();
        for face in mockup.mesh().queried() {
            let at = &mut next[mockup.part_of_face(face) as usize];
            faces[*at as usize] = face;
            *at += 1;
        }
        PartFaces { starts, faces }
    }

    /// Those of one part, ascending.
    pub fn of(&self, part: u32) -> &[u32] {
        &self.faces[self.starts[part as usize] as usize..self.starts[part as usize + 1] as usize]
    }
}

/// Vertices and faces of one part alone, in the order of its faces.
fn arrays_of(mesh: &Mesh, faces: &[u32]) -> (Vec<Point>, Vec<[u32; 3]>) {
    let mut used: Vec<u32> = faces.iter().flat_map(|face| mesh.faces()[*face as usize]).collect();
    used.sort_unstable();
    used.dedup();
    let place = |vertex: u32| used.partition_point(|v| *v < vertex) as u32;
    let own = faces.iter().map(|face| mesh.faces()[*face as usize].map(place)).collect();
    (used.iter().map(|vertex| mesh.vertices()[*vertex as usize]).collect(), own)
}

/// One part: its triangles by their own numbers, in which its adjacency has them.
#[derive(Debug, Clone, Copy)]
pub struct Solid<'a> {
    mockup: &'a Mockup,
    part: u32,
    faces: &'a [u32],
    adjacency: &'a Adjacency,
    /// Whether that is the whole mock-up's, and own numbers are the mock-up's.
    is_whole: bool,
}

impl<'a> Solid<'a> {
    /// The own number of one of the mock-up's triangles, of this part.
    pub fn own(&self, face: u32) -> u32 {
        if self.is_whole {
            face
        } else {
            self.faces.partition_point(|f| *f < face) as u32
        }
    }

    fn face(&self, own: u32) -> u32 {
        if self.is_whole {
            own
        } else {
            self.faces[own as usize]
        }
    }

    /// The corners of a triangle, by its own number.
    pub fn triangle(&self, own: u32) -> Triangle {
        self.mockup.mesh().triangle(self.face(own))
    }

    /// The own numbers of all its triangles.
    pub fn triangles(&self) -> impl Iterator<Item = u32> + Clone + 'a {
        let is_whole = self.is_whole;
        self.faces.iter().zip(0..).map(move |(face, own)| if is_whole { *face } else { own })
    }

    /// How its triangles hang together, by their own numbers.
    pub fn adjacency(&self) -> &'a Adjacency {
        self.adjacency
    }

    fn number(&self) -> u32 {
        if self.is_whole {
            self.part
        } else {
            0
        }
    }

    /// Its closed surfaces; the first triangle of each by its own number.
    pub fn shells(&self) -> &'a [ClosedShell] {
        self.adjacency.shells_of(self.number())
    }

    /// Whether it has an inside.
    pub fn is_closed(&self) -> bool {
        !self.shells().is_empty()
    }

    /// The first triangle of each of its open surfaces, by its own number.
    pub fn open_surfaces(&self) -> impl Iterator<Item = u32> + Clone + 'a {
        self.adjacency.open_surfaces_of(self.number()).iter().map(|[_, own]| *own)
    }

    fn fillings(&self) -> Vec<Triangle> {
        if !self.adjacency.is_loose() {
            return Vec::new();
        }
        let outward = self.triangles().filter_map(|own| self.adjacency.wound_outward(own, self.triangle(own)));
        fillings(&outward.collect::<Vec<_>>())
    }

    /// A corner of each of its connected surfaces.
    pub fn corners_of_surfaces(&self) -> impl Iterator<Item = Point> + 'a {
        let solid = *self;
        let closed = self.shells().iter().map(|shell| shell.first);
        self.open_surfaces().chain(closed).map(move |own| solid.triangle(own)[0])
    }
}

/// The parts of a mock-up.
#[derive(Debug)]
pub struct Solids<'a> {
    mockup: &'a Mockup,
    faces: PartFaces,
    adjacencies: Vec<OnceBox<Adjacency>>,
    cycles: Vec<OnceBox<bool>>,
    fillings: Vec<OnceBox<Vec<Triangle>>>,
}

impl<'a> Solids<'a> {
    /// Of a mock-up.
    pub fn new(mockup: &'a Mockup) -> Solids<'a> {
        let adjacencies = mockup.part_bounds().iter().map(|_| OnceBox::new()).collect();
        let cycles = mockup.part_bounds().iter().map(|_| OnceBox::new()).collect();
        let fillings = mockup.part_bounds().iter().map(|_| OnceBox::new()).collect();
        Solids { mockup, faces: PartFaces::new(mockup), adjacencies, cycles, fillings }
    }

    /// Whether each edge of a part is run along as often in one sense as in the other, so that all of its surfaces are closed: by sums of
    /// hashes, in a pass over its triangles. A part that is closed but for cracks, or not wound in one sense, is none.
    pub fn is_cycle(&self, part: u32) -> bool {
        *self.cycles[part as usize].get_or_init(|| {
            let mesh = self.mockup.mesh();
            let sum = self.faces(part).iter().fold(0u64, |sum, face| {
                let [a, b, c] = mesh.triangle(*face).map(|corner| hash_all(&corner));
                [(a, b), (b, c), (c, a)].into_iter().fold(sum, |sum, (p, q)| {
                    let edge = mixed(p.min(q) ^ mixed(p.max(q)));
                    if p < q {
                        sum.wrapping_add(edge)
                    } else {
                        sum.wrapping_sub(edge)
                    }
                })
            });
            Box::new(sum == 0)
        })
    }

    /// The triangles that fill the gaps of a part's closed surfaces, in seams and cracks, wound outwards.
    pub fn fillings(&self, part: u32) -> &[Triangle] {
        if self.is_cycle(part) {
            return &[];
        }
        self.fillings[part as usize].get_or_init(|| Box::new(self.of(part).fillings()))
    }

    /// The mock-up.
    pub fn mockup(&self) -> &'a Mockup {
        self.mockup
    }

    /// A part that has triangles that can be queried. Where the adjacency of the whole mock-up is found, that is used.
    pub fn of(&self, part: u32) -> Solid<'_> {
        let (mockup, mesh, faces) = (self.mockup, self.mockup.mesh(), self.faces.of(part));
        if mockup.has_adjacency() {
            return Solid { mockup, part, faces, adjacency: mockup.adjacency(), is_whole: true };
        }
        let adjacency = self.adjacencies[part as usize].get_or_init(|| {
            let (vertices, own) = arrays_of(mesh, faces);
            Box::new(Adjacency::of_surfaces(&Mesh::of_checked(vertices, own)))
        });
        Solid { mockup, part, faces, adjacency, is_whole: false }
    }

    /// A part as a tool, where it is.
    pub fn tool(&self, part: u32) -> Result<Tool> {
        let (vertices, faces) = arrays_of(self.mockup.mesh(), self.faces.of(part));
        let tool = Tool::new(vertices, faces)?;
        if self.mockup.has_adjacency() {
            tool.take_adjacency(self.mockup.adjacency().of_part(tool.mesh(), part, self.faces.of(part)));
        }
        Ok(tool)
    }

    /// The triangles of a part that can be queried, ascending.
    pub fn faces(&self, part: u32) -> &[u32] {
        self.faces.of(part)
    }
}

/// A connected surface of a part: triangles that share corners, with equal coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct ConnectedSurface {
    /// Some of its corners, far apart; one at least if it has any.
    pub corners: Vec<Point>,
    /// The box around it.
    pub bounds: Aabb,
}

impl Default for ConnectedSurface {
    fn default() -> ConnectedSurface {
        ConnectedSurface { corners: Vec::new(), bounds: Aabb::EMPTY }
    }
}

impl ConnectedSurface {
    /// Grows by a corner. Of those that the box grew by, the last ones stay.
    pub fn add(&mut self, corner: &Point) {
        if self.bounds.is_overlapping(&Aabb { lower: *corner, upper: *corner }) {
            return;
        }
        self.bounds.grow(corner);
        if self.corners.len() == MOST_CORNERS {
            self.corners.remove(1);
        }
        self.corners.push(*corner);
    }
}

/// The connected surfaces of some triangles.
pub fn connected_surfaces(mesh: &Mesh, faces: &[u32]) -> Vec<ConnectedSurface> {
    let (sets, mut found) = (sets_by_corners(mesh, faces), Vec::new());
    let mut places = vec![u32::MAX; faces.len()];
    for (i, face) in faces.iter().enumerate() {
        let triangle = mesh.triangle(*face);
        let place = &mut places[sets[i] as usize];
        if *place == u32::MAX {
            *place = found.len() as u32;
            found.push(ConnectedSurface::default());
        }
        let surface = &mut found[*place as usize];
        for corner in &triangle {
            surface.add(corner);
        }
    }
    found
}

/// For each triangle the first one that it hangs together with over corners of equal coordinates.
fn sets_by_corners(mesh: &Mesh, faces: &[u32]) -> Vec<u32> {
    let mut sets = DisjointSets((0..faces.len() as u32).collect());
    // Open addressing by coordinates: for each corner the first triangle that has it, and as which of its three.
    let corner =
        |entry: u32| mesh.vertices()[mesh.faces()[faces[entry as usize / 3] as usize][entry as usize % 3] as usize];
    let slots = (4 * faces.len().max(1)).next_power_of_two();
    let mut table = vec![u32::MAX; slots];
    for entry in 0..3 * faces.len() as u32 {
        let own = corner(entry);
        let mut at = hash(&own) as usize & (slots - 1);
        while table[at] != u32::MAX && corner(table[at]) != own {
            at = (at + 1) & (slots - 1);
        }
        if table[at] == u32::MAX {
            table[at] = entry;
        } else {
            sets.join(table[at] / 3, entry / 3);
        }
    }
    sets.flatten();
    sets.0
}

fn hash(p: &Point) -> u64 {
    hash_all(p) >> 20
}

fn hash_all(p: &Point) -> u64 {
    p.iter().fold(0u64, |sum, x| {
        // 0.0 and -0.0 are one.
        (sum.rotate_left(21) ^ (x + 0.0).to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15)
    })
}
