//! Contacts of [`concave`](crate::concave) solids of known depth: no plane may be missing, too deep, or turned, and no
//! way out shorter than the shortest.

use std::sync::Arc;

use feeler_contacts::{ContactPlane, ContactSolver, Contacts, Penetration, PenetrationKind};
use feeler_core::{Level, Mockup, Point, Pose, Scene, SceneOptions, Tool};

use crate::blocks::{square, Solid, Spot, Surface};
use crate::check::STORES;
use crate::concave::{Contact, Family, Known, FAMILIES, SIZE};
use crate::random::Random;
use crate::shapes::Motion;
use crate::tally::{self, Figures};

/// Directions that differ in depth by less than these shares, of the depth and of the largest coordinate, are as deep as each other
/// (`SHALLOWER` and the noise of the search for the least depth): the first tried is taken.
const SHARE_OF_DEPTH: f64 = 2e-6;
const SHARE_OF_COORDINATES: f64 = 2e-12;

/// Counts of the contact judge. `worst` is the largest error of a depth.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ContactsFound {
    /// Planes that were to be found, deep ones, and near ones where nothing is deep.
    pub deep: u64,
    /// See `deep`.
    pub near: u64,
    /// Ways out by their kind: exact, bound, estimate.
    pub ways: [u64; 3],
    /// Bounds within a hundredth of the shortest way.
    pub close_bounds: u64,
    /// The longest of the others, in shortest ways.
    pub longest: f64,
}

impl Figures for ContactsFound {
    fn add(&mut self, other: ContactsFound) {
        self.deep += other.deep;
        self.near += other.near;
        (0..3).for_each(|i| self.ways[i] += other.ways[i]);
        self.close_bounds += other.close_bounds;
        self.longest = self.longest.max(other.longest);
    }
}

type Tally = crate::tally::Tally<ContactsFound>;

/// Runs `cases` contacts of each of some families (all where none is named), from a number on, of solids cut into up to about
/// `most_triangles` triangles; case `i` depends on the seed, `i` and that number alone.
/// `progress` is called as contacts finish.
///
/// Errors: a family that there is not.
pub fn run(
    cases: u64,
    seed: u64,
    from: u64,
    only: &[String],
    most_triangles: usize,
    progress: &dyn Fn(&str, f64),
) -> Result<Vec<(Family, Tally)>, String> {
    tally::run(&FAMILIES, [from, cases], only, progress, |family, i| judge(family, seed, i, most_triangles))
}

/// A contact brought into the world.
struct Placed {
    solver: ContactSolver,
    tool: Tool,
    pose: Pose,
    world: Motion,
    /// Metres.
    unit: f64,
    /// How far a depth of so much may be off, and a unit normal.
    tolerance: Tolerance,
    triangles: usize,
    what: String,
}

/// Bounds of the rounding. A corner is off by a few roundings of its coordinates, and a normal by that over the shortest edge; over the
/// length of the solids a normal turns into a depth.
struct Tolerance {
    normal: f64,
    depth: f64,
}

impl Tolerance {
    fn of_depth(&self, depth: f64) -> f64 {
        self.depth + SHARE_OF_DEPTH * depth.abs()
    }
}

