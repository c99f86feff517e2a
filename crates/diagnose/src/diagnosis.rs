//! The diagnosis: findings, model, proof.

use std::collections::BTreeMap;

use armident_effects::{EffectOnJoint, Place, Scope, effect};
use armident_ident::ArmModel;
use armident_recording::{Recording, RecordingError};
use nalgebra::Vector3;
use serde::Serialize;

use crate::evidence::{Evidence, OperatingPoint, changed};
use crate::flexible::FlexibleTerm;
use crate::material::{Materiality, link_materiality, materiality};
use crate::model::DiagnosedModel;
use crate::problem::{Group, Meaning, Whitened};
use crate::search::answer;
use crate::select::{Selection, moves, select};
use crate::signals::{Signals, low_pass};
use crate::transmission::{Transmission, TransmissionTerm, mean_inertia, of_shape};

/// Cut-offs tried for the output of a joint \[Hz\].
const OUTPUT_HZ: [Option<f64>; 6] = [None, Some(18.0), Some(11.0), Some(8.0), Some(6.0), Some(4.5)];

/// Cut-offs tried for the rigid part \[Hz\].
const RIGID_HZ: [f64; 5] = [14.0, 10.0, 7.0, 5.0, 3.5];

/// A number with its standard error.
#[derive(Debug, Clone, Serialize)]
pub struct Value {
    /// Estimate.
    pub value: f64,
    /// Standard error, if it is known.
    pub stderr: Option<f64>,
    /// Unit.
    pub unit: &'static str,
}

/// What else the recordings cannot tell from a finding.
#[derive(Debug, Clone, Serialize)]
pub struct Alternative {
    /// Slug.
    pub effect: String,
    /// Joints.
    pub joints: Vec<String>,
    /// Link.
    pub link: Option<String>,
}

/// What a finding stands on.
#[derive(Debug, Clone, Serialize)]
pub struct FindingEvidence {
    /// Root mean square effort that comes back without the finding, in standard deviations of one
    /// recorded sample, on the joint where it matters most.
    pub materiality: f64,
    /// What must come back there for a name.
    pub least_materiality: f64,
    /// That joint.
    pub joint: String,
    /// Columns that an unnamed structure depends on.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub variables: Vec<String>,
}

/// One effect that the model leaves out.
#[derive(Debug, Clone, Serialize)]
pub struct Finding {
    /// Slug of the library, or `unmodelled`.
    pub effect: String,
    /// Joints.
    pub joints: Vec<String>,
    /// Link, for inertial effects.
    pub link: Option<String>,
    /// Window \[s\], for contacts.
    pub window: Option<[f64; 2]>,
    /// Recording of the window.
    pub recording: Option<String>,
    /// Parameters of the law.
    pub parameters: BTreeMap<&'static str, Value>,
    /// 0.5 where it just matters, 0.95 where it matters twice as much as it must.
    pub confidence: f64,
    /// Why.
    pub evidence: FindingEvidence,
    /// What it may be instead.
    pub alternatives: Vec<Alternative>,
}

/// Root mean square errors of the raw recorded effort, by joint.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Errors {
    /// The believed model.
    pub before: BTreeMap<String, f64>,
    /// The rigid body identified again, nothing else.
    pub rigid: BTreeMap<String, f64>,
    /// The diagnosed model.
    pub after: BTreeMap<String, f64>,
}

/// The result.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// Most material first.
    pub findings: Vec<Finding>,
    /// The model with what was learned.
    pub model: DiagnosedModel,
    /// The believed model with its rigid body identified again.
    pub rigid: DiagnosedModel,
    /// Joints of the chain.
    pub joints: Vec<String>,
    /// Noise of one recorded effort sample \[N m or N\].
    pub effort_noise: BTreeMap<String, f64>,
    /// Relative error of the believed inertias that the recordings ask for.
    pub inertial_error: f64,
}

/// Why there is no diagnosis.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DiagnoseError {
    /// A recording cannot be used.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// No recording is long enough.
    #[error("no recording is long enough")]
    TooShort,
    /// No joint moves.
    #[error("no joint moves")]
    NoMotion,
    /// The effort of a joint that moves is one number.
    #[error("the effort of {0} is the same number throughout although the joint moves")]
    ConstantEffort(String),
    /// The problem could not be solved.
    #[error("the efforts cannot be compared with the model")]
    Unsolvable,
}

