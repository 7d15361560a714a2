//! The query: tool tree and block tree are descended together.

use super::node::{Box32, LaneBytes};
use super::{Blocks, FANOUT};
use crate::lanes::{LaneBoxes, Placement, LANES};
use crate::narrow::Narrow;
use crate::tool::Tool;

/// Working memory of a query.
#[derive(Debug, Default)]
pub struct BlocksScratch {
    nodes: Vec<u32>,
    masks: Vec<u16>,
}

impl Blocks {
    /// Offers every pair of pieces whose boxes meet to the narrow phase, until it says stop.
    pub fn offer_candidates(&self, tool: &Tool, scratch: &mut BlocksScratch, narrow: &mut Narrow<'_>) {
        let margin = tool.margin_at(narrow.pose);
        // In float64 first: a tool far away is done with.
        let whole = narrow.pose.apply_box(&tool.mesh().bounds(), margin);
        if !whole.is_overlapping(&narrow.mesh.bounds()) {
            return;
        }
        let placement = Placement::new(tool.unit(), narrow.pose, margin, &self.frame.origin, self.frame.scale);
        scratch.nodes.clear();
        scratch.nodes.push(0);
        let root = self.frame.to_box32(&whole);
        let mut descent =
            Descent { blocks: self, tool, placement, nodes: &mut scratch.nodes, masks: &mut scratch.masks };
        descent.descend(tool.height(), 0, &root, self.levels.len() - 1, 0, narrow);
    }
}

struct Descent<'a> {
    blocks: &'a Blocks,
    tool: &'a Tool,
    placement: Placement,
    /// A stack of node lists; each step of the descent reads the top one and pushes its own.
    nodes: &'a mut Vec<u32>,
    /// The same for the children of tool entries: which of the 16 meet each node of the list.
    masks: &'a mut Vec<u16>,
}

impl Descent<'_> {
    /// Tests tool entry `entry` of `tool_level`, inside `bounds`, against the nodes `nodes[from..]` of `level`. True when the
    /// query is over.
    ///
    /// The tool entry's box goes down until the nodes are one level below it, so that groups arrive at blocks and their
    /// clusters test only the blocks the group reached.
    fn descend(
        &mut self,
        tool_level: usize,
        entry: usize,
        bounds: &Box32,
        level: usize,
        from: usize,
        narrow: &mut Narrow<'_>,
    ) -> bool {
        let to = self.nodes.len();
        let (mut level, mut from) = (level, from);
        while level > tool_level.saturating_sub(1) {
            from = self.expand(bounds, level, from, narrow);
            level -= 1;
        }
        let over = if self.nodes.len() == from {
            false
        } else if tool_level == 0 {
            self.offer_cluster(entry, bounds, from, narrow)
        } else {
            self.descend_children(tool_level, entry, level, from, narrow)
        };
        self.nodes.truncate(to);
        over
    }

    /// Goes on with each child of a tool entry, and the nodes of `nodes[from..]` whose own box meets the child's.
    fn descend_children(
        &mut self,
        tool_level: usize,
        entry: usize,
        level: usize,
        from: usize,
        narrow: &mut Narrow<'_>,
    ) -> bool {
        let children = self.placement.place_boxes(&self.tool.children(tool_level)[entry]);
        let (to, first_mask) = (self.nodes.len(), self.masks.len());
        narrow.stats.voxels_visited += (to - from) as u64;
        let nodes = &self.blocks.levels[level];
        self.masks.extend(self.nodes[from..].iter().map(|node| nodes[*node as usize].overlapping_lanes(&children)));
        let over = (0..children.count).any(|i| {
            for at in from..to {
                if self.masks[first_mask + at - from] >> i & 1 == 1 {
                    self.nodes.push(self.nodes[at]);
                }
            }
            let over = self.nodes.len() > to && {
                let bounds = Box32::of_lane(&children, i);
                self.descend(tool_level - 1, LANES * entry + i, &bounds, level, to, narrow)
            };
            self.nodes.truncate(to);
            over
        });
        self.masks.truncate(first_mask);
        over
    }

    /// Pushes the children, of the nodes `nodes[from..]` of `level`, that meet a box; returns where they begin.
    fn expand(&mut self, bounds: &Box32, level: usize, from: usize, narrow: &mut Narrow<'_>) -> usize {
        let to = self.nodes.len();
        narrow.stats.voxels_visited += (to - from) as u64;
        for at in from..to {
            let node = self.nodes[at];
            let mut hit = self.blocks.levels[level][node as usize].overlapping(bounds);
            while hit != 0 {
                self.nodes.push(FANOUT as u32 * node + hit.trailing_zeros());
                hit &= hit - 1;
            }
        }
        to
    }

    /// Offers the pairs of a cluster's pieces and the pieces of blocks `nodes[from..]`.
    fn offer_cluster(&mut self, cluster: usize, loose: &Box32, from: usize, narrow: &mut Narrow<'_>) -> bool {
        let pieces = &self.tool.clusters()[cluster];
        // The cluster's pieces are placed when its loose box first meets something.
        let mut placed: Option<(LaneBoxes, Box32)> = None;
        narrow.stats.voxels_visited += (self.nodes.len() - from) as u64;
        for at in from..self.nodes.len() {
            let block = self.nodes[at] as usize;
            let node = &self.blocks.levels[0][block];
            if placed.is_none() && node.overlapping(loose) == 0 {
                continue;
            }
            let (boxes, bounds) = placed.get_or_insert_with(|| {
                let boxes = self.placement.place_pieces(&pieces.corners);
                let bounds = Box32::around(&boxes);
                (boxes, bounds)
            });
            let mut hit = node.overlapping(bounds);
            if hit == 0 {
                continue;
            }
            let bytes = LaneBytes::new(node, boxes);
            while hit != 0 {
                let i = hit.trailing_zeros() as usize;
                hit &= hit - 1;
                let mut lanes = bytes.overlapping(&node.child(i));
                while lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize;
                    lanes &= lanes - 1;
                    // A pair comes again only if one of the two triangles has several pieces.
                    let may_repeat = (u32::from(pieces.cut) >> lane | node.cut >> i) & 1 == 1;
                    let mockup_triangle = self.blocks.triangles[FANOUT * block + i];
                    if narrow.offer(pieces.triangles[lane], mockup_triangle, may_repeat) {
                        return true;
                    }
                }
            }
        }
        false
    }
}
