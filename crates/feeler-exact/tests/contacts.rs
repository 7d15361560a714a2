//! The short form of the contacts of concave solids.

use feeler_exact::concave::FAMILIES;
use feeler_exact::contacts::run;

#[test]
fn contacts_of_concave_solids_are_as_deep_as_they_are_made() {
    let rows = run(80, 2004, 0, &[], 1500, &|_, _| {}).unwrap();
    assert_eq!(rows.len(), FAMILIES.len());
    for (family, t) in &rows {
        assert_eq!((t.fault_count, &t.faults), (0, &Vec::new()), "{}", family.name);
        assert!(t.cases == 80 && t.figures.deep > 30 && t.figures.near > 5, "{} makes few planes: {t:?}", family.name);
        // Wedged tools, and tools without a usable plane, are freed too; with planes the translation is mostly the shortest.
        let [_, bound, estimate] = t.figures.ways;
        assert!(estimate == 0 && bound > 20 && 2 * t.figures.close_bounds >= bound, "{}: {t:?}", family.name);
    }
    assert!(rows.iter().map(|(_, t)| t.triangles).sum::<u64>() > 100_000);
}

#[test]
fn the_figures_depend_on_the_seed_and_the_number_alone() {
    let only = ["rack".to_string()];
    let in_pool = |threads: usize, from: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(6, 5, from, &only, 200, &|_, _| {})).unwrap()[0].1.clone()
    };
    assert_eq!(in_pool(1, 0), in_pool(3, 0));
    assert_ne!(in_pool(1, 0), in_pool(1, 6));
}

#[test]
fn an_unknown_family_is_named() {
    let why = run(1, 1, 0, &["racks".into()], 100, &|_, _| {}).err().unwrap();
    assert!(why.contains("\"racks\"") && why.contains("rack,"), "{why}");
}
