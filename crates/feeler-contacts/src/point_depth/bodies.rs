//! The bodies of a mock-up's parts: made on demand, and cached up to a limit.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::body::Body;
use crate::constants::MOST_KEPT_TRIANGLES;

/// See the module. Any number of threads may ask it at once.
#[derive(Debug, Default)]
pub struct Bodies {
    kept: Mutex<Kept>,
}

#[derive(Debug, Default)]
struct Kept {
    /// Each with when it was last asked for.
    of_part: HashMap<u32, (Arc<Body>, u64)>,
    triangles: usize,
    asked: u64,
}

impl Bodies {
    /// The body of a part; `make` makes it, where it is not kept.
    pub fn of(&self, part: u32, make: impl FnOnce() -> Body) -> Arc<Body> {
        let kept = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(body) = kept().find(part) {
            return body;
        }
        // Not while others wait: two threads may make the same.
        let made = Arc::new(make());
        kept().keep(part, &made);
        made
    }
}

impl Kept {
    fn find(&mut self, part: u32) -> Option<Arc<Body>> {
        self.asked += 1;
        let (body, when) = self.of_part.get_mut(&part)?;
        *when = self.asked;
        Some(body.clone())
    }

    /// Keeps one, and gives up those that were not asked for the longest time. Two of the largest always have room, so that a pair is not
    /// made anew for every look at it.
    fn keep(&mut self, part: u32, body: &Arc<Body>) {
        self.asked += 1;
        if let Some((earlier, _)) = self.of_part.insert(part, (body.clone(), self.asked)) {
            self.triangles -= earlier.len();
        }
        self.triangles += body.len();
        let largest = self.of_part.values().map(|(body, _)| body.len()).max().unwrap_or(0);
        if self.triangles <= MOST_KEPT_TRIANGLES.max(2 * largest) {
            return;
        }
        let mut oldest: Vec<(u64, u32, usize)> =
            self.of_part.iter().map(|(part, (body, when))| (*when, *part, body.len())).collect();
        oldest.sort_unstable();
        // By half, so that this is seldom; the body used last stays.
        let enough = (MOST_KEPT_TRIANGLES / 2).max(2 * largest);
        oldest.pop();
        for (_, part, triangles) in oldest {
            if self.triangles <= enough {
                break;
            }
            self.of_part.remove(&part);
            self.triangles -= triangles;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_core::mesh::topology::adjacency::Adjacency;
    use std::cell::Cell;

    fn body(triangles: usize) -> Body {
        let adjacency = Adjacency::of_neighbours(vec![[0; 3]; triangles]);
        let t = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        Body::new((0..triangles as u32).map(|i| (i, t)), &adjacency)
    }

    #[test]
    fn a_large_body_is_not_made_again_for_each_of_many_small_ones() {
        let (bodies, made) = (Bodies::default(), Cell::new(0));
        let large = MOST_KEPT_TRIANGLES / 8;
        for small in 1..20 {
            bodies.of(0, || {
                made.set(made.get() + 1);
                body(large)
            });
            bodies.of(small, || body(large / 2));
        }
        assert_eq!(made.get(), 1);
        assert!(bodies.kept.lock().unwrap().triangles <= MOST_KEPT_TRIANGLES);
    }
}
