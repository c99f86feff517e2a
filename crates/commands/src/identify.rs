//! `identify`: inertia and friction parameters of an arm.

mod batch;
mod payloads;
mod planned;

use std::path::PathBuf;

use armident_ident::StructureSearch;
use armident_ident::estimators::{Estimator, Huber};
use armident_model::ArmModel;
use armident_page::{Correlation, Drawing, RecordingRole};
use armident_recording::Recording;
use armident_report::IdentifyReport;

use crate::drawing;
use crate::failure::Failure;

pub use batch::identify;
pub use planned::{PLAN_FILE, PlannedRecordings, identify_planned, plan_in};

/// How parameters are identified.
#[derive(Clone)]
pub struct IdentifyOptions {
    /// Low-pass \[Hz\]; none: from the spectrum of the motion.
    pub cutoff_hz: Option<f64>,
    /// Estimator of a batch fit.
    pub estimator: &'static dyn Estimator,
    /// Whether each recording is predicted by a fit to the others.
    pub cross_validate: bool,
    /// Whether there is a prior on the link inertias of the robot.
    pub prior: bool,
    /// Known payloads in recordings.
    pub payloads: Vec<PayloadOn>,
    /// What structure is selected by cross-validation.
    pub search: StructureSearch,
    /// Whether the projection to physically consistent parameters is skipped.
    pub raw_estimate: bool,
}

impl Default for IdentifyOptions {
    fn default() -> Self {
        Self {
            cutoff_hz: None,
            estimator: &Huber,
            cross_validate: false,
            prior: true,
            payloads: Vec::new(),
            search: StructureSearch::ALL,
            raw_estimate: false,
        }
    }
}

/// Known payload in one of the recordings.
#[derive(Debug, Clone, PartialEq)]
pub struct PayloadOn {
    /// The recording, by its path or the name of its file.
    pub file: PathBuf,
    /// Mass \[kg\].
    pub mass_kg: f64,
    /// Centre of mass in the frame of the last moving link \[m\].
    pub com_m: Option<[f64; 3]>,
    /// Standard deviation of each coordinate of the centre \[m\].
    pub com_error_m: f64,
}

/// An identification.
#[derive(Debug)]
pub struct Identified {
    /// The result.
    pub report: IdentifyReport,
    /// The identified model.
    pub model: ArmModel,
    /// Training recordings, with efforts in place of currents.
    pub training: Vec<Recording>,
    /// Hold-out recordings, likewise.
    pub holdout: Vec<Recording>,
    correlation: Option<Correlation>,
}

impl Identified {
    /// What the page shows beside the result.
    ///
    /// # Errors
    /// Recordings that cannot be predicted.
    pub fn drawing(&self) -> Result<Drawing, Failure> {
        let recorded = [
            (self.training.as_slice(), RecordingRole::Training),
            (self.holdout.as_slice(), RecordingRole::Holdout),
        ];
        let before = self.model.before();
        let models: [(&str, &ArmModel); 2] = [("URDF only", &before), ("model", &self.model)];
        let chain = &self.model.chain;
        let drawing = drawing::of_models(chain, &models, &recorded, self.report.cutoff_hz)?;
        Ok(Drawing { correlation: self.correlation.clone(), ..drawing })
    }
}
