//! Arrays of plain data that are owned, or lie in memory that somebody else keeps, such as a mapped file.

use std::fmt;
use std::ops::{Deref, Range};
use std::sync::Arc;

use bytemuck::Pod;

/// The most that an entry of a [`Column`] may be aligned to, bytes: bytes in a file are laid out for it.
pub const COLUMN_ALIGNMENT: usize = 64;

/// Memory that others may keep views of.
///
/// # Safety
///
/// `bytes` gives the same slice at every call, and its content does not change while the object lives.
pub unsafe trait SharedMemory: Send + Sync {
    /// All of it.
    fn bytes(&self) -> &[u8];
}

// SAFETY: a vector that nobody can borrow mutably keeps its place and content.
unsafe impl SharedMemory for Vec<u8> {
    fn bytes(&self) -> &[u8] {
        self
    }
}

/// A range of shared memory.
#[derive(Clone)]
pub struct SharedBytes {
    memory: Arc<dyn SharedMemory>,
    range: Range<usize>,
}

impl SharedBytes {
    /// `None` where the memory ends before the range does.
    pub fn new(memory: Arc<dyn SharedMemory>, range: Range<usize>) -> Option<SharedBytes> {
        memory.bytes().get(range.clone()).is_some().then_some(SharedBytes { memory, range })
    }
}

impl Deref for SharedBytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.memory.bytes()[self.range.clone()]
    }
}

/// An array that cannot change: a `Vec`, or a view of [`SharedBytes`]. Reading it costs what reading a `Vec` costs, and a clone shares the
/// entries.
///
/// ```
/// use std::sync::Arc;
/// use feeler_lanes::{Column, SharedBytes};
///
/// let owned: Column<u32> = vec![1, 2, 3].into();
/// let bytes = SharedBytes::new(Arc::new(owned.bytes().to_vec()), 0..12).unwrap();
/// match Column::<u32>::of_bytes(bytes) {
///     Some(view) => assert_eq!(view[..], owned[..]),
///     None => println!("the bytes are not aligned"),
/// }
/// ```
pub struct Column<T: Pod> {
    /// Into what `keeper` keeps.
    start: *const T,
    len: usize,
    keeper: Keeper<T>,
}

enum Keeper<T> {
    Owned(Arc<Vec<T>>),
    Shared { _memory: SharedBytes },
}

// SAFETY: nobody can change the entries through a column, and plain data can be read from any thread; the keepers are `Send` and
// `Sync` themselves.
unsafe impl<T: Pod + Send + Sync> Send for Column<T> {}
// SAFETY: see above.
unsafe impl<T: Pod + Send + Sync> Sync for Column<T> {}

impl<T: Pod> Column<T> {
    /// The entries that lie in the bytes one after the other; `None` where their number is not whole, or where they are not aligned.
    pub fn of_bytes(bytes: SharedBytes) -> Option<Column<T>> {
        let entries: &[T] = bytemuck::try_cast_slice(&bytes).ok()?;
        Some(Column { start: entries.as_ptr(), len: entries.len(), keeper: Keeper::Shared { _memory: bytes } })
    }

    /// The entries as bytes.
    pub fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(self)
    }

    /// Bytes held in memory that is not shared.
    pub fn owned_memory(&self) -> usize {
        match &self.keeper {
            Keeper::Owned(entries) => entries.capacity() * size_of::<T>(),
            Keeper::Shared { .. } => 0,
        }
    }

    /// The vector, where this column alone owns it.
    pub fn into_vec(self) -> Option<Vec<T>> {
        match self.keeper {
            Keeper::Owned(entries) => Arc::try_unwrap(entries).ok(),
            Keeper::Shared { .. } => None,
        }
    }

    /// Bytes of the entries, wherever they are.
    pub fn memory(&self) -> usize {
        self.owned_memory().max(size_of_val(&**self))
    }
}

impl<T: Pod> From<Vec<T>> for Column<T> {
    fn from(entries: Vec<T>) -> Column<T> {
        // The vector's buffer stays where it is when the vector is moved.
        Column { start: entries.as_ptr(), len: entries.len(), keeper: Keeper::Owned(Arc::new(entries)) }
    }
}

impl<T: Pod> Clone for Column<T> {
    fn clone(&self) -> Column<T> {
        let keeper = match &self.keeper {
            Keeper::Owned(entries) => Keeper::Owned(Arc::clone(entries)),
            Keeper::Shared { _memory } => Keeper::Shared { _memory: _memory.clone() },
        };
        // The entries stay where they are as long as either keeper holds them.
        Column { start: self.start, len: self.len, keeper }
    }
}

impl<T: Pod> Default for Column<T> {
    fn default() -> Column<T> {
        Vec::new().into()
    }
}

impl<T: Pod> Deref for Column<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        // SAFETY: `start` and `len` are of a slice that the keeper holds for as long as the column lives, and that nobody changes: the
        // vector cannot be reached, and shared memory promises it.
        unsafe { std::slice::from_raw_parts(self.start, self.len) }
    }
}

impl<'a, T: Pod> IntoIterator for &'a Column<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<T: Pod + fmt::Debug> fmt::Debug for Column<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shared(bytes: Vec<u8>, range: Range<usize>) -> Option<SharedBytes> {
        SharedBytes::new(Arc::new(bytes), range)
    }

    #[test]
    fn a_view_keeps_its_memory() {
        let column: Column<u32> = vec![7, 8, 9].into();
        let bytes = column.bytes().to_vec();
        drop(column);
        let start = bytes.as_ptr() as usize;
        let view = Column::<u32>::of_bytes(shared(bytes, 4..12).unwrap());
        assert_eq!(view.is_some(), start.is_multiple_of(4));
        if let Some(view) = view {
            assert_eq!((view[..].to_vec(), view.owned_memory(), view.memory()), (vec![8, 9], 0, 8));
        }
    }

    #[test]
    fn a_clone_shares_the_entries_and_the_last_owner_gets_them() {
        let column: Column<u32> = vec![7, 8, 9].into();
        let copy = column.clone();
        assert_eq!(column.as_ptr(), copy.as_ptr());
        assert!(column.into_vec().is_none());
        assert_eq!(copy[..], [7, 8, 9]);
        assert_eq!(copy.into_vec(), Some(vec![7, 8, 9]));
        let view = Column::<u8>::of_bytes(shared(vec![1, 2, 3], 1..3).unwrap()).unwrap();
        let copy = view.clone();
        drop(view);
        assert_eq!(copy[..], [2, 3]);
        assert!(copy.into_vec().is_none());
    }

    #[test]
    fn ranges_and_bytes_that_do_not_fit_are_refused() {
        assert!(shared(vec![0; 12], 4..13).is_none());
        #[allow(clippy::reversed_empty_ranges, reason = "a range of a damaged file")]
        let reversed = 8..4;
        assert!(shared(vec![0; 12], reversed).is_none());
        assert!(Column::<u32>::of_bytes(shared(vec![0; 12], 0..10).unwrap()).is_none());
        let memory: Arc<dyn SharedMemory> = Arc::new(vec![0u8; 17]);
        let odd = SharedBytes::new(memory, 1..9).unwrap();
        assert_eq!(Column::<u64>::of_bytes(odd.clone()).is_some(), (odd.as_ptr() as usize).is_multiple_of(8));
    }

    #[test]
    fn an_empty_column_has_no_entries() {
        assert!(Column::<f64>::default().is_empty());
        assert!(Column::<f64>::of_bytes(shared(Vec::new(), 0..0).unwrap()).is_none_or(|view| view.is_empty()));
    }
}
