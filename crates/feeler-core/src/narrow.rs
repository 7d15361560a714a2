//! The narrow phase: candidate pairs go through two filters to the triangle test.

use crate::bounds::{Aabb, Triangle};
use crate::defects::corners;
use crate::intersect_triangle_triangle::{intersect_with, PairKind, Plane};
use crate::mesh::Mesh;
use crate::pose::Pose;
use crate::predicates::Signs;
use crate::tool::Tool;

/// Which filters stand before the triangle test. Neither changes the answer; they can be switched off to measure what they
/// bring.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Filters {
    /// Pairs met again (in another voxel, or by another piece) are skipped.
    pub repeats: bool,
    /// The boxes of the two triangles are compared first.
    pub boxes: bool,
}

impl Default for Filters {
    fn default() -> Filters {
        Filters { repeats: true, boxes: true }
    }
}

/// What a query did, stage by stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Stats {
    /// Voxels looked up; with blocks, nodes whose 32 children were tested against a box.
    pub voxels_visited: u64,
    /// Pairs of tool triangle and list entry; with blocks, pairs of pieces whose boxes meet.
    pub entries_scanned: u64,
    /// Pairs skipped because they had been seen.
    pub repeats_skipped: u64,
    /// Pairs whose triangles' boxes meet (all of them when that filter is off).
    pub box_survivors: u64,
    /// Triangle tests.
    pub triangle_tests: u64,
    /// Triangle tests in which float64 arithmetic could not decide and exact arithmetic did.
    pub exact_tests: u64,
    /// Distinct pairs that meet.
    pub pairs: u64,
}

impl Stats {
    /// Names and values, in order of the stages.
    pub fn entries(&self) -> [(&'static str, u64); 7] {
        [
            ("voxels_visited", self.voxels_visited),
            ("entries_scanned", self.entries_scanned),
            ("repeats_skipped", self.repeats_skipped),
            ("box_survivors", self.box_survivors),
            ("triangle_tests", self.triangle_tests),
            ("exact_tests", self.exact_tests),
            ("pairs", self.pairs),
        ]
    }
}

/// A tool triangle at the pose.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlacedTriangle {
    pub corners: Triangle,
    pub bounds: Aabb,
    pub plane: Plane,
}

/// The tool at a pose. Triangles are placed when first needed, so that a large tool in empty space costs little.
#[derive(Debug, Default)]
pub(crate) struct PlacedTool {
    triangles: Vec<PlacedTriangle>,
    /// `placed[t] == query` where triangle `t` is up to date.
    placed: Vec<u32>,
    query: u32,
}

impl PlacedTriangle {
    fn new(corners: Triangle) -> PlacedTriangle {
        PlacedTriangle { corners, bounds: Aabb::of_triangle(&corners), plane: Plane::of_triangle(&corners) }
    }
}

impl PlacedTool {
    /// Forgets the last query and makes room for `tool`.
    pub fn begin(&mut self, tool: &Tool) {
        let count = tool.mesh().faces().len();
        if self.placed.len() < count {
            self.triangles.resize(count, PlacedTriangle::new([[0.0; 3]; 3]));
            self.placed.resize(count, 0);
        }
        if self.query == u32::MAX {
            self.placed.fill(0);
            self.query = 0;
        }
        self.query += 1;
    }

    /// A triangle at the pose.
    #[inline]
    pub fn triangle(&mut self, tool: &Tool, pose: &Pose, id: u32) -> &PlacedTriangle {
        let i = id as usize;
        if self.placed[i] != self.query {
            self.placed[i] = self.query;
            self.triangles[i] = PlacedTriangle::new(pose.apply_triangle(&tool.mesh().triangle(id)));
        }
        &self.triangles[i]
    }
}

/// A set of triangle pairs that empties in constant time.
#[derive(Debug, Default)]
pub(crate) struct PairSet {
    slots: Vec<(u64, u32)>,
    query: u32,
    len: usize,
}

impl PairSet {
    /// Empties the set.
    pub fn clear(&mut self) {
        if self.slots.is_empty() {
            self.slots = vec![(0, 0); 1024];
        }
        if self.query == u32::MAX {
            self.slots.fill((0, 0));
            self.query = 0;
        }
        self.query += 1;
        self.len = 0;
    }

    /// Adds a pair; false when it was there.
    #[inline]
    pub fn insert(&mut self, key: u64) -> bool {
        if 2 * self.len >= self.slots.len() {
            self.grow();
        }
        let mask = self.slots.len() - 1;
        let mut at = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & mask;
        while self.slots[at].1 == self.query {
            if self.slots[at].0 == key {
                return false;
            }
            at = (at + 1) & mask;
        }
        self.slots[at] = (key, self.query);
        self.len += 1;
        true
    }

