//! The last steps of the distance search: a cluster of the tool against a block, by gaps between boxes and along three
//! separating axes; each is a lower bound.

use super::nearest::{gaps, NearScratch, Search};
use super::node::FANOUT;
use super::pieces::HalfBlock;
use super::separating_planes::Dividers;
use crate::constants::{LEAF_ROUNDING, LEAST_AXIS_SQUARE};
use crate::index::interner::pair_key;
use crate::index::sink::NearSink;
use crate::tool::placement::PlacedPieces;
use feeler_lanes::{load3, prefetch, Simd, LANES};

/// Hands on the pairs of triangles of a cluster and a block that boxes and planes do not hold farther apart than the limit,
/// nearest first. True when the search is over.
#[inline(always)]
pub fn scan<S: Simd, W: NearSink>(
    s: S,
    run: &mut Search<'_, W>,
    scratch: &mut NearScratch,
    cluster: usize,
    block: u32,
) -> bool {
    let NearScratch { clusters, block: unpacked, seen, candidates, .. } = scratch;
    let node = &run.blocks.levels[0][block as usize];
    let (placed, above) = clusters.get(s, run, cluster);
    let halves = &mut unpacked.halves;
    if unpacked.block != block {
        unpacked.block = block;
        unpacked.has_corners = false;
        unpacked.is_judged = 0;
        halves[0].unpack_boxes(s, node, 0);
        halves[1].unpack_boxes(s, node, 1);
    }
    let mut found = 0;
    let limit = s.splat(run.limit);
    for h in 0..2 {
        let squared = gaps(s, &halves[h].lower, &halves[h].upper, &placed.bounds);
        found |= u32::from(!s.lanes(s.above(squared, limit))) << (LANES * h);
    }
    found &= node.valid;
    if found == 0 {
        return false;
    }
    let slack = run.placement.slack + run.blocks.slack;
    let slots = &run.at.tool.clusters()[cluster];
    let packed = &run.blocks.pieces[block as usize];
    let mesh = run.at.mockup.mesh();
    candidates.clear();
    // Pieces with the lanes whose boxes are near. Whether there are any cannot be foreseen: no branch depends on it.
    let mut near = [(0, 0); FANOUT];
    let mut count = 0;
    while found != 0 {
        let piece = found.trailing_zeros() as usize;
        found &= found - 1;
        let bounds = halves[piece / LANES].boxes_lane(piece % LANES);
        let squared = gaps(s, &placed.boxes.lower, &placed.boxes.upper, &bounds);
        let lanes = u32::from(!s.lanes(s.above(squared, limit))) & u32::from(slots.corners.used);
        near[count] = (piece, lanes);
        count += usize::from(lanes != 0);
    }
    if count > 0 && !unpacked.has_corners {
        unpacked.has_corners = true;
        for h in 0..2 {
            halves[h].unpack_corners(s, packed, h, slack);
        }
    }
    let mut planes = Planes::ZERO;
    let has_bounds_of_parts = run.wanted.has_bounds_of_parts();
    for &(piece, mut lanes) in &near[..count] {
        let (h, lane) = (piece / LANES, piece % LANES);
        let triangle = packed.triangles[piece];
        let selection = run.at.selection;
        if !selection.has(triangle) || selection.ignores_all_with(run.at.mockup, triangle) {
            continue;
        }
        let mut limit = run.limit;
        if has_bounds_of_parts {
            let Some(bound) = run.wanted.bound_of(triangle) else { continue };
            limit = run.limit_at(bound);
            let squared = gaps(s, &placed.boxes.lower, &placed.boxes.upper, &halves[h].boxes_lane(lane));
            lanes &= u32::from(!s.lanes(s.above(squared, s.splat(limit))));
            if lanes == 0 {
                continue;
            }
        }
        if !run.dividers.is_empty() {
            if unpacked.is_judged >> piece & 1 == 0 {
                unpacked.is_judged |= 1 << piece;
                let part = run.at.mockup.part_of_face(triangle);
                unpacked.behind[piece] = Dividers::judge(s, &run.dividers, part, &halves[h], lane);
            }
            let (i, behind) = unpacked.behind[piece];
            lanes = run.dividers[i as usize].sift(s, placed, &mut above[i as usize], behind, lanes);
            if lanes == 0 {
                continue;
            }
        }
        placed.need_normals(s);
        lanes &= u32::from(planes.of(s, placed, &halves[h], lane, &run.direction, limit));
        if lanes == 0 {
            continue;
        }
        prefetch(&mesh.faces()[triangle as usize]);
        let mut boxes = [0.0; LANES];
        let bounds = halves[h].boxes_lane(lane);
        s.store(gaps(s, &placed.boxes.lower, &placed.boxes.upper, &bounds), &mut boxes);
        while lanes != 0 {
            let i = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let bound = planes.bound(i).max(boxes[i]);
            candidates.push(Candidate { bound, slot: slots.slots[i], triangle });
        }
    }
    if run.wanted.is_collecting() {
        // Rounded down: the scale and the root are.
        let per_unit = (1.0 - LEAF_ROUNDING) / run.blocks.frame.scale;
        let mut collect = |c: &Candidate| run.wanted.collect(c.slot, c.triangle, f64::from(c.bound).sqrt() * per_unit);
        return candidates.iter().any(&mut collect);
    }
    let ignores_any = run.at.selection.ignores_any();
    candidates.sort_unstable_by(|a, b| a.bound.total_cmp(&b.bound));
    for candidate in candidates.iter() {
        mesh.faces()[candidate.triangle as usize].iter().for_each(|v| prefetch(&mesh.vertices()[*v as usize]));
    }
    for candidate in candidates.iter() {
        if candidate.bound > run.limit {
            break;
        }
        // Those never make the limit fall: where many are near, they would all be remembered.
        if ignores_any && !run.at.selection.wants(run.at.tool, run.at.mockup, candidate.slot, candidate.triangle) {
            continue;
        }
        // A bound only falls, so a pair needs no second look.
        if seen.insert(pair_key(candidate.slot, candidate.triangle)) {
            if run.wanted.take(candidate.slot, candidate.triangle) {
                return true;
            }
            run.update_limit();
        }
    }
    false
}

