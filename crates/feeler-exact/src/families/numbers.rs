//! Difficult numbers: far from the origin, huge, denormal, decimal fractions, slivers; and first triangles without
//! area.

use feeler_core::{PairKind, Point, Triangle};

use super::book::{flat, mapped, Book, APART, BASE, COPLANAR, CROSSING, TINY, TOUCHING};

pub(super) fn add(book: &mut Book) {
    placed(book);
    decimals(book);
    slivers(book);
    mixed_scales(book);
    without_area(book);
}

/// Pairs in small whole numbers, one for each way to meet or miss.
fn models() -> Vec<(&'static str, Triangle, Option<PairKind>)> {
    vec![
        ("pierces the face", [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]], CROSSING),
        ("cuts right across", [[-2.0, 1.0, -2.0], [6.0, 1.0, -2.0], [2.0, 1.0, 6.0]], CROSSING),
        ("one edge in each", [[1.0, 1.0, -2.0], [1.0, 1.0, 2.0], [7.0, 1.0, 0.0]], CROSSING),
        ("through a corner", [[-1.0, -1.0, 0.0], [1.0, 1.0, -1.0], [1.0, 1.0, 1.0]], CROSSING),
        ("corner on face", [[1.0, 1.0, 0.0], [2.0, 1.0, 3.0], [0.0, 3.0, 3.0]], TOUCHING),
        ("corner on edge", [[2.0, 0.0, 0.0], [2.0, -1.0, 3.0], [0.0, -3.0, 3.0]], TOUCHING),
        ("corner on corner", [[4.0, 0.0, 0.0], [5.0, 0.0, 3.0], [5.0, 1.0, 3.0]], TOUCHING),
        ("edge on face", [[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [2.0, 1.0, 3.0]], TOUCHING),
        ("edge on edge, in line", [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 3.0]], TOUCHING),
        ("edge on edge, skew", [[2.0, 0.0, -1.0], [2.0, 0.0, 1.0], [2.0, -3.0, 0.0]], TOUCHING),
        ("edge on the longest edge", [[2.0, 2.0, -1.0], [2.0, 2.0, 1.0], [5.0, 5.0, 0.0]], TOUCHING),
        ("the same", BASE, COPLANAR),
        ("overlap", flat([[1.0, 1.0], [6.0, 1.0], [6.0, 6.0]]), COPLANAR),
        ("inside", flat([[1.0, 1.0], [2.0, 1.0], [1.0, 2.0]]), COPLANAR),
        ("shared edge, flat", flat([[4.0, 0.0], [0.0, 4.0], [4.0, 4.0]]), COPLANAR),
        ("corner to corner, flat", flat([[4.0, 0.0], [5.0, 0.0], [5.0, 1.0]]), COPLANAR),
        ("corner on edge, flat", flat([[2.0, 2.0], [5.0, 3.0], [3.0, 5.0]]), COPLANAR),
        ("above", [[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, 4.0, 1.0]], APART),
        ("one step short of the face", [[1.0, 1.0, 1.0], [2.0, 1.0, 3.0], [0.0, 3.0, 3.0]], APART),
        ("one step short of the longest edge", flat([[3.0, 2.0], [5.0, 3.0], [3.0, 5.0]]), APART),
        ("beside, planes cross", [[3.0, 3.0, -1.0], [3.0, 3.0, 1.0], [4.0, 2.0, 0.0]], APART),
        ("passages apart on the line", [[4.0, 1.0, -1.0], [4.0, 1.0, 1.0], [6.0, 1.0, 0.0]], APART),
    ]
}

