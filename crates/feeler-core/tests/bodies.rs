//! Bodies against each other: every pair of triangles, each corner where [`Pose::apply`] puts it, is the judge.

use std::collections::BTreeSet;
use std::sync::Arc;

use feeler_core::{
    closest_triangle_triangle, intersect_triangle_triangle, weld_vertices, Bodies, Error, Pose, Shape, Triangle, Who,
};
use feeler_shapes::random::Random;
use feeler_shapes::soups::{lattice, needles, soup};
use feeler_shapes::{ball, box_mesh, cylinder, Arrays};

fn shape(arrays: Arrays) -> Arc<Shape> {
    Arc::new(Shape::new(arrays.0, arrays.1, u64::MAX).unwrap())
}

/// Triangles in the world, by number.
fn placed(shape: &Shape, pose: &Pose) -> Vec<(u32, Triangle)> {
    shape.mesh().queried().map(|id| (id, pose.apply_triangle(&shape.mesh().triangle(id)))).collect()
}

struct World {
    bodies: Bodies,
    placed: Vec<Vec<(u32, Triangle)>>,
}

impl World {
    fn new(bodies: Vec<(Arc<Shape>, Pose)>) -> World {
        let mut world = World { bodies: Bodies::default(), placed: Vec::new() };
        for (shape, pose) in bodies {
            world.placed.push(placed(&shape, &pose));
            world.bodies.add(shape, pose);
        }
        world
    }

    /// Every two triangles that meet, by brute force.
    fn contacts(&self, a: usize, b: usize) -> Vec<[u32; 2]> {
        let mut found = Vec::new();
        for (s, p) in &self.placed[a] {
            for (t, q) in &self.placed[b] {
                if intersect_triangle_triangle(p, q).is_some() {
                    found.push([*s, *t]);
                }
            }
        }
        found
    }

    fn distance(&self, a: usize, b: usize) -> f64 {
        let each = self.placed[a].iter().flat_map(|(_, p)| self.placed[b].iter().map(move |(_, q)| (p, q)));
        each.map(|(p, q)| closest_triangle_triangle(p, q).distance).fold(f64::INFINITY, f64::min)
    }

    /// Compares all answers with brute force. How many pairs of bodies meet.
    fn check(&self, what: &str) -> usize {
        let n = self.placed.len();
        let (mut pairs, mut triangles, mut least) = (Vec::new(), Vec::new(), f64::INFINITY);
        for a in 0..n {
            for b in a + 1..n {
                let found = self.contacts(a, b);
                if !found.is_empty() {
                    pairs.push([a as u32, b as u32]);
                }
                triangles.extend(found.into_iter().map(|pair| ([a as u32, b as u32], pair)));
                least = self.distance(a, b).min(least);
            }
        }
        assert_eq!(self.bodies.meeting(Who::Each).unwrap(), pairs, "{what}");
        assert_eq!(self.bodies.is_meeting(Who::Each).unwrap(), !pairs.is_empty(), "{what}");
        let contacts = self.bodies.contacts(Who::Each).unwrap();
        let found: Vec<_> = contacts.iter().map(|contact| (contact.bodies, contact.triangles)).collect();
        assert_eq!(found, triangles, "{what}");
        let closest = self.bodies.closest(Who::Each, f64::INFINITY).unwrap().unwrap();
        assert_eq!(closest.distance, least, "{what}");
        for one in 0..n as u32 {
            let with: BTreeSet<u32> = pairs.iter().filter(|pair| pair.contains(&one)).flatten().copied().collect();
            let expected: Vec<_> = with.into_iter().filter(|b| *b != one).map(|b| [one, b]).collect();
            assert_eq!(self.bodies.meeting(Who::One(one)).unwrap(), expected, "{what}, of {one}");
            let least = (0..n).filter(|b| *b != one as usize).map(|b| self.distance(one as usize, b));
            let closest = self.bodies.closest(Who::One(one), f64::INFINITY).unwrap().unwrap();
            assert_eq!(closest.distance, least.fold(f64::INFINITY, f64::min), "{what}, of {one}");
            assert_eq!(closest.bodies[0], one);
        }
        pairs.len()
    }
}

fn shapes() -> Vec<Arc<Shape>> {
    vec![
        shape(ball(0.5, 6)),
        shape(box_mesh([0.0; 3], [1.0, 0.7, 0.4], 1)),
        shape(cylinder(0.2, 1.5, 7, 2)),
        shape(soup(3, 30, 0.5)),
        shape(needles(4, 25, 1e-9)),
        shape(lattice(5, 40, 3)),
    ]
}

