//! A convex piece of a triangle: where the other surface cuts it, and how it is cut on.

use feeler_core::geometry::vectors::{cross, dot, length, normal, scaled, sub};
use feeler_core::{Aabb, Point, Triangle};

use super::body::Body;
use super::corners::{corner, CornerCache};
use super::distances::{least_bound, Corner, Distances};
use super::outline::{between, Outline, Plane};

/// A convex polygon in a triangle of the one surface, relative to the other body's origin.
#[derive(Debug, Clone)]
pub struct Piece {
    pub corners: Vec<Corner>,
    /// The normal of its triangle; zero where it has none.
    pub normal: Point,
    /// As that of an outline.
    sense: i8,
    /// No point of it is farther from the other surface, metres.
    pub upper: f64,
    /// The triangle that says so.
    pub witness: u32,
    /// Whether mixtures of distances bound it already.
    is_mixed: bool,
    /// How often it was cut.
    generation: u32,
}

impl Piece {
    /// A polygon, each corner with what is closest to it.
    pub fn new(outline: &Outline, body: &Body, cache: &mut CornerCache) -> Option<Piece> {
        let mut corners: Vec<Corner> = Vec::with_capacity(outline.points.len());
        for p in &outline.points {
            let near = corners.last().map(|last| last.nearest);
            corners.push(cache.closest(*p, near.as_slice(), body)?);
        }
        let (normal, upper, witness) = (outline.normal, f64::INFINITY, 0);
        let mut piece = Piece { corners, normal, sense: outline.sense, upper, witness, is_mixed: false, generation: 0 };
        piece.bound(body);
        Some(piece)
    }

    /// Bounds it by the distances to single triangles.
    fn bound(&mut self, body: &Body) {
        let (upper, witness) = least_bound(&self.corners, body);
        (self.upper, self.witness) = (upper.min(self.upper), witness);
    }

    /// Bounds it by the distances to two triangles; whether that is less.
    pub fn mix(&mut self, body: &Body) -> bool {
        if std::mem::replace(&mut self.is_mixed, true) {
            return false;
        }
        let mixed = Distances::new(&self.corners, None, body).mixed();
        let is_less = mixed < self.upper;
        self.upper = mixed.min(self.upper);
        is_less
    }

    /// The box around it.
    pub fn bounds(&self) -> Aabb {
        self.corners.iter().fold(Aabb::EMPTY, |mut around, corner| {
            around.grow(&corner.at);
            around
        })
    }

    /// The farthest of its corners from the other surface.
    pub fn farthest(&self) -> &Corner {
        let mut farthest = &self.corners[0];
        for corner in &self.corners[1..] {
            if corner.distance > farthest.distance {
                farthest = corner;
            }
        }
        farthest
    }

    /// The polygon alone.
    pub fn outline(&self) -> Outline {
        Outline {
            points: self.corners.iter().map(|corner| corner.at).collect(),
            normal: self.normal,
            sense: self.sense,
        }
    }

    /// The two parts on each side of a plane. A part that is nothing but a line is left out.
    pub fn cut(&self, plane: &Plane, body: &Body) -> Vec<Piece> {
        let heights: Vec<f64> = self.corners.iter().map(|corner| plane.height(&corner.at)).collect();
        let count = self.corners.len();
        let mut halves = [Vec::with_capacity(count + 1), Vec::with_capacity(count + 1)];
        for i in 0..count {
            let j = (i + 1) % count;
            let (p, h, k) = (&self.corners[i], heights[i], heights[j]);
            if h >= 0.0 {
                halves[0].push(*p);
            }
            if h <= 0.0 {
                halves[1].push(*p);
            }
            if h * k < 0.0 {
                let (s, q) = (h / (h - k), &self.corners[j]);
                let at = between(&p.at, &q.at, s);
                let near = [plane.nearest().unwrap_or(self.witness), p.nearest, q.nearest];
                let Some(new) = corner(at, &near, body) else { continue };
                halves.iter_mut().for_each(|half| half.push(new));
            }
        }
        let pieces = halves.into_iter().filter(|half| half.len() >= 3).map(|corners| {
            let mut piece = Piece { corners, is_mixed: false, generation: self.generation + 1, ..*self };
            piece.bound(body);
            piece
        });
        pieces.collect()
    }

    /// The plane that best brings down the bound of a piece: where two triangles of the other body are equally far, a side of the
    /// triangle that bounds it, or across its length. Bounds up to `enough` (metres) are of no interest.
    pub fn halving(&self, body: &Body, enough: f64) -> Option<Plane> {
        let distances = Distances::new(&self.corners, Some(self.witness), body);
        let rival = distances.farthest_from(self.witness);
        let size = length(&self.bounds().extent());
        // A cut that leaves nothing to be done on one side is better than one that leaves less on both.
        let mut best = ((false, f64::INFINITY), None);
        let mut consider = |plane: Option<Plane>| {
            let Some((plane, [p, q])) = plane.and_then(|plane| Some((plane, distances.bounds_after(&plane, size)?)))
            else {
                return;
            };
            let new = (p.min(q) > enough, p.max(q));
            if best.1.is_none() || new < best.0 {
                best = (new, Some(plane));
            }
        };
        // Every few cuts without choice, so that no piece gets ever narrower; and as long as it is over many triangles, since a cut along
        // the side of one goes on beyond it.
        let is_local = distances.count() <= MOST_RIVALS && self.corners.len() <= MOST_CORNERS_TO_CHOOSE;
        if self.generation % FORCED != FORCED - 1 && is_local {
            let (witness, other) = (body.triangle(self.witness), body.triangle(rival.nearest));
            if rival.nearest != self.witness {
                consider(self.halfway(witness, other));
            }
            if let Some(n) = normal(witness) {
                for i in 0..3 {
                    let (p, q) = (&witness[i], &witness[(i + 1) % 3]);
                    let side = Plane::through(p, &cross(&sub(q, p), &n));
                    consider(side.filter(|side| side.height(&rival.at) > 0.0));
                }
            }
        }
        consider(self.outline().lengthwise());
        best.1
    }

    /// The plane in which two triangles' planes are equally far, on the side where the piece is.
    fn halfway(&self, t: &Triangle, u: &Triangle) -> Option<Plane> {
        let (m, n) = (normal(t)?, normal(u)?);
        let sum =
            |p: &Point, q: &Point| self.corners.iter().map(|corner| dot(q, &sub(&corner.at, p))).sum::<f64>().signum();
        let (m, n) = (scaled(&m, sum(&t[0], &m)), scaled(&n, sum(&u[0], &n)));
        let across = sub(&m, &n);
        let size = length(&across);
        // Of triangles in nearly one plane it is anywhere.
        (size > 1e-6).then(|| Plane::at(scaled(&across, 1.0 / size), (dot(&m, &t[0]) - dot(&n, &u[0])) / size))
    }
}

/// After how many cuts one goes across the length.
const FORCED: u32 = 8;

/// Near more triangles a piece is cut across its length.
const MOST_RIVALS: usize = 4;

/// With more corners a piece is cut across its length.
const MOST_CORNERS_TO_CHOOSE: usize = 10;
