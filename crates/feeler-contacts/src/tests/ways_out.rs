//! The guarantees of ways out, each in a case where nothing else would find one.

use feeler_core::geometry::vectors::length;
use feeler_core::{GoOn, Mockup, Point, Pose};
use feeler_shapes::{ball, box_mesh, box_sides, joined, sheet, Arrays};

use super::{at, scene, tool, Held};
use crate::containment::find::parts_in_containment;
use crate::{Penetration, PenetrationKind};

fn parts(meshes: Vec<Arrays>) -> Held {
    let count = meshes.len();
    let part_of_face = (0..).zip(&meshes).flat_map(|(part, (_, faces))| vec![part; faces.len()]).collect();
    let (vertices, faces) = joined(meshes);
    Held::of(Mockup::new(vertices, faces, part_of_face, count).unwrap())
}

/// A block between corners.
fn block(low: Point, high: Point) -> Arrays {
    let of = |a: usize| (0.5 * (low[a] + high[a]), high[a] - low[a]);
    box_mesh([0, 1, 2].map(|a| of(a).0), [0, 1, 2].map(|a| of(a).1), 2)
}

/// About x, then moved.
fn tilted(degrees: f64, [x, y, z]: Point) -> Pose {
    let (s, c) = degrees.to_radians().sin_cos();
    Pose::new(&[[1.0, 0.0, 0.0, x], [0.0, c, -s, y], [0.0, s, c, z], [0.0, 0.0, 0.0, 1.0]]).unwrap()
}

fn assert_way(found: &Penetration, kind: PenetrationKind, depth: f64, share: f64) {
    assert_eq!(found.kind, kind, "{found:?}");
    assert!(found.depth >= depth * (1.0 - 1e-9) && found.depth <= depth * (1.0 + share), "{depth}: {found:?}");
    assert!((length(&found.translation) - found.depth).abs() < 1e-12, "{found:?}");
}

#[test]
fn a_plane_that_another_way_makes_needless_is_left_out() {
    // A wall pushes the tool aside by 2 mm; a block under its edge asks for a millimetre up, and is left behind by going aside.
    let cube = tool(block([0.0; 3], [0.02; 3]));
    let wall = block([-0.02, -0.01, 0.005], [0.002, 0.03, 0.05]);
    let below = block([-0.02, -0.01, -0.02], [0.0015, 0.03, 0.001]);
    let found = parts(vec![wall, below]).penetration(&cube, &Pose::IDENTITY, 0.0, None).unwrap();
    assert_eq!(found.contacts.planes.len(), 2, "{found:?}");
    assert_way(&found, PenetrationKind::Bound, 0.002, 1e-5);
}

#[test]
fn what_is_met_on_the_way_out_is_gone_around() {
    // Aside by 2 mm it would run into a step of half a millimetre's height that is a millimetre away.
    let cube = tool(block([0.0; 3], [0.02; 3]));
    let wall = block([-0.02, -0.01, 0.005], [0.002, 0.03, 0.05]);
    let step = block([0.021, -0.01, -0.02], [0.05, 0.03, 0.0005]);
    let found = parts(vec![wall, step]).penetration(&cube, &Pose::IDENTITY, 0.0, None).unwrap();
    assert_eq!(found.contacts.planes.len(), 1, "{found:?}");
    assert_way(&found, PenetrationKind::Bound, f64::hypot(0.002, 0.0005), 1e-5);
}

/// A slot along y whose walls go up to z = 0, half as wide as `half`; each a part of its own.
fn slot(half: f64) -> Held {
    parts(vec![block([-0.05, -0.1, -0.06], [-half, 0.1, 0.0]), block([half, -0.1, -0.06], [0.05, 0.1, 0.0])])
}

#[test]
fn a_way_out_by_trial_is_turned_until_it_is_short() {
    // A bar wedged in a slot, and tilted in it: the shortest way is straight up, which is none of the bar's own directions nor one
    // of the walls'.
    let held = slot(0.00995);
    for degrees in [15.0f64, 25.0] {
        let bar = tool(box_mesh([0.0; 3], [0.02, 0.03, 0.02], 2));
        let (s, c) = degrees.to_radians().sin_cos();
        let (lowest, deep) = (-(0.015 * s + 0.01 * c), 0.012);
        let pose = tilted(degrees, [0.0, 0.0, -lowest - deep]);
        let found = held.penetration(&bar, &pose, 0.0, None).unwrap();
        assert_way(&found, PenetrationKind::Bound, deep, 0.03);
    }
}

#[test]
fn out_of_a_solid_it_goes_to_its_surface_though_others_are_nearer() {
    // A block within a plate, tilted against it, with bars nearer by that it is beside of.
    let plate = block([-0.2, -0.2, -0.1], [0.2, 0.2, 0.1]);
    let bars = (0..12).map(|i| {
        let x = 0.0115 + 0.0002 * f64::from(i);
        block([x, -0.002, -0.03], [x + 0.0001, 0.002, 0.03])
    });
    let held = parts(bars.chain([plate]).collect());
    let small = tool(box_mesh([0.0; 3], [0.02, 0.02, 0.01], 1));
    for degrees in [20.0f64, 25.0] {
        let (s, c) = degrees.to_radians().sin_cos();
        let below = 0.01 * s + 0.005 * c;
        let pose = tilted(degrees, [0.0, 0.0, 0.06]);
        assert!(!held.is_colliding(&small, &pose));
        let found = held.penetration(&small, &pose, 0.0, None).unwrap();
        assert_way(&found, PenetrationKind::Bound, 0.04 + below, 0.005);
    }
}

#[test]
fn a_way_through_a_crack_does_not_tell_alone() {
    // A box of a metre whose lid is of two pieces, half a millimetre apart. Ways go to the lid aside of the straight one, and those
    // from some places through the gap.
    let whole = box_sides([0.0; 3], [1.0; 3], |_| [2; 2]);
    let lid = |from: f64, to: f64| sheet(2, 3, move |s, t| [from + s * (to - from), t - 0.5, 0.5]);
    let pieces = whole.into_iter().enumerate().filter(|(side, _)| *side != 4).map(|(_, mesh)| mesh);
    let held = scene(joined(pieces.chain([lid(-0.5, -0.00025), lid(0.00025, 0.5)])));
    assert!(held.mockup().adjacency().has_cracks && held.mockup().adjacency().outward.iter().all(|side| *side != 0));
    let speck = tool(ball(1e-5, 3));
    for i in 0..800 {
        for deep in [0.1, 0.2] {
            let p = [0.0001 * (f64::from(i) - 400.0), 0.01, 0.5 - deep];
            assert_eq!(parts_in_containment(&held, &speck, &at(p[0], p[1], p[2]), GoOn::default()), [0], "{p:?}");
        }
    }
}

#[test]
fn where_nothing_frees_the_tool_it_is_left_between_what_presses_it() {
    // A cavity that is too short for it, in a block much larger than it is.
    let mut cavity = block([0.002, -0.05, -0.05], [0.019, 0.07, 0.07]);
    cavity.1.iter_mut().for_each(|f| f.swap(1, 2));
    let held = scene(joined([block([-1.0; 3], [1.0; 3]), cavity]));
    let cube = tool(block([0.0; 3], [0.02; 3]));
    let found = held.penetration(&cube, &Pose::IDENTITY, 0.0, None).unwrap();
    assert_eq!(found.kind, PenetrationKind::Estimate, "{found:?}");
    // Two millimetres on the one side, one on the other.
    let [x, y, z] = found.translation;
    assert!((1e-4..0.0019).contains(&x) && y.abs().max(z.abs()) < 1e-9, "{found:?}");
}
