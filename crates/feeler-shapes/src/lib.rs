//! What tests are made of, as plain arrays: surfaces of known form, each cut as finely as a test wants, [`soups`] of triangles,
//! the [`cases`] behind the [golden hashes](golden), numbers from a seed.

pub mod cases;
pub mod golden;
pub mod random;
pub mod soups;

use std::f64::consts::TAU;

/// Metres.
pub type Point = [f64; 3];

/// A rigid motion, `(4, 4)` by rows.
pub type Matrix = [[f64; 4]; 4];

/// Vertices and faces.
pub type Arrays = (Vec<Point>, Vec<[u32; 3]>);

/// A grid of `n` by `m` cells spanned by a function of two parameters in [0, 1], two triangles a cell.
pub fn sheet(n: usize, m: usize, at: impl Fn(f64, f64) -> Point) -> Arrays {
    let mut vertices = Vec::new();
    for i in 0..=n {
        vertices.extend((0..=m).map(|j| at(i as f64 / n as f64, j as f64 / m as f64)));
    }
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let a = (i * (m + 1) + j) as u32;
            let (b, c, d) = (a + m as u32 + 1, a + m as u32 + 2, a + 1);
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    (vertices, faces)
}

/// Several meshes as one, vertices not shared between them.
pub fn joined(meshes: impl IntoIterator<Item = Arrays>) -> Arrays {
    let mut all: Arrays = Default::default();
    for (vertices, faces) in meshes {
        let from = all.0.len() as u32;
        all.0.extend(vertices);
        all.1.extend(faces.iter().map(|f| f.map(|v| v + from)));
    }
    all
}

/// A closed box around `centre` with the given side lengths, every side cut into `cells` by `cells`.
pub fn box_mesh(centre: Point, size: Point, cells: usize) -> Arrays {
    joined(box_sides(centre, size, |_| [cells; 2]))
}

/// The six sides of such a box, each cut into as many cells as is said of it. They meet edge to edge only if that is the same.
pub fn box_sides(centre: Point, size: Point, cells: impl Fn(usize) -> [usize; 2]) -> [Arrays; 6] {
    let half = size.map(|x| 0.5 * x);
    std::array::from_fn(|side| {
        let (axis, sense, [n, m]) = (side / 2, if side % 2 == 0 { 1.0 } else { -1.0 }, cells(side));
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        sheet(n, m, move |s, t| {
            let (s, t) = if sense > 0.0 { (s, t) } else { (t, s) };
            let mut p = [0.0; 3];
            p[axis] = sense * half[axis];
            p[u] = (2.0 * s - 1.0) * half[u];
            p[v] = (2.0 * t - 1.0) * half[v];
            std::array::from_fn(|a| centre[a] + p[a])
        })
    })
}

/// A ball of radius `r` around the origin, its poles on the z axis; `n` bands. Closed but for the degenerate triangles at
/// the poles, which are left out.
pub fn ball(r: f64, n: usize) -> Arrays {
    let (vertices, faces) = sheet(2 * n, n, |s, t| {
        let (phi, theta) = (TAU * if s == 1.0 { 0.0 } else { s }, 0.5 * TAU * t);
        match t {
            0.0 => [0.0, 0.0, -r],
            1.0 => [0.0, 0.0, r],
            _ => [r * theta.sin() * phi.cos(), r * theta.sin() * phi.sin(), -r * theta.cos()],
        }
    });
    let keep = |f: &[u32; 3]| {
        let p = f.map(|v| vertices[v as usize]);
        p[0] != p[1] && p[1] != p[2] && p[2] != p[0]
    };
    let faces = faces.into_iter().filter(keep).collect();
    (vertices, faces)
}

