//! The short form of the depths of polyhedra.

use feeler_exact::depths::run;
use feeler_exact::polyhedra::KINDS;

#[test]
fn no_point_is_deeper_than_is_said_and_the_one_that_is_shown_is_as_deep() {
    let rows = run(40, 2004, 0, &[], &|_, _| {}).unwrap();
    assert_eq!(rows.len(), KINDS.len());
    for (family, t) in &rows {
        assert_eq!((t.fault_count, &t.faults), (0, &Vec::new()), "{}", family.name);
        assert!(
            t.cases == 40 && t.figures.deep >= 10 && t.figures.points > 100,
            "{} makes few depths: {t:?}",
            family.name
        );
        assert!(10 * t.figures.open <= t.cases, "{}: {t:?}", family.name);
        // Sampling would find depths that are too small.
        assert!(5 * t.figures.reached >= 2 * t.figures.deep, "{}: {t:?}", family.name);
    }
    assert!(rows.iter().map(|(_, t)| t.figures.shallow).sum::<u64>() > 50);
}

#[test]
fn the_figures_depend_on_the_seed_and_the_number_alone() {
    let only = ["turned".to_string()];
    let in_pool = |threads: usize, from: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(6, 5, from, &only, &|_, _| {})).unwrap()[0].1.clone()
    };
    assert_eq!(in_pool(1, 0), in_pool(3, 0));
    assert_ne!(in_pool(1, 0), in_pool(1, 6));
}

#[test]
fn an_unknown_family_is_named() {
    let why = run(1, 1, 0, &["gem".into()], &|_, _| {}).err().unwrap();
    assert!(why.contains("\"gem\"") && why.contains("gems,"), "{why}");
}
