//! Force shading: the force on the facets of a curved surface as on the smooth surface (H. B. Morgenbesser and M. A.
//! Srinivasan, *Force Shading for Haptic Shape Perception*, 1996).
//!
//! The proxy stays where the facets stop it; only the force is turned. With facets on both sides the point of contact
//! jumps from corner to corner of the surface that bends more, so it says little by itself. But both surfaces are known
//! to second order around it: `n` and `m` are the normals of mock-up and tool there, `S` and `T` their curvatures. Two
//! smooth surfaces touch where their normals agree, which is `d = (S + T)⁻¹ (m - n)` farther along, with the normal
//! `n + S d`: the same from every starting point, and so without jumps. For a ball of radius r on one of radius R it is
//! the line of the centres.
//!
//! If the tool moves by `t` and turns by `w`, that normal changes by `S (S + T)⁻¹ (T t + w × n)`: the servo side
//! follows it between two sets.
//!
//! A force that is only turned has no potential: a hand that presses on the way from the middle of a facet to its rim
//! and lifts there gains the force times the height of the smooth surface over the facet, several per cent of the
//! spring's energy for coarse facets. With that height, the sum of `h` of the mock-up, of the tool, and `(m - n) (S +
//! T)⁻¹ (m - n) / 2` for the way between, it has one: the spring's energy plus `W h`, where `W` is the force except for
//! a ramp at the first touch, has the turned force as its gradient across the normal, and along it the spring's and `W'
//! h`, as if the spring was stretched from the smooth surface.

use feeler_core::geometry::twist::{rotation_of, times, Twist};
use feeler_core::geometry::vectors::{across, add, cross, dot, length, scaled, unit};
use feeler_core::{Point, Pose, Tool};
use feeler_world::{Environment, Pair, Plane};

use crate::constants::{
    LARGEST_BULGE_M, LARGEST_GAIN, LARGEST_SHADING_TURN, LEAST_CURVATURE, LEAST_SLOPE, MEAN_OF_ARC, SHADING_RAMP,
};
use crate::smooth_surface::{Curvature, Edge, Surface};

/// How a force is turned.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Shading {
    /// Rotation vector, world.
    pub turn: Point,
    /// How far the smooth surface stands out of the facets, above its mean height over the mock-up's, metres.
    pub height_m: f64,
    /// How far it does where that is most, metres, not negative.
    pub bulge_m: f64,
}

impl Shading {
    /// As the facets have it.
    pub const NONE: Shading = Shading { turn: [0.0; 3], height_m: 0.0, bulge_m: 0.0 };

    /// A spring's force as it is on the smooth surface, and the energy that it has beside the spring's, joules. `stiffness`: by how much the force
    /// grows along the normal, newtons a metre; `ramp`: of a spring that is not at its bound.
    pub(crate) fn turned(&self, force: &Point, stiffness: f64, ramp: f64) -> (Point, f64) {
        let size = length(force);
        if self.bulge_m <= 0.0 || size <= 0.0 {
            return (*force, 0.0);
        }
        let full = ramp * SHADING_RAMP * self.bulge_m;
        let (weight, slope) =
            if size < full { (0.5 * size * size / full, size / full) } else { (size - 0.5 * full, 1.0) };
        let turn = scaled(&self.turn, weight / size);
        let along = stiffness * slope * self.height_m;
        let by = 1.0 / length(&turn).cos() + along / size;
        (scaled(&times(&rotation_of(&turn), force), by), weight * self.height_m)
    }
}

/// The smooth contact behind a plane, and how it moves with the tool.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Shade {
    /// How far its normal is off the plane's, along the two directions across that.
    off: [f64; 2],
    /// Change of that for a way of the tool's point (one over metres), symmetric.
    by_way: Curvature,
    /// Change of that for a turn of the tool's normal.
    by_turn: [[f64; 2]; 2],
    /// As of [`Shading`], metres.
    height: f64,
    bulge: f64,
}

