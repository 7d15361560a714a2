//! Pairs of boxes that overlap, or are near: sorted along one axis and swept (D. Baraff: *Dynamic simulation of
//! non-penetrating rigid bodies*, 1992).

use crate::constants::ROOT_ROUNDING;
use crate::geometry::bounds::Aabb;
use crate::geometry::distance_triangle_triangle::distance_bound;

/// The box of a body.
#[derive(Debug, Clone, Copy)]
pub(super) struct BoxOf {
    pub bounds: Aabb,
    /// The body.
    pub id: u32,
    /// Boxes of two groups are paired across, those of one each with each.
    pub is_second: bool,
}

/// Boxes in order along an axis.
pub(super) struct Boxes {
    boxes: Vec<BoxOf>,
    axis: usize,
    is_two_groups: bool,
}

impl Boxes {
    pub fn new(mut boxes: Vec<BoxOf>, is_two_groups: bool) -> Boxes {
        let axis = best_axis(&boxes);
        let place = |b: &BoxOf| (b.id, b.is_second);
        boxes.sort_unstable_by(|a, b| {
            a.bounds.lower[axis].total_cmp(&b.bounds.lower[axis]).then(place(a).cmp(&place(b)))
        });
        Boxes { boxes, axis, is_two_groups }
    }

    /// A distance (metres) that some pair is surely within: that of the farthest corners of boxes that follow each
    /// other.
    pub fn surely_within(&self) -> f64 {
        let (mut last, mut within) = ([None; 2], f64::INFINITY);
        for b in &self.boxes {
            let group = usize::from(b.is_second);
            let other: Option<BoxOf> = last[if self.is_two_groups { 1 - group } else { group }];
            if let Some(a) = other {
                within = farthest(&a.bounds, &b.bounds).min(within);
            }
            last[group] = Some(*b);
        }
        within
    }

    /// Each pair of boxes that are at most `within` apart, and by how much. Of one group the lower number is first; of
    /// two, the first's.
    pub fn near_pairs(&self, within: f64) -> Vec<([u32; 2], f64)> {
        let mut pairs = Vec::new();
        for (i, a) in self.boxes.iter().enumerate() {
            for b in &self.boxes[i + 1..] {
                // Rounded as in `distance_bound`.
                if (b.bounds.lower[self.axis] - a.bounds.upper[self.axis]) * (1.0 - ROOT_ROUNDING) > within {
                    break;
                }
                if self.is_two_groups && a.is_second == b.is_second {
                    continue;
                }
                let gap = match within == 0.0 {
                    true if a.bounds.is_overlapping(&b.bounds) => 0.0,
                    true => continue,
                    false => distance_bound(&a.bounds, &b.bounds),
                };
                if gap <= within {
                    let is_turned = if self.is_two_groups { a.is_second } else { a.id > b.id };
                    pairs.push((if is_turned { [b.id, a.id] } else { [a.id, b.id] }, gap));
                }
            }
        }
        pairs
    }
}

/// No less than the distance of any two points of two boxes.
fn farthest(a: &Aabb, b: &Aabb) -> f64 {
    let along = |i: usize| (a.upper[i] - b.lower[i]).max(b.upper[i] - a.lower[i]);
    let largest = (0..3).map(along).fold(0.0, f64::max);
    // Of three sides none of which is longer.
    2.0 * largest
}

/// The axis along which the boxes are spread widest, for their size.
fn best_axis(boxes: &[BoxOf]) -> usize {
    let spread = |axis: usize| {
        let (mut lower, mut upper, mut sides) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
        for b in boxes {
            lower = b.bounds.lower[axis].min(lower);
            upper = b.bounds.upper[axis].max(upper);
            sides += b.bounds.upper[axis] - b.bounds.lower[axis];
        }
        if sides > 0.0 {
            (upper - lower) / sides
        } else {
            f64::MAX
        }
    };
    (0..3).max_by(|a, b| spread(*a).total_cmp(&spread(*b))).unwrap_or(0)
}
