//! Every limit and tolerance of this crate: its unit, the reason for its value, and the effect of a change.

// What may touch.

/// Bodies nearer than this (metres) touch; it is also the tolerance of casts. Above rounding in a mock-up of a
/// kilometre, and far below manufacturing tolerances. Larger: casts end earlier, and more flush faces count as seated.
pub const TOUCH: f64 = 1e-6;

/// Play of touching seats, metres: how much deeper they may get. Above rounding, below machining tolerances. Larger: slides end less often
/// by rounding.
pub const FLUSH_PLAY: f64 = 1e-6;

/// How far a seated pair that is in each other may go deeper, or leave its place, metres: facets of curved surfaces differ by as much.
/// Verified, a pair may be that much deeper between two looks. Larger: parts are drawn through bumps of that height; smaller: paths along
/// surfaces that are looked at take more looks.
pub const SEAT_TOLERANCE: f64 = 1e-5;

/// The depth of a fit is found to this factor. Less: it may go less deeper than it was, and takes longer to find.
pub const EROSION_SHARE: f64 = 1.07;

/// The depth of a fit is first sought in steps by this factor. Larger: thin sheets in contact count as sunk; smaller: it takes longer.
pub const EROSION_STEP: f64 = 4.0;

/// Most times that a part is made smaller to find which of its surfaces are less deep than the deepest. Fewer: those of parts with many
/// surfaces get its play.
pub const MOST_EROSIONS: usize = 48;

/// Cosine from which on two faces at a corner are one: 1.4 mrad. Less: facets of smooth surfaces count as one, and move by less.
pub const FACE_ANGLE_COS: f64 = 0.999_999;

/// How far a corner moves at most where its faces move by 1: four times, as at an edge of 29 degrees. Larger: knives shrink by more of their
/// edge.
pub const LONGEST_MITRE: f64 = 4.0;

/// Added to the squares of normals when a corner's way is found: the square of it is above rounding, as a corner within a flat face needs,
/// whatever way the face is turned. Larger: facets at angles of milliradians move by less than they should.
pub const MITRE_ADDED: f64 = 1e-5;

/// A corner moves with all faces at it where each goes inwards by this share of what it should. Larger: corners are split that move almost
/// as they should.
pub const LEAST_INWARDS: f64 = 0.5;

/// Angle (radians) about an edge up to which faces of several solids coincide: above the rounding of files. Larger: thin wedges of one
/// solid are mixed up with those of another.
pub const SAME_FACE_ANGLE: f64 = 1e-5;

/// Most concave edges at a vertex at which its corner is split. More: noise in scans is split, which takes long.
pub const MOST_ARCS: usize = 32;

/// How far before the end of its play a seated part stops along its way, metres: an eighth of `FLUSH_PLAY`. Smaller: motions that start
/// there may be blocked.
pub const SEAT_REST: f64 = 1.25e-7;

/// Tolerance of casts of seats, metres: a hundredth of [`SEAT_REST`]. Larger: motions that begin there end at once.
pub const SEAT_CAST: f64 = 1.25e-9;

/// Depth at the start, in lengths of the tool, up to which a pair is a fit, such as a press fit: it may be as deep on
/// its whole way. A deeper pair has no hole, and is pulled out of the volume that it fills. Larger: thicker walls are
/// passed through sideways.
pub const FIT_DEPTH: f64 = 0.02;

/// How far a part that goes through a neighbour is moved against a contact plane, in lengths, to see whether that is a
/// way out of its volume: past the play of that volume, up to the thickness of most heads. More and other values: heads
/// of other thickness are recognised.
pub const THROUGH_TRIALS: [f64; 3] = [0.03, 0.06, 0.12];

/// Faces whose normals are this near to such a way lead on it (cosine). Less: the sides of a bolt, which only slide, count too.
pub const LEADING_COS: f64 = 0.3;

/// Cosine between a contact plane's normal and such a way from which on it is that way: ten degrees. Less: other planes are left out with
/// it.
pub const THROUGH_COS: f64 = 0.985;

/// Contact planes less deep than this share of the pair's depth at the start are ignored: a part that has almost left its place overlaps in
/// slivers, whose planes point anywhere. Larger: a part may be pushed so deep into another place.
pub const SLIVER_DEPTH: f64 = 0.25;

/// How far a part pulled out of its volume may come outside of it, in lengths of the part: the height of a thread's
/// ridges. Larger: parts without a hole may lean more on their way out.
pub const PLACE_SHARE: f64 = 0.02;

/// How far beyond that the neighbour's surface may still be looked at, as a share of it, instead of being cast. Smaller: it is cut into more
/// pieces.
pub const BEYOND_GRAIN: f64 = 0.5;

/// Most planes of a neighbour's faces at which a triangle of a sunk part is cut, to find what of it is in the neighbour. Fewer: more is cut
/// at its middle, until it is small.
pub const MOST_CUTS: usize = 4;

/// Points no farther than this from a plane, metres, are in it: above rounding in a mock-up of a kilometre. Larger: the part of a
/// surface that counts as inside a neighbour ends this far from the neighbour's surface.
pub const SAME_PLANE: f64 = 1e-9;

/// Most pieces that a surface is cut into to find what lies beyond a place. Fewer: more of a surface that is near a large place all
/// over is looked at.
pub const MOST_BEYOND_PIECES: usize = 100_000;

