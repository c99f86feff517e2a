//! The nearest known name to a misspelt one, for "did you mean".

/// The known name most like `name`, if any is like it at all (Damerau-Levenshtein distance of at
/// most a third of the length, letters' case ignored).
pub fn nearest<'a>(name: &str, known: &'a [String]) -> Option<&'a str> {
    let wanted = name.to_lowercase();
    known
        .iter()
        .map(|k| (strsim::damerau_levenshtein(&wanted, &k.to_lowercase()), k))
        .filter(|(distance, k)| 3 * distance <= k.chars().count().max(3))
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, k)| k.as_str())
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn suggests_only_similar_names() {
        let known = ["elbow_joint".to_owned(), "wrist_1_joint".to_owned()];
        assert_eq!(nearest("elbwo_joint", &known), Some("elbow_joint"));
        assert_eq!(nearest("Wrist_1_Joint", &known), Some("wrist_1_joint"));
        assert_eq!(nearest("gripper", &known), None);
    }
}
