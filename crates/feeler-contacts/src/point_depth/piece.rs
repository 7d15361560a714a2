//! A convex piece of a triangle: where the other surface cuts it, and how it is split further.

use feeler_core::geometry::vectors::{cross, dot, length, precise_normal, scaled, sub};
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
    /// The triangle that shows it.
    pub witness: u32,
    /// Whether mixtures of distances bound it already.
    is_mixed: bool,
    /// How often it was cut.
    generation: u32,
}

impl Piece {
    /// A polygon, each corner with its closest point.
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
            if let Some(n) = precise_normal(witness) {
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
        let (m, n) = (precise_normal(t)?, precise_normal(u)?);
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

#[cfg(test)]
mod tests {
    use super::super::brute::{body, distance, point_of, triangle};
    use super::*;
    use feeler_core::geometry::vectors::add;
    use feeler_shapes::random::Random;
    use feeler_shapes::soups::arrays_of;
    use feeler_shapes::{ball, box_mesh};

    fn area(points: &[Point]) -> f64 {
        let sum = (1..points.len() - 1)
            .fold([0.0; 3], |sum, i| add(&sum, &cross(&sub(&points[i], &points[0]), &sub(&points[i + 1], &points[0]))));
        0.5 * length(&sum)
    }

    fn piece_in(t: &Triangle, body: &Body) -> Piece {
        let outline = Outline::clipped(t, -1, None).unwrap();
        Piece::new(&outline, body, &mut CornerCache::default()).unwrap()
    }

    fn assert_corners(piece: &Piece, body: &Body) {
        for corner in &piece.corners {
            assert!((corner.distance - distance(body, &corner.at)).abs() < 1e-12);
            assert!((length(&sub(&corner.at, &corner.point)) - corner.distance).abs() < 1e-12);
            assert!(
                (super::super::body::distance_to(&corner.at, body.triangle(corner.nearest)) - corner.distance).abs()
                    < 1e-12
            );
            assert!(corner.distance <= piece.farthest().distance);
        }
    }

    #[test]
    fn parts_keep_the_area_and_know_how_far_their_corners_are() {
        let mut r = Random::new(1);
        for n in 0..300 {
            let body = body(arrays_of((0..1 + r.below(20)).map(|_| triangle(&mut r, 0.4)).collect::<Vec<_>>()));
            let t = triangle(&mut r, 0.5).map(|p| sub(&p, body.origin()));
            let mut pieces = vec![piece_in(&t, &body)];
            for _ in 0..8 {
                let piece = pieces.swap_remove(r.below(pieces.len() as u64) as usize);
                let outline = piece.outline();
                assert_eq!((outline.normal, outline.sense), (precise_normal(&t).unwrap(), -1));
                let through = if n % 2 == 0 { outline.points[0] } else { point_of(&mut r, &outline.points) };
                let plane = Plane::through(&through, &r.point(-1.0, 1.0)).unwrap();
                let parts = piece.cut(&plane, &body);
                let sum: f64 = parts.iter().map(|part| area(&part.outline().points)).sum();
                assert!((sum - area(&outline.points)).abs() < 1e-12);
                for (sense, part) in [1.0, -1.0].iter().zip(&parts).filter(|_| parts.len() == 2) {
                    assert!(part.corners.iter().all(|corner| sense * plane.height(&corner.at) >= -1e-12));
                }
                for part in &parts {
                    assert_corners(part, &body);
                    assert!(part.upper <= piece.upper && part.generation == piece.generation + 1);
                    for _ in 0..20 {
                        let p = point_of(&mut r, &part.outline().points);
                        assert!(distance(&body, &p) <= part.upper + 1e-12);
                    }
                }
                pieces.extend(parts);
            }
        }
    }

    #[test]
    fn mixing_is_tried_once_and_only_brings_down_the_bound() {
        let wall = |x: f64| [[x, -100.0, -100.0], [x, 100.0, -100.0], [x, 0.0, 200.0]];
        let body = body(arrays_of([wall(0.0), wall(2.0)]));
        let mut piece = piece_in(&[[-1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [1.0, 0.0, 0.0]], &body);
        assert!((piece.upper - 2.0).abs() < 1e-12);
        let mut known = Piece { upper: 0.5, ..piece.clone() };
        assert!(piece.mix(&body) && (piece.upper - 1.0).abs() < 1e-9 && !piece.mix(&body));
        // What is known already is not forgotten.
        assert!(!known.mix(&body) && known.upper == 0.5);
        // A plane along a side leaves the whole.
        let along_side = Plane::through(&piece.corners[0].at, &[-1.0, 0.0, 0.0]).unwrap();
        assert_eq!(piece.cut(&along_side, &body).iter().map(|part| part.corners.len()).collect::<Vec<_>>(), [3]);
    }

    #[test]
    fn halving_brings_the_bound_down_to_the_farthest_point() {
        let mut r = Random::new(2);
        let bodies =
            [body(box_mesh([0.0; 3], [2.0, 1.5, 1.0], 1)), body(box_mesh([0.0; 3], [2.0; 3], 4)), body(ball(1.0, 6))];
        let mut steps = Vec::new();
        for n in 0..90 {
            let body = &bodies[n % 3];
            let t = triangle(&mut r, 1.2).map(|p| p.map(|x| x - 0.5));
            let (mut pieces, mut lower) = (vec![piece_in(&t, body)], 0.0f64);
            let mut count = 0;
            loop {
                let most = (0..pieces.len()).max_by(|i, j| pieces[*i].upper.total_cmp(&pieces[*j].upper)).unwrap();
                let mut piece = pieces.swap_remove(most);
                lower = lower.max(piece.farthest().distance);
                if piece.upper <= 1.001 * lower {
                    break;
                }
                count += 1;
                assert!(count < 2000, "{n}: {} {lower}", piece.upper);
                if piece.mix(body) {
                    pieces.push(piece);
                    continue;
                }
                let plane = piece.halving(body, 1.001 * lower).unwrap();
                let parts = piece.cut(&plane, body);
                assert_eq!(parts.len(), 2, "{n}");
                let sizes = parts.iter().map(|part| area(&part.outline().points));
                assert!(sizes.into_iter().all(|size| size > 0.0 && size < area(&piece.outline().points)));
                pieces.extend(parts);
            }
            let sampled = (0..200).map(|_| distance(body, &point_of(&mut r, &t))).fold(0.0, f64::max);
            assert!(sampled <= 1.001 * lower + 1e-12, "{n}: {sampled} {lower}");
            steps.push(count);
        }
        steps.sort_unstable();
        // Many need two cuts, and none many.
        assert!(steps[20] <= 2 && steps[45] <= 15 && steps[89] <= 60, "{steps:?}");
    }

    #[test]
    fn the_plane_halfway_is_as_far_from_both() {
        // Walls at right angles, and beside each other.
        let (floor, wall) =
            ([[0.0; 3], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]], [[0.0; 3], [0.0, 9.0, 0.0], [0.0, 0.0, 9.0]]);
        let body = body(arrays_of([floor, wall]));
        let origin = *body.origin();
        let other_way = |[p, q, r]: Triangle| [p, r, q];
        let moved = |t: &Triangle| t.map(|p| sub(&p, &origin));
        for (t, turned) in [(floor, wall), (other_way(floor), wall), (floor, other_way(wall))] {
            let piece = piece_in(&moved(&[[1.0, 2.0, 1.0], [3.0, 2.0, 1.0], [1.0, 2.0, 4.0]]), &body);
            let plane = piece.halfway(&moved(&t), &moved(&turned)).unwrap();
            assert!(plane.height(&sub(&[2.0, 2.0, 2.0], &origin)).abs() < 1e-12);
            assert!((plane.height(&sub(&[3.0, 2.0, 1.0], &origin)).abs() - 2f64.sqrt()).abs() < 1e-12);
        }
        let piece = piece_in(&moved(&[[1.0, 2.0, 1.0], [3.0, 2.0, 1.0], [1.0, 2.0, 4.0]]), &body);
        assert!(piece.halfway(&moved(&floor), &moved(&floor.map(|p| [p[0] + 1.0, p[1], p[2]]))).is_none());
    }
}
