//! `armident plan`.

use std::path::PathBuf;

use armident_ident::MinimalSet;
use armident_ident::experiment::{Dither, Plan, PlanSettings, plan};
use armident_recording::{JointChannels, Recording, write_csv_to};
use armident_report::plan_text;

use crate::args::PlanArgs;
use crate::failure::Outcome;
use crate::progress::Progress;
use crate::{output, robot};
use armident_commands::{Failure, PLAN_FILE, chain_notes};

pub(crate) fn run(args: &PlanArgs) -> Result<Outcome, Failure> {
    output::protect([args.robot.as_path()], [args.output.json.as_ref()])?;
    let model = robot::open(&args.robot, &args.chain)?.arm(None)?;
    let set = MinimalSet::of(&model.rigid_arm())?;
    for (joint, _) in &args.coulomb {
        if !model.chain.joint_names().contains(&joint.as_str()) {
            return Err(Failure::new(
                format!("--coulomb: joint `{joint}` is not on the chain"),
                args.robot.display(),
                Some(format!("joints of the chain: {}", model.chain.joint_names().join(", "))),
            ));
        }
    }
    let settings = PlanSettings {
        rate_hz: args.rate_hz,
        amplitude_rad: args.amplitude,
        amplitude_m: args.amplitude_m,
        sigma_per_s: args.sigma,
        coulomb: args.coulomb.iter().cloned().collect(),
        dither: args.dither.map(|(amplitude, frequency_hz)| Dither { amplitude, frequency_hz }),
        seed: args.seed,
    };
    let plan = {
        let _progress = Progress::of(&args.output, "planning");
        plan(&model.chain, &set, &settings)?
    };
    output::create_folder(&args.output_folder)?;
    let document = serde_json::to_string_pretty(&plan).map_err(|error| {
        Failure::new(format!("cannot write JSON: {error}"), PLAN_FILE, None::<String>)
    })?;
    output::write_file(&args.output_folder.join(PLAN_FILE), (document + "\n").as_bytes())?;
    for experiment in &plan.experiments {
        let recording = trajectory(&plan, experiment)?;
        let mut bytes = Vec::new();
        write_csv_to(&mut bytes, &recording)?;
        let path: PathBuf = args.output_folder.join(format!("{}.csv", experiment.id));
        output::write_file(&path, &bytes)?;
    }
    let warnings: Vec<String> =
        model.chain.warnings.iter().map(ToString::to_string).chain(plan.notes.clone()).collect();
    output::say_all(&args.output, "note", &chain_notes(&model));
    output::write_result(&args.output, &plan_text(&plan), &plan, &warnings)
}

/// The planned motion of one experiment as a recording without efforts.
pub(crate) fn trajectory(
    plan: &Plan,
    experiment: &armident_ident::experiment::Experiment,
) -> Result<Recording, Failure> {
    let planned = plan.trajectory(experiment);
    let joints = plan
        .joints
        .iter()
        .zip(&planned.joints)
        .map(|(name, samples)| {
            let mut channels = JointChannels::new(name);
            channels.position = Some(samples.iter().map(|s| s.0).collect());
            channels.velocity = Some(samples.iter().map(|s| s.1).collect());
            channels.acceleration = Some(samples.iter().map(|s| s.2).collect());
            channels
        })
        .collect();
    Ok(Recording::new(&experiment.id, planned.time_s, joints)?)
}
