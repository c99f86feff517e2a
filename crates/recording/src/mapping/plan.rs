//! Assignment of columns to channels.

use crate::error::{Fault, RecordingError, listed};
use crate::quantity::Quantity;

use super::rules::{ChannelRule, JOINT, PerJoint, QUANTITY, Rules, suggestion};

/// Default columns of time stamps in seconds.
const TIME_COLUMNS: [&str; 3] = ["t", "__time", "time"];

/// A column that matches a rule.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Claim {
    pub(super) column: usize,
    pub(super) rule: usize,
    pub(super) joint: String,
    pub(super) quantity: Quantity,
}

impl Claim {
    pub(super) fn is(&self, joint: &str, quantity: Quantity) -> bool {
        self.joint == joint && self.quantity == quantity
    }
}

/// The columns of a file by the rules of a mapping.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plan {
    pub(super) time: usize,
    /// In the order of the columns.
    pub(super) claims: Vec<Claim>,
    pub(super) ignored: Vec<usize>,
}

/// Names the mapping file and the recording in messages.
struct Files<'a> {
    mapping: &'a str,
    recording: &'a str,
}

impl Files<'_> {
    fn fault(
        &self,
        line: Option<u64>,
        column: Option<&str>,
        what: String,
        advice: String,
    ) -> RecordingError {
        let mut error = RecordingError::new(Fault::Mapping { what, advice }, self.mapping);
        if let Some(line) = line {
            error = error.on_line(line);
        }
        match column {
            Some(column) => error.in_column(column),
            None => error,
        }
    }

    /// The only column of this name.
    fn column(
        &self,
        names: &[String],
        wanted: &str,
        line: Option<u64>,
    ) -> Result<usize, RecordingError> {
        let mut found = (0..names.len()).filter(|k| names[*k] == wanted);
        let Some(first) = found.next() else {
            let what = format!("no such column in {}", self.recording);
            let advice = suggestion(wanted, names, "columns");
            return Err(self.fault(line, Some(wanted), what, advice));
        };
        match found.next() {
            None => Ok(first),
            Some(second) => {
                let what = format!(
                    "duplicate column in {} (columns {} and {})",
                    self.recording,
                    first + 1,
                    second + 1
                );
                let advice = "delete or rename one of the two".to_owned();
                Err(self.fault(line, Some(wanted), what, advice))
            }
        }
    }
}

impl Plan {
    /// # Errors
    /// A column, or the joint of a number, is not in the file; a rule that matches no column; two
    /// columns for one channel.
    pub(super) fn new(
        rules: &Rules,
        names: &[String],
        mapping: &str,
        recording: &str,
    ) -> Result<Self, RecordingError> {
        let files = Files { mapping, recording };
        let time = match &rules.time.column {
            Some(column) => files.column(names, column, rules.time.line)?,
            None => {
                let known = TIME_COLUMNS.iter().find_map(|t| names.iter().position(|n| n == t));
                known.ok_or_else(|| {
                    let what = format!("no column `t`, `__time` or `time` in {recording}");
                    let list = listed(names);
                    let advice = format!(
                        "add [time] with column = \"name of the time stamps\"; columns: {list}"
                    );
                    files.fault(rules.time.line, None, what, advice)
                })?
            }
        };
        let mut claims = Vec::new();
        let mut is_taken = vec![false; names.len()];
        is_taken[time] = true;
        let (patterns, exact): (Vec<usize>, Vec<usize>) =
            (0..rules.channels.len()).partition(|k| rules.channels[*k].is_pattern());
        for rule in exact {
            let channel = &rules.channels[rule];
            let column = files.column(names, &channel.column, Some(channel.line))?;
            is_taken[column] = true;
            // rules without placeholders always have a quantity
            if let Some(quantity) = channel.quantity {
                claims.push(Claim { column, rule, joint: channel.joint.clone(), quantity });
            }
        }
        for rule in patterns {
            let channel = &rules.channels[rule];
            let before = claims.len();
            for (column, name) in names.iter().enumerate().filter(|(k, _)| !is_taken[*k]) {
                if let Some((joint, quantity)) = channel.matches(name) {
                    claims.push(Claim { column, rule, joint, quantity });
                }
            }
            for claim in &claims[before..] {
                is_taken[claim.column] = true;
            }
            if claims.len() == before {
                let what = format!("no column of {recording} matches");
                let advice = suggestion(&channel.column, names, "columns");
                return Err(files.fault(Some(channel.line), Some(&channel.column), what, advice));
            }
        }
        claims.sort_by_key(|claim| claim.column);
        for (rule, channel) in rules.channels.iter().enumerate() {
            let of_rule = claims.iter().filter(|claim| claim.rule == rule);
            let joints: Vec<&str> = of_rule.map(|claim| claim.joint.as_str()).collect();
            if let Some((key, joint)) = unused_joint(channel, &joints) {
                let what = format!("`{key}` names joint `{joint}`, which has no matching column");
                let advice = suggestion(&joint, &joints, "its joints");
                return Err(files.fault(Some(channel.line), Some(&channel.column), what, advice));
            }
        }
        for (k, claim) in claims.iter().enumerate() {
            if let Some(other) = claims[..k].iter().find(|c| c.is(&claim.joint, claim.quantity)) {
                let what = format!(
                    "two columns for {}/{}: `{}` and `{}`",
                    claim.joint, claim.quantity, names[other.column], names[claim.column]
                );
                let line = rules.channels[claim.rule].line;
                let advice =
                    "name the intended column, or assign another quantity to the other one";
                return Err(files.fault(Some(line), None, what, advice.to_owned()));
            }
        }
        let ignored = (0..names.len()).filter(|k| !is_taken[*k]).collect();
        Ok(Self { time, claims, ignored })
    }
}

/// A joint with a number, but without a column.
fn unused_joint(rule: &ChannelRule, joints: &[&str]) -> Option<(&'static str, String)> {
    rule.numbers().find_map(|(key, values)| {
        let PerJoint::Each(each) = values else { return None };
        let (name, _) = each.iter().find(|(name, _)| !joints.contains(&name.as_str()))?;
        Some((key, name.clone()))
    })
}

impl ChannelRule {
    /// Joint and quantity of a column that matches, if the rule has all numbers of the joint.
    fn matches(&self, name: &str) -> Option<(String, Quantity)> {
        let quantities: Vec<Quantity> = match self.quantity {
            Some(quantity) => vec![quantity],
            None => {
                // the shorter of two names must not take the columns of the longer
                let mut all = Quantity::ALL.to_vec();
                all.sort_by_key(|quantity| std::cmp::Reverse(quantity.suffix().len()));
                all
            }
        };
        let found = quantities.into_iter().find_map(|quantity| {
            let pattern = self.column.replacen(QUANTITY, quantity.suffix(), 1);
            let joint = match pattern.split_once(JOINT) {
                Some((prefix, suffix)) => {
                    let part = name.strip_prefix(prefix)?.strip_suffix(suffix)?;
                    (!part.is_empty()).then(|| self.joint.replacen(JOINT, part, 1))?
                }
                None => (pattern == name).then(|| self.joint.clone())?,
            };
            let is_clean = joint.trim() == joint;
            is_clean.then_some((joint, quantity))
        });
        found.filter(|(joint, _)| self.required().all(|(_, values)| values.of(joint).is_some()))
    }
}
