//! A tool, parts that it grips, and bodies around it: what is seated, what may go back, and how surfaces are told from each other.

use std::collections::BTreeSet;
use std::sync::Arc;

use feeler_contacts::{ContactSolver, Manifolds};
use feeler_core::geometry::twist::{pose_of, rotation_of, times, transposed};
use feeler_core::geometry::vectors::{scaled, sub};
use feeler_core::{Mockup, Motion, Point, Pose, Scene, SceneOptions, Tool};
use feeler_shapes::{box_mesh, joined, lathe, Arrays};
use feeler_world::{
    least_distance, Body, Environment, Error, PutDown, Release, SeatKind, Surroundings, WalkOptions, World,
};

/// A mock-up with one part for each mesh.
fn scene(parts: &[Arrays]) -> Arc<Scene> {
    let numbers = (0..).zip(parts).flat_map(|(part, (_, faces))| vec![part; faces.len()]).collect();
    let (vertices, faces) = joined(parts.to_vec());
    let mockup = Mockup::new(vertices, faces, numbers, parts.len()).unwrap();
    Arc::new(Scene::build(Arc::new(mockup), &SceneOptions::default()).unwrap())
}

fn tool(parts: &[Arrays]) -> Arc<Tool> {
    let numbers = (0..).zip(parts).flat_map(|(part, (_, faces))| vec![part; faces.len()]).collect();
    let (vertices, faces) = joined(parts.to_vec());
    Arc::new(Tool::of_parts(vertices, faces, numbers, parts.len()).unwrap())
}

fn at(place: Point) -> Pose {
    Pose::IDENTITY.translated(&place).unwrap()
}

fn around(parts: &[Arrays], tool: &Arc<Tool>, start: &Pose) -> Surroundings {
    let body = Body { solver: ContactSolver::new(scene(parts)), part: None };
    Surroundings::around(vec![body], tool.clone(), start).unwrap()
}

#[test]
fn a_part_goes_back_to_its_place_unless_the_tool_is_there() {
    let plate = box_mesh([0.0, 0.0, -0.01], [0.4, 0.4, 0.02], 1);
    let block = box_mesh([0.1, 0.0, 0.02], [0.04; 3], 1);
    let hand = tool(&[box_mesh([0.0; 3], [0.02; 3], 1)]);
    let mut world = World::new(scene(&[plate, block]), hand, &[]).unwrap();
    let off = at([0.1, 0.0, 0.06]);
    world.move_to(&off).unwrap();
    world.grip(&[1], &off).unwrap();
    // In it by its lower half, across one of its sides, and wholly inside, where no surfaces meet.
    for taken in [at([0.1, 0.0, 0.045]), at([0.115, 0.0, 0.02]), at([0.1, 0.0, 0.02])] {
        assert_eq!(world.release(Release::PutBack, &taken), Err(Error::PlaceIsTaken { part: 1 }));
        assert_eq!((world.gripped().len(), world.tool().parts()), (1, 2), "nothing has changed");
    }
    world.release(Release::PutBack, &off).unwrap();
    assert_eq!((world.gripped().len(), world.tool().parts()), (0, 1));
    assert!(world.around().environment().is_colliding(world.tool(), &at([0.115, 0.0, 0.02])));
    assert_eq!(world.release(Release::PutBack, &off), Err(Error::HoldsNothing));
}

