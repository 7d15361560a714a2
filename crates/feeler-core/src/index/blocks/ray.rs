//! The search along a ray, in lanes: the 32 children of a node at once, nearest first.
//!
//! The ray is clipped to the mock-up's box in float64; from there on float32 in frame units distinguishes everything
//! that is more than [`RAY_GROWTH`] away from it.

use super::node::{Node, FANOUT};
use super::tree::Blocks;
use crate::constants::{FAR_RAY, LEAST_SLOPE, RAY_GROWTH, RAY_ROUNDOFFS, UNIT_ROUNDOFF};
use crate::geometry::vectors::{any_length, largest, unit};
use crate::index::ray_search::{search_ray, RayPath, RayScratch};
use crate::index::selection::there as selected;
use crate::index::sink::RaySink;
use crate::mesh::triangle_mesh::Mesh;
use feeler_lanes::{prefetch, Kernel, LaneBoxes, Simd, LANES};

/// A ray in frame units, from where it enters the mock-up's box.
#[derive(Debug, Clone, Copy)]
struct FrameRay {
    origin: [f32; 3],
    /// One over each entry of the unit direction.
    per_slope: [f32; 3],
    /// Where the searched part of the ray begins.
    from: f32,
    /// Frame units along the ray for each share of the direction given, and where its origin is.
    per_share: f64,
    start: f64,
}

impl Blocks {
    /// Calls `wanted` with every triangle that the ray may hit within its limit, nearest boxes first.
    pub fn search_ray<W: RaySink>(&self, mesh: &Mesh, path: &RayPath<'_>, scratch: &mut RayScratch, wanted: &mut W) {
        let (scale, bounds) = (self.frame.scale, mesh.bounds());
        let per_share = any_length(&path.direction) * scale;
        let reach = (largest(&path.origin) + bounds.largest_coordinate() + bounds.longest()) * scale;
        let Some(direction) = unit(&path.direction).filter(|_| per_share.is_normal()) else {
            return search_ray(self, mesh, path, wanted);
        };
        if RAY_ROUNDOFFS * UNIT_ROUNDOFF * reach > FAR_RAY {
            return search_ray(self, mesh, path, wanted);
        }
        let origin: [f64; 3] = std::array::from_fn(|a| (path.origin[a] - self.frame.origin[a]) * scale);
        let whole = self.levels[self.levels.len() - 1][0].bounds();
        let mut start = 0.0f64;
        let mut end = f64::INFINITY;
        for a in 0..3 {
            let slope = if direction[a].abs() < f64::from(LEAST_SLOPE) { f64::from(LEAST_SLOPE) } else { direction[a] };
            let side = |x: f32, growth: f32| (f64::from(x) + f64::from(growth) - origin[a]) / slope;
            let sides = [side(whole.lower[a], -RAY_GROWTH), side(whole.upper[a], RAY_GROWTH)];
            start = start.max(sides[0].min(sides[1]));
            end = end.min(sides[0].max(sides[1]));
        }
        if start > end {
            return;
        }
        let ray = FrameRay {
            origin: std::array::from_fn(|a| (origin[a] + start * direction[a]) as f32),
            per_slope: direction.map(|x| {
                let slope = x as f32;
                1.0 / if slope.abs() < LEAST_SLOPE { LEAST_SLOPE } else { slope }
            }),
            from: (path.from * per_share - start) as f32 - RAY_GROWTH,
            per_share,
            start,
        };
        path.lanes.run(Along { blocks: self, path, ray, scratch, wanted });
    }
}

struct Along<'a, 'b, W> {
    blocks: &'a Blocks,
    path: &'a RayPath<'b>,
    ray: FrameRay,
    scratch: &'a mut RayScratch,
    wanted: &'a mut W,
}

impl<W: RaySink> Along<'_, '_, W> {
    /// Where nothing is of interest any more.
    #[inline(always)]
    fn limit(&self) -> f32 {
        // Far more than the rounding to float32 of places in the box, which is at most two units long.
        (self.wanted.limit() * self.ray.per_share - self.ray.start) as f32 + RAY_GROWTH
    }
}

impl<W: RaySink> Kernel for Along<'_, '_, W> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Blocks { levels, pieces, .. } = self.blocks;
        let mut limit = self.limit();
        let mut near = Near { enters: [0.0; FANOUT], order: [0; FANOUT] };
        self.scratch.stack.clear();
        self.scratch.stack.push((0.0, levels.len() as u8 - 1, 0));
        while let Some((enters, level, at)) = self.scratch.stack.pop() {
            if enters > limit {
                continue;
            }
            let found = near.of_children(s, &levels[level as usize][at as usize], &self.ray, limit);
            let count = near.list(selected(self.path.selection.children(level as usize), at, found));
            if level == 0 {
                let mut triangles = [0; FANOUT];
                for (triangle, key) in triangles.iter_mut().zip(&near.order[..count]) {
                    *triangle = pieces[at as usize].triangles[*key as u32 as usize];
                }
                self.wanted.take(&triangles[..count]);
                limit = self.limit();
                continue;
            }
            for key in near.order[..count].iter().rev() {
                let i = *key as u32;
                let child = FANOUT as u32 * at + i;
                prefetch(&levels[level as usize - 1][child as usize]);
                self.scratch.stack.push((near.enters[i as usize], level - 1, child));
            }
        }
    }
}

/// Where a ray enters up to 32 boxes, and their order.
struct Near {
    enters: [f32; FANOUT],
    /// Where it does in the upper half, the place in the lower.
    order: [u64; FANOUT],
}

impl Near {
    /// Which children of a node the ray may meet within the limit.
    #[inline(always)]
    fn of_children<S: Simd>(&mut self, s: S, node: &Node, ray: &FrameRay, limit: f32) -> u32 {
        let mut half = LaneBoxes::ZERO;
        let mut found = 0;
        for h in 0..2 {
            node.unpack(s, h, &mut half.lower, &mut half.upper);
            let (mut enters, mut leaves) = (s.splat(ray.from.max(0.0)), s.splat(limit));
            for a in 0..3 {
                let per_slope = s.splat(ray.per_slope[a]);
                let lower = (s.load(&half.lower[a]) - s.splat(ray.origin[a] + RAY_GROWTH)) * per_slope;
                let upper = (s.load(&half.upper[a]) - s.splat(ray.origin[a] - RAY_GROWTH)) * per_slope;
                enters = s.max(enters, s.min(lower, upper));
                leaves = s.min(leaves, s.max(lower, upper));
            }
            let to = &mut self.enters[LANES * h..LANES * (h + 1)];
            s.store(enters, to.try_into().expect("16 of 32"));
            found |= u32::from(!s.lanes(s.above(enters, leaves))) << (LANES * h);
        }
        found & node.valid
    }

    /// Puts the places chosen into `order`, nearest first. Returns how many.
    #[inline(always)]
    fn list(&mut self, mut chosen: u32) -> usize {
        let mut count = 0;
        while chosen != 0 {
            let i = chosen.trailing_zeros() as usize;
            chosen &= chosen - 1;
            // Numbers that are not negative are ordered as their bits are.
            let key = u64::from(self.enters[i].to_bits()) << 32 | i as u64;
            let mut at = count;
            while at > 0 && self.order[at - 1] > key {
                self.order[at] = self.order[at - 1];
                at -= 1;
            }
            self.order[at] = key;
            count += 1;
        }
        count
    }
}
