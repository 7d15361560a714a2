//! Lanes: sixteen float32 or eight float64 at once, with the widest instructions the CPU has.
//!
//! Kernels are written once, generic over [`Simd`], as a type that implements [`Kernel`]. [`Checked::run`] compiles
//! them for each instruction set and calls the selected one; [`Level::best`] detects the CPU's. All `unsafe` code of
//! the core is here: each wrapper around an instruction relies on a token ([`Simd`]) that only [`Checked::run`] makes,
//! for a level the CPU has.
//!
//! No level fuses a multiplication with an addition unless the kernel says so ([`Arithmetic::mul_add`]), so float64 kernels give the
//! same numbers on each.

#![allow(unsafe_code, reason = "instructions a CPU may lack: the rest of the core is free of unsafe code")]

mod arithmetic;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod level;
#[cfg(all(target_arch = "aarch64", target_endian = "little"))]
mod neon;
mod portable;
mod prefetch;
#[cfg(any(target_arch = "x86_64", all(target_arch = "aarch64", target_endian = "little")))]
mod registers;
#[cfg(test)]
mod twins;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use arithmetic::{
    few_lanes, part_lanes, Arithmetic, ByteBoxes, ByteLanes, CacheLine, Kernel, LineLanes, Simd, Wide, FEW, LANES,
    WIDE_LANES,
};
pub use level::{Checked, Level};
pub use prefetch::{prefetch, prefetch_at};
