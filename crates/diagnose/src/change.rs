//! What changed between two sets of recordings of one arm.

use armident_effects::{EVERYDAY, EffectOnJoint, tilted};
use armident_ident::ArmModel;
use armident_recording::Recording;
use nalgebra::Vector3;

use crate::diagnosis::{DiagnoseError, Diagnosis, diagnose, diagnose_from};
use crate::model::DiagnosedModel;

/// The diagnosis of recordings against reference recordings of the same arm: what the reference shows
/// beyond the believed model is learned first and is no finding.
///
/// Gives what was learned of the reference, and the diagnosis of the difference.
///
/// # Errors
/// [`DiagnoseError`].
pub fn diagnose_change(
    model: &ArmModel,
    reference: &[Recording],
    after: &[Recording],
) -> Result<(DiagnosedModel, Diagnosis), DiagnoseError> {
    let of_reference = diagnose(model, reference)?;
    let before = of_reference.model;
    let mut believed = before.arm.clone();
    believed.effects.clear();
    // the tilt of the base becomes part of the arm; gains, zeros and lags stay the recordings'
    let tilt = Vector3::new(before.learned.tilt_rad[0], before.learned.tilt_rad[1], 0.0);
    let chain = &mut believed.chain;
    chain.gravity_e0 = tilted(&chain.base_from_e0, &chain.gravity_e0, &tilt);
    // effects and nothing else: what the low-passes do to the rigid body is none
    let mut effects = before.clone();
    effects.learned.output_cutoff_hz.fill(None);
    let mut rigid = DiagnosedModel::believed(&believed);
    rigid.learned.rigid_cutoff_hz = effects.learned.rigid_cutoff_hz;
    let corrected: Vec<Recording> = reference
        .iter()
        .chain(after)
        .map(|recording| {
            let all = effects.predict(recording)?;
            let body = rigid.predict(recording)?;
            let mut corrected = recording.clone();
            for (joint, (all, body)) in chain_names(&before.arm).iter().zip(all.iter().zip(&body)) {
                let Some(channels) = corrected.joints.iter_mut().find(|j| j.name == *joint) else {
                    continue;
                };
                for (effort, (all, body)) in
                    channels.effort.iter_mut().flatten().zip(all.iter().zip(body))
                {
                    *effort -= all - body;
                }
            }
            Ok(corrected)
        })
        .collect::<Result<_, DiagnoseError>>()?;
    // the reference stays in the problem: what is uncertain about the arm before is uncertain in both
    let mut difference =
        diagnose_from(&believed, &corrected, reference.len(), of_reference.narrowed_to_hz)?;
    difference.model = together(&before, difference.model);
    difference.rigid = together(&before, difference.rigid);
    let beside = difference.without.iter_mut().flatten();
    for model in beside.chain(difference.rivals.iter_mut().flatten()) {
        *model = together(&before, model.clone());
    }
    Ok((before, difference))
}

fn chain_names(model: &ArmModel) -> Vec<String> {
    model.chain.joints.iter().map(|j| j.name.clone()).collect()
}

/// What was learned before and what was learned of the change, in one model.
fn together(before: &DiagnosedModel, change: DiagnosedModel) -> DiagnosedModel {
    let mut all = change;
    let mut effects = before.arm.effects.clone();
    for change in all.arm.effects {
        // the everyday terms of a joint, seen again with the recordings after
        let same = |e: &&mut EffectOnJoint| {
            EVERYDAY.iter().any(|law| law.law().slug == e.effect)
                && e.effect == change.effect
                && e.joint == change.joint
        };
        match effects.iter_mut().find(same) {
            Some(known) => known.parameters[0] += change.parameters[0],
            None => effects.push(change),
        }
    }
    all.arm.effects = effects;
    let (learned, earlier) = (&mut all.learned, &before.learned);
    learned.couplings = [earlier.couplings.clone(), learned.couplings.clone()].concat();
    learned.transmissions = [earlier.transmissions.clone(), learned.transmissions.clone()].concat();
    learned.flexible = [earlier.flexible.clone(), learned.flexible.clone()].concat();
    learned.delay_s += earlier.delay_s;
    for (now, then) in learned.encoder_offset.iter_mut().zip(&earlier.encoder_offset) {
        *now += then;
    }
    for (now, then) in learned.gain.iter_mut().zip(&earlier.gain) {
        *now *= then;
    }
    all
}
