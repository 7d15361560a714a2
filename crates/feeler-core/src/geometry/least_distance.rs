//! The point nearest to another among those that satisfy linear inequalities: the small quadratic program of every tick.
//!
//! In six coordinates of one scale (see [`Metric`](crate::tool::metric::Metric)) the proxy's motion is the one nearest
//! to the device's that no contact row forbids: Gauss's principle of least constraint. Solved by the dual active-set
//! method of D. Goldfarb and A. Idnani (*A numerically stable dual method for solving strictly convex quadratic
//! programs*, 1983) with the identity for the Hessian: violated rows join the active ones one after the other, and leave
//! if their multiplier would turn negative. The active rows are kept as an orthonormal basis, made anew at each change:
//! six coordinates have at most six of them.

use crate::constants::{LEAST_SINE, MOST_QP_STEPS, QP_SLACK};

/// Coordinates.
pub const DIMENSIONS: usize = 6;

/// Six numbers.
pub type Six = [f64; DIMENSIONS];

/// `normal . x >= offset`, with a unit normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace {
    /// Unit, or zero: then it is left out.
    pub normal: Six,
    /// Metres.
    pub offset: f64,
}

/// The result of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// The nearest point, or where the steps ended.
    pub point: Six,
    /// The rows that hold it, `active` of them, and how hard: metres.
    rows: [(usize, f64); DIMENSIONS],
    active: usize,
    /// Whether all rows are satisfied: false where they exclude each other.
    pub is_feasible: bool,
}

impl Nearest {
    /// The rows that hold the point, with their multipliers (metres): the point is the target plus the sum of multiplier times normal.
    pub fn active(&self) -> &[(usize, f64)] {
        &self.rows[..self.active]
    }
}

/// The active rows.
#[derive(Debug, Clone, Copy)]
struct ActiveSet {
    rows: [usize; DIMENSIONS],
    multipliers: Six,
    count: usize,
    /// Orthonormal, spanning the normals of the active rows; `triangle[j]` has row `j`'s coefficients.
    basis: [Six; DIMENSIONS],
    triangle: [Six; DIMENSIONS],
}

impl ActiveSet {
    fn new() -> ActiveSet {
        ActiveSet {
            rows: [0; DIMENSIONS],
            multipliers: [0.0; DIMENSIONS],
            count: 0,
            basis: [[0.0; DIMENSIONS]; DIMENSIONS],
            triangle: [[0.0; DIMENSIONS]; DIMENSIONS],
        }
    }

    /// What of a normal is across all active ones, and its coefficients in them.
    fn split(&self, normal: &Six) -> (Six, Six) {
        let (mut across, mut inner) = (*normal, [0.0; DIMENSIONS]);
        // Twice, so that the rest is across to the last digit.
        for _ in 0..2 {
            for k in 0..self.count {
                let part = dot(&self.basis[k], &across);
                inner[k] += part;
                add_to(&mut across, -part, &self.basis[k]);
            }
        }
        // Back substitution: the normal is the sum of the active ones times these, plus the part across.
        let mut coefficients = [0.0; DIMENSIONS];
        for j in (0..self.count).rev() {
            let rest: f64 = (j + 1..self.count).map(|i| self.triangle[i][j] * coefficients[i]).sum();
            coefficients[j] = (inner[j] - rest) / self.triangle[j][j];
        }
        (across, coefficients)
    }

    fn push(&mut self, row: usize, multiplier: f64, normal: &Six) {
        let (mut across, mut inner) = (*normal, [0.0; DIMENSIONS]);
        for _ in 0..2 {
            for k in 0..self.count {
                let part = dot(&self.basis[k], &across);
                inner[k] += part;
                add_to(&mut across, -part, &self.basis[k]);
            }
        }
        let j = self.count;
        let length = dot(&across, &across).sqrt();
        inner[j] = length;
        self.basis[j] = across.map(|x| x / length);
        self.triangle[j] = inner;
        self.rows[j] = row;
        self.multipliers[j] = multiplier;
        self.count += 1;
    }

    fn remove(&mut self, at: usize, rows: &[HalfSpace]) {
        let before = *self;
        self.count = 0;
        for j in (0..before.count).filter(|j| *j != at) {
            self.push(before.rows[j], before.multipliers[j], &rows[before.rows[j]].normal);
        }
    }
}

fn dot(a: &Six, b: &Six) -> f64 {
    (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) + (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
}

fn add_to(a: &mut Six, by: f64, b: &Six) {
    a.iter_mut().zip(b).for_each(|(x, y)| *x += by * y);
}

/// The point nearest to `target` that satisfies all rows, up to `QP_SLACK` of `scale` (metres). Rows for which `first` is true are
/// looked at before others: those that held the last time. Allocates nothing.
///
/// Where rows exclude each other, the steps end at a point that violates the one that could not be had.
pub fn nearest(target: &Six, rows: &[HalfSpace], scale: f64, first: impl Fn(usize) -> bool) -> Nearest {
    let slack = QP_SLACK * scale;
    let (mut point, mut set, mut is_feasible) = (*target, ActiveSet::new(), true);
    let mut steps = 0;
    'rows: while let Some((row, mut violation)) = most_violated(&point, rows, slack, &set, &first) {
        let normal = rows[row].normal;
        let mut multiplier = 0.0;
        loop {
            steps += 1;
            let (across, coefficients) = set.split(&normal);
            let square = dot(&across, &across);
            // The active row that would first have a negative multiplier.
            let leaving = (0..set.count)
                .filter(|j| coefficients[*j] > 0.0)
                .map(|j| (set.multipliers[j] / coefficients[j], j))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let whole = if square > LEAST_SINE * LEAST_SINE { violation / square } else { f64::INFINITY };
            let step = leaving.map_or(whole, |(length, _)| length.min(whole));
            if !step.is_finite() || steps > MOST_QP_STEPS {
                is_feasible = false;
                break 'rows;
            }
            (0..set.count).for_each(|j| set.multipliers[j] -= step * coefficients[j]);
            multiplier += step;
            if whole.is_finite() {
                add_to(&mut point, step, &across);
                violation -= step * square;
            }
            match leaving {
                Some((length, at)) if length <= step && whole > step => set.remove(at, rows),
                _ => {
                    set.push(row, multiplier, &normal);
                    break;
                }
            }
        }
    }
    let mut held = [(0, 0.0); DIMENSIONS];
    (0..set.count).for_each(|j| held[j] = (set.rows[j], set.multipliers[j]));
    Nearest { point, rows: held, active: set.count, is_feasible }
}

