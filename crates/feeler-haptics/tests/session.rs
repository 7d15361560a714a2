//! Sessions stepped by a device: nothing is passed through, the force is the coupling's, and doubtful input releases
//! it.

use std::sync::Arc;

use feeler_core::geometry::twist::{pose_of, rotation_of, rotation_vector};
use feeler_core::geometry::vectors::{length, sub};
use feeler_core::{Mockup, Point, Pose, Scene, SceneOptions, Tool};
use feeler_haptics::{Error, Mode, PutDown, Release, SeatKind, Session, SessionOptions, Start, Step, Wrench};
use feeler_shapes::random::Random;
use feeler_shapes::{ball, box_mesh, cylinder, joined, sheet, Arrays};
use feeler_world::Error as World;
use proptest::prelude::*;

fn scene(parts: impl IntoIterator<Item = Arrays>) -> Arc<Scene> {
    let parts: Vec<Arrays> = parts.into_iter().collect();
    let of_face = parts.iter().enumerate().flat_map(|(i, part)| vec![i as u32; part.1.len()]).collect();
    let count = parts.len();
    let (vertices, faces) = joined(parts);
    let mockup = Mockup::new(vertices, faces, of_face, count).unwrap();
    Arc::new(Scene::build(Arc::new(mockup), &SceneOptions::default()).unwrap())
}

fn tool((vertices, faces): Arrays) -> Arc<Tool> {
    Arc::new(Tool::new(vertices, faces).unwrap())
}

fn at(place: Point, turn: Point) -> Pose {
    pose_of(&rotation_of(&turn), &place).unwrap()
}

fn begun(scene: &Arc<Scene>, tool: &Arc<Tool>, pose: &Pose, options: SessionOptions) -> Session {
    let mut session = Session::new(scene.clone(), tool.clone(), options).unwrap();
    assert_eq!(session.start(pose).unwrap(), Start::Free);
    session
}

/// A step, after which the proxy is free by the exact test.
fn step(session: &mut Session, pose: &Pose) -> Step {
    let step = session.step(Some(pose), 0.001).unwrap();
    assert!(!session.is_colliding(&step.proxy), "{:?}", step.proxy);
    step
}

fn flat(half: f64, cells: usize) -> Arrays {
    sheet(cells, cells, |s, t| [half * (2.0 * s - 1.0), half * (2.0 * t - 1.0), 0.0])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// A sheet without thickness, a tool that tumbles into it at any speed: all of it stays on its side.
    #[test]
    fn nothing_passes_a_sheet(speed in 0.1..3.0f64, spin in prop::array::uniform3(-60.0..60.0f64), aside in prop::array::uniform2(-1.0..1.0f64), cells in 1usize..12, hz in prop::option::of(10.0..300.0f64)) {
        let (wall, block) = (scene([flat(3.0, cells)]), tool(box_mesh([0.01, 0.0, 0.0], [0.03, 0.04, 0.05], 2)));
        let options = SessionOptions::default().with_collision_hz(hz);
        let mut session = begun(&wall, &block, &at([0.0, 0.0, 0.1], [0.0; 3]), options);
        for k in 0..300 {
            let t = 0.001 * f64::from(k);
            let device = at([aside[0] * t, aside[1] * t, 0.1 - speed * t], spin.map(|w| w * t));
            let now = step(&mut session, &device);
            let low = block.mesh().vertices().iter().map(|p| now.proxy.apply(p)[2]).fold(1.0, f64::min);
            prop_assert!(low > 0.0, "{k}: {low}");
        }
    }

    /// A grid of wires, thinner than any step, with meshes narrower than the tool: it is caught.
    #[test]
    fn nothing_passes_a_grid_of_wires(speed in 0.1..3.0f64, spin in prop::array::uniform3(-40.0..40.0f64), offset in 0.0..0.008f64) {
        let places = || (-12..=12).map(|i| 0.008 * f64::from(i) + offset);
        let along_x = places().map(|y| box_mesh([0.0, y, 0.0], [1.0, 2e-5, 2e-5], 1));
        let along_y = places().map(|x| box_mesh([x, 0.0, 0.0], [2e-5, 1.0, 2e-5], 1));
        let (grid, block) = (scene(along_x.chain(along_y)), tool(box_mesh([0.0; 3], [0.04, 0.03, 0.012], 3)));
        let mut session = begun(&grid, &block, &at([0.0, 0.0, 0.06], [0.0; 3]), SessionOptions::default());
        for k in 0..200 {
            let t = 0.001 * f64::from(k);
            let now = step(&mut session, &at([0.0, 0.0, 0.06 - speed * t], spin.map(|w| w * t)));
            prop_assert!(now.proxy.translation()[2] > -0.001, "{k} {now:?}");
        }
    }
}

