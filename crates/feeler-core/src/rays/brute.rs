//! The plain twin of all searches along rays: every triangle, no index.

use super::query::{check, First};
use super::ray::{HalfSpace, Ray, RayHit};
use super::span::Span;
use crate::error::Result;
use crate::index::selection::Selection;
use crate::index::sink::RaySink;
use crate::mesh::mockup::Mockup;

/// The first triangle that a ray hits, as [`Scene::ray`](crate::Scene::ray).
pub fn first_of_all(
    mockup: &Mockup,
    selection: &Selection,
    ray: &Ray,
    max: f64,
    sections: &[HalfSpace],
) -> Result<Option<RayHit>> {
    check(std::slice::from_ref(ray), max, sections)?;
    let Some(span) = Span::new(ray, sections) else { return Ok(None) };
    let mut first = First::new(mockup, selection, ray, &span, max);
    mockup.mesh().queried().for_each(|t| first.take(&[t]));
    Ok(first.hit())
}
