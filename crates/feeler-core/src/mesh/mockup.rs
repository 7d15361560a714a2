//! A static mock-up.

use std::sync::Arc;

use feeler_lanes::{prefetch_at, Column};
use once_cell::race::OnceBox;
use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::bounds::{Aabb, Point};
use crate::geometry::pose::Pose;
use crate::mesh::moved::{self, MovedOfThis, Rest};
use crate::mesh::part_numbers::check_parts;
use crate::mesh::topology::adjacency::Adjacency;
use crate::mesh::topology::body_outlines::BodyOutlines;
use crate::mesh::triangle_mesh::Mesh;
use crate::saved::{check, Reader, Sections};

/// A static mock-up: one mesh made of parts.
#[derive(Debug)]
pub struct Mockup {
    mesh: Mesh,
    part_of_face: Column<u32>,
    part_bounds: Vec<Aabb>,
    part_triangles: Vec<u32>,
    /// Made at first use, by every thread that needs it meanwhile: waiting for another thread would never end in a forked
    /// process, which lacks that thread.
    adjacency: OnceBox<Adjacency>,
    outlines: BodyOutlines,
    for_moved: MovedOfThis,
    /// Where some parts are moved.
    rest: Option<Rest>,
}

impl Mockup {
    /// Checks the arrays: vertices in metres, world; faces as places among them. `part_of_face` gives each triangle's part, 0 to
    /// `parts - 1`; empty means that all belong to part 0.
    ///
    /// Errors: no triangle at all, none that can be queried, more than 2^32 - 1 triangles, vertices or parts, no part, and a
    /// `part_of_face` of another length or with a part that is not there. Other defects are listed in [`Mesh::defects`].
    pub fn new(vertices: Vec<Point>, faces: Vec<[u32; 3]>, part_of_face: Vec<u32>, parts: usize) -> Result<Mockup> {
        check_parts(&part_of_face, faces.len(), parts)?;
        let mesh = Mesh::new("mock-up", vertices, faces)?;
        let mut part_bounds = vec![Aabb::EMPTY; parts];
        let mut part_triangles = vec![0; parts];
        for face in 0..mesh.faces().len() {
            part_triangles[part_of_face.get(face).map_or(0, |p| *p as usize)] += 1;
        }
        for face in mesh.queried() {
            let b = &mut part_bounds[part_of_face.get(face as usize).map_or(0, |p| *p as usize)];
            for corner in mesh.triangle(face) {
                b.grow(&corner);
            }
        }
        Ok(Mockup {
            mesh,
            part_of_face: part_of_face.into(),
            part_bounds,
            part_triangles,
            adjacency: OnceBox::new(),
            outlines: BodyOutlines::default(),
            for_moved: MovedOfThis::default(),
            rest: None,
        })
    }

