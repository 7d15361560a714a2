//! The least gap along a motion, between proven bounds.
//!
//! Best first: the span of time whose lower bound is the least is halved. In a span no point of the tool is farther from where
//! it is in the middle than its displacement in half of it, so the gap in the middle less that is a lower bound.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::gap::Gap;
use super::query::{check_distance, closest, DistanceScratch};
use crate::error::Result;
use crate::geometry::pose::Pose;
use crate::index::mockup_index::Index;
use crate::progress::GoOn;
use crate::tool::motion::Motion;
use crate::tool::moving_tool::Tool;

/// Spans that the motion is cut into first, for a curve.
const FIRST_SPANS: usize = 32;

/// The most spans: a query that would need more ends with the bounds that it has.
const MOST_SPANS: usize = 1 << 20;

/// The gap in a span of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GapSpan {
    /// Where the span begins and ends, shares of the motion.
    pub from: f64,
    /// See above.
    pub to: f64,
    /// Metres; nowhere in the span is the gap less.
    pub lower: f64,
    /// Metres; in the middle of the span the gap is not more. Infinite where nothing is near.
    pub upper: f64,
}

/// The least gap of a tool along a motion.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LeastGap {
    /// Metres; the gap is nowhere less.
    pub lower: f64,
    /// Metres; at `share` it is that. Infinite where nothing is near.
    pub upper: f64,
    /// When, a share of the motion.
    pub share: f64,
    /// The pose then.
    pub pose: Pose,
    /// The closest pair then; `None` where nothing is near.
    pub gap: Option<Gap>,
    /// All of the motion, span by span.
    pub spans: Vec<GapSpan>,
}

/// A span to be halved, the one with the least lower bound first.
struct Open(GapSpan);

impl Ord for Open {
    fn cmp(&self, other: &Open) -> Ordering {
        other.0.lower.total_cmp(&self.0.lower).then(other.0.from.total_cmp(&self.0.from))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Open) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Open {
    fn eq(&self, other: &Open) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

struct Search<'a> {
    index: &'a Index,
    tool: &'a Tool,
    motion: &'a Motion,
    within: f64,
    go_on: GoOn<'a>,
    scratch: &'a mut DistanceScratch,
    best: Option<(f64, Gap)>,
}

impl Search<'_> {
    fn upper(&self) -> f64 {
        self.best.map_or(f64::INFINITY, |(_, gap)| gap.distance)
    }

    /// The gap at a time, where it is within a distance.
    fn gap_at(&mut self, time: f64, within: f64) -> Result<Option<f64>> {
        self.go_on.check()?;
        let pose = self.motion.at(time);
        let found = closest(self.index, self.tool, &pose, within, self.go_on, self.scratch)?;
        if let Some(gap) = found.filter(|gap| gap.distance < self.upper() && gap.distance <= self.within) {
            self.best = Some((time, gap));
        }
        Ok(found.map(|gap| gap.distance))
    }

    /// A span, measured in its middle; `known`: bounds of the one that it is a part of, and where they hold.
    fn span(&mut self, from: f64, to: f64, known: Option<&GapSpan>) -> Result<GapSpan> {
        let middle = 0.5 * (from + to);
        let moved = self.motion.displacement(from, to) + self.tool.margin_at(&self.motion.at(middle));
        // Farther than that it does not matter how far.
        let limit = if known.is_some() { self.upper().min(self.within) } else { self.within };
        let enough = limit + moved;
        let gap = self.gap_at(middle, enough)?;
        let lower = (gap.unwrap_or(enough) - moved).max(known.map_or(0.0, |known| known.lower));
        let far = known.map_or(f64::INFINITY, |known| known.upper + self.motion.displacement(known.from, known.to));
        Ok(GapSpan { from, to, lower: lower.min(gap.unwrap_or(f64::INFINITY)), upper: gap.unwrap_or(far) })
    }
}

/// The least gap of the tool along a motion, within `within` (metres), its bounds at most `error` (metres) apart unless it takes too many
/// spans.
pub(crate) fn least_gap(
    index: &Index,
    (tool, motion): (&Tool, &Motion),
    (within, error): (f64, f64),
    go_on: GoOn<'_>,
    scratch: &mut DistanceScratch,
) -> Result<LeastGap> {
    check_distance("within", within)?;
    check_distance("error", error)?;
    let mut search = Search { index, tool, motion, within, go_on, scratch, best: None };
    let mut open = BinaryHeap::new();
    // Both ends and the middle first: they are what is asked for most.
    for time in [0.0, 1.0] {
        search.gap_at(time, within)?;
    }
    let first = if motion.is_still() { 1 } else { FIRST_SPANS };
    let at = |i: usize| i as f64 / first as f64;
    for i in 0..first {
        open.push(Open(search.span(at(i), at(i + 1), None)?));
    }
    let mut spans = Vec::new();
    while let Some(Open(span)) = open.pop() {
        // The least there can be: zero, where they collide.
        let upper = search.upper().min(within);
        let is_shortest = span.to - span.from < 1e-12;
        if upper == 0.0 || span.lower >= upper - error || is_shortest || open.len() + spans.len() >= MOST_SPANS {
            spans.push(span);
            continue;
        }
        let middle = 0.5 * (span.from + span.to);
        open.push(Open(search.span(span.from, middle, Some(&span))?));
        open.push(Open(search.span(middle, span.to, Some(&span))?));
    }
    spans.sort_unstable_by(|a, b| a.from.total_cmp(&b.from));
    let lower = spans.iter().map(|span| span.lower).fold(f64::INFINITY, f64::min);
    let (share, gap) = search.best.map_or((0.0, None), |(time, gap)| (time, Some(gap)));
    let upper = gap.map_or(f64::INFINITY, |gap| gap.distance);
    Ok(LeastGap { lower: lower.min(upper), upper, share, pose: motion.at(share), gap, spans })
}
