//! Meshes packed for drawing: every queried triangle once, with its own corners, in pieces of the promised form.

use std::collections::HashSet;

use feeler_core::{Error, Mockup, Packed, PartNumbers, Point, Tool};

/// A grid of `n` by `n` squares around a point, every corner a vertex of its own, in a scrambled order of triangles.
fn sheet(n: usize, size: f64, at: Point, vertices: &mut Vec<Point>, faces: &mut Vec<[u32; 3]>) {
    let corner = |i: usize, j: usize| {
        let along = |k: usize| size * (k as f64 / n as f64 - 0.5);
        [at[0] + along(i), at[1] + along(j), at[2] + 0.1 * along(i) * along(j)]
    };
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..n {
            triangles.push([corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)]);
            triangles.push([corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)]);
        }
    }
    let count = triangles.len();
    for k in 0..count {
        let first = vertices.len() as u32;
        vertices.extend(triangles[k * 7919 % count]);
        faces.push([first, first + 1, first + 2]);
    }
}

/// Sheets of many sizes, and a triangle of each kind of defect.
fn sheets(sizes: &[usize]) -> Mockup {
    let (mut vertices, mut faces, mut parts) = (Vec::new(), Vec::new(), Vec::new());
    for (part, &n) in sizes.iter().enumerate() {
        sheet(n, n as f64, [100.0 * part as f64, 5.0, -7.0], &mut vertices, &mut faces);
        let odd = vertices.len() as u32;
        vertices.push([f64::NAN, 0.0, 0.0]);
        faces.extend([[0, 1, odd], [0, 0, 1], [0, 1, u32::MAX]]);
        parts.resize(faces.len(), part as u32);
    }
    Mockup::new(vertices, faces, parts, sizes.len() + 1).unwrap()
}

/// Checks the guarantees of every packed mesh.
fn check(packed: &Packed, mockup: &Mockup, limit: usize, small: &[bool]) {
    let mesh = mockup.mesh();
    assert_eq!(packed.places.len(), mesh.faces().len());
    let queried: HashSet<u32> = mesh.queried().collect();
    assert_eq!(packed.order.iter().copied().collect::<HashSet<u32>>(), queried);
    assert_eq!(packed.order.len(), queried.len());
    for (t, place) in packed.places.iter().enumerate() {
        if queried.contains(&(t as u32)) {
            assert_eq!(packed.order[*place as usize], t as u32);
        } else {
            assert_eq!(*place, u32::MAX);
        }
    }
    let narrowed = |p: Point| p.iter().zip(&packed.middle).map(|(x, m)| ((x - m) as f32 + 0.0).to_bits()).collect();
    let (mut next, mut part_before) = (0, None);
    for piece in &packed.pieces {
        assert_eq!(piece.first, next);
        assert!(piece.positions.len() <= limit && !piece.indices.is_empty());
        assert_eq!(piece.parts.len(), piece.positions.len());
        for (i, corners) in piece.indices.iter().enumerate() {
            let t = packed.order[next as usize + i];
            let part = mockup.part_of_face(t);
            assert_eq!(piece.is_small, small[part as usize]);
            for (at, corner) in corners.iter().zip(mesh.triangle(t)) {
                let bits: Vec<u32> = narrowed(corner);
                assert_eq!(piece.positions[usize::from(*at)].map(|x| x.to_bits()).to_vec(), bits);
                assert_eq!(piece.parts.get(usize::from(*at)), part);
                assert!((0..3).all(|a| (piece.bounds.lower[a]..=piece.bounds.upper[a]).contains(&corner[a])));
            }
            if part_before != Some(part) {
                let size = |part: u32| mockup.part_bounds()[part as usize].longest();
                let key = |part: u32| (small[part as usize], -size(part));
                assert!(part_before.is_none_or(|before| key(before) <= key(part)), "large parts come first");
                part_before = Some(part);
            }
        }
        let used: HashSet<u16> = piece.indices.iter().flatten().copied().collect();
        assert_eq!(used.len(), piece.positions.len(), "no vertex is idle");
        next += piece.indices.len() as u32;
    }
}

