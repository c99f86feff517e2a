//! Figures for plotly.js from what is drawn. A colour `@name` is one of the page's, which knows whether
//! it is dark.

use armident_report::{FleetParameter, FleetRobot, effect_at, parameter_label};
use serde::Serialize;
use serde_json::{Value, json};

use crate::drawing::{
    Correlation, Drawing, DrawnQuantity, FindingRegion, FindingTraces, JointResidual, PlotSeries,
    RecordingRole, RecordingTraces, Skeleton,
};
use crate::finding::ACTS;

/// One figure with the views a reader chooses among.
#[derive(Debug, Clone)]
pub(crate) struct Figure {
    /// Element of the page.
    pub(crate) id: String,
    /// What it shows, above it.
    pub(crate) title: String,
    /// How to read it, below it and for screen readers.
    pub(crate) legend: String,
    /// Pixels.
    pub(crate) height: u32,
    /// What the page's script needs.
    pub(crate) content: Value,
}

/// Colours that mean a model: the given one, any between, the one found.
fn colour(model: usize, models: usize) -> &'static str {
    match model {
        0 => "@before",
        m if m + 1 == models => "@after",
        _ => "@between",
    }
}

/// Dashes distinguish the models without colours.
fn dash(model: usize, models: usize) -> &'static str {
    match model {
        0 => "solid",
        m if m + 1 == models => "solid",
        _ => "dot",
    }
}

/// Name of the recorded effort in legends.
const MEASURED: &str = "measured";
/// Recordings with a number below the axis of a trend, at most.
const MOST_TICKS: usize = 12;

fn axis(title: &str) -> Value {
    json!({ "title": { "text": title }, "automargin": true })
}

fn view(label: &str, data: Vec<Value>, layout: Value) -> Value {
    let mut view = json!({ "label": label });
    view["data"] = Value::Array(data);
    view["layout"] = layout;
    view
}

fn figure(id: String, title: String, legend: String, height: u32, views: Vec<Value>) -> Figure {
    let mut content = json!({});
    content["views"] = Value::Array(views);
    Figure { id, title, legend, height, content }
}

/// Effort and residual of a joint over time, recordings of one role after another.
pub(crate) fn efforts(
    drawing: &Drawing,
    joint: usize,
    role: RecordingRole,
    noise: Option<f64>,
) -> Option<Figure> {
    let recordings: Vec<&RecordingTraces> = drawing
        .recordings
        .iter()
        .filter(|r| r.role == role && r.joints.get(joint).is_some_and(|j| !j.measured.is_empty()))
        .collect();
    if recordings.is_empty() {
        return None;
    }
    let (unit, word) = (drawing.quantity.unit(drawing.joints.get(joint)?), drawing.quantity.word());
    let models = drawing.models.len();
    let mut data = Vec::new();
    let mut start = 0.0;
    let mut ends = Vec::new();
    for (k, recording) in recordings.iter().enumerate() {
        let traces = &recording.joints[joint];
        let line = |y: &[f64], name: &str, colour: &str, dash: &str, axis: &str, legend: bool| {
            // the recorded effort lies broad under the predictions
            let width = if name == MEASURED { 3.5 } else { 1.3 };
            json!({
                "type": "scatter", "mode": "lines", "name": name, "legendgroup": name,
                "showlegend": legend && k == 0, "x0": start, "dx": recording.step_s, "y": y,
                "xaxis": "x", "yaxis": axis,
                "line": { "color": colour, "dash": dash, "width": width },
                "hovertemplate": "%{y:.4g}"
            })
        };
        data.push(line(&traces.measured, MEASURED, "@measured", "solid", "y", true));
        for (m, name) in drawing.models.iter().enumerate() {
            let (colour, dash) = (colour(m, models), dash(m, models));
            data.push(line(&traces.predicted[m], name, colour, dash, "y", true));
            data.push(line(&traces.residual[m], name, colour, dash, "y2", false));
        }
        start += recording.duration_s;
        ends.push(start);
    }
    ends.pop();
    let mut shapes: Vec<Value> = ends
        .iter()
        .map(|t| {
            json!({ "type": "line", "x0": t, "x1": t, "y0": 0, "y1": 1, "yref": "paper",
                    "line": { "color": "@faint", "width": 1, "dash": "dot" } })
        })
        .collect();
    if let Some(noise) = noise.filter(|n| *n > 0.0) {
        shapes.push(json!({
            "type": "rect", "xref": "paper", "x0": 0, "x1": 1, "yref": "y2",
            "y0": -1.96 * noise, "y1": 1.96 * noise, "fillcolor": "@band", "line": { "width": 0 },
            "layer": "below"
        }));
    }
    let layout = json!({
        "hovermode": "x unified",
        "xaxis": { "title": { "text": "time [s]" }, "anchor": "y2", "automargin": true },
        "yaxis": { "title": { "text": format!("{word} [{unit}]") }, "domain": [0.44, 1], "automargin": true },
        "yaxis2": { "title": { "text": format!("residual [{unit}]") }, "domain": [0, 0.38],
                    "automargin": true, "zeroline": true },
        "shapes": shapes,
    });
    let (role_name, slug) = match role {
        RecordingRole::Training => ("Training", "training"),
        RecordingRole::Holdout => ("Hold-out", "holdout"),
    };
    let reduced = recordings.iter().map(|r| r.samples_per_pair).max().unwrap_or(1);
    let mut legend = format!(
        "Top: {word}. Bottom: residual (measured minus predicted){}. Drag to zoom, double click to go back.",
        if noise.is_some() { "; band: \u{b1}1.96 noise levels" } else { "" }
    );
    if recordings.len() > 1 {
        legend += &format!(" {} recordings, one after another.", recordings.len());
    }
    if reduced > 1 {
        legend += &format!(" Minimum and maximum of every {reduced} samples, so that peaks stay.");
    }
    Some(figure(
        format!("efforts-{slug}-{joint}"),
        format!("{role_name}: {word} over time"),
        legend,
        420,
        vec![view("", data, layout)],
    ))
}

