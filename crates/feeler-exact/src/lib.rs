//! Holds feeler to exact arithmetic.
//!
//! The [`oracle`] decides any pair of triangles slowly and obviously. The [`corpus`] keeps hard pairs by name, made by
//! [`families`] of cases. The [`mass`] aims millions of [`pairs`] and whole [`scenes`] at the core; what fails is shrunk by
//! [`minimise`] to a line of the corpus. [`distance`] does for distances what the oracle does for meetings. A mass
//! of [`casts`] is known to hit. Sets of [`bodies`] are all moved. How deep [`concave`] solids of [`blocks`] are in each other is known to the judge of [`contacts`].
//! How deep [`polyhedra`] are in each other by points, the judge of [`depths`] asks points in whole numbers of [`spots`].
//! No product code depends on this crate.
//!
//! ```
//! use feeler_core::PairKind;
//! use feeler_exact::oracle::kind_of_pair;
//!
//! let floor = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let above = |z: f64| [[0.25, 0.25, z], [0.5, 0.25, 1.0], [0.25, 0.5, 1.0]];
//! assert_eq!(kind_of_pair(&floor, &above(0.0)), Some(PairKind::Touching));
//! assert_eq!(kind_of_pair(&floor, &above(f64::MIN_POSITIVE)), None);
//! assert_eq!(kind_of_pair(&floor, &above(-f64::MIN_POSITIVE)), Some(PairKind::Crossing));
//! ```

pub mod blocks;
pub mod bodies;
pub mod casts;
pub mod check;
pub mod concave;
pub mod contacts;
pub mod corpus;
pub mod depths;
pub mod distance;
pub mod families;
pub mod mass;
pub mod minimise;
pub mod oracle;
pub mod pairs;
pub mod polyhedra;
pub mod random;
pub mod scenes;
pub mod shapes;
pub mod sieve;
pub mod spots;
pub mod tally;
