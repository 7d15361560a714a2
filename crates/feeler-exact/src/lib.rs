//! Holds feeler-core to exact rational arithmetic.
//!
//! The [`oracle`] decides any pair of triangles slowly and obviously. The [`corpus`] keeps hard pairs by name, made by
//! [`families`] of cases. The [`mass`] aims millions of [`pairs`] and whole [`scenes`] at the core; what fails is shrunk by
//! [`minimise`] to a line of the corpus. [`distance`] does for distances what the oracle does for meetings. No product code depends on this crate.

pub mod check;
pub mod corpus;
pub mod distance;
pub mod families;
pub mod mass;
pub mod minimise;
pub mod oracle;
pub mod pairs;
pub mod random;
pub mod scenes;
pub mod shapes;
pub mod sieve;
