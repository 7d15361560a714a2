//! Parts that come out, parts that do not, and paths verified independently.

use std::f64::consts::TAU;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};

use feeler_contacts::ContactSolver;
use feeler_core::{Mockup, Motion, Pose, Scene, SceneOptions, Tool};
use feeler_plan::{removal, Allowed, Error, Method, Removal, RemovalOptions, RemovalTask};
use feeler_shapes::{ball, box_mesh, cylinder, joined, sheet, turned, Arrays, Point};
use feeler_world::{Body, Environment, Surroundings, WalkOptions};

/// Parts, each alone as a tool.
struct Assembly {
    parts: Vec<Arrays>,
    scene: Scene,
}

impl Assembly {
    /// Parts rotated so that no face is parallel to an axis of the world.
    fn new(parts: Vec<Arrays>) -> Assembly {
        let askew = Pose::new(&turned(0.7, [0.31, -0.17, 0.23])).unwrap();
        Assembly::as_given(
            parts
                .into_iter()
                .map(|(vertices, faces)| (vertices.iter().map(|p| askew.apply(p)).collect(), faces))
                .collect(),
        )
    }

    fn as_given(parts: Vec<Arrays>) -> Assembly {
        let numbers = (0..).zip(&parts).flat_map(|(part, (_, faces))| vec![part; faces.len()]).collect();
        let (vertices, faces) = joined(parts.clone());
        let mockup = Mockup::new(vertices, faces, numbers, parts.len()).unwrap();
        let scene = Scene::build(Arc::new(mockup), &SceneOptions::default()).unwrap();
        Assembly { parts, scene }
    }

    fn task(&self, part: usize) -> RemovalTask {
        let (vertices, faces) = self.parts[part].clone();
        RemovalTask::new(Arc::new(Tool::new(vertices, faces).unwrap()), Pose::IDENTITY)
    }

    fn rest(&self, part: usize) -> ContactSolver {
        ContactSolver::new(Arc::new(self.scene.without(&[part as u32]).unwrap()))
    }

    fn remove(&self, part: usize, change: impl FnOnce(&mut RemovalTask)) -> Removal {
        let mut task = self.task(part);
        change(&mut task);
        removal_in(&self.rest(part), &task, 15_000)
    }

    /// Whether a part collides with nothing but the parts `but` at many poses along a path, by the exact test.
    fn is_free(&self, part: usize, poses: &[Pose], but: &[u32]) -> bool {
        let (tool, scene) = (self.task(part).tool, self.scene.without(&[&[part as u32], but].concat()).unwrap());
        let places = |pair: &[Pose]| {
            let motion = Motion::new(&tool, &pair[0], &pair[1]);
            (0..=200).map(move |i| motion.at(f64::from(i) / 200.0)).collect::<Vec<_>>()
        };
        poses.windows(2).flat_map(places).all(|pose| !scene.is_colliding(&tool, &pose))
    }
}

/// A removal with time for this many directions, pushes and extensions of trees.
fn removal_in(solver: &ContactSolver, task: &RemovalTask, rounds: u32) -> Removal {
    let asked = AtomicU32::new(0);
    let has_time = || asked.fetch_add(1, Ordering::Relaxed) < rounds;
    removal(solver, task, &RemovalOptions::default().with_has_time(&has_time)).unwrap()
}

/// A closed tube along x with a hole that a cylinder of as many sides fits.
fn ring(hole: f64, outer: f64, long: f64, sides: usize) -> Arrays {
    let at = |r: f64, s: f64, x: f64| {
        let angle = TAU * if s == 1.0 { 0.0 } else { s };
        [x, angle.sin() * r, -angle.cos() * r]
    };
    let (low, high) = (-0.5 * long, 0.5 * long);
    joined([
        sheet(sides, 4, |s, t| at(outer, s, low + t * long)),
        sheet(4, sides, |t, s| at(hole, s, low + t * long)),
        sheet(1, sides, |t, s| at(outer + t * (hole - outer), s, low)),
        sheet(1, sides, |t, s| at(hole + t * (outer - hole), s, high)),
    ])
}

