//! The goal of a search: which gaps it keeps, and its current limit.

use super::gap::Gap;
use crate::constants::{DISTANCE_ROUNDOFFS, UNIT_ROUNDOFF};
use crate::error::{Error, Result};
use crate::geometry::distance_triangle_triangle::closest_within;
use crate::index::selection::Selection;
use crate::index::sink::{NearSink, NearTool};
use crate::progress::{GoOn, Pace};

/// The gaps to find.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Goal {
    /// Every pair up to a distance.
    Pairs,
    /// The closest pair of each part up to a distance.
    Parts,
    /// The closest pair of each of the closest parts; their number.
    Nearest(usize),
    /// Pairs that may be within a distance, unmeasured: see [`Candidate`].
    Candidates,
}

/// A pair of triangles that boxes and planes do not hold farther apart than the distance asked for. A pair may come several
/// times, once for each two pieces of its triangles; the least of its bounds is below its distance.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    /// Metres: no more than the distance of the two pieces.
    pub bound: f64,
    pub part: u32,
    pub tool_triangle: u32,
    pub mockup_triangle: u32,
}

/// Candidates that are kept as they come.
const MOST_UNMERGED: usize = 1 << 16;

/// The state of one search.
pub(crate) struct Wanted<'a> {
    at: NearTool<'a>,
    goal: Goal,
    /// No more than this many gaps; beyond it the search stops.
    most: usize,
    /// Candidates from which on duplicates are left out.
    room: usize,
    bound: f64,
    direction: [f32; 3],
    gaps: &'a mut Vec<Gap>,
    candidates: Vec<Candidate>,
    /// For each part its place in `gaps` plus one, or 0.
    places: &'a mut Vec<u32>,
    /// Distances, for finding the k-th.
    sorted: &'a mut Vec<f64>,
    /// Parts that came closer since the bound was last found.
    changes: usize,
    pace: Pace<'a>,
}

/// Steps of a search between two questions whether it goes on. A step tests up to 512 pairs of triangles, but mostly few.
const STEPS_BETWEEN: u32 = 64;

impl NearSink for Wanted<'_> {
    #[inline(always)]
    fn bound(&self) -> f64 {
        self.bound
    }

    #[inline(always)]
    fn has_bounds_of_parts(&self) -> bool {
        matches!(self.goal, Goal::Parts) || matches!(self.goal, Goal::Nearest(k) if k > 1)
    }

    #[inline(always)]
    fn bound_of(&self, mockup_triangle: u32) -> Option<f64> {
        if matches!(self.goal, Goal::Pairs | Goal::Candidates) {
            return Some(self.bound);
        }
        match self.places[self.at.mockup.part_of_face(mockup_triangle) as usize] {
            0 => Some(self.bound),
            place => {
                let within = self.bound.min(self.gaps[place as usize - 1].distance);
                (within > 0.0).then_some(within)
            }
        }
    }

    /// By how much (metres, per axis) the tool's boxes must grow, so that no bound from boxes is above the distance that the
    /// triangle test computes: the uncertainty of the tool's place, and the error of that test.
    fn margin(&self) -> f64 {
        let mockup = self.at.mockup.mesh().bounds().largest_coordinate();
        let tool = 2.0 * self.at.tool.mesh().bounds().largest_coordinate() + self.at.pose.largest_translation();
        self.at.tool.margin_at(self.at.pose) + 2.0 * DISTANCE_ROUNDOFFS * UNIT_ROUNDOFF * (mockup + tool)
    }

    #[inline(always)]
    fn direction(&self) -> [f32; 3] {
        self.direction
    }

    #[inline(always)]
    fn is_collecting(&self) -> bool {
        self.goal == Goal::Candidates
    }

    fn collect(&mut self, slot: u32, mockup_triangle: u32, bound: f64) -> bool {
        if !self.at.selection.wants(self.at.tool, self.at.mockup, slot, mockup_triangle) {
            return false;
        }
        self.candidates.push(Candidate {
            bound,
            part: self.at.mockup.part_of_face(mockup_triangle),
            tool_triangle: self.at.tool.ids()[slot as usize],
            mockup_triangle,
        });
        self.candidates.len() > self.room && self.is_full_of_candidates()
    }

    #[inline(always)]
    fn must_stop(&mut self) -> bool {
        self.pace.step()
    }

    fn take(&mut self, slot: u32, mockup_triangle: u32) -> bool {
        if !self.at.selection.wants(self.at.tool, self.at.mockup, slot, mockup_triangle) {
            return false;
        }
        let Some(within) = self.bound_of(mockup_triangle) else { return false };
        let p = self.at.pose.apply_triangle(&self.at.tool.placeable()[slot as usize]);
        let Some(closest) = closest_within(&p, &self.at.mockup.mesh().triangle(mockup_triangle), within) else {
            return false;
        };
        let tool_triangle = self.at.tool.ids()[slot as usize];
        self.keep(Gap {
            tool_triangle,
            mockup_triangle,
            part: self.at.mockup.part_of_face(mockup_triangle),
            tool_part: self.at.tool.part_of_face(tool_triangle),
            distance: closest.distance,
            on_tool: closest.on_p,
            on_mockup: closest.on_q,
        })
    }
}

