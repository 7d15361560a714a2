//! The cast in windows of time: the store offers the pairs that may collide in a window, and each of these is followed
//! through it.
//!
//! A long window is loose: boxes around the tool's whole motion overlap much that the tool passes by. A short one costs
//! a descent for little progress. So a window that offers too many pairs is cut, and the next one after few pairs is
//! longer.

use super::impact::{Impact, Touching};
use super::pair::Moving;
use super::shadow::{Screen, Shadows};
use super::sliding::Slide;
use crate::collide::query::{any_pair, entering_pair, CollideScratch};
use crate::error::{Error, Result};
use crate::geometry::bounds::{Aabb, Point, Triangle};
use crate::geometry::pose::Pose;
use crate::geometry::vectors::{dot, length};
use crate::index::blocks::SweepScratch;
use crate::index::interner::pair_key;
use crate::index::mockup_index::Index;
use crate::index::sink::Sweep;
use crate::tool::motion::{Motion, Window};
use crate::tool::moving_tool::Tool;

/// Most directions that are tried for a pair. More: fewer pairs are followed, and each takes longer to try.
const MOST_DIRECTIONS: usize = 16;

/// Pairs that a window may offer before it is cut, for a small tool; a large one's descents cost more, and bring more.
const FEW_PAIRS: usize = 96;

/// This many times as many where directions are given, along which most are held apart without following them.
const TIMES_BESIDE: usize = 8;

/// Share of a window that a cut leaves.
const CUT: f64 = 0.25;

/// Up to this share of its own size in a window a tool is not near the parts that it sweeps past: the first cuts make windows so short. Each cut
/// beyond allows twice as many pairs.
const STRIDE: f64 = 0.125;

/// A window that offers at most this many times the pairs of the tool standing still would gain little by a cut.
const TIMES_STILL: usize = 4;

/// Most cuts of either kind, so that float64 can tell the ends of a window apart. After the last one pairs are followed as they
/// come, however many there are.
const MOST_COARSE_CUTS: u32 = 16;
/// See above.
const MOST_CUTS: u32 = 8;

/// Pairs after which those that never meet, however far the tool goes, are sorted out: see [`super::shadow`]. Fewer: casts that end soon
/// take longer; more: those along tight fits do.
const SHADOWS_AFTER: usize = 4096;

/// Where that takes too long, the next try is after this many times as many pairs.
const SHADOWS_LATER: usize = 4;

/// Pairs that were followed for each triangle nearby; else there are too many to cast shadows.
const PAIRS_A_SHADOW: usize = 2;

/// Tests of boxes, and pairs that are left, for each shadow at most.
const TESTS_A_SHADOW: usize = 512;
/// See above.
const LEFT_A_SHADOW: usize = 32;

/// Cuts after which it pays to ask whether the tool begins in contact, which no cut would bring out.
const CUTS_IN_CONTACT: u32 = 2;

/// Pairs that are followed between two checks for a stop: some milliseconds at most.
const PAIRS_BETWEEN: usize = 256;

/// Shortest window, as a share of the motion: several times that, added to a time, is a later one.
const SHORTEST_WINDOW: f64 = 64.0 * f64::EPSILON;

/// Triangles whose shadows are cast between two checks: one of many turns has thousands of shadows.
const CAST_BETWEEN: usize = 64;

/// The options of a cast.
#[derive(Clone, Copy)]
pub struct How<'a> {
    /// Metres.
    pub tolerance: f64,
    pub touching: Touching,
    /// Units, world, along which tool and mock-up are probably apart all the time: pairs that are need not be followed.
    pub directions: &'a [Point],
    /// Whether to go on: asked in each window of time, and every [`PAIRS_BETWEEN`] pairs.
    pub goes_on: &'a dyn Fn() -> bool,
}

/// The triangles that some directions hold apart, for a whole window and by more than the tolerance, from one of the tool.
struct HeldApart<'a> {
    directions: &'a [Point],
    tolerance: f64,
    /// How low along each all that the tool's triangle sweeps is at least.
    lowest: [f64; MOST_DIRECTIONS],
    /// The one that held the last: mostly it holds the next.
    last: usize,
}

