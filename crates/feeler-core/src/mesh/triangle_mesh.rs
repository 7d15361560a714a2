//! Triangle meshes as given, with their defects.

use once_cell::race::OnceBox;
use rayon::prelude::*;

use crate::constants::{LARGEST_COORDINATE, SMALL_MESH};
use crate::error::{Error, Result};
use crate::geometry::bounds::{Aabb, Point, Triangle};
use crate::mesh::defects::{corners, is_defective, Defects};
use crate::saved::{check, Reader, Sections};
use feeler_lanes::{prefetch_at, Column};

/// An indexed triangle mesh, metres, as a [`Mockup`](crate::Mockup) or a [`Tool`](crate::Tool) holds it. A triangle's id is its
/// place in the caller's faces.
#[derive(Debug)]
pub struct Mesh {
    vertices: Column<Point>,
    faces: Column<[u32; 3]>,
    /// Ids of all triangles that are not queried, sorted.
    excluded: Vec<u32>,
    /// Of a mesh with parts moved found when first asked for.
    defects: OnceBox<Defects>,
    what: &'static str,
    bounds: Aabb,
}

fn found(defects: Defects) -> OnceBox<Defects> {
    OnceBox::with_value(Box::new(defects))
}

impl Mesh {
    /// Takes the arrays as they are and looks for defects. `what` names the mesh in messages.
    ///
    /// Errors: no triangle at all, none that can be queried, or more than 32-bit ids can name.
    pub(crate) fn new(what: &'static str, vertices: Vec<Point>, faces: Vec<[u32; 3]>) -> Result<Mesh> {
        if faces.is_empty() {
            return Err(Error::EmptyMesh { what });
        }
        for (what, count) in [("vertices", vertices.len()), ("triangles", faces.len())] {
            if count as u64 > u64::from(u32::MAX) {
                return Err(Error::TooMany { what, count: count as u64, limit: u64::from(u32::MAX) });
            }
        }
        let defects = Defects::find(&vertices, &faces);
        if defects.excluded.len() == faces.len() {
            return Err(Error::NothingToQuery { what, triangles: faces.len(), defects: defects.summary() });
        }
        let (vertices, faces, excluded) = (vertices.into(), faces.into(), defects.excluded.clone());
        let mut mesh = Mesh { vertices, faces, excluded, defects: found(defects), what, bounds: Aabb::EMPTY };
        let with = |b: Aabb, t: u32| b.union(&Aabb::of_triangle(&mesh.triangle(t)));
        mesh.bounds = if mesh.faces.len() < SMALL_MESH {
            mesh.queried().fold(Aabb::EMPTY, with)
        } else {
            mesh.par_queried().fold(|| Aabb::EMPTY, with).reduce(|| Aabb::EMPTY, |a, b| a.union(&b))
        };
        Ok(mesh)
    }

    /// Of triangles that can all be queried.
    pub(crate) fn of_checked(vertices: Vec<Point>, faces: Vec<[u32; 3]>) -> Mesh {
        let mut bounds = Aabb::EMPTY;
        faces.iter().flatten().for_each(|v| bounds.grow(&vertices[*v as usize]));
        let (vertices, faces, defects) = (vertices.into(), faces.into(), found(Defects::default()));
        Mesh { vertices, faces, excluded: Vec::new(), defects, what: "mesh", bounds }
    }

    /// The same triangles with other vertices, as many; [`without_defects_of`](Self::without_defects_of) and
    /// [`with_bounds`](Self::with_bounds) must follow.
    pub(crate) fn with_vertices(&self, vertices: Vec<Point>) -> Mesh {
        self.with_columns(vertices.into(), self.faces.clone())
    }

    /// The same with other arrays, as [`with_vertices`](Self::with_vertices).
    pub(crate) fn with_arrays(&self, vertices: Vec<Point>, faces: Vec<[u32; 3]>) -> Mesh {
        self.with_columns(vertices.into(), faces.into())
    }

    fn with_columns(&self, vertices: Column<Point>, faces: Column<[u32; 3]>) -> Mesh {
        let Mesh { excluded, what, bounds, .. } = self;
        Mesh { vertices, faces, excluded: excluded.clone(), defects: OnceBox::new(), what, bounds: *bounds }
    }

    /// The mesh without those of some queried triangles (ascending) that cannot be queried, and the others of them. An error where
    /// there is nothing left.
    pub(crate) fn without_defects_of(mut self, asked: &[u32]) -> Result<(Mesh, Vec<u32>)> {
        let is_bad = |t: &u32| is_defective(&self.vertices, &self.faces[*t as usize]);
        let (bad, good): (Vec<u32>, Vec<u32>) = asked.iter().partition(|t| is_bad(t));
        if !bad.is_empty() {
            self.excluded.extend(bad);
            self.excluded.sort_unstable();
            if self.queried_count() == 0 {
                let (what, triangles, defects) = (self.what, self.faces.len(), self.defects().summary());
                return Err(Error::NothingToQuery { what, triangles, defects });
            }
        }
        Ok((self, good))
    }

