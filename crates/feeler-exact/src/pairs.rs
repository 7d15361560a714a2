//! Difficult pairs of triangles, one generator for each kind. The second triangle always has an area.

use feeler_core::{Point, Triangle};

use crate::oracle::has_area;
use crate::random::Random;

/// Makes one pair.
pub type PairMaker = fn(&mut Random) -> [Triangle; 2];

fn with_area(mut make: impl FnMut() -> Triangle) -> Triangle {
    loop {
        let t = make();
        if has_area(&t) {
            return t;
        }
    }
}

/// A point of the triangle's plane (inside when the weights are in 0 to 1), as floating point finds it.
fn on_plane(t: &Triangle, u: f64, v: f64) -> Point {
    std::array::from_fn(|a| t[0][a] + u * (t[1][a] - t[0][a]) + v * (t[2][a] - t[0][a]))
}

/// Weights inside, on the sides, at the corners and beyond.
fn weights(r: &mut Random) -> (f64, f64) {
    match r.below(4) {
        0 => (r.real(-0.5, 1.5), r.real(-0.5, 1.5)),
        1 => (r.quarters(-4, 8), r.quarters(-4, 8)),
        2 => (r.real(-0.2, 1.2), 0.0),
        _ => {
            let u = r.real(-0.2, 1.2);
            (u, 1.0 - u)
        }
    }
}

fn random_triangle(r: &mut Random) -> Triangle {
    let c = r.point(0.0, 1.0);
    let size = r.pick(&[0.3, 0.6, 1.0]);
    with_area(|| std::array::from_fn(|_| std::array::from_fn(|a| c[a] + r.real(-size, size))))
}

/// In general position, boxes mostly overlapping: what nominal poses are made of.
pub fn general(r: &mut Random) -> [Triangle; 2] {
    [random_triangle(r), random_triangle(r)]
}

/// Small whole numbers: everything touches, lies flush or coincides all the time.
pub fn lattice(r: &mut Random) -> [Triangle; 2] {
    let high = r.pick(&[1, 2, 2, 3, 4, 6]);
    let flat = r.one_in(3).then(|| (r.below(3), r.below(3), f64::from(r.whole(0, high))));
    let make = |axis: usize, r: &mut Random| -> Triangle {
        let mut t = r.lattice_triangle(0, high);
        if let Some((_, _, level)) = flat {
            t.iter_mut().for_each(|c| c[axis] = level);
        }
        t
    };
    let (axis_p, axis_q) = flat.map_or((0, 0), |(a, b, _)| (a, b));
    let p = if r.one_in(20) { make(axis_p, r) } else { with_area(|| make(axis_p, r)) };
    [p, with_area(|| make(axis_q, r))]
}

/// Corners computed on the other's plane, then a few neighbours off it.
pub fn near_coplanar(r: &mut Random) -> [Triangle; 2] {
    let is_whole = r.one_in(3);
    let q = if is_whole { with_area(|| r.lattice_triangle(-9, 9)) } else { random_triangle(r) };
    let p = with_area(|| {
        std::array::from_fn(|_| {
            // Halves and quarters of whole numbers stay exactly on the plane.
            let (u, v) = if is_whole { (r.quarters(-4, 8), r.quarters(-4, 8)) } else { weights(r) };
            on_plane(&q, u, v)
        })
    });
    let steps = r.whole(0, 3);
    [r.nudged_triangle(p, steps), q]
}

/// One or two corners in common, or computed on the other's edges; the rest anywhere or near the other's plane.
pub fn shared(r: &mut Random) -> [Triangle; 2] {
    let q = if r.one_in(3) { with_area(|| r.lattice_triangle(-3, 3)) } else { random_triangle(r) };
    let p = with_area(|| {
        let count = r.whole(1, 3);
        let from = r.below(3);
        std::array::from_fn(|i| {
            let corner = q[(from + i) % 3];
            if i as i32 >= count {
                return if r.one_in(2) {
                    r.point(-1.0, 2.0)
                } else {
                    on_plane(&q, r.real(-1.0, 2.0), r.real(-1.0, 2.0))
                };
            }
            match r.below(4) {
                0 => {
                    let next = q[(from + i + 1) % 3];
                    let share = if r.one_in(2) { f64::from(r.whole(0, 8)) / 8.0 } else { r.real(0.0, 1.0) };
                    std::array::from_fn(|a| corner[a] + share * (next[a] - corner[a]))
                }
                1 => corner.map(|x| r.nudged(x, 1)),
                _ => corner,
            }
        })
    });
    [r.shuffled(p), r.shuffled(q)]
}

/// Aspects of 1e3 to 1e15, side by side, crossing, end to end.
pub fn slivers(r: &mut Random) -> [Triangle; 2] {
    let sliver = |r: &mut Random, a: Point, b: Point| -> Triangle {
        let thin = r.pick(&[1e-3, 1e-6, 1e-9, 1e-12, 1e-15]);
        with_area(|| {
            let share = r.real(-0.1, 1.1);
            [a, b, std::array::from_fn(|k| a[k] + share * (b[k] - a[k]) + thin * r.real(-1.0, 1.0))]
        })
    };
    let (a, b) = (r.point(0.0, 1.0), r.point(0.0, 1.0));
    let q = sliver(r, a, b);
    let p = match r.below(5) {
        0 => random_triangle(r),
        // Along the other.
        1 => sliver(r, b, on_plane(&q, 0.3, 0.2)),
        2 => {
            let d = r.point(-1.0, 1.0).map(|x| x * 1e-9);
            sliver(r, std::array::from_fn(|k| a[k] + d[k]), std::array::from_fn(|k| b[k] - d[k]))
        }
        // Across it.
        3 => {
            let c = on_plane(&q, r.real(0.0, 0.5), r.real(0.0, 0.5));
            let d = r.point(-1.0, 1.0);
            sliver(r, std::array::from_fn(|k| c[k] - d[k]), std::array::from_fn(|k| c[k] + d[k]))
        }
        _ => {
            let (c, d) = (r.point(0.0, 1.0), on_plane(&q, r.real(0.0, 1.0), 0.0));
            sliver(r, c, d)
        }
    };
    [r.shuffled(p), r.shuffled(q)]
}

