//! Scenes of all kinds of contact for the golden hashes, the same on every machine: whole numbers, rotations by 3-4-5 triangles and
//! correctly rounded operations only, since sine and cosine differ between platforms.

use crate::random::Random;
use crate::soups::{arrays_of, lattice, needles, soup};
use crate::{Arrays, Matrix, Point};

/// Parts of each mock-up.
const PARTS: usize = 5;

/// A mock-up, a tool, and poses at which they collide or nearly do.
#[derive(Debug, Clone)]
pub struct Case {
    /// Its name.
    pub name: &'static str,
    /// The mock-up.
    pub mockup: Arrays,
    /// The part of each of its faces.
    pub part_of_face: Vec<u32>,
    /// Number of parts.
    pub parts: usize,
    /// The tool, in its own frame.
    pub tool: Arrays,
    /// `world_from_tool`.
    pub poses: Vec<Matrix>,
}

impl Case {
    fn new(name: &'static str, mockup: Vec<[Point; 3]>, tool: Vec<[Point; 3]>, poses: Vec<Matrix>) -> Case {
        let mockup = arrays_of(mockup);
        let part_of_face = (0..mockup.1.len()).map(|i| (i * 7 / 3 % PARTS) as u32).collect();
        Case { name, mockup, part_of_face, parts: PARTS, tool: arrays_of(tool), poses }
    }
}

/// About the z, y or x axis by the angle of a 3-4-5 triangle, or a quarter turn, then moved.
fn turned(axis: usize, [c, s]: [f64; 2], t: Point) -> Matrix {
    let (u, v) = ([1, 2, 0][axis], [2, 0, 1][axis]);
    let mut m = [[0.0; 4]; 4];
    (m[axis][axis], m[3][3]) = (1.0, 1.0);
    (m[u][u], m[u][v], m[v][u], m[v][v]) = (c, -s, s, c);
    for i in 0..3 {
        m[i][3] = t[i];
    }
    m
}

/// A motion without a turn.
fn moved(by: Point) -> Matrix {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            if i == j {
                1.0
            } else if j == 3 {
                by[i]
            } else {
                0.0
            }
        })
    })
}

/// Every operation rounded once, as poses are applied.
fn applied(m: &Matrix, [x, y, z]: Point) -> Point {
    std::array::from_fn(|a| ((m[a][0] * x + m[a][1] * y) + m[a][2] * z) + m[a][3])
}

const THREE_FOUR_FIVE: [f64; 2] = [0.8, 0.6];
const FIVE_TWELVE: [f64; 2] = [5.0 / 13.0, 12.0 / 13.0];
const QUARTER: [f64; 2] = [0.0, 1.0];

/// Points of a circle at rational places `((1 - t^2) / (1 + t^2), 2 t / (1 + t^2))`: `4 n` of them.
fn circle(n: u32, radius: f64) -> Vec<[f64; 2]> {
    let quarter: Vec<[f64; 2]> = (0..n)
        .map(|i| {
            let t = f64::from(i) / f64::from(n);
            [radius * (1.0 - t * t) / (1.0 + t * t), radius * (2.0 * t) / (1.0 + t * t)]
        })
        .collect();
    let turn = |k: usize, [x, y]: [f64; 2]| [[x, y], [-y, x], [-x, -y], [y, -x]][k];
    (0..4).flat_map(|k| quarter.iter().map(move |p| turn(k, *p))).collect()
}

/// A solid between two heights around the z axis; with a hole when the inner outline is not empty.
fn tube(outer: &[[f64; 2]], inner: &[[f64; 2]], low: f64, high: f64) -> Vec<[Point; 3]> {
    let n = outer.len();
    let at = |p: [f64; 2], z: f64| -> Point { [p[0], p[1], z] };
    let mut triangles = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        let mut quad = |a: Point, b: Point, c: Point, d: Point| triangles.extend([[a, b, c], [a, c, d]]);
        quad(at(outer[i], low), at(outer[j], low), at(outer[j], high), at(outer[i], high));
        if inner.is_empty() {
            triangles.push([at([0.0; 2], high), at(outer[i], high), at(outer[j], high)]);
            triangles.push([at([0.0; 2], low), at(outer[j], low), at(outer[i], low)]);
        } else {
            quad(at(inner[j], low), at(inner[i], low), at(inner[i], high), at(inner[j], high));
            quad(at(outer[i], high), at(outer[j], high), at(inner[j], high), at(inner[i], high));
            quad(at(outer[j], low), at(outer[i], low), at(inner[i], low), at(inner[j], low));
        }
    }
    triangles
}

