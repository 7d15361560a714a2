//! The piece size of blocks for a tool: the one with the fewest overlapping boxes.
//!
//! With a tool's piece anywhere, turned anyhow, the pieces of the mock-up whose boxes its box meets are on average as many as
//! `product(b + e_a)`, summed over them, over the space: `b` is the mean width of the tool's piece, `e` the sides of the box of
//! the mock-up's. Cutting shrinks the boxes of long triangles, which are mostly empty, and adds `b^3` for each piece: the sum
//! has a minimum, at smaller sizes for finer tools. The same sum with the tool's clusters of 16 pieces counts the comparisons
//! before; it has its minimum at larger sizes, and a small weight (`CLUSTER_SHARE`).
//!
//! The sum is estimated from a sample: triangles are chosen in proportion to what they add uncut, and of each halving one half
//! is followed, at random, for both. So a sampled triangle of a thousand pieces costs ten halvings.

use super::random::Random;
use super::spread::{chosen, spread};
use crate::constants::{CHOSEN_CUT_ALLOWANCE, CLUSTER_SHARE, MAX_CUT_DEPTH};
use crate::geometry::bounds::{Aabb, Piece, Triangle};
use crate::index::blocks::Blocks;
use crate::mesh::pieces::{first_cut, grown_box, halves, least_piece_size, longest_edge};
use crate::mesh::triangle_mesh::Mesh;
use crate::tool::moving_tool::{Tool, Widths};

/// Triangles that are looked at, evenly spread over the mesh.
const TRIANGLES_LOOKED_AT: usize = 25_000;

/// Of these, the ones whose cutting is followed.
const FOLLOWED: usize = 2000;

/// The expected work of a query at a piece size, per piece of the tool and in cubic metres: divided by the volume in
/// which the tool may be it is the number of overlaps. Only ratios between sizes mean something.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[non_exhaustive]
pub struct PieceWork {
    /// Pieces of the mock-up whose boxes overlap that of a tool's piece.
    pub pairs: f64,
    /// The same for that of a cluster.
    pub cluster_pairs: f64,
    /// Pieces of the mock-up (a number).
    pub pieces: f64,
}

impl PieceWork {
    /// The cost to minimise, in units of a pair of pieces.
    pub fn cost(&self) -> f64 {
        self.pairs + CLUSTER_SHARE * self.cluster_pairs
    }
}

/// Predicts how the work of queries of a tool in a mock-up with blocks depends on the piece size.
#[derive(Debug)]
pub struct PiecePredictor {
    sample: Vec<Followed>,
    widths: Widths,
    triangles: f64,
    longest: f64,
}

/// A piece that stands for others.
#[derive(Debug, Clone)]
struct Followed {
    corners: Piece,
    /// Not cut yet.
    is_whole: bool,
    /// Its longest side, metres.
    reach: f64,
    /// It is not cut below this, metres.
    least: f64,
    /// How many pieces it stands for.
    weight: f64,
    /// Which halves to follow, a bit each.
    choices: u64,
}

impl PiecePredictor {
    /// Looks at a sample of the mock-up: a millisecond for any. `None` for meshes near the limits of float64.
    pub fn new(mesh: &Mesh, tool: &Tool) -> Option<PiecePredictor> {
        let ids = spread(mesh, TRIANGLES_LOOKED_AT);
        let each = mesh.queried_count() as f64 / ids.len() as f64;
        let widths = *tool.widths();
        let mut longest = 0.0f64;
        let mut shares: Vec<f64> = ids
            .iter()
            .map(|id| {
                let t = mesh.triangle(*id);
                longest = longest.max(longest_edge(&t));
                met(&Aabb::of_triangle(&t), &widths.pieces)
            })
            .collect();
        let total: f64 = shares.iter().sum();
        if !(total.is_normal() && longest.is_normal()) {
            return None;
        }
        // Half of the sample by what triangles add to the sum, half by number: pieces are counted too.
        let mean = total / shares.len() as f64;
        shares.iter_mut().for_each(|share| *share += mean);
        let mut random = Random::new(0);
        let sample = chosen(&ids, &shares, FOLLOWED)
            .into_iter()
            .flat_map(|(id, times, weight)| (0..times).map(move |_| (id, weight)))
            .map(|(id, weight)| Followed::new(&mesh.triangle(id), each * weight, random.bits()))
            .collect();
        Some(PiecePredictor { sample, widths, triangles: mesh.queried_count() as f64, longest })
    }

    /// The work of a query with pieces of `size` metres.
    pub fn work(&self, size: f64) -> PieceWork {
        let mut sample = self.sample.clone();
        sample.iter_mut().for_each(|piece| piece.shrink(size));
        self.sum(&sample)
    }

    /// The size (metres) with the least work, among those with about two extra pieces a triangle at most, and
    /// building which stays below `limit` bytes: one of a ladder of half octaves down from the longest edge.
    pub fn optimal_size(&self, limit: u64) -> f64 {
        // The number of pieces is an estimate.
        let fit = 0.9 * limit as f64 / Blocks::BUILD_BYTES_PER_PIECE;
        let most = fit.min((1.0 + CHOSEN_CUT_ALLOWANCE) * self.triangles);
        let mut sample = self.sample.clone();
        let (mut best, mut least) = (self.longest, self.sum(&sample).cost());
        let mut size = self.longest;
        for _ in 0..2 * MAX_CUT_DEPTH {
            size /= std::f64::consts::SQRT_2;
            sample.iter_mut().for_each(|piece| piece.shrink(size));
            let work = self.sum(&sample);
            if work.pieces > most {
                break;
            }
            if work.cost() < least {
                (best, least) = (size, work.cost());
            }
        }
        best
    }

    fn sum(&self, sample: &[Followed]) -> PieceWork {
        let mut work = PieceWork::default();
        for piece in sample {
            let b = grown_box(&piece.corners, 0.0);
            work.pairs += piece.weight * met(&b, &self.widths.pieces);
            work.cluster_pairs += piece.weight * met(&b, &self.widths.clusters);
            work.pieces += piece.weight;
        }
        work
    }
}

impl Followed {
    fn new(t: &Triangle, weight: f64, choices: u64) -> Followed {
        let [a, b, c] = *t;
        let (reach, least) = (longest_edge(t), least_piece_size(t));
        Followed { corners: [a, b, c, c], is_whole: true, reach, least, weight, choices }
    }

    /// Goes on to pieces of `size` metres.
    fn shrink(&mut self, size: f64) {
        let size = size.max(self.least);
        if self.reach <= size {
            return;
        }
        if self.is_whole {
            self.is_whole = false;
            let [a, b, c, _] = self.corners;
            match first_cut(&[a, b, c], size) {
                (one, None) => self.corners = one,
                (one, Some(other)) => self.follow([one, other]),
            }
        }
        while let Some(pair) = halves(&self.corners, size) {
            self.follow(pair);
        }
        self.reach = size;
    }

    fn follow(&mut self, pair: [Piece; 2]) {
        self.corners = pair[(self.choices & 1) as usize];
        self.choices = self.choices.rotate_right(1);
        self.weight *= 2.0;
    }
}

/// The volume in which the middle of a box of a mean width lies when it meets a given box, from the means of the powers of widths.
fn met(b: &Aabb, widths: &[f64; 3]) -> f64 {
    let [x, y, z] = b.extent();
    x * y * z + widths[0] * (x * y + y * z + z * x) + widths[1] * (x + y + z) + widths[2]
}
