//! Failures as three lines: fault, place, hint.

use std::fmt::Display;
use std::path::Path;

use armident_diagnose::{DiagnoseError, Unusable};
use armident_excitation::ExcitationError;
use armident_export::ThresholdError;
use armident_ident::experiment::Algorithm2Error;
use armident_kinematics::{ChainError, UrdfError};
use armident_model::ModelError;
use armident_recording::RecordingError;
use armident_simulation::SimulationError;

use crate::excerpt::Excerpt;

/// A failed command: fault, place and hint.
#[derive(Debug)]
pub struct Failure {
    what: String,
    place: String,
    hint: Option<String>,
    excerpt: Option<Box<Excerpt>>,
}

impl Failure {
    /// Fault, place and hint.
    pub fn new(what: impl Display, place: impl Display, hint: Option<impl Into<String>>) -> Self {
        Self {
            what: what.to_string(),
            place: place.to_string(),
            hint: hint.map(Into::into),
            excerpt: None,
        }
    }

    /// Adds the faulty line of the file.
    pub fn showing(mut self, excerpt: Option<Excerpt>) -> Self {
        self.excerpt = excerpt.map(Box::new);
        self
    }

    /// A file that cannot be written.
    pub fn unwritable(path: &Path, error: &std::io::Error) -> Self {
        Self::new(
            format!("cannot write: {error}"),
            path.display(),
            Some("choose another path, or create the folder"),
        )
    }

    /// The fault: what was expected and found.
    pub fn what(&self) -> &str {
        &self.what
    }

    /// File, line or column, joint; may be empty.
    pub fn place(&self) -> &str {
        &self.place
    }

    /// What to do, in the imperative.
    pub fn hint(&self) -> Option<&str> {
        self.hint.as_deref()
    }

    /// The faulty line of the file.
    pub fn excerpt(&self) -> Option<&Excerpt> {
        self.excerpt.as_deref()
    }
}

