//! Convex bodies in the form for the depth search: facets, points in lanes, and how far the points extend along the
//! facets' normals.

use crate::constants::{CANCELLED_MEAN, MOST_NORMALS};
use crate::containers::bit_set::BitSets;
use crate::patch::convex_bodies::ConvexBodies;
use crate::patch::extents::largest;
use crate::patch::patches::Patches;
use crate::patch::support::{highest, push_eights, Eight};
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{along, dot, length, unit};
use feeler_lanes::{Checked, WIDE_LANES};

/// A patch as a face of a body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facet {
    pub normal: Point,
    pub size: f64,
    pub flat: bool,
    /// Range of its triangles in the list of all patches.
    triangles: (usize, usize),
}

/// Facets with their triangles: those of one body, or of all bodies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facets<'a> {
    /// Number of the body; the number of bodies if these are the facets of all.
    pub number: usize,
    list: &'a [Facet],
    triangles: &'a [u32],
}

impl<'a> Facets<'a> {
    /// The triangles, whole, each with the normal of its facet.
    pub fn triangles(&self) -> impl Iterator<Item = (u32, &'a Point)> + 'a {
        let all = self.triangles;
        self.list.iter().flat_map(|f| all[f.triangles.0..f.triangles.1].iter().map(|id| (*id, &f.normal)))
    }
}

#[cfg(test)]
impl Facet {
    /// Without triangles.
    pub fn looking(normal: Point) -> Facet {
        Facet::over(normal, 0..0)
    }

    /// With a range of triangles.
    pub fn over(normal: Point, triangles: std::ops::Range<usize>) -> Facet {
        Facet { normal, size: 1.0, flat: true, triangles: (triangles.start, triangles.end) }
    }
}

#[cfg(test)]
impl<'a> Facets<'a> {
    pub fn new(number: usize, list: &'a [Facet], triangles: &'a [u32]) -> Facets<'a> {
        Facets { number, list, triangles }
    }
}

/// A body as ranges of the lists of [`Bodies`].
#[derive(Debug)]
struct Entry {
    facets: (usize, usize),
    points: (usize, usize),
    point_eights: (usize, usize),
    normals: (usize, usize),
    mean: Point,
    size: f64,
    largest: f64,
}

/// The convex bodies of one surface in a contact region. Kept as working memory.
#[derive(Debug, Default)]
pub(crate) struct Bodies {
    list: Vec<Entry>,
    /// All patches as facets, each once.
    patches: Vec<Facet>,
    /// Facets body by body; a shared patch is a facet of several.
    facets: Vec<Facet>,
    points: Vec<Point>,
    /// For each point the range of its contour segments in `point_segments`.
    segments_of: Vec<(u32, u32)>,
    point_segments: Vec<u32>,
    /// For each patch the set of its contour segments, by their indices in the contact region.
    patch_segments: BitSets,
    eights: Vec<Eight>,
    triangles: Vec<u32>,
    normals: Vec<(Point, f64)>,
    /// For each body the set of its contour segments, by their indices in the contact region.
    pub segments: BitSets,
}

/// A convex body, as views of the lists of [`Bodies`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Body<'a> {
    /// Number of the body in its contact region.
    pub number: usize,
    pub facets: &'a [Facet],
    /// Points of its facets; one on the edge of several facets occurs once for each.
    pub points: &'a [Point],
    pub point_eights: &'a [Eight],
    /// Triangles of all patches, which the facets have ranges of.
    pub triangles: &'a [u32],
    /// For each point the range of its segments in `point_segments`: points of the contour have several, others none.
    pub segments_of: &'a [(u32, u32)],
    pub point_segments: &'a [u32],
    /// The normals of the first [`MOST_NORMALS`] facets and the mean, and how far the points reach along each.
    pub normals: &'a [(Point, f64)],
    /// Mean of the facets' normals weighted by size squared, unit; zero if they cancel out.
    pub mean: Point,
    /// Size of the largest facet, metres.
    pub size: f64,
    /// The largest absolute coordinate, metres.
    pub largest: f64,
}

impl<'a> Body<'a> {
    /// All its facets with their triangles.
    pub fn whole(&self) -> Facets<'a> {
        Facets { number: self.number, list: self.facets, triangles: self.triangles }
    }

    /// A triangle of the facet that faces an axis most; of several the first.
    pub fn triangle_facing(&self, axis: &Point) -> Option<u32> {
        let along = |f: &Facet| dot(&f.normal, axis);
        let facet = self.facets.iter().reduce(|best, f| if along(f) > along(best) { f } else { best })?;
        self.triangles[facet.triangles.0..facet.triangles.1].first().copied()
    }
}

#[cfg(test)]
impl<'a> Body<'a> {
    /// With facets and nothing else.
    pub fn of_facets(facets: &'a [Facet]) -> Body<'a> {
        Body {
            number: 0,
            facets,
            points: &[],
            point_eights: &[],
            triangles: &[],
            segments_of: &[],
            point_segments: &[],
            normals: &[],
            mean: [0.0; 3],
            size: 1.0,
            largest: 1.0,
        }
    }
}

impl Bodies {
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether a body has a segment of the contour.
    pub fn is_on_contour(&self, i: usize) -> bool {
        self.segments.get(i).iter().any(|word| *word != 0)
    }

