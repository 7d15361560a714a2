//! Shrinks a failure to the smallest one: a scene to one pair of triangles, a pair to simple numbers.
//!
//! The same idea as delta debugging (A. Zeller and R. Hildebrandt, *Simplifying and isolating failure-inducing input*,
//! 2002): remove a part or simplify a number, and keep the change if the failure stays.

use feeler_core::{Pose, Triangle};

use crate::corpus::Case;
use crate::oracle;

/// A mock-up, a tool and a pose at which something is wrong.
#[derive(Debug, Clone)]
pub struct Trouble {
    /// The mock-up's triangles, metres.
    pub mockup: Vec<Triangle>,
    /// The tool's triangles in its own frame, metres.
    pub tool: Vec<Triangle>,
    /// `world_from_tool`.
    pub pose: Pose,
}

/// The least trouble that still fails: fewest triangles, then no pose, then the simplest numbers.
///
/// `is_failing` must be true for `trouble` itself.
pub fn minimise_scene(trouble: &Trouble, is_failing: &dyn Fn(&Trouble) -> bool) -> Trouble {
    let mut least = trouble.clone();
    loop {
        let before = least.mockup.len() + least.tool.len();
        least.mockup = fewest(&least.mockup, &|part| is_failing(&Trouble { mockup: part.to_vec(), ..least.clone() }));
        least.tool = fewest(&least.tool, &|part| is_failing(&Trouble { tool: part.to_vec(), ..least.clone() }));
        if least.mockup.len() + least.tool.len() == before {
            break;
        }
    }
    let placed = Trouble {
        tool: least.tool.iter().map(|t| least.pose.apply_triangle(t)).collect(),
        pose: Pose::IDENTITY,
        mockup: least.mockup.clone(),
    };
    if is_failing(&placed) {
        least = placed;
    }
    if let ([p], [q]) = (&least.tool[..], &least.mockup[..]) {
        let pose = least.pose;
        let of_pair = |p: &Triangle, q: &Triangle| Trouble { mockup: vec![*q], tool: vec![*p], pose };
        let [p, q] = minimise_pair(p, q, &|p, q| is_failing(&of_pair(p, q)));
        least = of_pair(&p, &q);
    }
    least
}

/// The trouble as a line of the corpus. Where more than one pair at no pose is left, a line for each pair (of many, those that
/// could meet), after a comment that says what remains.
pub fn lines(name: &str, trouble: &Trouble) -> String {
    let mut lines = Vec::new();
    let is_one_pair = trouble.tool.len() == 1 && trouble.mockup.len() == 1;
    if !is_one_pair || trouble.pose != Pose::IDENTITY {
        lines.push(format!(
            "# fails as a whole only: {} tool and {} mock-up triangles at {:?}; tool {:?}",
            trouble.tool.len(),
            trouble.mockup.len(),
            trouble.pose,
            trouble.tool
        ));
    }
    for (i, p) in trouble.tool.iter().enumerate() {
        let p = trouble.pose.apply_triangle(p);
        for (j, q) in trouble.mockup.iter().enumerate() {
            let is_shown = trouble.mockup.len() <= 20 || oracle::is_meeting_boxes(&p, q);
            if is_shown && oracle::has_area(q) {
                let name = if is_one_pair { name.into() } else { format!("{name} {i} {j}") };
                lines.push(line_of_pair(&name, &p, q));
            }
        }
    }
    lines.join("\n")
}

/// A pair as a line of the corpus, with the true answer.
pub fn line_of_pair(name: &str, p: &Triangle, q: &Triangle) -> String {
    Case { name: name.into(), p: *p, q: *q, answer: oracle::kind_of_pair(p, q) }.line()
}

/// The fewest triangles that still fail: halves are dropped first, then quarters, down to single ones.
fn fewest(triangles: &[Triangle], is_failing: &dyn Fn(&[Triangle]) -> bool) -> Vec<Triangle> {
    let mut kept = triangles.to_vec();
    let mut size = kept.len().div_ceil(2);
    while kept.len() > 1 && size > 0 {
        let mut from = 0;
        while from < kept.len() && kept.len() > 1 {
            let rest: Vec<Triangle> =
                kept.iter().enumerate().filter(|(i, _)| !(from..from + size).contains(i)).map(|(_, t)| *t).collect();
            if !rest.is_empty() && is_failing(&rest) {
                kept = rest;
            } else {
                from += size;
            }
        }
        size /= 2;
    }
    kept
}