/// Pushed in, after the force has come up.
fn pressed(scene: &Arc<Scene>, tool: &Arc<Tool>, high: f64, low: f64) -> Step {
    let mut session = begun(scene, tool, &at([0.0, 0.0, high], [0.0; 3]), SessionOptions::default());
    let mut last = None;
    for k in 0..600 {
        let z = high + (low - high) * (f64::from(k) / 300.0).min(1.0);
        last = Some(step(&mut session, &at([0.0, 0.0, z], [0.0; 3])));
    }
    last.unwrap()
}

#[test]
fn the_force_does_not_depend_on_the_triangles() {
    let plate = |cells| box_mesh([0.0, 0.0, -0.01], [0.2, 0.2, 0.02], cells);
    let block = |cells| tool(box_mesh([0.0, 0.0, 0.01], [0.02, 0.03, 0.02], cells));
    // 2 mm deep, and the skin: 1000 N/m of it.
    for (of_plate, of_block) in [(1, 1), (1, 12), (40, 1), (40, 12)] {
        let force = pressed(&scene([plate(of_plate)]), &block(of_block), 0.005, -0.002).wrench.force;
        assert!((force[2] - 2.02).abs() < 1e-4 && force[0].hypot(force[1]) < 1e-6, "{of_plate} {of_block}: {force:?}");
    }
    // A ball on a plate, at 0.1 % of its radius: the mean of its facets.
    let mut forces = Vec::new();
    for n in [24, 48, 96] {
        forces.push(pressed(&scene([plate(3)]), &tool(ball(0.02, n)), 0.025, 0.018).wrench.force[2]);
    }
    assert!(forces.iter().all(|f| (f / forces[2] - 1.0).abs() < 0.05), "{forces:?}");
}

#[test]
fn the_force_is_the_same_by_any_clock() {
    let plate = scene([box_mesh([0.0, 0.0, -0.01], [0.2, 0.2, 0.02], 2)]);
    let block = tool(box_mesh([0.0, 0.0, 0.01], [0.02, 0.03, 0.02], 2));
    let mut r = Random::new(1);
    let even = |dt: f64| Box::new(move |_: &mut Random| dt) as Box<dyn Fn(&mut Random) -> f64>;
    let uneven = |share: f64| Box::new(move |r: &mut Random| 0.001 * (1.0 + share * r.real(-1.0, 1.0))) as _;
    let mut clocks =
        vec![even(1e-3), even(1e-4), even(2e-6), even(0.017), even(0.02), even(0.06), even(0.5), even(1.0)];
    clocks.extend([1e-12, 1e-9, 1e-3, 0.01, 0.1, 0.5].map(uneven));
    clocks.push(Box::new(|r: &mut Random| 10f64.powf(r.real(-5.0, 0.0))));
    for (n, clock) in clocks.iter().enumerate() {
        for hz in [None, Some(100.0)] {
            let options = SessionOptions::default().with_collision_hz(hz);
            let slew = options.coupling.slew_n_per_s;
            let mut session = begun(&plate, &block, &at([0.0, 0.0, 0.005], [0.0; 3]), options);
            let (mut time, mut before, mut sum, mut steps) = (0.0, [0.0; 3], 0.0, 0u32);
            // 50 mm a second, 5 mm deep, and held there.
            let end = if n == 2 { 0.5 } else { 4.0 };
            while time < end {
                let dt = clock(&mut r);
                time += dt;
                let device = at([0.0, 0.0, (0.005 - 0.05 * time).max(-0.005)], [0.0; 3]);
                let step = session.step(Some(&device), dt).unwrap();
                let change = length(&sub(&step.wrench.force, &before));
                // A step shorter than a tick may bring the change of a whole one.
                assert!(change <= slew * dt.max(2.0e-5) + 1e-9, "{n} {hz:?}: {change} at {time} after {dt}");
                before = step.wrench.force;
                if time > 0.8 * end {
                    (sum, steps) = (sum + before[2], steps + 1);
                }
            }
            let mean = sum / f64::from(steps);
            assert!((mean / 5.02 - 1.0).abs() < 0.01, "{n} {hz:?}: {mean}");
        }
    }
    let mut session = begun(&plate, &block, &at([0.0, 0.0, 0.005], [0.0; 3]), SessionOptions::default());
    for dt in [0.0, -1e-3, f64::NAN, f64::INFINITY, 1.0000001] {
        let refused = session.step(Some(&at([0.0; 3], [0.0; 3])), dt);
        assert!(matches!(refused, Err(Error::Option { what: "dt", .. })), "{dt}: {refused:?}");
    }
}

