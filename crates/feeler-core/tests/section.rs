//! Sections: outlines of closed surfaces are closed, whatever lies on the plane; areas are right; selections are obeyed.

use std::collections::HashMap;
use std::sync::Arc;

use feeler_core::{Error, Mockup, Point, Scene, SceneOptions, SectionOutline};
use feeler_shapes::{box_mesh, joined};

mod common;

use common::{ball, mockup_of, placed, soup, with_defects, Random};

fn scene_of(mockup: Arc<Mockup>) -> Scene {
    Scene::build(mockup, &SceneOptions::default()).unwrap()
}

/// For each point the number of segments that end there minus those that start there, if not 0.
fn open_ends(outline: &SectionOutline) -> Vec<i32> {
    let mut ends: HashMap<[u64; 3], i32> = HashMap::new();
    for [start, end] in &outline.segments {
        *ends.entry(start.map(|x| (x + 0.0).to_bits())).or_default() -= 1;
        *ends.entry(end.map(|x| (x + 0.0).to_bits())).or_default() += 1;
    }
    ends.into_values().filter(|count| *count != 0).collect()
}

/// The area that an outline encloses, seen from the side that the unit normal points to.
fn area(outline: &SectionOutline, normal: &Point) -> f64 {
    let cross =
        |a: &Point, b: &Point| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let twice = |[a, b]: &[Point; 2]| cross(a, b).iter().zip(normal).map(|(x, n)| x * n).sum::<f64>();
    outline.segments.iter().map(twice).sum::<f64>() / 2.0
}

#[test]
fn a_box_is_cut_where_it_is_in_front_of_the_plane() {
    let scene = scene_of(mockup_of(box_mesh([0.0; 3], [2.0, 1.0, 4.0], 3)));
    let up = [0.0, 0.0, 1.0];
    let at = |z: f64, normal: Point| scene.section(&[0.3, 0.1, z], &normal).unwrap();
    for z in [-2.0, -1.0, 0.0, 0.123, 2.0f64.next_down()] {
        let outline = at(z, up);
        assert!(open_ends(&outline).is_empty(), "{z}");
        assert!((area(&outline, &up) - 2.0).abs() < 1e-12, "{z}: {}", area(&outline, &up));
        assert!(outline.triangles.is_sorted());
        assert!(outline.segments.as_flattened().iter().all(|p| p[2] == z));
    }
    // A body that touches the plane from behind is not cut, nor is one away from it.
    for z in [2.0, 2.1, (-2.0f64).next_down()] {
        assert_eq!(at(z, up), SectionOutline::default(), "{z}");
    }
    // Seen from the other side, the plane cuts the other end.
    let down = [0.0, 0.0, -3.0];
    assert!(at(-2.0, down).segments.is_empty() && !at(2.0, down).segments.is_empty());
}

#[test]
fn outlines_of_closed_surfaces_are_closed() {
    let many = joined([ball(20, 1.0), box_mesh([0.5, 0.5, 0.5], [1.0, 1.0, 1.0], 4), placed(ball(7, 1.0), 0.5, 0.25)]);
    let mockup = mockup_of(many);
    let scene = scene_of(mockup.clone());
    let mut random = Random::new(3);
    let mut cut = 0;
    for i in 0..300 {
        let mut point = random.point(-1.0, 1.0);
        let mut normal = random.point(-1.0, 1.0);
        if i % 3 == 0 {
            point = mockup.mesh().vertices()[random.below(mockup.mesh().vertices().len() as u64) as usize];
        }
        if i % 2 == 0 {
            normal = std::array::from_fn(|a| (3.0 * normal[a]).round());
            if normal == [0.0; 3] {
                continue;
            }
        }
        let outline = scene.section(&point, &normal).unwrap();
        assert!(open_ends(&outline).is_empty(), "through {point:?} across {normal:?}: {:?}", open_ends(&outline));
        cut += outline.triangles.len();
    }
    assert!(cut > 10_000);
}

#[test]
fn the_size_of_the_numbers_plays_no_part() {
    let mockup = mockup_of(box_mesh([0.5; 3], [1.0; 3], 2));
    let normal = [1.0, 2.0, -0.5];
    let expected = scene_of(mockup).section(&[0.5, 0.25, 0.5], &normal).unwrap();
    for exponent in [-300, -100, 100, 330] {
        let by = 2f64.powi(exponent);
        let mockup = mockup_of(placed(box_mesh([0.5; 3], [1.0; 3], 2), by, 0.0));
        let outline = scene_of(mockup).section(&[0.5 * by, 0.25 * by, 0.5 * by], &normal.map(|x| x * by)).unwrap();
        assert_eq!(outline.triangles, expected.triangles, "{exponent}");
        for (p, q) in outline.segments.as_flattened().iter().zip(expected.segments.as_flattened()) {
            assert!((0..3).all(|a| (p[a] / by - q[a]).abs() < 1e-12), "{exponent}: {p:?}, {q:?}");
        }
    }
}

#[test]
fn a_corner_on_the_plane_is_on_it_though_float64_says_behind() {
    // Exactly 1 + t - 1 - t; float64 drops the first t.
    let t = 2.0f64.powi(-60);
    let triangle = (vec![[1.0, 0.0, -t], [3.0, 3.0, 3.0], [4.0, 3.0, 3.0]], vec![[0, 1, 2]]);
    let outline = scene_of(mockup_of(triangle)).section(&[-t, 1.0, 0.0], &[1.0; 3]).unwrap();
    assert_eq!(outline, SectionOutline::default());
}

#[test]
fn selections_are_obeyed_and_defects_are_not_cut() {
    let (vertices, faces) = with_defects(soup(5, 900, 0.3));
    let parts = (0..faces.len() as u32).map(|t| t % 5).collect();
    let mockup = Arc::new(Mockup::new(vertices, faces, parts, 5).unwrap());
    let scene = scene_of(mockup.clone());
    let (point, normal) = ([0.4, 0.5, 0.6], [0.3, -1.0, 0.2]);
    let whole = scene.section(&point, &normal).unwrap();
    assert!(whole.triangles.iter().all(|t| mockup.mesh().is_queried(*t)));
    assert!(whole.triangles.iter().zip(&whole.parts).all(|(t, part)| t % 5 == *part));
    let some = scene.without(&[1, 4]).unwrap().section(&point, &normal).unwrap();
    let there: Vec<u32> = whole.triangles.iter().copied().filter(|t| ![1, 4].contains(&(t % 5))).collect();
    assert_eq!(some.triangles, there);
    assert!(there.len() > 50);
}

#[test]
fn the_number_of_threads_shows_nowhere() {
    let scene = scene_of(mockup_of(ball(120, 1.0)));
    let cut = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| scene.section(&[0.1, 0.0, 0.0], &[1.0, 1.0, 0.2]).unwrap())
    };
    let alone = cut(1);
    assert!(!alone.segments.is_empty() && [2, 5].iter().all(|threads| cut(*threads) == alone));
}

#[test]
fn what_is_no_plane_is_refused() {
    let scene = scene_of(mockup_of(ball(4, 1.0)));
    for x in [f64::NAN, f64::INFINITY, 1e101] {
        let error = scene.section(&[0.0, x, 0.0], &[1.0, 0.0, 0.0]).unwrap_err();
        assert!(matches!(error, Error::Plane { what: "point", .. }), "{error}");
        assert!(matches!(scene.section(&[0.0; 3], &[x, 1.0, 0.0]), Err(Error::Plane { what: "normal", .. })));
    }
    assert!(matches!(scene.section(&[0.0; 3], &[0.0; 3]), Err(Error::Plane { what: "normal", .. })));
}
