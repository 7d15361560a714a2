//! The smooth surface behind a mesh, near a point of it: its normal and curvature there, or the presence of a real
//! edge.
//!
//! Normals are interpolated over a triangle from those at its corners (Phong 1975), which are means over the smooth fan
//! around each corner, weighted by angles; a flat face beside a fillet keeps its own normal there, and the fillet takes
//! it over.
//! Computed on demand from some dozens of triangles around: nothing is stored for a mock-up.

use feeler_core::geometry::vectors::{add, cross, dot, length, normal, scaled, sub, unit};
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_core::{Point, Triangle};

use crate::constants::{
    BEND_LIKENESS, EDGE_SHARE, FLAT_BEND, LARGEST_BULGE_M, LARGEST_FAN, LARGEST_FLAT_WALK, LARGEST_SMOOTH_BEND,
    LIKE_WIDTHS, PARALLEL_COSINE,
};

/// Bends of a surface, a symmetric matrix in the two directions of a plane: `[xx, xy, yy]`, one over metres. Positive where it is convex.
pub(crate) type Curvature = [f64; 3];

/// A surface at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SurfacePoint {
    /// Unit, outward.
    pub normal: Point,
    /// `None`: the point is on a real edge or corner.
    pub curvature: Option<Curvature>,
    /// How far the smooth surface stands out of the triangle here, metres; negative where it is hollow.
    pub height: f64,
    /// The same where it is most, metres.
    pub bulge: f64,
}

/// A straight piece of a real edge, seen from a point on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Edge {
    /// Unit.
    pub direction: Point,
    /// How far it goes on against the direction, and along it, metres.
    pub ends: [f64; 2],
}

/// A mesh with its topology, placed in the world by `triangle`.
pub(crate) struct Surface<'a, F> {
    pub adjacency: &'a Adjacency,
    pub triangle: F,
}

/// A triangle as seen from another that it is connected with: its normal is to the same side.
#[derive(Debug, Clone, Copy)]
struct Facet {
    id: u32,
    corners: Triangle,
    normal: Point,
    /// The normal by the winding times this.
    sense: f64,
}