fn block(lower: Point, upper: Point) -> Arrays {
    let centre = std::array::from_fn(|a| 0.5 * (lower[a] + upper[a]));
    box_mesh(centre, std::array::from_fn(|a| upper[a] - lower[a]), 1)
}

/// A cube of 10 mm in a duct of 14 mm: 46 mm along x, then around a corner, and out along y.
fn duct(is_open: bool) -> Assembly {
    let (w, far) = (0.007, 0.08);
    let mut parts = vec![
        block([-0.005; 3], [0.005; 3]),
        block([-0.02, -0.02, -0.02], [0.07, far, -w]),
        block([-0.02, -0.02, w], [0.07, far, 0.02]),
        block([-0.02, -0.02, -w], [-0.01, 0.02, w]),
        block([-0.01, -0.02, -w], [0.07, -w, w]),
        block([-0.01, w, -w], [0.046, far, w]),
        block([0.06, -w, -w], [0.07, far, w]),
    ];
    if !is_open {
        parts.push(block([0.04, far, -0.02], [0.07, far + 0.01, 0.02]));
    }
    Assembly::new(parts)
}

#[test]
fn a_peg_is_drawn_out_of_its_hole() {
    for play in [0.01, 0.001] {
        let assembly = Assembly::new(vec![cylinder(0.005 * (1.0 - play), 0.04, 24, 2), ring(0.005, 0.02, 0.05, 24)]);
        let found = assembly.remove(0, |_| ());
        assert_eq!(found.method, Some(Method::Straight), "{play}");
        assert!(found.rotation < 1e-12 && found.path_length < 0.08, "{found:?}");
        assert!(assembly.is_free(0, &found.poses, &[]));
        // Facet to facet.
        let gap = 0.005 * play * (TAU / 48.0).cos();
        assert!((found.clearance / gap - 1.0).abs() < 1e-3, "{} {gap}", found.clearance);
    }
}

#[test]
fn what_is_flush_on_five_sides_slides_out_on_the_sixth() {
    let parts = vec![
        block([-0.013, -0.017, -0.011], [0.013, 0.017, 0.011]),
        block([-0.03, -0.03, -0.03], [-0.013, 0.017, 0.03]),
        block([0.013, -0.03, -0.03], [0.03, 0.017, 0.03]),
        block([-0.013, -0.03, -0.03], [0.013, 0.017, -0.011]),
        block([-0.013, -0.03, 0.011], [0.013, 0.017, 0.03]),
        block([-0.013, -0.03, -0.011], [0.013, -0.017, 0.011]),
    ];
    for assembly in [Assembly::new(parts.clone()), Assembly::as_given(parts)] {
        let found = assembly.remove(0, |_| ());
        assert_eq!(found.method, Some(Method::Straight));
        // No contact is allowed, but it touches the surface that it slides on.
        let refused = assembly.remove(0, |task| task.allowed.start = false);
        assert_eq!(refused.method, None);
        assert_eq!(refused.blockers.len(), 5);
    }
}

#[test]
fn a_bolt_without_a_hole_goes_no_deeper_than_it_is() {
    // A head on a plate, and a shank that the plate and a block below have no hole for.
    let bolt = joined([cylinder(0.004, 0.03, 12, 2), cylinder(0.008, 0.006, 12, 1)].map(|(vertices, faces)| {
        let up = if vertices.iter().any(|p| p[0] > 0.01) { 0.0 } else { 0.018 };
        (vertices.iter().map(|p| [p[1], p[2], p[0] + up]).collect::<Vec<Point>>(), faces)
    }));
    let assembly = Assembly::new(vec![
        bolt,
        block([-0.03, -0.03, 0.0], [0.03, 0.03, 0.015]),
        block([-0.03, -0.03, -0.04], [0.03, 0.03, -0.001]),
    ]);
    let found = assembly.remove(0, |_| ());
    assert_eq!(found.method, Some(Method::Straight), "{found:?}");
    // Along its axis, not through the plates, although that is as deep.
    let askew = Pose::new(&turned(0.7, [0.31, -0.17, 0.23])).unwrap();
    let (way, length) = (found.poses[1].translation(), found.path_length);
    assert!((0..3).all(|a| (way[a] / length - askew.rotation()[a][2]).abs() < 1e-6), "{way:?}");
    // If contact with the neighbour is allowed by name, any direction is free.
    let all = assembly.remove(0, |task| task.allowed = Allowed::default().with_parts(vec![1, 2]));
    assert!(all.method.is_some() && all.clearance == f64::INFINITY);
}

