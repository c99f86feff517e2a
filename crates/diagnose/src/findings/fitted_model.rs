//! The model of an estimate.

use crate::selection::solution::Solution;
use armident_model::{
    ArmModel, BandPrediction, FittedTransmission, OperatingPoint, SHARP, SmoothTerm,
    TransmissionTerm, changed,
};

use crate::design::compliant_link::mean_inertia;
use armident_effects::{BASELINE, EffectOnJoint, Law, OperatingTerm, ReversalModel, Scope};
use armident_recording::RecordingError;
use rayon::prelude::*;

use crate::design::candidate::{Candidate, CandidateKind};
use crate::design::training::Design;
use crate::regression::consistent_links::{ConsistentEstimate, consistent_estimate};
use crate::regression::fit_set::fit_set;
use crate::regression::relinearise::moves;
use armident_motion::low_pass;

/// Cut-offs tried for the output of a joint \[Hz\].
const OUTPUT_HZ: [Option<f64>; 6] = [None, Some(18.0), Some(11.0), Some(8.0), Some(6.0), Some(4.5)];

/// Cut-offs tried for the rigid part \[Hz\].
const RIGID_HZ: [f64; 7] = [40.0, 20.0, 14.0, 10.0, 7.0, 5.0, 3.5];

/// Parameters of a law in true efforts: coefficients of one joint are divided by the gain of its channel; columns of two
/// joints include it.
pub(crate) fn law_parameters(
    candidate: &Candidate,
    coefficients: &[f64],
    gain: &[f64],
) -> Vec<f64> {
    let Some(law) = candidate.law() else { return Vec::new() };
    let scale = match candidate.location.joints.as_slice() {
        [joint] if !is_gain(candidate) => gain[*joint],
        _ => 1.0,
    };
    let coefficients: Vec<f64> = coefficients.iter().map(|c| c / scale).collect();
    law.parameters(&candidate.shape, &coefficients)
}

/// Whether it is the gain of an effort channel.
fn is_gain(candidate: &Candidate) -> bool {
    candidate.has(|law| law.operating == Some(OperatingTerm::Gain))
}

/// What links a model has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Links {
    /// Physically consistent ones.
    Consistent,
    /// Those of the estimate, whatever they are.
    AsFitted,
}

/// The model of an estimate; and the distance of its links from the estimate's in standard errors, where these are not
/// physically consistent.
pub(crate) fn fitted_model(
    model: &ArmModel,
    solution: &Solution<'_, '_>,
    links: Links,
) -> (ArmModel, Option<f64>) {
    let Solution { design, metric, estimate, point: formed_at, ref gain, .. } = *solution;
    let problem = metric.problem;
    let mut found = model.links_in_band();
    let ConsistentEstimate { change, coefficients, distance_in_standard_errors } = match links {
        Links::Consistent => consistent_estimate(design.chain, metric, estimate),
        Links::AsFitted => ConsistentEstimate::of(metric, estimate),
    };
    let point = moves(problem, estimate, formed_at);
    for (&g, coefficients) in estimate.set.iter().zip(coefficients) {
        let candidate = &problem.candidates[g];
        if candidate.transform.is_some() {
            continue;
        }
        if let CandidateKind::SmoothDirections(flexible) = &candidate.kind {
            let hats = flexible.transform.first().map_or(0, Vec::len);
            let scale = gain[candidate.location.joints[0]];
            found.smooth_terms.push(SmoothTerm {
                joint: design.names[candidate.location.joints[0]].clone(),
                basis: flexible.basis.clone(),
                coefficients: (0..hats)
                    .map(|h| {
                        let of_hat = flexible.transform.iter().map(|t| t[h]).zip(&coefficients);
                        of_hat.map(|(t, c)| t * c).sum::<f64>() / scale
                    })
                    .collect(),
            });
            continue;
        }
        let Some(law) = candidate.law() else { continue };
        if let (Some(_), Some(&joint)) = (law.law().link_side(), candidate.location.joints.first())
        {
            // a compliance to first order has no damping: that of gears, by experience
            const DAMPING: f64 = 0.1;
            let inertia = mean_inertia(solution.at(), joint);
            let of_shape = FittedTransmission::of_law(law, &candidate.shape, inertia);
            let (transmission, share) = of_shape.map_or_else(
                || {
                    let stiffness = 1.0 / coefficients[0];
                    let damping = 2.0 * DAMPING * (stiffness * inertia).sqrt();
                    (FittedTransmission { gap: 0.0, stiffness, damping }, 1.0)
                },
                |transmission| (transmission, coefficients[0]),
            );
            found.transmissions.push(TransmissionTerm {
                joint: design.names[joint].clone(),
                transmission,
                motor_inertia: coefficients[1] / gain[joint],
                share,
            });
            continue;
        }
        let on_joint = |parameters: Vec<f64>| {
            EffectOnJoint::new(law.slug(), &design.names[candidate.location.joints[0]], parameters)
        };
        match law.law().scope {
            Scope::Joint if !is_gain(candidate) => {
                found.effects.push(on_joint(law_parameters(candidate, &coefficients, gain)));
            }
            Scope::Neighbours => found.effects.push(EffectOnJoint {
                other_joint: design.names.get(candidate.location.joints[0] + 1).cloned(),
                ..on_joint(law_parameters(candidate, &coefficients, gain))
            }),
            _ => {}
        }
    }
    for (k, joint) in found.chain.joints.iter_mut().enumerate() {
        joint.link = changed(&joint.link, &change[10 * k..10 * (k + 1)]);
    }
    // baseline terms of the reference and the recordings after it together
    let links = problem.link_error_prior.links;
    for (k, x) in change[10 * links..].iter().enumerate() {
        let (joint, law) = (k / BASELINE.len(), BASELINE[k % BASELINE.len()]);
        found.effects.push(EffectOnJoint::new(law.law().slug, &design.names[joint], vec![*x]));
    }
    found.base_tilt_rad = point.tilt;
    found.encoder_offset = point.offset;
    found.effort_delay_s = point.delay_s;
    let has_dry_friction = |name: &String| {
        found.effects.iter().any(|on| {
            let law = design.library.law(&on.effect);
            on.joint == *name && law.is_some_and(Law::is_dry_friction)
        })
    };
    let reversals = design.names.iter().zip(point.reversals);
    let reversals: Vec<ReversalModel> = reversals
        .map(|(name, reversal)| if has_dry_friction(name) { reversal } else { SHARP })
        .collect();
    found.reversals = Some(reversals);
    found.channel_gain.clone_from(gain);
    found.prior_links = Some(design.chain.joints.iter().map(|j| j.link).collect());
    (found, distance_in_standard_errors)
}

