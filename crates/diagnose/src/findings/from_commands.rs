//! Findings where commands are recorded and efforts are not: what lies between a command and the position that follows it.
//!
//! The given model is the ideal controller: positions equal commands. A law is named where positions are followed worse without it,
//! all others fitted again, in all blocks of the recordings, and where its size is beyond two standard errors.
//!
//! Hypothesis: a law lowers no position error. Statistic: the paired t of the logarithms of the errors without and with it, over
//! blocks of the training recordings, one-sided. Then the size of the position error that the law alone explains, over the larger of the
//! encoder's noise and a share of the residual of the whole model, as for a change that must hold in every block; and the Wald
//! statistic of its parameter by the block jackknife. Both make the confidence as they do where efforts are recorded.
//! References: own.

use std::collections::BTreeMap;

use armident_effects::{
    CoulombFriction, Effect, LoadDependentFriction, PositionControl, RotorInertia,
    StribeckFriction, TorqueOffset, ViscousFriction,
};
use armident_ident::{
    OF_ROUNDING, ServoAblation, ServoError, ServoIdentification, ServoJointFit, ServoParameter,
    ServoRequest, ServoValue, identify_servos,
};
use armident_inference::{paired_t, student_t_tail};
use armident_kinematics::JointKind;

use crate::findings::confidence::{Evidence, NOT_CONFIRMED, with_odds};
use crate::findings::finding::{Alternative, Finding, FindingEvidence};
use crate::findings::numbers::Value;
use crate::selection::materiality::{LEAST, Materiality, SHARE_FOR_CHANGE};

/// Level of the test of a law that a joint may lack: with some thirty of them on an arm one in a thousand arms has a name that is
/// none.
const LEVEL: f64 = 3e-5;
/// Level of the test of a controller: no joint follows its command without delay and sag, and what is tested is whether the
/// recordings show it.
const CONTROLLER_LEVEL: f64 = 1e-3;
/// Standard errors beyond which a size is one.
const DEVIATIONS: f64 = 2.0;
/// Correlation of two estimates beyond which recordings hardly separate them: their sum is known ten times as well as their
/// difference.
const NOT_SEPARATED: f64 = 0.98;
/// Least confidence of a finding.
const LEAST_CONFIDENCE: f64 = 0.5;

/// What commands and positions show of an arm.
#[derive(Debug)]
pub struct ServoDiagnosis {
    /// Laws between commands and positions, by joint from base to tip.
    pub findings: Vec<Finding>,
    /// The identification that they are of.
    pub identification: ServoIdentification,
}

/// Diagnoses an arm from commands and positions: controllers, friction, and the weight that no controller carries.
///
/// # Errors
/// [`ServoError`].
pub fn diagnose_servos(request: &ServoRequest<'_>) -> Result<ServoDiagnosis, ServoError> {
    let identification = identify_servos(&ServoRequest { ablations: true, ..*request })?;
    let gains = request.train_gains;
    let one_gain = gains.iter().all(|gain| *gain == gains[0]);
    let chain = &identification.model.chain;
    let of_joint = |(fit, joint): (&ServoJointFit, JointKind)| {
        let found = JointFindings { fit, kind: joint, one_gain, model: &identification };
        found.all()
    };
    let kinds = chain.joints.iter().map(|joint| joint.kind);
    let findings = identification.joints.iter().zip(kinds).flat_map(of_joint).collect();
    Ok(ServoDiagnosis { findings, identification })
}

struct JointFindings<'a> {
    fit: &'a ServoJointFit,
    kind: JointKind,
    one_gain: bool,
    model: &'a ServoIdentification,
}

