//! The metric of poses: a length of motions at the tool's centre.
//!
//! By the tool's own inertia a motion is as long as the root mean square travel of its surface (metres). The pose
//! nearest to the device's is then the one that Gauss's principle of least constraint gives a body released there. A
//! hand, however, feels a coupling: if its springs weigh rotations differently, their wrench at that pose has a part
//! along the surface that no contact balances, and closed motions gain and lose energy. By the coupling's own springs
//! the contacts alone balance the wrench, which is the gradient of half the squared distance: of a potential.

use crate::constants::LEAST_GYRATION_SHARE;
use crate::geometry::bounds::Point;
use crate::geometry::least_distance::{HalfSpace, Six};
use crate::geometry::pose::Pose;
use crate::geometry::twist::{times, transposed, Matrix, Twist};
use crate::geometry::vectors::{add, cross, dot, length, scaled, sub};
use crate::tool::moving_tool::Tool;

/// The inertia of a tool's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Metric {
    /// Centre of area, tool frame, metres.
    pub centre: Point,
    /// The farthest that any point of the tool is from the centre, metres.
    pub radius: f64,
    /// Lower triangle of the Cholesky factor of the moment of inertia over the mass, tool frame, metres; and its inverse.
    factor: Matrix,
    inverse: Matrix,
}

impl Metric {
    /// The metric of a tool, as a shell of even thickness. Open surfaces have one as well as closed ones. A tool
    /// without inertia about an axis, such as a straight wire, gets a little, so that it does not spin freely.
    pub fn new(tool: &Tool) -> Metric {
        let mesh = tool.mesh();
        let middle = scaled(&add(&mesh.bounds().lower, &mesh.bounds().upper), 0.5);
        // Three points of a triangle that have its mean and its moments of second order: the middles of its sides.
        let sum = |of: &mut dyn FnMut(f64, &Point)| {
            for t in mesh.queried() {
                let [a, b, c] = mesh.triangle(t).map(|p| sub(&p, &middle));
                let area = 0.5 * length(&cross(&sub(&b, &a), &sub(&c, &a)));
                [(a, b), (b, c), (c, a)].iter().for_each(|(p, q)| of(area / 3.0, &scaled(&add(p, q), 0.5)));
            }
        };
        let (mut area, mut first) = (0.0, [0.0; 3]);
        sum(&mut |w, p| {
            area += w;
            first = add(&first, &scaled(p, w));
        });
        let from_middle = if area > 0.0 { scaled(&first, 1.0 / area) } else { [0.0; 3] };
        let centre = add(&middle, &from_middle);
        let mut second = [[0.0; 3]; 3];
        sum(&mut |w, p| {
            let d = sub(p, &from_middle);
            (0..3).for_each(|i| (0..3).for_each(|j| second[i][j] += w / area * d[i] * d[j]));
        });
        let radius = mesh.vertices().iter().map(|p| length(&sub(p, &centre))).fold(0.0, f64::max);
        let trace = second[0][0] + second[1][1] + second[2][2];
        let least = (LEAST_GYRATION_SHARE * radius).powi(2);
        let moment: Matrix = std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j { trace - second[i][i] + least } else { -second[i][j] })
        });
        let factor = cholesky(&moment);
        Metric { centre, radius, factor, inverse: inverse_lower(&factor) }
    }

    /// The same centre, and a turn about any axis as long as its angle times `lever` (metres): for springs the root of the rotational
    /// stiffness over the stiffness. `None` where it is not positive and finite, as where a coupling turns nothing.
    pub fn with_lever(&self, lever: f64) -> Option<Metric> {
        let is_of_use = lever.is_finite() && lever > 0.0;
        let diagonal = |x: f64| std::array::from_fn(|i| std::array::from_fn(|j| if i == j { x } else { 0.0 }));
        is_of_use.then(|| Metric { factor: diagonal(lever), inverse: diagonal(1.0 / lever), ..*self })
    }

    /// The same metric for a tool that has grown, as by a part that it holds: only how far it reaches is another.
    pub fn with_radius_of(&self, tool: &Tool) -> Metric {
        let radius = tool.mesh().vertices().iter().map(|p| length(&sub(p, &self.centre))).fold(0.0, f64::max);
        Metric { radius, ..*self }
    }

    /// A displacement at the centre in coordinates in which its length is the metric's; the tool is at a pose.
    pub fn coordinates(&self, pose: &Pose, by: &Twist) -> Six {
        let in_tool = times(&transposed(pose.rotation()), &by.angular);
        let turned = times(&transposed(&self.factor), &in_tool);
        let [x, y, z] = by.linear;
        [x, y, z, turned[0], turned[1], turned[2]]
    }

    /// The displacement of coordinates.
    pub fn displacement(&self, pose: &Pose, [x, y, z, u, v, w]: &Six) -> Twist {
        let in_tool = times(&transposed(&self.inverse), &[*u, *v, *w]);
        Twist { linear: [*x, *y, *z], angular: times(pose.rotation(), &in_tool) }
    }

    /// The half-space, in coordinates, of displacements that move a point of the tool along `normal` (unit, world) by `least` (metres)
    /// or more; `arm` leads from the centre to the point, world.
    pub fn half_space(&self, pose: &Pose, normal: &Point, arm: &Point, least: f64) -> HalfSpace {
        let lever = times(&transposed(pose.rotation()), &cross(arm, normal));
        let turned = times(&self.inverse, &lever);
        let by = 1.0 / (1.0 + dot(&turned, &turned)).sqrt();
        let ([x, y, z], [u, v, w]) = (*normal, turned);
        HalfSpace { normal: [by * x, by * y, by * z, by * u, by * v, by * w], offset: by * least }
    }
}

