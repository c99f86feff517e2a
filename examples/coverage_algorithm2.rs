//! Coverage of the standard errors of Algorithm 2.
//!
//! Simulates the planned experiments of the Stanford arm with white effort noise on exact motion for
//! many seeds, identifies each, and prints the coverage of the 95 % intervals:
//!
//! ```text
//! cargo run --release --example coverage_algorithm2 -- 400 0.1 > docs/studies/algorithm2_coverage.md
//! ```

#![allow(clippy::print_stdout, reason = "the table is the output")]

use armident_dynamics::inverse_dynamics_of_motion;
use armident_ident::MinimalSet;
use armident_ident::experiment::{PlanSettings, algorithm2, plan};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_motion::{Motion, MotionSettings};
use armident_recording::{JointChannels, Recording};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let seeds: u64 = arguments.next().map_or(Ok(400), |a| a.parse())?;
    let noise_nm: f64 = arguments.next().map_or(Ok(0.1), |a| a.parse())?;

    let robot = load_urdf("urdf/stanford.urdf".as_ref())?;
    let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
    let chain = DrivingAxisChain::from_chain(&chain);
    let arm = armident_dynamics::RigidArm::from_chain(&chain);
    let set = MinimalSet::of(&arm)?;
    let plan = plan(&chain, &set, &PlanSettings::default())?;
    let truth = set.values(&arm.constants());
    let names: Vec<&str> = plan.joints.iter().map(String::as_str).collect();

    // exact motions and efforts once, noise per seed
    let exact: Vec<(Recording, Vec<Vec<f64>>)> = plan
        .experiments
        .iter()
        .map(|experiment| {
            let planned = plan.trajectory(experiment);
            let column = |pick: fn(&(f64, f64, f64)) -> f64| -> Vec<Vec<f64>> {
                planned.joints.iter().map(|j| j.iter().map(pick).collect()).collect()
            };
            let (q, dq, ddq) = (column(|s| s.0), column(|s| s.1), column(|s| s.2));
            let effort = inverse_dynamics_of_motion(&arm, &q, &dq, &ddq);
            let joints = (0..names.len())
                .map(|j| JointChannels {
                    position: Some(q[j].clone()),
                    velocity: Some(dq[j].clone()),
                    acceleration: Some(ddq[j].clone()),
                    effort: Some(effort[j].clone()),
                    ..JointChannels::new(names[j])
                })
                .collect();
            Ok((Recording::new(&experiment.id, planned.time_s, joints)?, effort))
        })
        .collect::<Result<_, armident_recording::RecordingError>>()?;

    let count = set.len();
    let (mut covered, mut sum, mut squares) =
        (vec![0u64; count], vec![0.0; count], vec![0.0; count]);
    let mut mean_error = vec![0.0; count];
    for seed in 0..seeds {
        let mut random = Pcg64::seed_from_u64(seed);
        let motions: Vec<Motion> = exact
            .iter()
            .map(|(recording, effort)| {
                let mut noisy = recording.clone();
                for (joint, effort) in noisy.joints.iter_mut().zip(effort) {
                    joint.effort = Some(
                        effort
                            .iter()
                            .map(|e| {
                                let z: f64 = StandardNormal.sample(&mut random);
                                e + noise_nm * z
                            })
                            .collect(),
                    );
                }
                Motion::from_recording(&noisy, &names, &MotionSettings::default())
            })
            .collect::<Result<_, _>>()?;
        let found = algorithm2(&arm, &set, &plan, &motions)?;
        for k in 0..count {
            let z = (found.values[k] - truth[k]) / found.standard_error(k);
            covered[k] += u64::from(z.abs() <= found.quantile_95[k]);
            sum[k] += z;
            squares[k] += z * z;
            mean_error[k] += found.standard_error(k) / seeds as f64;
        }
    }

    println!("# Coverage of Algorithm 2's intervals\n");
    println!(
        "Stanford arm, {} planned experiments at {} Hz, white effort noise of {noise_nm} N m (N) on \
         exact motion, seeds 0 to {}; armident {}.",
        plan.experiments.len(),
        plan.rate_hz,
        seeds - 1,
        env!("CARGO_PKG_VERSION")
    );
    println!(
        "Made by `cargo run --release --example coverage_algorithm2 -- {seeds} {noise_nm}`.\n"
    );
    println!(
        "| constant | true value | mean standard error | inside 95 % interval | mean of (estimate - truth)/error | SD |"
    );
    println!("| --- | ---: | ---: | ---: | ---: | ---: |");
    let n = seeds as f64;
    for k in 0..count {
        println!(
            "| {} | {:.6} | {:.2e} | {:.1} % | {:+.3} | {:.3} |",
            set.constants[k],
            truth[k],
            mean_error[k],
            100.0 * covered[k] as f64 / n,
            sum[k] / n,
            ((squares[k] - sum[k] * sum[k] / n) / (n - 1.0)).sqrt()
        );
    }
    let total = n * count as f64;
    let pooled = covered.iter().sum::<u64>() as f64 / total;
    let lowest = covered.iter().min().copied().unwrap_or(0) as f64 / n;
    let highest = covered.iter().max().copied().unwrap_or(0) as f64 / n;
    println!(
        "\nPooled over constants and seeds: {:.2} % inside, lowest constant {:.1} %, highest {:.1} %; \
         standardised errors have SD {:.3}.",
        100.0 * pooled,
        100.0 * lowest,
        100.0 * highest,
        (squares.iter().sum::<f64>() / total).sqrt()
    );
    Ok(())
}
