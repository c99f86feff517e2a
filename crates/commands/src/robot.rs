//! From a URDF or a model file and the chain options to the arm.

use std::path::Path;

use armident_effects::{EffectOnJoint, Library};
use armident_kinematics::{
    ChainSelection, DrivingAxisChain, MjcfRobot, RobotDescription, SerialChain, is_mjcf, load_urdf,
    parse_mjcf,
};
use armident_model::ArmModel;

use crate::failure::Failure;

/// Part of the robot that is the arm.
#[derive(Debug, Clone)]
pub struct ChainOptions {
    /// First link of the chain; none: the root of the URDF.
    pub base: Option<String>,
    /// Last link of the chain; none: the tip that contains the recorded joints, else the path with the most movable
    /// joints.
    pub tip: Option<String>,
    /// Joints locked at a position \[rad or m\].
    pub lock: Vec<(String, f64)>,
    /// Gravity in the base link frame \[m/s²\].
    pub gravity: Option<[f64; 3]>,
    /// Tolerance within which URDF joint angles are snapped to multiples of pi/12 \[rad\].
    pub snap_rpy_rad: f64,
}

impl Default for ChainOptions {
    fn default() -> Self {
        Self {
            base: None,
            tip: None,
            lock: Vec::new(),
            gravity: None,
            snap_rpy_rad: ChainSelection::default().snap_rpy_rad,
        }
    }
}

/// A robot as given: a URDF or a model, and the part of it that is the arm.
#[derive(Debug, Clone)]
pub struct GivenRobot {
    /// Path of the file, or a description.
    pub source: String,
    given: Given,
    chain: ChainOptions,
}

#[derive(Debug, Clone)]
enum Given {
    Urdf(Box<RobotDescription>),
    Mjcf(Box<MjcfRobot>),
    Model(Box<ArmModel>),
}

impl GivenRobot {
    /// Names of the joints of the arm in order.
    ///
    /// # Errors
    /// A chain that cannot be chosen.
    pub fn joint_names(&self) -> Result<Vec<String>, Failure> {
        Ok(self.arm(None)?.chain.joints.into_iter().map(|joint| joint.name).collect())
    }

    /// Reads a URDF, MJCF, or a model file (`.json`), which has its chain already.
    ///
    /// # Errors
    /// A file that cannot be read or is not valid; chain options beside a model file.
    pub fn open(path: &Path, chain: ChainOptions) -> Result<Self, Failure> {
        let source = path.display().to_string();
        let is_model = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
        let given = if is_model {
            no_chain_options(&source, &chain)?;
            let model = ArmModel::load(path).map_err(|error| Failure::model(path, &error))?;
            Given::Model(Box::new(model))
        } else {
            match std::fs::read_to_string(path) {
                Ok(text) if is_mjcf(&text) => Given::Mjcf(Box::new(parse_mjcf(&text, &source)?)),
                _ => Given::Urdf(Box::new(load_urdf(path)?)),
            }
        };
        Ok(Self { source, given, chain })
    }

    /// A model in memory.
    pub fn of_model(source: impl Into<String>, model: ArmModel) -> Self {
        let given = Given::Model(Box::new(model));
        Self { source: source.into(), given, chain: ChainOptions::default() }
    }

    /// The same robot with another part of it as the arm.
    #[must_use]
    pub fn with_chain(&self, chain: ChainOptions) -> Self {
        Self { chain, ..self.clone() }
    }

    /// Part of the robot that is the arm.
    pub fn chain_options(&self) -> &ChainOptions {
        &self.chain
    }

    /// Whether a model was given.
    pub fn is_model(&self) -> bool {
        matches!(self.given, Given::Model(_))
    }

    /// The arm; `recorded` are the joints of the recordings at hand, which choose the tip of a URDF.
    ///
    /// # Errors
    /// A chain that cannot be chosen.
    pub fn arm(&self, recorded: Option<&[String]>) -> Result<ArmModel, Failure> {
        let robot = match &self.given {
            Given::Model(model) => return Ok((**model).clone()),
            Given::Urdf(robot) => robot,
            Given::Mjcf(robot) => &robot.description,
        };
        let chain = &self.chain;
        let mut default = ChainSelection::default();
        if let Given::Mjcf(robot) = &self.given {
            default.gravity_base = robot.gravity;
        }
        let selection = ChainSelection {
            base: chain.base.clone(),
            tip: chain.tip.clone(),
            recorded_joints: recorded.map(<[String]>::to_vec),
            locked: chain.lock.iter().cloned().collect(),
            gravity_base: chain.gravity.unwrap_or(default.gravity_base),
            snap_rpy_rad: chain.snap_rpy_rad,
        };
        let serial = SerialChain::from_description(robot, &selection)?;
        let mut arm = ArmModel::from_chain(DrivingAxisChain::from_chain(&serial));
        if let Given::Mjcf(robot) = &self.given {
            arm.effects = effects_of(robot, &arm);
        }
        Ok(arm)
    }

    /// The links of the arm, with a note on the other content of its file.
    ///
    /// # Errors
    /// A chain that cannot be chosen.
    pub fn links(
        &self,
        recorded: Option<&[String]>,
    ) -> Result<(ArmModel, Option<String>), Failure> {
        let model = self.arm(recorded)?;
        let (simulated, mut beside) = model.simulated();
        let tilted = model.base_tilt_rad.iter().any(|x| *x != 0.0);
        beside.extend(tilted.then(|| "base tilt".to_owned()));
        let mut slugs: Vec<String> = simulated.effects.into_iter().map(|e| e.effect).collect();
        slugs.sort();
        slugs.dedup();
        slugs.extend(beside);
        let note = (!slugs.is_empty()).then(|| {
            format!("using only the links of {}; ignoring {}", self.source, slugs.join(", "))
        });
        Ok((model.links_only(), note))
    }
}

/// What the joints of a simulator's model lose and their rotors add, as the laws that hold it.
fn effects_of(robot: &MjcfRobot, arm: &ArmModel) -> Vec<EffectOnJoint> {
    let laws: Vec<_> = Library::standard().all().map(|effect| effect.law()).collect();
    let on_joint = |value: &armident_kinematics::MjcfJointValue| {
        arm.chain.joints.iter().find(|joint| joint.name == value.joint)?;
        let law = laws.iter().find(|law| law.export.mjcf == Some(value.attribute))?;
        Some(EffectOnJoint::new(law.slug, &value.joint, [value.value]))
    };
    robot.joint_values.iter().filter_map(on_joint).collect()
}

/// Notes on a chain, in addition to its warnings.
pub fn chain_notes(model: &ArmModel) -> Vec<String> {
    model.chain.ignored_note().into_iter().collect()
}

/// Warnings on a chain.
pub fn chain_warnings(model: &ArmModel) -> Vec<String> {
    model.chain.warnings.iter().map(ToString::to_string).collect()
}

fn no_chain_options(source: &str, chain: &ChainOptions) -> Result<(), Failure> {
    let chosen = [
        ("--base", chain.base.is_some()),
        ("--tip", chain.tip.is_some()),
        ("--lock", !chain.lock.is_empty()),
        ("--gravity", chain.gravity.is_some()),
    ];
    match chosen.iter().find(|(_, given)| *given) {
        Some((option, _)) => Err(Failure::new(
            format!("{option} cannot be used with a model file"),
            source,
            Some("pass the URDF instead, or omit the option"),
        )),
        None => Ok(()),
    }
}
