//! Which pairs of parts to check, and with which limits.

use std::collections::HashMap;

use crate::constants::COORDINATE_ROUNDOFFS;
use crate::error::{Error, Result};
use crate::geometry::bounds::Aabb;
use crate::index::interner::pair_key;

/// Which pairs of parts to check, and with which limits: by classes of parts, a table for each two of them.
#[derive(Debug, Clone, PartialEq)]
pub struct PairLimits {
    /// `(parts,)`: the class of each part; empty: all are of class 0.
    class_of_part: Vec<u32>,
    classes: usize,
    /// `(classes, classes)`, row by row, symmetric, metres.
    clearance: Vec<f64>,
    /// Likewise.
    contact: Vec<f64>,
    /// `(parts,)`, metres; empty: nothing.
    contact_of_part: Vec<f64>,
    /// `(parts,)`, metres, by which coordinates may be rounded; empty: nothing.
    rounding_of_part: Vec<f64>,
    /// Metres.
    copies_within: f64,
    /// Pairs never asked, the lesser part first; sorted.
    excluded: Vec<[u32; 2]>,
}

/// See [`PairLimits::new`].
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct PairLimitTables {
    /// `(parts,)`: the class of each part; empty: all are of class 0.
    pub class_of_part: Vec<u32>,
    /// `(classes, classes)`, row by row, symmetric: how near (metres) parts of two classes may come; negative: these are not asked.
    pub clearance: Vec<f64>,
    /// `(classes, classes)`, row by row, symmetric: how deep (metres) parts of two classes may be in each other, or how far apart, and
    /// still count as in contact.
    pub contact: Vec<f64>,
    /// `(parts,)`: added to the contact of each part's pairs, metres; empty: nothing.
    pub contact_of_part: Vec<f64>,
    /// How far apart (metres) rounding in a file may put two copies of one surface; 0: only the last places of coordinates differ.
    pub copies_within: f64,
    /// Pairs of parts that are never asked, in any order.
    pub excluded: Vec<[u32; 2]>,
}

impl PairLimitTables {
    /// Tables of the clearance and of the contact, each `(classes, classes)`, row by row, symmetric, metres.
    pub fn new(clearance: Vec<f64>, contact: Vec<f64>) -> PairLimitTables {
        PairLimitTables { clearance, contact, ..PairLimitTables::default() }
    }

    crate::setters! {
        with_class_of_part: class_of_part: Vec<u32>,
        with_clearance: clearance: Vec<f64>,
        with_contact: contact: Vec<f64>,
        with_contact_of_part: contact_of_part: Vec<f64>,
        with_copies_within: copies_within: f64,
        with_excluded: excluded: Vec<[u32; 2]>,
    }
}

impl PairLimits {
    /// One clearance and one contact for all pairs, metres.
    pub fn uniform(clearance: f64, contact: f64) -> Result<PairLimits> {
        let tables =
            PairLimitTables { clearance: vec![clearance], contact: vec![contact], ..PairLimitTables::default() };
        PairLimits::new(tables, 0)
    }

    /// Checks the tables for a mock-up with that number of parts.
    ///
    /// Errors: arrays of other lengths, classes that are not in the tables, invalid lengths, negative contacts, tables
    /// that are not symmetric, and parts that the mock-up does not have.
    pub fn new(tables: PairLimitTables, parts: usize) -> Result<PairLimits> {
        let PairLimitTables { class_of_part, clearance, contact, contact_of_part, copies_within, excluded } = tables;
        let classes = class_of_part.iter().map(|class| *class as usize + 1).max().unwrap_or(1);
        let classes = classes.max((clearance.len() as f64).sqrt() as usize);
        let expected =
            [("clearance", clearance.len(), classes * classes), ("contact", contact.len(), classes * classes)];
        let of_parts = [("class_of_part", class_of_part.len()), ("contact_of_part", contact_of_part.len())];
        let of_parts = of_parts.into_iter().filter(|(_, got)| *got != 0).map(|(what, got)| (what, got, parts));
        if let Some((what, got, expected)) =
            expected.into_iter().chain(of_parts).find(|(_, got, expected)| got != expected)
        {
            return Err(Error::Length { what, got, expected });
        }
        for (what, table, least) in [
            ("clearance", &clearance, f64::NEG_INFINITY),
            ("contact", &contact, 0.0),
            ("contact_of_part", &contact_of_part, 0.0),
            ("copies_within", &vec![copies_within], 0.0),
        ] {
            if let Some(value) = table.iter().copied().find(|x| !x.is_finite() || *x < least) {
                return Err(Error::Distance { what, value });
            }
        }
        for (what, table) in [("clearance", &clearance), ("contact", &contact)] {
            for row in 0..classes {
                for column in 0..row {
                    let values = [table[row * classes + column], table[column * classes + row]];
                    if values[0] != values[1] {
                        return Err(Error::NotSymmetric { what, row, column, values });
                    }
                }
            }
        }
        if let Some(part) = excluded.iter().flatten().find(|part| **part as usize >= parts) {
            return Err(Error::NoSuchPart { part: *part, parts });
        }
        let mut excluded: Vec<[u32; 2]> = excluded.into_iter().map(in_order).collect();
        excluded.sort_unstable();
        excluded.dedup();
        let rounding_of_part = Vec::new();
        Ok(PairLimits {
            class_of_part,
            classes,
            clearance,
            contact,
            contact_of_part,
            rounding_of_part,
            copies_within,
            excluded,
        })
    }

