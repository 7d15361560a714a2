//! Every tolerance and limit of the contacts, with its unit, its reason, and the effect of a change.

use feeler_lanes::WIDE_LANES;

/// Most planes of an answer.
pub const MOST_PLANES: usize = 32;

/// Deep planes up to which all that is near is searched: one for each degree of freedom of the tool. Beside more it matters less,
/// and searching it takes as long as all else, so the margin shrinks. More: slower where many planes are deep.
pub const FEW_DEEP: usize = 6;

/// Deep planes from which on nothing near is searched, and piercings have no plane: the margin shrinks to nothing between
/// [`FEW_DEEP`] and this. More: slower where many planes are deep.
pub const MANY_DEEP: usize = 12;

/// Most near pairs of triangles: with more the margin is halved, and surfaces a little farther than the nearest get no
/// planes. Two fine surfaces one in the other are all near, each triangle to thousands.
pub const MANY_NEAR: usize = 1 << 20;

/// Near pairs that are put in the order of their bounds at once. More: longer sorting, of pairs that are never measured; fewer: the rest
/// is gone through more often.
pub const SORTED_AT_ONCE: usize = 2048;

/// Measured pairs that are put in their places one by one; more are sorted with all others, which takes longer where they are few.
pub const FEW_FRESH: usize = 4 * WIDE_LANES;

/// Points up to which a hull is found of all of them; of more, those well within are left out first, which costs as much as some
/// twenty points in order.
pub const FEW_FEET: usize = 24;

/// Most halvings of the margin towards [`MANY_NEAR`]: down to a thousandth, after which all pairs are taken, however many.
pub const MOST_MARGIN_HALVINGS: usize = 10;

/// Least that halving leaves of the margin, as a multiple of the least distance, so that the nearest surfaces keep
/// their planes.
pub const LEAST_MARGIN_OVER_NEAREST: f64 = 1.05;

/// Number of colliding pairs from which coinciding triangles are sought: that costs less than a tenth of the rest.
pub const MANY_PAIRS: usize = 1 << 16;

/// Most pairs of triangles after which a query's working memory is kept for the next, since it grows with them. Moves memory only.
pub const MOST_PAIRS_KEPT: usize = 1 << 16;

/// Cosine of the angle within which planes of flat-faced bodies of one region are one: half a degree, above the rounding of normals.
pub const SAME_PLANE: f64 = 0.999_96;

/// Cosine of the angle between a plane and the best face axis of other bodies up to which it may dominate them: 25 degrees. Wider:
/// fewer planes and less time, and curved surfaces have planes in fewer directions.
pub const DOMINATED_COSINE: f64 = 0.9063;

/// Cosine of the angle within which planes of curved or hollow surfaces are one: 12 degrees. Wider: fewer planes.
pub const SAME_DIRECTION: f64 = 0.978;

/// Share by which a later axis must be shallower to be preferred: above rounding, so that ties always fall to normals of the
/// mock-up. Smaller: normals may flicker between poses.
pub const SHALLOWER: f64 = 1e-6;

// Contours: segments, sides of vertices, and enclosed regions.

/// Sine of the angle between two triangles up to which they lie in one plane: rounding then decides where their common line is, and
/// they share a polygon. Larger: thin wedges share a polygon where they share a segment.
pub const PARALLEL_SINE: f64 = 1e-9;

/// One less the cosine of the angle between two triangles up to which their segment is flat and has no side: 1.4e-6
/// radians. Larger: more vertices at grazing contours have no side; smaller: rounding decides it.
pub const COPLANAR_COSINE: f64 = 1e-12;

/// Most triangles that the search for the normal of a thin one visits. Fewer: in wider strips of slivers normals are noise.
pub const MOST_THIN_NEIGHBOURS: usize = 16;

/// Share of the tool's displacement since the reference that must come out of a closed surface, along its normal, for the tool to
/// have gone in on the other side: 30 degrees off the surface. Smaller: sliding along the surface is taken for it; larger: thin plates
/// must be pierced more steeply.
pub const CAME_THROUGH_SHARE: f64 = 0.5;

/// Share of the displacement since the reference that must be along the normal of an open surface to define its
/// outside: 0.06 degrees off the surface. Below that the tool slid along it, and its centre of area decides.
pub const SIDEWAYS_MOTION_SHARE: f64 = 1e-3;

