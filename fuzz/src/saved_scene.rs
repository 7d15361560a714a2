//! Saved scenes that somebody changed, with the checksums made right again: an error, or a scene whose queries do not panic.

use std::fs::{self, File};
use std::io::{Seek, SeekFrom, Write};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::sync::{Arc, OnceLock};

use arbitrary::{Arbitrary, Result, Unstructured};
use feeler_contacts::ContactSolver;
use feeler_core::{CastOptions, Mockup, Pose, Progress, Ray, Scene, SceneOptions, Storage, Tool};
use feeler_saved::{open, save, OpenOptions, SavedScene};
use feeler_shapes::{ball, box_mesh, cylinder, joined, soups};
use xxhash_rust::xxh3::{xxh3_128, xxh3_64};

use super::shapes::matrix;

/// The layout of the file, as the head of `feeler-saved` describes it.
const ALIGNMENT: usize = 65_536;
const HEADER: usize = 64;
const ENTRY: usize = 64;
const NAME: usize = 32;
const CONTENT: [&str; 4] = ["mesh.vertices", "mesh.faces", "parts.of_face", "parts.triangles"];
/// Bytes of an index that is built again, and of the result of a query.
const MEMORY_LIMIT: u64 = 1 << 24;

#[derive(Debug)]
pub struct Case {
    kind: u8,
    edits: Vec<Edit>,
    /// Which checksums stay wrong, by bits: of the header, of the content, of the sections. Mostly none.
    left_wrong: u8,
    poses: [[[f64; 4]; 4]; 2],
}

/// A change of the file. Sections are counted modulo how many there are, and words modulo the length of the section.
#[derive(Arbitrary, Debug)]
enum Edit {
    /// Another number in a section.
    Word { section: u8, at: u16, value: Value },
    /// The same number several times.
    Fill { section: u8, at: u16, count: u8, value: Value },
    /// Numbers of another place of any section.
    Copy { from: (u8, u16), to: (u8, u16), count: u8 },
    /// A section that is longer or shorter than it was.
    Length { section: u8, by: i16 },
    /// Two sections under each other's names.
    Swap { sections: [u8; 2] },
    /// A byte of the table: names, places, lengths.
    Table { section: u8, at: u8, value: u8 },
    /// A byte of the header.
    Header { at: u8, value: u8 },
    /// A file that ends early.
    Cut { by: u32 },
}

#[derive(Arbitrary, Debug, Clone, Copy)]
enum Value {
    Index(u8),
    /// A triangle that is not queried, and has a corner that is not there.
    Excluded,
    Odd(u8),
    Added(i8),
    Bits(u32),
}

/// Ends of ranges, of whole numbers and of both halves of float64.
const ODD: [u32; 10] = [0, 1, 31, 32, 0x7fff_ffff, 0x8000_0000, u32::MAX, 0x7ff0_0000, 0x7ff8_0000, 0x5fe0_0000];

impl<'a> Arbitrary<'a> for Case {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Case> {
        let poses = [matrix(u, 0.25)?, matrix(u, 0.25)?];
        let left_wrong = if u.ratio(1, 16)? { u.int_in_range(1..=7)? } else { 0 };
        let kind = u.int_in_range(0..=7)?;
        let edits = (0..u.int_in_range(0..=6)?).map(|_| u.arbitrary()).collect::<Result<_>>()?;
        Ok(Case { kind, edits, left_wrong, poses })
    }
}

pub fn check(case: Case) {
    let [Ok(pose), Ok(other)] = case.poses.map(|pose| Pose::new(&pose)) else { return };
    let kinds = kinds();
    // Blocks, which a file holds, more often than the stores that are built again.
    let mut file = Forged(kinds[usize::from(case.kind).saturating_sub(5)].clone());
    for edit in &case.edits {
        file.change(edit);
    }
    file.make_right(case.left_wrong);
    let written = Written::new(&file.0);
    let opened = open(&written.0, &OpenOptions::default().with_memory_limit(MEMORY_LIMIT));
    assert!(!case.edits.is_empty() || case.left_wrong != 0 || opened.is_ok(), "{:?}", opened.err());
    if let Ok(saved) = opened {
        ask(saved, &pose, &other);
    }
}

