//! One plane: overlap, containment, shared edges and corners, and their near misses, in planes of three directions; then
//! one corner lifted out of the plane.

use feeler_core::{PairKind, Point, Triangle};

use super::book::{flat, Book, APART, COPLANAR, TINY};

type Flat = [[f64; 2]; 3];

const FLAT_BASE: Flat = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]];

/// Name, first triangle, second triangle, answer; in (u, v).
fn designs() -> Vec<(&'static str, Flat, Flat, Option<PairKind>)> {
    let up = f64::next_up;
    let down = f64::next_down;
    vec![
        ("the same", FLAT_BASE, FLAT_BASE, COPLANAR),
        ("the same, turned over", [[0.0, 0.0], [0.0, 4.0], [4.0, 0.0]], FLAT_BASE, COPLANAR),
        ("inside", [[1.0, 1.0], [2.0, 1.0], [1.0, 2.0]], FLAT_BASE, COPLANAR),
        ("inside, a corner on an edge", [[1.0, 0.0], [2.0, 1.0], [1.0, 2.0]], FLAT_BASE, COPLANAR),
        ("inside, an edge on an edge", [[1.0, 0.0], [2.0, 0.0], [1.0, 2.0]], FLAT_BASE, COPLANAR),
        ("inside, at a corner", [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], FLAT_BASE, COPLANAR),
        ("inside, a corner on a corner", [[0.0, 0.0], [2.0, 1.0], [1.0, 2.0]], FLAT_BASE, COPLANAR),
        ("the middle triangle", [[2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], FLAT_BASE, COPLANAR),
        ("covering", [[-1.0, -1.0], [9.0, -1.0], [-1.0, 9.0]], FLAT_BASE, COPLANAR),
        ("covering, an edge in line", [[-2.0, 0.0], [8.0, 0.0], [-1.0, 9.0]], FLAT_BASE, COPLANAR),
        ("covering, at a corner", [[0.0, 0.0], [8.0, 0.0], [0.0, 8.0]], FLAT_BASE, COPLANAR),
        ("a corner in", [[1.0, 1.0], [9.0, 1.0], [9.0, 9.0]], FLAT_BASE, COPLANAR),
        ("a corner in across an edge", [[1.0, 1.0], [0.0, -3.0], [2.0, -3.0]], FLAT_BASE, COPLANAR),
        ("an edge through, no corner in", [[-1.0, 1.0], [5.0, 1.0], [9.0, 9.0]], FLAT_BASE, COPLANAR),
        ("the star of David", [[0.0, 4.0], [6.0, 4.0], [3.0, -2.0]], [[0.0, 0.0], [6.0, 0.0], [3.0, 6.0]], COPLANAR),
        (
            "needles that cross",
            [[1.0, -9.0], [1.5, -9.0], [1.25, 9.0]],
            [[-9.0, 1.0], [-9.0, 1.5], [9.0, 1.25]],
            COPLANAR,
        ),
        ("a shared edge, other side", [[4.0, 0.0], [0.0, 4.0], [4.0, 4.0]], FLAT_BASE, COPLANAR),
        ("a shared edge, same side", [[0.0, 0.0], [4.0, 0.0], [1.0, 1.0]], FLAT_BASE, COPLANAR),
        ("a shared edge, same side, larger", [[0.0, 0.0], [4.0, 0.0], [1.0, 9.0]], FLAT_BASE, COPLANAR),
        ("a part of an edge, other side", [[1.0, 0.0], [2.0, 0.0], [1.0, -2.0]], FLAT_BASE, COPLANAR),
        ("more than an edge, other side", [[-1.0, 0.0], [5.0, 0.0], [1.0, -2.0]], FLAT_BASE, COPLANAR),
        ("over the end of an edge", [[3.0, 0.0], [6.0, 0.0], [5.0, -2.0]], FLAT_BASE, COPLANAR),
        ("edges in line, end to end", [[4.0, 0.0], [6.0, 0.0], [5.0, -2.0]], FLAT_BASE, COPLANAR),
        ("edges in line, a gap", [[5.0, 0.0], [6.0, 0.0], [5.0, -2.0]], FLAT_BASE, APART),
        ("edges in line, a gap of an ulp", [[up(4.0), 0.0], [6.0, 0.0], [5.0, -2.0]], FLAT_BASE, APART),
        ("edges in line, over by an ulp", [[down(4.0), 0.0], [6.0, 0.0], [5.0, -2.0]], FLAT_BASE, COPLANAR),
        ("a corner on a corner", [[4.0, 0.0], [6.0, -1.0], [6.0, 1.0]], FLAT_BASE, COPLANAR),
        ("a corner on a corner, diagonal", [[0.0, 0.0], [-1.0, -2.0], [-2.0, -1.0]], FLAT_BASE, COPLANAR),
        ("a corner short of a corner", [[-TINY, 0.0], [-1.0, -2.0], [-2.0, -1.0]], FLAT_BASE, APART),
        ("a corner on an edge", [[2.0, 0.0], [1.0, -2.0], [3.0, -2.0]], FLAT_BASE, COPLANAR),
        ("a corner short of an edge", [[2.0, -TINY], [1.0, -2.0], [3.0, -2.0]], FLAT_BASE, APART),
        ("a corner over an edge", [[2.0, TINY], [1.0, -2.0], [3.0, -2.0]], FLAT_BASE, COPLANAR),
        ("a corner on the longest edge", [[2.0, 2.0], [5.0, 3.0], [3.0, 5.0]], FLAT_BASE, COPLANAR),
        ("a corner short of the longest edge", [[2.0, up(2.0)], [5.0, 3.0], [3.0, 5.0]], FLAT_BASE, APART),
        ("a corner over the longest edge", [[2.0, down(2.0)], [5.0, 3.0], [3.0, 5.0]], FLAT_BASE, COPLANAR),
        ("an edge past a corner", [[3.0, -1.0], [5.0, 1.0], [6.0, -1.0]], FLAT_BASE, COPLANAR),
        ("an edge just past a corner", [[3.0, -1.0], [5.0, down(1.0)], [6.0, -1.0]], FLAT_BASE, APART),
        ("parallel edges, a gap of an ulp", [[0.0, -TINY], [4.0, -TINY], [2.0, -3.0]], FLAT_BASE, APART),
        ("parallel longest edges, a gap", [[5.0, 0.0], [0.0, 5.0], [5.0, 5.0]], FLAT_BASE, APART),
        ("a nearly parallel edge that meets at its end", [[4.0, 0.0], [0.0, up(4.0)], [5.0, 5.0]], FLAT_BASE, COPLANAR),
        ("beside, boxes overlap", [[3.0, 3.0], [4.0, 2.0], [4.0, 4.0]], FLAT_BASE, APART),
        ("beside, boxes share an edge", [[4.0, 1.0], [4.0, 4.0], [6.0, 2.0]], FLAT_BASE, APART),
        ("beside, boxes share a corner", [[4.0, 4.0], [5.0, 4.0], [4.0, 5.0]], FLAT_BASE, APART),
        ("in the notch of an L", [[1.0, 3.5], [3.5, 1.0], [3.5, 3.5]], FLAT_BASE, APART),
        ("a needle inside", [[1.0, 1.0], [2.0, 1.0], [1.5, 1.0 + 1e-12]], FLAT_BASE, COPLANAR),
        ("a needle across", [[-9.0, 1.0], [9.0, 1.0], [0.0, 1.0 + 1e-12]], FLAT_BASE, COPLANAR),
        ("a needle along the longest edge, outside", [[4.0, 0.0], [0.0, 4.0], [2.0, up(2.0)]], FLAT_BASE, COPLANAR),
        ("far away", [[100.0, 0.0], [101.0, 0.0], [100.0, 1.0]], FLAT_BASE, APART),
    ]
}

pub(super) fn add(book: &mut Book) {
    for (name, p, q, answer) in designs() {
        book.add(format!("coplanar: {name}"), flat(p), flat(q), answer);
        // The diagonal upright plane, where nothing rounds either.
        let upright = |t: Flat| -> Triangle { t.map(|[u, v]| [u, u, v]) };
        book.add(format!("coplanar, upright: {name}"), upright(p), upright(q), answer);
        // The plane x + y + z = 0, where sums of neighbours would round.
        if let (Some(p), Some(q)) = (tilted(p), tilted(q)) {
            book.add(format!("coplanar, tilted: {name}"), p, q, answer);
        }
    }
    lifted(book);
}

fn tilted(t: Flat) -> Option<Triangle> {
    let place = |[u, v]: [f64; 2]| -> Option<Point> {
        let sum = u + v;
        (sum - u == v && sum - v == u).then_some([u, v, -sum])
    };
    Some([place(t[0])?, place(t[1])?, place(t[2])?])
}

/// The same, all lifted by the smallest number (apart), or one corner lifted or dipped: a hinge.
fn lifted(book: &mut Book) {
    for (name, p, q, _) in designs().into_iter().filter(|(name, ..)| !name.contains("far")).step_by(3) {
        let (p, q) = (flat(p), flat(q));
        let raised = |z: [f64; 3]| -> Triangle { std::array::from_fn(|i| [p[i][0], p[i][1], z[i]]) };
        book.add(format!("nearly coplanar: {name}, lifted"), raised([TINY; 3]), q, APART);
        book.add_decided(format!("nearly coplanar: {name}, one corner up"), raised([0.0, 0.0, TINY]), q);
        book.add_decided(format!("nearly coplanar: {name}, one corner down"), raised([-f64::EPSILON, 0.0, 0.0]), q);
        book.add_decided(format!("nearly coplanar: {name}, one up, one down"), raised([TINY, 0.0, -TINY]), q);
    }
}
