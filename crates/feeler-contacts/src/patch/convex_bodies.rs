//! Patches that bulge the same way together.

use crate::containers::bit_set::{is_meeting, BitSets};
use crate::patch::half_space_filter::HalfSpaceFilter;
use crate::patch::patches::Patches;
use feeler_core::geometry::bounds::Point;
use feeler_lanes::Checked;

/// Patches of which none stands out over the plane of another: together, part of a convex body. The largest first. Kept as
/// working memory.
#[derive(Debug, Default)]
pub(crate) struct ConvexBodies {
    /// Patches of each.
    pub patches: Vec<Vec<u32>>,
    /// Patches of which a part belongs to it.
    pub shared_patches: Vec<Vec<u32>>,
    /// How many there are; what lies behind in the lists is memory.
    pub count: usize,
    members: BitSets,
    judge: HalfSpaceFilter,
    /// For each patch the patches over whose planes its middle stands out.
    over: BitSets,
    /// For each patch those whose middles stand out over its plane.
    below: BitSets,
    /// Over which planes each corner of a patch stands out.
    corner_over: BitSets,
    /// Those under whose planes the same corner or middle is.
    under: BitSets,
    /// Patches that a patch or a part of it is not with.
    barred: Vec<u64>,
    middles: Vec<Point>,
    straddling: Vec<u32>,
}

impl ConvexBodies {
    /// Sorts patches, the largest first, into clusters.
    ///
    /// A patch that reaches from behind another's plane to before it, as the end of an L does with both its legs, makes no body
    /// of its own if it can help: it lends its nearer part to each.
    pub fn set(&mut self, lanes: Checked, patches: &Patches) {
        let count = patches.list.len();
        self.count = 0;
        self.members.clear(count, count);
        self.over.clear(count, count);
        self.straddling.clear();
        self.judge.set(&patches.list);
        self.middles.clear();
        self.middles.extend(patches.list.iter().map(|p| p.middle));
        self.under.clear(count, count);
        self.judge.judge(lanes, &self.middles, &mut self.over, &mut self.under);
        self.below.transpose(&self.over, count);
        self.corner_over.clear(patches.all_corners().len(), count);
        self.under.clear(patches.all_corners().len(), count);
        self.judge.judge(lanes, patches.all_corners(), &mut self.corner_over, &mut self.under);
        for (i, patch) in patches.list.iter().enumerate() {
            let corners = patches.corners(patch);
            if self.corner_over.is_meeting_union(&self.under, corners) {
                self.straddling.push(i as u32);
            }
        }
        let mut straddling = std::mem::take(&mut self.straddling);
        let mut next = straddling.iter().copied().peekable();
        for i in 0..count as u32 {
            if next.next_if_eq(&i).is_none() {
                self.join_or_found(i, 0);
            }
        }
        let bodies = self.count;
        for i in straddling.drain(..) {
            let mut shared_patches = false;
            let corners = patches.corners(&patches.list[i as usize]);
            self.barred.clear();
            self.barred.extend_from_slice(self.below.get(i as usize));
            self.corner_over.join_common(corners, &mut self.barred);
            for c in 0..bodies {
                if self.is_partly_within(corners, c) {
                    shared_patches = true;
                    self.shared_patches[c].push(i);
                }
            }
            if !shared_patches {
                self.join_or_found(i, bodies);
            }
        }
        self.straddling = straddling;
    }

    /// Adds a patch to the first cluster, from one on, that it bulges with.
    fn join_or_found(&mut self, i: u32, from: usize) {
        self.barred.clear();
        self.barred.extend(self.over.get(i as usize).iter().zip(self.below.get(i as usize)).map(|(o, b)| o | b));
        let fits = |c: &usize| !is_meeting(&self.barred, self.members.get(*c));
        let c = (from..self.count).find(fits).unwrap_or_else(|| {
            if self.patches.len() == self.count {
                self.patches.push(Vec::new());
                self.shared_patches.push(Vec::new());
            }
            self.patches[self.count].clear();
            self.shared_patches[self.count].clear();
            self.count += 1;
            self.count - 1
        });
        self.patches[c].push(i);
        self.members.insert(c, i as usize);
    }

    /// Whether none of a cluster's patches is barred, and one of some corners is over none of them.
    fn is_partly_within(&self, corners: &[u32], c: usize) -> bool {
        let members = self.members.get(c);
        !is_meeting(&self.barred, members)
            && corners.iter().any(|k| !is_meeting(self.corner_over.get(*k as usize), members))
    }
}
