//! The short form of the mass: every generator, a hundred thousand pairs, nothing wrong.

use feeler_exact::mass::{run, total, GENERATORS};

#[test]
fn a_hundred_thousand_pairs_are_as_exact_arithmetic_says() {
    let rows = run(100_000, 2004, &[], &|_, _| {}).unwrap();
    assert_eq!(rows.len(), GENERATORS.len());
    for row in &rows {
        let t = &row.tally;
        assert_eq!((t.mismatch_count, &t.mismatches), (0, &Vec::new()), "{}", row.name);
        assert_eq!(t.by_answer.iter().sum::<u64>(), t.pairs, "{}", row.name);
        assert!(t.by_answer.iter().filter(|n| **n > 0).count() >= 2, "{} makes one kind only: {t:?}", row.name);
        assert!(t.scene_queries > 0 || row.name == "without-area", "{} makes no scenes", row.name);
    }
    let t = total(&rows).tally;
    assert!(t.pairs >= 100_000 && t.by_answer.iter().all(|n| *n > 2000), "{t:?}");
    assert!(t.exact > 10_000 && t.exact < t.reached, "{t:?}");
}

#[test]
fn the_figures_depend_on_the_seed_alone() {
    let only = ["lattice".to_string(), "gears".to_string()];
    let in_pool = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let rows = pool.install(|| run(4000, seed, &only, &|_, _| {})).unwrap();
        rows.into_iter().map(|row| row.tally).collect::<Vec<_>>()
    };
    assert_eq!(in_pool(1, 5), in_pool(3, 5));
    assert_ne!(in_pool(1, 5), in_pool(1, 6));
}

#[test]
fn an_unknown_generator_is_named() {
    let why = run(1, 1, &["gear".into()], &|_, _| {}).unwrap_err();
    assert!(why.contains("\"gear\"") && why.contains("gears"), "{why}");
}
