//! The search for all pairs of parts that are too near each other: first the verdict of each pair, then the distances
//! of pairs that do not collide, then the depths of those that do.

use std::collections::{BTreeMap, HashMap};

use feeler_core::clash::duplicates::{duplicate_pairs, same_parts};
use feeler_core::clash::holding::held_parts;
use feeler_core::clash::location::LocationScratch;
use feeler_core::clash::meeting::{meeting_parts, Meeting};
use feeler_core::clash::meets::Meets;
use feeler_core::clash::near::{near_parts, PartGap};
use feeler_core::clash::search::SelfIndex;
use feeler_core::clash::solids::Solids;
use feeler_core::clash::touch::{judge as touching, Touching};
use feeler_core::scratch_pool::ScratchPool;
use feeler_core::{Aabb, PairLimits, Progress, Result, Scene, Tool};
use rayon::prelude::*;

use super::row::{Clash, Verdict};
use super::verdicts::{Judge, Related, Relation};
use super::way_out::{shared_box, touching_points, Met, Pair, WayOut};
use crate::point_depth::bodies::Bodies;
use crate::point_depth::crossing::crossing_depth;
use crate::point_depth::depth::{point_depth, DepthKind, PointDepth};
use crate::solver::ContactSolver;

impl Relation {
    /// Whether one is wholly in the other.
    fn is_within(self) -> bool {
        matches!(self, Relation::Duplicate | Relation::Held | Relation::Touching(Touching::Holding | Touching::Held))
    }
}

/// Options of [`clash`].
#[derive(Debug, Clone, Copy, Default)]
#[non_exhaustive]
pub struct ClashOptions<'a> {
    /// Reports the progress, and may stop the search, which then returns its findings so far.
    pub progress: Progress<'a>,
}

impl<'a> ClashOptions<'a> {
    /// Calls a function with the share done (0 to 1) of a stage, and the stage. The search stops where it returns false.
    #[must_use]
    pub fn with_progress(mut self, progress: &'a (dyn Fn(f64, &str) -> bool + Sync)) -> Self {
        self.progress = Progress::new(progress);
        self
    }
}

/// What [`clash`] found.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Clashes {
    /// The pairs of parts, each with the lesser part first, in order.
    pub rows: Vec<Clash>,
    /// Pairs by their relation.
    pub counts: ClashCounts,
    /// Whether the search was not stopped. A pair that was not measured by then has NaN for a depth.
    pub is_complete: bool,
}

/// Finds all pairs of parts of a scene that are nearer each other than `limits` allow, or in each other, and measures them; in parallel
/// on the current rayon pool.
///
/// ```
/// use std::sync::Arc;
///
/// use feeler_contacts::{clash, ClashOptions, ContactSolver, Verdict};
/// use feeler_core::{Mockup, PairLimits, Scene, SceneOptions};
///
/// # fn main() -> feeler_core::Result<()> {
/// // Two tetrahedra that are 1 cm in each other.
/// let corners = |x: f64| [[x, 0.0, 0.0], [x + 0.1, 0.0, 0.0], [x, 0.1, 0.0], [x, 0.0, 0.1]];
/// let vertices = [corners(0.0), corners(0.09)].concat();
/// let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
/// let faces = [faces, faces.map(|f| f.map(|v| v + 4))].concat();
/// let mockup = Mockup::new(vertices, faces, vec![0, 0, 0, 0, 1, 1, 1, 1], 2)?;
/// let solver = ContactSolver::new(Arc::new(Scene::build(Arc::new(mockup), &SceneOptions::default())?));
///
/// // No two parts nearer than 5 mm; in contact up to a depth of 0.1 mm.
/// let found = clash(&solver, &PairLimits::uniform(0.005, 1e-4)?, &ClashOptions::default())?;
/// assert_eq!(found.rows.len(), 1);
/// assert_eq!((found.rows[0].parts, found.rows[0].verdict), ([0, 1], Verdict::Clash));
/// # Ok(())
/// # }
/// ```
///
/// Errors: as of building blocks, where the scene has none.
pub fn clash(solver: &ContactSolver, limits: &PairLimits, options: &ClashOptions<'_>) -> Result<Clashes> {
    let mut search = ClashSearch::new(solver, limits, options)?;
    if search.find_verdicts() {
        search.find_gaps();
    }
    let rows = search.measure()?;
    Ok(Clashes { rows, counts: search.counts(), is_complete: search.is_complete() })
}

