//! From a URDF or a model file and the chain options to the arm.

use std::path::Path;

use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_model::ArmModel;

use crate::args::ChainArgs;
use crate::failure::Failure;

/// Loads the arm; `recorded` are the joints of the recordings at hand.
pub(crate) fn load(
    path: &Path,
    chain: &ChainArgs,
    recorded: Option<&[String]>,
) -> Result<ArmModel, Failure> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
        return load_model(path, chain);
    }
    let robot = load_urdf(path)?;
    let default = ChainSelection::default();
    let selection = ChainSelection {
        base: chain.base.clone(),
        tip: chain.tip.clone(),
        recorded_joints: recorded.map(<[String]>::to_vec),
        locked: chain.lock.iter().cloned().collect(),
        gravity_base: chain.gravity.unwrap_or(default.gravity_base),
        snap_rpy_rad: chain.snap_rpy,
    };
    let serial = SerialChain::from_description(&robot, &selection)?;
    Ok(ArmModel::from_chain(DrivingAxisChain::from_chain(&serial)))
}

/// Notes on a chain, in addition to its warnings.
pub(crate) fn notes(model: &ArmModel) -> Vec<String> {
    model.chain.ignored_note().into_iter().collect()
}

fn load_model(path: &Path, chain: &ChainArgs) -> Result<ArmModel, Failure> {
    let chosen = [
        ("--base", chain.base.is_some()),
        ("--tip", chain.tip.is_some()),
        ("--lock", !chain.lock.is_empty()),
        ("--gravity", chain.gravity.is_some()),
    ];
    if let Some((option, _)) = chosen.iter().find(|(_, given)| *given) {
        return Err(Failure::new(
            format!("{option} cannot be used with a model file"),
            path.display(),
            Some("pass the URDF instead, or omit the option"),
        ));
    }
    ArmModel::load(path).map_err(|error| Failure::model(path, &error))
}

/// Loads the links of the arm, with a note on the other content of its file.
pub(crate) fn load_links(
    path: &Path,
    chain: &ChainArgs,
    recorded: Option<&[String]>,
) -> Result<(ArmModel, Option<String>), Failure> {
    let model = load(path, chain, recorded)?;
    let (simulated, mut beside) = model.simulated();
    let tilted = model.base_tilt_rad.iter().any(|x| *x != 0.0);
    beside.extend(tilted.then(|| "base tilt".to_owned()));
    let mut slugs: Vec<String> = simulated.effects.into_iter().map(|e| e.effect).collect();
    slugs.sort();
    slugs.dedup();
    slugs.extend(beside);
    let note = (!slugs.is_empty()).then(|| {
        format!("using only the links of {}; ignoring {}", path.display(), slugs.join(", "))
    });
    Ok((model.links_only(), note))
}