/// Heat maps of where residuals lie.
pub(crate) fn maps<'a>(
    drawing: &'a Drawing,
    joint: usize,
    of: &'a JointResidual,
) -> Option<Figure> {
    let name = drawing.joints.get(joint)?;
    let unit = drawing.quantity.unit(name);
    let mut views = Vec::new();
    // where each finding acts
    let marks = |of: fn(&FindingRegion) -> &Vec<[f64; 4]>| -> Vec<&'a [[f64; 4]]> {
        let of_finding = |finding: &'a FindingTraces| {
            let region = finding.regions.iter().find(|r| r.joint == joint);
            region.map_or(&[][..], |r| of(r))
        };
        drawing.findings.iter().map(of_finding).collect()
    };
    let kinds = [
        (
            "speed and position",
            &of.speed_position,
            marks(|r| &r.speed_position),
            format!("position [{}]", name.position_unit),
            json!({ "title": { "text": format!("speed [{}/s]", name.position_unit) }, "automargin": true }),
        ),
        (
            "load and direction",
            &of.load_direction,
            marks(|r| &r.load_direction),
            format!("predicted effort [{}]", name.effort_unit),
            json!({ "title": { "text": "direction" }, "automargin": true, "tickmode": "array",
                    "tickvals": [-1, 0, 1], "ticktext": ["backward", "at rest", "forward"] }),
        ),
    ];
    for (kind, map, marks, x, y) in kinds {
        let one = |label: &str, z: &Vec<Vec<Option<f64>>>, most: f64| {
            let data = json!({
                "type": "heatmap", "x": map.x, "y": map.y, "z": z, "zmin": -most, "zmax": most,
                "colorscale": [[0, "#0072B2"], [0.5, "@middle"], [1, "#D55E00"]],
                "colorbar": { "title": { "text": unit, "side": "right" }, "thickness": 12 },
                "hovertemplate": format!("{x} %{{x:.3g}}<br>%{{y}}<br>residual %{{z:.3g}} {unit}<extra></extra>"),
                "hoverongaps": false
            });
            let layout = json!({ "xaxis": axis(&x), "yaxis": y, "hovermode": "closest" });
            let mut view = view(&format!("{kind}, {label}"), vec![data], layout);
            view["marks"] = json!(marks);
            view
        };
        // all models on one scale: what became better is seen; and the last on its own: what is left
        let largest = |z: &Vec<Vec<Option<f64>>>| {
            z.iter().flatten().flatten().fold(0.0_f64, |m, v| m.max(v.abs()))
        };
        let most = map.values.iter().map(largest).fold(0.0, f64::max);
        for (m, (model, z)) in drawing.models.iter().zip(&map.values).enumerate().rev() {
            let mut view = one(model, z, most);
            // what a finding explains is in the residual of the given model
            view["given"] = json!(m == 0);
            views.push(view);
        }
        if let (Some(model), Some(z)) = (drawing.models.last(), map.values.last())
            && largest(z) < 0.5 * most
        {
            views.push(one(&format!("{model}, own colour scale"), z, largest(z)));
        }
    }
    (!views.is_empty()).then(|| {
        figure(
            format!("maps-{joint}"),
            "Residual map".to_owned(),
            "Mean residual per cell, training recordings; one colour scale for all models. A finding shown in \
             the arm frames the cells in which it acts."
                .to_owned(),
            300,
            views,
        )
    })
}

