//! Smooth regions: connected triangles of nearly one normal, in one plane or on one curved surface. Computed once for a
//! mesh by region growing from seeds (Besl and Jain: *Segmentation through variable-order surface fitting*, 1988), of
//! constant order and with the seed's plane as the fit.

use bytemuck::{Pod, Zeroable};

use crate::constants::{COORDINATE_ROUNDING, NONE, ONE_PLANE, REGION_PLANE_ROUNDING, SAME_REGION_COSINE};
use crate::geometry::bounds::Triangle;
use crate::geometry::vectors::{dot, normal, sub};
use crate::mesh::triangle_mesh::Mesh;

/// Flags of a triangle, above the number of its region.
const IN_PLANE: u32 = 1 << 31;
const THIN: u32 = 1 << 30;

/// The region of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct SmoothRegion(u32);

impl SmoothRegion {
    /// The region of triangles that are not queried.
    pub const NONE: SmoothRegion = SmoothRegion(THIN - 1);

    /// The number of the region, less than the number of triangles.
    pub fn number(self) -> u32 {
        self.0 & !(IN_PLANE | THIN)
    }

    /// The same with another number for the region.
    pub fn numbered(self, number: u32) -> SmoothRegion {
        SmoothRegion(self.0 & (IN_PLANE | THIN) | number)
    }

    /// Whether the triangle is in the plane of the region's seed.
    pub fn is_in_plane(self) -> bool {
        self.0 & IN_PLANE != 0
    }

    /// Whether the triangle is so thin that its normal is noise.
    pub fn is_thin(self) -> bool {
        self.0 & THIN != 0
    }
}

