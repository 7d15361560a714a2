//! Chains of joints: one motion that is a product of screws and slides, each at its own constant rate.
//!
//! Bounds of speed and acceleration after F. Schwarzer, M. Saha and J.-C. Latombe, *Adaptive dynamic collision checking
//! for single and multiple articulated robots in complex environments* (2005), and X. Zhang, S. Redon, M. Lee and
//! Y. Kim, *Continuous collision detection for articulated models using Taylor models and temporal culling* (2007):
//! from the last joint to the first, each joint adds what it does to a point at its largest distance from the axis.

use std::sync::Arc;

use super::screw::Screw;
use crate::constants::{ARC_ROUNDING, LARGEST_COORDINATE, MOTION_ROUNDOFFS, UNIT_ROUNDOFF};
use crate::error::{Error, Result};
use crate::geometry::bounds::Point;
use crate::geometry::pose::Pose;
use crate::geometry::twist::{product, times, turn, Matrix};
use crate::geometry::vectors::{add, any_length, cross, dot, largest, length, scaled, sub};

/// Sine of the angle up to which two axes are the same direction.
const PARALLEL: f64 = 1e-14;

/// One joint of a [`Chain`], at a constant rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Joint {
    /// About an axis and along it.
    Screw(Screw),
    /// Straight, metres, world.
    Slide(Point),
}

/// A motion `S1(t) S2(t) ... Sn(t)`, t from 0 to 1: the first joint carries all the others.
///
/// Axes and directions are those in the world at the start.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    joints: Arc<[Joint]>,
}

/// A joint in numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Link {
    /// Unit; of a slide any.
    axis: Point,
    /// On the axis.
    point: Point,
    /// Radians.
    angle: f64,
    /// Metres along the axis, or anyhow where it does not turn.
    way: Point,
}

impl Link {
    fn of(joint: &Joint) -> Link {
        match joint {
            Joint::Screw(screw) => {
                Link { axis: *screw.axis(), point: *screw.point(), angle: screw.angle(), way: screw.way() }
            }
            Joint::Slide(way) => Link { axis: [0.0, 0.0, 1.0], point: [0.0; 3], angle: 0.0, way: *way },
        }
    }

    fn joint(&self) -> Result<Joint> {
        if self.angle == 0.0 {
            return Ok(Joint::Slide(self.way));
        }
        let pitch = dot(&self.way, &self.axis) / self.angle * std::f64::consts::TAU;
        Ok(Joint::Screw(Screw::new(&self.axis, &self.point, self.angle, pitch)?))
    }

    fn is_nothing(&self) -> bool {
        self.angle == 0.0 && self.way == [0.0; 3]
    }

    /// Both at once, where one follows the other as one joint would.
    fn with(&self, next: &Link) -> Option<Link> {
        let is_along = |way: &Point, axis: &Point| *way == scaled(axis, dot(way, axis));
        let way = add(&self.way, &next.way);
        match (self.angle == 0.0, next.angle == 0.0) {
            (true, true) => Some(Link { way, ..*self }),
            (false, true) => is_along(&next.way, &self.axis).then_some(Link { way, ..*self }),
            (true, false) => is_along(&self.way, &next.axis).then_some(Link { way, ..*next }),
            (false, false) => {
                let is_same = self.axis == next.axis && self.point == next.point;
                let is_opposed = self.axis == scaled(&next.axis, -1.0) && self.point == next.point;
                let by = if is_opposed { -next.angle } else { next.angle };
                (is_same || is_opposed).then_some(Link { angle: self.angle + by, way, ..*self })
            }
        }
    }

    /// A rotation, then a shift, at a time.
    fn at(&self, time: f64) -> (Matrix, Point) {
        (turn(&self.axis, self.angle * time), scaled(&self.way, time))
    }

    fn place(&self, (turned, way): &(Matrix, Point), x: &Point) -> Point {
        if self.angle == 0.0 {
            return add(x, way);
        }
        add(&add(&self.point, way), &times(turned, &sub(x, &self.point)))
    }
}

