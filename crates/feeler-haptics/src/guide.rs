//! A soft spring that draws the tool to a place, and a light pull along a way: a virtual fixture that guides (L. Rosenberg, *Virtual
//! fixtures: perceptual tools for telerobotic manipulation*, VRAIS 1993).
//!
//! The caller sets the place a few hundred times a second. The servo computes the spring at its own rate, so it is stable even if the
//! caller is late. The force is at most [`GUIDE_FORCE_N`], and zero in doubt. The proxy does not know of it: contact is unchanged, and
//! the force of contact has priority.

use feeler_core::geometry::twist::Wrench;
use feeler_core::geometry::vectors::{add, length, scaled, sub};
use feeler_core::{Point, Pose};

use crate::constants::{
    GUIDE_DAMPING_NS_PER_M, GUIDE_FORCE_N, GUIDE_RISE_S, GUIDE_SLEW_N_PER_S, GUIDE_STIFFNESS_N_PER_M, GUIDE_VELOCITY_S,
    JUMP_SPEED, OLDEST_GUIDE_S,
};
use crate::coupling::Coupling;
use crate::force::is_tick;
use crate::saturation::added_within;
use crate::saturation::slewed;

/// Where the tool is drawn to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guide {
    /// `world_from_tool`. Only its place counts, at the point where the coupling acts.
    pub place: Pose,
    /// A pull besides, newtons, world axes.
    pub pull: Point,
}

/// The force of a guide on the hand.
#[derive(Debug, Clone, Default)]
pub(crate) struct GuideForce {
    /// The newest guide, and whether it still guides: its force goes softly.
    told: Option<(Guide, bool)>,
    told_at: f64,
    share: f64,
    force: Point,
    velocity: Point,
    last: Option<Point>,
}

impl GuideForce {
    /// Takes a new place at a time, seconds; `None` ends the guidance.
    pub fn tell(&mut self, guide: Option<Guide>, now: f64) {
        self.told_at = now;
        self.told = match guide {
            Some(guide) => Some((guide, true)),
            None => self.told.map(|(last, _)| (last, false)),
        };
    }

    /// The force of this tick, newtons, world axes. `centre`: where the coupling acts, tool frame.
    pub fn step(&mut self, device: &Pose, centre: &Point, now: f64, dt: f64, in_doubt: bool) -> Point {
        let at = device.apply(centre);
        let moved = self.last.map_or([0.0; 3], |last| sub(&at, &last));
        let is_jump = length(&moved) > JUMP_SPEED * dt;
        let is_old = self.told.is_some_and(|(_, guides)| guides && now - self.told_at > OLDEST_GUIDE_S);
        if in_doubt || !is_tick(dt) || is_jump || is_old || !at.iter().all(|x| x.is_finite()) {
            return self.let_go();
        }
        self.last = Some(at);
        let speed = scaled(&moved, 1.0 / dt);
        let part = dt / (GUIDE_VELOCITY_S + dt);
        self.velocity = add(&self.velocity, &scaled(&sub(&speed, &self.velocity), part));
        let Some((guide, guides)) = &self.told else { return self.force };
        let grown = if *guides { dt } else { -dt };
        self.share = (self.share + grown / GUIDE_RISE_S).clamp(0.0, 1.0);
        if self.share == 0.0 {
            self.told = None;
            self.force = [0.0; 3];
            return self.force;
        }
        let off = sub(&guide.place.apply(centre), &at);
        let spring = sub(&scaled(&off, GUIDE_STIFFNESS_N_PER_M), &scaled(&self.velocity, GUIDE_DAMPING_NS_PER_M));
        let wanted = scaled(&within(&add(&spring, &guide.pull)), self.share);
        if !wanted.iter().all(|x| x.is_finite()) {
            return self.let_go();
        }
        self.force = slewed(&self.force, &wanted, GUIDE_SLEW_N_PER_S * dt);
        self.force
    }

    /// No force at once; it grows from nothing again.
    pub fn let_go(&mut self) -> Point {
        (self.share, self.force, self.velocity, self.last) = (0.0, [0.0; 3], [0.0; 3], None);
        self.force
    }
}

/// A wrench within a coupling's bounds, and as much of a guide's force as fits in beside it.
pub(crate) fn beside(wrench: &Wrench, force: &Point, coupling: &Coupling) -> Wrench {
    if *force == [0.0; 3] {
        return *wrench;
    }
    let more = Wrench { force: *force, torque: [0.0; 3] };
    added_within(wrench, &more, coupling.max_force_n, coupling.max_torque_nm)
}