impl HeldApart<'_> {
    fn new(directions: &[Point], tolerance: f64) -> HeldApart<'_> {
        let directions = &directions[..directions.len().min(MOST_DIRECTIONS)];
        HeldApart { directions, tolerance, lowest: [0.0; MOST_DIRECTIONS], last: 0 }
    }

    fn set(&mut self, window: &Window, corners: &Triangle) {
        if self.directions.is_empty() {
            return;
        }
        let places = window.poses.each_ref().map(|pose| pose.apply_triangle(corners));
        for (direction, lowest) in self.directions.iter().zip(&mut self.lowest) {
            let low = places.as_flattened().iter().map(|p| dot(p, direction)).fold(f64::INFINITY, f64::min);
            // The margin is for each axis; the heights have some roundings of their own, which it has much more than.
            let slack = window.margin * direction.iter().map(|x| x.abs()).sum::<f64>();
            *lowest = low - slack - self.tolerance;
        }
    }

    fn contains(&mut self, q: &Triangle) -> bool {
        let n = self.directions.len();
        let found = (0..n).map(|i| (self.last + i) % n).find(|i| {
            let direction = &self.directions[*i];
            q.iter().all(|p| dot(p, direction) < self.lowest[*i])
        });
        self.last = found.unwrap_or(self.last);
        found.is_some()
    }
}

/// Working memory of a cast.
#[derive(Debug, Default)]
pub(super) struct SweepMemory {
    store: SweepScratch,
    /// Slot of the tool, and triangle of the mock-up, in one number.
    pairs: Vec<u64>,
}

/// The first impact of a tool on its way. An error: a request to stop.
pub(super) fn first_impact(
    index: &Index,
    tool: &Tool,
    motion: &Motion,
    how: How<'_>,
    scratch: &mut SweepMemory,
    collide: &mut CollideScratch,
) -> Result<Option<Impact>> {
    let How { tolerance, touching, directions, goes_on } = how;
    let selection = index.selection();
    let few = FEW_PAIRS.max(tool.clusters().len()) * if directions.is_empty() { 1 } else { TIMES_BESIDE };
    // Shorter than this a window is no use: all it holds is within the tolerance.
    let shortest = (tolerance / motion.longest_way().max(tolerance)).max(SHORTEST_WINDOW);
    let coarse = coarse_cuts(tool, motion);
    let mut from = 0.0;
    let (mut before, mut after) = (Vec::new(), Vec::new());
    let mut cuts = coarse.saturating_sub(1);
    // Pairs offered so far, and the number at which shadows are tried.
    let (mut spent, mut ask_at) = (0, SHADOWS_AFTER);
    // Pairs offered with the tool standing still, and when.
    let (mut still, mut still_at) = (0, -1.0);
    while from < 1.0 {
        if !goes_on() {
            return Err(Error::Cancelled);
        }
        if spent >= ask_at {
            ask_at = spent.saturating_mul(SHADOWS_LATER);
            let left = pairs_in_shadow((index, tool, motion), from, spent, goes_on, &mut scratch.store);
            if let Some(mut left) = left.filter(|left| left.is_empty() || touching == Touching::Ends) {
                let window = motion.window(tool, from, 1.0);
                let how = How { directions: &[], ..how };
                let span = (from, 1.0);
                let mut chase = Chase::new((index, tool, motion), how, span, &before, &mut after);
                chase.follow(&mut left, &window);
                return if chase.is_stopped { Err(Error::Cancelled) } else { Ok(chase.best) };
            }
        }
        let share = CUT.powi(cuts as i32);
        let to = if from + share < 1.0 { from + share } else { 1.0 };
        let fine = cuts.saturating_sub(coarse);
        let limit = (few << fine).max(TIMES_STILL * still);
        let may_cut = fine < MOST_CUTS && share > shortest;
        let mut chase = Chase::new((index, tool, motion), how, (from, to), &before, &mut after);
        let sweep = |to: f64, selection| Sweep {
            mesh: index.mockup().mesh(),
            tool,
            window: motion.window(tool, from, to),
            lanes: index.lanes(),
            selection,
            may_give_up: may_cut && to > from,
        };
        let SweepMemory { store, pairs } = &mut *scratch;
        pairs.clear();
        let mut is_full = false;
        let whole = sweep(to, selection);
        let mut all_seen = true;
        for (blocks, selection) in index.stores() {
            let whole = Sweep { selection, window: whole.window.clone(), ..whole };
            all_seen &= blocks.offer_swept(&whole, store, &mut |slot, triangle| {
                if !selection.wants(tool, index.mockup(), slot, triangle) {
                    return false;
                }
                pairs.push(pair_key(slot, triangle));
                if pairs.len() < limit {
                    return false;
                }
                if may_cut {
                    is_full = true;
                    return true;
                }
                chase.follow(pairs, &whole.window);
                // Nothing is earlier than the beginning.
                chase.until <= from || chase.is_stopped
            });
            if is_full || !all_seen || chase.is_stopped {
                break;
            }
        }
        if is_full || !all_seen {
            cuts += 1;
            spent += pairs.len();
            if from == 0.0 && cuts == coarse + CUTS_IN_CONTACT {
                if let Some(impact) = impact_at(index, tool, motion, touching, 0.0, collide) {
                    return Ok(Some(impact));
                }
            }
            if is_full && cuts > coarse + CUTS_IN_CONTACT && still_at < from {
                (still, still_at) = (0, from);
                for (blocks, selection) in index.stores() {
                    blocks.offer_swept(&sweep(from, selection), store, &mut |slot, triangle| {
                        still += usize::from(selection.wants(tool, index.mockup(), slot, triangle));
                        false
                    });
                }
            }
            continue;
        }
        let offered = pairs.len();
        spent += offered;
        chase.follow(pairs, &whole.window);
        if chase.is_stopped {
            return Err(Error::Cancelled);
        }
        if chase.best.is_some() {
            return Ok(chase.best);
        }
        std::mem::swap(&mut before, &mut after);
        before.sort_unstable_by_key(|(pair, _)| *pair);
        after.clear();
        from = to;
        cuts = cuts.saturating_sub(u32::from(offered < limit / 4));
    }
    Ok(None)
}