impl Placed {
    fn new(contact: &Contact, most_triangles: usize, r: &mut Random) -> Result<Placed, String> {
        let size = r.pick(&[1e-2, 0.1, 1.0, 30.0]);
        let unit = size / SIZE as f64;
        let far: f64 = r.pick(&[0.0, 0.0, 1.0, 100.0, 1e4]);
        // A small part that far away is mostly rounding.
        let far = if size < 0.1 { far.min(100.0) } else { far };
        let is_turned = !r.one_in(4);
        let motion = |r: &mut Random, far: f64| match is_turned {
            true => Motion::random(r, far),
            false => Motion::shift(r.point(-far, far)),
        };
        let (world, modelled) = (motion(r, far), if r.one_in(2) { motion(r, size) } else { Motion::NONE });
        let wanted = |r: &mut Random| 12 << r.below((most_triangles / 12).ilog2() as usize + 1);
        let mut shortest = i64::MAX;
        let mut surface = |solid: &Solid, r: &mut Random| {
            let surface = solid.surface(wanted(r), r);
            shortest = shortest.min(shortest_edge(&surface));
            surface
        };
        let (mut vertices, mut faces, mut part_of_face) = (Vec::new(), Vec::new(), Vec::new());
        for (part, solid) in (0..).zip(&contact.parts) {
            let (spots, triangles) = surface(solid, r);
            let from = vertices.len() as u32;
            vertices.extend(spots.iter().map(|p| world.pose().apply(&p.map(|x| x as f64 * unit))));
            part_of_face.extend(vec![part; triangles.len()]);
            faces.extend(triangles.iter().map(|f| f.map(|v| v + from)));
        }
        let (spots, of_tool) = surface(&contact.tool, r);
        let triangles = faces.len() + of_tool.len();
        let of_spots = spots.iter().map(|p| modelled.pose().apply(&p.map(|x| x as f64 * unit)));
        let tool = Tool::new(of_spots.collect(), of_tool).map_err(|e| e.to_string())?;
        let pose = world.after(&modelled.inverse()).pose();
        let mockup = Mockup::new(vertices, faces, part_of_face, contact.parts.len()).map_err(|e| e.to_string())?;
        let (storage, levels) = (STORES[r.below(STORES.len())], Level::available());
        let options = SceneOptions::default().with_storage(storage).with_tool(&tool);
        let mut scene = Scene::build(Arc::new(mockup), &options).map_err(|e| e.to_string())?;
        scene.set_lanes(levels[r.below(levels.len())]);
        let coordinates = 2.0 * far + 3.0 * size;
        let normal = 16.0 * f64::EPSILON * coordinates / (shortest as f64 * unit);
        let depth = 4.0 * size * normal + SHARE_OF_COORDINATES * coordinates;
        let what = format!("{triangles} triangles, size {size} m, {far} m away, {storage:?}");
        let (solver, tolerance) = (ContactSolver::new(Arc::new(scene)), Tolerance { normal: normal + 1e-7, depth });
        Ok(Placed { solver, tool, pose, world, unit, tolerance, triangles, what })
    }

    fn normal(&self, known: &Known) -> Point {
        self.world.rotation.map(|row| known.sense as f64 * row[known.axis])
    }

    /// A direction in the frame of the blocks.
    fn back(&self, d: &Point) -> Point {
        [0, 1, 2].map(|k| (0..3).map(|a| self.world.rotation[a][k] * d[a]).sum())
    }

    fn is_along(&self, plane: &ContactPlane, known: &Known) -> bool {
        let n = self.normal(known);
        plane.part as usize == known.part && (0..3).all(|a| (plane.normal[a] - n[a]).abs() <= self.tolerance.normal)
    }
}

fn shortest_edge((spots, faces): &Surface) -> i64 {
    let edge = |f: &[u32; 3], k: usize| -> Spot {
        let [p, q] = [f[k], f[(k + 1) % 3]].map(|v| spots[v as usize]);
        [0, 1, 2].map(|a| p[a] - q[a])
    };
    let least = faces.iter().flat_map(|f| (0..3).map(move |k| square(&edge(f, k)))).min().unwrap_or(1);
    (least as f64).sqrt() as i64
}

fn judge(family: &Family, seed: u64, i: u64, most_triangles: usize) -> Tally {
    let mut r = Random::new(seed.wrapping_mul(1 << 32) ^ i);
    let contact = family.make(&mut r);
    let mut tally = Tally { cases: 1, ..Tally::default() };
    let faults = match Placed::new(&contact, most_triangles, &mut r) {
        Ok(placed) => {
            tally.triangles = placed.triangles as u64;
            let margin = r.pick(&[0.0, 0.04]) * SIZE as f64 * placed.unit;
            let found = placed.solver.penetration(&placed.tool, &placed.pose, margin, None);
            match (placed.solver.contacts(&placed.tool, &placed.pose, margin, None), found) {
                (Ok(contacts), Ok(way)) => {
                    let mut faults = faults_of_planes(&contact, &placed, &contacts, margin, &mut tally);
                    faults.extend(faults_of_way(&contact, &placed, &way, &mut tally));
                    faults.iter().map(|fault| format!("{}: {fault}", placed.what)).collect()
                }
                (contacts, way) => vec![format!("{contacts:?} {way:?}")],
            }
        }
        Err(why) => vec![why],
    };
    tally.fault_count = faults.len() as u64;
    tally.faults = faults.into_iter().map(|fault| format!("{} {i} (seed {seed}), {fault}", family.name)).collect();
    tally
}

