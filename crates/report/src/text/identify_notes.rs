//! What an identification reports besides its numbers: choices as notes, doubts as warnings.

use armident_ident::{CouplingFound, EstimateNote, Identification, SublinearFound};

/// Share of a direction that counts as not identified.
const NOT_IDENTIFIED: f64 = 1e-3;

/// What was chosen on the way.
pub(crate) fn notes(found: &Identification) -> Vec<String> {
    let joints = found.model.chain.joint_names();
    let mut notes = Vec::new();
    for CouplingFound { coupling, gain } in &found.structure.couplings {
        let [a, b] = coupling.joints().map(|joint| joints[joint]);
        notes.push(format!(
            "{a} and {b}: coupled transmission included (ratio {}, cross-validated error {:.0} % lower)",
            coupling.ratio,
            100.0 * gain
        ));
    }
    let chain = &found.model.chain.joints;
    for (joint, reversal) in chain.iter().zip(found.problem.reversals.iter().flatten()) {
        if reversal.presliding_travel() > 0.0 {
            let unit = if joint.kind.is_rotational() { "mrad" } else { "mm" };
            notes.push(format!(
                "{}: presliding friction included (travel {:.2} {unit}, selected by cross-validation)",
                joint.name,
                1e3 * reversal.presliding_travel()
            ));
        }
    }
    for SublinearFound { joint, t } in &found.structure.sublinear {
        notes.push(format!(
            "{}: sublinear viscous friction included (t = {t:.0}); disable with --viscous linear",
            joints[*joint]
        ));
    }
    if let Some(gain) = found.velocity_gain {
        notes.push(format!(
            "using recorded velocities (error {:.1} % lower than with differentiated positions)",
            100.0 * gain
        ));
    }
    for ((name, share), dead_zone) in
        joints.iter().zip(&found.dead_zone_shares).zip(&found.dead_zones)
    {
        let (Some(share), Some(dead_zone)) = (share, dead_zone) else { continue };
        notes.push(format!(
            "{name}: effort column has a dead zone (one value in {:.0} % of the moving samples); the column counts as a \
             single sample. It shows {:.1} % of the modelled effort, and predictions of it are scaled accordingly",
            100.0 * share,
            100.0 * dead_zone.share
        ));
    }
    notes.extend(found.estimate.notes.iter().filter_map(|note| match note {
        EstimateNote::Remark(remark) => Some(remark.clone()),
        _ => None,
    }));
    notes
}

/// What is doubtful about the estimate; warnings about the links are those of their projection.
pub(crate) fn warnings(found: &Identification) -> Vec<String> {
    let joints = found.model.chain.joint_names();
    let mut warnings = Vec::new();
    if found.drive_gains.as_ref().is_some_and(|gains| !gains.absolute) {
        warnings.push(
            "drive gains are known only relative to each other: no recording has a known payload \
             (--payload) and no joint an effort in N m or N. They are scaled to match the URDF \
             inertias; all constants share this scale [only-ratios]"
                .to_owned(),
        );
    }
    // beyond three standard errors, and a percent
    if let Some((gain, error)) = found.effort_of_load
        && gain.ln().abs() > f64::max(3.0 * error, 0.01)
    {
        let [low, high] = [-1.96, 1.96].map(|deviations| gain * (deviations * error).exp());
        warnings.push(format!(
            "the known payload requires {gain:.3} times the recorded efforts (95 % interval {low:.3} to {high:.3}): the efforts \
             have another scale, or its mass is wrong [payload-contradicts]"
        ));
    }
    let (problem, estimate) = (&found.problem, &found.estimate);
    if estimate.rank < problem.terms.len() {
        let open: Vec<String> = (0..problem.terms.len())
            .filter(|&k| estimate.undetermined[k] > NOT_IDENTIFIED)
            .map(|k| problem.label(&problem.terms[k], &joints))
            .collect();
        warnings.push(format!(
            "the recordings identify {} of {} parameters; not identified: combinations of {} \
             [not-determined]",
            estimate.rank,
            problem.terms.len(),
            open.join(", ")
        ));
    }
    warnings
}
