//! An arm with everything that is known about it: what `predict` and `simulate` run, and what
//! `model.json` holds.

use std::collections::BTreeMap;
use std::path::Path;

use armident_dynamics::{RigidArm, inverse_dynamics_of_motion};
use armident_effects::{EffectOnJoint, Turn, UnknownEffect};
use armident_kinematics::{
    AxisPair, DrivingAxisChain, DrivingAxisFrame, DrivingAxisJoint, InertialParameters, JointKind,
    JointLimits,
};
use armident_motion::{Motion, with_recorded_velocity};
use armident_recording::Recording;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::dead_zone::Shown;
use crate::effect_columns::{effect_columns, pair_columns};

/// Schema of `model.json`.
pub const MODEL_SCHEMA: &str = "armident.model/1";

/// A chain with its links, effects on its joints, and the filter they were found with.
#[derive(Debug, Clone)]
pub struct ArmModel {
    /// Geometry, links and gravity.
    pub chain: DrivingAxisChain,
    /// Effects beyond the rigid body.
    pub effects: Vec<EffectOnJoint>,
    /// Cut-off of the low-pass the model was estimated with \[Hz\]; predictions use it too.
    pub cutoff_hz: Option<f64>,
    /// Whether the model was fitted with recorded velocities in the place of differentiated positions;
    /// predictions use them too where a motion has them.
    pub recorded_velocities: bool,
    /// How each joint's dry friction turns.
    pub turns: Option<Vec<Turn>>,
    /// Noise level of each joint's effort in the fit \[N m or N\], after the low-pass of `cutoff_hz` or, without one,
    /// as recorded; none for a URDF.
    pub effort_noise: Option<Vec<f64>>,
    /// What columns show that leave small efforts out, by joint; predictions of these columns follow it, the links and
    /// effects do not.
    pub shown: Option<Vec<Option<Shown>>>,
    /// The links before the fit, those of the URDF; none for a URDF itself.
    pub prior_links: Option<Vec<InertialParameters>>,
    /// Where the numbers come from, one sentence each.
    pub provenance: Vec<String>,
}

