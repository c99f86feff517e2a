//! False alarms of changes in fleets that do not age, and states of recordings for a run of ten thousand.
//!
//! One state is made for each of eight motions from a recording without noise; the states of all other recordings
//! have its columns and efforts drawn as least squares supposes them: `R (x + u) + e`, with `u` the scatter of the parameters
//! between recordings and `e` the noise of the effective samples.
//!
//! ```text
//! cargo run --release --example coverage_fleet -- 2000 > docs/studies/fleet.md
//! cargo run --release --example coverage_fleet -- states 10000 states.jsonl
//! ```

#![allow(clippy::print_stdout, reason = "the table is the output")]

use std::io::Write as _;

use armident_fleet::{FleetAnalysis, FleetSettings};
use armident_ident::{JointTriangle, RecordingState, StateColumns};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
use armident_model::ArmModel;
use armident_recording::{JointChannels, Recording};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

type Anything = Box<dyn std::error::Error>;

const RATE_HZ: f64 = 100.0;
const DURATION_S: f64 = 20.0;
const CUTOFF_HZ: f64 = 5.0;
/// Motions that recordings have.
const MOTIONS: usize = 8;
/// Noise of the filtered effort \[N m\].
const NOISE: f64 = 0.1;
/// Standard deviation of each parameter between recordings, in standard errors of one recording.
const SCATTERS: [f64; 3] = [0.0, 0.3, 3.0];

/// An arm with recordings of it to draw from.
pub(crate) struct Source {
    model: ArmModel,
    designs: Vec<RecordingState>,
}

impl Source {
    pub(crate) fn new(urdf: &str) -> Result<Self, Anything> {
        let robot = parse_urdf(urdf, "arm.urdf")?;
        let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
        let model = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
        let columns = StateColumns::new(&model, CUTOFF_HZ)?;
        let mut random = Pcg64::seed_from_u64(37);
        let mut designs = Vec::new();
        for motion in 0..MOTIONS {
            designs.push(columns.reduce(&moved(&model, motion, &mut random)?)?);
        }
        Ok(Self { model, designs })
    }

