//! Bodies that move, by number.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::Arc;

use rayon::prelude::*;

use super::body::Body;
use super::near_boxes::{BoxOf, Boxes};
use super::shape::Shape;
use super::two_bodies::{
    closest, is_meeting, meeting, needs, too_many, tool_and_mockup, Found, ToolAndMockup, TwoScratch,
};
use crate::error::{Error, Result};
use crate::geometry::bounds::Point;
use crate::geometry::intersect_triangle_triangle::PairKind;
use crate::geometry::pose::Pose;
use crate::progress::GoOn;
use crate::scratch_pool::ScratchPool;

/// Bodies that move: each against each, or against those of another set. Each is a [`Shape`] at a pose; bodies of one
/// shape share it.
///
/// Two bodies meet if and only if exact rational arithmetic says that two of their closed triangles share a point, on
/// corners that [`Pose::apply`] computes, for both; or if one is [solid](Shape::solid_if_convex) and a whole connected
/// surface of the other is in it. That one body moves and the other does not changes nothing. A copy of a set shares
/// its bodies, and costs a word each.
///
/// ```
/// use std::sync::Arc;
/// use feeler_core::{Bodies, Pose, Shape, Who};
///
/// // Three tetrahedra in a row: the second touches the first, the third is 1 m from the second.
/// let vertices = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let shape = Arc::new(Shape::new(vertices, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], u64::MAX)?);
/// let mut bodies = Bodies::default();
/// for x in [0.0, 1.0, 3.0] {
///     bodies.add(Arc::clone(&shape), Pose::IDENTITY.translated(&[x, 0.0, 0.0])?);
/// }
/// assert_eq!(bodies.meeting(Who::Each)?, [[0, 1]]);
/// assert_eq!(bodies.closest(Who::One(2), f64::INFINITY)?.map(|gap| (gap.bodies, gap.distance)), Some(([2, 1], 1.0)));
/// # Ok::<(), feeler_core::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Bodies {
    bodies: Vec<Option<Arc<Body>>>,
    /// Numbers of removed bodies.
    free: Vec<u32>,
    pool: Arc<ScratchPool<TwoScratch>>,
    memory_limit: Option<u64>,
}

/// Which pairs of bodies are asked.
#[derive(Debug, Clone, Copy)]
pub enum Who<'a> {
    /// Each with each, the lower number first.
    Each,
    /// One with each other, that one first.
    One(u32),
    /// Each with each of another set, that one second.
    Others(&'a Bodies),
}

/// Two triangles of two bodies that meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyContact {
    /// The bodies.
    pub bodies: [u32; 2],
    /// A triangle of each.
    pub triangles: [u32; 2],
    /// How they meet; `None` where one body is inside the other: then they are the closest.
    pub kind: Option<PairKind>,
    /// A point that both have, or the middle between the closest; world, metres.
    pub point: Point,
}

/// The closest points of two bodies' surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyGap {
    /// The bodies.
    pub bodies: [u32; 2],
    /// A triangle of each.
    pub triangles: [u32; 2],
    /// Metres; 0 if and only if the triangles meet.
    pub distance: f64,
    /// The closest point of each, world, metres.
    pub points: [Point; 2],
}

impl Bodies {
    /// No bodies; the most bytes that the result of a query may take.
    pub fn with_memory_limit(bytes: u64) -> Bodies {
        Bodies { memory_limit: Some(bytes), ..Bodies::default() }
    }

    /// Adds a body and returns its number. Numbers of removed bodies are used again.
    pub fn add(&mut self, shape: Arc<Shape>, pose: Pose) -> u32 {
        let body = Some(Arc::new(Body::new(shape, pose)));
        if let Some(number) = self.free.pop() {
            self.bodies[number as usize] = body;
            return number;
        }
        self.bodies.push(body);
        self.bodies.len() as u32 - 1
    }

    /// Removes a body. Errors: no such body.
    pub fn remove(&mut self, body: u32) -> Result<()> {
        self.body(body)?;
        self.bodies[body as usize] = None;
        self.free.push(body);
        Ok(())
    }

    /// Moves a body. Errors: no such body.
    pub fn set_pose(&mut self, body: u32, pose: Pose) -> Result<()> {
        let old = self.body(body)?;
        if *old.pose() != pose {
            self.bodies[body as usize] = Some(Arc::new(Body::new(Arc::clone(old.shape()), pose)));
        }
        Ok(())
    }

    /// The shape of a body, and its pose `world_from_body`. Errors: no such body.
    pub fn placed(&self, body: u32) -> Result<(&Arc<Shape>, &Pose)> {
        self.body(body).map(|body| (body.shape(), body.pose()))
    }

