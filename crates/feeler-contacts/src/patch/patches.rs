//! One surface of a contact region as a few patches of nearly one normal, however many triangles it is cut into.
//!
//! The patches come from region growing: smooth regions are grown once for a mesh ([`smooth_regions`]), and a patch is
//! the share of a contact region in one of them. Variational shape approximation (Cohen-Steiner et al. 2004) would fit
//! the patches better, but it iterates, and its patches change from pose to pose; a smooth region is the same at every
//! pose.
//!
//! [`smooth_regions`]: feeler_core::mesh::topology::smooth_regions

use std::hint::select_unpredictable;

use crate::constants::{MOST_CORNERS, MOST_PATCHES};
use crate::containers::counting_sort::lay_out;
use crate::containers::point_interner::PointInterner;
use crate::context::QueryContext;
use crate::contour::contact_region::ContactRegions;
use crate::patch::connected_components::ConnectedComponents;
use crate::patch::extents::{measure_extents, Extents};
use crate::patch::surface_patch::{part, Fragment, Patch};
use crate::surface::{Side, Surface};
use feeler_core::constants::{NONE, ONE_PLANE};
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::triangle_normals::eight_normals;
use feeler_core::geometry::vectors::{dot, normal, scaled};
use feeler_core::index::interner::Interner;
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_lanes::{Checked, Sorter, WIDE_LANES};

/// The patches of one surface in a contact region, largest first. Kept as working memory.
#[derive(Debug, Default)]
pub(crate) struct Patches {
    pub list: Vec<Patch>,
    /// Points of the fragments, those of the contour included, each once a patch, patch by patch.
    points: Vec<Point>,
    /// For each of them its number on the surface: the same in all patches that share the point.
    numbers: Vec<u32>,
    /// For each of them the range of its contour segments in `point_segments`: points of the contour have several,
    /// others none.
    segments_of: Vec<(u32, u32)>,
    /// Contour segments, point by point.
    pub point_segments: Vec<u32>,
    /// Corners of patches, patch by patch, as indices of `corner_points`.
    corners: Vec<u32>,
    /// The corners' points, each once.
    corner_points: Vec<Point>,
    /// For each number of a point its index in `corner_points`, or [`NONE`].
    corner_of: Vec<u32>,
    fragments: Vec<Fragment>,
    /// Points fragment by fragment, each with its segment if it is a point of the contour, or [`NONE`].
    fragment_points: Vec<(Point, u32)>,
    /// Fragments that are whole triangles of curved closed surfaces.
    curved: Vec<u32>,
    founded: Founded,
    components: ConnectedComponents,
    /// Fragments patch by patch.
    order: Vec<u32>,
    gathering: Gathering,
    extents: Vec<Extents>,
    by_size: Sorter,
    in_order: Vec<Patch>,
}

/// Working memory of [`Patches::found`].
#[derive(Debug, Default)]
struct Founded {
    /// Smooth regions, numbered in the order of their first fragments.
    numbers: Interner,
    /// For each number the patch.
    patches: Vec<u32>,
    /// For each patch whether the fragment that founded it lies in the plane of its smooth region.
    in_plane: Vec<bool>,
}

/// Working memory of [`Patches::gather`].
#[derive(Debug, Default)]
struct Gathering {
    /// Numbers of the points of the surface.
    known: PointInterner,
    /// How many points have a number.
    distinct: usize,
    /// For each of [`Patches::fragment_points`] its number.
    all_numbers: Vec<u32>,
    /// For each number the last patch that has the point, counted from 1, and the index of the point there.
    latest: Vec<(u32, u32)>,
    /// Points of the contour by their indices, each with a segment.
    on_contour: Vec<(u32, u32)>,
}

impl Patches {
    /// The points of a patch, each once.
    pub fn points(&self, patch: &Patch) -> &[Point] {
        patch.of_points(&self.points)
    }

    /// For each of them the range of its segments in [`point_segments`](Self::point_segments).
    pub fn segments_of(&self, patch: &Patch) -> &[(u32, u32)] {
        patch.of_points(&self.segments_of)
    }

