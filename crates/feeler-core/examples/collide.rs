//! A hook is pulled out of a drum through its lid: is the way free, and if not, which part does it hit?
//!
//!     cargo run --release -p feeler-core --example collide

use std::sync::Arc;

use feeler_core::{Mockup, PathOptions, Point, Pose, Result, Scene, SceneOptions, Tool};

/// The eight corners and twelve triangles of a box, metres.
fn cuboid(lower: Point, upper: Point) -> (Vec<Point>, Vec<[u32; 3]>) {
    let corner = |i: usize| std::array::from_fn(|a| if i >> a & 1 == 0 { lower[a] } else { upper[a] });
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    ((0..8).map(corner).collect(), faces)
}

/// Several boxes as one mesh, and which box each triangle is of.
fn joined(boxes: &[(Point, Point)]) -> (Vec<Point>, Vec<[u32; 3]>, Vec<u32>) {
    let (mut vertices, mut faces, mut part_of_face) = (vec![], vec![], vec![]);
    for (part, (lower, upper)) in boxes.iter().enumerate() {
        let (corners, triangles) = cuboid(*lower, *upper);
        let first = vertices.len() as u32;
        part_of_face.extend(triangles.iter().map(|_| part as u32));
        faces.extend(triangles.iter().map(|t| t.map(|v| v + first)));
        vertices.extend(corners);
    }
    (vertices, faces, part_of_face)
}

fn main() -> Result<()> {
    let parts = ["floor", "left wall", "right wall", "left half of the lid", "right half of the lid"];
    let (vertices, faces, part_of_face) = joined(&[
        ([-0.5, -0.5, -0.02], [0.5, 0.5, 0.0]),
        ([-0.5, -0.5, 0.0], [-0.48, 0.5, 0.6]),
        ([0.48, -0.5, 0.0], [0.5, 0.5, 0.6]),
        ([-0.5, -0.5, 0.6], [-0.1, 0.5, 0.62]),
        ([0.1, -0.5, 0.6], [0.5, 0.5, 0.62]),
    ]);
    let mockup = Mockup::new(vertices, faces, part_of_face, parts.len())?;

    // A shaft with a hook at its foot; the foot is the tool's origin.
    let (vertices, faces, _) =
        joined(&[([-0.02, -0.02, 0.0], [0.02, 0.02, 0.8]), ([-0.02, -0.02, 0.0], [0.16, 0.02, 0.03])]);
    let tool = Tool::new(vertices, faces)?;

    let options = SceneOptions::default().with_tool(&tool);
    let scene = Scene::build(Arc::new(mockup), &options)?;
    let at = |x: f64, z: f64| Pose::IDENTITY.translated(&[x, 0.0, z]);

    let gap = scene.distance(&tool, &at(0.0, 0.1)?, f64::INFINITY)?.expect("a scene is never empty");
    println!("in the drum: {:.3} m to the {}", gap.distance, parts[gap.part as usize]);

    for (name, path) in [
        ("straight up", [at(0.0, 0.1)?, at(0.0, 0.5)?, at(0.0, 0.8)?]),
        ("to the left, then up", [at(0.0, 0.1)?, at(-0.07, 0.5)?, at(-0.07, 0.8)?]),
    ] {
        let check = scene.check_path(&tool, &path, &PathOptions::default().with_tolerance(1e-6))?;
        match check.hits.first() {
            None => println!("{name}: free"),
            Some((segment, hit)) => {
                let part = scene.mockup().part_of_face(hit.mockup_triangle);
                let free = 100.0 * hit.fraction;
                println!("{name}: step {segment} hits the {} after {free:.1} % of its way", parts[part as usize]);
            }
        }
    }

    // What it would cut if it went on.
    let hit = scene.collide(&tool, &at(0.0, 0.6)?);
    println!("in the lid: {} pairs of triangles meet", hit.pairs.len());
    Ok(())
}