#[test]
fn in_the_air_nothing_at_all_is_felt() {
    let plate = scene([box_mesh([0.0, 0.0, -0.01], [0.4, 0.4, 0.02], 4)]);
    let block = tool(box_mesh([0.0; 3], [0.03, 0.04, 0.05], 2));
    for (hz, speed) in [(None, 3.0), (Some(100.0), 1.0), (Some(100.0), 0.3), (Some(10.0), 0.6)] {
        let options = SessionOptions::default().with_collision_hz(hz);
        let path = |t: f64| at([speed * t - 0.3, 0.02 * (20.0 * t).sin(), 0.5], [0.3 * (9.0 * t).sin(), t, 0.0]);
        let mut session = begun(&plate, &block, &path(0.0), options);
        for k in 0..500 {
            let now = step(&mut session, &path(0.001 * f64::from(k)));
            assert_eq!((now.wrench, now.mode), (Wrench::ZERO, Mode::Free), "{hz:?} {speed} {k}");
        }
    }
    // Near the plate it is as far as that between two sets.
    let options = SessionOptions::default().with_collision_hz(10.0);
    let mut session = begun(&plate, &block, &at([0.0, 0.0, 0.095], [0.0; 3]), options);
    for k in 0..99 {
        step(&mut session, &at([0.0, 0.0, 0.095 - 0.001 * f64::from(k)], [0.0; 3]));
        let set = session.constraints().unwrap();
        assert!(set.rows().is_empty() && set.margin > 0.06 && set.margin <= 0.07, "{k} {}", set.margin);
    }
}

#[test]
fn sliding_over_a_cylinder_and_along_a_flat_face_is_smooth() {
    // The force changes by at most 2 % a tick, and by no more than a facet's angle in direction.
    let n = 64;
    let (vertices, faces) = cylinder(0.03, 0.2, n, 4);
    let roller = scene([(vertices, faces)]);
    let block = tool(box_mesh([0.0; 3], [0.02, 0.03, 0.02], 2));
    let turn = std::f64::consts::TAU / n as f64;
    let smooth = |scene: &Arc<Scene>, path: &dyn Fn(f64) -> Pose| {
        let mut session = begun(scene, &block, &path(-0.5), SessionOptions::default());
        let mut before: Option<Wrench> = None;
        for k in 0..2400 {
            let now = step(&mut session, &path(-0.5 + f64::from(k) / 2000.0)).wrench;
            if let Some(before) = before.filter(|_| k > 1100) {
                let (a, b) = (length(&before.force), length(&now.force));
                assert!((b / a - 1.0).abs() < 0.02, "{k}: {a} {b}");
                let cosine = before.force.iter().zip(now.force).map(|(x, y)| x * y).sum::<f64>() / (a * b);
                assert!(cosine.min(1.0).acos() < turn, "{k}: {before:?} {now:?}");
            }
            before = Some(now);
        }
    };
    // The axis is x: around it, 2 mm too deep.
    smooth(&roller, &|t| {
        let (angle, lift) = (0.4 * t.max(0.0), if t < 0.0 { -0.01 * t } else { 0.0 });
        let r = 0.038 + lift;
        at([0.0, r * angle.sin(), r * angle.cos()], [-angle, 0.0, 0.0])
    });
    let floor = scene([box_mesh([0.0, 0.0, -0.01], [0.3, 0.3, 0.02], 70)]);
    smooth(&floor, &|t| at([0.1 * t, 0.03 * t, 0.008 + if t < 0.0 { -0.02 * t } else { 0.0 }], [0.0; 3]));
}