/// How far before what a sunk part meets beyond its place it ends, metres: it is cast smaller by [`FLUSH_PLAY`], and would be in it by that.
/// Larger: it ends farther off; smaller: where it comes to a slanting surface, or turns, it ends at the last look before.
pub const BEYOND_REST: f64 = 4.0 * FLUSH_PLAY;

/// Most triangles of the tool times crossings of surfaces that are tested at a step. Fewer: large parts get fewer
/// tests.
pub const MOST_CROSSING_WORK: usize = 20_000;
/// Least crossings looked at, however large the tool is.
pub const LEAST_CROSSINGS: usize = 8;

/// Steps at which seated pairs are measured while the tool moves by its own length. More: thinner ribs within a seat are seen, and it
/// takes longer.
pub const STEPS_A_LENGTH: f64 = 32.0;

/// The longest of these steps, in mean thicknesses of the tool: half, so that it is measured within whatever it passes. Larger: thin parts
/// are drawn through walls.
pub const STEP_THICKNESS: f64 = 0.5;

/// Most of these steps while the tool moves by its own length, however thin it is. More: sheets thinner than this are measured as often as
/// they need it, and take longer.
pub const MOST_STEPS_A_LENGTH: f64 = 2048.0;

/// Where the first sample of a motion is, in depths that the tool is sunk: there a motion against the contact plane has not passed it.
/// Larger: it may have.
pub const FIRST_SAMPLE: f64 = 0.5;

/// Times as many steps where a way is verified.
pub const VERIFY_FINER: f64 = 2.0;

/// Share of a clearance by which a way may come nearer: where less is left above it, the next step is that long.
pub const CLEARANCE_SLACK: f64 = 0.02;

/// The least distance along a way is refined to this share of the tool's length, or to the next of itself, whichever is more.
pub const CLEARANCE_STEP: f64 = 1.0 / 64.0;
/// See above. Smaller: a query more for each share of the tool's length.
pub const CLEARANCE_SHARE: f64 = 0.05;

/// How far beyond the box of the mock-up the tool is out, as a share of its length.
pub const EXIT_MARGIN: f64 = 0.01;

// Surfaces.

/// Faces whose unit normals round to the same multiples of this, and whose planes are as far from the origin in multiples of
/// [`PLANE_OFFSET`], are in one plane. Larger: faces beside each other that differ count as one.
pub const PLANE_NORMAL: f64 = 1e-5;
/// Metres; see above.
pub const PLANE_OFFSET: f64 = 1e-6;

/// Triangles whose angle is smaller than this (radians) are one flat face: above rounding of single precision, below
/// the facets of a circle of 6,000 sides. Larger: fine facets count as flat, and a fillet made of them joins the floor.
pub const FLAT_ANGLE: f64 = 1e-3;

/// Cosine of the largest angle between facets of one curved surface: 31 degrees, so that a cylinder of twelve sides is one. Less: more
/// such angles are edges.
pub const CURVED_ANGLE_COS: f64 = 0.857;

/// Facets of one curved surface are alike in area up to this ratio. Larger: a coarse fillet joins floor and wall.
pub const MOST_AREA_RATIO: f64 = 4.0;

/// Most samples of a sunk part's surface that have to stay within its place while they are inside the neighbour. More: it takes longer.
pub const MOST_PLACE_SAMPLES: usize = 12;

/// Most corners of a sunk part that have to stay within its place too: a tilt takes corners out first. More: it takes longer.
pub const MOST_PLACE_CORNERS: usize = 12;

/// How far a corner's sample is from it, as a share of the way to the middle of its triangle: off the planes of faces that are flush with
/// the neighbour's. Larger: corners come out by more.
pub const CORNER_SHARE: f64 = 0.005;

/// Most triangles of a tool from which rays look for such samples. More: smaller faces are seen, and a start takes longer.
pub const MOST_SAMPLE_RAYS: usize = 1024;

/// Most points of a sunk part's surfaces that are flush with its neighbour's, which hold these from going in. More: it takes longer.
pub const MOST_FLUSH_POINTS: usize = 12;

/// The same where they are face to face: the edges of a tilted head go deeper between its points. More: it takes longer.
pub const MOST_BEARING_POINTS: usize = 24;

/// Most such points that are tried. More: smaller surfaces are seen, and a start takes longer.
pub const MOST_FLUSH_TRIED: usize = 4096;

/// How far the rim of a pocket may be out of a plane, as a share of the tool's size. Larger: rims of domed heads count, too, and what
/// lies behind a bent edge may be taken for a pocket.
pub const MOUTH_FLATNESS: f64 = 1e-4;

// Seats for control loops.

/// Most crossings that hold a sunk part in its place. More: it is held at more points, and each takes a row of the program.
pub const MOST_PLACE_ROWS: usize = 24;

// Guarded moves.

/// A guarded move that would end within this distance (metres) of its start treats its contacts as seats, since
/// rounding decides which way is free. Larger: more moves along a near surface take the time of seats.
pub const STUCK: f64 = 1e-9;

/// Contact planes within this distance (metres) may have stopped the tool: more than it stays off them. Larger: it
/// costs more, and a plane farther off may be named.
pub const IMPACT_MARGIN: f64 = 2e-5;