    /// Adds it to the sections of a saved scene, with what the first queries need: the connectivity of the triangles.
    pub(crate) fn save<'a>(&'a self, sections: &mut Sections<'a>) {
        self.mesh.save(sections);
        sections.add("parts.of_face", &self.part_of_face);
        sections.add("parts.bounds", &self.part_bounds);
        sections.add("parts.triangles", &self.part_triangles);
        self.adjacency().save(sections);
    }

    /// From the sections of a saved scene.
    pub(crate) fn of_saved(saved: Reader<'_>) -> Result<Mockup> {
        let mesh = Mesh::of_saved(saved)?;
        let part_bounds = saved.column("parts.bounds")?.to_vec();
        let part_triangles = saved.column_of("parts.triangles", part_bounds.len())?.to_vec();
        let part_of_face: Column<u32> = saved.column("parts.of_face")?;
        if saved.is_checked {
            check(part_of_face.is_empty() || part_of_face.len() == mesh.faces().len(), || "parts.of_face".into())?;
            let parts = part_bounds.len();
            check(parts > 0 && part_of_face.par_iter().all(|part| (*part as usize) < parts), || {
                "parts.of_face".into()
            })?;
        }
        let adjacency = Adjacency::of_saved(saved, &mesh, part_bounds.len())?;
        let found = OnceBox::new();
        let _ = found.set(Box::new(adjacency));
        Ok(Mockup {
            mesh,
            part_of_face,
            part_bounds,
            part_triangles,
            adjacency: found,
            outlines: BodyOutlines::default(),
            for_moved: MovedOfThis::default(),
            rest: None,
        })
    }

    /// The mock-up with parts at other places: by part the number of its pose among `poses`, which counts from where the parts are
    /// modelled, also where this mock-up has some moved; `None` leaves a part there, and so does a list that ends before it. Triangles
    /// and parts keep their numbers, and what stays is shared.
    ///
    /// Vertices that a moved part shares with others get copies, behind the rest. Triangles without area stay without. Errors: nothing
    /// left that can be queried, or more vertices than 32 bits can number.
    ///
    /// ```
    /// # use feeler_core::*;
    /// # let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// let mockup = std::sync::Arc::new(Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![0, 1], 2)?);
    /// let up = Pose::IDENTITY.translated(&[0.0, 0.0, 0.5])?;
    /// let moved = Mockup::moved(&mockup, &[None, Some(0)], &[up])?;
    /// assert_eq!(moved.mesh().triangle(1)[1], [1.0, 1.0, 0.5]);
    /// assert_eq!(moved.mesh().triangle(0), mockup.mesh().triangle(0));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn moved(this: &Arc<Mockup>, pose_of_part: &[Option<u32>], poses: &[Pose]) -> Result<Mockup> {
        moved::moved(this.modelled(), pose_of_part, poses)
    }

    /// With all parts where they are modelled.
    pub(crate) fn modelled(self: &Arc<Mockup>) -> &Arc<Mockup> {
        self.rest.as_ref().map_or(self, |rest| &rest.mockup)
    }

    /// What it knows of its moved parts; `None` where it has none.
    pub(crate) fn rest(&self) -> Option<&Rest> {
        self.rest.as_ref()
    }

    /// What it keeps for those with parts moved.
    pub(crate) fn for_moved(&self) -> &MovedOfThis {
        &self.for_moved
    }

    /// The same parts with other places.
    pub(crate) fn with_moved(&self, mesh: Mesh, part_bounds: Vec<Aabb>, rest: Rest) -> Mockup {
        Mockup {
            mesh,
            part_of_face: self.part_of_face.clone(),
            part_bounds,
            part_triangles: self.part_triangles.clone(),
            adjacency: OnceBox::new(),
            outlines: BodyOutlines::default(),
            for_moved: MovedOfThis::default(),
            rest: Some(rest),
        }
    }

    /// The triangles.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The part a triangle belongs to.
    #[inline]
    pub fn part_of_face(&self, face: u32) -> u32 {
        self.part_of_face.get(face as usize).copied().unwrap_or(0)
    }

    /// The part of each triangle; empty where all belong to part 0.
    pub(crate) fn parts_of_faces(&self) -> &[u32] {
        &self.part_of_face
    }

    /// Prefetches the data of [`part_of_face`](Self::part_of_face).
    #[inline]
    #[doc(hidden)]
    pub fn prefetch_part(&self, face: u32) {
        prefetch_at(&self.part_of_face, face as usize);
    }

    /// The box around the queried triangles of each part; empty where a part has none.
    pub fn part_bounds(&self) -> &[Aabb] {
        &self.part_bounds
    }

    /// Bytes held by the arrays that say which triangle belongs to which part.
    pub(crate) fn parts_memory(&self) -> usize {
        self.part_of_face.memory()
            + self.part_bounds.capacity() * size_of::<Aabb>()
            + self.part_triangles.capacity() * size_of::<u32>()
    }

    /// Which triangles share edges, within each part; found when first asked for, in parallel on the current rayon pool. Threads that
    /// ask before it is found each find it.
    #[doc(hidden)]
    pub fn adjacency(&self) -> &Adjacency {
        let part = |face| self.part_of_face(face);
        self.adjacency.get_or_init(|| {
            Box::new(match &self.rest {
                // What moves as a whole hangs together as before.
                Some(rest) if rest.are_all_queried() => {
                    let is_moved = |part: u32| rest.is_moved[part as usize];
                    rest.mockup.adjacency().moved((&self.mesh, &self.part_bounds), is_moved)
                }
                _ => Adjacency::new(&self.mesh, part, &self.part_bounds),
            })
        })
    }

    /// Whether [`adjacency`](Self::adjacency) is found.
    #[doc(hidden)]
    pub fn has_adjacency(&self) -> bool {
        self.adjacency.get().is_some()
    }

    /// The points that span the convex body of a triangle, found when first asked for.
    #[doc(hidden)]
    pub fn body_outline(&self, triangle: u32) -> Arc<[Point]> {
        self.outlines.of(&self.mesh, self.adjacency(), triangle)
    }

    /// Bytes of the connectivity of the triangles; `None` before its first use.
    pub(crate) fn topology_memory(&self) -> Option<usize> {
        self.adjacency.get().map(Adjacency::memory)
    }

    /// Number of triangles of each part, defective ones included.
    pub fn part_triangles(&self) -> &[u32] {
        &self.part_triangles
    }
}

impl Drop for Mockup {
    fn drop(&mut self) {
        if let Some(rest) = &mut self.rest {
            rest.take_back(self.mesh.take_vertices());
        }
    }
}
