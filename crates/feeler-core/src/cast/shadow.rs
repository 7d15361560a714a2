//! Triangles that never collide during a motion, however long it is, because their shadows are apart.
//!
//! A slide casts shadows on the plane across it. A rotation or a screw casts them on the half-plane of radius and
//! height, with the height reduced by the screw's rise for the angle of a point: each point of the tool keeps its place
//! there during the whole motion. In a tight fit, a bore or a thread, many thousands of triangles stay near each other
//! all along, and following each pair of them takes seconds; their shadows lie along one outline each, so that a few
//! oriented boxes separate nearly all of them.
//!
//! A shadow is the triangle through the corners' shadows, grown by a bound on how far the shadow of a flat triangle
//! curves off it, and by how far the motion may deviate from a screw. Boxes of a tree are oriented by the spread of
//! their content.

use std::f64::consts::{PI, TAU};

use crate::constants::{ARC_ROUNDING, UNIT_ROUNDOFF};
use crate::geometry::bounds::{Point, Triangle};
use crate::geometry::vectors::{cross, dot, length, sub, unit};
use crate::tool::motion::Steady;

/// A triangle whose shadow curves by more than this share of its length is halved.
const LEAST_CURVE: f64 = 1.0 / 64.0;
/// So often at most.
const MOST_BISECTIONS: u32 = 8;

type Flat = [f64; 2];

/// The surface on which shadows fall.
#[derive(Debug, Clone, Copy)]
pub struct Screen {
    steady: Steady,
    /// Units, across the axis or the way, and each other.
    across: [Point; 2],
    /// Rise of a screw per radian, metres; 0 of a slide or a turn.
    rise: f64,
    /// Heights that are one, metres: what a screw rises for a turn; 0: none are.
    period: f64,
    shifts: [f64; 3],
}

/// The shadow of a triangle.
#[derive(Debug, Clone, Copy)]
pub struct Shadow {
    /// The number that it was given.
    pub number: u32,
    corners: [Flat; 3],
    /// By how much it may be beyond these, along the first and the second axis.
    beyond: Flat,
    /// Where the triangle is along the way, the middle and half of it: metres of a slide, else radians.
    along: [f64; 2],
}

impl Screen {
    /// Of a way; `None` where points keep no place: a turn about an axis that moves across itself.
    pub fn of(steady: Option<Steady>) -> Option<Screen> {
        let steady = steady?;
        let axis = match steady {
            Steady::Slide { way, .. } => unit(&way)?,
            Steady::Screw { axis, .. } => axis,
        };
        let least = (0..3).min_by(|a, b| axis[*a].abs().total_cmp(&axis[*b].abs())).unwrap_or(0);
        let first = unit(&cross(&axis, &std::array::from_fn(|a| f64::from(u8::from(a == least)))))?;
        let second = cross(&axis, &first);
        let rise = match steady {
            Steady::Slide { .. } => 0.0,
            Steady::Screw { advance, angle, .. } => advance / angle,
        };
        let period = TAU * rise.abs();
        Some(Screen { steady, across: [first, second], rise, period, shifts: [0.0, period, -period] })
    }

    /// The shadows of a triangle, in the world where the way begins: of its pieces, where it curves much. `stray`: by how much it may be off
    /// its place (metres, per axis). `with`: those that are apart from all of these are left out.
    pub fn cast(
        &self,
        number: u32,
        triangle: &Triangle,
        stray: f64,
        with: Option<&Shadows>,
        shadows: &mut Vec<Shadow>,
    ) {
        match self.steady {
            Steady::Slide { way, .. } => {
                let [u, v] = &self.across;
                let size = triangle.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
                let corners = triangle.each_ref().map(|p| [dot(p, u), dot(p, v)]);
                let stray = 2.0 * stray + 32.0 * UNIT_ROUNDOFF * size;
                let heights = triangle.each_ref().map(|p| dot(p, &way) / length(&way));
                let along = widened(middle_and_half(&heights), stray);
                let shadow = Shadow { number, corners, beyond: [stray; 2], along };
                if with.is_none_or(|with| self.is_near(&shadow, with)) {
                    shadows.push(shadow);
                }
            }
            Steady::Screw { axis, point, .. } => {
                let size = triangle.iter().chain([&point]).flatten().fold(0.0f64, |m, x| m.max(x.abs()));
                let stray = 2.0 * stray + 64.0 * UNIT_ROUNDOFF * size;
                let arms = triangle.each_ref().map(|p| sub(p, &point));
                let [u, v] = &self.across;
                let turned = arms.each_ref().map(|p| [dot(p, u), dot(p, v), dot(p, &axis)]);
                self.cast_turned(number, &turned, (stray, MOST_BISECTIONS), with, shadows);
            }
        }
    }

