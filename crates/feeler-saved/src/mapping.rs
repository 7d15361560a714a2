//! A file as memory that cannot be written.

use std::fs::File;
use std::path::Path;

use feeler_lanes::SharedMemory;
use memmap2::Mmap;

use crate::error::{Error, Result};

/// A mapped file.
#[derive(Debug)]
pub struct Mapping(Mmap);

impl Mapping {
    /// Maps a file.
    pub fn new(path: &Path) -> Result<Mapping> {
        // Before it is opened: opening a pipe waits for somebody who writes.
        if !std::fs::metadata(path)?.is_file() {
            return Err(Error::NotSaved);
        }
        let file = File::open(path)?;
        let is_file = file.metadata()?.is_file();
        if !is_file || file.metadata()?.len() == 0 {
            return Err(Error::NotSaved); // mapping nothing is an error of the system
        }
        // SAFETY: the crate's contract is that nobody changes the file in place while it is used; `save` writes a new one and renames it.
        Ok(Mapping(unsafe { Mmap::map(&file)? }))
    }
}

// SAFETY: the mapping is where it is for as long as it lives, and its file does not change: see `new`.
unsafe impl SharedMemory for Mapping {
    fn bytes(&self) -> &[u8] {
        &self.0
    }
}
