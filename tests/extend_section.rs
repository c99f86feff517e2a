//! A section of a diagnosis, added from outside the crates: its data is in the JSON, its text on the terminal, its
//! content on the page.

use armident_diagnose::{DiagnoseRequest, diagnose};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
use armident_model::ArmModel;
use armident_report::{
    Bars, Block, DiagnoseInputs, DiagnoseReport, DiagnosisSection, Fits, SectionData, Source,
    Table, shows, standard_sections, text_of_sections,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::shared::project;

/// What the new section shows.
#[derive(Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
struct Travel {
    /// Effects that were found.
    effects: usize,
    /// Joints of the chain.
    joints: Vec<String>,
}

impl SectionData for Travel {
    const KEY: &'static str = "test_travel";

    fn of(source: &Source<'_>) -> Option<Self> {
        let joints = source.chain.joints.iter().map(|joint| joint.name.clone()).collect();
        Some(Self { effects: source.diagnosis.findings.len(), joints })
    }

    fn text(&self, result: &DiagnoseReport) -> Vec<Block> {
        let rows = self.joints.iter().map(|joint| {
            let unit = result.position_unit(joint).to_owned();
            vec![joint.clone(), unit]
        });
        vec![
            Block::heading_with_note("Travel", format!("{} effects", self.effects)),
            Block::Table(Table::new("", &["joint", "unit"]).with(rows)),
        ]
    }
}

/// Standard sections, and the new one.
fn sections() -> Vec<&'static dyn DiagnosisSection> {
    const TRAVEL: &dyn DiagnosisSection = &shows::<Travel>();
    standard_sections::DIAGNOSIS.iter().copied().chain([TRAVEL]).collect()
}

#[test]
fn section_reaches_json_text_and_page() {
    let urdf = std::fs::read_to_string(project("urdf/planar_2r.urdf")).unwrap();
    let robot = parse_urdf(&urdf, "planar_2r.urdf").unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    let model = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
    let recording = moved(&model);
    let diagnosis = diagnose(&DiagnoseRequest::new(&model, &[recording])).unwrap();
    let sections = sections();
    let inputs = DiagnoseInputs::default();
    let report =
        DiagnoseReport::with_sections(&model.chain, &diagnosis, inputs, Fits::default(), &sections);

    let json = serde_json::to_string(&report).unwrap();
    let read: DiagnoseReport = serde_json::from_str(&json).unwrap();
    let names: Vec<String> = model.chain.joint_names().into_iter().map(str::to_owned).collect();
    let expected = Travel { effects: diagnosis.findings.len(), joints: names.clone() };
    assert_eq!(read.section::<Travel>(), Some(expected));

    let text = text_of_sections(&report, &sections, Bars::Ascii);
    let heading = format!("\nTravel ({} effects)\njoint", diagnosis.findings.len());
    assert!(text.contains(&heading), "{text}");

    let page = armident_page::html_of_sections(&json, &sections).unwrap();
    assert!(page.contains("<section id=\"test-travel\""));
    // without the section its data is kept, and not shown
    let standard = armident_page::html(&json).unwrap();
    assert!(!standard.contains("<section id=\"test-travel\"") && standard.contains("test_travel"));
    // data of another form is refused
    let broken = json.replace("\"effects\":", "\"effect\":");
    assert!(armident_page::html_of_sections(&broken, &sections).is_err());
}

/// Both joints in motion, with the efforts of the model.
fn moved(model: &ArmModel) -> armident_recording::Recording {
    let time_s: Vec<f64> = (0..2000).map(|k| f64::from(k) / 100.0).collect();
    let swing = |a: f64, w: f64| -> [Vec<f64>; 3] {
        let of = |f: &dyn Fn(f64) -> f64| time_s.iter().map(|t| f(*t)).collect();
        [
            of(&|t| a * (w * t).sin()),
            of(&|t| a * w * (w * t).cos()),
            of(&|t| -a * w * w * (w * t).sin()),
        ]
    };
    let joints = [swing(0.8, 1.3), swing(0.6, 2.9)];
    let arm = model.rigid_arm();
    let efforts: Vec<Vec<f64>> = (0..time_s.len())
        .map(|k| {
            let of = |order: usize| -> Vec<f64> { joints.iter().map(|j| j[order][k]).collect() };
            armident_dynamics::inverse_dynamics(&arm, &of(0), &of(1), &of(2))
        })
        .collect();
    let channels = model.chain.joint_names().into_iter().enumerate().map(|(j, name)| {
        // a thousandth of noise, the same in every run
        let noise =
            |k: usize| 1e-3 * ((k as f64 * 12.9898 + j as f64 * 78.233).sin() * 43758.5).fract();
        armident_recording::JointChannels {
            position: Some(joints[j][0].clone()),
            effort: Some(efforts.iter().enumerate().map(|(k, e)| e[j] + noise(k)).collect()),
            ..armident_recording::JointChannels::new(name)
        }
    });
    armident_recording::Recording::new("made", time_s.clone(), channels.collect()).unwrap()
}
