//! Every limit and rounding constant, with its unit, its reason, and what moves when it changes.

/// Half the distance from 1 to the next float64: the largest relative error of one rounded operation.
pub const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// Largest coordinate (metres) of a triangle that is queried, and of a pose's translation.
///
/// Cubes of sums of such numbers stay below the largest float64, so no predicate can overflow. A triangle beyond it is
/// counted in the report as `too_large` and not queried.
pub const LARGEST_COORDINATE: f64 = 1e100;

/// How far `R * transpose(R)` may be from the identity, entry by entry, for a pose to count as rigid (no unit).
pub const POSE_TOLERANCE: f64 = 1e-6;

/// Most triangles of a tool: a found pair and its kind share 64 bits, two of them for the kind.
pub const MAX_TOOL_TRIANGLES: usize = 1 << 30;

/// Most voxels along one axis: keeps a voxel's key `(i*Nj + j)*Nk + k` below 2^63.
pub const MAX_VOXELS_PER_AXIS: u32 = 1 << 21;

/// Deepest bisection of a triangle into pieces. Forty halvings shrink a kilometre to a nanometre.
pub const MAX_CUT_DEPTH: u32 = 40;

/// Cutting rounds each midpoint once per level, so a piece may lie off its exact place by this many unit roundoffs of
/// the largest coordinate: one a level for the midpoint's sum, with a factor of two to spare.
pub const CUT_ROUNDOFFS: f64 = 2.0 * MAX_CUT_DEPTH as f64;

/// Smallest piece size, in unit roundoffs of the triangle's largest coordinate: boxes of pieces grow by [`CUT_ROUNDOFFS`] of
/// them anyway, so smaller pieces would bring nothing.
pub const LEAST_PIECE_ROUNDOFFS: f64 = 8.0 * CUT_ROUNDOFFS;

/// Share of extra pieces that cutting may add under the default piece-size rule of the mock-up (no unit).
/// More tightens boxes around long triangles and costs memory.
pub const MOCKUP_CUT_ALLOWANCE: f64 = 0.25;

/// Extra pieces a triangle where the piece size is chosen for a tool (no unit): the most that the choice may spend. With three
/// pieces a triangle the index and the triangles take some 120 bytes a triangle.
pub const CHOSEN_CUT_ALLOWANCE: f64 = 2.0;

/// Extra pieces a tool may have: the long triangles of a coarse tool are worth several pieces each. A fine tool has short ones
/// already, and pays for each piece at every pose.
pub const TOOL_CUT_PIECES: f64 = 1000.0;

/// But at most this many for each of its triangles.
pub const TOOL_CUT_PIECES_EACH: f64 = 2.5;

/// Ids kept per kind of defect in a report.
pub const DEFECT_IDS_KEPT: usize = 100;

/// Roundings, in unit roundoffs of the largest number involved, by which a placed piece or box may be off the triangle at
/// the pose: 4 for the triangle's corners, 4 for the piece's, 16 for a box's centre and reach, and a factor of two to spare.
pub const TRANSFORM_ROUNDOFFS: f64 = 48.0;

/// What a distance of two triangles may be off by, in unit roundoffs of the largest difference of their coordinates: about a
/// dozen roundings on the way to each witness point, as many for the other, and a factor of four to spare.
pub const DISTANCE_ROUNDOFFS: f64 = 128.0;

/// What the common point of two triangles that meet may be off both, likewise. Worst where slivers that are nearly in one plane
/// cross: how far float64 can tell where.
pub const MEETING_ROUNDOFFS: f64 = 8_388_608.0;

/// How wide the triangle is that stands for a way, as a share of the way's length (no unit): by far more than rounding. Wider ones
/// meet more that the way itself does not.
pub const NEEDLE_WIDTH: f64 = 0.01;

/// Share of a surface's length by which its corners may be off (no unit): a few steps of float32, in which many files have their
/// numbers. Corners as near as that may be one, and triangles as thin have normals that say nothing. More closes wider seams and
/// distrusts more slivers.
pub const WELD_SHARE: f64 = 1.0 / (1 << 19) as f64;

/// Stands for no triangle, and for no entry of any other list, where a number is kept: no list is so long.
pub const NONE: u32 = u32::MAX;

/// How far a smooth region may stand out over another's plane (share of the distance between them, no unit) and still bulge with it:
/// below the turn between neighbouring regions of a hollow surface, above the noise of rounded corners. More makes fewer, less convex
/// bodies.
pub const BODY_HOLLOW: f64 = 0.02;

/// Cosine of the turn between neighbouring smooth regions of an open surface up to which they are of one body: 30 degrees. What is
/// rolled stays one, what is bent over an edge does not.
pub const OPEN_TURN: f64 = 0.866;

/// Cosine of the angle between the normals of two regions from which on both stand for a body's planes: 8 degrees. Less lets a body
/// of many small regions become hollow unseen, more makes bodies of thousands of regions slow.
pub const SAME_BODY_PLANE: f64 = 0.9903;
