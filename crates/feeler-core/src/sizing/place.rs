//! Places for the tool: as `feeler.sample_poses` chooses them for working poses, with an estimate instead of queries.

use super::crowd::Crowd;
use super::random::Random;
use super::statics::Statics;
use crate::geometry::bounds::{Aabb, Point, Triangle};
use crate::mesh::pieces::{edge_lengths, twice_area};
use crate::mesh::triangle_mesh::Mesh;

/// Pairs that meet, for each triangle of the tool, when it is at work: 1 to 5 % of its triangles meet a few each.
const AT_WORK: [f64; 2] = [0.02, 0.1];

/// Triangles of which one is chosen by area.
const SPOT_CHOICES: usize = 24;

/// Tool triangles looked at for how many of them meet the mock-up.
const PROBES: usize = 48;

/// How far the z axis may be from the normal: the standard deviation of each coordinate is half of this.
const TILT: f64 = 0.9;

/// Places tried on the way.
const PLACES_TRIED: usize = 12;

/// The tool turned and moved.
#[derive(Debug)]
pub struct Place {
    rotation: [[f64; 3]; 3],
    translation: Point,
}

impl Place {
    /// A point of the tool on a point of the mock-up, turned at random, moved along the surface's normal until the
    /// number of colliding pairs of triangles is that of a working pose, or as near to it as possible.
    pub fn at_work(statics: &Statics, tool: &Mesh, tool_ids: &[u32], crowd: &Crowd, seed: u64) -> Place {
        let mut random = Random::new(seed);
        let surface = Spot::new(|i| statics.triangles[i].corners, statics.triangles.len(), &mut random);
        let held = Spot::new(|i| tool.triangle(tool_ids[i]), tool_ids.len(), &mut random);
        // Either way, as meshes need not be closed.
        let side = if random.unit() < 0.5 { -1.0 } else { 1.0 };
        let outward = surface.normal.map(|x| side * x);
        let any = random.rotation();
        let rotation = if random.unit() < 0.5 { any } else { outwards(&any, &outward, &mut random) };
        let turned: Point = rotation.map(|row| row[0] * held.at[0] + row[1] * held.at[1] + row[2] * held.at[2]);
        let mut place = Place { rotation, translation: std::array::from_fn(|a| surface.at[a] - turned[a]) };
        let every = tool_ids.len().div_ceil(PROBES);
        let probes: Vec<Probe> = tool_ids
            .iter()
            .skip(random.below(every))
            .step_by(every)
            .map(|id| Probe::new(&place.apply(&tool.triangle(*id)), crowd))
            .collect();
        let pairs =
            |s: f64| probes.iter().map(|probe| probe.met(&outward, s, crowd)).sum::<f64>() / probes.len() as f64;
        let size = tool.bounds().extent().iter().map(|x| x * x).sum::<f64>().sqrt();
        let s = slide(pairs, 0.02 * size);
        place.translation = std::array::from_fn(|a| place.translation[a] + s * outward[a]);
        place
    }

    /// A triangle of the tool in the world.
    pub fn apply(&self, t: &Triangle) -> Triangle {
        t.map(|p| {
            std::array::from_fn(|a| {
                let row = &self.rotation[a];
                row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + self.translation[a]
            })
        })
    }

    /// Where a point of the world is in the tool's frame.
    pub fn in_tool(&self, p: &Point) -> Point {
        let moved: Point = std::array::from_fn(|a| p[a] - self.translation[a]);
        std::array::from_fn(|a| (0..3).map(|i| self.rotation[i][a] * moved[i]).sum())
    }

    /// A box around the tool.
    pub fn bounds_of(&self, tool: &Mesh) -> Aabb {
        let b = tool.bounds();
        let mut around = Aabb::EMPTY;
        for corner in 0..8 {
            let p: Point = std::array::from_fn(|a| if corner >> a & 1 == 0 { b.lower[a] } else { b.upper[a] });
            around.grow(&self.apply(&[p; 3])[0]);
        }
        around
    }
}

/// The rotation, changed so that it takes the z axis about outwards: tools go in with the tip, and have it below.
fn outwards(any: &[[f64; 3]; 3], outward: &Point, random: &mut Random) -> [[f64; 3]; 3] {
    let unit = |v: Point| {
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        v.map(|x| x / length)
    };
    let z = unit(outward.map(|x| x + TILT * (random.unit() + random.unit() + random.unit() - 1.5)));
    let along: f64 = (0..3).map(|a| any[a][0] * z[a]).sum();
    let x = unit(std::array::from_fn(|a| any[a][0] - along * z[a]));
    let y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]];
    std::array::from_fn(|a| [x[a], y[a], z[a]])
}