impl JointFindings<'_> {
    fn all(&self) -> Vec<Finding> {
        let mut found: Vec<Finding> = self.controller().into_iter().collect();
        found.extend(self.dry_friction());
        for parameter in [
            ServoParameter::LoadFriction,
            ServoParameter::Damping,
            ServoParameter::Offset,
            ServoParameter::Inertia,
        ] {
            found.extend(self.law(parameter));
        }
        found.sort_by(|a, b| b.evidence.materiality.total_cmp(&a.evidence.materiality));
        found
    }

    fn value(&self, parameter: ServoParameter) -> Option<&ServoValue> {
        self.fit.values.iter().find(|value| value.parameter == parameter)
    }

    fn ablation(&self, parameters: &[ServoParameter]) -> Option<&ServoAblation> {
        self.fit.ablations.iter().find(|without| without.parameters == parameters)
    }

    /// Over two standard errors; none where these are not known.
    fn size(&self, parameter: ServoParameter) -> Option<f64> {
        let value = self.value(parameter)?;
        Some(value.value.abs() / (DEVIATIONS * value.standard_error?))
    }

    /// Of the parameter that is known best.
    fn size_of(&self, parameters: &[ServoParameter]) -> Option<f64> {
        parameters.iter().filter_map(|p| self.size(*p)).max_by(f64::total_cmp)
    }

    fn materiality(&self, ablation: &ServoAblation) -> Materiality {
        let [with, without] = ablation.train;
        let noise = (OF_ROUNDING * self.fit.resolution).max(f64::MIN_POSITIVE);
        let excess = (with * with - noise * noise).max(0.0).sqrt();
        let explained = (without * without - with * with).max(0.0).sqrt();
        Materiality {
            value: explained / noise,
            least: LEAST.max(SHARE_FOR_CHANGE * excess / noise),
            joint: 0,
        }
    }

    /// A finding of what these ablations show; none where that is not material or has no size.
    fn finding(
        &self,
        (law, level): (&dyn Effect, f64),
        shown_by: &[&[ServoParameter]],
        parameters: BTreeMap<&'static str, Value>,
        alternatives: Vec<Alternative>,
    ) -> Option<Finding> {
        let judged = |of: &&[ServoParameter]| {
            let ablation = self.ablation(of)?;
            let gains = &ablation.block_gains;
            let p = student_t_tail(paired_t(gains), gains.len().saturating_sub(1) as f64);
            if p.is_nan() || p > level {
                return None;
            }
            let (materiality, size) = (self.materiality(ablation), self.size_of(of));
            let alone =
                Evidence { materiality: &materiality, size, left: None, behind: Vec::new() };
            let [with, without] = ablation.holdout.unwrap_or([0.0, 1.0]);
            let confirmed = ablation.holdout.map(|_| with < without);
            let confidence = match confirmed {
                Some(false) => with_odds(alone.confidence(), NOT_CONFIRMED),
                _ => alone.confidence(),
            };
            size.is_none_or(|size| size >= 1.0).then_some((
                confidence,
                confirmed,
                materiality,
                size,
            ))
        };
        let best = shown_by.iter().filter_map(judged).max_by(|a, b| a.0.total_cmp(&b.0))?;
        let (confidence, confirmed, materiality, size) = best;
        (confidence >= LEAST_CONFIDENCE).then(|| Finding {
            effect: law.slug().to_owned(),
            joints: vec![self.fit.joint.clone()],
            link: None,
            window: None,
            recording: None,
            parameters,
            confidence,
            confirmed,
            evidence: FindingEvidence {
                materiality: materiality.value,
                least_materiality: materiality.least,
                joint: self.fit.joint.clone(),
                size,
                variables: Vec::new(),
                character: None,
                holdout_gain: None,
            },
            alternatives,
        })
    }

    fn controller(&self) -> Option<Finding> {
        let mut parameters = BTreeMap::new();
        let term = self.model.model.servos.iter().find(|term| term.joint == self.fit.joint)?;
        let units = PositionControl.law().parameters;
        let mut put = |name: &'static str, value: f64, stderr: Option<f64>, unit: &'static str| {
            parameters.insert(name, Value { value, stderr, unit });
        };
        if term.is_determined {
            let unit = units[0].unit(self.kind);
            put("stiffness", term.servo.stiffness, term.stiffness_error, unit);
        }
        put("delay", term.servo.delay_s, term.delay_error_s, "s");
        if let Some(limit) = term.servo.effort_limit.filter(|_| term.is_determined) {
            put("effort_limit", limit, None, units[3].unit(self.kind));
        }
        let length = if self.kind.is_rotational() { "rad" } else { "m" };
        if let Some(sag) = self.fit.sag {
            put("sag", sag, None, length);
        }
        if let Some(lag) = self.fit.lag {
            let stderr = lag.interval_95.map(|[low, high]| (high - low) / (2.0 * 1.96));
            put("lag", lag.value_s, stderr, "s");
        }
        // a lag that the delay or the damping alone explains may be either; so may a sag under a weight that hardly changes and
        // an offset
        let lag = [ServoParameter::Delay, ServoParameter::Damping];
        let sag = [ServoParameter::Compliance, ServoParameter::Offset];
        let alone: [&[ServoParameter]; 2] = [&sag[..1], &lag[..1]];
        let alternatives = self.lag_by(&ViscousFriction, &PositionControl);
        let controller: (&dyn Effect, f64) = (&PositionControl, CONTROLLER_LEVEL);
        let by_two = |two: &[ServoParameter], other: &dyn Effect| {
            let either = vec![self.alternative(other, &PositionControl)];
            self.finding(controller, &[two], parameters.clone(), either)
        };
        self.finding(controller, &alone, parameters.clone(), alternatives)
            .or_else(|| by_two(&lag, &ViscousFriction))
            .or_else(|| by_two(&sag, &TorqueOffset).filter(|_| self.is_beyond_errors(sag[0])))
    }

    fn is_beyond_errors(&self, parameter: ServoParameter) -> bool {
        self.size(parameter).is_some_and(|size| size >= 1.0)
    }

    /// The other law of a lag, where the recordings do not separate delay and damping.
    fn lag_by(&self, other: &dyn Effect, named: &dyn Effect) -> Vec<Alternative> {
        let is_open = self.fit.delay_with_damping.is_some_and(|r| r.abs() > NOT_SEPARATED);
        if is_open { vec![self.alternative(other, named)] } else { Vec::new() }
    }

    /// Another law of what a named one explains.
    fn alternative(&self, law: &dyn Effect, named: &dyn Effect) -> Alternative {
        Alternative {
            effect: law.slug().to_owned(),
            joints: vec![self.fit.joint.clone()],
            link: None,
            left_more: None,
            separated_by: named.law().separated_from(law.law()),
        }
    }

    /// Stribeck friction where its static part is shown, Coulomb friction otherwise. Of a level and a part by load either may do
    /// for the other, and none of them be shown alone.
    fn dry_friction(&self) -> Option<Finding> {
        let alone = [ServoParameter::StaticExcess, ServoParameter::DryFriction];
        let either = || {
            let pair = [ServoParameter::DryFriction, ServoParameter::LoadFriction];
            let parameters = self.parameters(&CoulombFriction, ServoParameter::DryFriction)?;
            let by_load = vec![self.alternative(&LoadDependentFriction, &CoulombFriction)];
            self.law(ServoParameter::LoadFriction)
                .is_none()
                .then(|| self.finding((&CoulombFriction, LEVEL), &[&pair], parameters, by_load))?
        };
        alone.into_iter().find_map(|parameter| self.law(parameter)).or_else(either)
    }

    /// A law of the joint by its parameter; where the stiffness is not determined, over the stiffness.
    fn law(&self, parameter: ServoParameter) -> Option<Finding> {
        let law: &dyn Effect = match parameter {
            ServoParameter::StaticExcess => &StribeckFriction,
            ServoParameter::DryFriction => &CoulombFriction,
            ServoParameter::LoadFriction => &LoadDependentFriction,
            ServoParameter::Damping => &ViscousFriction,
            ServoParameter::Offset => &TorqueOffset,
            ServoParameter::Inertia => &RotorInertia,
            _ => return None,
        };
        let alternatives = match parameter {
            // back-EMF and the derivative part of the controller are damping too
            ServoParameter::Damping if self.one_gain => {
                vec![self.alternative(&PositionControl, &ViscousFriction)]
            }
            ServoParameter::Damping => self.lag_by(&PositionControl, &ViscousFriction),
            _ => Vec::new(),
        };
        let parameters = self.parameters(law, parameter)?;
        self.finding((law, LEVEL), &[&[parameter]], parameters, alternatives)
    }

    fn parameters(
        &self,
        law: &dyn Effect,
        parameter: ServoParameter,
    ) -> Option<BTreeMap<&'static str, Value>> {
        let term = self.model.model.servos.iter().find(|term| term.joint == self.fit.joint)?;
        let stiffness = term.servo.stiffness;
        let own = law.law().parameters;
        let value = *self.value(parameter)?;
        let mut of = BTreeMap::new();
        if parameter == ServoParameter::LoadFriction {
            let stderr = value.standard_error;
            of.insert("load_coefficient", Value { value: value.value, stderr, unit: "1" });
            return Some(of);
        }
        let effort = |value: f64, stderr: Option<f64>, unit: &'static str| {
            // errors of the ratio to the stiffness and of the stiffness as independent ones
            let relative = |error: Option<f64>, of: f64| error.map(|error| (error / of).powi(2));
            let both = relative(stderr, value).zip(relative(term.stiffness_error, stiffness));
            let stderr = both.map(|(a, b)| (a + b).sqrt() * (value * stiffness).abs());
            Value { value: value * stiffness, stderr, unit }
        };
        let length = if self.kind.is_rotational() { "rad" } else { "m" };
        if !term.is_determined {
            let (name, unit) = match parameter {
                ServoParameter::Damping => ("coefficient_over_stiffness", "s"),
                ServoParameter::Inertia => ("inertia_over_stiffness", "s^2"),
                ServoParameter::Offset => ("offset_over_stiffness", length),
                _ => ("level_over_stiffness", length),
            };
            of.insert(name, Value { value: value.value, stderr: value.standard_error, unit });
            return Some(of);
        }
        let unit = |k: usize| own[k].unit(self.kind);
        if parameter == ServoParameter::StaticExcess {
            let level = self.value(ServoParameter::DryFriction)?;
            let coulomb = effort(level.value, level.standard_error, unit(1));
            let beyond = effort(value.value, value.standard_error, unit(0));
            let stderr = coulomb.stderr.zip(beyond.stderr).map(|(a, b)| a.hypot(b));
            let static_level = coulomb.value + beyond.value;
            of.insert(own[0].name, Value { value: static_level, stderr, unit: unit(0) });
            of.insert(own[1].name, coulomb);
            if let Some(velocity) = self.value(ServoParameter::StribeckVelocity) {
                let (value, stderr) = (velocity.value, velocity.standard_error);
                of.insert(own[2].name, Value { value, stderr, unit: unit(2) });
            }
            return Some(of);
        }
        of.insert(own[0].name, effort(value.value, value.standard_error, unit(0)));
        Some(of)
    }
}
