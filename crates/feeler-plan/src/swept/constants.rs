//! How an error is shared out, and limits, of swept volumes.

/// Spacing of the grid, in errors. Twice what interpolation may be off ([`INTERPOLATION`]) and [`HULL_SHARE`] must be below 1.
pub const SPACING: f64 = 0.44;

/// The level of the surface, in spacings: in the middle between [`INTERPOLATION`], below which the swept set could reach the surface,
/// and what is left of the error above it.
pub const LEVEL: f64 = 0.895;

/// By how much a distance that is interpolated in a tetrahedron of a cell may be off, in spacings: half the cell's diagonal, and
/// what [`EDGE_SHARE`] moves.
pub const INTERPOLATION: f64 = 0.866_026 + 1.733 * EDGE_SHARE;

/// A corner of the surface keeps this share of its grid edge to both ends (no unit): no triangle degenerates. More makes the surface
/// coarser.
pub const EDGE_SHARE: f64 = 1.0 / 64.0;

/// The longest edge of a tetrahedron, in spacings: a cell's diagonal.
pub const LONGEST_EDGE: f64 = 1.732_051;

/// What hulls of places may be off, in errors: the more, the fewer steps.
pub const HULL_SHARE: f64 = 0.19;

/// How exactly distances to hulls are found, in errors.
pub const DISTANCE_TOLERANCE: f64 = 0.01;

/// Cells along a side of a block. Larger blocks have fewer nodes twice, and end the search for empty space sooner.
pub const BLOCK: usize = 8;

/// Most cells along an axis: an edge's number, of three coordinates and a direction, fits 64 bits.
pub const MOST_CELLS: u32 = 1 << 20;

/// Triangles narrower than this, in errors, are not cut: their hulls would be smaller than what is near them.
pub const LEAST_WIDTH: f64 = 6.0;

/// Bytes of memory for a step of a triangle: itself, and its number in the lists of the cubes that it is near.
pub const BYTES_PER_STEP: f64 = 64.0;

/// Most steps of triangles: a search among more takes an hour.
pub const MOST_STEPS: f64 = 8_388_608.0;

/// Errors that are tried for one that fits, where the one given does not: each is three times the one before, or nearer.
pub const MOST_TRIALS: usize = 40;

/// The least error, in lengths of the tool, with which is looked how large the surface is.
pub const COARSE: f64 = 1.0 / 64.0;

/// Most halvings of a segment of the way.
pub const MOST_HALVINGS: u32 = 24;

/// Nodes of the tree at which it is shared out to threads, and the memory needed is judged by.
pub const SHARES: usize = 4096;

/// Triangles of the surface to a cell that it passes, where it is flat and along the grid: most that a plane gives is twice as many.
pub const TRIANGLES_PER_CELL: f64 = 8.0;

/// Bytes of memory for a triangle of the surface, in blocks, joined, and as a mesh.
pub const BYTES_PER_TRIANGLE: f64 = 160.0;
