//! An order in which neighbours in space are neighbours in memory, for trees whose nodes take a fixed number of entries.
//!
//! Entries are halved by the median of their middles, as in a k-d tree (J. Bentley 1975), along the axis that leaves the least
//! surface (the heuristic of J. Goldsmith and J. Salmon, 1987), again and again, always between whole nodes. Compared with an
//! order along a Morton curve the nodes' boxes overlap far less.

use crate::constants::SMALL_MESH;
use crate::geometry::bounds::{Aabb, Point};
use feeler_lanes::{greatest, least};

/// An entry to be ordered.
pub trait Entry: Copy + Send {
    /// The middle of its box: see [`Cells`].
    fn middle(&self) -> u64;
}

impl Entry for (u64, u32) {
    fn middle(&self) -> u64 {
        self.0
    }
}

/// Bits per axis of a middle; x is highest.
const BITS: u32 = 21;
const MASK: u64 = (1 << BITS) - 1;

/// A box divided into 2^21 cells along its longest side.
#[derive(Debug, Clone)]
pub struct Cells {
    origin: Point,
    per_unit: f64,
}

impl Cells {
    /// Cubic cells over `bounds`.
    pub fn new(bounds: &Aabb) -> Cells {
        let longest = bounds.longest();
        let per_unit = (1u64 << BITS) as f64 / longest;
        Cells { origin: bounds.lower, per_unit: if per_unit.is_finite() { per_unit } else { 0.0 } }
    }

    /// The cell of a box's middle.
    pub fn middle(&self, lower: &Point, upper: &Point) -> u64 {
        let cell = |a: usize| {
            let x = (0.5 * (lower[a] + upper[a]) - self.origin[a]) * self.per_unit;
            // NaN is 0 too. Fewer instructions than `clamp` and a cast to the type wanted.
            let x = if x > 0.0 { x } else { 0.0 };
            (if x < MASK as f64 { x } else { MASK as f64 }) as i32 as u64
        };
        cell(0) << (2 * BITS) | cell(1) << BITS | cell(2)
    }
}

/// Orders entries for a tree whose leaves take `fan_out` entries and whose nodes take `fan_out` children. All leaves but the
/// last are full, and so on upwards.
pub fn order<E: Entry>(entries: &mut [E], fan_out: usize) {
    if entries.len() <= fan_out {
        return;
    }
    // The largest node that is smaller than all entries together.
    let mut node = fan_out;
    while node.saturating_mul(fan_out) < entries.len() {
        node *= fan_out;
    }
    let middle = entries.len().div_ceil(node) / 2 * node;
    let axis = best_axis(entries, middle);
    // With the axis known, comparing is quick.
    match axis {
        0 => entries.select_nth_unstable_by_key(middle, |entry| turned(entry, 0)),
        1 => entries.select_nth_unstable_by_key(middle, |entry| turned(entry, 1)),
        _ => entries.select_nth_unstable_by_key(middle, |entry| turned(entry, 2)),
    };
    let (left, right) = entries.split_at_mut(middle);
    if left.len() + right.len() < SMALL_MESH {
        order(left, fan_out);
        order(right, fan_out);
    } else {
        rayon::join(|| order(left, fan_out), || order(right, fan_out));
    }
}

/// The places of a leaf's entries, at most `N`, in order along the longest side of the box around their middles: this
/// separates its halves, and near entries lie in few registers.
///
/// Counts for each entry how many come before it: no branch depends on them.
#[inline(always)]
pub fn places_in_leaf<E: Entry, const N: usize>(leaf: &[E]) -> [i32; N] {
    let mut middles = [leaf[0].middle(); N];
    for (middle, entry) in middles.iter_mut().zip(leaf) {
        *middle = entry.middle();
    }
    let mut cells = [[0i32; N]; 3];
    let (mut axis, mut longest) = (0, -1);
    for a in 0..3 {
        let (mut low, mut high) = (i32::MAX, 0);
        for i in 0..N {
            let cell = (middles[i] >> (BITS * (2 - a as u32)) & MASK) as i32;
            cells[a][i] = cell;
            low = if cell < low { cell } else { low };
            high = if cell > high { cell } else { high };
        }
        if high - low > longest {
            (axis, longest) = (a, high - low);
        }
    }
    // Cells, and then numbers: no two keys are equal, and entries outside the leaf come last.
    let mut keys = [0i32; N];
    for i in 0..N {
        keys[i] = if i < leaf.len() { cells[axis][i] * N as i32 + i as i32 } else { i32::MAX };
    }
    let mut places = [0i32; N];
    for i in 0..N {
        for other in 0..N {
            places[other] += i32::from(keys[other] > keys[i]);
        }
    }
    places
}

/// Entries that are looked at for choosing an axis: half of them, but at least and at most these numbers.
const LEAST_SAMPLE: usize = 64;
const SAMPLE: usize = 512;

