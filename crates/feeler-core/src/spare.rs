//! The working memory of past queries, for the next ones.

use std::fmt;
use std::sync::{Mutex, PoisonError};

use crossbeam_utils::atomic::AtomicCell;

use crate::scene::Scratch;

/// What the last query left, and what others left that ran at the same time. One after the other they find the former with one
/// atomic instruction; a lock takes several.
#[derive(Default)]
pub(crate) struct Spare {
    last: AtomicCell<Option<Box<Scratch>>>,
    others: Mutex<Vec<Box<Scratch>>>,
}

impl Spare {
    /// For one query: until it is put back it is nobody else's.
    #[inline]
    pub fn take(&self) -> Box<Scratch> {
        self.last.take().unwrap_or_else(|| self.other())
    }

    #[inline]
    pub fn put(&self, scratch: Box<Scratch>) {
        if let Some(other) = self.last.swap(Some(scratch)) {
            self.others.lock().unwrap_or_else(PoisonError::into_inner).push(other);
        }
    }

    /// A function of its own: a new one needs thirteen pages of stack, each of which is touched before anything else is done.
    #[cold]
    #[inline(never)]
    fn other(&self) -> Box<Scratch> {
        let other = self.others.lock().unwrap_or_else(PoisonError::into_inner).pop();
        other.unwrap_or_default()
    }
}

impl fmt::Debug for Spare {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Spare").finish_non_exhaustive()
    }
}
