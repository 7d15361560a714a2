//! What can be wrong with what a caller passes in.

/// What is wrong, where, and what to do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// From the engine below.
    #[error(transparent)]
    Core(#[from] feeler_core::Error),
    /// What grips the part is not free where it starts.
    #[error("the tool's part {tool_part} meets part {part} where it starts: start it where it is free, or allow that part by name")]
    StartsInCollision {
        /// Of the tool.
        tool_part: u32,
        /// Of the mock-up.
        part: u32,
    },
    /// A number that cannot be.
    #[error("{what} is {value:?}: {must}")]
    Option {
        /// Which.
        what: &'static str,
        /// As given.
        value: f64,
        /// What is needed.
        must: &'static str,
    },
}

/// This crate's result type.
pub type Result<T> = std::result::Result<T, Error>;