/// A pair of triangles to be tested.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    bound: f32,
    slot: u32,
    triangle: u32,
}

/// Gaps between a cluster's pieces and one piece of a block, along the normals of both and one direction more.
///
/// As for collisions: whatever the axis is, intervals along it that are apart by more than their uncertainty are proof, and the
/// gap over the axis's length is a bound. Lengths near what float32 can square prove nothing.
struct Planes {
    /// By axis and lane: squares of gaps and of lengths.
    gaps: [[f32; LANES]; 3],
    lengths: [[f32; LANES]; 3],
}

impl Planes {
    const ZERO: Planes = Planes { gaps: [[0.0; LANES]; 3], lengths: [[1.0; LANES]; 3] };

    /// Fills them in, whatever other piece they were of; returns which lanes are not held farther apart than the limit (a square).
    #[inline(always)]
    fn of<S: Simd>(
        &mut self,
        s: S,
        placed: &PlacedPieces,
        half: &HalfBlock,
        piece: usize,
        direction: &[f32; 3],
        limit: f32,
    ) -> u16 {
        let zero = s.splat(0.0);
        let limit = s.splat(limit * (1.0 + LEAF_ROUNDING as f32));
        // The plane of the block's piece.
        let m = half.normal(s, piece);
        let (near, far) = placed.along(s, &m);
        let gap = s.max(near - s.splat(half.far[piece]), s.splat(half.near[piece]) - far);
        let mut beyond = self.keep(s, 0, s.max(gap, zero), &m, limit);
        // The planes of the tool's pieces.
        let n = load3(s, &placed.normals);
        let (near, far) = half.along(s, piece, &n);
        let gap = s.max(near - s.load(&placed.far), s.load(&placed.near) - far);
        beyond |= self.keep(s, 1, s.max(gap, zero), &n, limit);
        // The direction, if there is one.
        if direction != &[0.0; 3] {
            let m = [s.splat(direction[0]), s.splat(direction[1]), s.splat(direction[2])];
            let ((near, far), (least, greatest)) = (half.along(s, piece, &m), placed.along(s, &m));
            let gap = s.max(near - greatest, least - far);
            beyond |= self.keep(s, 2, s.max(gap, zero), &m, limit);
        }
        !beyond
    }

    #[inline(always)]
    fn keep<S: Simd>(&mut self, s: S, axis: usize, gap: S::F32, n: &[S::F32; 3], limit: S::F32) -> u16 {
        let length = s.mul_add(n[0], n[0], s.mul_add(n[1], n[1], n[2] * n[2]));
        let gap = gap * gap;
        s.store(gap, &mut self.gaps[axis]);
        s.store(length, &mut self.lengths[axis]);
        s.lanes(s.above(gap, limit * length)) & s.lanes(s.above(length, s.splat(LEAST_AXIS_SQUARE)))
    }

    /// The largest bound for a lane (a square), rounded down.
    fn bound(&self, lane: usize) -> f32 {
        let mut bound = 0.0f32;
        for axis in 0..3 {
            let (gap, length) = (self.gaps[axis][lane], self.lengths[axis][lane]);
            if length > LEAST_AXIS_SQUARE {
                bound = bound.max(gap / length);
            }
        }
        bound * (1.0 - LEAF_ROUNDING as f32)
    }
}