#[test]
fn collision_at_ten_hertz_drags_and_does_not_give_way() {
    let (wall, block) = (scene([flat(1.0, 7)]), tool(box_mesh([0.0; 3], [0.03, 0.04, 0.05], 2)));
    let options = SessionOptions::default().with_collision_hz(10.0);
    let mut session = begun(&wall, &block, &at([0.0, 0.0, 0.06], [0.0; 3]), options);
    let (mut bound, mut oldest) = (0, 0.0f64);
    for k in 0..2000 {
        let t = 0.001 * f64::from(k);
        let now = step(&mut session, &at([0.05 * t, 0.0, 0.06 - 0.05 * t], [0.3 * t, 0.0, 0.0]));
        bound += i32::from(now.mode == Mode::Bound);
        oldest = oldest.max(now.age);
        assert!(length(&now.wrench.force) <= 8.0 + 1e-9);
    }
    assert!(bound > 100 && (0.0985..0.1).contains(&oldest), "{bound} {oldest}");
}

#[test]
fn what_cannot_be_lets_go() {
    let (wall, block) = (scene([flat(1.0, 3)]), tool(box_mesh([0.0; 3], [0.03, 0.04, 0.05], 1)));
    let high = at([0.0, 0.0, 0.06], [0.0; 3]);
    let mut session = Session::new(wall.clone(), block.clone(), SessionOptions::default()).unwrap();
    assert_eq!(session.step(Some(&high), 0.001).unwrap_err(), Error::NotStarted);
    session.start(&high).unwrap();
    for dt in [0.0, -1.0, f64::NAN, f64::INFINITY, 2.0] {
        assert!(matches!(session.step(Some(&high), dt), Err(Error::Option { what: "dt", .. })), "{dt}");
    }
    let deep = at([0.0, 0.0, 0.02], [0.0; 3]);
    let mut force = 0.0;
    for k in 0..500 {
        force = step(&mut session, &at([0.0, 0.0, 0.06 - 0.00008 * f64::from(k)], [0.0; 3])).wrench.force[2];
    }
    assert!(force > 4.0, "{force}");
    // Without input there is no force and the proxy stays. With input the force returns slowly.
    let silent = session.step(None, 0.001).unwrap();
    assert_eq!((silent.wrench, silent.mode), (Wrench::ZERO, Mode::Doubt));
    assert!(step(&mut session, &deep).wrench.force[2] < 0.1);
    // A jump by a metre through the wall: no force in that tick, bounded after it, and the proxy stays on its side.
    for k in 0..300 {
        let now = step(&mut session, &at([0.0, 0.0, -1.0], [0.0; 3]));
        assert!(length(&now.wrench.force) <= 8.0 + 1e-9 && now.proxy.translation()[2] > 0.025, "{k} {now:?}");
        if k == 0 {
            assert_eq!(now.wrench, Wrench::ZERO);
        }
    }
}

