//! The regular voxel grid (Borro et al. 2004): addressing, and the test of a triangle against a voxel by separating axes
//! (T. Akenine-Möller, *Fast 3D triangle-box overlap testing*, 2001).

use crate::constants::{MAX_VOXELS_PER_AXIS, UNIT_ROUNDOFF};
use crate::error::{Error, Result};
use crate::geometry::bounds::{Aabb, Point, Triangle};
use crate::mesh::pieces::grown_box;

/// A regular grid of cubic voxels over a box.
///
/// A coordinate `x` lies in voxel `floor((x - origin) / size)`, clamped to the grid. Each step rounds monotonically, so
/// `x <= y` gives addresses in the same order: a point shared by two boxes has its voxel among the voxels of both. That
/// is all the broad phase relies on.
#[derive(Debug, Clone, PartialEq)]
pub struct VoxelGrid {
    origin: Point,
    size: f64,
    per_metre: f64,
    counts: [u32; 3],
    slack: f64,
}

/// An inclusive range of voxels along each axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VoxelRange {
    /// First voxel.
    pub first: [u32; 3],
    /// Last voxel.
    pub last: [u32; 3],
}

impl VoxelGrid {
    /// A grid of voxels of edge `size` (metres) over `bounds`.
    pub fn new(bounds: &Aabb, size: f64) -> Result<VoxelGrid> {
        if !(size.is_finite() && size > 0.0) {
            return Err(Error::VoxelSize { value: size });
        }
        let extent = bounds.extent();
        let longest = extent.iter().fold(0.0f64, |m, x| m.max(*x));
        let per_metre = 1.0 / size;
        let cells = longest / size + 1.0;
        if !(per_metre.is_finite() && cells <= f64::from(MAX_VOXELS_PER_AXIS)) {
            // The size must have a reciprocal, too.
            let least = f64::max(longest / f64::from(MAX_VOXELS_PER_AXIS - 2), 1e-307);
            return Err(Error::GridTooFine { voxel_size: size, cells, limit: MAX_VOXELS_PER_AXIS, least });
        }
        let counts = extent.map(|x| (x * per_metre) as u32 + 1);
        let slack = 32.0 * UNIT_ROUNDOFF * (bounds.largest_coordinate() + longest + size);
        Ok(VoxelGrid { origin: bounds.lower, size, per_metre, counts, slack })
    }

    /// Voxel edge, metres.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Voxels along each axis: Ni, Nj, Nk.
    pub fn counts(&self) -> [u32; 3] {
        self.counts
    }

    /// Voxels in all, below 2^63.
    pub fn voxel_count(&self) -> u64 {
        self.counts.iter().map(|n| u64::from(*n)).product()
    }

    /// The voxels that a box overlaps, clamped to the grid (the paper's equation 2).
    #[inline]
    pub fn range(&self, b: &Aabb) -> VoxelRange {
        VoxelRange { first: self.address(&b.lower), last: self.address(&b.upper) }
    }

    /// A box (metres) around a range of voxels and all they hold.
    pub fn bounds_of(&self, range: &VoxelRange) -> Aabb {
        // A point's address is off by rounding, which the slack covers.
        let side = |a: usize, x: u32| self.origin[a] + f64::from(x) * self.size;
        Aabb {
            lower: std::array::from_fn(|a| side(a, range.first[a]) - 2.0 * self.slack),
            upper: std::array::from_fn(|a| side(a, range.last[a].saturating_add(1)) + 2.0 * self.slack),
        }
    }

    /// The key of a voxel: `(i*Nj + j)*Nk + k`.
    #[inline]
    pub fn key(&self, [i, j, k]: [u32; 3]) -> u64 {
        (u64::from(i) * u64::from(self.counts[1]) + u64::from(j)) * u64::from(self.counts[2]) + u64::from(k)
    }

    #[inline]
    fn address(&self, p: &Point) -> [u32; 3] {
        std::array::from_fn(|a| {
            // A cast from float saturates, so places before the grid get 0.
            (((p[a] - self.origin[a]) * self.per_metre) as u32).min(self.counts[a] - 1)
        })
    }

