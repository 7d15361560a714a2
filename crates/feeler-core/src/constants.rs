//! Every limit, tolerance and rounding bound of the core, with its unit, its reason, and the effect of a change.
//!
//! Answers are exact for any values, as long as no bound is below the one that its reason gives: a filter with a larger
//! one lets more pairs through to the next, slower stage. Sizes that only cost time (of batches, samples, look-ahead)
//! stand where they are used.

use std::ops::Range;

// --- Limits of accepted input ---

/// Largest coordinate (metres) of a triangle that is queried, and of a pose's translation.
///
/// Cubes of sums of such numbers stay below the largest float64, so no predicate can overflow. A triangle beyond it is
/// counted in the report as `too_large` and not queried.
pub(crate) const LARGEST_COORDINATE: f64 = 1e100;

/// How far `R * transpose(R)` may be from the identity, entry by entry, for a pose to count as rigid (no unit). Float32 matrices
/// are within it; more would let scale and shear pass for a rotation.
pub(crate) const POSE_TOLERANCE: f64 = 1e-6;

/// Most triangles of a tool: a found pair and its kind share 64 bits, two of them for the kind.
pub(crate) const MAX_TOOL_TRIANGLES: usize = 1 << 30;

/// Most voxels along one axis: keeps a voxel's key `(i*Nj + j)*Nk + k` below 2^63.
pub(crate) const MAX_VOXELS_PER_AXIS: u32 = 1 << 21;

/// Fewest vertices of a piece for drawing: a triangle's.
pub(crate) const LEAST_PIECE_VERTICES: usize = 3;

/// Most vertices of a piece for drawing: indices of 16 bits name them, and leave out the one that restarts strips.
pub(crate) const MOST_PIECE_VERTICES: usize = 65_535;

/// Of several pieces for drawing, the first has a share of 1 / this of the vertices allowed: it is drawn while the others are still
/// on their way, and a picture of the largest shapes alone is there the sooner.
pub(crate) const FIRST_PIECE_SHARE: usize = 4;

/// Parts of fewer bytes in a packed piece are not looked for among others: a place takes 64 itself.
pub(crate) const LEAST_SHARED_BYTES: usize = 160;

/// The most shapes with the same triangles that a part is compared with.
pub(crate) const MOST_SHAPES_ALIKE: usize = 8;

/// How far a vertex of a copy may be from its place, of the largest coordinate: both ends are rounded to 2^-24 of theirs, and a
/// rotation by three vertices has their rounding too.
pub(crate) const SHARED_ROUNDING: f32 = 1.0 / (1 << 22) as f32;

/// Ids kept per kind of defect in a report. Counts are complete; more ids take memory.
pub(crate) const DEFECT_IDS_KEPT: usize = 100;

/// Stands for no triangle, and for no entry of any other list, where a number is kept: no list is so long.
pub const NONE: u32 = u32::MAX;

// --- Float64 and its limits ---

/// Half the distance from 1 to the next float64: the largest relative error of one rounded operation.
pub const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// The same of float32.
pub(crate) const UNIT_ROUNDOFF_F32: f32 = f32::EPSILON / 2.0;

/// The smallest float64 above 0: the value of a distance too small for float64, so that only meeting gives 0.
pub(crate) const SMALLEST: f64 = f64::from_bits(1);

/// Squares of lengths (square metres) that neither overflow nor lose digits, and whose products do not. Others are scaled first:
/// slower, the same to the last few digits.
pub const PLAIN: Range<f64> = 1e-140..1e140;

/// Sums of products below this (square metres) have lost too much to rounding towards 0; their terms are scaled first.
pub(crate) const VANISHING: f64 = 1e-280;

/// Squared gaps of boxes (square metres) of which a root can be taken; beyond, a single axis gives the bound.
pub(crate) const MEASURABLE: Range<f64> = 1e-290..1e290;

/// Shortest normal, and slowest rate, whose square is still a number to count on (any unit); a shorter normal holds nothing apart.
pub(crate) const LEAST_LENGTH: f64 = 1e-140;

// --- Orientation signs (Shewchuk 1997) ---