#[test]
fn a_fit_goes_no_deeper_than_at_the_start() {
    // A block pressed into a shaft, 0.1 mm in two of its walls; with a ridge across one wall above it, or without.
    let pressed = |ridge: bool| {
        let mut case = vec![
            block([-0.03, -0.03, -0.03], [0.03, 0.03, -0.001]),
            block([-0.03, -0.03, -0.03], [-0.0099, 0.03, 0.04]),
            block([0.0099, -0.03, -0.03], [0.03, 0.03, 0.04]),
            block([-0.03, -0.03, -0.03], [0.03, -0.011, 0.04]),
            block([-0.03, 0.011, -0.03], [0.03, 0.03, 0.04]),
        ];
        if ridge {
            case.push(block([0.008, -0.03, 0.028], [0.03, 0.03, 0.034]));
        }
        let case = case.into_iter().reduce(|one, other| joined(vec![one, other])).unwrap();
        Assembly::new(vec![case, block([-0.01, -0.01, 0.0], [0.01, 0.01, 0.02])])
    };
    let out = pressed(false).remove(1, |_| {});
    assert_eq!(out.method, Some(Method::Straight));
    let stuck = pressed(true).remove(1, |_| {});
    assert_eq!(stuck.method, None);
    assert_eq!(stuck.blockers[0].part, 0);
    // Past the ridge it overlaps by 2 mm, which must be allowed.
    let forced = pressed(true).remove(1, |task| task.allowed.overlap = 0.0025);
    assert!(forced.method.is_some());
}

#[test]
fn so_many_metres_of_overlap_are_allowed() {
    // 0.1 mm too wide for its slot.
    let assembly = Assembly::new(vec![
        block([-0.0101, -0.01, -0.01], [0.0101, 0.01, 0.01]),
        block([0.01, -0.012, -0.03], [0.03, 0.012, 0.02]),
        block([-0.03, -0.012, -0.03], [-0.01, 0.012, 0.02]),
        block([-0.0099, -0.012, -0.03], [0.0099, 0.012, -0.0101]),
    ]);
    let with = |overlap| assembly.remove(0, |task| task.allowed = Allowed::default().with_overlap(overlap));
    assert_eq!(with(1.5e-4).method, Some(Method::Straight));
    let less = with(5e-5);
    assert_eq!((less.method, less.blockers.len()), (None, 2));
}

#[test]
fn around_a_corner_it_takes_pushes_and_the_way_is_free() {
    let assembly = duct(true);
    for seed in 0..4 {
        let found = assembly.remove(0, |task| task.seed = seed);
        assert!(found.method == Some(Method::Pushes), "{seed} {found:?}");
        assert_eq!(found.poses[0], Pose::IDENTITY);
        assert!(assembly.is_free(0, &found.poses, &[]), "{seed}");
        assert!(found.clearance > 0.0 && found.path_length > 0.12 && found.path_length < 0.3, "{found:?}");
    }
}

#[test]
fn the_answer_does_not_depend_on_threads() {
    let assembly = duct(true);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| assembly.remove(0, |task| task.seed = 7))
    };
    let one = with(1);
    assert!(one.method.is_some());
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}