    pub(crate) fn columns(&self) -> Result<StateColumns<'_>, Anything> {
        Ok(StateColumns::new(&self.model, CUTOFF_HZ)?)
    }

    /// Parameters of the arm, with friction.
    fn truth(&self, columns: &StateColumns<'_>) -> Vec<f64> {
        let problem = columns.problem();
        let constants = problem.set().values(&problem.arm().constants());
        let value = |term: &armident_ident::Term| match *term {
            armident_ident::Term::Constant(k) => constants[k],
            _ => 1.0,
        };
        problem.terms.iter().map(value).collect()
    }

    /// Standard error of each parameter in one recording, all others held.
    fn errors(&self, columns: &StateColumns<'_>) -> Vec<f64> {
        let problem = columns.problem();
        let mut information = vec![0.0; problem.terms.len()];
        for design in &self.designs {
            for (joint, of) in design.joints.iter().enumerate() {
                let terms = problem.terms_of_joint(joint);
                for (i, j, x) in entries(terms.len(), &of.triangle) {
                    if j < terms.len() {
                        information[terms[j]] += x * x * design.independent_share / NOISE.powi(2);
                    }
                    let _ = i;
                }
            }
        }
        let error = |of: &f64| if *of > 0.0 { (MOTIONS as f64 / of).sqrt() } else { 0.0 };
        information.iter().map(error).collect()
    }

    /// A recording of a robot with these parameters.
    fn drawn(
        &self,
        columns: &StateColumns<'_>,
        values: &[f64],
        name: String,
        robot: String,
        random: &mut Pcg64,
    ) -> RecordingState {
        let design = &self.designs[random.random_range(0..MOTIONS)];
        let share = design.independent_share;
        let problem = columns.problem();
        let of_joint = |(joint, of): (usize, &JointTriangle)| {
            let terms = problem.terms_of_joint(joint);
            let p = terms.len();
            let mut triangle = of.triangle.clone();
            let mut efforts = vec![0.0; p + 1];
            let mut places = vec![0; p + 1];
            for (place, (i, j, x)) in entries(p, &of.triangle).enumerate() {
                if j < p { efforts[i] += x * values[terms[j]] } else { places[i] = place }
            }
            // noise of the effective samples, of which the columns take one each
            let deviation = NOISE / share.sqrt();
            let mut normal = || -> f64 { StandardNormal.sample(random) };
            efforts.iter_mut().take(p).for_each(|effort| *effort += deviation * normal());
            let freedom = (of.rows as f64 - p as f64 / share).max(1.0);
            efforts[p] = NOISE * freedom.sqrt();
            let squares = efforts.iter().map(|effort| effort * effort).sum();
            for (effort, place) in efforts.into_iter().zip(places) {
                triangle[place] = effort;
            }
            JointTriangle { rows: of.rows, triangle, effort: (of.rows, 0.0, squares) }
        };
        RecordingState {
            recording: name,
            robot: Some(robot),
            joints: design.joints.iter().enumerate().map(of_joint).collect(),
            ..design.clone()
        }
    }

    /// Robots with recordings each, whose parameters scatter by so many standard errors of one recording.
    pub(crate) fn fleet(
        &self,
        columns: &StateColumns<'_>,
        (robots, recordings): (usize, usize),
        scatter: f64,
        random: &mut Pcg64,
    ) -> Vec<Vec<RecordingState>> {
        let (truth, errors) = (self.truth(columns), self.errors(columns));
        (0..robots)
            .map(|robot| {
                (0..recordings)
                    .map(|recording| {
                        let normal = |of: &mut Pcg64| -> f64 { StandardNormal.sample(of) };
                        let values: Vec<f64> = (truth.iter().zip(&errors))
                            .map(|(x, error)| x + scatter * error * normal(random))
                            .collect();
                        let name = format!("arm{robot}/run{recording}.csv");
                        self.drawn(columns, &values, name, format!("arm{robot}"), random)
                    })
                    .collect()
            })
            .collect()
    }
}

/// Row, column and value of each entry of an upper triangle of `p + 1` columns.
fn entries(p: usize, upper: &[f64]) -> impl Iterator<Item = (usize, usize, f64)> {
    (0..=p).flat_map(move |i| (i..=p).map(move |j| (i, j))).zip(upper).map(|((i, j), x)| (i, j, *x))
}

/// A recording with two sines a joint.
fn moved(model: &ArmModel, number: usize, random: &mut Pcg64) -> Result<Recording, Anything> {
    let count = (RATE_HZ * DURATION_S) as usize;
    let time: Vec<f64> = (0..count).map(|k| k as f64 / RATE_HZ).collect();
    let joints = model.chain.joints.iter().map(|joint| {
        let mut wave = |hz: f64, size: f64| {
            let phase: f64 = random.random_range(0.0..std::f64::consts::TAU);
            time.iter().map(move |t| size * (std::f64::consts::TAU * hz * t + phase).sin())
        };
        let (slow, fast) = (wave(0.15, 0.9).collect::<Vec<_>>(), wave(0.45, 0.3));
        let position: Vec<f64> = slow.into_iter().zip(fast).map(|(a, b)| a + b).collect();
        let effort = position.iter().map(|q| 0.1 * q).collect();
        JointChannels {
            name: joint.name.clone(),
            position: Some(position),
            velocity: None,
            effort: Some(effort),
            ..JointChannels::default()
        }
    });
    let joints = joints.collect();
    Ok(Recording::new(format!("run{number}.csv"), time.clone(), joints)?)
}

/// False alarms in fleets that do not age.
pub(crate) struct Alarms {
    pub(crate) robots: usize,
    pub(crate) with_change: usize,
}

