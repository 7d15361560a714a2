//! What a prediction looks at: the tool at a few places on the mock-up's surface, a part of its triangles there, and the
//! mock-up's triangles around each.

use std::cmp::Ordering;

use rayon::prelude::*;

use super::crowd::Crowd;
use super::place::Place;
use super::random::Random;
use crate::bounds::{Aabb, Point, Triangle};
use crate::cost::StaticMeans;
use crate::mesh::Mesh;
use crate::pieces::{edge_lengths, twice_area};

/// Places of the tool that are tried.
const TRIES: u64 = 32;

/// And kept: of those at work the ones where it meets least. A few, through a crowd of slivers, would outweigh all others.
const KEPT: usize = 26;

/// Tool triangles at each place whose voxels are counted.
const VISITORS: usize = 128;

/// Of these, the ones whose neighbours are looked at.
const MEETERS: usize = 24;

/// Mock-up triangles looked at, evenly spread over the mesh.
const STATICS: usize = 50_000;

/// Of these, in a run that is passed over at once.
const RUN: usize = 32;

/// Mock-up triangles around one place that are looked at more closely.
const LOOKED_AT: usize = 3000;

/// Mock-up triangles around one place that are paired with the tool's.
const NEIGHBOURS: usize = 500;

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
    pub triangles: Vec<Triangle>,
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
        let ids = spread(mesh, STATICS);
        let mut triangles = Vec::new();
        ids.par_iter().map(|id| mesh.triangle(*id)).collect_into_vec(&mut triangles);
        let n = triangles.len() as f64;
        // Summed up in order: the same for any number of threads.
        let looked: Vec<(Aabb, StaticMeans)> = triangles.par_chunks(RUN).map(around).collect();
        let sum = |f: fn(&StaticMeans) -> f64| looked.iter().map(|(_, sums)| f(sums)).sum::<f64>();
        Statics {
            each: mesh.queried_count() as f64 / n,
            means: StaticMeans { area: sum(|s| s.area) / n, edge: sum(|s| s.edge) / n },
            runs: looked.iter().map(|(b, _)| *b).collect(),
            triangles,
        }
    }
}

/// The box around a run of triangles, and the sums of their areas and mean edges.
fn around(run: &[Triangle]) -> (Aabb, StaticMeans) {
    run.iter().fold((Aabb::EMPTY, StaticMeans { area: 0.0, edge: 0.0 }), |(b, sums), t| {
        let edge = edge_lengths(t).iter().sum::<f64>() / 3.0;
        (b.union(&Aabb::of_triangle(t)), StaticMeans { area: sums.area + 0.5 * twice_area(t), edge: sums.edge + edge })
    })
}

/// See the module. Deterministic.
#[derive(Debug)]
pub struct Sample {
    pub places: f64,
    pub visitors: Vec<Visitor>,
    /// By ascending gap.
    pub meetings: Vec<Meeting>,
    /// Shapes of mock-up triangles anywhere.
    pub shapes: Vec<Shape>,
    /// How many each of them stands for.
    pub each_shape: f64,
}

/// What is found at a place.
struct Found {
    /// How far it is from a place at work, see [`Place::at_work`].
    off: f64,
    /// Pairs whose boxes meet.
    contact: f64,
    visitors: Vec<Visitor>,
    meetings: Vec<Meeting>,
}