#[test]
fn a_deep_start_is_sunk_and_leaves_by_its_place() {
    let (wall, block) =
        (scene([box_mesh([0.0; 3], [0.2, 0.2, 0.02], 3)]), tool(box_mesh([0.0; 3], [0.03, 0.04, 0.05], 1)));
    let mut session = Session::new(wall, block, SessionOptions::default()).unwrap();
    let deep = at([0.0, 0.0, 0.03], [0.0; 3]);
    let Start::Seated(seating) = session.start(&deep).unwrap() else { panic!() };
    let out = seating.way_out.unwrap();
    assert!((length(&out.translation) - 0.005).abs() < 1e-6, "{out:?}");
    assert_eq!(seating.seats.iter().map(|seat| seat.kind).collect::<Vec<_>>(), [SeatKind::Sunk]);
    let go = |session: &mut Session, to: Point| (0..100).map(|_| step(session, &at(to, [0.0; 3]))).last().unwrap();
    // It moves no deeper, and sideways no farther than the play of its seat: the force acts from the beginning.
    let pressed = go(&mut session, [0.0, 0.0, 0.02]);
    assert!(pressed.proxy.translation()[2] > 0.03 - 2e-5 && pressed.wrench.force[2] > 5.0, "{pressed:?}");
    let aside = go(&mut session, [0.02, 0.0, 0.03]);
    assert!(aside.proxy.translation()[0] < 0.0015 && aside.wrench.force[0] < -5.0, "{aside:?}");
    // It can move up, and from then on it cannot enter again.
    let up = go(&mut session, [0.0, 0.0, 0.04]);
    assert!((up.proxy.translation()[2] - 0.04).abs() < 1e-6 && session.seats().is_empty(), "{up:?}");
    let back = go(&mut session, [0.0, 0.0, 0.03]);
    assert!((back.proxy.translation()[2] - 0.03502).abs() < 1e-6, "{back:?}");
}

#[test]
fn a_gripped_part_leaves_its_seat_and_is_kept_out_of_the_rest() {
    // A block seated on a plate (they share a plane), a wall beside it, and a hand above the block.
    let plate = box_mesh([0.0, 0.0, -0.01], [0.4, 0.4, 0.02], 4);
    let block = box_mesh([0.0, 0.0, 0.02], [0.04, 0.04, 0.04], 2);
    let wall = box_mesh([0.1, 0.0, 0.05], [0.02, 0.4, 0.1], 3);
    let (scene, hand) = (scene([plate, block, wall]), tool(box_mesh([0.0, 0.0, 0.06], [0.02, 0.02, 0.0399], 1)));
    let mut session = begun(&scene, &hand, &Pose::IDENTITY, SessionOptions::default());
    let go = |session: &mut Session, from: Point, to: Point| {
        let mut last = None;
        for k in 0..=300 {
            let share = f64::from(k) / 300.0;
            last = Some(step(session, &at(std::array::from_fn(|a| from[a] + share * (to[a] - from[a])), [0.0; 3])));
        }
        last.unwrap()
    };
    assert!(matches!(session.grip(&[3]), Err(Error::Core(_))));
    assert_eq!(session.release(Release::Here), Err(Error::World(World::HoldsNothing)));
    let before = go(&mut session, [0.0; 3], [0.0; 3]).wrench;
    session.grip(&[1]).unwrap();
    assert_eq!(session.grip(&[2]), Err(Error::World(World::HoldsAlready { part: 1 })));
    let after = step(&mut session, &Pose::IDENTITY);
    assert!(length(&sub(&after.wrench.force, &before.force)) < 1e-3, "{before:?} {after:?}");
    // It does not move down: the seat holds it, although collisions with the plate are ignored.
    let pressed = go(&mut session, [0.0; 3], [0.0, 0.0, -0.005]);
    assert!(pressed.proxy.translation()[2] > -1e-6 && pressed.wrench.force[2] > 3.0, "{pressed:?}");
    // Moved up, it leaves its seat. From now on the plate and the wall stop it.
    let up = go(&mut session, [0.0, 0.0, -0.005], [0.0, 0.0, 0.03]);
    assert!((up.proxy.translation()[2] - 0.03).abs() < 1e-6 && session.seats().is_empty());
    let aside = go(&mut session, [0.0, 0.0, 0.03], [0.075, 0.0, 0.03]);
    // It leans on the wall, held above the place where it touches.
    let vertices = session.world().tool().mesh().vertices().to_vec();
    let far = vertices.iter().map(|p| aside.proxy.apply(p)[0]).fold(0.0, f64::max);
    assert!((far - (0.09 - 2e-5)).abs() < 1e-6 && aside.mode == Mode::Contact, "{far} {aside:?}");
    go(&mut session, [0.075, 0.0, 0.03], [0.05, 0.0, 0.03]);
    let down = go(&mut session, [0.05, 0.0, 0.03], [0.05, 0.0, -0.02]);
    assert!((down.proxy.translation()[2] - 2e-5).abs() < 1e-6, "{down:?}");
    // The block is put down and the hand leaves: the block is at its new place only.
    session.release(Release::Here).unwrap();
    assert_eq!(session.world().moved().collect::<Vec<_>>(), [1]);
    go(&mut session, [0.05, 0.0, -0.02], [0.05, 0.0, 0.05]);
    let over = go(&mut session, [0.05, 0.0, 0.05], [0.05, 0.0, -0.01]);
    assert!(over.proxy.translation()[2] > -1e-4 && over.mode == Mode::Contact, "{over:?}");
    go(&mut session, [0.05, 0.0, 0.05], [0.0, 0.0, 0.05]);
    let empty = go(&mut session, [0.0, 0.0, 0.05], [0.0, 0.0, -0.039]);
    assert!(empty.proxy.translation()[2] < -0.038, "{empty:?}");
    // The block cannot return to the place where the hand is; from above it can.
    go(&mut session, [0.0, 0.0, -0.039], [0.0, 0.0, 0.05]);
    go(&mut session, [0.0, 0.0, 0.05], [0.05, 0.0, 0.05]);
    session.grip(&[1]).unwrap();
    go(&mut session, [0.05, 0.0, 0.05], [0.05, 0.0, 0.08]);
    session.release(Release::PutBack).unwrap();
    assert!(session.world().moved().next().is_none() && session.world().gripped().is_empty());
    go(&mut session, [0.05, 0.0, 0.08], [0.0, 0.0, 0.08]);
    let again = go(&mut session, [0.0, 0.0, 0.08], [0.0, 0.0, -0.02]);
    assert!(again.proxy.translation()[2] > -1e-4, "{again:?}");
}

