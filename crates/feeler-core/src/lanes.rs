//! Sixteen boxes or pieces side by side, and their places at a pose, in float32.
//!
//! Lane `i` of each array belongs to entry `i`. The loops over lanes are written so that compilers turn them into vector
//! instructions.

use crate::bounds::Aabb;
use crate::pieces::Piece;
use crate::pose::Pose;

/// Lanes of an array.
pub const LANES: usize = 16;

/// Axis-aligned boxes, by axis and lane. Lanes from `count` on are not used.
#[derive(Debug, Clone)]
pub struct LaneBoxes {
    /// Smallest coordinates.
    pub lower: [[f32; LANES]; 3],
    /// Largest coordinates.
    pub upper: [[f32; LANES]; 3],
    /// Lanes used.
    pub count: usize,
}

impl LaneBoxes {
    /// No lane used.
    pub const EMPTY: LaneBoxes = LaneBoxes { lower: [[0.0; LANES]; 3], upper: [[0.0; LANES]; 3], count: 0 };
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
pub struct BoxLanes {
    centre: [[f32; LANES]; 3],
    half: [[f32; LANES]; 3],
    count: usize,
}

/// Corners of up to 16 pieces in tool units.
#[derive(Debug, Clone)]
pub struct PieceLanes {
    /// By corner, axis and lane.
    corners: [[[f32; LANES]; 3]; 4],
    count: usize,
}

impl ToolUnit {
    /// The unit for a tool with this box.
    pub fn new(bounds: &Aabb) -> ToolUnit {
        let centre = std::array::from_fn(|a| 0.5 * bounds.lower[a] + 0.5 * bounds.upper[a]);
        let longest = bounds.extent().iter().fold(0.0f64, |m, x| m.max(*x));
        let exponent = if longest > 0.0 { longest.log2().ceil().clamp(-900.0, 900.0) } else { 0.0 };
        ToolUnit { centre, metres: exponent.exp2() }
    }

    fn to_unit(self, x: f64, axis: usize) -> f32 {
        ((x - self.centre[axis]) / self.metres) as f32
    }
}

impl BoxLanes {
    /// At most 16 boxes.
    pub fn new(boxes: &[Aabb], unit: &ToolUnit) -> BoxLanes {
        let mut lanes = BoxLanes { centre: [[0.0; LANES]; 3], half: [[0.0; LANES]; 3], count: boxes.len() };
        for (i, b) in boxes.iter().enumerate() {
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

impl PieceLanes {
    /// At most 16 pieces.
    pub fn new<'a>(pieces: impl ExactSizeIterator<Item = &'a Piece>, unit: &ToolUnit) -> PieceLanes {
        let mut lanes = PieceLanes { corners: [[[0.0; LANES]; 3]; 4], count: pieces.len() };
        for (i, piece) in pieces.enumerate() {
            for (c, corner) in piece.iter().enumerate() {
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
    /// By how much every box grows, in frame units.
    margin: f32,
    /// False where float32 cannot hold the numbers; boxes are then endless.
    is_finite: bool,
}

impl Placement {
    /// `margin` (metres) covers what is uncertain about the tool's coordinates at the pose in float64.
    ///
    /// The rest of the margin is float32's. With m the sum of a row's absolute entries and t the translation, a coordinate is
    /// `sum of three products + t`, at most m + t as tool units are at most 1: one rounding each of entry, coordinate, product
    /// and sums makes six roundings of 2^-24 of m + t, and converting the frame's own float64 coordinates (of the same size)
    /// two more. 2^-20 of m + t is twice that. The last term covers products that underflow.
    pub fn new(unit: &ToolUnit, pose: &Pose, margin: f64, origin: &[f64; 3], scale: f64) -> Placement {
        let ratio = unit.metres * scale;
        let centre = pose.apply(&unit.centre);
        let translation: [f64; 3] = std::array::from_fn(|a| (centre[a] - origin[a]) * scale);
        let matrix = pose.rotation().map(|row| row.map(|x| x * ratio));
        let size = 3.1 * ratio + translation.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let margin = 1.001 * (margin * scale + size * 2f64.powi(-20) + 1e-30);
        Placement {
            matrix: matrix.map(|row| row.map(|x| x as f32)),
            translation: translation.map(|x| x as f32),
            margin: margin as f32,
            is_finite: size < 1e30 && margin < 1e30,
        }
    }

    /// Boxes around rotated boxes: quick and loose.
    #[inline]
    pub fn place_boxes(&self, boxes: &BoxLanes) -> LaneBoxes {
        let mut out = LaneBoxes { count: boxes.count, ..LaneBoxes::EMPTY };
        for a in 0..3 {
            let [x, y, z] = self.matrix[a];
            let t = self.translation[a];
            for i in 0..LANES {
                let centre = x * boxes.centre[0][i] + y * boxes.centre[1][i] + z * boxes.centre[2][i] + t;
                let reach = x.abs() * boxes.half[0][i] + y.abs() * boxes.half[1][i] + z.abs() * boxes.half[2][i];
                out.lower[a][i] = centre - (reach + self.margin);
                out.upper[a][i] = centre + (reach + self.margin);
            }
        }
        self.bound(out)
    }

    /// Boxes around pieces.
    #[inline]
    pub fn place_pieces(&self, pieces: &PieceLanes) -> LaneBoxes {
        let mut out = LaneBoxes { count: pieces.count, ..LaneBoxes::EMPTY };
        for a in 0..3 {
            let [x, y, z] = self.matrix[a];
            let (mut lower, mut upper) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
            for corner in &pieces.corners {
                for i in 0..LANES {
                    let at = x * corner[0][i] + y * corner[1][i] + z * corner[2][i];
                    lower[i] = if at < lower[i] { at } else { lower[i] };
                    upper[i] = if at > upper[i] { at } else { upper[i] };
                }
            }
            for i in 0..LANES {
                out.lower[a][i] = lower[i] + (self.translation[a] - self.margin);
                out.upper[a][i] = upper[i] + (self.translation[a] + self.margin);
            }
        }
        self.bound(out)
    }

    #[inline]
    fn bound(&self, mut boxes: LaneBoxes) -> LaneBoxes {
        if !self.is_finite {
            boxes.lower = [[f32::NEG_INFINITY; LANES]; 3];
            boxes.upper = [[f32::INFINITY; LANES]; 3];
        }
        boxes
    }
}