    pub fn get(&self, i: usize) -> Body<'_> {
        let e = &self.list[i];
        Body {
            number: i,
            facets: &self.facets[e.facets.0..e.facets.1],
            points: &self.points[e.points.0..e.points.1],
            point_eights: &self.eights[e.point_eights.0..e.point_eights.1],
            triangles: &self.triangles,
            segments_of: &self.segments_of[e.points.0..e.points.1],
            point_segments: &self.point_segments,
            normals: &self.normals[e.normals.0..e.normals.1],
            mean: e.mean,
            size: e.size,
            largest: e.largest,
        }
    }

    /// The patches of all bodies, each once.
    pub fn all(&self) -> Facets<'_> {
        Facets { number: self.list.len(), list: &self.patches, triangles: &self.triangles }
    }

    /// Lays out the bodies of a contact region with that many segments. `index_of_segment` gives the index of a segment
    /// in the contact region.
    pub fn set(
        &mut self,
        lanes: Checked,
        patches: &Patches,
        convex_bodies: &ConvexBodies,
        segments: usize,
        index_of_segment: impl Fn(u32) -> usize,
    ) {
        self.list.clear();
        self.patches.clear();
        self.facets.clear();
        self.points.clear();
        self.segments_of.clear();
        self.point_segments.clone_from(&patches.point_segments);
        self.eights.clear();
        self.triangles.clear();
        self.normals.clear();
        self.segments.clear(convex_bodies.count, segments);
        self.patch_segments.clear(patches.list.len(), segments);
        for (p, patch) in patches.list.iter().enumerate() {
            let from = self.triangles.len();
            self.triangles.extend(patches.triangles(patch));
            let triangles = (from, self.triangles.len());
            self.patches.push(Facet { normal: patch.normal, size: patch.size, flat: patch.flat, triangles });
            patches
                .segments(patch)
                .iter()
                .for_each(|segment| self.patch_segments.insert(p, index_of_segment(*segment)));
        }
        for (i, (own, shared_patches)) in
            convex_bodies.patches.iter().zip(&convex_bodies.shared_patches).enumerate().take(convex_bodies.count)
        {
            let from = (self.facets.len(), self.points.len());
            for p in own.iter().chain(shared_patches) {
                self.facets.push(self.patches[*p as usize]);
                self.segments.join(i, self.patch_segments.get(*p as usize));
            }
            for patch in own.iter().map(|p| &patches.list[*p as usize]) {
                self.points.extend_from_slice(patches.points(patch));
                self.segments_of.extend_from_slice(patches.segments_of(patch));
            }
            if !shared_patches.is_empty() {
                // The body takes the points of these that are below the planes of all its own patches.
                let whole = self.points.len();
                for patch in shared_patches.iter().map(|p| &patches.list[*p as usize]) {
                    self.points.extend_from_slice(patches.points(patch));
                    self.segments_of.extend_from_slice(patches.segments_of(patch));
                }
                let (points, with) = (&mut self.points[whole..], &mut self.segments_of[whole..]);
                let kept = convex_bodies.planes.keep_below(lanes, i, points, with);
                self.points.truncate(whole + kept);
                self.segments_of.truncate(whole + kept);
            }
            let facets = &self.facets[from.0..];
            let sum = facets.iter().fold([0.0; 3], |s, p| along(&s, p.size * p.size, &p.normal));
            let weight: f64 = facets.iter().map(|p| p.size * p.size).sum();
            let mean = unit(&sum).filter(|_| length(&sum) > CANCELLED_MEAN * weight).unwrap_or([0.0; 3]);
            let from_normals = self.normals.len();
            self.push_normals(lanes, from.0, from.1, mean);
            let facets = &self.facets[from.0..];
            let from_eights = self.eights.len();
            push_eights(&self.points[from.1..], &mut self.eights);
            self.list.push(Entry {
                facets: (from.0, self.facets.len()),
                points: (from.1, self.points.len()),
                point_eights: (from_eights, self.eights.len()),
                normals: (from_normals, self.normals.len()),
                mean,
                size: facets.iter().fold(0.0f64, |m, p| m.max(p.size)),
                largest: largest(lanes, &self.eights[from_eights..]),
            });
        }
    }

    fn push_normals(&mut self, lanes: Checked, facets: usize, points: usize, mean: Point) {
        let from = self.normals.len();
        self.normals.extend(self.facets[facets..].iter().take(MOST_NORMALS).map(|f| (f.normal, 0.0)));
        self.normals.push((mean, 0.0));
        for some in self.normals[from..].chunks_mut(WIDE_LANES) {
            let directions = std::array::from_fn(|i| some[i.min(some.len() - 1)].0);
            let reach = highest(lanes, &self.points[points..], &directions);
            some.iter_mut().zip(reach).for_each(|(n, height)| n.1 = height);
        }
    }
}

/// Most edges between `facets` facets: the number of their pairs.
pub(crate) fn edge_count(facets: usize) -> usize {
    facets * facets.saturating_sub(1) / 2
}
