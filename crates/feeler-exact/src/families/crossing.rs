//! Two planes: where the triangles' passages through the common line overlap, end on each other, or miss; and every way to
//! touch with a corner or an edge.

use feeler_core::{PairKind, Triangle};

use super::book::{mapped, Book, APART, BASE, CROSSING, TINY, TOUCHING};

pub(super) fn add(book: &mut Book) {
    through_the_face(book);
    along_an_edge(book);
    through_a_corner(book);
    corner_contacts(book);
    edges_in_the_plane(book);
    edge_against_edge(book);
    junctions(book);
}

/// How a triangle in a plane v, w passes the line w = 0 from `a` to `b`.
#[derive(Clone, Copy)]
enum Shape {
    /// One corner above, two below.
    LoneAbove,
    /// One corner below, two above.
    LoneBelow,
    /// A corner on the line at `a`, the opposite edge passing at `b`.
    CornerAtStart,
    /// A corner on the line at `b`, the opposite edge passing at `a`.
    CornerAtEnd,
    /// An edge on the line, the third corner above: strictly on one side only.
    EdgeOnLine,
    /// An edge on the line, the third corner below.
    EdgeOnLineBelow,
}

const TWO_SIDED: [(&str, Shape); 4] = [
    ("lone corner above", Shape::LoneAbove),
    ("lone corner below", Shape::LoneBelow),
    ("corner on the line, left", Shape::CornerAtStart),
    ("corner on the line, right", Shape::CornerAtEnd),
];
const ONE_SIDED: [(&str, Shape); 2] =
    [("edge on the line, above", Shape::EdgeOnLine), ("edge on the line, below", Shape::EdgeOnLineBelow)];

impl Shape {
    /// Corners as (along the line, above it). Exact for small multiples of a half.
    fn corners(self, a: f64, b: f64) -> [[f64; 2]; 3] {
        let m = (a + b) / 2.0;
        match self {
            Shape::LoneAbove => [[m, 2.0], [2.0 * a - m, -2.0], [2.0 * b - m, -2.0]],
            Shape::LoneBelow => [[m, -2.0], [2.0 * a - m, 2.0], [2.0 * b - m, 2.0]],
            Shape::CornerAtStart => [[a, 0.0], [b, 2.0], [b, -2.0]],
            Shape::CornerAtEnd => [[b, 0.0], [a, 2.0], [a, -2.0]],
            Shape::EdgeOnLine => [[a, 0.0], [b, 0.0], [m, 2.0]],
            Shape::EdgeOnLineBelow => [[a, 0.0], [b, 0.0], [m, -2.0]],
        }
    }
}

/// Against the face's passage from 0 to `end`: every order of the four ends of two intervals. The flag: more than a point.
fn intervals(end: f64) -> Vec<(&'static str, f64, f64, Option<bool>)> {
    let long = Some(true);
    let point = Some(false);
    vec![
        ("inside", 1.0, end - 1.0, long),
        ("equal", 0.0, end, long),
        ("covering", -1.0, end + 1.0, long),
        ("over the left end", -1.0, 1.0, long),
        ("over the right end", end - 1.0, end + 1.0, long),
        ("from the left end inwards", 0.0, 1.0, long),
        ("from the right end inwards", end - 1.0, end, long),
        ("from the left end and beyond", 0.0, end + 2.0, long),
        ("from beyond to the right end", -2.0, end, long),
        ("up to the left end", -2.0, 0.0, point),
        ("from the right end on", end, end + 2.0, point),
        ("left of it", -3.0, -1.0, None),
        ("right of it", end + 1.0, end + 3.0, None),
    ]
}

fn meeting(overlap: Option<bool>, is_two_sided: bool) -> Option<PairKind> {
    match overlap {
        Some(true) if is_two_sided => CROSSING,
        Some(_) => TOUCHING,
        None => APART,
    }
}