    /// The mesh with the box around all its queried triangles.
    pub(crate) fn with_bounds(self, bounds: Aabb) -> Mesh {
        Mesh { bounds, ..self }
    }

    /// The vertices, where nobody else has them.
    pub(crate) fn take_vertices(&mut self) -> Option<Vec<Point>> {
        std::mem::take(&mut self.vertices).into_vec()
    }

    /// Adds it to the sections of a saved scene.
    pub(crate) fn save<'a>(&'a self, sections: &mut Sections<'a>) {
        sections.add("mesh.vertices", &self.vertices);
        sections.add("mesh.faces", &self.faces);
        sections.add_made("mesh.bounds", &[self.bounds]);
        self.defects().save(sections);
    }

    /// From the sections of a saved scene.
    pub(crate) fn of_saved(saved: Reader<'_>) -> Result<Mesh> {
        let (vertices, faces) = (saved.column::<Point>("mesh.vertices")?, saved.column::<[u32; 3]>("mesh.faces")?);
        let count = |what: &str, count: usize| check(u32::try_from(count).is_ok(), || format!("{what}: too many"));
        count("mesh.vertices", vertices.len())?;
        count("mesh.faces", faces.len())?;
        let defects = Defects::of_saved(saved, faces.len())?;
        let (excluded, bounds) = (defects.excluded.clone(), saved.one("mesh.bounds")?);
        let mesh = Mesh { vertices, faces, excluded, defects: found(defects), what: "mock-up", bounds };
        if saved.is_checked {
            let is_there = |face: &[u32; 3]| face.iter().all(|v| (*v as usize) < mesh.vertices.len());
            let is_inside = |t: u32| mesh.triangle(t).iter().all(|p| mesh.bounds.contains(p));
            let is_right = |t: u32| is_there(&mesh.faces[t as usize]) && is_inside(t);
            check(mesh.par_queried().all(is_right), || "mesh.faces: a corner is not there, or outside the box".into())?;
            check(mesh.bounds.largest_coordinate() <= LARGEST_COORDINATE, || "mesh.bounds".into())?;
        }
        Ok(mesh)
    }

    /// The vertices given.
    pub fn vertices(&self) -> &[Point] {
        &self.vertices
    }

    /// The faces given.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// The defects of the mesh.
    pub fn defects(&self) -> &Defects {
        self.defects.get_or_init(|| Box::new(Defects::find_beside(&self.vertices, &self.faces, &self.excluded)))
    }

    /// Ids of all triangles that are not queried, sorted.
    pub(crate) fn excluded(&self) -> &[u32] {
        &self.excluded
    }

    /// The box around all queried triangles.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The corners of a triangle that is queried; panics or gives something else for others.
    #[inline]
    pub fn triangle(&self, id: u32) -> Triangle {
        corners(&self.vertices, &self.faces[id as usize])
    }

    /// Faces and vertices.
    pub(crate) fn corners(&self) -> Corners<'_> {
        Corners { faces: &self.faces, vertices: &self.vertices }
    }

    /// The first corner of such a triangle.
    #[inline]
    #[doc(hidden)]
    pub fn corner(&self, id: u32) -> Point {
        self.vertices[self.faces[id as usize][0] as usize]
    }

    /// Number of triangles that are queried.
    pub fn queried_count(&self) -> usize {
        self.faces.len() - self.excluded.len()
    }

    /// Whether a triangle is queried.
    pub fn is_queried(&self, id: u32) -> bool {
        self.excluded.binary_search(&id).is_err()
    }

    /// Ids of the queried triangles, ascending.
    pub fn queried(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.faces.len() as u32).filter(|id| self.is_queried(*id))
    }

    /// The same, in parallel.
    pub(crate) fn par_queried(&self) -> impl ParallelIterator<Item = u32> + '_ {
        (0..self.faces.len() as u32).into_par_iter().filter(|id| self.is_queried(*id))
    }

    /// Bytes held by the vertex and face arrays.
    pub(crate) fn memory(&self) -> usize {
        self.vertices.memory() + self.faces.memory() + self.excluded.capacity() * size_of::<u32>()
    }
}

/// Faces, and the places of their vertices: a mesh's own, or where it is placed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Corners<'a> {
    pub faces: &'a [[u32; 3]],
    pub vertices: &'a [Point],
}

impl Corners<'_> {
    /// As [`Mesh::triangle`].
    #[inline]
    pub(crate) fn triangle(&self, id: u32) -> Triangle {
        corners(self.vertices, &self.faces[id as usize])
    }
}

/// Asks for the corners of a face whose indices are in range, before they are needed.
#[inline(always)]
pub(crate) fn prefetch_corners(vertices: &[Point], face: &[u32; 3]) {
    face.iter().for_each(|v| prefetch_at(vertices, *v as usize));
}
