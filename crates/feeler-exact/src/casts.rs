//! Casts with a known hit: nothing may tunnel, no impact may be late.
//!
//! A motion is random, between poses, along a screw or along a chain of joints; then it is shifted so that at a chosen time a chosen point of
//! the tool lies on a chosen point of a sheet without thickness or of a wire. Rational arithmetic confirms that the two
//! triangles collide then. So the tool is in contact at that time, however fast it moves, and the cast must have found
//! an impact by then.

use std::sync::Arc;

use feeler_core::{
    closest_triangle_triangle, intersect_triangle_triangle, CastOptions, Chain, Error, Joint, Mockup, Motion, Point,
    Pose, Scene, SceneOptions, Screw, Tool, Triangle,
};
use rayon::prelude::*;

use crate::check::{arrays_of, STORES};
use crate::oracle;
use crate::random::Random;
use crate::shapes;

/// Metres.
const TOLERANCE: f64 = 1e-6;

/// Casts through one scene.
const PER_SCENE: u64 = 32;

/// Times before the impact at which everything is looked at.
const EARLIER: u32 = 6;

/// Faults kept with their words.
pub(crate) const KEPT: usize = 20;

/// The results of many casts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tally {
    /// Casts judged: the tool surely meets the mock-up on its way.
    pub casts: u64,
    /// Of these, the ones along a screw.
    pub screws: u64,
    /// And along a chain of joints.
    pub chains: u64,
    /// Of those between poses, the ones that turn by more than a quarter.
    pub spinning: u64,
    /// Casts that were not: by rounding, the two triangles do not meet at the chosen time.
    pub not_judged: u64,
    /// Casts without an impact where there is one.
    pub tunnelled: u64,
    /// Impacts after the chosen time, or with a pair that meets before.
    pub late: u64,
    /// Impacts at which the pair is farther apart than the tolerance.
    pub early: u64,
    /// Some of the errors, in words.
    pub faults: Vec<String>,
}

impl Tally {
    /// Whether nothing was wrong.
    pub fn is_right(&self) -> bool {
        self.tunnelled + self.late + self.early == 0
    }

    fn and(mut self, other: Tally) -> Tally {
        self.casts += other.casts;
        self.screws += other.screws;
        self.chains += other.chains;
        self.spinning += other.spinning;
        self.not_judged += other.not_judged;
        self.tunnelled += other.tunnelled;
        self.late += other.late;
        self.early += other.early;
        self.faults.extend(other.faults);
        self.faults.truncate(KEPT);
        self
    }
}

/// At least `casts` casts, each checked at `samples` times before its impact; the same for the same seed, on any number of threads.
pub fn run(casts: u64, seed: u64, samples: u32) -> Tally {
    (0..casts.div_ceil(PER_SCENE))
        .into_par_iter()
        .map(|scene| cast_through(seed.wrapping_mul(1 << 32) ^ scene, samples))
        .reduce(Tally::default, Tally::and)
}

fn cast_through(seed: u64, samples: u32) -> Tally {
    let mut r = Random::new(seed);
    let obstacles: Vec<Triangle> = (0..1 + r.below(5)).map(|i| obstacle(&mut r, i)).collect();
    let (vertices, faces) = arrays_of(&obstacles);
    let mut tally = Tally::default();
    // A wire may be so thin that it has no area once its corners are rounded.
    let Ok(mockup) = Mockup::new(vertices, faces, Vec::new(), 1) else { return tally };
    let mockup = Arc::new(mockup);
    let storage = STORES[r.below(3)];
    let options = SceneOptions::default().with_storage(storage).with_voxel_size(r.real(0.05, 0.5));
    let Ok(scene) = Scene::build(mockup.clone(), &options) else {
        return Tally { late: 1, faults: vec![format!("seed {seed}: no scene")], ..tally };
    };
    for _ in 0..PER_SCENE / 8 {
        let (vertices, faces) = arrays_of(&tool(&mut r));
        let tool = Tool::new(vertices, faces).expect("tools have an area");
        for _ in 0..8 {
            judge(&mut r, &scene, &tool, &mut tally, (seed, samples));
        }
    }
    tally
}

