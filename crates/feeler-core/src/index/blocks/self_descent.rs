//! The descent of the tree against itself: each node with the list of nodes of its level that it reaches and that come
//! after it, down to blocks (one tree's depth first, as a tool's in [`super::collide`]). Each pair of blocks occurs
//! once.
//!
//! Nodes of the same single part are not compared with each other: in a mock-up of many parts, those are most of the
//! near ones.

use std::ops::Range;

use super::block_parts::{BlockParts, MANY, NOTHING};
use super::node::FANOUT;
use super::tree::Blocks;
use feeler_lanes::{Box4, Checked, Kernel, Simd};

/// Takes the blocks of the tree that reach each other, as kernels do.
pub trait BlockSink {
    /// Takes a block, and those after it (it may be the first of them itself) that are near enough.
    fn take<S: Simd>(&mut self, s: S, block: u32, others: &[u32]);
}

/// A share of the search: a node, and the nodes of its level that it is held against.
#[derive(Debug, Clone)]
pub struct SelfTask {
    level: usize,
    node: u32,
    others: Vec<u32>,
}

/// The whole search in shares.
pub struct SelfSearch<'a> {
    pub blocks: &'a Blocks,
    pub parts: &'a BlockParts,
    pub lanes: Checked,
    /// How far boxes may be apart, per axis; frame units, rounded up.
    pub reach: f32,
}

/// Shares that a search has at least, if there are as many nodes.
const LEAST_TASKS: usize = 256;

impl SelfSearch<'_> {
    /// All shares, in order.
    pub fn tasks(&self) -> Vec<SelfTask> {
        let top = self.blocks.levels.len() - 1;
        let mut tasks = Vec::new();
        if self.parts.of_node(top, 0) == MANY {
            tasks.push(SelfTask { level: top, node: 0, others: vec![0] });
        }
        while tasks.len() < LEAST_TASKS && tasks.first().is_some_and(|task| task.level > 0) {
            let mut below = Vec::new();
            for task in &tasks {
                let sink = |level, node, others: &[u32]| below.push(SelfTask { level, node, others: others.to_vec() });
                self.lanes.run(Children { search: self, task, sink });
            }
            tasks = below;
        }
        tasks
    }

    /// Works on a share.
    pub fn run(&self, task: &SelfTask, sink: &mut impl BlockSink) {
        self.lanes.run(Descend { search: self, task, sink });
    }

    /// Puts into `to` what of the children of `others` child `child` of a node reaches; false where there is nothing.
    #[inline(always)]
    fn reached<S: Simd>(&self, s: S, level: usize, node: u32, others: &[u32], child: u32, to: &mut Vec<u32>) -> bool {
        let (own, below) = (&self.blocks.levels[level], &self.blocks.levels[level - 1]);
        let at = FANOUT as u32 * node + child;
        let part = self.parts.of_node(level - 1, at);
        if part == NOTHING {
            return false;
        }
        let bounds = grown(&below[at as usize].bounds(), self.reach);
        for &other in others {
            let mut hit = own[other as usize].overlapping(s, &bounds);
            if other == node {
                hit &= u32::MAX << child;
            }
            while hit != 0 {
                let i = FANOUT as u32 * other + hit.trailing_zeros();
                hit &= hit - 1;
                let of_other = self.parts.of_node(level - 1, i);
                if of_other != NOTHING && (of_other != part || part == MANY) {
                    to.push(i);
                }
            }
        }
        !to.is_empty()
    }
}

/// A box that reaches farther.
#[inline(always)]
pub fn grown(b: &Box4, reach: f32) -> Box4 {
    let mut b = *b;
    for a in 0..3 {
        b.lower[a] -= reach;
        b.upper[a] += reach;
    }
    b
}

/// The shares that one falls into.
struct Children<'a, 'b, F> {
    search: &'a SelfSearch<'b>,
    task: &'a SelfTask,
    sink: F,
}

impl<F: FnMut(usize, u32, &[u32])> Kernel for Children<'_, '_, F> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) {
        let SelfTask { level, node, others } = self.task;
        let mut list = Vec::new();
        let count = self.search.blocks.levels[*level][*node as usize].valid.count_ones();
        for child in 0..count {
            list.clear();
            if self.search.reached(s, *level, *node, others, child, &mut list) {
                (self.sink)(level - 1, FANOUT as u32 * node + child, &list);
            }
        }
    }
}

struct Descend<'a, 'b, B> {
    search: &'a SelfSearch<'b>,
    task: &'a SelfTask,
    sink: &'a mut B,
}

/// A node whose turn comes, and where its list stands.
struct Waiting {
    level: usize,
    node: u32,
    list: Range<usize>,
}

impl<B: BlockSink> Kernel for Descend<'_, '_, B> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Descend { search, task, sink } = self;
        let mut lists = task.others.clone();
        let mut waiting = vec![Waiting { level: task.level, node: task.node, list: 0..lists.len() }];
        let mut found = Vec::new();
        while let Some(Waiting { level, node, list }) = waiting.pop() {
            // What stands behind belongs to nodes that are done.
            lists.truncate(list.end);
            if level == 0 {
                sink.take(s, node, &lists[list]);
                continue;
            }
            for child in 0..search.blocks.levels[level][node as usize].valid.count_ones() {
                found.clear();
                if search.reached(s, level, node, &lists[list.clone()], child, &mut found) {
                    let from = lists.len();
                    lists.extend_from_slice(&found);
                    let node = FANOUT as u32 * node + child;
                    waiting.push(Waiting { level: level - 1, node, list: from..lists.len() });
                }
            }
        }
    }
}
