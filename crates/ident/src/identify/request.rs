//! What is to be identified, and how.

use armident_model::ArmModel;
use armident_recording::Recording;

use crate::estimators::{Estimator, Huber};
use crate::regression::{BatchSettings, KnownLoad};
use crate::structure::StructureSearch;

/// Recordings of an arm and how its parameters are to be estimated from them.
///
/// [`IdentifyRequest::new`] gives the defaults; every field may be changed.
#[derive(Clone, Copy)]
pub struct IdentifyRequest<'a> {
    /// The given model: the arm's geometry, and the links that the prior is about.
    pub model: &'a ArmModel,
    /// Training recordings: fitted.
    pub train: &'a [Recording],
    /// Hold-out recordings: predicted only.
    pub holdout: &'a [Recording],
    /// Cut-off of the low-pass \[Hz\]; none: from the spectrum of the motion.
    pub cutoff_hz: Option<f64>,
    /// Whether motions are decimated to 16 times the cut-off before the fit.
    pub decimate: bool,
    /// Loads of known mass on the last link in some of the recordings.
    pub loads: &'a [KnownLoad],
    /// How the parameters are estimated.
    pub estimator: &'a dyn Estimator,
    /// Signs of effects and link prior. The prior scale is estimated from the recordings where there is a prior.
    pub settings: BatchSettings,
    /// What structure is sought.
    pub search: StructureSearch,
    /// Whether the estimate is projected to physically consistent links.
    pub project: bool,
    /// Whether each training recording is predicted by a fit to the others.
    pub cross_validate: bool,
    /// Called at the beginning of each stage.
    pub progress: &'a (dyn Fn(Stage) + Sync),
}

impl<'a> IdentifyRequest<'a> {
    /// Robust weighted least squares with all defaults.
    pub fn new(model: &'a ArmModel, train: &'a [Recording]) -> Self {
        Self {
            model,
            train,
            holdout: &[],
            cutoff_hz: None,
            decimate: true,
            loads: &[],
            estimator: &Huber,
            settings: BatchSettings::default(),
            search: StructureSearch::ALL,
            project: true,
            cross_validate: false,
            progress: &|_| {},
        }
    }
}

/// A stage of an identification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Recordings become motions: grid, low-pass, derivatives, gains of drives.
    Motions,
    /// The structure is chosen by cross-validation.
    Structure,
    /// The parameters are estimated.
    Fit,
    /// The estimate is projected to physically consistent links.
    Projection,
}
