//! Every limit and tolerance of this crate: its unit, the reason for its value, and the effect of a change.

// Straight ways.

/// Contact planes within this share of the tool's length give directions.
pub const DIRECTION_MARGIN: f64 = 0.02;

/// Most contact planes of which sums and cross products are taken: they are quadratic.
pub const MOST_NORMALS: usize = 10;

/// Cosine from which two directions are one: 1.4 urad, less than contact over a tenth of a metre. Smaller: a direction
/// along a face may be taken for one that leads into it.
pub const SAME_DIRECTION: f64 = 1.0 - 1e-12;

/// Sine up to which a way that goes against a contact plane still counts as along it: facets of a bore lean by rounding. Larger: more
/// ways that are blocked at once are tried early.
pub const OPPOSING_SHARE: f64 = 1e-3;

/// Most directions tried.
pub const MOST_DIRECTIONS: usize = 96;

// Held parts.

/// Triangles that are nearer than this to each other, in lengths of the part, may hold it; first the near ones alone. More and larger: parts
/// with more play are shown to be held, and it takes longer.
pub const HELD_WITHIN: [f64; 3] = [2e-3, 1.2e-2, 5e-2];

/// The least of them, metres: the play of fits is up to a third of it.
pub const LEAST_HELD_WITHIN: f64 = 3e-5;

/// Of more pairs of triangles nothing is shown: the programs would take longer than most ways out.
pub const MOST_HELD_PAIRS: usize = 20_000;

/// Times that bounds of the play are widened. More: parts with more play are shown to be held.
pub const MOST_WIDENED: usize = 6;

// Pushes.

/// Most axes along which a part is pushed from a pose. More: more directions off the first ones; fewer: faster.
pub const MOST_AXES: usize = 8;

/// Share of a part's area from which on its faces of one normal are a flat to push along. Less: more of small faces.
pub const FLAT_SHARE: f64 = 0.04;

/// Moments that differ by less than this share are one: their axes are any. Larger: axes of parts that are nearly round are not tried.
pub const SAME_MOMENT: f64 = 0.01;

/// A pitch below this share of the tool's length is none.
pub const LEAST_PITCH: f64 = 0.0025;

/// Times that a screw is followed on from the middle of its play.
pub const MOST_THREADED: usize = 24;

/// Most flats.
pub const MOST_FLATS: usize = 5;

/// Most axes of cylinders of a part.
pub const MOST_CYLINDERS: usize = 6;

/// Most edges of the cylinders along a direction: pairs of them are compared.
pub const MOST_CYLINDER_EDGES: usize = 200;

/// Contact planes whose normals a node is pushed along, too.
pub const MOST_TOUCHED: usize = 4;

/// Most poses of a search by pushes: with their pending pushes they take tens of megabytes.
pub const MOST_NODES: usize = 8192;

/// Most twists that contacts leave free which are followed: the space has at most six dimensions.
pub const MOST_TWISTS: usize = 4;

/// Eigenvalue, as a share of the largest, up to which the contacts leave a twist free: facets lean by about the square root of it. Larger:
/// more twists that are blocked at once.
pub const FREE_SHARE: f64 = 1e-3;

/// Turns after which a thread is taken for endless.
pub const MOST_TURNS_OF_A_THREAD: f64 = 40.0;

/// Poses whose farthest corner is nearer to each other than this are one, in lengths of the tool.
pub const SAME_PLACE: f64 = 0.06;

/// Where all pushes are tried, it begins anew with less that counts as play, by this share.
pub const NEXT_LEVEL: f64 = 0.25;

/// Below this level, as a share of the first, not any more.
pub const LEAST_LEVEL: f64 = 0.02;

/// A push shorter than this, in lengths of the tool, is play.
pub const LEAST_PUSH: f64 = 0.06;

/// A turn by less than this is play, radians.
pub const LEAST_TURN: f64 = 0.2;

/// Shorter pushes, in lengths of the tool, may be play: they are continued later.
pub const LONG_PUSH: f64 = 0.15;

/// Beside a push shorter than this, in lengths of the tool, no openings are looked for.
pub const LEAST_SCAN: f64 = 0.06;

/// A part that is turned by less than this, radians, is pushed along the axes that it had at the start.
pub const LITTLE_TURN: f64 = 0.1;

/// Between two places where a push is tried for openings beside it, in lengths of the tool. Shorter: narrower openings are found.
pub const SAMPLE_STEP: f64 = 0.02;

/// The same of a turn, radians: a degree. A part fits into a slot with a play of a hundredth of its radius.
pub const SAMPLE_ANGLE: f64 = 0.017_453_292_519_943_295;

/// Most places of one push.
pub const MOST_SAMPLES: usize = 180;

/// How far it is pushed there, in lengths of the tool: into an opening, and not all the way.
pub const PROBE: f64 = 0.25;

/// Where on that it is looked whether it collides; the last ones are beyond it, for doors that it is not at yet. More: fewer openings behind
/// thin walls are tried in vain.
pub const PROBED: [f64; 10] = [0.031, 0.0625, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 6.0, FAR];

/// If nearly everything beside is free, a direction that is free up to here is an opening, too.
pub const FAR: f64 = 8.0;

/// Pushes are alone for as much work, in collisions, but for the first rounds of the trees: then trees grow beside them. More: later where
/// only a tree finds a way after long.
pub const YOUNG: u64 = 15_000;

/// Rounds of the trees beside young pushes, from [`FIRST_PUSHES`] on: most ways that trees find are found soon. More: pushes find theirs
/// later.
pub const FIRST_TREE_ROUNDS: u32 = 16;

/// Pushes are alone at first for as much work, in collisions.
pub const FIRST_PUSHES: u64 = 1_000;

