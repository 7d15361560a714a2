//! A drawer is taken out of a cabinet: which way, what does it need beside it, and what if a pillar stands before it?
//!
//!     cargo run --release -p feeler-plan --example removal

use std::sync::Arc;
use std::time::{Duration, Instant};

use feeler_contacts::ContactSolver;
use feeler_core::{Mockup, Point, Pose, Scene, SceneOptions, Tool};
use feeler_plan::{removal, swept, RemovalOptions, RemovalTask, SweptOptions};

/// The eight corners and twelve triangles of a box, metres.
fn cuboid(lower: Point, upper: Point) -> (Vec<Point>, Vec<[u32; 3]>) {
    let corner = |i: usize| std::array::from_fn(|a| if i >> a & 1 == 0 { lower[a] } else { upper[a] });
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    ((0..8).map(corner).collect(), faces)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Parts 0 to 5: a cabinet of five boards that is open at the front (-y), with 1 mm of play around the drawer; and a pillar
    // 1 cm before its opening.
    let names = ["bottom", "top", "left side", "right side", "back", "pillar"];
    let (w, d, h, t) = (0.201, 0.301, 0.101, 0.02);
    let boxes = [
        cuboid([-w, -d, -h - t], [w, d, -h]),
        cuboid([-w, -d, h], [w, d, h + t]),
        cuboid([-w - t, -d, -h - t], [-w, d, h + t]),
        cuboid([w, -d, -h - t], [w + t, d, h + t]),
        cuboid([-w - t, d, -h - t], [w + t, d + t, h + t]),
        cuboid([-w - t, -d - 0.11, -h - t], [w + t, -d - 0.01, h + t]),
    ];
    let (mut vertices, mut faces, mut part_of_face) = (vec![], vec![], vec![]);
    for (part, (corners, triangles)) in boxes.into_iter().enumerate() {
        let first = vertices.len() as u32;
        part_of_face.extend(triangles.iter().map(|_| part as u32));
        faces.extend(triangles.iter().map(|f| f.map(|v| v + first)));
        vertices.extend(corners);
    }
    let scene = Scene::build(Arc::new(Mockup::new(vertices, faces, part_of_face, 6)?), &SceneOptions::default())?;
    let (vertices, faces) = cuboid([-0.2, -0.3, -0.1], [0.2, 0.3, 0.1]);
    let drawer = Arc::new(Tool::new(vertices, faces)?);
    let task = RemovalTask::new(drawer.clone(), Pose::IDENTITY);

    // The crate reads no clock: how long it may try, the caller says.
    let end = Instant::now() + Duration::from_secs(2);
    let has_time = || Instant::now() < end;
    let options = RemovalOptions::default().with_has_time(&has_time);
    let found = removal(&ContactSolver::new(Arc::new(scene.clone())), &task, &options)?;
    println!(
        "with the pillar: {:?}; most tries were stopped by the {}",
        found.method, names[found.blockers[0].part as usize]
    );
    assert!(found.method.is_none());

    // The same index without the pillar.
    let open = Arc::new(scene.without(&[5])?);
    let found = removal(&ContactSolver::new(open), &task, &RemovalOptions::default())?;
    let (from, to) = (found.poses[0].translation(), found.poses[found.poses.len() - 1].translation());
    println!("without it: {:?}, {:.3} m, from {from:.3?} to {to:.3?}", found.method, found.path_length);
    println!("the least distance on the way is {:.2} mm", 1e3 * found.clearance);
    assert!(to[1] < -0.5);

    // The room that it sweeps, as a closed mesh within 2 cm.
    let room = swept(&drawer, &found.poses, 0.02, &SweptOptions::default())?;
    println!("the room it needs: {} triangles", room.faces.len());
    Ok(())
}