/// The models moved and scaled so that no number rounds: the answer stays.
fn placed(book: &mut Book) {
    // Features of 2^-20, about 1e-6, at a million: 40 bits.
    let step = 1.0 / f64::from(1 << 20);
    let powers_of_two = |n: i32| -> f64 { (0..n.abs()).fold(1.0, |x, _| if n > 0 { x * 2.0 } else { x * 0.5 }) };
    type Place = Box<dyn Fn(Point) -> Point>;
    let places: Vec<(&str, Place)> = vec![
        ("at a million", Box::new(move |c| c.map(|x| 1e6 + x * step))),
        ("at mixed places", Box::new(move |[x, y, z]| [x * step - 1e6, y * step + 123_456.0, z * step + 0.5])),
        ("at a thousand, tiny", Box::new(move |c| c.map(|x| 1024.0 + x * f64::EPSILON * 1024.0))),
        ("huge", Box::new(move |c| c.map(|x| x * powers_of_two(325)))),
        ("small", Box::new(move |c| c.map(|x| x * powers_of_two(-600)))),
        ("at the edge of normal", Box::new(move |c| c.map(|x| x * f64::MIN_POSITIVE))),
        ("denormal", Box::new(|c| c.map(|x| x * TINY))),
        ("stretched by powers", Box::new(move |[x, y, z]| [x * powers_of_two(300), y * powers_of_two(-300), z])),
        ("stretched, denormal height", Box::new(|[x, y, z]| [x, y, z * TINY])),
    ];
    for (place_name, place) in &places {
        for (name, p, answer) in models() {
            book.add(format!("{place_name}: {name}"), mapped(p, place), mapped(BASE, place), answer);
        }
    }
    // One neighbour off, where it is as large as the features: at 2^20 with features of 2^-32.
    for (name, p, _) in models().into_iter().filter(|(.., answer)| *answer == TOUCHING) {
        let far = |c: Point| c.map(|x| 1_048_576.0 + x / 1_048_576.0 / 4096.0);
        for (way, nudge) in [("up", f64::next_up as fn(f64) -> f64), ("down", f64::next_down)] {
            let mut q = mapped(p, far);
            q[0][2] = nudge(q[0][2]);
            book.add_decided(format!("far, one ulp {way}: {name}"), q, mapped(BASE, far));
        }
    }
}

/// 0.1 + 0.2 is not 0.3: planes that hold on paper.
fn decimals(book: &mut Book) {
    let plane: Triangle = [[0.1, 0.2, 0.3], [0.2, 0.3, 0.1], [0.3, 0.1, 0.2]];
    for (name, p) in [
        ("shares the plane x + y + z = 0.6", [[0.6, 0.0, 0.0], [0.0, 0.6, 0.0], [0.0, 0.0, 0.6]]),
        ("its middle", [[0.2, 0.2, 0.2], [0.2, 0.2, 0.9], [0.9, 0.2, 0.2]]),
        ("its middle, from below", [[0.2, 0.2, 0.2], [0.1, 0.1, 0.1], [0.0, 0.2, 0.1]]),
        ("middle of its edge", [[0.15, 0.25, 0.2], [0.9, 0.9, 0.9], [0.8, 0.9, 0.9]]),
        ("middle of its edge, below", [[0.15, 0.25, 0.2], [0.0, 0.0, 0.0], [0.0, 0.1, 0.0]]),
        ("shares an edge", [[0.1, 0.2, 0.3], [0.2, 0.3, 0.1], [0.0, 0.5, 0.1]]),
        ("shares a corner", [[0.1, 0.2, 0.3], [0.0, 0.4, 0.2], [0.0, 0.3, 0.3]]),
        ("the plane by other decimals", [[0.11, 0.22, 0.27], [0.21, 0.31, 0.08], [0.29, 0.13, 0.18]]),
    ] {
        book.add_decided(format!("decimal: {name}"), p, plane);
        let shifted = |c: Point| c.map(|x| x + 1000.1);
        book.add_decided(format!("decimal, far: {name}"), mapped(p, shifted), mapped(plane, shifted));
        let inches = |c: Point| c.map(|x| x * 0.0254);
        book.add_decided(format!("decimal, inches: {name}"), mapped(p, inches), mapped(plane, inches));
    }
}

