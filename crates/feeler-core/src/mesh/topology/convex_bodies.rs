//! Convex bodies: smooth regions of a surface that bulge together. Computed once for a mesh, so that a contact keeps
//! its identity while the tool slides over triangles and regions.
//!
//! Greedy growth over the adjacency of smooth regions, as in approximate convex decomposition (J.-M. Lien, N. Amato:
//! *Approximate convex decomposition of polyhedra*, 2007), but of the surface: starting from the largest region without
//! a body, a neighbour joins if none of its points extends over the plane of a member, nor a member's over its own. On
//! an open surface, whose normals have no sense, neighbours join if the surface turns little between them.

use rayon::prelude::*;

use super::disjoint_sets::DisjointSets;
use super::smooth_regions::SmoothRegion;
use crate::constants::{BODY_HOLLOW, NONE, OPEN_TURN, SAME_BODY_PLANE};
use crate::geometry::bounds::Point;
use crate::geometry::vectors::{add, cross, dot, length, normal, scaled, sub};
use crate::mesh::triangle_mesh::Mesh;

/// Directions along which the outermost points of a region stand for all of them: axes and diagonals of a cube, each both ways.
const DIRECTIONS: [Point; 13] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, 1.0, -1.0],
];

/// The body of each smooth region: the number of the region that founded it.
pub fn convex_bodies(
    mesh: &Mesh,
    neighbours: &[[u32; 3]],
    outward: &[i8],
    smooth_regions: &[SmoothRegion],
) -> Vec<u32> {
    let region = |t: u32| smooth_regions[t as usize].number() as usize;
    let count = mesh.queried().map(|t| region(t) + 1).max().unwrap_or(0);
    let pairs: Vec<(u32, u32)> = mesh.queried().map(|t| (region(t) as u32, t)).collect();
    let triangles = Lists::new(count, &pairs);
    let beside = |t: u32| {
        let of = neighbours[t as usize].into_iter().filter(move |n| *n != NONE && mesh.is_queried(*n));
        of.map(&region).filter(move |r| *r != region(t))
    };
    // Connected regions are one task: no body reaches beyond them.
    let mut connected = DisjointSets((0..count as u32).collect());
    for t in mesh.queried() {
        beside(t).for_each(|r| connected.join(region(t) as u32, r as u32));
    }
    let pairs: Vec<(u32, u32)> = (0..count as u32).map(|r| (connected.of(r), r)).collect();
    let tasks = Lists::new(count, &pairs);
    let mut places = vec![0; count];
    (0..count).flat_map(|root| (0..).zip(tasks.of(root))).for_each(|(i, r)| places[*r as usize] = i);
    let found: Vec<Vec<(u32, u32)>> = (0..count)
        .into_par_iter()
        .filter(|root| tasks.of(*root).len() > 1)
        .map(|root| {
            let of_task = tasks.of(root);
            let is_closed = outward[triangles.of(of_task[0] as usize)[0] as usize] != 0;
            let regions: Vec<Region> =
                of_task.iter().map(|r| Region::new(mesh, outward, triangles.of(*r as usize))).collect();
            let mut pairs: Vec<(u32, u32)> = Vec::new();
            for (i, r) in (0..).zip(of_task) {
                let near = triangles.of(*r as usize).iter().flat_map(|t| beside(*t));
                pairs.extend(near.map(|n| (i, places[n])));
            }
            let beside = Lists::new(of_task.len(), &pairs);
            let founders = grow(&regions, &beside, is_closed);
            of_task.iter().zip(founders).map(|(r, founder)| (*r, of_task[founder])).collect()
        })
        .collect();
    let mut bodies: Vec<u32> = (0..count as u32).collect();
    found.into_iter().flatten().for_each(|(r, founder)| bodies[r as usize] = founder);
    bodies
}

/// The founder of each region's body, by places.
fn grow(regions: &[Region], beside: &Lists, is_closed: bool) -> Vec<usize> {
    // Areas are not negative, so their bits are in their order.
    let mut order: Vec<(u64, u32)> = regions.iter().zip(0..).map(|(r, i)| (!r.area.to_bits(), i)).collect();
    order.sort_unstable();
    let mut founders = vec![usize::MAX; regions.len()];
    // The last body that asked for a region: each asks once.
    let mut asked = vec![usize::MAX; regions.len()];
    let mut members: Vec<usize> = Vec::new();
    for (_, founder) in order {
        let founder = founder as usize;
        if founders[founder] != usize::MAX {
            continue;
        }
        founders[founder] = founder;
        members.clear();
        members.push(founder);
        let mut hull = Hull::of(&regions[founder]);
        let mut next = 0;
        while next < members.len() {
            let from = &regions[members[next]];
            for r in beside.of(members[next]).iter().map(|r| *r as usize) {
                if founders[r] != usize::MAX || asked[r] == founder {
                    continue;
                }
                let region = &regions[r];
                let joins = if is_closed {
                    asked[r] = founder;
                    from.bulges_with(region) && hull.bulges_with(region)
                } else {
                    dot(&from.normal, &region.normal).abs() >= OPEN_TURN
                };
                if joins {
                    founders[r] = founder;
                    members.push(r);
                    if is_closed {
                        hull.add(region);
                    }
                }
            }
            next += 1;
        }
    }
    founders
}