    /// Of a triangle in the axes of the screen, the last of them the screw's; halved at most `halvings` times.
    fn cast_turned(
        &self,
        number: u32,
        [a, b, c]: &Triangle,
        (stray, halvings): (f64, u32),
        with: Option<&Shadows>,
        shadows: &mut Vec<Shadow>,
    ) {
        let flat = [a, b, c].map(|p| [p[0], p[1]]);
        let shadow = self.shadow_of_turned(number, &flat, &[a[2], b[2], c[2]], stray);
        if !with.is_none_or(|with| self.is_near(&shadow, with)) {
            return;
        }
        let sides = [(a, b, c), (b, c, a), (c, a, b)];
        let long = |p: &Point, q: &Point| (p[0] - q[0]).hypot(p[1] - q[1]);
        let Some((p, q, r)) = sides.into_iter().max_by(|x, y| long(x.0, x.1).total_cmp(&long(y.0, y.1))) else {
            return;
        };
        if halvings == 0 || shadow.beyond[0] <= LEAST_CURVE * long(p, q) + stray {
            shadows.push(shadow);
            return;
        }
        let middle = std::array::from_fn(|i| 0.5 * (p[i] + q[i]));
        for half in [[*p, middle, *r], [middle, *q, *r]] {
            self.cast_turned(number, &half, (stray, halvings - 1), with, shadows);
        }
    }

    /// Whether a shadow meets the box around others.
    fn is_near(&self, shadow: &Shadow, others: &Shadows) -> bool {
        let bounds = Bounds::of(&[*shadow]);
        let root = others.nodes.first();
        root.is_some_and(|root| self.shifts().iter().any(|shift| !root.bounds.is_apart(&bounds, *shift)))
    }

    /// By how much shadows may be higher and yet be the same.
    fn shifts(&self) -> &[f64] {
        if self.period == 0.0 {
            &self.shifts[..1]
        } else {
            &self.shifts
        }
    }

    fn shadow_of_turned(&self, number: u32, flat: &[Flat; 3], heights: &[f64; 3], stray: f64) -> Shadow {
        let radii = flat.map(|[x, y]| x.hypot(y));
        let nearest = (nearest_to_origin(flat) - stray).max(0.0);
        let farthest = radii.into_iter().fold(0.0, f64::max) + stray;
        let wide = diameter(flat) + 2.0 * stray;
        let first = flat[0][1].atan2(flat[0][0]);
        if nearest <= wide {
            // Near the axis, or around it: a box.
            let [middle, half] = middle_and_half(heights);
            let turn = if nearest > 0.0 { (wide / nearest).min(PI) } else { PI };
            let tall = half + stray + self.rise.abs() * turn;
            let corner = [0.5 * (farthest + nearest), middle - self.rise * first];
            let beyond = [0.5 * (farthest - nearest), tall];
            return self.in_one_period(Shadow { number, corners: [corner; 3], beyond, along: [first, turn] });
        }
        let angles = flat.map(|[x, y]| {
            let by = y.atan2(x) - first;
            first + by
                - if by > PI {
                    TAU
                } else if by < -PI {
                    -TAU
                } else {
                    0.0
                }
        });
        // A radius is at most as interpolated between the corners, and at least the height along the direction to the middle, which is so
        // much less at a corner.
        let [middle, turn] = middle_and_half(&angles);
        let (sine, cosine) = middle.sin_cos();
        let sag = [0, 1, 2].map(|i: usize| radii[i] - (cosine * flat[i][0] + sine * flat[i][1]));
        let sag = sag.into_iter().fold(0.0, f64::max);
        // An angle is off its interpolation by at most half its second derivative, at most 1/r^2, times the square of the radius of the least
        // circle around the triangle (S. Waldron, 1998).
        let bend =
            (radius_around(flat) + stray).powi(2) / (2.0 * nearest * nearest) * (1.0 + ARC_ROUNDING) + stray / nearest;
        let corners = [0, 1, 2].map(|i: usize| [radii[i] - 0.5 * sag, heights[i] - self.rise * angles[i]]);
        let tall = stray + self.rise.abs() * bend + 64.0 * UNIT_ROUNDOFF * self.period;
        let shadow = Shadow { number, corners, beyond: [0.5 * sag + stray, tall], along: [middle, turn + bend] };
        self.in_one_period(shadow)
    }

