//! Connected components of the fragments of a patch, over shared edges.

use crate::constants::FEW_FRAGMENTS;
use crate::context::QueryContext;
use crate::contour::contact_region::FaceNumbers;
use crate::patch::surface_patch::{Fragment, Patch};
use crate::surface::Surface;
use feeler_core::constants::NONE;
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_lanes::{Kernel, Simd, LANES};

/// Working memory of the split of patches into connected components.
#[derive(Debug, Default)]
pub(crate) struct ConnectedComponents {
    /// For each fragment the first one of its component, in the order of its patch.
    first: Vec<u32>,
    /// Patches of more than [`FEW_FRAGMENTS`] fragments.
    large: Vec<u32>,
    /// By face number, the fragment of that face; entries of faces without one are left over from other patches.
    fragment_of: Vec<u32>,
    stack: Vec<u32>,
    /// For each patch whether one of its components has kept it.
    taken: Vec<bool>,
}

impl ConnectedComponents {
    /// Gives each connected component of a patch a patch of its own: the faces left and right of a slot lie in one
    /// plane, but each belongs to its own side of the slot. Patches of open surfaces stay whole, since the neighbours
    /// there are not all known.
    ///
    /// `order` lists the fragments patch by patch, `numbers` the faces of the contact regions. Returns whether a patch
    /// was split.
    pub fn split(
        &mut self,
        context: &QueryContext<'_>,
        numbers: &FaceNumbers,
        surface: Surface,
        list: &mut Vec<Patch>,
        fragments: &mut [Fragment],
        order: &[u32],
    ) -> bool {
        if list.len() == fragments.len() {
            return false;
        }
        let adjacency = context.adjacency[surface];
        let ConnectedComponents { first, large, .. } = self;
        first.clear();
        first.resize(fragments.len(), NONE);
        large.clear();
        context.lanes.run(Connect { adjacency, patches: list, fragments, order, first, large });
        if !self.large.is_empty() {
            self.connect_large(adjacency, numbers, surface, list, fragments, order);
        }
        // The first component keeps the patch.
        let ConnectedComponents { first, taken, .. } = self;
        let count = list.len();
        taken.clear();
        taken.resize(count, false);
        for i in 0..fragments.len() {
            let patch = fragments[i].patch as usize;
            if first[i] as usize != i {
                fragments[i].patch = fragments[first[i] as usize].patch;
            } else if std::mem::replace(&mut taken[patch], true) {
                fragments[i].patch = list.len() as u32;
                list.push(list[patch]);
            }
        }
        list.len() > count
    }

    /// The components of large patches, by flood fill over shared edges.
    fn connect_large(
        &mut self,
        adjacency: &Adjacency,
        numbers: &FaceNumbers,
        surface: Surface,
        list: &[Patch],
        fragments: &[Fragment],
        order: &[u32],
    ) {
        let ConnectedComponents { first, large, fragment_of, stack, .. } = self;
        // Left-over entries are not cleared: each use checks that the fragment is that of the triangle.
        fragment_of.resize(numbers.len(surface).max(fragment_of.len()), 0);
        for patch in large.iter() {
            let of = list[*patch as usize].of_fragments(order);
            for i in of {
                if let Some(number) = numbers.get(surface, fragments[*i as usize].id) {
                    fragment_of[number as usize] = *i;
                }
            }
            let mut left = of.len();
            for i in of {
                if first[*i as usize] != NONE {
                    continue;
                }
                first[*i as usize] = *i;
                left -= 1;
                stack.push(*i);
                while let Some(j) = stack.pop() {
                    if left == 0 {
                        continue;
                    }
                    let beside = adjacency.neighbours[fragments[j as usize].id as usize];
                    for n in beside.into_iter().filter(|n| *n != NONE) {
                        let Some(number) = numbers.get(surface, n) else { continue };
                        let k = fragment_of[number as usize];
                        let is_it = fragments
                            .get(k as usize)
                            .is_some_and(|fragment| fragment.id == n && fragment.patch == *patch);
                        if is_it && first[k as usize] == NONE {
                            first[k as usize] = *i;
                            left -= 1;
                            stack.push(k);
                        }
                    }
                }
            }
        }
    }
}

/// Finds, for the fragments of small patches, the first one of their component; lists the large patches.
struct Connect<'a> {
    adjacency: &'a Adjacency,
    patches: &'a [Patch],
    fragments: &'a [Fragment],
    order: &'a [u32],
    first: &'a mut [u32],
    large: &'a mut Vec<u32>,
}

impl Kernel for Connect<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Connect { adjacency, patches, fragments, order, first, large } = self;
        for (i, patch) in patches.iter().enumerate() {
            let of = patch.of_fragments(order);
            let mut is_closed = true;
            for i in of {
                is_closed &= fragments[*i as usize].closed;
            }
            if of.len() == 1 || !is_closed {
                for i in of {
                    first[*i as usize] = of[0];
                }
            } else if of.len() <= LANES {
                connect::<LANES>(adjacency, fragments, of, first);
            } else if of.len() <= FEW_FRAGMENTS {
                connect::<FEW_FRAGMENTS>(adjacency, fragments, of, first);
            } else {
                large.push(i as u32);
            }
        }
    }
}