/// Sine of the angle by which the line between two contours on one triangle must lead behind the other surface to join them: six
/// degrees, above the turn of a chord on a curved surface. Smaller: contours on a bulge are one region; larger: shallow grooves are not.
pub const CONTOUR_LEAN: f64 = 0.1;

/// Most segments of one triangle that are compared with each other to join contours; of more an even sample is. Fewer: small
/// contours on a large triangle may stay regions of their own.
pub const MOST_SEGMENTS_COMPARED: usize = 256;

/// Most enclosed triangles that a fill finds, of each surface and in one part. Triangles beyond count for depth only by
/// the nearer part. More: deep contacts of fine meshes take longer.
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

/// Share of the longest side by which a solid's box is widened, so that points outside it are outside the solid: above
/// the rounding of placed corners. Larger: fills leak farther before they are dropped.
pub const ENCLOSURE_SLACK: f64 = 1e-9;

// Proximity: planes between surfaces that are near and do not meet.

/// Share of the margin by which a pair may violate a plane and still be separated by it. Larger: fewer planes, with a
/// larger error of their distance.
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

/// Share of their distance by which the nearest point of a pair must be behind the other's triangle, and share of the
/// margin by which all of a triangle must, to be behind it: such a triangle is near the surface, but not stopped by it.
/// Above rounding; larger: points just inside a solid get planes.
pub const BEHIND_SHARE: f64 = 1e-3;

// Patches and convex bodies.

/// Most patches of one surface in a contact region, before patches that are not connected are split. Further smooth
/// regions join the patch with the nearest normal. The half-space tests compare all patches with all: twice as many
/// take four times as long; with fewer, finely curved surfaces are resolved less.
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
/// registers of eight float64. Depths of bodies with more facets may not be the least.
pub const MOST_NORMALS: usize = 3 * WIDE_LANES - 1;

/// Most pairs of an edge of one body and an edge of the other, an edge being any two facets, whose cross products are
/// all tried. Beyond, the least depth is searched for by arcs and descent, and may not be found.
pub const MOST_EDGES: usize = 100;

// Depth: the axis of least depth of two bodies.

/// Share of the largest size or coordinate of two bodies below which two depths count as equal: some thousands of
/// roundings. Smaller: rounding chooses among axes of a touch.
pub const DEPTH_NOISE: f64 = 1e-12;

/// Difference of sums of cosines by which surfaces must face another axis less for it to be preferred where they only touch: above
/// rounding. Smaller: the normal of a touch may flicker.
pub const FACING_NOISE: f64 = 1e-6;

/// An axis leads in where its cosine to a body's mean normal is at most the negative of this: half a degree beyond perpendicular, so
/// that bodies may be moved along their faces. Larger: more axes are tried, some of which lead in.
pub const AGAINST_NORMAL: f64 = 0.01;

/// Length of a mean of unit normals, up to which they cancel out: the sides of a shaft all around face nowhere, and what is left of
/// their sum is rounding. Larger: surfaces that face mostly to one side lose the side that leads out. Smaller: half of the axes of a
/// shaft in its hub lead in by chance.
pub const CANCELLED_MEAN: f64 = 0.01;

/// Sine of the angle from which on a surface rises along an axis beyond the contour: three degrees, above the turns of flat faces.
/// Smaller: nearly flat surfaces block axes that free the tool.
pub const BLOCKING_SINE: f64 = 0.05;

/// Share of the depth below a support within which a point of the contour counts as extreme, and may block the axis.
pub const BLOCKING_SHARE: f64 = 1e-6;

/// How far a face must rise above that to block, in the same tolerance: more than its own edge may by rounding.
pub const BLOCKING_RISE: f64 = 3.0;

/// Cosines between the normals of two facets whose arc on the Gauss map is searched. Opposite faces have no edge (120 degrees and
/// more), and nearly equal ones no arc to speak of (18 degrees and less).
pub const ARC_COSINES: std::ops::Range<f64> = -0.5..0.95;

/// Most spans of arcs at a time: about ten for each arc of two bodies. Fewer: depths on long edges get larger.
pub const MOST_ARC_SPANS: usize = 64;

/// Most times that eight axes on arcs are tried; few arcs need as many. Fewer: depths on long edges get larger.
pub const MOST_ARC_ROUNDS: usize = 6;

/// Share by which a depth on an arc may be above its lower bound and count as the least there.
pub const ARC_BOUND_SHARE: f64 = 1e-6;