    /// The same with its middle between 0 and a period; all of one where it is longer.
    fn in_one_period(&self, mut shadow: Shadow) -> Shadow {
        if self.period == 0.0 {
            return shadow;
        }
        let [middle, half] = middle_and_half(&shadow.corners.map(|c| c[1]));
        if half + shadow.beyond[1] >= 0.5 * self.period {
            let [radius, wide] = middle_and_half(&shadow.corners.map(|c| c[0]));
            shadow.corners = [[radius, 0.5 * self.period]; 3];
            shadow.beyond = [wide + shadow.beyond[0], 0.5 * self.period * (1.0 + ARC_ROUNDING)];
            return shadow;
        }
        let turns = (middle / self.period).floor() * self.period;
        shadow.corners.iter_mut().for_each(|corner| corner[1] -= turns);
        shadow.beyond[1] += 4.0 * UNIT_ROUNDOFF * turns.abs();
        shadow
    }

    /// Offers the pairs of shadows, `of_tool` and `of_mockup`, that may overlap, by number; the callback returns
    /// whether to go on. Makes at most that many tests of boxes. Returns whether all pairs were offered.
    pub fn meeting(
        &self,
        of_tool: &Shadows,
        of_mockup: &Shadows,
        mut tests: usize,
        offer: &mut dyn FnMut(u32, u32) -> bool,
    ) -> bool {
        let mut stack: Vec<(usize, usize, f64)> = self.shifts().iter().map(|shift| (0, 0, *shift)).collect();
        while let Some((a, b, shift)) = stack.pop() {
            if tests == 0 {
                return false;
            }
            tests -= 1;
            let (own, other) = (&of_tool.nodes[a], &of_mockup.nodes[b]);
            if own.bounds.is_apart(&other.bounds, shift) {
                continue;
            }
            match (own.children, other.children) {
                (None, None) => {
                    let (shadow, with) = (&of_tool.shadows[own.from], &of_mockup.shadows[other.from]);
                    if !self.are_apart(shadow, with, shift) && !offer(shadow.number, with.number) {
                        return false;
                    }
                }
                (Some(children), None) => stack.extend(children.map(|child| (child, b, shift))),
                (None, Some(children)) => stack.extend(children.map(|child| (a, child, shift))),
                (Some(of_own), Some(of_other)) => match own.to - own.from >= other.to - other.from {
                    true => stack.extend(of_own.map(|child| (child, b, shift))),
                    false => stack.extend(of_other.map(|child| (a, child, shift))),
                },
            }
        }
        true
    }

    fn are_apart(&self, a: &Shadow, b: &Shadow, shift: f64) -> bool {
        self.are_apart_along(a, b) || a.is_apart(b, shift) || b.is_apart(a, -shift)
    }

    /// Whether the tool's does not come to the other on its way.
    fn are_apart_along(&self, a: &Shadow, b: &Shadow) -> bool {
        let reach = a.along[1] + b.along[1];
        match self.steady {
            Steady::Slide { way, .. } => {
                let ahead = b.along[0] - a.along[0];
                ahead < -reach || ahead > reach + length(&way) * (1.0 + ARC_ROUNDING)
            }
            Steady::Screw { angle, .. } => {
                let (middle, reach) = (0.5 * angle, reach + 0.5 * angle + ARC_ROUNDING);
                let ahead = b.along[0] - a.along[0] - middle;
                reach < PI && (ahead - TAU * (ahead / TAU).round()).abs() > reach
            }
        }
    }
}

impl Shadow {
    /// Whether a line along an edge of this one holds the other, higher by `shift`, apart; or one along the axes.
    fn is_apart(&self, other: &Shadow, shift: f64) -> bool {
        let [a, b, c] = &self.corners;
        let beyond = [self.beyond[0] + other.beyond[0], self.beyond[1] + other.beyond[1]];
        let parts = |n: Flat| {
            let ([low, high], [from, to]) = (range(&self.corners, &n), range(&other.corners, &n));
            let slack = (n[0].abs() * beyond[0] + n[1].abs() * beyond[1]) * (1.0 + ARC_ROUNDING);
            let shift = n[1] * shift;
            from + shift > high + slack || to + shift < low - slack
        };
        let across = |p: &Flat, q: &Flat| [p[1] - q[1], q[0] - p[0]];
        parts(across(a, b)) || parts(across(b, c)) || parts(across(c, a)) || parts([1.0, 0.0]) || parts([0.0, 1.0])
    }
}

