//! Polygons across the normal of a plane, whose points have a height along it: the area that carries a contact.

use std::f64::consts::TAU;
use std::sync::LazyLock;

use feeler_core::mesh::topology::body_outlines::hull;
use feeler_lanes::{Checked, Kernel, Simd, WIDE_LANES};

use crate::constants::{FEW_FEET, FOOTING_DIRECTIONS, FOOTING_MERGED, JUST_BEYOND, MOST_FANS, ON_BORDER};

const BATCHES: usize = FOOTING_DIRECTIONS / WIDE_LANES;
const _: () = assert!(BATCHES * WIDE_LANES == FOOTING_DIRECTIONS);

/// Sines and cosines of the directions around a normal.
static DIRECTIONS: LazyLock<[[[f64; WIDE_LANES]; 2]; BATCHES]> = LazyLock::new(|| {
    std::array::from_fn(|batch| {
        let angle = |i: usize| TAU * (WIDE_LANES * batch + i) as f64 / FOOTING_DIRECTIONS as f64;
        [std::array::from_fn(|i| angle(i).sin()), std::array::from_fn(|i| angle(i).cos())]
    })
});

/// A point of a footing: two coordinates across the normal, and the height along it, both from the plane's point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Foot {
    pub at: [f64; 2],
    pub height: f64,
}

impl Foot {
    /// The point on the line to another, at a share of the way.
    pub fn towards(&self, other: &Foot, share: f64) -> Foot {
        let mix = |a: f64, b: f64| a + share * (b - a);
        Foot {
            at: [mix(self.at[0], other.at[0]), mix(self.at[1], other.at[1])],
            height: mix(self.height, other.height),
        }
    }
}

/// The hull of all points across the normal.
pub(crate) fn across_hull(feet: &[Foot]) -> Vec<Foot> {
    // Most points are well within the farthest along four lines, and need not be put in order.
    let along = |foot: &Foot| [foot.at[0], foot.at[1], foot.at[0] + foot.at[1], foot.at[0] - foot.at[1]];
    let (mut least, mut most) = ([f64::INFINITY; 4], [f64::NEG_INFINITY; 4]);
    let (mut first, mut last) = ([0; 4], [0; 4]);
    for (i, foot) in feet.iter().enumerate() {
        for (k, x) in along(foot).into_iter().enumerate() {
            if x < least[k] {
                (least[k], first[k]) = (x, i);
            }
            if x > most[k] {
                (most[k], last[k]) = (x, i);
            }
        }
    }
    if feet.len() > FEW_FEET {
        let corners: Vec<Foot> = first.into_iter().chain(last).map(|i| feet[i]).collect();
        let sides = half_planes(&hull_of(&corners), -1e-6 * (most[0] - least[0]).max(most[1] - least[1]));
        let is_within = |at: &[f64; 2]| sides.iter().all(|(n, limit)| n[0] * at[0] + n[1] * at[1] < *limit);
        let left: Vec<Foot> = feet.iter().filter(|foot| !is_within(&foot.at)).copied().collect();
        return hull_of(&left);
    }
    hull_of(feet)
}

fn hull_of(feet: &[Foot]) -> Vec<Foot> {
    hull(&feet.iter().map(|foot| foot.at).collect::<Vec<_>>()).into_iter().map(|i| feet[i]).collect()
}

/// The convex hull, across the normal, of the points that are lowest along the directions of a ring around it, which lean by `turn`
/// (radians).
pub(crate) fn lowest(lanes: Checked, feet: &[Foot], turn: f64) -> Vec<Foot> {
    let slope = turn.tan();
    let mut chosen: Vec<usize> = Vec::new();
    let floor = feet.iter().map(|foot| foot.height).fold(f64::INFINITY, f64::min);
    let reach = |axis: usize| {
        let at = || feet.iter().map(|foot| foot.at[axis]);
        at().fold(f64::NEG_INFINITY, f64::max) - at().fold(f64::INFINITY, f64::min)
    };
    // What is higher than the slope over the whole width is lowest along none of them.
    let most = floor + slope * (reach(0) + reach(1));
    let near: Vec<usize> = (0..feet.len()).filter(|i| feet[*i].height <= most).collect();
    // All that are as low: of a flat side its corners.
    let noise = 1e-12 * (reach(0) + reach(1));
    lanes.run(Lowest { feet, near: &near, slope, noise, chosen: &mut chosen });
    chosen.sort_unstable();
    chosen.dedup();
    let places: Vec<[f64; 2]> = chosen.iter().map(|i| feet[*i].at).collect();
    hull(&places).into_iter().map(|i| feet[chosen[i]]).collect()
}

/// Chooses the points that are lowest along one of the directions, or as low but for noise.
struct Lowest<'a> {
    feet: &'a [Foot],
    /// The points that may be.
    near: &'a [usize],
    slope: f64,
    noise: f64,
    chosen: &'a mut Vec<usize>,
}

