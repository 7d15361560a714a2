//! Saving a scene.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use feeler_core::{Progress, Scene};
use rayon::prelude::*;
use xxhash_rust::xxh3::xxh3_128;

use crate::constants::{SECTION_ALIGNMENT, WRITTEN_AT_ONCE};
use crate::error::{Error, Result};
use crate::format::Table;

/// A section of the caller's own: its name (at most 32 bytes) and its bytes.
pub type Extra<'a> = (&'a str, &'a [u8]);

/// Saves a scene, with sections of the caller's own, and returns the hash of its mock-up.
///
/// The file is written beside its place, under a name that ends in `.part`, and renamed when it is complete: a file that was there
/// stays as it was until then, also when the disk is full or the process dies. The connectivity of the triangles is found first where
/// no query needed it so far.
pub fn save(path: impl AsRef<Path>, scene: &Scene, extras: &[Extra<'_>], progress: Progress<'_>) -> Result<u128> {
    if cfg!(target_endian = "big") {
        return Err(Error::BigEndian);
    }
    let tell = |done: f64, stage: &str| {
        if progress.tell(done, stage) {
            Ok(())
        } else {
            Err(Error::Core(feeler_core::Error::Cancelled))
        }
    };
    tell(0.0, "finding the connectivity")?;
    let scene = scene.in_one_index(Progress::default())?;
    let sections = scene.sections();
    let own = sections.0.iter().map(|section| (section.name.as_str(), &*section.bytes));
    let all: Vec<(&str, &[u8])> = own.chain(extras.iter().copied()).collect();
    tell(0.4, "computing checksums")?;
    let hashes: Vec<u128> = all.par_iter().map(|(_, bytes)| xxh3_128(bytes)).collect();
    let described = all.iter().zip(hashes).map(|((name, bytes), hash)| ((*name).to_owned(), bytes.len() as u64, hash));
    let table = Table::new(described)?;
    // Of a link the file that it names is replaced, not the link.
    let path = fs::canonicalize(path.as_ref()).unwrap_or_else(|_| path.as_ref().to_owned());
    let beside = Beside::new(&path)?;
    let mut file = &beside.file;
    file.write_all(&table.to_bytes())?;
    let mut written = 0;
    for (_, bytes) in &all {
        for piece in bytes.chunks(WRITTEN_AT_ONCE) {
            tell(0.5 + 0.5 * written as f64 / table.file_length as f64, "writing")?;
            file.write_all(piece)?;
            written += piece.len() as u64;
        }
        let zeros = (bytes.len() as u64).next_multiple_of(SECTION_ALIGNMENT) - bytes.len() as u64;
        file.write_all(&[0; SECTION_ALIGNMENT as usize][..zeros as usize])?;
    }
    beside.rename(&path)?;
    let _ = progress.tell(1.0, "saved"); // there is nothing left to stop
    Ok(table.content_hash())
}

/// A new file beside the place of another one. It is removed unless it is renamed.
struct Beside {
    file: File,
    path: PathBuf,
    is_renamed: bool,
}

impl Beside {
    fn new(path: &Path) -> Result<Beside> {
        if path.file_name().is_none() {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "the path has no file name").into());
        }
        if path.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "the path is a folder").into());
        }
        if path.exists() && !path.is_file() {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "the path is a device, not a file").into());
        }
        for attempt in 0u32.. {
            let own = path.with_file_name(format!(".feeler-{}-{attempt}.part", std::process::id()));
            match OpenOptions::new().write(true).create_new(true).open(&own) {
                Ok(file) => {
                    // The file that is replaced may be for few to read.
                    if let Ok(replaced) = fs::metadata(path) {
                        let _ = file.set_permissions(replaced.permissions());
                    }
                    return Ok(Beside { file, path: own, is_renamed: false });
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists && attempt < 1000 => {}
                Err(error) => return Err(error.into()),
            }
        }
        unreachable!("the last attempt returns")
    }

    fn rename(mut self, path: &Path) -> Result<()> {
        self.file.sync_all()?;
        fs::rename(&self.path, path)?;
        self.is_renamed = true;
        // The name is kept by the folder; where a folder cannot be synced, the system does it later.
        if let Some(folder) = path.parent().filter(|_| cfg!(unix)) {
            let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            let _ = File::open(folder).and_then(|folder| folder.sync_all());
        }
        Ok(())
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        if !self.is_renamed {
            let _ = fs::remove_file(&self.path);
        }
    }
}
