//! A peg is pressed into a corner of two plates: which planes hold it, and how does it come free?
//!
//!     cargo run --release -p feeler-contacts --example contacts

use std::sync::Arc;

use feeler_contacts::{ContactSolver, ContactTracker};
use feeler_core::{Mockup, Pose, Result, Scene, SceneOptions, Tool};

fn main() -> Result<()> {
    // A floor and a wall, open sheets of two triangles each, metres.
    let vertices =
        vec![[0.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 1.0], [0.0, 1.0, 1.0]];
    let faces = vec![[0, 1, 2], [0, 2, 3], [0, 3, 5], [0, 5, 4]];
    let mockup = Mockup::new(vertices, faces, vec![0, 0, 1, 1], 2)?;
    let scene = Scene::build(Arc::new(mockup), &SceneOptions::default())?;
    let solver = ContactSolver::new(Arc::new(scene));

    // A peg of 10 cm by 10 cm by 20 cm.
    let corners = (0..8).map(|i| std::array::from_fn(|a| [0.1, 0.1, 0.2][a] * (i >> a & 1) as f64)).collect();
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let tool = Tool::new(corners, sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect())?;

    // It comes from where it is free, so that the open sheets have a side.
    let mut tracker = ContactTracker::new();
    let at = |x: f64, z: f64| Pose::IDENTITY.translated(&[x, 0.0, z]);
    for (x, z) in [(0.1, 0.1), (0.001, 0.001), (-0.002, -0.004)] {
        let contacts = tracker.contacts(&solver, &tool, &at(x, z)?, 0.005)?;
        println!("at x = {x}, z = {z}: {} planes, {:.1} mm deep", contacts.planes.len(), 1e3 * contacts.depth());
        for plane in &contacts.planes {
            println!("  part {}: gap {:+.1} mm along {:.3?}", plane.part, 1e3 * plane.gap, plane.normal);
        }
    }
    let free = solver.penetration(&tool, &at(-0.002, -0.004)?, 0.005, tracker.last_free())?;
    println!("free after {:.4?} m ({:?})", free.translation, free.kind);
    Ok(())
}
