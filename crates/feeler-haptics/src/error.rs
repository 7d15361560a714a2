//! Errors in a caller's arguments, and failures of a device.

/// The problem, its place, and the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// From the engine below.
    #[error(transparent)]
    Core(#[from] feeler_core::Error),
    /// A step before the start, or a grip.
    #[error("the session has no proxy yet: call start() first")]
    NotStarted,
    /// From gripping a part, putting it down or putting it back.
    #[error(transparent)]
    World(feeler_world::Error),
    /// A wish to a run that has ended.
    #[error("the run has ended: start another")]
    Ended,
    /// A thread of a run died by a fault in this program. The force was released first.
    #[error("the {thread} thread of the run failed, and the force was released: start a new session, and report this")]
    Panicked {
        /// Which: `servo` or `collision`.
        thread: &'static str,
    },
    /// The driver of the device failed and does not go on, which ended the run. It was asked to release the force first.
    #[error("{why}; the driver was asked to release the force, and the run ended: fix the driver, and run again")]
    Device {
        /// The device, and the reason.
        why: String,
    },
    /// The system gave no thread.
    #[error("no thread for the run: {why}")]
    Thread {
        /// The system's message.
        why: String,
    },
    /// An option that is out of its range.
    #[error("{what} is {value}, but must be {range}")]
    Option {
        /// Which.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Its range, in words.
        range: &'static str,
    },
}

impl From<feeler_world::Error> for Error {
    fn from(error: feeler_world::Error) -> Error {
        match error {
            feeler_world::Error::Core(error) => Error::Core(error),
            error => Error::World(error),
        }
    }
}

/// Of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