impl Shade {
    /// Of the nearest points of a pair of triangles; none where it is not of two surfaces of which one is smooth at least, and on a real
    /// edge of the mock-up.
    pub fn of_pair(environment: &Environment, tool: &Tool, pose: &Pose, pair: &Pair, plane: &Plane) -> Option<Shade> {
        let mockup = environment.bodies.get(pair.body as usize)?.solver.scene().mockup();
        let (own, other) = (tool.mesh(), mockup.mesh());
        let closest = environment.closest(tool, pose, pair)?;
        let directions = across(&plane.normal);
        let towards = scaled(&plane.normal, -1.0);
        let surface = Surface { adjacency: mockup.adjacency(), triangle: |t| other.triangle(t) };
        let below = surface.at(pair.triangle, &closest.on_q, &plane.normal, &directions)?;
        let surface = Surface { adjacency: tool.adjacency(), triangle: |t| pose.apply_triangle(&own.triangle(t)) };
        let above = surface.at(pair.tool_triangle, &closest.on_p, &towards, &directions);
        // How far a normal is off the plane's, where that is one long.
        let flat = |v: &Point| directions.map(|d| dot(v, &d) / dot(v, &plane.normal));
        let off = flat(&below.normal);
        // On a flat face there is nothing to turn.
        let s = below.curvature.filter(|s| s.iter().any(|x| x.abs() > LEAST_CURVATURE))?;
        let (height, bulge) = (below.height - MEAN_OF_ARC * below.bulge, below.bulge.abs());
        let Some((above, t)) = above.and_then(|above| Some((above, above.curvature?))) else {
            let edges = surface.edges(pair.tool_triangle, &closest.on_p, &towards);
            return Shade::of_edges(Shade { off, by_way: s, by_turn: [[0.0; 2]; 2], height, bulge }, &edges, plane)
                .checked();
        };
        let inverse = inverse_of(&[s[0] + t[0], s[1] + t[1], s[2] + t[2]]);
        let by_turn = product(&s, &inverse);
        let both = times_symmetric(&by_turn, &t);
        let tool_off = flat(&above.normal);
        let apart = [tool_off[0] - off[0], tool_off[1] - off[1]];
        let by = times_flat(&by_turn, &apart);
        Shade {
            off: [off[0] + by[0], off[1] + by[1]],
            by_way: [both[0][0], 0.5 * (both[0][1] + both[1][0]), both[1][1]],
            by_turn,
            height: height + above.height + 0.5 * dot_flat(&apart, &times_flat(&full(&inverse), &apart)),
            bulge: bulge + above.bulge.abs(),
        }
        .checked()
    }

    /// Of the mock-up's surface alone, under real edges of the tool. A corner touches where it is. A straight edge touches where the
    /// surface runs along with it, if the edge is so long: a tool that is curved without end across the edge, and not along it.
    fn of_edges(at_point: Shade, edges: &[Option<Edge>; 2], plane: &Plane) -> Shade {
        let [u, v] = across(&plane.normal);
        let s = full(&at_point.by_way);
        let slid = |edge: &Edge| {
            let along = [dot(&edge.direction, &u), dot(&edge.direction, &v)];
            let size = along[0].hypot(along[1]);
            let e = along.map(|x| x / size);
            let bent = times_flat(&s, &e);
            let bend = dot_flat(&bent, &e);
            if size < LEAST_SLOPE || bend <= LEAST_CURVATURE {
                return at_point;
            }
            let apart = -dot(&edge.direction, &plane.normal) / size - dot_flat(&at_point.off, &e);
            let whole = apart / bend;
            let way = whole.clamp(-edge.ends[0], edge.ends[1]);
            let mut there = at_point;
            there.off = [0, 1].map(|k| there.off[k] + bent[k] * way);
            there.height += apart * way - 0.5 * bend * way * way;
            if way == whole {
                let by = |i: usize, j: usize| bent[i] * bent[j] / bend;
                there.by_way = [s[0][0] - by(0, 0), s[0][1] - by(0, 1), s[1][1] - by(1, 1)];
                there.by_turn = [0, 1].map(|i| [0, 1].map(|j| bent[i] * e[j] / bend));
            }
            there
        };
        let higher = |a: Shade, b: Shade| if b.height > a.height { b } else { a };
        edges.iter().flatten().map(slid).fold(at_point, higher)
    }

