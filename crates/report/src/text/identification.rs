//! `armident identify`: from an identification to its result.

use crate::results::{
    ByJoint, ConsistencyReport, ConstantRow, DriveGainRow, EffectRow, EndogeneityRow, FitReport,
    FitRows, IdentifyReport, MergedRow, PayloadRow, SensedGearRow, SensedNumber, StepRow,
};
use armident_ident::{
    Consistent, Coupling, DriveGains, Identification, JointFit, KnownLoad, LAWS, MinimalSet,
    PlannedIdentification, SensedGear, SensedValue, Term,
};
use armident_motion::Motion;

use crate::text::identify_notes::{notes, warnings};

impl IdentifyReport {
    /// Of a batch fit, with its notes and warnings; names of recordings are to be added.
    pub fn of_batch(found: &Identification, estimator: &str, loads: &[KnownLoad]) -> Self {
        let Identification { model, problem, estimate, errors, .. } = found;
        let joints = model.chain.joint_names();
        let label = |term: &Term| problem.label(term, &joints);
        let mut constants = Vec::new();
        let mut effects = Vec::new();
        for (k, term) in problem.terms.iter().enumerate() {
            match *term {
                Term::Load { .. } => {}
                Term::Constant(c) => constants.push(ConstantRow {
                    // a constant has no bound, so its error is always there
                    undetermined: estimate.undetermined[k],
                    prior_share: estimate.prior_share[k],
                    ..constant_row(
                        problem.set(),
                        c,
                        &joints,
                        found.given_values[k],
                        estimate
                            .standard_error(k)
                            .map(|error| (estimate.values[k], error, estimate.quantile_95)),
                    )
                }),
                Term::Effect { joint, .. }
                | Term::Shared { coupling: Coupling { first: joint, .. }, .. } => {
                    effects.extend(effect_row(found, k, joint, &joints));
                }
            }
        }
        add_consistent(&mut constants, problem.set(), found.consistent.as_ref());
        let merged = problem.merged.iter().map(|m| MergedRow {
            term: label(&m.term),
            into: m.into.iter().map(|&(k, factor)| (label(&problem.terms[k]), factor)).collect(),
        });
        let significant = |k: &usize| estimate.is_significant(*k);
        IdentifyReport {
            schema: IdentifyReport::SCHEMA.to_owned(),
            method: "batch".to_owned(),
            estimator: Some(estimator.to_owned()),
            robot: model.chain.robot.clone(),
            recordings: Vec::new(),
            holdout_recordings: Vec::new(),
            joints: joints.iter().map(|joint| (*joint).to_owned()).collect(),
            cutoff_hz: found.cutoff_hz,
            velocities: if model.recorded_velocities || found.cutoff_hz.is_none() {
                "recorded"
            } else {
                "position"
            }
            .to_owned(),
            prior_scale: found.structure.settings.link_prior,
            consistency: found.consistent.as_ref().map(|c| ConsistencyReport::of(c, &joints)),
            constants,
            effects,
            merged: merged.collect(),
            drive_gains: found.drive_gains.as_ref().map_or_else(Vec::new, |g| gain_rows(g, found)),
            sensed_gears: sensed_gear_rows(&found.gears, &joints),
            payloads: loads.iter().map(|load| payload_row(load, found)).collect(),
            steps: Vec::new(),
            rank: estimate.rank,
            parameters: problem.terms.len(),
            condition: estimate.condition,
            rows: estimate.rows,
            effective_sample_share: estimate.independent_share,
            effort_noise: by_joint(&found.effort_noise, &joints),
            not_significant: (0..problem.terms.len())
                .filter(|k| !significant(k))
                .map(|k| label(&problem.terms[k]))
                .collect(),
            endogeneity: estimate.endogeneity().map(|tested| EndogeneityRow {
                term: label(&problem.terms[tested.term]),
                t: tested.t,
                p: tested.p,
            }),
            cross_validation: errors.cross_validated.as_ref().map(|fits| fit_rows(fits, &joints)),
            fit: FitReport {
                train: fit_rows(&errors.train, &joints),
                holdout: errors.holdout.as_ref().map(|fits| fit_rows(fits, &joints)),
                urdf: fit_rows(&errors.given, &joints),
            },
            warnings: warnings(found),
            notes: notes(found),
        }
    }

