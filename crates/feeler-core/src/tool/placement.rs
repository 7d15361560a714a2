//! Sixteen boxes or pieces of a tool side by side, and their places at a pose, in float32.
//!
//! Lane `i` of each array belongs to entry `i`. Unused lanes repeat the last entry, so that no step needs to skip them
//! before the end.

use feeler_lanes::{along, greatest4, least4, load3, splat3, Box4, Lane32, LaneBoxes, Simd, LANES, TINY};

use crate::constants::{LARGEST_PLACEMENT, LEAST_MARGIN, PLACEMENT_ROUNDING};
use crate::geometry::bounds::{Aabb, Piece};
use crate::geometry::pose::Pose;

/// Pieces of a tool at a pose, in a frame.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct PlacedPieces {
    /// Their boxes, margin included.
    pub boxes: LaneBoxes,
    /// The box around all of them.
    pub bounds: Box4,
    /// Their corners, by corner, axis and lane.
    pub corners: [[Lane32; 3]; 4],
    /// An axis across each piece's plane, of any length, and the piece's interval along it; made when first needed.
    pub normals: [Lane32; 3],
    /// See `normals`.
    pub near: Lane32,
    /// See `normals`.
    pub far: Lane32,
    has_normals: bool,
}

/// The unit in which a tool's float32 coordinates are kept: from the middle of its box, at most 1 in size.
#[derive(Debug, Clone, Copy)]
pub struct ToolUnit {
    centre: [f64; 3],
    /// Metres per unit, a power of two.
    metres: f64,
}

/// Boxes of tool entries (clusters, groups) in tool units, as centre and half sides.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct BoxLanes {
    centre: [Lane32; 3],
    half: [Lane32; 3],
    /// One bit a lane in use.
    pub used: u16,
}

/// Corners of up to 16 pieces in tool units.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct PieceLanes {
    /// By corner, axis and lane.
    corners: [[Lane32; 3]; 4],
    /// One bit a lane in use.
    pub used: u16,
}

/// Which lanes a number of entries uses.
fn used(count: usize) -> u16 {
    ((1u32 << count) - 1) as u16
}

impl PlacedPieces {
    /// Pieces to be filled in.
    pub const ZERO: PlacedPieces = PlacedPieces {
        boxes: LaneBoxes::ZERO,
        bounds: Box4::EMPTY,
        corners: [[[0.0; LANES]; 3]; 4],
        normals: [[0.0; LANES]; 3],
        near: [0.0; LANES],
        far: [0.0; LANES],
        has_normals: false,
    };

    /// Makes the normals where that was not done since the pieces were placed.
    #[inline(always)]
    pub fn need_normals<S: Simd>(&mut self, s: S) {
        if !self.has_normals {
            self.make_normals(s);
        }
    }

    /// The corners.
    #[inline(always)]
    pub fn corners<S: Simd>(&self, s: S) -> [[S::F32; 3]; 4] {
        [load3(s, &self.corners[0]), load3(s, &self.corners[1]), load3(s, &self.corners[2]), load3(s, &self.corners[3])]
    }

    /// The interval of each piece along an axis.
    #[inline(always)]
    pub fn along<S: Simd>(&self, s: S, n: &[S::F32; 3]) -> (S::F32, S::F32) {
        along(s, &self.corners(s), n)
    }

    #[inline(always)]
    fn make_normals<S: Simd>(&mut self, s: S) {
        let c = self.corners(s);
        let u = [c[2][0] - c[0][0], c[2][1] - c[0][1], c[2][2] - c[0][2]];
        let v = [c[3][0] - c[1][0], c[3][1] - c[1][1], c[3][2] - c[1][2]];
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let (near, far) = along(s, &c, &n);
        for a in 0..3 {
            s.store(n[a], &mut self.normals[a]);
        }
        s.store(near, &mut self.near);
        s.store(far, &mut self.far);
        self.has_normals = true;
    }
}

impl ToolUnit {
    /// The unit for a tool with this box.
    pub fn new(bounds: &Aabb) -> ToolUnit {
        let centre = std::array::from_fn(|a| 0.5 * bounds.lower[a] + 0.5 * bounds.upper[a]);
        let longest = bounds.longest();
        let exponent = if longest > 0.0 { longest.log2().ceil().clamp(-900.0, 900.0) } else { 0.0 };
        ToolUnit { centre, metres: exponent.exp2() }
    }

    fn to_unit(self, x: f64, axis: usize) -> f32 {
        ((x - self.centre[axis]) / self.metres) as f32
    }

