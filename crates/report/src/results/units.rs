//! Units of joints.

/// Unit of a position: `rad`, `m` of a joint that translates, or both where that is not known.
pub(crate) fn position_unit(translates: Option<bool>) -> &'static str {
    translates.map_or("rad or m", |translates| if translates { "m" } else { "rad" })
}

/// Unit of an effort: `N m`, `N` of a joint that translates, or both where that is not known.
pub(crate) fn effort_unit(translates: Option<bool>) -> &'static str {
    translates.map_or("N m or N", |translates| if translates { "N" } else { "N m" })
}

/// Whether all joints translate; none where some do, or where that is not known.
pub(crate) fn all_translate(joints: &[String], prismatic: Option<&Vec<String>>) -> Option<bool> {
    match prismatic?.len() {
        0 => Some(false),
        some => (some == joints.len()).then_some(true),
    }
}
