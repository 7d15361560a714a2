//! What can be wrong with what a caller passes in, and what a device may fail at.

/// What is wrong, where, and what to do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// From the engine below.
    #[error(transparent)]
    Core(#[from] feeler_core::Error),
    /// The tool meets the mock-up where a session is to start.
    #[error("the tool starts in collision: start it where it is free, or along the way out")]
    StartsInCollision,
    /// A step before the start, or a grip while there is no proxy.
    #[error("the session has no proxy yet: call start() at a pose where the tool is free")]
    NotStarted,
    /// A second grip.
    #[error("the tool holds part {part} already: release it first")]
    HoldsAlready {
        /// What it holds.
        part: u32,
    },
    /// A release without a grip.
    #[error("the tool holds no part: grip one first")]
    HoldsNothing,
    /// A part cannot be put back since the tool is in its place.
    #[error(
        "part {part} cannot go back, the tool is in its place: move the tool away, or release the part where it is"
    )]
    PlaceIsTaken {
        /// Which.
        part: u32,
    },
    /// A part cannot be put back since the scene was given without it.
    #[error("part {part} has no place to go back to: the scene was given without it. Release it where it is")]
    HasNoPlace {
        /// Which.
        part: u32,
    },
    /// A part that is put down elsewhere twice, or as a scene that is not of one part.
    #[error(
        "part {part} is put down twice, or as a scene of {parts} parts: give it once, as a scene of that part alone"
    )]
    PutDown {
        /// Which.
        part: u32,
        /// Of its scene.
        parts: usize,
    },
    /// A wish to a run that has ended.
    #[error("the run has ended: start another")]
    Ended,
    /// A thread of a run died by a fault in this program. The force was let go first.
    #[error("the {thread} thread of the run failed, and the force was let go: start another session, and report this")]
    Panicked {
        /// Which: `servo` or `collision`.
        thread: &'static str,
    },
    /// The system gave no thread.
    #[error("no thread for the run: {why}")]
    Thread {
        /// What the system said.
        why: String,
    },
    /// An option that is out of its range.
    #[error("{what} is {value}, but must be {range}")]
    Option {
        /// Which.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it may be, in words.
        range: &'static str,
    },
}

/// Of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
