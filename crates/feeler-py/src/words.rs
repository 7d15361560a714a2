//! Counts and lengths in words, for `repr`.

/// "1 pair", "2 pairs".
pub fn counted(count: usize, noun: &str) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{ending}")
}

/// "0.577 m": of five digits, and never minus zero.
pub fn metres(length: f64) -> String {
    let rounded: f64 = format!("{length:.4e}").parse().unwrap_or(length);
    format!("{:?} m", rounded + 0.0)
}
