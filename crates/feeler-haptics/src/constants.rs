//! Every limit and tolerance of this crate: its unit, why this value, and what moves if it is changed.

/// Angle (radians) below which the series of sine and cosine are exact to the last digit, and their quotients are not.
pub const SMALL_ANGLE: f64 = 1e-4;

// The least-distance program.

/// Share of the scale by which a row may be violated: above rounding of six products, far below any skin.
pub const QP_SLACK: f64 = 1e-11;

/// Sine of the angle between a row and those that are active from which on it is not a combination of them: above rounding after two
/// orthogonalisations. Larger: rows of nearly parallel faces exclude each other; smaller: multipliers without bound.
pub const LEAST_SINE: f64 = 1e-7;

/// Most steps of the program: each lets a row in or out, and few take more than three for each of the six coordinates. More: time.
pub const MOST_QP_STEPS: usize = 96;

/// Radius of gyration that every tool has at least about any axis, as a share of its radius: a straight wire has none of its own
/// about itself. Larger: thin tools turn less easily about their length than they would.
pub const LEAST_GYRATION_SHARE: f64 = 0.01;

// Constraint sets.

/// Most planes of a set: see [`MOST_ROWS`].
pub const MOST_PLANES: usize = 64;

/// Most rows of a set: 32 planes of eight points. More: a servo tick takes longer; fewer: planes beyond shorten how far a set is good
/// for.
pub const MOST_ROWS: usize = 256;

/// Programs in a row for one pose, each linear at the last one's: two for what turns a degree, the third for rounding.
pub const SOLVER_ROUNDS: usize = 4;

/// Share of the skin below which a round moves nothing.
pub const SOLVER_STILL_SHARE: f64 = 1e-4;

// The proxy.

/// Share of the skin below which a motion is none.
pub const STILL_SHARE: f64 = 1e-4;

/// Share of the least gap that a cast may end before the impact. Larger: motions along a surface are stopped by it; smaller: slower.
pub const CAST_SHARE: f64 = 0.05;

/// Bounds for that, metres: a micrometre, and what is above rounding in a mock-up of some metres.
pub const LARGEST_CAST_TOLERANCE: f64 = 1e-6;
pub const LEAST_CAST_TOLERANCE: f64 = 1e-10;

/// Share of the skin that the pair which stopped a motion is left apart.
pub const BACK_OFF_SHARE: f64 = 0.5;

/// Most times that the way back is doubled to get there: from a share of the skin to all of a metre.
pub const BACK_OFF_HALVINGS: usize = 16;

/// Most pairs remembered that stopped a cast.
pub const MOST_BLOCKERS: usize = 32;

/// Share of the clearance that is the skin, where that is less than the option's.
pub const CLEARANCE_SHARE: f64 = 0.5;

/// Bisections of the clearance: to two per cent of it.
pub const SKIN_HALVINGS: usize = 9;

/// Longest way, in skins as asked for, that may be needed to have all rows off by a skin for it to fit: farther off is another place.
pub const MOST_LIFT: f64 = 10.0;

/// Share of the skin by which a motion must lead nearer to the device for another to follow in the same tick.
pub const STUCK_SHARE: f64 = 0.1;

/// By how much the longest motion shrinks after one that was stopped by what it knew of, and grows after a free one.
pub const TRUST_GROWTH: f64 = 2.0;

/// Share of the skin with which the proxy is tried where contacts hold it from several sides. Smaller: tighter fits are entered.
pub const SQUEEZE_SHARE: f64 = 1.0 / 16.0;

/// How much nearer to the device that must lead, in skins: more than any but a very sharp wedge gives by itself.
pub const SQUEEZE_GAIN: f64 = 4.0;

/// Most ticks between two such tries.
pub const MOST_PATIENCE: u32 = 63;

/// By how much the skin grows a tick, where it may.
pub const SKIN_GROWTH: f64 = 2.0;

/// How far a wider skin may push the tool, in skins: less than [`SQUEEZE_GAIN`], so that it does not push out of what was squeezed into.
pub const SKIN_LIFT: f64 = 2.5;

/// What is a contact: as far as so many of the longest of the last motions, and so many skins, lead. More: more planes, which are
/// merged more coarsely where surfaces are curved; fewer: a fast tool is held back between two sets.
pub const STRIDES: f64 = 2.0;
pub const SKINS_IN_MARGIN: f64 = 20.0;

/// What is a contact at least, in skins as asked for.
pub const LEAST_MARGIN: f64 = 2.0;

/// By how much the longest of the last motions is forgotten a tick.
pub const STRIDE_DECAY: f64 = 0.8;
