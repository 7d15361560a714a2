//! Poses as the types of other crates have them, each behind a feature of its name.

#[cfg(feature = "glam")]
mod glam;
#[cfg(feature = "nalgebra")]
mod nalgebra;
