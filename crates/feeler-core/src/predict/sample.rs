//! What a prediction looks at: the tool at a few places on the mock-up's surface, a part of its triangles there, and the
//! mock-up's triangles around each.

use rayon::prelude::*;

use super::crowd::{Crowd, Measured};
use super::place::Place;
use super::random::Random;
use super::{work_of, CostConstants};
use crate::bounds::{Aabb, Point, Triangle};
use crate::cost::StaticMeans;
use crate::mesh::Mesh;

/// Places of the tool.
const PLACES: u64 = 20;

/// Tool triangles at each place whose voxels are counted.
const VISITORS: usize = 128;

/// Of these, the ones whose neighbours are looked at.
const MEETERS: usize = 24;

/// Of so many mock-up triangles one is looked at: of fewer, a cell of the crowd would hold one of them or none, and the tool
/// would find gaps that are not there.
const STRIDE: usize = 16;

/// Least and most that are looked at.
const STATICS: [usize; 2] = [12_500, 200_000];

/// Of these, in a run that is passed over at once.
const RUN: usize = 32;

/// Mock-up triangles around one place that are looked at more closely.
const LOOKED_AT: usize = 2000;

/// Mock-up triangles around one place that are paired with the tool's.
const NEIGHBOURS: usize = 400;

/// Mock-up triangles whose shapes are kept.
const SHAPES: usize = 2000;

/// The box of a tool triangle at a place, cut to the mock-up's box.
#[derive(Debug, Clone, Copy)]
pub struct Visitor {
    pub extent: Point,
    /// How many tool triangles of a pose it stands for.
    pub weight: f64,
}

/// A tool triangle at a place and a mock-up triangle near it.
#[derive(Debug, Clone, Copy)]
pub struct Meeting {
    /// By how much the two boxes overlap along each axis, metres; negative: the gap between them.
    pub overlap: Point,
    pub shape: Shape,
    /// How many pairs of a pose it stands for.
    pub weight: f64,
    /// The largest gap, metres; 0 where the boxes meet.
    pub gap: f64,
}

/// What decides how many voxels a triangle meets.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    /// Sides of its box, metres.
    pub extent: Point,
    /// Sum of the areas of its three shadows along the axes, square metres.
    pub shadows: f64,
}

impl Shape {
    /// Of a triangle.
    pub fn of(t: &Triangle) -> Shape {
        let shadow = |u: usize, v: usize| {
            0.5 * ((t[1][u] - t[0][u]) * (t[2][v] - t[0][v]) - (t[1][v] - t[0][v]) * (t[2][u] - t[0][u])).abs()
        };
        Shape { extent: Aabb::of_triangle(t).extent(), shadows: shadow(0, 1) + shadow(1, 2) + shadow(2, 0) }
    }
}

/// A part of the mock-up's triangles.
#[derive(Debug)]
pub struct Statics {
    pub triangles: Vec<Measured>,
    /// Boxes around runs of them: neighbours in a file are mostly neighbours in space.
    runs: Vec<Aabb>,
    /// How many each stands for.
    pub each: f64,
    /// Their means, which stand for the mock-up's.
    pub means: StaticMeans,
}

impl Statics {
    /// Evenly spread over the mesh.
    pub fn new(mesh: &Mesh) -> Statics {
        let ids = spread(mesh, (mesh.queried_count() / STRIDE).clamp(STATICS[0], STATICS[1]));
        let mut triangles = Vec::new();
        ids.par_iter().map(|id| Measured::of(mesh.triangle(*id))).collect_into_vec(&mut triangles);
        let n = triangles.len() as f64;
        let mean = |f: fn(&Measured) -> f64| triangles.iter().map(f).sum::<f64>() / n;
        let around = |run: &[Measured]| run.iter().fold(Aabb::EMPTY, |all, t| all.union(&t.bounds));
        Statics {
            each: mesh.queried_count() as f64 / n,
            means: StaticMeans { area: mean(|t| t.area), edge: mean(|t| t.outline / 3.0) },
            runs: triangles.chunks(RUN).map(around).collect(),
            triangles,
        }
    }
}

