//! The command line: the mass of pairs, the corpus, one pair.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use feeler_core::intersect_triangle_triangle;
use feeler_exact::corpus::{self, word};
use feeler_exact::{bodies, casts, contacts, depths, families, mass, oracle};

/// Holds feeler's triangle test and stores to exact rational arithmetic.
#[derive(Parser)]
#[command(
    version,
    after_help = "\
Examples:
  feeler-exact mass                               ten million pairs from all generators
  feeler-exact mass --pairs 100000 --seed 7       a short run with other pairs
  feeler-exact mass --only gears --only lattice   two generators only
  feeler-exact mass --json > figures.json         figures for a program
  feeler-exact casts --casts 100000               casts that must hit: none may tunnel or be late
  feeler-exact casts --casts 1000 --samples 1000  the same, each looked at a thousand times before its impact
  feeler-exact bodies --sets 10000                sets of bodies that all are moved, fits among them
  feeler-exact contacts --cases 1000              contacts of concave solids of known depth, so many of each family
  feeler-exact contacts --only rack --from 7 --cases 1    one of them once more
  feeler-exact depths --cases 1000                depths of polyhedra against points in whole numbers, so many of each family
  feeler-exact corpus                             make testdata/triangle_pairs.txt anew; found cases stay
  feeler-exact pair 'x | 0 0 0 4 0 0 0 4 0 | 1 1 0 2 1 3 0 3 3 | touching'"
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Judge millions of pairs and thousands of scenes; exit code 1 when the core is wrong about one.
    Mass {
        /// How many pairs, at least.
        #[arg(long, default_value_t = 10_000_000)]
        pairs: u64,
        /// Another seed makes other pairs; the same seed the same ones on every machine.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Only this generator (may be repeated).
        #[arg(long, value_name = "NAME")]
        only: Vec<String>,
        /// Print the figures as JSON.
        #[arg(long)]
        json: bool,
    },
    /// Judge casts that are known to hit; exit code 1 when one tunnels, is late, or too early.
    Casts {
        /// How many, about.
        #[arg(long, default_value_t = 1_000_000)]
        casts: u64,
        /// Another seed makes other casts; the same seed the same ones.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Times before each impact at which all pairs are looked at, beside six close to it.
        #[arg(long, default_value_t = 0)]
        samples: u32,
    },
    /// Judge which triangles of bodies that all are moved meet; exit code 1 when the core is wrong about a pair.
    Bodies {
        /// How many sets.
        #[arg(long, default_value_t = 3000)]
        sets: u64,
        /// Another seed makes other sets; the same seed the same ones on every machine.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// Judge contacts of concave solids whose depths are known; exit code 1 when a plane is missing, too deep or turned, or a way
    /// out is too short.
    Contacts {
        /// How many of each family.
        #[arg(long, default_value_t = 2000)]
        cases: u64,
        /// Another seed makes other contacts; the same seed the same ones on every machine.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// The number of the first.
        #[arg(long, default_value_t = 0)]
        from: u64,
        /// Only this family (may be repeated).
        #[arg(long, value_name = "NAME")]
        only: Vec<String>,
        /// Surfaces are cut into about as many triangles at most.
        #[arg(long, default_value_t = 12_000)]
        triangles: usize,
    },
    /// Judge depths by points; exit code 1 when a point is deeper than is said, or the point that is shown is not as deep.
    Depths {
        /// How many of each family.
        #[arg(long, default_value_t = 3000)]
        cases: u64,
        /// Another seed makes other pairs; the same seed the same ones on every machine.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// The number of the first.
        #[arg(long, default_value_t = 0)]
        from: u64,
        /// Only this family (may be repeated).
        #[arg(long, value_name = "NAME")]
        only: Vec<String>,
    },
    /// Write the corpus of hard pairs, every answer checked; exit code 1 when `--check` finds the file out of date.
    Corpus {
        /// Where it is kept.
        #[arg(long, default_value = "testdata/triangle_pairs.txt")]
        file: PathBuf,
        /// Only compare, write nothing.
        #[arg(long)]
        check: bool,
    },
    /// Answers of exact arithmetic and of the core on one line of the corpus; exit code 1 when they differ.
    Pair {
        /// `name | 9 numbers | 9 numbers | answer`
        line: String,
    },
}

