//! Which robot of a fleet a recording is of, by its path or by a column.

use std::path::Path;

/// What stands for the robot in a pattern.
const ROBOT: &str = "{robot}";

/// What stands in front of the name of a column.
const COLUMN: &str = "column:";

/// What the name of the robot is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RobotOf<'a> {
    /// That in its state, else its folder.
    Folder,
    /// A part of its path.
    Pattern(&'a str),
    /// The text of a column, of a table of states or of the recording.
    Column(&'a str),
}

impl<'a> RobotOf<'a> {
    /// As given: `column:NAME`, or a pattern with `{robot}` once.
    pub(crate) fn of(given: Option<&'a str>) -> Option<Self> {
        let Some(given) = given else { return Some(Self::Folder) };
        match given.strip_prefix(COLUMN) {
            Some(name) => (!name.is_empty()).then_some(Self::Column(name)),
            None => (given.matches(ROBOT).count() == 1).then_some(Self::Pattern(given)),
        }
    }

    /// The column, where it is one.
    pub(crate) fn column(self) -> Option<&'a str> {
        match self {
            Self::Column(name) => Some(name),
            Self::Folder | Self::Pattern(_) => None,
        }
    }
}

/// The part of a path that stands where a pattern has `{robot}`. The pattern covers the end of the path, from the start of
/// a folder or file name on; `*` is any characters but `/`.
pub(crate) fn robot_of(pattern: &str, path: &str) -> Option<String> {
    let starts = std::iter::once(0).chain(path.match_indices('/').map(|(at, _)| at + 1));
    starts.into_iter().find_map(|start| matched(pattern, &path[start..], None))
}

/// The robot where a pattern covers the whole text.
fn matched(pattern: &str, text: &str, robot: Option<&str>) -> Option<String> {
    let Some(next) = pattern.chars().next() else {
        return text.is_empty().then_some(robot).flatten().map(ToOwned::to_owned);
    };
    let ends = || {
        let inside = text.split('/').next().unwrap_or_default();
        inside.char_indices().map(|(at, c)| at + c.len_utf8()).collect::<Vec<_>>()
    };
    if let Some(rest) = pattern.strip_prefix(ROBOT) {
        return ends().into_iter().find_map(|end| matched(rest, &text[end..], Some(&text[..end])));
    }
    if let Some(rest) = pattern.strip_prefix('*') {
        let ends = std::iter::once(0).chain(ends());
        return ends.into_iter().find_map(|end| matched(rest, &text[end..], robot));
    }
    matched(&pattern[next.len_utf8()..], text.strip_prefix(next)?, robot)
}

/// The folder that holds a recording.
pub(crate) fn folder_of(path: &str) -> Option<String> {
    let folder = Path::new(path).parent()?.file_name()?;
    Some(folder.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robot_stands_where_pattern_has_it() {
        let of = |pattern: &str, path: &str| robot_of(pattern, path);
        assert_eq!(of("{robot}/*.csv", "logs/arm-2/day 3.csv").as_deref(), Some("arm-2"));
        assert_eq!(of("{robot}_*.csv", "logs/arm-2_day3.csv").as_deref(), Some("arm-2"));
        assert_eq!(of("cell*/{robot}/*/*", "a/cell7/r1/x/y.mcap").as_deref(), Some("r1"));
        assert_eq!(of("{robot}/*.csv", "day3.csv"), None);
        assert_eq!(folder_of("logs/arm-2/day3.csv").as_deref(), Some("arm-2"));
        assert_eq!(RobotOf::of(Some("{robot}*")), Some(RobotOf::Pattern("{robot}*")));
        assert_eq!(RobotOf::of(Some("column:cell")), Some(RobotOf::Column("cell")));
        assert_eq!(
            [Some("*"), Some("{robot}{robot}"), Some("column:")].map(RobotOf::of),
            [None; 3]
        );
    }
}
