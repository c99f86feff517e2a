//! What a recording tells, reduced to one triangle a joint: small, merged in any order, finished anywhere.
//!
//! Method: the rows of each joint of one recording as the triangle of their QR factors, for fixed columns and one cut-off.
//! Orthogonal sums of states are those of the recordings, however these were dealt out. Robust weights of single samples
//! need a further pass over the recordings and are not part of it: the estimate is weighted least squares.
//!
//! References: as [`crate::JointRows`].

use armident_model::ArmModel;
use armident_numeric::{AccumulatedQr, NumericError};
use armident_recording::Recording;
use serde::{Deserialize, Serialize};

use crate::consistency::ConsistencyError;
use crate::identify::{IdentifyError, motions_with_effort};
use crate::minimal_set::MinimalSet;
use crate::regression::{BatchEstimate, BatchProblem, BatchSettings, JointFit, JointRows};

/// Largest difference of the geometry of two arms that count as one \[m, rad\]: that of a printed number.
const SAME_GEOMETRY: f64 = 1e-9;
/// Stamps above it are seconds since 1970 (this one is of 2001), below it seconds since some start.
const UNIX_TIME_S: f64 = 1e9;

/// The rows of one recording, reduced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordingState {
    /// `armident.state/1`.
    pub schema: String,
    /// Where the recording comes from.
    pub recording: String,
    /// Which robot of a fleet it was made on, where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// When it was made, since 1970 (UTC) \[s\], where its stamps have it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recorded_at_s: Option<f64>,
    /// Digest of the file's bytes and of how they were read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub content: Option<String>,
    /// The arm and the columns that it was reduced for.
    pub arm: ReducedArm,
    /// Independent samples over samples.
    pub independent_share: f64,
    /// Length \[s\].
    pub seconds: f64,
    /// What was repaired or left out on reading.
    pub notes: Vec<String>,
    /// One of each joint; tables have them in columns of their own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<JointTriangle>,
}

/// An arm and the columns of its joints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReducedArm {
    /// Joints of the chain.
    pub joints: Vec<String>,
    /// Driving-axis constants `b, d, β, θ` of each joint \[m, m, rad, rad\].
    pub frames: Vec<[f64; 4]>,
    /// Gravity in the base frame \[m/s²\].
    pub gravity: [f64; 3],
    /// Labels of the parameters.
    pub parameters: Vec<String>,
    /// Cut-off of the low-pass \[Hz\].
    pub cutoff_hz: f64,
}

/// The rows of one joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointTriangle {
    /// Observations.
    pub rows: usize,
    /// Upper triangle of `[columns | effort]`, row by row.
    pub triangle: Vec<f64>,
    /// Number, sum and sum of squares of the filtered effort \[N m or N\].
    pub effort: (usize, f64, f64),
}

/// Why states cannot be merged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StateError {
    /// There is none.
    #[error("no state of a recording")]
    None,
    /// Another version.
    #[error("{recording}: expected schema `{}`, found `{schema}`", RecordingState::SCHEMA)]
    Schema {
        /// The recording.
        recording: String,
        /// What stands there.
        schema: String,
    },
    /// It was made for another arm.
    #[error("{recording}: the state is of another arm: {difference}")]
    OtherArm {
        /// The recording.
        recording: String,
        /// What differs.
        difference: String,
    },
    /// Its numbers do not fit its columns.
    #[error("{recording}: the state is damaged: {fault}")]
    Damaged {
        /// The recording.
        recording: String,
        /// What was found.
        fault: String,
    },
    /// Least squares failed.
    #[error(transparent)]
    Numeric(#[from] NumericError),
    /// No consistent links.
    #[error(transparent)]
    Consistency(#[from] ConsistencyError),
}

/// Columns of an arm, for states of its recordings.
#[derive(Debug, Clone)]
pub struct StateColumns<'a> {
    model: &'a ArmModel,
    problem: BatchProblem,
    arm: ReducedArm,
}

/// An arm identified from states.
#[derive(Debug, Clone)]
pub struct MergedIdentification {
    /// Consistent links and effects.
    pub model: ArmModel,
    /// The parameters.
    pub problem: BatchProblem,
    /// Their values and errors.
    pub estimate: BatchEstimate,
    /// Errors of the estimate on the merged rows, by joint.
    pub fits: Vec<JointFit>,
    /// Errors of the given model.
    pub given_fits: Vec<JointFit>,
    /// Observations of all joints.
    pub rows: usize,
}

