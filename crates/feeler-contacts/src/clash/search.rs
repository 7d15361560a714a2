//! The search for all pairs of parts that are too near each other: first what each pair is, then how near those are that do not meet,
//! then how deep those are that do.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use feeler_core::clash::asked::in_order;
use feeler_core::clash::duplicates::{duplicate_pairs, same_parts};
use feeler_core::clash::holding::held_parts;
use feeler_core::clash::location::LocationScratch;
use feeler_core::clash::meeting::{meeting_parts, Meeting};
use feeler_core::clash::meets::Meets;
use feeler_core::clash::near::{near_parts, PartGap};
use feeler_core::clash::search::SelfIndex;
use feeler_core::clash::solids::Solids;
use feeler_core::clash::touch::{judge, Touching};
use feeler_core::geometry::vectors::dot;
use feeler_core::scratch_pool::ScratchPool;
use feeler_core::{closest_triangle_triangle, Aabb, PairLimits, Progress, Result, Scene, Tool};
use rayon::prelude::*;

use super::depth::{shared_box, Depth, Pair};
use super::row::{Clash, Verdict};
use crate::escape::penetration::PenetrationKind;
use crate::solver::ContactSolver;

/// What two parts are to each other, before anything is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Relation {
    Duplicate,
    Crossing,
    Touching(Touching),
    /// Nothing meets, and one holds the other.
    Held,
}

/// Two parts, and what they are to each other.
type Related = ([u32; 2], Relation);

impl Relation {
    /// Whether one is wholly in the other.
    fn is_within(self) -> bool {
        matches!(self, Relation::Duplicate | Relation::Held | Relation::Touching(Touching::Holding | Touching::Held))
    }
}

/// A search in steps, each of which may be stopped; what was found until then can be told.
#[derive(Debug)]
pub struct ClashSearch<'a> {
    solver: &'a ContactSolver,
    limits: &'a PairLimits,
    index: SelfIndex<'a>,
    solids: Solids<'a>,
    /// By pair.
    relations: BTreeMap<[u32; 2], Relation>,
    meeting: Meeting,
    sets: Vec<Vec<u32>>,
    gaps: Vec<PartGap>,
    is_complete: bool,
    is_measuring: bool,
    /// Working memory.
    locations: ScratchPool<LocationScratch>,
}

const STAGE: &str = "measuring depths";

/// How many pairs were found, by what they are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ClashCounts {
    /// Pairs that cross.
    pub crossing: usize,
    /// Pairs that meet and do not cross.
    pub touching: usize,
    /// Pairs of which one holds the other and nothing meets.
    pub held: usize,
    /// Pairs with the same triangles.
    pub duplicates: usize,
    /// Pairs that are near and do not meet.
    pub near: usize,
}