/// Aspects of 1e12 and more.
fn slivers(book: &mut Book) {
    let e = 1e-12;
    let sliver: Triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, e, 0.0]];
    for (name, p, q, answer) in [
        ("pierced in the middle", [[0.5, e / 2.0, -1.0], [0.5, e / 2.0, 1.0], [0.5, 2.0, 0.0]], sliver, CROSSING),
        ("missed by half its height", [[0.5, 1.5 * e, -1.0], [0.5, 1.5 * e, 1.0], [0.5, 2.0, 0.0]], sliver, APART),
        ("apex on an edge", [[0.5, e, -1.0], [0.5, e, 1.0], [0.5, 2.0, 0.0]], sliver, TOUCHING),
        ("apex on a face", [[0.0, e, -1.0], [1.0, e, -1.0], [0.5, e, 1.0]], sliver, TOUCHING),
        (
            "apex an ulp through a face",
            [0.0, 1.0, 0.5].map(|x| [x, e.next_down(), if x == 0.5 { 1.0 } else { -1.0 }]),
            sliver,
            CROSSING,
        ),
        ("the same", sliver, sliver, COPLANAR),
        ("back to back", [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, -e, 0.0]], sliver, COPLANAR),
        ("a hinge of two", [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.0, e]], sliver, TOUCHING),
        ("crosswise", [[0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [0.5 + e, 0.0, 0.0]], sliver, COPLANAR),
        ("crosswise, above", [[0.5, -0.5, e], [0.5, 0.5, e], [0.5, 0.0, 2.0 * e]], sliver, APART),
        ("crosswise, leaning on its base", [[0.5, -0.5, -e], [0.5, 0.5, e], [0.5 + e, 0.0, 0.0]], sliver, TOUCHING),
        ("end to end", [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.5, 0.0, e]], sliver, TOUCHING),
        ("end to end, a gap", [[1f64.next_up(), 0.0, 0.0], [2.0, 0.0, 0.0], [1.5, 0.0, e]], sliver, APART),
        ("through a face lengthwise", [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0 + e, 1.0, 0.0]], BASE, CROSSING),
        ("on a face lengthwise", [[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [1.5, 1.0, e]], BASE, TOUCHING),
        ("dips its apex", [[1.0, 1.0, e], [2.0, 1.0, e], [1.5, 1.0, -e]], BASE, CROSSING),
    ] {
        book.add(format!("sliver: {name}"), p, q, answer);
    }
    // Not along an axis: nothing is exact any more.
    let slanted: Triangle = [[0.1, 0.2, 0.3], [1.3, 0.7, 0.9], [0.7, 0.45, 0.6 + 1e-12]];
    for (name, p) in [
        ("over its base", [[0.7, 0.45, 0.6], [0.7, 0.45, 0.7], [0.8, 0.0, 0.6]]),
        ("through its middle", [[0.6, 0.2, 0.6], [0.8, 0.7, 0.6], [0.7, 0.4, 0.9]]),
        ("its own base line", [[0.1, 0.2, 0.3], [1.3, 0.7, 0.9], [1.0, 1.0, 0.0]]),
        ("a corner on its base", [[0.7, 0.45, 0.6], [0.0, 1.0, 0.0], [0.0, 1.0, 0.3]]),
        ("a like one, crossing", [[0.1, 0.2, 0.3 + 1e-12], [1.3, 0.7, 0.9 + 1e-12], [0.7, 0.45, 0.6 - 1e-12]]),
        (
            "a like one, shifted by an ulp",
            [[0.1, 0.2, 0.3f64.next_up()], [1.3, 0.7, 0.9f64.next_up()], [0.7, 0.45, 0.6]],
        ),
    ] {
        book.add_decided(format!("sliver, slanted: {name}"), p, slanted);
    }
}

/// The large and the tiny in one pair.
fn mixed_scales(book: &mut Book) {
    let ground: Triangle = [[-1e100, -1e100, 0.0], [1e100, -1e100, 0.0], [0.0, 1e100, 0.0]];
    for (name, p, answer) in [
        ("a speck on the ground", [[0.0, 0.0, 0.0], [TINY, 0.0, TINY], [0.0, TINY, TINY]], TOUCHING),
        ("a speck in the ground", [[0.0, 0.0, -TINY], [TINY, 0.0, TINY], [0.0, TINY, TINY]], CROSSING),
        ("a speck flat on the ground", [[0.0, 0.0, 0.0], [TINY, 0.0, 0.0], [0.0, TINY, 0.0]], COPLANAR),
        ("a speck above the ground", [[0.0, 0.0, TINY], [TINY, 0.0, TINY], [0.0, TINY, TINY]], APART),
        ("a mast from denormal to huge", [[0.0, 0.0, -TINY], [1.0, 0.0, 1e100], [-1.0, 1.0, 1e100]], CROSSING),
        ("a mast that stands", [[0.0, 0.0, 0.0], [1.0, 0.0, 1e100], [-1.0, 1.0, 1e100]], TOUCHING),
        ("a mast that floats", [[0.0, 0.0, TINY], [1.0, 0.0, 1e100], [-1.0, 1.0, 1e100]], APART),
        ("two grounds, a grain apart", mapped(ground, |[x, y, _]| [x, y, TINY]), APART),
        ("two grounds that cross", [[-1e100, 0.0, -1e100], [1e100, 0.0, -1e100], [0.0, 0.0, 1e100]], CROSSING),
    ] {
        book.add(format!("mixed: {name}"), p, ground, answer);
    }
    let wide: Triangle = [[-1e30, 0.1, 1e-30], [1e30, 0.2, 3e-30], [1e-5, 1e10, 7e-100]];
    for (name, p) in [
        ("a unit one", [[0.0, 1.0, -1.0], [1.0, 1.0, 1.0], [0.0, 2.0, 1.0]]),
        ("one as thin", [[-1.0, 0.5, 1e-30], [1.0, 0.5, 2e-30], [0.0, 0.7, -1e-200]]),
        ("one as wide", [[-1e30, 0.2, 1e-30], [1e30, 0.1, 3e-30], [0.0, -1e10, 1e-300]]),
    ] {
        book.add_decided(format!("mixed, wide: {name}"), p, wide);
    }
}