fn main() -> ExitCode {
    let done = match Arguments::parse().command {
        Command::Mass { pairs, seed, only, json } => run_mass(pairs, seed, &only, json),
        Command::Casts { casts, seed, samples } => Ok(run_casts(casts, seed, samples)),
        Command::Bodies { sets, seed } => Ok(run_bodies(sets, seed)),
        Command::Contacts { cases, seed, from, only, triangles } => run_contacts(cases, seed, from, &only, triangles),
        Command::Depths { cases, seed, from, only } => run_depths(cases, seed, from, &only),
        Command::Corpus { file, check } => make_corpus(&file, check),
        Command::Pair { line } => judge_line(&line),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(why) => {
            eprintln!("feeler-exact: {why}");
            ExitCode::from(2)
        }
    }
}

fn show_progress(name: &str, done: f64) {
    if std::io::stderr().is_terminal() {
        eprint!("\r{name:<16}{:>4.0} %", 100.0 * done);
    } else if done >= 1.0 {
        eprintln!("{name} done");
    }
    std::io::stderr().flush().ok();
}

fn clear_progress() {
    if std::io::stderr().is_terminal() {
        eprint!("\r{:<24}\r", "");
    }
}

fn run_mass(pairs: u64, seed: u64, only: &[String], json: bool) -> Result<bool, String> {
    let rows = mass::run(pairs, seed, only, &show_progress)?;
    clear_progress();
    let total = mass::total(&rows);
    if json {
        print_json(&rows, &total, seed);
    } else {
        print_table(&rows, &total, seed);
    }
    Ok(total.tally.mismatch_count == 0)
}

fn run_casts(count: u64, seed: u64, samples: u32) -> bool {
    let tally = casts::run(count, seed, samples);
    println!(
        "casts (seed {seed}): {} that hit, {} of them along screws, {} along chains, {} turning by more than a quarter; {} tunnelled, {} late, \
         {} too early ({} not judged: apart by rounding)",
        tally.casts, tally.screws, tally.chains, tally.spinning, tally.tunnelled, tally.late, tally.early, tally.not_judged
    );
    tally.faults.iter().for_each(|fault| println!("  {fault}"));
    tally.is_right()
}

fn run_bodies(sets: u64, seed: u64) -> bool {
    let tally = bodies::run(sets, seed);
    println!(
        "bodies (seed {seed}): {} sets, {} pairs of bodies, {} pairs of triangles, {} of which meet; {} wrong ({} not judged: both \
         without an area where they are)",
        tally.sets, tally.bodies, tally.pairs, tally.meeting, tally.wrong, tally.not_judged
    );
    tally.faults.iter().for_each(|fault| println!("  {fault}"));
    tally.wrong == 0
}

fn run_contacts(cases: u64, seed: u64, from: u64, only: &[String], triangles: usize) -> Result<bool, String> {
    let rows = contacts::run(cases, seed, from, only, triangles, &show_progress)?;
    clear_progress();
    println!(
        "{:<10}{:>7}{:>11}{:>8}{:>8}{:>8}{:>8}{:>7}{:>10}{:>9}{:>8}{:>7}  what",
        "family", "cases", "triangles", "deep", "near", "exact", "bound", "<1 %", "estimate", "longest", "off", "wrong"
    );
    for (family, t) in &rows {
        let [exact, bound, estimate] = t.figures.ways;
        println!(
            "{:<10}{:>7}{:>11}{:>8}{:>8}{exact:>8}{bound:>8}{:>7}{estimate:>10}{:>9.2}{:>8.3}{:>7}  {}",
            family.name,
            t.cases,
            t.triangles,
            t.figures.deep,
            t.figures.near,
            t.figures.close_bounds,
            t.figures.longest,
            t.worst,
            t.fault_count,
            family.about
        );
    }
    println!(
        "\nseed {seed}; deep, near: planes to be found; <1 %: bounds as close to the shortest way; longest: of the others, in \
         shortest ways; off: the worst depth, as a share of what rounding may do"
    );
    rows.iter().flat_map(|(_, t)| &t.faults).for_each(|fault| println!("{fault}"));
    Ok(rows.iter().all(|(_, t)| t.fault_count == 0))
}

fn run_depths(cases: u64, seed: u64, from: u64, only: &[String]) -> Result<bool, String> {
    let rows = depths::run(cases, seed, from, only, &show_progress)?;
    clear_progress();
    println!(
        "{:<10}{:>7}{:>11}{:>10}{:>8}{:>9}{:>9}{:>7}{:>8}{:>7}  what",
        "family", "cases", "triangles", "points", "deep", "shallow", "reached", "open", "off", "wrong"
    );
    for (family, t) in &rows {
        println!(
            "{:<10}{:>7}{:>11}{:>10}{:>8}{:>9}{:>9}{:>7}{:>8.3}{:>7}  {}",
            family.name,
            t.cases,
            t.triangles,
            t.figures.points,
            t.figures.deep,
            t.figures.shallow,
            t.figures.reached,
            t.figures.open,
            t.worst,
            t.fault_count,
            family.about
        );
    }
    println!(
        "\nseed {seed}; points: inside the other body; reached: a point was found as deep, but for a hundredth; open: not judged, since a surface does \
         not count as closed; off: the most that one was \
         deeper, as a share of the error that is said"
    );
    rows.iter().flat_map(|(_, t)| &t.faults).for_each(|fault| println!("{fault}"));
    Ok(rows.iter().all(|(_, t)| t.fault_count == 0))
}