impl Chain {
    /// Of joints, the one that carries all the others first.
    ///
    /// Errors: a slide that is not finite or too large.
    pub fn new(joints: impl Into<Vec<Joint>>) -> Result<Chain> {
        let joints: Vec<Joint> = joints.into();
        for joint in &joints {
            let Joint::Slide(way) = joint else { continue };
            if let Some(value) = way.iter().find(|x| !x.is_finite() || x.abs() > LARGEST_COORDINATE) {
                return Err(Error::Screw {
                    what: "way of the slide",
                    value: *value,
                    must: "finite and at most 1e100 in size",
                });
            }
        }
        Ok(Chain { joints: joints.into() })
    }

    /// Its joints, the one that carries all the others first.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// A pose after a share of it, 0 to 1 as a rule.
    ///
    /// Errors: a share that is not finite, and a pose beyond the coordinate limit.
    pub fn at(&self, pose: &Pose, share: f64) -> Result<Pose> {
        self.joints.iter().rev().try_fold(*pose, |pose, joint| match joint {
            Joint::Screw(screw) => screw.at(&pose, share),
            Joint::Slide(way) => pose.translated(&scaled(way, share)),
        })
    }

    /// A share of it, from 0 to 1.
    #[must_use]
    pub fn share(&self, share: f64) -> Chain {
        let joints = self.joints.iter().map(|joint| match joint {
            Joint::Screw(screw) => Joint::Screw(screw.share(share)),
            Joint::Slide(way) => Joint::Slide(scaled(way, share)),
        });
        Chain { joints: joints.collect() }
    }

    /// The rest of it from a time on, begun where it is then. Errors: axes that come beyond the coordinate limit.
    pub fn rest(&self, time: f64) -> Result<Chain> {
        self.from(time, 1.0 - time)
    }

    /// The way back, begun at its end. Errors as [`rest`](Self::rest).
    pub fn reversed(&self) -> Result<Chain> {
        self.from(1.0, -1.0)
    }

    /// With the axes where they are at a time, and the rates times a factor.
    fn from(&self, time: f64, by: f64) -> Result<Chain> {
        let links: Vec<Link> = self.joints.iter().map(Link::of).collect();
        let mut moved = Vec::with_capacity(links.len());
        for (n, link) in links.iter().enumerate() {
            let mut now = Link { angle: link.angle * by, way: scaled(&link.way, by), ..*link };
            for before in links[..n].iter().rev() {
                let at = before.at(time);
                now.point = before.place(&at, &now.point);
                now.axis = times(&at.0, &now.axis);
                now.way = times(&at.0, &now.way);
            }
            moved.push(now.joint()?);
        }
        Chain::new(moved)
    }

    /// How it looks from a body that itself moves along another chain meanwhile: a scene of that body alone, where it is at the start,
    /// stands still. Joints that both have in common drop out.
    #[must_use]
    pub fn relative_to(&self, other: &Chain) -> Chain {
        let common = self.joints.iter().zip(&*other.joints).take_while(|(a, b)| a == b).count();
        let back = other.joints[common..].iter().rev().map(|joint| match joint {
            Joint::Screw(screw) => Joint::Screw(screw.reversed()),
            Joint::Slide(way) => Joint::Slide(scaled(way, -1.0)),
        });
        Chain { joints: back.chain(self.joints[common..].iter().copied()).collect() }
    }

    /// The same in as few joints as it takes: none where nothing moves.
    pub(super) fn shortened(&self) -> Result<Vec<Joint>> {
        let mut links: Vec<Link> = Vec::new();
        for joint in &*self.joints {
            let mut link = Link::of(joint);
            while let Some(both) = links.last().and_then(|last| last.with(&link)) {
                links.pop();
                link = both;
            }
            if !link.is_nothing() {
                links.push(link);
            }
        }
        links.iter().map(Link::joint).collect()
    }
}

/// How a body moves at a time: the velocity of its point at `centre`, and its rotation; metres and radians for the whole way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spin {
    centre: Point,
    linear: Point,
    angular: Point,
}

impl Spin {
    /// Of the point at a place.
    #[inline]
    pub(crate) fn velocity(&self, place: &Point) -> Point {
        add(&self.linear, &cross(&self.angular, &sub(place, &self.centre)))
    }
}

/// Bounds that hold for some points during a span of time, metres for the whole way.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Rates {
    pub speed: f64,
    pub acceleration: f64,
}