/// An edge of one computed through a point on an edge of the other, some neighbours off: hit or miss by a last bit.
pub fn edge_on_edge(r: &mut Random) -> [Triangle; 2] {
    // Of whole numbers and quarters of them nothing rounds: the edges do meet.
    let is_whole = r.one_in(3);
    let q = if is_whole { with_area(|| r.lattice_triangle(-9, 9)) } else { random_triangle(r) };
    let middle = on_plane(&q, if is_whole { r.quarters(0, 4) } else { r.real(0.0, 1.0) }, 0.0);
    let p = with_area(|| {
        let d = if is_whole { r.lattice_point(-5, 5) } else { r.point(-1.0, 1.0) };
        let share = if is_whole { r.quarters(0, 8) } else { r.pick(&[1.0, 0.5, 2.0, 0.3, 0.0]) };
        let away: Point = std::array::from_fn(|a| middle[a] - 0.5 * (q[2][a] - q[0][a]) + r.real(-0.4, 0.4));
        [std::array::from_fn(|a| middle[a] + d[a]), std::array::from_fn(|a| middle[a] - share * d[a]), away]
    });
    let steps = r.pick(&[0, 0, 1, 2]);
    let p = r.nudged_triangle(p, steps);
    [r.shuffled(p), r.shuffled(q)]
}

/// Features of a millionth at a million, and worse: few bits are left.
pub fn far(r: &mut Random) -> [Triangle; 2] {
    let [p, q] = match r.below(4) {
        0 => general(r),
        1 => near_coplanar(r),
        2 => shared(r),
        _ => lattice(r),
    };
    let (offset, scale) =
        r.pick(&[(1e6, 1e-6), (3000.0, 1e-9), (1e6, 1e-8), (1e3, 1e-3), (1048576.0, 1.0 / 1048576.0)]);
    let centre: Point = std::array::from_fn(|_| if r.one_in(4) { 0.0 } else { offset * r.real(-1.0, 1.0) });
    let place = |t: Triangle| -> Triangle { t.map(|c| std::array::from_fn(|a| centre[a] + scale * c[a])) };
    let (p, q) = (place(p), place(q));
    if has_area(&q) {
        [p, q]
    } else {
        far(r)
    }
}

fn power_of_two(n: i32) -> f64 {
    (0..n.abs()).fold(1.0, |x, _| if n > 0 { x * 2.0 } else { x * 0.5 })
}

/// Lattice pairs and fractions times any power of two, from denormals to the largest coordinates, per axis or in all.
pub fn powers(r: &mut Random) -> [Triangle; 2] {
    let [p, q] = if r.one_in(3) { near_coplanar(r) } else { lattice(r) };
    let mut exponent = || match r.below(4) {
        0 => -1074,
        1 => r.whole(-1074, -900),
        2 => 320,
        _ => r.whole(-400, 320),
    };
    let n = exponent();
    let stretched = exponent();
    let axis = r.below(6);
    let place =
        |c: Point| -> Point { std::array::from_fn(|a| c[a] * power_of_two(if a == axis { stretched } else { n })) };
    let (p, q) = (p.map(place), q.map(place));
    if has_area(&q) {
        [p, q]
    } else {
        powers(r)
    }
}

/// All scales in one pair: zeros, ones, denormals and giants side by side.
pub fn mixed_scales(r: &mut Random) -> [Triangle; 2] {
    let mut number = || -> f64 {
        let x = f64::from(r.whole(-3, 3));
        match r.below(8) {
            0..=2 => x,
            3 => x * 5e-324,
            4 => x * 1e-120,
            5 => x * 3e99,
            6 => x * 0.1,
            _ => f64::from_bits((x + 0.5).to_bits() + 1),
        }
    };
    let mut make = || with_area(|| std::array::from_fn(|_| std::array::from_fn(|_| number())));
    [make(), make()]
}

/// The first has lost its area, as a tool's triangle can at a pose: a segment or a point at, through and beside the second.
pub fn without_area(r: &mut Random) -> [Triangle; 2] {
    let whole = r.one_in(2);
    let q = if whole { with_area(|| r.lattice_triangle(0, 4)) } else { random_triangle(r) };
    let end = |r: &mut Random| -> Point {
        match (whole, r.below(4)) {
            (true, 0..=2) => r.lattice_point(-1, 5),
            (_, 3) => q[r.below(3)],
            _ => {
                let (u, v) = weights(r);
                on_plane(&q, u, v).map(|x| r.nudged(x, 1))
            }
        }
    };
    let (a, b) = (end(r), end(r));
    let p = match r.below(3) {
        0 => [a, a, a],
        1 => [a, b, b],
        _ if whole => [a, std::array::from_fn(|k| 2.0 * b[k] - a[k]), b],
        // Exactly on one line: along an axis.
        _ => [a, [a[0], a[1], b[2]], [a[0], a[1], q[0][2]]],
    };
    [r.shuffled(p), r.shuffled(q)]
}
