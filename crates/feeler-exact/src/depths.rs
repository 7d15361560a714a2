//! Depths by points of [`polyhedra`](crate::polyhedra) with integer corners: no point inside is deeper than the
//! reported depth, and the reported point lies on its surface, inside the other, at that depth.

use std::sync::Arc;

use feeler_contacts::{ContactSolver, DepthKind, PartDepth};
use feeler_core::{Mockup, Point, Pose, Scene, SceneOptions, Tool};

use crate::blocks::{Spot, Surface};
use crate::check::STORES;
use crate::polyhedra::{Family, KINDS};
use crate::random::{Random, ORDERS};
use crate::spots::{Fine, Place, Triangles, PARTS};
use crate::tally::{self, Figures};

/// Points of each surface that are tried beside its corners.
const SAMPLES: usize = 60;

/// Of these the deepest are moved on their triangles so often.
const CLIMBERS: usize = 3;
const CLIMBS: usize = 120;

/// Bound of the rounding, over the roundings of coordinates: strips of surface that thin count as nothing.
const ROUNDINGS: f64 = 64.0;

/// Counts of the depth judge. `worst` is the largest excess of a point's depth over the depth told.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DepthsFound {
    /// Points of surfaces that exact arithmetic found inside the other body.
    pub points: u64,
    /// Pairs that are deep in each other, and those that are not.
    pub deep: u64,
    /// See `deep`.
    pub shallow: u64,
    /// Of the deep ones, those where a point was found as deep, but for a hundredth.
    pub reached: u64,
    /// Pairs of which a surface does not count as closed: it is cut so that edges do not meet, and there four triangles meet, or it is thin.
    pub open: u64,
}

impl Figures for DepthsFound {
    fn add(&mut self, other: DepthsFound) {
        self.points += other.points;
        self.deep += other.deep;
        self.shallow += other.shallow;
        self.reached += other.reached;
        self.open += other.open;
    }
}

type Tally = crate::tally::Tally<DepthsFound>;

/// Runs `cases` pairs of each of some families (all where none is named), from a number on; pair `i` depends on the seed and `i` alone.
/// `progress` is called as pairs finish.
///
/// Errors: a family that there is not.
pub fn run(
    cases: u64,
    seed: u64,
    from: u64,
    only: &[String],
    progress: &dyn Fn(&str, f64),
) -> Result<Vec<(Family, Tally)>, String> {
    tally::run(&KINDS, [from, cases], only, progress, |family, i| judge(family, seed, i))
}

/// Where units are in the world: nothing is rounded on the way there.
struct Placed {
    /// Metres.
    unit: f64,
    /// Units that the world's origin is off.
    offset: Spot,
    /// A permutation of axes, and their senses, of the tool's frame.
    turn: [(usize, f64); 3],
    /// Where the tool's origin is, units.
    origin: Spot,
    /// Bound of the rounding of a depth, units.
    tolerance: f64,
}

impl Placed {
    fn new(pair: &[Surface; 2], r: &mut Random) -> Placed {
        let largest = pair.iter().flat_map(|surface| &surface.0).flatten().map(|x| x.abs()).max().unwrap_or(1);
        let far = r.pick(&[0, 0, 0, 1 << 16, 1 << 24]);
        let whole = |r: &mut Random, reach: i32| [0; 3].map(|_| i64::from(r.whole(-reach, reach)));
        let (offset, origin) = (whole(r, far), whole(r, 1 << 10));
        let (order, signs) = (ORDERS[r.below(6)], [0; 3].map(|_| r.pick(&[-1.0, 1.0])));
        let is_mirror =
            ORDERS.iter().position(|o| *o == order).is_some_and(|n| n > 2) != (signs.iter().product::<f64>() < 0.0);
        let turn = if is_mirror { [(0, 1.0), (1, 1.0), (2, 1.0)] } else { [0, 1, 2].map(|a| (order[a], signs[a])) };
        let place = offset.iter().map(|x| x.abs()).max().unwrap_or(0) + largest;
        let tolerance =
            ROUNDINGS * (largest as f64 * 2f64.powi(-48) + 6.0 * place as f64 * f64::EPSILON) + 4.0 / PARTS as f64;
        Placed { unit: 2f64.powi(-r.whole(0, 16)), offset, turn, origin, tolerance }
    }

    fn world(&self, p: &Spot) -> Point {
        [0, 1, 2].map(|a| (p[a] + self.offset[a]) as f64 * self.unit)
    }

