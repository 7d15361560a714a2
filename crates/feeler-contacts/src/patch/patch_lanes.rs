//! The planes of patches as structures of arrays, each patch laid out once a precision for all half-space tests of a
//! surface.
//!
//! Sixteen patches at once in float32, in their order, answer where a point clearly is
//! ([`half_space_filter`](super::half_space_filter)); eight at once in float64, body by body, answer where it is
//! strictly ([`half_spaces`](super::half_spaces)).

use crate::constants::{HOLLOW, HOLLOW_OF_PLANE};
use crate::patch::surface_patch::{part, Patch};
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{dot, sub};
use feeler_lanes::{Wide, LANES, WIDE_LANES};

/// Sixteen float32 in one cache line.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(64))]
pub(super) struct Lanes(pub [f32; LANES]);

/// Planes of sixteen patches in float32, relative to a point among them and scaled to their size.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SixteenPlanes {
    pub normal: [Lanes; 3],
    pub middle: [Lanes; 3],
    /// Height of the middle over the patch's plane.
    pub height: Lanes,
}

/// Planes of eight patches in float64.
#[derive(Debug)]
pub(super) struct EightPlanes {
    pub normal: [Wide; 3],
    pub at: [Wide; 3],
    pub middle: [Wide; 3],
    /// Square of the least sine, seen from the middle, of points that count as above the plane: [`HOLLOW_OF_PLANE`] for
    /// flat patches, [`HOLLOW`] for others.
    pub share: Wide,
}

impl EightPlanes {
    /// Eight times one patch.
    fn all(patch: &Patch) -> EightPlanes {
        let all = |x: &Point| x.map(|c| Wide([c; WIDE_LANES]));
        let (normal, at, middle) = (all(&patch.normal), all(&patch.at), all(&patch.middle));
        EightPlanes { normal, at, middle, share: Wide([share(patch); WIDE_LANES]) }
    }

    fn put(&mut self, lane: usize, patch: &Patch) {
        for a in 0..3 {
            self.normal[a][lane] = patch.normal[a];
            self.at[a][lane] = patch.at[a];
            self.middle[a][lane] = patch.middle[a];
        }
        self.share[lane] = share(patch);
    }
}

fn share(patch: &Patch) -> f64 {
    let sine = if patch.flat { HOLLOW_OF_PLANE } else { HOLLOW };
    sine * sine
}

/// The planes of the patches of a surface. Kept as working memory.
#[derive(Debug, Default)]
pub(crate) struct PatchLanes {
    pub(super) sixteens: Vec<SixteenPlanes>,
    eights: Vec<EightPlanes>,
    /// For each body the range of its eights.
    bodies: Vec<(u32, u32)>,
    origin: Point,
    scale: f64,
}

impl PatchLanes {
    /// Lays out the planes in float32; there are no bodies yet.
    pub fn set(&mut self, patches: &[Patch]) {
        self.eights.clear();
        self.bodies.clear();
        self.sixteens.clear();
        self.origin = patches.first().map_or([0.0; 3], |patch| patch.middle);
        let farthest = |p: &Patch| sub(&p.middle, &self.origin).iter().fold(p.size, |m, x| m.max(x.abs()));
        let largest = patches.iter().map(farthest).fold(0.0, f64::max);
        self.scale = if largest.is_normal() { largest.recip() } else { 1.0 };
        self.sixteens.resize(patches.len().div_ceil(LANES), SixteenPlanes::default());
        for (i, patch) in patches.iter().enumerate() {
            let middle = self.local(&patch.middle);
            let (sixteen, lane) = (&mut self.sixteens[i / LANES], i % LANES);
            for a in 0..3 {
                (sixteen.normal[a].0[lane], sixteen.middle[a].0[lane]) = (patch.normal[a] as f32, middle[a]);
            }
            sixteen.height.0[lane] = (dot(&sub(&patch.middle, &patch.at), &patch.normal) * self.scale) as f32;
        }
    }

    /// Lays out the planes of the next body in float64; the last eight is filled up with one of its patches.
    pub fn push_body<'a>(&mut self, patches: impl Iterator<Item = &'a Patch>) {
        let from = self.eights.len();
        for (i, patch) in patches.enumerate() {
            match self.eights.last_mut() {
                Some(eight) if i % WIDE_LANES > 0 => eight.put(i % WIDE_LANES, patch),
                _ => self.eights.push(EightPlanes::all(patch)),
            }
        }
        self.bodies.push((from as u32, self.eights.len() as u32));
    }

    pub(super) fn eights_of(&self, body: usize) -> &[EightPlanes] {
        part(&self.eights, self.bodies[body])
    }

    /// A point as the float32 planes see it: relative to the origin, and scaled.
    #[inline(always)]
    pub(super) fn local(&self, p: &Point) -> [f32; 3] {
        sub(p, &self.origin).map(|x| (x * self.scale) as f32)
    }
}
