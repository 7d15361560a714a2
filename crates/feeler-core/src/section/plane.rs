//! The plane of a section: the exact side of a point.

use crate::constants::{DOT_BOUND, LARGEST_COORDINATE};
use crate::error::{Error, Result};
use crate::geometry::bounds::Point;
use crate::geometry::predicates::{big_sign, certain_sign, whole_numbers, Sign};

/// A plane through a point, across a normal.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    point: Point,
    normal: Point,
}

impl Plane {
    /// Errors: a normal of zero, and numbers that are not finite or beyond 1e100 in size.
    pub fn new(point: &Point, normal: &Point) -> Result<Plane> {
        for (what, value) in [("point", *point), ("normal", *normal)] {
            if !value.iter().all(|x| x.abs() <= LARGEST_COORDINATE) || what == "normal" && value == [0.0; 3] {
                return Err(Error::Plane { what, value });
            }
        }
        Ok(Plane { point: *point, normal: *normal })
    }

    /// How far in front of the plane a point is, in lengths of the normal, and what that is made of: the same sum with absolute
    /// values.
    #[inline(always)]
    fn height_and_size(&self, p: &Point) -> (f64, f64) {
        let terms: [f64; 3] = std::array::from_fn(|a| self.normal[a] * (p[a] - self.point[a]));
        (terms[0] + terms[1] + terms[2], terms[0].abs() + terms[1].abs() + terms[2].abs())
    }

    /// On which side a point is: in front (1), behind (-1), or exactly on the plane (0); 0 of a point that is not finite.
    #[inline]
    pub fn side(&self, p: &Point) -> Sign {
        let (height, size) = self.height_and_size(p);
        certain_sign(height, DOT_BOUND * size, size).unwrap_or_else(|| self.side_exactly(p))
    }

    #[cold]
    fn side_exactly(&self, p: &Point) -> Sign {
        if !p.iter().all(|x| x.is_finite()) {
            return 0;
        }
        let (n, q) = (&self.normal, &self.point);
        // Mostly there is one term, as planes lie across an axis; signs of differences are exact.
        let mut terms = (0..3).filter(|a| n[*a] != 0.0 && p[*a] != q[*a]);
        match (terms.next(), terms.next()) {
            (None, _) => 0,
            (Some(a), None) if (p[a] > q[a]) == (n[a] > 0.0) => 1,
            (Some(_), None) => -1,
            _ => {
                let w = whole_numbers([n[0], n[1], n[2], p[0], p[1], p[2], q[0], q[1], q[2]]);
                let term = |a: usize| &w[a] * (&w[3 + a] - &w[6 + a]);
                big_sign(&(term(0) + term(1) + term(2)))
            }
        }
    }

    /// Where an edge passes from behind the plane (with a corner on it: there) to in front of it, the same whichever triangle asks.
    pub fn crossing(&self, (behind, side): (&Point, Sign), in_front: &Point) -> Point {
        if side == 0 {
            return *behind;
        }
        let (h, g) = (self.height_and_size(behind).0, self.height_and_size(in_front).0);
        // Where float64 cannot tell, that end is on the plane for all it can.
        let share = if h < 0.0 && g > h { (h / (h - g)).min(1.0) } else { 0.0 };
        std::array::from_fn(|a| {
            let x = behind[a] + share * (in_front[a] - behind[a]);
            x.clamp(behind[a].min(in_front[a]), behind[a].max(in_front[a]))
        })
    }
}