    fn pose(&self) -> Result<Pose, String> {
        let mut m = [[0.0; 4]; 4];
        m[3][3] = 1.0;
        for (a, (axis, sense)) in self.turn.into_iter().enumerate() {
            m[a][axis] = sense;
            m[a][3] = (self.origin[a] + self.offset[a]) as f64 * self.unit;
        }
        Pose::new(&m).map_err(|e| e.to_string())
    }

    fn in_tool(&self, p: &Spot) -> Point {
        let mut at = [0.0; 3];
        for (a, (axis, sense)) in self.turn.into_iter().enumerate() {
            at[axis] = sense * (p[a] - self.origin[a]) as f64 * self.unit;
        }
        at
    }

    /// A point of the world, rounded to parts.
    fn fine(&self, p: &Point) -> Fine {
        [0, 1, 2].map(|a| ((p[a] / self.unit - self.offset[a] as f64) * PARTS as f64).round() as i128)
    }

    /// What is said of a tool and a mock-up of one part; `None` if one does not count as closed.
    fn depth(&self, [tool, part]: [&Surface; 2], r: &mut Random) -> Result<Option<Vec<PartDepth>>, String> {
        let mockup = Mockup::new(part.0.iter().map(|p| self.world(p)).collect(), part.1.clone(), Vec::new(), 1);
        let mockup = mockup.map_err(|e| e.to_string())?;
        let tool =
            Tool::new(tool.0.iter().map(|p| self.in_tool(p)).collect(), tool.1.clone()).map_err(|e| e.to_string())?;
        let options = SceneOptions::default().with_storage(STORES[r.below(STORES.len())]);
        let scene = Scene::build(Arc::new(mockup), &options).map_err(|e| e.to_string())?;
        let is_closed = [scene.mockup().adjacency(), tool.adjacency()].map(|of| !of.outward.contains(&0));
        let found = ContactSolver::new(Arc::new(scene)).depths(&tool, &self.pose()?);
        Ok((is_closed == [true; 2]).then_some(found))
    }
}

/// The deepest of some points of a surface that are inside another, and how many are inside.
struct Deepest {
    depth: f64,
    at: Fine,
    points: u64,
}

fn deepest(surface: &Triangles, other: &Triangles, r: &mut Random) -> Deepest {
    let mut best: Vec<(f64, usize, [i128; 3])> = Vec::new();
    let mut points = 0;
    let depth_at = |i: usize, shares: &[i128; 3]| {
        let p = surface.point(i, shares);
        (other.place(&p) == Place::Inside).then(|| other.distance(&p))
    };
    let corners = (0..surface.len()).map(|i| (i, [PARTS, 0, 0]));
    let random = (0..SAMPLES).map(|_| {
        let [mut x, mut y] = [0; 2].map(|_| (r.bits() % (PARTS as u64 + 1)) as i128);
        if x + y > PARTS {
            (x, y) = (PARTS - x, PARTS - y);
        }
        let mut shares = [x, y, PARTS - x - y];
        match r.below(4) {
            0 => shares = [x + y, 0, PARTS - x - y],
            1 => shares = [PARTS / 4, PARTS / 4, PARTS / 2],
            _ => {}
        }
        (r.below(surface.len()), shares)
    });
    let tried: Vec<(usize, [i128; 3])> = corners.chain(random).collect();
    for (i, shares) in tried {
        if let Some(depth) = depth_at(i, &shares) {
            points += 1;
            best.push((depth, i, shares));
        }
    }
    best.sort_by(|p, q| q.0.total_cmp(&p.0));
    best.truncate(CLIMBERS);
    for (depth, i, shares) in &mut best {
        let mut step = PARTS as u64 / 2;
        for _ in 0..CLIMBS {
            let [x, y] = [0; 2].map(|_| (r.bits() % (2 * step + 1)) as i128 - i128::from(step));
            let k = r.below(3);
            let mut new = [0; 3];
            new[k] = (shares[k] + x).clamp(0, PARTS);
            new[(k + 1) % 3] = (shares[(k + 1) % 3] + y).clamp(0, PARTS - new[k]);
            new[(k + 2) % 3] = PARTS - new[k] - new[(k + 1) % 3];
            match depth_at(*i, &new) {
                Some(deeper) if deeper > *depth => (*depth, *shares, points) = (deeper, new, points + 1),
                _ => step = (step * 7 / 8).max(1),
            }
        }
    }
    let of =
        |(depth, i, shares): &(f64, usize, [i128; 3])| Deepest { depth: *depth, at: surface.point(*i, shares), points };
    best.iter().max_by(|p, q| p.0.total_cmp(&q.0)).map_or(Deepest { depth: 0.0, at: [0; 3], points }, of)
}

