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

// Contours: segments, sides of vertices, and what is enclosed.

/// Sine of the angle between two triangles up to which they lie in one plane: rounding then decides where their common line is, and
/// they share a polygon. Larger: thin wedges share a polygon where they share a segment.
pub const PARALLEL_SINE: f64 = 1e-9;

/// One less the cosine of the angle between two triangles up to which their segment is flat and tells no side: 1.4e-6 radians.
/// Larger: more vertices at grazing contours are on no side; smaller: rounding tells their side.
pub const COPLANAR_COSINE: f64 = 1e-12;

/// Most triangles that the search for the normal of a thin one visits. Fewer: in wider strips of slivers normals are noise.
pub const MOST_THIN_NEIGHBOURS: usize = 16;

/// Share of the tool's displacement since the reference that must come out of a closed surface, along its normal, for the tool to
/// have gone in on the other side: 30 degrees off the surface. Smaller: sliding along the surface is taken for it; larger: thin plates
/// must be pierced more steeply.
pub const CAME_THROUGH_SHARE: f64 = 0.5;

/// Share of the displacement since the reference that must be along the normal of an open surface to tell its outside: 0.06 degrees
/// off the surface. Below, the tool slid along it, and its centre of area tells.
pub const SIDEWAYS_MOTION_SHARE: f64 = 1e-3;

/// Sine of the angle by which the line between two contours on one triangle must lead behind the other surface to join them: six
/// degrees, above the turn of a chord on a curved surface. Smaller: contours on a bulge are one region; larger: shallow grooves are not.
pub const CONTOUR_LEAN: f64 = 0.1;

/// Most segments of one triangle that are compared with each other to join contours; of more an even sample is. Fewer: small
/// contours on a large triangle may stay regions of their own.
pub const MOST_SEGMENTS_COMPARED: usize = 256;

/// Most enclosed triangles that a fill finds, of each surface and in one part. What lies farther counts for depth only by its nearer
/// part, and such a plane is not certain. More: deep contacts of fine meshes take longer.
pub const MOST_FILLED: usize = 1 << 16;

/// Share of its distance from a segment up to which a vertex is on the plane of the other face, or in line with the segment; and
/// share of the distance or of the surface's length up to which a segment has no direction. Above rounding. Larger: more vertices are
/// on no side.
pub const ON_PLANE_SHARE: f64 = 1e-9;

/// Share by which the squares of two distances, or of two sines, of a vertex may differ and be equal: above rounding. Larger: more
/// vertices take the slower, careful path.
pub const EQUAL_SHARE: f64 = 1e-9;

/// Share of a vertex's distance up to which two nearest points are one point, an edge or vertex of the other surface. Larger: feet
/// of neighbouring edges are mixed up; smaller: rounding parts them.
pub const SAME_FOOT_SHARE: f64 = 1e-6;

/// Distance of the probe from such a point, as a share of the shortest edge there: near enough for its triangles to be the nearest, and
/// far above rounding.
pub const PROBE_SHARE: f64 = 1e-3;

/// Share of the longest side by which a solid's box is widened before what is outside it is outside the solid: above the rounding of
/// placed corners. Larger: fills leak farther before they are dropped.
pub const ENCLOSURE_SLACK: f64 = 1e-9;

// Proximity: planes between surfaces that are near and do not meet.

/// Share of the margin by which a pair may violate a plane and still be separated by it. Larger: fewer planes, which are as much
/// too far from what they stand for.
pub const SEPARATION_SLACK: f64 = 0.01;

/// Sine of the angle whose cosine is [`SAME_DIRECTION`]: how far a surface may turn away from a plane that stands for it.
pub const SAME_DIRECTION_SINE: f64 = 0.208;

/// Slope of the distance from which on a step to a neighbouring pair leads down: along a concave surface around the tool the distance
/// changes slowly, and each direction is to have its plane. Larger: more planes on slopes; smaller: fewer around the tool.
pub const DOWNHILL_SLOPE: f64 = 0.2;

/// Share of the margin up to which two pairs are equally near, and have one plane in the middle of all: above rounding. Smaller: the
/// point of a plane depends on the order of the pairs.
pub const EQUALLY_NEAR_SHARE: f64 = 1e-6;

/// Most pairs around a corner or edge that are searched for a step down. More: fans of slivers take longer; fewer: some have planes
/// that another place explains.
pub const MOST_PAIRS_AROUND_CORNER: usize = 256;

/// Share by which a pair around the same corner or edge may be farther than the pair that it is around: above rounding.
pub const AROUND_CORNER_SHARE: f64 = 1e-6;

/// Share of a pair's distance up to which a distance is 0, or a difference of two: above rounding.
pub const DISTANCE_NOISE: f64 = 1e-9;

/// One less the cosine of the angle up to which two pairs have one normal, and count for one plane: 4.5e-5 radians.
pub const SAME_NORMAL: f64 = 1e-9;

/// One less the cosine of the angle up to which a plane takes the normal of its triangle: 1.4e-5 radians. So normals of flat faces
/// do not depend on rounding. Larger: normals of finely curved surfaces are rounded to those of their triangles.
pub const SNAP_COSINE: f64 = 1e-10;

/// Rounding of the direction between the nearest points of a pair (radians), and of their coordinates (share of the largest, some
/// hundred roundings), which turns the direction the more the nearer they are. Where that is more, [`SNAP_COSINE`] widens by it.
pub const DIRECTION_NOISE: f64 = 1e-9;
pub const COORDINATE_NOISE: f64 = 1e-13;

/// Share of their distance by which the nearest point of a pair must be behind the other's triangle, and share of the margin by which
/// all of a triangle must, to be behind it: then it is near the surface, but not kept off by it. Above rounding; larger: what is just
/// inside a solid has planes.
pub const BEHIND_SHARE: f64 = 1e-3;