    #[cold]
    fn grow(&mut self) {
        let old = std::mem::take(&mut self.slots);
        let query = std::mem::replace(&mut self.query, 1);
        self.slots = vec![(0, 0); 2 * old.len()];
        self.len = 0;
        for (key, _) in old.into_iter().filter(|slot| slot.1 == query) {
            self.insert(key);
        }
    }
}

/// Pairs tested at a time: enough for their cache misses to overlap, few enough for the corners to stay in the first cache.
const BATCH: usize = 128;

/// The same where the first pair found ends the query.
const FIRST_BATCH: usize = 16;

/// Candidate pairs that wait for their test, and room for their indices and corners.
#[derive(Debug, Default)]
pub(crate) struct Pending {
    pairs: Vec<(u32, u32)>,
    faces: Vec<[u32; 3]>,
    triangles: Vec<Triangle>,
}

impl Pending {
    /// Forgets what a query that was over early left.
    pub fn clear(&mut self) {
        self.pairs.clear();
    }
}

/// One query's narrow phase. Stores offer candidate pairs to it.
pub(crate) struct Narrow<'a> {
    pub mesh: &'a Mesh,
    pub tool: &'a Tool,
    pub pose: &'a Pose,
    pub filters: Filters,
    /// Stop at the first pair found.
    pub first_only: bool,
    pub placed: &'a mut PlacedTool,
    pub seen: &'a mut PairSet,
    pub pending: &'a mut Pending,
    /// Found pairs: tool triangle in the upper half, mock-up triangle in the lower.
    pub hits: &'a mut Vec<(u64, PairKind)>,
    pub stats: &'a mut Stats,
}

impl Narrow<'_> {
    /// The box of a tool triangle at the pose.
    #[inline]
    pub fn placed_bounds(&mut self, tool_triangle: u32) -> Aabb {
        self.placed.triangle(self.tool, self.pose, tool_triangle).bounds
    }

    /// Takes a candidate pair; true when the query is over. `may_repeat` says whether the pair could be offered again.
    ///
    /// Pairs are kept until there are enough for a batch; the last ones wait for [`finish`](Self::finish).
    #[inline]
    pub fn offer(&mut self, tool_triangle: u32, mockup_triangle: u32, may_repeat: bool) -> bool {
        self.stats.entries_scanned += 1;
        let key = pair_key(tool_triangle, mockup_triangle);
        if may_repeat && self.filters.repeats && !self.seen.insert(key) {
            self.stats.repeats_skipped += 1;
            return false;
        }
        self.pending.pairs.push((tool_triangle, mockup_triangle));
        let batch = if self.first_only { FIRST_BATCH } else { BATCH };
        self.pending.pairs.len() >= batch && self.finish()
    }

    /// Tests the pairs kept so far; true when the query is over.
    pub fn finish(&mut self) -> bool {
        let Pending { pairs, faces, triangles } = self.pending;
        // All indices, then all corners: loads that do not wait for each other, so that their cache misses overlap.
        faces.clear();
        faces.extend(pairs.iter().map(|(_, m)| self.mesh.faces()[*m as usize]));
        triangles.clear();
        triangles.extend(faces.iter().map(|face| corners(self.mesh.vertices(), face)));
        // Pairs come in runs of one mock-up triangle: its box and plane are made once a run.
        let mut run = None;
        for (&(tool_triangle, mockup_triangle), q) in pairs.iter().zip(triangles.iter()) {
            let (bounds, plane) = match run {
                Some((triangle, bounds, plane)) if triangle == mockup_triangle => (bounds, plane),
                _ => (Aabb::of_triangle(q), Plane::of_triangle(q)),
            };
            run = Some((mockup_triangle, bounds, plane));
            let p = self.placed.triangle(self.tool, self.pose, tool_triangle);
            if self.filters.boxes && !p.bounds.is_overlapping(&bounds) {
                continue;
            }
            self.stats.box_survivors += 1;
            self.stats.triangle_tests += 1;
            if plane.is_surely_beside(&p.corners) || p.plane.is_surely_beside(q) {
                continue;
            }
            let mut signs = Signs::default();
            let meeting = intersect_with(&mut signs, &p.corners, q);
            self.stats.exact_tests += u64::from(signs.exact > 0);
            if let Some(kind) = meeting {
                self.hits.push((pair_key(tool_triangle, mockup_triangle), kind));
                if self.first_only {
                    break;
                }
            }
        }
        pairs.clear();
        self.first_only && !self.hits.is_empty()
    }
}

fn pair_key(tool_triangle: u32, mockup_triangle: u32) -> u64 {
    u64::from(tool_triangle) << 32 | u64::from(mockup_triangle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pair_set_remembers_through_growth_and_forgets_on_clear() {
        let mut set = PairSet::default();
        for round in 0..3 {
            set.clear();
            for key in 0..5000u64 {
                assert!(set.insert(key * 77 + round), "{key}");
            }
            for key in 0..5000u64 {
                assert!(!set.insert(key * 77 + round), "{key}");
            }
        }
    }
}
