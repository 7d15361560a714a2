//! Asks the oracle and the core how two triangles meet, while one comes down to the other by single units in the last place.
//!
//!     cargo run --release -p feeler-exact --example judge

use feeler_core::intersect_triangle_triangle;
use feeler_exact::corpus::word;
use feeler_exact::oracle::kind_of_pair;

fn main() {
    // A triangle that leans, and one whose lowest corner is near the middle of it.
    let floor = [[0.1, 0.0, 0.3], [1.1, 0.0, 0.7], [0.1, 1.0, 0.9]];
    let middle = [1.3 / 3.0, 1.0 / 3.0, 1.9 / 3.0f64];
    let mut height = middle[2];
    for _ in 0..4 {
        height = height.next_up();
    }
    for _ in 0..8 {
        let above = [[middle[0], middle[1], height], [0.5, 0.2, 2.0], [0.2, 0.5, 2.0]];
        // Exact rational arithmetic, and the core's filtered predicates.
        let (truth, found) = (kind_of_pair(&floor, &above), intersect_triangle_triangle(&floor, &above));
        println!("corner at {height:.17}: the oracle says {}, the core says {}", word(truth), word(found));
        assert_eq!(truth, found);
        height = height.next_down();
    }
}