    /// Not where two hollow surfaces fit so well that the contact says nothing.
    fn checked(self) -> Option<Shade> {
        let gain = self.by_turn.iter().flatten().map(|x| x * x).sum::<f64>().sqrt();
        let is_finite = self.off.iter().chain(&self.by_way).all(|x| x.is_finite());
        (is_finite && gain <= LARGEST_GAIN).then_some(self)
    }

    /// The smooth normal of a plane after the tool has moved by a twist at the contact's point; height and bulge.
    pub fn at(&self, plane: &Plane, by: &Twist) -> (Point, [f64; 2]) {
        let [u, v] = across(&plane.normal);
        let leaned = cross(&by.angular, &plane.normal);
        let flat = |p: &Point| [dot(p, &u), dot(p, &v)];
        let (way, lean) = (flat(&by.linear), flat(&leaned));
        let turned = times_flat(&self.by_turn, &lean);
        let slid = times_flat(&full(&self.by_way), &way);
        let height = self.height - dot_flat(&self.off, &way) - 0.5 * dot_flat(&way, &slid);
        let bulge = self.bulge.min(LARGEST_BULGE_M);
        let mut off = [0, 1].map(|k| self.off[k] + turned[k] + slid[k]);
        let size = off[0].hypot(off[1]);
        let most = LARGEST_SHADING_TURN.tan();
        if size > most {
            off = off.map(|x| x * (most / size));
        }
        let leaning = add(&scaled(&u, off[0]), &scaled(&v, off[1]));
        (unit(&add(&plane.normal, &leaning)).unwrap_or(plane.normal), [height.clamp(-bulge, bulge), bulge])
    }
}

/// How the sum of forces along planes' normals is turned to their sum along smooth ones: size, normal, smooth normal, height and
/// bulge of each.
pub(crate) fn shading_of(pushes: impl Iterator<Item = (f64, Point, Point, [f64; 2])>) -> Shading {
    let (mut sum, mut smooth, mut size, mut heights) = ([0.0; 3], [0.0; 3], 0.0, [0.0; 2]);
    for (push, normal, smooth_normal, own) in pushes {
        sum = add(&sum, &scaled(&normal, push));
        smooth = add(&smooth, &scaled(&smooth_normal, push));
        size += push;
        heights = [heights[0] + push * own[0], heights[1] + push * own[1]];
    }
    let axis = cross(&sum, &smooth);
    let sine = length(&axis);
    if size <= 0.0 || heights[1] == 0.0 {
        return Shading::NONE;
    }
    let angle = sine.atan2(dot(&sum, &smooth)).min(LARGEST_SHADING_TURN);
    let turn = if sine > 0.0 { scaled(&axis, angle / sine) } else { [0.0; 3] };
    Shading { turn, height_m: heights[0] / size, bulge_m: heights[1] / size }
}

/// The inverse of a symmetric matrix, without the directions in which it is flat or hollow.
fn inverse_of(&[a, b, d]: &Curvature) -> Curvature {
    let (middle, half) = (0.5 * (a + d), (0.5 * (a - d)).hypot(b));
    let inverse = |x: f64| if x > LEAST_CURVATURE { 1.0 / x } else { 0.0 };
    let (p, q) = (inverse(middle + half), inverse(middle - half));
    // The direction of the larger one by its double angle.
    let (cosine, sine) = if half > 0.0 { (0.5 * (a - d) / half, b / half) } else { (1.0, 0.0) };
    let (middle, half) = (0.5 * (p + q), 0.5 * (p - q));
    [middle + half * cosine, half * sine, middle - half * cosine]
}

fn full(&[a, b, d]: &Curvature) -> [[f64; 2]; 2] {
    [[a, b], [b, d]]
}

fn product(p: &Curvature, q: &Curvature) -> [[f64; 2]; 2] {
    times_symmetric(&full(p), q)
}

fn times_symmetric(p: &[[f64; 2]; 2], q: &Curvature) -> [[f64; 2]; 2] {
    let q = full(q);
    [0, 1].map(|i| [0, 1].map(|j| p[i][0] * q[0][j] + p[i][1] * q[1][j]))
}

fn times_flat(m: &[[f64; 2]; 2], v: &[f64; 2]) -> [f64; 2] {
    [0, 1].map(|i| dot_flat(&m[i], v))
}

fn dot_flat(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
