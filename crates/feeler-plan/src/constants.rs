//! Every limit and tolerance of this crate: its unit, why this value, and what moves if it is changed.

// What may touch.

/// Bodies nearer than this (metres) touch; it is also the tolerance of casts. Above rounding in a mock-up of a kilometre, and far below
/// what is made. Larger: casts end earlier, and more of what is flush counts as seated.
pub const TOUCH: f64 = 1e-6;

/// How much deeper than at the start a seated pair may be, metres: contact gaps of curved surfaces vary by as much from facet to facet.
/// Larger: parts are drawn through bumps of that height.
pub const SEAT_TOLERANCE: f64 = 1e-5;

/// Steps at which seated pairs are measured while the tool moves by its own length. More: thinner ribs within a seat are seen, and it
/// takes longer.
pub const STEPS_A_LENGTH: f64 = 32.0;

/// Times as many steps where a way is verified.
pub const VERIFY_FINER: f64 = 4.0;

/// Share of a clearance by which a way may come nearer: where less is left above it, the next step is that long.
pub const CLEARANCE_SLACK: f64 = 0.02;

/// Share of the tool's length up to which the least distance along a way is refined.
pub const CLEARANCE_STEP: f64 = 1.0 / 256.0;

// Straight ways.

/// How far beyond the box of the mock-up the tool is out, as a share of its length.
pub const EXIT_MARGIN: f64 = 0.01;

/// Contact planes within this share of the tool's length give directions.
pub const DIRECTION_MARGIN: f64 = 0.02;

/// Most contact planes of which sums and cross products are taken: they are quadratic.
pub const MOST_NORMALS: usize = 10;

/// Cosine from which on two directions are one: two degrees. Smaller: fewer ways are tried.
pub const SAME_DIRECTION: f64 = 0.9994;

/// Most directions tried.
pub const MOST_DIRECTIONS: usize = 96;