fn print_table(rows: &[mass::Row], total: &mass::Row, seed: u64) {
    let [a, b, c, d] = mass::answers();
    println!(
        "{:<14}{:>11}{a:>11}{b:>11}{c:>11}{d:>11}{:>11}{:>9}{:>9}{:>7}{:>6}  what",
        "generator", "pairs", "tested", "exact %", "scenes", "s", "wrong"
    );
    for row in rows.iter().chain([total]) {
        let t = &row.tally;
        let [a, b, c, d] = t.by_answer;
        println!(
            "{:<14}{:>11}{a:>11}{b:>11}{c:>11}{d:>11}{:>11}{:>9.3}{:>9}{:>7.1}{:>6}  {}",
            row.name,
            t.pairs,
            t.reached,
            percent(t),
            t.scene_queries,
            row.seconds,
            t.mismatch_count,
            row.about
        );
    }
    println!("\nseed {seed}; tested: reach the triangle test; exact: of these, floats could not decide");
    if total.tally.skipped > 0 {
        println!("{} stores not built: too many voxels for a test", total.tally.skipped);
    }
    for row in rows.iter().filter(|row| row.tally.mismatch_count > 0) {
        println!("\n{}: {} wrong. The first, shrunk:", row.name, row.tally.mismatch_count);
        row.tally.mismatches.iter().for_each(|text| println!("{text}"));
    }
}

fn percent(t: &mass::Tally) -> f64 {
    100.0 * t.exact as f64 / t.reached.max(1) as f64
}

fn print_json(rows: &[mass::Row], total: &mass::Row, seed: u64) {
    let object = |row: &mass::Row| {
        let t = &row.tally;
        let answers: Vec<String> =
            mass::answers().iter().zip(t.by_answer).map(|(word, n)| format!("\"{word}\": {n}")).collect();
        // Rust's quoting of these plain ASCII texts is JSON's.
        format!(
            "{{\"name\": {:?}, \"pairs\": {}, {}, \"tested\": {}, \"exact\": {}, \"exact_percent\": {:.4}, \
             \"scene_queries\": {}, \"skipped_stores\": {}, \"wrong\": {}, \"wrong_lines\": {:?}, \"seconds\": {:.1}}}",
            row.name,
            t.pairs,
            answers.join(", "),
            t.reached,
            t.exact,
            percent(t),
            t.scene_queries,
            t.skipped,
            t.mismatch_count,
            t.mismatches,
            row.seconds
        )
    };
    let rows: Vec<String> = rows.iter().map(object).collect();
    println!("{{\"seed\": {seed},\n \"generators\": [\n  {}],\n \"total\": {}}}", rows.join(",\n  "), object(total));
}

fn make_corpus(file: &Path, check: bool) -> Result<bool, String> {
    let before = std::fs::read_to_string(file).unwrap_or_default();
    let text = families::corpus(&before);
    let cases = corpus::parse(&text)?;
    for case in &cases {
        let truth = oracle::kind_of_pair(&case.p, &case.q);
        if truth != case.answer {
            return Err(format!("{}: the file says {}, in truth {}", case.name, word(case.answer), word(truth)));
        }
    }
    if check {
        println!(
            "{}: {} cases, {}",
            file.display(),
            cases.len(),
            if text == before { "up to date" } else { "out of date" }
        );
        return Ok(text == before);
    }
    std::fs::write(file, &text).map_err(|why| format!("{}: {why}", file.display()))?;
    println!("{}: {} cases", file.display(), cases.len());
    Ok(true)
}

fn judge_line(line: &str) -> Result<bool, String> {
    let cases = corpus::parse(line)?;
    let mut is_right = true;
    for case in &cases {
        let (truth, core) = (oracle::kind_of_pair(&case.p, &case.q), intersect_triangle_triangle(&case.p, &case.q));
        println!("{}: in truth {}, core {}, line {}", case.name, word(truth), word(core), word(case.answer));
        is_right &= truth == core && truth == case.answer;
    }
    Ok(is_right)
}