#[test]
fn every_triangle_is_drawn_once_with_its_own_corners() {
    let mockup = sheets(&[3, 1, 20, 8, 2, 11]);
    let none = [false; 7];
    for limit in [3, 4, 7, 50, 300, 65_535] {
        let packed = mockup.pack(limit, None).unwrap();
        check(&packed, &mockup, limit, &none);
        let small = [true, true, false, false, true, false, true];
        let packed = mockup.pack(limit, Some(&small)).unwrap();
        check(&packed, &mockup, limit, &small);
        assert!(packed.pieces.iter().any(|piece| piece.is_small));
    }
    let packed = mockup.pack(65_535, None).unwrap();
    assert_eq!(packed.pieces.len(), 1);
    let vertices: usize = [3, 1, 20, 8, 2, 11].iter().map(|n| (n + 1) * (n + 1)).sum();
    assert_eq!(packed.pieces[0].positions.len(), vertices, "each position of a part once");
}

#[test]
fn a_part_of_many_pieces_is_cut_compactly() {
    // 180,000 triangles in a scrambled order, 90,601 positions.
    let mockup = sheets(&[300]);
    let packed = mockup.pack(65_535, None).unwrap();
    check(&packed, &mockup, 65_535, &[false; 2]);
    assert_eq!(packed.pieces.len(), 3);
    let vertices: usize = packed.pieces.iter().map(|piece| piece.positions.len()).sum();
    assert!(vertices < 95_000, "{vertices} vertices: few are on borders");
}

#[test]
fn the_first_of_several_pieces_is_small() {
    let mockup = sheets(&[60, 40, 20]);
    let packed = mockup.pack(1000, None).unwrap();
    let sizes: Vec<usize> = packed.pieces.iter().map(|piece| piece.positions.len()).collect();
    assert!(sizes.len() > 5 && sizes[0] <= 250 && sizes[1] > 750, "{sizes:?}");
    assert_eq!(mockup.pack(10_000, None).unwrap().pieces.len(), 1);
}

#[test]
fn the_number_of_threads_shows_nowhere() {
    let mockup = sheets(&[150, 40, 3, 60]);
    let packed = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| mockup.pack(9_000, None).unwrap())
    };
    let alone = packed(1);
    assert!([2, 3, 8].iter().all(|threads| packed(*threads) == alone));
}

#[test]
fn numbers_far_out_and_near_zero() {
    let far = vec![[-1e100, 0.0, 0.0], [1e100, 0.0, -0.0], [0.0, 1e100, 0.0], [0.0, 1e-320, 1.0]];
    let mockup = Mockup::new(far, vec![[0, 1, 2], [0, 1, 3]], vec![], 1).unwrap();
    let packed = mockup.pack(65_535, None).unwrap();
    assert!(packed.pieces[0].positions.as_flattened().iter().all(|x| x.is_finite()));
    assert_eq!(packed.pieces[0].indices.len(), 2);
}

#[test]
fn part_numbers_are_as_wide_as_they_need_to_be() {
    let vertices = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    for (parts, part, is_short) in [(65_535, 65_534, true), (65_536, 65_535, false)] {
        let mockup = Mockup::new(vertices.clone(), vec![[0, 1, 2]], vec![part], parts).unwrap();
        let packed = mockup.pack(65_535, None).unwrap();
        let numbers = &packed.pieces[0].parts;
        assert_eq!(matches!(numbers, PartNumbers::Short(_)), is_short);
        assert_eq!((numbers.get(2), numbers.is_empty()), (part, false));
    }
}

#[test]
fn a_tool_is_packed_in_its_own_frame() {
    let spike = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [-0.1, 0.1, 0.2], [-0.1, -0.1, 0.2]];
    let tool = Tool::of_parts(spike, vec![[0, 2, 1], [0, 3, 2], [1, 2, 3]], vec![1, 1, 0], 2).unwrap();
    let packed = tool.pack(65_535, Some(&[true, false])).unwrap();
    assert_eq!(packed.order, [0, 1, 2]);
    assert_eq!(packed.pieces.iter().map(|piece| piece.is_small).collect::<Vec<bool>>(), [false, true]);
    assert_eq!(packed.middle, [0.0, 0.0, 0.1]);
}

#[test]
fn what_cannot_be_asked_is_refused() {
    let mockup = sheets(&[1]);
    for limit in [0, 2, 65_536, usize::MAX] {
        assert_eq!(mockup.pack(limit, None), Err(Error::VertexLimit { value: limit }));
    }
    let error = mockup.pack(65_535, Some(&[true])).unwrap_err();
    assert_eq!(error, Error::Length { what: "small", got: 1, expected: 2 });
}
