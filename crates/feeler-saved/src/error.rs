//! Why a scene could not be saved or opened.

use std::io;

/// The result of saving or opening.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a scene could not be saved or opened. Messages do not name the file: the caller knows it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file could not be read or written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The file is none that this crate has written.
    #[error("it is not a saved scene")]
    NotSaved,
    /// The file has another layout.
    #[error("it has layout {found}, and this version of feeler reads layout {expected}: save the scene again with this version")]
    Layout {
        /// The layout of the file.
        found: u32,
        /// The layout of this version.
        expected: u32,
    },
    /// The file ends too early, or goes on.
    #[error("it has {found} bytes where its header promises {promised}: it was cut off, or not copied completely; save or copy it again")]
    Length {
        /// Bytes of the file.
        found: u64,
        /// Bytes that its header promises.
        promised: u64,
    },
    /// A checksum does not match, or a number is out of range.
    #[error("it is damaged ({what}): save or copy it again")]
    Damaged {
        /// Where.
        what: String,
    },
    /// This machine has the other byte order.
    #[error("saved scenes are little endian, and this machine is big endian")]
    BigEndian,
    /// More sections than the table has room for, or a name that is too long or used twice.
    #[error("section {name:?} cannot be saved: {why}")]
    Section {
        /// Its name.
        name: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// An error of the core: work was stopped, or memory is short.
    #[error(transparent)]
    Core(feeler_core::Error),
}

impl From<feeler_core::Error> for Error {
    fn from(error: feeler_core::Error) -> Error {
        match error {
            feeler_core::Error::DamagedScene { what } => Error::Damaged { what },
            other => Error::Core(other),
        }
    }
}

pub(crate) fn damaged(what: impl Into<String>) -> Error {
    Error::Damaged { what: what.into() }
}
