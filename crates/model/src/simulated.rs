//! The model as an arm with effects on its joints: what simulations and exports can hold.

use armident_effects::{EffectOnJoint, Turn, joined_where_inadmissible, tilted};
use nalgebra::Vector3;

use crate::arm_model::ArmModel;
use crate::transmission::Transmission;

impl ArmModel {
    /// The arm with all that the model holds as effects on joints, for simulation and export; and what these cannot hold
    /// (smooth terms, delays, how friction reverses, dead zones of channels).
    pub fn simulated(&self) -> (Self, Vec<String>) {
        if self.band.is_none() {
            return (self.clone(), self.only_predicted());
        }
        let mut arm = Self {
            effects: self.joint_effects().chain(self.pair_effects()).cloned().collect(),
            ..self.links_only()
        };
        let names: Vec<String> = arm.chain.joints.iter().map(|j| j.name.clone()).collect();
        let mut lost = Vec::new();
        for term in &self.transmissions {
            let Transmission { stiffness, damping, .. } = term.transmission;
            let gap = term.transmission.gap_told(term.share);
            let (slug, parameters) = if gap > 0.0 {
                ("backlash", vec![gap, stiffness, damping, term.motor_inertia])
            } else {
                ("joint_elasticity", vec![stiffness, damping, term.motor_inertia])
            };
            arm.effects.push(EffectOnJoint::new(slug, &term.joint, parameters));
        }
        let tilt = Vector3::new(self.base_tilt_rad[0], self.base_tilt_rad[1], 0.0);
        arm.chain.gravity_e0 = tilted(&arm.chain.base_from_e0, &arm.chain.gravity_e0, &tilt);
        for (name, offset) in names.iter().zip(&self.encoder_offset) {
            if *offset != 0.0 {
                arm.effects.push(EffectOnJoint::new("encoder_offset", name, vec![*offset]));
            }
        }
        for (name, gain) in names.iter().zip(&self.channel_gain) {
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
        if self.effort_delay_s != 0.0 {
            lost.push(format!("the lag of the efforts, {:.4} s", self.effort_delay_s));
        }
        for (name, turn) in names.iter().zip(self.turns.iter().flatten()) {
            match turn {
                Turn::Speed(speed) if *speed > 0.0 => {
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
        for term in &self.smooth_terms {
            lost.push(format!("structure without a name on {}", term.joint));
        }
        (arm, lost)
    }

    /// What predictions have that is no part of a simulated arm: presliding friction, which reverses at once
    /// there, and the dead zones of channels.
    fn only_predicted(&self) -> Vec<String> {
        let names = || self.chain.joints.iter().map(|joint| &joint.name);
        let turns =
            names().zip(self.turns.iter().flatten()).filter(|(_, turn)| turn.travel() > 0.0);
        let turns = turns.map(|(name, turn)| {
            format!("dry friction of {name} building up over {:.5} rad or m", turn.travel())
        });
        let shown = names().zip(self.shown.iter().flatten());
        let shown = shown.filter_map(|(name, shown)| {
            let percent = 100.0 * shown.as_ref()?.share;
            Some(format!("the {percent:.1} % of its effort that the column of {name} shows"))
        });
        turns.chain(shown).collect()
    }
}