impl<F: Fn(u32) -> Triangle> Surface<'_, F> {
    /// The surface at a point on a triangle; `outward`: roughly, where the winding does not tell; `directions`: of the curvature, across
    /// `outward`. `None` where the triangle says nothing: it is a sliver, or its normal is far from `outward`.
    pub fn at(&self, triangle: u32, point: &Point, outward: &Point, directions: &[Point; 2]) -> Option<SurfacePoint> {
        let facet = self.first(triangle, outward)?;
        let shares = shares_of(&facet, point)?;
        let mut normals = [[0.0; 3]; 3];
        let mut is_edge = false;
        for k in 0..3 {
            let (mean, is_whole) = self.corner_normal(&facet, k);
            normals[k] = unit(&mean)?;
            let is_at_corner = shares[(k + 1) % 3].max(shares[(k + 2) % 3]) <= EDGE_SHARE;
            let is_on_side = shares[(k + 2) % 3] <= EDGE_SHARE;
            is_edge |= is_at_corner && !is_whole;
            is_edge |= is_on_side && !self.is_smooth_side(&facet, k);
        }
        let mean = (0..3).fold([0.0; 3], |sum, k| add(&sum, &scaled(&normals[k], shares[k])));
        let curvature = if is_edge { None } else { Some(bends(&facet.corners, &normals, directions)?) };
        // An arc over a side: an eighth of the side times the turn of its normal.
        let arcs = [[0, 1], [1, 2], [2, 0]]
            .map(|[k, l]| 0.5 * dot(&sub(&normals[l], &normals[k]), &sub(&facet.corners[l], &facet.corners[k])));
        let bulge = 0.25 * arcs.iter().fold(0.0, |most: f64, arc| if arc.abs() > most.abs() { *arc } else { most });
        let height =
            arcs[0] * shares[0] * shares[1] + arcs[1] * shares[1] * shares[2] + arcs[2] * shares[2] * shares[0];
        Some(SurfacePoint { normal: unit(&mean)?, curvature, height, bulge })
    }

    /// The real edges that a point on a triangle is on, as far as the triangle has them.
    pub fn edges(&self, triangle: u32, point: &Point, outward: &Point) -> [Option<Edge>; 2] {
        let mut edges = [None; 2];
        let Some(facet) = self.facet(triangle, outward) else { return edges };
        let Some(shares) = shares_of(&facet, point) else { return edges };
        let on = (0..3).filter(|k| shares[(k + 2) % 3] <= EDGE_SHARE && !self.is_smooth_side(&facet, *k));
        for (edge, k) in edges.iter_mut().zip(on) {
            let side = side_of(&facet, k);
            let size = length(&side);
            let ends = [shares[(k + 1) % 3] * size, shares[k] * size];
            *edge = unit(&side).map(|direction| Edge { direction, ends });
        }
        edges
    }

    fn first(&self, id: u32, outward: &Point) -> Option<Facet> {
        // A normal that far off is of a triangle that the contact meets with its rim only.
        self.facet(id, outward).filter(|facet| dot(&facet.normal, outward) > LARGEST_SMOOTH_BEND.cos())
    }

    fn facet(&self, id: u32, outward: &Point) -> Option<Facet> {
        let corners = (self.triangle)(id);
        let own = normal(&corners)?;
        let sense = match self.adjacency.outward[id as usize] {
            0 => dot(&own, outward).signum(),
            known => f64::from(known),
        };
        Some(Facet { id, corners, normal: scaled(&own, sense), sense })
    }

    /// The triangle across the side from corner `k` to the next, and which of its sides that is.
    fn across(&self, facet: &Facet, k: usize) -> Option<(Facet, usize)> {
        let id = self.adjacency.neighbours[facet.id as usize][k];
        let ends = *self.adjacency.neighbours.get(id as usize)?;
        let corners = (self.triangle)(id);
        let (from, to) = (&facet.corners[k], &facet.corners[(k + 1) % 3]);
        let off = |p: &Point, q: &Point| {
            let way = sub(p, q);
            dot(&way, &way)
        };
        // How far a side is from this one, run against it and along it.
        let against = |l: usize| off(&corners[l], to) + off(&corners[(l + 1) % 3], from);
        let along = |l: usize| off(&corners[l], from) + off(&corners[(l + 1) % 3], to);
        let nearest = |a: &usize, b: &usize| against(*a).min(along(*a)).total_cmp(&against(*b).min(along(*b)));
        let l = (0..3).filter(|l| ends[*l] == facet.id).min_by(nearest).or_else(|| (0..3).min_by(nearest))?;
        let sense = if against(l) <= along(l) { facet.sense } else { -facet.sense };
        Some((Facet { id, corners, normal: scaled(&normal(&corners)?, sense), sense }, l))
    }

    /// The mean of the normals of the smooth fan around a corner, as long as it comes, and whether the fan is closed.
    fn corner_normal(&self, facet: &Facet, corner: usize) -> (Point, bool) {
        let at = facet.corners[corner];
        let mut fan = Fan::of(facet, corner);
        for first_side in [corner, (corner + 2) % 3] {
            let (mut facet_now, mut side) = (*facet, first_side);
            for step in 0.. {
                let Some((next, back)) = self.across(&facet_now, side) else { break };
                let Some(flatter) = self.smooth(&facet_now, side, &next, back).filter(|_| step < LARGEST_FAN) else {
                    break;
                };
                match flatter {
                    Flatter::This => fan.add_flat(&facet_now),
                    Flatter::Next => fan.add_flat(&next),
                    Flatter::Neither => {}
                }
                if next.id == facet.id {
                    return (fan.mean(), true);
                }
                let [p, q] = [back, (back + 1) % 3];
                let is_first = length(&sub(&next.corners[p], &at)) <= length(&sub(&next.corners[q], &at));
                let own = if is_first { p } else { q };
                fan.add(&next, own);
                side = if own == back { (own + 2) % 3 } else { own };
                facet_now = next;
            }
        }
        (fan.mean(), false)
    }

    fn is_smooth_side(&self, facet: &Facet, k: usize) -> bool {
        self.across(facet, k).is_some_and(|(next, l)| self.smooth(facet, k, &next, l).is_some())
    }

    /// Whether the side between two triangles is one of the tessellation and not of the body: it bends little, and beyond one of the two
    /// the surface bends on alike. A roof of two flat faces has a real edge, however flat. If so, which of the two is of a flat face,
    /// much wider than the other one, that the curved surface ends at.
    fn smooth(&self, facet: &Facet, k: usize, next: &Facet, l: usize) -> Option<Flatter> {
        let bend = bend(facet, k, next);
        if bend.abs() <= FLAT_BEND {
            return Some(Flatter::Neither);
        }
        if bend.abs() > LARGEST_SMOOTH_BEND {
            return None;
        }
        let ((own, is_own), (others, is_others)) = (self.bends_on(facet, k, bend), self.bends_on(next, l, bend));
        if !(is_own || is_others) {
            None
        } else if own > LIKE_WIDTHS * others {
            Some(Flatter::This)
        } else if others > LIKE_WIDTHS * own {
            Some(Flatter::Next)
        } else {
            Some(Flatter::Neither)
        }
    }

    /// How wide the flat face of a triangle is across from one of its sides, metres, and whether it ends there with a bend like that
    /// one's, and so near that an arc between the two does not stand out far.
    fn bends_on(&self, facet: &Facet, side: usize, bend_there: f64) -> (f64, bool) {
        let (along, middle) = (side_of(facet, side), middle_of(facet, side));
        let mut faces = [(*facet, side); LARGEST_FLAT_WALK];
        let (mut count, mut done) = (1, 0);
        let (mut width, mut is_like): (f64, bool) = (0.0, false);
        let apart = |p: &Point| {
            let way = sub(p, &facet.corners[side]);
            length(&cross(&way, &along)) / length(&along)
        };
        while done < count {
            let (now, from) = faces[done];
            done += 1;
            width = now.corners.iter().map(apart).fold(width, f64::max);
            for k in (0..3).filter(|k| *k != from) {
                let Some((next, back)) = self.across(&now, k) else { continue };
                let bend = bend(&now, k, &next);
                if bend.abs() <= FLAT_BEND {
                    if count < LARGEST_FLAT_WALK && faces[..count].iter().all(|(face, _)| face.id != next.id) {
                        faces[count] = (next, back);
                        count += 1;
                    }
                    continue;
                }
                let ratio = bend / bend_there;
                let direction = side_of(&now, k);
                let way = sub(&middle_of(&now, k), &middle);
                let beside = dot(&way, &along) / length(&along);
                let across = (dot(&way, &way) - beside * beside).max(0.0).sqrt();
                is_like |= (1.0 / BEND_LIKENESS..=BEND_LIKENESS).contains(&ratio)
                    && bend.abs() <= LARGEST_SMOOTH_BEND
                    && across >= beside.abs()
                    && 0.125 * bend_there.abs() * across <= LARGEST_BULGE_M
                    && dot(&direction, &along).abs() >= PARALLEL_COSINE * length(&direction) * length(&along);
            }
        }
        (width, is_like)
    }
}