    /// The numbers of the bodies, ascending.
    pub fn numbers(&self) -> impl Iterator<Item = u32> + '_ {
        self.boxes(false).map(|b| b.id)
    }

    /// Whether any bodies meet. Errors: no such body, and more memory for an index than its shape allows.
    pub fn is_meeting(&self, who: Who<'_>) -> Result<bool> {
        self.is_meeting_while(who, GoOn::default())
    }

    /// The pairs of bodies that meet, sorted. Errors as [`is_meeting`](Self::is_meeting).
    pub fn meeting(&self, who: Who<'_>) -> Result<Vec<[u32; 2]>> {
        self.meeting_while(who, GoOn::default())
    }

    /// Every pair of triangles of different bodies that meets, sorted by bodies, then triangles. Errors as
    /// [`is_meeting`](Self::is_meeting), and more of them than memory allows.
    pub fn contacts(&self, who: Who<'_>) -> Result<Vec<BodyContact>> {
        self.contacts_while(who, GoOn::default())
    }

    /// The closest pair of bodies whose surfaces are at most `within` (metres) apart; of several, the first by bodies
    /// and triangles, and of several that meet, any. Errors as [`is_meeting`](Self::is_meeting).
    pub fn closest(&self, who: Who<'_>, within: f64) -> Result<Option<BodyGap>> {
        self.closest_while(who, within, GoOn::default())
    }

    /// [`is_meeting`](Self::is_meeting), which stops with [`Error::Cancelled`] where a function says so.
    pub fn is_meeting_while(&self, who: Who<'_>, go_on: GoOn<'_>) -> Result<bool> {
        let pairs = self.near(who)?;
        self.prepare(who, &pairs)?;
        let ask = |pair: &[u32; 2]| self.asked(who, *pair, |a, b, s| is_meeting(a, b, go_on, s));
        // The first error or meeting ends it.
        pairs.par_iter().map(ask).find_any(|answer| !matches!(answer, Ok(false))).unwrap_or(Ok(false))
    }

    /// [`meeting`](Self::meeting), stopped as [`is_meeting_while`](Self::is_meeting_while).
    pub fn meeting_while(&self, who: Who<'_>, go_on: GoOn<'_>) -> Result<Vec<[u32; 2]>> {
        let mut pairs = self.near(who)?;
        self.prepare(who, &pairs)?;
        let meet = |pair: &[u32; 2]| self.asked(who, *pair, |a, b, s| is_meeting(a, b, go_on, s));
        let meets: Vec<bool> = pairs.par_iter().map(meet).collect::<Result<_>>()?;
        let mut meets = meets.into_iter();
        pairs.retain(|_| meets.next().unwrap_or(false));
        Ok(pairs)
    }

    /// [`contacts`](Self::contacts), stopped as [`is_meeting_while`](Self::is_meeting_while).
    pub fn contacts_while(&self, who: Who<'_>, go_on: GoOn<'_>) -> Result<Vec<BodyContact>> {
        let pairs = self.near(who)?;
        self.prepare(who, &pairs)?;
        let limit = self.memory_limit.unwrap_or(u64::MAX) / size_of::<(BodyContact, Found)>() as u64;
        let most = usize::try_from(limit).unwrap_or(usize::MAX);
        let count = AtomicU64::new(0);
        let of_pair = |bodies: &[u32; 2]| -> Result<Vec<BodyContact>> {
            let found = self.asked(who, *bodies, |a, b, s| meeting(a, b, most, go_on, s))?;
            let so_far = count.fetch_add(found.len() as u64, Ordering::Relaxed) as usize + found.len();
            if so_far > most {
                return Err(too_many(so_far, most));
            }
            Ok(found.into_iter().map(|found| contact(*bodies, &found)).collect())
        };
        Ok(pairs.par_iter().map(of_pair).collect::<Result<Vec<_>>>()?.concat())
    }

    /// [`closest`](Self::closest), stopped as [`is_meeting_while`](Self::is_meeting_while).
    pub fn closest_while(&self, who: Who<'_>, within: f64, go_on: GoOn<'_>) -> Result<Option<BodyGap>> {
        let boxes = self.boxes_of(who)?;
        let within = boxes.surely_within().min(within);
        let mut pairs = boxes.near_pairs(within);
        pairs.sort_unstable_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        // Distances are not negative, so that their bits are ordered as they are.
        let best = AtomicU64::new(within.to_bits());
        let of_pair = |(bodies, gap): &([u32; 2], f64)| -> Result<Option<BodyGap>> {
            let within = f64::from_bits(best.load(Ordering::Relaxed));
            if *gap > within {
                return Ok(None);
            }
            let found = self.asked(who, *bodies, |a, b, s| closest(a, b, within, go_on, s))?;
            let gap = found.map(|Found { triangles, closest, .. }| {
                let (distance, points) = (closest.distance, [closest.on_p, closest.on_q]);
                BodyGap { bodies: *bodies, triangles, distance, points }
            });
            if let Some(gap) = &gap {
                best.fetch_min(gap.distance.to_bits(), Ordering::Relaxed);
            }
            Ok(gap)
        };
        // The nearest boxes alone first: most others need no look then.
        let alone = pairs.len().min(1);
        let first = pairs[..alone].iter().map(of_pair).collect::<Result<Vec<_>>>()?;
        let rest = pairs[alone..].par_iter().map(of_pair).collect::<Result<Vec<_>>>()?;
        let order = |a: &BodyGap, b: &BodyGap| {
            a.distance.total_cmp(&b.distance).then((a.bodies, a.triangles).cmp(&(b.bodies, b.triangles)))
        };
        Ok(first.into_iter().chain(rest).flatten().min_by(order))
    }

    /// No less than the least translation (metres) that parts two bodies: along an axis of the world, by their boxes.
    #[doc(hidden)]
    pub fn parted_by(&self, who: Who<'_>, [a, b]: [u32; 2]) -> Result<f64> {
        let (a, b) = (*self.body(a)?.bounds(), *self.second(who, b)?.bounds());
        let along = |i: usize| (a.upper[i] - b.lower[i]).min(b.upper[i] - a.lower[i]);
        Ok((0..3).map(along).fold(f64::INFINITY, f64::min))
    }

    /// The shapes and poses of two bodies. Errors: no such body.
    #[doc(hidden)]
    pub fn pair<'a>(&'a self, who: Who<'a>, [a, b]: [u32; 2]) -> Result<[(&'a Arc<Shape>, &'a Pose); 2]> {
        Ok([self.body(a)?, self.second(who, b)?].map(|body| (body.shape(), body.pose())))
    }

    /// Two bodies as tool and mock-up. Errors: no such body.
    #[doc(hidden)]
    pub fn as_tool_and_mockup(&self, who: Who<'_>, [a, b]: [u32; 2]) -> Result<ToolAndMockup> {
        tool_and_mockup(self.body(a)?, self.second(who, b)?)
    }

    /// The pairs of bodies whose boxes overlap, sorted.
    fn near(&self, who: Who<'_>) -> Result<Vec<[u32; 2]>> {
        let mut pairs: Vec<_> = self.boxes_of(who)?.near_pairs(0.0).into_iter().map(|(pair, _)| pair).collect();
        pairs.sort_unstable();
        Ok(pairs)
    }

    /// Makes what the pairs need of their shapes, in parallel, and each once.
    fn prepare(&self, who: Who<'_>, pairs: &[[u32; 2]]) -> Result<()> {
        let mut needed = Vec::new();
        for [a, b] in pairs {
            needs(self.body(*a)?, self.second(who, *b)?, &mut needed);
        }
        needed.sort_unstable_by_key(|(shape, is_moving)| (Arc::as_ptr(shape), *is_moving));
        needed.dedup_by_key(|(shape, is_moving)| (Arc::as_ptr(shape), *is_moving));
        needed.par_iter().try_for_each(
            |(shape, is_moving)| {
                if *is_moving {
                    shape.tool().map(drop)
                } else {
                    shape.scene().map(drop)
                }
            },
        )
    }

    fn asked<T>(
        &self,
        who: Who<'_>,
        [a, b]: [u32; 2],
        ask: impl FnOnce(&Body, &Body, &mut TwoScratch) -> Result<T>,
    ) -> Result<T> {
        let (a, b) = (self.body(a)?, self.second(who, b)?);
        self.pool.with(|scratch| ask(a, b, scratch))
    }

    fn body(&self, number: u32) -> Result<&Body> {
        self.bodies.get(number as usize).and_then(Option::as_deref).ok_or(Error::NoSuchBody { body: number })
    }

    /// The second body of a pair.
    fn second<'a>(&'a self, who: Who<'a>, number: u32) -> Result<&'a Body> {
        match who {
            Who::Others(others) => others.body(number),
            Who::Each | Who::One(_) => self.body(number),
        }
    }

    fn boxes(&self, is_second: bool) -> impl Iterator<Item = BoxOf> + '_ {
        let numbered = self.bodies.iter().zip(0..).filter_map(|(body, id)| Some((body.as_deref()?, id)));
        numbered.map(move |(body, id)| BoxOf { bounds: *body.bounds(), id, is_second })
    }

    /// The boxes of those asked.
    fn boxes_of(&self, who: Who<'_>) -> Result<Boxes> {
        Ok(match who {
            Who::Each => Boxes::new(self.boxes(false).collect(), false),
            Who::Others(others) => Boxes::new(self.boxes(false).chain(others.boxes(true)).collect(), true),
            Who::One(number) => {
                let one = BoxOf { bounds: *self.body(number)?.bounds(), id: number, is_second: false };
                let others = self.boxes(true).filter(|b| b.id != number);
                Boxes::new(std::iter::once(one).chain(others).collect(), true)
            }
        })
    }
}

fn contact(bodies: [u32; 2], found: &Found) -> BodyContact {
    let Found { triangles, kind, closest } = *found;
    let point = std::array::from_fn(|a| 0.5 * (closest.on_p[a] + closest.on_q[a]));
    BodyContact { bodies, triangles, kind, point }
}
