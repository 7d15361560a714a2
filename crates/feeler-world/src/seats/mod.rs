//! Seats: what the tool meets where it starts, surface by surface, and what it may meet until it has parted from that.

mod erosion;
mod find;
mod place;
mod seated;

pub use find::{Allowed, Seat, SeatKind};
pub use seated::Seated;

pub(crate) use find::find_seats;
pub(crate) use place::{crossing_outside, crossings_in_place, Inside};
pub(crate) use seated::{Makings, SeatedBody, SmallerPart};