/// The search of [`clash`] in steps, each of which may be stopped; the findings so far stay available.
#[derive(Debug)]
pub struct ClashSearch<'a> {
    solver: &'a ContactSolver,
    limits: PairLimits,
    progress: Progress<'a>,
    index: SelfIndex<'a>,
    solids: Solids<'a>,
    /// By pair.
    related: BTreeMap<[u32; 2], Related>,
    bodies: Bodies,
    meeting: Meeting,
    sets: Vec<Vec<u32>>,
    /// The place of the set that a part is in.
    set_of_part: HashMap<u32, usize>,
    gaps: Vec<PartGap>,
    is_complete: bool,
    is_measuring: bool,
    /// Working memory.
    locations: ScratchPool<LocationScratch>,
}

const STAGE: &str = "measuring depths";

/// The numbers of pairs found, by relation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ClashCounts {
    /// Pairs that cross.
    pub crossing: usize,
    /// Pairs that collide and do not cross.
    pub touching: usize,
    /// Pairs of which one contains the other without a collision.
    pub held: usize,
    /// Pairs with the same triangles.
    pub duplicates: usize,
    /// Pairs that are near and do not collide.
    pub near: usize,
}

impl<'a> ClashSearch<'a> {
    /// A search of the parts that are there. Errors: as of building blocks, where the scene has none.
    pub fn new(solver: &'a ContactSolver, limits: &PairLimits, options: &ClashOptions<'a>) -> Result<ClashSearch<'a>> {
        let scene = solver.scene();
        let meeting = Meeting { pairs: Vec::new(), examples: Vec::new(), touches: Vec::new(), is_complete: true };
        Ok(ClashSearch {
            solver,
            limits: limits.with_rounding(scene.mockup().part_bounds()),
            progress: options.progress,
            index: SelfIndex::new(scene.index())?,
            solids: Solids::new(scene.mockup()),
            related: BTreeMap::new(),
            bodies: Bodies::default(),
            meeting,
            sets: Vec::new(),
            set_of_part: HashMap::new(),
            gaps: Vec::new(),
            is_complete: true,
            is_measuring: true,
            locations: ScratchPool::default(),
        })
    }

    fn scene(&self) -> &'a Scene {
        self.solver.scene()
    }

    /// Finds what each pair of parts is, but for those that only come near; false where it was stopped.
    pub fn find_verdicts(&mut self) -> bool {
        let progress = self.progress;
        let (index, limits) = (self.scene().index(), &self.limits);
        self.sets = same_parts(self.scene().mockup(), |part| index.selection().has_part(part));
        self.set_of_part =
            self.sets.iter().zip(0..).flat_map(|(set, at)| set.iter().map(move |part| (*part, at))).collect();
        let duplicates = duplicate_pairs(&self.sets, limits);
        self.meeting = meeting_parts(&self.index, limits, &duplicates, progress);
        let (meeting, solids) = (&self.meeting, &self.solids);
        let judge = Judge { solids, limits, bodies: &self.bodies };
        let related = |parts: &[u32; 2], relation| (*parts, judge.judge(*parts, relation, None));
        let mut found: BTreeMap<[u32; 2], Related> =
            duplicates.iter().map(|parts| related(parts, Relation::Duplicate)).collect();
        let of_meeting: Vec<([u32; 2], Related)> = meeting
            .pairs
            .par_iter()
            .zip(&meeting.examples)
            .map(|(pair, example)| {
                let relation = match pair.meets {
                    Meets::Crossing => Relation::Crossing,
                    Meets::Touching => self.locations.with(|scratch| {
                        let touches = meeting.touches_of(pair.parts);
                        Relation::Touching(touching((index, solids), pair.parts, touches, scratch))
                    }),
                };
                let crossing = (relation == Relation::Crossing).then_some(*example);
                (pair.parts, judge.judge(pair.parts, relation, crossing))
            })
            .collect();
        found.extend(of_meeting);
        if meeting.is_complete {
            let known: Vec<[u32; 2]> = found.keys().copied().collect();
            let held = held_parts(index, solids, limits, &known);
            let related: Vec<Related> = held.par_iter().filter_map(|held| judge.held(held)).collect();
            for related in related {
                let kept = found.entry(related.parts).or_insert(related);
                if related.relation == Relation::Crossing {
                    *kept = related;
                }
            }
        }
        self.is_complete &= meeting.is_complete;
        self.related = found;
        self.is_complete
    }

    /// Measures how near the pairs are that do not meet; false where it was stopped.
    pub fn find_gaps(&mut self) -> bool {
        let progress = self.progress;
        if self.limits.largest_reach() > 0.0 {
            let known: Vec<[u32; 2]> = self.related.keys().copied().collect();
            let found = near_parts(&self.index, &self.limits, &known, progress);
            self.is_complete &= found.is_complete;
            // Copies of an open surface, between which rounding left a gap.
            let judge = Judge { solids: &self.solids, limits: &self.limits, bodies: &self.bodies };
            let is_copy = |gap: &PartGap| {
                gap.distance <= self.limits.copies_within(gap.parts[0], gap.parts[1]) && judge.is_same(gap.parts)
            };
            let (copies, gaps): (Vec<PartGap>, Vec<PartGap>) = found.all.into_par_iter().partition(is_copy);
            self.gaps = gaps;
            let same = |parts| Related { parts, relation: Relation::Held, verdict: Some(Verdict::Duplicate) };
            self.related.extend(copies.iter().map(|copy| (copy.parts, same(copy.parts))));
        }
        self.is_complete
    }

    /// Whether no step was stopped so far.
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// The counts so far.
    pub fn counts(&self) -> ClashCounts {
        let mut counts = ClashCounts { near: self.gaps.len(), ..ClashCounts::default() };
        for related in self.related.values() {
            *match related.relation {
                Relation::Duplicate => &mut counts.duplicates,
                Relation::Crossing => &mut counts.crossing,
                Relation::Touching(_) => &mut counts.touching,
                Relation::Held => &mut counts.held,
            } += 1;
        }
        counts
    }

    /// Measures the pairs that meet, and tells of all that were found, in order of parts. Where it is stopped, pairs that were not
    /// measured by then have NaN for a depth.
    pub fn measure(&mut self) -> Result<Vec<Clash>> {
        let progress = self.progress;
        let is_stopped = !progress.tell(0.0, STAGE);
        let adjacency = (!is_stopped).then(|| self.scene().mockup().adjacency());
        let is_open = |parts: [u32; 2]| parts.map(|part| adjacency.is_some_and(|adjacency| adjacency.is_open(part)));
        self.is_measuring = !is_stopped;
        let mut rows = Vec::new();
        let mut deep: BTreeMap<u32, Vec<Related>> = BTreeMap::new();
        for related in self.related.values() {
            let Related { parts, relation, verdict } = *related;
            match relation {
                Relation::Touching(Touching::Beside) if verdict == Some(Verdict::Contact) => {
                    rows.push(self.contact(parts, is_open(parts)));
                }
                // Of parts that are the same all pairs are as the first.
                Relation::Duplicate if !self.is_first_of_its_set(parts) => {}
                _ => deep.entry(self.tool_of(parts)).or_default().push(*related),
            }
        }
        rows.extend(self.gaps.iter().map(|gap| self.apart(gap, is_open(gap.parts))));
        let groups: Vec<(u32, Vec<Related>)> = deep.into_iter().collect();
        const WAVE: usize = 256;
        for (n, wave) in groups.chunks(WAVE).enumerate() {
            if !self.is_measuring || !progress.tell((n * WAVE) as f64 / groups.len() as f64, STAGE) {
                (self.is_complete, self.is_measuring) = (false, false);
                let all = wave.iter().flat_map(|(_, pairs)| pairs);
                rows.extend(
                    all.map(|related| Clash::unmeasured(related.parts, related.verdict, is_open(related.parts))),
                );
                continue;
            }
            let measured: Vec<Result<Vec<Clash>>> = wave
                .par_iter()
                .map(|(part, pairs)| {
                    let tool = self.solids.tool(*part)?;
                    pairs.iter().map(|related| self.measured(&tool, *part, related, is_open(related.parts))).collect()
                })
                .collect();
            for found in measured {
                rows.extend(found?);
            }
        }
        self.add_duplicates(&mut rows);
        rows.sort_unstable_by_key(|row| row.parts);
        Ok(rows)
    }

    /// Two parts that are in each other, the one as a tool.
    fn measured(&self, tool: &Tool, part: u32, related: &Related, is_open: [bool; 2]) -> Result<Clash> {
        let Related { parts, relation, verdict } = *related;
        let other = if parts[0] == part { parts[1] } else { parts[0] };
        let (scene, solids) = (self.scene(), &self.solids);
        let alone = scene.of_one_part(other);
        let judge = Judge { solids, limits: &self.limits, bodies: &self.bodies };
        let [a, b] = judge.bodies_of(parts);
        let bodies = if part == parts[0] { [&*a, &*b] } else { [&*b, &*a] };
        let pair = Pair { scene, other_alone: &alone, solids, tool, parts: [part, other], bodies };
        let by_points = if verdict == Some(Verdict::Duplicate) {
            // Neither surface is farther from the other than that.
            let is_cut_alike = relation == Relation::Duplicate;
            let apart = if is_cut_alike { PairLimits::rounding } else { PairLimits::copies_within };
            PointDepth { depth: 0.0, error: apart(&self.limits, parts[0], parts[1]), points: None }
        } else if a.is_closed() || b.is_closed() {
            let deepest = point_depth([&a, &b]);
            let sheets = (relation == Relation::Crossing).then(|| judge.crossing_of_sheets(parts)).flatten();
            sheets.filter(|crossing| crossing.depth > deepest.depth).unwrap_or(deepest)
        } else {
            crossing_depth([&a, &b])
        };
        let is_shallow = || by_points.depth <= self.limits.contact(parts[0], parts[1]);
        let verdict = verdict.unwrap_or_else(|| if is_shallow() { Verdict::Contact } else { Verdict::Clash });
        let kind = if is_open == [false; 2] { DepthKind::Measured } else { DepthKind::Estimate };
        if verdict == Verdict::Contact {
            let met = pair.meeting()?;
            return Ok(self.shallow(parts, by_points, kind, &met, part != parts[0], is_open));
        }
        let pool = self.solver.query().pool;
        let way = self.locations.with(|scratch| pair.way_out(relation.is_within(), pool, scratch))?;
        let way = if part == parts[0] { way } else { way.turned() };
        Ok(self.deep(parts, verdict, by_points, kind, way, is_open))
    }

    /// The part of a pair that serves as the tool: the one of fewer triangles.
    fn tool_of(&self, [a, b]: [u32; 2]) -> u32 {
        if self.solids.faces(b).len() < self.solids.faces(a).len() {
            b
        } else {
            a
        }
    }

    fn is_first_of_its_set(&self, pair: [u32; 2]) -> bool {
        self.first_of_set(pair) == Some(pair)
    }

    /// The first pair to check in the set of identical parts of a pair.
    fn first_of_set(&self, pair: [u32; 2]) -> Option<[u32; 2]> {
        let set = &self.sets[*self.set_of_part.get(&pair[0])?];
        let pairs = (0..set.len()).flat_map(|i| set[i + 1..].iter().map(move |b| [set[i], *b]));
        pairs.into_iter().find(|pair| self.limits.clearance(pair[0], pair[1]).is_some())
    }

    /// The other pairs of parts that are the same, as the first of each set.
    fn add_duplicates(&self, rows: &mut Vec<Clash>) {
        let firsts: BTreeMap<[u32; 2], Clash> =
            rows.iter().filter(|row| row.verdict == Verdict::Duplicate).map(|row| (row.parts, row.clone())).collect();
        for set in &self.sets {
            let pairs = (0..set.len()).flat_map(|i| set[i + 1..].iter().map(move |b| [set[i], *b]));
            let mut asked = pairs.filter(|[a, b]| self.limits.clearance(*a, *b).is_some());
            let Some(first) = asked.next().and_then(|first| firsts.get(&first)) else { continue };
            rows.extend(asked.map(|parts| Clash { parts, ..first.clone() }));
        }
    }

    /// Two parts that only touch.
    fn contact(&self, parts: [u32; 2], is_open: [bool; 2]) -> Clash {
        let touches = self.meeting.touches_of(parts);
        let mesh = self.scene().mockup().mesh();
        let (mut bounds, mut points) = (Aabb::EMPTY, None);
        for touch in touches {
            let both = touch.triangles.map(|t| mesh.triangle(t));
            bounds = bounds.union(&shared_box(&both));
            points.get_or_insert_with(|| touching_points(&both));
        }
        let (points, triangles) = (points.unwrap_or_default(), touches.len() as u32);
        Clash { points, triangles, bounds, ..Clash::of(parts, Verdict::Contact, is_open) }
    }

    /// Two parts that do not meet.
    fn apart(&self, gap: &PartGap, is_open: [bool; 2]) -> Clash {
        let is_contact = gap.distance <= self.limits.contact(gap.parts[0], gap.parts[1]);
        let verdict = if is_contact { Verdict::Contact } else { Verdict::Clearance };
        let mut bounds = Aabb::EMPTY;
        gap.points.iter().for_each(|p| bounds.grow(p));
        Clash { gap: gap.distance, points: gap.points, bounds, ..Clash::of(gap.parts, verdict, is_open) }
    }

    /// Two parts that cross no deeper than contact allows.
    fn shallow(
        &self,
        parts: [u32; 2],
        depth: PointDepth,
        kind: DepthKind,
        met: &Met,
        is_turned: bool,
        is_open: [bool; 2],
    ) -> Clash {
        let met_points = met.points.map(|[p, q]| if is_turned { [q, p] } else { [p, q] });
        Clash {
            depth: depth.depth,
            depth_error: depth.error,
            kind,
            gap: met.gap,
            points: depth.points.or(met_points).unwrap_or_default(),
            triangles: met.triangles.min(u32::MAX as usize) as u32,
            bounds: met.bounds,
            ..Clash::of(parts, Verdict::Contact, is_open)
        }
    }

    /// Two parts that are in each other.
    fn deep(
        &self,
        parts: [u32; 2],
        verdict: Verdict,
        depth: PointDepth,
        kind: DepthKind,
        way: WayOut,
        is_open: [bool; 2],
    ) -> Clash {
        // What lies in the other and meets nothing is shown where the surfaces are closest.
        let points = depth.points.filter(|_| verdict == Verdict::Clash || way.gap == 0.0).unwrap_or(way.points);
        let mut bounds = way.bounds;
        if way.triangles == 0 {
            bounds = Aabb::EMPTY;
            points.iter().for_each(|p| bounds.grow(p));
        }
        Clash {
            depth: depth.depth,
            depth_error: depth.error,
            kind,
            translation: way.translation,
            gap: way.gap,
            points,
            triangles: way.triangles.min(u32::MAX as usize) as u32,
            bounds,
            ..Clash::of(parts, verdict, is_open)
        }
    }
}