/// Diagnoses the difference between a believed arm and recordings.
///
/// # Errors
/// [`DiagnoseError`].
pub fn diagnose(model: &ArmModel, train: &[Recording]) -> Result<Diagnosis, DiagnoseError> {
    let names: Vec<String> = model.chain.joints.iter().map(|j| j.name.clone()).collect();
    let signals: Vec<Signals> =
        train.iter().map(|r| Signals::new(r, &names)).collect::<Result<_, _>>()?;
    if signals.iter().any(|s| s.band.kept.len() < 2) {
        return Err(DiagnoseError::TooShort);
    }
    said_something(&names, &signals)?;
    let mut evidence = Evidence::new(&model.chain, signals);
    let selection = select(&mut evidence).ok_or(DiagnoseError::Unsolvable)?;
    let findings = findings(&evidence, &selection);
    let mut learned = learned(model, &evidence, &selection);
    choose_outputs(&mut learned, &evidence)?;
    let mut rigid =
        rigid_alone(model, &evidence).unwrap_or_else(|| DiagnosedModel::believed(model));
    choose_outputs(&mut rigid, &evidence)?;
    Ok(Diagnosis {
        findings,
        model: learned,
        rigid,
        effort_noise: names.iter().cloned().zip(evidence.rows.sample_deviation.clone()).collect(),
        joints: names,
        inertial_error: selection.scale,
    })
}

/// Refuses recordings from which every answer would be invented: channels that say one number.
fn said_something(names: &[String], signals: &[Signals]) -> Result<(), DiagnoseError> {
    let moves = |j: usize| signals.iter().any(|s| !is_constant(&s.recorded_position[j]));
    if !(0..names.len()).any(moves) {
        return Err(DiagnoseError::NoMotion);
    }
    for (j, name) in names.iter().enumerate() {
        let recorded = signals.iter().any(|s| !s.effort[j].is_empty());
        if recorded && moves(j) && signals.iter().all(|s| is_constant(&s.effort[j])) {
            return Err(DiagnoseError::ConstantEffort(name.clone()));
        }
    }
    Ok(())
}

fn is_constant(values: &[f64]) -> bool {
    values.windows(2).all(|pair| pair[0] == pair[1])
}

impl Diagnosis {
    /// Errors on a recording that the model was not fitted to.
    ///
    /// # Errors
    /// A recording that cannot be used.
    pub fn errors(
        &self,
        before: &DiagnosedModel,
        recording: &Recording,
    ) -> Result<Errors, RecordingError> {
        let of = |model: &DiagnosedModel| -> Result<BTreeMap<String, f64>, RecordingError> {
            let predicted = model.predict(recording)?;
            let mut errors = BTreeMap::new();
            for (name, predicted) in self.joints.iter().zip(&predicted) {
                let Some(recorded) = recording.joint(name).and_then(|j| j.effort.as_ref()) else {
                    continue;
                };
                let squares: f64 =
                    predicted.iter().zip(recorded).map(|(p, r)| (p - r).powi(2)).sum();
                errors.insert(name.clone(), (squares / recorded.len() as f64).sqrt());
            }
            Ok(errors)
        };
        Ok(Errors { before: of(before)?, rigid: of(&self.rigid)?, after: of(&self.model)? })
    }
}

fn confidence(size: &Materiality) -> f64 {
    1.0 / (1.0 + (-3.0 * (size.ratio() - 1.0)).exp())
}

