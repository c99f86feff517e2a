//! Content of a mapping file.

use crate::error::listed;
use crate::quantity::Quantity;
use crate::units::{Base, Unit};

use super::coupling::Coupling;

/// A number for all joints of a channel, or one per joint.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum PerJoint {
    One(f64),
    Each(Vec<(String, f64)>),
}

impl PerJoint {
    pub(super) fn of(&self, joint: &str) -> Option<f64> {
        match self {
            Self::One(value) => Some(*value),
            Self::Each(values) => {
                values.iter().find(|(name, _)| name == joint).map(|(_, value)| *value)
            }
        }
    }
}

/// `[time]`.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct TimeRule {
    pub(super) line: Option<u64>,
    pub(super) column: Option<String>,
    pub(super) unit: Option<Unit>,
    pub(super) sort: bool,
}

/// One `[[channel]]`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ChannelRule {
    pub(super) line: u64,
    /// Name of the column, with optional `{joint}` and `{quantity}`.
    pub(super) column: String,
    /// Name of the joint, with optional `{joint}`.
    pub(super) joint: String,
    /// None if the name of the column determines it.
    pub(super) quantity: Option<Quantity>,
    /// None for the default of the quantity.
    pub(super) unit: Option<Unit>,
    pub(super) sign: Option<PerJoint>,
    pub(super) offset: Option<PerJoint>,
    pub(super) gain: Option<PerJoint>,
    pub(super) gear_ratio: Option<PerJoint>,
    pub(super) torque_constant: Option<PerJoint>,
    pub(super) resistance_ohm: Option<PerJoint>,
    pub(super) counts_per_turn: Option<PerJoint>,
    pub(super) back_emf: bool,
}

impl ChannelRule {
    pub(super) fn is_pattern(&self) -> bool {
        self.column.contains(JOINT) || self.column.contains(QUANTITY)
    }

    /// Numbers that restrict the channel to the joints that have them.
    pub(super) fn required(&self) -> impl Iterator<Item = (&'static str, &PerJoint)> {
        [
            ("gain", &self.gain),
            ("gear_ratio", &self.gear_ratio),
            ("torque_constant", &self.torque_constant),
            ("resistance_ohm", &self.resistance_ohm),
            ("counts_per_turn", &self.counts_per_turn),
        ]
        .into_iter()
        .filter_map(|(key, values)| Some((key, values.as_ref()?)))
    }

    /// All numbers.
    pub(super) fn numbers(&self) -> impl Iterator<Item = (&'static str, &PerJoint)> {
        [("sign", &self.sign), ("offset", &self.offset)]
            .into_iter()
            .filter_map(|(key, values)| Some((key, values.as_ref()?)))
            .chain(self.required())
    }
}

pub(super) const JOINT: &str = "{joint}";
pub(super) const QUANTITY: &str = "{quantity}";

/// All rules of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Rules {
    pub(super) time: TimeRule,
    pub(super) channels: Vec<ChannelRule>,
    pub(super) couplings: Vec<Coupling>,
}

/// Contradictory keys: the fault and advice.
pub(super) fn contradiction(rule: &ChannelRule) -> Option<(String, String)> {
    use Quantity::{Acceleration, Command, Effort, MotorPosition, Position, Velocity};
    let fault = |what: String, advice: &str| Some((what, advice.to_owned()));
    let Some(quantity) = rule.quantity else {
        let (key, _) = rule.numbers().next()?;
        let what = format!("`{key}` with {{quantity}} in the column");
        return fault(what, "use one [[channel]] per quantity, or remove the number");
    };
    let base = rule.unit.map_or(Base::Si, |unit| unit.base);
    let is_position =
        matches!(quantity, Position | MotorPosition | Command | Velocity | Acceleration);
    let drives = matches!(base, Base::Ampere | Base::Volt);
    let unit = rule.unit.map_or("", |unit| unit.name);
    let meaningless = [
        ("gear_ratio", rule.gear_ratio.is_some() && !is_position && quantity != Effort),
        ("torque_constant", rule.torque_constant.is_some() && !drives),
        ("resistance_ohm", rule.resistance_ohm.is_some() && base != Base::Volt),
        ("back_emf", rule.back_emf && base != Base::Volt),
        (
            "counts_per_turn",
            rule.counts_per_turn.is_some() && !(is_position && base == Base::Counts),
        ),
    ];
    if let Some((key, _)) = meaningless.iter().find(|(_, is)| *is) {
        let what = format!("`{key}` does not apply to {quantity} in this unit");
        let advice = match *key {
            "gear_ratio" => "remove it",
            "counts_per_turn" => "it applies to positions with unit = \"counts\"",
            "torque_constant" => "it applies to quantity = \"effort\" with unit = \"A\" or \"V\"",
            _ => "it applies to quantity = \"effort\" with unit = \"V\"",
        };
        return fault(what, advice);
    }
    let both_gains = rule.gain.is_some()
        && (rule.counts_per_turn.is_some() || (drives && rule.torque_constant.is_some()));
    if both_gains || (base == Base::Ampere && rule.gain.is_some() && rule.gear_ratio.is_some()) {
        let what = "`gain` together with its factors".to_owned();
        return fault(
            what,
            "use only gain, in N m per A (rad per count) with the gear ratio included",
        );
    }
    match base {
        Base::Ampere if rule.gain.is_none() && rule.torque_constant.is_none() => fault(
            format!("effort in {unit} requires a torque per current"),
            "add gain (N m per A on the joint side), or torque_constant and gear_ratio; or use \
             quantity = \"current\"",
        ),
        Base::Volt if rule.torque_constant.is_none() || rule.resistance_ohm.is_none() => fault(
            format!("effort in {unit} requires motor constants"),
            "add torque_constant (N m/A), resistance_ohm and gear_ratio; or use quantity = \
             \"voltage\"",
        ),
        Base::Counts if rule.gain.is_none() && rule.counts_per_turn.is_none() => fault(
            format!("{quantity} in counts requires the size of a count"),
            "add counts_per_turn for an encoder, or gain (SI unit per count)",
        ),
        _ => None,
    }
}

/// The nearest name as a suggestion, and the list.
pub(super) fn suggestion<S: AsRef<str>>(name: &str, known: &[S], of: &str) -> String {
    let names: Vec<&str> = known.iter().map(AsRef::as_ref).collect();
    let list = format!("{of}: {}", listed_str(&names));
    match nearest(name, names.iter().copied()) {
        Some(best) => format!("did you mean `{best}`? {list}"),
        None => list,
    }
}

/// The most similar name, if it is similar at all.
fn nearest<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    let wanted = name.to_lowercase();
    known
        .map(|candidate| (strsim::jaro_winkler(&wanted, &candidate.to_lowercase()), candidate))
        .filter(|(similarity, _)| *similarity > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

pub(super) fn listed_str(names: &[&str]) -> String {
    listed(&names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>())
}