/// Residuals by frequency, by order, by lag.
pub(crate) fn spectra(drawing: &Drawing, joint: usize, of: &JointResidual) -> Option<Figure> {
    let name = drawing.joints.get(joint)?;
    let unit = drawing.quantity.unit(name);
    let orders = if name.position_unit == "m" { "cycles per metre" } else { "cycles per turn" };
    let kinds = [
        (
            "by frequency",
            &of.spectrum,
            json!({ "xaxis": axis("frequency [Hz]"),
                    "yaxis": { "title": { "text": format!("{unit}/sqrt(Hz)") }, "type": "log", "automargin": true } }),
        ),
        (
            "by order in position",
            &of.orders,
            json!({ "xaxis": axis(orders), "yaxis": axis(&format!("amplitude [{unit}]")) }),
        ),
        (
            "autocorrelation",
            &of.autocorrelation,
            json!({ "xaxis": axis("lag [s]"), "yaxis": axis("correlation"),
                    "shapes": [{ "type": "rect", "xref": "paper", "x0": 0, "x1": 1,
                                 "y0": -of.white_bound, "y1": of.white_bound, "fillcolor": "@band",
                                 "line": { "width": 0 }, "layer": "below" }] }),
        ),
    ];
    let views: Vec<Value> = kinds
        .into_iter()
        .filter(|(_, series, _)| !series.x.is_empty())
        .map(|(label, series, layout)| view(label, lines(drawing, series), hovering(layout)))
        .collect();
    (!views.is_empty()).then(|| {
        figure(
            format!("spectra-{joint}"),
            "Spectrum and whiteness of the residual".to_owned(),
            "Lines at one frequency are resonances or interference; lines at one order in position are \
             ripple. The autocorrelation of white noise stays inside the band."
                .to_owned(),
            300,
            views,
        )
    })
}

fn hovering(mut layout: Value) -> Value {
    layout["hovermode"] = json!("x unified");
    layout
}

fn lines(drawing: &Drawing, series: &PlotSeries) -> Vec<Value> {
    let models = drawing.models.len();
    (drawing.models.iter().zip(&series.values).enumerate())
        .map(|(m, (name, y))| {
            json!({
                "type": "scatter", "mode": "lines", "name": name, "x": series.x, "y": y,
                "line": { "color": colour(m, models), "dash": dash(m, models), "width": 1.3 },
                "hovertemplate": "%{y:.3g}"
            })
        })
        .collect()
}

/// Root mean square residuals of all joints over time, in standard deviations of each joint's effort.
pub(crate) fn over_time(drawing: &Drawing) -> Option<Figure> {
    let x = &drawing.residuals.iter().find(|r| !r.time.x.is_empty())?.time.x;
    let names: Vec<&str> = drawing.joints.iter().map(|j| j.name.as_str()).collect();
    let rows = |m: usize| -> Vec<Vec<Option<f64>>> {
        drawing
            .residuals
            .iter()
            .map(|r| {
                let row = r.time.values.first().and_then(|rows| rows.get(m));
                let percent = |v: f64| (1e4 * v / r.effort_deviation).round() / 1e2;
                row.map_or_else(Vec::new, |row| {
                    row.iter().map(|v| v.map(percent).filter(|p| p.is_finite())).collect()
                })
            })
            .collect()
    };
    let views = (0..drawing.models.len())
        .rev()
        .map(|m| {
            let data = json!({
                "type": "heatmap", "x": x, "y": names, "z": rows(m), "colorscale": "Cividis", "zmin": 0,
                "colorbar": { "title": { "text": "%", "side": "right" }, "thickness": 12 },
                "hovertemplate": "%{y}<br>%{x:.3g} s<br>%{z:.3g} % of its size<extra></extra>"
            });
            let layout = json!({
                "xaxis": axis("time [s]"), "hovermode": "closest",
                "yaxis": { "automargin": true, "autorange": "reversed" }
            });
            view(&drawing.models[m], vec![data], layout)
        })
        .collect();
    Some(figure(
        "over-time".to_owned(),
        "Residual over time".to_owned(),
        format!(
            "RMS residual of each joint over the training recordings, relative to the standard deviation of its {}.",
            drawing.quantity.word()
        ),
        90 + 30 * names.len() as u32,
        views,
    ))
}