fn findings(evidence: &Evidence<'_>, selection: &Selection) -> Vec<Finding> {
    let metric = selection.metric();
    let point = moves(&selection.problem, &selection.answer, &selection.point);
    let gain = gains(evidence, selection);
    let mut found: Vec<Finding> = selection
        .answer
        .set
        .iter()
        .map(|&g| {
            let group = &selection.problem.groups[g];
            let (size, _) = materiality(&metric, &selection.answer, g, &selection.point);
            let names =
                |joints: &[usize]| joints.iter().map(|j| evidence.names[*j].clone()).collect();
            let is_link = group.transform.is_some();
            let confidence = confidence(&size);
            let confidence = if described_anyway(selection, group) {
                confidence.min(IN_A_DESCRIPTION)
            } else {
                confidence
            };
            Finding {
                effect: group.slug().to_owned(),
                joints: names(&group.site.joints),
                link: is_link
                    .then(|| evidence.chain.joints[group.site.joints[0]].child_link.clone()),
                window: group.site.window.map(|w| w.1),
                recording: group.site.window.map(|w| stem(&evidence.signals[w.0].source)),
                parameters: parameters(evidence, selection, &metric, group, &point, &gain),
                confidence,
                evidence: FindingEvidence {
                    materiality: size.value,
                    least_materiality: size.least,
                    joint: evidence.names[size.joint].clone(),
                    variables: match &group.meaning {
                        Meaning::Flexible(flexible) => flexible.basis.variables(),
                        Meaning::Law(_) => Vec::new(),
                    },
                },
                alternatives: Vec::new(),
            }
        })
        .collect();
    let errors = metric.inertial_errors(&selection.answer.fit);
    for &link in &selection.wide {
        let size = link_materiality(&metric, &selection.answer, link);
        if size.ratio() < 1.0 {
            continue;
        }
        found.push(wrong_body(evidence, link, &errors[10 * link..10 * (link + 1)], &size));
    }
    found.sort_by(|a, b| b.evidence.materiality.total_cmp(&a.evidence.materiality));
    found
}

/// Change of mass and first moment of a link, in the frame of its URDF link.
fn in_link_frame(evidence: &Evidence<'_>, link: usize, change: &[f64]) -> [f64; 4] {
    let pose = evidence.chain.joints[link].child_link_in_e;
    let moment = Vector3::new(change[1], change[2], change[3]);
    let moved = pose.rotation.inverse() * (moment - pose.translation.vector * change[0]);
    [change[0], moved.x, moved.y, moved.z]
}

/// Confidence of a friction law beside a description of the same joint's speed: which of the two the
/// friction belongs to cannot be told.
const IN_A_DESCRIPTION: f64 = 0.45;

fn described_anyway(selection: &Selection, group: &Group) -> bool {
    let friction = [Place::Viscous, Place::Drag];
    if !group.places.iter().any(|p| friction.contains(p)) {
        return false;
    }
    selection.answer.set.iter().map(|g| &selection.problem.groups[*g]).any(|other| {
        other.site == group.site
            && matches!(&other.meaning, Meaning::Flexible(f) if !f.basis.factors.is_empty())
    })
}

/// A link whose inertial errors stand out from those of all others.
fn wrong_body(evidence: &Evidence<'_>, link: usize, change: &[f64], size: &Materiality) -> Finding {
    let joint = &evidence.chain.joints[link];
    let names = ["delta_mass", "delta_mcx", "delta_mcy", "delta_mcz"];
    let units = ["kg", "kg m", "kg m", "kg m"];
    let in_link = in_link_frame(evidence, link, change);
    let parameters = (0..4)
        .map(|p| (names[p], Value { value: in_link[p], stderr: None, unit: units[p] }))
        .collect();
    Finding {
        effect: "link_inertia_error".to_owned(),
        joints: vec![joint.name.clone()],
        link: Some(joint.child_link.clone()),
        window: None,
        recording: None,
        parameters,
        confidence: confidence(size),
        evidence: FindingEvidence {
            materiality: size.value,
            least_materiality: size.least,
            joint: evidence.names[size.joint].clone(),
            variables: Vec::new(),
        },
        alternatives: Vec::new(),
    }
}

/// Name of a file without folder and ending.
fn stem(source: &str) -> String {
    std::path::Path::new(source)
        .file_stem()
        .map_or_else(|| source.to_owned(), |s| s.to_string_lossy().into_owned())
}

/// Gain of every joint's effort channel.
fn gains(evidence: &Evidence<'_>, selection: &Selection) -> Vec<f64> {
    let mut gain = vec![1.0; evidence.joints()];
    for g in &selection.answer.set {
        let group = &selection.problem.groups[*g];
        if group.slug() == "torque_scale" {
            gain[group.site.joints[0]] = 1.0 + selection.answer.fit.of_group(group)[0];
        }
    }
    gain
}

/// Parameters of a law in true terms: the gain of a joint's channel is taken out of its other laws.
fn law_parameters(group: &Group, coefficients: &[f64], gain: &[f64]) -> Vec<f64> {
    let Some(law) = effect(group.slug()) else { return Vec::new() };
    let scale = match (group.slug(), group.site.joints.as_slice()) {
        ("torque_scale", _) => 1.0,
        (_, [joint, ..]) => gain[*joint],
        _ => 1.0,
    };
    let coefficients: Vec<f64> = coefficients.iter().map(|c| c / scale).collect();
    law.parameters(&group.shape, &coefficients)
}

