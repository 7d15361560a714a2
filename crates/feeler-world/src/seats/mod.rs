//! Seats: the contacts at the tool's start, surface by surface, and the contacts allowed until they have separated.

mod around;
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

pub(crate) use around::find_around;
pub(crate) use beyond::{beyond, scene_of, surface_in, tool_of, Beyond};
pub(crate) use erosion::Erosion;
pub(crate) use find::find_seats;
pub(crate) use flush::{flush_points, Flush, FlushAt};
pub(crate) use place::{crossing_outside, crossings_in_place, Around, AtStart, Inside};
pub(crate) use pockets::{pockets, Filled};
pub(crate) use seated::{Makings, SeatedBody, SmallerPart};