/// The axis along which halving at `middle` gives the two boxes (of the entries' middles) the least surface, each weighted by
/// its number of entries: a box is met by others about as often as it has surface. Looks at an even sample.
fn best_axis<E: Entry>(entries: &[E], middle: usize) -> usize {
    let count = entries.len().div_ceil(2).clamp(LEAST_SAMPLE, SAMPLE).min(entries.len());
    let mut sample = [[0.0; 4]; SAMPLE];
    for (i, place) in sample[..count].iter_mut().enumerate() {
        // A jitter, as meshes repeat themselves.
        let jitter = i.wrapping_mul(0x9e37_79b9) >> 8;
        let entry = &entries[i * entries.len() / count + jitter % (entries.len() / count)];
        *place = [along(entry, 0) as f32, along(entry, 1) as f32, along(entry, 2) as f32, 0.0];
    }
    let sample = &mut sample[..count];
    let middle = (middle * count / entries.len()).clamp(1, count - 1);
    let mut best = (f64::INFINITY, 0);
    for axis in 0..3 {
        // Numbers that are not negative have the order of their bits.
        sample.select_nth_unstable_by_key(middle, |place| place[axis].to_bits());
        let (left, right) = sample.split_at(middle);
        let cost = surface(left) * left.len() as f64 + surface(right) * right.len() as f64;
        if cost < best.0 {
            best = (cost, axis);
        }
    }
    best.1
}

/// Half the surface of the box around some cells: three coordinates, whole numbers of at most 21 bits, and nothing.
fn surface(places: &[[f32; 4]]) -> f64 {
    let (mut low, mut high) = ([f32::INFINITY; 4], [0.0f32; 4]);
    for place in places {
        for a in 0..4 {
            low[a] = least(place[a], low[a]);
            high[a] = greatest(place[a], high[a]);
        }
    }
    let [x, y, z] = [0, 1, 2].map(|a| f64::from(high[a] - low[a]) + 1.0);
    x * y + y * z + z * x
}

/// A middle's cells along all axes, with this one first: one number, as comparing it takes no branch.
#[inline]
fn turned<E: Entry>(entry: &E, axis: usize) -> u64 {
    let (middle, by) = (entry.middle(), BITS * axis as u32);
    middle << by & ((1 << (3 * BITS)) - 1) | middle >> (3 * BITS - by)
}

#[inline]
fn along<E: Entry>(entry: &E, axis: usize) -> u64 {
    entry.middle() >> (BITS * (2 - axis as u32)) & MASK
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random_entries(count: u32) -> Vec<(u64, u32)> {
        let mut state = 7u64;
        (0..count)
            .map(|i| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 1, i)
            })
            .collect()
    }

    #[test]
    fn nothing_is_lost_and_the_order_given_does_not_matter_where_all_are_looked_at() {
        for count in [LEAST_SAMPLE as u32, 5000] {
            let mut entries = random_entries(count);
            let mut reversed: Vec<_> = entries.iter().rev().copied().collect();
            order(&mut entries, 8);
            order(&mut reversed, 8);
            for leaves in [&mut entries, &mut reversed] {
                leaves.chunks_mut(8).for_each(<[_]>::sort_unstable);
            }
            assert!(entries == reversed || count as usize > LEAST_SAMPLE);
            entries.sort_unstable_by_key(|e| e.1);
            assert_eq!(entries, random_entries(count));
        }
    }

    #[test]
    fn leaves_and_nodes_are_small_boxes() {
        // A lattice of 16^3 cells: 512 leaves of 8, each a cube of 2 cells, and 64 nodes of 8 leaves, each a cube of 4.
        let mut entries: Vec<(u64, u32)> =
            (0..4096u64).map(|i| ((i >> 8) << 42 | (i >> 4 & 15) << 21 | (i & 15), i as u32)).collect();
        order(&mut entries, 8);
        for (count, side) in [(8, 2), (64, 4), (512, 8)] {
            for node in entries.chunks(count) {
                for a in 0..3 {
                    let (low, high) =
                        node.iter().fold((u64::MAX, 0), |(l, h), e| (l.min(along(e, a)), h.max(along(e, a))));
                    assert_eq!(high - low, side - 1);
                }
            }
        }
    }

    #[test]
    fn a_leaf_is_in_order_along_its_longest_side() {
        for (count, axis) in [(32, 0), (29, 1), (8, 2), (1, 1)] {
            // Some have the same middle.
            let leaf: Vec<(u64, u32)> = (0..count)
                .map(|i| {
                    let [long, short] = [i * 37 % 11 * 1000, i * 53 % 13].map(u64::from);
                    let cells: [u64; 3] = std::array::from_fn(|a| if a == axis { long } else { short });
                    (cells[0] << 42 | cells[1] << 21 | cells[2], i)
                })
                .collect();
            let places = places_in_leaf::<_, 32>(&leaf);
            let mut ordered = vec![(0, u32::MAX); leaf.len()];
            for (entry, place) in leaf.iter().zip(places) {
                ordered[place as usize] = *entry;
            }
            let mut expected = leaf.clone();
            expected.sort_by_key(|entry| along(entry, axis));
            assert_eq!(ordered, expected);
        }
    }

    #[test]
    fn a_point_has_a_middle_too() {
        let point = Aabb { lower: [7.0; 3], upper: [7.0; 3] };
        assert_eq!(Cells::new(&point).middle(&point.lower, &point.upper), 0);
    }
}