/// Shadows under a tree of oriented boxes.
#[derive(Debug)]
pub struct Shadows {
    shadows: Vec<Shadow>,
    nodes: Vec<Node>,
}

#[derive(Debug)]
struct Node {
    bounds: Bounds,
    from: usize,
    to: usize,
    children: Option<[usize; 2]>,
}

/// A box: its middle, its first axis (unit; the second is across it), half its sides.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    middle: Flat,
    axis: Flat,
    half: Flat,
}

impl Shadows {
    /// Builds the tree.
    pub fn new(mut shadows: Vec<Shadow>) -> Shadows {
        let mut nodes = Vec::with_capacity(shadows.len());
        if !shadows.is_empty() {
            let to = shadows.len();
            build(&mut shadows, (0, to), &mut nodes);
        }
        Shadows { shadows, nodes }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.shadows.len()
    }
}

/// Builds the node of some shadows, and those below; its number.
fn build(shadows: &mut [Shadow], (from, to): (usize, usize), nodes: &mut Vec<Node>) -> usize {
    let own = &mut shadows[from..to];
    let bounds = Bounds::of(own);
    let number = nodes.len();
    nodes.push(Node { bounds, from, to, children: None });
    if to - from > 1 {
        let middle = (to - from) / 2;
        let along = if bounds.half[0] >= bounds.half[1] { bounds.axis } else { [-bounds.axis[1], bounds.axis[0]] };
        let key = |shadow: &Shadow| {
            let [p, q, r] = shadow.corners.each_ref().map(|c| along[0] * c[0] + along[1] * c[1]);
            p + q + r
        };
        own.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
        let first = build(shadows, (from, from + middle), nodes);
        let second = build(shadows, (from + middle, to), nodes);
        nodes[number].children = Some([first, second]);
    }
    number
}

impl Bounds {
    /// Around shadows, oriented by the spread of their corners.
    fn of(shadows: &[Shadow]) -> Bounds {
        let corners = || shadows.iter().flat_map(|shadow| shadow.corners.iter());
        let count = 3.0 * shadows.len() as f64;
        let mean = [0, 1].map(|a: usize| corners().map(|c| c[a]).sum::<f64>() / count);
        let spread = |a: usize, b: usize| corners().map(|c| (c[a] - mean[a]) * (c[b] - mean[b])).sum::<f64>();
        // The direction of the largest variance.
        let turn = 0.5 * (2.0 * spread(0, 1)).atan2(spread(0, 0) - spread(1, 1));
        let axis = [turn.cos(), turn.sin()];
        let axes = [axis, [-axis[1], axis[0]]];
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for shadow in shadows {
            for (a, n) in axes.iter().enumerate() {
                let beyond = n[0].abs() * shadow.beyond[0] + n[1].abs() * shadow.beyond[1];
                let [from, to] = range(&shadow.corners, n);
                low[a] = low[a].min(from - beyond);
                high[a] = high[a].max(to + beyond);
            }
        }
        let at = [0, 1].map(|a: usize| 0.5 * (low[a] + high[a]));
        let middle = [axis[0] * at[0] - axis[1] * at[1], axis[1] * at[0] + axis[0] * at[1]];
        // The axes, the middle and the sides round.
        let size = low.iter().chain(&high).fold(0.0f64, |m, x| m.max(x.abs()));
        let half = [0, 1].map(|a: usize| 0.5 * (high[a] - low[a]) + 64.0 * UNIT_ROUNDOFF * size);
        Bounds { middle, axis, half }
    }

    /// Whether a side of one of them holds the two apart, the other higher by `shift`.
    fn is_apart(&self, other: &Bounds, shift: f64) -> bool {
        let by = [other.middle[0] - self.middle[0], other.middle[1] + shift - self.middle[1]];
        let cosine = (self.axis[0] * other.axis[0] + self.axis[1] * other.axis[1]).abs();
        let sine = (self.axis[0] * other.axis[1] - self.axis[1] * other.axis[0]).abs();
        let slack = 64.0 * UNIT_ROUNDOFF * (by[0].abs() + by[1].abs() + self.middle[0].abs() + self.middle[1].abs());
        let parted = |of: &Bounds, with: &Bounds| {
            let [first, second] = [of.axis[0] * by[0] + of.axis[1] * by[1], of.axis[0] * by[1] - of.axis[1] * by[0]];
            first.abs() > of.half[0] + with.half[0] * cosine + with.half[1] * sine + slack
                || second.abs() > of.half[1] + with.half[0] * sine + with.half[1] * cosine + slack
        };
        parted(self, other) || parted(other, self)
    }
}

