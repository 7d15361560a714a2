//! Distances of difficult pairs, compared with exact rational arithmetic.

use feeler_core::constants::UNIT_ROUNDOFF;
use feeler_core::{Point, Triangle};
use feeler_exact::distance::check_pair;
use feeler_exact::oracle::has_area;
use feeler_exact::pairs::{self, PairMaker};
use feeler_exact::random::Random;

fn moved(t: Triangle, by: Point) -> Triangle {
    t.map(|c| std::array::from_fn(|a| c[a] + by[a]))
}

/// A pair of another generator, drawn apart by a small or a large way.
fn apart(r: &mut Random) -> [Triangle; 2] {
    let make: PairMaker = r.pick(&[pairs::general as PairMaker, pairs::lattice, pairs::slivers, pairs::edge_on_edge]);
    let [p, q] = make(r);
    let far = r.pick(&[1e-15, 1e-9, 1e-4, 0.1, 3.0]);
    [moved(p, r.point(-far, far)), q]
}

/// Triangles of all aspects that nearly share an edge's line, a plane, or a corner.
fn near_parallel(r: &mut Random) -> [Triangle; 2] {
    let (a, d) = (r.point(-1.0, 1.0), r.point(-1.0, 1.0));
    let tilt = r.pick(&[0.0, 1e-16, 1e-12, 1e-8, 1e-4]);
    let width = r.pick(&[1.0, 1e-3, 1e-8, 1e-13]);
    let gap = r.pick(&[0.0, 1e-14, 1e-9, 1e-3]);
    let side = |r: &mut Random, from: f64, by: f64| -> Triangle {
        let at = |r: &mut Random, t: f64, off: f64| -> Point {
            let e = r.point(-1.0, 1.0);
            std::array::from_fn(|k| a[k] + t * d[k] + off * e[k])
        };
        let (t0, t1) = (from + r.real(0.0, 0.5), from + r.real(0.5, 1.0));
        let t2 = r.real(t0, t1);
        [at(r, t0, by), at(r, t1, by), at(r, t2, width)]
    };
    let shift = r.pick(&[0.0, 0.3, 1.0, 2.5]);
    let p = side(r, 0.0, 0.0);
    let q = side(r, shift, tilt);
    [p, moved(q, r.point(-gap, gap))]
}

/// A corner above the inside of a sliver.
fn above_a_sliver(r: &mut Random) -> [Triangle; 2] {
    let (a, b, e) = (r.point(-1.0, 1.0), r.point(-1.0, 1.0), r.point(-1.0, 1.0));
    let width = r.pick(&[1e-2, 1e-5, 1e-8, 1e-11, 1e-14]);
    let share = r.real(0.0, 1.0);
    let q: Triangle = [a, b, std::array::from_fn(|k| a[k] + share * (b[k] - a[k]) + width * e[k])];
    let (u, v) = (r.real(0.0, 0.5), r.real(0.0, 0.5));
    let height = r.pick(&[1e-16, 1e-10, 1e-3, 1.0]);
    let up = r.point(-1.0, 1.0);
    let foot: Point =
        std::array::from_fn(|k| q[0][k] + u * (q[1][k] - q[0][k]) + v * (q[2][k] - q[0][k]) + height * up[k]);
    let reach = r.pick(&[1e-6, 1.0]);
    let (x, y) = (r.point(-reach, reach), r.point(-reach, reach));
    [[foot, std::array::from_fn(|k| foot[k] + x[k] + up[k]), std::array::from_fn(|k| foot[k] + y[k] + up[k])], q]
}

/// Checks pairs as they are, far from the origin, tiny and huge, with the two exchanged. Returns the largest error.
fn check(name: &str, make: PairMaker, count: usize, seed: u64) -> f64 {
    let mut r = Random::new(seed);
    let mut worst = 0.0f64;
    for i in 0..count {
        let [p, q] = make(&mut r);
        let scale = r.pick(&[1.0, 1.0, 2f64.powi(-300), 2f64.powi(260), 1e-6]);
        let offset = r.pick(&[0.0, 0.0, 1e3, -1e7]) * scale;
        let placed = |t: Triangle| t.map(|c| c.map(|x| x * scale + offset));
        let (p, q) = (placed(p), placed(q));
        let numbers = || p.iter().chain(&q).flatten();
        // Far away, rounding may have taken the area of both.
        if numbers().any(|x| !x.is_finite() || x.abs() > 1e99) || !has_area(&q) {
            continue;
        }
        let error = check_pair(&p, &q).unwrap_or_else(|why| panic!("{name} {i}: {why}\n{p:?}\n{q:?}"));
        worst = worst.max(error);
    }
    worst
}

#[test]
fn distances_are_right_within_the_stated_bound() {
    let families: [(&str, PairMaker, usize); 13] = [
        ("general", pairs::general, 2000),
        ("lattice", pairs::lattice, 3000),
        ("near-coplanar", pairs::near_coplanar, 2000),
        ("shared", pairs::shared, 2000),
        ("slivers", pairs::slivers, 3000),
        ("edge-on-edge", pairs::edge_on_edge, 2000),
        ("far", pairs::far, 1000),
        ("powers", pairs::powers, 1000),
        ("mixed-scales", pairs::mixed_scales, 2000),
        ("without-area", pairs::without_area, 2000),
        ("apart", apart, 4000),
        ("near-parallel", near_parallel, 6000),
        ("above-a-sliver", above_a_sliver, 6000),
    ];
    for (i, (name, make, count)) in families.into_iter().enumerate() {
        let worst = check(name, make, count, 77 + i as u64);
        println!("{name}: {:.1} roundoffs", worst / UNIT_ROUNDOFF);
    }
}