fn judge(r: &mut Random, scene: &Scene, tool: &Tool, tally: &mut Tally, (seed, samples): (u64, u32)) {
    let mesh = scene.mockup().mesh();
    let ids = |r: &mut Random, mesh: &feeler_core::Mesh| {
        let ids: Vec<u32> = mesh.queried().collect();
        ids[r.below(ids.len())]
    };
    let (p, q) = (ids(r, tool.mesh()), ids(r, mesh));
    let (p, q) = (tool.mesh().triangle(p), mesh.triangle(q));
    let time = r.real(0.01, 1.0);
    let (on_tool, in_world) = (inside(r, &p), inside(r, &q));
    let (is_chain, is_screw) = (r.one_in(3), r.one_in(2));
    let motion = if is_chain {
        match chained_through(r, tool, &on_tool, &in_world, time) {
            Ok(motion) => motion,
            Err(error) => panic!("seed {seed}: {error}"),
        }
    } else if is_screw {
        match screwed_through(r, tool, &on_tool, &in_world, time) {
            Ok(motion) => motion,
            Err(error) => panic!("seed {seed}: {error}"),
        }
    } else {
        let (pose0, pose1) = through(r, tool, &on_tool, &in_world, time);
        tally.spinning += u64::from(turns(&pose0, &pose1) > 0.25);
        Motion::new(tool, &pose0, &pose1)
    };
    if oracle::kind_of_pair(&motion.at(time).apply_triangle(&p), &q).is_none() {
        tally.not_judged += 1;
        return;
    }
    tally.casts += 1;
    tally.chains += u64::from(is_chain);
    tally.screws += u64::from(is_screw && !is_chain);
    let words = |what: String| format!("seed {seed}, {:?}, {motion:?}: {what}", scene.storage());
    let cast = match scene.cast_along(tool, &motion, &CastOptions::default().with_tolerance(TOLERANCE)) {
        Ok(Some(cast)) => cast,
        other => {
            tally.tunnelled += 1;
            tally.faults.push(words(format!("{other:?}, but they meet at {time}")));
            return;
        }
    };
    let meets = |time: f64| {
        let pose = motion.at(time);
        tool.mesh().queried().any(|t| {
            let placed = pose.apply_triangle(&tool.mesh().triangle(t));
            mesh.queried().any(|m| intersect_triangle_triangle(&placed, &mesh.triangle(m)).is_some())
        })
    };
    // The last of them just before the impact.
    let close = (1..=EARLIER).map(|i| cast.fraction * (1.0 - 0.5f64.powi(9 * i as i32 / 2)));
    let before = close.chain((0..samples).map(|i| cast.fraction * f64::from(i) / f64::from(samples)));
    if cast.fraction > time || before.filter(|t| *t < cast.fraction).any(meets) {
        tally.late += 1;
        tally.faults.push(words(format!("{} is late: they meet at {time} or before", cast.fraction)));
    }
    let placed = cast.pose.apply_triangle(&tool.mesh().triangle(cast.tool_triangle));
    let distance = closest_triangle_triangle(&placed, &mesh.triangle(cast.mockup_triangle)).distance;
    if distance > TOLERANCE || cast.pose != motion.at(cast.fraction) {
        tally.early += 1;
        tally.faults.push(words(format!("{distance} m apart at {}", cast.fraction)));
    }
}

/// Poses between which, at a time, a point of the tool lies on a point of the world.
fn through(r: &mut Random, tool: &Tool, on_tool: &Point, in_world: &Point, time: f64) -> (Pose, Pose) {
    let mut ends = [shapes::Motion::random(r, 1.0), shapes::Motion::random(r, 1.0)];
    if r.one_in(4) {
        ends[1].rotation = ends[0].rotation;
    }
    let speed = r.pick(&[0.01, 0.3, 3.0, 100.0, 1e5]);
    for end in &mut ends {
        end.translation = r.point(-speed, speed);
    }
    let at = Motion::new(tool, &ends[0].pose(), &ends[1].pose()).at(time).apply(on_tool);
    for end in &mut ends {
        (0..3).for_each(|a| end.translation[a] += in_world[a] - at[a]);
    }
    (ends[0].pose(), ends[1].pose())
}

/// A motion along a screw on which, at a time, a point of the tool lies on a point of the world: up to ten turns, about axes through the
/// tool and a kilometre away.
fn screwed_through(r: &mut Random, tool: &Tool, on_tool: &Point, in_world: &Point, time: f64) -> Result<Motion, Error> {
    let mut start = shapes::Motion::random(r, 1.0);
    let away = r.pick(&[0.0, 0.1, 3.0, 1000.0]);
    let mut point = start.pose().apply(&r.point(-0.5, 0.5));
    point = plus(&point, &r.point(-away, away));
    let most = if away > 100.0 { 0.01 } else { r.pick(&[0.3, 6.0, 60.0]) };
    let (axis, angle) = (r.point(-1.0, 1.0), r.real(-most, most));
    let pitch = r.pick(&[0.0, 0.001, -0.3, 5.0]);
    let at = Motion::screw(tool, &start.pose(), &Screw::new(&axis, &point, angle, pitch)?)?.at(time).apply(on_tool);
    for a in 0..3 {
        start.translation[a] += in_world[a] - at[a];
        point[a] += in_world[a] - at[a];
    }
    Motion::screw(tool, &start.pose(), &Screw::new(&axis, &point, angle, pitch)?)
}