fn faults_of_planes(
    contact: &Contact,
    placed: &Placed,
    contacts: &Contacts,
    margin: f64,
    tally: &mut Tally,
) -> Vec<String> {
    let mut faults = Vec::new();
    let Placed { unit, tolerance, .. } = placed;
    let metres = |units: i64| units as f64 * unit;
    let is_deep = contact.planes.iter().any(|known| known.depth > 0);
    if contacts.is_meeting != is_deep {
        faults.push(format!("is_meeting is {}", contacts.is_meeting));
    }
    // Nothing deep beyond the known faces.
    let deep: Vec<&ContactPlane> = contacts.planes.iter().filter(|p| p.gap < -tolerance.depth).collect();
    for plane in &deep {
        let off = |known: &&Known| (plane.gap + metres(known.depth)).abs() / tolerance.of_depth(plane.gap);
        let known = contact.planes.iter().filter(|known| placed.is_along(plane, known));
        match known.map(|known| off(&known)).min_by(f64::total_cmp) {
            Some(off) if off <= 1.0 => tally.worst = tally.worst.max(off),
            _ => faults.push(format!(
                "{:.3} deep along {:.6?}, part {}",
                -plane.gap / unit,
                placed.back(&plane.normal),
                plane.part
            )),
        }
    }
    // Of each part and direction the deepest, or where none is deep the nearest, unless so many are deep that little near is sought.
    for (k, known) in contact.planes.iter().enumerate() {
        let same = |other: &Known| (other.part, other.axis, other.sense) == (known.part, known.axis, known.sense);
        let of_class = contact.planes.iter().enumerate().filter(|(_, other)| same(other));
        let deepest = of_class.max_by_key(|(_, other)| other.depth).map(|(j, _)| j);
        let is_near = metres(-known.depth) < 0.98 * margin && !is_deep;
        if deepest != Some(k) || known.depth <= 0 && !is_near {
            continue;
        }
        *(if known.depth > 0 { &mut tally.figures.deep } else { &mut tally.figures.near }) += 1;
        let allowed = tolerance.of_depth(metres(known.depth));
        let along = contacts.planes.iter().filter(|plane| placed.is_along(plane, known));
        if !along.clone().any(|plane| (plane.gap + metres(known.depth)).abs() <= allowed) {
            let found: Vec<f64> = along.map(|plane| -plane.gap / unit).collect();
            faults.push(format!("no plane of {known:?}, {found:?} along it"));
        }
    }
    if !is_deep {
        let distance = (contact.obstacles(0).square_distance() as f64).sqrt() * unit;
        let nearest = contacts.planes.first().map(|plane| plane.gap);
        let is_right = match nearest {
            Some(gap) => (gap - distance).abs() <= tolerance.of_depth(distance),
            None => distance > margin - tolerance.of_depth(distance),
        };
        if !is_right {
            faults.push(format!("nearest at {nearest:?}, in truth {distance}"));
        }
    }
    faults
}

fn faults_of_way(contact: &Contact, placed: &Placed, way: &Penetration, tally: &mut Tally) -> Vec<String> {
    let mut faults = Vec::new();
    let Placed { solver, tool, pose, unit, tolerance, .. } = placed;
    tally.figures.ways[way.kind as usize] += 1;
    let truth = contact.obstacles(0).shortest_way();
    let least = (square(&truth) as f64).sqrt() * unit;
    let mut fault = |what: String| faults.push(format!("{what}; {way:?}, in truth {least}, {truth:?}"));
    let moved = pose.translated(&way.translation);
    let is_free = moved.is_ok_and(|moved| !solver.scene().is_colliding(tool, &moved));
    if is_free == (way.kind == PenetrationKind::Estimate) {
        fault(format!("free: {is_free}"));
    }
    if way.kind == PenetrationKind::Estimate {
        return faults;
    }
    let allowed = tolerance.of_depth(least);
    if way.depth < least - allowed {
        fault("too short".to_string());
    }
    if way.kind == PenetrationKind::Exact && way.depth > least + allowed {
        fault("not exact".to_string());
    }
    // Where the planes of what is deep show the shortest way, it is to be found.
    let shown = [0, 1, 2].map(|axis| {
        let of_axis = |sense: i64| {
            let of = contact.planes.iter().filter(|known| (known.axis, known.sense) == (axis, sense));
            of.map(|known| known.depth).max().unwrap_or(0).max(0)
        };
        of_axis(1) - of_axis(-1)
    });
    if way.depth <= 1.01 * least + allowed {
        tally.figures.close_bounds += u64::from(way.kind == PenetrationKind::Bound);
    } else {
        tally.figures.longest = tally.figures.longest.max(way.depth / least);
        if shown == truth {
            fault("not the way that the planes show".to_string());
        }
    }
    faults
}