#[test]
fn surfaces_of_two_bodies_have_ids_of_their_own() {
    // Two blocks of the same triangles, the second put down beside the first, and a bar over both. Each scene alone gives their upper faces
    // the same id.
    let size = 1.0 / 64.0;
    let block = |x: f64| box_mesh([x, 0.0, 0.0], [size; 3], 1);
    let mockup = scene(&[block(0.0), block(0.5)]);
    let put_down = PutDown::new(1, scene(&[block(2.0 * size)]));
    let bar = tool(&[box_mesh([0.0; 3], [8.0 * size, size, 0.5 * size], 1)]);
    let over = at([size, 0.0, 0.75 * size + 5e-4]);
    let alone = [&mockup, &put_down.scene].map(|scene| {
        let contacts = ContactSolver::new(scene.clone()).contacts(&bar, &over, 0.001, None).unwrap();
        contacts.planes.iter().map(|plane| plane.id).collect::<Vec<_>>()
    });
    assert!(alone[0].len() == 1 && alone[0] == alone[1], "{alone:?}");
    let world = World::new(mockup.clone(), bar.clone(), std::slice::from_ref(&put_down)).unwrap();
    let environment = Environment::new(&mockup, &[put_down]).unwrap();
    let (contacts, _) = environment.contacts(&bar, &over, 0.001, None).unwrap();
    let found: BTreeSet<(u32, u64)> = contacts.planes.iter().map(|plane| (plane.part, plane.id)).collect();
    let ids: BTreeSet<u64> = found.iter().map(|(_, id)| *id).collect();
    assert_eq!((contacts.planes.len(), ids.len()), (2, 2), "{contacts:?}");
    assert_eq!(found.iter().map(|(part, _)| *part).collect::<Vec<_>>(), [0, 1]);
    // The ids are the same wherever the bar is above the blocks.
    let (lower, _) = environment.contacts(&bar, &at([size + 1e-3, 1e-3, 0.75 * size + 2e-4]), 0.001, None).unwrap();
    assert_eq!(lower.planes.iter().map(|plane| (plane.part, plane.id)).collect::<BTreeSet<_>>(), found);
    // So are the ids of manifolds.
    let (around, mut manifolds) = (world.around(), Manifolds::default());
    around.manifolds(&around.seated_at_start(), &over, 0.001, &mut manifolds).unwrap();
    let ids: BTreeSet<u64> = manifolds.manifolds.iter().map(|manifold| manifold.id).collect();
    assert_eq!((manifolds.manifolds.len(), ids.len()), (2, 2));
}

#[test]
fn each_part_of_a_tool_parts_from_its_seat_by_itself() {
    // Two blocks that stand on a plate, and move as one.
    let plate = box_mesh([0.0, 0.0, -0.01], [0.4, 0.4, 0.02], 1);
    let both = tool(&[box_mesh([0.0, 0.0, 0.01], [0.02; 3], 1), box_mesh([0.05, 0.0, 0.01], [0.02; 3], 1)]);
    let around = around(&[plate], &both, &Pose::IDENTITY);
    let kinds =
        |seats: Vec<feeler_world::Seat>| seats.iter().map(|seat| (seat.tool_part, seat.kind)).collect::<Vec<_>>();
    let standing = [(0, SeatKind::Flush), (1, SeatKind::Flush)];
    assert_eq!(kinds(around.seats().collect()), standing);
    let start = around.seated_at_start();
    let walk = |to: &Pose| around.walk(&start, (&Pose::IDENTITY, to), WalkOptions::default()).unwrap();
    // Along the plate both stay seated.
    let along = walk(&at([0.03, 0.02, 0.0]));
    assert!(along.stop.is_none());
    assert_eq!(kinds(along.seated.of(around.seats())), standing);
    // Tilted about the lower right edge of the second block, the first alone comes off.
    let (tilt, edge) = (rotation_of(&[0.0, 0.1, 0.0]), [0.06, 0.0, 0.0]);
    let turned = pose_of(&tilt, &[edge[0] - tilt[0][0] * edge[0], 0.0, -tilt[2][0] * edge[0]]).unwrap();
    let left = around.left_at(&start, &turned).unwrap().expect("one is off");
    assert_eq!(kinds(left.of(around.seats())), [(1, SeatKind::Flush)]);
    // Moved up, both leave their seats.
    assert!(walk(&at([0.0, 0.0, 0.01])).seated.is_free());
}

#[test]
fn each_part_of_a_tool_is_as_deep_as_it_is() {
    // Through a plate without holes, by as much of their lengths.
    let plate = box_mesh([0.0, 0.0, -0.05], [0.4, 0.4, 0.1], 1);
    let bolt = |x: f64, depth: f64| box_mesh([x, 0.0, 0.03 - depth], [0.02, 0.02, 0.06], 1);
    let depths = [0.004, 0.009];
    let both = tool(&[bolt(0.0, depths[0]), bolt(0.06, depths[1])]);
    let around = around(&[plate], &both, &Pose::IDENTITY);
    let seats: Vec<_> = around.seats().collect();
    assert_eq!(seats.len(), 2);
    for (seat, depth) in seats.iter().zip(depths) {
        assert!(seat.kind == SeatKind::Sunk && (seat.depth - depth).abs() < 1e-9, "{seat:?}");
    }
}