    /// Of Algorithm 2; names of recordings, notes and warnings are to be added.
    pub fn of_planned(found: &PlannedIdentification) -> Self {
        let PlannedIdentification { model, set, estimate, .. } = found;
        let joints = model.chain.joint_names();
        let mut constants: Vec<ConstantRow> = (0..set.len())
            .map(|k| {
                let value = estimate.values[k];
                let known = value.is_finite();
                let with_error =
                    known.then(|| (value, estimate.standard_error(k), estimate.quantile_95[k]));
                ConstantRow {
                    undetermined: if known { 0.0 } else { 1.0 },
                    ..constant_row(set, k, &joints, found.given_values[k], with_error)
                }
            })
            .collect();
        add_consistent(&mut constants, set, found.consistent.as_ref());
        let friction = found.friction.iter().map(|friction| {
            let (parameter, joint) =
                (&friction.law.parameters[0], &model.chain.joints[friction.joint]);
            EffectRow {
                effect: friction.law.slug.to_owned(),
                joint: joint.name.clone(),
                other_joint: None,
                parameter: parameter.name.to_owned(),
                unit: parameter.unit(joint.kind).to_owned(),
                value: friction.value,
                standard_error: Some(friction.standard_error),
                at_bound: false,
                // noise of either sign around zero is no inadmissible sign
                admissible: friction.value >= -3.0 * friction.standard_error,
                undetermined: 0.0,
            }
        });
        let steps = estimate.steps.iter().map(|s| StepRow {
            step: s.step.clone(),
            equation: s.equation.clone(),
            observed: s.observed.clone(),
            unknowns: s.unknowns.clone(),
            rows: s.rows,
            rank: s.rank,
            columns: s.columns,
            condition: s.condition,
            rmse: s.rmse,
        });
        IdentifyReport {
            schema: IdentifyReport::SCHEMA.to_owned(),
            method: "algorithm2".to_owned(),
            estimator: None,
            robot: model.chain.robot.clone(),
            recordings: Vec::new(),
            holdout_recordings: Vec::new(),
            joints: joints.iter().map(|joint| (*joint).to_owned()).collect(),
            cutoff_hz: found.cutoff_hz,
            velocities: if found.cutoff_hz.is_some() { "position" } else { "recorded" }.to_owned(),
            prior_scale: None,
            consistency: found.consistent.as_ref().map(|c| ConsistencyReport::of(c, &joints)),
            constants,
            effects: friction.collect(),
            merged: Vec::new(),
            drive_gains: Vec::new(),
            sensed_gears: Vec::new(),
            payloads: Vec::new(),
            steps: steps.collect(),
            rank: estimate.values.iter().filter(|v| v.is_finite()).count(),
            parameters: set.len(),
            condition: estimate.steps.iter().map(|s| s.condition).fold(0.0, f64::max),
            rows: estimate.steps.iter().map(|s| s.rows).sum(),
            effective_sample_share: found
                .motions
                .iter()
                .map(Motion::independent_share)
                .fold(1.0, f64::min),
            effort_noise: by_joint(&estimate.effort_noise, &joints),
            not_significant: Vec::new(),
            endogeneity: None,
            cross_validation: None,
            fit: FitReport {
                train: fit_rows(&found.train_error, &joints),
                holdout: None,
                urdf: fit_rows(&found.given_error, &joints),
            },
            warnings: Vec::new(),
            notes: Vec::new(),
        }
    }
}

/// `found`: estimate, standard error and quantile.
fn constant_row(
    set: &MinimalSet,
    k: usize,
    joints: &[&str],
    given: f64,
    found: Option<(f64, f64, f64)>,
) -> ConstantRow {
    let constant = &set.constants[k];
    ConstantRow {
        label: constant.label(),
        joint: joints[constant.joint].to_owned(),
        unit: constant.unit().to_owned(),
        value: found.map(|(value, _, _)| value),
        standard_error: found.map(|(_, error, _)| error),
        interval_95: found.map(|(value, error, t)| [value - t * error, value + t * error]),
        urdf: given,
        consistent: None,
        prior_share: 0.0,
        undetermined: 0.0,
    }
}