fn side_of(facet: &Facet, k: usize) -> Point {
    sub(&facet.corners[(k + 1) % 3], &facet.corners[k])
}

fn middle_of(facet: &Facet, k: usize) -> Point {
    scaled(&add(&facet.corners[k], &facet.corners[(k + 1) % 3]), 0.5)
}

/// Of two triangles beside each other on a smooth surface, the one that is of a flat face where the curved surface ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Flatter {
    This,
    Next,
    Neither,
}

/// The smooth fan around a corner: the sum of its normals times their angles there, and that of its flat faces alone.
struct Fan {
    sum: Point,
    flat: Point,
}

impl Fan {
    fn of(facet: &Facet, corner: usize) -> Fan {
        let mut fan = Fan { sum: [0.0; 3], flat: [0.0; 3] };
        fan.add(facet, corner);
        fan
    }

    fn add(&mut self, facet: &Facet, corner: usize) {
        let [a, b, c] = [0, 1, 2].map(|k| &facet.corners[(corner + k) % 3]);
        let (p, q) = (sub(b, a), sub(c, a));
        let angle = length(&cross(&p, &q)).atan2(dot(&p, &q));
        self.sum = add(&self.sum, &scaled(&facet.normal, angle));
    }

    fn add_flat(&mut self, facet: &Facet) {
        self.flat = add(&self.flat, &facet.normal);
    }

    fn mean(&self) -> Point {
        if self.flat == [0.0; 3] {
            self.sum
        } else {
            self.flat
        }
    }
}

/// The angle between two facets, as the length of its chord; negative where the surface is hollow.
fn bend(facet: &Facet, k: usize, next: &Facet) -> f64 {
    let by = length(&sub(&next.normal, &facet.normal));
    // The next one's normal leans away over a convex side: out of this facet, across the side.
    let outwards = scaled(&cross(&side_of(facet, k), &facet.normal), facet.sense);
    if dot(&outwards, &next.normal) < 0.0 {
        -by
    } else {
        by
    }
}

/// The shares of the corners in a point of a triangle, as near to it as there are.
fn shares_of(facet: &Facet, point: &Point) -> Option<[f64; 3]> {
    let [a, b, c] = &facet.corners;
    let across = cross(&sub(b, a), &sub(c, a));
    let square = dot(&across, &across);
    let share = |p: &Point, q: &Point| dot(&cross(&sub(p, point), &sub(q, point)), &across) / square;
    let shares = [share(b, c), share(c, a), share(a, b)].map(|s| s.max(0.0));
    let sum: f64 = shares.iter().sum();
    (sum.is_finite() && sum > 0.0).then(|| shares.map(|s| s / sum))
}

/// How the normals of a triangle's corners change along two directions.
fn bends(corners: &Triangle, normals: &[Point; 3], [u, v]: &[Point; 2]) -> Option<Curvature> {
    let flat = |p: &Point, q: &Point| {
        let way = sub(p, q);
        [dot(&way, u), dot(&way, v)]
    };
    let ([a, b], [c, d]) = (flat(&corners[1], &corners[0]), flat(&corners[2], &corners[0]));
    let ([m, n], [p, q]) = (flat(&normals[1], &normals[0]), flat(&normals[2], &normals[0]));
    let area = a * d - b * c;
    let inverse = 1.0 / area;
    // The matrix that takes (a, b) to (m, n) and (c, d) to (p, q); of a surface it is symmetric.
    let (xx, xy) = ((m * d - p * b) * inverse, (p * a - m * c) * inverse);
    let (yx, yy) = ((n * d - q * b) * inverse, (q * a - n * c) * inverse);
    let found = [xx, 0.5 * (xy + yx), yy];
    found.iter().all(|x| x.is_finite()).then_some(found)
}
