//! The order in which a mesh is packed, cut into runs: triangles of one part, few enough for a piece.

use rayon::prelude::*;

use crate::geometry::bounds::Aabb;
use crate::mesh::median::{order, Cells};
use crate::mesh::triangle_mesh::Mesh;

/// Where some triangles of one part lie in the order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// Their first place.
    pub first: usize,
    /// How many there are.
    pub count: usize,
    /// Their part.
    pub part: u32,
    /// Whether that was called small.
    pub is_small: bool,
}

/// The triangles in the order in which they are packed, and the runs of at most `longest` triangles that they are cut into.
///
/// Parts by the longest side of their box, large ones first and those called small last. A part of one run stays in its own order; a
/// longer one is halved in space, so that its runs are compact and share few vertices.
pub fn runs(
    mesh: &Mesh,
    part_of_face: impl Fn(u32) -> u32,
    part_bounds: &[Aabb],
    small: Option<&[bool]>,
    longest: usize,
) -> (Vec<u32>, Vec<Run>) {
    let is_small = |part: u32| small.is_some_and(|small| small[part as usize]);
    let mut parts: Vec<u32> = (0..part_bounds.len() as u32).collect();
    parts.sort_by(|p, q| {
        let size = |part: u32| part_bounds[part as usize].longest();
        is_small(*p).cmp(&is_small(*q)).then_with(|| size(*q).total_cmp(&size(*p)))
    });

    // Sorted by counting: the next free place of each part.
    let mut counts = vec![0usize; part_bounds.len()];
    mesh.queried().for_each(|t| counts[part_of_face(t) as usize] += 1);
    let mut next = vec![0; part_bounds.len()];
    let mut sum = 0;
    for &part in &parts {
        next[part as usize] = sum;
        sum += counts[part as usize];
    }
    let mut triangles = vec![0; sum];
    for t in mesh.queried() {
        let at = &mut next[part_of_face(t) as usize];
        triangles[*at] = t;
        *at += 1;
    }

    let mut runs = Vec::with_capacity(parts.len());
    let mut rest = triangles.as_mut_slice();
    let mut long = Vec::new();
    let mut first = 0;
    for part in parts {
        let count = counts[part as usize];
        let (own, others) = rest.split_at_mut(count);
        rest = others;
        for from in (0..count).step_by(longest) {
            let count = longest.min(count - from);
            runs.push(Run { first: first + from, count, part, is_small: is_small(part) });
        }
        if count > longest {
            long.push((part, own));
        }
        first += count;
    }
    long.into_par_iter().for_each(|(part, own)| cut_in_space(mesh, &part_bounds[part as usize], own, longest));
    (triangles, runs)
}

/// Puts a part's triangles into an order in which each `longest` of them, one after the other, lie together.
fn cut_in_space(mesh: &Mesh, bounds: &Aabb, triangles: &mut [u32], longest: usize) {
    let cells = Cells::new(bounds);
    let middle = |t: &u32| {
        let b = Aabb::of_triangle(&mesh.triangle(*t));
        (cells.middle(&b.lower, &b.upper), *t)
    };
    let mut entries: Vec<(u64, u32)> = triangles.par_iter().map(middle).collect();
    // A tree halves down to two entries.
    order(&mut entries, longest.max(2));
    let put = |(run, entries): (&mut [u32], &[(u64, u32)])| {
        run.iter_mut().zip(entries).for_each(|(t, (_, id))| *t = *id);
        // As given again: what follows each other there often shares vertices.
        run.sort_unstable();
    };
    triangles.par_chunks_mut(longest).zip(entries.par_chunks(longest)).for_each(put);
}
