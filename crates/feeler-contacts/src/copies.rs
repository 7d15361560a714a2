//! Triangles that coincide with others, corner for corner: a thousand on a thousand make a million pairs, and one of
//! them suffices.

use std::collections::HashMap;

use crate::context::QueryContext;
use crate::surface::Surface;

/// Of pairs of triangles (sorted by tool triangle) those of the first triangle of its part with the same corners, on both sides;
/// `None` where these are all.
pub(crate) fn without_copies(context: &QueryContext<'_>, pairs: &[[u32; 2]]) -> Option<Vec<[u32; 2]>> {
    let is_copy = Surface::BOTH.map(|surface| {
        let mut ids: Vec<u32> = pairs.iter().map(|pair| pair[surface]).collect();
        ids.sort_unstable();
        ids.dedup();
        let mut first = HashMap::with_capacity(ids.len());
        let mut copies = Vec::new();
        for id in ids {
            // 0.0 and -0.0 are one place.
            let mut corners = context.triangle(surface, id).map(|p| p.map(|x| (x + 0.0).to_bits()));
            corners.sort_unstable();
            let part = match surface {
                Surface::Tool => context.tool.part_of_face(id),
                Surface::Mockup => context.mockup.part_of_face(id),
            };
            if *first.entry((part, corners)).or_insert(id) != id {
                copies.push(id);
            }
        }
        copies
    });
    if is_copy.iter().all(Vec::is_empty) {
        return None;
    }
    let is_first = |pair: &&[u32; 2]| {
        Surface::BOTH.iter().all(|surface| is_copy[*surface].binary_search(&pair[*surface]).is_err())
    };
    Some(pairs.iter().filter(is_first).copied().collect())
}
