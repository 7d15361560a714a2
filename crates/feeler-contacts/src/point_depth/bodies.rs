//! The bodies of a mock-up's parts: each is made when first asked for, and kept as long as they are not too many.

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
    of_part: HashMap<u32, Arc<Body>>,
    triangles: usize,
}

impl Bodies {
    /// The body of a part; `make` makes it, where it is not kept.
    pub fn of(&self, part: u32, make: impl FnOnce() -> Body) -> Arc<Body> {
        let kept = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(body) = kept().of_part.get(&part) {
            return body.clone();
        }
        // Not while others wait: two threads may make the same.
        let made = Arc::new(make());
        let mut kept = kept();
        if kept.triangles + made.len() > MOST_KEPT_TRIANGLES {
            kept.of_part.clear();
            kept.triangles = 0;
        }
        kept.triangles += made.len();
        kept.of_part.insert(part, made.clone());
        made
    }
}