/// Why a model file cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// The file cannot be read.
    #[error("the model file cannot be read: {0}")]
    Unreadable(std::io::Error),
    /// The file is not JSON of the expected form.
    #[error("the model file is not valid: {message}")]
    Invalid {
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// Another schema.
    #[error("the file has schema `{found}`, expected `{MODEL_SCHEMA}`")]
    Schema {
        /// What the file says.
        found: String,
    },
    /// A chain without joints, numbers that are not finite, and the like.
    #[error("the model is inconsistent: {0}")]
    Inconsistent(String),
    /// An effect the library does not know.
    #[error(transparent)]
    Effect(#[from] UnknownEffect),
}

impl ArmModel {
    /// The model a URDF describes: its rigid body and nothing else.
    pub fn from_chain(chain: DrivingAxisChain) -> Self {
        let provenance = vec![format!("inertials of {}", chain.source)];
        Self {
            chain,
            effects: Vec::new(),
            cutoff_hz: None,
            recorded_velocities: false,
            turns: None,
            effort_noise: None,
            shown: None,
            prior_links: None,
            provenance,
        }
    }

    /// The same arm with other links, one per joint, in the frames of the joints.
    #[must_use]
    pub fn with_links(mut self, links: &[InertialParameters]) -> Self {
        let before = self.chain.joints.iter().map(|j| j.link).collect();
        self.prior_links.get_or_insert(before);
        for (joint, link) in self.chain.joints.iter_mut().zip(links) {
            joint.link = *link;
        }
        self
    }

    /// The model before the fit: the prior links and no effects. A URDF is its own.
    #[must_use]
    pub fn before(&self) -> Self {
        let mut model = self.clone();
        model.effects.clear();
        model.effort_noise = None;
        model.shown = None;
        if let Some(links) = model.prior_links.take() {
            for (joint, link) in model.chain.joints.iter_mut().zip(links) {
                joint.link = link;
            }
        }
        model
    }

    /// The motion as the model wants it: with its recorded velocities if the model was fitted so.
    pub fn motion_of(&self, motion: Motion, recording: &Recording) -> Motion {
        if !self.recorded_velocities {
            return motion;
        }
        with_recorded_velocity(&motion, recording).unwrap_or(motion)
    }

    /// The rigid body alone.
    pub fn rigid_arm(&self) -> RigidArm {
        RigidArm::from_chain(&self.chain)
    }

    /// What predictions have that is no part of a simulated arm: friction that builds up over a travel, which turns at once
    /// there, and columns that show a share of the efforts.
    pub fn of_predictions_alone(&self) -> Vec<String> {
        let names = || self.chain.joints.iter().map(|joint| &joint.name);
        let turns =
            names().zip(self.turns.iter().flatten()).filter(|(_, turn)| turn.travel() > 0.0);
        let turns = turns.map(|(name, turn)| {
            format!("dry friction of {name} building up over {:.5} rad or m", turn.travel())
        });
        let shown = names().zip(self.shown.iter().flatten());
        let shown = shown.filter_map(|(name, shown)| {
            let percent = 100.0 * shown.as_ref()?.share;
            Some(format!("the {percent:.1} % of its effort that the column of {name} shows"))
        });
        turns.chain(shown).collect()
    }

    /// Effort of every joint on the grid of a motion, as its column shows it, joint-major, not filtered afterwards.
    ///
    /// # Errors
    /// [`UnknownEffect`] when an effect is not in the library.
    pub fn predict(&self, motion: &Motion) -> Result<Vec<Vec<f64>>, UnknownEffect> {
        let mut effort = inverse_dynamics_of_motion(
            &self.rigid_arm(),
            &motion.position,
            &motion.velocity,
            &motion.acceleration,
        );
        for on_joint in &self.effects {
            let effect = on_joint.resolve()?;
            let index = |name: &str| self.chain.joints.iter().position(|j| j.name == name);
            let Some(joint) = index(&on_joint.joint) else { continue };
            if let Some(other) = on_joint.other_joint.as_deref().and_then(index) {
                let kinds = [joint, other].map(|j| self.chain.joints[j].kind);
                let (shape, coefficients) = effect.shape_and_coefficients(&on_joint.parameters);
                let columns = pair_columns(effect, &shape, [joint, other], kinds, motion);
                for (column, parameter) in columns.iter().zip(&coefficients) {
                    for (on, column) in [joint, other].into_iter().zip(column) {
                        for (e, x) in effort[on].iter_mut().zip(column) {
                            *e += parameter * x;
                        }
                    }
                }
                continue;
            }
            let turn = self.turns.as_ref().map(|turns| turns[joint]);
            let (shape, coefficients) = effect.shape_and_coefficients(&on_joint.parameters);
            let kind = self.chain.joints[joint].kind;
            let columns = effect_columns(effect, &shape, kind, joint, motion, turn);
            for (column, parameter) in columns.iter().zip(&coefficients) {
                for (e, x) in effort[joint].iter_mut().zip(column) {
                    *e += parameter * x;
                }
            }
        }
        for (effort, shown) in effort.iter_mut().zip(self.shown.iter().flatten()) {
            if let Some(shown) = shown {
                shown.of(effort);
            }
        }
        Ok(effort)
    }

    /// Writes the model as JSON.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn save(&self, path: &Path) -> std::io::Result<()> {
        let text = self.to_json()? + "\n";
        armident_recording::write_whole(path, |file| file.write_all(text.as_bytes()))
    }

    /// The model file as text.
    ///
    /// # Errors
    /// When a number cannot be put into JSON.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(&ModelFile::from(self))
    }

    /// Reads a model written by [`Self::save`].
    ///
    /// # Errors
    /// [`ModelError`].
    pub fn load(path: &Path) -> Result<Self, ModelError> {
        let text = std::fs::read_to_string(path).map_err(ModelError::Unreadable)?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Reads a model from text; `source` names it in messages.
    ///
    /// # Errors
    /// [`ModelError`].
    pub fn parse(text: &str, source: &str) -> Result<Self, ModelError> {
        let invalid = |error: serde_json::Error| ModelError::Invalid {
            line: error.line(),
            message: error.to_string(),
        };
        let value: serde_json::Value = serde_json::from_str(text).map_err(invalid)?;
        let schema = value.get("schema").and_then(serde_json::Value::as_str).unwrap_or("none");
        if schema != MODEL_SCHEMA {
            return Err(ModelError::Schema { found: schema.to_owned() });
        }
        let file: ModelFile = serde_json::from_str(text).map_err(invalid)?;
        file.into_model(source)
    }
}

#[derive(Serialize, Deserialize)]
struct ModelFile {
    schema: String,
    /// version of the program that wrote the file
    version: String,
    robot: String,
    base_link: String,
    tip_link: String,
    gravity_base: [f64; 3],
    gravity_e0: [f64; 3],
    base_from_e0: Pose,
    tip_in_e: Pose,
    locked: BTreeMap<String, f64>,
    joints: Vec<JointEntry>,
    axis_pairs: Vec<String>,
    effects: Vec<EffectOnJoint>,
    cutoff_hz: Option<f64>,
    #[serde(default)]
    recorded_velocities: bool,
    /// speeds below which dry friction turns, 0 where it turns over a travel
    #[serde(default)]
    speed_resolution: Option<Vec<f64>>,
    /// travels over which it turns, 0 where it turns with the speed
    #[serde(default, skip_serializing_if = "Option::is_none")]
    turning_travel: Option<Vec<f64>>,
    #[serde(default)]
    effort_noise: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    shown: Option<Vec<Option<Shown>>>,
    /// ten parameters a link, as in the joints
    #[serde(default)]
    prior_links: Option<Vec<[f64; 10]>>,
    provenance: Vec<String>,
}

