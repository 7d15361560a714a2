//! The numbers of the format.

/// The first bytes of the file. The line feed shows files that were transferred as text.
pub const MAGIC: [u8; 8] = *b"FEELSCN\n";

/// Sections begin at multiples of it, bytes: the largest page of a machine that maps them.
pub const SECTION_ALIGNMENT: u64 = 65_536;

/// Bytes of the header, and of an entry of the table.
pub const HEADER: usize = 64;
pub const ENTRY: usize = 64;

/// Bytes of a section's name.
pub const NAME: usize = 32;

/// Most sections: header and table fit before the first one.
pub const MOST_SECTIONS: usize = (SECTION_ALIGNMENT as usize - HEADER) / ENTRY;

/// Bytes that are written between two reports of progress.
pub const WRITTEN_AT_ONCE: usize = 8 << 20;

/// The sections that make up the content hash: those that say what the mock-up is, whatever its index.
pub const CONTENT: [&str; 4] = ["mesh.vertices", "mesh.faces", "parts.of_face", "parts.triangles"];
