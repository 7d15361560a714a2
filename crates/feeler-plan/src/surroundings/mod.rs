//! What a part is taken out of: how far it moves freely, and what it may touch on the way.

mod place;
mod seated;
mod seats;
mod walk;

pub use seated::Seated;
pub use seats::Allowed;
pub use walk::{Care, Span, Surroundings};
