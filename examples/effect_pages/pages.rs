//! A page an effect: what `crates/effects` says of it, sizes that were published, and what it does to the
//! efforts of a simulated UR5.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

use armident_effects::{Admissible, Effect, EffectOnJoint, LIBRARY, Law, Scope, effect};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_motion::{Motion, MotionSettings};
use armident_recording::{JointChannels, Recording, read_csv};
use armident_simulation::{SimulatedArm, Trajectory, inverse};
use plotters::prelude::*;
use serde::Deserialize;

/// Joint that carries an effect of one joint.
const ELBOW: usize = 2;
/// Points of a picture: more say nothing more.
const POINTS: usize = 300;
const SIZE: (u32, u32) = (760, 280);
/// Colour-blind safe (Okabe and Ito).
const COLOURS: [RGBColor; 3] = [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115)];
const GREY: RGBColor = RGBColor(110, 110, 110);

/// What is written by hand of an effect, in `docs/book/effects.toml`.
#[derive(Deserialize)]
struct Prose {
    /// What it is, in a sentence or two.
    about: String,
    /// Sizes that were published, each with its source.
    sizes: Vec<String>,
    /// How to look at it.
    see: String,
    /// Joint of the picture, and of the command.
    #[serde(default)]
    joint: String,
    /// The second of two neighbours.
    other_joint: Option<String>,
    /// Parameters of the picture.
    parameters: Vec<f64>,
    /// Seconds of a contact.
    window_s: Option<[f64; 2]>,
    /// What its effort is drawn against.
    against: Against,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
enum Against {
    Speed,
    Position,
    Acceleration,
    Load,
    Time,
}

/// Path below `docs/book/src` and content of every file.
pub(crate) fn pages() -> Result<BTreeMap<String, String>, Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let prose: BTreeMap<String, Prose> =
        toml::from_str(&std::fs::read_to_string(root.join("docs/book/effects.toml"))?)?;
    let arm = Arm::load(root)?;
    let mut files = BTreeMap::new();
    let mut table = String::from(INDEX);
    for effect in LIBRARY {
        let law = effect.law();
        let prose =
            prose.get(law.slug).ok_or_else(|| format!("effects.toml has no [{}]", law.slug))?;
        files.insert(format!("effects/{}.svg", law.slug), arm.picture(*effect, prose)?);
        files.insert(format!("effects/{}.md", law.slug), page(law, prose));
        let _ = writeln!(
            table,
            "| [{}]({}.md) | `{}` | {} |",
            law.title,
            law.slug,
            law.formula.replace('|', "\\|"),
            acts_on(law.scope)
        );
    }
    files.insert("effects/index.md".to_owned(), table);
    Ok(files)
}

const INDEX: &str = "\
# The catalogue of effects

What `diagnose` can name, `simulate` can conceal and `identify` can fit, one page each. The pages are written
by `cargo run --release --example effect_pages` from the laws themselves (`crates/effects`) and a short text
beside them; the pictures are what each does to the efforts of the bundled UR5 in its bundled motion.

Efforts are what the motor supplies: `effort = rigid(q, dq, ddq) + f`. `v` is the joint's velocity.

| effect | law | acts on |
| --- | --- | --- |
";

fn acts_on(scope: Scope) -> &'static str {
    match scope {
        Scope::Joint => "one joint",
        Scope::Neighbours => "two neighbouring joints",
        Scope::ThroughJoint => "one joint, felt by all",
        Scope::Link => "one link, felt by the joints before it",
        Scope::Arm => "the whole arm",
    }
}