/// The shape of a body, for any number of members: planes that no region may stand out over, and its outermost points.
struct Hull<'a> {
    /// Members of which no two have nearly one normal.
    planes: Vec<&'a Region>,
    /// Along each direction, and against it.
    outermost: [[Point; 2]; DIRECTIONS.len()],
    /// How far along the direction these are.
    reach: [[f64; 2]; DIRECTIONS.len()],
}

impl<'a> Hull<'a> {
    fn of(region: &'a Region) -> Hull<'a> {
        let mut hull = Hull {
            planes: vec![region],
            outermost: [[region.outermost[0]; 2]; DIRECTIONS.len()],
            reach: DIRECTIONS.map(|d| [dot(&region.outermost[0], &d); 2]),
        };
        hull.widen(region);
        hull
    }

    fn add(&mut self, region: &'a Region) {
        if !self.planes.iter().any(|p| dot(&p.normal, &region.normal) > SAME_BODY_PLANE) {
            self.planes.push(region);
        }
        self.widen(region);
    }

    fn widen(&mut self, region: &Region) {
        for p in &region.outermost {
            for ((d, [high, low]), [most, least]) in DIRECTIONS.iter().zip(&mut self.outermost).zip(&mut self.reach) {
                let height = dot(p, d);
                if height > *most {
                    (*most, *high) = (height, *p);
                }
                if height < *least {
                    (*least, *low) = (height, *p);
                }
            }
        }
    }

    fn bulges_with(&self, region: &Region) -> bool {
        region.is_over_all_of(self.outermost.as_flattened())
            && self.planes.iter().all(|plane| plane.is_over_all_of(&region.outermost))
    }
}

/// A smooth region, as far as bodies ask about it.
struct Region {
    /// Unit, outward where the surface is closed: the mean of its triangles', by area.
    normal: Point,
    /// A point of its plane, the mean of its outermost points.
    middle: Point,
    /// How high its corners are at most over the plane through the middle: where a curved region touches its plane.
    height: f64,
    outermost: Vec<Point>,
    /// Twice, square metres.
    area: f64,
}

impl Region {
    fn new(mesh: &Mesh, outward: &[i8], triangles: &[u32]) -> Region {
        let sense = |t: u32| if outward[t as usize] < 0 { -1.0 } else { 1.0 };
        // Windings of an open surface may differ: all normals are turned to the first one's side.
        let first = normal(&mesh.triangle(triangles[0])).unwrap_or_default();
        let (mut sum, mut area) = ([0.0; 3], 0.0);
        for t in triangles {
            let [a, b, c] = mesh.triangle(*t);
            let n = scaled(&cross(&sub(&b, &a), &sub(&c, &a)), sense(*t));
            let is_turned = outward[*t as usize] == 0 && dot(&n, &first) < 0.0;
            sum = if is_turned { sub(&sum, &n) } else { add(&sum, &n) };
            area += length(&n);
        }
        let size = length(&sum);
        let corners: Vec<Point> = triangles.iter().flat_map(|t| mesh.triangle(*t)).collect();
        let mut outermost: Vec<Point> = Vec::with_capacity(2 * DIRECTIONS.len());
        for d in &DIRECTIONS {
            let (mut low, mut high) = ((f64::INFINITY, 0), (f64::NEG_INFINITY, 0));
            for (i, p) in corners.iter().enumerate() {
                let height = dot(p, d);
                low = if height < low.0 { (height, i) } else { low };
                high = if height > high.0 { (height, i) } else { high };
            }
            for p in [corners[low.1], corners[high.1]] {
                if !outermost.contains(&p) {
                    outermost.push(p);
                }
            }
        }
        let middle = scaled(&outermost.iter().fold([0.0; 3], |s, p| add(&s, p)), 1.0 / outermost.len() as f64);
        let normal = if size > 0.0 { scaled(&sum, 1.0 / size) } else { [0.0; 3] };
        let height = corners.iter().map(|p| dot(&sub(p, &middle), &normal)).fold(0.0, f64::max);
        Region { normal, middle, height, outermost, area }
    }

