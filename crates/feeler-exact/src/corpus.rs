//! The corpus file: one named pair of triangles a line, with the true answer.

use feeler_core::{PairKind, Triangle};

/// One pair of triangles and how they meet.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Lower-case words, unique in the corpus.
    pub name: String,
    /// The first triangle, metres. It may have lost its area, as a tool's triangle at a pose can.
    pub p: Triangle,
    /// The second triangle, metres, always with an area, as a mock-up's.
    pub q: Triangle,
    /// How they meet; `None` when they are apart.
    pub answer: Option<PairKind>,
}

/// The word for an answer in the corpus.
pub fn word(answer: Option<PairKind>) -> &'static str {
    match answer {
        None => "apart",
        Some(PairKind::Coplanar) => "coplanar",
        Some(PairKind::Crossing) => "crossing",
        Some(PairKind::Touching) => "touching",
    }
}

impl Case {
    /// The case as a line of the corpus; each number is the shortest decimal that reads back as the same float64.
    pub fn line(&self) -> String {
        format!("{} | {} | {} | {}", self.name, numbers(&self.p), numbers(&self.q), word(self.answer))
    }
}

fn numbers(t: &Triangle) -> String {
    let words: Vec<String> = t
        .iter()
        .flatten()
        .map(|x| {
            let word = format!("{x:?}");
            word.strip_suffix(".0").map(String::from).unwrap_or(word)
        })
        .collect();
    words.join(" ")
}

/// Reads a corpus; empty lines and lines that start with `#` are skipped. An error names the line and its fault.
pub fn parse(text: &str) -> Result<Vec<Case>, String> {
    let mut cases: Vec<Case> = Vec::new();
    let mut names = std::collections::HashSet::new();
    for (n, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#')) {
        let case = parse_line(line).map_err(|why| format!("line {}: {why}", n + 1))?;
        if !names.insert(case.name.clone()) {
            return Err(format!("line {}: the name {:?} is taken", n + 1, case.name));
        }
        cases.push(case);
    }
    Ok(cases)
}

fn parse_line(line: &str) -> Result<Case, String> {
    let fields: Vec<&str> = line.split('|').map(str::trim).collect();
    let [name, p, q, answer] = fields[..] else {
        return Err(format!("{} fields between bars, not 4: name | 9 numbers | 9 numbers | answer", fields.len()));
    };
    let answer = [None, Some(PairKind::Coplanar), Some(PairKind::Crossing), Some(PairKind::Touching)]
        .into_iter()
        .find(|a| word(*a) == answer)
        .ok_or_else(|| format!("the answer is {answer:?}, not apart, coplanar, crossing or touching"))?;
    Ok(Case { name: name.into(), p: parse_triangle(p)?, q: parse_triangle(q)?, answer })
}

fn parse_triangle(text: &str) -> Result<Triangle, String> {
    let numbers: Vec<f64> = text
        .split_whitespace()
        .map(|word| word.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(|| format!("{word:?} is no number")))
        .collect::<Result<_, _>>()?;
    if numbers.len() != 9 {
        return Err(format!("a triangle has 9 numbers, not {}", numbers.len()));
    }
    Ok([0, 3, 6].map(|i| [numbers[i], numbers[i + 1], numbers[i + 2]]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_read_back_bit_for_bit() {
        let case = Case {
            name: "all sorts".into(),
            p: [[0.1, -0.0, 5e-324], [1e100, 1.0 / 3.0, -2.5e-310], [0.3f64.next_up(), 1e6, 7.0]],
            q: [[0.0; 3], [1.0; 3], [2.0, 1.0, -1e-12]],
            answer: Some(PairKind::Touching),
        };
        let read = parse(&format!("# head\n\n{}\n", case.line())).unwrap();
        assert!(read.len() == 1 && read[0] == case);
        assert!(read[0].p[0][1].is_sign_negative());
    }

    #[test]
    fn errors_name_the_line_and_the_reason() {
        for (text, why) in [
            ("a | 1 2 3 | apart", "3 fields"),
            ("\na | 0 0 0 1 0 0 0 1 x | 0 0 0 1 0 0 0 1 0 | apart", "line 2: \"x\" is no number"),
            ("a | 0 0 0 1 0 0 0 1 | 0 0 0 1 0 0 0 1 0 | apart", "9 numbers, not 8"),
            ("a | 0 0 0 1 0 0 0 1 0 | 0 0 0 1 0 0 0 1 0 | near", "the answer is \"near\""),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(why), "{error}");
        }
        let twice = "a | 0 0 0 1 0 0 0 1 0 | 0 0 0 1 0 0 0 1 0 | coplanar\n".repeat(2);
        assert!(parse(&twice).unwrap_err().contains("taken"));
    }
}
