//! Ablation: the model without one of its findings; the difference is the effort that the finding explains.

use armident_effects::{EffectOnJoint, OperatingTerm, UNMODELLED};

use crate::findings::finding::Finding;
use armident_model::{ArmModel, SmoothTerm};

impl Finding {
    /// A diagnosed model without the effect of the finding, all else as it is; `before` is the given model. Contacts are in no
    /// model and remove nothing.
    #[must_use]
    pub fn ablated_from(&self, model: &ArmModel, before: &ArmModel) -> ArmModel {
        let (finding, mut model) = (self, model.clone());
        let is_on = |joint: &str| finding.joints.first().is_some_and(|j| j == joint);
        let index = model.chain.joints.iter().position(|j| is_on(&j.name));
        let slug = finding.effect.as_str();
        let is_it = |e: &EffectOnJoint| e.effect == slug && is_on(&e.joint);
        // known effects stand first, or are joined with the finding
        let known = before.effects.iter().filter(|e| is_it(e)).count();
        let effects = &mut model.effects;
        if let Some(k) = effects.iter().rposition(is_it) {
            let found = finding.parameters.values().next().map(|number| number.value);
            match (effects.iter().filter(|e| is_it(e)).count(), found) {
                (all, Some(found)) if all == known => effects[k].parameters[0] -= found,
                _ => drop(effects.remove(k)),
            }
        }
        let law = model.library.law(slug);
        if law.is_some_and(|law| law.link_side().is_some())
            && let Some(k) = model.transmissions.iter().rposition(|t| is_on(&t.joint))
        {
            model.transmissions.remove(k);
        }
        match (law.and_then(|law| law.operating), index) {
            (Some(OperatingTerm::Gain), Some(j)) => model.channel_gain[j] = before.channel_gain[j],
            (Some(OperatingTerm::EncoderZero), Some(j)) => {
                model.encoder_offset[j] = before.encoder_offset[j];
            }
            (Some(OperatingTerm::Tilt), _) => model.base_tilt_rad = before.base_tilt_rad,
            (Some(OperatingTerm::Delay), _) => model.effort_delay_s = before.effort_delay_s,
            _ => {}
        }
        let same =
            |f: &SmoothTerm| is_on(&f.joint) && f.basis.variables() == finding.evidence.variables;
        if slug == UNMODELLED
            && let Some(k) = model.smooth_terms.iter().rposition(same)
        {
            model.smooth_terms.remove(k);
        }
        if let Some(link) = &finding.link {
            let joints = model.chain.joints.iter_mut().zip(&before.chain.joints);
            for (joint, earlier) in joints.filter(|(j, _)| j.child_link == *link) {
                joint.link = earlier.link;
            }
        }
        model
    }
}
