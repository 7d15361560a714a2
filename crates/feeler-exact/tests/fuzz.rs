//! A short smoke of the fuzz targets in Rust; `make fuzz` runs them for long, guided by coverage.

#[path = "../../../fuzz/src/lib.rs"]
mod targets;

use std::fs;
use std::panic::UnwindSafe;
use std::path::Path;

use arbitrary::{Arbitrary, Unstructured};
use feeler_exact::random::Random;

/// Checks the seeds of a target, and this many random changes of each, as libFuzzer would.
fn smoke<C: for<'a> Arbitrary<'a> + UnwindSafe>(target: &str, changes: usize, check: fn(C)) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds").join(target);
    let mut seeds: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    seeds.sort();
    assert!(!seeds.is_empty());
    let mut r = Random::new(0);
    for path in seeds {
        let seed = fs::read(path).unwrap();
        for i in 0..=changes {
            let mut data = seed.clone();
            for _ in 0..if i == 0 { 0 } else { 1 + r.below(8) } {
                change(&mut data, &mut r);
            }
            // Too few bytes make no case.
            if let Ok(case) = C::arbitrary_take_rest(Unstructured::new(&data)) {
                let outcome = std::panic::catch_unwind(|| check(case));
                assert!(outcome.is_ok(), "{target}: {data:?}");
            }
        }
    }
}

fn change(data: &mut Vec<u8>, r: &mut Random) {
    let at = r.below(data.len() + 1);
    let to = (at + 1 + r.below(16)).min(data.len());
    match r.below(3) {
        0 if at < to => data[at] = r.bits() as u8,
        1 => drop(data.drain(at..to)),
        _ => data.extend((at..to + 8).map(|_| r.bits() as u8)),
    }
}

#[test]
fn collisions() {
    smoke("collide", 40, targets::collide::check);
}

#[test]
fn contact_planes() {
    smoke("contacts", 20, targets::contacts::check);
}

#[test]
fn distances() {
    smoke("distance", 40, targets::distance::check);
}

#[test]
fn meshes() {
    smoke("mesh", 200, targets::mesh::check);
}

#[test]
fn saved_scenes() {
    smoke("saved_scene", 20, targets::saved_scene::check);
}
