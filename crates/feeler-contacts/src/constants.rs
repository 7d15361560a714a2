//! Every tolerance and limit of the contacts, with its unit, its reason, and what moves when it changes.

use feeler_lanes::WIDE_LANES;

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

/// A later direction must be shallower by this share to be preferred, so that ties fall to normals of the mock-up always.
pub const SHALLOWER: f64 = 1e-6;

// Patches and convex bodies.

/// Most patches of one surface in a contact region, before patches that are not connected are split. Further smooth
/// regions join the patch with the nearest normal. The half-space tests compare all patches with all: twice as many
/// take four times as long; with fewer, finely curved surfaces are told apart less.
pub const MOST_PATCHES: usize = 256;

/// Points of a patch up to which all of them are its corners; a patch with more is represented by its extreme points
/// along eight directions. More corners find more planes that a patch crosses between its extreme points, and each is
/// one more point to test.
pub const MOST_CORNERS: usize = 8;

/// Fragments of a patch up to which connected components are found by comparing all with all: as many as one `u32` has
/// bits. Larger patches are flood filled. The result is the same; it moves time alone.
pub const FEW_FRAGMENTS: usize = u32::BITS as usize;

/// Sine of the angle, seen from the middle of a patch, up to which a point may stand out over the patch's plane and
/// still count as not above it: below the turn between neighbouring patches of a concave surface (3 degrees), above the
/// noise of rounded corners. Larger values join concave patches into one body, which then counts as deeper than it is;
/// smaller values break convex surfaces apart at corners that are rounded inward.
pub const HOLLOW: f64 = 0.02;

/// The same for a patch whose triangles all lie in one plane, where only rounding has to be allowed for: which points
/// of a shared patch a body takes. Larger values lend a body points of its neighbour, smaller ones drop points on the
/// common edge.
pub const HOLLOW_OF_PLANE: f64 = 1e-6;

/// Most facets of a body, the largest, whose normals are tried as axes: with the mean of all normals, three full
/// registers of eight float64. Depths of bodies with more facets are not certain to be the least.
pub const MOST_NORMALS: usize = 3 * WIDE_LANES - 1;

/// Most pairs of an edge of one body and an edge of the other, an edge being any two facets, whose cross products are
/// all tried. Beyond, the least depth is searched for by arcs and descent, and is not certain to be the least.
pub const MOST_EDGES: usize = 100;
