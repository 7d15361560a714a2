//! What a prediction looks at: the tool at a few places on the mock-up's surface, a part of its triangles there, and the
//! mock-up's triangles around each.

use rayon::prelude::*;

use super::random::Random;
use crate::bounds::{Aabb, Point, Triangle};
use crate::mesh::Mesh;
use crate::pieces::twice_area;

/// Places of the tool that are looked at.
const PLACES: u64 = 32;

/// And kept: those where it meets least. In the others it is stuck deep in parts, not at work.
const KEPT: usize = 22;

/// Tool triangles at each place whose voxels are counted.
const VISITORS: usize = 128;

/// Of these, the ones whose neighbours are looked at.
const MEETERS: usize = 24;

/// Mock-up triangles looked at, evenly spread over the mesh.
const STATICS: usize = 60_000;

/// Mock-up triangles around one place that are paired with the tool's.
const NEIGHBOURS: usize = 1000;

/// Triangles of which one is chosen by area.
const SPOTS: usize = 24;

/// Tool triangles looked at for how far the tool reaches into the surface.
const DEPTH_PROBES: usize = 64;

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

/// See the module. Deterministic.
#[derive(Debug)]
pub struct Sample {
    pub places: f64,
    pub visitors: Vec<Visitor>,
    /// By ascending gap.
    pub meetings: Vec<Meeting>,
    /// Shapes of mock-up triangles anywhere.
    pub statics: Vec<Shape>,
    /// How many each of them stands for.
    pub static_weight: f64,
}

impl Sample {
    /// Mock-up triangles count as near up to `reach` metres from a tool triangle's box.
    pub fn new(mesh: &Mesh, tool: &Mesh, reach: f64) -> Sample {
        let ids = spread(mesh, STATICS);
        let tool_ids: Vec<u32> = tool.queried().collect();
        let chosen = chosen_visitors(tool, &tool_ids);
        let bounds = mesh.bounds();
        let places: Vec<Place> =
            (0..PLACES).map(|seed| Place::new(mesh, &ids, tool, &tool_ids, &mut Random::new(seed))).collect();
        let around: Vec<Aabb> = places.iter().map(|place| grown(&place.bounds_of(tool), reach)).collect();
        let static_weight = mesh.queried_count() as f64 / ids.len() as f64;

        // The mock-up's triangles near each place.
        let near: Vec<Vec<(usize, u32)>> = ids
            .par_chunks(4096)
            .map(|chunk| {
                let mut found = Vec::new();
                for &id in chunk {
                    let b = Aabb::of_triangle(&mesh.triangle(id));
                    found.extend((0..around.len()).filter(|p| around[*p].is_overlapping(&b)).map(|p| (p, id)));
                }
                found
            })
            .collect();
        let mut by_place: Vec<Vec<u32>> = vec![Vec::new(); places.len()];
        for (place, id) in near.into_iter().flatten() {
            by_place[place].push(id);
        }
        let mut found: Vec<(Vec<Visitor>, Vec<Meeting>)> = places
            .par_iter()
            .zip(&by_place)
            .enumerate()
            .map(|(seed, (place, near))| {
                let boxes: Vec<(Aabb, f64)> = chosen
                    .iter()
                    .map(|(id, weight)| (Aabb::of_triangle(&place.apply(&tool.triangle(*id))), *weight))
                    .collect();
                let visitors = boxes.iter().filter(|(b, _)| b.is_overlapping(&bounds)).map(|(b, weight)| {
                    let extent =
                        std::array::from_fn(|a| b.upper[a].min(bounds.upper[a]) - b.lower[a].max(bounds.lower[a]));
                    Visitor { extent, weight: *weight }
                });
                let meetings = meetings(mesh, &boxes, near, static_weight, reach, &mut Random::new(!(seed as u64)));
                (visitors.collect(), meetings)
            })
            .collect();
        let contact = |m: &Vec<Meeting>| m.iter().filter(|m| m.gap == 0.0).map(|m| m.weight).sum::<f64>();
        found.sort_by(|(_, p), (_, q)| contact(p).total_cmp(&contact(q)));
        found.truncate(KEPT);
        let kept = found.len() as f64;
        let mut meetings: Vec<Meeting> = found.iter().flat_map(|(_, m)| m.iter().copied()).collect();
        meetings.sort_by(|p, q| p.gap.total_cmp(&q.gap));
        let few = ids.len().div_ceil(2000);
        let statics: Vec<Shape> = ids.iter().step_by(few).map(|id| Shape::of(&mesh.triangle(*id))).collect();
        Sample {
            places: kept,
            visitors: found.into_iter().flat_map(|(v, _)| v).collect(),
            meetings,
            static_weight: mesh.queried_count() as f64 / statics.len() as f64,
            statics,
        }
    }
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
    mesh: &Mesh,
    boxes: &[(Aabb, f64)],
    near: &[u32],
    static_weight: f64,
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
    let statics: Vec<(Aabb, Shape)> = near
        .iter()
        .skip(random.below(every_near))
        .step_by(every_near)
        .map(|id| mesh.triangle(*id))
        .map(|t| (Aabb::of_triangle(&t), Shape::of(&t)))
        .collect();
    let weight = static_weight * every as f64 * every_near as f64;
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

/// Where the tool is: a point of it on a point of the mock-up, turned at random.
struct Place {
    rotation: [[f64; 3]; 3],
    translation: Point,
}

impl Place {
    fn new(mesh: &Mesh, ids: &[u32], tool: &Mesh, tool_ids: &[u32], random: &mut Random) -> Place {
        let (on, normal) = spot(mesh, ids, random);
        let (held, _) = spot(tool, tool_ids, random);
        let rotation = random.rotation();
        let turned: Point = rotation.map(|row| row[0] * held[0] + row[1] * held[1] + row[2] * held[2]);
        let mut place = Place { rotation, translation: std::array::from_fn(|a| on[a] - turned[a]) };
        // Out along the normal until the tool rests on the surface: tools at work touch, they are not buried. Either way, as
        // meshes need not be closed.
        let side = if random.unit() < 0.5 { -1.0 } else { 1.0 };
        let depth = (0..DEPTH_PROBES)
            .map(|_| place.apply(&tool.triangle(tool_ids[random.below(tool_ids.len())]))[0])
            .map(|p| (0..3).map(|a| side * normal[a] * (on[a] - p[a])).sum::<f64>())
            .fold(0.0, f64::max);
        let way = side * depth;
        place.translation = std::array::from_fn(|a| place.translation[a] + way * normal[a]);
        place
    }

