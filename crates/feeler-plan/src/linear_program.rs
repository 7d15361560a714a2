//! Linear programs with a few equations and many unknowns, by the revised simplex method.

/// Most pivots: programs of six equations take some thirty.
const MOST_PIVOTS: usize = 2_000;

/// Pivots by the steepest price; then by Bland's rule, which never goes round in a circle.
const STEEPEST_PIVOTS: usize = 400;

/// A price or pivot below this share of the largest number around is 0.
const ROUNDING: f64 = 1e-11;

/// Unknowns `x >= 0` with `sum(x[i] * columns[i]) = right` and the least `sum(x[i] * costs[i])`: those that are not 0, with their numbers.
///
/// `None` if there are none, if the sum has no least value, or if rounding leaves it open. The equations hold up to
/// rounding: a proof that uses the answer must add their error.
pub fn least_cost<const N: usize>(columns: &[[f64; N]], costs: &[f64], right: &[f64; N]) -> Option<Vec<(usize, f64)>> {
    let mut tableau = Tableau::new(columns, right);
    // First the artificial unknowns, which make the equations true at the start, are brought to 0.
    tableau.pivot_all(|unknown| if unknown >= columns.len() { 1.0 } else { 0.0 })?;
    let scale = right.iter().fold(0.0_f64, |most, b| most.max(b.abs()));
    let artificial = (0..N).filter(|row| tableau.basis[*row] >= columns.len());
    if artificial.map(|row| tableau.values[row]).sum::<f64>() > 1e-9 * scale {
        return None;
    }
    tableau.pivot_all(|unknown| costs.get(unknown).copied().unwrap_or(0.0))?;
    let basis = tableau.basis.iter().copied().zip(tableau.values);
    Some(basis.filter(|(unknown, value)| *unknown < columns.len() && *value > 0.0).collect())
}

struct Tableau<'a, const N: usize> {
    columns: &'a [[f64; N]],
    /// Of the artificial unknowns, whose columns are along the axes.
    signs: [f64; N],
    basis: [usize; N],
    inverse: [[f64; N]; N],
    values: [f64; N],
}