    /// Whether neither stands out over the other's plane.
    fn bulges_with(&self, other: &Region) -> bool {
        self.is_over_all_of(&other.outermost) && other.is_over_all_of(&self.outermost)
    }

    /// Whether none of some points is over its plane by more than a share of the distance, or of its own height.
    fn is_over_all_of(&self, points: &[Point]) -> bool {
        points.iter().all(|p| {
            let way = sub(p, &self.middle);
            let height = dot(&way, &self.normal) - self.height;
            height <= 0.0 || height * height <= BODY_HOLLOW * BODY_HOLLOW * dot(&way, &way)
        })
    }
}

/// Lists laid one behind the other.
struct Lists {
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl Lists {
    /// The given number of lists, from pairs of a list and an entry; each list in the order of the pairs.
    fn new(count: usize, pairs: &[(u32, u32)]) -> Lists {
        let mut starts = vec![0u32; count + 1];
        pairs.iter().for_each(|(list, _)| starts[*list as usize + 1] += 1);
        (0..count).for_each(|i| starts[i + 1] += starts[i]);
        let mut ends = starts.clone();
        let mut entries = vec![0; starts[count] as usize];
        for (list, entry) in pairs {
            entries[ends[*list as usize] as usize] = *entry;
            ends[*list as usize] += 1;
        }
        Lists { starts, entries }
    }

    fn of(&self, list: usize) -> &[u32] {
        &self.entries[self.starts[list] as usize..self.starts[list + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::super::adjacency::Adjacency;
    use super::*;
    use feeler_shapes::{ball, box_mesh, cylinder, joined, ridge, sheet, Arrays};

    fn bodies((vertices, faces): Arrays) -> Vec<u32> {
        let mesh = Mesh::new("tool", vertices, faces).unwrap();
        let adjacency = Adjacency::of_one_part(&mesh);
        (0..mesh.faces().len() as u32).map(|t| adjacency.body_of(t)).collect()
    }

    fn count(mut bodies: Vec<u32>) -> usize {
        bodies.sort_unstable();
        bodies.dedup();
        bodies.len()
    }

    #[test]
    fn what_is_convex_is_one_body_however_finely_it_is_cut() {
        for cells in [1, 2, 9] {
            assert_eq!(count(bodies(box_mesh([3.0, 1.0, 0.0], [1.0, 2.0, 0.1], cells))), 1, "{cells}");
        }
        for n in [5, 24, 60] {
            assert_eq!(count(bodies(ball(0.02, n))), 1, "{n}");
            assert_eq!(count(bodies(cylinder(0.01, 0.05, n, 3))), 1, "{n}");
        }
        // Inside out, far away, and two apart.
        let mut turned = box_mesh([1e5, -2e5, 3e5], [0.1; 3], 3);
        turned.1.iter_mut().for_each(|f| f.swap(1, 2));
        assert_eq!(count(bodies(turned)), 1);
        assert_eq!(count(bodies(joined([box_mesh([0.0; 3], [1.0; 3], 2), ball(0.02, 9)]))), 2);
    }

    #[test]
    fn a_hollow_parts_what_bulges_on_both_its_sides() {
        // An L: its inner sides are not of one body, however finely it is cut.
        let line = [[-0.03, 0.0], [0.0, 0.0], [1e-9, 0.02], [0.01, 0.02]];
        for n in [1, 2, 6] {
            let (vertices, faces) = ridge(&line, -0.01, 0.02, n, 2 * n);
            let inner = |axis: usize, at: f64, below: f64| {
                let is_it = |f: &[u32; 3]| {
                    f.iter().all(|v| (vertices[*v as usize][axis] - at).abs() < 1e-8)
                        && f.iter().all(|v| vertices[*v as usize][2 - axis] <= below + 1e-8)
                };
                faces.iter().position(is_it).unwrap()
            };
            let (wall, floor) = (inner(0, 0.0, 0.02), inner(2, 0.0, 0.0));
            let found = bodies((vertices.clone(), faces.clone()));
            assert_ne!(found[wall], found[floor], "{n}");
            assert!(count(found) <= 6, "{n}");
        }
    }

    #[test]
    fn an_open_surface_that_turns_little_is_one_body() {
        let rolled = |angle: f64| sheet(40, 3, move |s, t| [(angle * s).sin(), 0.4 * t, (angle * s).cos()]);
        assert_eq!(count(bodies(rolled(3.0))), 1);
        let bent = sheet(2, 1, |s, t| [f64::min(s, 0.5), t, f64::max(s - 0.5, 0.0)]);
        assert_eq!(count(bodies(bent)), 2);
    }
}