/// Every query that reads what a file holds.
fn ask(saved: SavedScene, pose: &Pose, other: &Pose) {
    let scene = Arc::new(saved.scene);
    let (vertices, faces) = ball(0.3, 4);
    let tool = Tool::new(vertices, faces).unwrap();
    let mockup = scene.mockup();
    let _ = (scene.collide(&tool, pose), scene.is_colliding(&tool, pose), scene.is_entering(&tool, pose));
    let _ = (scene.distance(&tool, pose, 1.0), scene.near_pairs(&tool, pose, 0.1), scene.clearance(&tool, pose, 0.5));
    let _ = scene.nearest(&tool, pose, 3, f64::INFINITY);
    let options = CastOptions::default().with_tolerance(1e-3);
    let _ = scene.cast(&tool, other, pose, &options);
    let ray = Ray { origin: [-2.0, 0.1, 0.2], direction: [1.0, 0.0, 0.0] };
    let _ = (scene.ray(&ray, f64::INFINITY, &[]), scene.section(&[0.1; 3], &[0.6, 0.0, 0.8]), scene.memory());
    for part in 0..mockup.part_bounds().len().min(6) as u32 {
        let _ = (scene.has_part(part), scene.without(&[part]), scene.only(&[part]));
        let _ = mockup.body_outline(part);
    }
    let solver = ContactSolver::new(Arc::clone(&scene));
    if let Ok(contacts) = solver.contacts(&tool, pose, 0.1, Some(other)) {
        for plane in &contacts.planes {
            let _ = solver.footing(&tool, pose, plane);
        }
    }
    let _ = (solver.penetration(&tool, pose, 0.1, None), solver.containment(&tool, pose), solver.depths(&tool, pose));
}

/// The bytes of a file.
struct Forged(Vec<u8>);

impl Forged {
    fn u64_at(&self, at: usize) -> u64 {
        u64::from_le_bytes(self.0[at..at + 8].try_into().unwrap())
    }

    fn set(&mut self, at: usize, bytes: &[u8]) {
        self.0[at..at + bytes.len()].copy_from_slice(bytes);
    }

    fn count(&self) -> usize {
        let count = u32::from_le_bytes(self.0[12..16].try_into().unwrap()) as usize;
        count.min((ALIGNMENT - HEADER) / ENTRY)
    }

    /// The entry of a section in the table.
    fn entry(&self, section: u8) -> Option<usize> {
        (self.0.len() >= ALIGNMENT).then_some(())?;
        Some(HEADER + usize::from(section).checked_rem(self.count())? * ENTRY)
    }

    /// The bytes of a section, if they are in the file.
    fn range(&self, entry: usize) -> Option<std::ops::Range<usize>> {
        let (from, length) = (self.u64_at(entry + NAME) as usize, self.u64_at(entry + NAME + 8) as usize);
        let end = from.checked_add(length)?;
        (from >= ALIGNMENT && end <= self.0.len()).then_some(from..end)
    }

    /// Where a word of a section begins.
    fn word(&self, section: u8, at: u16) -> Option<usize> {
        let range = self.range(self.entry(section)?)?;
        Some(range.start + 4 * usize::from(at).checked_rem(range.len() / 4)?)
    }

    fn put(&mut self, at: usize, value: Value) {
        let before = u32::from_le_bytes(self.0[at..at + 4].try_into().unwrap());
        let after = match value {
            Value::Index(index) => u32::from(index),
            Value::Excluded => excluded(),
            Value::Odd(which) => ODD[usize::from(which) % ODD.len()],
            Value::Added(by) => before.wrapping_add_signed(i32::from(by)),
            Value::Bits(bits) => bits,
        };
        self.set(at, &after.to_le_bytes());
    }

    fn change(&mut self, edit: &Edit) {
        let _ = self.try_change(edit); // an edit of a place that there is none of changes nothing
    }

    fn try_change(&mut self, edit: &Edit) -> Option<()> {
        match *edit {
            Edit::Word { section, at, value } => {
                let at = self.word(section, at)?;
                self.put(at, value);
            }
            Edit::Fill { section, at, count, value } => {
                let end = self.range(self.entry(section)?)?.end;
                let from = self.word(section, at)?;
                for at in (from..end.saturating_sub(3)).step_by(4).take(usize::from(count)) {
                    self.put(at, value);
                }
            }
            Edit::Copy { from, to, count } => {
                let ends = [from, to].map(|(section, _)| Some(self.range(self.entry(section)?)?.end));
                let (from, to) = (self.word(from.0, from.1)?, self.word(to.0, to.1)?);
                let most = (ends[0]? - from).min(ends[1]? - to);
                self.0.copy_within(from..from + most.min(4 * usize::from(count)), to);
            }
            Edit::Length { section, by } => {
                let entry = self.entry(section)?;
                let length = self.u64_at(entry + NAME + 8).saturating_add_signed(i64::from(by));
                self.set(entry + NAME + 8, &length.to_le_bytes());
            }
            Edit::Swap { sections: [a, b] } => {
                let (a, b) = (self.entry(a)?, self.entry(b)?);
                for i in NAME..ENTRY {
                    self.0.swap(a + i, b + i);
                }
            }
            Edit::Table { section, at, value } => {
                let entry = self.entry(section)?;
                self.0[entry + usize::from(at) % (ENTRY - 16)] = value;
            }
            Edit::Header { at, value } => *self.0.get_mut(usize::from(at) % HEADER)? = value,
            Edit::Cut { by } => {
                let length = self.0.len().saturating_sub(by as usize % ALIGNMENT);
                self.0.truncate(length);
            }
        }
        Some(())
    }

