//! Numbers by joint.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Deref;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Deserializer, Serialize};

/// One number a joint; joints whose number could not be determined are absent (`null` in JSON).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "BTreeMap<String, Option<f64>>")]
pub struct ByJoint(BTreeMap<String, f64>);

impl ByJoint {
    /// The joints with their numbers and a unit: `joint_1 0.29 rad/s, joint_2 0.1 rad/s`.
    pub(crate) fn listed(&self, unit_of: impl Fn(&str) -> String) -> String {
        let of_joint = |(joint, number): (&String, &f64)| {
            format!("{joint} {} {}", crate::layout::significant(*number, 2, 0.0), unit_of(joint))
        };
        self.iter().map(of_joint).collect::<Vec<_>>().join(", ")
    }
}

impl From<BTreeMap<String, Option<f64>>> for ByJoint {
    fn from(map: BTreeMap<String, Option<f64>>) -> Self {
        Self(map.into_iter().filter_map(|(joint, number)| Some((joint, number?))).collect())
    }
}

impl From<BTreeMap<String, f64>> for ByJoint {
    fn from(map: BTreeMap<String, f64>) -> Self {
        Self(map)
    }
}

impl FromIterator<(String, f64)> for ByJoint {
    fn from_iter<T: IntoIterator<Item = (String, f64)>>(pairs: T) -> Self {
        Self(pairs.into_iter().collect())
    }
}

impl Deref for ByJoint {
    type Target = BTreeMap<String, f64>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl JsonSchema for ByJoint {
    fn schema_name() -> Cow<'static, str> {
        "{joint: number}".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        BTreeMap::<String, Option<f64>>::json_schema(generator)
    }
}

/// A number that is `null` in JSON where it could not be determined.
pub(crate) fn or_nan<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undetermined_numbers_are_absent() {
        let read: ByJoint = serde_json::from_str(r#"{"a": 1.5, "b": null}"#).unwrap();
        assert_eq!(read, [("a".to_owned(), 1.5)].into_iter().collect());
    }
}
