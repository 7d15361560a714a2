//! Planes between the tool and parts of the mock-up, in lanes: they hold pairs of pieces apart before anything else is asked.

use super::node::Frame;
use super::pieces::HalfBlock;
use crate::lanes::{load3, Lane32, PlacedPieces, LANES};
use crate::proximity::Divider;
use crate::simd::Simd;

/// Up to sixteen planes of one part, in the frame.
#[derive(Debug)]
pub struct Dividers {
    part: u32,
    normals: [Lane32; 3],
    /// The highest that the mock-up's pieces may be, and the lowest that the tool's may.
    highest: Lane32,
    lowest: Lane32,
    /// How far rounding may take a tool's corner along the normal.
    slack: Lane32,
}

impl Dividers {
    /// Of planes sorted by part the first sixteen of each.
    pub fn new(planes: &[Divider], frame: &Frame, slack: f32) -> Vec<Dividers> {
        let of_part = |planes: &[Divider]| {
            let mut lanes = Dividers {
                part: planes[0].part,
                normals: [[0.0; LANES]; 3],
                // Nothing is so low.
                highest: [f32::NEG_INFINITY; LANES],
                lowest: [0.0; LANES],
                slack: [0.0; LANES],
            };
            for (i, plane) in planes.iter().take(LANES).enumerate() {
                let n = &plane.normal;
                (0..3).for_each(|a| lanes.normals[a][i] = n[a] as f32);
                let origin: f64 = (0..3).map(|a| n[a] * frame.origin[a]).sum();
                let [highest, lowest] = plane.heights.map(|h| ((h - origin) * frame.scale) as f32);
                // Normals and heights are rounded themselves: coordinates are at most a few units.
                lanes.slack[i] = 2.0 * slack;
                lanes.highest[i] = highest - slack;
                lanes.lowest[i] = lowest;
            }
            lanes
        };
        planes.chunk_by(|p, q| p.part == q.part).map(of_part).collect()
    }

    /// Those of a part.
    #[inline(always)]
    pub fn of(all: &[Dividers], part: u32) -> Option<&Dividers> {
        let mut i = 0;
        while i < all.len() && all[i].part != part {
            i += 1;
        }
        all.get(i)
    }

    /// Of some lanes of a cluster those that no plane surely holds apart from a piece of a block.
    #[inline(always)]
    pub fn sift<S: Simd>(&self, s: S, placed: &PlacedPieces, half: &HalfBlock, piece: usize, lanes: u32) -> u32 {
        let mut lanes = lanes;
        let (_, far) = half.along(s, piece, &load3(s, &self.normals));
        let mut below = !s.above(far, s.load(&self.highest));
        while below != 0 && lanes != 0 {
            let i = below.trailing_zeros() as usize;
            below &= below - 1;
            let n = [s.splat(self.normals[0][i]), s.splat(self.normals[1][i]), s.splat(self.normals[2][i])];
            let (near, _) = placed.along(s, &n);
            lanes &= !u32::from(s.above(near, s.splat(self.lowest[i] + self.slack[i])));
        }
        lanes
    }
}