    /// A box in the tool's frame, metres, around a box rounded to these sides: tool units are at most 1, so a rounding is at
    /// most 2^-24 of them.
    fn to_metres(self, sides: impl Fn(usize) -> (f32, f32)) -> Aabb {
        let rounding = 2f64.powi(-22);
        let mut b = Aabb::EMPTY;
        for a in 0..3 {
            let (lower, upper) = sides(a);
            b.lower[a] = (f64::from(lower) - rounding) * self.metres + self.centre[a];
            b.upper[a] = (f64::from(upper) + rounding) * self.metres + self.centre[a];
        }
        b
    }
}

impl BoxLanes {
    /// One to 16 boxes.
    pub fn new(boxes: &[Aabb], unit: &ToolUnit) -> BoxLanes {
        let mut lanes = BoxLanes { centre: [[0.0; LANES]; 3], half: [[0.0; LANES]; 3], used: used(boxes.len()) };
        for i in 0..LANES {
            let b = &boxes[i.min(boxes.len() - 1)];
            for a in 0..3 {
                let centre = unit.to_unit(0.5 * b.lower[a] + 0.5 * b.upper[a], a);
                // Half sides from the rounded centre, and a little more: the margin of a placement need not know of them.
                let (lower, upper) = (unit.to_unit(b.lower[a], a), unit.to_unit(b.upper[a], a));
                lanes.centre[a][i] = centre;
                lanes.half[a][i] = (upper - centre).max(centre - lower) * (1.0 + 4.0 * f32::EPSILON);
            }
        }
        lanes
    }
}

impl BoxLanes {
    /// One of them, in the tool's frame, metres.
    pub fn bounds(&self, i: usize, unit: &ToolUnit) -> Aabb {
        unit.to_metres(|a| (self.centre[a][i] - self.half[a][i], self.centre[a][i] + self.half[a][i]))
    }
}

impl PieceLanes {
    /// The box of one of them, in the tool's frame, metres.
    pub fn bounds(&self, i: usize, unit: &ToolUnit) -> Aabb {
        let side = |a: usize, f: fn(f32, f32) -> f32| {
            self.corners[1..].iter().fold(self.corners[0][a][i], |x, c| f(x, c[a][i]))
        };
        unit.to_metres(|a| (side(a, f32::min), side(a, f32::max)))
    }

    /// One to 16 pieces.
    pub fn new(pieces: &[Piece], unit: &ToolUnit) -> PieceLanes {
        let mut lanes = PieceLanes { corners: [[[0.0; LANES]; 3]; 4], used: used(pieces.len()) };
        for i in 0..LANES {
            for (c, corner) in pieces[i.min(pieces.len() - 1)].iter().enumerate() {
                for a in 0..3 {
                    lanes.corners[c][a][i] = unit.to_unit(corner[a], a);
                }
            }
        }
        lanes
    }
}

/// A pose of a tool in a scaled frame (`(x - origin) * scale`), for float32 boxes in tool units.
#[derive(Debug, Clone)]
pub struct Placement {
    matrix: [[f32; 3]; 3],
    translation: [f32; 3],
    /// By how much every box grows, in frame units; endless where float32 cannot hold the numbers.
    margin: f32,
    /// How far, per axis, a corner may be off, and how much rounding may add to a projection on an axis (per unit of the sum
    /// of its entries), of tool and mock-up together.
    pub slack: f32,
}

/// Something that places boxes of tool entries in a frame: at a pose, or along a way.
pub trait PlaceBoxes {
    /// Boxes around boxes: quick and loose.
    fn place_boxes<S: Simd>(&self, s: S, boxes: &BoxLanes, to: &mut LaneBoxes);
}

impl PlaceBoxes for Placement {
    #[inline(always)]
    fn place_boxes<S: Simd>(&self, s: S, boxes: &BoxLanes, to: &mut LaneBoxes) {
        let margin = s.splat(self.margin);
        let (centre, half) = (load3(s, &boxes.centre), load3(s, &boxes.half));
        for a in 0..3 {
            let row = splat3(s, &self.matrix[a]);
            let t = s.splat(self.translation[a]);
            let c = s.mul_add(row[0], centre[0], s.mul_add(row[1], centre[1], s.mul_add(row[2], centre[2], t)));
            let reach = s.mul_add(s.abs(row[2]), half[2], margin);
            let reach = s.mul_add(s.abs(row[0]), half[0], s.mul_add(s.abs(row[1]), half[1], reach));
            s.store(c - reach, &mut to.lower[a]);
            s.store(c + reach, &mut to.upper[a]);
        }
    }
}

/// How boxes of tool entries at a pose lie along sixteen axes of a frame, one a lane.
pub struct Along<S: Simd> {
    /// The tool's axes along them, and its place.
    axes: [S::F32; 3],
    at: S::F32,
    /// Bound of the rounding.
    slack: S::F32,
}