/// The row that a point violates most, of the first ones if any, and by how much.
fn most_violated(
    point: &Six,
    rows: &[HalfSpace],
    slack: f64,
    set: &ActiveSet,
    first: &impl Fn(usize) -> bool,
) -> Option<(usize, f64)> {
    let (mut worst, mut is_first_worst) = (None, false);
    for (i, row) in rows.iter().enumerate() {
        let violation = row.offset - dot(&row.normal, point);
        if violation <= slack || set.rows[..set.count].contains(&i) {
            continue;
        }
        let is_first = first(i);
        let is_worse = worst.is_none_or(|(_, most)| violation > most);
        if is_first & !is_first_worst || is_first == is_first_worst && is_worse {
            (worst, is_first_worst) = (Some((i, violation)), is_first);
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn half_space(normal: Six, offset: f64) -> Option<HalfSpace> {
        let length = dot(&normal, &normal).sqrt();
        (length > 1e-3).then(|| HalfSpace { normal: normal.map(|x| x / length), offset })
    }

    fn six(most: f64) -> impl Strategy<Value = Six> {
        prop::array::uniform6(-most..most)
    }

    /// Karush, Kuhn, Tucker: the conditions that make a point the nearest, however it was found.
    fn assert_is_nearest(target: &Six, rows: &[HalfSpace], found: &Nearest) -> Result<(), TestCaseError> {
        for row in rows {
            prop_assert!(dot(&row.normal, &found.point) >= row.offset - 1e-9, "{row:?} {found:?}");
        }
        let mut sum = *target;
        for (i, multiplier) in found.active() {
            prop_assert!(*multiplier >= -1e-9, "{found:?}");
            let tight = dot(&rows[*i].normal, &found.point) - rows[*i].offset;
            prop_assert!(tight.abs() < 1e-7, "{tight} {found:?}");
            add_to(&mut sum, *multiplier, &rows[*i].normal);
        }
        let off: f64 = sum.iter().zip(&found.point).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        prop_assert!(off < 1e-7, "{off} {found:?}");
        Ok(())
    }

    proptest! {
        #[test]
        fn the_point_found_is_the_nearest(target in six(3.0), inside in six(1.0), normals in prop::collection::vec((six(1.0), 0.0..0.5f64), 1..200)) {
            // All rows have the point `inside` on their good side.
            let rows: Vec<HalfSpace> = normals
                .iter()
                .filter_map(|(n, slack)| half_space(*n, 0.0).map(|h| HalfSpace { offset: dot(&h.normal, &inside) - slack, ..h }))
                .collect();
            let found = nearest(&target, &rows, 1e-6, |_| false);
            prop_assert!(found.is_feasible, "{found:?}");
            assert_is_nearest(&target, &rows, &found)?;
            // The order in which rows are looked at does not tell in the point.
            let other = nearest(&target, &rows, 1e-6, |i| i % 3 == 0);
            let off: f64 = other.point.iter().zip(&found.point).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
            prop_assert!(off < 1e-7, "{off}");
        }

        #[test]
        fn rows_many_times_over_and_nearly_parallel_do_no_harm(target in six(2.0), n in six(1.0), jitter in prop::collection::vec(six(1.0), 1..60), size in 1e-16..1e-3f64) {
            let Some(first) = half_space(n, 0.25) else { return Ok(()) };
            let rows: Vec<HalfSpace> = jitter
                .iter()
                .filter_map(|j| half_space(std::array::from_fn(|k| first.normal[k] + size * j[k]), 0.25))
                .chain([first, first])
                .collect();
            let found = nearest(&target, &rows, 1e-6, |_| false);
            prop_assert!(found.is_feasible);
            for row in &rows {
                prop_assert!(dot(&row.normal, &found.point) >= row.offset - 1e-9);
            }
        }
    }

    #[test]
    fn rows_that_exclude_each_other_are_told() {
        let along = |x: f64| HalfSpace { normal: [x, 0.0, 0.0, 0.0, 0.0, 0.0], offset: 0.1 };
        let found = nearest(&[0.0; 6], &[along(1.0), along(-1.0)], 1e-6, |_| false);
        assert!(!found.is_feasible);
        assert!(nearest(&[0.0; 6], &[along(1.0), along(1.0)], 1e-6, |_| false).is_feasible);
    }

    #[test]
    fn a_row_of_zeros_is_left_out() {
        let none = HalfSpace { normal: [0.0; 6], offset: -1.0 };
        let found = nearest(&[1.0; 6], &[none], 1e-6, |_| false);
        assert_eq!((found.point, found.active().len()), ([1.0; 6], 0));
    }
}