/// What a finding explains.
pub(crate) fn finding(drawing: &Drawing, index: usize, of: &FindingTraces) -> Option<Figure> {
    let views: Vec<Value> = of
        .views
        .iter()
        .map(|v| {
            let unit = drawing.joints.get(v.joint).map_or("", |j| j.effort_unit.as_str());
            let (mut x, mut low, mut high) = (Vec::new(), Vec::new(), Vec::new());
            for (at, ends) in v.x.iter().zip(&v.spread) {
                if let Some([a, b]) = ends {
                    x.push(*at);
                    low.push(*a);
                    high.push(*b);
                }
            }
            x.extend(x.clone().into_iter().rev());
            high.extend(low.into_iter().rev());
            let line = |y: &[Option<f64>], name: &str, colour: &str, dash: &str| {
                json!({
                    "type": "scatter", "mode": "lines+markers", "name": name, "x": v.x, "y": y,
                    "line": { "color": colour, "dash": dash, "width": 1.8 }, "marker": { "size": 4 },
                    "connectgaps": false, "hovertemplate": "%{y:.3g}"
                })
            };
            let data = vec![
                json!({
                    "type": "scatter", "mode": "lines", "x": x, "y": high, "fill": "toself",
                    "fillcolor": "@spread", "line": { "width": 0, "color": "@before" },
                    "name": "80 % of the samples", "hoverinfo": "skip"
                }),
                line(&v.without, "residual without", "@before", "solid"),
                line(&v.law, "fitted law", "@between", "dash"),
                line(&v.with, "residual with", "@after", "solid"),
            ];
            let layout = json!({
                "hovermode": "x unified", "xaxis": axis(&v.over),
                "yaxis": { "title": { "text": format!("mean residual [{unit}]") }, "automargin": true,
                           "zeroline": true }
            });
            view(&v.over, data, layout)
        })
        .collect();
    (!views.is_empty()).then(|| {
        figure(
            format!("finding-{index}"),
            "Residual and fitted law".to_owned(),
            "Residual without this finding (points) and the fitted law (line). With the finding included \
             the residual should be flat. The other views check for dependence on other variables."
                .to_owned(),
            320,
            views,
        )
    })
}

/// What a finding lights in the arm.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(crate) struct LitFinding {
    /// The finding, with its place.
    pub(crate) title: String,
    /// Joints, from 0.
    pub(crate) joints: Vec<usize>,
    /// Links, by the joints that move them, from 0.
    pub(crate) links: Vec<usize>,
    /// What its law depends on.
    pub(crate) regime: String,
    /// Intervals of the recordings in which it acts \[s\].
    pub(crate) acts_s: Vec<[f64; 2]>,
    /// Where its effort is largest \[s\].
    pub(crate) strongest_s: Option<f64>,
}

impl LitFinding {
    /// With what the recordings show of a finding.
    pub(crate) fn with(self, traces: &FindingTraces) -> Self {
        let regime = traces.views.first().map_or_else(String::new, |view| view.over.clone());
        let over_time = traces.views.iter().find(|view| view.over.starts_with("time in"));
        let Some(view) = over_time else { return Self { regime, ..self } };
        let size = |k: usize| view.law.get(k).copied().flatten().map_or(0.0, f64::abs);
        let largest = (0..view.x.len()).map(size).fold(0.0, f64::max);
        let strongest = (0..view.x.len()).max_by(|a, b| size(*a).total_cmp(&size(*b)));
        let half = match view.x[..] {
            [first, second, ..] => 0.5 * (second - first),
            _ => 0.0,
        };
        let mut acts_s: Vec<[f64; 2]> = Vec::new();
        for (k, x) in view.x.iter().enumerate().filter(|(k, _)| size(*k) > ACTS * largest) {
            match acts_s.last_mut().filter(|last| k > 0 && x - half - last[1] < half) {
                Some(last) => last[1] = x + half,
                None => acts_s.push([x - half, x + half]),
            }
        }
        let strongest_s = strongest.filter(|_| largest > 0.0).map(|k| view.x[k]);
        Self { regime, acts_s, strongest_s, ..self }
    }
}

