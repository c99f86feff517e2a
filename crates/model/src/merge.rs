//! A model and a change of it in one.

use armident_effects::{BASELINE, EffectOnJoint};

use crate::arm_model::ArmModel;
use crate::reversal::SHARP;

impl ArmModel {
    /// The model with a change that was found beside it: links and effects of both, and the low-passes of this one, for
    /// those of a change would blur what it already explains.
    #[must_use]
    pub fn with_change(&self, change: Self) -> Self {
        let mut all = change;
        let mut effects = self.effects.clone();
        for change in all.effects {
            // baseline terms of a joint, seen again with the recordings after
            let same = |e: &&mut EffectOnJoint| {
                BASELINE.iter().any(|law| law.law().slug == e.effect)
                    && e.effect == change.effect
                    && e.joint == change.joint
            };
            match effects.iter_mut().find(same) {
                Some(known) => known.parameters[0] += change.parameters[0],
                None => effects.push(change),
            }
        }
        all.effects = effects;
        // the first model of the arm stays what a later one is compared with
        if self.prior_links.is_some() {
            all.prior_links.clone_from(&self.prior_links);
        }
        all.transmissions = [self.transmissions.clone(), all.transmissions].concat();
        all.smooth_terms = [self.smooth_terms.clone(), all.smooth_terms].concat();
        all.effort_delay_s += self.effort_delay_s;
        all.effort_low_pass_s += self.effort_low_pass_s;
        all.effort_clock_drift += self.effort_clock_drift;
        all.band.clone_from(&self.band);
        if let Some(own) = &self.reversals {
            // where the change says nothing of how friction reverses, it does as before
            let of_change = all.reversals.unwrap_or_else(|| vec![SHARP; own.len()]);
            let both = of_change.into_iter().zip(own);
            all.reversals =
                Some(both.map(|(new, own)| if new == SHARP { *own } else { new }).collect());
        }
        for (now, then) in all.encoder_offset.iter_mut().zip(&self.encoder_offset) {
            *now += then;
        }
        for (now, then) in all.channel_gain.iter_mut().zip(&self.channel_gain) {
            *now *= then;
        }
        all
    }
}
