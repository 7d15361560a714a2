//! Every case of the corpus, in every ordering, mirrored, turned and scaled, through the triangle test and through scenes.

use feeler_core::{intersect_triangle_triangle, Point, Pose, Storage, Triangle};
use feeler_exact::check::{Checked, STORES};
use feeler_exact::corpus::{parse, word, Case};
use feeler_exact::random::ORDERS;
use feeler_exact::scenes::Setup;
use feeler_exact::{families, oracle};
use rayon::prelude::*;

const TEXT: &str = include_str!("../../../testdata/triangle_pairs.txt");

fn cases() -> Vec<Case> {
    parse(TEXT).unwrap()
}

/// Axes permuted (6 ways) and turned round (8 ways): 48 maps, half of them mirrors.
fn turns() -> Vec<impl Fn(&Triangle) -> Triangle> {
    let map = |axes: [usize; 3], signs: usize| {
        move |t: &Triangle| t.map(|c| [0, 1, 2].map(|i| if signs >> i & 1 == 1 { -c[axes[i]] } else { c[axes[i]] }))
    };
    ORDERS.iter().flat_map(|axes| (0..8).map(move |signs| map(*axes, signs))).collect()
}

/// The pair times a power of two, which is exact.
fn scaled(p: &Triangle, q: &Triangle, factor: f64) -> Option<[Triangle; 2]> {
    let larger = [p, q].map(|t| t.map(|c| c.map(|x| x * factor)));
    let is_exact = |t: &Triangle, u: &Triangle| {
        t.iter().flatten().zip(u.iter().flatten()).all(|(x, y)| y / factor == *x && y.abs() <= 1e100)
    };
    (is_exact(p, &larger[0]) && is_exact(q, &larger[1])).then_some(larger)
}

#[test]
fn there_are_hundreds_and_the_file_is_what_the_families_make() {
    assert!(cases().len() >= 300);
    assert!(families::corpus(TEXT) == TEXT, "make it anew: cargo run -p feeler-exact -- corpus");
    for answer in ["apart", "coplanar", "crossing", "touching"] {
        assert!(cases().iter().filter(|case| word(case.answer) == answer).count() > 50, "{answer}");
    }
}

#[test]
fn the_oracle_agrees_with_every_line() {
    for case in cases() {
        assert_eq!(word(oracle::kind_of_pair(&case.p, &case.q)), word(case.answer), "{}", case.name);
        assert_eq!(word(oracle::kind_of_pair(&case.q, &case.p)), word(case.answer), "{}, swapped", case.name);
    }
}

#[test]
fn the_core_agrees_in_all_72_orderings_under_all_exact_maps() {
    let turns = turns();
    assert_eq!(turns.len(), 48);
    let factors = [1.0, 1.0 / 8.0, 1048576.0, 2f64.powi(-300), 2f64.powi(200)];
    let tested: usize = cases()
        .par_iter()
        .map(|case| {
            let mut tested = 0;
            for factor in factors {
                let Some([p, q]) = scaled(&case.p, &case.q, factor) else { continue };
                for (n, turn) in turns.iter().enumerate() {
                    // All orderings of every turned pair; of the scaled ones a different ordering for each turn.
                    let step = if factor == 1.0 { 1 } else { 9 };
                    let (p, q) = (turn(&p), turn(&q));
                    for i in (n % step..36).step_by(step) {
                        let (a, b) = (ORDERS[i / 6].map(|i| p[i]), ORDERS[i % 6].map(|i| q[i]));
                        for (a, b) in [(&a, &b), (&b, &a)] {
                            let answer = intersect_triangle_triangle(a, b);
                            let what = format_args!("{}: {a:?} {b:?}", case.name);
                            assert_eq!(word(answer), word(case.answer), "{what}");
                        }
                        tested += 2;
                    }
                }
            }
            tested
        })
        .sum();
    assert!(tested > cases().len() * 48 * 72, "{tested}");
}

/// A tool triangle with an area and a pose at which it rounds to the points of `t`, which have none.
fn tool_that_rounds_to(t: &Triangle) -> Option<(Triangle, Pose)> {
    // One corner is at the tool's origin, with one coordinate changed by so little that the translation rounds it away.
    for corner in 0..3 {
        let at = t[corner];
        let away: Triangle = t.map(|c| [0, 1, 2].map(|a| c[a] - at[a]));
        let pose =
            Pose::new(&[[1.0, 0.0, 0.0, at[0]], [0.0, 1.0, 0.0, at[1]], [0.0, 0.0, 1.0, at[2]], [0.0, 0.0, 0.0, 1.0]])
                .ok()?;
        for (i, a, j, b) in (0..81).map(|n| (n / 27, n / 9 % 3, n / 3 % 3, n % 3)) {
            let mut tool = away;
            tool[i][a] += at[a].abs() * 1e-20;
            tool[j][b] -= at[b].abs() * 1e-20;
            if oracle::has_area(&tool) && pose.apply_triangle(&tool) == *t {
                return Some((tool, pose));
            }
        }
    }
    None
}

#[test]
fn scenes_in_all_stores_agree() {
    let results: Vec<(usize, usize)> = cases()
        .par_iter()
        .map(|case| {
            // A tool's triangle loses its area only on its way to a place other than its origin: move the pair there.
            let (p, q, tool) = if oracle::has_area(&case.p) {
                (case.p, case.q, Some((case.p, Pose::IDENTITY)))
            } else {
                let shifted = |t: &Triangle| -> Triangle { t.map(|c: Point| c.map(|x| x + 16.0)) };
                let (p, q) = (shifted(&case.p), shifted(&case.q));
                let is_exact = p.map(|c| c.map(|x| x - 16.0)) == case.p && q.map(|c| c.map(|x| x - 16.0)) == case.q;
                (p, q, tool_that_rounds_to(&p).filter(|_| is_exact))
            };
            let Some((tool, pose)) = tool else { return (0, 0) };
            let checked = Checked::new(&Setup { mockup: vec![q], tool: vec![tool], poses: vec![pose] }, |_, _, _| {});
            let checked = checked.unwrap_or_else(|| panic!("{}: cannot be queried: {p:?} {q:?}", case.name));
            let found: Vec<_> = checked.truth[0].iter().map(|(_, kind)| *kind).collect();
            assert_eq!(found, case.answer.into_iter().collect::<Vec<_>>(), "{}", case.name);
            let mut built = 0;
            for storage in STORES {
                let extent = checked.extent();
                for size in [None, Some(extent), Some(extent / 3.0)].into_iter().filter(|s| *s != Some(0.0)) {
                    match checked.fault(storage, size) {
                        Ok(fault) => {
                            assert_eq!(fault.map(|(_, what)| what), None, "{}", case.name);
                            built += 1;
                        }
                        // Voxels of a triangle that is 1e200 times as long as wide may be too many; blocks never are.
                        Err(why) => assert!(storage != Storage::Blocks, "{}: {why}", case.name),
                    }
                }
            }
            (1, built)
        })
        .collect();
    let (tested, built) = results.iter().fold((0, 0), |(a, b), (c, d)| (a + c, b + d));
    // The rest are segments and points at places where no small change is rounded away, or not exactly.
    assert!(tested >= cases().len() - 30, "{tested} of {}", cases().len());
    assert!(built >= 8 * tested, "{built} stores for {tested} cases");
}
