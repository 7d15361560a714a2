//! Every tolerance and limit of the contacts, with its unit, its reason, and what moves when it changes.

/// Most planes of an answer.
pub const MOST_PLANES: usize = 32;

/// So many deep planes, one for each freedom of the tool, go well with all that is near. Beside more it matters less and less, and
/// looking for it takes as long as all else: it is sought ever nearer by.
pub const FEW_DEEP: usize = 6;

/// So many deep planes are an answer without anything that is only near.
pub const MANY_DEEP: usize = 12;

/// So many pairs that are near are enough: beyond, what is a little farther than the nearest is not worth its time. Two fine
/// surfaces one in the other are all near, each triangle to thousands.
pub const MANY_NEAR: usize = 1 << 20;

/// Times that the margin is halved to have fewer, and by how much it is more than the least distance at least.
pub const MOST_HALVINGS: usize = 10;
pub const BESIDE_THE_NEAREST: f64 = 1.05;

/// Pairs of a query from which on its working memory is not kept.
pub const MOST_HELD: usize = 1 << 16;

/// Cosine of the angle within which planes of two flat surfaces in one zone are one: half a degree.
pub const SAME_PLANE: f64 = 0.999_96;

/// Cosine of the angle between a plane and the best normal of two bodies up to which it holds these as well: 25 degrees.
pub const HELD_DIRECTION: f64 = 0.9063;

/// Cosine of the angle within which planes of a hollow surface are one: 12 degrees.
pub const SAME_DIRECTION: f64 = 0.978;

/// How far a patch may stand out over another's plane (share of the distance between them) and still count as not: below the
/// turn between neighbouring patches of a hollow surface, above the noise of rounded corners.
pub const HOLLOW: f64 = 0.02;

/// A later direction must be shallower by this share to be preferred, so that ties fall to normals of the mock-up always.
pub const SHALLOWER: f64 = 1e-6;
