//! Ablation: the model without one of its findings; the difference is what the finding explains.

use armident_effects::EffectOnJoint;

use crate::findings::finding::Finding;
use armident_model::DiagnosedModel;

impl Finding {
    /// A diagnosed model without what the finding stands for, all else as it is; `before` is
    /// the model that was diagnosed. Contacts are in no model: nothing goes.
    #[must_use]
    pub fn ablated_from(&self, model: &DiagnosedModel, before: &DiagnosedModel) -> DiagnosedModel {
        let (finding, mut model) = (self, model.clone());
        let is_on = |joint: &str| finding.joints.first().is_some_and(|j| j == joint);
        let index = model.arm.chain.joints.iter().position(|j| is_on(&j.name));
        let slug = finding.effect.as_str();
        let is_it = |e: &EffectOnJoint| e.effect == slug && is_on(&e.joint);
        // what was known before stands first, or is one with what was found
        let known = before.arm.effects.iter().filter(|e| is_it(e)).count();
        for (effects, known) in [(&mut model.arm.effects, known), (&mut model.learned.couplings, 0)]
        {
            let Some(k) = effects.iter().rposition(is_it) else { continue };
            let found = finding.parameters.values().next().map(|number| number.value);
            match (effects.iter().filter(|e| is_it(e)).count(), found) {
                (all, Some(found)) if all == known => effects[k].parameters[0] -= found,
                _ => drop(effects.remove(k)),
            }
        }
        let (learned, earlier) = (&mut model.learned, &before.learned);
        match (slug, index) {
            ("joint_elasticity" | "backlash", _) => {
                if let Some(k) = learned.transmissions.iter().rposition(|t| is_on(&t.joint)) {
                    learned.transmissions.remove(k);
                }
            }
            ("torque_scale", Some(j)) => learned.gain[j] = earlier.gain[j],
            ("encoder_offset", Some(j)) => learned.encoder_offset[j] = earlier.encoder_offset[j],
            ("gravity_direction", _) => learned.tilt_rad = earlier.tilt_rad,
            ("time_delay", _) => learned.delay_s = earlier.delay_s,
            (crate::UNMODELLED, _) => {
                let same = |f: &armident_model::SmoothTerm| {
                    is_on(&f.joint) && f.basis.variables() == finding.evidence.variables
                };
                if let Some(k) = learned.flexible.iter().rposition(same) {
                    learned.flexible.remove(k);
                }
            }
            _ => {}
        }
        if let Some(link) = &finding.link {
            let joints = model.arm.chain.joints.iter_mut().zip(&before.arm.chain.joints);
            for (joint, earlier) in joints.filter(|(j, _)| j.child_link == *link) {
                joint.link = earlier.link;
            }
        }
        model
    }
}
