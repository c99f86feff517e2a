//! From a URDF or a model file and the chain options to the arm.

use std::path::Path;

use armident_diagnose::{DiagnosedModel, Learned};
use armident_ident::ArmModel;
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};

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

/// What to say about a chain beside its warnings.
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
            format!("{option} cannot change a model file: its chain is fixed"),
            path.display(),
            Some("give the URDF instead, or leave the option out"),
        ));
    }
    ArmModel::load(path).map_err(|error| Failure::model(path, &error))
}

/// Loads the arm with all that its file holds: of a model that a diagnosis wrote, what it learned too.
pub(crate) fn load_whole(
    path: &Path,
    chain: &ChainArgs,
    recorded: Option<&[String]>,
) -> Result<(ArmModel, Option<Learned>), Failure> {
    let model = load(path, chain, recorded)?;
    let learned = learned(path, &model)?;
    Ok((model, learned))
}

/// The arm with all that a diagnosis learned as effects on it, and what of it a simulated arm cannot hold.
pub(crate) fn as_simulated(
    path: &Path,
    model: ArmModel,
) -> Result<(ArmModel, Vec<String>), Failure> {
    Ok(match learned(path, &model)? {
        Some(learned) => DiagnosedModel { arm: model, learned }.as_simulated(),
        None => (model, Vec::new()),
    })
}

/// What a diagnosis learned, if the file is a model that holds it.
fn learned(path: &Path, model: &ArmModel) -> Result<Option<Learned>, Failure> {
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
        return Ok(None);
    }
    let text = std::fs::read_to_string(path)
        .map_err(|error| Failure::model(path, &armident_ident::ModelError::Unreadable(error)))?;
    Learned::in_model_file(&text, &model.chain.joint_names()).map_err(|error| {
        Failure::new(
            error,
            path.display(),
            Some("write the model again with `armident diagnose --save-model`"),
        )
    })
}
