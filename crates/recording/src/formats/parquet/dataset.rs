//! Datasets of LeRobot (versions 2 and 3): names of the entries of lists, and episodes in one file.

use std::path::Path;

use serde_json::Value;

use crate::raw::RawColumns;

/// Column with the number of the episode of each row.
pub(super) const EPISODE: &str = "episode_index";
/// Column of the time since the episode began \[s\].
const TIMESTAMP: &str = "timestamp";
/// Time between two episodes, longer than a gap that is fitted \[s\].
const PAUSE_S: f64 = 1.0;
/// Folders between a file and its dataset: `data/chunk-000`.
const DEEPEST: usize = 4;

/// Names of the entries of a feature, by `meta/info.json` in a folder above the file.
pub(super) fn entries(file: &Path, feature: &str, count: usize) -> Option<Vec<String>> {
    let mut above = file.ancestors().skip(1).take(DEEPEST);
    let text =
        above.find_map(|folder| std::fs::read_to_string(folder.join("meta/info.json")).ok())?;
    let info: Value = serde_json::from_str(&text).ok()?;
    let names = info.get("features")?.get(feature)?.get("names")?;
    // a list, or groups of lists: {"motors": [...]}
    let list: Vec<&Value> = match names {
        Value::Array(list) => list.iter().collect(),
        Value::Object(groups) => groups.values().filter_map(Value::as_array).flatten().collect(),
        _ => return None,
    };
    let names: Option<Vec<String>> =
        list.into_iter().map(|n| Some(n.as_str()?.to_owned())).collect();
    names.filter(|names| names.len() == count)
}

/// Moves the stamps of each episode behind those of the one before.
pub(super) fn one_after_the_other(raw: &mut RawColumns, episode: &[f64]) {
    let Some(column) = raw.columns.iter_mut().find(|column| column.name == TIMESTAMP) else {
        return;
    };
    let Some(stamps) = &mut column.values else { return };
    let (mut shift, mut count) = (0.0, 1);
    for k in 1..stamps.len().min(episode.len()) {
        if episode[k] != episode[k - 1] {
            // the stamp before is shifted already, this one is not
            shift = stamps[k - 1] + PAUSE_S - stamps[k];
            count += 1;
        }
        stamps[k] += shift;
    }
    if count > 1 {
        raw.notes.push(format!("{count} episodes, one after the other with pauses of {PAUSE_S} s"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn episodes_follow_each_other() {
        let mut raw = RawColumns::new("x").with(TIMESTAMP, vec![0.0, 0.1, 0.2, 0.0, 0.1, 0.0]);
        one_after_the_other(&mut raw, &[4.0, 4.0, 4.0, 5.0, 5.0, 6.0]);
        let stamps = raw.columns[0].values.as_ref().unwrap();
        for (found, expected) in stamps.iter().zip([0.0, 0.1, 0.2, 1.2, 1.3, 2.3]) {
            assert!((found - expected).abs() < 1e-12, "{stamps:?}");
        }
        assert_eq!(raw.notes, ["3 episodes, one after the other with pauses of 1 s"]);
    }
}
