//! Sorting, sets and maps that keep their memory from query to query.

pub(crate) mod bit_set;
pub(crate) mod bounded_interner;
pub(crate) mod counting_sort;
pub(crate) mod point_interner;
