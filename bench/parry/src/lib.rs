//! parry3d behind a C interface, for parry_engine.py.
//!
//! parry has no query for all pairs of triangles of two meshes. What its own mesh intersection does to find them is
//! done here: both trees are walked at once (`Bvh::leaf_pairs`), the tool's boxes turned into the mock-up's frame. Its
//! triangle-triangle test is not public, so the public one for convex shapes takes its place (GJK).

use std::slice;

use parry3d::bounding_volume::BoundingVolume;
use parry3d::math::{Mat3, Pose, Rot3, Vec3};
use parry3d::partitioning::BvhNode;
use parry3d::query::{
    cast_shapes, cast_shapes_nonlinear, details, gjk::VoronoiSimplex, intersection_test, NonlinearRigidMotion,
    ShapeCastOptions,
};
use parry3d::shape::TriMesh;

/// A mock-up, a tool, and what the last query found.
pub struct Engine {
    mockup: TriMesh,
    tool: Option<TriMesh>,
    pairs: Vec<[u32; 2]>, // tool triangle, mock-up triangle
}

/// # Safety
/// `vertices` holds 3 * `corners` numbers, `faces` 3 * `count`.
unsafe fn mesh(vertices: *const f64, corners: usize, faces: *const u32, count: usize) -> Option<TriMesh> {
    // SAFETY: the lengths are the caller's promise.
    let (xyz, abc) = unsafe { (slice::from_raw_parts(vertices, 3 * corners), slice::from_raw_parts(faces, 3 * count)) };
    let points = xyz.chunks_exact(3).map(|p| Vec3::new(p[0] as f32, p[1] as f32, p[2] as f32)).collect();
    TriMesh::new(points, abc.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect()).ok()
}

/// # Safety
/// `rows` holds the twelve numbers of a rigid 3 x 4 matrix, row by row.
unsafe fn pose(rows: *const f64) -> Pose {
    // SAFETY: the length is the caller's promise.
    let m = unsafe { slice::from_raw_parts(rows, 12) };
    let column = |j: usize| Vec3::new(m[j] as f32, m[4 + j] as f32, m[8 + j] as f32);
    let turn = Rot3::from_mat3(&Mat3::from_cols(column(0), column(1), column(2)));
    Pose::from_parts(column(3), turn)
}

/// A new engine, or null where parry does not take the mesh.
///
/// # Safety
/// See [`mesh`].
#[no_mangle]
pub unsafe extern "C" fn parry_new(
    vertices: *const f64,
    corners: usize,
    faces: *const u32,
    count: usize,
) -> *mut Engine {
    // SAFETY: passed on.
    match unsafe { mesh(vertices, corners, faces, count) } {
        Some(mockup) => Box::into_raw(Box::new(Engine { mockup, tool: None, pairs: Vec::new() })),
        None => std::ptr::null_mut(),
    }
}

/// # Safety
/// `engine` comes from [`parry_new`] and is not used again.
#[no_mangle]
pub unsafe extern "C" fn parry_free(engine: *mut Engine) {
    // SAFETY: made by Box::into_raw.
    drop(unsafe { Box::from_raw(engine) });
}

/// Take a tool; 0 where parry does not take the mesh.
///
/// # Safety
/// See [`mesh`]; `engine` comes from [`parry_new`].
#[no_mangle]
pub unsafe extern "C" fn parry_tool(
    engine: &mut Engine,
    vertices: *const f64,
    corners: usize,
    faces: *const u32,
    count: usize,
) -> i32 {
    // SAFETY: passed on.
    engine.tool = unsafe { mesh(vertices, corners, faces, count) };
    i32::from(engine.tool.is_some())
}

