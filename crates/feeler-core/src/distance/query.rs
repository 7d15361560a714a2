//! The distance queries, one pose at a time.

use super::gap::Gap;
use super::wanted::{Candidate, Goal, Wanted};
use crate::error::{Error, Result};
use crate::geometry::pose::Pose;
use crate::index::blocks::NearScratch;
use crate::index::mockup_index::Index;
use crate::index::plain_search::SearchScratch;
use crate::index::sink::{Divider, NearTool};
use crate::progress::GoOn;
use crate::tool::moving_tool::Tool;

/// Working memory of one query at a time.
#[derive(Debug, Default)]
#[repr(align(128))] // as of a collision query
pub struct DistanceScratch {
    /// What the last search found, sorted.
    gaps: Vec<Gap>,
    places: Vec<u32>,
    sorted: Vec<f64>,
    search: SearchScratch,
    near: NearScratch,
    /// Of [`near_candidates`], to be used again.
    candidates: Vec<Candidate>,
}

impl DistanceScratch {
    /// What the last search found, sorted.
    pub(super) fn gaps(&self) -> &[Gap] {
        &self.gaps
    }

    /// The same, taken out where it is long: a long list is handed over, not held for ever.
    fn take_gaps(&mut self) -> Vec<Gap> {
        if self.gaps.len() > LONG_LIST {
            std::mem::take(&mut self.gaps)
        } else {
            self.gaps.clone()
        }
    }

    /// Gives a list of [`near_candidates`] back, for the next query to use its memory. A long list is not held for ever.
    pub fn put_candidates(&mut self, mut list: Vec<Candidate>) {
        if list.capacity() <= MOST_HELD {
            list.clear();
            self.candidates = list;
        }
    }
}

/// Gaps from which on a list is handed over.
const LONG_LIST: usize = 4096;

/// Candidates for which memory is kept.
const MOST_HELD: usize = 1 << 16;

/// Every pair of triangles within a distance, or the closest of each part, as the goal says; sorted.
pub(crate) fn gaps(
    index: &Index,
    tool: &Tool,
    pose: &Pose,
    goal: Goal,
    within: f64,
    go_on: GoOn<'_>,
    scratch: &mut DistanceScratch,
) -> Result<Vec<Gap>> {
    let fits = find_gaps(index, tool, pose, goal, within, go_on, scratch)?;
    let found = scratch.take_gaps();
    if fits {
        return Ok(found);
    }
    Err(too_many_gaps(index, found.len()))
}

/// The closest pair of triangles, `None` when all are farther than `max` (metres); allocates nothing.
pub(crate) fn closest(
    index: &Index,
    tool: &Tool,
    pose: &Pose,
    max: f64,
    go_on: GoOn<'_>,
    scratch: &mut DistanceScratch,
) -> Result<Option<Gap>> {
    find_gaps(index, tool, pose, Goal::Nearest(1), max, go_on, scratch)?;
    Ok(scratch.gaps.first().copied())
}

/// Pairs that may be within a distance (metres, not checked), in no order but always the same; without most of those whose
/// pieces `dividers` (sorted by part) hold apart. `None` where they are more than `most`.
///
/// Errors: more of them than the memory limit of the index allows, and a request to stop.
#[allow(clippy::too_many_arguments, reason = "the query, and what it works with")]
pub fn near_candidates(
    index: &Index,
    tool: &Tool,
    pose: &Pose,
    within: f64,
    dividers: &[Divider],
    most: usize,
    go_on: GoOn<'_>,
    scratch: &mut DistanceScratch,
) -> Result<Option<Vec<Candidate>>> {
    let DistanceScratch { gaps, places, sorted, search, near, candidates } = scratch;
    let allowed = most_gaps(index);
    let at = near_tool(index, tool, pose, dividers);
    let mut wanted = Wanted::new(at, Goal::Candidates, within, most.min(allowed), go_on, (gaps, places, sorted));
    wanted.collect_into(std::mem::take(candidates));
    for (store, selection) in index.stores() {
        wanted.select(selection);
        store.search(&NearTool { selection, ..at }, search, near, &mut wanted);
    }
    let found = wanted.collect_into(Vec::new());
    if wanted.is_stopped() {
        return Err(Error::Cancelled);
    }
    if found.len() > allowed {
        return Err(too_many_gaps(index, found.len()));
    }
    Ok((found.len() <= most).then_some(found))
}

/// One search: `scratch.gaps` afterwards holds the gaps found. False when there were more than memory allows. An error where it was
/// stopped.
pub(super) fn find_gaps(
    index: &Index,
    tool: &Tool,
    pose: &Pose,
    goal: Goal,
    within: f64,
    go_on: GoOn<'_>,
    scratch: &mut DistanceScratch,
) -> Result<bool> {
    let DistanceScratch { gaps, places, sorted, search, near, .. } = scratch;
    let at = near_tool(index, tool, pose, &[]);
    let mut wanted = Wanted::new(at, goal, within, most_gaps(index), go_on, (gaps, places, sorted));
    for (store, selection) in index.stores() {
        wanted.select(selection);
        store.search(&NearTool { selection, ..at }, search, near, &mut wanted);
    }
    let fits = wanted.finish();
    if fits.is_err() {
        // A long list that nobody gets is not held for ever.
        scratch.gaps = Vec::new();
    }
    fits
}

fn near_tool<'a>(index: &'a Index, tool: &'a Tool, pose: &'a Pose, dividers: &'a [Divider]) -> NearTool<'a> {
    NearTool { mockup: index.mockup(), tool, pose, lanes: index.lanes(), selection: index.selection(), dividers }
}

/// How many gaps a result may hold. Growing vectors hold up to three times their content.
pub(super) fn most_gaps(index: &Index) -> usize {
    usize::try_from(index.memory_limit() / (3 * size_of::<Gap>() as u64)).unwrap_or(usize::MAX)
}

pub(super) fn too_many_gaps(index: &Index, count: usize) -> Error {
    Error::Memory {
        what: "the pairs within this distance",
        needed: 3 * (size_of::<Gap>() as u64) * count as u64,
        allowed: index.memory_limit(),
        advice: "ask for a smaller distance, pass fewer poses at a time, or allow more memory",
    }
}

/// Refuses a distance that is negative or NaN.
pub(crate) fn check_distance(what: &'static str, value: f64) -> Result<()> {
    // Written so that NaN fails.
    if value >= 0.0 {
        return Ok(());
    }
    Err(Error::Distance { what, value })
}