/// All pairs that may meet from a time on, by their shadows; `None` where that is no slide or screw, or takes too much beside the pairs
/// that were followed until then.
fn pairs_in_shadow(
    (index, tool, motion): (&Index, &Tool, &Motion),
    from: f64,
    spent: usize,
    goes_on: &dyn Fn() -> bool,
    store: &mut SweepScratch,
) -> Option<Vec<u64>> {
    let screen = Screen::of(motion.steady(from))?;
    let (slots, most) = (tool.placeable(), spent / PAIRS_A_SHADOW);
    if slots.len() > most {
        return None;
    }
    let (mesh, selection) = (index.mockup().mesh(), index.selection());
    let bounds = motion.swept_bounds(tool, from);
    let triangles = triangles_within(index, &bounds, most, store)?;
    let (pose, stray) = (motion.at(from), motion.stray());
    let (mut of_tool, mut of_mockup) = (Vec::with_capacity(slots.len()), Vec::new());
    for (slot, corners) in (0..).zip(slots) {
        if slot as usize % CAST_BETWEEN == CAST_BETWEEN - 1 && !goes_on() {
            return None; // the next window of the cast asks, too, and ends it
        }
        screen.cast(slot, &pose.apply_triangle(corners), stray, None, &mut of_tool);
    }
    let of_tool = Shadows::new(of_tool);
    for (number, triangle) in triangles.into_iter().filter(|triangle| selection.has(*triangle)).enumerate() {
        if number % CAST_BETWEEN == CAST_BETWEEN - 1 && !goes_on() {
            return None;
        }
        screen.cast(triangle, &mesh.triangle(triangle), 0.0, Some(&of_tool), &mut of_mockup);
        if of_mockup.len() > most {
            return None;
        }
    }
    let of_mockup = Shadows::new(of_mockup);
    let mut left = Vec::new();
    if of_tool.len() == 0 || of_mockup.len() == 0 {
        return Some(left);
    }
    let (shadows, mut seen) = (of_tool.len() + of_mockup.len(), 0);
    let all_seen = screen.meeting(&of_tool, &of_mockup, TESTS_A_SHADOW * shadows, &mut |slot, triangle| {
        seen += 1;
        if selection.wants(tool, index.mockup(), slot, triangle) {
            left.push(pair_key(slot, triangle));
        }
        left.len() < LEFT_A_SHADOW * shadows && (seen % PAIRS_BETWEEN != 0 || goes_on())
    });
    all_seen.then_some(left)
}

/// The triangles of the mock-up in a box, and some beside it; `None` where they are more than the limit.
fn triangles_within(index: &Index, bounds: &Aabb, most: usize, store: &mut SweepScratch) -> Option<Vec<u32>> {
    let [a, b] = [bounds.lower, bounds.upper];
    // A side of the box, on its way to the opposite one.
    let corners = vec![a, [b[0], a[1], a[2]], [b[0], b[1], a[2]], [a[0], b[1], a[2]]];
    let side = Tool::new(corners, vec![[0, 1, 2], [0, 2, 3]]).ok()?;
    let poses = [Pose::IDENTITY, Pose::IDENTITY.translated(&[0.0, 0.0, b[2] - a[2]]).ok()?];
    let sweep = Sweep {
        mesh: index.mockup().mesh(),
        tool: &side,
        window: Window {
            poses,
            margin: side.margin_at(&Pose::IDENTITY) + 8.0 * f64::EPSILON * bounds.largest_coordinate(),
        },
        lanes: index.lanes(),
        selection: index.selection(),
        may_give_up: false,
    };
    let mut found = Vec::new();
    let mut is_full = false;
    for (blocks, selection) in index.stores() {
        blocks.offer_swept(&Sweep { selection, window: sweep.window.clone(), ..sweep }, store, &mut |_, triangle| {
            found.push(triangle);
            is_full = found.len() > 2 * most;
            is_full
        });
        if is_full {
            break;
        }
    }
    if is_full {
        return None;
    }
    found.sort_unstable();
    found.dedup();
    Some(found)
}

