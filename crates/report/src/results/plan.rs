//! `armident plan`: the experiment list as text. Its JSON is the plan itself.

use armident_ident::experiment::Plan;

use crate::layout::{aligned, significant};

/// The experiments and steps of a plan, for people.
pub fn plan_text(plan: &Plan) -> String {
    let mut text = format!(
        "{}: {} experiments, {} steps of Algorithm 2\n\nExperiments (one joint moves out and back; the others are held)\n",
        plan.robot,
        plan.experiments.len(),
        plan.steps.len()
    );
    let rows: Vec<Vec<String>> = plan
        .experiments
        .iter()
        .map(|e| {
            let held: Vec<String> = plan
                .joints
                .iter()
                .map(|joint| match e.held.get(joint) {
                    Some(at) => format!("{at:.3}"),
                    None => "moves".to_owned(),
                })
                .collect();
            vec![
                e.id.clone(),
                e.moving.clone(),
                format!("{:.3}", e.motion.start),
                format!("{:.3}", e.motion.amplitude),
                format!("{:.2}", e.motion.sigma_per_s),
                format!("{:.2}", e.motion.duration_s()),
                held.join(" "),
            ]
        })
        .collect();
    text += &aligned(
        &[
            "id",
            "joint",
            "start",
            "amplitude",
            "sigma [1/s]",
            "time [s]",
            "positions of all joints",
        ],
        &rows,
        2,
    );
    text += "\nSteps (distal joints first; signal: RMS effort due to the parameters)\n";
    let rows: Vec<Vec<String>> = plan
        .steps
        .iter()
        .map(|s| {
            vec![
                s.step.clone(),
                s.equation.clone(),
                s.observed.clone(),
                s.unknowns.join(" "),
                s.experiments.join(" "),
                significant(s.condition, 3, 0.0),
                significant(s.signal_rms, 3, 0.0),
                match (s.signal_to_stiction(), s.coulomb_assumed) {
                    (Some(ratio), true) => format!("~{}", significant(ratio, 2, 0.0)),
                    (Some(ratio), false) => significant(ratio, 2, 0.0),
                    (None, _) => "?".to_owned(),
                },
            ]
        })
        .collect();
    text += &aligned(
        &[
            "step",
            "equation",
            "observed",
            "parameters",
            "experiments",
            "condition",
            "signal RMS",
            "signal/stiction",
        ],
        &rows,
        5,
    );
    text += "\n~: Coulomb level assumed to be 3 % of the effort limit; set it with --coulomb joint=LEVEL\n";
    text += &format!("\n{}\n", plan.holding);
    for note in &plan.notes {
        text += &format!("note: {note}\n");
    }
    text
}
