//! What was learned, in a form that predicts.

use crate::{ArmModel, OperatingPoint, PosedRecording, PreparedRecording, Transmission};
use armident_dynamics::RigidArm;
use armident_effects::{
    Effect, EffectOnJoint, Scope, SublinearViscousFriction, Turn, effect,
    joined_where_inadmissible, tilted,
};
use armident_recording::{Recording, RecordingError};
use nalgebra::Vector3;

use crate::learned::Learned;
use armident_motion::{Signals, continued, filter_between, later, low_pass};

/// A model with what a diagnosis learned.
#[derive(Debug, Clone)]
pub struct DiagnosedModel {
    /// Rigid body and effects on joints.
    pub arm: ArmModel,
    /// The rest.
    pub learned: Learned,
}

impl DiagnosedModel {
    /// The believed arm, nothing learned.
    pub fn believed(arm: &ArmModel) -> Self {
        let learned = Learned::nothing(arm.chain.dof());
        let mut arm = arm.clone();
        arm.effects.clear();
        Self { arm, learned }
    }

    /// What a model file holds: an arm with effects on joints, and what a diagnosis learned beyond.
    pub fn of_file(mut arm: ArmModel, learned: Option<Learned>) -> Self {
        let mut learned = learned.unwrap_or_else(|| Learned::nothing(arm.chain.dof()));
        let (pairs, single): (Vec<_>, Vec<_>) =
            arm.effects.into_iter().partition(|e| e.other_joint.is_some());
        arm.effects = single;
        learned.couplings.extend(pairs);
        Self { arm, learned }
    }

    /// Whether there is nothing but links: what a URDF gives.
    pub fn is_links_alone(&self) -> bool {
        let Learned {
            couplings,
            tilt_rad,
            encoder_offset,
            delay_s,
            gain,
            transmissions,
            flexible,
            ..
        } = &self.learned;
        self.arm.effects.is_empty()
            && couplings.is_empty()
            && transmissions.is_empty()
            && flexible.is_empty()
            && encoder_offset.iter().chain(tilt_rad).chain([delay_s]).all(|x| *x == 0.0)
            && gain.iter().all(|g| *g == 1.0)
    }

    /// Joints whose friction grows more slowly than the speed, and the coefficients of that.
    pub fn friction_bends(&self) -> impl Iterator<Item = (&str, f64)> {
        let bends = self.arm.effects.iter().filter(|on| is_bend(&on.effect));
        bends.map(|on| (on.joint.as_str(), on.parameters[0]))
    }

    /// Where the model puts what turns the configuration itself.
    pub fn point(&self) -> OperatingPoint {
        OperatingPoint {
            tilt: self.learned.tilt_rad,
            offset: self.learned.encoder_offset.clone(),
            delay_s: self.learned.delay_s,
            // those of the chain already
            links: None,
            springs: Vec::new(),
            turns: self.learned.turns(),
            gain: self.learned.gain.clone(),
        }
    }

    /// Effort of every joint at every stamp of a motion, in recorded terms.
    ///
    /// # Errors
    /// A motion without the positions of the joints, or mostly gaps.
    pub fn predict(&self, motion: &Recording) -> Result<Vec<Vec<f64>>, RecordingError> {
        let names: Vec<String> = self.arm.chain.joints.iter().map(|j| j.name.clone()).collect();
        self.predict_seen(&PreparedRecording::of(motion, &names)?)
    }

    /// The same of a motion that other models predict as well: most of the work is to see it.
    ///
    /// # Errors
    /// None but those of a filter.
    pub fn predict_seen(
        &self,
        motion: &PreparedRecording<'_>,
    ) -> Result<Vec<Vec<f64>>, RecordingError> {
        let PreparedRecording { grid, signals, .. } = motion;
        let smoothed = |(effort, cutoff_hz): (&Vec<f64>, &Option<f64>)| match cutoff_hz {
            Some(hz) => Ok(grid.at_stamps(&low_pass(*hz, signals.rate_hz)?.filter(effort))),
            None => Ok(grid.at_stamps(effort)),
        };
        self.on_grid(signals)?.iter().zip(&self.learned.output_cutoff_hz).map(smoothed).collect()
    }