impl<'a> Wanted<'a> {
    /// A new search; `gaps` is emptied.
    pub(crate) fn new(
        at: NearTool<'a>,
        goal: Goal,
        within: f64,
        most: usize,
        go_on: GoOn<'a>,
        (gaps, places, sorted): (&'a mut Vec<Gap>, &'a mut Vec<u32>, &'a mut Vec<f64>),
    ) -> Wanted<'a> {
        gaps.clear();
        let parts = at.mockup.part_bounds().len();
        // As many as there are parts: the k-th closest bounds nothing.
        let goal = if matches!(goal, Goal::Nearest(k) if k >= parts && k > 1) { Goal::Parts } else { goal };
        if !matches!(goal, Goal::Pairs | Goal::Candidates) && places.len() < parts {
            places.resize(parts, 0);
        }
        Wanted {
            at,
            goal,
            most,
            room: most.min(MOST_UNMERGED),
            bound: within,
            direction: [0.0; 3],
            gaps,
            candidates: Vec::new(),
            places,
            sorted,
            changes: 0,
            pace: Pace::new(go_on, STEPS_BETWEEN),
        }
    }

    /// Pairs come once for each two of their pieces, or for each voxel they share: before there are too many, of each one is left.
    #[cold]
    fn is_full_of_candidates(&mut self) -> bool {
        let pair = |c: &Candidate| (c.tool_triangle, c.mockup_triangle);
        self.candidates.sort_unstable_by(|a, b| pair(a).cmp(&pair(b)).then(a.bound.total_cmp(&b.bound)));
        self.candidates.dedup_by_key(|c| pair(c));
        self.room = self.room.max(2 * self.candidates.len()).min(self.most);
        self.candidates.len() > self.most
    }

    /// What comes next is of a store with this selection.
    pub(crate) fn select(&mut self, selection: &'a Selection) {
        self.at.selection = selection;
    }

    /// Returns the collected gaps in the memory of an empty list.
    pub(crate) fn collect_into(&mut self, list: Vec<Candidate>) -> Vec<Candidate> {
        std::mem::replace(&mut self.candidates, list)
    }

    fn keep(&mut self, gap: Gap) -> bool {
        if gap.distance > 0.0 {
            let d = |a: usize| ((gap.on_mockup[a] - gap.on_tool[a]) / gap.distance) as f32;
            self.direction = [d(0), d(1), d(2)];
        }
        if self.goal == Goal::Pairs {
            self.gaps.push(gap);
            return self.gaps.len() > self.most;
        }
        let place = &mut self.places[gap.part as usize];
        if *place == 0 {
            self.gaps.push(gap);
            *place = self.gaps.len() as u32;
        } else {
            let old = &mut self.gaps[*place as usize - 1];
            if gap.order(old).is_ge() {
                return false;
            }
            *old = gap;
        }
        if let Goal::Nearest(k) = self.goal {
            self.changes += 1;
            if k == 1 {
                self.bound = gap.distance;
            } else if self.gaps.len() >= k && self.changes > k / 16 {
                self.changes = 0;
                self.sorted.clear();
                self.sorted.extend(self.gaps.iter().map(|gap| gap.distance));
                self.bound = *self.sorted.select_nth_unstable_by(k - 1, f64::total_cmp).1;
            }
            return self.bound == 0.0 && self.gaps.len() >= k;
        }
        false
    }

    /// Sorts the gaps found; true when there was room for all of them. An error where the search was stopped.
    pub(crate) fn finish(self) -> Result<bool> {
        if self.goal != Goal::Pairs {
            for gap in self.gaps.iter() {
                self.places[gap.part as usize] = 0;
            }
        }
        if self.pace.is_stopped() {
            return Err(Error::Cancelled);
        }
        sort(self.gaps, self.pace)?;
        if let Goal::Nearest(k) = self.goal {
            self.gaps.truncate(k);
        }
        Ok(self.gaps.len() <= self.most)
    }

    /// Whether the search was stopped.
    pub(crate) fn is_stopped(&self) -> bool {
        self.pace.is_stopped()
    }
}

/// Gaps up to which a list is sorted at once, which takes some hundredths of a second.
const SORTED_AT_ONCE: usize = 1 << 18;

/// Sorts gaps; a long list in parts, before each of which it asks whether to go on.
fn sort(gaps: &mut [Gap], mut pace: Pace<'_>) -> Result<()> {
    let mut parts = vec![gaps];
    while let Some(part) = parts.pop() {
        if part.len() <= SORTED_AT_ONCE {
            part.sort_unstable_by(Gap::order);
            continue;
        }
        if pace.ask() {
            return Err(Error::Cancelled);
        }
        let middle = part.len() / 2;
        part.select_nth_unstable_by(middle, Gap::order);
        let (nearer, farther) = part.split_at_mut(middle);
        parts.extend([farther, nearer]);
    }
    Ok(())
}
