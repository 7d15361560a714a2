//! A scene as named arrays of bytes. The owner of each array writes it and reads it again; where the bytes are kept, such as in a
//! file, is the caller's business. Their layout is this machine's: little endian, and that of the structures of this version.

use std::borrow::Cow;

use bytemuck::Pod;
use feeler_lanes::{Column, SharedBytes};

use crate::error::{Error, Result};

/// The version of the layout of all sections: raised with every change of a stored structure, so that older files are refused.
pub const LAYOUT: u32 = 1;

/// One array of a scene.
#[derive(Debug)]
pub struct Section<'a> {
    /// Its name, unique in the scene; at most 32 bytes.
    pub name: String,
    /// Its entries.
    pub bytes: Cow<'a, [u8]>,
}

/// The sections of a scene, in the order in which they are written.
#[derive(Debug, Default)]
pub struct Sections<'a>(pub Vec<Section<'a>>);

impl<'a> Sections<'a> {
    /// Adds an array.
    pub(crate) fn add<T: Pod>(&mut self, name: impl Into<String>, entries: &'a [T]) {
        self.0.push(Section { name: name.into(), bytes: Cow::Borrowed(bytemuck::cast_slice(entries)) });
    }

    /// Adds entries that were made for it.
    pub(crate) fn add_made<T: Pod>(&mut self, name: impl Into<String>, entries: &[T]) {
        self.0.push(Section { name: name.into(), bytes: Cow::Owned(bytemuck::cast_slice(entries).to_vec()) });
    }
}

/// Where sections are read from.
pub trait SavedSections {
    /// A section; `None` where there is none of that name.
    fn section(&self, name: &str) -> Option<SharedBytes>;
}

/// Sections, with typed access. With `is_checked`, their owners check every index in them.
#[derive(Clone, Copy)]
pub(crate) struct Reader<'a> {
    sections: &'a dyn SavedSections,
    pub is_checked: bool,
}

impl<'a> Reader<'a> {
    pub fn new(sections: &'a dyn SavedSections, is_checked: bool) -> Reader<'a> {
        Reader { sections, is_checked }
    }

    /// An array.
    pub fn column<T: Pod>(&self, name: &str) -> Result<Column<T>> {
        let bytes = self.sections.section(name).ok_or_else(|| damaged(format!("{name} is missing")))?;
        Column::of_bytes(bytes).ok_or_else(|| damaged(format!("{name} is not a whole number of entries")))
    }

    /// An array of a known length.
    pub fn column_of<T: Pod>(&self, name: &str, len: usize) -> Result<Column<T>> {
        let column = self.column(name)?;
        check(column.len() == len, || format!("{name} has {} entries, not {len}", column.len()))?;
        Ok(column)
    }

    /// An array of one entry.
    pub fn one<T: Pod>(&self, name: &str) -> Result<T> {
        Ok(self.column_of::<T>(name, 1)?[0])
    }
}

/// The error of a section that cannot be right.
pub(crate) fn damaged(what: impl Into<String>) -> Error {
    Error::DamagedScene { what: what.into() }
}

/// An error unless `is_right`.
pub(crate) fn check(is_right: bool, what: impl FnOnce() -> String) -> Result<()> {
    if is_right {
        Ok(())
    } else {
        Err(damaged(what()))
    }
}
