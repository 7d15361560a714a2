//! Lanes: sixteen float32 or eight float64 at once, with the widest instructions the CPU has.
//!
//! Kernels are written once, generic over [`Simd`], as a type that implements [`Kernel`]; [`Checked::run`] compiles them for each
//! instruction set (AVX-512, AVX2, NEON, plain code) and calls the one asked for, [`Level::best`] asks the CPU. All `unsafe` code of the
//! pure crates of feeler is here. It knows no meshes.
//!
//! ```
//! use feeler_lanes::{Arithmetic, Kernel, Level, Simd, LANES};
//!
//! /// Sixteen numbers, none of which counts as less than 1.
//! struct Clamped<'a>(&'a [f32; LANES]);
//!
//! impl Kernel for Clamped<'_> {
//!     type Output = [f32; LANES];
//!
//!     #[inline(always)]
//!     fn run<S: Simd>(self, s: S) -> [f32; LANES] {
//!         let mut out = [0.0; LANES];
//!         s.store(s.max(s.load(self.0), s.splat(1.0)), &mut out);
//!         out
//!     }
//! }
//!
//! for level in Level::available() {
//!     assert_eq!(level.checked().run(Clamped(&[0.5; LANES])), [1.0; LANES]);
//! }
//! ```

mod boxes;
mod column;
mod constants;
mod simd;
mod sort;
mod split_mix;

pub use boxes::{
    along, boxes_apart, greatest, greatest4, least, least4, load3, load_few3, splat3, Box4, Lane32, LaneBoxes,
    SpreadBoxes,
};
pub use column::{Column, SharedBytes, SharedMemory, COLUMN_ALIGNMENT};
pub use constants::TINY;
pub use simd::{
    few_lanes, part_lanes, prefetch, prefetch_at, Arithmetic, ByteBoxes, ByteLanes, CacheLine, Checked, Kernel, Level,
    LineLanes, Simd, Wide, FEW, LANES, WIDE_LANES,
};
pub use sort::Sorter;
pub use split_mix::{mixed, SplitMix64};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