#[test]
fn the_least_distance_of_a_motion_is_refined_to_a_share_of_the_tool() {
    // A thin bar passes the end of another, which it is near for less than a step.
    let (gap, size) = (5e-4, 0.1);
    let post = scene(&[box_mesh([0.0; 3], [1e-4, size, 1e-4], 1)]);
    let bar = tool(&[box_mesh([0.0, 0.5 * size + gap + 5e-5, 0.0], [1e-4, 1e-4, size], 1)]);
    for offset in 0..20 {
        let from = at([-0.3 - 0.004 * f64::from(offset), 0.0, 0.0]);
        let motion = Motion::new(&bar, &from, &at([0.4, 0.0, 0.0]));
        let least = least_distance(&post, &bar, &motion, f64::INFINITY, &|| true).unwrap();
        assert!(least >= gap - 1e-12 && least <= gap + size / 64.0, "{offset}: {least}");
    }
}

#[test]
fn a_sunk_part_whose_faces_are_flush_does_not_leave_sideways() {
    // Both ends of a bolt are in the planes of the plate's faces, or one stands out: as it moves aside, surfaces hardly cross.
    let plate = [box_mesh([0.0; 3], [0.2, 0.2, 0.02], 1)];
    for long in [0.02, 0.03] {
        let bolt = tool(&[box_mesh([0.0, 0.0, 0.5 * (long - 0.02)], [0.01, 0.01, long], 1)]);
        let around = around(&plate, &bolt, &Pose::IDENTITY);
        assert_eq!(around.seats().map(|seat| seat.kind).collect::<Vec<_>>(), [SeatKind::Sunk]);
        let start = around.seated_at_start();
        let walk = |by| around.walk(&start, (&Pose::IDENTITY, &at(by)), WalkOptions::default()).unwrap();
        for by in [[0.05, 0.0, 0.0], [0.0, -0.05, 0.0], [0.03, 0.04, 0.0]] {
            let aside = walk(by);
            let far = aside.fraction * 0.05;
            assert!(aside.stop.is_some_and(|stop| stop.is_seat) && far <= 0.02 * around.size() + 1e-5, "{by:?} {far}");
        }
        assert!(walk([0.0, 0.0, 0.05]).stop.is_none());
    }
}

#[test]
fn a_bolt_through_a_plate_leaves_to_either_side_that_nothing_holds() {
    // Both ends flush, one, or none. The second: with a head on the plate, which the way down would press into it.
    let plate = [box_mesh([0.0; 3], [0.2, 0.2, 0.02], 1)];
    for (low, high) in [(-0.01, 0.01), (-0.01, 0.02), (-0.02, 0.01), (-0.015, 0.02), (-0.02, 0.02)] {
        for head in [false, true] {
            let shank = box_mesh([0.0, 0.0, 0.5 * (low + high)], [0.01, 0.01, high - low], 1);
            let on_top = box_mesh([0.0, 0.0, 0.0125], [0.02, 0.02, 0.005], 1);
            let (vertices, faces) = joined(if head { vec![shank, on_top] } else { vec![shank] });
            let around = around(&plate, &Arc::new(Tool::new(vertices, faces).unwrap()), &Pose::IDENTITY);
            let start = around.seated_at_start();
            let is_free = |z: f64| {
                let to = at([0.0, 0.0, z]);
                around.walk(&start, (&Pose::IDENTITY, &to), WalkOptions::default()).unwrap().stop.is_none()
            };
            assert_eq!([is_free(0.06), is_free(-0.06)], [true, !head], "from {low} to {high}, head: {head}");
        }
    }
}