/// The region of each triangle. A thin triangle takes the region that reaches it first, and passes it on.
///
/// Windings of an open surface may differ from one triangle to the next, so there the sign of a normal does not count.
pub fn smooth_regions(
    mesh: &Mesh,
    neighbours: &[[u32; 3]],
    outward: &[i8],
    is_thin: impl Fn(u32, &Triangle) -> bool,
) -> Vec<SmoothRegion> {
    let mut smooth_regions = vec![SmoothRegion::NONE; neighbours.len()];
    let (mut count, mut next) = (0, Vec::new());
    // Thin triangles are seeds only after all others.
    for thin_too in [false, true] {
        for seed in mesh.queried() {
            let first = mesh.triangle(seed);
            let thin = is_thin(seed, &first);
            if smooth_regions[seed as usize] != SmoothRegion::NONE || thin && !thin_too {
                continue;
            }
            let (at, n) = (first[0], normal(&first).unwrap_or_default());
            let rounding = COORDINATE_ROUNDING * at[0].abs().max(at[1].abs()).max(at[2].abs());
            let number: u32 = count;
            // Beyond a billion regions the last ones share a number.
            count = (count + 1).min(SmoothRegion::NONE.0 - 1);
            smooth_regions[seed as usize] = SmoothRegion(number | IN_PLANE | if thin { THIN } else { 0 });
            next.push(seed);
            while let Some(from) = next.pop() {
                for t in neighbours[from as usize].into_iter().filter(|t| *t != NONE) {
                    if smooth_regions[t as usize] != SmoothRegion::NONE || outward[t as usize] != outward[seed as usize]
                    {
                        continue;
                    }
                    let triangle = mesh.triangle(t);
                    let kind = if is_thin(t, &triangle) {
                        THIN | smooth_regions[from as usize].0 & IN_PLANE
                    } else {
                        let Some(m) = normal(&triangle) else { continue };
                        let along = if outward[t as usize] == 0 { dot(&m, &n).abs() } else { dot(&m, &n) };
                        let (turn, way) = ((1.0 - along).max(0.0), sub(&triangle[0], &at));
                        let off = (dot(&way, &n).abs() - rounding).max(0.0);
                        // The seed's plane passes the triangle no farther off than the plane of an arc with that turn would.
                        let is_passing =
                            off * off <= dot(&way, &way) * (2.0 * turn + REGION_PLANE_ROUNDING * REGION_PLANE_ROUNDING);
                        if turn > 1.0 - SAME_REGION_COSINE || !is_passing {
                            continue;
                        }
                        if turn <= ONE_PLANE {
                            IN_PLANE
                        } else {
                            0
                        }
                    };
                    smooth_regions[t as usize] = SmoothRegion(number | kind);
                    next.push(t);
                }
            }
        }
    }
    smooth_regions
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::triangle_normals as normals;
    use crate::mesh::topology::adjacency::Adjacency;
    use feeler_shapes::{ball, box_mesh, cylinder, joined, sheet, Arrays};

    fn of((vertices, faces): Arrays) -> (Mesh, Adjacency) {
        let mesh = Mesh::new("tool", vertices, faces).unwrap();
        let adjacency = Adjacency::of_one_part(&mesh);
        (mesh, adjacency)
    }

    #[test]
    fn each_side_of_a_box_is_one() {
        let (_, Adjacency { smooth_regions, .. }) = of(box_mesh([0.0; 3], [1.0, 2.0, 3.0], 3));
        for (t, region) in smooth_regions.iter().enumerate() {
            assert_eq!((region.number() as usize, region.is_in_plane(), region.is_thin()), (t / 18, true, false));
        }
    }

    #[test]
    fn what_turns_is_divided_as_far_as_it_must_be() {
        let shapes =
            [ball(0.02, 60), cylinder(0.01, 0.05, 200, 4), joined([ball(1.0, 7), box_mesh([3.0; 3], [1.0; 3], 2)])];
        for (i, shape) in shapes.into_iter().enumerate() {
            let (mesh, Adjacency { smooth_regions, neighbours, .. }) = of(shape);
            let number = |t: usize| smooth_regions[t].number() as usize;
            let count = (0..smooth_regions.len()).map(number).max().unwrap() + 1;
            let mut first = vec![usize::MAX; count];
            (0..smooth_regions.len()).rev().for_each(|t| first[number(t)] = t);
            // No neighbouring region that was grown before may fit a triangle that it has not.
            let fits = |t: usize, region: usize| {
                let [a, b] = [mesh.triangle(first[region] as u32), mesh.triangle(t as u32)];
                let (n, m) = (normal(&a).unwrap(), normal(&b).unwrap());
                let (turn, way) = (1.0 - dot(&n, &m), sub(&b[0], &a[0]));
                turn < 1.0 - SAME_REGION_COSINE - 1e-9
                    && dot(&way, &n).powi(2) < dot(&way, &way) * (2.0 * turn + 1e-12) * 0.999
            };
            let mut sizes = vec![0; count];
            for t in 0..smooth_regions.len() {
                sizes[number(t)] += 1;
                let beside = neighbours[t].map(|n| n as usize);
                assert!(first[number(t)] == t || beside.iter().any(|n| number(*n) == number(t)), "{i} {t}");
                assert!(beside.iter().all(|n| number(*n) >= number(t) || !fits(t, number(*n))), "{i} {t}");
                let [n, m] = [first[number(t)], t].map(|t| normal(&mesh.triangle(t as u32)).unwrap());
                assert!(dot(&n, &m) >= SAME_REGION_COSINE, "{i} {t}");
                assert_eq!(smooth_regions[t].is_in_plane(), 1.0 - dot(&n, &m) <= ONE_PLANE, "{i} {t}");
            }
            assert!(sizes.iter().any(|size| *size > 2), "{i}");
        }
    }

    #[test]
    fn windings_of_open_surfaces_do_not_matter() {
        let (vertices, mut faces) = sheet(6, 5, |s, t| [s, t, 0.0]);
        faces.iter_mut().step_by(3).for_each(|face| face.swap(0, 1));
        let (_, Adjacency { smooth_regions, outward, .. }) = of((vertices, faces));
        assert!(outward.iter().all(|o| *o == 0));
        assert!(smooth_regions.iter().all(|region| region.number() == 0 && region.is_in_plane()));
    }

    #[test]
    fn thin_triangles_belong_to_their_neighbours_region() {
        // Two squares with a strip of slivers between them, and a sliver alone.
        let strip = |from: f64, to: f64| sheet(1, 1, move |s, t| [from + s * (to - from), t, 0.0]);
        let alone = (vec![[0.0, 5.0, 0.0], [1.0, 5.0, 1e-9], [2.0, 5.0, 0.0]], vec![[0, 1, 2]]);
        let (mesh, Adjacency { smooth_regions, .. }) =
            of(joined([strip(0.5, 0.5 + 1e-8), strip(0.0, 0.5), strip(0.5 + 1e-8, 1.0), alone]));
        let numbers: Vec<u32> = smooth_regions.iter().map(|region| region.number()).collect();
        assert_eq!(numbers, [0, 0, 0, 0, 0, 0, 1]);
        for (t, region) in (0..).zip(&smooth_regions) {
            assert_eq!(region.is_thin(), normals::is_thin(&mesh.triangle(t), 1e-6), "{t}");
            assert_eq!(region.is_thin(), [0, 1, 6].contains(&t), "{t}");
        }
    }
}