#[test]
fn random_bodies_are_as_by_brute_force() {
    let shapes = shapes();
    let (mut meeting, mut apart) = (0, 0);
    for seed in 0..60 {
        let mut random = Random::new(seed);
        // Crowded, sparse, and far from the origin.
        let reach = [0.5, 1.0, 2.5][seed as usize % 3];
        let far = [0.0, 1e3, 1e7][seed as usize / 3 % 3];
        let one = |random: &mut Random| {
            let mut motion = if random.below(3) == 0 { random.lattice_motion(2) } else { random.motion(reach) };
            motion[0][3] += far;
            (Arc::clone(&shapes[random.below(shapes.len() as u64) as usize]), Pose::new(&motion).unwrap())
        };
        let bodies: Vec<_> = (0..7).map(|_| one(&mut random)).collect();
        let found = World::new(bodies).check(&format!("seed {seed}"));
        meeting += found;
        apart += 21 - found;
    }
    assert!(meeting > 120 && apart > 500, "{meeting} meet, {apart} do not");
}

#[test]
fn poses_are_used_as_given_also_where_they_are_not_quite_rigid() {
    // Flush boxes: that a frame is longer by a ten-millionth decides whether they meet.
    let cube = shape(box_mesh([0.0; 3], [1.0, 1.0, 1.0], 1));
    for (stretch, meets) in [(4e-7, true), (0.0, true), (-4e-7, false)] {
        for turned in [false, true] {
            let axis = |k: usize| if k == 0 { 1.0 + stretch } else { 1.0 };
            let stretched = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { axis(i) } else { 0.0 }));
            let stretched = Pose::new(&stretched).unwrap();
            let beside = Pose::IDENTITY.translated(&[1.0, 0.0, 0.0]).unwrap();
            let (a, b) = if turned { (beside, stretched) } else { (stretched, beside) };
            let world = World::new(vec![(Arc::clone(&cube), a), (Arc::clone(&cube), b)]);
            assert_eq!(world.check(&format!("{stretch}")), usize::from(meets));
        }
    }
}

#[test]
fn neither_a_common_motion_nor_who_moves_changes_which_flush_bodies_meet() {
    // Whole numbers are moved without rounding, so brute force and closed form agree: boxes in a row meet their neighbours alone.
    let cube = shape(box_mesh([0.0; 3], [2.0, 2.0, 2.0], 2));
    for place in [[0.0; 3], [64.0, -3.0, 8.0], [1_048_576.0, 0.0, -4096.0]] {
        let at = |i: u32| {
            let mut p = place;
            p[0] += 2.0 * f64::from(i);
            (Arc::clone(&cube), Pose::IDENTITY.translated(&p).unwrap())
        };
        assert_eq!(World::new((0..6).map(at).collect()).check(&format!("{place:?}")), 5);
    }
}

#[test]
fn sets_are_asked_across() {
    let shapes = shapes();
    let mut random = Random::new(11);
    let mut one = |n: usize| -> Vec<(Arc<Shape>, Pose)> {
        let any = |random: &mut Random| Arc::clone(&shapes[random.below(shapes.len() as u64) as usize]);
        (0..n).map(|_| (any(&mut random), Pose::new(&random.motion(2.0)).unwrap())).collect()
    };
    for (n, m) in [(6, 7), (1, 9), (9, 1), (0, 3), (3, 0)] {
        let (first, second) = (one(n), one(m));
        let all = World::new(first.iter().chain(&second).cloned().collect());
        let (mut a, mut b) = (Bodies::default(), Bodies::default());
        first.into_iter().for_each(|(shape, pose)| _ = a.add(shape, pose));
        second.into_iter().for_each(|(shape, pose)| _ = b.add(shape, pose));
        let (mut expected, mut least) = (Vec::new(), f64::INFINITY);
        for i in 0..n {
            for j in 0..m {
                if !all.contacts(i, n + j).is_empty() {
                    expected.push([i as u32, j as u32]);
                }
                least = all.distance(i, n + j).min(least);
            }
        }
        assert_eq!(a.meeting(Who::Others(&b)).unwrap(), expected, "{n} and {m}");
        assert_eq!(a.is_meeting(Who::Others(&b)).unwrap(), !expected.is_empty());
        let gap = a.closest(Who::Others(&b), f64::INFINITY).unwrap();
        assert_eq!(gap.map_or(f64::INFINITY, |gap| gap.distance), least);
    }
}

#[test]
fn what_lies_in_a_solid_body_meets_it() {
    let (outer, inner) = (ball(1.0, 12), ball(0.2, 5));
    let hollow = shape(outer.clone());
    let solid = Arc::new(Shape::new(outer.0, outer.1, u64::MAX).unwrap().solid_if_convex());
    let inner = shape(inner);
    for (x, is_in) in [(0.0, true), (0.7, true), (0.9, true), (1.0, true), (1.3, false), (5.0, false)] {
        let pose = Pose::IDENTITY.translated(&[x, 0.0, 0.0]).unwrap();
        for (around, expected) in [(&solid, is_in), (&hollow, is_in && x > 0.75)] {
            let mut bodies = Bodies::default();
            bodies.add(Arc::clone(&inner), pose);
            bodies.add(Arc::clone(around), Pose::IDENTITY);
            assert_eq!(bodies.is_meeting(Who::Each).unwrap(), expected, "{x}");
            let contacts = bodies.contacts(Who::Each).unwrap();
            assert_eq!(!contacts.is_empty(), expected);
            assert!(contacts.iter().all(|contact| contact.kind.is_some() == (x > 0.75)), "{x}");
        }
    }
}