/// The joints at a time, in numbers.
pub(crate) type Turned = Vec<(Matrix, Point)>;

/// The motion of one tool along a chain.
#[derive(Debug, Clone)]
pub(super) struct Linked {
    pub chain: Chain,
    links: Vec<Link>,
    /// Of each joint but the last: how far the next joint's point is from its axis.
    arms: Vec<f64>,
    /// And from its point.
    spans: Vec<f64>,
    start: Pose,
    /// Of the tool, in its frame and at the start.
    pivot: Point,
    at_start: Point,
    /// The direction of all axes that turn, where it is one.
    common: Option<Point>,
    /// Radians, all together.
    pub angle: f64,
    /// Corners of the tool's box at the start.
    corners: [Point; 8],
    /// Of the whole tool on the whole way.
    pub rates: Rates,
    /// Metres per axis.
    pub rounding: f64,
    stray_velocity: f64,
}

impl Linked {
    /// `joints`: at least one; `corners` of the tool's box, in its frame.
    pub fn new(chain: &Chain, joints: &[Joint], start: &Pose, pivot: &Point, corners: &[Point; 8]) -> Linked {
        let at_start = start.apply(pivot);
        let mut links: Vec<Link> = joints.iter().map(Link::of).collect();
        // A point of each axis near the tool; a slide has the next joint's.
        let mut next = at_start;
        for (link, joint) in links.iter_mut().zip(joints).rev() {
            link.point = match joint {
                Joint::Screw(screw) => screw.foot(&at_start),
                Joint::Slide(_) => next,
            };
            next = link.point;
        }
        let between = |of: &dyn Fn(&Link, &Point) -> f64| links.windows(2).map(|w| of(&w[0], &w[1].point)).collect();
        let arms = between(&|link, point| off_axis(link, point));
        let spans = between(&|link, point| any_length(&sub(point, &link.point)));
        let angle: f64 = links.iter().map(|link| link.angle.abs()).sum();
        let mut linked = Linked {
            chain: chain.clone(),
            arms,
            spans,
            start: *start,
            pivot: *pivot,
            at_start,
            common: common_axis(&links),
            angle,
            corners: corners.map(|corner| start.apply(&corner)),
            rates: Rates::default(),
            rounding: 0.0,
            stray_velocity: 0.0,
            links,
        };
        linked.rates = linked.rates_of(&linked.corners, &linked.turned(0.0), 0.0, 1.0);
        // All numbers that a place is made of.
        let own = largest(pivot) + corners.iter().map(largest).fold(0.0, f64::max);
        let joints = linked.links.iter().map(|link| largest(&link.point) + largest(&link.way)).fold(0.0, f64::max);
        let far = linked.corners.iter().map(largest).fold(0.0, f64::max);
        let coordinates = own + joints + far + linked.rates.speed.min(reach_of(&linked));
        let number = linked.links.len() as f64;
        linked.rounding = MOTION_ROUNDOFFS * UNIT_ROUNDOFF * (number + angle) * coordinates + f64::MIN_POSITIVE;
        linked.stray_velocity = 64.0 * number * UNIT_ROUNDOFF * (linked.rates.speed + angle * coordinates)
            + (1.0 + angle) * linked.rounding;
        linked
    }

    pub fn turned(&self, time: f64) -> Turned {
        self.links.iter().map(|link| link.at(time)).collect()
    }

    pub fn at(&self, time: f64) -> Pose {
        let mut rotation = *self.start.rotation();
        let mut place = self.at_start;
        for link in self.links.iter().rev() {
            let at = link.at(time);
            place = link.place(&at, &place);
            if link.angle != 0.0 {
                rotation = product(&at.0, &rotation);
            }
        }
        Pose::unchecked(rotation, sub(&place, &times(&rotation, &self.pivot)))
    }

    /// How the tool moves at a time.
    pub fn spin(&self, time: f64) -> Spin {
        // From the last joint to the first: each turns the motion that the later ones make, and adds its own.
        let (mut centre, mut linear, mut angular) = (self.at_start, [0.0; 3], [0.0; 3]);
        for link in self.links.iter().rev() {
            let at = link.at(time);
            centre = link.place(&at, &centre);
            if link.angle != 0.0 {
                let own = scaled(&link.axis, link.angle);
                linear = add(&times(&at.0, &linear), &cross(&own, &sub(&centre, &link.point)));
                angular = add(&times(&at.0, &angular), &own);
            }
            linear = add(&linear, &link.way);
        }
        Spin { centre, linear, angular }
    }

