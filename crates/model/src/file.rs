//! The model file: JSON of schema 2, which reads files of schema 1.

use std::collections::BTreeMap;
use std::path::Path;

use armident_effects::{EffectOnJoint, Library, ReversalModel, Scope, UnknownEffect};
use armident_kinematics::{
    AxisPair, DrivingAxisChain, DrivingAxisFrame, DrivingAxisJoint, InertialParameters, JointKind,
    JointLimits,
};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::arm_model::{ArmModel, BandPrediction, DriveGainsKnown};
use crate::dead_zone::DeadZone;
use crate::servo::{ServoTerm, check_servos};
use crate::smooth_term::SmoothTerm;
use crate::transmission::TransmissionTerm;

/// Schema of the model files that are written.
pub const MODEL_SCHEMA: &str = "armident.model/2";
/// Schemas of the files that are read.
const READ_SCHEMAS: [&str; 2] = [MODEL_SCHEMA, "armident.model/1"];

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
    #[error("the file has schema `{found}`, expected `{MODEL_SCHEMA}` or `armident.model/1`")]
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
        if !READ_SCHEMAS.contains(&schema) {
            return Err(ModelError::Schema { found: schema.to_owned() });
        }
        let mut file: ModelFile = serde_json::from_str(text).map_err(invalid)?;
        if let Some(learned) = file.learned.take() {
            learned.into_file(&mut file);
        }
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
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    transmissions: Vec<TransmissionTerm>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    smooth_terms: Vec<SmoothTerm>,
    #[serde(default)]
    base_tilt_rad: [f64; 2],
    /// recorded minus true position, one a joint; none in files of schema 1
    #[serde(default)]
    encoder_offset: Vec<f64>,
    #[serde(default)]
    effort_delay_s: f64,
    #[serde(default, skip_serializing_if = "is_zero")]
    effort_low_pass_s: f64,
    #[serde(default, skip_serializing_if = "is_zero")]
    effort_clock_drift: f64,
    /// one a joint; none in files of schema 1
    #[serde(default)]
    channel_gain: Vec<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    band: Option<BandPrediction>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    drive_gains: Option<DriveGainsKnown>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    servos: Vec<ServoTerm>,
    /// what a diagnosis found, in files of schema 1
    #[serde(default, skip_serializing)]
    learned: Option<Learned>,
    /// speeds below which dry friction is regularised, 0 where it builds up over a travel
    #[serde(default)]
    speed_resolution: Option<Vec<f64>>,
    /// travels over which it builds up after a reversal, 0 where it follows the speed
    #[serde(default, skip_serializing_if = "Option::is_none")]
    turning_travel: Option<Vec<f64>>,
    #[serde(default)]
    effort_noise: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    shown: Option<Vec<Option<DeadZone>>>,
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
        let of_reversals = |of: fn(ReversalModel) -> f64| -> Option<Vec<f64>> {
            model
                .reversals
                .as_ref()
                .map(|reversals| reversals.iter().map(|reversal| of(*reversal)).collect())
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
            speed_resolution: of_reversals(ReversalModel::regularised_below),
            turning_travel: of_reversals(ReversalModel::presliding_travel)
                .filter(|all| all.iter().any(|x| *x > 0.0)),
            transmissions: model.transmissions.clone(),
            smooth_terms: model.smooth_terms.clone(),
            base_tilt_rad: model.base_tilt_rad,
            encoder_offset: model.encoder_offset.clone(),
            effort_delay_s: model.effort_delay_s,
            effort_low_pass_s: model.effort_low_pass_s,
            effort_clock_drift: model.effort_clock_drift,
            channel_gain: model.channel_gain.clone(),
            band: model.band.clone(),
            drive_gains: model.drive_gains.clone(),
            servos: model.servos.clone(),
            learned: None,
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
                shapes: Vec::new(),
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
        let is_sound = |s: &Vec<Option<DeadZone>>| {
            s.len() == count && s.iter().flatten().all(DeadZone::is_sound)
        };
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
        let reversals = self.speed_resolution.map(|speeds| {
            speeds
                .iter()
                .zip(&travels)
                .map(|(speed, travel)| ReversalModel::of(*speed, *travel))
                .collect()
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
        let mut numbers = ChannelTerms {
            base_tilt_rad: self.base_tilt_rad,
            encoder_offset: self.encoder_offset,
            effort_delay_s: self.effort_delay_s,
            effort_low_pass_s: self.effort_low_pass_s,
            effort_clock_drift: self.effort_clock_drift,
            channel_gain: self.channel_gain,
        };
        numbers.check(count).map_err(ModelError::Inconsistent)?;
        let names: Vec<&str> = joints.iter().map(|j| j.name.as_str()).collect();
        check_terms(&names, &self.effects, &self.transmissions, &self.smooth_terms)
            .map_err(ModelError::Inconsistent)?;
        if self.drive_gains.as_ref().is_some_and(|gains| !gains.is_sound()) {
            return bad("drive_gains must have one finite gain and variance per joint".to_owned());
        }
        check_servos(&self.servos, &names).map_err(ModelError::Inconsistent)?;
        if let Some(band) = &self.band {
            check_band(band, count).map_err(ModelError::Inconsistent)?;
        }
        Ok(ArmModel {
            chain: DrivingAxisChain {
                robot: self.robot,
                source: source.to_owned(),
                base_link: self.base_link,
                tip_link: self.tip_link,
                tip_in_e: self.tip_in_e.isometry(),
                base_shapes: Vec::new(),
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
            library: Library::standard().clone(),
            cutoff_hz: self.cutoff_hz,
            recorded_velocities: self.recorded_velocities,
            reversals,
            effort_noise: self.effort_noise,
            shown: self.shown,
            prior_links: self
                .prior_links
                .map(|links| links.iter().map(InertialParameters::from_array).collect()),
            provenance: self.provenance,
            transmissions: self.transmissions,
            smooth_terms: self.smooth_terms,
            base_tilt_rad: numbers.base_tilt_rad,
            encoder_offset: numbers.encoder_offset,
            effort_delay_s: numbers.effort_delay_s,
            effort_low_pass_s: numbers.effort_low_pass_s,
            effort_clock_drift: numbers.effort_clock_drift,
            channel_gain: numbers.channel_gain,
            band: self.band,
            drive_gains: self.drive_gains,
            servos: self.servos,
        })
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// Terms of the channels and the base, as a file has them.
struct ChannelTerms {
    base_tilt_rad: [f64; 2],
    encoder_offset: Vec<f64>,
    effort_delay_s: f64,
    effort_low_pass_s: f64,
    effort_clock_drift: f64,
    channel_gain: Vec<f64>,
}

impl ChannelTerms {
    /// Checks that there is a usable number for each joint, and fills what a file of schema 1 has none of.
    fn check(&mut self, joints: usize) -> Result<(), String> {
        for (list, values, none) in [
            ("encoder_offset", &mut self.encoder_offset, 0.0),
            ("channel_gain", &mut self.channel_gain, 1.0),
        ] {
            if values.is_empty() {
                *values = vec![none; joints];
            }
            if values.len() != joints {
                let found = values.len();
                return Err(format!(
                    "`{list}` has {found} entries, expected {joints}, one a joint"
                ));
            }
        }
        finite("base_tilt_rad", &self.base_tilt_rad, f64::MIN)?;
        finite("encoder_offset", &self.encoder_offset, f64::MIN)?;
        finite("effort_delay_s", &[self.effort_delay_s], f64::MIN)?;
        finite("effort_low_pass_s", &[self.effort_low_pass_s], 0.0)?;
        finite("effort_clock_drift", &[self.effort_clock_drift], -0.5)?;
        finite("channel_gain", &self.channel_gain, f64::MIN)
    }
}

/// Whether all numbers of a list can be used.
fn finite(list: &str, values: &[f64], least: f64) -> Result<(), String> {
    match values.iter().find(|x| !x.is_finite() || **x < least) {
        Some(x) => Err(format!("`{list}` has the number {x}")),
        None => Ok(()),
    }
}

fn check_band(band: &BandPrediction, joints: usize) -> Result<(), String> {
    let found = band.output_cutoff_hz.len();
    if found != joints {
        return Err(format!(
            "`output_cutoff_hz` has {found} entries, expected {joints}, one a joint"
        ));
    }
    finite("rigid_cutoff_hz", &[band.rigid_cutoff_hz], f64::MIN_POSITIVE)?;
    let cutoffs: Vec<f64> = band.output_cutoff_hz.iter().copied().flatten().collect();
    finite("output_cutoff_hz", &cutoffs, f64::MIN_POSITIVE)
}

/// Whether couplings, transmissions and smooth terms are of joints that are there, and all their numbers can be used.
fn check_terms(
    joints: &[&str],
    effects: &[EffectOnJoint],
    transmissions: &[TransmissionTerm],
    smooth_terms: &[SmoothTerm],
) -> Result<(), String> {
    let place = |list: &str, name: &str| {
        let unknown = || {
            let known = joints.join(", ");
            format!("`{list}` is on unknown joint `{name}`, known are {known}")
        };
        joints.iter().position(|j| *j == name).ok_or_else(unknown)
    };
    for coupling in effects {
        let Ok(law) = coupling.resolve() else { continue };
        if law.law().scope != Scope::Neighbours {
            continue;
        }
        let first = place("effects", &coupling.joint)?;
        match coupling.other_joint.as_deref() {
            None => {
                return Err(format!(
                    "`{}` on `{}` has no other joint",
                    coupling.effect, coupling.joint
                ));
            }
            Some(other) if place("effects", other)? == first => {
                return Err(format!("`{}` couples `{other}` with itself", coupling.effect));
            }
            Some(_) => {}
        }
    }
    for term in transmissions {
        place("transmissions", &term.joint)?;
        let between = term.transmission;
        finite("transmissions", &[term.share, term.motor_inertia], f64::MIN)?;
        finite("transmissions", &[between.gap, between.damping], 0.0)?;
        finite("transmissions", &[between.stiffness], f64::MIN_POSITIVE)?;
    }
    for term in smooth_terms {
        place("smooth_terms", &term.joint)?;
        finite("smooth_terms", &term.coefficients, f64::MIN)?;
        if !term.is_whole() {
            return Err(format!("`smooth_terms` on `{}` is not whole", term.joint));
        }
    }
    Ok(())
}

/// The section `learned` of files of schema 1.
#[derive(Deserialize)]
struct Learned {
    /// of two neighbouring joints, `joint` being the first
    couplings: Vec<EffectOnJoint>,
    tilt_rad: [f64; 2],
    encoder_offset: Vec<f64>,
    delay_s: f64,
    gain: Vec<f64>,
    transmissions: Vec<TransmissionTerm>,
    flexible: Vec<SmoothTerm>,
    rigid_cutoff_hz: f64,
    output_cutoff_hz: Vec<Option<f64>>,
    #[serde(default)]
    fading_speed: Vec<f64>,
    #[serde(default)]
    turning_travel: Vec<f64>,
}

impl Learned {
    /// Moves all of it to where files of schema 2 have it.
    fn into_file(self, file: &mut ModelFile) {
        let names: Vec<&str> = file.joints.iter().map(|j| j.name.as_str()).collect();
        for mut coupling in self.couplings {
            let first = names.iter().position(|name| *name == coupling.joint);
            let second = first.and_then(|j| names.get(j + 1));
            coupling.other_joint = second.map(ToString::to_string);
            file.effects.push(coupling);
        }
        file.base_tilt_rad = self.tilt_rad;
        file.encoder_offset = self.encoder_offset;
        file.effort_delay_s = self.delay_s;
        file.channel_gain = self.gain;
        file.transmissions = self.transmissions;
        file.smooth_terms = self.flexible;
        file.band = Some(BandPrediction {
            rigid_cutoff_hz: self.rigid_cutoff_hz,
            output_cutoff_hz: self.output_cutoff_hz,
        });
        // files from before friction could be regularised have empty lists
        let filled = |list: Vec<f64>| if list.is_empty() { vec![0.0; names.len()] } else { list };
        file.speed_resolution = Some(filled(self.fading_speed));
        file.turning_travel = Some(filled(self.turning_travel));
    }
}

#[cfg(test)]
mod tests {
    use armident_kinematics::{ChainSelection, SerialChain, parse_urdf};
    use serde_json::{Value, json};

    use super::*;

    fn planar() -> ArmModel {
        let text = include_str!("../../../urdf/planar_2r.urdf");
        let robot = parse_urdf(text, "planar_2r.urdf").unwrap();
        let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
        ArmModel::from_chain(DrivingAxisChain::from_chain(&chain))
    }

    fn parsed(document: &Value) -> Result<ArmModel, String> {
        ArmModel::parse(&document.to_string(), "made").map_err(|error| error.to_string())
    }

    fn document() -> Value {
        let model = planar().links_in_band();
        serde_json::from_str(&model.to_json().unwrap()).unwrap()
    }

    /// A model file of schema 1 with this in its section `learned`.
    fn of_schema_1(list: &str, value: Value) -> Result<ArmModel, String> {
        let mut document = document();
        document["schema"] = json!("armident.model/1");
        for key in ["base_tilt_rad", "encoder_offset", "effort_delay_s", "channel_gain", "band"] {
            document.as_object_mut().unwrap().remove(key);
        }
        document["learned"] = json!({
            "couplings": [], "tilt_rad": [0.0, 0.0], "encoder_offset": [0.0, 0.0],
            "delay_s": 0.0, "gain": [1.0, 1.0], "transmissions": [], "flexible": [],
            "rigid_cutoff_hz": 14.0, "output_cutoff_hz": [null, null],
            "fading_speed": [0.0, 0.0], "turning_travel": [0.0, 0.0],
        });
        document["learned"][list] = value;
        parsed(&document)
    }

    #[test]
    fn file_round_trip_keeps_every_term() {
        let [first, second] = ["joint_1", "joint_2"];
        let mut model = planar().links_in_band();
        let coupling = EffectOnJoint::new("joint_coupling", first, vec![1.0, 0.1, 0.1]);
        model.effects.push(EffectOnJoint { other_joint: Some(second.to_owned()), ..coupling });
        model.base_tilt_rad = [0.01, -0.02];
        model.encoder_offset = vec![0.003, 0.0];
        model.effort_delay_s = 0.004;
        model.effort_low_pass_s = 0.02;
        model.effort_clock_drift = 1e-4;
        model.channel_gain = vec![1.1, 1.0];
        model.reversals =
            Some(vec![ReversalModel::regularised(0.02), ReversalModel::presliding(0.001)]);
        let read = ArmModel::parse(&model.to_json().unwrap(), "made").unwrap();
        assert_eq!(read.effects, model.effects);
        assert_eq!(read.base_tilt_rad, model.base_tilt_rad);
        assert_eq!(read.encoder_offset, model.encoder_offset);
        assert_eq!(read.effort_delay_s, model.effort_delay_s);
        assert_eq!(read.effort_low_pass_s, model.effort_low_pass_s);
        assert_eq!(read.effort_clock_drift, model.effort_clock_drift);
        assert_eq!(read.channel_gain, model.channel_gain);
        assert_eq!((read.reversals, read.band), (model.reversals, model.band));
    }

    #[test]
    fn schema_1_terms_become_terms_of_the_model() {
        let read = of_schema_1("delay_s", json!(0.01)).unwrap();
        assert_eq!((read.effort_delay_s, read.band.is_some()), (0.01, true));
        // files from before friction could be regularised
        for list in ["fading_speed", "turning_travel"] {
            let read = of_schema_1(list, json!([])).unwrap();
            assert_eq!(
                (read.regularised_below(), read.presliding_travel()),
                (vec![0.0; 2], vec![0.0; 2])
            );
        }
        let coupling = json!([{ "effect": "joint_coupling", "joint": "joint_1", "parameters": [1.0, 0.1, 0.1] }]);
        let read = of_schema_1("couplings", coupling).unwrap();
        assert_eq!(read.effects[0].other_joint.as_deref(), Some("joint_2"));
    }

    #[test]
    fn schema_1_section_that_does_not_fit_is_refused() {
        let knots =
            json!({ "joint": "joint_2", "quantity": "position", "range": [0.0, 1.0], "knots": 3 });
        let structure = |joint: &str, axis: &Value, coefficients: &[f64]| {
            let basis = json!({ "factors": [], "axes": [axis] });
            json!([{ "joint": joint, "basis": basis, "coefficients": coefficients }])
        };
        assert!(of_schema_1("flexible", structure("joint_2", &knots, &[1.0, 2.0, 3.0])).is_ok());
        let mut no_knots = knots.clone();
        no_knots["knots"] = json!(0);
        let coupling = |effect: &str, joint: &str| json!([{ "effect": effect, "joint": joint, "parameters": [1.0, 0.1, 0.1] }]);
        let between = json!({ "gap": 0.0, "stiffness": 0.0, "damping": 1.0 });
        let spring = json!([{ "joint": "joint_2", "transmission": between, "motor_inertia": 0.1, "share": 1.0 }]);
        for (list, value, expected) in [
            ("gain", json!([1.0]), "`channel_gain` has 1 entries, expected 2"),
            (
                "encoder_offset",
                json!([0.0, 0.0, 0.0]),
                "`encoder_offset` has 3 entries, expected 2",
            ),
            ("rigid_cutoff_hz", json!(0.0), "`rigid_cutoff_hz` has the number 0"),
            ("output_cutoff_hz", json!([null, -1.0]), "`output_cutoff_hz` has the number -1"),
            ("couplings", coupling("joint_coupling", "joint_2"), "`joint_2` has no other joint"),
            ("couplings", coupling("joint_coupling", "knee"), "unknown joint `knee`"),
            ("couplings", coupling("viscous_friction", "joint_2"), "found 3 numbers"),
            ("transmissions", spring, "`transmissions` has the number 0"),
            ("flexible", structure("knee", &knots, &[1.0, 2.0, 3.0]), "unknown joint `knee`"),
            (
                "flexible",
                structure("joint_2", &knots, &[1.0]),
                "`smooth_terms` on `joint_2` is not whole",
            ),
            ("flexible", structure("joint_2", &no_knots, &[]), "is not whole"),
            ("tilt_rad", json!("level"), "invalid type"),
        ] {
            let error = of_schema_1(list, value.clone()).expect_err(&value.to_string());
            assert!(error.contains(expected), "{error}");
        }
    }
}
