//! The cases of the corpus, designed family by family.
//!
//! Most answers follow from the design and are written beside the case. Where rounding decides (a neighbour of a number,
//! a decimal fraction), the oracle gives the answer. Making the corpus checks every designed answer with the oracle.

mod book;
mod coplanar;
mod crossing;
mod numbers;

use crate::corpus::Case;
use book::Book;

const HEAD: &str = "\
# Pairs of triangles that make trouble, and how they meet.
#
# One a line:  name | first triangle | second triangle | apart, coplanar, crossing or touching
#
# A triangle is nine numbers, x y z of each corner, metres; each is the shortest decimal that reads back as the float64
# meant. Triangles are closed: sharing one point is meeting. The second always has an area; the first may have lost it, as
# a tool's triangle can at a pose. `coplanar`: one plane. `crossing`: two planes, each triangle strictly on both sides of
# the other's, more than a point shared. `touching`: every other way to meet.
#
# Tests run each pair in all 72 orderings, mirrored, turned and scaled, through the triangle test and through scenes.
# Made by `cargo run -p feeler-exact -- corpus`, which checks each answer in exact arithmetic.
# Cases found by accident go to the end, under their own heading; they are kept.
";

/// The heading under which found cases are kept when the corpus is made anew.
pub const FOUND: &str = "# Found by accident.";

/// All designed cases, in order. Panics when a designed answer is not what exact arithmetic says, or a name is used twice.
pub fn cases() -> Vec<Case> {
    let mut book = Book { cases: Vec::new(), names: std::collections::HashSet::new() };
    crossing::add(&mut book);
    coplanar::add(&mut book);
    numbers::add(&mut book);
    book.cases
}

/// The corpus file: head, designed cases, and the found ones of the file before.
pub fn corpus(before: &str) -> String {
    let mut text = String::from(HEAD);
    let mut family = String::new();
    for case in cases() {
        let of_case = case.name.split([' ', ':', ',']).next().unwrap_or_default();
        if of_case != family {
            text += "\n";
            family = of_case.into();
        }
        text += &case.line();
        text += "\n";
    }
    text += "\n";
    text += before.find(FOUND).map_or(FOUND, |at| &before[at..]);
    text.truncate(text.trim_end().len());
    text + "\n"
}
