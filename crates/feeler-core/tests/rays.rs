//! Rays against their plain twin, on every store; known properties; and refused arguments.

use std::sync::Arc;

use feeler_core::{first_of_all, Error, HalfSpace, Level, Mockup, Point, Ray, Scene, SceneOptions, Storage};

mod common;

use common::{ball, lattice, mockup_of, needles, placed, soup, with_defects, Random, STORAGES};

fn scene(mockup: &Arc<Mockup>, storage: Storage, voxel_size: Option<f64>) -> Scene {
    Scene::build(mockup.clone(), &SceneOptions::default().with_storage(storage).with_voxel_size(voxel_size)).unwrap()
}

/// Every store, and every instruction set of the default one, against all triangles; also in a batch. Returns how many rays hit.
fn compare(name: &str, mockup: &Arc<Mockup>, rays: &[Ray], max: f64, sections: &[HalfSpace]) -> usize {
    let size = mockup.mesh().bounds().longest() / 20.0;
    let mut scenes: Vec<Scene> = STORAGES.iter().map(|storage| scene(mockup, *storage, Some(size))).collect();
    for level in Level::available() {
        scenes.push(scene(mockup, Storage::Blocks, None));
        scenes.last_mut().unwrap().set_lanes(level);
    }
    let of_all = |ray: &Ray| first_of_all(mockup, scenes[0].index().selection(), ray, max, sections).unwrap();
    let expected: Vec<_> = rays.iter().map(of_all).collect();
    for scene in &scenes {
        for (ray, expected) in rays.iter().zip(&expected) {
            assert_eq!(scene.ray(ray, max, sections).unwrap(), *expected, "{name}, {:?}: {ray:?}", scene.storage());
        }
        assert_eq!(scene.rays(rays, max, sections).unwrap(), expected, "{name}");
    }
    expected.iter().flatten().count()
}

/// Rays from around a box and from within, half of them along axes, edges and diagonals.
fn rays_at(mockup: &Mockup, count: usize, random: &mut Random) -> Vec<Ray> {
    let b = mockup.mesh().bounds();
    let (size, corners) = (b.longest(), mockup.mesh().queried().collect::<Vec<u32>>());
    let mut rays = Vec::new();
    for i in 0..count {
        let within = |r: &mut Random| -> Point { std::array::from_fn(|a| r.real(b.lower[a], b.upper[a])) };
        let corner = |r: &mut Random| {
            let t = mockup.mesh().triangle(corners[r.below(corners.len() as u64) as usize]);
            t[r.below(3) as usize]
        };
        let far = |r: &mut Random| -> Point { std::array::from_fn(|a| b.lower[a] + r.real(-2.0, 3.0) * size) };
        let towards = |from: Point, to: Point| -> Point { std::array::from_fn(|a| to[a] - from[a]) };
        let (origin, direction) = match i % 6 {
            0 => (far(random), within(random)),
            1 => (within(random), far(random)),
            // Through corners, along edges, in planes of lattices.
            2 => (corner(random), corner(random)),
            3 => (far(random), corner(random)),
            4 => {
                let origin = corner(random);
                let step: Point = std::array::from_fn(|_| random.below(3) as f64 - 1.0);
                (origin, std::array::from_fn(|a| origin[a] + step[a] * size))
            }
            _ => {
                let mut origin = corner(random);
                let axis = random.below(3) as usize;
                let end = origin;
                origin[axis] = b.lower[axis] - size;
                (origin, end)
            }
        };
        let direction = towards(origin, direction);
        if direction.iter().any(|x| x.abs() > 1e-90) {
            rays.push(Ray { origin, direction });
        }
    }
    rays
}

#[test]
fn every_store_finds_what_all_triangles_give() {
    let meshes = [
        ("soup", soup(1, 700, 0.2)),
        ("needles", needles(2, 300, 1e-4)),
        ("lattice", lattice(3, 500, 4)),
        ("ball", ball(12, 1.0)),
        ("defects", with_defects(soup(4, 300, 0.3))),
        ("far out", placed(soup(5, 200, 0.2), 1.0, 1e7)),
        ("huge", placed(lattice(6, 200, 4), 1e90, 0.0)),
        ("tiny", placed(lattice(7, 200, 4), 1e-90, 0.0)),
        ("one", (vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])),
    ];
    let mut random = Random::new(8);
    for (name, mesh) in meshes {
        let mockup = mockup_of(mesh);
        let rays = rays_at(&mockup, 240, &mut random);
        let size = mockup.mesh().bounds().longest();
        let hits = compare(name, &mockup, &rays, f64::INFINITY, &[]);
        assert!(hits > rays.len() / 10, "{name}: {hits} of {} hit", rays.len());
        let fewer = compare(name, &mockup, &rays, 0.5 * size, &[]);
        assert!(fewer < hits, "{name}: {fewer}");
        // Planes through corners, and askew.
        let b = mockup.mesh().bounds();
        let middle: Point = std::array::from_fn(|a| 0.5 * (b.lower[a] + b.upper[a]));
        let through = |normal: Point, p: Point| HalfSpace { normal, offset: (0..3).map(|a| normal[a] * p[a]).sum() };
        let flat = through([0.0, 0.0, -1.0], middle);
        let askew = through([1.0, 0.5, 0.25], middle);
        compare(name, &mockup, &rays, f64::INFINITY, &[flat]);
        compare(name, &mockup, &rays, f64::INFINITY, &[flat, askew]);
    }
}

