//! Every limit and tolerance of this crate: its unit, why this value, and what moves if it is changed.

// Straight ways.

/// Contact planes within this share of the tool's length give directions.
pub const DIRECTION_MARGIN: f64 = 0.02;

/// Most contact planes of which sums and cross products are taken: they are quadratic.
pub const MOST_NORMALS: usize = 10;

/// Cosine from which on two directions are one: 1.4 urad, which over a tenth of a metre is less than what touches. Smaller: a direction
/// along a face may be taken for one that leads into it.
pub const SAME_DIRECTION: f64 = 1.0 - 1e-12;

/// Sine up to which a way that goes against a contact plane still counts as along it: facets of a bore lean by rounding. Larger: more
/// ways that are blocked at once are tried early.
pub const OPPOSING_SHARE: f64 = 1e-3;

/// Most directions tried.
pub const MOST_DIRECTIONS: usize = 96;

// Trees.

/// How many trees there are: each thread takes some. Fixed, so that the answer does not depend on the threads.
pub const TREES: u64 = 8;

/// Casts that each tree makes in a round. Time is asked for, and ways are looked for, after each. More: less to wait for others; fewer:
/// nearer to the time limit.
pub const ROUND_CASTS: u64 = 16;

/// Nodes until a tree begins anew the first time. A tree that starts badly may take a thousand times as long as another. More: more of
/// a long way is found in one life; fewer: less is lost by bad luck.
pub const NODES_A_LIFE: u64 = 60;

/// Longest motion towards a sample, in lengths of the tool.
pub const STEP: f64 = 0.5;

/// The share of samples towards which the nearest node moves without a turn.
pub const STRAIGHT_SHARE: f64 = 0.3;

/// What a turn weighs when the nearest node is sought: a lever, as a share of the tool's radius.
pub const TURN_WEIGHT: f64 = 0.5;

/// Most times that a motion slides on.
pub const MOST_SLIDES: usize = 4;

/// Longest motion on a slide, in lengths of the tool: contacts are taken for planes along it.
pub const LONGEST_SLIDE: f64 = 0.25;

/// How far a slide stays off what stopped it, in lengths of the tool.
pub const SLIDE_SKIN: f64 = 1e-4;

/// What stopped a motion stands in the way of the next ones while it is nearer than this, in lengths of the tool.
pub const BLOCKER_MARGIN: f64 = 0.05;

/// A motion shorter than this, in lengths of the tool, makes no node.
pub const SHORTEST_STEP: f64 = 1e-3;

/// Of so many new nodes one tries straight ways out.
pub const EXIT_EVERY: u64 = 4;

// Shortcuts.

/// Shortcuts that are tried between random places of a way.
pub const CUT_TRIES: u32 = 40;

/// A shortcut saves this at least, in lengths of the tool.
pub const LEAST_CUT: f64 = 0.01;

// Swept volumes: how an error is shared out, and limits.

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