/// Components of a patch of at most `N` fragments: a flood fill whose sets are bits of a `u32`, in which each fragment
/// is compared with the neighbours of each.
#[inline(always)]
fn connect<const N: usize>(adjacency: &Adjacency, fragments: &[Fragment], of: &[u32], first: &mut [u32]) {
    let mut ids = [NONE; N];
    for (id, i) in ids.iter_mut().zip(of) {
        *id = fragments[*i as usize].id;
    }
    let mut left = u32::MAX >> (u32::BITS as usize - of.len());
    while left != 0 {
        let from = of[left.trailing_zeros() as usize];
        let mut next = left & left.wrapping_neg();
        while next != 0 {
            let i = next.trailing_zeros() as usize;
            next &= next - 1;
            left &= !(1 << i);
            first[of[i] as usize] = from;
            let [a, b, c] = adjacency.neighbours[ids[i] as usize];
            let mut beside = 0;
            for k in 0..N {
                beside |= u32::from((ids[k] == a) | (ids[k] == b) | (ids[k] == c)) << k;
            }
            next |= beside & left;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Surface;
    use feeler_lanes::Level;

    /// For each fragment of a patch the first one reached from it over shared edges; the first of all where one is
    /// open.
    fn plainly_first(adjacency: &Adjacency, fragments: &[Fragment], of: &[u32]) -> Vec<u32> {
        if of.iter().any(|i| !fragments[*i as usize].closed) {
            return vec![of[0]; of.len()];
        }
        let mut first = vec![NONE; of.len()];
        for from in 0..of.len() {
            let mut next = vec![from];
            while let Some(k) = next.pop() {
                if first[k] == NONE {
                    first[k] = of[from];
                    let beside = adjacency.neighbours[fragments[of[k] as usize].id as usize];
                    next.extend((0..of.len()).filter(|j| beside.contains(&fragments[of[*j] as usize].id)));
                }
            }
        }
        first
    }

    #[test]
    fn components_are_those_a_flood_fill_finds() {
        // Triangles in rows, each adjacent to the next, with gaps; some have another neighbour in the next row.
        let (rows, long) = (30u32, 90u32);
        let beside = |t: u32| {
            let (row, at) = (t / long, t % long);
            let is_gap = |at: u32| (at * at + 3 * row).is_multiple_of(11);
            let before = if at > 0 && !is_gap(at) { t - 1 } else { NONE };
            let after = if at + 1 < long && !is_gap(at + 1) { t + 1 } else { NONE };
            let other = if at.is_multiple_of(7) { (row ^ 1) * long + at } else { NONE };
            [before, other, after]
        };
        let neighbours: Vec<[u32; 3]> = (0..rows * long).map(beside).collect();
        let adjacency = Adjacency::of_neighbours(neighbours);
        // Two rows make a patch, of which every other triangle, or more, is a fragment; fragments come in any order.
        let mut fragments: Vec<Fragment> = (0..rows * long)
            .map(|i| i * 1009 % (rows * long))
            .filter(|t| t % long < 4 * (t / long / 2) && (t % long % 5 > 0 || (t / long).is_multiple_of(4)))
            .map(|t| Fragment::new(t, None, (0, 0), t / long != 8))
            .collect();
        let mut patches: Vec<Patch> = Vec::new();
        let mut order: Vec<u32> = Vec::new();
        for patch in 0..rows / 2 {
            let from = order.len() as u32;
            order.extend((0..fragments.len() as u32).filter(|i| fragments[*i as usize].id / long / 2 == patch));
            if order.len() as u32 > from {
                order[from as usize..].iter().for_each(|i| fragments[*i as usize].patch = patches.len() as u32);
                patches.push(Patch::new([0.0; 3], [0.0; 3]));
                patches.last_mut().unwrap().fragments = (from, order.len() as u32);
            }
        }
        let mut numbers = FaceNumbers::default();
        fragments.iter().for_each(|fragment| _ = numbers.number(Surface::Mockup, fragment.id));
        for level in Level::available() {
            let mut components =
                ConnectedComponents { first: vec![NONE; fragments.len()], ..ConnectedComponents::default() };
            let ConnectedComponents { first, large, .. } = &mut components;
            level.checked().run(Connect {
                adjacency: &adjacency,
                patches: &patches,
                fragments: &fragments,
                order: &order,
                first,
                large,
            });
            assert!(!large.is_empty() && large.len() < patches.len());
            components.connect_large(&adjacency, &numbers, Surface::Mockup, &patches, &fragments, &order);
            let mut counts = [0; 2];
            for patch in &patches {
                let of = patch.of_fragments(&order);
                let expected = plainly_first(&adjacency, &fragments, of);
                let found: Vec<u32> = of.iter().map(|i| components.first[*i as usize]).collect();
                assert_eq!(found, expected, "{level:?} {}", of.len());
                counts[usize::from(of.len() <= FEW_FRAGMENTS && expected.iter().any(|i| *i != of[0]))] += 1;
            }
            assert!(counts.iter().all(|count| *count > 2), "{counts:?}");
        }
    }
}
