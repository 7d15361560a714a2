//! Ways out: removal of a part from a large triangle mock-up, and the volume that a motion sweeps.

mod swept;

pub use swept::sweep::{swept, Swept};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