/// The common line is y = 1, z = 0: through two edges of the base, from x = 0 to x = 3.
fn through_the_face(book: &mut Book) {
    let stand = |c: [[f64; 2]; 3]| -> Triangle { c.map(|[v, w]| [v, 1.0, w]) };
    for (list, is_two_sided) in [(&TWO_SIDED[..], true), (&ONE_SIDED[..], false)] {
        for (shape_name, shape) in list {
            for (name, a, b, overlap) in intervals(3.0) {
                let p = stand(shape.corners(a, b));
                book.add(format!("face: {shape_name}, {name}"), p, BASE, meeting(overlap, is_two_sided));
            }
        }
    }
    // One neighbour short of an end, and one over it.
    let ends = [
        ("one ulp short of the left end", -2.0, -TINY, None),
        ("one ulp over the left end", -2.0, TINY, Some(true)),
        ("one ulp short of the right end", 3f64.next_up(), 5.0, None),
        ("one ulp over the right end", 3f64.next_down(), 5.0, Some(true)),
        ("one ulp long, inside", 1.0, 1f64.next_up(), Some(true)),
        ("one ulp long, up to the right end", 3f64.next_down(), 3.0, Some(true)),
    ];
    for (shape_name, shape, is_two_sided) in [
        ("corner on the line, left", Shape::CornerAtStart, true),
        ("corner on the line, right", Shape::CornerAtEnd, true),
        ("edge on the line, above", Shape::EdgeOnLine, false),
    ] {
        for (name, a, b, overlap) in ends {
            let p = stand(shape.corners(a, b));
            book.add(format!("face: {shape_name}, {name}"), p, BASE, meeting(overlap, is_two_sided));
        }
    }
    // The same in a slanted plane: y = 1 + z.
    for (name, a, b, overlap) in intervals(3.0) {
        let p = Shape::LoneAbove.corners(a, b).map(|[v, w]| [v, 1.0 + w, w]);
        book.add(format!("face: slanted, {name}"), p, BASE, meeting(overlap, true));
    }
}

/// The common line is the base's edge y = 0, z = 0: the base is on one side of the other's plane, so nothing crosses.
fn along_an_edge(book: &mut Book) {
    for (shape_name, shape) in TWO_SIDED.iter().chain(&ONE_SIDED) {
        for (name, a, b, overlap) in intervals(4.0) {
            let p = shape.corners(a, b).map(|[v, w]| [v, 0.0, w]);
            book.add(format!("along an edge: {shape_name}, {name}"), p, BASE, meeting(overlap, false));
        }
    }
}

fn through_a_corner(book: &mut Book) {
    // The plane x = y: through the corner at the origin and the middle of the edge across, where s runs from 0 to 2.
    for (shape_name, shape) in &TWO_SIDED[..3] {
        for (name, a, b, overlap) in intervals(2.0).into_iter().filter(|(name, ..)| *name != "inside") {
            let p = shape.corners(a, b).map(|[v, w]| [v, v, w]);
            book.add(format!("through a corner: {shape_name}, {name}"), p, BASE, meeting(overlap, true));
        }
    }
    // The plane x = -y meets the base at that corner only.
    for (shape_name, shape) in TWO_SIDED.iter().chain(&ONE_SIDED) {
        for (name, a, b, overlap) in [
            ("across it", -1.0, 1.0, Some(false)),
            ("up to it", -2.0, 0.0, Some(false)),
            ("from it on", 0.0, 2.0, Some(false)),
            ("beside it", 1.0, 2.0, None),
        ] {
            let p = shape.corners(a, b).map(|[v, w]| [v, -v, w]);
            book.add(format!("at a corner: {shape_name}, {name}"), p, BASE, meeting(overlap, false));
        }
    }
}