/// A pair that meets at a time, or where touching is free one that enters, exactly.
pub(super) fn impact_at(
    index: &Index,
    tool: &Tool,
    motion: &Motion,
    touching: Touching,
    time: f64,
    scratch: &mut CollideScratch,
) -> Option<Impact> {
    let pose = motion.at(time);
    let pair = match touching {
        Touching::Ends => any_pair(index, tool, &pose, scratch),
        Touching::Free => entering_pair(index, tool, &pose, scratch),
        // Where nothing moves, nothing goes deeper.
        Touching::Within => None,
    };
    pair.map(|[tool_triangle, mockup_triangle]| Impact { time, tool_triangle, mockup_triangle })
}

/// Cuts that make a window no longer than a stride.
fn coarse_cuts(tool: &Tool, motion: &Motion) -> u32 {
    let size = length(&tool.mesh().bounds().extent());
    let strides = motion.longest_way() / (STRIDE * size).max(f64::MIN_POSITIVE);
    let cuts = strides.max(1.0).log(1.0 / CUT).ceil();
    // A cast from float saturates, and NaN gives 0.
    (cuts as u32).min(MOST_COARSE_CUTS)
}

/// Follows pairs through a window.
struct Chase<'a> {
    index: &'a Index,
    tool: &'a Tool,
    motion: &'a Motion,
    how: How<'a>,
    /// By a request.
    is_stopped: bool,
    from: f64,
    until: f64,
    best: Option<Impact>,
    /// Where touching is free: of pairs that touch at the beginning of the window (sorted), and at its end, the normals that hold them
    /// apart.
    before: &'a [(u64, Point)],
    after: &'a mut Vec<(u64, Point)>,
}

impl<'a> Chase<'a> {
    /// From a time until another.
    fn new(
        (index, tool, motion): (&'a Index, &'a Tool, &'a Motion),
        how: How<'a>,
        (from, until): (f64, f64),
        before: &'a [(u64, Point)],
        after: &'a mut Vec<(u64, Point)>,
    ) -> Chase<'a> {
        Chase { index, tool, motion, how, is_stopped: false, from, until, best: None, before, after }
    }

    /// Follows each pair once, and empties the list.
    fn follow(&mut self, pairs: &mut Vec<u64>, window: &Window) {
        pairs.sort_unstable();
        pairs.dedup();
        let pose = &window.poses[0];
        let mut held_apart = HeldApart::new(self.how.directions, self.how.tolerance);
        let mockup = self.index.mockup();
        let mesh = mockup.mesh();
        let during = self.motion.during(self.from, self.until);
        let mut moving: Option<(u32, Moving<'_>)> = None;
        let mut at = 0;
        for (number, &pair) in pairs.iter().enumerate() {
            if number % PAIRS_BETWEEN == PAIRS_BETWEEN - 1 && !(self.how.goes_on)() {
                self.is_stopped = true;
                break;
            }
            let (slot, triangle) = ((pair >> 32) as u32, pair as u32);
            if moving.as_ref().is_none_or(|(s, _)| *s != slot) {
                let corners = self.tool.placeable()[slot as usize];
                moving = Some((slot, Moving::new(self.motion, corners, &during)));
                held_apart.set(window, &corners);
            }
            let Some((_, moving)) = &moving else { continue };
            let q = mesh.triangle(triangle);
            if held_apart.contains(&q) {
                continue;
            }
            let tool_triangle = self.tool.ids()[slot as usize];
            let time = if self.how.touching == Touching::Ends {
                moving.first_impact(&q, self.from, self.until, pose, self.how.tolerance)
            } else {
                let of_tool = self.tool.adjacency().outward[tool_triangle as usize];
                let senses = [of_tool, mockup.adjacency().outward[triangle as usize]];
                let span = (self.from, self.until);
                // Both lists are in order.
                while self.before.get(at).is_some_and(|(other, _)| *other < pair) {
                    at += 1;
                }
                let held = self.before.get(at).filter(|(other, _)| *other == pair).map(|(_, normal)| *normal);
                match moving.slide(&q, senses, span, pose, held, self.how.tolerance) {
                    Slide::Blocked(time) => Some(time),
                    Slide::Free(normal) => {
                        self.after.extend(normal.map(|normal| (pair, normal)));
                        None
                    }
                }
            };
            if let Some(time) = time {
                self.until = time;
                self.best = Some(Impact { time, tool_triangle, mockup_triangle: triangle });
            }
        }
        pairs.clear();
    }
}