/// A parameter of a law; none for other terms.
fn effect_row(
    found: &Identification,
    k: usize,
    joint: usize,
    joints: &[&str],
) -> Option<EffectRow> {
    let (term, estimate) = (&found.problem.terms[k], &found.estimate);
    let parameter = term.parameter()?;
    let (effect, other_joint) = match *term {
        Term::Effect { effect, .. } => (LAWS[effect].law().slug, None),
        _ => (Coupling::slug(), Some(joints[joint + 1].to_owned())),
    };
    Some(EffectRow {
        effect: effect.to_owned(),
        joint: joints[joint].to_owned(),
        other_joint,
        parameter: parameter.name.to_owned(),
        unit: parameter.unit(found.model.chain.joints[joint].kind).to_owned(),
        value: estimate.values[k],
        standard_error: estimate.standard_error(k),
        admissible: parameter.admissible.allows(estimate.values[k]),
        at_bound: estimate.at_bound[k],
        undetermined: estimate.undetermined[k],
    })
}

/// Values of the consistent links beside the estimates, which are in the order of the set.
fn add_consistent(rows: &mut [ConstantRow], set: &MinimalSet, found: Option<&Consistent>) {
    let Some(found) = found else { return };
    for (k, constant) in set.constants.iter().enumerate() {
        let label = constant.label();
        if let Some(row) = rows.iter_mut().find(|row| row.label == label) {
            row.consistent = Some(found.estimated[k]);
        }
    }
}

fn sensed_gear_rows(gears: &[Option<SensedGear>], joints: &[&str]) -> Vec<SensedGearRow> {
    let number =
        |of: SensedValue| SensedNumber { value: of.value, standard_error: of.standard_error };
    let row = |(gear, joint): (&Option<SensedGear>, &&str)| {
        gear.map(|gear| SensedGearRow {
            joint: (*joint).to_owned(),
            determined: gear.is_determined,
            gain: number(gear.gain),
            viscous: number(gear.viscous),
            coulomb: number(gear.coulomb),
            inertia: number(gear.inertia),
            offset: number(gear.offset),
            rms: gear.rms,
        })
    };
    gears.iter().zip(joints).filter_map(row).collect()
}

fn gain_rows(gains: &DriveGains, found: &Identification) -> Vec<DriveGainRow> {
    let pairs = found.model.chain.joints.iter().zip(&gains.joints);
    pairs
        .filter_map(|(joint, gain)| {
            let gain = (*gain)?;
            let rotational = joint.kind.is_rotational();
            Some(DriveGainRow {
                joint: joint.name.clone(),
                value: gain.value,
                standard_error: gain.standard_error,
                interval_95: gain.interval_95,
                unit: match (gains.absolute, rotational) {
                    (true, true) => "N m/A",
                    (true, false) => "N/A",
                    (false, _) => "relative",
                }
                .to_owned(),
                used: gain.value * gains.scale_of_description,
            })
        })
        .collect()
}

fn payload_row(load: &KnownLoad, found: &Identification) -> PayloadRow {
    let in_link = found.model.chain.joints.last().map(|joint| joint.child_link_in_e.inverse());
    let centre = found.problem.centre_of(load, &found.estimate.values);
    PayloadRow {
        recordings: load.sources.clone(),
        mass_kg: load.mass_kg,
        centre_of_mass_m: in_link.map_or(centre, |to| to.transform_point(&centre.into()).into()),
        is_estimated: load.centre_error_m > 0.0,
    }
}

fn fit_rows(fits: &[JointFit], joints: &[&str]) -> FitRows {
    let pick = |value: fn(&JointFit) -> f64| {
        joints.iter().zip(fits).map(|(j, fit)| ((*j).to_owned(), value(fit))).collect()
    };
    FitRows { rmse: pick(|f| f.rmse), relative: pick(|f| f.relative) }
}

fn by_joint(values: &[f64], joints: &[&str]) -> ByJoint {
    joints.iter().zip(values).map(|(j, v)| ((*j).to_owned(), *v)).collect()
}
