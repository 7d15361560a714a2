//! The parts of a mock-up one by one: their triangles, how these hang together, and their insides; each found when first needed.

use once_cell::race::OnceBox;

use crate::geometry::bounds::{Aabb, Point, Triangle};
use crate::mesh::mockup::Mockup;
use crate::mesh::topology::adjacency::Adjacency;
use crate::mesh::topology::disjoint_sets::DisjointSets;
use crate::mesh::triangle_mesh::Mesh;

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
pub fn arrays_of(mesh: &Mesh, faces: &[u32]) -> (Vec<Point>, Vec<[u32; 3]>) {
    let mut used: Vec<u32> = faces.iter().flat_map(|face| mesh.faces()[*face as usize]).collect();
    used.sort_unstable();
    used.dedup();
    let place = |vertex: u32| used.partition_point(|v| *v < vertex) as u32;
    let own = faces.iter().map(|face| mesh.faces()[*face as usize].map(place)).collect();
    (used.iter().map(|vertex| mesh.vertices()[*vertex as usize]).collect(), own)
}

/// One part: triangle `i` is the mock-up's `faces[i]`.
#[derive(Debug, Clone, Copy)]
pub struct Solid<'a> {
    mockup: &'a Mockup,
    faces: &'a [u32],
    adjacency: &'a Adjacency,
}

impl Solid<'_> {
    /// The corners of a triangle, by its own number.
    pub fn triangle(&self, own: u32) -> Triangle {
        self.mockup.mesh().triangle(self.faces[own as usize])
    }

    /// The own number of one of the mock-up's triangles, of this part.
    pub fn own(&self, face: u32) -> u32 {
        self.faces.partition_point(|f| *f < face) as u32
    }

    /// How many triangles it has.
    pub fn len(&self) -> usize {
        self.faces.len()
    }

    /// How its triangles hang together, by their own numbers.
    pub fn adjacency(&self) -> &Adjacency {
        self.adjacency
    }

    /// Whether it has an inside.
    pub fn is_closed(&self) -> bool {
        !self.adjacency.shells_of(0).is_empty()
    }
}

/// The parts of a mock-up.
#[derive(Debug)]
pub struct Solids<'a> {
    mockup: &'a Mockup,
    faces: PartFaces,
    adjacencies: Vec<OnceBox<Adjacency>>,
}

impl<'a> Solids<'a> {
    /// Of a mock-up.
    pub fn new(mockup: &'a Mockup) -> Solids<'a> {
        let adjacencies = mockup.part_bounds().iter().map(|_| OnceBox::new()).collect();
        Solids { mockup, faces: PartFaces::new(mockup), adjacencies }
    }

    /// The mock-up.
    pub fn mockup(&self) -> &'a Mockup {
        self.mockup
    }

    /// A part that has triangles that can be queried.
    pub fn of(&self, part: u32) -> Solid<'_> {
        let (mesh, faces) = (self.mockup.mesh(), self.faces.of(part));
        let adjacency = self.adjacencies[part as usize].get_or_init(|| {
            let (vertices, own) = arrays_of(mesh, faces);
            Box::new(Adjacency::of_one_part(&Mesh::of_checked(vertices, own)))
        });
        Solid { mockup: self.mockup, faces, adjacency }
    }

    /// The triangles of a part that can be queried, ascending.
    pub fn faces(&self, part: u32) -> &[u32] {
        self.faces.of(part)
    }
}

/// A connected surface of a part: triangles that share corners, with equal coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConnectedSurface {
    /// One of its corners.
    pub corner: Point,
    /// The box around it.
    pub bounds: Aabb,
}

/// The connected surfaces of some triangles.
pub fn connected_surfaces(mesh: &Mesh, faces: &[u32]) -> Vec<ConnectedSurface> {
    let (sets, mut found) = (sets_by_corners(faces.iter().map(|face| mesh.triangle(*face))), Vec::new());
    let mut places = vec![u32::MAX; faces.len()];
    for (i, face) in faces.iter().enumerate() {
        let triangle = mesh.triangle(*face);
        let place = &mut places[sets[i] as usize];
        if *place == u32::MAX {
            *place = found.len() as u32;
            found.push(ConnectedSurface { corner: triangle[0], bounds: Aabb::EMPTY });
        }
        let bounds = &mut found[*place as usize].bounds;
        triangle.iter().for_each(|corner| bounds.grow(corner));
    }
    found
}

/// For each triangle the first one that it hangs together with over corners of equal coordinates.
pub fn sets_by_corners(triangles: impl ExactSizeIterator<Item = Triangle>) -> Vec<u32> {
    let count = triangles.len();
    let mut sets = DisjointSets((0..count as u32).collect());
    // Open addressing by coordinates: each slot the first triangle with a corner there, and the corner.
    let slots = (6 * count.max(1)).next_power_of_two();
    let mut table: Vec<(u32, Point)> = vec![(u32::MAX, [0.0; 3]); slots];
    for (i, triangle) in (0..).zip(triangles) {
        for corner in triangle {
            let mut at = hash(&corner) as usize & (slots - 1);
            loop {
                let slot = &mut table[at];
                if slot.0 == u32::MAX {
                    *slot = (i, corner);
                    break;
                }
                if slot.1 == corner {
                    sets.join(slot.0, i);
                    break;
                }
                at = (at + 1) & (slots - 1);
            }
        }
    }
    sets.flatten();
    sets.0
}

fn hash(p: &Point) -> u64 {
    let mixed = p.iter().fold(0u64, |sum, x| {
        // 0.0 and -0.0 are one.
        (sum.rotate_left(21) ^ (x + 0.0).to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15)
    });
    mixed >> 20
}