    /// Calls `visit` with every voxel that the closed triangle overlaps, and possibly a few that it just misses.
    ///
    /// Large ranges are halved along their longest axis, and halves that the triangle misses are dropped whole, so the cost
    /// grows with the triangle's surface and not with the volume of its box.
    pub fn for_each_voxel(&self, t: &Triangle, mut visit: impl FnMut([u32; 3])) {
        // Voxels are closed: a triangle in the face between two belongs to both.
        let range = self.range(&grown_box(t, self.slack));
        if range.first == range.last {
            return visit(range.first);
        }
        // In voxels from the origin: numbers of moderate size, whatever the size of the mock-up.
        let t = t.map(|p| std::array::from_fn(|a| (p[a] - self.origin[a]) * self.per_metre));
        self.for_each_voxel_in(&t, range, &mut visit);
    }

    fn for_each_voxel_in(&self, t: &Triangle, range: VoxelRange, visit: &mut impl FnMut([u32; 3])) {
        let lengths: [u32; 3] = std::array::from_fn(|a| range.last[a] - range.first[a] + 1);
        let voxels: u64 = lengths.iter().map(|n| u64::from(*n)).product();
        if voxels > 16 {
            let axis = (0..3).max_by_key(|a| lengths[*a]).unwrap_or(0);
            let (mut low, mut high) = (range, range);
            low.last[axis] = range.first[axis] + lengths[axis] / 2 - 1;
            high.first[axis] = low.last[axis] + 1;
            for half in [low, high] {
                if self.is_range_overlapping(t, &half) {
                    self.for_each_voxel_in(t, half, visit);
                }
            }
            return;
        }
        for i in range.first[0]..=range.last[0] {
            for j in range.first[1]..=range.last[1] {
                for k in range.first[2]..=range.last[2] {
                    let voxel = [i, j, k];
                    if self.is_range_overlapping(t, &VoxelRange { first: voxel, last: voxel }) {
                        visit(voxel);
                    }
                }
            }
        }
    }

    /// The least number of voxels that a triangle overlaps: its shadow along each axis covers that many columns.
    pub fn least_voxels(&self, t: &Triangle) -> f64 {
        let shadow = |u: usize, v: usize| {
            0.5 * ((t[1][u] - t[0][u]) * (t[2][v] - t[0][v]) - (t[1][v] - t[0][v]) * (t[2][u] - t[0][u])).abs()
        };
        let area = shadow(0, 1).max(shadow(1, 2)).max(shadow(2, 0));
        let b = Aabb::of_triangle(t);
        let length = b.longest();
        (area * self.per_metre * self.per_metre).max(length * self.per_metre).max(1.0)
    }

    fn is_range_overlapping(&self, t: &Triangle, range: &VoxelRange) -> bool {
        // Voxels at the rim also stand for what is clamped to them; nothing of the mock-up lies outside, so their own
        // box suffices. The slack covers the rounding of addresses and of the scaled corners.
        let centre: Point = std::array::from_fn(|a| 0.5 * (f64::from(range.first[a]) + f64::from(range.last[a]) + 1.0));
        let slack = self.slack * self.per_metre;
        let half: Point = std::array::from_fn(|a| 0.5 * f64::from(range.last[a] - range.first[a] + 1) + slack);
        overlap_triangle_box(t, &centre, &half)
    }
}

