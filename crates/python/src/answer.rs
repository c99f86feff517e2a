//! Results of commands: JSON, text, page, and the model where there is one.

use std::path::PathBuf;
use std::sync::Arc;

use armident_commands::{
    CardFiles, CardOptions, Checked, ConvertReport, Diagnosed, Drawn, Excited, ExportReport,
    Failure, GivenRobot, Identified, InfoReport, Merged, PredictReport, Validated, card_files,
    card_paths,
};
use armident_page::{Drawing, Provenance};
use armident_report::{AccumulateReport, Bars, FleetReport, ParamsReport};
use pyo3::prelude::*;
use serde::Serialize;

use crate::error::raised;
use crate::robot::Robot;
use crate::work::done;

/// What a command found.
pub(crate) enum Found {
    Checked(Box<Checked>),
    Identified(Box<Identified>),
    Diagnosed(Box<Diagnosed>),
    Validated(Box<Validated>),
    Params(Box<ParamsReport>),
    Predicted(PredictReport),
    Exported(Box<ExportReport>),
    Informed(InfoReport),
    Converted(ConvertReport),
    Excited(Box<Excited>),
    Accumulated(AccumulateReport),
    Merged(Box<Merged>),
    Fleet(Box<FleetReport>),
}

/// The result of a command.
#[pyclass(frozen, module = "armident._armident")]
pub(crate) struct Answer {
    found: Arc<Found>,
    notes: Vec<String>,
    command: Vec<String>,
    files: Vec<PathBuf>,
}

impl Answer {
    /// `command` is the call, `files` are what it was made of.
    pub(crate) fn new(found: Found, command: &str, files: Vec<PathBuf>) -> Self {
        let command = vec![format!("armident.{command} (Python)")];
        Self { found: Arc::new(found), notes: Vec::new(), command, files }
    }

    /// With notes that are no part of the JSON.
    pub(crate) fn with_notes(self, notes: Vec<String>) -> Self {
        Self { notes, ..self }
    }

    fn model_of(&self) -> Option<(&'static str, &armident_model::ArmModel)> {
        match &*self.found {
            Found::Identified(found) => Some(("identified", &found.model)),
            Found::Diagnosed(found) => Some(("diagnosed", found.model()?)),
            Found::Merged(found) => Some(("merged", &found.model)),
            _ => None,
        }
    }
}

