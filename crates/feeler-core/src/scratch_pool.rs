//! The working memory of past queries, reused by the next ones.

use std::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

use crossbeam_utils::atomic::AtomicCell;

/// How often a lock that is held is looked at.
const LOOKS: usize = 100;

/// The working memory of the last query, and of others that ran at the same time. Sequential queries get the former
/// with one atomic instruction; a lock takes several.
///
/// Nobody waits for the lock, since in a forked process it may be held by a thread that does not exist there: a query
/// that finds it locked works with new memory.
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
            if let Some(mut others) = self.others() {
                others.push(other);
            }
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
        self.others().and_then(|mut others| others.pop()).unwrap_or_default()
    }

    /// The memory that others left, unless it is in use. It is held for an instant, so another look or two nearly always helps.
    fn others(&self) -> Option<MutexGuard<'_, Vec<Box<T>>>> {
        for _ in 0..LOOKS {
            match self.others.try_lock() {
                Ok(others) => return Some(others),
                Err(TryLockError::Poisoned(others)) => return Some(PoisonError::into_inner(others)),
                Err(TryLockError::WouldBlock) => std::hint::spin_loop(),
            }
        }
        None
    }
}

impl<T> fmt::Debug for ScratchPool<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ScratchPool").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_used_again() {
        let pool = ScratchPool::<Vec<u32>>::default();
        let (mut a, mut b) = (pool.take(), pool.take());
        a.push(1);
        b.push(2);
        pool.put(a);
        pool.put(b);
        let mut left = [pool.take()[0], pool.take()[0]];
        left.sort_unstable();
        assert_eq!(left, [1, 2]);
    }

    #[test]
    fn a_lock_that_is_never_given_back_stops_nobody() {
        let pool = ScratchPool::<Vec<u32>>::default();
        let _held = pool.others.lock().unwrap();
        let [a, b, c] = std::array::from_fn(|_| pool.take());
        [a, b, c].into_iter().for_each(|scratch| pool.put(scratch));
        assert!(pool.take().is_empty());
    }
}