    /// Makes the checksums right, but for those that are to stay wrong.
    fn make_right(&mut self, left_wrong: u8) {
        if self.0.len() < ALIGNMENT {
            return;
        }
        let mut content = Vec::new();
        for entry in (0..self.count()).map(|i| HEADER + i * ENTRY) {
            if let Some(range) = self.range(entry).filter(|_| left_wrong & 4 == 0) {
                let hash = xxh3_128(&self.0[range]).to_le_bytes();
                self.set(entry + NAME + 16, &hash);
            }
            let name = &self.0[entry..entry + NAME];
            let name = &name[..name.iter().position(|byte| *byte == 0).unwrap_or(NAME)];
            if CONTENT.iter().any(|own| own.as_bytes() == name) {
                content.extend_from_slice(&self.0[entry + NAME + 8..entry + ENTRY]);
            }
        }
        if left_wrong & 2 == 0 {
            self.set(24, &xxh3_128(&content).to_le_bytes());
        }
        if left_wrong & 1 == 0 {
            self.set(40, &[0; 8]);
            let checksum = xxh3_64(&self.0[..ALIGNMENT]).to_le_bytes();
            self.set(40, &checksum);
        }
    }
}

/// Open and closed parts, defects, and a part without triangles.
fn mockup() -> &'static Arc<Mockup> {
    static MOCKUP: OnceLock<Arc<Mockup>> = OnceLock::new();
    MOCKUP.get_or_init(|| {
        let parts =
            [box_mesh([0.0; 3], [1.0, 1.0, 0.2], 1), ball(0.3, 4), cylinder(0.1, 1.5, 6, 1), soups::soup(5, 12, 0.3)];
        let mut of_face: Vec<u32> =
            parts.iter().zip(0..).flat_map(|((_, faces), part)| vec![part; faces.len()]).collect();
        let (vertices, mut faces) = joined(parts);
        faces.extend([[0, 0, 1], faces[0], [0, 1, u32::MAX]]);
        of_face.extend([0, 2, 1]);
        Arc::new(Mockup::new(vertices, faces, of_face, 5).unwrap())
    })
}

/// The triangle of [`mockup`] with a corner that is not there.
fn excluded() -> u32 {
    mockup().mesh().faces().len() as u32 - 1
}

/// Whole files, one for each store, with a part that is out.
fn kinds() -> &'static [Vec<u8>; 3] {
    static KINDS: OnceLock<[Vec<u8>; 3]> = OnceLock::new();
    KINDS.get_or_init(|| {
        [Storage::Blocks, Storage::Dense, Storage::Hashed { level: 0.3 }].map(|storage| {
            let options = SceneOptions::default().with_storage(storage).with_voxel_size(0.15);
            let scene = Scene::build(Arc::clone(mockup()), &options).unwrap().without(&[2]).unwrap();
            let place = Written::new(&[]);
            save(&place.0, &scene, &[], Progress::default()).unwrap();
            fs::read(&place.0).unwrap()
        })
    })
}

/// A file that is removed again.
struct Written(std::path::PathBuf);

impl Written {
    fn new(bytes: &[u8]) -> Written {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("feeler-forged-{}-{}.feeler", std::process::id(), COUNT.fetch_add(1, Relaxed));
        let path = std::env::temp_dir().join(name);
        let mut file = File::create(&path).unwrap();
        // Sections are short, and most of the file is zeros: holes.
        for (i, piece) in bytes.chunks(ALIGNMENT).enumerate() {
            let end = piece.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
            file.seek(SeekFrom::Start((i * ALIGNMENT) as u64)).unwrap();
            file.write_all(&piece[..end]).unwrap();
        }
        file.set_len(bytes.len() as u64).unwrap();
        Written(path)
    }
}

impl Drop for Written {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}
