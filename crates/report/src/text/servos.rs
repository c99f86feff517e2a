//! `armident identify` on recordings of commands: from an identification to its result, and its text.

use armident_ident::{ServoIdentification, ServoJointFit, ServoParameter};

use crate::layout::{Bars, Block, Table, render, significant, uncertain};
use crate::results::{ServoNumber, ServoRow, ServosReport};
use crate::words::counted;

impl ServosReport {
    /// Of an identification; names of recordings are to be added.
    pub fn of(found: &ServoIdentification) -> Self {
        let chain = &found.model.chain;
        let row = |(k, fit): (usize, &ServoJointFit)| {
            let number = |p: ServoParameter| {
                let value = fit.values.iter().find(|value| value.parameter == p)?;
                Some(ServoNumber { value: value.value, standard_error: value.standard_error })
            };
            let there = |p| number(p).unwrap_or_default();
            let servo = found.model.servos.iter().find(|term| term.joint == fit.joint);
            let stiffness = servo.filter(|term| term.is_determined).map(|term| ServoNumber {
                value: term.servo.stiffness,
                standard_error: term.stiffness_error,
            });
            ServoRow {
                joint: fit.joint.clone(),
                translates: !chain.joints[k].kind.is_rotational(),
                stiffness,
                delay_s: there(ServoParameter::Delay),
                damping_s: there(ServoParameter::Damping),
                inertia_s2: there(ServoParameter::Inertia),
                offset: there(ServoParameter::Offset),
                dry_friction: there(ServoParameter::DryFriction),
                static_excess: number(ServoParameter::StaticExcess),
                stribeck_velocity: number(ServoParameter::StribeckVelocity),
                load_friction: number(ServoParameter::LoadFriction),
                sag: fit.sag,
                lag_s: fit.lag.map(|lag| lag.value_s),
                lag_interval_95_s: fit.lag.and_then(|lag| lag.interval_95),
                train_rms: fit.train.clone(),
                holdout_rms: fit.holdout.clone(),
                command_rms: fit.command_alone.clone(),
            }
        };
        let mut notes = Vec::new();
        let open: Vec<&str> = (found.joints.iter())
            .filter(|fit| !fit.is_determined)
            .map(|fit| fit.joint.as_str())
            .collect();
        if !open.is_empty() {
            notes.push(format!(
                "stiffness of {} not identifiable: the weight on the joint moves it too little, and commands give only ratios to \
                 it; a known load on the joint determines it. Its efforts in the model have an arbitrary scale, its positions do not \
                 depend on it",
                open.join(", ")
            ));
        }
        notes.extend(found.joints.iter().filter_map(|fit| load_friction_note(found, fit)));
        notes.push(
            "damping is the sum of viscous friction, back-EMF and the derivative gain, which no motion separates".to_owned(),
        );
        if !found.magnitudes.is_empty() {
            notes.push(format!(
                "currents of {} are magnitudes: never negative, while the controller pushes both ways; they are not used as \
                 efforts, whose sign is that of command minus position",
                found.magnitudes.join(", ")
            ));
        }
        Self {
            schema: Self::SCHEMA.to_owned(),
            robot: chain.robot.clone(),
            joints: found.joints.iter().enumerate().map(row).collect(),
            currents_without_sign: found.magnitudes.clone(),
            notes,
            ..Self::default()
        }
    }

    /// Human-readable text.
    pub fn text(&self, bars: Bars) -> String {
        let holdout = match self.holdout_recordings.len() {
            0 => String::new(),
            some => format!(", {some} held out"),
        };
        format!(
            "{}: {} behind position controllers, {}{holdout}\n{}",
            self.robot,
            counted(self.joints.len(), "joint"),
            counted(self.recordings.len(), "recording"),
            render(self.blocks(), bars)
        )
    }

    fn blocks(&self) -> Vec<Block> {
        vec![
            Block::heading("Findings"),
            Block::Paragraph(self.findings().join("\n")),
            Block::heading_with_note(
                "Controllers",
                "friction and offset over the stiffness, in mrad or mm; ± one standard error",
            ),
            Block::Table(self.controllers()),
            Block::heading_with_note(
                "Position error",
                "RMS in mrad or mm, median over recordings, simulated from commands",
            ),
            Block::Table(self.errors()),
        ]
    }

