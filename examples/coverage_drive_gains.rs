//! Coverage of drive gains, and of a load that is weighed with them.
//!
//! Arms whose links differ from their URDF, with friction in every joint, record positions and motor currents: one motion without a
//! load, one or two with a known load. The gains are identified; a recording with an unknown load is then diagnosed against the
//! identified model. Prints how often the 95 % intervals hold the true gain and the true mass:
//!
//! ```text
//! cargo run --release --example coverage_drive_gains -- 200 > docs/studies/drive_gains_coverage.md
//! ```

#![allow(clippy::print_stdout, reason = "the table is the output")]

mod random_arm;

use std::collections::BTreeMap;

use armident_diagnose::{DiagnoseRequest, diagnose};
use armident_effects::{Effect, EffectOnJoint, LinkInertiaError, Payload};
use armident_ident::estimators::Huber;
use armident_ident::{IdentifyRequest, KnownLoad, identify};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_model::ArmModel;
use armident_recording::{Quantity, Recording};
use armident_simulation::{Sensors, SimulatedArm, Trajectory, inverse};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use random_arm::{add_coloured_noise, drawn_link, sum_of_sines};

const ROBOTS: [&str; 6] = ["ur5", "iiwa14", "panda", "ur10", "kinova_gen3", "xarm7"];
const RATE_HZ: f64 = 100.0;
const DURATION_S: f64 = 20.0;
const FUNDAMENTAL_HZ: f64 = 0.1;
/// Speed of each harmonic \[rad/s\].
const SPEED: f64 = 0.4;
const ENCODER_BITS: u32 = 17;
/// Noise of the currents relative to each joint's own, and correlation of neighbouring samples.
const NOISE: f64 = 0.02;
const COLOUR: f64 = 0.9;
/// Relative error of the links of the URDF.
const LINK_ERROR: f64 = 0.1;
/// Standard deviation of each coordinate of the centre of a known load \[m\].
const CENTRE_ERROR_M: f64 = 0.003;
/// Mass of a known load \[kg\].
const KNOWN_KG: f64 = 2.0;
/// Most mass of an unknown load \[kg\]; the least is a quarter.
const MOST_KG: f64 = 3.0;
/// Factor of the standard error in a 95 % interval.
const NORMAL_975: f64 = 1.96;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let arms: u64 = std::env::args().nth(1).map_or(Ok(200), |a| a.parse())?;
    let mut of_loads: BTreeMap<usize, Counts> = BTreeMap::new();
    let mut of_robot: BTreeMap<&str, Counts> = BTreeMap::new();
    let mut all = Counts::default();
    for seed in 0..arms {
        let robot = ROBOTS[seed as usize % ROBOTS.len()];
        let loads = 1 + (seed as usize / ROBOTS.len()) % 2;
        let counts =
            counts(robot, loads, seed).map_err(|e| format!("{robot}, seed {seed}: {e}"))?;
        for total in
            [of_robot.entry(robot).or_default(), of_loads.entry(loads).or_default(), &mut all]
        {
            total.add(&counts);
        }
    }
    println!("# Coverage of drive gains\n");
    println!(
        "{arms} arms with random errors of every link ({:.0} % of the second moments of mass), viscous and Coulomb friction, offset and \
         rotor inertia on every joint; a motion without a load and one or two with a known load ({KNOWN_KG} kg, and half of it; \
         centre known to {:.0} mm), {DURATION_S} s each at {RATE_HZ} Hz; {ENCODER_BITS}-bit encoders; noise of the currents {:.0} % with \
         correlation {COLOUR} of neighbouring samples. The gains are identified (`armident identify --payload`), and a \
         recording with an unknown load of {} to {MOST_KG} kg is diagnosed against the identified model; armident {}.",
        100.0 * LINK_ERROR,
        1e3 * CENTRE_ERROR_M,
        100.0 * NOISE,
        0.25 * MOST_KG,
        env!("CARGO_PKG_VERSION")
    );
    println!("Made by `cargo run --release --example coverage_drive_gains -- {arms}`.\n");
    println!(
        "| arms | count | gains inside | of | half-width of the interval, median | load named | mass inside | \
         standard error of the mass, median |"
    );
    println!("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |");
    for (robot, counts) in &of_robot {
        counts.print(robot);
    }
    for (loads, counts) in &of_loads {
        counts.print(if *loads == 1 { "one known load" } else { "two known loads" });
    }
    all.print("all");
    Ok(())
}

/// What is counted.
#[derive(Debug, Clone, Default)]
pub(crate) struct Counts {
    pub(crate) arms: usize,
    pub(crate) gains: usize,
    pub(crate) gains_inside: usize,
    half_widths: Vec<f64>,
    pub(crate) named: usize,
    pub(crate) masses_inside: usize,
    mass_errors: Vec<f64>,
}

