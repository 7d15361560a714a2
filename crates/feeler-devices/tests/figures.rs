//! The tables of docs/devices.md equal the crate's data.

use feeler_devices::{Figures, FIGURES};

const PAGE: &str = include_str!("../../../docs/devices.md");

fn thousands(value: f64) -> String {
    match value.round() as u64 {
        small if small < 1000 => small.to_string(),
        large => format!("{},{:03}", large / 1000, large % 1000),
    }
}

fn row(line: &Figures) -> String {
    let known = |value: f64, said: String| if value > 0.0 { said } else { "–".to_string() };
    let [x, y, z] = line.workspace.map(|half| (2e3 * half).round());
    let stiffness = match line.rotational_stiffness_nm_per_rad {
        angular if angular > 0.0 => format!("{}; {angular} Nm/rad", thousands(line.stiffness_n_per_m)),
        _ => thousands(line.stiffness_n_per_m),
    };
    format!(
        "| {} | {} | {} | {stiffness} | {} | {} | {} | {x} x {y} x {z} |",
        line.name,
        line.force_n,
        known(line.torque_nm, line.torque_nm.to_string()),
        thousands(line.rate_hz),
        (1e7 * line.resolution_m).round() / 10.0,
        known(line.friction_n, line.friction_n.to_string()),
    )
}

#[test]
fn the_page_has_every_line_and_its_sources() {
    for line in &FIGURES {
        let (row, source) = (row(line), format!("- {}: {}", line.name, line.sources));
        assert!(PAGE.contains(&row), "docs/devices.md lacks\n{row}");
        assert!(PAGE.contains(&source), "docs/devices.md lacks\n{source}");
    }
    let rows = PAGE.lines().filter(|line| line.matches('|').count() == 9).count();
    assert_eq!(rows, FIGURES.len() + 2, "a row that the crate does not have");
}
