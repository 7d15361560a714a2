//! Header and table of the file, as bytes and read back.

use xxhash_rust::xxh3::{xxh3_128, xxh3_64};

use crate::constants::{CONTENT, ENTRY, HEADER, MAGIC, MOST_SECTIONS, NAME, SECTION_ALIGNMENT};
use crate::error::{damaged, Error, Result};
use crate::LAYOUT;

/// A section in the table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    pub name: String,
    pub offset: u64,
    pub length: u64,
    /// XXH3-128 of its bytes.
    pub hash: u128,
}

/// The table, and the length of the file that it describes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    pub entries: Vec<Entry>,
    pub file_length: u64,
}

/// Where the checksum of header and table lies.
const CHECKSUM: std::ops::Range<usize> = 40..48;

impl Table {
    /// Lays out sections of these names, lengths and hashes, in this order.
    pub fn new(sections: impl IntoIterator<Item = (String, u64, u128)>) -> Result<Table> {
        let mut entries: Vec<Entry> = Vec::new();
        let mut end = SECTION_ALIGNMENT;
        for (name, length, hash) in sections {
            let refused = |why| Err(Error::Section { name: name.clone(), why });
            if name.is_empty() || name.len() > NAME || name.contains('\0') {
                return refused("a name has 1 to 32 bytes, none of them zero");
            }
            if entries.iter().any(|other| other.name == name) {
                return refused("the name is used twice");
            }
            if entries.len() == MOST_SECTIONS {
                return refused("there are too many sections");
            }
            entries.push(Entry { name, offset: end, length, hash });
            end += length.next_multiple_of(SECTION_ALIGNMENT);
        }
        Ok(Table { entries, file_length: end })
    }

    /// A hash of the mock-up, whatever its index.
    pub fn content_hash(&self) -> u128 {
        let mut bytes = Vec::new();
        for entry in self.entries.iter().filter(|entry| CONTENT.contains(&entry.name.as_str())) {
            bytes.extend(entry.length.to_le_bytes());
            bytes.extend(entry.hash.to_le_bytes());
        }
        xxh3_128(&bytes)
    }

    /// Header and table as bytes, up to the first section.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(SECTION_ALIGNMENT as usize);
        bytes.extend(MAGIC);
        bytes.extend(LAYOUT.to_le_bytes());
        bytes.extend((self.entries.len() as u32).to_le_bytes());
        bytes.extend(self.file_length.to_le_bytes());
        bytes.extend(self.content_hash().to_le_bytes());
        bytes.resize(HEADER, 0);
        for entry in &self.entries {
            bytes.extend(entry.name.as_bytes());
            bytes.resize(bytes.len().next_multiple_of(ENTRY) - ENTRY + NAME, 0);
            bytes.extend(entry.offset.to_le_bytes());
            bytes.extend(entry.length.to_le_bytes());
            bytes.extend(entry.hash.to_le_bytes());
        }
        bytes.resize(SECTION_ALIGNMENT as usize, 0);
        let checksum = xxh3_64(&bytes).to_le_bytes();
        bytes[CHECKSUM].copy_from_slice(&checksum);
        bytes
    }

    /// From the bytes of a file. All ranges are inside the file then; sections may overlap, which only an ill-meant file does.
    pub fn of_file(file: &[u8]) -> Result<Table> {
        if !file.starts_with(&MAGIC) {
            return Err(Error::NotSaved);
        }
        let u32_at = |at: usize| file.get(at..at + 4).map(|b| u32::from_le_bytes(b.try_into().expect("4 bytes")));
        let u64_at = |at: usize| file.get(at..at + 8).map(|b| u64::from_le_bytes(b.try_into().expect("8 bytes")));
        let too_short =
            || Error::Length { found: file.len() as u64, promised: u64_at(16).unwrap_or(SECTION_ALIGNMENT) };
        let found = u32_at(8).ok_or_else(too_short)?;
        if found != LAYOUT {
            return Err(Error::Layout { found, expected: LAYOUT });
        }
        let file_length = u64_at(16).ok_or_else(too_short)?;
        if file_length != file.len() as u64 || file_length < SECTION_ALIGNMENT {
            return Err(too_short());
        }
        let mut head = file[..SECTION_ALIGNMENT as usize].to_vec();
        head[CHECKSUM].fill(0);
        if Some(xxh3_64(&head)) != u64_at(CHECKSUM.start) {
            return Err(damaged("header"));
        }
        let count = u32_at(12).map_or(0, |count| count as usize);
        if count > MOST_SECTIONS {
            return Err(damaged("number of sections"));
        }
        let entries = head[HEADER..].chunks_exact(ENTRY).take(count).map(|entry| Entry::of_bytes(entry, file_length));
        let table = Table { entries: entries.collect::<Result<_>>()?, file_length };
        if head[24..40] != table.content_hash().to_le_bytes() {
            return Err(damaged("content hash"));
        }
        Ok(table)
    }
}

impl Entry {
    fn of_bytes(bytes: &[u8], file_length: u64) -> Result<Entry> {
        let u64_at = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().expect("8 bytes"));
        let name = &bytes[..NAME];
        let name = &name[..name.iter().position(|byte| *byte == 0).unwrap_or(NAME)];
        let name = std::str::from_utf8(name).map_err(|_| damaged("name of a section"))?.to_owned();
        let hash = u128::from_le_bytes(bytes[NAME + 16..].try_into().expect("16 bytes"));
        let (offset, length) = (u64_at(NAME), u64_at(NAME + 8));
        let is_inside = offset.checked_add(length).is_some_and(|end| end <= file_length);
        if !is_inside || offset < SECTION_ALIGNMENT || !offset.is_multiple_of(SECTION_ALIGNMENT) {
            return Err(damaged(format!("place of {name}")));
        }
        Ok(Entry { name, offset, length, hash })
    }
}