#[test]
fn in_a_closed_box_it_ends_in_time_and_says_what_is_in_the_way() {
    let assembly = duct(false);
    let found = assembly.remove(0, |_| ());
    assert_eq!((found.method, found.is_out_of_time), (None, true));
    assert_eq!(found.poses, [Pose::IDENTITY]);
    assert!(found.blockers.iter().any(|blocker| blocker.part == 7), "{:?}", found.blockers);
    assert!(found.blockers.windows(2).all(|pair| pair[0].count >= pair[1].count));
    // The lid was reached around the corner.
    let lid = found.blockers.iter().find(|blocker| blocker.part == 7).unwrap();
    assert!(lid.reach > 0.06, "{lid:?}");
    let tool = assembly.task(0).tool;
    let gap = assembly.scene.only(&[7]).unwrap().distance(&tool, &lid.pose, 1.0).unwrap().unwrap();
    assert!(gap.distance < 2e-6, "{gap:?}");
}

#[test]
fn the_share_done_grows() {
    let assembly = duct(false);
    let (shares, asked) = (Mutex::new(Vec::new()), AtomicU32::new(0));
    let progress = |share: f64, _: &str| {
        shares.lock().unwrap().push(share);
        true
    };
    let has_time = || asked.fetch_add(1, Ordering::Relaxed) < 15_000;
    let options = RemovalOptions::default().with_progress(&progress).with_has_time(&has_time);
    removal(&assembly.rest(0), &assembly.task(0), &options).unwrap();
    let shares = shares.into_inner().unwrap();
    assert!(shares.len() > 5 && shares[0] == 0.0 && shares.is_sorted_by(|a, b| a < b), "{shares:?}");
    assert!(shares.last().is_some_and(|last| *last < 1.0), "{shares:?}");
}

/// A block of 40 x 24 x 10 mm with so much play to each of some walls: the lower and the upper one along x, then y, then z.
fn boxed(play: f64, walls: &[usize]) -> Assembly {
    let half = [0.02, 0.012, 0.005];
    let parts = [block(half.map(|x| -x), half)].into_iter().chain(boxed_walls(play, walls));
    Assembly::new(parts.collect())
}

fn boxed_walls(play: f64, walls: &[usize]) -> Vec<Arrays> {
    let half = [0.02, 0.012, 0.005];
    let wall = |side: usize| {
        let (axis, sense) = (side / 2, if side.is_multiple_of(2) { -1.0 } else { 1.0 });
        let bound = |end: f64| -> Point {
            std::array::from_fn(|a| if a == axis { sense * (half[a] + play) } else { end * (half[a] + 0.004) })
        };
        let (mut lower, mut upper) = (bound(-1.0), bound(1.0));
        if sense < 0.0 {
            lower[axis] -= 0.004
        } else {
            upper[axis] += 0.004
        }
        block(lower, upper)
    };
    walls.iter().map(|side| wall(*side)).collect()
}

#[test]
fn what_has_nowhere_to_go_is_shown_to_be_held_by_what_holds_it() {
    for play in [0.0, 2e-6, 1e-4, 2e-4] {
        let found = boxed(play, &[0, 1, 2, 3, 4, 5]).remove(0, |_| ());
        let held = found.held.unwrap_or_else(|| panic!("six walls, play {play}"));
        assert_eq!((found.method, held.parts), (None, vec![1, 2, 3, 4, 5, 6]), "play {play}");
        // What its corner may move with the play to each wall, and with the turn that this leaves.
        assert!(held.play >= play * 3.0_f64.sqrt() && held.play < 3e-5 + 12.0 * play, "play {play}: {}", held.play);
        let pressed = boxed(-2e-5, &[0, 1, 2, 3, 4, 5]).remove(0, |_| ());
        assert!(pressed.held.is_some(), "pressed in");
    }
}