/// Most axes tried by a descent. Fewer: depths of curved surfaces get larger, and contacts faster.
pub const MOST_DESCENT_STEPS: usize = 24;

/// Length of a descent's step after one that led nowhere, as a share of that.
pub const DESCENT_STEP_RATIO: f64 = 0.6;

/// Length of a descent's last step (radians, about): half a degree.
pub const SHORTEST_DESCENT_STEP: f64 = 0.01;

/// Share of the depth within which points count as extreme for the gradient: an edge or a face counts as a whole. Smaller: the
/// descent zigzags across edges.
pub const DESCENT_EXTREME_SHARE: f64 = 0.02;

/// Share of the depth within which points count as extreme for the contact point. Moves that point only.
pub const POINT_SHARE: f64 = 1e-3;

/// Sine of the angle between a triangle and an axis up to which it is seen edge-on and does not count for an overlap: its neighbours
/// have that edge too.
pub const EDGE_ON_SINE: f64 = 1e-3;

/// Most pairs of triangles that an overlap is measured over. With more, bodies count as overlapping by their depth.
pub const MOST_OVERLAP_PAIRS: usize = 1 << 22;

/// Most times that a triangle is clipped against eight others for one overlap. Likewise.
pub const MOST_OVERLAP_CLIPS: usize = 1 << 14;

/// Share of the greatest overlap so far by which another must exceed it to be evaluated. Overlaps are too small by at
/// most that.
pub const OVERLAP_GAIN: f64 = 1e-3;

/// The same, as a share of an overlap that is enough: above rounding.
pub const OVERLAP_NOISE: f64 = 1e-9;

/// Share of a triangle's height over an edge by which a point beyond that edge counts as on it: above rounding.
pub const ON_EDGE_SHARE: f64 = 1e-9;

/// Share of the depth from which on an overlap counts as all of it. Larger: more planes are overlaps, and more overlaps are measured.
pub const FILLED_SHARE: f64 = 0.9;

/// Share of [`FILLED_SHARE`] from which on an overlap is searched first. Moves time only.
pub const FIRST_OVERLAP_SHARE: f64 = 0.75;

// Escape: the translation that frees the tool.

/// Share by which the translation exceeds the one of the planes, so that the tool ends off the surface and not on it.
pub const ESCAPE_EXCESS: f64 = 1e-6;

/// Share of the largest coordinate by which the tool ends off the surface at least: about ninety roundings, for those of a placed corner.
pub const ESCAPE_ROUNDING: f64 = 1e-14;

/// Least cosine between the translation and a plane that it leaves: bounds by how much it is lengthened for a plane at grazing angle.
pub const LEAST_ESCAPE_LEAN: f64 = 0.01;

/// Most times that planes of the pose reached are added, and most planes left out. More: shorter translations, and slower.
pub const MOST_ESCAPE_ROUNDS: usize = 8;

/// Most planes that a translation is searched over; the tightest are kept. All threes of them are tried: 17,000.
pub const MOST_ESCAPE_PLANES: usize = 48;

/// One less the cosine of the angle within which two of these planes are parallel, and only the tighter is kept: 0.003 degrees.
pub const PARALLEL_ESCAPE_PLANES: f64 = 1e-9;

/// Share by which a translation without one of the planes must be shorter to be preferred.
pub const LEFT_OUT_SHORTER: f64 = 1e-3;

/// Share of the largest distance by which a least-norm point may violate a plane: above rounding.
pub const MIN_NORM_SLACK: f64 = 1e-9;

/// Share by which a later point must be shorter to be preferred, so that ties fall to the fewest planes.
pub const MIN_NORM_SHORTER: f64 = 1e-12;

/// Least squared sine between two planes, and least determinant of three, that have a point in common: nearly parallel ones have
/// theirs far away, and rounding decides where.
pub const LEAST_PAIR_DETERMINANT: f64 = 1e-9;
pub const LEAST_TRIPLE_DETERMINANT: f64 = 1e-6;

/// Rounds of relaxation over planes that no translation satisfies. Moves an estimate only.
pub const RELAXATION_ROUNDS: u32 = 64;

/// First length probed along each axis, as a share of the longest, and the growth of each next one. Finer: shorter
/// escapes are found before longer ones, and slower.
pub const PROBE_FIRST_SHARE: f64 = 1.0 / 1024.0;
pub const PROBE_GROWTH: f64 = 1.5;

/// Bisections between a length that frees the tool and one that does not: to 0.4 % of their difference.
pub const PROBE_HALVINGS: usize = 8;

