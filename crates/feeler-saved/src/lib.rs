//! Saved scenes: a mock-up, its index, and what first queries need, in one file that is mapped when it is opened.
//!
//! [`save`] writes the file beside its place and renames it; [`open`] maps it and gives a scene on the mapping. Nothing is copied but
//! short lists, so a scene of ten million triangles opens in milliseconds, and processes that open the same file share its memory.
//!
//! ```text
//! "FEELSCN\n" | layout u32 | sections u32 | length of the file u64 | content hash [16] | checksum of header and table u64 | zeros
//! table: for each section name [32], offset u64, length u64, XXH3-128 [16]
//! sections, each at a multiple of 65,536 bytes
//! ```
//!
//! All is little endian. A file of another layout is refused: a layout belongs to a version of the structures, and there is no
//! conversion. The file must not be changed in place while a scene uses it; [`save`] never does.

mod constants;
mod error;
mod format;
mod mapping;
mod open;
mod write;

pub use error::{Error, Result};
pub use open::{open, OpenOptions, SavedScene};
pub use write::{save, Extra};

/// The version of the layout that this version writes, and the only one that it reads.
pub use feeler_core::saved::LAYOUT;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