#[test]
fn what_has_a_way_is_not_shown_to_be_held() {
    for open in 0..6 {
        let walls: Vec<usize> = (0..6).filter(|side| *side != open).collect();
        for play in [0.0, 1e-4, -2e-5] {
            let found = boxed(play, &walls).remove(0, |task| task.directions.push([0.3, 0.2, 0.1]));
            assert!(found.held.is_none() && found.method.is_some(), "without wall {open}: {found:?}");
        }
    }
    // Two walls instead of one, with a gap between them: over the gap nothing holds.
    let around = duct(true).remove(0, |_| ());
    assert!(around.held.is_none() && around.method.is_some());
}

/// A block in a slot of an L: across it has 0.4 mm to each side.
fn corner() -> Assembly {
    let (w, far) = (0.0054, 0.1);
    Assembly::new(vec![
        block([-0.005; 3], [0.005; 3]),
        block([-0.02, -0.02, -0.02], [0.06, far, -w]),
        block([-0.02, -0.02, w], [0.06, far, 0.02]),
        block([-0.02, -0.02, -w], [-w, far, w]),
        block([-w, -0.02, -w], [0.06, -w, w]),
        block([0.04 + w, -w, -w], [0.06, far, w]),
        block([-w, w, -w], [0.04 - w, far, w]),
    ])
}

/// A window in a wall that a block is beside by less than its play: it moves over, and goes through.
#[test]
fn what_moves_over_within_its_play_and_goes_out_is_not_shown_to_be_held() {
    let (half, play, rim) = ([0.02, 0.012, 0.005], 1e-4, 5e-5);
    let far = half.map(|x| x + play);
    let frame = [
        block([far[0], -0.02, -0.02], [0.03, -half[1] + rim, 0.02]),
        block([far[0], far[1] + 0.001, -0.02], [0.03, 0.02, 0.02]),
        block([far[0], -half[1] + rim, far[2] + 0.001], [0.03, far[1] + 0.001, 0.02]),
        block([far[0], -half[1] + rim, -0.02], [0.03, far[1] + 0.001, -far[2] - 0.001]),
    ];
    let mut parts = vec![block(half.map(|x| -x), half)];
    parts.extend(boxed_walls(play, &[0, 2, 3, 4, 5]));
    parts.extend(frame);
    let found = Assembly::as_given(parts).remove(0, |task| task.directions.push([1.0, 0.0, 0.0]));
    assert!(found.held.is_none(), "{found:?}");
    assert!(found.method.is_some(), "{:?}", found.blockers);
}

#[test]
fn a_way_keeps_off_what_it_passes_and_turns_no_more_than_it_needs() {
    for seed in 0..6 {
        let assembly = corner();
        let found = assembly.remove(0, |task| task.seed = seed);
        assert_eq!(found.rotation, 0.0, "seed {seed}: {found:?}");
        assert!(found.clearance > 5e-5, "seed {seed}: {} m of 0.4 mm, {:?}", found.clearance, found.method);
        assert!(assembly.is_free(0, &found.poses, &[]));
    }
}

#[test]
fn what_may_be_met_holds_nothing() {
    let assembly = boxed(1e-4, &[0, 1, 2, 3, 4, 5]);
    let found = assembly.remove(0, |task| task.allowed.parts = vec![3]);
    assert!(found.held.is_none() && found.method.is_some(), "{found:?}");
    let overlapping = assembly.remove(0, |task| task.allowed.overlap = 0.005);
    assert!(overlapping.held.is_none());
}

#[test]
fn a_way_keeps_its_clearance() {
    let assembly = duct(true);
    let found = assembly.remove(0, |task| task.clearance = 0.0015);
    assert!(found.method.is_some() && found.clearance >= 0.98 * 0.0015, "{found:?}");
    let (tool, scene) = (assembly.task(0).tool, assembly.scene.without(&[0]).unwrap());
    for pair in found.poses.windows(2) {
        let motion = Motion::new(&tool, &pair[0], &pair[1]);
        for i in 0..=100 {
            let pose = motion.at(f64::from(i) / 100.0);
            let gap = scene.distance(&tool, &pose, 1.0).unwrap().unwrap();
            assert!(gap.distance >= 0.98 * 0.0015 && gap.distance >= found.clearance - 3e-4, "{gap:?}");
        }
    }
    // The last wall is never that far: there the duct is 4 mm wider than the cube. Walls that are nearer at the start may stay so.
    assert_eq!(assembly.remove(0, |task| task.clearance = 0.0045).method, None);
}