/// Error bound of the float64 evaluation of `orient3d`, relative to its permanent (the same sum with absolute values).
///
/// Shewchuk's stage-A bound: differences carry one rounding each, products and sums up to six more on any path, which
/// gives (7 + 56 u) u with u the unit roundoff; the second term covers the higher orders and the rounding of the
/// permanent itself. Less would be wrong, more sends more signs to exact arithmetic.
pub(crate) const ORIENT3D_BOUND: f64 = (7.0 + 56.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;

/// The same for `orient2d`: (3 + 16 u) u.
pub(crate) const ORIENT2D_BOUND: f64 = (3.0 + 16.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;

/// The same for a scalar product with a difference of points: a difference, a product, two sums: (4 + 16 u) u.
pub(crate) const DOT_BOUND: f64 = (4.0 + 16.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;

/// Below this permanent (cubic metres) the bounds above could be spoilt by underflow: a product that underflows loses at most
/// 2^-1074, which a further factor of at most 2e100 and the sum of six terms bring to less than 1e-221; the bound itself is
/// then 7e-216 or more.
pub(crate) const SAFE_PERMANENT: f64 = 1e-200;

/// Adaptive expansions are exact while every nonzero input (metres) has a binary exponent in [-142, 201] (Shewchuk, section 5, for
/// `orient3d`): this is just above 2^-142. Other inputs go to big integers.
pub(crate) const SAFE_SMALLEST: f64 = 1.8e-43;

/// The other end of that range: just below 2^201.
pub(crate) const SAFE_LARGEST: f64 = 3.2e60;

// --- Triangle pairs in float32 lanes; the derivation stands at the head of intersect_lanes.rs ---

/// No entry of a vector counts as less, metres: 2^-32, so that no product of three of them underflows.
pub(crate) const LEAST_ENTRY: f32 = 1.0 / 4_294_967_296.0;

/// Share of the size of the numbers that a corner's place is the sum of, below which no entry counts: 2^-20. It covers what a place
/// at a pose is off by.
pub(crate) const PLACE_ROUNDING: f64 = 1.0 / 1_048_576.0;

/// Error bound of the normal of a mock-up's triangle, in products of its edges' largest entries: 2^-22.
pub(crate) const MOCKUP_NORMAL_ROUNDING: f32 = 1.0 / 4_194_304.0;

/// The same of a tool's triangle, whose corners are off by their places at the pose as well: 2^-20.
pub(crate) const TOOL_NORMAL_ROUNDING: f32 = 1.0 / 1_048_576.0;

// --- Distances of triangles ---

/// The largest error of a distance of two triangles, in unit roundoffs of the largest difference of their coordinates:
/// about a dozen roundings on the way to each witness point, and a factor of four to spare. Searches look that much
/// farther than requested.
pub const DISTANCE_ROUNDOFFS: f64 = 128.0;

/// The largest error of the common point of two colliding triangles, likewise. It is worst where slivers that are
/// nearly in one plane cross, which float64 cannot locate better.
pub const MEETING_ROUNDOFFS: f64 = 8_388_608.0;

/// Square of the sine below which two directions count as near parallel, or a face as a sliver (no unit). What is narrower takes
/// more steps, so that the error of its parameters does not show.
pub(crate) const NARROW: f64 = 1e-6;

/// How far outside 0 to 1 a parameter of an edge or face may seem to be, by the rounding of directions that are not [`NARROW`]
/// (no unit). Beyond it the inside is not tried; more only costs time.
pub(crate) const OUTSIDE: f64 = 1e-6;

/// Square of a gap, over that of the size, that rounding alone leaves where triangles meet (no unit): no better point is sought.
pub(crate) const CLOSE_ENOUGH: f64 = 64.0 * UNIT_ROUNDOFF * UNIT_ROUNDOFF;

/// Below that, products and inverse of a square leave the range (pair of size 1): such lengths are nothing beside 1.
pub(crate) const LEAST_SQUARE: f64 = 1e-200;

/// Least gap along an axis that counts as one beyond rounding: products that underflow are no proof.
pub(crate) const LEAST_GAP: f64 = 1e-300;

/// Relative error of a root and the dozen operations before it, rounded up (no unit).
pub(crate) const ROOT_ROUNDING: f64 = 1e-13;

/// Largest coordinates (metres, from the first corner) that eight pairs at once work with as they are; units make no difference
/// there. Other pairs are done one at a time, in units of the pair.
pub(crate) const LANE_COORDINATES: Range<f64> = 1e-6..1e6;

/// Share of the largest coordinate by which a gap along an axis may be off: a few dozen roundings are less (no unit).
pub(crate) const GAP_ROUNDING: f64 = 1e-9;

/// Relative error of a squared gap over a squared length, far above what its dozen roundings make (no unit).
pub(crate) const SQUARE_ROUNDING: f64 = 1e-6;

// --- Pieces of triangles, and their boxes in the index ---

/// Deepest bisection of a triangle into pieces. Forty halvings shrink a kilometre to a nanometre.
pub(crate) const MAX_CUT_DEPTH: u32 = 40;

/// Cutting rounds each midpoint once per level, so a piece may lie off its exact place by this many unit roundoffs of
/// the largest coordinate: one a level for the midpoint's sum, with a factor of two to spare.
pub(crate) const CUT_ROUNDOFFS: f64 = 2.0 * MAX_CUT_DEPTH as f64;

/// Smallest piece size, in unit roundoffs of the triangle's largest coordinate: boxes of pieces grow by [`CUT_ROUNDOFFS`] of
/// them anyway, so smaller pieces would bring nothing.
pub(crate) const LEAST_PIECE_ROUNDOFFS: f64 = 8.0 * CUT_ROUNDOFFS;

/// Share of extra pieces that cutting may add under the default piece-size rule of the mock-up (no unit).
/// More tightens boxes around long triangles and costs memory.
pub(crate) const MOCKUP_CUT_ALLOWANCE: f64 = 0.25;

/// Extra pieces a triangle where the piece size is chosen for a tool (no unit): the most that the choice may spend. With three
/// pieces a triangle the index and the triangles take some 120 bytes a triangle.
pub(crate) const CHOSEN_CUT_ALLOWANCE: f64 = 2.0;

/// Extra pieces a tool may have: the long triangles of a coarse tool are worth several pieces each. A fine tool has short ones
/// already, and pays for each piece at every pose.
pub(crate) const TOOL_CUT_PIECES: f64 = 1000.0;

/// But at most this many for each of its triangles.
pub(crate) const TOOL_CUT_PIECES_EACH: f64 = 2.5;

/// Roundings, in unit roundoffs of the largest number involved, by which a placed piece or box may be off the triangle at
/// the pose: 4 for the triangle's corners, 4 for the piece's, 16 for a box's centre and reach, and a factor of two to spare.
pub(crate) const TRANSFORM_ROUNDOFFS: f64 = 48.0;

/// Roundings, in unit roundoffs of the largest number involved, by which a pose relative to another may put a triangle elsewhere: the
/// inverse of a rotation takes 8 an entry, its product with another 3 rows of 14, the translation 20, the corners of both triangles in
/// the world 4 each; times the root of three for an axis of the other frame, and a factor of four to spare.
pub(crate) const RELATIVE_ROUNDOFFS: f64 = 512.0;

/// How much longer a distance may be in the frame of a pose than in the world (a share): poses are rigid within
/// [`POSE_TOLERANCE`].
pub(crate) const FRAME_STRETCH: f64 = 10.0 * POSE_TOLERANCE;

/// Error bound of a placed coordinate in float32, as a share of the sum of the numbers it is made of: 2^-20, twice its eight
/// roundings of 2^-24. The derivation stands at `Placement::new`.
pub(crate) const PLACEMENT_ROUNDING: f64 = 1.0 / 1_048_576.0;

/// Least margin of a placement, frame units: covers products that underflow in float32.
pub(crate) const LEAST_MARGIN: f64 = 1e-30;

/// Numbers of a placement from which on float32 could overflow (frame units): its boxes are endless then, and nothing is dropped.
pub(crate) const LARGEST_PLACEMENT: f64 = 1e30;

/// Rounding error bound of coordinates unpacked from bytes, frame units: 2^-21, eight roundings of coordinates that are at
/// most 1.
pub(crate) const UNPACK_ROUNDING: f32 = 1.0 / 2_097_152.0;

/// Half a byte, or half a step, and a little for the roundings on the way there (steps).
pub(crate) const HALF_STEP: f32 = 0.51;

/// Error bound of a side of a box in float32, frame units: 2^-23, coordinates are at most 1 and were rounded once; twice that.
pub(crate) const SIDE_ROUNDING: f64 = 1.0 / 8_388_608.0;

// --- The search for near triangles, in float32 lanes ---

/// Margin of a placement (frame units) beyond which float32 tells too little, at some 64 times the mock-up's size: the plain search
/// takes over.
pub(crate) const FAR_MARGIN: f32 = 1.0 / 16_384.0;

/// Distances (frame units) from which on the square is no longer one for float32: nothing is dropped by it.
pub(crate) const LARGEST_BOUND: f64 = 1e15;

/// By how much the square of a distance is rounded up, as a share of it: bounds of boxes have a few roundings of 2^-24 each.
pub(crate) const BOUND_ROUNDING: f64 = 1e-5;

/// Added to it: covers squares that underflow in float32 (square frame units).
pub(crate) const VANISHING_SQUARE: f64 = 1e-36;

/// By how much a bound from planes is rounded down, as a share of it: far more than its few dozen roundings of 2^-24.
pub(crate) const LEAF_ROUNDING: f64 = 1e-4;

/// Squares of axes shorter than that (square frame units) have lost too much to rounding towards 0; they prove nothing.
pub(crate) const LEAST_AXIS_SQUARE: f32 = 1e-28;

// --- Rays ---

/// Relative error of where along a ray a triangle is met (no unit): 2^-40. Where float64 cannot say it as well it is found exactly,
/// and places closer than that are compared exactly. Less makes more rays slow.
pub(crate) const TIME_SURE: f64 = 1.0 / (1u64 << 40) as f64;

/// By how much the end of the searched part of a ray is rounded up, as a share of it: 2^-36, far above the former.
pub(crate) const RAY_LIMIT_ROUNDING: f64 = 1.0 / (1u64 << 36) as f64;

/// Error bound of the sides of boxes, seen from a ray's origin, in float64, in unit roundoffs of the largest coordinate in play:
/// two roundings, and room to spare.
pub(crate) const RAY_ROUNDOFFS: f64 = 16.0;

/// By how much boxes grow for a ray in float32, frame units: 2^-19. Its origin, brought to the mock-up's box, and its direction are
/// rounded once (2^-23 along the box), a place along it four times (2^-21), and what came before adds [`FAR_RAY`].
pub(crate) const RAY_GROWTH: f32 = 1.0 / 524_288.0;

/// Error bound of a ray's origin in float64 when brought to the mock-up's box, frame units: 2^-22. Beyond, the plain search
/// takes over.
pub(crate) const FAR_RAY: f64 = 1.0 / 4_194_304.0;

/// The least entry of a unit direction in float32: smaller ones are taken for it, which moves no point by more.
pub(crate) const LEAST_SLOPE: f32 = 1e-20;

// --- Motion and casts ---

/// Share of the path in which a matrix's deviation from a rotation fades out. A turn by the angle `a` changes an entry of
/// `R R^T - I` by at most `6e-6 a`, and the shortest way turns by at most 3.15 in all: fading in 1/32 takes away more.
pub(crate) const FADE: f64 = 1.0 / 32.0;

/// Most turns of a screw, no unit. More: a cast may take as many times as long, and the sine of the angle knows less.
pub(crate) const MOST_TURNS: f64 = 1000.0;

/// Roundings, in unit roundoffs of the largest coordinate in play, by which a tool corner at a pose on the way may be off the
/// way itself, per axis: some 40 for an entry of the rotation (sine, cosine, two products of matrices), three entries to a
/// coordinate, twice (once for the pivot), and 10 for the sums; and 2 to spare.
pub(crate) const MOTION_ROUNDOFFS: f64 = 512.0;

/// Relative error of a reach or an acceleration, far above what its few dozen roundings make (no unit).
pub(crate) const ARC_ROUNDING: f64 = 1e-9;

/// Roundings of a height above a plane relative to a corner of the triangle that stands still, in unit roundoffs of the largest
/// coordinate from there: differences, products, sums; and a factor of two to spare.
pub(crate) const HEIGHT_ROUNDOFFS: f64 = 16.0;

/// Relative error of a time at which a height is used up, far above what its dozen roundings make (no unit). More makes steps
/// shorter.
pub(crate) const TIME_ROUNDING: f64 = 1e-12;

/// A share of the way that is lost in the rounding of a time: shorter steps are none.
pub(crate) const SHORTEST_STEP: f64 = 16.0 * UNIT_ROUNDOFF;

/// Most planes tried for one pair; then the time reached counts as the impact: early, not late.
pub(crate) const MAX_STEPS: u32 = 10_000;

/// Planes tried once a pair is nearer than the tolerance. Most pairs that only pass by get past; with fewer, more of these count
/// as impacts.
pub(crate) const STEPS_WHEN_NEAR: u32 = 4;

/// Share of the tolerance by which a plane that was searched for may be overlapped, where the plane of one of the triangles may be by all
/// of it: flat faces that come down together have pairs that all end at one time but for rounding, and only the first is followed to
/// its end. Larger, up to 1: more are followed; smaller: a slide ends by that much less than the tolerance deep.
pub(crate) const SEARCHED_SHARE: f64 = 0.999;

// --- Surfaces ---

/// Width of the triangle that represents a way, as a share of the way's length (no unit): far above rounding. Wider
/// ones collide with more that the way itself does not touch.
pub const NEEDLE_WIDTH: f64 = 0.01;

/// How much longer a ray is than the line to the border of the box that it leaves, as a share of the box: it ends clearly outside.
pub const RAY_EXCESS: f64 = 0.01;

/// Rays that decide by their median where a surface has cracks, which one ray may go through. Fewer: such surfaces may seem open.
pub const RAYS_WITH_CRACKS: usize = 3;

/// Share of a surface's length by which its corners may be off (no unit): a few steps of float32, in which many files have their
/// numbers. Corners as near as that may be one, and triangles as thin have normals that say nothing. More closes wider seams and
/// distrusts more slivers.
pub const WELD_SHARE: f64 = 1.0 / (1 << 19) as f64;

// --- Topology of meshes: seams, cracks, smooth regions and convex bodies ---

/// Parts are loose triangles if, after seams are closed, more than one in this many edges is a border. Their cracks are sought only if
/// they have few borders. Larger: fewer torn meshes are closed; smaller: soups of triangles take longer to load.
pub(crate) const EDGES_PER_OPEN_EDGE: usize = 2;

/// Border edges of a part up to which cracks are sought however loose its triangles are: about 20 ms. Larger: as above.
pub(crate) const LOOSE_EDGES_TRIED: usize = 4096;

/// Angle (radians) around an edge up to which two triangles coincide: above rounding. Larger: thin wedges that touch are mixed up.
pub(crate) const SAME_ANGLE: f64 = 1e-9;

/// How wide a crack may be, as a share of its part's length: a circle is off its polygon of 50 corners by that. Larger: more torn
/// surfaces are solids, and narrow slots may be closed.
pub(crate) const CRACK_WIDTH: f64 = 1e-3;

/// Share of a surface's area that its cracks may have together: a strip of sheet as narrow as a crack is all crack, and stays open.
pub(crate) const CRACK_AREA: f64 = 0.01;

/// Where along an edge (share of its length) the other border is sought: in the middle, which decides, and towards both ends.
pub(crate) const CRACK_SAMPLES: [f64; 3] = [0.5, 0.2, 0.8];

/// Most edges compared with one such point; more lie within a crack's width only in soups of triangles, which stay open.
pub(crate) const MOST_EDGES_NEAR: usize = 256;

/// Cosine of the angle between the normals of a triangle and of its smooth region's seed: 3 degrees, which on a surface of radius r
/// is off by r/700. Smaller: fewer, coarser regions, and planes of curved surfaces are that much off.
pub(crate) const SAME_REGION_COSINE: f64 = 0.998_63;

/// One less the cosine of the angle up to which normals are of one plane: 4.5e-5 radians, above rounding.
/// Larger: finely curved surfaces count as flat.
pub const ONE_PLANE: f64 = 1e-9;

/// Share of their distance by which rounding may put the triangles of one plane off it. Larger: steps in a surface are overlooked.
pub(crate) const REGION_PLANE_ROUNDING: f64 = 1e-6;

/// Rounding of a coordinate as a share of the largest: some thousand roundings.
pub(crate) const COORDINATE_ROUNDING: f64 = 1e-12;

/// How far a smooth region may stand out over another's plane (share of the distance between them, no unit) and still bulge with it:
/// below the turn between neighbouring regions of a hollow surface, above the noise of rounded corners. More makes fewer, less convex
/// bodies.
pub const BODY_HOLLOW: f64 = 0.02;

/// Cosine of the turn between neighbouring smooth regions of an open surface up to which they are of one body: 30
/// degrees. Rolled sheets stay one body, sheets bent over an edge do not.
pub const OPEN_TURN: f64 = 0.866;

/// Cosine of the angle between the normals of two regions from which on both stand for a body's planes: 8 degrees. Less lets a body
/// of many small regions become hollow unseen, more makes bodies of thousands of regions slow.
pub const SAME_BODY_PLANE: f64 = 0.9903;

// --- The cost of a query; they move the voxel size that is chosen, and no answer ---

/// Probability that a pair of tool triangle and voxel does not collide (the paper's `pnc`).
pub(crate) const NO_COLLISION_PROBABILITY: f64 = 0.99;

/// Cost of a triangle test over the cost of a voxel visit (the paper's `rt`).
pub(crate) const TEST_TO_VISIT_RATIO: f64 = 100.0;

/// Cost of a pair of a tool's cluster and a piece, over that of one of the sixteen pairs of pieces in it if their boxes meet,
/// per piece of the tool (no unit). Found on the samples carcass, differential and engine of 200,000 triangles; from half to
/// twice of it the chosen size is within 6 % of the best on all (docs/voxel-size.md).
pub(crate) const CLUSTER_SHARE: f64 = 0.04;

/// Cells along a side of the grid in which triangles are looked up by rays that tell which shells hold others.
pub(crate) const SENSE_GRID_SIDE: usize = 512;
/// A triangle in more cells than this is looked at for every ray, so that the grid stays small.
pub(crate) const SENSE_LARGE_CELLS: usize = 256;
/// Rays from a shell. Most of them decide: with cracks one may slip through.
pub(crate) const SENSE_RAYS: usize = 5;

/// The cosine from which on two unit normals are one plane's: a cast with contact takes a solid's own side then.
pub(crate) const SAME_AXIS: f64 = 0.999_9;

/// Triangles below which a mesh is prepared on the thread that asks: less work than to wake another.
pub(crate) const SMALL_MESH: usize = 512;

// --- Motions, and the least-distance program of motions that rows forbid ---

/// Angle (radians) below which the series of sine and cosine are exact to the last digit, and their quotients are not.
pub const SMALL_ANGLE: f64 = 1e-4;

/// Share of the scale, the skin, by which a row may be violated: above rounding in a mock-up of some metres. Larger: the proxy is that
/// much nearer; smaller: rows that hold from both sides exclude each other by rounding.
pub(crate) const QP_SLACK: f64 = 1e-5;

/// Sine of the angle between a row and those that are active from which on it is not a combination of them: above rounding after two
/// orthogonalisations. Larger: rows of nearly parallel faces exclude each other; smaller: multipliers without bound.
pub(crate) const LEAST_SINE: f64 = 1e-7;

/// Most steps of the program: each lets a row in or out, and few take more than three for each of the six coordinates. More: time.
pub(crate) const MOST_QP_STEPS: usize = 96;

/// Radius of gyration that every tool has at least about any axis, as a share of its radius: a straight wire has none of its own
/// about itself. Larger: thin tools turn less easily about their length than they would.
pub(crate) const LEAST_GYRATION_SHARE: f64 = 0.01;

/// How far two parts may be in each other, or apart, by the rounding of their coordinates, in units of the last place of the largest: each
/// of both surfaces may be off by some, in each coordinate, after a turn that was computed. More: thinner overlaps are contact.
pub const COORDINATE_ROUNDOFFS: f64 = 32.0;
