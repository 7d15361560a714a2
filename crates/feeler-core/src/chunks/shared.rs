//! Repeated shapes in packed pieces: ten thousand bolts are one bolt and ten thousand places.
//!
//! The search compares packed positions, so it finds copies in files of every format. A part is a copy of another one if both have
//! the same triangles, and a rotation and a translation map its corners to those of the other, up to the rounding of float32.

use std::collections::HashMap;

use rayon::prelude::*;

use super::packed::{PackedPiece, PartNumbers};
use crate::constants::{LEAST_SHARED_BYTES, MOST_SHAPES_ALIKE, SHARED_ROUNDING};

/// The vertices of one part in a piece, one after the other, and its triangles.
#[derive(Debug, Clone, Copy)]
struct Segment {
    piece: usize,
    vertex: usize,
    vertices: usize,
    triangle: usize,
    triangles: usize,
    part: u32,
    use_of: Use,
}

/// How a segment is sent.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Use {
    /// As it is.
    Own,
    /// As it is, and others are copies of it.
    Shape(u32),
    /// As a place of a shape.
    Copy(u32, Place),
}

/// Where a copy of a shape lies: its first vertex is `to`, and the differences from it are turned by the rows of `turn`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Place {
    turn: [[f32; 3]; 3],
    to: [f32; 3],
}

/// Which parts of packed pieces are copies of others.
#[derive(Debug)]
pub struct Sharing {
    /// By piece, in order.
    segments: Vec<Vec<Segment>>,
}

/// A piece whose copies are places of shapes, of this piece or one before.
///
/// Expanded, a copy's vertex is `to + turn * (p - first)`, where `p` is that of the shape and `first` the shape's first one; in
/// float64, rounded to float32. That is the packed position but for 2^-22 of the largest coordinate of either.
#[derive(Debug, Clone, PartialEq)]
pub struct SharedPiece {
    /// Kind, vertices, triangles and part of each run. Kind: 0 as it is (the part is without meaning), [`SharedPiece::SHAPE`] + n as it is,
    /// and called shape n; else a copy of shape kind - 1.
    pub runs: Vec<[u32; 4]>,
    /// Of each copy: three rows of `turn`, then `to`.
    pub places: Vec<[f32; 12]>,
    /// Of the runs that are sent as they are.
    pub positions: Vec<[f32; 3]>,
    /// Likewise.
    pub parts: PartNumbers,
    /// Likewise; as places among the positions of the whole piece.
    pub indices: Vec<[u16; 3]>,
}

impl SharedPiece {
    /// Marks a run that is a shape of its own.
    pub const SHAPE: u32 = 1 << 31;
}

impl Sharing {
    /// Finds the copies in all pieces of a mesh; in parallel on the current rayon pool. The first of several pieces is left as it
    /// is: the first picture waits for it alone.
    pub fn find<P: AsRef<PackedPiece> + Sync>(pieces: &[P]) -> Sharing {
        let mut all: Vec<Vec<Segment>> =
            pieces.par_iter().enumerate().map(|(number, piece)| segments(number, piece.as_ref())).collect();
        let mut groups: HashMap<(usize, usize), Vec<(usize, usize)>> = HashMap::new();
        for (piece, segments) in all.iter().enumerate().skip(usize::from(all.len() > 1)) {
            for (at, segment) in segments.iter().enumerate() {
                if 14 * segment.vertices + 6 * segment.triangles >= LEAST_SHARED_BYTES {
                    groups.entry((segment.vertices, segment.triangles)).or_default().push((piece, at));
                }
            }
        }
        let alike: Vec<Vec<Segment>> = groups
            .into_values()
            .filter(|group| group.len() > 1)
            .map(|group| group.into_iter().map(|(piece, at)| all[piece][at]).collect())
            .collect();
        let mut found: Vec<Vec<(Segment, Segment, Place)>> =
            alike.par_iter().map(|group| copies(pieces, group)).collect();
        // Shapes are numbered in the order of the pieces, on any number of threads.
        let mut copies: Vec<_> = found.drain(..).flatten().collect();
        copies.sort_unstable_by_key(|(copy, shape, _)| (shape.piece, shape.vertex, copy.piece, copy.vertex));
        let place = |all: &[Vec<Segment>], s: &Segment| all[s.piece].partition_point(|each| each.vertex < s.vertex);
        let mut shapes = 0;
        let mut last = None;
        for (copy, shape, turned) in copies {
            if last != Some((shape.piece, shape.vertex)) {
                last = Some((shape.piece, shape.vertex));
                let at = place(&all, &shape);
                all[shape.piece][at].use_of = Use::Shape(shapes);
                shapes += 1;
            }
            let at = place(&all, &copy);
            all[copy.piece][at].use_of = Use::Copy(shapes - 1, turned);
        }
        Sharing { segments: all }
    }