    /// The prediction on the grid, before the low-pass of the output.
    pub fn on_grid(&self, signals: &Signals) -> Result<Vec<Vec<f64>>, RecordingError> {
        let chain = &self.arm.chain;
        let at = PosedRecording::new(chain, &RigidArm::from_chain(chain), signals, &self.point());
        let rigid_filter = low_pass(self.learned.rigid_cutoff_hz, signals.rate_hz)?;
        let mut effort: Vec<Vec<f64>> = (at.rigid.iter().enumerate())
            .map(|(j, rigid)| {
                let own = at.of_own(j, false);
                let rigid = own.as_ref().unwrap_or(rigid);
                filter_between(rigid, &signals.stops[j], &rigid_filter, signals.rate_hz)
            })
            .collect();
        let index = |name: &str| chain.joints.iter().position(|j| j.name == name);
        for on_joint in &self.arm.effects {
            let (Some(law), Some(j)) = (effect(&on_joint.effect), index(&on_joint.joint)) else {
                continue;
            };
            if law.law().scope == Scope::Joint {
                add(&mut effort[j], &law.effort(&on_joint.parameters, &at.joint(j)));
            }
        }
        for term in &self.learned.transmissions {
            let Some(j) = index(&term.joint) else { continue };
            let difference = term.transmission.difference(&at, j)?;
            for (effort, difference) in effort.iter_mut().zip(&difference) {
                let part: Vec<f64> = difference.iter().map(|x| x * term.share).collect();
                add(effort, &part);
            }
            let inertia: Vec<f64> =
                signals.held_acceleration[j].iter().map(|a| a * term.motor_inertia).collect();
            add(&mut effort[j], &inertia);
        }
        for coupling in &self.learned.couplings {
            let (Some(law), Some(j)) = (effect(&coupling.effect), index(&coupling.joint)) else {
                continue;
            };
            let (shape, coefficients) = law.shape_and_coefficients(&coupling.parameters);
            let columns = law.pair_columns(&shape, &at.joint(j), &at.joint(j + 1));
            for (column, x) in columns.iter().zip(&coefficients) {
                for side in 0..2 {
                    let part: Vec<f64> = column[side].iter().map(|c| c * x).collect();
                    add(&mut effort[j + side], &part);
                }
            }
        }
        for term in &self.learned.flexible {
            if let Some(j) = index(&term.joint) {
                add(&mut effort[j], &term.effort(&at, index));
            }
        }
        for (j, effort) in effort.iter_mut().enumerate() {
            *effort = continued(effort, &signals.stops[j], signals.rate_hz);
            effort.iter_mut().for_each(|e| *e *= self.learned.gain[j]);
            *effort = later(effort, -self.learned.delay_s * signals.rate_hz);
        }
        Ok(effort)
    }

    /// The arm with all that was learned as effects on it, for simulation and export; and what has no place
    /// in a simulated arm (structure without a name, lags and gains of channels).
    pub fn as_simulated(&self) -> (ArmModel, Vec<String>) {
        let mut arm = self.arm.clone();
        let names: Vec<String> = arm.chain.joints.iter().map(|j| j.name.clone()).collect();
        let mut lost = Vec::new();
        for coupling in &self.learned.couplings {
            let second = names.iter().position(|n| *n == coupling.joint).map(|j| j + 1);
            let mut coupling = coupling.clone();
            coupling.other_joint = second.and_then(|j| names.get(j).cloned());
            arm.effects.push(coupling);
        }
        for term in &self.learned.transmissions {
            let Transmission { stiffness, damping, .. } = term.transmission;
            let gap = term.transmission.gap_told(term.share);
            let (slug, parameters) = if gap > 0.0 {
                ("backlash", vec![gap, stiffness, damping, term.motor_inertia])
            } else {
                ("joint_elasticity", vec![stiffness, damping, term.motor_inertia])
            };
            arm.effects.push(EffectOnJoint::new(slug, &term.joint, parameters));
        }
        let tilt = Vector3::new(self.learned.tilt_rad[0], self.learned.tilt_rad[1], 0.0);
        arm.chain.gravity_e0 = tilted(&arm.chain.base_from_e0, &arm.chain.gravity_e0, &tilt);
        for (name, offset) in names.iter().zip(&self.learned.encoder_offset) {
            if *offset != 0.0 {
                arm.effects.push(EffectOnJoint::new("encoder_offset", name, vec![*offset]));
            }
        }
        for (name, gain) in names.iter().zip(&self.learned.gain) {
            if *gain != 1.0 {
                arm.effects.push(EffectOnJoint::new("torque_scale", name, vec![*gain]));
            }
        }
        arm.effects = joined_where_inadmissible(arm.effects);
        arm.effects.retain(|on| {
            let has_place = on.has_admissible_signs();
            if !has_place {
                lost.push(format!("{} of {}, which is below zero", on.effect, on.joint));
            }
            has_place
        });
        if self.learned.delay_s != 0.0 {
            lost.push(format!("the lag of the efforts, {:.4} s", self.learned.delay_s));
        }
        for (name, turn) in names.iter().zip(self.learned.turns()) {
            match turn {
                Turn::Speed(speed) if speed > 0.0 => {
                    lost.push(format!("dry friction of {name} fading below {speed:.3} /s"));
                }
                Turn::Travel(travel) => {
                    lost.push(format!(
                        "dry friction of {name} building up over {travel:.5} rad or m"
                    ));
                }
                Turn::Speed(_) => {}
            }
        }
        for term in &self.learned.flexible {
            lost.push(format!("structure without a name on {}", term.joint));
        }
        (arm, lost)
    }

    /// Writes the model as one JSON file: that of the arm, and a section of what was learned.
    ///
    /// # Errors
    /// When the model cannot be put into JSON.
    pub fn to_json(&self) -> serde_json::Result<String> {
        let mut document: serde_json::Value = serde_json::from_str(&self.arm.to_json()?)?;
        document["learned"] = serde_json::to_value(&self.learned)?;
        Ok(serde_json::to_string_pretty(&document)? + "\n")
    }
}

fn add(to: &mut [f64], part: &[f64]) {
    for (to, part) in to.iter_mut().zip(part) {
        *to += part;
    }
}

/// Whether a law is the bend of a joint's friction.
pub fn is_bend(slug: &str) -> bool {
    slug == SublinearViscousFriction.law().slug
}
