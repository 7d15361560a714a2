//! A hand presses a spike onto a plate and slides it over the edge: what does the hand feel?
//!
//!     cargo run --release -p feeler-haptics --example press

use std::sync::Arc;

use feeler_core::{Mockup, Pose, Scene, SceneOptions, Tool};
use feeler_haptics::{Mode, Session, SessionOptions, Start};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A square plate of 20 cm without thickness, and a spike of 2 cm with its tip at the tool's origin.
    let plate = vec![[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [-0.1, 0.1, 0.0]];
    let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
    let spike = vec![[0.0, 0.0, 0.0], [0.01, 0.0, 0.02], [-0.01, 0.01, 0.02], [-0.01, -0.01, 0.02]];
    let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
    let scene = Scene::build(Arc::new(mockup), &SceneOptions::default())?;

    let mut session = Session::new(Arc::new(scene), Arc::new(tool), SessionOptions::default())?;
    let at = |x: f64, z: f64| Pose::IDENTITY.translated(&[x, -0.02, z]);
    assert_eq!(session.start(&at(0.08, 0.01)?)?, Start::Free);
    // A thousand steps a second: down to 3 mm below the plate in 0.2 s, then aside at 5 cm/s, over the edge at x = 0.1.
    for tick in 1..=1000 {
        let time = 1e-3 * f64::from(tick);
        let (x, z) = (0.08 + 0.05 * (time - 0.2).max(0.0), (0.01 - 0.065 * time).max(-0.003));
        let step = session.step(Some(&at(x, z)?), 1e-3)?;
        if tick % 100 == 0 {
            let ([tip_x, _, tip_z], [fx, _, fz]) = (*step.proxy.translation(), step.wrench.force);
            println!(
                "{time:.1} s: hand at ({:6.1}, {:5.1}) mm, tool at ({:6.1}, {:5.1}) mm, force ({fx:5.2}, {fz:5.2}) N, {:?}",
                1e3 * x,
                1e3 * z,
                1e3 * tip_x,
                1e3 * tip_z,
                step.mode
            );
        }
        match tick {
            // On the plate: the tool stays above it, and the spring pushes the hand up.
            400 => {
                assert!(step.mode == Mode::Contact && step.proxy.translation()[2] > 0.0 && step.wrench.force[2] > 2.0)
            }
            // Beyond the edge: free, and no force.
            1000 => assert!(step.mode == Mode::Free && step.wrench.force == [0.0; 3]),
            _ => {}
        }
    }
    Ok(())
}
