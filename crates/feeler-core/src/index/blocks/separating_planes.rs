//! Planes between the tool and parts of the mock-up, in lanes: they separate pairs of pieces before any other test.

use super::node::Frame;
use super::pieces::HalfBlock;
use crate::index::sink::Divider;
use crate::tool::placement::PlacedPieces;
use feeler_lanes::{load3, Lane32, Simd, LANES};

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

/// The pieces of a cluster that are surely above planes, by plane; found out about when first asked for.
#[derive(Debug, Clone, Copy, Default)]
pub struct Above {
    is_known: u16,
    lanes: [u16; LANES],
}

impl Dividers {
    /// Of planes sorted by part the first sixteen of each; of no more than 256 parts.
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
        planes.chunk_by(|p, q| p.part == q.part).take(1 << u8::BITS).map(of_part).collect()
    }

    /// The place among all of those of a part, and which of them a piece of a block surely is behind: none where it has none.
    #[inline(always)]
    pub fn judge<S: Simd>(s: S, all: &[Dividers], part: u32, half: &HalfBlock, piece: usize) -> (u8, u16) {
        let mut i = 0;
        while i < all.len() && all[i].part != part {
            i += 1;
        }
        if i == all.len() {
            return (0, 0);
        }
        let (_, far) = half.along(s, piece, &load3(s, &all[i].normals));
        (i as u8, !s.lanes(s.above(far, s.load(&all[i].highest))))
    }

    /// Of some lanes of a cluster those that are not surely above one of the planes `behind`.
    #[inline(always)]
    pub fn sift<S: Simd>(&self, s: S, placed: &PlacedPieces, above: &mut Above, behind: u16, lanes: u32) -> u32 {
        let (mut behind, mut lanes) = (behind, lanes);
        while behind != 0 && lanes != 0 {
            let i = behind.trailing_zeros() as usize;
            behind &= behind - 1;
            if above.is_known >> i & 1 == 0 {
                above.is_known |= 1 << i;
                let n = [s.splat(self.normals[0][i]), s.splat(self.normals[1][i]), s.splat(self.normals[2][i])];
                let (near, _) = placed.along(s, &n);
                above.lanes[i] = s.lanes(s.above(near, s.splat(self.lowest[i] + self.slack[i])));
            }
            lanes &= !u32::from(above.lanes[i]);
        }
        lanes
    }
}
