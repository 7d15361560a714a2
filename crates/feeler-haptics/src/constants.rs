//! Every limit and tolerance of this crate: its unit, why this value, and what moves if it is changed.

/// Angle (radians) below which the series of sine and cosine are exact to the last digit, and their quotients are not.
pub const SMALL_ANGLE: f64 = 1e-4;