impl<'a, const N: usize> Tableau<'a, N> {
    fn new(columns: &'a [[f64; N]], right: &[f64; N]) -> Tableau<'a, N> {
        let signs = right.map(|b| if b < 0.0 { -1.0 } else { 1.0 });
        Tableau {
            columns,
            signs,
            basis: std::array::from_fn(|row| columns.len() + row),
            inverse: std::array::from_fn(|i| std::array::from_fn(|j| if i == j { signs[i] } else { 0.0 })),
            values: right.map(f64::abs),
        }
    }

    fn column(&self, unknown: usize) -> [f64; N] {
        match unknown.checked_sub(self.columns.len()) {
            None => self.columns[unknown],
            Some(row) => std::array::from_fn(|i| if i == row { self.signs[row] } else { 0.0 }),
        }
    }

    /// Pivots until no unknown that is 0 would make the sum less by growing. Artificial unknowns never come back. `None`: no least value, or
    /// too many pivots.
    fn pivot_all(&mut self, cost: impl Fn(usize) -> f64) -> Option<()> {
        for pivot in 0..MOST_PIVOTS {
            let basic = self.basis.map(&cost);
            let prices: [f64; N] = std::array::from_fn(|j| (0..N).map(|i| basic[i] * self.inverse[i][j]).sum());
            let largest = prices.iter().fold(1.0_f64, |most, p| most.max(p.abs()));
            let reduced =
                self.columns.iter().enumerate().map(|(unknown, column)| {
                    (unknown, cost(unknown) - (0..N).map(|i| prices[i] * column[i]).sum::<f64>())
                });
            let mut cheaper = reduced.filter(|(_, reduced)| *reduced < -ROUNDING * largest);
            let entering = match pivot < STEEPEST_PIVOTS {
                true => cheaper.min_by(|a, b| a.1.total_cmp(&b.1)),
                false => cheaper.next(),
            };
            let Some((entering, _)) = entering else { return Some(()) };
            let column = self.column(entering);
            let way: [f64; N] = self.inverse.map(|row| row.iter().zip(&column).map(|(a, b)| a * b).sum());
            let steepest = way.iter().fold(0.0_f64, |most, w| most.max(w.abs()));
            let mut leaving: Option<(usize, f64)> = None;
            for row in (0..N).filter(|row| way[*row] > ROUNDING * steepest) {
                let ratio = self.values[row].max(0.0) / way[row];
                let is_less = leaving.is_none_or(|(best, least)| {
                    ratio < least || (ratio == least && self.basis[row] < self.basis[best])
                });
                if is_less {
                    leaving = Some((row, ratio));
                }
            }
            let (leaving, ratio) = leaving?;
            self.basis[leaving] = entering;
            for row in 0..N {
                self.values[row] = if row == leaving { ratio } else { (self.values[row] - ratio * way[row]).max(0.0) };
            }
            let pivot_row = self.inverse[leaving].map(|x| x / way[leaving]);
            for row in 0..N {
                for (x, p) in self.inverse[row].iter_mut().zip(&pivot_row) {
                    *x = if row == leaving { *p } else { *x - way[row] * p };
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn cost(costs: &[f64], x: &[(usize, f64)]) -> f64 {
        x.iter().map(|(i, value)| costs[*i] * value).sum()
    }

    /// All pairs of columns are bases: the least cost of those that are feasible.
    fn by_all_bases(columns: &[[f64; 2]], costs: &[f64], right: &[f64; 2]) -> Option<f64> {
        let mut least: Option<f64> = None;
        for i in 0..columns.len() {
            for j in i + 1..columns.len() {
                let ([a, c], [b, d]) = (columns[i], columns[j]);
                let determinant = a * d - b * c;
                if determinant.abs() < 1e-9 {
                    continue;
                }
                let x = (right[0] * d - b * right[1]) / determinant;
                let y = (a * right[1] - right[0] * c) / determinant;
                if x >= 0.0 && y >= 0.0 {
                    let here = x * costs[i] + y * costs[j];
                    least = Some(least.map_or(here, |least| least.min(here)));
                }
            }
        }
        least
    }

    #[test]
    fn as_cheap_as_the_best_of_all_bases() {
        let mut random = Random::new(5, 0);
        let mut solved = 0;
        for _ in 0..500 {
            let columns: Vec<[f64; 2]> = (0..6).map(|_| std::array::from_fn(|_| random.between(-1.0, 1.0))).collect();
            let costs: Vec<f64> = (0..6).map(|_| random.between(0.0, 1.0)).collect();
            let right = std::array::from_fn(|_| random.between(-1.0, 1.0));
            let (found, expected) = (least_cost(&columns, &costs, &right), by_all_bases(&columns, &costs, &right));
            assert_eq!(found.is_some(), expected.is_some());
            let (Some(found), Some(expected)) = (found, expected) else { continue };
            assert!((cost(&costs, &found) - expected).abs() < 1e-9, "{found:?} costs more than {expected}");
            for row in 0..2 {
                let sum: f64 = found.iter().map(|(i, x)| columns[*i][row] * x).sum();
                assert!((sum - right[row]).abs() < 1e-9);
            }
            solved += 1;
        }
        assert!(solved > 100);
    }

    #[test]
    fn none_where_the_columns_do_not_reach() {
        let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(least_cost(&columns, &[1.0; 3], &[1.0, 2.0, -1.0]), None);
        assert_eq!(least_cost(&columns, &[1.0; 3], &[1.0, 0.0, 2.0]), Some(vec![(0, 1.0), (2, 2.0)]));
        assert_eq!(least_cost(&[[1.0], [-1.0]], &[-1.0, 0.0], &[1.0]), None, "no least value");
    }
}