/// Whether a triangle may overlap the box with the given centre and half sides: false only when a separating axis is
/// certain.
///
/// T. Akenine-Möller, *Fast 3D triangle-box overlap testing* (2001): three box normals, the triangle's normal, and the
/// nine products of edges. Every comparison allows for the rounding of its own terms, so a touching box is never missed.
pub fn overlap_triangle_box(t: &Triangle, centre: &Point, half: &Point) -> bool {
    let v = t.map(|p| -> Point { std::array::from_fn(|a| p[a] - centre[a]) });
    for a in 0..3 {
        // One rounding in each difference, relative to itself.
        let allowed = half[a] * (1.0 + 8.0 * UNIT_ROUNDOFF);
        let (low, high) = (v[0][a].min(v[1][a]).min(v[2][a]), v[0][a].max(v[1][a]).max(v[2][a]));
        if low - low.abs() * (4.0 * UNIT_ROUNDOFF) > allowed || high + high.abs() * (4.0 * UNIT_ROUNDOFF) < -allowed {
            return false;
        }
    }
    let edges: [Point; 3] = std::array::from_fn(|i| std::array::from_fn(|a| v[(i + 1) % 3][a] - v[i][a]));
    // The largest number in play: corners relative to the centre, and half sides.
    let reach = v.iter().chain([half]).flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    let is_separated = |axis: &Point, error: f64| {
        let d = v.map(|p| axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2]);
        let radius = half[0] * axis[0].abs() + half[1] * axis[1].abs() + half[2] * axis[2].abs();
        let low = d[0].min(d[1]).min(d[2]);
        let high = d[0].max(d[1]).max(d[2]);
        // Not "less or equal" negated: a NaN from overflow must keep the box.
        low > radius + error || high < -radius - error
    };
    for e in &edges {
        for axis in [[0.0, -e[2], e[1]], [e[2], 0.0, -e[0]], [-e[1], e[0], 0.0]] {
            // Edges are differences of the rounded corners, at most 2 reach and off by at most 4 u reach per entry. Two
            // products with corners (off by u reach) on one side, two with half sides on the other.
            if is_separated(&axis, 64.0 * UNIT_ROUNDOFF * reach * reach) {
                return false;
            }
        }
    }
    let [e, f, _] = &edges;
    let normal = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
    // Normal entries are at most 8 reach^2, off by at most 64 u reach^2; three products on either side.
    !is_separated(&normal, 512.0 * UNIT_ROUNDOFF * reach * reach * reach)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unit() -> Aabb {
        Aabb { lower: [0.0; 3], upper: [1.0; 3] }
    }

    #[test]
    fn refuses_sizes_that_make_no_grid() {
        for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(VoxelGrid::new(&unit(), size), Err(Error::VoxelSize { .. })), "{size}");
        }
        for size in [1e-300, 5e-324, 1e-9] {
            assert!(matches!(VoxelGrid::new(&unit(), size), Err(Error::GridTooFine { .. })), "{size}");
        }
        let error = VoxelGrid::new(&unit(), 1e-9).unwrap_err();
        let Error::GridTooFine { least, .. } = error else { panic!("{error}") };
        assert!(VoxelGrid::new(&unit(), least).is_ok(), "the size it advises works");
    }

    #[test]
    fn a_flat_mock_up_is_one_voxel_thick() {
        let flat = Aabb { lower: [0.0, 0.0, 2.0], upper: [1.0, 1.0, 2.0] };
        assert_eq!(VoxelGrid::new(&flat, 0.25).unwrap().counts(), [5, 5, 1]);
    }

    #[test]
    fn a_triangle_in_a_voxel_face_is_in_the_voxels_on_both_sides() {
        // Closed voxels: the plane x = 0.5 belongs to both neighbours.
        let grid = VoxelGrid::new(&unit(), 0.25).unwrap();
        let t = [[0.5, 0.3, 0.3], [0.5, 0.4, 0.3], [0.5, 0.3, 0.4]];
        let mut visited = Vec::new();
        grid.for_each_voxel(&t, |v| visited.push(v));
        assert_eq!(visited, [[1, 1, 1], [2, 1, 1]]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]
        // The promise of the broad phase: a point of the triangle has its voxel among the triangle's voxels.
        #[test]
        fn the_voxel_of_any_point_is_visited(
            t in prop::array::uniform3(prop::array::uniform3(0.0f64..1.0)),
            w in prop::array::uniform3(0.0f64..1.0),
            offset in prop_oneof![Just(0.0), Just(1e6), Just(-3e3)],
            size in 0.02f64..0.7,
        ) {
            let t = t.map(|p| p.map(|x| x + offset));
            let grid = VoxelGrid::new(&Aabb { lower: [offset; 3], upper: [offset + 1.0; 3] }, size).unwrap();
            let mut visited = Vec::new();
            grid.for_each_voxel(&t, |v| visited.push(v));
            let sum: f64 = w.iter().sum::<f64>().max(1e-9);
            for p in [t[0], t[1], t[2], std::array::from_fn(|a| (0..3).map(|i| t[i][a] * w[i] / sum).sum())] {
                prop_assert!(visited.contains(&grid.address(&p)), "{:?} not visited", grid.address(&p));
            }
        }
    }
}
