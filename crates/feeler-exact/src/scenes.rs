//! Difficult whole scenes: a mock-up, a tool, and poses at which they fit, lie flush or nearly do.

use feeler_core::{Pose, Triangle};

use crate::random::Random;
use crate::shapes::{circle, cuboid, gear, sheet, tube, Motion};

/// A mock-up and a tool as unconnected triangles, metres, and the poses to try.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The mock-up, in the world.
    pub mockup: Vec<Triangle>,
    /// The tool, in its own frame.
    pub tool: Vec<Triangle>,
    /// `world_from_tool`.
    pub poses: Vec<Pose>,
}

/// Makes one scene.
pub type SceneMaker = fn(&mut Random) -> Setup;

/// How a fit is brought into the world: the mock-up by one motion, the tool by the same (equal numbers), or by another one
/// with the tool modelled elsewhere (equal up to rounding).
fn brought(r: &mut Random, mockup: &[Triangle], tool: &[Triangle], fits: &[Motion]) -> Setup {
    let world = match r.below(5) {
        0 => Motion::NONE,
        1 => Motion::shift(r.point(-3000.0, 3000.0)),
        2 => Motion::random(r, 3000.0),
        _ => Motion::random(r, 1.0),
    };
    let modelled = if r.one_in(2) { Motion::NONE } else { Motion::random(r, 1.0) };
    let back = modelled.inverse();
    Setup {
        mockup: world.applied(mockup),
        tool: modelled.applied(tool),
        poses: fits.iter().map(|fit| world.after(fit).after(&back).pose()).collect(),
    }
}

/// A pin in a hole of the same size, straight, turned by whole and half steps, pushed in part of the way, and with a
/// clearance of a billionth.
pub fn pin_in_hole(r: &mut Random) -> Setup {
    let (n, radius, height) = (r.pick(&[6, 8, 12, 24]), r.real(0.2, 2.0), r.real(0.5, 2.0));
    let clearance = r.pick(&[0.0, 0.0, 0.0, 1e-9]);
    let hole = tube(&circle(n, 2.0 * radius), Some(&circle(n, radius)), 0.0, height);
    let pin = tube(&circle(n, radius - clearance), None, 0.0, height);
    let mut fits = vec![Motion::NONE];
    for _ in 0..3 {
        let steps = r.below(2 * n) as f64 / (2 * n) as f64;
        let push = r.pick(&[0.0, 0.0, 0.5, 1.0, -1.0]) * height;
        fits.push(Motion::about_z(steps).after(&Motion::shift([0.0, 0.0, push])));
    }
    brought(r, &hole, &pin, &fits)
}

/// Two gears in mesh: tips on roots, flanks at flanks, faces flush, turned step by step.
pub fn gears(r: &mut Random) -> Setup {
    let teeth = r.pick(&[6, 8, 12]);
    let (root, tip, height) = (1.0, r.pick(&[1.25, 1.3, 1.5]), r.real(0.2, 0.6));
    let outline = gear(teeth, root, tip);
    let bore = circle(4 * teeth, 0.4);
    let mockup = tube(&outline, Some(&bore), 0.0, height);
    let tool = tube(&outline, Some(&bore), 0.0, height);
    let apart = Motion::shift([root + tip, 0.0, 0.0]);
    // One outline has a tooth on the x axis, the other must have a gap there: turned by half and a half step.
    let fits: Vec<Motion> = (0..3)
        .map(|_| {
            let step = r.below(8 * teeth) as f64 / (8 * teeth) as f64;
            let push = Motion::shift([0.0, 0.0, r.pick(&[0.0, 0.0, height, 0.5 * height])]);
            apart.after(&push).after(&Motion::about_z(step))
        })
        .collect();
    brought(r, &mockup, &tool, &fits)
}

/// A pile of equal boxes, face on face, and one more set against and among them.
pub fn boxes(r: &mut Random) -> Setup {
    let size = r.pick(&[1.0, 0.1, 0.3, 2.54]);
    let mut pile = Vec::new();
    for i in 0..2 {
        for j in 0..2 {
            for k in 0..2 {
                let low = [i, j, k].map(|x| f64::from(x) * size);
                let high = [i + 1, j + 1, k + 1].map(|x| f64::from(x) * size);
                pile.extend(cuboid(low, high));
            }
        }
    }
    let tool = cuboid([0.0; 3], [size; 3]);
    let fits: Vec<Motion> = (0..5)
        .map(|_| {
            let step = |r: &mut Random| f64::from(r.whole(-2, 4)) * 0.5 * size;
            Motion::shift([step(r), step(r), step(r)]).after(&Motion::about_z(0.25 * f64::from(r.whole(0, 3))))
        })
        .collect();
    brought(r, &pile, &tool, &fits)
}

/// Two sheets of one plane, meshed differently: corners in the middle of edges everywhere; also upright on each other.
pub fn sheets(r: &mut Random) -> Setup {
    let mut cells = || (r.pick(&[2, 3, 4]), r.pick(&[1, 2, 3, 5]));
    let ((n, m), (k, l)) = (cells(), cells());
    let (mockup, tool) = (sheet(n, m, 1.0, 1.0), sheet(k, l, 1.0, 0.75));
    let upright = Motion { rotation: [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]], ..Motion::NONE };
    let fits: Vec<Motion> = (0..5)
        .map(|i| {
            let shift = [r.pick(&[0.0, 0.25, 0.3, 1.0]), r.pick(&[0.0, 0.5, 0.1]), r.pick(&[0.0, 0.0, -0.375, 1e-16])];
            let turned = match i % 3 {
                0 => upright,
                1 => Motion::about_z(r.pick(&[0.125, 0.25, 0.1])),
                _ => Motion::NONE,
            };
            Motion::shift(shift).after(&turned)
        })
        .collect();
    brought(r, &mockup, &tool, &fits)
}

/// Triangles on whole numbers, many without area at some scales, at poses that are whole too, or that round away most bits.
pub fn lattice_soup(r: &mut Random) -> Setup {
    let soup = |r: &mut Random, count: usize, high: i32| -> Vec<Triangle> {
        (0..count)
            .map(|_| {
                let c = r.lattice_point(0, high);
                std::array::from_fn(|_| std::array::from_fn(|a| c[a] + f64::from(r.whole(-1, 1))))
            })
            .collect()
    };
    let (mockup, tool) = (soup(r, 60, 4), soup(r, 20, 2));
    // Far below the last bit of the place the pose brings it to: a point, a segment, a triangle flattened into a plane.
    let scales = r.pick(&[[1.0; 3], [1.0; 3], [0.1; 3], [1e-7; 3], [1e-17; 3], [1.0, 1.0, 1e-17], [1.0, 1e-17, 1e-17]]);
    let tool: Vec<Triangle> = tool.iter().map(|t| t.map(|c| std::array::from_fn(|a| c[a] * scales[a]))).collect();
    let poses = (0..4).map(|_| {
        let quarter = Motion::about_z(0.25 * f64::from(r.whole(0, 3)));
        Motion::shift(r.lattice_point(0, 4)).after(&quarter).pose()
    });
    Setup { poses: poses.collect(), mockup, tool }
}
