//! Parses mapping files; faults have their line.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{Fault, RecordingError};
use crate::quantity::Quantity;
use crate::units::{self, TIME, Unit, units_of};

use super::coupling::Coupling;
use super::rules::{
    ChannelRule, JOINT, PerJoint, QUANTITY, Rules, TimeRule, contradiction, listed_str, suggestion,
};

/// Reads values from tables; faults have their line.
pub(super) struct Reader<'a> {
    text: &'a str,
    source: &'a str,
}

type Result<T> = std::result::Result<T, RecordingError>;
type Table<'a> = DeTable<'a>;
type Value<'a> = Spanned<DeValue<'a>>;

impl<'a> Reader<'a> {
    pub(super) fn rules(text: &'a str, source: &'a str) -> Result<Rules> {
        let reader = Self { text, source };
        let file = DeTable::parse(text).map_err(|error| {
            let place = error.span().unwrap_or(0..0);
            let reason = error.message().lines().next().unwrap_or_default().to_owned();
            let advice = "use the tables [time], [[channel]] and [[coupling]], see docs/mapping.md";
            reader.fault(&place, format!("invalid TOML: {reason}"), advice)
        })?;
        let file = file.get_ref();
        reader.only(file, "the file", &["time", "channel", "coupling"])?;
        let mut rules = Rules::default();
        if let Some(time) = file.get("time") {
            rules.time = reader.time(time)?;
        }
        for channel in reader.tables(file, "channel")? {
            rules.channels.push(reader.channel(channel)?);
        }
        for coupling in reader.tables(file, "coupling")? {
            rules.couplings.push(reader.coupling(coupling)?);
        }
        if rules.channels.is_empty() {
            let advice = "add [[channel]] with column = \"{joint}/{quantity}\", or one per column";
            return Err(reader.fault(&(0..0), "missing [[channel]]".to_owned(), advice));
        }
        Ok(rules)
    }

    fn line(&self, place: &Range<usize>) -> u64 {
        let before = self.text.as_bytes().iter().take(place.start);
        1 + before.filter(|byte| **byte == b'\n').count() as u64
    }

    fn fault(
        &self,
        place: &Range<usize>,
        what: String,
        advice: impl Into<String>,
    ) -> RecordingError {
        RecordingError::new(Fault::Mapping { what, advice: advice.into() }, self.source)
            .on_line(self.line(place))
    }

    /// Refuses unknown keys, which are probably misspelt.
    fn only(&self, table: &Table<'_>, of: &str, known: &[&str]) -> Result<()> {
        let unknown = table.keys().find(|key| !known.contains(&key.get_ref().as_ref()));
        let Some(key) = unknown else { return Ok(()) };
        let name = key.get_ref().as_ref();
        let what = format!("unknown key `{name}` in {of}");
        Err(self.fault(&key.span(), what, suggestion(name, known, "valid keys")))
    }

