//! Prefetches cache lines.

/// Asks for the cache lines of a value that will be read soon.
#[inline(always)]
pub fn prefetch<T>(value: &T) {
    prefetch_at(std::slice::from_ref(value), 0);
}

/// The same for an entry of a list; without a look at whether there is such an entry.
#[inline(always)]
pub fn prefetch_at<T>(list: &[T], index: usize) {
    let start = list.as_ptr().wrapping_add(index).cast::<i8>();
    for line in 0..size_of::<T>().div_ceil(64) {
        prefetch_line(start.wrapping_add(64 * line));
    }
}

#[allow(clippy::pointers_in_nomem_asm_block, reason = "a hint changes nothing that the program sees")]
#[inline(always)]
fn prefetch_line(at: *const i8) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: prefetching is a hint on any address, and every x86-64 CPU has it.
    unsafe {
        std::arch::x86_64::_mm_prefetch(at, std::arch::x86_64::_MM_HINT_T0);
    }
    #[cfg(target_arch = "aarch64")]
    // SAFETY: the same of every 64-bit ARM CPU.
    unsafe {
        std::arch::asm!("prfm pldl1keep, [{}]", in(reg) at, options(nomem, nostack, preserves_flags));
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    let _ = at;
}