#[test]
fn rays_from_very_far_away_are_told_apart() {
    let mockup = mockup_of(ball(10, 1.0));
    let scenes: Vec<Scene> = STORAGES.iter().map(|storage| scene(&mockup, *storage, Some(0.1))).collect();
    for far in [1e3, 1e8, 1e15, 1e60, 1e100] {
        for scene in &scenes {
            let hit = |y: f64| {
                let ray = Ray { origin: [-far, y, 0.25], direction: [1.0, 0.0, 0.0] };
                scene.ray(&ray, f64::INFINITY, &[]).unwrap()
            };
            assert!(hit(0.125).is_some() && hit(1.0 + 1e-9).is_none(), "{far}, {:?}", scene.storage());
        }
    }
}

#[test]
fn selections_are_obeyed() {
    let (vertices, faces) = soup(11, 600, 0.3);
    let parts = (0..faces.len() as u32).map(|t| t % 7).collect();
    let mockup = Arc::new(Mockup::new(vertices, faces, parts, 7).unwrap());
    let rays = rays_at(&mockup, 120, &mut Random::new(12));
    for storage in STORAGES {
        let whole = scene(&mockup, storage, Some(0.1));
        for some in [whole.without(&[0, 3]).unwrap(), whole.only(&[2]).unwrap(), whole.only(&[]).unwrap()] {
            let selection = some.index().selection();
            for ray in &rays {
                let hit = some.ray(ray, f64::INFINITY, &[]).unwrap();
                assert_eq!(hit, first_of_all(&mockup, selection, ray, f64::INFINITY, &[]).unwrap());
                assert!(hit.is_none_or(|hit| some.has_part(hit.part) && hit.part == hit.triangle % 7));
            }
        }
    }
}

/// A square of two triangles in the plane z = 0, from -1 to 1, and one below it.
fn plates() -> Scene {
    let square = |z: f64| [[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]];
    let vertices = [square(0.0), square(-1.0)].concat();
    let faces = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let mockup = Arc::new(Mockup::new(vertices, faces, vec![0, 0, 1, 1], 2).unwrap());
    scene(&mockup, Storage::Blocks, None)
}

fn asked(scene: &Scene, origin: Point, direction: Point) -> Option<(u32, f64, Point)> {
    let hit = scene.ray(&Ray { origin, direction }, f64::INFINITY, &[]).unwrap();
    hit.map(|hit| (hit.triangle, hit.distance, hit.normal))
}

#[test]
fn borders_are_met_and_ties_go_to_the_lowest() {
    let scene = plates();
    let up = [0.0, 0.0, 1.0];
    // The diagonal is of both triangles, the rim of one, and a step beyond is outside.
    assert_eq!(asked(&scene, [0.5, 0.5, 2.0], [0.0, 0.0, -1.0]), Some((0, 2.0, up)));
    assert_eq!(asked(&scene, [-1.0, 1.0, 2.0], [0.0, 0.0, -1.0]), Some((1, 2.0, up)));
    assert_eq!(asked(&scene, [1.0, 0.0, 2.0], [0.0, 0.0, -0.5]), Some((0, 2.0, up)));
    assert_eq!(asked(&scene, [1.0f64.next_up(), 0.0, 2.0], [0.0, 0.0, -1.0]), None);
    // From below and from between.
    assert_eq!(asked(&scene, [0.5, 0.25, -0.25], [0.0, 0.0, 4.0]), Some((0, 0.25, [0.0, 0.0, -1.0])));
    assert_eq!(asked(&scene, [0.5, 0.25, -0.25], [0.0, 0.0, -4.0]), Some((2, 0.75, up)));
    // On the surface: at once, whichever way.
    assert_eq!(asked(&scene, [0.5, 0.25, 0.0], [0.0, 0.0, 1.0]).map(|hit| hit.1), Some(0.0));
    assert_eq!(asked(&scene, [0.5, 0.25, 0.0], [1.0, 2.0, 0.0]), Some((0, 0.0, up)));
}