fn judge(family: &Family, seed: u64, i: u64) -> Tally {
    let mut r = Random::new(seed.wrapping_mul(1 << 32) ^ i);
    let pair = family.make(&mut r);
    let placed = Placed::new(&pair, &mut r);
    let mut tally = Tally { cases: 1, ..Tally::default() };
    let faults = faults_of(&pair, &placed, &mut r, &mut tally).unwrap_or_else(|why| vec![why]);
    tally.fault_count = faults.len() as u64;
    let what = |fault| format!("{} {i} (seed {seed}), {} triangles: {fault}", family.name, tally.triangles);
    tally.faults = faults.into_iter().map(what).collect();
    tally
}

fn faults_of(pair: &[Surface; 2], placed: &Placed, r: &mut Random, tally: &mut Tally) -> Result<Vec<String>, String> {
    let surfaces = pair.each_ref().map(Triangles::new);
    let [p, q] = &surfaces;
    tally.triangles = (p.len() + q.len()) as u64;
    let found = [deepest(p, q, r), deepest(q, p, r)];
    tally.figures.points = found[0].points + found[1].points;
    let truth = found[0].depth.max(found[1].depth);
    let mut faults = Vec::new();
    // As tool and mock-up, and the other way round.
    for turned in [false, true] {
        let [tool, part] = if turned { [1, 0] } else { [0, 1] };
        let Some(all) = placed.depth([&pair[tool], &pair[part]], r)? else {
            tally.figures.open += u64::from(!turned);
            continue;
        };
        let said = match &all[..] {
            [said] => said,
            [] if truth == 0.0 => {
                tally.figures.shallow += u64::from(!turned);
                continue;
            }
            _ => {
                let at = found.each_ref().map(|d| (d.depth, d.at));
                faults.push(format!("{} depths, in truth {at:?}; turned: {turned}", all.len()));
                continue;
            }
        };
        let [depth, error] = [said.depth, said.error].map(|x| x / placed.unit);
        let mut fault = |what: String| faults.push(format!("{what}; turned: {turned}, {depth} + {error} of {said:?}"));
        if said.kind != DepthKind::Measured || !(depth >= 0.0 && error >= 0.0) {
            fault("not measured".to_string());
        }
        if said.error > (1e-3 * said.depth).max(1e-9) + placed.tolerance * placed.unit {
            fault("not as exact as promised".to_string());
        }
        let over = truth - depth - error;
        if over > placed.tolerance {
            fault(format!("a point is {truth} deep: {:?}", found.iter().map(|d| (d.depth, d.at)).collect::<Vec<_>>()));
        }
        tally.worst = tally.worst.max((truth - depth) / (error + placed.tolerance));
        if depth > 4.0 * placed.tolerance {
            let points = said.points.map(|p| placed.fine(&p));
            let surfaces = [&surfaces[tool], &surfaces[part]];
            if let Err(why) = [0, 1]
                .map(|side| is_attained(&points, surfaces, side, depth, placed.tolerance))
                .into_iter()
                .reduce(Result::or)
                .unwrap_or(Ok(()))
            {
                fault(why);
            }
        }
        if !turned {
            let is_deep = depth > 4.0 * placed.tolerance;
            *(if is_deep { &mut tally.figures.deep } else { &mut tally.figures.shallow }) += 1;
            tally.figures.reached += u64::from(is_deep && truth >= 0.99 * depth);
        }
    }
    Ok(faults)
}

/// Whether the point of one of the surfaces is on it, inside the other, and as deep as said; the other point is the closest there.
fn is_attained(
    points: &[Fine; 2],
    surfaces: [&Triangles; 2],
    side: usize,
    depth: f64,
    tolerance: f64,
) -> Result<(), String> {
    let ([at, closest], [own, other]) = match side {
        0 => (*points, surfaces),
        _ => ([points[1], points[0]], [surfaces[1], surfaces[0]]),
    };
    let between = (0..3).map(|a| (at[a] - closest[a]) as f64).map(|x| x * x).sum::<f64>().sqrt() / PARTS as f64;
    let off =
        [own.distance(&at), (other.distance(&at) - depth).abs(), other.distance(&closest), (between - depth).abs()];
    if other.place(&at) != Place::Inside || off.iter().any(|off| *off > tolerance) {
        return Err(format!("not attained: {:?}, off by {off:?}", other.place(&at)));
    }
    Ok(())
}
