//! Contact planes and ways out of solids, soups and what lies between: the same from every store and instruction set, and what is
//! promised of them.

use std::sync::Arc;

use arbitrary::{Arbitrary, Result, Unstructured};
use feeler_contacts::{ContactPlane, ContactSolver, ContactTracker, Contacts, PenetrationKind, MOST_PLANES};
use feeler_core::{Aabb, Error, Level, Mockup, Point, Pose, Scene, SceneOptions, Storage, Tool};

use super::shapes::{made, matrix, mesh, solids, unit_and_offset, Arrays};

#[derive(Debug)]
pub struct Case {
    unit: f64,
    offset: f64,
    mockup: Arrays,
    parts: usize,
    tool: Arrays,
    poses: [[[f64; 4]; 4]; 2],
    margin: f64,
}

impl<'a> Arbitrary<'a> for Case {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Case> {
        let (unit, offset) = unit_and_offset(u)?;
        let mut shape = |most: usize| {
            if u.ratio(1, 3)? {
                mesh(u, most, unit, offset)
            } else {
                solids(u, unit, offset)
            }
        };
        let (mockup, tool) = (shape(32)?, shape(12)?);
        let poses = [matrix(u, unit)?, matrix(u, unit)?];
        let margin = match u.int_in_range(0..=7)? {
            0 => 0.0,
            1 => u.arbitrary::<f64>()?,
            2 => f64::INFINITY,
            _ => unit * f64::from(u.int_in_range(1..=40u8)?) * 0.05,
        };
        Ok(Case { unit, offset, mockup, parts: *u.choose(&[1, 1, 1, 2, 3, 5])?, tool, poses, margin })
    }
}

pub fn check(case: Case) {
    // Solids stay whole, but for the last of a part.
    let count = case.mockup.1.len();
    let part = |i: usize| i * case.parts / count;
    let Some((mockup, tool, [pose, before])) = made(case.mockup, part, case.parts, case.tool, &case.poses) else {
        return;
    };
    let extent = |b: Aabb| (0..3).map(|a| b.upper[a] - b.lower[a]).fold(0.0, f64::max);
    let sizes = [extent(mockup.mesh().bounds()), extent(tool.mesh().bounds())];
    // Where lengths, their squares and their ratios are to be had in float64, and rounding is far below the unit.
    let is_plain = (1e-9..1e9).contains(&case.unit)
        && case.offset <= 1e6 * case.unit
        && sizes.iter().all(|size| (case.unit * 1e-3..case.unit * 1e3).contains(size));
    let is_margin = case.margin.is_finite() && case.margin >= 0.0;
    let mut first: Option<[Contacts; 2]> = None;
    // Many voxels take long to fill.
    for (storage, memory_limit) in [(Storage::Blocks, 64 << 20), (Storage::Hashed { level: 0.3 }, 1 << 20)] {
        let options = SceneOptions::default().with_storage(storage).with_tool(&tool).with_memory_limit(memory_limit);
        let Ok(scene) = Scene::build(Arc::clone(&mockup), &options) else { continue };
        let mut scene = Arc::new(scene);
        for lanes in Level::available() {
            Arc::get_mut(&mut scene).expect("no solver has it").set_lanes(lanes);
            let solver = ContactSolver::new(Arc::clone(&scene));
            let what = format!("{storage:?}, {}", lanes.name());
            let found = [None, Some(&before)].map(|reference| solver.contacts(&tool, &pose, case.margin, reference));
            if !is_margin {
                assert!(found.iter().all(|f| matches!(f, Err(Error::Margin { .. }))), "{what}: {found:?}");
                let found = solver.penetration(&tool, &pose, case.margin, None);
                assert!(matches!(found, Err(Error::Margin { .. })), "{what}: {found:?}");
                continue;
            }
            // All pairs may be more than the little that is allowed where there are voxels.
            if storage != Storage::Blocks && found.iter().any(|f| matches!(f, Err(Error::Memory { .. }))) {
                continue;
            }
            let found = found.map(|f| f.unwrap());
            for contacts in &found {
                assert_eq!(contacts.is_meeting, scene.is_colliding(&tool, &pose), "{what}");
                check_planes(contacts, &mockup, &tool, case.margin, is_plain);
                check_footing(contacts, &solver, &tool, &pose, is_plain);
            }
            match &first {
                Some(first) => assert!(is_same(first, &found), "{what}: {found:?} for {first:?}"),
                None => first = Some(found),
            }
        }
        let solver = ContactSolver::new(scene);
        check_way_out(&solver, &tool, &pose, case.margin, is_plain);
        if is_margin {
            let mut tracker = ContactTracker::new();
            for pose in [&before, &pose, &before] {
                let Ok(contacts) = tracker.contacts(&solver, &tool, pose, case.margin) else { break };
                assert!(contacts.is_meeting || tracker.last_free() == Some(pose));
            }
        }
    }
}

