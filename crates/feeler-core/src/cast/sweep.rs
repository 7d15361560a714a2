//! The cast in windows of time: the store offers the pairs that may meet in a window, and each of these is followed through it.
//!
//! A long window is a loose one: boxes around the tool's whole way meet much that the tool passes by. A short one costs a
//! descent for little progress. So a window that offers too many pairs is cut, and the next one after few pairs is longer.

use super::motion::Motion;
use super::pair::Moving;
use super::Impact;
use crate::scene::Scene;
use crate::store::{Sweep, SweepScratch};
use crate::tool::Tool;

/// Pairs that a window may offer before it is cut, for a small tool; a large one's descents cost more, and bring more.
const FEW_PAIRS: usize = 96;

/// Each cut allows twice as many pairs and makes the window four times shorter: where everything is near everything cutting
/// does not help, and is soon given up.
const CUT: f64 = 0.25;

/// Cuts at most; then pairs are followed as they come, however many there are.
const MOST_CUTS: u32 = 10;

/// Voxels that may be looked up for each pair allowed.
const VOXELS_PER_PAIR: u64 = 64;

/// Working memory of a cast.
#[derive(Debug, Default)]
pub(crate) struct CastScratch {
    store: SweepScratch,
    /// Slot of the tool, and triangle of the mock-up, in one number.
    pairs: Vec<u64>,
}

/// The first impact of a tool on its way.
pub(super) fn first_impact(
    scene: &Scene,
    tool: &Tool,
    motion: &Motion,
    tolerance: f64,
    scratch: &mut CastScratch,
) -> Option<Impact> {
    let few = FEW_PAIRS.max(tool.clusters().len());
    // Shorter than this a window is no use: all it holds is within the tolerance.
    let shortest = tolerance / motion.longest_way().max(tolerance);
    let (mut from, mut cuts) = (0.0, 0);
    while from < 1.0 {
        let length = CUT.powi(cuts as i32);
        let to = if from + length < 1.0 { from + length } else { 1.0 };
        let limit = few << cuts;
        let may_cut = cuts < MOST_CUTS && length > shortest;
        let mut chase = Chase { scene, tool, motion, tolerance, from, best: None, until: to };
        let sweep = Sweep {
            mesh: scene.mockup().mesh(),
            tool,
            window: motion.window(tool, from, to),
            lanes: scene.checked_lanes(),
            effort: if may_cut { VOXELS_PER_PAIR * limit as u64 } else { u64::MAX },
        };
        let CastScratch { store, pairs } = &mut *scratch;
        pairs.clear();
        let mut is_full = false;
        let all_seen = scene.store().offer_swept(&sweep, store, &mut |slot, triangle| {
            pairs.push(u64::from(slot) << 32 | u64::from(triangle));
            if pairs.len() < limit {
                return false;
            }
            if may_cut {
                is_full = true;
                return true;
            }
            chase.follow(pairs, &sweep.window.poses[0]);
            // Nothing is earlier than the beginning.
            chase.until <= from
        });
        if is_full || !all_seen {
            cuts += 1;
            continue;
        }
        let offered = pairs.len();
        chase.follow(pairs, &sweep.window.poses[0]);
        if chase.best.is_some() {
            return chase.best;
        }
        from = to;
        cuts = cuts.saturating_sub(u32::from(offered < limit / 4));
    }
    None
}

/// Follows pairs through a window.
struct Chase<'a> {
    scene: &'a Scene,
    tool: &'a Tool,
    motion: &'a Motion,
    tolerance: f64,
    from: f64,
    until: f64,
    best: Option<Impact>,
}

impl Chase<'_> {
    /// Follows each pair once, and empties the list.
    fn follow(&mut self, pairs: &mut Vec<u64>, pose: &crate::pose::Pose) {
        pairs.sort_unstable();
        pairs.dedup();
        let mesh = self.scene.mockup().mesh();
        let mut moving: Option<(u32, Moving<'_>)> = None;
        for &pair in pairs.iter() {
            let (slot, triangle) = ((pair >> 32) as u32, pair as u32);
            if moving.as_ref().is_none_or(|(s, _)| *s != slot) {
                moving = Some((slot, Moving::new(self.motion, self.tool.placeable()[slot as usize])));
            }
            let Some((_, moving)) = &moving else { continue };
            let q = mesh.triangle(triangle);
            if let Some(time) = moving.first_impact(&q, self.from, self.until, pose, self.tolerance) {
                self.until = time;
                let tool_triangle = self.tool.ids()[slot as usize];
                self.best = Some(Impact { time, tool_triangle, mockup_triangle: triangle });
            }
        }
        pairs.clear();
    }
}
