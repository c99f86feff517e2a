//! Coverage of the standard errors of the batch fit.
//!
//! Simulates a UR5 with a heavier forearm, friction and rotor inertia on random motions, recorded with 17-bit
//! encoders and efforts with coloured noise, differentiates and filters as usual, identifies each
//! recording, and prints the coverage of the 95 % intervals:
//!
//! ```text
//! cargo run --release --example coverage_batch -- 200 irls > docs/studies/batch_coverage.md
//! cargo run --release --example coverage_batch -- 200 irls none > docs/studies/batch_coverage_without_prior.md
//! cargo run --release --example coverage_batch -- 200 irls urdf drawn > docs/studies/batch_coverage_drawn_arms.md
//! ```

#![allow(clippy::print_stdout, reason = "the table is the output")]

mod random_arm;

use armident_effects::EffectOnJoint;
use armident_ident::estimators::{Estimator, by_name};
use armident_ident::{
    BatchProblem, BatchSettings, IdentifyRequest, MinimalSet, StructureSearch, Term, identify,
};
use armident_kinematics::{
    ChainSelection, DrivingAxisChain, InertialParameters, SerialChain, load_urdf,
};
use armident_model::ArmModel;
use armident_recording::Recording;
use armident_simulation::{Sensors, SimulatedArm, Trajectory, inverse};
use nalgebra::{Matrix3, Vector3};
use rand::SeedableRng;
use rand_pcg::Pcg64;

use random_arm::{add_coloured_noise, drawn_link, sum_of_sines};

const RATE_HZ: f64 = 100.0;
const DURATION_S: f64 = 20.0;
const FUNDAMENTAL_HZ: f64 = 0.1;
const ENCODER_BITS: u32 = 17;
/// Effort noise relative to each joint's effort, and correlation of neighbouring samples.
const NOISE: f64 = 0.02;
const COLOUR: f64 = 0.9;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let seeds: u64 = arguments.next().map_or(Ok(200), |a| a.parse())?;
    let name = arguments.next().unwrap_or_else(|| "irls".to_owned());
    let estimator = by_name(&name).ok_or("no such method")?;

    let prior = arguments.next().unwrap_or_else(|| "urdf".to_owned());
    let (settings, of_prior) = match prior.as_str() {
        "urdf" => (BatchSettings::default(), "prior about the URDF with its scale estimated"),
        "none" => (BatchSettings { link_prior: None, ..BatchSettings::default() }, "no prior"),
        _ => return Err("the prior is urdf or none".into()),
    };

    let arms = match arguments.next().as_deref() {
        None | Some("forearm") => Arms::HeavierForearm,
        Some("drawn") => Arms::Drawn,
        Some(_) => return Err("the arms are forearm or drawn".into()),
    };
    let (who, how, whose, believed) = match arms {
        Arms::HeavierForearm => (
            "UR5 with a forearm 0.6 kg heavier than its URDF",
            "",
            "true value",
            "if it is large, the intervals are wider than necessary for a URDF that is right here (except for the \
             forearm), and their coverage exceeds 95 %",
        ),
        Arms::Drawn => (
            "UR5 with random errors of every link, another arm for each recording (pseudo-inertia \
             L S S' L' for L L' with S normal about the unit matrix: second moments of mass, along every line, \
             differing by 30 %)",
            " drawn",
            "true value, mean",
            "the errors of the URDF are at most the prior scale, and the coverage must be nominal for any share",
        ),
    };

    let study = study(seeds, estimator, &settings, arms)?;
    let Study { count, labels, true_values, inside, inside_white, .. } = &study;
    let Study { from_prior, off, off_squares, cutoffs, .. } = &study;
    let count = *count;
    let share = |hits: u64| 100.0 * hits as f64 / seeds as f64;
    let pooled = |hits: &[u64]| hits.iter().map(|h| share(*h)).sum::<f64>() / count as f64;
    let lowest = cutoffs.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = cutoffs.iter().copied().fold(0.0, f64::max);
    println!("# Coverage of the batch fit's intervals\n");
    println!(
        "{who}; viscous and Coulomb friction, offset and rotor inertia on every joint; {seeds} recordings of {DURATION_S} s at {RATE_HZ} Hz, five harmonics of \
         {FUNDAMENTAL_HZ} Hz with random phases; {ENCODER_BITS}-bit encoders; effort noise of {} % with \
         correlation {COLOUR} of neighbouring samples; velocity and acceleration from positions through \
         the chosen low-pass ({lowest:.1} to {highest:.1} Hz); method {name}, {of_prior}; armident {}.",
        100.0 * NOISE,
        env!("CARGO_PKG_VERSION")
    );
    println!(
        "Made by `cargo run --release --example coverage_batch -- {seeds} {name} {prior}{how}`. *Prior* is the mean share \
         of the information that comes from the URDF: {believed}.\n"
    );
    println!(
        "Inside 95 % intervals, all {count} parameters: **{:.1} %** with the block jackknife, {:.1} % under the assumption \
         of white residuals.\n",
        pooled(inside),
        pooled(inside_white)
    );
    println!(
        "| parameter | {whose} | prior | inside | inside, white | mean of (estimate - truth)/error | SD |"
    );
    println!("| --- | ---: | ---: | ---: | ---: | ---: | ---: |");
    for k in 0..count {
        let mean = off[k] / seeds as f64;
        let deviation = (off_squares[k] / seeds as f64 - mean * mean).sqrt();
        println!(
            "| {} | {:.6} | {:.0} % | {:.1} % | {:.1} % | {mean:+.3} | {deviation:.3} |",
            labels[k],
            true_values[k],
            100.0 * from_prior[k] / seeds as f64,
            share(inside[k]),
            share(inside_white[k]),
        );
    }
    Ok(())
}

