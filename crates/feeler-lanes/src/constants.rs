//! The one tolerance of the lanes. Register widths stand beside their traits, sizes of sorting in `sort.rs`.

/// Added to every slack (the unit of the slack): covers products that underflow in float32, and makes axes of next to no length
/// prove nothing. Less would let a product of two small numbers vanish unseen; more drops fewer pairs of specks.
pub const TINY: f32 = 1e-36;