#[test]
fn a_part_that_lies_elsewhere_from_the_beginning_is_felt_there_as_in_its_place() {
    // The block is 0.25 m aside, and turned by nothing, so that all that it does is the same.
    let aside = [0.25, 0.0, 0.0];
    let (plate, block) = (box_mesh([0.0, 0.0, -0.51], [0.4, 0.4, 0.02], 4), box_mesh([0.0, 0.0, 0.02], [0.04; 3], 2));
    let mockup = scene([plate.clone(), block.clone()]);
    let moved = (block.0.iter().map(|p| std::array::from_fn(|a| p[a] + aside[a])).collect(), block.1.clone());
    let put_down = || vec![PutDown::new(1, scene([moved.clone()]))];
    let hand = tool(box_mesh([0.0; 3], [0.02; 3], 1));
    let start = |from: &Pose, scene: &Arc<Scene>, put_down: Vec<PutDown>| {
        let mut session =
            Session::with_put_down(scene.clone(), hand.clone(), put_down, SessionOptions::default()).unwrap();
        assert_eq!(session.start(from).unwrap(), Start::Free);
        session
    };
    // Down onto the block, 5 mm deep, and along it.
    let way = |k: i32| {
        let (along, down) = (f64::from((k - 200).max(0)), f64::from(k.min(200)));
        at([-0.01 + 1e-4 * along, 0.0, 0.055 - 1e-4 * down], [0.0; 3])
    };
    let shifted = |pose: &Pose| pose.translated(&aside).unwrap();
    let mut in_place = start(&way(0), &mockup, vec![]);
    let mut elsewhere = start(&shifted(&way(0)), &mockup, put_down());
    assert_eq!(elsewhere.world().moved().collect::<Vec<_>>(), [1]);
    for k in 0..300 {
        let (one, other) = (step(&mut in_place, &way(k)), step(&mut elsewhere, &shifted(&way(k))));
        assert!(length(&sub(&one.wrench.force, &other.wrench.force)) < 1e-6, "{k} {one:?} {other:?}");
        let (there, here) = (other.proxy.translation(), one.proxy.translation());
        assert!(length(&sub(&sub(there, here), &aside)) < 1e-8, "{k} {here:?} {there:?}");
        assert_eq!(one.mode, other.mode);
    }
    assert!(step(&mut in_place, &way(299)).wrench.force[2] > 4.0);
    assert_eq!(elsewhere.held().map(|plane| plane.part).collect::<Vec<_>>(), [1]);

    // It is at that place only, and it stays there when the scene changes, even to one without the part.
    let in_top = at([0.0, 0.0, 0.045], [0.0; 3]);
    let lacking = Arc::new(mockup.without(&[1]).unwrap());
    for scene in [&mockup, &lacking] {
        elsewhere.set_scene(scene.clone()).unwrap();
        assert_eq!(elsewhere.start(&in_top).unwrap(), Start::Free);
        let Start::Seated(seating) = elsewhere.start(&shifted(&in_top)).unwrap() else { panic!() };
        let out = seating.way_out.unwrap();
        assert!((out.depth - 0.005).abs() < 1e-6, "{out:?}");
    }
    // It can be gripped again, and returns to its own place.
    elsewhere.start(&shifted(&way(0))).unwrap();
    elsewhere.grip(&[1]).unwrap();
    assert!(elsewhere.world().moved().next().is_none());
    assert_eq!(elsewhere.release(Release::PutBack), Err(Error::World(World::HasNoPlace { part: 1 })));
    elsewhere.set_scene(mockup.clone()).unwrap();
    elsewhere.grip(&[1]).unwrap();
    elsewhere.release(Release::PutBack).unwrap();
    assert!(matches!(elsewhere.start(&in_top).unwrap(), Start::Seated(_)));
}