#[derive(Serialize, Deserialize)]
struct JointEntry {
    name: String,
    kind: String,
    b: f64,
    d: f64,
    beta: f64,
    theta: f64,
    child_link: String,
    body_links: Vec<String>,
    child_link_in_e: Pose,
    lower: Option<f64>,
    upper: Option<f64>,
    effort: Option<f64>,
    velocity: Option<f64>,
    /// m, mcx, mcy, mcz, Ixx, Ixy, Ixz, Iyy, Iyz, Izz about the origin of E
    link: [f64; 10],
}

/// Position \[m\] and quaternion (w, x, y, z).
#[derive(Serialize, Deserialize, Clone, Copy)]
struct Pose {
    position: [f64; 3],
    quaternion_wxyz: [f64; 4],
}

impl From<&Isometry3<f64>> for Pose {
    fn from(pose: &Isometry3<f64>) -> Self {
        let (t, q) = (pose.translation, pose.rotation);
        Self { position: [t.x, t.y, t.z], quaternion_wxyz: [q.w, q.i, q.j, q.k] }
    }
}

impl Pose {
    fn isometry(self) -> Isometry3<f64> {
        let [w, i, j, k] = self.quaternion_wxyz;
        let [x, y, z] = self.position;
        Isometry3::from_parts(
            Translation3::new(x, y, z),
            UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k)),
        )
    }

    fn is_sound(self) -> bool {
        let norm: f64 = self.quaternion_wxyz.iter().map(|x| x * x).sum();
        self.position.iter().all(|x| x.is_finite()) && (norm - 1.0).abs() < 1e-9
    }
}

impl From<&ArmModel> for ModelFile {
    fn from(model: &ArmModel) -> Self {
        let chain = &model.chain;
        let vector = |v: &Vector3<f64>| [v.x, v.y, v.z];
        let of_turns = |of: fn(Turn) -> f64| -> Option<Vec<f64>> {
            model.turns.as_ref().map(|turns| turns.iter().map(|turn| of(*turn)).collect())
        };
        Self {
            schema: MODEL_SCHEMA.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            robot: chain.robot.clone(),
            base_link: chain.base_link.clone(),
            tip_link: chain.tip_link.clone(),
            gravity_base: vector(&chain.gravity_base),
            gravity_e0: vector(&chain.gravity_e0),
            base_from_e0: (&chain.base_from_e0).into(),
            tip_in_e: (&chain.tip_in_e).into(),
            locked: chain.locked.clone(),
            joints: chain
                .joints
                .iter()
                .map(|j| JointEntry {
                    name: j.name.clone(),
                    kind: j.kind.letter().to_string(),
                    b: j.frame.b_m,
                    d: j.frame.d_m,
                    beta: j.frame.beta_rad,
                    theta: j.frame.theta_rad,
                    child_link: j.child_link.clone(),
                    body_links: j.body_links.clone(),
                    child_link_in_e: (&j.child_link_in_e).into(),
                    lower: j.limits.lower,
                    upper: j.limits.upper,
                    effort: j.limits.effort,
                    velocity: j.limits.velocity,
                    link: j.link.to_array(),
                })
                .collect(),
            axis_pairs: chain.axis_pairs.iter().map(|p| p.name().to_owned()).collect(),
            effects: model.effects.clone(),
            cutoff_hz: model.cutoff_hz,
            recorded_velocities: model.recorded_velocities,
            speed_resolution: of_turns(Turn::speed),
            turning_travel: of_turns(Turn::travel).filter(|all| all.iter().any(|x| *x > 0.0)),
            effort_noise: model.effort_noise.clone(),
            shown: model.shown.clone(),
            prior_links: model
                .prior_links
                .as_ref()
                .map(|links| links.iter().map(InertialParameters::to_array).collect()),
            provenance: model.provenance.clone(),
        }
    }
}