/// A tilt takes the corners of a blind bolt out first, inside the solid, where surfaces do not cross.
#[test]
fn a_sunk_part_does_not_leave_its_place_by_its_corners() {
    let plate = [box_mesh([0.0; 3], [0.2, 0.2, 0.04], 1)];
    // 15 mm deep in the plate, 5 mm above it.
    let (size, low) = ([0.01, 0.01, 0.02], 0.005);
    let bolt = tool(&[box_mesh([0.0, 0.0, low + 0.01], size, 1)]);
    let around = around(&plate, &bolt, &Pose::IDENTITY);
    let start = around.seated_at_start();
    for turn in [[0.4, 0.0, 0.0], [0.0, -0.4, 0.0], [0.3, 0.3, 0.0]] {
        // About the middle of the shank's mouth, and up, so that no corner goes deeper; in steps, as a hand goes.
        let tilted = |by: f64| {
            let rotation = rotation_of(&turn.map(|part| by * part));
            let turned = pose_of(&rotation, &[0.0; 3]).unwrap().apply(&[0.0, 0.0, 0.02]);
            pose_of(&rotation, &[-turned[0], -turned[1], 0.02 + 0.004 * by - turned[2]]).unwrap()
        };
        let mut shown = Pose::IDENTITY;
        let stopped = (1..=200).map(|k| tilted(f64::from(k) / 200.0)).any(|to| {
            let walk = around.walk(&start, (&shown, &to), WalkOptions::default()).unwrap();
            shown = walk.pose;
            walk.stop.is_some()
        });
        let out = (0..8).map(|i| {
            let corner: Point = std::array::from_fn(|a| {
                let side = if i >> a & 1 == 1 { 0.5 } else { -0.5 };
                side * size[a] + if a == 2 { low + 0.01 } else { 0.0 }
            });
            let moved = shown.apply(&corner);
            // How far outside of the box that it filled, of corners within the plate.
            let beyond = |a: usize| (moved[a].abs() - 0.5 * size[a]).max(0.0);
            let below = (low - moved[2]).max(0.0);
            if moved[2] < 0.02 {
                beyond(0).hypot(beyond(1)).hypot(below)
            } else {
                0.0
            }
        });
        let most = out.fold(0.0, f64::max);
        assert!(stopped && most <= 0.021 * around.size() + 1e-5, "{turn:?}: {most} of {}", around.size());
        assert!(most > 0.01 * around.size(), "{turn:?}: {most}");
    }
}

/// A bolt in a plate without a hole, in some frame: its head's face is flush with the plate's, as far as rounding goes.
struct FlushHead {
    around: Surroundings,
    start: Pose,
    frame: Pose,
    face: Vec<Point>,
}

impl FlushHead {
    fn new(bolt: Arrays, above: f64, thick: f64, frame: &Pose) -> FlushHead {
        let (vertices, faces) = box_mesh([0.004, -0.003, -0.5 * thick], [0.1, 0.08, thick], 1);
        let plate = (vertices.iter().map(|p| frame.apply(p)).collect(), faces);
        let start = frame.translated(&times(frame.rotation(), &[0.0, 0.0, above])).unwrap();
        let face = bolt.0.iter().filter(|p| p[2] == 0.0).copied().collect();
        FlushHead { around: around(&[plate], &tool(&[bolt]), &start), start, frame: *frame, face }
    }

    fn moved(&self, by: Point) -> Pose {
        self.start.translated(&times(self.frame.rotation(), &by)).unwrap()
    }

    /// Where it gets by walks along a way to its shares, and how deep the face is at the deepest, metres.
    fn walked(&self, way: Point, shares: &[f64]) -> (Point, f64) {
        let (mut seated, mut pose) = (self.around.seated_at_start(), self.start);
        let into_frame = transposed(self.frame.rotation());
        let went = |pose: &Pose, p: &Point| times(&into_frame, &sub(&pose.apply(p), &self.start.apply(p)));
        let mut deepest = 0.0f64;
        for share in shares {
            let to = self.moved(scaled(&way, *share));
            let walk = self.around.walk(&seated, (&pose, &to), WalkOptions::default()).unwrap();
            (seated, pose) = (walk.seated, walk.pose);
            deepest = self.face.iter().map(|p| -went(&pose, p)[2]).fold(deepest, f64::max);
        }
        (went(&pose, &[0.0; 3]), deepest)
    }
}

