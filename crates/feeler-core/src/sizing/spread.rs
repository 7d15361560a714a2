//! Systematic samples of triangles: evenly spread, or in proportion to a share.

use crate::mesh::triangle_mesh::Mesh;

/// At most `most` queried triangles, evenly spread; at least one.
pub(super) fn spread(mesh: &Mesh, most: usize) -> Vec<u32> {
    let stride = mesh.queried_count().div_ceil(most).max(1);
    if mesh.excluded().is_empty() {
        return (0..mesh.faces().len() as u32).step_by(stride).collect();
    }
    mesh.queried().step_by(stride).collect()
}

/// About `most` of the triangles, in proportion to their shares: how often each was chosen, and how many it stands for each time.
pub(super) fn chosen(ids: &[u32], shares: &[f64], most: usize) -> Vec<(u32, u32, f64)> {
    let total: f64 = shares.iter().sum();
    let step = total / most as f64;
    let (mut chosen, mut sum, mut next) = (Vec::new(), 0.0, 0.5 * step);
    for (id, share) in ids.iter().zip(shares) {
        sum += share;
        let mut times = 0;
        while next < sum {
            times += 1;
            next += step;
        }
        if times > 0 {
            chosen.push((*id, times, step / share));
        }
    }
    chosen
}