impl Display for Failure {
    /// The three lines, with the faulty line of the file before the hint.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.what)?;
        if !self.place.is_empty() {
            write!(f, "\n   in: {}", self.place)?;
        }
        if let Some(excerpt) = &self.excerpt {
            write!(f, "\n{}", excerpt.plain())?;
        }
        if let Some(hint) = &self.hint {
            write!(f, "\n hint: {hint}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Failure {}

impl From<UrdfError> for Failure {
    fn from(error: UrdfError) -> Self {
        Self::new(&error, error.place(), error.hint()).showing(Excerpt::of_urdf(error.urdf_place()))
    }
}

impl From<ChainError> for Failure {
    fn from(error: ChainError) -> Self {
        Self::new(&error, error.place(), error.hint())
    }
}

impl From<RecordingError> for Failure {
    fn from(error: RecordingError) -> Self {
        Self::new(&error, error.place(), error.hint()).showing(Excerpt::of_recording(&error))
    }
}

impl From<SimulationError> for Failure {
    fn from(error: SimulationError) -> Self {
        Self::new(&error, error.place(), error.hint())
    }
}

impl From<DiagnoseError> for Failure {
    fn from(error: DiagnoseError) -> Self {
        match error {
            DiagnoseError::Unusable(Unusable::Recording(error)) => error.into(),
            other => Self::new(
                other,
                "the recordings",
                Some("provide recordings of several seconds in which the joints move under effort"),
            ),
        }
    }
}

impl From<armident_numeric::NumericError> for Failure {
    fn from(error: armident_numeric::NumericError) -> Self {
        Self::new(error, "", Some("check the URDF and recordings for extreme values"))
    }
}

impl From<armident_ident::ConsistencyError> for Failure {
    fn from(error: armident_ident::ConsistencyError) -> Self {
        Self::new(
            error,
            "the links of the model",
            Some("check the URDF, or pass --raw-estimate to skip the projection"),
        )
    }
}

impl From<armident_ident::estimators::EstimatorError> for Failure {
    fn from(error: armident_ident::estimators::EstimatorError) -> Self {
        use armident_ident::estimators::EstimatorError;
        match error {
            EstimatorError::Numeric(error) => error.into(),
            EstimatorError::Unsuitable { estimator, ref hint, .. } => {
                let hint = hint.clone();
                Self::new(error, format!("--method {estimator}"), Some(hint))
            }
            other => Self::new(other, "--method", None::<String>),
        }
    }
}

impl From<armident_model::PredictError> for Failure {
    fn from(error: armident_model::PredictError) -> Self {
        match error {
            armident_model::PredictError::Recording(error) => error.into(),
            armident_model::PredictError::Effect(error) => error.into(),
            other => Self::new(other, "the motion", None::<String>),
        }
    }
}

impl From<ThresholdError> for Failure {
    fn from(error: ThresholdError) -> Self {
        match error {
            ThresholdError::Recording(error) => error.into(),
            ThresholdError::Predict(error) => error.into(),
            ThresholdError::NoEffort { ref recording, .. } => {
                let place = recording.clone();
                Self::new(error, place, Some("record <joint>/effort of every chain joint"))
            }
            ThresholdError::Gain { ref recording, most, .. } => {
                let (place, hint) = (recording.clone(), format!("pass --observer-gain {most:.0}"));
                Self::new(error, place, Some(hint))
            }
            other => Self::new(
                other,
                "--without-contact",
                Some("add recordings of ordinary motion without contact, some minutes in all"),
            ),
        }
    }
}

impl From<armident_effects::UnknownEffect> for Failure {
    fn from(error: armident_effects::UnknownEffect) -> Self {
        Self::new(error, "the model", None::<String>)
    }
}

impl From<Algorithm2Error> for Failure {
    fn from(error: Algorithm2Error) -> Self {
        Self::new(
            error,
            "plan.json",
            Some("use the same robot and chain options for plan, simulate and identify"),
        )
    }
}

impl Failure {
    /// A TOML file that cannot be used, with its line.
    pub fn of_toml(error: &toml::de::Error, text: &str, path: &Path, hint: &str) -> Self {
        let line = error.span().map(|span| text[..span.start].matches('\n').count() + 1);
        let place = match line {
            Some(line) => format!("{}, line {line}", path.display()),
            None => path.display().to_string(),
        };
        Self::new(error.message().lines().next().unwrap_or_default(), place, Some(hint))
    }

    /// Motions that cannot be designed, with limits of a file or of the URDF.
    pub fn excitation(error: &ExcitationError, limits: Option<&Path>) -> Self {
        let (place, hint) = match error {
            ExcitationError::UnknownJoint { known, .. } => {
                (limits, format!("joints of the chain: {}", known.join(", ")))
            }
            ExcitationError::Limit { .. } => {
                let hint =
                    "limits are in rad, m, s, N m and N; leave one out to use that of the URDF";
                (limits, hint.to_owned())
            }
            ExcitationError::Effort { .. } => {
                let hint = "raise `effort` of this joint with --limits FILE, or narrow `lower` and `upper` to poses it can hold";
                (limits, hint.to_owned())
            }
            ExcitationError::NoFreePose { .. } => {
                let hint = "make the keep-out smaller or move it away, or widen `lower` and `upper` with --limits FILE to poses that are free";
                return Self::new(error, "keep-outs and shapes of the links", Some(hint));
            }
            ExcitationError::KeepOut { .. } => {
                let hint = "`armident excite --help` shows a box and a plane";
                return Self::new(error, "the keep-outs", Some(hint));
            }
            ExcitationError::NoShapes => {
                let hint = "add `<collision>` boxes, cylinders or spheres to the links of the URDF";
                return Self::new(error, "the URDF", Some(hint));
            }
            ExcitationError::Rival { .. } => {
                let hint = "pass the robot and the diagnosis of the same arm";
                return Self::new(error, "the diagnosis", Some(hint));
            }
            _ => (None, "choose another value".to_owned()),
        };
        let place = place.map_or("the limits".to_owned(), |path| path.display().to_string());
        Self::new(error, place, Some(hint))
    }

    /// A model file that cannot be used.
    pub fn model(path: &Path, error: &ModelError) -> Self {
        let place = match error {
            ModelError::Invalid { line, .. } => format!("{}, line {line}", path.display()),
            _ => path.display().to_string(),
        };
        let hint = match error {
            ModelError::Schema { .. } | ModelError::Invalid { .. } => {
                "pass a URDF, or a model written by `armident identify --save-model`"
            }
            _ => "write the model again with `armident identify --save-model`",
        };
        Self::new(error, place, Some(hint))
    }
}
