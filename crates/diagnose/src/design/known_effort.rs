//! Efforts that a given model explains beyond its rigid body: taken out of the recordings.

use armident_effects::{EffectOnJoint, tilted};
use armident_model::{ArmModel, DiagnosedModel};
use armident_motion::Signals;
use armident_recording::RecordingError;
use nalgebra::Vector3;
/// A model that holds more than a rigid body: what it knows is taken out of recordings, and they are compared with
/// its body alone.
pub struct Known {
    /// The whole of it.
    pub(crate) model: DiagnosedModel,
    /// Its links under its gravity and nothing else.
    body: DiagnosedModel,
}

impl Known {
    /// Of a model.
    pub fn of(model: DiagnosedModel) -> Self {
        let mut arm = model.arm.clone();
        arm.effects.clear();
        // the tilt of the base becomes part of the arm; gains, zeros and lags stay the recordings'
        let tilt = Vector3::new(model.learned.tilt_rad[0], model.learned.tilt_rad[1], 0.0);
        arm.chain.gravity_e0 = tilted(&arm.chain.base_from_e0, &arm.chain.gravity_e0, &tilt);
        let mut body = DiagnosedModel::believed(&arm);
        body.learned.rigid_cutoff_hz = model.learned.rigid_cutoff_hz;
        Self { model, body }
    }

    /// The arm that recordings are compared with once that is taken out of them.
    pub fn arm(&self) -> &ArmModel {
        &self.body.arm
    }

    /// Effects on single joints that it knows.
    pub(crate) fn effects(&self) -> &[EffectOnJoint] {
        &self.model.arm.effects
    }

    /// A recording without the efforts that the model knows beyond those of its body. The low-passes of the predictions
    /// are no effects.
    ///
    /// # Errors
    /// A recording that cannot be used.
    pub(crate) fn taken_out_of(&self, signals: Signals) -> Result<Signals, RecordingError> {
        let (all, body) = (self.model.on_grid(&signals)?, self.body.on_grid(&signals)?);
        let less = |(all, body): (&Vec<f64>, &Vec<f64>)| {
            all.iter().zip(body).map(|(all, body)| all - body).collect()
        };
        Ok(signals.without(all.iter().zip(&body).map(less).collect()))
    }
}