pub(crate) fn alarms(
    source: &Source,
    (fleets, robots, recordings): (usize, usize, usize),
    scatter: f64,
    seed: u64,
) -> Result<Alarms, Anything> {
    let columns = source.columns()?;
    let mut found = Alarms { robots: 0, with_change: 0 };
    let mut random = Pcg64::seed_from_u64(seed);
    for _ in 0..fleets {
        let fleet = source.fleet(&columns, (robots, recordings), scatter, &mut random);
        let analysis = FleetAnalysis::learn(&columns, &fleet, FleetSettings::default())?;
        for states in &fleet {
            found.robots += 1;
            found.with_change += usize::from(!analysis.robot("arm", states)?.changes.is_empty());
        }
    }
    Ok(found)
}

#[allow(dead_code, reason = "the sample of the acceptance tests has no table")]
fn main() -> Result<(), Anything> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [word, count, path] = &arguments[..]
        && word == "states"
    {
        return states(count.parse()?, path);
    }
    let fleets: usize = arguments.first().map_or(Ok(2000), |count| count.parse())?;
    // `-- 2000 ur5 3`: only this arm and scatter
    let only = (arguments.get(1), arguments.get(2));
    println!("# False alarms of changes in fleets that do not age\n");
    println!(
        "Fleets of one arm whose parameters differ between recordings at random, by *scatter* standard errors of one \
         recording, and do not change otherwise. The stated rate of a robot is 1 %. Made by `docs/studies/make fleet`: `cargo \
         run --release --example coverage_fleet -- {fleets}`; armident {}.\n",
        env!("CARGO_PKG_VERSION")
    );
    println!(
        "| arm | robots | recordings of each | scatter | robots tried | with a change | share |"
    );
    println!("| --- | ---: | ---: | ---: | ---: | ---: | ---: |");
    let planar = Source::new(include_str!("../urdf/planar_2r.urdf"))?;
    let ur5 = Source::new(include_str!("../urdf/ur5.urdf"))?;
    // of each arm and scatter a third of the fleets; the larger arm takes much longer
    for (name, source, share) in [("planar 2R", &planar, 3), ("UR5", &ur5, 100)] {
        for (row, (robots, recordings)) in [(10, 10), (3, 4)].into_iter().enumerate() {
            for scatter in SCATTERS {
                let is_wanted = |wanted: Option<&String>, of: &str| {
                    wanted.is_none_or(|wanted| wanted.eq_ignore_ascii_case(of))
                };
                if !is_wanted(only.0, name) || !is_wanted(only.1, &scatter.to_string()) {
                    continue;
                }
                let seed = 3700 + row as u64;
                let fleets = (fleets / share).max(1);
                let found = alarms(source, (fleets, robots, recordings), scatter, seed)?;
                let percent = 100.0 * found.with_change as f64 / found.robots as f64;
                println!(
                    "| {name} | {robots} | {recordings} | {scatter} | {} | {} | {percent:.2} % |",
                    found.robots, found.with_change
                );
            }
        }
    }
    Ok(())
}

/// Writes states of a hundred robots.
#[allow(dead_code, reason = "the sample of the acceptance tests writes none")]
fn states(count: usize, path: &str) -> Result<(), Anything> {
    let source = Source::new(include_str!("../urdf/ur5.urdf"))?;
    let columns = source.columns()?;
    let mut random = Pcg64::seed_from_u64(10_000);
    let mut file = std::io::BufWriter::new(std::fs::File::create(path)?);
    let robots = 100.min(count);
    let (truth, errors) = (source.truth(&columns), source.errors(&columns));
    for number in 0..count {
        let (robot, recording) = (number % robots, number / robots);
        let values: Vec<f64> = (truth.iter().zip(&errors))
            .map(|(x, error)| {
                let normal: f64 = StandardNormal.sample(&mut random);
                x + error * normal
            })
            .collect();
        let name = format!("arm{robot}/run{recording}.csv");
        let state = source.drawn(&columns, &values, name, format!("arm{robot}"), &mut random);
        serde_json::to_writer(&mut file, &state)?;
        file.write_all(b"\n")?;
    }
    Ok(file.flush()?)
}
