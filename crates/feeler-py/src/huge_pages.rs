//! Puts large arrays into huge pages, if the system grants them on request.
//!
//! A query reads a few hundred scattered cache lines in an index of a hundred megabytes. In pages of 4 KiB nearly each
//! of them is in a page whose address must first be looked up in memory, in pages of 2 MiB hardly any.

use std::alloc::{GlobalAlloc, Layout, System};

/// The system's allocator; asks for huge pages behind whatever is large.
pub struct HugePages;

// SAFETY: the system's allocator does it all.
unsafe impl GlobalAlloc for HugePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise.
        advised(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise.
        advised(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller's promise.
        advised(unsafe { System.realloc(place, layout, size) }, size)
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(place, layout) }
    }
}

#[cfg(target_os = "linux")]
fn advised(place: *mut u8, size: usize) -> *mut u8 {
    /// Bytes of a huge page. Less cannot lie in one.
    const HUGE: usize = 2 << 20;
    /// Advice is for whole pages of the ordinary size. Where that is larger, it is refused, at no harm.
    const SMALL: usize = 4 << 10;
    if size >= HUGE && !place.is_null() {
        let skipped = place.align_offset(SMALL);
        // SAFETY: inside the memory just allocated, whose content is not changed.
        unsafe { libc::madvise(place.add(skipped).cast(), (size - skipped) / SMALL * SMALL, libc::MADV_HUGEPAGE) };
    }
    place
}

#[cfg(not(target_os = "linux"))]
fn advised(place: *mut u8, _size: usize) -> *mut u8 {
    place
}