    /// The contour segments of a patch; one occurs once for each of its points in the patch.
    pub fn segments(&self, patch: &Patch) -> &[u32] {
        let (first, last) = (self.segments_of[patch.points.0 as usize], self.segments_of[patch.points.1 as usize - 1]);
        &self.point_segments[first.0 as usize..last.1 as usize]
    }

    /// The triangles of a patch.
    pub fn triangles(&self, patch: &Patch) -> impl Iterator<Item = u32> + '_ {
        patch.of_fragments(&self.order).iter().map(|i| self.fragments[*i as usize].id)
    }

    /// The corners of a patch, some several times, as indices of [`all_corners`](Self::all_corners): all its points
    /// where these are at most [`MOST_CORNERS`], else the extreme ones along a few directions.
    pub fn corners(&self, patch: &Patch) -> &[u32] {
        part(&self.corners, patch.corners)
    }

    /// The corners of all patches, each once.
    pub fn all_corners(&self) -> &[Point] {
        &self.corner_points
    }

    /// Makes the patches of one surface in a contact region.
    pub fn set(&mut self, context: &QueryContext<'_>, regions: &ContactRegions, region: usize, surface: Surface) {
        self.fragments.clear();
        self.fragment_points.clear();
        self.push_contour_faces(regions, region, surface);
        self.push_inside(context, regions, region, surface);
        self.found(context, surface);
        self.group();
        let Patches { list, fragments, order, components, .. } = self;
        if components.split(context, &regions.face_numbers, surface, list, fragments, order) {
            self.group();
        }
        self.gather();
        self.finish(context.lanes);
    }

    /// Adds the rests of the triangles that the contour crosses: the ends of their segments, and the corners inside the
    /// other.
    fn push_contour_faces(&mut self, regions: &ContactRegions, region: usize, surface: Surface) {
        let face_of = |c: &u32| regions.segments[*c as usize].faces[surface];
        for same in regions.segments_of(region, surface).chunk_by(|x, y| face_of(x) == face_of(y)) {
            let face = &regions.faces[surface][face_of(&same[0]) as usize];
            let from = self.fragment_points.len() as u32;
            for c in same {
                let shared = regions.segments[*c as usize].points;
                let points = &regions.points[shared.0 as usize..shared.1 as usize];
                self.fragment_points.extend(points.iter().map(|x| (*x, *c)));
            }
            for (k, side) in face.side.iter().enumerate() {
                if *side == Side::Inside
                    && face.is_corner_of(k, |c| regions.region_of_segment[c as usize] == region as u32)
                {
                    self.fragment_points.push((face.corners[k], NONE));
                }
            }
            let points = (from, self.fragment_points.len() as u32);
            self.fragments.push(Fragment::new(face.id, Some(face.normal), points, face.closed));
        }
    }

    /// Adds the whole triangles that the contour encloses.
    fn push_inside(&mut self, context: &QueryContext<'_>, regions: &ContactRegions, region: usize, surface: Surface) {
        let Adjacency { smooth_regions, outward, .. } = context.adjacency[surface];
        self.curved.clear();
        for [t, segment] in regions.inside_of(region, surface) {
            // Thin triangles have no normal of their own, and their corners belong to their neighbours too.
            if smooth_regions[*t as usize].is_thin() {
                continue;
            }
            let (corners, near) = (context.triangle(surface, *t), regions.face(surface, *segment));
            let from = self.fragment_points.len() as u32;
            self.fragment_points.extend(corners.map(|x| (x, NONE)));
            let is_known = near.closed && outward[*t as usize] != 0;
            let turned =
                || normal(&corners).map(|n| context.turned_outward(surface, *t, &n, near.closed, &near.normal));
            let normal = if is_known { None } else { turned() };
            if is_known && !smooth_regions[*t as usize].is_in_plane() {
                self.curved.push(self.fragments.len() as u32);
            }
            self.fragments.push(Fragment::new(*t, normal, (from, from + 3), near.closed));
        }
        let Patches { fragments, fragment_points, curved, .. } = self;
        for some in curved.chunks(WIDE_LANES) {
            let corners = |i: usize| {
                let from = fragments[some[i] as usize].points.0 as usize;
                [0, 1, 2].map(|k| &fragment_points[from + k].0)
            };
            let (normals, _) = eight_normals(context.lanes, some.len(), 0.0, corners);
            for (i, n) in some.iter().zip(normals) {
                let fragment = &mut fragments[*i as usize];
                fragment.normal = n.map(|n| scaled(&n, context.sense(surface, fragment.id)));
            }
        }
    }

    /// Gives each fragment the patch of its smooth region, which the first fragment of the region founds. Fragments
    /// that face the other way, as some of an open surface may, have a second patch.
    fn found(&mut self, context: &QueryContext<'_>, surface: Surface) {
        let Patches { list, fragments, founded: Founded { numbers, patches, in_plane }, .. } = self;
        list.clear();
        numbers.clear();
        patches.clear();
        in_plane.clear();
        for fragment in fragments {
            let smooth_region = context.adjacency[surface].smooth_regions[fragment.id as usize];
            let key = u64::from(smooth_region.number()) << 2 | u64::from(fragment.closed) << 1;
            let (mut number, mut is_new) = numbers.number(key);
            if let (false, Some(n)) = (is_new, &fragment.normal) {
                if dot(n, &list[patches[number as usize] as usize].normal) < 0.0 {
                    (number, is_new) = numbers.number(key | 1);
                }
            }
            let of_winding = || {
                normal(&context.triangle(surface, fragment.id)).map(|n| scaled(&n, context.sense(surface, fragment.id)))
            };
            let outward = || fragment.normal.or_else(of_winding).unwrap_or_default();
            if is_new {
                let normal = outward();
                patches.push(if list.len() < MOST_PATCHES {
                    list.push(Patch::new(normal, context.corner(surface, fragment.id)));
                    in_plane.push(smooth_region.is_in_plane());
                    list.len() as u32 - 1
                } else {
                    let along = |i: &u32| dot(&list[*i as usize].normal, &normal);
                    (0..list.len() as u32).max_by(|i, j| along(i).total_cmp(&along(j))).unwrap_or(0)
                });
            }
            fragment.patch = patches[number as usize];
            let patch = &mut list[fragment.patch as usize];
            let is_known = !is_new && smooth_region.is_in_plane() && in_plane[fragment.patch as usize];
            patch.flat = patch.flat && (is_known || 1.0 - dot(&patch.normal, &outward()) <= ONE_PLANE);
        }
    }

    /// Lists the fragments patch by patch, in their order.
    fn group(&mut self) {
        let Patches { list, fragments, order, .. } = self;
        list.iter_mut().for_each(|patch| patch.fragments = (0, 0));
        fragments.iter().for_each(|fragment| list[fragment.patch as usize].fragments.1 += 1);
        lay_out(list.iter_mut().map(|patch| &mut patch.fragments));
        order.resize(fragments.len(), 0);
        for (i, fragment) in (0..).zip(fragments.iter()) {
            let end = &mut list[fragment.patch as usize].fragments.1;
            order[*end as usize] = i;
            *end += 1;
        }
    }

    /// Lists the points patch by patch, each once a patch, in the order of the fragments.
    fn gather(&mut self) {
        let Patches { list, points, numbers, segments_of, point_segments, fragments, fragment_points, order, .. } =
            self;
        let Gathering { known, distinct, all_numbers, latest, on_contour } = &mut self.gathering;
        let most = fragment_points.len();
        let mut known = known.begin(most);
        // The lists are long enough for any outcome; entries beyond those written below do not count.
        points.resize(most.max(points.len()), [0.0; 3]);
        numbers.resize(most.max(numbers.len()), 0);
        on_contour.resize(most.max(on_contour.len()), (0, 0));
        for pairs in [&mut *segments_of, &mut *latest] {
            pairs.clear();
            pairs.resize(most, (0, 0));
        }
        // The numbers first, in a loop of their own: without a branch, and in few registers.
        all_numbers.resize(most.max(all_numbers.len()), 0);
        for ((x, _), number) in fragment_points.iter().zip(&mut all_numbers[..most]) {
            *number = known.insert(x) as u32;
        }
        *distinct = known.len();
        // Without branches: neither whether a point is new to its patch nor whether it is on the contour can be
        // predicted. Slices instead of vectors, which stay in registers.
        let (mut count, mut contour_count) = (0, 0);
        let (new_points, numbers, on_contour) = (&mut points[..], &mut numbers[..], &mut on_contour[..]);
        let (counts, latest, order, fragments) = (&mut segments_of[..], &mut latest[..], &order[..], &fragments[..]);
        for (mark, Patch { points, fragments: of, .. }) in (1..).zip(list.iter_mut()) {
            let from = count as u32;
            for i in part(order, *of) {
                let range = fragments[*i as usize].points.0 as usize..fragments[*i as usize].points.1 as usize;
                for ((x, segment), number) in fragment_points[range.clone()].iter().zip(&all_numbers[range]) {
                    let (patch, index) = latest[*number as usize];
                    let index = select_unpredictable(patch == mark, index, count as u32);
                    latest[*number as usize] = (mark, index);
                    (new_points[count], numbers[count]) = (*x, *number);
                    count += usize::from(patch != mark);
                    let has_segment = *segment != NONE;
                    counts[index as usize].1 += u32::from(has_segment);
                    on_contour[contour_count] = (index, *segment);
                    contour_count += usize::from(has_segment);
                }
            }
            *points = (from, count as u32);
        }
        segments_of.truncate(count);
        // A counting sort: each range is empty at first, and grows to its end.
        lay_out(segments_of.iter_mut());
        point_segments.resize(contour_count, 0);
        for (index, segment) in &on_contour[..contour_count] {
            let end = &mut segments_of[*index as usize].1;
            point_segments[*end as usize] = *segment;
            *end += 1;
        }
    }

    /// Measures the patches, chooses their corners, and sorts them by size.
    fn finish(&mut self, lanes: Checked) {
        let Patches { list, points, numbers, corners, corner_points, corner_of, by_size, in_order, .. } = self;
        let Patches { gathering, extents, .. } = self;
        let distinct = gathering.distinct;
        corners.clear();
        corner_points.resize(distinct + 1, [0.0; 3]);
        corner_of.clear();
        corner_of.resize(distinct, NONE);
        let mut count = 0;
        measure_extents(lanes, points, list, extents);
        for (patch, found) in list.iter_mut().zip(&*extents) {
            (patch.middle, patch.size) = (found.middle, found.size);
            let (points, numbers) = (patch.of_points(points), patch.of_points(numbers));
            patch.corners.0 = corners.len() as u32;
            let mut push = |i: usize| {
                let known = corner_of[numbers[i] as usize];
                let index = select_unpredictable(known == NONE, count as u32, known);
                corner_of[numbers[i] as usize] = index;
                corner_points[count] = points[i];
                count += usize::from(known == NONE);
                corners.push(index);
            };
            if points.len() <= MOST_CORNERS {
                (0..points.len()).for_each(push);
            } else {
                found.extreme.as_flattened().iter().for_each(|i| push(*i as usize));
            }
            patch.corners.1 = corners.len() as u32;
        }
        corner_points.truncate(count);
        // Largest first, and equal ones in their order. Only sizes and numbers are sorted, since patches are large to
        // move. Sizes are not negative, so their bits sort as they do; sizes that are equal in float32 count as equal.
        by_size.clear();
        let largest = list.iter().fold(0.0, |m: f64, p| m.max(p.size));
        let scale = if largest.is_normal() { largest.recip() } else { 1.0 };
        let key = |(i, p): (u32, &Patch)| u64::from(!((p.size * scale) as f32).to_bits()) << u32::BITS | u64::from(i);
        by_size.keys.extend((0..).zip(&*list).map(key));
        by_size.sort(lanes);
        in_order.clear();
        in_order.extend(by_size.sorted().iter().map(|key| list[*key as u32 as usize]));
        std::mem::swap(list, in_order);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Surface;
    use crate::tests::{at, scene, tool};
    use feeler_core::geometry::vectors::{across, sub, unit};
    use feeler_shapes::{box_mesh, sheet};

    #[test]
    fn regions_beyond_the_most_patches_join_the_nearest_normal() {
        // Triangles apart from each other, each with another normal; one occurs twice, the second time facing the other
        // way.
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (0.3 * i as f64).sin()];
        let normals: Vec<Point> = (0..MOST_PATCHES + 40).map(|i| unit(&wave(i)).unwrap()).collect();
        let triangles = normals.iter().enumerate().flat_map(|(i, n)| {
            let ([u, v], p) = (across(n), [3.0 * i as f64, 0.0, 0.0]);
            [p, sub(&p, &scaled(&u, -1.0)), sub(&p, &scaled(&v, -1.0))]
        });
        let faces = (0..normals.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mockup = scene((triangles.collect(), faces));
        let tool = tool(box_mesh([0.0; 3], [1.0; 3], 1));
        let pose = at(0.0, 0.0, 0.0);
        let context = QueryContext::new(&mockup, &tool, &pose, None);
        let mut patches = Patches::default();
        let fragment = |i: usize, sense: f64| Fragment::new(i as u32, Some(scaled(&normals[i], sense)), (0, 0), false);
        patches.fragments.extend([fragment(0, 1.0), fragment(0, -1.0), fragment(0, 1.0), fragment(0, -1.0)]);
        patches.fragments.extend((1..normals.len()).map(|i| fragment(i, 1.0)));
        patches.found(&context, Surface::Mockup);
        assert_eq!(patches.list.len(), MOST_PATCHES);
        assert_eq!(patches.list[1].normal, scaled(&normals[0], -1.0));
        let mut joined = vec![0; MOST_PATCHES];
        for (k, fragment) in patches.fragments.iter().enumerate() {
            let own = if k < 4 { k % 2 } else { k - 2 };
            let along = |i: &usize| dot(&patches.list[*i].normal, &normals[fragment.id as usize]);
            let nearest = (0..MOST_PATCHES).max_by(|i, j| along(i).total_cmp(&along(j))).unwrap();
            assert_eq!(fragment.patch as usize, if own < MOST_PATCHES { own } else { nearest }, "{k}");
            joined[fragment.patch as usize] += usize::from(own >= MOST_PATCHES);
        }
        // A patch that others joined is not flat any more.
        assert!(patches.list.iter().zip(&joined).all(|(patch, joined)| patch.flat == (*joined == 0)));
        assert_eq!(joined.iter().sum::<usize>(), 41);
    }

    #[test]
    fn patches_in_one_plane_are_flat_wherever_their_region_begins() {
        // A sheet whose first cell is tilted a little: all of it is one smooth region, and all but two triangles lie in
        // one plane.
        let mockup = scene(sheet(9, 1, |s, t| [s, t, if s == 0.0 { 0.003 } else { 0.0 }]));
        let tool = tool(box_mesh([0.0; 3], [1.0; 3], 1));
        let pose = at(0.0, 0.0, 0.0);
        let context = QueryContext::new(&mockup, &tool, &pose, None);
        assert!(context.adjacency[Surface::Mockup]
            .smooth_regions
            .iter()
            .all(|smooth_region| smooth_region.number() == 0));
        for (some, expected) in [([2, 3, 9], true), ([0, 1, 1], true), ([7, 0, 5], false), ([1, 2, 3], false)] {
            let mut patches = Patches::default();
            patches.fragments.extend(some.map(|t| Fragment::new(t, None, (0, 0), true)));
            patches.found(&context, Surface::Mockup);
            assert_eq!(patches.list.iter().map(|patch| patch.flat).collect::<Vec<_>>(), [expected], "{some:?}");
        }
    }
}
