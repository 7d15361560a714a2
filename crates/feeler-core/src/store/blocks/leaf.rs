//! The last steps of the search for what is near: a cluster of the tool against a block.

use super::near::{Near, NearScratch, Search};
use super::pieces::HalfBlock;
use super::FANOUT;
use crate::lanes::{greatest4, least4, load3, PlacedPieces, LANES, TINY};
use crate::simd::{prefetch, Simd};

/// Hands on the pairs of triangles of a cluster and a block that boxes and planes do not hold farther apart than the limit,
/// nearest first. True when the search is over.
#[inline(always)]
pub fn scan<S: Simd>(s: S, run: &mut Search<'_, '_>, scratch: &mut NearScratch, cluster: usize, block: u32) -> bool {
    let NearScratch { clusters, block: unpacked, seen, .. } = scratch;
    let node = &run.blocks.levels[0][block as usize];
    let placed = clusters.get(s, run, cluster);
    let mut near = Near::ZERO;
    let halves = &mut unpacked.halves;
    if unpacked.block != block {
        unpacked.block = block;
        unpacked.has_corners = false;
        halves[0].unpack_boxes(s, node, 0);
        halves[1].unpack_boxes(s, node, 1);
    }
    let mut found = 0;
    for h in 0..2 {
        let half = &halves[h];
        found |= near.of(s, &half.lower, &half.upper, &placed.bounds, run.limit, LANES * h) << (LANES * h);
    }
    found &= node.valid;
    if found == 0 {
        return false;
    }
    let slack = run.placement.slack + run.blocks.slack;
    let slots = &run.wanted.tool.clusters()[cluster];
    let triangles = &run.blocks.triangles[FANOUT * block as usize..];
    let mut pairs = Near::ZERO;
    let count = near.sort(&mut found);
    for at in 0..count {
        let piece = near.order[at] as u32 as usize;
        if near.bounds[piece] > run.limit {
            continue;
        }
        let (h, lane) = (piece / LANES, piece % LANES);
        let bounds = halves[h].boxes_lane(lane);
        let mut lanes = pairs.of_lanes(s, &placed.boxes, &bounds, run.limit) & u32::from(slots.corners.used);
        if lanes == 0 {
            continue;
        }
        if !unpacked.has_corners {
            unpacked.has_corners = true;
            for h in 0..2 {
                halves[h].unpack_corners(s, &run.blocks.packed[block as usize], h, slack);
            }
        }
        placed.need_normals(s);
        lanes &= u32::from(planes_within(s, placed, &halves[h], lane, run.limit));
        let triangle = triangles[piece];
        if lanes != 0 {
            prefetch(&run.wanted.mockup.mesh().faces()[triangle as usize]);
        }
        let count = pairs.sort(&mut lanes);
        for at in 0..count {
            let i = pairs.order[at] as u32 as usize;
            // A bound only falls, so a pair needs no second look.
            if pairs.bounds[i] <= run.limit && seen.insert(u64::from(slots.slots[i]) << 32 | u64::from(triangle)) {
                if run.wanted.take(slots.slots[i], triangle) {
                    return true;
                }
                run.update_limit();
            }
        }
    }
    false
}

/// Which of a cluster's pieces are not held farther apart from one piece of a block than the limit (a square), by the plane of
/// either.
///
/// As for collisions: whatever the axis is, intervals along it that are apart by more than their uncertainty are proof, and the
/// gap over the axis's length is a bound. Lengths near what float32 can square prove nothing.
#[inline(always)]
fn planes_within<S: Simd>(s: S, placed: &PlacedPieces, half: &HalfBlock, piece: usize, limit: f32) -> u16 {
    let zero = s.splat(0.0);
    let shortest = s.splat(1e-28);
    let limit = s.splat(limit * (1.0 + 1e-4));
    let mut d = [zero; 4];
    // The plane of the block's piece.
    let m = [s.splat(half.normals[0][piece]), s.splat(half.normals[1][piece]), s.splat(half.normals[2][piece])];
    for c in 0..4 {
        let at = load3(s, &placed.corners[c]);
        d[c] = s.mul_add(m[0], at[0], s.mul_add(m[1], at[1], m[2] * at[2]));
    }
    let gap = s.max(least4(s, &d) - s.splat(half.far[piece]), s.splat(half.near[piece]) - greatest4(s, &d));
    let gap = s.max(gap, zero);
    let length = s.mul_add(m[0], m[0], s.mul_add(m[1], m[1], m[2] * m[2]));
    let beyond = s.above(gap * gap, limit * length) & s.above(length, shortest);
    // The planes of the tool's pieces.
    let n = load3(s, &placed.normals);
    for c in 0..4 {
        let at = [&half.corners[c][0], &half.corners[c][1], &half.corners[c][2]];
        let last = n[2] * s.splat(at[2][piece]);
        d[c] = s.mul_add(n[0], s.splat(at[0][piece]), s.mul_add(n[1], s.splat(at[1][piece]), last));
    }
    let slack = s.mul_add(s.abs(n[2]), s.splat(half.slack[2][piece]), s.splat(TINY));
    let slack = s.mul_add(s.abs(n[1]), s.splat(half.slack[1][piece]), slack);
    let slack = s.mul_add(s.abs(n[0]), s.splat(half.slack[0][piece]), slack);
    let (near, far) = (least4(s, &d) - slack, greatest4(s, &d) + slack);
    let gap = s.max(s.max(near - s.load(&placed.far), s.load(&placed.near) - far), zero);
    let length = s.mul_add(n[0], n[0], s.mul_add(n[1], n[1], n[2] * n[2]));
    !(beyond | s.above(gap * gap, limit * length) & s.above(length, shortest))
}
