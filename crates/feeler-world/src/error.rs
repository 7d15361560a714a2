//! Errors when parts are gripped, put down and put back.

/// The problem, its place, and the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// From the engine below.
    #[error(transparent)]
    Core(#[from] feeler_core::Error),
    /// The gripping tool is not free where it starts.
    #[error("the tool's part {tool_part} collides with part {part} at the start: start it where it is free, or allow that part by name")]
    GripMeets {
        /// Of the tool.
        tool_part: u32,
        /// Of the mock-up.
        part: u32,
    },
    /// A second grip.
    #[error("the tool holds part {part} already: release it first")]
    HoldsAlready {
        /// The part that it holds.
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
}

/// Of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