/// The arm in motion; drawn by the page's script, which projects the points.
pub(crate) fn skeleton(
    drawing: &Drawing,
    of: &Skeleton,
    blamed_joints: &[usize],
    blamed_links: &[usize],
    findings: &[LitFinding],
) -> Figure {
    let share = |m: usize| -> Vec<Option<f64>> {
        drawing
            .residuals
            .iter()
            .map(|r| {
                let share = r.rms.get(m)? / r.effort_deviation;
                share.is_finite().then(|| (1e4 * share).round() / 1e4)
            })
            .collect()
    };
    let shares: Vec<Value> = drawing
        .models
        .iter()
        .enumerate()
        .map(|(m, name)| json!({ "label": name, "share": share(m) }))
        .collect();
    let marked = if blamed_joints.is_empty() && blamed_links.is_empty() {
        String::new()
    } else {
        " Rings: joints with findings. Orange: links with findings.".to_owned()
    };
    Figure {
        id: "skeleton".to_owned(),
        title: "Arm in the recorded motion".to_owned(),
        legend: format!(
            "Joints as in the URDF, coloured by the residual relative to their effort.{marked} Recording: {}.",
            of.source
        ),
        height: 520,
        content: json!({
            "skeleton": {
                "time_s": of.time_s, "points_m": of.points_m, "shares": shares,
                "joints": drawing.joints.iter().map(|j| j.name.as_str()).collect::<Vec<_>>(),
                "links": drawing.joints.iter().map(|j| j.link.as_str()).collect::<Vec<_>>(),
                "blamed_joints": blamed_joints, "blamed_links": blamed_links,
                "findings": findings,
            }
        }),
    }
}

/// Which estimates are identified only jointly.
pub(crate) fn correlation(of: &Correlation) -> Figure {
    let data = json!({
        "type": "heatmap", "x": of.labels, "y": of.labels, "z": of.rows, "zmin": -1, "zmax": 1,
        "colorscale": [[0, "#0072B2"], [0.5, "@middle"], [1, "#D55E00"]],
        "colorbar": { "thickness": 12 }, "hoverongaps": false,
        "hovertemplate": "%{x}<br>%{y}<br>%{z:.2f}<extra></extra>"
    });
    let layout = json!({
        "hovermode": "closest",
        "xaxis": { "automargin": true, "tickangle": -90, "tickfont": { "size": 9 } },
        "yaxis": { "automargin": true, "autorange": "reversed", "tickfont": { "size": 9 } }
    });
    figure(
        "correlation".to_owned(),
        "Correlation of the estimates".to_owned(),
        "Pairs near 1 or -1 are identified only jointly.".to_owned(),
        (180 + 11 * of.labels.len() as u32).clamp(320, 900),
        vec![view("", vec![data], layout)],
    )
}

/// Estimates with their intervals against the robot description, in standard errors.
pub(crate) fn intervals(rows: &[(String, f64, f64)]) -> Option<Figure> {
    if rows.is_empty() {
        return None;
    }
    let labels: Vec<&str> = rows.iter().map(|r| r.0.as_str()).collect();
    let deviations: Vec<f64> = rows.iter().map(|r| ((r.1 / r.2) * 100.0).round() / 100.0).collect();
    let data = json!({
        "type": "bar", "orientation": "h", "y": labels, "x": deviations,
        "marker": { "color": "@after" }, "hovertemplate": "%{y}<br>%{x:.1f} standard errors<extra></extra>"
    });
    let layout = json!({
        "hovermode": "closest", "showlegend": false,
        "xaxis": axis("(est-URDF)/se"),
        "yaxis": { "automargin": true, "autorange": "reversed", "tickfont": { "size": 10 } },
        "shapes": [{ "type": "rect", "yref": "paper", "y0": 0, "y1": 1, "x0": -1.96, "x1": 1.96,
                     "fillcolor": "@band", "line": { "width": 0 }, "layer": "below" }]
    });
    Some(figure(
        "intervals".to_owned(),
        "Estimates relative to the URDF".to_owned(),
        "Inside the band, the estimate agrees with the URDF (95 %).".to_owned(),
        (140 + 15 * rows.len() as u32).clamp(220, 1200),
        vec![view("", vec![data], layout)],
    ))
}

