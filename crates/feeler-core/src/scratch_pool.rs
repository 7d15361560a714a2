//! The working memory of past queries, for the next ones.

use std::fmt;
use std::sync::{Mutex, PoisonError};

use crossbeam_utils::atomic::AtomicCell;

/// What the last query left, and what others left that ran at the same time. One after the other they find the former with one
/// atomic instruction; a lock takes several.
pub struct ScratchPool<T> {
    last: AtomicCell<Option<Box<T>>>,
    others: Mutex<Vec<Box<T>>>,
}

impl<T> Default for ScratchPool<T> {
    fn default() -> ScratchPool<T> {
        ScratchPool { last: AtomicCell::new(None), others: Mutex::default() }
    }
}

impl<T: Default> ScratchPool<T> {
    /// For one query: until it is put back it is nobody else's.
    #[inline]
    pub fn take(&self) -> Box<T> {
        self.last.take().unwrap_or_else(|| self.other())
    }

    /// Gives it back, for the next query.
    #[inline]
    pub fn put(&self, scratch: Box<T>) {
        if let Some(other) = self.last.swap(Some(scratch)) {
            self.others.lock().unwrap_or_else(PoisonError::into_inner).push(other);
        }
    }

    /// Runs a query with working memory of the pool.
    #[inline]
    pub fn with<R>(&self, query: impl FnOnce(&mut T) -> R) -> R {
        let mut scratch = self.take();
        let result = query(&mut scratch);
        self.put(scratch);
        result
    }

    /// A function of its own: a new one needs thirteen pages of stack, each of which is touched before anything else is done.
    #[cold]
    #[inline(never)]
    fn other(&self) -> Box<T> {
        let other = self.others.lock().unwrap_or_else(PoisonError::into_inner).pop();
        other.unwrap_or_default()
    }
}

impl<T> fmt::Debug for ScratchPool<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ScratchPool").finish_non_exhaustive()
    }
}
