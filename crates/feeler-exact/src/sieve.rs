//! The stage of the core that decides a pair, and whether floats could: the cost of the exact stage in practice.

use feeler_core::geometry::intersect_lanes::prove;
use feeler_core::geometry::intersect_triangle_triangle::intersect_with;
use feeler_core::geometry::predicates::Signs;
use feeler_core::{Aabb, Level, Triangle};

/// Where a pair is decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// The boxes are apart: it never reaches the triangle test.
    Before,
    /// The triangle test decides by float signs alone.
    Floats,
    /// Some sign needed exact arithmetic.
    Exact,
}

/// Follows the core's order of tests. Only the statistics depend on this.
pub fn stage_of_pair(p: &Triangle, q: &Triangle) -> Stage {
    if !Aabb::of_triangle(p).is_overlapping(&Aabb::of_triangle(q)) {
        return Stage::Before;
    }
    let verdict = prove(Level::best(), &[(*p, *q)]);
    let mut signs = Signs::default();
    if verdict.apart | verdict.crossing == 0 {
        intersect_with(&mut signs, p, q);
    }
    if signs.exact > 0 {
        Stage::Exact
    } else {
        Stage::Floats
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_decide_plain_cases_and_not_touching_ones() {
        let base: Triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let stage = |p: Triangle| stage_of_pair(&p, &base);
        assert_eq!(stage([[1.0, 1.1, -1.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.3]]), Stage::Floats);
        assert_eq!(stage([[1.0, 1.1, 0.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.3]]), Stage::Exact);
        assert_eq!(stage([[1.0, 1.1, 0.1], [1.0, 1.0, 1.0], [2.0, 1.0, 1.3]]), Stage::Before);
        assert_eq!(stage([[3.0, 3.0, -1.0], [3.1, 3.0, 1.0], [3.0, 4.0, 0.1]]), Stage::Floats);
    }
}