#[test]
fn what_lies_elsewhere_is_one_part_of_the_mockup_once() {
    let mockup = scene([box_mesh([0.0; 3], [0.02; 3], 1), box_mesh([0.1; 3], [0.02; 3], 1)]);
    let hand = tool(box_mesh([0.0; 3], [0.02; 3], 1));
    let alone = || scene([box_mesh([0.2; 3], [0.02; 3], 1)]);
    let refused = |put_down: Vec<PutDown>| {
        Session::with_put_down(mockup.clone(), hand.clone(), put_down, SessionOptions::default()).err()
    };
    let part = |part, scene| PutDown::new(part, scene);
    assert!(matches!(refused(vec![part(2, alone())]), Some(Error::Core(_))));
    assert_eq!(refused(vec![part(0, mockup.clone())]), Some(Error::World(World::PutDown { part: 0, parts: 2 })));
    assert_eq!(
        refused(vec![part(1, alone()), part(1, alone())]),
        Some(Error::World(World::PutDown { part: 1, parts: 1 }))
    );
    let gone = Arc::new(alone().without(&[0]).unwrap());
    assert_eq!(refused(vec![part(0, gone)]), Some(Error::World(World::PutDown { part: 0, parts: 1 })));
    assert_eq!(refused(vec![part(1, alone()), part(0, alone())]), None);
    // A different mock-up without such a part changes nothing.
    let options = SessionOptions::default();
    let mut session = Session::with_put_down(mockup.clone(), hand.clone(), vec![part(1, alone())], options).unwrap();
    session.start(&at([0.0, 0.0, 0.1], [0.0; 3])).unwrap();
    assert!(matches!(session.set_scene(alone()), Err(Error::Core(_))));
    assert_eq!(session.world().moved().collect::<Vec<_>>(), [1]);
}

#[test]
fn a_box_on_edge_falls_flat_and_slides_over_the_border() {
    let (plate, block) =
        (scene([box_mesh([0.0, 0.0, -0.01], [0.1, 0.1, 0.02], 3)]), tool(box_mesh([0.0; 3], [0.02; 3], 2)));
    let mut session = begun(&plate, &block, &at([0.0, 0.0, 0.05], [0.7, 0.0, 0.0]), SessionOptions::default());
    for k in 0..400 {
        // The hand tilts it, and presses: it lies down.
        step(&mut session, &at([0.0, 0.0, 0.05 - 0.0002 * f64::from(k)], [0.7 - 0.0017 * f64::from(k), 0.0, 0.0]));
    }
    let flat = step(&mut session, &at([0.0, 0.0, -0.03], [0.02, 0.0, 0.0]));
    assert!(length(&rotation_vector(flat.proxy.rotation())) < 0.01, "{flat:?}");
    let mut last = flat;
    for k in 0..400 {
        last = step(&mut session, &at([0.0004 * f64::from(k), 0.0, -0.03], [0.02, 0.0, 0.0]));
    }
    // Past the border it falls, down to the device.
    assert!(last.proxy.translation()[2] < -0.02, "{last:?}");
}