fn range(corners: &[Flat; 3], n: &Flat) -> [f64; 2] {
    let height = |c: &Flat| n[0] * c[0] + n[1] * c[1];
    let (p, q, r) = (height(&corners[0]), height(&corners[1]), height(&corners[2]));
    [p.min(q).min(r), p.max(q).max(r)]
}

fn middle_and_half(values: &[f64; 3]) -> [f64; 2] {
    let (low, high) = (values[0].min(values[1]).min(values[2]), values[0].max(values[1]).max(values[2]));
    [0.5 * (low + high), 0.5 * (high - low)]
}

fn widened([middle, half]: [f64; 2], by: f64) -> [f64; 2] {
    [middle, half + by]
}

fn diameter(flat: &[Flat; 3]) -> f64 {
    let side = |i: usize, j: usize| (flat[i][0] - flat[j][0]).hypot(flat[i][1] - flat[j][1]);
    side(0, 1).max(side(1, 2)).max(side(2, 0))
}

/// The radius of the least circle around a triangle.
fn radius_around(flat: &[Flat; 3]) -> f64 {
    let side = |i: usize, j: usize| (flat[i][0] - flat[j][0]).hypot(flat[i][1] - flat[j][1]);
    let mut sides = [side(0, 1), side(1, 2), side(2, 0)];
    sides.sort_by(f64::total_cmp);
    let [a, b, c] = sides;
    let [p, q, r] = flat;
    let twice_area = ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])).abs();
    // Of an acute one it goes through the corners; no more than this is ever needed.
    if a * a + b * b <= c * c || twice_area <= 0.0 {
        0.5 * c
    } else {
        (a * b * c / (2.0 * twice_area)).min(c / 3.0f64.sqrt())
    }
}