impl Counts {
    pub(crate) fn add(&mut self, other: &Self) {
        self.arms += other.arms;
        self.gains += other.gains;
        self.gains_inside += other.gains_inside;
        self.half_widths.extend(&other.half_widths);
        self.named += other.named;
        self.masses_inside += other.masses_inside;
        self.mass_errors.extend(&other.mass_errors);
    }

    fn print(&self, whose: &str) {
        let share = |inside: usize, of: usize| 100.0 * inside as f64 / of.max(1) as f64;
        let median = |values: &[f64]| {
            let mut sorted = values.to_vec();
            sorted.sort_by(f64::total_cmp);
            100.0 * sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
        };
        println!(
            "| {whose} | {} | {:.1} % | {} | {:.1} % | {} | {:.1} % | {:.1} % |",
            self.arms,
            share(self.gains_inside, self.gains),
            self.gains,
            median(&self.half_widths),
            self.named,
            share(self.masses_inside, self.named),
            median(&self.mass_errors),
        );
    }
}

/// Identifies the gains of one arm and weighs a load with them.
pub(crate) fn counts(robot: &str, loads: usize, seed: u64) -> Result<Counts, Failure> {
    let robot = load_urdf(format!("urdf/{robot}.urdf").as_ref())?;
    let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
    let given = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
    let mut random = Pcg64::seed_from_u64(seed);
    let bench = Bench::drawn(given, &mut random)?;
    let known = [0.0, KNOWN_KG, 0.5 * KNOWN_KG];
    let mut recordings = Vec::new();
    let mut known_loads = Vec::new();
    for mass_kg in &known[..=loads] {
        let centre_m = drawn_centre(&mut random);
        let recording = bench.recording(*mass_kg, centre_m, &mut random)?;
        if *mass_kg > 0.0 {
            let error_m: [f64; 3] = std::array::from_fn(|_| CENTRE_ERROR_M * normal(&mut random));
            let stated_m = std::array::from_fn(|k| centre_m[k] + error_m[k]);
            known_loads.push(KnownLoad::new(
                &bench.given.chain,
                &recording.source,
                *mass_kg,
                Some(stated_m),
                CENTRE_ERROR_M,
            ));
        }
        recordings.push(recording);
    }
    let request = IdentifyRequest {
        loads: &known_loads,
        estimator: &Huber,
        ..IdentifyRequest::new(&bench.given, &recordings)
    };
    let identified = identify(&request)?;
    let mut counts = Counts { arms: 1, ..Counts::default() };
    let gains = identified.drive_gains.as_ref().ok_or("no gains")?;
    for (gain, truth) in gains.joints.iter().zip(&bench.gains) {
        let Some([low, high]) = gain.and_then(|gain| gain.interval_95) else { continue };
        counts.gains += 1;
        counts.gains_inside += usize::from((low..=high).contains(truth));
        counts.half_widths.push(0.5 * (high - low) / truth);
    }
    let mass_kg = MOST_KG * 4.0_f64.powf(-random.random_range(0.0..1.0));
    let unknown = [bench.recording(mass_kg, drawn_centre(&mut random), &mut random)?];
    let diagnosis = diagnose(&DiagnoseRequest::new(&identified.model, &unknown))?;
    let last = bench.given.chain.joints.last().map(|joint| joint.child_link.clone());
    let found = diagnosis.findings.iter().find(|finding| {
        let is_body = [Payload.slug(), LinkInertiaError.slug()].contains(&finding.effect.as_str());
        is_body && finding.link == last
    });
    let mass = found.and_then(|finding| {
        finding.parameters.get("mass").or_else(|| finding.parameters.get("delta_mass"))
    });
    if let Some((value, error)) = mass.and_then(|mass| Some((mass.value, mass.stderr?))) {
        counts.named = 1;
        counts.masses_inside = usize::from((value - mass_kg).abs() <= NORMAL_975 * error);
        counts.mass_errors.push(error / mass_kg);
    }
    Ok(counts)
}

/// A simulated arm whose drives report currents.
struct Bench {
    given: ArmModel,
    truth: ArmModel,
    names: Vec<String>,
    effects: Vec<EffectOnJoint>,
    /// \[N m/A\]
    gains: Vec<f64>,
}

