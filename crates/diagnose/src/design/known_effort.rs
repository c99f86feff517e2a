//! Efforts that a given model explains beyond its rigid body: taken out of the recordings.

use armident_effects::{EffectOnJoint, tilted};
use armident_model::{ArmModel, BandPrediction};
use armident_motion::BandMotion;
use armident_recording::RecordingError;
use nalgebra::Vector3;

/// A model that holds more than a rigid body: its other efforts are subtracted from recordings, which are compared with
/// its body alone.
pub(crate) struct KnownModel {
    /// The whole of it.
    pub(crate) model: ArmModel,
    /// Its links under its gravity and nothing else.
    body: ArmModel,
    joint_effects: Vec<EffectOnJoint>,
}

impl KnownModel {
    /// Of a model.
    pub(crate) fn of(model: ArmModel) -> Self {
        let mut body = model.links_in_band();
        // the tilt of the base becomes part of the arm; gains, zeros and lags stay the recordings'
        let tilt = Vector3::new(model.base_tilt_rad[0], model.base_tilt_rad[1], 0.0);
        body.chain.gravity_e0 = tilted(&body.chain.base_from_e0, &body.chain.gravity_e0, &tilt);
        let band = model.band.clone().unwrap_or_else(|| BandPrediction::of(body.chain.dof()));
        if let Some(of_body) = &mut body.band {
            of_body.rigid_cutoff_hz = band.rigid_cutoff_hz;
        }
        let joint_effects = model.joint_effects().cloned().collect();
        let model = ArmModel { band: Some(band), ..model };
        Self { model, body, joint_effects }
    }

    /// The rigid-body part of the model: recordings are compared with it once all other known efforts are subtracted.
    pub(crate) fn body(&self) -> &ArmModel {
        &self.body
    }

    /// Effects on single joints that it knows.
    pub(crate) fn effects(&self) -> &[EffectOnJoint] {
        &self.joint_effects
    }

    /// A recording without the efforts that the model knows beyond those of its body. The low-passes of the predictions
    /// are no effects.
    ///
    /// # Errors
    /// A recording that cannot be used.
    pub(crate) fn taken_out_of(&self, signals: BandMotion) -> Result<BandMotion, RecordingError> {
        let (all, body) =
            (self.model.predict_in_band(&signals)?, self.body.predict_in_band(&signals)?);
        let less = |(all, body): (&Vec<f64>, &Vec<f64>)| {
            all.iter().zip(body).map(|(all, body)| all - body).collect()
        };
        Ok(signals.without(all.iter().zip(&body).map(less).collect()))
    }
}