fn page(law: &Law, prose: &Prose) -> String {
    let mut text = format!("# {}\n\n{}\n\n", capital(law.title), prose.about.trim());
    let _ = writeln!(text, "```text\n{}\n```\n", law.formula);
    let _ = writeln!(
        text,
        "Name in files and commands: `{}`. Acts on {}.\n",
        law.slug,
        acts_on(law.scope)
    );
    text += "| parameter | unit, rotational | unit, translational | sign |\n| --- | --- | --- | --- |\n";
    for p in law.parameters {
        let sign = match p.admissible {
            Admissible::Any => "any",
            Admissible::NonNegative => "zero or more",
        };
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {sign} |",
            p.name, p.unit_rotational, p.unit_translational
        );
    }
    let _ = writeln!(
        text,
        "\n## Signature\n\n![{}: its effort]({}.svg)\n\n{}\n",
        law.title,
        law.slug,
        prose.see.trim()
    );
    // the command line has no place for a time window and for a second joint
    if prose.window_s.is_none() && prose.other_joint.is_none() {
        let joint = &prose.joint;
        let numbers: Vec<String> = prose.parameters.iter().map(ToString::to_string).collect();
        let _ = writeln!(
            text,
            "The same in a recording, to try things on:\n\n```console\n$ armident simulate urdf/ur5.urdf \
             examples/ur5/train.csv -o with.csv --effect {}:{joint}={} -q\nur5: 1 recording of 1200 samples in all, written to with.csv\n\n```\n",
            law.slug,
            numbers.join(",")
        );
    }
    text += "## Typical sizes\n\n";
    for size in &prose.sizes {
        let _ = writeln!(text, "* {}", size.trim());
    }
    text += "\n## What it is taken for, and how to tell\n\n| it may be | told apart by |\n| --- | --- |\n";
    for other in law.look_alikes {
        let name = match effect(other.slug) {
            Some(e) => format!("[{}]({}.md)", e.law().title, other.slug),
            None => other.slug.replace('_', " "),
        };
        let _ = writeln!(text, "| {name} | {} |", other.separated_by);
    }
    if !law.contains.is_empty() {
        let names: Vec<String> =
            law.contains.iter().map(|slug| format!("[{slug}]({slug}.md)")).collect();
        let _ = writeln!(
            text,
            "\nIt contains {}: its own name is given only where it beats that.",
            names.join(", ")
        );
    }
    let held = match (law.export.urdf, law.export.mjcf) {
        (None, None) => {
            "Neither URDF nor MJCF has a place for it: `export` says that it is lost.".to_owned()
        }
        (urdf, mjcf) => {
            let place = |format: &str, attribute: Option<&str>| {
                attribute
                    .map_or_else(|| format!("lost in {format}"), |a| format!("`{a}` in {format}"))
            };
            format!("`export` writes it as {} and {}.", place("URDF", urdf), place("MJCF", mjcf))
                .replace("as lost in URDF and ", "only as ")
        }
    };
    let _ = writeln!(text, "\n## In other formats\n\n{held}");
    text
}