impl Sample {
    /// Mock-up triangles count as near up to `reach` metres from a tool triangle's box.
    pub fn new(statics: &Statics, bounds: &Aabb, tool: &Mesh, reach: f64) -> Sample {
        let tool_ids: Vec<u32> = tool.queried().collect();
        let chosen = chosen_visitors(tool, &tool_ids);
        let crowd = Crowd::new(bounds, statics.triangles.iter().step_by(2), 2.0 * statics.each);
        let mut found: Vec<Found> = (0..TRIES)
            .into_par_iter()
            .map(|seed| {
                let (place, off) = Place::at_work(statics, tool, &tool_ids, &crowd, seed);
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
                let meetings = meetings(&boxes, &near, each, reach, &mut Random::new(!seed));
                let contact = meetings.iter().filter(|m| m.gap == 0.0).map(|m| m.weight).sum();
                Found { off, contact, visitors: visitors.collect(), meetings }
            })
            .collect();
        found.sort_by(|p, q| (p.off, p.contact).partial_cmp(&(q.off, q.contact)).unwrap_or(Ordering::Equal));
        found.truncate(KEPT);
        let places = found.len() as f64;
        let mut meetings: Vec<Meeting> = found.iter().flat_map(|place| place.meetings.iter().copied()).collect();
        meetings.sort_unstable_by(|p, q| p.gap.total_cmp(&q.gap));
        let few = statics.triangles.len().div_ceil(SHAPES);
        let shapes: Vec<Shape> = statics.triangles.iter().step_by(few).map(Shape::of).collect();
        Sample {
            places,
            visitors: found.into_iter().flat_map(|place| place.visitors).collect(),
            meetings,
            each_shape: statics.each * statics.triangles.len() as f64 / shapes.len() as f64,
            shapes,
        }
    }
}

/// The mock-up's triangles that may be within `reach` of the tool's box at a place, and how many of the sample each stands for.
fn near<'a>(statics: &'a Statics, place: &Place, tool: &Mesh, reach: f64) -> (Vec<&'a Triangle>, usize) {
    let around = grown(&place.bounds_of(tool), reach);
    let is_near = |t: &&Triangle| {
        let b = Aabb::of_triangle(t);
        // The box around the turned box holds much that is not near.
        around.is_overlapping(&b) && {
            let middle = place.in_tool(&std::array::from_fn(|a| 0.5 * b.lower[a] + 0.5 * b.upper[a]));
            let radius = 0.5 * b.extent().iter().map(|x| x * x).sum::<f64>().sqrt();
            grown(&tool.bounds(), reach + radius).is_overlapping(&Aabb { lower: middle, upper: middle })
        }
    };
    let runs = statics.triangles.chunks(RUN).zip(&statics.runs);
    let runs: Vec<&[Triangle]> = runs.filter(|(_, b)| around.is_overlapping(b)).map(|(run, _)| run).collect();
    let every = (runs.len() * RUN).div_ceil(LOOKED_AT).max(1);
    (runs.iter().flat_map(|run| run.iter()).step_by(every).filter(is_near).collect(), every)
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
fn meetings(boxes: &[(Aabb, f64)], near: &[&Triangle], each: f64, reach: f64, random: &mut Random) -> Vec<Meeting> {
    if near.is_empty() {
        return Vec::new();
    }
    // Another part of the tool's triangles at each place.
    let every = boxes.len().div_ceil(MEETERS).max(1);
    let first = random.below(every);
    let some = boxes.iter().skip(first).step_by(every);
    let every_near = near.len().div_ceil(NEIGHBOURS);
    let statics: Vec<(Aabb, Shape)> = near
        .iter()
        .skip(random.below(every_near))
        .step_by(every_near)
        .map(|t| (Aabb::of_triangle(t), Shape::of(t)))
        .collect();
    let weight = each * every as f64 * every_near as f64;
    let kept_whole = reach / 8.0;
    let mut found = Vec::new();
    for (tool_box, tool_weight) in some {
        for (b, shape) in &statics {
            let overlap: Point =
                std::array::from_fn(|a| tool_box.upper[a].min(b.upper[a]) - tool_box.lower[a].max(b.lower[a]));
            let gap = overlap.iter().fold(0.0f64, |m, x| m.max(-x));
            if gap < reach {
                let share = f64::min(1.0, (kept_whole / gap).powi(2));
                if share == 1.0 || random.unit() < share {
                    found.push(Meeting { overlap, shape: *shape, weight: weight * tool_weight / share, gap });
                }
            }
        }
    }
    found
}

fn grown(b: &Aabb, margin: f64) -> Aabb {
    Aabb { lower: b.lower.map(|x| x - margin), upper: b.upper.map(|x| x + margin) }
}