    /// Piece `number`, which `find` was given; `None` if it has neither copies nor shapes of others.
    pub fn piece(&self, number: usize, piece: &PackedPiece) -> Option<SharedPiece> {
        let segments = &self.segments[number];
        if segments.iter().all(|segment| segment.use_of == Use::Own) {
            return None;
        }
        let sent = |segment: &&Segment| !matches!(segment.use_of, Use::Copy(..));
        let vertices = segments.iter().filter(sent).map(|segment| segment.vertices).sum();
        let mut shared = SharedPiece {
            runs: Vec::new(),
            places: Vec::new(),
            positions: Vec::with_capacity(vertices),
            parts: match piece.parts {
                PartNumbers::Short(_) => PartNumbers::Short(Vec::with_capacity(vertices)),
                PartNumbers::Long(_) => PartNumbers::Long(Vec::with_capacity(vertices)),
            },
            indices: Vec::new(),
        };
        for segment in segments {
            let (vertices, triangles) = (segment.vertices as u32, segment.triangles as u32);
            let kind = match segment.use_of {
                Use::Own => 0,
                Use::Shape(shape) => SharedPiece::SHAPE + shape,
                Use::Copy(shape, _) => shape + 1,
            };
            match shared.runs.last_mut() {
                Some(last) if kind == 0 && last[0] == 0 => {
                    (last[1], last[2]) = (last[1] + vertices, last[2] + triangles)
                }
                _ => shared.runs.push([kind, vertices, triangles, segment.part]),
            }
            if let Use::Copy(_, Place { turn: [a, b, c], to }) = segment.use_of {
                shared.places.push([a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2], to[0], to[1], to[2]]);
                continue;
            }
            shared.positions.extend_from_slice(&piece.positions[segment.vertex..][..segment.vertices]);
            shared.parts.extend(segment.part, segment.vertices);
            shared.indices.extend_from_slice(&piece.indices[segment.triangle..][..segment.triangles]);
        }
        Some(shared)
    }
}

/// The segments of a piece.
fn segments(number: usize, piece: &PackedPiece) -> Vec<Segment> {
    let mut found = Vec::new();
    let (mut vertex, mut triangle) = (0, 0);
    while vertex < piece.positions.len() {
        let part = piece.parts.get(vertex);
        let mut end = vertex + 1;
        while end < piece.positions.len() && piece.parts.get(end) == part {
            end += 1;
        }
        let first = triangle;
        while triangle < piece.indices.len() && usize::from(piece.indices[triangle][0]) < end {
            triangle += 1;
        }
        let (vertices, triangles) = (end - vertex, triangle - first);
        found.push(Segment { piece: number, vertex, vertices, triangle: first, triangles, part, use_of: Use::Own });
        vertex = end;
    }
    found
}

/// Of segments with as many vertices and triangles: each that is a copy, the one that it is a copy of, and its place.
fn copies<P: AsRef<PackedPiece>>(pieces: &[P], group: &[Segment]) -> Vec<(Segment, Segment, Place)> {
    let mut shapes: HashMap<u64, Vec<(Segment, Corners)>> = HashMap::new();
    let mut found = Vec::new();
    for segment in group {
        let alike = shapes.entry(hash(pieces, segment)).or_default();
        let copied = alike.iter().find_map(|(shape, far)| Some((*shape, place(pieces, shape, far, segment)?)));
        match copied {
            Some((shape, place)) => found.push((*segment, shape, place)),
            None if alike.len() < MOST_SHAPES_ALIKE => alike.push((*segment, Corners::of(positions(pieces, segment)))),
            None => (),
        }
    }
    found
}

/// Three vertices of a shape that are far from each other: the first, the farthest from it, and the farthest from their line.
#[derive(Debug, Clone, Copy)]
struct Corners([usize; 3]);

impl Corners {
    fn of(points: &[[f32; 3]]) -> Corners {
        let farthest = |size: &dyn Fn(&Vector) -> f64| {
            let sizes = points.iter().map(|p| size(&minus(p, &points[0])));
            sizes.enumerate().fold((0, 0.0), |most, each| if each.1 > most.1 { each } else { most }).0
        };
        let one = farthest(&|v| dot(v, v));
        let along = unit(&minus(&points[one], &points[0])).unwrap_or_default();
        let other = farthest(&|v| dot(v, v) - dot(v, &along).powi(2));
        Corners([0, one, other])
    }

    /// Their coordinates.
    fn among(self, points: &[[f32; 3]]) -> [[f32; 3]; 3] {
        self.0.map(|at| points[at])
    }
}

fn positions<'a, P: AsRef<PackedPiece>>(pieces: &'a [P], s: &Segment) -> &'a [[f32; 3]] {
    &pieces[s.piece].as_ref().positions[s.vertex..][..s.vertices]
}

