//! The short form of the mass of casts.

use feeler_exact::casts::run;

#[test]
fn twenty_thousand_casts_neither_tunnel_nor_are_late() {
    let tally = run(20_000, 2004, 0);
    assert_eq!(tally.faults, Vec::<String>::new());
    assert!(tally.is_right());
    assert!(
        tally.casts > 15_000 && tally.screws > 4_000 && tally.chains > 4_000 && tally.spinning > 1_400,
        "{tally:?}"
    );
}

#[test]
fn the_figures_depend_on_the_seed_alone() {
    let in_pool = |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    assert_eq!(in_pool(1).install(|| run(500, 5, 3)), in_pool(3).install(|| run(500, 5, 3)));
}
