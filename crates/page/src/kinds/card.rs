//! The model card of an identified arm.

use armident_report::{ModelCard, counted, percent, standard_sections};

use crate::blocks::parts;
use crate::drawing::DrawnQuantity;
use crate::figures;
use crate::view::{Tone, View, number};

pub(crate) fn view(of: &ModelCard) -> View {
    let shown = standard_sections::CARD.iter();
    let shown = shown.map(|section| (section.key(), section.page(of)));
    let errors = |error: fn(&armident_report::CardEffort) -> Option<f64>| {
        of.effort.iter().map(error).collect()
    };
    let mut series = vec![
        ("URDF only".to_owned(), errors(|row| row.given)),
        ("training".to_owned(), errors(|row| row.training)),
    ];
    if of.effort.iter().any(|row| row.holdout.is_some()) {
        series.push(("hold-out".to_owned(), errors(|row| row.holdout)));
    }
    View {
        kind: "Model card",
        tone: Tone::Good,
        headline: match &of.serial {
            Some(serial) => format!("{}, serial number {serial}", of.robot),
            None => of.robot.clone(),
        },
        sentences: sentences(of),
        overview: figures::errors(&of.joints, &series, DrawnQuantity::Effort).into_iter().collect(),
        sections: parts(shown, |_| None),
        robot: of.robot.clone(),
        warnings: of.warnings.clone(),
        ..View::default()
    }
}

fn sentences(of: &ModelCard) -> Vec<String> {
    let training = of.inputs.iter().filter(|input| input.used_as == "training").count();
    let low_pass =
        of.cutoff_hz.map_or_else(String::new, |hz| format!(" below {} Hz", number(hz, 3)));
    let mut all = vec![format!(
        "{} from {} by {}{low_pass}, {}.",
        counted(of.parameters.len(), "parameter"),
        counted(training, "training recording"),
        of.method,
        of.date
            .as_ref()
            .map_or_else(|| "date not given".to_owned(), |date| format!("recorded on {date}"),)
    )];
    let relative =
        of.effort.iter().filter_map(|row| Some(row.holdout.or(row.training)? / row.given?));
    if let Some(worst) = relative.max_by(f64::total_cmp) {
        all.push(format!(
            "Effort error at most {} of that of the robot description (worst joint).",
            percent(worst)
        ));
    }
    all
}