/// Parameters of a robot over its recordings, one view each, with its changes.
pub(crate) fn fleet_trend(
    index: usize,
    robot: &FleetRobot,
    parameters: &[FleetParameter],
    opened: Option<&str>,
) -> Figure {
    // friction before constants of the links
    let mut order: Vec<usize> = (0..parameters.len())
        .filter(|&k| robot.trends[k].points.iter().any(Option::is_some))
        .collect();
    order.sort_by_key(|&k| parameters[k].is_constant);
    let first = opened.and_then(|label| order.iter().position(|&k| parameters[k].label == label));
    let shapes: Vec<Value> = (robot.changes.iter())
        .map(|change| {
            let x = change.number as f64 - 0.5;
            json!({ "type": "line", "x0": x, "x1": x, "y0": 0, "y1": 1, "yref": "paper",
                    "line": { "color": "@before", "width": 1.5, "dash": "dot" } })
        })
        .collect();
    let between_ticks = robot.recordings.len().div_ceil(MOST_TICKS).max(1);
    let views = order
        .into_iter()
        .map(|k| {
            let points = || robot.trends[k].points.iter();
            let of = |at: usize| points().map(move |point| point.map(|point| point[at]));
            let values: Vec<Option<f64>> = of(0).collect();
            let halves: Vec<Option<f64>> = of(1).map(|error| error.map(|e| 1.96 * e)).collect();
            let numbers: Vec<usize> = (1..=values.len()).collect();
            let data = json!({
                "type": "scatter", "mode": "markers", "x": numbers, "y": values,
                "text": robot.recordings, "marker": { "color": "@after" },
                "error_y": { "type": "data", "array": halves, "thickness": 1 },
                "hovertemplate": "%{text}<br>%{y:.4g}<extra></extra>"
            });
            let name = parameter_name(&parameters[k].label);
            // above the axis: beside it there is no room for a name
            let title = json!({
                "text": format!("{name} [{}]", parameters[k].unit), "font": { "size": 12 },
                "x": 0.005, "xref": "container", "xanchor": "left",
                "y": 1, "yref": "paper", "yanchor": "bottom", "pad": { "b": 8 }
            });
            let mut recordings = axis("recording");
            recordings["tick0"] = json!(1);
            recordings["dtick"] = json!(between_ticks);
            let layout = json!({
                "hovermode": "closest", "showlegend": false, "title": title, "xaxis": recordings,
                "yaxis": { "automargin": true }, "shapes": shapes
            });
            view(&name, vec![data], layout)
        })
        .collect();
    let mut legend = "Value of each recording with its 95 % interval, scatter included.".to_owned();
    if !robot.changes.is_empty() {
        legend += " Dotted: changes.";
    }
    let mut figure = figure(format!("trend-{index}"), robot.robot.clone(), legend, 320, views);
    figure.content["first"] = json!(first.unwrap_or(0));
    figure
}

/// A parameter by its label, in words: `viscous friction on elbow` for `viscous_friction(elbow)`; constants keep theirs.
pub(crate) fn parameter_name(label: &str) -> String {
    let Some((what, joint)) = label.strip_suffix(')').and_then(|label| label.split_once('('))
    else {
        return label.to_owned();
    };
    let (slug, number) = what.split_once('.').unwrap_or((what, ""));
    let joints = [joint.to_owned()];
    let name = effect_at(slug, &joints, None);
    if number.is_empty() { name } else { format!("{name}, {}", parameter_label(number)) }
}

/// Errors of all joints, one group of bars a joint.
pub(crate) fn errors(
    joints: &[String],
    models: &[(String, Vec<Option<f64>>)],
    quantity: DrawnQuantity,
) -> Option<Figure> {
    let unit = match quantity {
        DrawnQuantity::Effort => "N m or N",
        DrawnQuantity::Position => "rad or m",
    };
    let data: Vec<Value> = models
        .iter()
        .enumerate()
        .map(|(m, (name, values))| {
            json!({
                "type": "bar", "name": name, "x": joints, "y": values,
                "marker": { "color": colour(m, models.len()) }, "hovertemplate": "%{y:.3g}"
            })
        })
        .collect();
    let layout = json!({
        "hovermode": "x unified", "barmode": "group",
        "xaxis": { "automargin": true },
        "yaxis": { "title": { "text": format!("RMS error [{unit}]") }, "type": "log", "automargin": true }
    });
    (!data.is_empty() && !joints.is_empty()).then(|| {
        figure(
            "errors".to_owned(),
            "Effort error by joint".to_owned(),
            "Logarithmic scale.".to_owned(),
            300,
            vec![view("", data, layout)],
        )
    })
}