/// How far to go until as much meets as at work, in growing steps, then by bisection.
fn slide(pairs: impl Fn(f64) -> f64, first_step: f64) -> f64 {
    let [low, high] = AT_WORK;
    let mut best = (0.0, f64::INFINITY);
    // Whether it is good, and whether there is too much.
    let mut look = |s: f64| {
        let here = pairs(s);
        let off = (here / high).max(low / here).max(1.0).ln();
        if off < best.1 {
            best = (s, off);
        }
        (off == 0.0, here > high)
    };
    let (mut is_good, is_inside) = look(0.0);
    let way = if is_inside { 1.0 } else { -1.0 };
    let (mut last, mut s, mut step, mut is_past) = (0.0, 0.0, first_step, false);
    for _ in 0..PLACES_TRIED {
        if is_good {
            break;
        }
        let next = if is_past { 0.5 * (last + s) } else { s + way * step };
        let (good, is_high) = look(next);
        is_good = good;
        if is_past && is_high != is_inside {
            s = next;
        } else if is_past {
            last = next;
        } else {
            (last, s, step) = (s, next, 1.8 * step);
            is_past = is_high != is_inside;
        }
    }
    best.0
}

/// A triangle of the tool at a place.
struct Probe {
    /// Points that stand for it.
    points: Vec<Point>,
    area: f64,
    outline: f64,
}

impl Probe {
    fn new(t: &Triangle, crowd: &Crowd) -> Probe {
        let outline = edge_lengths(t).iter().sum();
        Probe { points: crowd.points_of(t), area: 0.5 * twice_area(t), outline }
    }

    /// How many triangles it meets when it has moved by `s` outwards.
    fn met(&self, outward: &Point, s: f64, crowd: &Crowd) -> f64 {
        let moved = |p: &Point| -> Point { std::array::from_fn(|a| p[a] + s * outward[a]) };
        let sum: f64 = self.points.iter().map(|p| crowd.met(&moved(p), self.area, self.outline)).sum();
        sum / self.points.len() as f64
    }
}

/// A point of a surface.
struct Spot {
    at: Point,
    /// Of length 1, or 0 where it cannot be told.
    normal: Point,
}

impl Spot {
    /// Anywhere on the surface: every other time on any triangle, else on one of a few, in proportion to their areas.
    fn new(triangle: impl Fn(usize) -> Triangle, triangles: usize, random: &mut Random) -> Spot {
        let count = if random.unit() < 0.5 { 1 } else { SPOT_CHOICES };
        let picked: Vec<Triangle> = (0..count).map(|_| triangle(random.below(triangles))).collect();
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
        Spot { at: random.point_in(t), normal }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::geometry::pose::Pose;
    use crate::mesh::mockup::Mockup;
    use crate::scene::{Scene, SceneOptions};
    use crate::sizing::crowd::tests::scattered;
    use crate::sizing::tests::{mockup, tool};

    #[test]
    fn about_as_much_meets_as_at_work() {
        // Large sheets, and a cloud of small triangles of which one in sixteen is looked at.
        let corners: Vec<Point> = scattered(600_000, 0.008, 4).concat();
        let faces = (0..600_000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let cloud = Mockup::new(corners, faces, Vec::new(), 1).unwrap();
        for mockup in [mockup(40, 1.0), cloud] {
            let (mockup, tool) = (Arc::new(mockup), tool(1.0));
            let scene = Scene::build(Arc::clone(&mockup), &SceneOptions::default()).unwrap();
            let statics = Statics::new(mockup.mesh());
            let crowd = Crowd::new(&mockup.mesh().bounds(), &statics.triangles, statics.each);
            let ids: Vec<u32> = tool.mesh().queried().collect();
            let (mut each, mut good) = (0.0, 0);
            for seed in 0..100 {
                let place = Place::at_work(&statics, tool.mesh(), &ids, &crowd, seed);
                let ([a, b, c], [x, y, z]) = (place.rotation, place.translation);
                let rows = [[a[0], a[1], a[2], x], [b[0], b[1], b[2], y], [c[0], c[1], c[2], z], [0.0, 0.0, 0.0, 1.0]];
                let pose = Pose::new(&rows).unwrap();
                let pairs = scene.collide(&tool, &pose).pairs.len() as f64 / ids.len() as f64;
                each += 0.01 * pairs;
                good += usize::from(pairs < 5.0 * AT_WORK[1]);
                let p = [0.1, -0.2, 0.3];
                let back = place.in_tool(&place.apply(&[p; 3])[0]);
                assert!((0..3).all(|a| (back[a] - p[a]).abs() < 1e-12));
            }
            assert!(good > 80 && each > 0.5 * AT_WORK[0] && each < 2.2 * AT_WORK[1], "{good} {each}");
        }
    }
}