fn gear(n: u32) -> Vec<[Point; 3]> {
    let (tip, root) = (circle(n, 1.25), circle(n, 1.0));
    let outline: Vec<[f64; 2]> = (0..tip.len()).map(|i| if i % 4 < 2 { tip[i] } else { root[i] }).collect();
    tube(&outline, &circle(n, 0.5), 0.0, 0.5)
}

fn cuboid(low: Point, size: f64) -> Vec<[Point; 3]> {
    let [x, y, z] = low;
    tube(&[[x, y], [x + size, y], [x + size, y + size], [x, y + size]], &[], z, z + size)
}

/// The scenes.
pub fn cases() -> Vec<Case> {
    // A crooked place in the world: 3-4-5 about two axes, then moved by numbers with all their bits.
    let world = turned(0, FIVE_TWELVE, [0.1, 0.7, 1.3]);
    let placed = |triangles: &[[Point; 3]], by: &Matrix| -> Vec<[Point; 3]> {
        triangles.iter().map(|t| t.map(|p| applied(by, p))).collect()
    };
    let (hole, pin) = (tube(&circle(8, 2.0), &circle(8, 1.0), 0.0, 1.0), tube(&circle(8, 1.0), &[], 0.0, 1.0));
    let pile: Vec<[Point; 3]> =
        (0..27u8).flat_map(|i| cuboid([i % 3, i / 3 % 3, i / 9].map(|x| f64::from(x) * 0.3), 0.3)).collect();
    let soup_of = |seed: u64, count: usize, size: f64| -> Vec<[Point; 3]> {
        let (vertices, faces) = soup(seed, count, size);
        faces.iter().map(|f| f.map(|i| vertices[i as usize])).collect()
    };
    let lattice_of = |seed: u64, count: usize, side: u64| -> Vec<[Point; 3]> {
        let (vertices, faces) = lattice(seed, count, side);
        faces.iter().map(|f| f.map(|i| vertices[i as usize])).collect()
    };
    let needles_of = |seed: u64, count: usize| -> Vec<[Point; 3]> {
        let (vertices, faces) = needles(seed, count, 1e-3);
        faces.iter().map(|f| f.map(|i| vertices[i as usize])).collect()
    };
    let mut r = Random::new(11);
    vec![
        Case::new(
            "pin in a hole",
            placed(&hole, &world),
            pin,
            vec![
                world,
                turned(0, FIVE_TWELVE, [0.1, 0.7, 1.3f64.next_up()]),
                turned(0, THREE_FOUR_FIVE, [0.1, 0.7, 1.3]),
                turned(0, FIVE_TWELVE, [0.1, 0.2, 1.0]),
                turned(2, QUARTER, [0.1, 0.7, 1.3]),
            ],
        ),
        Case::new(
            "gears in mesh",
            gear(6),
            gear(6),
            vec![
                moved([2.25, 0.0, 0.0]),
                turned(2, QUARTER, [2.25, 0.0, 0.0]),
                turned(2, THREE_FOUR_FIVE, [0.0, 2.25, 0.5]),
                turned(2, FIVE_TWELVE, [0.0, 2.25, 0.0]),
                moved([0.0; 3]),
            ],
        ),
        Case::new(
            "boxes",
            pile,
            cuboid([0.0; 3], 0.3),
            vec![
                moved([0.3, 0.3, 0.9]),
                moved([0.3 + 0.3, 0.3, 0.3]),
                moved([0.15, 0.45, 0.3]),
                turned(1, QUARTER, [0.6, 0.0, 0.3]),
                turned(2, THREE_FOUR_FIVE, [0.3, 0.3, 0.3]),
            ],
        ),
        Case::new(
            "soup",
            soup_of(1, 400, 0.08),
            soup_of(2, 80, 0.08),
            (0..8).map(|i| turned(i % 3, [THREE_FOUR_FIVE, FIVE_TWELVE][i % 2], r.point(-0.3, 0.3))).collect(),
        ),
        Case::new(
            "lattice",
            lattice_of(5, 300, 6),
            lattice_of(6, 60, 4),
            (0..6).map(|_| r.lattice_motion(2)).collect(),
        ),
        Case::new(
            "needles",
            needles_of(7, 120),
            needles_of(8, 40),
            (0..4).map(|i| turned(i % 3, THREE_FOUR_FIVE, r.point(-0.1, 0.4))).collect(),
        ),
    ]
}