/// Per unknown, over all recordings.
pub(crate) struct Study {
    /// Number of unknowns.
    pub(crate) count: usize,
    labels: Vec<String>,
    true_values: Vec<f64>,
    /// Sum of the shares.
    from_prior: Vec<f64>,
    /// Recordings whose 95 % interval holds the true value.
    pub(crate) inside: Vec<u64>,
    inside_white: Vec<u64>,
    off: Vec<f64>,
    off_squares: Vec<f64>,
    cutoffs: Vec<f64>,
}

/// What the arms of a study are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Arms {
    /// One arm, whose forearm is heavier than its URDF says.
    HeavierForearm,
    /// Another arm for each recording, every link off its URDF.
    Drawn,
}

/// Identifies so many recordings, each with a seed of its own.
pub(crate) fn study(
    seeds: u64,
    estimator: &dyn Estimator,
    settings: &BatchSettings,
    arms: Arms,
) -> Result<Study, Box<dyn std::error::Error>> {
    let robot = load_urdf("urdf/ur5.urdf".as_ref())?;
    let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
    let given = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
    let names: Vec<String> = given.chain.joints.iter().map(|j| j.name.clone()).collect();
    let joints: Vec<&str> = names.iter().map(String::as_str).collect();
    let effects = friction(&names);
    let rigid = given.rigid_arm();
    let set = MinimalSet::of(&rigid)?;
    let problem = BatchProblem::new(&rigid, &set);
    let values_of = |truth: &ArmModel| true_values(&problem, &set, truth, &effects, &names);
    let count = problem.terms.len();
    let (mut inside, mut inside_white) = (vec![0_u64; count], vec![0_u64; count]);
    let (mut off, mut off_squares) = (vec![0.0; count], vec![0.0; count]);
    let mut from_prior = vec![0.0; count];
    let mut cutoffs = Vec::new();
    let mut sums = vec![0.0; count];
    for seed in 0..seeds {
        let truth = true_arm(&given, arms, seed)?;
        let arm = SimulatedArm::new(truth.rigid_arm(), &names, &effects)?;
        let true_values = values_of(&truth);
        sums.iter_mut().zip(&true_values).for_each(|(sum, value)| *sum += value);
        let recording = recording(&arm, &names, seed)?;
        let identified = identify(&IdentifyRequest {
            estimator,
            settings: *settings,
            search: StructureSearch::NOTHING,
            decimate: false,
            project: false,
            ..IdentifyRequest::new(&given, std::slice::from_ref(&recording))
        })?;
        cutoffs.extend(identified.cutoff_hz);
        let (found, settings) = (&identified.estimate, &identified.structure.settings);
        let white = identified.problem.estimate_with(&identified.rows, settings)?;
        for k in 0..count {
            from_prior[k] += found.prior_share[k];
            let hit = |error: Option<f64>, value: f64, quantile: f64| {
                error.is_none_or(|e| (value - true_values[k]).abs() <= quantile * e)
            };
            inside[k] +=
                u64::from(hit(found.standard_error(k), found.values[k], found.quantile_95));
            inside_white[k] +=
                u64::from(hit(white.standard_error(k), white.values[k], white.quantile_95));
            if let Some(error) = found.standard_error(k) {
                let z = (found.values[k] - true_values[k]) / error;
                off[k] += z;
                off_squares[k] += z * z;
            }
        }
    }
    let labels = problem.terms.iter().map(|term| problem.label(term, &joints)).collect();
    let study = Study {
        count,
        labels,
        true_values: sums.iter().map(|sum| sum / seeds as f64).collect(),
        from_prior,
        inside,
        inside_white,
        off,
        off_squares,
        cutoffs,
    };
    Ok(study)
}

