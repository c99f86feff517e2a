//! Names in the order of their numbers: `run2` before `run10`.

/// A name as pieces of digits and of other characters.
fn pieces(name: &str) -> Vec<(u128, &str)> {
    let mut pieces = Vec::new();
    let mut rest = name;
    while let Some(first) = rest.chars().next() {
        let is_digit = first.is_ascii_digit();
        let end = rest.find(|c: char| c.is_ascii_digit() != is_digit).unwrap_or(rest.len());
        let (piece, behind) = rest.split_at(end);
        // numbers of more digits than any count are compared as text
        pieces.push((if is_digit { piece.parse().unwrap_or(u128::MAX) } else { 0 }, piece));
        rest = behind;
    }
    pieces
}

/// Compares names with the numbers in them.
pub(crate) fn natural_order(a: &str, b: &str) -> std::cmp::Ordering {
    pieces(a).cmp(&pieces(b)).then_with(|| a.cmp(b))
}

#[cfg(test)]
mod tests {
    use super::natural_order;

    #[test]
    fn names_follow_their_numbers() {
        let mut names = ["run10", "run2", "run2b", "a", "run"];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(names, ["a", "run", "run2", "run2b", "run10"]);
    }
}