fn within(force: &Point) -> Point {
    let size = length(force);
    if size > GUIDE_FORCE_N {
        scaled(force, GUIDE_FORCE_N / size)
    } else {
        *force
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 1e-3;

    fn at(x: f64) -> Pose {
        Pose::IDENTITY.translated(&[x, 0.0, 0.0]).unwrap()
    }

    fn guide(x: f64, pull: Point) -> Option<Guide> {
        Some(Guide { place: at(x), pull })
    }

    /// The force after some ticks of a handle that stands at `x`, told anew each tick.
    fn held(force: &mut GuideForce, x: f64, to: Option<Guide>, ticks: usize, begin: f64) -> Point {
        let mut felt = [0.0; 3];
        for k in 0..ticks {
            let now = begin + k as f64 * DT;
            force.tell(to, now);
            felt = force.step(&at(x), &[0.0; 3], now, DT, false);
            assert!(length(&felt) <= GUIDE_FORCE_N + 1e-12);
        }
        felt
    }

    #[test]
    fn it_draws_softly_and_never_more_than_its_bound() {
        let mut force = GuideForce::default();
        let first = held(&mut force, 0.0, guide(0.01, [0.0; 3]), 1, 0.0);
        assert!(first[0] > 0.0 && first[0] <= GUIDE_FORCE_N * DT / GUIDE_RISE_S, "{first:?}");
        let felt = held(&mut force, 0.0, guide(0.01, [0.0; 3]), 500, 1.0);
        assert!((felt[0] - 0.01 * GUIDE_STIFFNESS_N_PER_M).abs() < 1e-9, "{felt:?}");
        let felt = held(&mut force, 0.0, guide(10.0, [0.0, 100.0, 0.0]), 500, 2.0);
        assert!((length(&felt) - GUIDE_FORCE_N).abs() < 1e-9, "{felt:?}");
        // The end of it is soft as well.
        let last = held(&mut force, 0.0, None, 1, 3.0);
        assert!(length(&last) > 0.9 * GUIDE_FORCE_N, "{last:?}");
        assert_eq!(held(&mut force, 0.0, None, 500, 4.0), [0.0; 3]);
    }

    #[test]
    fn in_doubt_it_is_nothing_at_once() {
        let wanted = guide(0.01, [0.0; 3]);
        let begun = || {
            let mut force = GuideForce::default();
            assert!(held(&mut force, 0.0, wanted, 200, 0.0)[0] > 0.1);
            force
        };
        let now = 0.2;
        // Nothing was told for long.
        let mut force = begun();
        assert!(force.step(&at(0.0), &[0.0; 3], now + 0.9 * OLDEST_GUIDE_S, DT, false)[0] > 0.0);
        assert_eq!(force.step(&at(0.0), &[0.0; 3], now + 1.1 * OLDEST_GUIDE_S, DT, false), [0.0; 3]);
        // Somebody else is in doubt, the handle jumps, a tick is none.
        assert_eq!(begun().step(&at(0.0), &[0.0; 3], now, DT, true), [0.0; 3]);
        assert_eq!(begun().step(&at(1.0), &[0.0; 3], now, DT, false), [0.0; 3]);
        for dt in [f64::NAN, 0.0, 1.0] {
            assert_eq!(begun().step(&at(0.0), &[0.0; 3], now, dt, false), [0.0; 3]);
        }
        // The place is not a number.
        for x in [f64::NAN, f64::INFINITY] {
            let mut force = begun();
            force.tell(guide(0.01, [x, 0.0, 0.0]), now);
            assert_eq!(force.step(&at(0.0), &[0.0; 3], now, DT, false), [0.0; 3]);
        }
        // Afterwards it grows from nothing.
        let mut force = begun();
        force.step(&at(0.0), &[0.0; 3], now, DT, true);
        assert!(held(&mut force, 0.0, wanted, 1, now)[0] <= GUIDE_FORCE_N * DT / GUIDE_RISE_S);
    }

    #[test]
    fn a_free_handle_comes_to_rest_at_the_place() {
        // 100 g with the friction of a hand of 1 N s/m, and the force of two ticks ago.
        for rate in [250.0, 1000.0] {
            let dt = 1.0 / rate;
            let (mut force, mut x, mut v) = (GuideForce::default(), 0.0, 0.0);
            let mut late = [0.0; 3];
            let mut most: f64 = 0.0;
            for k in 0..(5.0 * rate) as usize {
                force.tell(guide(0.03, [0.0; 3]), k as f64 * dt);
                let felt = force.step(&at(x), &[0.0; 3], k as f64 * dt, dt, false);
                v += (late[1] - 1.0 * v) / 0.1 * dt;
                x += v * dt;
                most = most.max(x);
                late = [felt[0], late[0], 0.0];
            }
            assert!((x - 0.03_f64).abs() < 1e-4 && v.abs() < 1e-3 && most < 0.05, "{rate}: {x} {v} {most}");
        }
    }
}