/// Relative error of a drawn arm's links.
const DRAWN_ERROR: f64 = 0.3;

/// The links, as the URDF does not know them.
fn true_arm(
    given: &ArmModel,
    arms: Arms,
    seed: u64,
) -> Result<ArmModel, Box<dyn std::error::Error>> {
    let mut truth = given.clone();
    match arms {
        Arms::HeavierForearm => {
            let forearm = &mut truth.chain.joints[2].link;
            let middle = forearm.com_m();
            *forearm = forearm.plus(&InertialParameters::from_com(
                0.6,
                middle + Vector3::new(0.05, 0.0, 0.0),
                Matrix3::identity() * 0.002,
            ));
        }
        Arms::Drawn => {
            // a stream of its own, so that the motions are those of the other study
            let mut random = Pcg64::new(u128::from(seed), 1);
            for joint in &mut truth.chain.joints {
                joint.link = drawn_link(&joint.link, DRAWN_ERROR, &mut random)?;
            }
        }
    }
    Ok(truth)
}

/// Friction and rotors of every joint.
fn friction(names: &[String]) -> Vec<EffectOnJoint> {
    let friction = [
        [3.1, 4.2, 0.10, 0.35],
        [3.4, 5.1, -0.20, 0.35],
        [1.9, 3.3, 0.15, 0.20],
        [0.55, 0.90, 0.02, 0.05],
        [0.50, 0.75, 0.00, 0.05],
        [0.45, 0.70, -0.03, 0.05],
    ];
    let slugs = ["viscous_friction", "coulomb_friction", "torque_offset", "rotor_inertia"];
    let mut effects = Vec::new();
    for (joint, numbers) in names.iter().zip(friction) {
        for (effect, value) in slugs.iter().zip(numbers) {
            effects.push(EffectOnJoint {
                effect: (*effect).to_owned(),
                joint: joint.clone(),
                parameters: vec![value],
                other_joint: None,
                window_s: None,
            });
        }
    }
    effects
}

/// True value of every unknown, merged rotors included.
fn true_values(
    problem: &BatchProblem,
    set: &MinimalSet,
    truth: &ArmModel,
    effects: &[EffectOnJoint],
    names: &[String],
) -> Vec<f64> {
    let constants = set.values(&truth.rigid_arm().constants());
    let of_effect = |joint: usize, effect: usize| {
        let slug = armident_effects::BASELINE[effect].law().slug;
        effects
            .iter()
            .find(|e| e.effect == slug && e.joint == names[joint])
            .map_or(0.0, |e| e.parameters[0])
    };
    let of_term = |term: &Term| match *term {
        Term::Constant(k) => constants[k],
        Term::Effect { joint, effect, .. } => of_effect(joint, effect),
        Term::Shared { .. } | Term::Load { .. } => 0.0,
    };
    let mut values: Vec<f64> = problem.terms.iter().map(of_term).collect();
    for merged in &problem.merged {
        for (k, factor) in &merged.into {
            values[*k] += factor * of_term(&merged.term);
        }
    }
    values
}

/// Position and effort of a random motion, as a logger gives them.
fn recording(
    arm: &SimulatedArm,
    names: &[String],
    seed: u64,
) -> Result<Recording, Box<dyn std::error::Error>> {
    let mut random = Pcg64::seed_from_u64(seed);
    let samples = (DURATION_S * RATE_HZ) as usize;
    let time_s: Vec<f64> = (0..samples).map(|k| k as f64 / RATE_HZ).collect();
    let middle = [0.0, -1.3, 1.4, -0.8, 0.6, 0.0];
    let speed = [0.35, 0.3, 0.4, 0.55, 0.6, 0.7];
    let joints = names
        .iter()
        .enumerate()
        .map(|(j, name)| {
            let motion = [middle[j], speed[j]];
            sum_of_sines(name, &time_s, FUNDAMENTAL_HZ, motion, &mut random)
        })
        .collect();
    let planned = Recording::new(format!("motion {seed}"), time_s, joints)?;
    let nothing_held = std::collections::BTreeMap::new();
    let trajectory = Trajectory::from_recording(&planned, names, &nothing_held)?;
    let sensors = Sensors { effort_noise: None, encoder_bits: Some(ENCODER_BITS), seed };
    let mut measured = sensors.apply(arm, &inverse(arm, &trajectory)?)?;
    for joint in &mut measured.joints {
        joint.velocity = None;
        joint.acceleration = None;
        let Some(effort) = &mut joint.effort else { continue };
        add_coloured_noise(effort, NOISE, COLOUR, &mut random);
    }
    Ok(measured)
}
