//! The model as an arm with effects on its joints: what simulations and exports can hold.

use armident_effects::{
    Backlash, Effect, EffectOnJoint, EncoderOffset, JointElasticity, PositionControl,
    ReversalModel, TorqueScale, tilted,
};
use nalgebra::Vector3;

use crate::arm_model::ArmModel;
use crate::transmission::FittedTransmission;

impl ArmModel {
    /// The arm with all that the model holds as effects on joints, for simulation and export; and what these cannot hold
    /// (smooth terms, delays, how friction reverses, dead zones of channels).
    pub fn simulated(&self) -> (Self, Vec<String>) {
        if self.band.is_none() {
            let mut arm = self.clone();
            arm.effects.extend(self.position_controls());
            return (arm, self.only_predicted());
        }
        let mut arm = Self {
            effects: self.joint_effects().chain(self.pair_effects()).cloned().collect(),
            ..self.links_only()
        };
        let names: Vec<String> = arm.chain.joints.iter().map(|j| j.name.clone()).collect();
        let mut lost = Vec::new();
        for term in &self.transmissions {
            let gap = term.transmission.fitted_gap(term.share);
            let transmission = FittedTransmission { gap, ..term.transmission }
                .with_motor_inertia(term.motor_inertia);
            let law: &dyn Effect = if gap > 0.0 { &Backlash } else { &JointElasticity };
            let parameters = law.parameters_of_transmission(&transmission);
            arm.effects.push(EffectOnJoint::new(law.slug(), &term.joint, parameters));
        }
        arm.effects.extend(self.position_controls());
        let tilt = Vector3::new(self.base_tilt_rad[0], self.base_tilt_rad[1], 0.0);
        arm.chain.gravity_e0 = tilted(&arm.chain.base_from_e0, &arm.chain.gravity_e0, &tilt);
        for (name, offset) in names.iter().zip(&self.encoder_offset) {
            if *offset != 0.0 {
                arm.effects.push(EffectOnJoint::new(EncoderOffset.slug(), name, vec![*offset]));
            }
        }
        for (name, gain) in names.iter().zip(&self.channel_gain) {
            if *gain != 1.0 {
                arm.effects.push(EffectOnJoint::new(TorqueScale.slug(), name, vec![*gain]));
            }
        }
        arm.effects = self.library.joined_where_inadmissible(arm.effects);
        arm.effects.retain(|on| {
            let has_place = self.library.has_admissible_signs(on);
            if !has_place {
                lost.push(format!("{} of {}, which is below zero", on.effect, on.joint));
            }
            has_place
        });
        if self.effort_delay_s != 0.0 {
            lost.push(format!("the lag of the efforts, {:.4} s", self.effort_delay_s));
        }
        if self.effort_low_pass_s != 0.0 {
            lost.push(format!("the low-pass of the efforts, {:.4} s", self.effort_low_pass_s));
        }
        if self.effort_clock_drift != 0.0 {
            lost.push(format!(
                "the drift of the clock of the efforts, {:.0} ppm",
                1e6 * self.effort_clock_drift
            ));
        }
        for (name, reversal) in names.iter().zip(self.reversals.iter().flatten()) {
            match reversal {
                ReversalModel::RegularisedSign { below } if *below > 0.0 => {
                    lost.push(format!(
                        "dry friction of {name} linear in speed below {below:.3} rad/s or m/s"
                    ));
                }
                ReversalModel::Presliding { travel } => {
                    lost.push(format!(
                        "dry friction of {name} building up over {travel:.5} rad or m"
                    ));
                }
                ReversalModel::RegularisedSign { .. } => {}
            }
        }
        for term in &self.smooth_terms {
            lost.push(format!("structure without a name on {}", term.joint));
        }
        (arm, lost)
    }

    /// What predictions have that is no part of a simulated arm: presliding friction, which reverses at once
    /// there, and the dead zones of channels.
    fn only_predicted(&self) -> Vec<String> {
        let names = || self.chain.joints.iter().map(|joint| &joint.name);
        let reversals = names()
            .zip(self.reversals.iter().flatten())
            .filter(|(_, reversal)| reversal.presliding_travel() > 0.0);
        let reversals = reversals.map(|(name, reversal)| {
            format!(
                "dry friction of {name} building up over {:.5} rad or m",
                reversal.presliding_travel()
            )
        });
        let shown = names().zip(self.shown.iter().flatten());
        let shown = shown.filter_map(|(name, shown)| {
            let percent = 100.0 * shown.as_ref()?.share;
            Some(format!("the {percent:.1} % of its effort that the column of {name} shows"))
        });
        reversals.chain(shown).collect()
    }

    /// The position controllers of the joints as effects on them.
    fn position_controls(&self) -> impl Iterator<Item = EffectOnJoint> {
        let slug = PositionControl.slug();
        self.servos
            .iter()
            .map(move |term| EffectOnJoint::new(slug, &term.joint, term.servo.parameters()))
    }
}