fn check_planes(contacts: &Contacts, mockup: &Mockup, tool: &Tool, margin: f64, is_plain: bool) {
    let Contacts { planes, omitted, is_meeting, .. } = contacts;
    assert!(planes.len() <= MOST_PLANES && (*omitted == 0 || planes.len() == MOST_PLANES), "{contacts:?}");
    assert!(planes.is_sorted_by(|p, q| p.gap.total_cmp(&q.gap).is_le()), "{contacts:?}");
    for plane in planes {
        let ContactPlane { point, normal, gap, part, tool_triangles, mockup_triangles, .. } = plane;
        assert!(*gap <= margin && (*is_meeting || *gap > 0.0), "{plane:?}");
        assert!((*part as usize) < mockup.part_bounds().len(), "{plane:?}");
        assert!(mockup_triangles.iter().all(|m| mockup.part_of_face(*m) == *part), "{plane:?}");
        for (ids, mesh) in [(tool_triangles, tool.mesh()), (mockup_triangles, mockup.mesh())] {
            assert!(!ids.is_empty() && ids.is_sorted_by(|a, b| a < b), "{plane:?}");
            assert!(ids.iter().all(|id| mesh.is_queried(*id)), "{plane:?}");
        }
        if is_plain {
            assert!((length(normal) - 1.0).abs() < 1e-9, "{plane:?}");
            assert!(gap.is_finite() && point.iter().all(|x| x.is_finite()), "{plane:?}");
        }
    }
}

fn check_footing(contacts: &Contacts, solver: &ContactSolver, tool: &Tool, pose: &Pose, is_plain: bool) {
    let mut ids: Vec<u64> = contacts.planes.iter().map(|plane| plane.id).collect();
    ids.sort_unstable();
    assert!(ids.is_sorted_by(|a, b| a < b), "two planes of one id: {contacts:?}");
    for plane in &contacts.planes {
        let footing = solver.footing(tool, pose, plane);
        assert!((1..=4).contains(&footing.points().len()), "{plane:?} {footing:?}");
        assert!(!is_plain || footing.points().iter().flatten().all(|x| x.is_finite()), "{plane:?} {footing:?}");
    }
}

fn check_way_out(solver: &ContactSolver, tool: &Tool, pose: &Pose, margin: f64, is_plain: bool) {
    let scene = solver.scene();
    let Ok(found) = solver.penetration(tool, pose, margin, None) else { return };
    let is_meeting = scene.is_colliding(tool, pose);
    // What meets nothing is free, or wholly inside a solid.
    assert!(is_meeting || found.translation == [0.0; 3] || found.kind == PenetrationKind::Bound, "{found:?}");
    if found.kind != PenetrationKind::Estimate {
        let moved = pose.translated(&found.translation).unwrap();
        assert!(!scene.is_colliding(tool, &moved), "{found:?}");
    }
    if is_plain {
        assert!((length(&found.translation) - found.depth).abs() <= 1e-12 * found.depth, "{found:?}");
    }
}

fn length(p: &Point) -> f64 {
    p.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The same, NaN included.
fn is_same(a: &[Contacts; 2], b: &[Contacts; 2]) -> bool {
    format!("{a:?}") == format!("{b:?}")
}