/// The links-only fit.
pub(crate) fn links_only_fit(model: &ArmModel, design: &Design<'_>) -> Option<ArmModel> {
    const SCALE: f64 = 1.0;
    let problem = design.problem_without_trials(&OperatingPoint::of(design.joints()));
    let metric = problem.marginalised(SCALE, &[]);
    let change = metric.inertial_errors(&fit_set(&metric, Vec::new())?.fit);
    let mut found = model.links_in_band();
    for (k, joint) in found.chain.joints.iter_mut().enumerate() {
        joint.link = changed(&joint.link, &change[10 * k..10 * (k + 1)]);
    }
    Some(found)
}

/// Chooses the low-pass of the rigid part, and then that of each joint's prediction, by the training recordings; their
/// residual is the noise of the model.
pub(crate) fn choose_outputs(
    model: &mut ArmModel,
    design: &Design<'_>,
) -> Result<(), RecordingError> {
    let n = design.joints();
    let mut band = BandPrediction::of(n);
    let discrepancy = |cutoff_hz: &f64| -> Result<(f64, f64), RecordingError> {
        let rigid = BandPrediction { rigid_cutoff_hz: *cutoff_hz, ..band.clone() };
        let model = ArmModel { band: Some(rigid), ..model.clone() };
        let mut squares = vec![0.0; n];
        for signals in design.signals.iter() {
            for (j, predicted) in model.predict_in_band(signals)?.iter().enumerate() {
                let differences = predicted.iter().zip(&signals.effort[j]);
                squares[j] += differences.map(|(p, e)| (p - e).powi(2)).sum::<f64>();
            }
        }
        // each joint in its own unit: a product of errors, not a sum
        Ok((squares.iter().map(|s| s.max(f64::MIN_POSITIVE).ln()).sum(), *cutoff_hz))
    };
    let discrepancies = RIGID_HZ.par_iter().map(discrepancy).collect::<Result<Vec<_>, _>>()?;
    let least = discrepancies.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    band.rigid_cutoff_hz = least.map_or(band.rigid_cutoff_hz, |(_, hz)| hz);
    model.band = Some(band.clone());
    let mut squares = vec![[0.0; OUTPUT_HZ.len()]; n];
    for signals in design.signals.iter() {
        let predicted = model.predict_in_band(signals)?;
        for j in 0..n {
            for (k, cutoff_hz) in OUTPUT_HZ.iter().enumerate() {
                let smooth = match cutoff_hz {
                    Some(hz) => low_pass(*hz, signals.rate_hz)?.filter(&predicted[j]),
                    None => predicted[j].clone(),
                };
                squares[j][k] += smooth
                    .iter()
                    .zip(&signals.effort[j])
                    .map(|(p, e)| (p - e).powi(2))
                    .sum::<f64>();
            }
        }
    }
    let mut noise = vec![0.0; n];
    for j in 0..n {
        let best = (0..OUTPUT_HZ.len()).min_by(|a, b| squares[j][*a].total_cmp(&squares[j][*b]));
        let Some(best) = best else { continue };
        band.output_cutoff_hz[j] = OUTPUT_HZ[best];
        let samples: usize = design.signals.iter().map(|s| s.effort[j].len()).sum();
        noise[j] = (squares[j][best] / samples.max(1) as f64).sqrt();
    }
    model.band = Some(band);
    model.effort_noise = Some(noise);
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::design::compliant_link::Posed;
    use armident_dynamics::RigidArm;
    use armident_effects::{Effect, LoadDependentFriction};
    use armident_kinematics::DrivingAxisChain;

    use super::*;
    use crate::selection::iterate::select;
    use crate::test_arms::{swung, ur5};
    use armident_motion::BandMotion;

    /// The UR5, and one with other links.
    fn given_and_true() -> (DrivingAxisChain, DrivingAxisChain) {
        let given = ur5();
        let mut true_arm = given.clone();
        for (k, joint) in true_arm.joints.iter_mut().enumerate() {
            let link = joint.link.to_array();
            let factor = if k % 2 == 0 { 0.15 } else { -0.1 };
            joint.link = changed(&joint.link, &link.map(|x| factor * x));
        }
        (given, true_arm)
    }

    /// The model fitted to a recording.
    fn fitted_to(recorded: &BandMotion, chain: &DrivingAxisChain) -> ArmModel {
        let design = Design::new(chain, vec![recorded.clone()]);
        let (design, selection) = select(&design).unwrap();
        let metric = selection.metric();
        fitted_model(
            &ArmModel::from_chain(chain.clone()),
            &selection.solution(&design, &metric),
            Links::Consistent,
        )
        .0
    }

    /// The gain of a channel scales the efforts of link errors too.
    #[test]
    fn channel_gain_scales_link_errors_too() {
        const SCALED: usize = 2;
        const GAIN: f64 = 1.45;
        let (chain, true_arm) = given_and_true();
        let mut recorded = swung(&true_arm, 0.1, |_, _| 0.0);
        recorded.effort[SCALED].iter_mut().for_each(|x| *x *= GAIN);

        let found = fitted_to(&recorded, &chain);
        let gain = found.channel_gain[SCALED];
        assert!((gain - GAIN).abs() < 0.005, "{gain}");
        let effort = &recorded.effort;
        for (j, predicted) in found.predict_in_band(&recorded).unwrap().iter().enumerate() {
            let left = predicted.iter().zip(&effort[j]).map(|(p, e)| (p - e).powi(2)).sum::<f64>();
            let left = (left / effort[j].len() as f64).sqrt();
            // even noise of 0.1 N m from end to end
            let noise = 0.1 / 12_f64.sqrt() * if j == SCALED { GAIN } else { 1.0 };
            assert!(left < 1.1 * noise, "joint {}: {left} of {noise}", j + 1);
        }
    }

    /// Load-dependent friction follows the load of the true links, not of the given ones.
    #[test]
    fn friction_follows_load_of_true_links() {
        const LOADED: usize = 1;
        const OF_LOAD: f64 = 0.1;
        let (chain, true_arm) = given_and_true();
        let mut recorded = swung(&true_arm, 0.1, |_, _| 0.0);
        let point = OperatingPoint::of(true_arm.joints.len());
        let moved = recorded.clone();
        let at = Posed::new(&true_arm, &RigidArm::from_chain(&true_arm), &moved, &point);
        let law = &LoadDependentFriction;
        let friction = law.effort(&[1.0, OF_LOAD], &at.joint(LOADED));
        recorded.effort[LOADED].iter_mut().zip(friction).for_each(|(e, f)| *e += f);

        let found = fitted_to(&recorded, &chain);
        let friction = found.effects.iter().find(|on| on.effect == law.law().slug).unwrap();
        assert_eq!(friction.joint, chain.joints[LOADED].name);
        let [level, of_load] = friction.parameters[..] else { panic!("{friction:?}") };
        assert!(
            (level - 1.0).abs() < 0.05 && (of_load / OF_LOAD - 1.0).abs() < 0.01,
            "{friction:?}"
        );
    }
}