/// All pairs; returns how many.
///
/// # Safety
/// See [`pose`]; `engine` comes from [`parry_new`].
#[no_mangle]
pub unsafe extern "C" fn parry_collide(engine: &mut Engine, world_from_tool: *const f64) -> usize {
    // SAFETY: passed on.
    let placed = unsafe { pose(world_from_tool) };
    engine.pairs.clear();
    let (Some(tool), mockup) = (&engine.tool, &engine.mockup) else { return 0 };
    let mut simplex = VoronoiSimplex::new();
    let boxes_meet = |a: &BvhNode, b: &BvhNode| a.aabb().intersects(&b.aabb().transform_by(&placed));
    for (i, j) in mockup.bvh().leaf_pairs(tool.bvh(), boxes_meet) {
        let (fixed, moved) = (mockup.triangle(i), tool.triangle(j).transformed(&placed));
        // The box of the turned triangle is tighter than the turned box of the leaf, and cheaper than GJK.
        if !fixed.local_aabb().intersects(&moved.local_aabb()) {
            continue;
        }
        let between = (moved.a - fixed.a).try_normalize();
        let (meets, _) = details::intersection_test_support_map_support_map_with_params(
            &Pose::IDENTITY,
            &fixed,
            &moved,
            &mut simplex,
            between,
        );
        if meets {
            engine.pairs.push([j, i]);
        }
    }
    engine.pairs.len()
}

/// Whether anything meets: parry's own query for two shapes.
///
/// # Safety
/// See [`pose`]; `engine` comes from [`parry_new`].
#[no_mangle]
pub unsafe extern "C" fn parry_is_colliding(engine: &mut Engine, world_from_tool: *const f64) -> i32 {
    // SAFETY: passed on.
    let placed = unsafe { pose(world_from_tool) };
    let Some(tool) = &engine.tool else { return 0 };
    // The tool first: parry then asks the mock-up's tree for each of the tool's triangles. The other way round is slower.
    let found = intersection_test(&placed, tool, &Pose::IDENTITY, &engine.mockup);
    i32::from(found.is_ok_and(|found| found.intersecting))
}

/// When the tool first meets the mock-up while its point `centre` (its own frame) moves by `way` and it turns about it by
/// `turn` (an axis, as long as the angle); 2 if it does not. Without a turn parry's linear cast is asked, else the nonlinear.
///
/// # Safety
/// See [`pose`]; `centre`, `way` and `turn` hold three numbers each; `engine` comes from [`parry_new`].
#[no_mangle]
pub unsafe extern "C" fn parry_cast(
    engine: &mut Engine,
    world_from_tool: *const f64,
    centre: *const f64,
    way: *const f64,
    turn: *const f64,
) -> f64 {
    let vector = |numbers: *const f64| {
        // SAFETY: the length is the caller's promise.
        let v = unsafe { slice::from_raw_parts(numbers, 3) };
        Vec3::new(v[0] as f32, v[1] as f32, v[2] as f32)
    };
    let (centre, way, turn) = (vector(centre), vector(way), vector(turn));
    // SAFETY: passed on.
    let placed = unsafe { pose(world_from_tool) };
    let (Some(tool), mockup) = (&engine.tool, &engine.mockup) else { return 2.0 };
    // The mock-up first: parry then looks for the tool's whole way in its tree.
    let found = if turn == Vec3::ZERO {
        let options = ShapeCastOptions { compute_impact_geometry_on_penetration: false, ..with_end() };
        cast_shapes(&Pose::IDENTITY, Vec3::ZERO, mockup, &placed, way, tool, options)
    } else {
        let moving = NonlinearRigidMotion::new(placed, centre, way, turn);
        cast_shapes_nonlinear(&NonlinearRigidMotion::identity(), mockup, &moving, tool, 0.0, 1.0, true)
    };
    found.ok().flatten().map_or(2.0, |hit| f64::from(hit.time_of_impact))
}

fn with_end() -> ShapeCastOptions {
    ShapeCastOptions::with_max_time_of_impact(1.0)
}

/// The pairs of the last [`parry_collide`].
#[no_mangle]
pub extern "C" fn parry_pairs(engine: &Engine) -> *const u32 {
    engine.pairs.as_ptr().cast()
}

/// What parry counts for the mock-up: its corners, faces and tree.
#[no_mangle]
pub extern "C" fn parry_bytes(engine: &Engine) -> usize {
    engine.mockup.total_memory_size()
}
