//! A book of cases, and the words they are written in.

use feeler_core::{PairKind, Point, Triangle};

use crate::corpus::{word, Case};
use crate::oracle;

/// The triangle that most cases are set against: legs of 4 along x and y, in the plane z = 0.
pub(super) const BASE: Triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

/// The smallest number above zero.
pub(super) const TINY: f64 = 5e-324;

pub(super) const APART: Option<PairKind> = None;
pub(super) const COPLANAR: Option<PairKind> = Some(PairKind::Coplanar);
pub(super) const CROSSING: Option<PairKind> = Some(PairKind::Crossing);
pub(super) const TOUCHING: Option<PairKind> = Some(PairKind::Touching);

/// Collects cases and refuses wrong ones.
pub(super) struct Book {
    pub cases: Vec<Case>,
    pub names: std::collections::HashSet<String>,
}

impl Book {
    /// A case whose answer follows from the design.
    pub fn add(&mut self, name: impl Into<String>, p: Triangle, q: Triangle, answer: Option<PairKind>) {
        let name = name.into();
        let truth = oracle::kind_of_pair(&p, &q);
        assert_eq!(word(truth), word(answer), "{name}: {p:?} {q:?}");
        self.add_decided(name, p, q);
    }

    /// A case that only exact arithmetic can decide.
    pub fn add_decided(&mut self, name: impl Into<String>, p: Triangle, q: Triangle) {
        let name = name.into();
        assert!(oracle::has_area(&q), "{name}: the second triangle has no area");
        assert!(self.names.insert(name.clone()), "{name} is taken");
        self.cases.push(Case { name, p, q, answer: oracle::kind_of_pair(&p, &q) });
    }
}

/// Each corner changed by `f`.
pub(super) fn mapped(t: Triangle, f: impl Fn(Point) -> Point) -> Triangle {
    t.map(f)
}

/// In the plane z = 0.
pub(super) fn flat(t: [[f64; 2]; 3]) -> Triangle {
    t.map(|[x, y]| [x, y, 0.0])
}