impl RecordingState {
    /// Its schema.
    pub const SCHEMA: &'static str = "armident.state/1";
}

impl<'a> StateColumns<'a> {
    /// The minimal set and the friction of each joint, below a cut-off \[Hz\] that is the same for all recordings.
    ///
    /// # Errors
    /// [`NumericError`] where the geometry is not finite.
    pub fn new(model: &'a ArmModel, cutoff_hz: f64) -> Result<Self, NumericError> {
        let rigid = model.rigid_arm();
        let set = MinimalSet::of(&rigid)?;
        let problem = BatchProblem::new(&rigid, &set);
        let names = model.chain.joint_names();
        let frame =
            |f: armident_kinematics::DrivingAxisFrame| [f.b_m, f.d_m, f.beta_rad, f.theta_rad];
        let arm = ReducedArm {
            joints: names.iter().map(|name| (*name).to_owned()).collect(),
            frames: model.chain.joints.iter().map(|joint| frame(joint.frame)).collect(),
            gravity: model.chain.gravity_base.into(),
            parameters: problem.terms.iter().map(|term| problem.label(term, &names)).collect(),
            cutoff_hz,
        };
        Ok(Self { model, problem, arm })
    }

    /// The arm that states are reduced for.
    pub fn model(&self) -> &ArmModel {
        self.model
    }

    /// The parameters, and which of them appear in the effort of each joint.
    pub fn problem(&self) -> &BatchProblem {
        &self.problem
    }

    /// What states of the arm carry of it.
    pub fn arm(&self) -> &ReducedArm {
        &self.arm
    }

    /// Reduces a recording.
    ///
    /// # Errors
    /// [`IdentifyError`]: a joint without position or effort, a cut-off that the recording does not allow.
    pub fn reduce(&self, recording: &Recording) -> Result<RecordingState, IdentifyError> {
        let names = self.model.chain.joint_names();
        let motions =
            motions_with_effort(std::slice::from_ref(recording), &names, Some(self.arm.cutoff_hz))?;
        let motions: Vec<_> = motions.into_iter().map(armident_motion::Motion::thinned).collect();
        let rows = self.problem.accumulate(&motions.iter().collect::<Vec<_>>());
        let joints = rows.triangles.iter().zip(&rows.effort);
        let stamps = &recording.time_s;
        Ok(RecordingState {
            schema: RecordingState::SCHEMA.to_owned(),
            recording: recording.source.clone(),
            robot: None,
            recorded_at_s: stamps.first().copied().filter(|first| *first > UNIX_TIME_S),
            content: None,
            arm: self.arm.clone(),
            independent_share: rows.share,
            seconds: stamps.last().unwrap_or(&0.0) - stamps.first().unwrap_or(&0.0),
            notes: recording.notes.clone(),
            joints: joints
                .map(|(triangle, effort)| JointTriangle {
                    rows: triangle.rows(),
                    triangle: triangle.upper(),
                    effort: *effort,
                })
                .collect(),
        })
    }

    /// Whether a state was made for this arm, and is whole.
    ///
    /// # Errors
    /// [`StateError`] with what differs.
    pub fn check(&self, state: &RecordingState) -> Result<(), StateError> {
        self.check_arm(&state.recording, &state.schema, &state.arm)?;
        self.check_numbers(state)
    }