/// Share of a joint's residual that single variables and functions of the motion explain.
pub(crate) fn regressors(joint: usize, rows: &[(String, f64, f64)], about: &str) -> Option<Figure> {
    if rows.is_empty() {
        return None;
    }
    let names: Vec<&str> = rows.iter().map(|r| r.0.as_str()).collect();
    let bars = |name: &str, colour: &str, of: fn(&(String, f64, f64)) -> f64| {
        let shares: Vec<f64> = rows.iter().map(|r| (1000.0 * of(r)).round() / 10.0).collect();
        json!({
            "type": "bar", "orientation": "h", "name": name, "y": names, "x": shares,
            "marker": { "color": colour }, "hovertemplate": "%{x:.1f} %"
        })
    };
    let data = vec![bars("given", "@before", |r| r.1), bars("diagnosed", "@after", |r| r.2)];
    let layout = json!({
        "hovermode": "y unified", "barmode": "group",
        "xaxis": { "title": { "text": "share of the residual's variance [%]" }, "automargin": true,
                   "rangemode": "tozero" },
        "yaxis": { "automargin": true, "autorange": "reversed" }
    });
    Some(figure(
        format!("regressors-{joint}"),
        "Regressors of the residual".to_owned(),
        about.trim().to_owned(),
        110 + 26 * rows.len() as u32,
        vec![view("", data, layout)],
    ))
}

/// Findings of like confidence.
pub(crate) struct Reliability {
    /// Mean confidence.
    pub(crate) confidence: f64,
    /// Share that is right.
    pub(crate) right: f64,
    /// 95 % interval of the share.
    pub(crate) interval: [f64; 2],
    /// Findings.
    pub(crate) count: usize,
}

/// Share of right findings against the confidence they were given.
pub(crate) fn reliability(bins: &[Reliability]) -> Option<Figure> {
    if bins.is_empty() {
        return None;
    }
    let of = |value: fn(&Reliability) -> f64| -> Vec<f64> { bins.iter().map(value).collect() };
    let counts: Vec<String> = bins.iter().map(|b| format!("{} findings", b.count)).collect();
    let data = vec![
        json!({
            "type": "scatter", "mode": "lines", "x": [0, 1], "y": [0, 1], "name": "ideal",
            "line": { "color": "@faint", "dash": "dot", "width": 1.5 }, "hoverinfo": "skip"
        }),
        json!({
            "type": "scatter", "mode": "markers", "name": "found", "x": of(|b| b.confidence),
            "y": of(|b| b.right), "text": counts, "marker": { "color": "@after", "size": 9 },
            "error_y": { "type": "data", "symmetric": false, "color": "@after", "thickness": 1.5,
                         "array": of(|b| b.interval[1] - b.right),
                         "arrayminus": of(|b| b.right - b.interval[0]) },
            "hovertemplate": "confidence %{x:.2f}<br>correct %{y:.2f}<br>%{text}<extra></extra>"
        }),
    ];
    let layout = json!({
        "hovermode": "closest", "hoverdistance": -1,
        "xaxis": { "title": { "text": "confidence" }, "range": [0, 1.03], "automargin": true },
        "yaxis": { "title": { "text": "share correct" }, "range": [0, 1.05], "automargin": true },
    });
    Some(figure(
        "reliability".to_owned(),
        "Calibration of the confidence".to_owned(),
        "Share of correct findings by confidence, with 95 % intervals. On the dotted line the two are \
         equal."
            .to_owned(),
        320,
        vec![view("", data, layout)],
    ))
}

