//! Opening a saved scene.

use std::path::Path;
use std::sync::Arc;

use feeler_core::saved::SavedSections;
use feeler_core::{Progress, Scene};
use feeler_lanes::{SharedBytes, SharedMemory};
use rayon::prelude::*;
use xxhash_rust::xxh3::xxh3_128;

use crate::error::{damaged, Error, Result};
use crate::format::{Entry, Table};
use crate::mapping::Mapping;

/// Options of [`open`].
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct OpenOptions<'a> {
    /// Compares the checksum of every section, and checks every index in them; in parallel on the current rayon pool. True by default.
    /// Without, a query of a damaged file may answer wrongly, or panic.
    pub verify: bool,
    /// The most bytes of a query's result, and of an index that is built again.
    pub memory_limit: u64,
    /// Reports the progress, and may stop it.
    pub progress: Progress<'a>,
}

impl Default for OpenOptions<'_> {
    fn default() -> Self {
        OpenOptions { verify: true, memory_limit: u64::MAX, progress: Progress::default() }
    }
}

impl<'a> OpenOptions<'a> {
    feeler_core::setters! {
        with_verify: verify: bool,
        with_memory_limit: memory_limit: u64,
    }

    /// Calls a function with the share done (0 to 1) and the stage. Opening stops where it returns false.
    #[must_use]
    pub fn with_progress(mut self, progress: &'a (dyn Fn(f64, &str) -> bool + Sync)) -> Self {
        self.progress = Progress::new(progress);
        self
    }
}

/// An opened file.
#[derive(Debug)]
pub struct SavedScene {
    /// The scene, on the mapped memory, which it keeps.
    pub scene: Scene,
    /// The hash of its mock-up (vertices, faces and parts): the same for the same mock-up, whatever its index.
    pub content_hash: u128,
    sections: Mapped,
}

impl SavedScene {
    /// A section that [`save`](crate::save) was given as an extra.
    pub fn extra(&self, name: &str) -> Option<&[u8]> {
        let entry = self.sections.entry(name)?;
        self.sections.memory.bytes().get(range(entry))
    }
}

struct Mapped {
    memory: Arc<dyn SharedMemory>,
    table: Table,
}

impl std::fmt::Debug for Mapped {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.table.fmt(f)
    }
}

impl Mapped {
    fn entry(&self, name: &str) -> Option<&Entry> {
        self.table.entries.iter().find(|entry| entry.name == name)
    }
}

impl SavedSections for Mapped {
    fn section(&self, name: &str) -> Option<SharedBytes> {
        SharedBytes::new(Arc::clone(&self.memory), range(self.entry(name)?))
    }
}

fn range(entry: &Entry) -> std::ops::Range<usize> {
    entry.offset as usize..(entry.offset + entry.length) as usize
}

/// Opens a scene that [`save`](crate::save) wrote: maps the file and uses it where it lies.
///
/// Errors: no such file, another kind of file, another layout, a file that is cut off, and with `verify` one that is damaged.
pub fn open(path: impl AsRef<Path>, options: &OpenOptions<'_>) -> Result<SavedScene> {
    if cfg!(target_endian = "big") {
        return Err(Error::BigEndian);
    }
    let memory: Arc<dyn SharedMemory> = Arc::new(Mapping::new(path.as_ref())?);
    let table = Table::of_file(memory.bytes())?;
    let sections = Mapped { memory, table };
    if options.verify {
        let is_right = |entry: &&Entry| xxh3_128(&sections.memory.bytes()[range(entry)]) == entry.hash;
        if let Some(wrong) = sections.table.entries.par_iter().find_first(|entry| !is_right(entry)) {
            return Err(damaged(wrong.name.clone()));
        }
        if !options.progress.tell(0.5, "verifying") {
            return Err(Error::Core(feeler_core::Error::Cancelled));
        }
    }
    let scene = Scene::of_sections(&sections, options.verify, options.memory_limit, options.progress)?;
    Ok(SavedScene { scene, content_hash: sections.table.content_hash(), sections })
}

#[cfg(test)]
mod tests {
    use std::panic::{catch_unwind, AssertUnwindSafe};

    use feeler_core::{Mockup, Pose, SceneOptions, Tool};
    use feeler_shapes::random::Random;
    use feeler_shapes::{ball, box_mesh, joined};

    use super::*;
    use crate::write::save;

    /// Queries that do not panic.
    fn ask(scene: &Scene, tool: &Tool, pose: &Pose) -> bool {
        let asked = catch_unwind(AssertUnwindSafe(|| {
            let _ = (scene.collide(tool, pose), scene.is_entering(tool, pose));
            let _ = (scene.distance(tool, pose, 1.0), scene.near_pairs(tool, pose, 0.1));
            let _ = (scene.without(&[0]), scene.mockup().body_outline(3));
        }));
        asked.is_ok()
    }