fn indices<'a, P: AsRef<PackedPiece>>(pieces: &'a [P], s: &Segment) -> impl Iterator<Item = [u16; 3]> + 'a {
    let base = s.vertex as u16;
    pieces[s.piece].as_ref().indices[s.triangle..][..s.triangles].iter().map(move |t| t.map(|at| at.wrapping_sub(base)))
}

/// Of the triangles, as places in the segment.
fn hash<P: AsRef<PackedPiece>>(pieces: &[P], segment: &Segment) -> u64 {
    indices(pieces, segment).fold(0x9e37_79b9_7f4a_7c15, |sum: u64, [a, b, c]| {
        let word = u64::from(a) << 32 | u64::from(b) << 16 | u64::from(c);
        (sum.rotate_left(23) ^ word).wrapping_mul(0xff51_afd7_ed55_8ccd)
    })
}

type Vector = [f64; 3];

fn wide(p: &[f32; 3]) -> Vector {
    p.map(f64::from)
}

fn minus(a: &[f32; 3], b: &[f32; 3]) -> Vector {
    std::array::from_fn(|k| f64::from(a[k]) - f64::from(b[k]))
}

fn dot(a: &Vector, b: &Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: &Vector) -> Option<Vector> {
    let length = dot(a, a).sqrt();
    (length > 0.0 && length.is_finite()).then(|| a.map(|x| x / length))
}

/// Where `other` lies as a copy of `shape`; `None` if it is none.
fn place<P: AsRef<PackedPiece>>(pieces: &[P], shape: &Segment, far: &Corners, other: &Segment) -> Option<Place> {
    let (from, to) = (positions(pieces, shape), positions(pieces, other));
    // Three distances distinguish most parts that are not copies but have equally many triangles.
    let (p, q) = (far.among(from), far.among(to));
    let slack = rounding(p.as_flattened()).max(rounding(q.as_flattened()));
    let distance = |points: &[[f32; 3]; 3], a: usize, b: usize| {
        let d = minus(&points[a], &points[b]);
        dot(&d, &d).sqrt()
    };
    if [(0, 1), (0, 2), (1, 2)].iter().any(|(a, b)| (distance(&p, *a, *b) - distance(&q, *a, *b)).abs() > 8.0 * slack) {
        return None;
    }
    let slack = rounding(from.as_flattened()).max(rounding(to.as_flattened()));
    // Most copies are only moved.
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let fitted = fit(from, to, &identity, slack).or_else(|| fit(from, to, &rotation(&p, &q)?, slack))?;
    // A hash is no proof.
    indices(pieces, shape).eq(indices(pieces, other)).then_some(fitted)
}

/// How far vertices with such coordinates may be from their places.
fn rounding(coordinates: &[f32]) -> f64 {
    f64::from(SHARED_ROUNDING * coordinates.iter().fold(0.0f32, |most, x| most.max(x.abs())))
}

/// The place with that rotation, as it is sent, if all vertices are within `slack` of theirs.
fn fit(from: &[[f32; 3]], to: &[[f32; 3]], turn: &[Vector; 3], slack: f64) -> Option<Place> {
    let turn = turn.map(|row| row.map(|x| x as f32));
    let turned = |p: &[f32; 3]| {
        let d = minus(p, &from[0]);
        turn.each_ref().map(|row| dot(&wide(row), &d))
    };
    // The middle of the smallest and the largest remaining difference: it makes the largest error smallest.
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for (p, q) in from.iter().zip(to) {
        let there = turned(p);
        for k in 0..3 {
            let rest = f64::from(q[k]) - there[k];
            (low[k], high[k]) = (low[k].min(rest), high[k].max(rest));
            if high[k] - low[k] > 2.0 * slack {
                return None;
            }
        }
    }
    let place = Place { turn, to: std::array::from_fn(|k| (0.5 * (low[k] + high[k])) as f32) };
    let is_near = |(p, q): (&[f32; 3], &[f32; 3])| {
        let there = turned(p);
        (0..3).all(|k| {
            let made = (f64::from(place.to[k]) + there[k]) as f32;
            (f64::from(made) - f64::from(q[k])).abs() <= slack
        })
    };
    from.iter().zip(to).all(is_near).then_some(place)
}

/// The rotation that takes three vertices to three others; `None` if they are on a line.
fn rotation(from: &[[f32; 3]; 3], to: &[[f32; 3]; 3]) -> Option<[Vector; 3]> {
    let frame = |points: &[[f32; 3]; 3]| {
        let x = unit(&minus(&points[1], &points[0]))?;
        let z = unit(&cross(&x, &minus(&points[2], &points[0])))?;
        Some([x, cross(&z, &x), z])
    };
    let (f, g) = (frame(from)?, frame(to)?);
    Some(std::array::from_fn(|row| std::array::from_fn(|column| (0..3).map(|k| g[k][row] * f[k][column]).sum())))
}
