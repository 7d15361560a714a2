//! The swept volume of a tool, as a closed mesh that contains it.
//!
//! **The set.** Each segment of the motion is cut into steps, and the places of a triangle at both ends of a step have
//! a convex hull (`steps.rs`). The union `H` of these hulls is the swept surface `S` up to bounded errors: `S` lies
//! within `short` of `H` and `H` within `wide` of `S` ([`feeler_core::Chord`]).
//!
//! **The field.** At the nodes of a grid of spacing `h` the value is `g = max(0, distance to H - short - rounding)`, so
//! that `g <= distance to S <= g + share`, where `share` is the sum of the errors above and the tolerance of distances
//! (`hull.rs`). In the six tetrahedra of each cell (H. W. Kuhn 1960: the same diagonals on both sides of every face) it
//! is interpolated; the mesh is its level set at `c` (`cells.rs`), which is closed, each edge twice, once each way.
//!
//! **Nothing of `S` is outside.** At a point `p` of `S` the value at a node `v` is at most `|p - v|`, and with the weights `w` of the
//! interpolation `sum w |p - v| <= sqrt(sum w |p - v|^2) <= sqrt(3)/2 h`: in the tetrahedron `x >= y >= z` the second sum is `x + y
//! + z - x^2 - y^2 - z^2`. The level is above that.
//!
//! **The mesh is nowhere farther than the error.** At a point `q` of the mesh, each node `v` of its tetrahedron is at
//! most `g(v) + share` from `S`, and `q` at most `|q - v|` more; weighted, that is `c + share + sqrt(3)/2 h` at most,
//! which is the error.
//!
//! **Inside.** Two nodes of a tetrahedron whose values are above `sqrt(3)/2 h` have no point of `S` between them. So
//! nodes outside the mesh that are connected by edges are on one side of every surface of the tool at every time, and
//! one of them at one pose decides whether they are inside its closed surfaces. If so they are swept, too, and count as
//! inside the mesh; if not they are outside, or in a cavity that stays.
//!
//! **The search** (`tree.rs`) halves space, with the hulls near each cube, down to blocks of 8 by 8 by 8 cells. A cube
//! far from all hulls, and one that lies in a single hull, has no surface in it. A block needs no other one: nodes on
//! its border are computed the same on both sides, so the result does not depend on threads.

pub mod sweep;

mod block;
mod cells;
mod hull;
mod join;
mod steps;
mod tree;