/// First triangles that are segments or points: they meet `coplanar` in the other's plane and `touching` through it.
fn without_area(book: &mut Book) {
    for (name, a, b, answer) in [
        ("pierces the face", [1.0, 1.0, -2.0], [1.0, 1.0, 2.0], TOUCHING),
        ("pierces slantwise", [0.0, 1.0, -2.0], [2.0, 1.0, 2.0], TOUCHING),
        ("pierces an edge", [2.0, 0.0, -2.0], [2.0, 0.0, 2.0], TOUCHING),
        ("pierces a corner", [0.0, 0.0, -2.0], [0.0, 0.0, 2.0], TOUCHING),
        ("pierces the longest edge", [2.0, 2.0, -2.0], [2.0, 2.0, 2.0], TOUCHING),
        ("pierces beside an edge", [2.0, -TINY, -2.0], [2.0, -TINY, 2.0], APART),
        ("pierces just inside an edge", [2.0, TINY, -2.0], [2.0, TINY, 2.0], TOUCHING),
        ("pierces beside, boxes overlap", [3.0, 3.0, -2.0], [3.0, 3.0, 2.0], APART),
        ("stands on the face", [1.0, 1.0, 0.0], [1.0, 1.0, 2.0], TOUCHING),
        ("hangs from the face", [1.0, 1.0, 0.0], [3.0, 1.0, -2.0], TOUCHING),
        ("stands on a corner", [4.0, 0.0, 0.0], [4.0, 2.0, 2.0], TOUCHING),
        ("stands beside", [5.0, 0.0, 0.0], [4.0, 2.0, 2.0], APART),
        ("above", [1.0, 1.0, 2.0], [3.0, 1.0, 4.0], APART),
        ("above by the smallest number", [1.0, 1.0, TINY], [3.0, 1.0, TINY], APART),
        ("inside the face", [1.0, 1.0, 0.0], [2.0, 1.0, 0.0], COPLANAR),
        ("across the face", [-2.0, 1.0, 0.0], [6.0, 1.0, 0.0], COPLANAR),
        ("the whole edge", [0.0, 0.0, 0.0], [4.0, 0.0, 0.0], COPLANAR),
        ("a part of the longest edge", [3.0, 1.0, 0.0], [1.0, 3.0, 0.0], COPLANAR),
        ("in line with an edge, end to end", [4.0, 0.0, 0.0], [6.0, 0.0, 0.0], COPLANAR),
        ("in line with an edge, a gap", [5.0, 0.0, 0.0], [7.0, 0.0, 0.0], APART),
        ("past a corner, flat", [3.0, -1.0, 0.0], [5.0, 1.0, 0.0], COPLANAR),
        ("beside, flat", [3.0, 3.0, 0.0], [5.0, 1.0, 0.0], APART),
        ("up to an edge, flat", [2.0, -2.0, 0.0], [2.0, 0.0, 0.0], COPLANAR),
        ("short of an edge, flat", [2.0, -2.0, 0.0], [2.0, -TINY, 0.0], APART),
    ] {
        let middle = std::array::from_fn(|i| a[i] + 0.5 * (b[i] - a[i]));
        book.add(format!("segment: {name}, middle last"), [a, b, middle], BASE, answer);
        book.add(format!("segment: {name}, doubled end"), [a, b, b], BASE, answer);
    }
    for (name, at, answer) in [
        ("on the face", [1.0, 1.0, 0.0], COPLANAR),
        ("on an edge", [2.0, 0.0, 0.0], COPLANAR),
        ("on the longest edge", [2.0, 2.0, 0.0], COPLANAR),
        ("on a corner", [4.0, 0.0, 0.0], COPLANAR),
        ("beside", [3.0, 3.0, 0.0], APART),
        ("just beside an edge", [2.0, -TINY, 0.0], APART),
        ("just beside the longest edge", [2.0, 2f64.next_up(), 0.0], APART),
        ("above", [1.0, 1.0, 1.0], APART),
        ("above by the smallest number", [1.0, 1.0, TINY], APART),
    ] {
        book.add(format!("point: {name}"), [at; 3], BASE, answer);
    }
    let slanted: Triangle = [[0.1, 0.2, 0.3], [1.3, 0.7, 0.9], [0.7, 0.9, 0.1]];
    book.add("point: on a slanted corner", [slanted[1]; 3], slanted, COPLANAR);
    book.add("segment: a slanted edge", [slanted[0], slanted[1], slanted[1]], slanted, COPLANAR);
    book.add_decided("point: in the middle of a slanted edge", [[0.7, 0.45, 0.6]; 3], slanted);
    book.add_decided("segment: from the middle of a slanted edge", [[0.7, 0.45, 0.6], [1.0; 3], [1.0; 3]], slanted);
}