    /// Bounds for all points in the convex hull of some, given by their places at the start, from a time on for a span; `turned` is
    /// that time's.
    pub fn rates_of(&self, places: &[Point], turned: &Turned, from: f64, span: f64) -> Rates {
        let mut points: [Point; 8] = [[0.0; 3]; 8];
        let points = &mut points[..places.len()];
        points.copy_from_slice(places);
        let (mut speed, mut acceleration) = (0.0f64, 0.0f64);
        // How far any of the points comes from the point of the joint after this one, before that turns it; and its advance.
        let mut far = 0.0f64;
        let mut advance = 0.0;
        for (k, (link, at)) in self.links.iter().zip(turned).enumerate().rev() {
            let now = points.iter().map(|p| off_axis(link, p)).fold(0.0, f64::max);
            let mut radius = now + speed * span;
            if k + 1 == self.links.len() {
                far = points.iter().map(|p| any_length(&sub(p, &link.point))).fold(0.0, f64::max);
            } else {
                radius = radius.min(self.arms[k] + advance + far);
                far += self.spans[k] + advance;
            }
            let (angle, way) = (link.angle.abs(), any_length(&link.way));
            // The point turns about the axis, while the later joints move it.
            acceleration += angle * (angle * radius + 2.0 * speed);
            speed += (angle * radius).hypot(way);
            advance = way * (from + span);
            points.iter_mut().for_each(|p| *p = link.place(at, p));
        }
        let more = 1.0 + ARC_ROUNDING;
        let off = 4.0 * self.rounding;
        Rates {
            speed: speed * more + self.angle * off,
            acceleration: acceleration * more + self.angle * self.angle * off,
        }
    }

    /// For a triangle of the tool.
    pub fn rates_of_triangle(&self, triangle: &[Point; 3], turned: &Turned, from: f64, span: f64) -> Rates {
        self.rates_of(&triangle.map(|p| self.start.apply(&p)), turned, from, span)
    }

    /// For all of the tool.
    pub fn rates_between(&self, from: f64, to: f64) -> Rates {
        self.rates_of(&self.corners, &self.turned(from), from, to - from)
    }

    pub fn stray_velocity(&self) -> f64 {
        self.stray_velocity
    }

    /// The share of a direction in which points are accelerated, as a length.
    #[inline]
    pub fn across(&self, n: &Point) -> f64 {
        match &self.common {
            Some(axis) => length(&cross(n, axis)) + 1e-9 * length(n),
            None => length(n) * (1.0 + ARC_ROUNDING),
        }
    }

    /// How far a point of the tool moves, metres, by quadrature.
    pub fn way_of(&self, point: &Point) -> f64 {
        let pieces = 64.0 * (1.0 + self.angle).ceil();
        let speed = |time: f64| length(&self.spin(time).velocity(&self.at(time).apply(point)));
        (0..pieces as usize).map(|i| speed((i as f64 + 0.5) / pieces)).sum::<f64>() / pieces
    }
}

/// How far the joints' own points and ways lead, metres.
fn reach_of(linked: &Linked) -> f64 {
    let ways: f64 = linked.links.iter().map(|link| any_length(&link.way)).sum();
    let last = linked.links.last().map_or([0.0; 3], |link| link.point);
    let own = linked.corners.iter().map(|p| any_length(&sub(p, &last))).fold(0.0, f64::max);
    linked.spans.iter().sum::<f64>() + ways + own
}

fn off_axis(link: &Link, p: &Point) -> f64 {
    if link.angle == 0.0 {
        return 0.0;
    }
    any_length(&cross(&link.axis, &sub(p, &link.point)))
}

fn common_axis(links: &[Link]) -> Option<Point> {
    let mut axes = links.iter().filter(|link| link.angle != 0.0).map(|link| link.axis);
    let first = axes.next()?;
    axes.all(|axis| any_length(&cross(&axis, &first)) <= PARALLEL).then_some(first)
}