/// See the module. Deterministic.
#[derive(Debug)]
pub struct Sample {
    pub visitors: Vec<Visitor>,
    /// By ascending gap.
    pub meetings: Vec<Meeting>,
    /// Shapes of mock-up triangles anywhere.
    pub shapes: Vec<Shape>,
    /// How many each of them stands for.
    pub each_shape: f64,
}

impl Sample {
    /// Mock-up triangles count as near up to `reach` metres from a tool triangle's box. `start` is a likely voxel size.
    pub fn new(statics: &Statics, bounds: &Aabb, tool: &Mesh, start: f64, reach: f64) -> Sample {
        let tool_ids: Vec<u32> = tool.queried().collect();
        let chosen = chosen_visitors(tool, &tool_ids);
        let crowd = Crowd::new(bounds, &statics.triangles, statics.each);
        let mut found: Vec<(Vec<Visitor>, Vec<Meeting>)> = (0..PLACES)
            .into_par_iter()
            .map(|seed| {
                let place = Place::at_work(statics, tool, &tool_ids, &crowd, seed);
                let boxes: Vec<(Aabb, f64)> = chosen
                    .iter()
                    .map(|(id, weight)| (Aabb::of_triangle(&place.apply(&tool.triangle(*id))), *weight))
                    .collect();
                let visitors = boxes.iter().filter(|(b, _)| b.is_overlapping(bounds)).map(|(b, weight)| {
                    let extent =
                        std::array::from_fn(|a| b.upper[a].min(bounds.upper[a]) - b.lower[a].max(bounds.lower[a]));
                    Visitor { extent, weight: *weight }
                });
                let (near, every) = near(statics, &place, tool, reach);
                let each = statics.each * every as f64;
                (visitors.collect(), meetings(statics, &boxes, &near, each, reach, &mut Random::new(!seed)))
            })
            .collect();
        balance(&mut found, start);
        let (visitors, meetings): (Vec<_>, Vec<_>) = found.into_iter().unzip();
        let mut meetings = meetings.concat();
        meetings.sort_unstable_by(|p, q| p.gap.total_cmp(&q.gap));
        let few = statics.triangles.len().div_ceil(SHAPES);
        let shapes: Vec<Shape> = statics.triangles.iter().step_by(few).map(|t| Shape::of(&t.corners)).collect();
        Sample {
            visitors: visitors.concat(),
            meetings,
            each_shape: statics.each * statics.triangles.len() as f64 / shapes.len() as f64,
            shapes,
        }
    }
}

/// Weighs the places so that each counts by how much longer a query takes there than with voxels of `start` metres.
///
/// In a plain mean the few through a crowd of slivers, where a query takes a hundred times as long, would decide alone.
pub(super) fn balance(found: &mut [(Vec<Visitor>, Vec<Meeting>)], start: f64) {
    let seconds: Vec<f64> = found
        .iter()
        .map(|(visitors, meetings)| {
            let near: Vec<Meeting> = meetings.iter().filter(|m| m.gap < start).copied().collect();
            work_of(visitors, &near, start).seconds(&CostConstants::default())
        })
        .collect();
    let places = seconds.len() as f64;
    // Which level the weights have decides nothing: that of the geometric mean, which few places move.
    let level = (seconds.iter().map(|t| t.ln()).sum::<f64>() / places).exp();
    for ((visitors, meetings), t) in found.iter_mut().zip(&seconds) {
        let weight = level / (t * places);
        visitors.iter_mut().for_each(|v| v.weight *= weight);
        meetings.iter_mut().for_each(|m| m.weight *= weight);
    }
}

/// The mock-up's triangles that may be within `reach` of the tool's box at a place, and how many of the sample each stands for.
fn near(statics: &Statics, place: &Place, tool: &Mesh, reach: f64) -> (Vec<usize>, usize) {
    let around = grown(&place.bounds_of(tool), reach);
    let is_near = |i: &usize| {
        let b = &statics.triangles[*i].bounds;
        // The box around the turned box holds much that is not near.
        around.is_overlapping(b) && {
            let middle = place.in_tool(&std::array::from_fn(|a| 0.5 * b.lower[a] + 0.5 * b.upper[a]));
            let radius = 0.5 * b.extent().iter().map(|x| x * x).sum::<f64>().sqrt();
            grown(&tool.bounds(), reach + radius).is_overlapping(&Aabb { lower: middle, upper: middle })
        }
    };
    let runs: Vec<usize> = (0..statics.runs.len()).filter(|run| around.is_overlapping(&statics.runs[*run])).collect();
    let every = (runs.len() * RUN).div_ceil(LOOKED_AT).max(1);
    let looked_at = (0..runs.len() * RUN).step_by(every).map(|i| runs[i / RUN] * RUN + i % RUN);
    (looked_at.filter(|i| *i < statics.triangles.len()).filter(is_near).collect(), every)
}

