//! Errors in a caller's arguments. Every message names the error, its place and a remedy.

/// An error in a caller's arguments, or the reason why a query stopped. Its message names the error, its place and a
/// remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A mesh without a single triangle.
    #[error("the {what} has no triangles: give at least one face")]
    EmptyMesh {
        /// "mock-up" or "tool".
        what: &'static str,
    },
    /// A mesh whose triangles are all defective.
    #[error("no triangle of the {what} can be queried, of {triangles} ({defects}): repair the mesh")]
    NothingToQuery {
        /// "mock-up" or "tool".
        what: &'static str,
        /// Triangles given.
        triangles: usize,
        /// Defect counts in words.
        defects: String,
    },
    /// More triangles, vertices or parts than 32-bit ids can name.
    #[error("{count} {what} is more than the {limit} that 32-bit ids can name: split the mesh")]
    TooMany {
        /// The thing counted.
        what: &'static str,
        /// How many there were.
        count: u64,
        /// The limit.
        limit: u64,
    },
    /// An array whose length does not match another.
    #[error("{what} has {got} entries where {expected} are needed")]
    Length {
        /// Which array.
        what: &'static str,
        /// Its length.
        got: usize,
        /// The length needed.
        expected: usize,
    },
    /// A requested part that does not exist.
    #[error("there is no part {part}: the mock-up has {parts} (0 to {last})", last = .parts - 1)]
    NoSuchPart {
        /// The part asked for.
        part: u32,
        /// Number of parts.
        parts: usize,
    },
    /// A number that no body has.
    #[error("there is no body {body}")]
    NoSuchBody {
        /// The body asked for.
        body: u32,
    },
    /// A part index past the last part.
    #[error("part_of_face[{face}] is {part}, but there are {parts} parts (0 to {last})", last = .parts - 1)]
    PartOutOfRange {
        /// The triangle.
        face: usize,
        /// Its part index.
        part: u32,
        /// Number of parts.
        parts: usize,
    },
    /// A pose with NaN, an infinity, or a translation beyond the coordinate limit.
    #[error("pose[{row}, {column}] is {value:?}: every entry must be finite and at most 1e100 in size")]
    PoseNotFinite {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// A pose whose matrix is not a rigid motion.
    #[error("the pose is not rigid: {why}; give a rotation without scale, shear or mirror")]
    PoseNotRigid {
        /// Which condition failed, and by how much.
        why: String,
        /// The most by which a condition fails: rows' lengths and right angles, the last row; 2 for a mirror.
        deviation: f64,
    },
    /// A tolerance of a cast that is not a positive finite number.
    #[error("tolerance is {value:?}: it must be a positive, finite length in metres")]
    Tolerance {
        /// The tolerance given.
        value: f64,
    },
    /// A screw with a number that is not finite or too large, or without an axis.
    #[error("{what} is {value:?}: it must be {must}")]
    Screw {
        /// "axis of the screw", "way of the slide", ...
        what: &'static str,
        /// The number given.
        value: f64,
        /// The condition that it violates.
        must: &'static str,
    },
    /// A path without a pose.
    #[error("the path has no pose: give at least one")]
    EmptyPath,
    /// A saved scene with a section that is missing, or that cannot be right.
    #[error("the saved scene is damaged: {what}; save it again")]
    DamagedScene {
        /// Which section, and what is wrong with it.
        what: String,
    },
    /// A voxel size that is not a positive finite number.
    #[error("voxel_size is {value:?}: it must be a positive, finite length in metres")]
    VoxelSize {
        /// The size given.
        value: f64,
    },
    /// A hashing level outside [0, 0.99].
    #[error("hashing is {value}: it must be between 0 (no memory saved) and 0.99")]
    Hashing {
        /// The level given.
        value: f64,
    },
    /// A hashing level with a store that does not hash.
    #[error("hashing is {value} but the storage is not 'hashed': leave hashing at 0 or choose storage='hashed'")]
    HashingUnused {
        /// The level given.
        value: f64,
    },
    /// A grid with more voxels along an axis than addresses allow.
    #[error(
        "a voxel size of {voxel_size:?} m cuts the mock-up into {cells:.3e} voxels along one axis; at most {limit} are \
         allowed: choose at least {least:.3e} m"
    )]
    GridTooFine {
        /// The size given, metres.
        voxel_size: f64,
        /// Voxels along the longest axis.
        cells: f64,
        /// The limit.
        limit: u32,
        /// The smallest size within the limit, metres.
        least: f64,
    },
    /// A structure that would need more memory than allowed.
    #[error("{what} would need {} bytes but {allowed} are allowed: {advice}", at_least(*needed))]
    Memory {
        /// The data to allocate.
        what: &'static str,
        /// Bytes it needs.
        needed: u64,
        /// Bytes allowed.
        allowed: u64,
        /// The remedy.
        advice: &'static str,
    },
    /// A table of pairs that says another thing of a pair than of the same pair the other way round.
    #[error("{what}[{row}, {column}] is {:?} and {what}[{column}, {row}] is {:?}: a pair has one limit", .values[0], .values[1])]
    NotSymmetric {
        /// Which table.
        what: &'static str,
        /// Row of the entry.
        row: usize,
        /// Its column.
        column: usize,
        /// The entry, and the one across.
        values: [f64; 2],
    },
    /// A distance that is negative or not a number.
    #[error("{what} is {value:?}: it must be a distance of 0 metres or more (infinity is allowed)")]
    Distance {
        /// Which argument.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// A margin of contacts that is negative, infinite or not a number.
    #[error("margin is {value:?}: it must be a finite distance of 0 metres or more")]
    Margin {
        /// The value given.
        value: f64,
    },
    /// A number of results of zero.
    #[error("{what} is 0: ask for at least one")]
    NoneAsked {
        /// Which argument.
        what: &'static str,
    },
    /// A ray with a number that is not finite or too large, or without a direction.
    #[error("{what}[{ray}] is {value:?}: {must}")]
    Ray {
        /// "origins" or "directions".
        what: &'static str,
        /// The ray.
        ray: usize,
        /// The entries given.
        value: [f64; 3],
        /// The requirement.
        must: &'static str,
    },
    /// A half space with a number that is not finite or too large, or without a normal.
    #[error("sections[{section}] is {value:?}: give a normal that is not zero and an offset, finite and at most 1e100 in size")]
    Section {
        /// The section.
        section: usize,
        /// Normal and offset given.
        value: [f64; 4],
    },
    /// A plane with a number that is not finite or too large, or without a normal.
    #[error("{what} is {value:?}: every entry must be finite and at most 1e100 in size, and a normal not zero")]
    Plane {
        /// "point" or "normal".
        what: &'static str,
        /// The entries given.
        value: [f64; 3],
    },
    /// A number of vertices that no piece for drawing can have.
    #[error("vertex_limit is {value}: a piece has 3 to 65535 vertices")]
    VertexLimit {
        /// The limit given.
        value: usize,
    },
    /// An error of a swept volume that is not a positive finite number.
    #[error("error is {value:?}: it must be a positive, finite length in metres")]
    SweptError {
        /// The error given.
        value: f64,
    },
    /// An error of a swept volume that is too small for the tool and its way.
    #[error("an error of {error:?} m would need {needed}: choose at least {least:.1e} m")]
    SweptTooFine {
        /// The error given, metres.
        error: f64,
        /// The memory needed, and the memory available.
        needed: String,
        /// An error that should fit, metres.
        least: f64,
    },
    /// The progress function asked to stop.
    #[error("stopped on request")]
    Cancelled,
    /// A list structure with more entries than 32-bit offsets can address.
    #[error("a voxel size of {voxel_size:?} m gives {} entries, more than 32-bit offsets hold: choose a larger one", at_least(*entries))]
    TooManyEntries {
        /// The size, metres.
        voxel_size: f64,
        /// Entries needed.
        entries: u64,
    },
}

/// A bound from below; the largest number stands for all beyond it.
fn at_least(count: u64) -> String {
    if count == u64::MAX {
        return "more than 2^64".into();
    }
    format!("at least {count}")
}

/// The core's result type.
pub type Result<T> = std::result::Result<T, Error>;