impl Kernel for Lowest<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Lowest { feet, near, slope, noise, chosen } = self;
        let (directions, slope) = (&*DIRECTIONS, s.wide_splat(slope));
        let height = |i: usize, [sin, cos]: &[[f64; WIDE_LANES]; 2]| {
            let Foot { at: [x, y], height } = feet[i];
            let lean = s.wide_load(cos) * s.wide_splat(x) + s.wide_load(sin) * s.wide_splat(y);
            s.wide_splat(height) - slope * lean
        };
        let mut least = [s.wide_splat(f64::INFINITY); BATCHES];
        for i in near {
            for (least, directions) in least.iter_mut().zip(directions) {
                *least = s.wide_min(*least, height(*i, directions));
            }
        }
        least.iter_mut().for_each(|least| *least = *least + s.wide_splat(noise));
        for i in near {
            let mut above = u8::MAX;
            for (least, directions) in least.iter().zip(directions) {
                above &= s.bits(s.wide_above(height(*i, directions), *least));
            }
            if above != u8::MAX {
                chosen.push(*i);
            }
        }
    }
}

/// The part of a hull over another, made wider by a little; heights are those of the first.
pub(crate) fn clipped(feet: &[Foot], other: &[Foot], wider: f64) -> Vec<Foot> {
    if other.is_empty() {
        return Vec::new();
    }
    cut_to(feet, &half_planes(other, wider))
}

/// The part of a convex polygon within half-planes.
pub(crate) fn cut_to(feet: &[Foot], within: &[([f64; 2], f64)]) -> Vec<Foot> {
    let mut left = Vec::new();
    Cutter::default().cut_to(feet, within, &mut left);
    left
}

/// Cuts polygons; its working memory.
#[derive(Debug, Default)]
pub(crate) struct Cutter {
    left: Vec<Foot>,
    before: Vec<Foot>,
}

impl Cutter {
    /// Appends to `out` the part of a convex polygon within half-planes.
    pub fn cut_to(&mut self, feet: &[Foot], within: &[([f64; 2], f64)], out: &mut Vec<Foot>) {
        let Cutter { left, before } = self;
        left.clear();
        left.extend_from_slice(feet);
        for (normal, limit) in within {
            let over = |foot: &Foot| normal[0] * foot.at[0] + normal[1] * foot.at[1] - limit;
            let (mut is_all_in, mut is_all_out) = (true, true);
            for foot in left.iter() {
                let is_in = over(foot) <= 0.0;
                (is_all_in, is_all_out) = (is_all_in && is_in, is_all_out && !is_in);
            }
            if is_all_out {
                return;
            }
            if is_all_in {
                continue;
            }
            std::mem::swap(left, before);
            left.clear();
            for (i, p) in before.iter().enumerate() {
                let q = &before[(i + 1) % before.len()];
                let (x, y) = (over(p), over(q));
                if x <= 0.0 {
                    left.push(*p);
                }
                if before.len() > 1 && (x < 0.0) != (y < 0.0) && x != 0.0 && y != 0.0 {
                    left.push(p.towards(q, x / (x - y)));
                }
            }
        }
        out.extend_from_slice(left);
    }
}

/// The sides of a convex polygon made wider, outward normals with limits; of a line or a point those of a box around it.
pub(crate) fn half_planes(feet: &[Foot], wider: f64) -> Vec<([f64; 2], f64)> {
    let side = |normal: [f64; 2], at: &[f64; 2]| (normal, normal[0] * at[0] + normal[1] * at[1] + wider);
    let outward = |p: &Foot, q: &Foot| {
        let way = [q.at[0] - p.at[0], q.at[1] - p.at[1]];
        let length = way[0].hypot(way[1]);
        [way[1] / length, -way[0] / length]
    };
    match feet {
        [] => Vec::new(),
        [p] => [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]].into_iter().map(|n| side(n, &p.at)).collect(),
        [p, q] => {
            let n = outward(p, q);
            vec![side(n, &p.at), side([-n[0], -n[1]], &p.at), side([-n[1], n[0]], &q.at), side([n[1], -n[0]], &p.at)]
        }
        _ => (0..feet.len()).map(|i| side(outward(&feet[i], &feet[(i + 1) % feet.len()]), &feet[i].at)).collect(),
    }
}

