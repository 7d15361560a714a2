//! A kernel of one's own: the largest coordinate of many points, sixteen at once, with every instruction set of this CPU.
//!
//!     cargo run --release -p feeler-lanes --example farthest

use feeler_lanes::{Kernel, Level, Simd, LANES};

/// The largest size of some numbers, which come in rows of sixteen.
struct Largest<'a>(&'a [[f32; LANES]]);

impl Kernel for Largest<'_> {
    type Output = f32;

    // Inlined, so that all of it is compiled for the instruction set that is asked for.
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> f32 {
        let mut largest = s.splat(0.0);
        for row in self.0 {
            largest = s.max(largest, s.abs(s.load(row)));
        }
        let mut lanes = [0.0; LANES];
        s.store(largest, &mut lanes);
        lanes.into_iter().fold(0.0, f32::max)
    }
}

fn main() {
    let number = |i: usize| (i as f32 * 0.7).sin() * (i % 100) as f32;
    let rows: Vec<[f32; LANES]> = (0..1000).map(|row| std::array::from_fn(|lane| number(LANES * row + lane))).collect();
    println!("this CPU is best used with {}", Level::best().name());
    let expected = rows.iter().flatten().fold(0.0, |most: f32, x| most.max(x.abs()));
    for level in Level::available() {
        // The same kernel, compiled for each; the answers are the same.
        let found = level.checked().run(Largest(&rows));
        println!("{}: {found}", level.name());
        assert_eq!(found, expected);
    }
}