    /// The same, with contacts at least as large as the rounding of the parts' coordinates.
    pub fn with_rounding(&self, part_bounds: &[Aabb]) -> PairLimits {
        PairLimits { rounding_of_part: part_bounds.iter().map(coordinate_rounding).collect(), ..self.clone() }
    }

    /// How far the rounding of the coordinates of two parts may move their surfaces, metres.
    pub fn rounding(&self, a: u32, b: u32) -> f64 {
        let of_part = |part: u32| self.rounding_of_part.get(part as usize).copied().unwrap_or(0.0);
        of_part(a).max(of_part(b))
    }

    /// How far apart (metres) rounding may put two parts that are copies: here, and in the file.
    pub fn copies_within(&self, a: u32, b: u32) -> f64 {
        self.copies_within.max(self.rounding(a, b))
    }

    fn class(&self, part: u32) -> usize {
        self.class_of_part.get(part as usize).map_or(0, |class| *class as usize)
    }

    fn of_part(&self, part: u32) -> f64 {
        self.contact_of_part.get(part as usize).copied().unwrap_or(0.0)
    }

    /// How near (metres) two parts may come; `None` where the pair is not asked.
    pub fn clearance(&self, a: u32, b: u32) -> Option<f64> {
        let clearance = self.clearance[self.class(a) * self.classes + self.class(b)];
        (a != b && clearance >= 0.0 && !self.is_excluded(a, b)).then_some(clearance)
    }

    /// How deep (metres) two parts may be in each other, or how far apart, and still count as in contact.
    pub fn contact(&self, a: u32, b: u32) -> f64 {
        let contact = self.contact[self.class(a) * self.classes + self.class(b)] + self.of_part(a) + self.of_part(b);
        contact.max(self.rounding(a, b))
    }

    /// The largest relevant gap of a pair, metres; `None` if the pair is skipped.
    pub fn reach(&self, a: u32, b: u32) -> Option<f64> {
        self.clearance(a, b).map(|clearance| clearance.max(self.contact(a, b)))
    }

    /// The largest reach of all pairs, metres.
    pub fn largest_reach(&self) -> f64 {
        let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, x| most.max(*x));
        let contact = largest(&self.contact) + 2.0 * largest(&self.contact_of_part);
        largest(&self.clearance).max(contact).max(largest(&self.rounding_of_part))
    }

    fn is_excluded(&self, a: u32, b: u32) -> bool {
        self.excluded.binary_search(&in_order([a, b])).is_ok()
    }
}

/// Some units in the last place of the largest coordinate.
fn coordinate_rounding(bounds: &Aabb) -> f64 {
    let largest = bounds.largest_coordinate();
    COORDINATE_ROUNDOFFS * (largest.next_up() - largest)
}

/// The lesser first.
pub fn in_order([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Pairs of parts with their findings, by key; for results that several tasks found.
pub(crate) fn merged<T: Copy>(
    found: impl Iterator<Item = ([u32; 2], T)>,
    merge: impl Fn(T, T) -> T,
) -> Vec<([u32; 2], T)> {
    let mut of_pair: HashMap<u64, T> = HashMap::new();
    for (pair, new) in found {
        of_pair.entry(pair_key(pair[0], pair[1])).and_modify(|old| *old = merge(*old, new)).or_insert(new);
    }
    let mut all: Vec<([u32; 2], T)> =
        of_pair.into_iter().map(|(key, value)| ([(key >> 32) as u32, key as u32], value)).collect();
    all.sort_unstable_by_key(|(pair, _)| *pair);
    all
}