#[pymethods]
impl Answer {
    /// The JSON of the command line, without chart data.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        self.document(py, false)
    }

    /// The JSON, with chart data where `traces`.
    fn document(&self, py: Python<'_>, traces: bool) -> PyResult<String> {
        let (found, command, files) =
            (Arc::clone(&self.found), self.command.clone(), self.files.clone());
        done(py, move || document(&found, traces, command, &files))
    }

    /// The text that the command line prints.
    fn text(&self) -> String {
        let bars = Bars::Unicode;
        match &*self.found {
            Found::Checked(found) => found.report.text(),
            Found::Identified(found) => found.report.text(bars),
            Found::Diagnosed(found) => found.report.text(bars),
            Found::Validated(found) => found.report.text(bars),
            Found::Params(report) => report.text(),
            Found::Predicted(report) => {
                format!("{} joints, {} samples\n", report.joints.len(), report.samples)
            }
            Found::Exported(report) => {
                format!(
                    "{}, {} joints; {} effects exported, {} omitted\n",
                    report.format,
                    report.joints.len(),
                    report.held.len(),
                    report.lost.len()
                ) + &report
                    .thresholds
                    .as_ref()
                    .map_or_else(String::new, |thresholds| thresholds.text())
            }
            Found::Informed(report) => report.text(),
            Found::Converted(report) => report.text(),
            Found::Excited(found) => found.report.text(),
            Found::Accumulated(report) => report.text(),
            Found::Merged(found) => found.report.text(),
            Found::Fleet(report) => report.text(),
        }
    }

    /// The page of `--report`: one self-contained HTML file.
    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let (found, command, files) =
            (Arc::clone(&self.found), self.command.clone(), self.files.clone());
        done(py, move || {
            let document = document(&found, true, command, &files)?;
            armident_page::html(&document).map_err(unpaged)
        })
    }

    /// The recordings as topics of an MCAP file, with predicted efforts and residuals; of a diagnosis with its findings.
    fn save_mcap(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let found = Arc::clone(&self.found);
        done(py, move || {
            let topics = match &*found {
                Found::Diagnosed(found) => found.mcap()?,
                Found::Validated(found) => found.mcap()?,
                _ => {
                    let what = "expected a diagnosis or a validation, found another result";
                    return Err(Failure::new(what, "the result", None::<String>));
                }
            };
            armident_recording::write_whole(&path, |file| {
                std::io::Write::write_all(file, &topics.bytes)
            })
            .map_err(|error| Failure::unwritable(&path, &error))
        })
    }

    /// The model card of an identification: a page, and its JSON beside it.
    fn save_card(
        &self,
        py: Python<'_>,
        path: PathBuf,
        serial: Option<String>,
        date: Option<String>,
    ) -> PyResult<()> {
        let found = Arc::clone(&self.found);
        let robot = self.files.first().cloned();
        done(py, move || {
            card_paths(&path)?;
            let Found::Identified(found) = &*found else {
                let what = "expected an identification, found another result";
                return Err(Failure::new(what, "the result", None::<String>));
            };
            let files = CardFiles { robot: robot.as_deref(), ..CardFiles::default() };
            for (path, text) in
                card_files(&found.card(files, &CardOptions { serial, date }), &path)?
            {
                armident_recording::write_whole(&path, |file| {
                    std::io::Write::write_all(file, text.as_bytes())
                })
                .map_err(|error| Failure::unwritable(&path, &error))?;
            }
            Ok(())
        })
    }

    /// Verdict, findings and tables as part of a page, without charts.
    fn excerpt(&self, py: Python<'_>) -> PyResult<String> {
        let document = self.json(py)?;
        armident_page::html_excerpt(&document).map_err(|e| raised(py, &unpaged(e)))
    }

    /// The model of an identification or a diagnosis.
    fn model(&self) -> Option<Robot> {
        let (kind, model) = self.model_of()?;
        let source = format!("{kind} model of {}", model.chain.robot);
        Some(Robot { given: GivenRobot::of_model(source, model.clone()) })
    }

    /// Warnings, each with its code in brackets.
    fn warnings(&self) -> Vec<String> {
        match &*self.found {
            Found::Checked(found) => found.report.warnings.clone(),
            Found::Identified(found) => found.report.warnings.clone(),
            Found::Diagnosed(found) => found.report.warnings.clone(),
            Found::Validated(found) => found.report.warnings.clone(),
            Found::Params(report) => report.warnings().to_vec(),
            Found::Predicted(report) => report.warnings.clone(),
            Found::Exported(report) => report.warnings.clone(),
            Found::Informed(report) => report.warnings(),
            Found::Excited(found) => found.warnings.clone(),
            Found::Fleet(report) => report.warnings.clone(),
            Found::Converted(_) | Found::Accumulated(_) | Found::Merged(_) => Vec::new(),
        }
    }

    /// Notes: automatic choices and repairs.
    fn notes(&self) -> Vec<String> {
        let own = match &*self.found {
            Found::Checked(found) => &found.report.notes[..],
            Found::Identified(found) => &found.report.notes,
            Found::Validated(found) => &found.report.notes,
            Found::Predicted(report) => &report.notes,
            Found::Exported(report) => &report.notes,
            Found::Converted(report) => &report.notes,
            Found::Excited(found) => &found.notes,
            Found::Diagnosed(_)
            | Found::Params(_)
            | Found::Informed(_)
            | Found::Accumulated(_)
            | Found::Merged(_)
            | Found::Fleet(_) => &[],
        };
        own.iter().chain(&self.notes).cloned().collect()
    }
}

fn unpaged(error: armident_page::PageError) -> Failure {
    Failure::new(error, "the result", None::<String>)
}

/// The JSON of a result.
fn document(
    found: &Found,
    traces: bool,
    command: Vec<String>,
    files: &[PathBuf],
) -> Result<String, Failure> {
    let drawing = match found {
        _ if !traces => None,
        Found::Checked(found) => Some(found.drawing()?),
        Found::Identified(found) => Some(found.drawing()?),
        Found::Diagnosed(found) => Some(found.drawing()?),
        Found::Validated(found) => Some(found.drawing()?),
        // its charts are made of the result; the drawing has where it comes from
        Found::Fleet(_) => Some(Drawing::default()),
        _ => None,
    };
    // recordings in memory have no file to be digested
    let files = files.iter().filter(|file| file.is_file()).map(PathBuf::as_path);
    let drawing =
        drawing.map(|drawing| Drawing { provenance: Provenance::of(command, files), ..drawing });
    match found {
        Found::Checked(found) => written(&found.report, drawing.as_ref()),
        Found::Identified(found) => written(&found.report, drawing.as_ref()),
        Found::Diagnosed(found) => written(&found.report, drawing.as_ref()),
        Found::Validated(found) => written(&found.report, drawing.as_ref()),
        Found::Params(report) => written(report, None),
        Found::Predicted(report) => written(report, None),
        Found::Exported(report) => written(report, None),
        Found::Informed(report) => written(report, None),
        Found::Converted(report) => written(report, None),
        Found::Excited(found) => written(&found.report, None),
        Found::Accumulated(report) => written(report, None),
        Found::Merged(found) => written(&found.report, None),
        Found::Fleet(report) => written(&**report, drawing.as_ref()),
    }
}

fn written<T: Serialize>(result: &T, drawing: Option<&Drawing>) -> Result<String, Failure> {
    match drawing {
        Some(drawing) => serde_json::to_string(&Drawn { result, drawing }),
        None => serde_json::to_string(result),
    }
    .map_err(|error| Failure::new(format!("cannot write JSON: {error}"), "", None::<String>))
}