fn capital(title: &str) -> String {
    let mut letters = title.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The bundled UR5 in its bundled motion.
struct Arm {
    chain: DrivingAxisChain,
    trajectory: Trajectory,
    motion: Motion,
    rigid: Vec<Vec<f64>>,
}

impl Arm {
    fn load(root: &Path) -> Result<Self, Box<dyn Error>> {
        let robot = load_urdf(&root.join("urdf/ur5.urdf"))?;
        let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
        let chain = DrivingAxisChain::from_chain(&chain);
        let joints = chain.joint_names();
        let recording = read_csv(root.join("examples/ur5/train.csv"))?;
        let motion = Motion::from_recording(&recording, &joints, &MotionSettings::default())?;
        let channels = joints
            .iter()
            .enumerate()
            .map(|(j, name)| JointChannels {
                position: Some(motion.position[j].clone()),
                velocity: Some(motion.velocity[j].clone()),
                acceleration: Some(motion.acceleration[j].clone()),
                ..JointChannels::new(*name)
            })
            .collect();
        let smooth = Recording::new("motion", motion.time_s.clone(), channels)?;
        let names: Vec<String> = joints.iter().map(ToString::to_string).collect();
        let trajectory = Trajectory::from_recording(&smooth, &names, &BTreeMap::new())?;
        let rigid = efforts(&inverse(&SimulatedArm::on_chain(&chain, &[])?, &trajectory)?);
        Ok(Self { trajectory, motion, rigid, chain })
    }

    /// The effort that an effect adds: against its variable on the joint that has most of it, and over time
    /// on the three that have most.
    fn picture(&self, effect: &dyn Effect, prose: &Prose) -> Result<String, Box<dyn Error>> {
        let law = effect.law();
        let mut on_joint = EffectOnJoint::new(law.slug, &prose.joint, prose.parameters.clone());
        on_joint.window_s = prose.window_s;
        on_joint.other_joint.clone_from(&prose.other_joint);
        let arm = SimulatedArm::on_chain(&self.chain, &[on_joint])?;
        let with = efforts(&inverse(&arm, &self.trajectory)?);
        let added: Vec<Vec<f64>> = with
            .iter()
            .zip(&self.rigid)
            .map(|(with, without)| with.iter().zip(without).map(|(a, b)| a - b).collect())
            .collect();
        let mut order: Vec<usize> = (0..added.len()).collect();
        let size = |j: usize| added[j].iter().map(|x| x * x).sum::<f64>();
        order.sort_by(|a, b| size(*b).total_cmp(&size(*a)));
        let most = match law.scope {
            Scope::Joint => ELBOW,
            _ => order[0],
        };
        let name = |j: usize| self.chain.joints[j].name.replace('_', " ");
        let (label, x): (&str, &[f64]) = match prose.against {
            Against::Speed => ("speed [rad/s]", &self.motion.velocity[most]),
            Against::Position => ("position [rad]", &self.motion.position[most]),
            Against::Acceleration => ("acceleration [rad/s2]", &self.motion.acceleration[most]),
            Against::Load => ("effort of the rigid body [N m]", &self.rigid[most]),
            Against::Time => ("time [s]", &self.motion.time_s),
        };
        let points: Vec<(f64, f64)> = thinned(x).zip(thinned(&added[most])).collect();
        let lines: Vec<(String, Vec<(f64, f64)>)> = order
            .iter()
            .take(3)
            .filter(|j| size(**j) > 1e-4 * size(order[0]))
            .map(|&j| (name(j), thinned(&self.motion.time_s).zip(thinned(&added[j])).collect()))
            .collect();

        let mut svg = String::new();
        {
            let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
            root.fill(&WHITE)?;
            let (left, right) = root.split_horizontally(SIZE.0 / 2);
            let mut chart = ChartBuilder::on(&left)
                .margin(8)
                .caption(format!("f on {}", name(most)), ("sans-serif", 14))
                .x_label_area_size(36)
                .y_label_area_size(52)
                .build_cartesian_2d(
                    range(points.iter().map(|p| p.0)),
                    range(points.iter().map(|p| p.1)),
                )?;
            grid(&mut chart, label)?;
            chart.draw_series(points.iter().map(|p| Circle::new(*p, 1, COLOURS[0].filled())))?;
            let all = lines.iter().flat_map(|(_, line)| line.iter().map(|p| p.1));
            let times = range(self.motion.time_s.iter().copied());
            let mut chart = ChartBuilder::on(&right)
                .margin(8)
                .caption("f over time", ("sans-serif", 14))
                .x_label_area_size(36)
                .y_label_area_size(52)
                .build_cartesian_2d(times, range(all))?;
            grid(&mut chart, "time [s]")?;
            for ((name, line), colour) in lines.into_iter().zip(COLOURS) {
                chart
                    .draw_series(LineSeries::new(line, colour))?
                    .label(name)
                    .legend(move |(x, y)| PathElement::new([(x, y), (x + 12, y)], colour));
            }
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::UpperRight)
                .background_style(WHITE.mix(0.8))
                .label_font(("sans-serif", 11))
                .draw()?;
            root.present()?;
        }
        Ok(svg)
    }
}

type Plane =
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>;

fn grid<DB: DrawingBackend>(
    chart: &mut ChartContext<'_, DB, Plane>,
    label: &str,
) -> Result<(), Box<dyn Error>>
where
    DB::ErrorType: 'static,
{
    chart
        .configure_mesh()
        .max_light_lines(0)
        .x_labels(6)
        .y_labels(6)
        .x_desc(label)
        .y_desc("f [N m]")
        .axis_style(GREY)
        .label_style(("sans-serif", 11))
        .draw()
        .map_err(|error| error.to_string().into())
}

fn efforts(recording: &Recording) -> Vec<Vec<f64>> {
    recording.joints.iter().map(|joint| joint.effort.clone().unwrap_or_default()).collect()
}

fn thinned(values: &[f64]) -> impl Iterator<Item = f64> + '_ {
    values.iter().copied().step_by(values.len().div_ceil(POINTS).max(1))
}

/// A range a little wider than the values.
fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    let more = (0.06 * (high - low)).max(0.05 * high.abs()).max(1e-6);
    low - more..high + more
}