/// How far the origin is from a triangle in the plane; 0 inside.
fn nearest_to_origin(flat: &[Flat; 3]) -> f64 {
    let sides = [0, 1, 2].map(|i: usize| (flat[i], flat[(i + 1) % 3]));
    let turn = |(p, q): (Flat, Flat)| p[0] * q[1] - p[1] * q[0];
    let turns = sides.map(turn);
    if turns.iter().all(|turn| *turn >= 0.0) || turns.iter().all(|turn| *turn <= 0.0) {
        return 0.0;
    }
    let of_side = |(p, q): (Flat, Flat)| {
        let by = [q[0] - p[0], q[1] - p[1]];
        let square = by[0] * by[0] + by[1] * by[1];
        let share = if square > 0.0 { (-(p[0] * by[0] + p[1] * by[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
        (p[0] + share * by[0]).hypot(p[1] + share * by[1])
    };
    sides.map(of_side).into_iter().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cast::pair::Moving;
    use crate::geometry::pose::Pose;
    use crate::tool::motion::Motion;
    use crate::tool::moving_tool::Tool;
    use crate::tool::screw::Screw;

    /// Numbers from -1 to 1 (a linear congruential generator; its high bits).
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }

        fn point(&mut self, size: f64) -> Point {
            [0; 3].map(|_| size * self.next())
        }

        /// A triangle of a size, somewhere.
        fn triangle(&mut self, size: f64) -> Triangle {
            let at = self.point(1.0);
            [0; 3].map(|_| {
                let by = self.point(size);
                std::array::from_fn(|a| at[a] + by[a])
            })
        }
    }

    fn tool_of(triangles: &[Triangle]) -> Tool {
        let faces = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Tool::new(triangles.as_flattened().to_vec(), faces).unwrap()
    }

    /// A turn, a screw and a slide, each long, short and in between, from a pose and a time.
    fn motions(numbers: &mut Numbers, tool: &Tool) -> Vec<(Motion, f64)> {
        let mut all = Vec::new();
        for kind in 0..6 {
            let (axis, point) = (numbers.point(1.0), numbers.point(0.3));
            let pose = Pose::IDENTITY.translated(&numbers.point(0.3)).unwrap();
            let angle = [0.2, 2.0, 9.0][kind % 3] * numbers.next();
            let motion = match kind {
                0..3 => Motion::screw(tool, &pose, &Screw::new(&axis, &point, angle, 0.0).unwrap()),
                3 | 4 => Motion::screw(tool, &pose, &Screw::new(&axis, &point, angle, numbers.next()).unwrap()),
                _ => Ok(Motion::new(tool, &pose, &pose.translated(&numbers.point(2.0)).unwrap())),
            };
            all.push((motion.unwrap(), 0.25 * (1.0 + numbers.next())));
        }
        all
    }

    #[test]
    fn pairs_that_meet_are_offered() {
        let mut numbers = Numbers(7);
        let (mut met, mut left_out) = (0, 0);
        for round in 0..30 {
            let size = [0.05, 0.3, 1.5][round % 3];
            let own: Vec<Triangle> = (0..24).map(|_| numbers.triangle(size)).collect();
            let others: Vec<Triangle> = (0..24).map(|_| numbers.triangle(size)).collect();
            let tool = tool_of(&own);
            for (motion, from) in motions(&mut numbers, &tool) {
                let pose = motion.at(from);
                let screen = Screen::of(motion.steady(from)).unwrap();
                let (mut of_tool, mut of_mockup) = (Vec::new(), Vec::new());
                for (number, triangle) in (0..).zip(&own) {
                    screen.cast(number, &pose.apply_triangle(triangle), motion.stray(), None, &mut of_tool);
                }
                let of_tool = Shadows::new(of_tool);
                for (number, triangle) in (0..).zip(&others) {
                    screen.cast(number, triangle, 0.0, Some(&of_tool), &mut of_mockup);
                }
                let mut offered = std::collections::BTreeSet::new();
                if !of_mockup.is_empty() {
                    let all = screen.meeting(&of_tool, &Shadows::new(of_mockup), usize::MAX, &mut |a, b| {
                        offered.insert([a, b]);
                        true
                    });
                    assert!(all);
                }
                for (a, triangle) in (0..).zip(&own) {
                    let moving = Moving::new(&motion, *triangle, &motion.during(from, 1.0));
                    for (b, q) in (0..).zip(&others) {
                        let meets = moving.first_impact(q, from, 1.0, &pose, 1e-9).is_some();
                        met += u32::from(meets);
                        left_out += u32::from(!offered.contains(&[a, b]));
                        assert!(
                            !meets || offered.contains(&[a, b]),
                            "round {round}: {a} meets {b} on {motion:?} from {from}"
                        );
                    }
                }
            }
        }
        assert!(met > 2_500 && left_out > 25_000, "{met} met, {left_out} left out");
    }

    #[test]
    fn facets_in_a_bore_are_apart_all_along() {
        let facets = |sides: u32, radius: f64, height: f64| -> Vec<Triangle> {
            let corner = |i: u32, z: f64| {
                let angle = TAU * f64::from(i) / f64::from(sides) + 0.1;
                [radius * angle.cos(), radius * angle.sin(), z]
            };
            (0..sides)
                .flat_map(|i| {
                    let [a, b, c, d] = [corner(i, 0.0), corner(i + 1, 0.0), corner(i + 1, height), corner(i, height)];
                    [[a, b, c], [a, c, d]]
                })
                .collect()
        };
        let (own, others) = (facets(48, 1.0, 3.0), facets(60, 1.01, 2.0));
        let tool = tool_of(&own);
        let far = Pose::IDENTITY.translated(&[0.0, 0.0, 5.0]).unwrap();
        for (motion, most) in [
            (Motion::new(&tool, &Pose::IDENTITY, &far), 0),
            (
                Motion::screw(&tool, &Pose::IDENTITY, &Screw::new(&[0.0, 0.0, 1.0], &[0.0; 3], 30.0, 0.0).unwrap())
                    .unwrap(),
                0,
            ),
            (Motion::new(&tool, &Pose::IDENTITY, &Pose::IDENTITY.translated(&[0.1, 0.0, 0.0]).unwrap()), usize::MAX),
        ] {
            let screen = Screen::of(motion.steady(0.0)).unwrap();
            let (mut of_tool, mut of_mockup) = (Vec::new(), Vec::new());
            own.iter().for_each(|t| screen.cast(0, t, motion.stray(), None, &mut of_tool));
            others.iter().for_each(|t| screen.cast(0, t, 0.0, None, &mut of_mockup));
            let mut left = 0usize;
            screen.meeting(&Shadows::new(of_tool), &Shadows::new(of_mockup), usize::MAX, &mut |_, _| {
                left += 1;
                true
            });
            assert!(left <= most && (most == 0 || left > 0), "{left} left of {motion:?}");
        }
    }
}
