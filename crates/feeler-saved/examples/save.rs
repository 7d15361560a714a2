//! Saves a hilly ground of 20,000 triangles with its index, opens the file twice, and asks the opened scenes how high a point is above it.
//!
//!     cargo run --release -p feeler-saved --example save

use std::sync::Arc;

use feeler_core::{Mockup, Point, Pose, Progress, Scene, SceneOptions, Tool};
use feeler_saved::{open, save, OpenOptions};

/// A ground of `n` by `n` cells of 1 m.
fn ground(n: u32) -> (Vec<Point>, Vec<[u32; 3]>) {
    let height = |x: u32, y: u32| (0.3 * f64::from(x)).sin() * (0.2 * f64::from(y)).cos();
    let vertices = (0..=n).flat_map(|y| (0..=n).map(move |x| [f64::from(x), f64::from(y), height(x, y)])).collect();
    let at = |x: u32, y: u32| y * (n + 1) + x;
    let cell =
        |x: u32, y: u32| [[at(x, y), at(x + 1, y), at(x + 1, y + 1)], [at(x, y), at(x + 1, y + 1), at(x, y + 1)]];
    (vertices, (0..n).flat_map(|y| (0..n).flat_map(move |x| cell(x, y))).collect())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (vertices, faces) = ground(100);
    let scene = Scene::build(Arc::new(Mockup::new(vertices, faces, Vec::new(), 1)?), &SceneOptions::default())?;
    let path = std::env::temp_dir().join(format!("feeler-example-{}.feeler", std::process::id()));
    let hash = save(&path, &scene, &[], Progress::default())?;
    println!("saved {:032x}, {} bytes", hash, std::fs::metadata(&path)?.len());

    let point = vec![[0.0; 3], [1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0]];
    let tool = Tool::new(point, vec![[0, 1, 2]])?;
    let pose = Pose::IDENTITY.translated(&[40.2, 55.7, 3.0])?;
    let expected = scene.distance(&tool, &pose, 10.0)?;
    // Verified, and trusted: for a file that this program wrote itself.
    for verify in [true, false] {
        let saved = open(&path, &OpenOptions::default().with_verify(verify))?;
        assert_eq!(saved.content_hash, hash);
        assert_eq!(saved.scene.distance(&tool, &pose, 10.0)?, expected);
    }
    println!("{:.4} m above the ground", expected.map_or(f64::INFINITY, |gap| gap.distance));
    std::fs::remove_file(&path)?;
    Ok(())
}