fn frames() -> impl Iterator<Item = Pose> {
    let turns = [[0.0; 3], [0.3, -0.2, 0.9], [2.0, 0.7, -1.1]];
    let places = [[0.0; 3], [0.1, 0.2, 0.3], [3000.0, -2000.0, 1000.0]];
    turns.into_iter().flat_map(move |turn| places.map(|place| pose_of(&rotation_of(&turn), &place).unwrap()))
}

/// Countersunk and flat heads, round and square; the shank 20 mm long.
fn heads() -> Vec<Arrays> {
    let turned = |sides: usize, head: &[[f64; 2]]| {
        lathe(&[&[[1e-4, -0.02], [0.003, -0.02]], head, &[[1e-4, 0.0]]].concat(), sides, 0.1)
    };
    let cone = [[0.003, -0.003], [0.006, 0.0]];
    let flat = [[0.003, -0.005], [0.005, -0.005], [0.005, 0.0]];
    vec![turned(16, &cone), turned(64, &cone), turned(33, &flat), turned(4, &flat)]
}

#[test]
fn a_flush_head_goes_no_deeper_in_any_frame() {
    let gaps = [0.0, 1e-15, 1e-12, 1e-9, -1e-12, -1e-9].into_iter().cycle();
    let bolts = heads().into_iter().cycle().zip(gaps.zip([0.04, 0.012].into_iter().cycle()));
    for (frame, (bolt, (above, thick))) in frames().zip(bolts) {
        let head = FlushHead::new(bolt, above, thick, &frame);
        let what = format!("{above} above a plate of {thick}, in {frame:?}");
        assert_eq!(head.around.seats().map(|seat| seat.kind).collect::<Vec<_>>(), [SeatKind::Sunk], "{what}");
        let steps: Vec<f64> = (1..=40).map(|k| f64::from(k) / 40.0).collect();
        for way in [[0.0, 0.0, -1.0], [0.6, 0.0, -0.8], [0.0, -0.95, -0.3], [0.1, 0.99, 0.0]] {
            // In steps that are shorter than the tolerance of contact planes, and at once.
            for (long, shares) in [(1e-4, &steps[..]), (0.005, &[1.0])] {
                let (at, deepest) = head.walked(scaled(&way, long), shares);
                assert!(deepest <= 1.01e-6, "{what}: {deepest} by {way:?}");
                assert!(at[0].hypot(at[1]) < 0.02 * head.around.size() + 1e-5, "{what}: {at:?} by {way:?}");
            }
        }
        let (out, _) = head.walked([0.0, 0.0, 0.04], &steps);
        assert!((out[2] - 0.04).abs() < 1e-9, "{what}: {out:?}");
    }
}

#[test]
fn a_pin_whose_ends_are_flush_leaves_to_both_sides_in_any_frame() {
    for frame in frames() {
        let pin = lathe(&[[1e-4, -0.012], [0.003, -0.012], [0.003, 0.0], [1e-4, 0.0]], 24, 0.1);
        let pin = FlushHead::new(pin, 0.0, 0.012, &frame);
        for z in [0.03, -0.03] {
            let (out, _) = pin.walked([0.0, 0.0, z], &[1.0]);
            assert!((out[2] - z).abs() < 1e-9, "{z} in {frame:?}: {out:?}");
        }
    }
}

#[test]
fn a_sunk_part_that_lies_wholly_in_its_neighbour_is_still_sunk() {
    // Its face is 0.1 mm beneath the plate's: no surface is near another.
    let head = FlushHead::new(heads().swap_remove(0), 0.0, 0.04, &Pose::IDENTITY);
    let start = head.around.seated_at_start();
    assert!(head.around.left_at(&start, &head.moved([0.0, 0.0, -1e-4])).unwrap().is_none());
    assert!(head.around.left_at(&start, &head.moved([0.0, 0.0, 0.03])).unwrap().is_some_and(|left| left.is_free()));
}
