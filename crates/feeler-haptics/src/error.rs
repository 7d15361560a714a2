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