    fn apply(&self, t: &Triangle) -> Triangle {
        t.map(|p| {
            std::array::from_fn(|a| {
                let row = &self.rotation[a];
                row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + self.translation[a]
            })
        })
    }

    fn bounds_of(&self, tool: &Mesh) -> Aabb {
        let b = tool.bounds();
        let mut around = Aabb::EMPTY;
        for corner in 0..8 {
            let p: Point = std::array::from_fn(|a| if corner >> a & 1 == 0 { b.lower[a] } else { b.upper[a] });
            around.grow(&self.apply(&[p; 3])[0]);
        }
        around
    }
}

/// A point of the surface, anywhere (of a few triangles one is chosen in proportion to their areas), and the normal there, of
/// length 1, or 0 where it cannot be told.
fn spot(mesh: &Mesh, ids: &[u32], random: &mut Random) -> (Point, Point) {
    let picked: Vec<Triangle> = (0..SPOTS).map(|_| mesh.triangle(ids[random.below(ids.len())])).collect();
    let areas: Vec<f64> = picked.iter().map(twice_area).collect();
    let mut left = random.unit() * areas.iter().sum::<f64>();
    let mut chosen = 0;
    for (i, area) in areas.iter().enumerate() {
        chosen = i;
        left -= area;
        if left < 0.0 {
            break;
        }
    }
    let t = &picked[chosen];
    let [u, v]: [Point; 2] = [1, 2].map(|i| std::array::from_fn(|a| t[i][a] - t[0][a]));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    let normal = if length.is_normal() { n.map(|x| x / length) } else { [0.0; 3] };
    (random.point_in(t), normal)
}

fn grown(b: &Aabb, margin: f64) -> Aabb {
    Aabb { lower: b.lower.map(|x| x - margin), upper: b.upper.map(|x| x + margin) }
}
