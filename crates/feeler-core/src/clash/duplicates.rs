//! Duplicate parts: each triangle of one has the corners of a triangle of the other.

use std::collections::HashMap;

use rayon::prelude::*;

use super::asked::PairLimits;
use crate::geometry::bounds::Triangle;
use crate::mesh::mockup::Mockup;

/// A triangle's corners as numbers that are equal where the coordinates are, in order.
type Corners = [[u64; 3]; 3];

/// Sets of parts with the same triangles, in order, among those with `is_there`. Coordinates must be equal, with 0.0
/// equal to -0.0, in any order and winding. Triangles that cannot be queried do not count.
pub fn same_parts(mockup: &Mockup, is_there: impl Fn(u32) -> bool) -> Vec<Vec<u32>> {
    // The boxes tell nearly all apart.
    let mut of_box: HashMap<[u64; 7], Vec<u32>> = HashMap::new();
    for ((part, bounds), count) in (0..).zip(mockup.part_bounds()).zip(mockup.part_triangles()) {
        if is_there(part) && !bounds.is_empty() {
            let [a, b] = [bounds.lower, bounds.upper].map(|corner| corner.map(number));
            of_box.entry([a[0], a[1], a[2], b[0], b[1], b[2], u64::from(*count)]).or_default().push(part);
        }
    }
    let mut candidates: Vec<u32> = of_box.into_values().filter(|same| same.len() > 1).flatten().collect();
    if candidates.is_empty() {
        return Vec::new();
    }
    candidates.sort_unstable();
    let mut triangles: HashMap<u32, Vec<Corners>> = candidates.iter().map(|part| (*part, Vec::new())).collect();
    for t in mockup.mesh().queried() {
        if let Some(of_part) = triangles.get_mut(&mockup.part_of_face(t)) {
            of_part.push(corners(&mockup.mesh().triangle(t)));
        }
    }
    triangles.par_iter_mut().for_each(|(_, of_part)| of_part.sort_unstable());
    let mut sets: HashMap<&[Corners], Vec<u32>> = HashMap::new();
    for part in &candidates {
        sets.entry(&triangles[part]).or_default().push(*part);
    }
    let mut sets: Vec<Vec<u32>> = sets.into_values().filter(|same| same.len() > 1).collect();
    sets.sort_unstable();
    sets
}

/// The pairs of parts of such sets to check, the lesser part first; sorted.
pub fn duplicate_pairs(sets: &[Vec<u32>], limits: &PairLimits) -> Vec<[u32; 2]> {
    let pairs = sets
        .iter()
        .flat_map(|same| (0..same.len()).flat_map(move |i| same[i + 1..].iter().map(move |b| [same[i], *b])));
    let mut pairs: Vec<[u32; 2]> = pairs.filter(|[a, b]| limits.clearance(*a, *b).is_some()).collect();
    pairs.sort_unstable();
    pairs
}

fn number(x: f64) -> u64 {
    (x + 0.0).to_bits()
}

fn corners(triangle: &Triangle) -> Corners {
    let mut corners = triangle.map(|corner| corner.map(number));
    corners.sort_unstable();
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clash::asked::PairLimitTables;
    use feeler_shapes::{box_mesh, joined};

    #[test]
    fn parts_with_the_same_corners_are_one_and_the_same() {
        let cube = box_mesh([0.0; 3], [1.0; 3], 2);
        let (vertices, mut faces) = cube.clone();
        faces.reverse();
        let turned = (vertices.clone(), faces.iter().map(|[a, b, c]| [*b, *a, *c]).collect());
        // The same box, cut along another diagonal.
        let [a, b] = [faces[0], faces[1]];
        let mut other = faces.clone();
        let shared: Vec<u32> = a.into_iter().filter(|v| b.contains(v)).collect();
        let ends: Vec<u32> = a.into_iter().chain(b).filter(|v| !shared.contains(v)).collect();
        (other[0], other[1]) = ([shared[0], ends[0], ends[1]], [shared[1], ends[0], ends[1]]);
        let meshes = [cube.clone(), box_mesh([0.0; 3], [1.0; 3], 1), turned, (vertices, other), cube];
        let parts = meshes.iter().zip(0..).flat_map(|(mesh, part)| vec![part; mesh.1.len()]).collect();
        let (vertices, faces) = joined(meshes);
        let mockup = Mockup::new(vertices, faces, parts, 5).unwrap();
        assert_eq!(same_parts(&mockup, |_| true), [vec![0, 2, 4]]);
        assert_eq!(same_parts(&mockup, |part| part != 2), [vec![0, 4]]);
        let sets = same_parts(&mockup, |_| true);
        let limits = PairLimits::uniform(0.0, 0.0).unwrap();
        assert_eq!(duplicate_pairs(&sets, &limits), [[0, 2], [0, 4], [2, 4]]);
        let but_one = PairLimitTables {
            clearance: vec![0.0],
            contact: vec![0.0],
            excluded: vec![[2, 0]],
            ..PairLimitTables::default()
        };
        assert_eq!(duplicate_pairs(&sets, &PairLimits::new(but_one, 5).unwrap()), [[0, 4], [2, 4]]);
    }
}