impl<'a> ClashSearch<'a> {
    /// Of the parts that are there. Errors: as of building blocks, where the scene has none.
    pub fn new(solver: &'a ContactSolver, limits: &'a PairLimits) -> Result<ClashSearch<'a>> {
        let scene = solver.scene();
        let meeting = Meeting { pairs: Vec::new(), touches: Vec::new(), is_complete: true };
        Ok(ClashSearch {
            solver,
            limits,
            index: SelfIndex::new(scene.index())?,
            solids: Solids::new(scene.mockup()),
            relations: BTreeMap::new(),
            meeting,
            sets: Vec::new(),
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
    pub fn find_verdicts(&mut self, progress: Progress<'_>) -> bool {
        let (index, limits) = (self.scene().index(), self.limits);
        self.sets = same_parts(self.scene().mockup(), |part| index.selection().has_part(part));
        let duplicates = duplicate_pairs(&self.sets, limits);
        self.relations = duplicates.iter().map(|pair| (*pair, Relation::Duplicate)).collect();
        self.meeting = meeting_parts(&self.index, limits, &duplicates, progress);
        let (meeting, solids) = (&self.meeting, &self.solids);
        let found: Vec<Related> = meeting
            .pairs
            .par_iter()
            .map(|pair| {
                let relation = match pair.meets {
                    Meets::Crossing => Relation::Crossing,
                    Meets::Touching => self.locations.with(|scratch| {
                        let touches = meeting.touches_of(pair.parts);
                        Relation::Touching(judge((index, solids), pair.parts, touches, scratch))
                    }),
                };
                (pair.parts, relation)
            })
            .collect();
        self.relations.extend(found);
        if meeting.is_complete {
            let known: Vec<[u32; 2]> = self.relations.keys().copied().collect();
            let held = held_parts(index, solids, limits, &known);
            self.relations.extend(held.iter().map(|held| (in_order([held.part, held.by]), Relation::Held)));
        }
        self.is_complete &= self.meeting.is_complete;
        self.is_complete
    }

    /// Measures how near the pairs are that do not meet; false where it was stopped.
    pub fn find_gaps(&mut self, progress: Progress<'_>) -> bool {
        if self.limits.largest_reach() > 0.0 {
            let known: Vec<[u32; 2]> = self.relations.keys().copied().collect();
            let found = near_parts(&self.index, self.limits, &known, progress);
            self.gaps = found.all;
            self.is_complete &= found.is_complete;
        }
        self.is_complete
    }

    /// Whether nothing was stopped so far.
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// What was found so far.
    pub fn counts(&self) -> ClashCounts {
        let mut counts = ClashCounts { near: self.gaps.len(), ..ClashCounts::default() };
        for relation in self.relations.values() {
            *match relation {
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
    pub fn measure(&mut self, progress: Progress<'_>) -> Result<Vec<Clash>> {
        let is_stopped = !progress(0.0, STAGE);
        let adjacency = (!is_stopped).then(|| self.scene().mockup().adjacency());
        let is_open =
            |parts: [u32; 2]| parts.map(|part| adjacency.is_some_and(|adjacency| adjacency.shells_of(part).is_empty()));
        self.is_measuring = !is_stopped;
        let mut rows = Vec::new();
        let mut deep: BTreeMap<u32, Vec<Related>> = BTreeMap::new();
        for (pair, relation) in &self.relations {
            match relation {
                Relation::Touching(Touching::Beside) => rows.push(self.contact(*pair, is_open(*pair))),
                // Of parts that are the same all pairs are as the first.
                Relation::Duplicate if !self.is_first_of_its_set(*pair) => {}
                _ => deep.entry(self.tool_of(*pair, *relation)).or_default().push((*pair, *relation)),
            }
        }
        rows.extend(self.gaps.iter().map(|gap| self.apart(gap, is_open(gap.parts))));
        let groups: Vec<(u32, Vec<Related>)> = deep.into_iter().collect();
        const WAVE: usize = 256;
        for (n, wave) in groups.chunks(WAVE).enumerate() {
            if !self.is_measuring || !progress((n * WAVE) as f64 / groups.len() as f64, STAGE) {
                (self.is_complete, self.is_measuring) = (false, false);
                let all = wave.iter().flat_map(|(_, pairs)| pairs);
                rows.extend(all.map(|(pair, relation)| self.met(*pair, *relation, Depth::UNKNOWN, is_open(*pair))));
                continue;
            }
            let measured: Vec<Result<Vec<Clash>>> = wave
                .par_iter()
                .map(|(part, pairs)| {
                    let tool = self.solids.tool(*part)?;
                    let measured = pairs.iter().map(|(pair, relation)| {
                        let depth = self.depth_of(&tool, *part, *pair, *relation)?;
                        Ok(self.met(*pair, *relation, depth, is_open(*pair)))
                    });
                    measured.collect()
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

    /// How deep one part of a pair, as a tool, is in the other.
    fn depth_of(&self, tool: &Tool, part: u32, pair: [u32; 2], relation: Relation) -> Result<Depth> {
        let other = if pair[0] == part { pair[1] } else { pair[0] };
        let (scene, solids) = (self.scene(), &self.solids);
        let alone = scene.of_one_part(other);
        let measured = Pair { scene, other_alone: &alone, solids, tool, parts: [part, other] };
        let pool = self.solver.query().pool;
        let depth = self.locations.with(|scratch| measured.measure(relation.is_within(), pool, scratch))?;
        Ok(if pair[0] == part { depth } else { depth.turned() })
    }

    /// The part of a pair that serves as the tool: the one of fewer triangles; where one is within the other, the one in the smaller
    /// box, as it is near little else.
    fn tool_of(&self, [a, b]: [u32; 2], relation: Relation) -> u32 {
        let extent = |part: u32| {
            let extent = self.scene().mockup().part_bounds()[part as usize].extent();
            dot(&extent, &extent)
        };
        let by_box = if relation.is_within() { extent(b).total_cmp(&extent(a)) } else { Ordering::Equal };
        if by_box.then(self.solids.faces(b).len().cmp(&self.solids.faces(a).len())).is_lt() {
            b
        } else {
            a
        }
    }

    fn is_first_of_its_set(&self, pair: [u32; 2]) -> bool {
        self.first_of_set(pair) == Some(pair)
    }

    /// The first pair that is asked of the set of two parts that are the same.
    fn first_of_set(&self, pair: [u32; 2]) -> Option<[u32; 2]> {
        let set = self.sets.iter().find(|set| set.binary_search(&pair[0]).is_ok())?;
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
            points.get_or_insert_with(|| {
                let closest = closest_triangle_triangle(&both[0], &both[1]);
                [closest.on_p, closest.on_q]
            });
        }
        Clash {
            parts,
            verdict: Verdict::Contact,
            depth: 0.0,
            kind: PenetrationKind::Exact,
            translation: [0.0; 3],
            gap: 0.0,
            points: points.unwrap_or_default(),
            triangles: touches.len() as u32,
            bounds,
            is_open,
        }
    }

    /// Two parts that do not meet.
    fn apart(&self, gap: &PartGap, is_open: [bool; 2]) -> Clash {
        let is_contact = gap.distance <= self.limits.contact(gap.parts[0], gap.parts[1]);
        let mut bounds = Aabb::EMPTY;
        gap.points.iter().for_each(|p| bounds.grow(p));
        Clash {
            parts: gap.parts,
            verdict: if is_contact { Verdict::Contact } else { Verdict::Clearance },
            depth: 0.0,
            kind: PenetrationKind::Exact,
            translation: [0.0; 3],
            gap: gap.distance,
            points: gap.points,
            triangles: 0,
            bounds,
            is_open,
        }
    }

    /// Two parts that are in each other.
    fn met(&self, parts: [u32; 2], relation: Relation, measured: Depth, is_open: [bool; 2]) -> Clash {
        let contact = self.limits.contact(parts[0], parts[1]);
        let verdict = match relation {
            Relation::Duplicate => Verdict::Duplicate,
            relation if relation.is_within() => Verdict::Contained,
            _ if contact > 0.0 && measured.depth <= contact => Verdict::Contact,
            _ => Verdict::Clash,
        };
        Clash {
            parts,
            verdict,
            depth: measured.depth,
            kind: measured.kind,
            translation: measured.translation,
            gap: measured.gap,
            points: measured.points,
            triangles: measured.triangles.min(u32::MAX as usize) as u32,
            bounds: measured.bounds,
            is_open,
        }
    }
}