/// A motion along a chain of up to eight joints on which, at a time, a point of the tool lies on a point of the world.
fn chained_through(r: &mut Random, tool: &Tool, on_tool: &Point, in_world: &Point, time: f64) -> Result<Motion, Error> {
    let mut start = shapes::Motion::random(r, 1.0);
    let most = r.pick(&[0.3, 3.0, 12.0]);
    let joints: Vec<Joint> = (0..2 + r.below(7))
        .map(|_| {
            if r.one_in(4) {
                return Ok(Joint::Slide(r.point(-1.0, 1.0)));
            }
            // Half of the arms turn in a plane.
            let axis = if r.one_in(2) { [0.0, 0.0, 1.0] } else { r.point(-1.0, 1.0) };
            let (point, pitch) = (r.point(-2.0, 2.0), r.pick(&[0.0, 0.0, 0.2]));
            Ok(Joint::Screw(Screw::new(&axis, &point, r.real(-most, most), pitch)?))
        })
        .collect::<Result<_, Error>>()?;
    let at = Motion::chain(tool, &start.pose(), &Chain::new(joints.clone())?)?.at(time).apply(on_tool);
    let off: Point = std::array::from_fn(|a| in_world[a] - at[a]);
    (0..3).for_each(|a| start.translation[a] += off[a]);
    let shifted = joints.iter().map(|joint| match joint {
        Joint::Screw(screw) => {
            Ok(Joint::Screw(Screw::new(screw.axis(), &plus(screw.point(), &off), screw.angle(), screw.pitch())?))
        }
        slide => Ok(*slide),
    });
    let chain = Chain::new(shifted.collect::<Result<Vec<_>, Error>>()?)?;
    Motion::chain(tool, &start.pose(), &chain)
}

/// How far the second is turned against the first, in turns.
fn turns(a: &Pose, b: &Pose) -> f64 {
    let (a, b) = (a.rotation(), b.rotation());
    let trace: f64 = (0..3).map(|i| (0..3).map(|j| a[i][j] * b[i][j]).sum::<f64>()).sum();
    (0.5 * (trace - 1.0)).clamp(-1.0, 1.0).acos() / std::f64::consts::TAU
}

/// A point well inside a triangle.
fn inside(r: &mut Random, t: &Triangle) -> Point {
    let [a, b] = [r.real(0.1, 0.4), r.real(0.1, 0.4)];
    std::array::from_fn(|k| t[0][k] + a * (t[1][k] - t[0][k]) + b * (t[2][k] - t[0][k]))
}

/// A sheet or a wire.
fn obstacle(r: &mut Random, i: usize) -> Triangle {
    let a = r.point(-1.0, 1.0);
    if i.is_multiple_of(2) {
        let size = r.pick(&[0.01, 0.3, 2.0]);
        return [a, plus(&a, &r.point(-size, size)), plus(&a, &r.point(-size, size))];
    }
    let width = r.pick(&[1e-3, 1e-5, 1e-7, 1e-9]);
    [a, plus(&a, &r.point(-1.0, 1.0)), plus(&a, &r.point(-width, width))]
}

/// A spinning wrench, a thin sheet, a needle, or next to nothing.
fn tool(r: &mut Random) -> Vec<Triangle> {
    let at = r.point(-1.0, 1.0);
    match r.below(4) {
        0 => {
            let long = [r.real(0.2, 1.0), 0.02, 0.01];
            let mut wrench = shapes::cuboid(at, plus(&at, &long));
            wrench.extend(shapes::cuboid(at, plus(&at, &[0.05, 0.08, 0.02])));
            wrench
        }
        1 => vec![[at, plus(&at, &r.point(-0.3, 0.3)), plus(&at, &r.point(-0.3, 0.3))]],
        2 => vec![[at, plus(&at, &r.point(-1.0, 1.0)), plus(&at, &r.point(-1e-6, 1e-6))]],
        _ => shapes::cuboid(at, plus(&at, &[1e-5, 2e-5, 1e-5])),
    }
}

fn plus(a: &Point, b: &Point) -> Point {
    std::array::from_fn(|k| a[k] + b[k])
}
