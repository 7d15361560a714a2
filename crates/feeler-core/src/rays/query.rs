//! The first triangle that a ray hits in a scene.

use std::cmp::Ordering;

use rayon::prelude::*;

use super::meeting::{meet, ratio, Meeting};
use super::ray::{HalfSpace, Ray, RayHit};
use super::span::Span;
use crate::constants::{RAY_LIMIT_ROUNDING, VANISHING};
use crate::distance::query::check_distance;
use crate::error::Result;
use crate::geometry::vectors::{along, any_length, normal, scaled};
use crate::index::mockup_index::Index;
use crate::index::ray_search::{RayPath, RayScratch};
use crate::index::selection::Selection;
use crate::index::sink::RaySink;
use crate::mesh::mockup::Mockup;
use crate::mesh::triangle_mesh::prefetch_corners;
use crate::scratch_pool::ScratchPool;

/// Rays a task handles at a time.
const RAYS_TASK: usize = 16;

/// The first triangle that a ray hits within `max` (metres) and the intersection of all sections.
pub fn first(
    index: &Index,
    ray: &Ray,
    max: f64,
    sections: &[HalfSpace],
    scratch: &mut RayScratch,
) -> Result<Option<RayHit>> {
    check(std::slice::from_ref(ray), max, sections)?;
    Ok(find(index, ray, max, sections, scratch))
}

/// The same of many rays, in parallel on the current rayon pool.
pub fn firsts(
    index: &Index,
    pool: &ScratchPool<RayScratch>,
    rays: &[Ray],
    max: f64,
    sections: &[HalfSpace],
) -> Result<Vec<Option<RayHit>>> {
    check(rays, max, sections)?;
    let mut found = vec![None; rays.len()];
    rays.par_chunks(RAYS_TASK).zip(found.par_chunks_mut(RAYS_TASK)).for_each(|(rays, found)| {
        pool.with(|scratch| {
            for (ray, found) in rays.iter().zip(found) {
                *found = find(index, ray, max, sections, scratch);
            }
        });
    });
    Ok(found)
}

/// Errors: see [`Scene::rays`](crate::Scene::rays).
pub(super) fn check(rays: &[Ray], max: f64, sections: &[HalfSpace]) -> Result<()> {
    check_distance("max", max)?;
    sections.iter().enumerate().try_for_each(|(i, section)| section.check(i))?;
    rays.iter().enumerate().try_for_each(|(i, ray)| ray.check(i))
}

fn find(index: &Index, ray: &Ray, max: f64, sections: &[HalfSpace], scratch: &mut RayScratch) -> Option<RayHit> {
    let span = Span::new(ray, sections)?;
    let mut first = First::new(index.mockup(), index.selection(), ray, &span, max);
    let from = span.from.t * (1.0 - RAY_LIMIT_ROUNDING);
    for (store, selection) in index.stores() {
        first.selection = selection;
        let path = RayPath { origin: ray.origin, direction: ray.direction, from, selection, lanes: index.lanes() };
        store.search_ray(index.mockup().mesh(), &path, scratch, &mut first);
    }
    first.hit()
}

/// The first triangle met so far.
pub(super) struct First<'a> {
    mockup: &'a Mockup,
    selection: &'a Selection,
    ray: &'a Ray,
    span: &'a Span,
    max: f64,
    /// Of the direction, metres.
    length: f64,
    /// Where along the ray nothing is of interest any more, rounded up.
    limit: f64,
    best: Option<(Meeting, u32)>,
}

impl<'a> First<'a> {
    pub fn new(mockup: &'a Mockup, selection: &'a Selection, ray: &'a Ray, span: &'a Span, max: f64) -> First<'a> {
        let length = any_length(&ray.direction);
        let end = span.to.as_ref().map_or(f64::INFINITY, |to| to.t);
        let limit = rounded_up(end.min(max / length));
        First { mockup, selection, ray, span, max, length, limit, best: None }
    }

    /// Looks at one triangle that is queried.
    fn look(&mut self, id: u32) {
        let (ray, mesh) = (self.ray, self.mockup.mesh());
        // One that was cut comes several times.
        if !self.selection.has(id) || self.best.as_ref().is_some_and(|(_, best)| *best == id) {
            return;
        }
        let Some(mut meeting) = meet(ray, &mesh.triangle(id), self.span) else { return };
        if meeting.place.t * self.length > self.max {
            return;
        }
        if let Some((best, of)) = &mut self.best {
            let exactly = |id: u32| move || ratio(ray, &mesh.triangle(id));
            let order = meeting.place.compare(&mut best.place, exactly(id), exactly(*of));
            if order == Ordering::Greater || order == Ordering::Equal && *of < id {
                return;
            }
        }
        self.limit = self.limit.min(rounded_up(meeting.place.t));
        self.best = Some((meeting, id));
    }

    /// The first hit.
    pub fn hit(&self) -> Option<RayHit> {
        let (Meeting { place, facing }, id) = self.best.as_ref()?;
        let wound = normal(&self.mockup.mesh().triangle(*id)).unwrap_or_default();
        Some(RayHit {
            distance: place.t * self.length,
            point: along(&self.ray.origin, place.t, &self.ray.direction),
            normal: if *facing > 0 { scaled(&wound, -1.0) } else { wound },
            triangle: *id,
            part: self.mockup.part_of_face(*id),
        })
    }
}

fn rounded_up(t: f64) -> f64 {
    t * (1.0 + RAY_LIMIT_ROUNDING) + VANISHING
}

impl RaySink for First<'_> {
    fn limit(&self) -> f64 {
        self.limit
    }

    fn take(&mut self, triangles: &[u32]) {
        let mesh = self.mockup.mesh();
        triangles.iter().for_each(|t| feeler_lanes::prefetch(&mesh.faces()[*t as usize]));
        triangles.iter().for_each(|t| prefetch_corners(mesh.vertices(), &mesh.faces()[*t as usize]));
        triangles.iter().for_each(|t| self.look(*t));
    }
}