/// A cast counts as this many collisions.
pub const WORK_OF_A_CAST: u64 = 16;

/// How much farther than beside it a direction must be free to be an opening, as a share.
pub const LEAST_OPENING: f64 = 0.1;

/// Casts that pushes have in a round, beside those of the trees. More: where only a tree finds a way it is found later.
pub const PUSH_CASTS: u64 = 128;

/// Pieces into which a quarter of a turn is cut when poses describe it: few first, then more until these are free, too.
pub const PIECES: [usize; 4] = [1, 4, 16, 64];

/// A middle no farther than this off the axis of a screw, in lengths of the tool, is on it: for rounding only.
pub const SAME_MOTION: f64 = 1e-12;

/// Poses and a screw that differ by at most this, metres, are one motion: a tenth of the contact distance.
pub const SAME_PLACE_M: f64 = 1e-7;

/// Most pieces of a quarter of a turn that are given because they are the same motion.
pub const MOST_SAME_PIECES: usize = 128;

// Trees.

/// How many trees there are: each thread takes some. Fixed, so that the answer does not depend on the threads.
pub const TREES: u64 = 8;

/// Casts that each tree makes in a round. After each round, time is checked and paths out are sought. More: less
/// waiting for others; fewer: nearer to the time limit.
pub const ROUND_CASTS: u64 = 16;

/// Nodes until a tree begins anew the first time. A tree that starts badly may take a thousand times as long as another. More: more of
/// a long way is found in one life; fewer: less is lost by bad luck.
pub const NODES_A_LIFE: u64 = 60;

/// Longest motion towards a sample, in lengths of the tool.
pub const STEP: f64 = 0.5;

/// The share of samples towards which the nearest node moves without a turn.
pub const STRAIGHT_SHARE: f64 = 0.3;

/// Weight of a turn in the search for the nearest node: a lever, as a share of the tool's radius.
pub const TURN_WEIGHT: f64 = 0.5;

/// Most times that a motion slides on.
pub const MOST_SLIDES: usize = 4;

/// Longest motion on a slide, in lengths of the tool: contacts are taken for planes along it.
pub const LONGEST_SLIDE: f64 = 0.25;

/// Distance that a slide keeps from the part that stopped it, in lengths of the tool.
pub const SLIDE_SKIN: f64 = 1e-4;

/// A part that stopped a motion also blocks the next ones while it is nearer than this, in lengths of the tool.
pub const BLOCKER_MARGIN: f64 = 0.05;

/// A motion shorter than this, in lengths of the tool, makes no node.
pub const SHORTEST_STEP: f64 = 1e-3;

/// One of this many new nodes tries straight paths out.
pub const EXIT_EVERY: u64 = 4;

// Shortcuts.

/// Shortcuts that are tried between random places of a way.
pub const CUT_TRIES: u32 = 40;

/// A shortcut saves this at least, in lengths of the tool.
pub const LEAST_CUT: f64 = 0.01;

/// Places of a way from which it is tried without more turns.
pub const MOST_UNTURNED: usize = 8;

/// How far a pose between two legs is moved away from near parts, in lengths of the tool, one after the other.
pub const PULLS: [f64; 6] = [0.04, 0.02, 0.01, 0.005, 0.0025, 0.00125];

/// Most of these moves that are followed.
pub const MOST_PULLS: u32 = 32;

/// Places of a leg at which it is looked how near it comes. More: of narrower edges it is kept off.
pub const PULLED_SAMPLES: u32 = 12;

/// How much longer a way may get by them.
pub const LONGER_FOR_CLEARANCE: f64 = 1.05;

// Swept volumes: how an error is shared out, and limits.

/// Spacing of the grid, in errors. Twice the error of interpolation ([`INTERPOLATION`]) and [`HULL_SHARE`] must be
/// below 1.
pub const SPACING: f64 = 0.44;

/// The level of the surface, in spacings: in the middle between [`INTERPOLATION`], below which the swept set could
/// reach the surface, and the rest of the error above it.
pub const LEVEL: f64 = 0.895;

/// The largest error of a distance interpolated in a tetrahedron of a cell, in spacings: half the cell's diagonal, and
/// the effect of [`EDGE_SHARE`].
pub const INTERPOLATION: f64 = 0.866_026 + 1.733 * EDGE_SHARE;

/// A corner of the surface keeps this share of its grid edge to both ends (no unit): no triangle degenerates. More makes the surface
/// coarser.
pub const EDGE_SHARE: f64 = 1.0 / 64.0;

/// The longest edge of a tetrahedron, in spacings: a cell's diagonal.
pub const LONGEST_EDGE: f64 = 1.732_051;

/// The largest error of hulls of places, in errors: the more, the fewer steps.
pub const HULL_SHARE: f64 = 0.19;

/// How exactly distances to hulls are found, in errors.
pub const DISTANCE_TOLERANCE: f64 = 0.01;

/// Cells along a side of a block. Larger blocks have fewer nodes twice, and end the search for empty space sooner.
pub const BLOCK: usize = 8;

/// Most cells along an axis: an edge's number, of three coordinates and a direction, fits 64 bits.
pub const MOST_CELLS: u32 = 1 << 20;

/// Triangles narrower than this, in errors, are not cut: their hulls would be smaller than their surroundings.
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

/// Share of a removal that counts as done after the straight paths, and before pushes and trees. They only shape what progress shows.
pub const SHARE_OF_STRAIGHT: f64 = 0.1;
pub const SHARE_OF_SEARCH: f64 = 0.2;

/// Rounds of pushes and trees that count as half of all. Most removals that are found need fewer.
pub const ROUNDS_TO_HALF: f64 = 32.0;
