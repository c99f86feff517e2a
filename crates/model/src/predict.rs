//! Predicted efforts of a motion.

use std::borrow::Cow;

use armident_dynamics::{RigidArm, inverse_dynamics_of_motion};
use armident_effects::{EffectOnJoint, Scope, UnknownEffect};
use armident_motion::{
    BandMotion, Motion, MotionSettings, by_clock, continued, filter_between, later, low_pass,
    reported,
};
use armident_recording::{Quantity, Recording, RecordingError};

use crate::arm_model::{ArmModel, BandPrediction};
use crate::effect_columns::{effect_columns, pair_columns};
use crate::posed_recording::PosedRecording;
use crate::prepared::PreparedRecording;

/// Predicted efforts.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// `[joint][stamp]` of the recording \[N m or N\].
    pub efforts: Vec<Vec<f64>>,
    /// Notes on how the motion was formed.
    pub notes: Vec<String>,
}

/// Why a motion has no prediction.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PredictError {
    /// A motion without the positions of the joints, or mostly gaps.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// An effect that is not in the library.
    #[error(transparent)]
    Effect(#[from] UnknownEffect),
}

impl ArmModel {
    /// Effort of every joint at every stamp of a motion, in recorded terms. `cutoff_hz` is the low-pass of the positions
    /// in the place of [the model's](Self::cutoff_hz); a model that was fitted in a [`band`](Self::band) has its own.
    ///
    /// # Errors
    /// [`PredictError`].
    pub fn predict(
        &self,
        recording: &Recording,
        cutoff_hz: Option<f64>,
    ) -> Result<Prediction, PredictError> {
        if self.band.is_some() {
            let joints: Vec<String> = self.chain.joints.iter().map(|j| j.name.clone()).collect();
            let efforts = self.predict_prepared(&PreparedRecording::of(recording, &joints)?)?;
            let notes = [recording.notes.clone(), self.notes_on_temperatures(recording)].concat();
            return Ok(Prediction { efforts, notes });
        }
        let settings = MotionSettings { cutoff_hz, ..MotionSettings::default() };
        let motion = Motion::from_recording(recording, &self.chain.joint_names(), &settings)?;
        let mut motion = self.motion_of(motion, recording);
        motion.notes.extend(self.notes_on_temperatures(recording));
        let efforts = self.predict_motion(&motion)?.iter().map(|e| motion.at_stamps(e)).collect();
        Ok(Prediction { efforts, notes: motion.notes })
    }

    /// Where the friction follows a temperature that a recording lacks.
    fn notes_on_temperatures(&self, recording: &Recording) -> Vec<String> {
        let lacks = |joint: &str| {
            let channels = recording.joint(joint);
            channels.is_none_or(|j| j.channel(Quantity::Temperature).is_none())
        };
        let follows = |on: &&EffectOnJoint| {
            self.library.resolve(on).is_ok_and(|effect| effect.law().follows_temperature)
        };
        let on_joints = self.effects.iter().filter(follows).filter(|on| lacks(&on.joint));
        let note = |on: &EffectOnJoint| {
            format!(
                "no temperature of {} is recorded: its friction is that at the reference temperature",
                on.joint
            )
        };
        on_joints.map(note).collect()
    }

    /// The same on the grids of motions that are formed already, one a recording: `[recording][joint][sample]`.
    ///
    /// # Errors
    /// [`PredictError`].
    pub fn predict_on_grids(
        &self,
        motions: &[Motion],
        recordings: &[Recording],
    ) -> Result<Vec<Vec<Vec<f64>>>, PredictError> {
        if self.band.is_none() {
            return Ok(motions.iter().map(|m| self.predict_motion(m)).collect::<Result<_, _>>()?);
        }
        let on_grid = |(motion, recording): (&Motion, &Recording)| {
            let at_stamps = self.predict(recording, None)?.efforts;
            Ok(at_stamps.iter().map(|effort| motion.on_grid(effort)).collect())
        };
        motions.iter().zip(recordings).map(on_grid).collect()
    }

    /// Effort of every joint on the grid of a motion below the cut-off of the model, as its channel shows it,
    /// joint-major, not filtered afterwards. Terms that only a [`band`](Self::band) holds have no part in it.
    ///
    /// # Errors
    /// [`UnknownEffect`] when an effect is not in the library.
    pub fn predict_motion(&self, motion: &Motion) -> Result<Vec<Vec<f64>>, UnknownEffect> {
        let mut effort = inverse_dynamics_of_motion(
            &self.rigid_arm(),
            &motion.position,
            &motion.velocity,
            &motion.acceleration,
        );
        for on_joint in &self.effects {
            let effect = self.library.resolve(on_joint)?;
            let index = |name: &str| self.chain.joints.iter().position(|j| j.name == name);
            let Some(joint) = index(&on_joint.joint) else { continue };
            if let Some(other) = on_joint.other_joint.as_deref().and_then(index) {
                let kinds = [joint, other].map(|j| self.chain.joints[j].kind);
                let (shape, coefficients) = effect.shape_and_coefficients(&on_joint.parameters);
                let columns = pair_columns(effect, &shape, [joint, other], kinds, motion);
                for (column, parameter) in columns.iter().zip(&coefficients) {
                    for (on, column) in [joint, other].into_iter().zip(column) {
                        for (e, x) in effort[on].iter_mut().zip(column) {
                            *e += parameter * x;
                        }
                    }
                }
                continue;
            }
            let reversal = self.reversals.as_ref().map(|reversals| reversals[joint]);
            let (shape, coefficients) = effect.shape_and_coefficients(&on_joint.parameters);
            let kind = self.chain.joints[joint].kind;
            let columns = effect_columns(effect, &shape, kind, joint, motion, reversal);
            for (column, parameter) in columns.iter().zip(&coefficients) {
                for (e, x) in effort[joint].iter_mut().zip(column) {
                    *e += parameter * x;
                }
            }
        }
        for (effort, shown) in effort.iter_mut().zip(self.shown.iter().flatten()) {
            if let Some(shown) = shown {
                shown.apply(effort);
            }
        }
        Ok(effort)
    }

