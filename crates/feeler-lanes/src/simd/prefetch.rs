//! Prefetches cache lines.

/// Asks for the cache lines of a value that will be read soon.
#[inline(always)]
pub fn prefetch<T>(value: &T) {
    prefetch_at(std::slice::from_ref(value), 0);
}

/// The same for an entry of a list; without a look at whether there is such an entry.
#[inline(always)]
pub fn prefetch_at<T>(list: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_mm_prefetch, _MM_HINT_T0};
        let start = list.as_ptr().wrapping_add(index).cast::<i8>();
        for line in 0..size_of::<T>().div_ceil(64) {
            // SAFETY: prefetching is a hint on any address, and every x86-64 CPU has it.
            unsafe { _mm_prefetch(start.wrapping_add(64 * line), _MM_HINT_T0) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (list, index);
}
