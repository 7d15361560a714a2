//! Whether a mesh is one closed convex surface.

use crate::geometry::bounds::Point;
use crate::mesh::triangle_mesh::Mesh;
use crate::mesh::weld::weld_vertices;

/// How far a corner may stand out of the plane of the face beside, a share of the mesh's diagonal: as in trimesh. Of a fine mesh whose
/// corners were rounded to float32 many do.
const INWARDS: f64 = 1e-5;

/// Whether all triangles are queried and form one closed surface, wound either way and nowhere bent inwards by more than
/// [`INWARDS`]. Vertices with equal coordinates are one.
pub(super) fn is_convex(mesh: &Mesh) -> bool {
    // By Euler's formula a closed surface without holes has half as many vertices as triangles, plus two. Nearly all
    // other meshes have another number, and need no closer look.
    let count = mesh.faces().len() / 2 + 2;
    if !mesh.excluded().is_empty() || mesh.vertices().len() < count {
        return false;
    }
    let extent = mesh.bounds().extent();
    let diagonal = dot(&extent, &extent).sqrt();
    is_convex_of(mesh.vertices(), mesh.faces(), diagonal, |v| v) || {
        // Vertices are looked up only where some may be there twice: it takes longer than all else.
        if mesh.vertices().len() == count {
            return false;
        }
        let (unique, index) = weld_vertices(mesh.vertices());
        unique.len() < mesh.vertices().len()
            && is_convex_of(mesh.vertices(), mesh.faces(), diagonal, |v| index[v as usize])
    }
}

fn is_convex_of(vertices: &[Point], faces: &[[u32; 3]], diagonal: f64, one: impl Fn(u32) -> u32) -> bool {
    let count = faces.len();
    // Euler again, of the vertices that are used.
    let mut is_used = vec![false; vertices.len()];
    faces.iter().flatten().for_each(|v| is_used[one(*v) as usize] = true);
    if count % 2 == 1 || is_used.iter().filter(|used| **used).count() != count / 2 + 2 {
        return false;
    }
    let mut edges = Vec::with_capacity(3 * count);
    for (face, corners) in faces.iter().enumerate() {
        for i in 0..3 {
            let [a, b] = [one(corners[i]), one(corners[(i + 1) % 3])];
            edges.push(([a.min(b), a.max(b)], a > b, face as u32));
        }
    }
    edges.sort_unstable();
    let volume: f64 = faces.iter().map(|face| six_volumes(vertices, face)).sum();
    let sense = volume.signum();
    let most = INWARDS * diagonal;
    let is_bent_out = |pair: &[([u32; 2], bool, u32)]| {
        let [(edge, is_back, face), (same, is_there, beside)] = [pair[0], pair[1]];
        let [face, beside] = [face, beside].map(|face| &faces[face as usize]);
        edge == same && is_back != is_there && !is_inwards(vertices, face, beside, sense, most)
    };
    // Each edge twice, once in each direction; of more, neighbours in order have the same direction.
    edges.chunks_exact(2).all(is_bent_out) && edges.windows(3).all(|w| w[0].0 != w[2].0) && volume != 0.0
}

/// Whether a corner of a face lies in front of another by more than may be, metres. `sense`: 1 where normals point outwards, else -1.
fn is_inwards(vertices: &[Point], face: &[u32; 3], beside: &[u32; 3], sense: f64, most: f64) -> bool {
    let [a, b, c] = face.map(|v| vertices[v as usize]);
    let (u, v) = (between(&a, &b), between(&a, &c));
    let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = dot(&normal, &normal).sqrt();
    beside.iter().any(|v| {
        let away = between(&a, &vertices[*v as usize]);
        sense * dot(&normal, &away) > most * length
    })
}

/// Six times the signed volume of a face with the first vertex.
fn six_volumes(vertices: &[Point], face: &[u32; 3]) -> f64 {
    let [a, b, c] = face.map(|v| between(&vertices[0], &vertices[v as usize]));
    dot(&a, &[b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]])
}

fn between(p: &Point, q: &Point) -> Point {
    std::array::from_fn(|a| q[a] - p[a])
}

fn dot(p: &Point, q: &Point) -> f64 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}
