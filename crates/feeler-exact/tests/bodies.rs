//! The short form of the judge of bodies.

use feeler_exact::bodies::run;

#[test]
fn bodies_that_all_move_meet_as_exact_arithmetic_says() {
    let tally = run(60, 2026);
    assert_eq!(tally.faults, Vec::<String>::new());
    assert_eq!(tally.wrong, 0);
    assert!(tally.pairs > 500_000 && tally.meeting > 5_000, "{tally:?}");
}