/// A closed profile of (radius, height), counterclockwise, revolved about z in `n` steps. The first is turned by `turn` of a step.
pub fn lathe(profile: &[[f64; 2]], n: usize, turn: f64) -> Arrays {
    let m = profile.len();
    let mut vertices = Vec::new();
    for i in 0..n {
        let (s, c) = (std::f64::consts::TAU * (i as f64 + turn) / n as f64).sin_cos();
        vertices.extend(profile.iter().map(|[r, z]| [r * c, r * s, *z]));
    }
    let at = |i: usize, j: usize| ((i % n) * m + j % m) as u32;
    let mut faces = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
        faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
    (vertices, faces)
}

/// A closed cylinder along x: radius `r`, length `l`, `n` sides, `m` rings.
pub fn cylinder(r: f64, l: f64, n: usize, m: usize) -> Arrays {
    let around = |s: f64| {
        let phi = TAU * if s == 1.0 { 0.0 } else { s };
        [phi.sin() * r, -phi.cos() * r]
    };
    let wall = sheet(n, m, |s, t| {
        let [y, z] = around(s);
        [(t - 0.5) * l, y, z]
    });
    let cap = |x: f64| {
        let mut vertices: Vec<Point> = (0..n).map(|i| around(i as f64 / n as f64)).map(|[y, z]| [x, y, z]).collect();
        vertices.push([x, 0.0, 0.0]);
        let n = n as u32;
        let face = |i: u32| if x > 0.0 { [n, i, (i + 1) % n] } else { [n, (i + 1) % n, i] };
        (vertices, (0..n).map(face).collect())
    };
    joined([wall, cap(0.5 * l), cap(-0.5 * l)])
}

/// A closed body between a polyline `(x, z)` and the height `far`, along y from -`half` to `half`: every piece of the line cut
/// into `n`, the length into `m`. With `far` below the line its top is the line, else its bottom.
pub fn ridge(line: &[[f64; 2]], far: f64, half: f64, n: usize, m: usize) -> Arrays {
    let pieces = line.len() - 1;
    let on_line = move |s: f64| {
        let u = s * pieces as f64;
        let i = (u as usize).min(pieces - 1);
        let (p, q, f) = (line[i], line[i + 1], u - i as f64);
        match f {
            0.0 => p,
            1.0 => q,
            _ => [p[0] + f * (q[0] - p[0]), p[1] + f * (q[1] - p[1])],
        }
    };
    let y = move |t: f64| (2.0 * t - 1.0) * half;
    let height = move |z: f64, t: f64| match t {
        0.0 => far,
        1.0 => z,
        _ => far + t * (z - far),
    };
    let count = pieces * n;
    let mut all = joined([
        sheet(count, m, |s, t| [on_line(s)[0], y(t), on_line(s)[1]]),
        sheet(m, count, |t, s| [on_line(s)[0], y(t), far]),
        sheet(count, n, |s, t| [on_line(s)[0], -half, height(on_line(s)[1], t)]),
        sheet(n, count, |t, s| [on_line(s)[0], half, height(on_line(s)[1], t)]),
        sheet(m, n, |s, t| [line[pieces][0], y(s), height(line[pieces][1], t)]),
        sheet(n, m, |t, s| [line[0][0], y(s), height(line[0][1], t)]),
    ]);
    if line[0][1] < far {
        all.1.iter_mut().for_each(|f| f.swap(1, 2));
    }
    all
}

/// A rigid motion: a turn by an angle (radians) about the axis (1, 2, 3), then to a place.
pub fn turned(angle: f64, place: Point) -> Matrix {
    let k = [1.0, 2.0, 3.0].map(|x| x * (1.0 / 14f64.sqrt()));
    let (s, c) = angle.sin_cos();
    let mut m = [[0.0; 4]; 4];
    m[3][3] = 1.0;
    for i in 0..3 {
        for j in 0..3 {
            let sign = match (3 + j - i) % 3 {
                0 => 0.0,
                1 => -1.0,
                _ => 1.0,
            };
            let across = if i == j { 0.0 } else { sign * k[3 - i - j] };
            m[i][j] = if i == j { c } else { 0.0 } + (1.0 - c) * k[i] * k[j] + s * across;
        }
        m[i][3] = place[i];
    }
    m
}