#[test]
fn a_callers_direction_comes_first() {
    let apart = Assembly::as_given(vec![ball(0.01, 8), block([-0.5, -0.5, -0.5], [0.5, 0.5, -0.01])]);
    let found = apart.remove(0, |task| task.directions = vec![[0.0, 3.0, 1.0]]);
    let way = found.poses[1].translation();
    assert!((way[1] / way[2] - 3.0).abs() < 1e-9, "{way:?}");
    let shortest = apart.remove(0, |_| ());
    assert!(shortest.path_length < 0.05);
}

#[test]
fn what_is_out_needs_no_way() {
    let apart = Assembly::as_given(vec![ball(0.01, 8), block([-0.5, -0.5, -0.5], [0.5, 0.5, -0.05])]);
    let found = apart.remove(0, |_| ());
    assert_eq!((found.method, found.poses.len(), found.path_length), (Some(Method::Out), 1, 0.0));
    assert!((found.clearance - 0.04).abs() < 1e-12);
}

#[test]
fn what_cannot_be_is_refused() {
    let assembly = duct(true);
    let (solver, task) = (assembly.rest(0), assembly.task(0));
    let error = |task: RemovalTask| removal(&solver, &task, &RemovalOptions::default()).unwrap_err();
    for clearance in [-1.0, f64::NAN, f64::INFINITY] {
        let refused = error(task.clone().with_clearance(clearance));
        assert!(matches!(refused, Error::Option { what: "clearance", .. }), "{refused}");
    }
    for direction in [[0.0; 3], [f64::NAN, 0.0, 1.0], [f64::INFINITY, 0.0, 0.0]] {
        let refused = error(task.clone().with_directions(vec![direction]));
        assert!(matches!(refused, Error::Option { what: "directions", .. }), "{refused}");
    }
    let allowed = Allowed::default().with_overlap(-0.1);
    assert!(matches!(error(task.clone().with_allowed(allowed)), Error::Option { what: "allow", .. }));
    // The whole tool is a gripper without parts of the mock-up: it may not start in contact.
    let start = Pose::IDENTITY.translated(&[0.0, 0.0, 0.004]).unwrap();
    let refused = error(task.clone().with_start(start).with_own_parts(0u32));
    assert!(matches!(refused, Error::World(feeler_world::Error::GripMeets { tool_part: 0, .. })), "{refused}");
    let stopped = removal(&solver, &task, &RemovalOptions::default().with_progress(&|_, _| false)).unwrap_err();
    assert_eq!(stopped, Error::Core(feeler_core::Error::Cancelled));
}

#[test]
fn a_way_is_given_as_it_was_found_where_there_is_no_time_to_shorten_it() {
    let assembly = duct(true);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let with = |rounds: u32| pool.install(|| removal_in(&assembly.rest(0), &assembly.task(0), rounds));
    let whole = with(u32::MAX);
    let (mut none, mut found) = (0, 1 << 20);
    while found - none > 1 {
        let rounds = (none + found) / 2;
        if with(rounds).method.is_some() {
            found = rounds;
        } else {
            none = rounds;
        }
    }
    let early = with(found);
    assert_eq!(early.method, Some(Method::Pushes));
    assert!(assembly.is_free(0, &early.poses, &[]));
    // Not yet farther off the walls.
    assert_ne!(early.poses, whole.poses);
}