/// The lower Cholesky factor of a positive definite matrix.
fn cholesky(m: &Matrix) -> Matrix {
    let mut l = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..=i {
            let rest = m[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            l[i][j] = if i == j { rest.max(f64::MIN_POSITIVE).sqrt() } else { rest / l[j][j] };
        }
    }
    l
}

/// The inverse of a lower triangular matrix.
fn inverse_lower(l: &Matrix) -> Matrix {
    let mut inverse = [[0.0; 3]; 3];
    for j in 0..3 {
        inverse[j][j] = 1.0 / l[j][j];
        for i in j + 1..3 {
            let rest: f64 = (j..i).map(|k| l[i][k] * inverse[k][j]).sum();
            inverse[i][j] = -rest / l[i][i];
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use feeler_shapes::box_mesh;

    use super::*;
    use crate::geometry::twist::{displaced, pose_of, rotation_of};

    fn tool(size: [f64; 3], at: Point, cells: usize) -> Tool {
        let (vertices, faces) = box_mesh(at, size, cells);
        Tool::new(vertices, faces).unwrap()
    }

    #[test]
    fn the_length_of_a_motion_is_the_mean_way_of_the_surface() {
        let tool = tool([0.3, 0.2, 0.1], [4.0, -2.0, 1.0], 6);
        let metric = Metric::new(&tool);
        assert!(length(&sub(&metric.centre, &[4.0, -2.0, 1.0])) < 1e-9);
        let pose = pose_of(&rotation_of(&[0.4, -0.9, 0.3]), &[0.1, 0.2, 0.3]).unwrap();
        for i in 0..20 {
            let wave = |k: f64| (k * f64::from(i) + k).sin() * 1e-5;
            let by =
                Twist { linear: [wave(1.1), wave(2.3), wave(0.7)], angular: [wave(5.0), 20.0 * wave(1.9), wave(3.1)] };
            let there = displaced(&pose, &by, &metric.centre).unwrap();
            let (mut square, mut area) = (0.0, 0.0);
            for t in tool.mesh().queried() {
                let triangle = tool.mesh().triangle(t);
                let [a, b, c] = triangle;
                let weight = length(&cross(&sub(&b, &a), &sub(&c, &a)));
                let middles = [[a, b], [b, c], [c, a]].map(|[p, q]| scaled(&add(&p, &q), 0.5));
                let ways = middles.map(|p| sub(&there.apply(&p), &pose.apply(&p)));
                square += weight / 3.0 * ways.iter().map(|w| dot(w, w)).sum::<f64>();
                area += weight;
            }
            let coordinates = metric.coordinates(&pose, &by);
            let long = coordinates.iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!((long / (square / area).sqrt() - 1.0).abs() < 1e-3, "{i} {long} {}", (square / area).sqrt());
            let back = metric.displacement(&pose, &coordinates);
            assert!(length(&sub(&back.linear, &by.linear)) + length(&sub(&back.angular, &by.angular)) < 1e-18);
        }
    }

    #[test]
    fn a_half_space_holds_the_motions_that_lift_its_point() {
        let tool = tool([0.3, 0.2, 0.1], [0.0; 3], 2);
        let metric = Metric::new(&tool);
        let pose = pose_of(&rotation_of(&[0.4, -0.9, 0.3]), &[0.1, 0.2, 0.3]).unwrap();
        let (normal, at) = ([0.6, 0.0, 0.8], [0.15, -0.1, 0.05]);
        let arm = sub(&pose.apply(&at), &pose.apply(&metric.centre));
        for i in 0..40 {
            let wave = |k: f64| (k * f64::from(i) + k).sin() * 1e-6;
            let by = Twist { linear: [wave(1.1), wave(2.3), wave(0.7)], angular: [wave(5.0), wave(1.9), wave(3.1)] };
            let row = metric.half_space(&pose, &normal, &arm, 5e-7);
            let x = metric.coordinates(&pose, &by);
            let inside: f64 = row.normal.iter().zip(&x).map(|(n, x)| n * x).sum::<f64>() - row.offset;
            let there = displaced(&pose, &by, &metric.centre).unwrap();
            let lifted = dot(&normal, &sub(&there.apply(&at), &pose.apply(&at))) - 5e-7;
            assert!((inside > 0.0) == (lifted > 0.0) || lifted.abs() < 1e-11, "{inside} {lifted}");
            let size: f64 = row.normal.iter().map(|n| n * n).sum();
            assert!((size - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_wire_has_an_inertia_about_its_axis() {
        let wire = Tool::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1e-9, 0.0]], vec![[0, 1, 2]]).unwrap();
        let metric = Metric::new(&wire);
        let turn = Twist { linear: [0.0; 3], angular: [1.0, 0.0, 0.0] };
        let long = metric.coordinates(&Pose::IDENTITY, &turn).iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!(long > 0.004 && metric.inverse.as_flattened().iter().all(|x| x.is_finite()), "{metric:?}");
    }
}
