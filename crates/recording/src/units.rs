//! Units of columns in files.

use std::f64::consts::{PI, TAU};

use crate::quantity::Quantity;

/// Base unit that [`Unit::factor`] leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Base {
    /// The unit of the quantity itself.
    Si,
    /// Ampere, in an effort channel.
    Ampere,
    /// Volt, in an effort channel.
    Volt,
    /// Counts of a converter.
    Counts,
}

/// A unit: value · factor + shift is in the base unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unit {
    pub(crate) name: &'static str,
    pub(crate) factor: f64,
    pub(crate) shift: f64,
    pub(crate) base: Base,
}

const fn unit(name: &'static str, factor: f64) -> Unit {
    Unit { name, factor, shift: 0.0, base: Base::Si }
}

const fn of_base(name: &'static str, factor: f64, base: Base) -> Unit {
    Unit { name, factor, shift: 0.0, base }
}

const DEG: f64 = PI / 180.0;
const POSITION: &[Unit] = &[
    unit("rad", 1.0),
    unit("deg", DEG),
    unit("turn", TAU),
    unit("m", 1.0),
    unit("mm", 1e-3),
    of_base("counts", 1.0, Base::Counts),
];
const VELOCITY: &[Unit] = &[
    unit("rad/s", 1.0),
    unit("deg/s", DEG),
    unit("turn/s", TAU),
    unit("rpm", TAU / 60.0),
    unit("m/s", 1.0),
    unit("mm/s", 1e-3),
    of_base("counts/s", 1.0, Base::Counts),
];
const ACCELERATION: &[Unit] = &[
    unit("rad/s^2", 1.0),
    unit("deg/s^2", DEG),
    unit("turn/s^2", TAU),
    unit("m/s^2", 1.0),
    unit("mm/s^2", 1e-3),
    of_base("counts/s^2", 1.0, Base::Counts),
];
const EFFORT: &[Unit] = &[
    unit("N m", 1.0),
    unit("N mm", 1e-3),
    unit("mN m", 1e-3),
    unit("N", 1.0),
    of_base("A", 1.0, Base::Ampere),
    of_base("mA", 1e-3, Base::Ampere),
    of_base("V", 1.0, Base::Volt),
    of_base("mV", 1e-3, Base::Volt),
    of_base("counts", 1.0, Base::Counts),
];
const CURRENT: &[Unit] = &[unit("A", 1.0), unit("mA", 1e-3), of_base("counts", 1.0, Base::Counts)];
const VOLTAGE: &[Unit] = &[unit("V", 1.0), unit("mV", 1e-3), of_base("counts", 1.0, Base::Counts)];
const TEMPERATURE: &[Unit] =
    &[unit("degC", 1.0), Unit { name: "K", factor: 1.0, shift: -273.15, base: Base::Si }];
/// Units of time stamps.
pub(crate) const TIME: &[Unit] =
    &[unit("s", 1.0), unit("ms", 1e-3), unit("us", 1e-6), unit("ns", 1e-9)];

/// Units that a channel may have, the default first.
pub(crate) fn units_of(quantity: Quantity) -> &'static [Unit] {
    match quantity {
        Quantity::Position | Quantity::MotorPosition | Quantity::Command => POSITION,
        Quantity::Velocity => VELOCITY,
        Quantity::Acceleration => ACCELERATION,
        Quantity::Effort => EFFORT,
        Quantity::Current => CURRENT,
        Quantity::Voltage => VOLTAGE,
        Quantity::Temperature => TEMPERATURE,
    }
}

/// The unit of this name in any spacing: `N m`, `Nm`, `N·m`, `N*m`; `µs`; `°/s`; `rad/s²`.
pub(crate) fn find(units: &'static [Unit], name: &str) -> Option<Unit> {
    let wanted = plain(name);
    units.iter().copied().find(|unit| plain(unit.name) == wanted)
}

fn plain(name: &str) -> String {
    let signs: String = name
        .chars()
        .filter_map(|c| match c {
            ' ' | '·' | '*' | '⋅' | '.' | '^' => None,
            'µ' | 'μ' => Some('u'),
            '²' => Some('2'),
            c => Some(c),
        })
        .collect();
    let (base, per) = signs.split_once('/').map_or((signs.as_str(), ""), |(base, per)| (base, per));
    let base = match base {
        "°" | "degree" | "degrees" => "deg",
        "°C" | "celsius" | "C" => "degC",
        "rev" | "turns" => "turn",
        "count" | "ticks" | "tick" => "counts",
        other => other,
    };
    format!("{base}/{per}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_found_in_every_spelling() {
        let all = Quantity::ALL.map(units_of);
        for units in all.into_iter().chain([TIME]) {
            for unit in units {
                assert_eq!(find(units, unit.name), Some(*unit));
            }
        }
        for (quantity, spelling, name) in [
            (Quantity::Effort, "Nm", "N m"),
            (Quantity::Effort, "N·m", "N m"),
            (Quantity::Effort, "mNm", "mN m"),
            (Quantity::Effort, "Nmm", "N mm"),
            (Quantity::Position, "°", "deg"),
            (Quantity::Velocity, "°/s", "deg/s"),
            (Quantity::Acceleration, "rad/s²", "rad/s^2"),
            (Quantity::Acceleration, "deg/s2", "deg/s^2"),
            (Quantity::Temperature, "°C", "degC"),
        ] {
            assert_eq!(find(units_of(quantity), spelling).map(|unit| unit.name), Some(name));
        }
        assert_eq!(find(TIME, "µs").map(|unit| unit.name), Some("us"));
        for (quantity, name) in [
            (Quantity::Position, "inch"),
            (Quantity::Velocity, "rad"),
            (Quantity::Position, "rad/s"),
            (Quantity::Effort, "MA"),
            (Quantity::Position, ""),
        ] {
            assert_eq!(find(units_of(quantity), name), None, "{name}");
        }
    }
}