    /// The tables under `[[key]]`.
    fn tables<'t>(&self, file: &'t Table<'_>, key: &str) -> Result<Vec<&'t Value<'t>>> {
        let Some(value) = file.get(key) else { return Ok(Vec::new()) };
        match value.get_ref() {
            DeValue::Array(tables) => Ok(tables.iter().collect()),
            _ => {
                let what = format!("`{key}` must be a list of tables");
                Err(self.fault(&value.span(), what, format!("use double brackets: [[{key}]]")))
            }
        }
    }

    fn table<'t>(&self, value: &'t Value<'_>, name: &str) -> Result<&'t Table<'t>> {
        value.get_ref().as_table().ok_or_else(|| {
            let what = format!("`{name}` must be a table");
            self.fault(&value.span(), what, format!("write [{name}] and its keys below"))
        })
    }

    fn string(&self, table: &Table<'_>, key: &str) -> Result<Option<(String, Range<usize>)>> {
        let Some(value) = table.get(key) else { return Ok(None) };
        match value.get_ref().as_str() {
            Some(text) => Ok(Some((text.to_owned(), value.span()))),
            None => {
                let what = format!("`{key}` must be text in quotation marks");
                Err(self.fault(&value.span(), what, format!("for example {key} = \"...\"")))
            }
        }
    }

    fn boolean(&self, table: &Table<'_>, key: &str) -> Result<bool> {
        let Some(value) = table.get(key) else { return Ok(false) };
        value.get_ref().as_bool().ok_or_else(|| {
            let what = format!("`{key}` must be true or false");
            self.fault(&value.span(), what, "remove the quotation marks")
        })
    }

    fn number(&self, value: &Value<'_>, key: &str) -> Result<f64> {
        let found = match value.get_ref() {
            DeValue::Float(number) => number.as_str().replace('_', "").parse::<f64>().ok(),
            DeValue::Integer(number) => {
                let digits = number.as_str().replace('_', "");
                i64::from_str_radix(&digits, number.radix()).ok().map(|number| number as f64)
            }
            _ => None,
        };
        found.filter(|number| number.is_finite()).ok_or_else(|| {
            self.fault(
                &value.span(),
                format!("`{key}` must be a finite number"),
                format!("for example {key} = 1.5, or per joint {key} = {{ elbow = 1.5 }}"),
            )
        })
    }

    /// A number, or a table of one per joint.
    fn per_joint(&self, table: &Table<'_>, key: &str) -> Result<Option<PerJoint>> {
        let Some(value) = table.get(key) else { return Ok(None) };
        let Some(joints) = value.get_ref().as_table() else {
            return Ok(Some(PerJoint::One(self.number(value, key)?)));
        };
        let each = joints
            .iter()
            .map(|(name, value)| Ok((name.get_ref().to_string(), self.number(value, key)?)))
            .collect::<Result<Vec<_>>>()?;
        if each.is_empty() {
            let what = format!("`{key}` is a table without joints");
            return Err(self.fault(&value.span(), what, "write { elbow = 1.5 }, or remove it"));
        }
        Ok(Some(PerJoint::Each(each)))
    }

    /// The same with every number checked.
    fn checked(
        &self,
        table: &Table<'_>,
        key: &str,
        allowed: fn(f64) -> bool,
        expected: &str,
        advice: &str,
    ) -> Result<Option<PerJoint>> {
        let values = self.per_joint(table, key)?;
        let wrong = match &values {
            Some(PerJoint::One(value)) => !allowed(*value),
            Some(PerJoint::Each(each)) => each.iter().any(|(_, value)| !allowed(*value)),
            None => false,
        };
        match table.get(key) {
            Some(value) if wrong => {
                Err(self.fault(&value.span(), format!("`{key}` must be {expected}"), advice))
            }
            _ => Ok(values),
        }
    }

    fn time(&self, value: &Value<'_>) -> Result<TimeRule> {
        let table = self.table(value, "time")?;
        self.only(table, "[time]", &["column", "unit", "sort"])?;
        let column = self.string(table, "column")?.map(|(text, _)| text);
        let unit = match self.string(table, "unit")? {
            Some((text, place)) => Some(self.unit(&text, &place, TIME, "time")?),
            None => None,
        };
        let sort = self.boolean(table, "sort")?;
        Ok(TimeRule { line: Some(self.line(&value.span())), column, unit, sort })
    }

    fn unit(
        &self,
        text: &str,
        place: &Range<usize>,
        known: &'static [Unit],
        of: &str,
    ) -> Result<Unit> {
        units::find(known, text).ok_or_else(|| {
            let names: Vec<&str> = known.iter().map(|unit| unit.name).collect();
            let what = format!("unknown unit `{text}` of {of}");
            self.fault(place, what, format!("units of {of}: {}", listed_str(&names)))
        })
    }

    fn channel(&self, value: &Value<'_>) -> Result<ChannelRule> {
        const KEYS: [&str; 12] = [
            "column",
            "joint",
            "quantity",
            "unit",
            "sign",
            "offset",
            "gain",
            "gear_ratio",
            "torque_constant",
            "resistance_ohm",
            "counts_per_turn",
            "back_emf",
        ];
        let table = self.table(value, "channel")?;
        let here = value.span();
        self.only(table, "[[channel]]", &KEYS)?;
        let Some((column, column_place)) = self.string(table, "column")? else {
            let advice = "add column = \"name in the file\"";
            return Err(self.fault(&here, "channel without `column`".to_owned(), advice));
        };
        self.placeholders(&column, &column_place)?;
        let quantity = self.quantity(table, &column, &here)?;
        let joint = self.joint(table, &column, &here)?;
        let unit = match self.string(table, "unit")? {
            None => None,
            Some((text, place)) => match quantity {
                Some(quantity) => {
                    Some(self.unit(&text, &place, units_of(quantity), quantity.suffix())?)
                }
                None => {
                    let what = "`unit` with {quantity} in the column".to_owned();
                    let advice = "use one [[channel]] per quantity, or remove the unit";
                    return Err(self.fault(&place, what, advice));
                }
            },
        };
        let positive = |key| {
            let advice = "use a positive number; set directions by `sign` or `gear_ratio`";
            self.checked(table, key, |value| value > 0.0, "above 0", advice)
        };
        let nonzero = |key| {
            let advice = "remove the channel if it is not needed";
            self.checked(table, key, |value| value != 0.0, "other than 0", advice)
        };
        let is_sign = |value: f64| value.abs() == 1.0;
        let sign_advice = "set other factors by `gain`";
        let rule = ChannelRule {
            line: self.line(&here),
            column,
            joint,
            quantity,
            unit,
            sign: self.checked(table, "sign", is_sign, "1 or -1", sign_advice)?,
            offset: self.per_joint(table, "offset")?,
            gain: nonzero("gain")?,
            gear_ratio: nonzero("gear_ratio")?,
            torque_constant: positive("torque_constant")?,
            resistance_ohm: positive("resistance_ohm")?,
            counts_per_turn: positive("counts_per_turn")?,
            back_emf: self.boolean(table, "back_emf")?,
        };
        if let Some((what, advice)) = contradiction(&rule) {
            return Err(self.fault(&here, what, advice));
        }
        Ok(rule)
    }

    fn placeholders(&self, column: &str, place: &Range<usize>) -> Result<()> {
        let rest = column.replacen(JOINT, "", 1).replacen(QUANTITY, "", 1);
        if !rest.contains(['{', '}']) {
            return Ok(());
        }
        let what = format!("unknown placeholder in `{column}`");
        Err(self.fault(place, what, "use {joint} and {quantity}, each at most once"))
    }

    fn quantity(
        &self,
        table: &Table<'_>,
        column: &str,
        here: &Range<usize>,
    ) -> Result<Option<Quantity>> {
        let names = Quantity::ALL.map(Quantity::suffix);
        let by_column = column.contains(QUANTITY);
        match self.string(table, "quantity")? {
            Some((_, place)) if by_column => {
                let what = "`quantity` and {quantity} in the column".to_owned();
                Err(self.fault(&place, what, "remove one of them"))
            }
            Some((name, place)) => match Quantity::from_suffix(&name) {
                Some(quantity) => Ok(Some(quantity)),
                None => {
                    let what = format!("unknown quantity `{name}`");
                    Err(self.fault(&place, what, suggestion(&name, &names, "quantities")))
                }
            },
            None if by_column => Ok(None),
            None => {
                let last = column.rsplit_once('/').map_or("", |(_, last)| last);
                match Quantity::from_suffix(last) {
                    Some(quantity) => Ok(Some(quantity)),
                    None => {
                        let what = format!("channel of `{column}` without `quantity`");
                        let advice = format!("add quantity = one of {}", listed_str(&names));
                        Err(self.fault(here, what, advice))
                    }
                }
            }
        }
    }

    fn joint(&self, table: &Table<'_>, column: &str, here: &Range<usize>) -> Result<String> {
        match self.string(table, "joint")? {
            Some((joint, place)) => {
                let rest = joint.replacen(JOINT, "", 1);
                let is_name = !joint.is_empty() && joint.trim() == joint;
                if rest.contains(['{', '}', '\n', '\r']) || !is_name {
                    let what = format!("`{joint}` is not a valid joint name");
                    return Err(self.fault(&place, what, "use a name, with {joint} at most once"));
                }
                if joint.contains(JOINT) != column.contains(JOINT) {
                    let what = "{joint} must be in both `column` and `joint`".to_owned();
                    let advice = "add it, or remove `joint` if the matched part is the joint name";
                    return Err(self.fault(&place, what, advice));
                }
                Ok(joint)
            }
            None if column.contains(JOINT) => Ok(JOINT.to_owned()),
            None => {
                let what = format!("channel of `{column}` without `joint`");
                let advice = "add joint = \"name in the URDF\", or {joint} in the column";
                Err(self.fault(here, what, advice))
            }
        }
    }

    fn coupling(&self, value: &Value<'_>) -> Result<Coupling> {
        let table = self.table(value, "coupling")?;
        let here = value.span();
        self.only(table, "[[coupling]]", &["joints", "motors", "matrix", "offset"])?;
        let names = |key: &str| -> Result<Vec<String>> {
            let names = table.get(key).and_then(|value| {
                let names = value.get_ref().as_array()?.iter();
                names.map(|name| Some(name.get_ref().as_str()?.to_owned())).collect()
            });
            names.ok_or_else(|| {
                let what = format!("`{key}` must be a list of names");
                self.fault(&here, what, format!("for example {key} = [\"a\", \"b\"]"))
            })
        };
        let numbers = |value: &Value<'_>| -> Result<Vec<f64>> {
            let Some(row) = value.get_ref().as_array() else {
                let what = "rows of `matrix` and `offset` must be lists of numbers".to_owned();
                return Err(self.fault(
                    &value.span(),
                    what,
                    "for example matrix = [[1, 0], [1, 1]]",
                ));
            };
            row.iter().map(|value| self.number(value, "matrix")).collect()
        };
        let (joints, motors) = (names("joints")?, names("motors")?);
        let rows = table.get("matrix").and_then(|value| value.get_ref().as_array());
        let matrix = match rows {
            Some(rows) => rows.iter().map(numbers).collect::<Result<Vec<_>>>()?,
            None => {
                let what = "coupling without `matrix`".to_owned();
                let advice = "add matrix = [[...], [...]], motor positions from joint positions, \
                              one row per motor";
                return Err(self.fault(&here, what, advice));
            }
        };
        let offset = match table.get("offset") {
            Some(value) => numbers(value)?,
            None => vec![0.0; joints.len()],
        };
        let line = self.line(&here);
        Coupling::new(line, joints, motors, &matrix, offset)
            .map_err(|(what, advice)| self.fault(&here, what, advice))
    }
}
