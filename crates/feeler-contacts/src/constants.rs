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

// --- footing -------------------------------------------------------------------------------------------------------

/// Most points of a footing: three hold a plane, the fourth is what most parts have.
pub const MOST_FOOTING: usize = 4;

/// The turn (radians) up to which holding a footing off a plane holds the tool off: one degree, far more than a tool turns between two
/// answers of a control loop. More makes footings of curved surfaces wider than what touches.
pub const FOOTING_TURN: f64 = 0.017_453_292_519_943_295;

/// Directions around the normal along which the lowest points are sought: between two of them a point of a round surface may be
/// lower by 1 - cos(180 / 64 degrees) of its distance from the middle, an eighth of a per cent.
pub const FOOTING_DIRECTIONS: usize = 64;

/// Share of the tool's length by which a body may be beyond a plane and still end at it: rounding of what made the plane. More takes
/// surfaces in each other's hollows for such that end at their plane.
pub const FOOTING_OFF: f64 = 1e-6;

/// Share of the tool's length by which what is carried is sought beyond the border of what carries, so that edges and corners of both
/// meet.
pub const FOOTING_WIDER: f64 = 1e-6;

/// Share of a footing's size up to which two of its points are one, and one in line with two others: well below the per cent that a
/// footing may leave undone.
pub const FOOTING_MERGED: f64 = 2e-3;

/// Share of the tool's length by which a point of a footing may be below the plane: what a round surface sags within a footing's
/// turn. A point that is lower pushes the tool away before it touches.
pub const FOOTING_LOW: f64 = 1e-4;

/// Triangles of a body that are asked where they are, whether or not what was found so far is over the other surface. Fewer lose
/// what touches beside the triangle that the contact was found at.
pub const FOOTING_FEW_ASKED: usize = 64;

/// Most triangles of a body that are asked: beyond, what carries is taken for what was found by then. More takes longer.
pub const FOOTING_MOST_ASKED: usize = 1 << 14;