    /// What the arm shows, one sentence a joint.
    fn findings(&self) -> Vec<String> {
        let sentence = |row: &ServoRow| {
            let milli = |x: f64| significant(1e3 * x, 3, 0.0);
            let unit = if row.translates { "mm" } else { "mrad" };
            let mut parts = Vec::new();
            if let Some(lag) = row.lag_s {
                let between = row.lag_interval_95_s.map_or_else(String::new, |[a, b]| {
                    format!(" (95 % interval {} to {})", milli(a), milli(b))
                });
                parts.push(format!("lags {} ms behind its command{between}", milli(lag)));
            }
            if let Some(sag) = row.sag.filter(|_| row.stiffness.is_some()) {
                parts.push(format!(
                    "sags up to {} {unit} under the weight of the links",
                    milli(sag)
                ));
            }
            let dry = row.dry_friction;
            if dry.standard_error.is_none_or(|error| dry.value > 2.0 * error) {
                let by_load = match row.load_friction {
                    Some(of) => {
                        format!(" and {} % of its load", significant(100.0 * of.value, 2, 0.0))
                    }
                    None => String::new(),
                };
                parts.push(format!(
                    "dry friction holds it {} {unit}{by_load} away",
                    milli(dry.value)
                ));
            }
            format!("  {}: {}", row.joint, parts.join("; "))
        };
        self.joints.iter().map(sentence).collect()
    }

    fn controllers(&self) -> Table {
        let shown = |number: &ServoNumber, factor: f64| match number.standard_error {
            Some(error) => {
                let (value, error) = uncertain(factor * number.value, factor * error);
                format!("{value} ± {error}")
            }
            None => significant(factor * number.value, 3, 0.0),
        };
        let row = |row: &ServoRow| -> Vec<String> {
            let maybe = |number: Option<ServoNumber>, factor: f64| {
                number.map_or_else(String::new, |number| shown(&number, factor))
            };
            vec![
                row.joint.clone(),
                row.stiffness.map_or_else(|| "not identifiable".to_owned(), |k| shown(&k, 1.0)),
                shown(&row.delay_s, 1e3),
                shown(&row.damping_s, 1e3),
                shown(&row.offset, 1e3),
                shown(&row.dry_friction, 1e3),
                maybe(row.static_excess, 1e3),
                maybe(row.load_friction, 1.0),
            ]
        };
        Table::new("Controllers", &["joint"])
            .numbers(&[
                "stiffness [N m/rad or N/m]",
                "delay [ms]",
                "damping [ms]",
                "offset",
                "dry friction",
                "stiction",
                "load friction [1]",
            ])
            .with(self.joints.iter().map(row))
            .without_empty_columns()
    }

    fn errors(&self) -> Table {
        let middle = |values: &[f64]| {
            let mut sorted = values.to_vec();
            sorted.sort_by(f64::total_cmp);
            let n = sorted.len();
            match n {
                0 => f64::NAN,
                n if n % 2 == 1 => sorted[n / 2],
                n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
            }
        };
        let milli = |values: &[f64]| match values {
            [] => String::new(),
            _ => significant(1e3 * middle(values), 3, 0.0),
        };
        let row = |row: &ServoRow| {
            let held = if row.holdout_rms.is_empty() { &row.train_rms } else { &row.holdout_rms };
            let ratio = middle(held) / middle(&row.command_rms);
            vec![
                row.joint.clone(),
                milli(&row.command_rms),
                milli(&row.train_rms),
                milli(&row.holdout_rms),
                significant(ratio, 2, 0.0),
            ]
        };
        Table::new("Position error", &["joint"])
            .numbers(&["command, best gain, offset, lag", "training", "hold-out", "over command"])
            .with(self.joints.iter().map(row))
            .without_empty_columns()
    }
}

/// Friction `f = µ |load|` behind a stiffness `K` and `f = µ |motor effort|` behind `K / (1 - µ²)` balance the same loads at the same
/// position errors: driving `(1 + µ) load / K`, driven `(1 - µ) load / K`.
fn load_friction_note(found: &ServoIdentification, fit: &ServoJointFit) -> Option<String> {
    let servo = found.model.servos.iter().find(|term| term.joint == fit.joint)?;
    let by_load =
        fit.values.iter().find(|value| value.parameter == ServoParameter::LoadFriction)?;
    servo.is_determined.then(|| {
        format!(
            "friction of {} is taken to grow with the load of its links; where it grows with the effort of its motor instead, \
             positions are the same and its stiffness is {}. A known effort of the motor separates the two",
            fit.joint,
            significant(servo.servo.stiffness / (1.0 - by_load.value.powi(2)), 3, 0.0)
        )
    })
}
