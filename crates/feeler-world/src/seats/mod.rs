//! Seats: the contacts at the tool's start, surface by surface, and the contacts allowed until they have separated.

mod beyond;
mod erosion;
mod fans;
mod find;
mod flush;
mod inwards;
mod place;
mod pockets;
mod seated;

pub use find::{Allowed, Seat, SeatKind};
pub use seated::Seated;

pub(crate) use beyond::{beyond, surface_in, Beyond};
pub(crate) use erosion::Erosion;
pub(crate) use find::find_seats;
pub(crate) use flush::{flush_points, Flush, FlushAt};
pub(crate) use place::{crossing_outside, crossings_in_place, AtStart, Inside};
pub(crate) use pockets::{pockets, Filled};
pub(crate) use seated::{Makings, SeatedBody, SmallerPart};
