//! A gripper takes a block off a table, carries it against a shelf, and puts it down: which motions are free with the block in it?
//!
//!     cargo run --release -p feeler-world --example grip

use std::sync::Arc;

use feeler_core::{Mockup, Point, Pose, Scene, SceneOptions, Tool};
use feeler_world::{Release, WalkOptions, World};

/// The eight corners and twelve triangles of a box, metres.
fn cuboid(lower: Point, upper: Point) -> (Vec<Point>, Vec<[u32; 3]>) {
    let corner = |i: usize| std::array::from_fn(|a| if i >> a & 1 == 0 { lower[a] } else { upper[a] });
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    ((0..8).map(corner).collect(), faces)
}

/// Moves the tool as far as that is free, and says how far it came and what stopped it.
fn go(world: &World, names: &[&str], from: Point, to: Point) -> Result<f64, Box<dyn std::error::Error>> {
    let around = world.around();
    let at = |p: &Point| Pose::IDENTITY.translated(p);
    let walk = around.walk(&around.seated_at_start(), (&at(&from)?, &at(&to)?), WalkOptions::default())?;
    match walk.stop {
        None => println!("from {from:?} to {to:?}: free"),
        Some(stop) => {
            let share = 100.0 * walk.fraction;
            println!("from {from:?} to {to:?}: the {} stops it after {share:.0} %", names[stop.part as usize]);
        }
    }
    Ok(walk.fraction)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Parts 0, 1 and 2: a table, a block of 10 cm on it, and a shelf 25 cm above the table.
    let names = ["table", "block", "shelf"];
    let boxes = [
        cuboid([-0.5, -0.5, -0.02], [0.5, 0.5, 0.0]),
        cuboid([-0.05, -0.05, 0.0], [0.05, 0.05, 0.1]),
        cuboid([0.2, -0.5, 0.25], [0.5, 0.5, 0.27]),
    ];
    let (mut vertices, mut faces, mut part_of_face) = (vec![], vec![], vec![]);
    for (part, (corners, triangles)) in boxes.into_iter().enumerate() {
        let first = vertices.len() as u32;
        part_of_face.extend(triangles.iter().map(|_| part as u32));
        faces.extend(triangles.iter().map(|t| t.map(|v| v + first)));
        vertices.extend(corners);
    }
    let scene = Scene::build(Arc::new(Mockup::new(vertices, faces, part_of_face, 3)?), &SceneOptions::default())?;
    // The gripper: a small plate, its origin in the middle of its lower side.
    let (vertices, faces) = cuboid([-0.02, -0.02, 0.0], [0.02, 0.02, 0.01]);
    let mut world = World::new(Arc::new(scene), Arc::new(Tool::new(vertices, faces)?), &[])?;

    // Alone it passes between block and shelf.
    let (on_block, beside) = ([0.0, 0.0, 0.1], [0.35, 0.0, 0.1]);
    let (lifted, over_there) = ([0.0, 0.0, 0.3], [0.35, 0.0, 0.3]);
    world.move_to(&Pose::IDENTITY.translated(&lifted)?)?;
    assert_eq!(go(&world, &names, lifted, over_there)?, 1.0);

    // It goes down, and grips the block: from now on the block is not in the mock-up, and moves with the tool.
    let at_block = Pose::IDENTITY.translated(&on_block)?;
    world.move_to(&at_block)?;
    world.grip(&[1], &at_block)?;
    // The block rests on the table. It may slide along it, and part from it, but not go through it.
    assert!(go(&world, &names, on_block, [0.0, 0.0, 0.05])? < 1e-3);
    assert_eq!(go(&world, &names, on_block, lifted)?, 1.0);
    // Lifted and carried aside, it meets the shelf, which the gripper alone did not.
    assert!(go(&world, &names, lifted, over_there)? < 1.0);
    // Under the shelf there is room: it slides over the table.
    assert_eq!(go(&world, &names, on_block, beside)?, 1.0);

    // It puts the block down there: a part of the scene again, in its new place.
    world.release(Release::Here, &Pose::IDENTITY.translated(&beside)?)?;
    println!("put down elsewhere: {:?}", world.moved().map(|part| names[part as usize]).collect::<Vec<_>>());
    assert!(go(&world, &names, [0.0, 0.0, 0.05], [0.35, 0.0, 0.05])? < 1.0);
    Ok(())
}
