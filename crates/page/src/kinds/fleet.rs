//! `armident fleet`.

use armident_report::{FleetReport, FleetRobot, counted, percent};

use crate::figures::{self, parameter_name};
use crate::view::{Grid, Piece, Section, Tone, View, number};

/// Robots whose trends are drawn, at most, those with changes first: the numbers of all are in the JSON.
const DRAWN_ROBOTS: usize = 24;

pub(crate) fn view(of: &FleetReport) -> View {
    // the name of a robot keeps its case, in front too
    let changes: Vec<String> = of.changes().map(|change| format!("{}.", change.sentence)).collect();
    let mut sections = vec![robots(of)];
    if !of.outliers.is_empty() {
        sections.push(outliers(of));
    }
    sections.extend(trends(of));
    sections.push(scatter(of));
    sections.extend(pages(of));
    if !of.set_aside.is_empty() {
        let rows = of.set_aside.iter().map(|one| vec![one.file.clone(), one.reason.clone()]);
        let table = Grid::new("Set aside", &["file", "reason"], 2).with(rows.collect());
        sections.push(Section::new("set-aside", "Set aside", Vec::new(), vec![table]));
    }
    let rate = percent(of.false_alarm_rate);
    let level = format!(
        "Friction of each joint and a body on each link are tested at each recording. A robot that does not change has a \
         change reported with a probability of at most {rate}."
    );
    View {
        kind: "Fleet",
        tone: if changes.is_empty() { Tone::Good } else { Tone::Bad },
        headline: armident_report::capital(&of.headline()),
        sentences: [changes, vec![level]].concat(),
        sections,
        robot: of.robot.clone(),
        warnings: of.warnings.clone(),
        ..View::default()
    }
}

/// One row a robot.
fn robots(of: &FleetReport) -> Section {
    let header = ["robot", "changes", "largest drift", "recordings", "unlike the fleet"];
    let rows = of.robots.iter().map(|robot| {
        let changes: Vec<String> = (robot.changes.iter())
            .map(|change| {
                let place = change.link.as_ref().unwrap_or(&change.joint);
                format!("{} on {place} from recording {}", change.what, change.number)
            })
            .collect();
        let unlike = of.outliers.iter().filter(|outlier| outlier.robot == robot.robot).count();
        vec![
            robot.robot.clone(),
            if changes.is_empty() { "none".to_owned() } else { changes.join("; ") },
            largest_drift(of, robot),
            robot.recordings.len().to_string(),
            unlike.to_string(),
        ]
    });
    let table = Grid::new("Robots", &header, 3).with(rows.collect());
    Section::new("robots", "Robots", Vec::new(), vec![table])
}

/// The drift of friction that exceeds its error by most, beyond two standard errors.
fn largest_drift(of: &FleetReport, robot: &FleetRobot) -> String {
    let drifts = of.parameters.iter().zip(&robot.trends).filter_map(|(parameter, trend)| {
        let [slope, error] = trend.drift?;
        (!parameter.is_constant && slope.abs() > 2.0 * error).then_some((parameter, slope, error))
    });
    let largest = drifts.max_by(|a, b| (a.1 / a.2).abs().total_cmp(&(b.1 / b.2).abs()));
    largest.map_or_else(
        || "-".to_owned(),
        |(parameter, slope, error)| {
            let (slope, error) = (number(slope, 2), number(error, 2));
            let name = parameter_name(&parameter.label);
            format!("{name}: {slope} \u{b1} {error} {} per recording", parameter.unit)
        },
    )
}

fn outliers(of: &FleetReport) -> Section {
    let header = ["robot", "parameter", "unit", "value", "median", "std error", "false alarm"];
    let rows = of.outliers.iter().map(|row| {
        vec![
            row.robot.clone(),
            parameter_name(&row.parameter),
            row.unit.clone(),
            number(row.value, 3),
            number(row.median, 3),
            number(row.standard_error, 2),
            number(row.false_alarm_probability, 2),
        ]
    });
    let table = Grid::new("Unlike the median of the fleet", &header, 2).with(rows.collect());
    Section::new("outliers", "Unlike the fleet", Vec::new(), vec![table])
}

fn trends(of: &FleetReport) -> Option<Section> {
    let mut robots: Vec<&FleetRobot> =
        of.robots.iter().filter(|robot| robot.recordings.len() > 1).collect();
    robots.sort_by_key(|robot| robot.changes.is_empty());
    let drawn = robots.len().min(DRAWN_ROBOTS);
    let charts = robots[..drawn].iter().enumerate().map(|(index, robot)| {
        let opened = opened(of, robot);
        Piece::Chart(figures::fleet_trend(index, robot, &of.parameters, opened))
    });
    let mut pieces: Vec<Piece> = charts.collect();
    if drawn < robots.len() {
        let rest = counted(robots.len() - drawn, "more robot");
        pieces.push(Piece::Text(format!("The numbers of {rest} are in the JSON of this page.")));
    }
    let title = "Trends".to_owned();
    (drawn > 0).then(|| Section { id: "trends".to_owned(), title, pieces })
}

/// The parameter whose trend of a robot is seen first: that of its first change, else that which is unlike the fleet's, else
/// that of the first change of the fleet, to compare with.
fn opened<'a>(of: &'a FleetReport, robot: &'a FleetRobot) -> Option<&'a str> {
    let of_change = |robot: &'a FleetRobot| robot.changes.first()?.parameter.as_deref();
    let unlike = || of.outliers.iter().find(|outlier| outlier.robot == robot.robot);
    of_change(robot)
        .or_else(|| Some(unlike()?.parameter.as_str()))
        .or_else(|| of.robots.iter().find_map(of_change))
}

fn scatter(of: &FleetReport) -> Section {
    let header = ["parameter", "unit", "between recordings"];
    let rows = of.parameters.iter().map(|parameter| {
        let name = parameter_name(&parameter.label);
        vec![name, parameter.unit.clone(), number(parameter.scatter, 3)]
    });
    let text = format!(
        "Standard deviation of each parameter between recordings of a robot that does not change, from {}; all errors and \
         thresholds include it.",
        counted(of.scatter_recordings, "recording")
    );
    let table = Grid::new("Scatter", &header, 2).with(rows.collect());
    Section::new("scatter", "Scatter between recordings", vec![text], vec![table])
}

/// Pages of single diagnoses that stand beside recordings.
fn pages(of: &FleetReport) -> Option<Section> {
    let links: Vec<(String, String)> = of
        .robots
        .iter()
        .flat_map(|robot| robot.recordings.iter().zip(&robot.pages))
        .filter_map(|(recording, page)| {
            let page = page.as_ref()?;
            // a path, never an address
            let is_rooted = page.starts_with('/');
            let path = if is_rooted { page.clone() } else { format!("./{page}") };
            Some((recording.clone(), path))
        })
        .collect();
    let (id, title) = ("diagnoses".to_owned(), "Single diagnoses".to_owned());
    (!links.is_empty()).then(|| Section { id, title, pieces: vec![Piece::Links(links)] })
}