impl ModelFile {
    fn into_model(self, source: &str) -> Result<ArmModel, ModelError> {
        let bad = |what: String| Err(ModelError::Inconsistent(what));
        if self.joints.is_empty() {
            return bad("it has no joints".to_owned());
        }
        if self.axis_pairs.len() + 1 != self.joints.len() {
            return bad("axis_pairs must have one entry fewer than joints".to_owned());
        }
        if !self.base_from_e0.is_sound() || !self.tip_in_e.is_sound() {
            return bad("a pose is not finite or its quaternion is not of unit length".to_owned());
        }
        let mut joints: Vec<DrivingAxisJoint> = Vec::new();
        for entry in self.joints {
            let kind = match entry.kind.as_str() {
                "R" => JointKind::Rotational,
                "P" => JointKind::Translational,
                other => {
                    return bad(format!(
                        "joint `{}` has kind `{other}`, expected R or P",
                        entry.name
                    ));
                }
            };
            let numbers = [entry.b, entry.d, entry.beta, entry.theta];
            if numbers.iter().chain(&entry.link).any(|x| !x.is_finite())
                || !entry.child_link_in_e.is_sound()
            {
                return bad(format!("joint `{}` has numbers that are not finite", entry.name));
            }
            if joints.iter().any(|j| j.name == entry.name) {
                return bad(format!("joint `{}` occurs twice", entry.name));
            }
            joints.push(DrivingAxisJoint {
                name: entry.name,
                kind,
                frame: DrivingAxisFrame {
                    b_m: entry.b,
                    d_m: entry.d,
                    beta_rad: entry.beta,
                    theta_rad: entry.theta,
                },
                link: InertialParameters::from_array(&entry.link),
                child_link: entry.child_link,
                body_links: entry.body_links,
                child_link_in_e: entry.child_link_in_e.isometry(),
                limits: JointLimits {
                    lower: entry.lower,
                    upper: entry.upper,
                    effort: entry.effort,
                    velocity: entry.velocity,
                },
                dynamics: None,
            });
        }
        let count = joints.len();
        let links_fit = self
            .prior_links
            .as_ref()
            .is_none_or(|l| l.len() == count && l.iter().flatten().all(|x| x.is_finite()));
        let sizes_fit = |sizes: &Option<Vec<f64>>| {
            let fit =
                |s: &Vec<f64>| s.len() == count && s.iter().all(|x| x.is_finite() && *x >= 0.0);
            sizes.as_ref().is_none_or(fit)
        };
        let is_sound =
            |s: &Vec<Option<Shown>>| s.len() == count && s.iter().flatten().all(Shown::is_sound);
        if !self.shown.as_ref().is_none_or(is_sound) {
            return bad(
                "shown must have one entry per joint, null or a share from 0 to 1 and an offset"
                    .to_owned(),
            );
        }
        if !links_fit
            || !sizes_fit(&self.effort_noise)
            || !sizes_fit(&self.speed_resolution)
            || !sizes_fit(&self.turning_travel)
        {
            return bad(
                "prior_links, effort_noise, speed_resolution and turning_travel must have one finite entry per joint".to_owned()
            );
        }
        let travels = self.turning_travel.unwrap_or_else(|| vec![0.0; count]);
        let turns = self.speed_resolution.map(|speeds| {
            speeds.iter().zip(&travels).map(|(speed, travel)| Turn::of(*speed, *travel)).collect()
        });
        let axis_pairs = self
            .axis_pairs
            .iter()
            .map(|name| match name.as_str() {
                "skew" => Ok(AxisPair::Skew),
                "intersecting" => Ok(AxisPair::Intersecting),
                "parallel" => Ok(AxisPair::Parallel),
                "coincident" => Ok(AxisPair::Coincident),
                other => Err(ModelError::Inconsistent(format!("unknown axis pair `{other}`"))),
            })
            .collect::<Result<_, _>>()?;
        for effect in &self.effects {
            effect.resolve()?;
            if !joints.iter().any(|j| j.name == effect.joint) {
                return bad(format!(
                    "effect `{}` is on unknown joint `{}`",
                    effect.effect, effect.joint
                ));
            }
            if let Some(other) = &effect.other_joint
                && !joints.iter().any(|j| j.name == *other)
            {
                return bad(format!("effect `{}` is on unknown joint `{other}`", effect.effect));
            }
            if effect.parameters.iter().any(|p| !p.is_finite()) {
                return bad(format!("effect `{}` has numbers that are not finite", effect.effect));
            }
        }
        Ok(ArmModel {
            chain: DrivingAxisChain {
                robot: self.robot,
                source: source.to_owned(),
                base_link: self.base_link,
                tip_link: self.tip_link,
                tip_in_e: self.tip_in_e.isometry(),
                locked: self.locked,
                base_from_e0: self.base_from_e0.isometry(),
                gravity_base: Vector3::from(self.gravity_base),
                gravity_e0: Vector3::from(self.gravity_e0),
                joints,
                axis_pairs,
                snap_error: 0.0,
                ignored: Vec::new(),
                warnings: Vec::new(),
            },
            effects: self.effects,
            cutoff_hz: self.cutoff_hz,
            recorded_velocities: self.recorded_velocities,
            turns,
            effort_noise: self.effort_noise,
            shown: self.shown,
            prior_links: self
                .prior_links
                .map(|links| links.iter().map(InertialParameters::from_array).collect()),
            provenance: self.provenance,
        })
    }
}