/// A corner on the base, the rest above; lifted off and dipped in by the smallest number and by the last bit of one.
fn corner_contacts(book: &mut Book) {
    let places = [
        ("on the face", 1.0, 1.0, true),
        ("on an edge", 2.0, 0.0, true),
        ("on another edge", 0.0, 3.0, true),
        ("on the longest edge", 2.0, 2.0, true),
        ("on a corner", 0.0, 0.0, true),
        ("on the second corner", 4.0, 0.0, true),
        ("on the third corner", 0.0, 4.0, true),
        ("beside, in line with an edge", 5.0, 0.0, false),
        ("beside, across the longest edge", 3.0, 3.0, false),
        ("beside an edge", 1.0, -1.0, false),
    ];
    for (name, x, y, is_on) in places {
        let p = |z: f64| [[x, y, z], [x + 1.0, y + 2.0, 3.0], [x - 1.0, y + 1.0, 3.0]];
        book.add(format!("corner {name}"), p(0.0), BASE, if is_on { TOUCHING } else { APART });
        book.add(format!("corner {name}: lifted by the smallest number"), p(TINY), BASE, APART);
        book.add(format!("corner {name}: lifted by a last bit"), p(f64::EPSILON), BASE, APART);
        book.add_decided(format!("corner {name}: dipped by the smallest number"), p(-TINY), BASE);
        book.add_decided(format!("corner {name}: dipped by a last bit"), p(-f64::EPSILON), BASE);
        book.add_decided(format!("corner {name}: dipped by one"), p(-1.0), BASE);
    }
    // Moved off the edge by one neighbour, and back over it.
    for (name, x, y, answer) in [
        ("just inside an edge", 2.0, TINY, TOUCHING),
        ("just outside an edge", 2.0, -TINY, APART),
        ("just inside the longest edge", 2.0, 2f64.next_down(), TOUCHING),
        ("just outside the longest edge", 2.0, 2f64.next_up(), APART),
        ("just outside a corner", -TINY, -TINY, APART),
        ("just past a corner", 4f64.next_up(), 0.0, APART),
        ("just before a corner", 4f64.next_down(), 0.0, TOUCHING),
    ] {
        book.add(
            format!("corner {name}"),
            [[x, y, 0.0], [x + 1.0, y + 2.0, 3.0], [x - 1.0, y + 1.0, 3.0]],
            BASE,
            answer,
        );
    }
    // Both triangles change places: a corner of the base on the other's face, edge and corner.
    for (name, p, answer) in [
        ("from below, on the face", [[4.0, -1.0, -1.0], [4.0, 1.0, -1.0], [4.0, 0.0, 2.0]], TOUCHING),
        ("on an edge", [[4.0, 0.0, -1.0], [4.0, 0.0, 1.0], [6.0, 0.0, 0.0]], TOUCHING),
        ("on an edge, slanted", [[3.0, -1.0, -1.0], [5.0, 1.0, 1.0], [6.0, 0.0, 0.0]], TOUCHING),
        ("beside the face", [[4.0, 1.0, -1.0], [4.0, 3.0, -1.0], [4.0, 2.0, 2.0]], APART),
        (
            "one ulp before the face",
            [-1.0, 1.0, 0.0].map(|y| [4f64.next_up(), y, if y == 0.0 { 2.0 } else { -1.0 }]),
            APART,
        ),
        (
            "one ulp through the face",
            [-1.0, 1.0, 0.0].map(|y| [4f64.next_down(), y, if y == 0.0 { 2.0 } else { -1.0 }]),
            CROSSING,
        ),
    ] {
        book.add(format!("corner of the second: {name}"), p, BASE, answer);
    }
}

/// An edge in the base's plane, the third corner above; then all lifted, and one end dipped.
fn edges_in_the_plane(book: &mut Book) {
    for (name, a, b, answer) in [
        ("inside the face", [1.0, 1.0], [2.0, 1.0], TOUCHING),
        ("right across", [-1.0, 1.0], [5.0, 1.0], TOUCHING),
        ("from outside in", [-1.0, 1.0], [1.0, 1.0], TOUCHING),
        ("up to an edge from outside", [-1.0, 1.0], [0.0, 1.0], TOUCHING),
        ("up to an edge from inside", [0.0, 1.0], [1.0, 1.0], TOUCHING),
        ("the whole edge", [0.0, 0.0], [4.0, 0.0], TOUCHING),
        ("the whole edge, turned round", [4.0, 0.0], [0.0, 0.0], TOUCHING),
        ("a part of an edge", [1.0, 0.0], [2.0, 0.0], TOUCHING),
        ("more than an edge", [-1.0, 0.0], [5.0, 0.0], TOUCHING),
        ("over the end of an edge", [3.0, 0.0], [5.0, 0.0], TOUCHING),
        ("end to end in line", [4.0, 0.0], [6.0, 0.0], TOUCHING),
        ("a gap in line", [5.0, 0.0], [6.0, 0.0], APART),
        ("past a corner", [-1.0, 1.0], [1.0, -1.0], TOUCHING),
        ("just past a corner", [-1.0, 1f64.next_down()], [1.0, -1.0], APART),
        ("the longest edge", [4.0, 0.0], [0.0, 4.0], TOUCHING),
        ("along the longest edge", [3.0, 1.0], [1.0, 3.0], TOUCHING),
        ("beside the longest edge", [4.0, 1.0], [1.0, 4.0], APART),
        ("beside an edge by the smallest number", [0.0, -TINY], [4.0, -TINY], APART),
    ] {
        let p = |low: f64, high: f64| [[a[0], a[1], low], [b[0], b[1], high], [1.0, 2.0, 3.0]];
        book.add(format!("edge in the plane: {name}"), p(0.0, 0.0), BASE, answer);
        book.add(format!("edge in the plane: {name}, lifted"), p(TINY, TINY), BASE, APART);
        book.add_decided(format!("edge in the plane: {name}, one end dipped"), p(-TINY, 0.0), BASE);
        book.add_decided(format!("edge in the plane: {name}, dipped"), p(-f64::EPSILON, -f64::EPSILON), BASE);
    }
}

