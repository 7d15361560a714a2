//! Patches grouped into convex bodies: a greedy cover of the patches by cliques of mutually compatible ones.
//!
//! Two patches are compatible if the middle of neither extends over the plane of the other by more than
//! [`HOLLOW`](crate::constants::HOLLOW). Patches are taken largest first, and each joins the first body whose patches
//! are all compatible with it. The result is an approximate convex decomposition of the surface (Lien & Amato 2004, who
//! cut a solid along its notches until each part is convex enough); here patches are only grouped and never cut, since
//! the depth search needs only a set of half-spaces and a set of points for each body.
//!
//! Bodies are grouped anew in each contact region, and differ from those of the mesh (`Adjacency::body_of`), which give
//! a contact its identity: two faces beside a convex edge bound one body there, although far away one of them may
//! extend over the plane of the other. With the bodies of the mesh, a tooth in its slot would get planes for parts of
//! its walls, and waves that fit each other would lose theirs.

use crate::containers::bit_set::{is_meeting, BitSets};
use crate::patch::patch_lanes::PatchLanes;
use crate::patch::patches::Patches;
use feeler_core::geometry::bounds::Point;
use feeler_lanes::Checked;

/// The convex bodies of one surface in a contact region, largest first. Kept as working memory.
#[derive(Debug, Default)]
pub(crate) struct ConvexBodies {
    /// For each body its patches. Entries from `count` on are left over.
    pub patches: Vec<Vec<u32>>,
    /// For each body the straddling patches that share a part with it.
    pub shared_patches: Vec<Vec<u32>>,
    /// Number of bodies.
    pub count: usize,
    /// For each body the set of its patches.
    members: BitSets,
    /// The planes of all patches; of the bodies those that have shared patches.
    pub planes: PatchLanes,
    /// For each patch the patches above whose planes its middle is.
    planes_below: BitSets,
    /// For each patch those whose middles are above its plane: the transpose.
    middles_above: BitSets,
    /// For each corner the patches above whose planes it is.
    corner_above: BitSets,
    /// For each corner, before that for each middle, the patches below whose planes it is.
    below: BitSets,
    /// Patches that exclude a patch, or the shared part of one, from their body.
    excluded: Vec<u64>,
    middles: Vec<Point>,
    straddling: Vec<u32>,
}

impl ConvexBodies {
    /// Groups patches, which come largest first, into bodies.
    ///
    /// A straddling patch has corners on both sides of another's plane, as the end face of an L has for both legs. It
    /// founds a body only if it can share a part with none; otherwise each body takes the points of it that lie below
    /// all planes of the body.
    pub fn set(&mut self, lanes: Checked, patches: &Patches) {
        let count = patches.list.len();
        self.count = 0;
        self.members.clear(count, count);
        self.planes_below.clear(count, count);
        self.straddling.clear();
        self.planes.set(&patches.list);
        self.middles.clear();
        self.middles.extend(patches.list.iter().map(|p| p.middle));
        self.below.clear(count, count);
        self.planes.classify(lanes, &self.middles, &mut self.planes_below, &mut self.below);
        self.middles_above.transpose(&self.planes_below, count);
        self.corner_above.clear(patches.all_corners().len(), count);
        self.below.clear(patches.all_corners().len(), count);
        self.planes.classify(lanes, patches.all_corners(), &mut self.corner_above, &mut self.below);
        for (i, patch) in patches.list.iter().enumerate() {
            let corners = patches.corners(patch);
            if self.corner_above.is_meeting_union(&self.below, corners) {
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
            let mut is_shared = false;
            let corners = patches.corners(&patches.list[i as usize]);
            // A body is out of the question if one of its patches has its middle above this plane, or all these corners
            // above its own.
            self.excluded.clear();
            self.excluded.extend_from_slice(self.middles_above.get(i as usize));
            self.corner_above.join_common(corners, &mut self.excluded);
            for c in 0..bodies {
                if self.is_partly_within(corners, c) {
                    is_shared = true;
                    self.shared_patches[c].push(i);
                }
            }
            if !is_shared {
                self.join_or_found(i, bodies);
            }
        }
        self.straddling = straddling;
        for (own, shared) in self.patches.iter().zip(&self.shared_patches).take(self.count) {
            let is_asked = !shared.is_empty();
            self.planes.push_body(own.iter().filter(|_| is_asked).map(|p| &patches.list[*p as usize]));
        }
    }

    /// Adds a patch to the first body, from one on, with all of whose patches it is compatible, or founds a body.
    fn join_or_found(&mut self, i: u32, from: usize) {
        let either =
            self.planes_below.get(i as usize).iter().zip(self.middles_above.get(i as usize)).map(|(x, y)| x | y);
        self.excluded.clear();
        self.excluded.extend(either);
        let is_compatible = |c: &usize| !is_meeting(&self.excluded, self.members.get(*c));
        let c = (from..self.count).find(is_compatible).unwrap_or_else(|| {
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

    /// Whether none of a body's patches is excluded, and at least one of the corners is above none of their planes.
    fn is_partly_within(&self, corners: &[u32], c: usize) -> bool {
        let members = self.members.get(c);
        !is_meeting(&self.excluded, members)
            && corners.iter().any(|k| !is_meeting(self.corner_above.get(*k as usize), members))
    }
}
