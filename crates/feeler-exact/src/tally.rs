//! Many cases of each of some families, judged in parallel and counted.

use rayon::prelude::*;

use crate::casts::KEPT;

/// Cases between two reports of progress.
const CASES_BETWEEN_REPORTS: u64 = 64;

/// A kind of case.
pub trait Family: Copy + Sync {
    /// The name for `--only` and the table.
    fn name(&self) -> &'static str;
}

/// The counts that only one judge has.
pub trait Figures: Default + Send {
    /// Sums them.
    fn add(&mut self, other: Self);
}

/// The result of many cases.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tally<F> {
    /// Cases judged.
    pub cases: u64,
    /// Of both bodies.
    pub triangles: u64,
    /// The judge's own.
    pub figures: F,
    /// The largest error of a figure, as a share of the error allowed.
    pub worst: f64,
    /// Number of faults.
    pub fault_count: u64,
    /// The first faults, in words.
    pub faults: Vec<String>,
}

impl<F: Figures> Tally<F> {
    /// Sums the figures; keeps the first faults.
    pub fn add(&mut self, other: Tally<F>) {
        self.cases += other.cases;
        self.triangles += other.triangles;
        self.figures.add(other.figures);
        self.worst = self.worst.max(other.worst);
        self.fault_count += other.fault_count;
        self.faults.extend(other.faults);
        self.faults.truncate(KEPT);
    }
}

/// Judges `cases` cases of each family in `only` (empty: of all), beginning with number `from`. `progress` gets a family's name and the
/// share done, 0 to 1.
///
/// Errors: an unknown name in `only`.
pub(crate) fn run<K: Family, F: Figures>(
    families: &[K],
    [from, cases]: [u64; 2],
    only: &[String],
    progress: &dyn Fn(&str, f64),
    judge: impl Fn(&K, u64) -> Tally<F> + Sync,
) -> Result<Vec<(K, Tally<F>)>, String> {
    if let Some(unknown) = only.iter().find(|name| families.iter().all(|f| f.name() != **name)) {
        let names: Vec<&str> = families.iter().map(Family::name).collect();
        return Err(format!("no family is called {unknown:?}; there are {}", names.join(", ")));
    }
    let chosen = families.iter().filter(|f| only.is_empty() || only.iter().any(|name| name == f.name()));
    let mut rows = Vec::new();
    for family in chosen {
        let (mut tally, end) = (Tally::default(), from + cases);
        for first in (from..end).step_by(CASES_BETWEEN_REPORTS as usize) {
            let wave = first..(first + CASES_BETWEEN_REPORTS).min(end);
            let done = (wave.end - from) as f64 / cases as f64;
            let found: Vec<Tally<F>> = wave.into_par_iter().map(|i| judge(family, i)).collect();
            found.into_iter().for_each(|t| tally.add(t));
            progress(family.name(), done);
        }
        rows.push((*family, tally));
    }
    Ok(rows)
}