    /// Whether the state of a recording was made for this arm, from what stands in front of its numbers.
    ///
    /// # Errors
    /// [`StateError`] with what differs.
    pub fn check_arm(
        &self,
        recording: &str,
        schema: &str,
        its: &ReducedArm,
    ) -> Result<(), StateError> {
        let recording = || recording.to_owned();
        if schema != RecordingState::SCHEMA {
            let schema = schema.to_owned();
            return Err(StateError::Schema { recording: recording(), schema });
        }
        let other =
            |difference: String| Err(StateError::OtherArm { recording: recording(), difference });
        let own = &self.arm;
        if own.joints != its.joints {
            return other(format!(
                "joints {}, expected {}",
                its.joints.join(", "),
                own.joints.join(", ")
            ));
        }
        if own.parameters != its.parameters {
            return other(format!(
                "{} parameters, expected {}",
                its.parameters.len(),
                own.parameters.len()
            ));
        }
        if (own.cutoff_hz - its.cutoff_hz).abs() > SAME_GEOMETRY {
            return other(format!("cut-off {} Hz, expected {} Hz", its.cutoff_hz, own.cutoff_hz));
        }
        let differs = |a: &[f64], b: &[f64]| {
            a.len() != b.len() || a.iter().zip(b).any(|(a, b)| (a - b).abs() > SAME_GEOMETRY)
        };
        for ((name, a), b) in own.joints.iter().zip(&own.frames).zip(&its.frames) {
            if differs(a, b) {
                return other(format!("frame of joint `{name}` {b:?}, expected {a:?}"));
            }
        }
        if differs(&own.gravity, &its.gravity) {
            return other(format!("gravity {:?}, expected {:?}", its.gravity, own.gravity));
        }
        Ok(())
    }

    /// Whether the numbers of a state fit its columns.
    fn check_numbers(&self, state: &RecordingState) -> Result<(), StateError> {
        let own = &self.arm;
        let recording = || state.recording.clone();
        let damaged = |fault: String| Err(StateError::Damaged { recording: recording(), fault });
        if state.joints.len() != own.joints.len() {
            return damaged(format!(
                "{} joints, expected {}",
                state.joints.len(),
                own.joints.len()
            ));
        }
        for (joint, of) in own.joints.iter().zip(&state.joints) {
            if of.triangle.iter().any(|x| !x.is_finite()) {
                return damaged(format!("numbers of joint `{joint}` are not finite"));
            }
        }
        let widths =
            (0..own.joints.len()).map(|joint| self.problem.terms_of_joint(joint).len() + 1);
        for ((joint, of), width) in own.joints.iter().zip(&state.joints).zip(widths) {
            let expected = width * (width + 1) / 2;
            if of.triangle.len() != expected {
                let found = of.triangle.len();
                return damaged(format!("{found} numbers of joint `{joint}`, expected {expected}"));
            }
        }
        Ok(())
    }

    /// Identifies the arm from states, in any order; the prior on the links has the scale of the default settings.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn identify<'s>(
        &self,
        states: impl IntoIterator<Item = &'s RecordingState>,
    ) -> Result<MergedIdentification, StateError> {
        let mut sum: Option<JointRows> = None;
        let mut sources = Vec::new();
        for state in states {
            self.check(state)?;
            let rows = self.rows(state);
            match &mut sum {
                Some(sum) => sum.merge(&rows),
                None => sum = Some(rows),
            }
            sources.push(state.recording.clone());
        }
        let rows = sum.ok_or(StateError::None)?;
        let problem = &self.problem;
        let estimate = problem.estimate_with(&rows, &BatchSettings::default())?;
        let consistent = problem.nearest_consistent(&estimate)?;
        let names = self.model.chain.joint_names();
        let mut model = ArmModel {
            effects: problem.consistent_effects(&consistent, &names),
            ..self.model.clone().with_links(&consistent.links)
        };
        model.cutoff_hz = Some(self.arm.cutoff_hz);
        model.effort_noise = Some(estimate.effort_noise.clone());
        model.provenance.push(format!("fitted to {} reduced recordings", sources.len()));
        let fits = problem.fit(&rows, &consistent.estimated);
        let given_fits = problem.fit(&rows, &problem.given_values());
        let rows = rows.effort.iter().map(|e| e.0).sum();
        Ok(MergedIdentification {
            model,
            problem: problem.clone(),
            estimate,
            fits,
            given_fits,
            rows,
        })
    }

    /// The rows of a state that fits the arm: a recording is one block of time.
    fn rows(&self, state: &RecordingState) -> JointRows {
        let triangles: Vec<AccumulatedQr> = (0..state.joints.len())
            .map(|joint| {
                let width = self.problem.terms_of_joint(joint).len();
                let of = &state.joints[joint];
                AccumulatedQr::from_upper(width, of.rows, &of.triangle)
            })
            .collect();
        JointRows {
            blocks: triangles.iter().map(|t| vec![t.clone()]).collect(),
            triangles,
            effort: state.joints.iter().map(|joint| joint.effort).collect(),
            share: state.independent_share,
        }
    }
}
