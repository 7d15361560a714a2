//! Motions that the contacts leave free: rotations about the axes of bores and hinges, and the screws of threads.

use feeler_core::geometry::twist::Twist;
use feeler_core::geometry::vectors::{cross, dot, length, scaled, sub, unit};
use feeler_core::{Point, Pose};

use crate::constants::{FREE_SHARE, LEAST_PITCH, MOST_TWISTS};
use crate::eigen::eigenvectors;
use crate::error::Result;
use feeler_world::Surroundings;

/// A screw without an angle: its axis, world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Unit.
    pub along: Point,
    /// On it, metres.
    pub point: Point,
    /// Metres along it for a whole turn.
    pub pitch: f64,
}

/// The contacts at a pose: their normals, and the screws that they leave free.
#[derive(Debug, Clone, Default)]
pub struct Footholds {
    /// Units, world.
    pub normals: Vec<Point>,
    pub axes: Vec<Axis>,
}

/// The contacts within a margin (metres) at a pose.
///
/// A contact plane with its middle at `p` and normal `n` lets a twist pass that does not move `p` along `n`. Twists that all of them let pass,
/// both ways, are a linear space (M. Ohwovoriole and B. Roth, 1981): the null space of the rows `(n, p x n)`.
pub fn footholds(around: &Surroundings, pose: &Pose, margin: f64) -> Result<Footholds> {
    let tool = around.tool();
    let (contacts, footings) = around.environment().contacts(tool, pose, margin, None)?;
    let (centre, lever) = (pose.apply(around.middle()), 0.5 * around.size());
    let mut moments = [[0.0; 6]; 6];
    let mut found = Footholds::default();
    for (plane, footing) in contacts.planes.iter().zip(&footings) {
        let points = footing.points();
        let sum = points.iter().fold([0.0; 3], |sum: Point, p| std::array::from_fn(|a| sum[a] + p[a]));
        let middle = pose.apply(&scaled(&sum, 1.0 / points.len().max(1) as f64));
        let n = plane.normal;
        let turn = scaled(&cross(&sub(&middle, &centre), &n), 1.0 / lever);
        let row = [n[0], n[1], n[2], turn[0], turn[1], turn[2]];
        for i in 0..6 {
            for j in 0..6 {
                moments[i][j] += row[i] * row[j];
            }
        }
        found.normals.push(n);
    }
    if found.normals.is_empty() {
        return Ok(found);
    }
    let (values, vectors) = eigenvectors(&moments);
    let largest = values.iter().copied().fold(0.0, f64::max);
    let free = values.iter().zip(&vectors).filter(|(value, _)| **value < FREE_SHARE * largest);
    let twists: Vec<Twist> = free
        .map(|(_, v)| Twist { linear: [v[0], v[1], v[2]], angular: scaled(&[v[3], v[4], v[5]], 1.0 / lever) })
        .collect();
    // More than two are turns about any axis, or along any surface: the part's own axes are as good.
    let twists = if twists.len() > 2 { Vec::new() } else { twists };
    for twist in with_plain_turns(&twists) {
        if let Some(axis) = axis_of(&twist, &centre, lever) {
            found.axes.push(axis);
        }
    }
    found.axes.truncate(MOST_TWISTS);
    Ok(found)
}

/// The twists, and where two of them span a bore's, the turn without an advance.
fn with_plain_turns(twists: &[Twist]) -> Vec<Twist> {
    let mut all = Vec::new();
    if let [a, b] = twists {
        // Along one axis: a slide and a turn, mixed.
        let (u, w) = (a.angular, b.angular);
        if length(&cross(&u, &w)) <= 1e-3 * (dot(&u, &u) + dot(&w, &w)) {
            let larger = if length(&u) > length(&w) { (*a, *b) } else { (*b, *a) };
            let share = dot(&larger.0.angular, &larger.1.angular) / dot(&larger.0.angular, &larger.0.angular);
            let slide = (larger.1 - larger.0 * share).linear;
            if let Some(slide) = unit(&slide) {
                let off = dot(&larger.0.linear, &slide);
                all.push(Twist { linear: sub(&larger.0.linear, &scaled(&slide, off)), angular: larger.0.angular });
                return all;
            }
        }
    }
    all.extend_from_slice(twists);
    all
}

/// The axis of a twist at a point; `None` of a slide.
fn axis_of(twist: &Twist, at: &Point, lever: f64) -> Option<Axis> {
    let size = length(&twist.angular);
    if size * lever < 0.05 {
        return None;
    }
    let along = scaled(&twist.angular, 1.0 / size);
    let arm = scaled(&cross(&twist.angular, &twist.linear), 1.0 / (size * size));
    let point = std::array::from_fn(|a| at[a] + arm[a]);
    let pitch = std::f64::consts::TAU * dot(&twist.linear, &along) / size;
    Some(Axis { along, point, pitch: if pitch.abs() < 2.0 * LEAST_PITCH * lever { 0.0 } else { pitch } })
}