#[test]
fn rays_in_a_plane_come_upon_its_triangles() {
    let scene = plates();
    let up = [0.0, 0.0, 1.0];
    assert_eq!(asked(&scene, [-3.0, 0.5, 0.0], [2.0, 0.0, 0.0]), Some((1, 2.0, up)));
    assert_eq!(asked(&scene, [3.0, -0.5, 0.0], [-1.0, 0.0, 0.0]), Some((0, 2.0, up)));
    // Along the rim, beside it, over a corner, and away.
    assert_eq!(asked(&scene, [-3.0, -1.0, 0.0], [1.0, 0.0, 0.0]), Some((0, 2.0, up)));
    assert_eq!(asked(&scene, [-3.0, 1.0f64.next_up(), 0.0], [1.0, 0.0, 0.0]), None);
    assert_eq!(asked(&scene, [2.0, 0.0, 0.0], [-1.0, 1.0, 0.0]).map(|hit| hit.0), Some(0));
    assert_eq!(asked(&scene, [3.0, 0.5, 0.0], [1.0, 0.0, 0.0]), None);
}

#[test]
fn sections_keep_what_is_in_all_of_them() {
    let scene = plates();
    let down = Ray { origin: [0.5, 0.25, 2.0], direction: [0.0, 0.0, -1.0] };
    let hit = |ray: &Ray, sections: &[HalfSpace]| scene.ray(ray, f64::INFINITY, sections).unwrap();
    let below = |z: f64| HalfSpace { normal: [0.0, 0.0, -2.0], offset: -2.0 * z };
    let above = |z: f64| HalfSpace { normal: [0.0, 0.0, 1.0], offset: z };
    assert_eq!(hit(&down, &[below(0.0)]).map(|hit| hit.triangle), Some(0), "what is on a section is kept");
    assert_eq!(hit(&down, &[below(-5e-324)]).map(|hit| hit.triangle), Some(2));
    assert_eq!(hit(&down, &[below(-0.5), above(-0.9)]), None);
    assert_eq!(hit(&down, &[below(-0.5), above(-1.0)]).map(|hit| hit.distance), Some(3.0));
    assert_eq!(hit(&down, &[above(3.0)]), None, "the ray leaves what is kept before it begins");
    // A ray in the section plane hits a triangle where the section keeps it.
    let along = Ray { origin: [-3.0, 0.5, 0.0], direction: [1.0, 0.0, 0.0] };
    let right = HalfSpace { normal: [1.0, 0.0, 0.0], offset: 0.75 };
    let found = hit(&along, &[right]).unwrap();
    assert_eq!((found.triangle, found.distance, found.point), (0, 3.75, [0.75, 0.5, 0.0]));
}

#[test]
fn max_is_a_length() {
    let scene = plates();
    let ray = Ray { origin: [0.5, 0.25, 2.0], direction: [0.0, 0.0, -8.0] };
    assert!(scene.ray(&ray, 2.0, &[]).unwrap().is_some());
    assert!(scene.ray(&ray, 2.0f64.next_down(), &[]).unwrap().is_none());
    assert!(scene.ray(&Ray { origin: [0.5, 0.25, 0.0], ..ray }, 0.0, &[]).unwrap().is_some());
}

#[test]
fn what_is_no_ray_is_refused() {
    let scene = plates();
    let good = Ray { origin: [0.0; 3], direction: [1.0, 0.0, 0.0] };
    let none: &[HalfSpace] = &[];
    assert_eq!(scene.rays(&[], 1.0, none), Ok(vec![]));
    for direction in [[0.0; 3], [f64::NAN, 1.0, 0.0], [f64::INFINITY, 0.0, 0.0], [1e-101, 0.0, 0.0], [1e101, 1.0, 0.0]]
    {
        let error = scene.rays(&[good, Ray { direction, ..good }], 1.0, none).unwrap_err();
        assert!(matches!(error, Error::Ray { what: "directions", ray: 1, .. }), "{error}");
    }
    for x in [f64::NAN, f64::NEG_INFINITY, 2e100] {
        let error = scene.ray(&Ray { origin: [0.0, x, 0.0], ..good }, 1.0, none).unwrap_err();
        assert!(matches!(error, Error::Ray { what: "origins", ray: 0, .. }), "{error}");
        let section = HalfSpace { normal: [1.0, 0.0, 0.0], offset: x };
        assert!(matches!(scene.ray(&good, 1.0, &[section]), Err(Error::Section { section: 0, .. })));
    }
    let section = HalfSpace { normal: [0.0; 3], offset: 1.0 };
    assert!(matches!(scene.rays(&[], 1.0, &[section]), Err(Error::Section { .. })));
    for max in [-1.0, f64::NAN] {
        assert!(matches!(scene.ray(&good, max, none), Err(Error::Distance { what: "max", .. })));
    }
}