/// Two skew edges through one point, then one neighbour apart and one neighbour in.
fn edge_against_edge(book: &mut Book) {
    for (name, x, third) in [
        ("upright", 2.0, [2.0, -3.0, 0.0]),
        ("upright, near the end", 3.5, [3.5, -3.0, 0.0]),
        ("upright, third corner above", 2.0, [2.0, -3.0, 5.0]),
        ("upright, third corner below", 1.0, [1.0, -3.0, -5.0]),
        ("twisted", 2.0, [3.0, -3.0, 1.0]),
    ] {
        let p = |y: f64| [[x, y, -1.0], [x, y, 1.0], third];
        book.add(format!("edge on edge: {name}"), p(0.0), BASE, TOUCHING);
        book.add(format!("edge on edge: {name}, a gap"), p(-TINY), BASE, APART);
        book.add(format!("edge on edge: {name}, in by the smallest number"), p(TINY), BASE, CROSSING);
        book.add(format!("edge on edge: {name}, in by one"), p(1.0), BASE, CROSSING);
    }
    for (name, s, answer) in [
        ("on the longest edge", 2.0, TOUCHING),
        ("a gap to the longest edge", 2f64.next_up(), APART),
        ("in the longest edge by an ulp", 2f64.next_down(), CROSSING),
    ] {
        book.add(format!("edge on edge: {name}"), [[s, s, -1.0], [s, s, 1.0], [5.0, 5.0, 0.0]], BASE, answer);
    }
    // A leaning edge over the base's edge: rounding happens in the middle of it.
    for (name, x, y) in [("leaning", 0.3, 0.7), ("leaning more", 0.1, 1.9), ("leaning far", 1e-3, 1e3)] {
        for (word, third) in [("outside", -3.0), ("far outside", -1e9)] {
            let p = [[1.0 - x, -y, -0.1], [1.0 + x, y, 0.1], [1.0, third, 0.0]];
            book.add_decided(format!("edge on edge: {name}, third corner {word}"), p, BASE);
        }
    }
}

/// What meshes do: neighbours in a solid, a corner in the middle of an edge, plates on plates.
fn junctions(book: &mut Book) {
    let wall: Triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 4.0]];
    book.add("junction: floor and wall share an edge", wall, BASE, TOUCHING);
    book.add("junction: floor and wall, half an edge each", mapped(wall, |[x, y, z]| [x + 2.0, y, z]), BASE, TOUCHING);
    book.add("junction: floor and wall, corner to corner", mapped(wall, |[x, y, z]| [x + 4.0, y, z]), BASE, TOUCHING);
    book.add("junction: a wall on the floor", mapped(wall, |[x, y, z]| [x, y + 1.0, z]), BASE, TOUCHING);
    book.add("junction: a wall through the floor", mapped(wall, |[x, y, z]| [x, y + 1.0, z - 1.0]), BASE, CROSSING);
    book.add("junction: a wall hangs from the floor", mapped(wall, |[x, y, z]| [x, y + 1.0, -z]), BASE, TOUCHING);
    let fan: Triangle = [[2.0, 0.0, 0.0], [3.0, -2.0, 1.0], [1.0, -2.0, 1.0]];
    book.add("junction: a corner in the middle of an edge", fan, BASE, TOUCHING);
    book.add("junction: a corner short of the edge", mapped(fan, |[x, y, z]| [x, y - 1e-9, z]), BASE, APART);
    book.add_decided("junction: a corner over the edge", mapped(fan, |[x, y, z]| [x, y + 1e-9, z]), BASE);
    book.add(
        "junction: three thirds of an edge",
        [[4.0 / 3.0, 0.0, 0.0], [8.0 / 3.0, 0.0, 0.0], [2.0, 0.0, 1.0]],
        BASE,
        TOUCHING,
    );
    // A third of the longest edge rounds to one side of it or the other.
    for (name, share) in [("a third", 1.0 / 3.0), ("a tenth", 0.1), ("three tenths", 0.3), ("two thirds", 2.0 / 3.0)] {
        let on = [4.0 * share, 4.0 - 4.0 * share, 0.0];
        let p = [on, [on[0] + 1.0, on[1] + 1.0, 1.0], [on[0] + 2.0, on[1] + 1.0, -1.0]];
        book.add_decided(format!("junction: {name} along the longest edge"), p, BASE);
        let longest: Triangle = [[0.1, 0.2, 0.3], [0.7, 1.1, 0.5], [0.3, 0.1, 1.3]];
        let middle: [f64; 3] = std::array::from_fn(|a| longest[0][a] + share * (longest[1][a] - longest[0][a]));
        let p = [
            middle,
            [middle[0] + 1.0, middle[1] - 1.0, middle[2] - 1.0],
            [middle[0], middle[1] - 1.0, middle[2] - 2.0],
        ];
        book.add_decided(format!("junction: {name} along a decimal edge"), p, longest);
    }
}
