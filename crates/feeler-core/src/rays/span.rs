//! The range of a ray that sections keep: its intersection with all half spaces.

use std::cmp::Ordering;

use super::ratio::Ratio;
use super::ray::{HalfSpace, Ray};
use crate::constants::{TIME_SURE, VANISHING};
use crate::geometry::predicates::whole_numbers;

/// A place along a ray: shares of its direction.
#[derive(Debug, Clone)]
pub struct Place {
    /// Right within [`TIME_SURE`] of itself.
    pub t: f64,
    /// Exactly, where that was found.
    pub ratio: Option<Ratio>,
}

/// A closed range of places, of 0 or more.
#[derive(Debug, Clone)]
pub struct Span {
    /// 0 is without a ratio.
    pub from: Place,
    /// `None`: no end.
    pub to: Option<Place>,
}

impl Place {
    /// The origin.
    pub const ORIGIN: Place = Place { t: 0.0, ratio: None };

    pub fn exact(ratio: Ratio) -> Place {
        Place { t: ratio.to_f64(), ratio: Some(ratio) }
    }

    /// Which of two places comes first: by their numbers, and exactly if these are too close.
    pub fn compare(
        &mut self,
        other: &mut Place,
        own_ratio: impl FnOnce() -> Ratio,
        other_ratio: impl FnOnce() -> Ratio,
    ) -> Ordering {
        // Each is off by its share, and next to the least float64 by more.
        let doubt = 2.0 * TIME_SURE * (self.t.abs() + other.t.abs()) + VANISHING;
        if (self.t - other.t).abs() > doubt {
            return self.t.total_cmp(&other.t);
        }
        let own = self.ratio.get_or_insert_with(own_ratio);
        own.compare(other.ratio.get_or_insert_with(other_ratio))
    }
}

impl Span {
    /// The range of a ray that all sections keep; `None`: nothing.
    pub fn new(ray: &Ray, sections: &[HalfSpace]) -> Option<Span> {
        let mut span = Span { from: Place::ORIGIN, to: None };
        for section in sections {
            // normal . (origin + t direction) >= offset, in whole numbers of one unit.
            let ([n, o, d], [offset, one]) = ([section.normal, ray.origin, ray.direction], [section.offset, 1.0]);
            let w = whole_numbers([n[0], n[1], n[2], o[0], o[1], o[2], d[0], d[1], d[2], offset, one]);
            let dot = |at: usize| &w[0] * &w[at] + &w[1] * &w[at + 1] + &w[2] * &w[at + 2];
            let (rate, needed) = (dot(6), &w[9] * &w[10] - dot(3));
            match rate.sign() {
                num_bigint::Sign::NoSign if needed.sign() == num_bigint::Sign::Plus => return None,
                num_bigint::Sign::NoSign => {}
                num_bigint::Sign::Plus => {
                    let from = Ratio::new(needed, rate);
                    let is_later = match &span.from.ratio {
                        Some(so_far) => from.compare(so_far) == Ordering::Greater,
                        None => !from.is_negative(),
                    };
                    if is_later {
                        span.from = Place::exact(from);
                    }
                }
                num_bigint::Sign::Minus => {
                    let to = Ratio::new(needed, rate);
                    let so_far = span.to.as_ref().and_then(|to| to.ratio.as_ref());
                    if so_far.is_none_or(|so_far| to.compare(so_far) == Ordering::Less) {
                        span.to = Some(Place::exact(to));
                    }
                }
            }
        }
        let from = span.from.ratio.clone().unwrap_or_else(Ratio::zero);
        let ends_before = |to: &Place| to.ratio.as_ref().is_some_and(|to| to.compare(&from) == Ordering::Less);
        (!span.to.as_ref().is_some_and(ends_before)).then_some(span)
    }

    /// Whether a place lies in it.
    pub fn has(&self, place: &mut Place, ratio: impl Fn() -> Ratio) -> bool {
        let is_begun = place.compare(&mut self.from.clone(), &ratio, Ratio::zero) != Ordering::Less;
        is_begun
            && self
                .to
                .as_ref()
                .is_none_or(|to| place.compare(&mut to.clone(), &ratio, Ratio::zero) != Ordering::Greater)
    }
}