    /// A fuzz target found these: pieces and neighbours that were triangles with a corner that is not there, and empty blocks.
    #[test]
    fn a_triangle_that_is_not_queried_is_refused_where_one_is_needed() {
        let path = std::env::temp_dir().join(format!("feeler-excluded-{}.feeler", std::process::id()));
        let (vertices, mut faces) = box_mesh([0.0; 3], [1.0; 3], 1);
        let excluded = faces.len() as u32;
        faces.push([0, 1, u32::MAX]);
        let mockup = Mockup::new(vertices, faces, Vec::new(), 1).unwrap();
        let scene = Scene::build(Arc::new(mockup), &SceneOptions::default()).unwrap();
        save(&path, &scene, &[], Progress::default()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let whole = Table::of_file(&bytes).unwrap();
        let (vertices, faces) = ball(0.4, 6);
        let (tool, pose) = (Tool::new(vertices, faces).unwrap(), Pose::IDENTITY.translated(&[0.9; 3]).unwrap());
        let places = ["blocks.pieces", "topology.neighbours", "topology.shells"].map(|name| (name, excluded));
        for (name, word) in places.into_iter().chain([("blocks.level0", 0)]) {
            let number = whole.entries.iter().position(|entry| entry.name == name).unwrap();
            let mut refused = 0;
            for at in range(&whole.entries[number]).step_by(4) {
                let (mut forged, mut table) = (bytes.clone(), whole.clone());
                forged[at..at + 4].copy_from_slice(&word.to_le_bytes());
                table.entries[number].hash = xxh3_128(&forged[range(&table.entries[number])]);
                forged.splice(..crate::constants::SECTION_ALIGNMENT as usize, table.to_bytes());
                std::fs::write(&path, &forged).unwrap();
                match open(&path, &OpenOptions::default()) {
                    Err(Error::Damaged { .. }) => refused += 1,
                    Err(error) => panic!("{name}: {error}"),
                    Ok(saved) => assert!(ask(&saved.scene, &tool, &pose), "{name} at {at}: a query panicked"),
                }
            }
            assert!(refused > 0, "{name}");
        }
        std::fs::remove_file(&path).unwrap();
    }

    /// Every section of a scene is changed in turn, at random, with all checksums made right again: as somebody would who means ill.
    #[test]
    fn forged_files_are_refused_or_queried_without_a_panic() {
        let path = std::env::temp_dir().join(format!("feeler-forged-{}.feeler", std::process::id()));
        let parts = [box_mesh([0.0; 3], [1.0; 3], 4), ball(0.7, 10)];
        let counts = [parts[0].1.len(), parts[1].1.len()];
        let (vertices, faces) = joined(parts);
        let of_face = (0..2).flat_map(|part| vec![part as u32; counts[part]]).collect();
        let mockup = Mockup::new(vertices, faces, of_face, 2).unwrap();
        let scene = Scene::build(Arc::new(mockup), &SceneOptions::default().with_voxel_size(0.1)).unwrap();
        save(&path, &scene, &[], Progress::default()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let table = Table::of_file(&bytes).unwrap();
        let (vertices, faces) = ball(0.4, 6);
        let tool = Tool::new(vertices, faces).unwrap();
        let mut random = Random::new(7);
        let (mut refused, mut opened) = (0, 0);
        for round in 0..60 * table.entries.len() {
            let mut forged = bytes.clone();
            let mut table = table.clone();
            let count = table.entries.len();
            let entry = &mut table.entries[round % count];
            let words = range(entry).step_by(4).collect::<Vec<_>>();
            if words.is_empty() || random.below(6) == 0 {
                entry.length = random.below(2 * entry.length + 200).min(table.file_length - entry.offset);
            } else {
                for _ in 0..=random.below(3) {
                    let at = words[random.below(words.len() as u64) as usize];
                    let odd = [0, 1, 31, 0x7fff_ffff, u32::MAX, 0x7ff0_0000, random.bits() as u32];
                    let word = odd[random.below(odd.len() as u64) as usize].to_le_bytes();
                    let end = (at + 4).min(range(entry).end);
                    forged[at..end].copy_from_slice(&word[..end - at]);
                }
            }
            entry.hash = xxh3_128(&forged[range(entry)]);
            let name = entry.name.clone();
            forged.splice(..crate::constants::SECTION_ALIGNMENT as usize, table.to_bytes());
            std::fs::write(&path, &forged).unwrap();
            match open(&path, &OpenOptions::default().with_memory_limit(1 << 26)) {
                // A store that is built again may be too large.
                Err(Error::Damaged { .. } | Error::Core(_)) => refused += 1,
                Err(error) => panic!("{name}: {error}"),
                Ok(saved) => {
                    opened += 1;
                    let motion = random.motion(0.5);
                    let pose = Pose::new(&motion).unwrap();
                    assert!(ask(&saved.scene, &tool, &pose), "{name}: a query panicked");
                }
            }
        }
        std::fs::remove_file(&path).unwrap();
        assert!(refused > 100 && opened > 100, "{refused} refused, {opened} opened");
    }
}