/// Leaves out corners next to a neighbour, or in line with both: nearer than a share of the whole, and than a length.
pub(crate) fn merge(feet: &mut Vec<Foot>, least: f64) {
    let apart = |p: &Foot, q: &Foot| (p.at[0] - q.at[0]).hypot(p.at[1] - q.at[1]);
    let size = feet.iter().flat_map(|p| feet.iter().map(move |q| apart(p, q))).fold(0.0, f64::max);
    let near = least.max(FOOTING_MERGED * size);
    let mut i = 0;
    while feet.len() > 1 && i < feet.len() {
        let (p, q, r) = (feet[(i + feet.len() - 1) % feet.len()], feet[i], feet[(i + 1) % feet.len()]);
        let base = apart(&p, &r);
        let area = (q.at[0] - p.at[0]) * (r.at[1] - p.at[1]) - (q.at[1] - p.at[1]) * (r.at[0] - p.at[0]);
        let is_in_line = feet.len() > 2 && area.abs() <= near * base && apart(&p, &q).max(apart(&q, &r)) <= base;
        if apart(&q, &r) <= near || is_in_line {
            feet.remove(i);
            i = i.saturating_sub(1);
        } else {
            i += 1;
        }
    }
}

/// Leaves out the edge whose neighbours, lengthened until they meet, add the least area. False where none can be.
pub(crate) fn leave_out_an_edge(feet: &mut Vec<Foot>) -> bool {
    let n = feet.len();
    let corner = |i: usize| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| &feet[(i + k) % n]);
        let (u, v) = ([b.at[0] - a.at[0], b.at[1] - a.at[1]], [c.at[0] - d.at[0], c.at[1] - d.at[1]]);
        let cross = |p: &[f64; 2], q: &[f64; 2]| p[0] * q[1] - p[1] * q[0];
        let (w, turn) = ([c.at[0] - b.at[0], c.at[1] - b.at[1]], cross(&u, &v));
        // Beyond b along the one, beyond c along the other.
        let (s, t) = (cross(&w, &v) / turn, cross(&w, &u) / turn);
        let is_beyond = s.is_finite() && t.is_finite() && s >= 0.0 && t >= 0.0;
        let at = [b.at[0] + s * u[0], b.at[1] + s * u[1]];
        let height = f64::min(b.height + s * (b.height - a.height), c.height + t * (c.height - d.height));
        let area = cross(&w, &[at[0] - b.at[0], at[1] - b.at[1]]).abs();
        is_beyond.then_some((area, i, Foot { at, height }))
    };
    let Some((_, i, foot)) = (0..n).filter_map(corner).min_by(|p, q| p.0.total_cmp(&q.0)) else { return false };
    feet[(i + 1) % n] = foot;
    feet.remove((i + 2) % n);
    true
}

/// The least height, over a place, of the ways of cutting a convex polygon into triangles around one of its corners; of a line the
/// height on it. A place just beyond the border, as the widened one of a clip, has the height of the triangle that it is nearest to.
pub(crate) fn height_over(feet: &[Foot], at: &[f64; 2]) -> f64 {
    let n = feet.len();
    let lowest = feet.iter().map(|foot| foot.height).fold(f64::INFINITY, f64::min);
    if let [p, q] = feet {
        let way = [q.at[0] - p.at[0], q.at[1] - p.at[1]];
        let share = (way[0] * (at[0] - p.at[0]) + way[1] * (at[1] - p.at[1])) / (way[0] * way[0] + way[1] * way[1]);
        return p.towards(q, share.clamp(0.0, 1.0)).height;
    }
    let (mut least, mut nearest) = (f64::INFINITY, (-JUST_BEYOND, lowest));
    for hub in (0..n).step_by(n.div_ceil(MOST_FANS).max(1)).filter(|_| n > 2) {
        for k in 1..n - 1 {
            let (inside, height) = height_on([&feet[hub], &feet[(hub + k) % n], &feet[(hub + k + 1) % n]], at);
            if inside >= -ON_BORDER {
                least = least.min(height);
            } else if inside > nearest.0 {
                nearest = (inside, height);
            }
        }
    }
    if least.is_finite() {
        least
    } else {
        nearest.1.max(lowest)
    }
}

/// The height over a place in a triangle.
pub(crate) fn height_in_triangle(three: [&Foot; 3], at: &[f64; 2]) -> Option<f64> {
    let (inside, height) = height_on(three, at);
    (inside >= -ON_BORDER).then_some(height)
}

/// The height of a triangle's plane over a place, and the least of its barycentric coordinates there: not negative inside.
fn height_on([a, b, c]: [&Foot; 3], at: &[f64; 2]) -> (f64, f64) {
    let (u, v) = ([b.at[0] - a.at[0], b.at[1] - a.at[1]], [c.at[0] - a.at[0], c.at[1] - a.at[1]]);
    let (w, turn) = ([at[0] - a.at[0], at[1] - a.at[1]], u[0] * v[1] - u[1] * v[0]);
    let (s, t) = ((w[0] * v[1] - w[1] * v[0]) / turn, (u[0] * w[1] - u[1] * w[0]) / turn);
    (s.min(t).min(1.0 - s - t), a.height + s * (b.height - a.height) + t * (c.height - a.height))
}