#[test]
fn a_way_cuts_its_corners() {
    // Along x and then along y it is 242 mm, in ducts that are 15 mm wider than the cube.
    let wide = 0.025;
    let assembly = Assembly::new(vec![
        block([-0.005; 3], [0.005; 3]),
        block([-0.04, -0.04, -0.02], [0.12, 0.12, -0.0055]),
        block([-0.04, -0.04, 0.0055], [0.12, 0.12, 0.02]),
        block([-0.04, -0.04, -0.0055], [-0.006, 0.12, 0.0055]),
        block([-0.006, -0.04, -0.0055], [0.12, -0.006, 0.0055]),
        block([-0.006, -0.006 + wide, -0.0055], [0.08, 0.12, 0.0055]),
        block([0.08 + wide, -0.006, -0.0055], [0.12, 0.12, 0.0055]),
    ]);
    for seed in 0..3 {
        let found = assembly.remove(0, |task| task.seed = seed);
        assert!(found.path_length < 0.235, "{seed} {found:?}");
        assert!(assembly.is_free(0, &found.poses, &[]));
    }
}

#[test]
fn a_direction_that_a_contact_opposes_comes_last() {
    // A cube 0.1 mm off a low wall. Up and a little over it, it is free; so it is along the wall, which is farther.
    let assembly =
        Assembly::as_given(vec![block([-0.01; 3], [0.01; 3]), block([-0.02, -0.05, -0.01], [-0.0101, 0.05, -0.0097])]);
    let (over, along) = ([-0.2, 0.0, 1.0], [0.0, 1.0, 0.0]);
    let way = |directions: Vec<Point>| {
        let found = assembly.remove(0, |task| task.directions = directions);
        assert_eq!(found.method, Some(Method::Straight));
        assert!(assembly.is_free(0, &found.poses, &[]));
        (*found.poses[1].translation(), found.path_length)
    };
    let (alone, near) = way(vec![over]);
    assert!((alone[0] / alone[2] + 0.2).abs() < 1e-9);
    let (both, far) = way(vec![over, along]);
    assert!(both[0] == 0.0 && both[1] > 0.0 && far > near, "{both:?} {far} {near}");
}

#[test]
fn a_way_is_looked_at_more_finely_before_it_is_given() {
    // Between two poses of the search a thin fin goes through a thin post, deeper than an overlap allows.
    let (thin, overlap) = (2e-4, 5e-5);
    let tool = joined([box_mesh([0.0; 3], [0.02; 3], 1), box_mesh([0.0, 0.0125, 0.0], [thin, 0.006, 0.02], 1)]);
    let size = (0.02_f64 * 0.02 + 0.0255 * 0.0255 + 0.02 * 0.02).sqrt();
    let step = size / 32.0;
    let post = box_mesh([20.5 * step, 0.0145, 0.0], [thin, 0.008, 0.05], 1);
    // It is out when it has passed the end of a block that lies off to the side.
    let end = 39.99 * step - 0.01 - 0.01 * size;
    let assembly = Assembly::as_given(vec![tool, post, block([-0.05, -0.05, -0.3], [end, 0.05, -0.2])]);
    let with = |task: &mut RemovalTask| {
        task.allowed.overlap = overlap;
        task.directions = vec![[1.0, 0.0, 0.0]];
    };
    let mut task = assembly.task(0);
    with(&mut task);
    let body = Body { solver: assembly.rest(0), part: None };
    let environment = Environment { bodies: vec![body] };
    let what = (&task.allowed, 0.0);
    let around = Surroundings::new(environment, task.tool.clone(), 1, &task.start, what, &|| true).unwrap();
    let length = around.way_out(&task.start, &[1.0, 0.0, 0.0]);
    assert!((length / step - 39.99).abs() < 1e-6 && (around.size() - size).abs() < 1e-12, "{}", length / step);
    let to = around.moved(&task.start, &[1.0, 0.0, 0.0], length).unwrap();
    let walk = around.walk(&around.seated_at_start(), (&task.start, &to), WalkOptions::default()).unwrap();
    assert!(walk.stop.is_none(), "the search does not see it");
    let found = assembly.remove(0, with);
    assert_eq!(found.method, Some(Method::Straight));
    assert!(found.poses[1].translation()[0] <= 0.0, "{:?}", found.poses);
}