/// At most `most` queried triangles, evenly spread; at least one.
pub(super) fn spread(mesh: &Mesh, most: usize) -> Vec<u32> {
    let stride = mesh.queried_count().div_ceil(most).max(1);
    if mesh.defects().excluded.is_empty() {
        return (0..mesh.faces().len() as u32).step_by(stride).collect();
    }
    mesh.queried().step_by(stride).collect()
}

/// Tool triangles and how many each stands for: long ones, which visit more voxels, are chosen more often.
fn chosen_visitors(tool: &Mesh, ids: &[u32]) -> Vec<(u32, f64)> {
    let lengths: Vec<f64> =
        ids.iter().map(|id| Aabb::of_triangle(&tool.triangle(*id)).extent().iter().sum::<f64>()).collect();
    let mean = lengths.iter().sum::<f64>() / ids.len() as f64;
    if ids.len() <= VISITORS || !(mean.is_finite() && mean > 0.0) {
        return ids.iter().map(|id| (*id, 1.0)).collect();
    }
    let shares: Vec<f64> = lengths.iter().map(|length| mean + length).collect();
    chosen(ids, &shares, VISITORS).into_iter().map(|(id, times, weight)| (id, f64::from(times) * weight)).collect()
}

/// About `most` of the triangles, in proportion to their shares: how often each was chosen, and how many it stands for each time.
pub(super) fn chosen(ids: &[u32], shares: &[f64], most: usize) -> Vec<(u32, u32, f64)> {
    let total: f64 = shares.iter().sum();
    let step = total / most as f64;
    let (mut chosen, mut sum, mut next) = (Vec::new(), 0.0, 0.5 * step);
    for (id, share) in ids.iter().zip(shares) {
        sum += share;
        let mut times = 0;
        while next < sum {
            times += 1;
            next += step;
        }
        if times > 0 {
            chosen.push((*id, times, step / share));
        }
    }
    chosen
}

/// The pairs of a place. Those far apart, of which there are many and which few voxel sizes bring together, are thinned.
fn meetings(
    all: &Statics,
    boxes: &[(Aabb, f64)],
    near: &[usize],
    each: f64,
    reach: f64,
    random: &mut Random,
) -> Vec<Meeting> {
    if near.is_empty() {
        return Vec::new();
    }
    // Another part of the tool's triangles at each place.
    let every = boxes.len().div_ceil(MEETERS).max(1);
    let first = random.below(every);
    let some = boxes.iter().skip(first).step_by(every);
    let every_near = near.len().div_ceil(NEIGHBOURS);
    let neighbours: Vec<usize> = near.iter().skip(random.below(every_near)).step_by(every_near).copied().collect();
    let statics: Vec<Aabb> = neighbours.iter().map(|i| all.triangles[*i].bounds).collect();
    let weight = each * every as f64 * every_near as f64;
    let kept_whole = reach / 8.0;
    let mut found = Vec::new();
    for (tool_box, tool_weight) in some {
        for (b, i) in statics.iter().zip(&neighbours) {
            let overlap: Point =
                std::array::from_fn(|a| tool_box.upper[a].min(b.upper[a]) - tool_box.lower[a].max(b.lower[a]));
            let gap = -overlap[0].min(overlap[1]).min(overlap[2]).min(0.0);
            if gap < reach {
                let share = f64::min(1.0, (kept_whole / gap).powi(2));
                if share == 1.0 || random.unit() < share {
                    let shape = Shape::of(&all.triangles[*i].corners);
                    found.push(Meeting { overlap, shape, weight: weight * tool_weight / share, gap });
                }
            }
        }
    }
    found
}

fn grown(b: &Aabb, margin: f64) -> Aabb {
    Aabb { lower: b.lower.map(|x| x - margin), upper: b.upper.map(|x| x + margin) }
}