impl<S: Simd> Along<S> {
    /// The interval of one of sixteen boxes along each axis, grown by all slack of the tool's.
    #[inline(always)]
    pub fn interval(&self, s: S, boxes: &BoxLanes, i: usize) -> (S::F32, S::F32) {
        let (mut middle, mut reach) = (self.at, self.slack);
        for a in 0..3 {
            middle = s.mul_add(self.axes[a], s.splat(boxes.centre[a][i]), middle);
            reach = s.mul_add(s.abs(self.axes[a]), s.splat(boxes.half[a][i]), reach);
        }
        (middle - reach, middle + reach)
    }
}

impl Placement {
    /// For intervals of boxes along sixteen axes. The slack of a projection of corners ([`Placement::new`]) holds here too: with m
    /// the sum of an axis's entries, the tool's axes along it are off by three roundings of m each, the middle and the reach by
    /// seven more of m times the size of the coordinates, and that slack has sixteen.
    #[inline(always)]
    pub fn along<S: Simd>(&self, s: S, n: &[S::F32; 3]) -> Along<S> {
        let mut axes = *n;
        for k in 0..3 {
            let row = [s.splat(self.matrix[0][k]), s.splat(self.matrix[1][k]), s.splat(self.matrix[2][k])];
            axes[k] = s.mul_add(row[0], n[0], s.mul_add(row[1], n[1], row[2] * n[2]));
        }
        let t = splat3(s, &self.translation);
        let at = s.mul_add(t[0], n[0], s.mul_add(t[1], n[1], t[2] * n[2]));
        let slack = s.splat(self.slack);
        let slack = s.mul_add(s.abs(n[0]) + s.abs(n[1]) + s.abs(n[2]), slack, s.splat(TINY));
        Along { axes, at, slack }
    }

    /// `margin` (metres) covers the uncertainty of the tool's coordinates at the pose in float64.
    ///
    /// The rest of the margin is float32's. With m the sum of a row's absolute entries and t the translation, a coordinate is
    /// `sum of three products + t`, at most m + t as tool units are at most 1: one rounding each of entry, coordinate, product
    /// and sums makes six roundings of 2^-24 of m + t, and converting the frame's own float64 coordinates (of the same size)
    /// two more. 2^-20 of m + t is twice that. The last term covers products that underflow.
    ///
    /// A projection of such coordinates (the mock-up's are at most 1) on an axis has four roundings more of the sum of the
    /// axis's entries times m + t + 1, on each side: 2^-20 of it again.
    pub fn new(unit: &ToolUnit, pose: &Pose, margin: f64, origin: &[f64; 3], scale: f64) -> Placement {
        let ratio = unit.metres * scale;
        let centre = pose.apply(&unit.centre);
        let translation: [f64; 3] = std::array::from_fn(|a| (centre[a] - origin[a]) * scale);
        let matrix = pose.rotation().map(|row| row.map(|x| x * ratio));
        let size = 3.1 * ratio + translation.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let margin = 1.001 * (margin * scale + size * PLACEMENT_ROUNDING + LEAST_MARGIN);
        let slack = 1.001 * (margin + (size + 1.0) * PLACEMENT_ROUNDING);
        if size < LARGEST_PLACEMENT && slack < LARGEST_PLACEMENT {
            Placement {
                matrix: matrix.map(|row| row.map(|x| x as f32)),
                translation: translation.map(|x| x as f32),
                margin: margin as f32,
                slack: slack as f32,
            }
        } else {
            // Boxes are endless, and nothing is ever beside a plane.
            let (matrix, translation) = ([[0.0; 3]; 3], [0.0; 3]);
            Placement { matrix, translation, margin: f32::INFINITY, slack: f32::INFINITY }
        }
    }

    /// By how much boxes grow, frame units.
    pub fn margin(&self) -> f32 {
        self.margin
    }

    /// Pieces at the pose.
    #[inline(always)]
    pub fn place_pieces<S: Simd>(&self, s: S, pieces: &PieceLanes, out: &mut PlacedPieces) {
        let margin = s.splat(self.margin);
        out.has_normals = false;
        let (mut lower, mut upper) = ([margin; 3], [margin; 3]);
        for a in 0..3 {
            let row = splat3(s, &self.matrix[a]);
            let t = s.splat(self.translation[a]);
            let mut at = [t; 4];
            for c in 0..4 {
                let p = load3(s, &pieces.corners[c]);
                at[c] = s.mul_add(row[0], p[0], s.mul_add(row[1], p[1], s.mul_add(row[2], p[2], t)));
                s.store(at[c], &mut out.corners[c][a]);
            }
            let low = least4(s, &at) - margin;
            let high = greatest4(s, &at) + margin;
            s.store(low, &mut out.boxes.lower[a]);
            s.store(high, &mut out.boxes.upper[a]);
            (lower[a], upper[a]) = (low, high);
        }
        out.bounds = Box4 { lower: s.smallest3(&lower), upper: s.largest3(&upper) };
    }
}