fn parameters(
    evidence: &Evidence<'_>,
    selection: &Selection,
    metric: &Whitened<'_>,
    group: &Group,
    point: &OperatingPoint,
    gain: &[f64],
) -> BTreeMap<&'static str, Value> {
    let Some(law) = effect(group.slug()) else { return BTreeMap::new() };
    let kind = evidence.chain.joints[group.site.joints.first().copied().unwrap_or(0)].kind;
    let coefficients = selection.answer.fit.of_group(group);
    let covariance = metric.covariance(&selection.answer.fit, &group.columns);
    let of = |coefficients: &[f64]| -> Vec<f64> {
        match group.slug() {
            "gravity_direction" => {
                let delta = [coefficients[0], coefficients[1]];
                let base = selection.point.tilt;
                law.parameters(&[], &[base[0] + delta[0], base[1] + delta[1]])
            }
            "time_delay" => vec![selection.point.delay_s + coefficients[0]],
            "encoder_offset" => {
                vec![selection.point.offset[group.site.joints[0]] + coefficients[0]]
            }
            "joint_elasticity" if group.shape.is_empty() => {
                vec![1.0 / coefficients[0], 0.0, coefficients[1]]
            }
            "joint_elasticity" => vec![group.shape[0], group.shape[1], coefficients[1]],
            "backlash" => {
                let at = evidence.at(&selection.point);
                let joint = group.site.joints[0];
                let of = of_shape("backlash", &group.shape, mean_inertia(&at, joint));
                vec![of.gap, of.stiffness, of.damping, coefficients[1]]
            }
            "link_inertia_error" | "payload" => {
                let transform = group.transform.as_deref().unwrap_or_default();
                let change: Vec<f64> = (0..10)
                    .map(|p| transform.iter().zip(coefficients).map(|(t, c)| t[p] * c).sum())
                    .collect();
                let [mass, x, y, z] = in_link_frame(evidence, group.site.joints[0], &change);
                if group.slug() == "payload" {
                    vec![mass, x / mass, y / mass, z / mass]
                } else {
                    vec![mass, x, y, z]
                }
            }
            _ => law_parameters(group, coefficients, gain),
        }
    };
    let _ = point;
    let values = of(&coefficients);
    // propagation of the covariance of the coefficients through the formulas
    let slopes: Vec<Vec<f64>> = (0..coefficients.len())
        .map(|k| {
            let step = 1e-4 * covariance[k][k].sqrt().max(1e-12);
            let mut moved = coefficients.clone();
            moved[k] += step;
            of(&moved).iter().zip(&values).map(|(a, b)| (a - b) / step).collect()
        })
        .collect();
    law.law()
        .parameters
        .iter()
        .zip(&values)
        .enumerate()
        .map(|(p, (parameter, &value))| {
            let variance: f64 = (0..coefficients.len())
                .flat_map(|a| (0..coefficients.len()).map(move |b| (a, b)))
                .map(|(a, b)| slopes[a][p] * slopes[b][p] * covariance[a][b])
                .sum();
            let stderr = (variance > 0.0).then(|| variance.sqrt());
            (parameter.name, Value { value, stderr, unit: parameter.unit(kind) })
        })
        .collect()
}