/// Share of the longest at and below which no shorter length is searched: less than any part is made to. Where surfaces only touch
/// there always is a shorter one.
pub const LEAST_PROBE_SHARE: f64 = 1e-9;

/// Share by which the length along another axis must be shorter to be preferred.
pub const PROBE_OTHER_SHORTER: f64 = 0.002;

/// By how much the best axis is turned (tangent of the angle) to find a shorter length: 27 to 3 degrees.
pub const PROBE_TURNS: [f64; 4] = [0.5, 0.25, 0.12, 0.06];

/// Most times that it is turned by each.
pub const MOST_PROBE_TURNS: usize = 8;

/// Share by which the length along a turned axis must be shorter: each costs several exact queries.
pub const PROBE_TURNED_SHORTER: f64 = 0.02;

/// Growth of the number of nearest parts requested, until a wanted one is among them. Affects only time.
pub const NEAREST_PARTS_GROWTH: usize = 8;

// Footing: the points of the tool that carry a contact.

/// Most points of a footing: three define a plane, the fourth fits most parts.
pub const MOST_FOOTING: usize = 4;

/// Most points of a contact manifold: a round face has as many around it that they stand out by a few per cent of its radius.
/// More: rounder, and as much slower.
pub const MOST_MANIFOLD_POINTS: usize = 12;

/// The turn (radians) up to which a manifold's points keep the tool off: the most that a hand turns in a millisecond or
/// two. Larger: includes surfaces that lean away from the plane, and keeps the tool off surfaces it could turn to.
pub const MANIFOLD_TURN: f64 = 0.004;

/// Corners around which a polygon is cut into triangles to find the height over a place. More: nearer to the hull of its corners.
pub const MOST_FANS: usize = 4;

/// Least barycentric coordinate of a place that is in a triangle: above rounding.
pub const ON_BORDER: f64 = 1e-9;

/// The same of one so little beyond a polygon that the nearest triangle's plane is taken to go on there: above what a clip is widened.
pub const JUST_BEYOND: f64 = 0.01;

/// Most contact manifolds of a pose: two rounds of a hole, a plane every dozen degrees. More of them are within the margin only
/// where all around is something, and then the nearest hold the tool.
pub const MOST_MANIFOLDS: usize = 64;

/// The turn (radians) up to which a footing off a plane keeps the tool off: one degree, far more than a tool turns
/// between two answers of a control loop. Larger: footings of curved surfaces are wider than the contact.
pub const FOOTING_TURN: f64 = 0.017_453_292_519_943_295;

/// Directions around the normal along which the lowest points are sought: between two of them a point of a round surface may be
/// lower by 1 - cos(180 / 64 degrees) of its distance from the middle, an eighth of a per cent.
pub const FOOTING_DIRECTIONS: usize = 64;

/// Share of the tool's length by which a body may be beyond a plane and still end at it: the rounding of the plane.
/// Larger: takes surfaces in each other's hollows for surfaces that end at their plane.
pub const FOOTING_OFF: f64 = 1e-6;

/// Share of the tool's length by which the carried area is sought beyond the border of the carrying one, so that edges
/// and corners of both touch.
pub const FOOTING_WIDER: f64 = 1e-6;

/// Share of a footing's size up to which two of its points are one, and one in line with two others: well below the per cent that a
/// footing may leave undone.
pub const FOOTING_MERGED: f64 = 2e-3;

/// Share of the tool's length by which a point of a footing may be below the plane: what a round surface sags within a footing's
/// turn. A point that is lower pushes the tool away before it touches.
pub const FOOTING_LOW: f64 = 1e-4;

/// Triangles of a body that are evaluated always, even if the area found so far is not over the other surface. With
/// fewer, contacts beside the triangle of the contact are lost.
pub const FOOTING_FEW_ASKED: usize = 64;

/// Most triangles of a body that are evaluated: beyond, the area found by then carries. More takes longer.
pub const FOOTING_MOST_ASKED: usize = 1 << 14;

// Parts of a mock-up against each other.

/// Face normals of each of two parts along which a way out is looked for where contact planes show none. More: shorter ways out of round
/// parts; as many times all corners are looked at.
pub const MOST_FACE_NORMALS: usize = 32;

/// Faces of each whose normals are looked at. More takes as long as it finds more directions.
pub const FACES_SAMPLED: usize = 256;

