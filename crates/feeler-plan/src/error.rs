//! Errors in a caller's arguments.

/// The problem, its place, and the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// From the engine below.
    #[error(transparent)]
    Core(#[from] feeler_core::Error),
    /// From the surroundings: the gripping tool is not free where it starts.
    #[error(transparent)]
    World(feeler_world::Error),
    /// A number that cannot be.
    #[error("{what} is {value:?}: {must}")]
    Option {
        /// Which.
        what: &'static str,
        /// As given.
        value: f64,
        /// The requirement.
        must: &'static str,
    },
}

impl From<feeler_world::Error> for Error {
    fn from(error: feeler_world::Error) -> Error {
        match error {
            feeler_world::Error::Core(error) => Error::Core(error),
            other => Error::World(other),
        }
    }
}

/// This crate's result type.
pub type Result<T> = std::result::Result<T, Error>;