impl Bench {
    fn drawn(given: ArmModel, random: &mut Pcg64) -> Result<Self, Failure> {
        let mut truth = given.clone();
        for joint in &mut truth.chain.joints {
            joint.link = drawn_link(&joint.link, LINK_ERROR, random)?;
        }
        let names: Vec<String> = given.chain.joints.iter().map(|j| j.name.clone()).collect();
        let mut bench = Self { given, truth, names, effects: Vec::new(), gains: Vec::new() };
        // friction is a share of what the joint carries, as gears are chosen for their load
        let alone = bench.recording_of(&bench.motion(random)?, 0.0, [0.0; 3])?;
        for joint in &alone.joints {
            let effort = joint.effort.as_deref().unwrap_or_default();
            let rms = (effort.iter().map(|e| e * e).sum::<f64>() / effort.len() as f64).sqrt();
            let size = rms.max(0.5);
            let mut on = |slug: &str, value: f64| {
                bench.effects.push(EffectOnJoint::new(slug, &joint.name, [value]));
            };
            on("viscous_friction", 0.3 * size * random.random_range(0.5..1.5));
            on("coulomb_friction", 0.2 * size * random.random_range(0.5..1.5));
            on("torque_offset", 0.02 * size * normal(random));
            on("rotor_inertia", 0.02 * size * random.random_range(0.5..1.5));
            bench.gains.push(5.0 * 4.0_f64.powf(random.random_range(0.0..1.0)));
        }
        Ok(bench)
    }

    /// A random motion in the middle of the arm's space.
    fn motion(&self, random: &mut Pcg64) -> Result<Recording, Failure> {
        let samples = (DURATION_S * RATE_HZ) as usize;
        let time_s: Vec<f64> = (0..samples).map(|k| k as f64 / RATE_HZ).collect();
        let joints = self.given.chain.joints.iter().map(|joint| {
            let [low, high] = [joint.limits.lower, joint.limits.upper]
                .map(|limit| limit.filter(|limit| limit.abs() < 3.0));
            let middle = match (low, high) {
                (Some(low), Some(high)) => 0.5 * (low + high),
                _ => 0.0,
            };
            let middle = middle + random.random_range(-0.3..0.3);
            sum_of_sines(&joint.name, &time_s, FUNDAMENTAL_HZ, [middle, SPEED], random)
        });
        let joints = joints.collect();
        let source = format!("motion_{}.csv", random.random_range(0..u32::MAX));
        Ok(Recording::new(source, time_s, joints)?)
    }

    /// The planned motion as an ideal logger would record it.
    fn recording_of(
        &self,
        planned: &Recording,
        mass_kg: f64,
        centre_m: [f64; 3],
    ) -> Result<Recording, Failure> {
        let (arm, trajectory) = self.loaded(planned, mass_kg, centre_m)?;
        Ok(inverse(&arm, &trajectory)?)
    }

    fn loaded(
        &self,
        planned: &Recording,
        mass_kg: f64,
        centre_m: [f64; 3],
    ) -> Result<(SimulatedArm, Trajectory), Failure> {
        let mut rigid = self.truth.rigid_arm();
        let load = KnownLoad::new(&self.truth.chain, "load", mass_kg, Some(centre_m), 0.0);
        if let Some(last) = rigid.links.last_mut() {
            *last = last.plus(&load.body);
        }
        let arm = SimulatedArm::new(rigid, &self.names, &self.effects)?;
        let trajectory = Trajectory::from_recording(planned, &self.names, &BTreeMap::new())?;
        Ok((arm, trajectory))
    }

    /// Positions and currents of a random motion with a load.
    fn recording(
        &self,
        mass_kg: f64,
        centre_m: [f64; 3],
        random: &mut Pcg64,
    ) -> Result<Recording, Failure> {
        let planned = self.motion(random)?;
        let (arm, trajectory) = self.loaded(&planned, mass_kg, centre_m)?;
        let seed = random.random_range(0..u64::from(u32::MAX));
        let sensors = Sensors { effort_noise: None, encoder_bits: Some(ENCODER_BITS), seed };
        let mut measured = sensors.apply(&arm, &inverse(&arm, &trajectory)?)?;
        measured.source.clone_from(&planned.source);
        for (joint, gain) in measured.joints.iter_mut().zip(&self.gains) {
            joint.velocity = None;
            joint.acceleration = None;
            let Some(mut effort) = joint.effort.take() else { continue };
            add_coloured_noise(&mut effort, NOISE, COLOUR, random);
            *joint.channel_mut(Quantity::Current) = Some(effort.iter().map(|e| e / gain).collect());
        }
        Ok(measured)
    }
}

fn normal(random: &mut Pcg64) -> f64 {
    StandardNormal.sample(random)
}

/// The centre of a load in the frame of the last link \[m\].
fn drawn_centre(random: &mut Pcg64) -> [f64; 3] {
    [0.03 * normal(random), 0.03 * normal(random), random.random_range(0.0..0.15)]
}