#[test]
fn closed_convex_shapes_are_solid() {
    let is_solid = |vertices: &[[f64; 3]], faces: &[[u32; 3]]| {
        Shape::new(vertices.to_vec(), faces.to_vec(), u64::MAX).unwrap().solid_if_convex().is_solid()
    };
    for (vertices, faces) in [ball(0.5, 6), box_mesh([0.3; 3], [0.1, 1e2, 1.0], 2), cylinder(0.2, 1.5, 7, 1)] {
        let (vertices, faces) = welded(&vertices, &faces);
        assert!(is_solid(&vertices, &faces));
        // Rounded, taken apart, far away.
        let rounded: Vec<_> = vertices.iter().map(|p| p.map(|x| f64::from(x as f32))).collect();
        assert!(is_solid(&rounded, &faces));
        let apart: Vec<_> = faces.iter().flatten().map(|v| vertices[*v as usize]).collect();
        let each: Vec<_> = (0..faces.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        assert!(is_solid(&apart, &each));
        let far: Vec<_> = vertices.iter().map(|p| p.map(|x| x + 64.0)).collect();
        assert!(is_solid(&far, &faces));
        assert!(is_solid(&vertices, &faces.iter().map(|[a, b, c]| [*a, *c, *b]).collect::<Vec<_>>()), "inside out");
        // Open, two of them, dented, with a triangle twice.
        assert!(!is_solid(&vertices, &faces[1..]));
        let n = vertices.len() as u32;
        let two: Vec<_> = vertices.iter().copied().chain(vertices.iter().map(|p| p.map(|x| x + 300.0))).collect();
        let both: Vec<_> = faces.iter().copied().chain(faces.iter().map(|f| f.map(|v| v + n))).collect();
        assert!(!is_solid(&two, &both));
        let mut dented = vertices.clone();
        dented[0] = dented[0].map(|x| -0.2 * x);
        assert!(!is_solid(&dented, &faces));
        assert!(!is_solid(&vertices, &[&faces[..], &faces[..2]].concat()));
    }
    let (vertices, faces) = soup(3, 30, 0.5);
    assert!(!is_solid(&vertices, &faces));
}

/// Vertices that are there once, and the faces of them.
fn welded(vertices: &[[f64; 3]], faces: &[[u32; 3]]) -> Arrays {
    let (unique, index) = weld_vertices(vertices);
    (unique, faces.iter().map(|face| face.map(|v| index[v as usize])).collect())
}

#[test]
fn bodies_come_go_and_move() {
    let cube = shape(box_mesh([0.0; 3], [1.0; 3], 1));
    let at = |x: f64| Pose::IDENTITY.translated(&[x, 0.0, 0.0]).unwrap();
    let mut bodies = Bodies::default();
    assert_eq!(bodies.closest(Who::Each, f64::INFINITY), Ok(None));
    let [a, b] = [0.0, 3.0].map(|x| bodies.add(Arc::clone(&cube), at(x)));
    assert_eq!(bodies.closest(Who::Each, 1.9), Ok(None));
    assert_eq!(bodies.closest(Who::Each, 2.0).unwrap().unwrap().distance, 2.0);
    bodies.set_pose(b, at(0.5)).unwrap();
    assert_eq!(bodies.meeting(Who::Each), Ok(vec![[a, b]]));
    bodies.remove(a).unwrap();
    assert_eq!(bodies.meeting(Who::Each), Ok(vec![]));
    assert_eq!(bodies.numbers().collect::<Vec<_>>(), [b]);
    for refused in [bodies.remove(a), bodies.set_pose(7, at(0.0)), bodies.meeting(Who::One(a)).map(drop)] {
        assert!(matches!(refused, Err(Error::NoSuchBody { .. })));
    }
    assert_eq!(bodies.add(Arc::clone(&cube), at(0.0)), a);
    let limited = Bodies::with_memory_limit(100);
    assert_eq!(limited.contacts(Who::Each), Ok(vec![]));
    let mut limited = limited;
    for x in [0.0, 0.5] {
        limited.add(Arc::clone(&cube), at(x));
    }
    assert!(matches!(limited.contacts(Who::Each), Err(Error::Memory { .. })));
}

#[test]
fn answers_do_not_depend_on_threads() {
    let shapes = shapes();
    let mut random = Random::new(5);
    let mut bodies = Bodies::default();
    for i in 0..60 {
        bodies.add(Arc::clone(&shapes[i % shapes.len()]), Pose::new(&random.motion(3.0)).unwrap());
    }
    let ask = || (bodies.contacts(Who::Each), bodies.closest(Who::One(3), 9.0), bodies.meeting(Who::Each));
    let on = |n: usize| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(ask);
    let alone = on(1);
    assert!(alone.0.as_ref().is_ok_and(|contacts| contacts.len() > 100));
    assert_eq!(on(2), alone);
    assert_eq!(on(8), alone);
}
