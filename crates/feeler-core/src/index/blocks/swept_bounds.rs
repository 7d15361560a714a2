//! Sixteen boxes or pieces of a tool side by side, and their sweep through a window of time, in a frame, in float32.
//!
//! A point of the tool stays within the window's margin of the straight line between its places at both ends, so the
//! box around both places, grown by the margin, contains its whole motion, and so does its interval along any axis.

use super::node::Frame;
use super::pieces::HalfBlock;
use crate::tool::motion::Window;
use crate::tool::moving_tool::Tool;
use crate::tool::placement::{BoxLanes, PieceLanes, PlaceBoxes, PlacedPieces, Placement};
use feeler_lanes::{load3, Box4, LaneBoxes, Simd};

/// The placements at both ends of a window.
pub struct SweptPlacement {
    ends: [Placement; 2],
    /// See [`Placement::slack`]: it covers the window's margin, too.
    pub slack: f32,
}

/// The swept bounds of up to 16 pieces.
pub struct SweptPieces {
    ends: [PlacedPieces; 2],
    /// Boxes around the ways of the pieces.
    pub boxes: LaneBoxes,
    /// The box around all of them.
    pub bounds: Box4,
}

impl SweptPlacement {
    /// For boxes and pieces of `tool`.
    pub fn new(tool: &Tool, window: &Window, frame: &Frame) -> SweptPlacement {
        let place = |i: usize| Placement::new(tool.unit(), &window.poses[i], window.margin, &frame.origin, frame.scale);
        let ends = [place(0), place(1)];
        let slack = ends[0].slack.max(ends[1].slack);
        SweptPlacement { ends, slack }
    }

    /// Computes the swept bounds of pieces.
    #[inline(always)]
    pub fn place_pieces<S: Simd>(&self, s: S, pieces: &PieceLanes, out: &mut SweptPieces) {
        self.ends[0].place_pieces(s, pieces, &mut out.ends[0]);
        self.ends[1].place_pieces(s, pieces, &mut out.ends[1]);
        for a in 0..3 {
            out.boxes.lower[a] = out.ends[0].boxes.lower[a];
            out.boxes.upper[a] = out.ends[0].boxes.upper[a];
        }
        union(s, &mut out.boxes, &out.ends[1].boxes);
        out.bounds = out.ends[0].bounds.union(&out.ends[1].bounds);
    }
}

impl PlaceBoxes for SweptPlacement {
    /// Boxes around what boxes sweep.
    #[inline(always)]
    fn place_boxes<S: Simd>(&self, s: S, boxes: &BoxLanes, to: &mut LaneBoxes) {
        let mut other = LaneBoxes::ZERO;
        self.ends[0].place_boxes(s, boxes, to);
        self.ends[1].place_boxes(s, boxes, &mut other);
        union(s, to, &other);
    }
}

impl SweptPieces {
    /// To be filled in.
    pub const ZERO: SweptPieces =
        SweptPieces { ends: [PlacedPieces::ZERO; 2], boxes: LaneBoxes::ZERO, bounds: Box4::EMPTY };

    /// Which of the pieces are not held apart from one piece of a block, all the way, by an axis across the plane of the
    /// block's piece, or of the tool's at either end.
    #[inline(always)]
    pub fn planes_meeting<S: Simd>(&mut self, s: S, half: &HalfBlock, piece: usize) -> u16 {
        let m = half.normal(s, piece);
        let [(a, b), (c, d)] = [self.ends[0].along(s, &m), self.ends[1].along(s, &m)];
        let (near, far) = (s.min(a, c), s.max(b, d));
        let mut apart = s.above(near, s.splat(half.far[piece])) | s.above(s.splat(half.near[piece]), far);
        for end in 0..2 {
            self.ends[end].need_normals(s);
            let n = load3(s, &self.ends[end].normals);
            let (a, b) = self.ends[1 - end].along(s, &n);
            let near = s.min(a, s.load(&self.ends[end].near));
            let far = s.max(b, s.load(&self.ends[end].far));
            let (least, greatest) = half.along(s, piece, &n);
            apart = apart | s.above(least, far) | s.above(near, greatest);
        }
        !s.lanes(apart)
    }
}

#[inline(always)]
fn union<S: Simd>(s: S, boxes: &mut LaneBoxes, other: &LaneBoxes) {
    for a in 0..3 {
        let lower = s.min(s.load(&boxes.lower[a]), s.load(&other.lower[a]));
        let upper = s.max(s.load(&boxes.upper[a]), s.load(&other.upper[a]));
        s.store(lower, &mut boxes.lower[a]);
        s.store(upper, &mut boxes.upper[a]);
    }
}
