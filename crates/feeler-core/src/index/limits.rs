//! Limits of an index: bytes, and entries that 32-bit positions can address.

use crate::error::{Error, Result};

/// Refuses structures that would need more than `limit` bytes.
pub fn check_memory(what: &'static str, needed: f64, limit: u64) -> Result<()> {
    if needed <= limit as f64 {
        return Ok(());
    }
    Err(out_of_memory(what, needed, limit))
}

fn out_of_memory(what: &'static str, needed: f64, limit: u64) -> Error {
    let advice = "choose a larger voxel size, or allow more memory if the machine has it";
    Error::Memory { what, needed: needed.min(u64::MAX as f64) as u64, allowed: limit, advice }
}

/// Refuses more entries than 32-bit positions can address. `count` is a bound from below.
pub fn check_entries(voxel_size: f64, count: f64) -> Result<()> {
    if count <= f64::from(u32::MAX) {
        return Ok(());
    }
    Err(Error::TooManyEntries { voxel_size, entries: count.min(u64::MAX as f64) as u64 })
}

/// `length` default values, or an error where the system has no memory for them.
pub fn filled<T: Default + Send>(what: &'static str, length: u64, limit: u64) -> Result<Vec<T>> {
    let mut values = Vec::new();
    let bytes = length as f64 * size_of::<T>() as f64;
    let length = usize::try_from(length).map_err(|_| out_of_memory(what, bytes, limit))?;
    values.try_reserve_exact(length).map_err(|_| out_of_memory(what, bytes, limit))?;
    values.resize_with(length, T::default);
    Ok(values)
}
