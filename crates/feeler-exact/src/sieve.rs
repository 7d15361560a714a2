//! How far a pair gets in the core, and whether floats could decide it: what the exact stage costs in practice.

use feeler_core::intersect_triangle_triangle::Plane;
use feeler_core::predicates::{orient3d_filter, Sign};
use feeler_core::{Aabb, Triangle};

/// Where a pair is decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// The boxes are apart, or one triangle is plainly beside the other's plane: it never reaches the triangle test.
    Before,
    /// The triangle test decides by float64 signs alone.
    Floats,
    /// Some sign needed exact arithmetic.
    Exact,
}

/// Follows the core's order of tests and asks its float64 filter each time. Only the statistics depend on this.
pub fn stage_of_pair(p: &Triangle, q: &Triangle) -> Stage {
    let is_beside = Plane::of_triangle(p).is_surely_beside(q) || Plane::of_triangle(q).is_surely_beside(p);
    if is_beside || !Aabb::of_triangle(p).is_overlapping(&Aabb::of_triangle(q)) {
        return Stage::Before;
    }
    let sides = |t: &Triangle, other: &Triangle| -> Option<[Sign; 3]> {
        let [a, b, c] = other.map(|corner| orient3d_filter(&t[0], &t[1], &t[2], &corner));
        Some([a?, b?, c?])
    };
    let is_one_sided = |s: [Sign; 3]| s[0] == s[1] && s[1] == s[2];
    let Some(sides_q) = sides(p, q) else { return Stage::Exact };
    if is_one_sided(sides_q) {
        return Stage::Floats;
    }
    let Some(sides_p) = sides(q, p) else { return Stage::Exact };
    if is_one_sided(sides_p) {
        return Stage::Floats;
    }
    // The filter never says zero, so one corner of each is alone on its side; put it first, on the positive one.
    let lone_first = |t: &Triangle, s: [Sign; 3]| -> (Triangle, bool) {
        let i = (0..3).find(|i| s[(i + 1) % 3] == s[(i + 2) % 3]).unwrap_or(0);
        ([t[i], t[(i + 1) % 3], t[(i + 2) % 3]], s[i] < 0)
    };
    let (mut a, flip_b) = lone_first(p, sides_p);
    let (mut b, flip_a) = lone_first(q, sides_q);
    if flip_a {
        a.swap(1, 2);
    }
    if flip_b {
        b.swap(1, 2);
    }
    match orient3d_filter(&a[0], &a[1], &b[0], &b[1]) {
        None => Stage::Exact,
        Some(1) => Stage::Floats,
        Some(_) if orient3d_filter(&a[0], &a[2], &b[2], &b[0]).is_none() => Stage::Exact,
        Some(_) => Stage::Floats,
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
