//! The books of force shading: a turned force gives the hand no energy that the hand has not given before.
//!
//! Beside the spring's force acts what shading adds to it. On a smooth surface that has a potential (see
//! [`shading`](crate::shading)), so that closed motions cost nothing; but the smooth surface is only known to second
//! order, around the point of contact, and a force that is not its gradient gives energy in some loops at any speed.
//! Three accounts close the loop. The first has what shading by its whole would have given beside its potential; it
//! says soon that the force is not that of a smooth surface. The second has the work that was really done, by all of
//! the force: it may be no more than a little below the least of the potential. The third is the second where nothing
//! is touched, where a closed motion ends. As one runs out, the added force fades, and where it is empty there is none;
//! so it can never give more. They fill as the hand gives, also to what the spring loses from facet to facet.

use feeler_core::geometry::vectors::{add, length, scaled, sub};
use feeler_core::Point;

use crate::constants::{
    SHADING_CREDIT, SHADING_DEBT, SHADING_FADE_RATE, SHADING_LOAN, SHADING_REACH_M, SHADING_TURN_RATE,
};

/// The books of the force that shading adds. Energies are positive where the hand gave them, joules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ShadingBudget {
    /// The last spring's force, and that as shading has it by its whole.
    spring: Point,
    turned: Point,
    /// The potential beside the spring's, in the last tick and in this one.
    held: f64,
    potential: f64,
    /// Work against the force with shading by its whole, less the potentials.
    beside: f64,
    /// Work against the force that was sent, and what that was where nothing was touched last.
    paid: f64,
    debt: f64,
    /// The largest potential since nothing was owed.
    unit: f64,
    /// Of the force that shading adds, sent in the last tick.
    share: f64,
}

impl ShadingBudget {
    /// New books.
    pub fn new() -> ShadingBudget {
        let zero = [0.0; 3];
        ShadingBudget {
            spring: zero,
            turned: zero,
            held: 0.0,
            potential: 0.0,
            beside: 0.0,
            paid: 0.0,
            debt: 0.0,
            unit: 0.0,
            share: 1.0,
        }
    }

    /// The turned force and its potential beside the spring's, from those of the last tick by a bounded change: what the spring changed
    /// by, and a little by time and way. `moved`: the way (metres) and the turn (radians) of the device in the tick of `dt` seconds.
    /// Returns the force.
    pub fn follow(&mut self, spring: &Point, (turned, held_j): (Point, f64), moved: [f64; 2], dt: f64) -> Point {
        let size = length(spring);
        let most = length(&sub(spring, &self.spring))
            + size * (SHADING_TURN_RATE * dt + moved[0] / SHADING_REACH_M + moved[1]);
        let change = length(&sub(&turned, &self.turned));
        // In the air there is nothing to follow.
        let by = if size > 0.0 && change > most { most / change } else { 1.0 };
        let from = if by < 1.0 { self.turned } else { turned };
        self.turned = add(&from, &scaled(&sub(&turned, &from), by));
        self.spring = *spring;
        self.potential = self.held + by * (held_j - self.held);
        self.turned
    }

    /// Books a tick that is over. `whole_j`, `sent_j`: the hand's work against what shading adds by its whole, and against what of it
    /// was sent; `rest_j`: what the hand gave for good to the rest of the wrench. `most_j`: the most that the potential may be at this
    /// force. `is_free`: nothing was touched.
    pub fn book(&mut self, [whole_j, sent_j, rest_j]: [f64; 3], most_j: f64, is_free: bool) {
        self.unit = self.unit.max(most_j);
        let within = |account: f64, loan: f64, most: f64| account.clamp(-loan * self.unit, most * self.unit);
        let beside = self.beside + whole_j - (self.potential - self.held) + rest_j;
        self.beside = within(beside, SHADING_CREDIT, SHADING_CREDIT);
        self.paid = within(self.paid + sent_j + rest_j, SHADING_LOAN, 1.0);
        if is_free {
            // A credit of the hand is not carried over to the next contact: a damper gives nothing back either.
            self.debt = self.paid.min(0.0);
            (self.paid, self.beside) = (self.debt, self.debt);
            if self.debt == 0.0 {
                self.unit = 0.0;
            }
        }
    }

    /// The share of the force that shading adds which may be sent in the coming tick, `dt` seconds after the last.
    pub fn share(&mut self, dt: f64) -> f64 {
        self.held = self.potential;
        // Of an account that may go so far below zero, and fades over the last of that.
        let share = |account: f64, loan: f64, fade: f64| {
            let (left, fade) = (account + loan * self.unit, fade * self.unit);
            let t = if fade > 0.0 { (left / fade).clamp(0.0, 1.0) } else { 1.0 };
            t * t * (3.0 - 2.0 * t)
        };
        let half = 0.5 * SHADING_CREDIT;
        let wanted = share(self.beside, SHADING_CREDIT, half)
            * share(self.debt, SHADING_DEBT, SHADING_DEBT)
            * share(self.paid, SHADING_LOAN, half);
        let most = SHADING_FADE_RATE * dt;
        self.share = wanted.clamp(self.share - most, self.share + most);
        self.share
    }

    /// The last force is let go: the energy in it is lost or given, so the accounts stand.
    pub fn let_go(&mut self) {
        (self.spring, self.turned, self.held, self.potential) = ([0.0; 3], [0.0; 3], 0.0, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A force that is no gradient: it pushes with the hand one way, and not the other way, in each contact again.
    #[test]
    fn a_force_without_potential_gives_little_and_then_nothing() {
        let mut budget = ShadingBudget::new();
        let (spring, turned) = ([0.0, 0.0, 1.0], [0.1, 0.0, 1.0]);
        let (unit_j, step_m, dt) = (1e-4, 5e-5, 1e-3);
        let mut lap = || {
            let (mut share, mut given) = (0.0, 0.0);
            for tick in 0..400 {
                let whole = budget.follow(&spring, (turned, 0.0), [step_m, 0.0], dt)[0];
                let work = if tick < 200 { whole * step_m } else { 0.0 };
                budget.book([-work, -share * work, 0.0], unit_j, false);
                given += share * work;
                share = budget.share(dt);
            }
            budget.book([0.0; 3], 0.0, true);
            budget.share(dt);
            budget.let_go();
            given
        };
        let given: Vec<f64> = (0..50).map(|_| lap()).collect();
        assert!(given[0] > 0.1 * unit_j && given.iter().sum::<f64>() < SHADING_LOAN * unit_j, "{given:?}");
        assert!(given[1..].iter().all(|given| *given < 0.01 * unit_j), "{given:?}");
    }

    #[test]
    fn a_force_follows_its_spring_at_once_and_else_by_a_bounded_rate() {
        let mut budget = ShadingBudget::new();
        let (spring, dt) = ([0.0, 0.0, 2.0], 1e-3);
        assert_eq!(budget.follow(&spring, ([0.2, 0.0, 2.0], 0.0), [0.0; 2], dt), [0.2, 0.0, 2.0]);
        // It flips.
        let found = budget.follow(&spring, ([-0.2, 0.0, 2.0], 0.0), [0.0; 2], dt);
        assert!((found[0] - (0.2 - 2.0 * SHADING_TURN_RATE * dt)).abs() < 1e-12, "{found:?}");
        assert_eq!(budget.follow(&[0.0; 3], ([0.0; 3], 0.0), [0.0; 2], dt), [0.0; 3]);
    }
}