/// The simplest numbers with which a pair still fails. The second triangle keeps an area, and the first if it has one.
pub fn minimise_pair(p: &Triangle, q: &Triangle, is_failing: &dyn Fn(&Triangle, &Triangle) -> bool) -> [Triangle; 2] {
    let needs_area = oracle::has_area(p);
    let is_kept = |pair: &[Triangle; 2]| {
        let [p, q] = pair;
        pair.iter().flatten().flatten().all(|x| x.abs() <= 1e100)
            && oracle::has_area(q)
            && (!needs_area || oracle::has_area(p))
            && is_failing(p, q)
    };
    let mut least = [*p, *q];
    loop {
        let before = cost(&least);
        for change in whole_changes(&least) {
            if cost(&change) < cost(&least) && is_kept(&change) {
                least = change;
            }
        }
        for at in 0..18 {
            let (t, c, a) = (at / 9, at / 3 % 3, at % 3);
            for x in simpler(least[t][c][a]) {
                let mut change = least;
                change[t][c][a] = x;
                if cost(&change) < cost(&least) && is_kept(&change) {
                    least = change;
                }
            }
        }
        if cost(&least) == before {
            return least;
        }
    }
}

/// How much there is to say about the numbers: their bits, and how far they are from one.
pub fn cost(pair: &[Triangle; 2]) -> u64 {
    pair.iter().flatten().flatten().map(|x| cost_of_number(*x)).sum()
}

fn cost_of_number(x: f64) -> u64 {
    if x == 0.0 {
        return u64::from(x.is_sign_negative());
    }
    let (first, last) = bits_of(x);
    4 * (first - last + 1) as u64 + u64::from(first.unsigned_abs()) + u64::from(x < 0.0)
}

/// The exponents of the first and last bit of a number that is not zero.
fn bits_of(x: f64) -> (i32, i32) {
    let bits = x.to_bits();
    let fraction = bits & ((1 << 52) - 1);
    match (bits >> 52 & 0x7ff) as i32 {
        0 => (fraction.ilog2() as i32 - 1074, fraction.trailing_zeros() as i32 - 1074),
        biased => (biased - 1023, (fraction | 1 << 52).trailing_zeros() as i32 + biased - 1075),
    }
}

/// Simpler numbers near or far: zero, one, whole ones, ones with fewer bits.
fn simpler(x: f64) -> Vec<f64> {
    let mut out = vec![0.0, 1.0, -1.0, 2.0, -2.0, 3.0, x.signum(), x.round(), x.trunc(), -x, x / 2.0];
    if x != 0.0 {
        // Fewer and fewer bits dropped from the end, to the number below and the one above.
        out.extend((0..52).rev().flat_map(|n| {
            let down = f64::from_bits(x.to_bits() >> n << n);
            [down, f64::from_bits((x.to_bits() >> n).wrapping_add(1) << n)]
        }));
    }
    out.retain(|x| x.is_finite());
    out
}

