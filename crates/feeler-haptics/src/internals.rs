//! The engine below [`Session`](crate::Session), for the tests, examples and measurements of feeler's own crates. It may change with
//! every version.

pub use crate::constraint_set::ConstraintSet;
pub use crate::device::mapping::Mapping;
pub use crate::force::{ForceInput, ForceLoop};
pub use crate::proxy::Proxy;
pub use crate::servo::{Servo, ServoInput};
pub use crate::shading::Shading;
pub use crate::velocity::VelocityEstimate;