/// Hidden effects (rows) against reported ones (columns), by counts.
pub(crate) fn confusion(
    table: &std::collections::BTreeMap<String, std::collections::BTreeMap<String, usize>>,
) -> Option<Figure> {
    if table.is_empty() {
        return None;
    }
    // the same order both ways, so that what is right stands on the diagonal
    let mut names: Vec<&String> = table
        .iter()
        .flat_map(|(truth, named)| std::iter::once(truth).chain(named.keys()))
        .collect();
    names.sort_by_key(|name| (name.as_str() == "nothing", name.as_str()));
    names.dedup();
    let rows: Vec<&String> =
        names.iter().copied().filter(|name| table.contains_key(*name)).collect();
    let columns: Vec<&String> = names
        .into_iter()
        .filter(|name| table.values().any(|row| row.contains_key(*name)))
        .collect();
    let z: Vec<Vec<Option<usize>>> = rows
        .iter()
        .map(|row| columns.iter().map(|column| table[*row].get(*column).copied()).collect())
        .collect();
    let most = z.iter().flatten().flatten().copied().max().unwrap_or(1);
    let data = json!({
        "type": "heatmap", "x": columns, "y": rows, "z": z, "showscale": false, "zmin": 0, "zmax": most,
        "colorscale": [[0, "@middle"], [1, "#0072B2"]], "xgap": 2, "ygap": 2, "hoverongaps": false,
        "texttemplate": "%{z}",
        "hovertemplate": "hidden: %{y}<br>reported: %{x}<br>%{z} times<extra></extra>"
    });
    let layout = json!({
        "hovermode": "closest",
        "xaxis": { "title": { "text": "reported" }, "automargin": true, "tickangle": -40,
                   "tickfont": { "size": 10 }, "type": "category" },
        "yaxis": { "title": { "text": "hidden" }, "automargin": true, "autorange": "reversed",
                   "tickfont": { "size": 10 }, "type": "category" }
    });
    Some(figure(
        "confusion".to_owned(),
        "Confusion of effects".to_owned(),
        "Rows: hidden effects, columns: reported effects. The column `nothing` holds misses, the row `nothing` \
         false positives."
            .to_owned(),
        (200 + 22 * rows.len() as u32).clamp(300, 900),
        vec![view("", vec![data], layout)],
    ))
}

/// Errors over their floors: what is compared, kind of case, effect, where, ratio.
pub(crate) fn over_floors(ratios: &[(&'static str, &str, String, String, f64)]) -> Option<Figure> {
    let mut views = Vec::new();
    for what in ["hold-out / reachable", "prediction / noise"] {
        let mut data = Vec::new();
        for (kind, colour) in [("clean", "@after"), ("field", "@before"), ("change", "@rigid")] {
            let of: Vec<_> = ratios.iter().filter(|r| r.0 == what && r.1 == kind).collect();
            if of.is_empty() {
                continue;
            }
            let x: Vec<f64> = of.iter().map(|r| (r.4 * 1000.0).round() / 1000.0).collect();
            let y: Vec<&str> = of.iter().map(|r| r.2.as_str()).collect();
            let text: Vec<&str> = of.iter().map(|r| r.3.as_str()).collect();
            data.push(json!({
                "type": "box", "orientation": "h", "name": kind, "x": x, "y": y, "text": text,
                "boxpoints": "all", "jitter": 0.5, "pointpos": 0, "marker": { "color": colour, "size": 4 },
                "line": { "width": 1 }, "hoveron": "points",
                "hovertemplate": "%{text}<br>%{x:.3f}<extra></extra>"
            }));
        }
        if data.is_empty() {
            continue;
        }
        let layout = json!({
            "hovermode": "closest", "boxmode": "group",
            "xaxis": { "title": { "text": what }, "type": "log", "automargin": true },
            "yaxis": { "automargin": true, "autorange": "reversed", "tickfont": { "size": 10 } },
            "shapes": [{ "type": "line", "yref": "paper", "y0": 0, "y1": 1, "x0": 1, "x1": 1,
                         "line": { "color": "@faint", "width": 1, "dash": "dot" } }]
        });
        views.push(view(what, data, layout));
    }
    let mut effects: Vec<&str> = ratios.iter().map(|r| r.2.as_str()).collect();
    effects.sort_unstable();
    effects.dedup();
    (!views.is_empty()).then(|| {
        figure(
            "floors".to_owned(),
            "Errors over their floors".to_owned(),
            "One point per joint and case. At 1, the hold-out error equals that of the true laws fitted to the same \
             recordings (or the sensor noise alone)."
                .to_owned(),
            (160 + 34 * effects.len() as u32).clamp(260, 1100),
            views,
        )
    })
}
