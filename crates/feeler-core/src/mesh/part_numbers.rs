//! The part of each triangle of a mesh, as given by a caller.

use crate::error::{Error, Result};

/// Checks one number a triangle, 0 to `parts - 1`; an empty list means that all belong to part 0.
///
/// Errors: no part, more than 2^32 - 1, a list of another length, and a number out of range.
pub(crate) fn check_parts(part_of_face: &[u32], faces: usize, parts: usize) -> Result<()> {
    if !part_of_face.is_empty() && part_of_face.len() != faces {
        return Err(Error::Length { what: "part_of_face", got: part_of_face.len(), expected: faces });
    }
    if parts == 0 || parts as u64 > u64::from(u32::MAX) {
        return Err(Error::TooMany { what: "parts", count: parts as u64, limit: u64::from(u32::MAX) });
    }
    match part_of_face.iter().enumerate().find(|(_, part)| **part as usize >= parts) {
        Some((face, &part)) => Err(Error::PartOutOfRange { face, part, parts }),
        None => Ok(()),
    }
}
