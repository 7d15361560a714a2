//! Counts in words, for `repr`.

/// "1 pair", "2 pairs".
pub fn counted(count: usize, noun: &str) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{ending}")
}
