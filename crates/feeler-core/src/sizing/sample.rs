//! The data of a prediction: the tool at a few places on the mock-up's surface, a part of its triangles there, and the
//! mock-up's triangles around each.

use rayon::prelude::*;

use super::cost_constants::CostConstants;
use super::crowd::Crowd;
use super::place::Place;
use super::random::Random;
use super::spread::chosen;
use super::statics::{Statics, STATICS_RUN};
use super::work::{work_of, Meeting, Shape, Visitor};
use crate::geometry::bounds::{Aabb, Point};
use crate::mesh::triangle_mesh::Mesh;

/// Places of the tool.
const TOOL_PLACES: u64 = 20;

/// Tool triangles at each place whose voxels are counted.
const VISITORS: usize = 128;

/// Of these, the ones whose neighbours are looked at.
const MEETERS: usize = 24;

/// Mock-up triangles around one place that are looked at more closely.
const MOCKUP_TRIANGLES: usize = 2000;

/// Mock-up triangles around one place that are paired with the tool's.
const NEIGHBOURS: usize = 400;

/// Mock-up triangles whose shapes are kept.
const SHAPES: usize = 2000;

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
        let mut found: Vec<(Vec<Visitor>, Vec<Meeting>)> = (0..TOOL_PLACES)
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
    let every = (runs.len() * STATICS_RUN).div_ceil(MOCKUP_TRIANGLES).max(1);
    let looked_at =
        (0..runs.len() * STATICS_RUN).step_by(every).map(|i| runs[i / STATICS_RUN] * STATICS_RUN + i % STATICS_RUN);
    (looked_at.filter(|i| *i < statics.triangles.len()).filter(is_near).collect(), every)
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
