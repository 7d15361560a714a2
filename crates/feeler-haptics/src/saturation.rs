//! Limits wrenches to bounds of force and torque.

use feeler_core::geometry::twist::Wrench;
use feeler_core::geometry::vectors::{add, dot, length, scaled, sub};
use feeler_core::Point;

/// Within both bounds (newtons, newton metres), by one factor for both: the wrench keeps its line of action.
pub fn saturated(wrench: &Wrench, max_force: f64, max_torque: f64) -> Wrench {
    let factor = |size: f64, most: f64| if size > most { most / size } else { 1.0 };
    let by = factor(length(&wrench.force), max_force).min(factor(length(&wrench.torque), max_torque));
    *wrench * by
}

/// A wrench that is within the bounds (newtons, newton metres), and as much of another as fits in beside it, force and
/// torque each.
pub fn added_within(wrench: &Wrench, more: &Wrench, max_force: f64, max_torque: f64) -> Wrench {
    Wrench {
        force: vector_within(&wrench.force, &more.force, max_force),
        torque: vector_within(&wrench.torque, &more.torque, max_torque),
    }
}

/// `a + t b` with the largest `t` in [0, 1] that keeps it within the bound; `a` within the bound.
fn vector_within(a: &Point, b: &Point, most: f64) -> Point {
    let at = |t: f64| std::array::from_fn(|i| a[i] + t * b[i]);
    let whole: Point = at(1.0);
    let square = most * most;
    if dot(&whole, &whole) <= square {
        return whole;
    }
    // |a|^2 + 2 t a.b + t^2 |b|^2 = most^2, the root that is not negative.
    let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
    let room = (square - aa).max(0.0);
    let root = (ab * ab + bb * room).sqrt();
    // Of the two forms of a root the one that does not subtract.
    // Where rounding has `a` beyond the bound and there is nothing to add, neither is a number.
    let t = if ab > 0.0 {
        room / (ab + root)
    } else if bb > 0.0 {
        (root - ab) / bb
    } else {
        0.0
    };
    let there: Point = at(t.clamp(0.0, 1.0));
    let norm = dot(&there, &there).sqrt();
    if norm > most {
        scaled(&there, most / norm)
    } else {
        there
    }
}

/// From one vector towards another, by at most `most`.
pub(crate) fn slewed(from: &Point, to: &Point, most: f64) -> Point {
    let change = sub(to, from);
    let size = length(&change);
    if size > most {
        add(from, &scaled(&change, most / size))
    } else {
        *to
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector(most: f64) -> impl Strategy<Value = Point> {
        prop::array::uniform3(-most..most)
    }

    proptest! {
        #[test]
        fn saturation_keeps_the_line_of_action(
            f in vector(20.0), t in vector(20.0), most in (0.01..20.0f64, 0.01..20.0f64),
        ) {
            let wrench = Wrench { force: f, torque: t };
            let found = saturated(&wrench, most.0, most.1);
            let (force, torque) = (length(&found.force), length(&found.torque));
            prop_assert!(force <= most.0 * (1.0 + 1e-12) && torque <= most.1 * (1.0 + 1e-12));
            // One factor for both, and the largest.
            let by = force / length(&f);
            let off = found - wrench * by;
            prop_assert!(length(&off.force) < 1e-12 && length(&off.torque) < 1e-12);
            prop_assert!(by == 1.0 || force > most.0 * (1.0 - 1e-12) || torque > most.1 * (1.0 - 1e-12));
        }

        #[test]
        fn as_much_is_added_as_fits(
            f in vector(1.0), t in vector(1.0), g in vector(50.0), u in vector(50.0), most in 0.01..10.0f64,
        ) {
            let wrench = saturated(&Wrench { force: f, torque: t }, most, most);
            let found = added_within(&wrench, &Wrench { force: g, torque: u }, most, most);
            for (a, b, c) in [(wrench.force, g, found.force), (wrench.torque, u, found.torque)] {
                prop_assert!(length(&c) <= most * (1.0 + 1e-12));
                let added: Point = std::array::from_fn(|i| c[i] - a[i]);
                let t = dot(&added, &b) / dot(&b, &b);
                prop_assert!((-1e-9..=1.0 + 1e-9).contains(&t), "{t}");
                prop_assert!((0..3).all(|i| (added[i] - t * b[i]).abs() < 1e-9));
                prop_assert!(t > 1.0 - 1e-9 || length(&c) > most * (1.0 - 1e-9));
            }
        }
    }

    #[test]
    fn nothing_added_to_what_rounding_has_beyond_the_bound_is_a_number() {
        let wrench = Wrench { force: [1.0 + 1e-15, 0.0, 0.0], torque: [0.0; 3] };
        let found = added_within(&wrench, &Wrench::ZERO, 1.0, 0.0);
        assert_eq!(found, Wrench { force: [1.0, 0.0, 0.0], torque: [0.0; 3] });
    }
}