/// The model that the selection stands for.
fn learned(model: &ArmModel, evidence: &Evidence<'_>, selection: &Selection) -> DiagnosedModel {
    let metric = selection.metric();
    let mut found = DiagnosedModel::believed(model);
    let mut change = metric.inertial_errors(&selection.answer.fit);
    let gain = gains(evidence, selection);
    let point = moves(&selection.problem, &selection.answer, &selection.point);
    for &g in &selection.answer.set {
        let group = &selection.problem.groups[g];
        let coefficients = selection.answer.fit.of_group(group);
        if let Some(transform) = &group.transform {
            for (t, c) in transform.iter().zip(&coefficients) {
                for (p, t) in t.iter().enumerate() {
                    change[10 * group.site.joints[0] + p] += t * c;
                }
            }
            continue;
        }
        if let Meaning::Flexible(flexible) = &group.meaning {
            let hats = flexible.transform.first().map_or(0, Vec::len);
            let scale = gain[group.site.joints[0]];
            found.learned.flexible.push(FlexibleTerm {
                joint: evidence.names[group.site.joints[0]].clone(),
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
        if let ("joint_elasticity" | "backlash", Some(&joint)) =
            (group.slug(), group.site.joints.first())
        {
            // a compliance to first order says nothing of its damping: that of gears, by experience
            const DAMPING: f64 = 0.1;
            let at = evidence.at(&selection.point);
            let inertia = mean_inertia(&at, joint);
            let (transmission, share) = if group.shape.is_empty() {
                let stiffness = 1.0 / coefficients[0];
                let damping = 2.0 * DAMPING * (stiffness * inertia).sqrt();
                (Transmission { gap: 0.0, stiffness, damping }, 1.0)
            } else {
                (of_shape(group.slug(), &group.shape, inertia), coefficients[0])
            };
            found.learned.transmissions.push(TransmissionTerm {
                joint: evidence.names[joint].clone(),
                transmission,
                motor_inertia: coefficients[1],
                share,
            });
            continue;
        }
        let Some(law) = effect(group.slug()) else { continue };
        let on_joint = |parameters: Vec<f64>| {
            EffectOnJoint::new(group.slug(), &evidence.names[group.site.joints[0]], parameters)
        };
        match law.law().scope {
            Scope::Joint if group.slug() != "torque_scale" => {
                found.arm.effects.push(on_joint(law_parameters(group, &coefficients, &gain)));
            }
            Scope::Neighbours => {
                found.learned.couplings.push(on_joint(law_parameters(group, &coefficients, &gain)));
            }
            _ => {}
        }
    }
    for (k, joint) in found.arm.chain.joints.iter_mut().enumerate() {
        joint.link = changed(&joint.link, &change[10 * k..10 * (k + 1)]);
    }
    found.learned.tilt_rad = point.tilt;
    found.learned.encoder_offset = point.offset;
    found.learned.delay_s = point.delay_s;
    found.learned.gain = gain;
    found.arm.prior_links = Some(evidence.chain.joints.iter().map(|j| j.link).collect());
    found.arm.effort_noise = Some(evidence.rows.sample_deviation.clone());
    found
}

/// The believed arm with its rigid body identified again and nothing else.
fn rigid_alone(model: &ArmModel, evidence: &Evidence<'_>) -> Option<DiagnosedModel> {
    const SCALE: f64 = 1.0;
    let problem = evidence.problem(&OperatingPoint::of(evidence.joints()));
    let metric = problem.whitened(SCALE, &[]);
    let change = metric.inertial_errors(&answer(&metric, Vec::new())?.fit);
    let mut found = DiagnosedModel::believed(model);
    for (k, joint) in found.arm.chain.joints.iter_mut().enumerate() {
        joint.link = changed(&joint.link, &change[10 * k..10 * (k + 1)]);
    }
    Some(found)
}

/// Chooses the low-pass of the rigid part, and then that of each joint's prediction, by the training
/// recordings.
fn choose_outputs(
    model: &mut DiagnosedModel,
    evidence: &Evidence<'_>,
) -> Result<(), RecordingError> {
    let n = evidence.joints();
    let mut best = f64::INFINITY;
    let mut chosen = model.learned.rigid_cutoff_hz;
    for cutoff_hz in RIGID_HZ {
        model.learned.rigid_cutoff_hz = cutoff_hz;
        let mut squares = vec![0.0; n];
        for signals in &evidence.signals {
            for (j, predicted) in model.on_grid(signals)?.iter().enumerate() {
                let differences = predicted.iter().zip(&signals.effort[j]);
                squares[j] += differences.map(|(p, e)| (p - e).powi(2)).sum::<f64>();
            }
        }
        // each joint in its own unit: a product of errors, not a sum
        let misfit: f64 = squares.iter().map(|s| s.max(f64::MIN_POSITIVE).ln()).sum();
        if misfit < best {
            (best, chosen) = (misfit, cutoff_hz);
        }
    }
    model.learned.rigid_cutoff_hz = chosen;
    let mut squares = vec![[0.0; OUTPUT_HZ.len()]; n];
    for signals in &evidence.signals {
        let predicted = model.on_grid(signals)?;
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
    for j in 0..n {
        let best = (0..OUTPUT_HZ.len()).min_by(|a, b| squares[j][*a].total_cmp(&squares[j][*b]));
        model.learned.output_cutoff_hz[j] = best.and_then(|k| OUTPUT_HZ[k]);
    }
    Ok(())
}