/// Changes of all numbers at once: moved to a corner, scaled by a power of two, put on a coarse grid.
fn whole_changes(pair: &[Triangle; 2]) -> Vec<[Triangle; 2]> {
    let mut out = Vec::new();
    let all = |f: &dyn Fn(usize, f64) -> f64| pair.map(|t| t.map(|c| [f(0, c[0]), f(1, c[1]), f(2, c[2])]));
    for corner in pair.iter().flatten() {
        out.push(all(&|axis, x| x - corner[axis]));
        for moved_axis in 0..3 {
            out.push(all(&|axis, x| if axis == moved_axis { x - corner[axis] } else { x }));
        }
    }
    let numbers: Vec<f64> = pair.iter().flatten().flatten().copied().filter(|x| *x != 0.0).collect();
    let Some(highest) = numbers.iter().map(|x| bits_of(*x).0).max() else { return out };
    let scaled = |x: f64, n: i32| -> f64 {
        let half = n / 2;
        x * 2f64.powi(half) * 2f64.powi(n - half)
    };
    for top in 0..12 {
        out.push(all(&|_, x| scaled(x, top - highest)));
    }
    for axis_scaled in 0..3 {
        out.push(all(&|axis, x| if axis == axis_scaled { scaled(x, -highest) } else { x }));
    }
    // Whole numbers of few bits, then more.
    for bits in 1..50 {
        out.push(all(&|_, x| scaled(x, bits - highest).round()));
        out.push(all(&|_, x| scaled(scaled(x, bits - highest).round(), highest - bits)));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::shapes::{circle, tube, Motion};
    use feeler_core::intersect_triangle_triangle;

    /// What many libraries do: heights over the other's plane, with a tolerance that knows no unit.
    fn is_meeting_sloppily(p: &Triangle, q: &Triangle) -> bool {
        let minus = |a: &[f64; 3], b: &[f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let is_beside = |p: &Triangle, q: &Triangle| {
            let (u, v) = (minus(&q[1], &q[0]), minus(&q[2], &q[0]));
            let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let heights = p.map(|c| {
                let d = minus(&c, &q[0]);
                n[0] * d[0] + n[1] * d[1] + n[2] * d[2]
            });
            heights.iter().all(|h| *h > -1e-9) || heights.iter().all(|h| *h < 1e-9)
        };
        !is_beside(p, q) && !is_beside(q, p) && intersect_triangle_triangle(p, q).is_some()
    }

    fn is_wrong(p: &Triangle, q: &Triangle) -> bool {
        is_meeting_sloppily(p, q) != oracle::kind_of_pair(p, q).is_some()
    }

    #[test]
    fn a_pair_shrinks_to_small_whole_numbers() {
        // Touching at a corner, far away, in crooked numbers: the sloppy test loses it.
        let q = [[1000.1, 2000.2, 3000.3], [1001.7, 2000.9, 3000.4], [1000.3, 2002.8, 3001.1]];
        let p = [q[1], [1003.3, 2001.1, 3009.7], [1002.9, 1999.3, 3004.1]];
        assert!(is_wrong(&p, &q));
        let [a, b] = minimise_pair(&p, &q, &is_wrong);
        assert!(is_wrong(&a, &b));
        assert!(cost(&[a, b]) * 20 < cost(&[p, q]), "{a:?} {b:?}");
        assert!([a, b].iter().flatten().flatten().all(|x| x.fract() == 0.0 && x.abs() < 10.0), "{a:?} {b:?}");
    }

    #[test]
    fn a_scene_shrinks_to_a_line_of_the_corpus() {
        let mut r = Random::new(3);
        let place = Motion::random(&mut r, 100.0);
        let modelled = Motion::random(&mut r, 1.0);
        let (hole, pin) =
            (tube(&circle(12, 2.0), Some(&circle(12, 1.0)), 0.0, 1.0), tube(&circle(12, 1.0), None, 0.0, 1.0));
        let trouble = Trouble {
            mockup: place.applied(&hole),
            tool: modelled.applied(&pin),
            pose: place.after(&modelled.inverse()).pose(),
        };
        let is_failing = |trouble: &Trouble| {
            trouble
                .tool
                .iter()
                .map(|p| trouble.pose.apply_triangle(p))
                .any(|p| trouble.mockup.iter().any(|q| oracle::has_area(q) && is_wrong(&p, q)))
        };
        assert!(is_failing(&trouble));
        let least = minimise_scene(&trouble, &is_failing);
        assert!(is_failing(&least));
        assert_eq!((least.tool.len(), least.mockup.len(), least.pose), (1, 1, Pose::IDENTITY));
        let text = lines("found: sloppy", &least);
        let cases = crate::corpus::parse(&text).unwrap();
        assert_eq!(cases.len(), 1, "{text}");
        assert!(is_wrong(&cases[0].p, &cases[0].q) && text.len() < 150, "{text}");
        assert_eq!(cases[0].answer, oracle::kind_of_pair(&cases[0].p, &cases[0].q));
    }

    #[test]
    fn what_fails_only_as_a_whole_is_said_so() {
        let t = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let trouble = Trouble { mockup: vec![t; 9], tool: vec![t; 9], pose: Pose::IDENTITY };
        let least = minimise_scene(&trouble, &|x| x.mockup.len() >= 2);
        assert_eq!((least.mockup.len(), least.tool.len()), (2, 1));
        assert!(lines("found", &least).starts_with("# fails as a whole only: 1 tool and 2 mock-up"));
    }
}
