//! Names of effects, locations and counts, as all texts use them.

use armident_effects::effect;

/// Label of residual structure that no law explains.
const UNMODELLED: &str = "unmodelled dynamics";

/// Label of an effect, from its slug.
pub fn effect_label(slug: &str) -> String {
    match effect(slug) {
        Some(known) => known.law().title.to_owned(),
        None if slug == armident_diagnose::UNMODELLED => UNMODELLED.to_owned(),
        None => slug.replace('_', " "),
    }
}

/// An effect at its location: `payload on link_6`.
pub fn effect_at(slug: &str, joints: &[String], link: Option<&str>) -> String {
    let label = effect_label(slug);
    let location = location(joints, link);
    if location.is_empty() { label } else { format!("{label} on {location}") }
}

/// The link, or else the joints; nothing for effects of the whole arm.
pub fn location(joints: &[String], link: Option<&str>) -> String {
    link.map_or_else(|| joints.join(", "), ToOwned::to_owned)
}

/// Label of a parameter, from its name in files.
pub fn parameter_label(name: &str) -> String {
    // differences are true less given model; `mcx` is mass times the centre's x
    match name.strip_prefix("delta_") {
        Some(rest) => match rest.strip_prefix("mc") {
            Some(axis) => format!("first moment difference {axis}"),
            None => format!("{} difference", rest.replace('_', " ")),
        },
        None => name.replace('_', " "),
    }
}

/// `1 recording`, `2 recordings`.
pub fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// A text with a capital first letter.
pub fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().collect::<String>() + letters.as_str()
    })
}

/// A text as a sentence: with a capital first letter and a full stop.
pub fn sentence(text: &str) -> String {
    let stop = if text.ends_with(['.', '!', '?']) { "" } else { "." };
    format!("{}{stop}", capital(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_have_labels() {
        assert_eq!(parameter_label("delta_mass"), "mass difference");
        assert_eq!(parameter_label("delta_mcx"), "first moment difference x");
        assert_eq!(parameter_label("level_positive"), "level positive");
    }

    #[test]
    fn counts_agree() {
        assert_eq!(counted(1, "recording"), "1 recording");
        assert_eq!(counted(0, "recording"), "0 recordings");
    }
}