/// The cosine from which on two face normals count as one there: about eight degrees.
pub const SAME_FACE_NORMAL: f64 = 0.99;

// Depth by points.

/// Share of a depth that its upper bound may be more. Smaller: more pieces.
pub const DEPTH_ERROR: f64 = 0.9e-3;

/// The same for depths of nearly nothing, metres.
pub const LEAST_DEPTH_ERROR: f64 = 0.9e-9;

/// Most nodes and pieces that a search for the farthest point looks at: some seconds. It then gives the bounds that it has.
pub const MOST_PIECES: usize = 1 << 21;

/// Share of a body's size that points computed on its surface may be off by: eight roundings. Larger: thinner slivers of surface
/// count as nothing.
pub const BODY_ROUNDING: f64 = 1.0 / (1u64 << 50) as f64;

/// The most by which the rounding of its coordinates may move a surface, in units of the last place of the largest:
/// surfaces nearer than that lie on each other. At most half of the distance that counts as contact.
pub const SURFACE_ROUNDOFFS: f64 = 6.0;

/// Share of its longest side below which the height of a triangle makes it a sliver, whose normal is left to rounding. Larger: distances
/// to needles are more by up to that share of their length.
pub const SLIVER_HEIGHT: f64 = 1e-10;

/// Most triangles of parts that are kept as bodies, of about 130 bytes each: 550 MB; two of the largest part are always kept. Fewer: parts
/// are prepared again.
pub const MOST_KEPT_TRIANGLES: usize = 1 << 22;

/// Cosine of the angle between the faces of a thin wall from which on they look opposite ways: 154 degrees. Larger: blunter edges are
/// walls.
pub const OPPOSITE_FACES: f64 = -0.9;

/// How far the search for faces around a needle reaches, as a multiple of the largest thickness allowed. A triangular section with a
/// corner of 26 degrees needs 2.7. Smaller: needles of flat section are missed.
pub const NEEDLE_REACH: f64 = 3.0;

/// How many rays look for the faces around a needle. Fewer: faces of needles with many sides are missed.
pub const NEEDLE_RAYS: u32 = 16;

/// The most that points of a line that are looked at for needles are apart, as a share of the largest thickness allowed. Larger: needles of
/// which few points show that they are needles are missed.
pub const NEEDLE_STEP: f64 = 0.125;

/// How many of them there are at most in a row. Fewer: very thin needles are missed in long lines, as where a needle lies on a wall.
pub const MOST_NEEDLE_POINTS: f64 = 1024.0;

/// Share of half a wall's thickness from which on a point is in the middle of it; below 1 by more than the error of depths.
pub const WALL_MIDDLE: f64 = 0.98;

/// Sine of the angle between two triangles of open surfaces below which they do not cross, as nearly in one plane. Smaller: rounding
/// decides where they cross.
pub const LEAST_CROSSING_SINE: f64 = 1e-6;

/// Most points where two open surfaces cross that are measured. Smaller: crossings of fine surfaces may be told too shallow.
pub const MOST_CROSSING_POINTS: usize = 2048;

/// Most triangles that a walk over an open surface goes through.
pub const MOST_CROSSING_STEPS: usize = 4096;

/// How many roundings beyond each other the edges of walls have to go to cross: flush faces of parts that are turned and far from the origin
/// differ by several.
pub const FLUSH_ROUNDINGS: f64 = 4.0;

/// Share of the depth of a point in the middle of a wall by which walls side by side are looked at farther in; below 1. Larger: two walls
/// have to overlap farther.
pub const SIDE_STEP: f64 = 0.5;

/// The multiple of `contact` that walls side by side share of their thickness to clash; above 1 by more than the error of depths.
pub const SIDE_EXCESS: f64 = 1.0 + 2e-3;

/// Share of a body's size above which a gap is no seam: twice that within which the topology closes seams. Larger: gaps at cracks count
/// as loose seams.
pub const WIDEST_SEAM: f64 = 4e-6;

/// The multiple of the gaps in its seams by which what a body contains may stick out of it; the depth has to be this many times more.
pub const SEAM_EXCESS: f64 = 4.0;

/// How far below a surface, in the distance within which copies count as one, a point is looked for that is in both. Larger: copies of
/// thinner walls are not found.
pub const COPY_STEP: f64 = 1.25;

/// How far that point has to be from the surface, likewise: above 1, so that it is on the same side of the other surface.
pub const COPY_DEPTH: f64 = 1.125;