    /// Effort of every joint at every stamp of a prepared recording, in recorded terms, below the low-passes of
    /// [`band`](Self::band).
    ///
    /// # Errors
    /// None but those of a filter.
    pub fn predict_prepared(
        &self,
        motion: &PreparedRecording<'_>,
    ) -> Result<Vec<Vec<f64>>, RecordingError> {
        let band = self.band_or_default();
        let PreparedRecording { grid, signals, .. } = motion;
        let smoothed = |(effort, cutoff_hz): (&Vec<f64>, &Option<f64>)| match cutoff_hz {
            Some(hz) => Ok(grid.at_stamps(&low_pass(*hz, signals.rate_hz)?.filter(effort))),
            None => Ok(grid.at_stamps(effort)),
        };
        self.predict_in_band(signals)?.iter().zip(&band.output_cutoff_hz).map(smoothed).collect()
    }

    /// Effort of every joint on the grid of a recording, in recorded terms, before the low-pass of the output.
    ///
    /// # Errors
    /// None but those of a filter.
    pub fn predict_in_band(&self, signals: &BandMotion) -> Result<Vec<Vec<f64>>, RecordingError> {
        let (chain, band) = (&self.chain, self.band_or_default());
        let at = PosedRecording::new(
            chain,
            &RigidArm::from_chain(chain),
            signals,
            &self.operating_point(),
        );
        let rigid_filter = low_pass(band.rigid_cutoff_hz, signals.rate_hz)?;
        let mut effort: Vec<Vec<f64>> = (at.rigid.iter().enumerate())
            .map(|(j, rigid)| {
                let own = at.of_own(j, false);
                let rigid = own.as_ref().unwrap_or(rigid);
                filter_between(rigid, &signals.standstills[j], &rigid_filter, signals.rate_hz)
            })
            .collect();
        let index = |name: &str| chain.joints.iter().position(|j| j.name == name);
        for on_joint in self.joint_effects() {
            let (Some(law), Some(j)) = (self.library.get(&on_joint.effect), index(&on_joint.joint))
            else {
                continue;
            };
            if law.law().scope == Scope::Joint {
                add(&mut effort[j], &law.effort(&on_joint.parameters, &at.joint(j)));
            }
        }
        for term in &self.transmissions {
            let Some(j) = index(&term.joint) else { continue };
            let difference = term.transmission.difference(&at, j)?;
            for (effort, difference) in effort.iter_mut().zip(&difference) {
                let part: Vec<f64> = difference.iter().map(|x| x * term.share).collect();
                add(effort, &part);
            }
            let inertia: Vec<f64> =
                signals.actuator_acceleration[j].iter().map(|a| a * term.motor_inertia).collect();
            add(&mut effort[j], &inertia);
        }
        for coupling in self.pair_effects() {
            let (Some(law), Some(j)) = (self.library.get(&coupling.effect), index(&coupling.joint))
            else {
                continue;
            };
            let (shape, coefficients) = law.shape_and_coefficients(&coupling.parameters);
            let columns = law.pair_columns(&shape, &at.joint(j), &at.joint(j + 1));
            for (column, x) in columns.iter().zip(&coefficients) {
                for side in 0..2 {
                    let part: Vec<f64> = column[side].iter().map(|c| c * x).collect();
                    add(&mut effort[j + side], &part);
                }
            }
        }
        for term in &self.smooth_terms {
            if let Some(j) = index(&term.joint) {
                add(&mut effort[j], &term.effort(&at, index));
            }
        }
        for (j, effort) in effort.iter_mut().enumerate() {
            *effort = continued(effort, &signals.standstills[j], signals.rate_hz);
            effort.iter_mut().for_each(|e| *e *= self.channel_gain[j]);
            *effort = later(effort, -self.effort_delay_s * signals.rate_hz);
            *effort = reported(effort, signals.rate_hz, self.effort_low_pass_s);
            *effort = by_clock(effort, self.effort_clock_drift);
        }
        Ok(effort)
    }

    fn band_or_default(&self) -> Cow<'_, BandPrediction> {
        match &self.band {
            Some(band) => Cow::Borrowed(band),
            None => Cow::Owned(BandPrediction::of(self.chain.dof())),
        }
    }
}

fn add(to: &mut [f64], part: &[f64]) {
    for (to, part) in to.iter_mut().zip(part) {
        *to += part;
    }
}
