//! What a diagnosis adds to the model of an arm, as a model file holds it.

use armident_effects::{EffectOnJoint, Scope, Turn, UnknownEffect};
use serde::{Deserialize, Serialize};

use crate::{SmoothTerm, TransmissionTerm};

/// Cut-off for the rigid part of a prediction \[Hz\], unless training recordings ask for a lower one:
/// above, differentiated encoders are mostly noise.
const RIGID_HZ: f64 = 14.0;

/// What a diagnosis adds to an [`ArmModel`](crate::ArmModel), whose links are the corrected ones and whose effects are
/// those on single joints.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Learned {
    /// Effects of two neighbouring joints, `joint` being the first.
    pub couplings: Vec<EffectOnJoint>,
    /// Rotation vector of the base about x and y of the world \[rad\].
    pub tilt_rad: [f64; 2],
    /// Recorded minus true position of each joint \[rad or m\].
    pub encoder_offset: Vec<f64>,
    /// Lag of the efforts \[s\].
    pub delay_s: f64,
    /// Gain of each effort channel.
    pub gain: Vec<f64>,
    /// Springy and loose transmissions.
    pub transmissions: Vec<TransmissionTerm>,
    /// Structure without a name.
    pub flexible: Vec<SmoothTerm>,
    /// Low-pass on the rigid part of a prediction \[Hz\].
    pub rigid_cutoff_hz: f64,
    /// Low-pass on the whole prediction of each joint \[Hz\]: where differentiated encoders or the
    /// timing of impacts spoil more than they tell.
    pub output_cutoff_hz: Vec<Option<f64>>,
    /// Speed of each joint below which its dry friction fades \[rad/s or m/s\]; 0 where it is sharp. Older files
    /// have none.
    #[serde(default)]
    pub fading_speed: Vec<f64>,
    /// Travel of each joint since its last reversal over which its dry friction builds up \[rad or m\]; 0 where it turns
    /// with the speed. Older files have none.
    #[serde(default)]
    pub turning_travel: Vec<f64>,
}

/// Why the section `learned` of a model file cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LearnedError {
    /// Not JSON of the expected form.
    #[error("the section `learned` is not valid: {0}")]
    Invalid(#[from] serde_json::Error),
    /// An effect the library does not know.
    #[error("the section `learned` is not valid: {0}")]
    Effect(#[from] UnknownEffect),
    /// Lists of another length, joints the arm does not have, numbers that are not finite.
    #[error("the section `learned` does not fit the arm: {0}")]
    DoesNotFit(String),
}

impl Learned {
    /// Of an arm with so many joints: nothing.
    pub fn nothing(joints: usize) -> Self {
        Self {
            couplings: Vec::new(),
            tilt_rad: [0.0; 2],
            encoder_offset: vec![0.0; joints],
            delay_s: 0.0,
            gain: vec![1.0; joints],
            transmissions: Vec::new(),
            flexible: Vec::new(),
            rigid_cutoff_hz: RIGID_HZ,
            output_cutoff_hz: vec![None; joints],
            fading_speed: vec![0.0; joints],
            turning_travel: vec![0.0; joints],
        }
    }

    /// How dry friction of each joint turns.
    pub fn turns(&self) -> Vec<Turn> {
        let pairs = self.fading_speed.iter().zip(&self.turning_travel);
        pairs.map(|(speed, travel)| Turn::of(*speed, *travel)).collect()
    }

    /// What a model file holds beyond an arm with these joints; none in the file of a plain identification.
    ///
    /// # Errors
    /// [`LearnedError`].
    pub fn in_model_file(text: &str, joints: &[&str]) -> Result<Option<Self>, LearnedError> {
        let document: serde_json::Value = serde_json::from_str(text)?;
        let Some(section) = document.get("learned") else { return Ok(None) };
        let mut learned: Self = serde_json::from_value(section.clone())?;
        for list in [&mut learned.fading_speed, &mut learned.turning_travel] {
            if list.is_empty() {
                *list = vec![0.0; joints.len()];
            }
        }
        learned.fits(joints)?;
        Ok(Some(learned))
    }

    /// Whether all lists have an entry a joint, all joints named are there, and all numbers can be used.
    fn fits(&self, joints: &[&str]) -> Result<(), LearnedError> {
        let of_joints = [
            ("encoder_offset", self.encoder_offset.len()),
            ("gain", self.gain.len()),
            ("output_cutoff_hz", self.output_cutoff_hz.len()),
            ("fading_speed", self.fading_speed.len()),
            ("turning_travel", self.turning_travel.len()),
        ];
        for (list, found) in of_joints {
            if found != joints.len() {
                let expected = joints.len();
                return Err(LearnedError::DoesNotFit(format!(
                    "`{list}` has {found} entries, expected {expected}, one a joint"
                )));
            }
        }
        let finite = |list: &str, values: &[f64], least: f64| match values
            .iter()
            .find(|x| !x.is_finite() || **x < least)
        {
            Some(x) => Err(LearnedError::DoesNotFit(format!("`{list}` has the number {x}"))),
            None => Ok(()),
        };
        let any = f64::MIN;
        finite("tilt_rad", &self.tilt_rad, any)?;
        finite("encoder_offset", &self.encoder_offset, any)?;
        finite("delay_s", &[self.delay_s], any)?;
        finite("gain", &self.gain, any)?;
        finite("fading_speed", &self.fading_speed, 0.0)?;
        finite("turning_travel", &self.turning_travel, 0.0)?;
        finite("rigid_cutoff_hz", &[self.rigid_cutoff_hz], f64::MIN_POSITIVE)?;
        let cutoffs: Vec<f64> = self.output_cutoff_hz.iter().copied().flatten().collect();
        finite("output_cutoff_hz", &cutoffs, f64::MIN_POSITIVE)?;
        let place = |list: &str, name: &str| {
            let unknown = || {
                let known = joints.join(", ");
                LearnedError::DoesNotFit(format!(
                    "`{list}` is on unknown joint `{name}`, known are {known}"
                ))
            };
            joints.iter().position(|j| *j == name).ok_or_else(unknown)
        };
        for coupling in &self.couplings {
            let law = coupling.resolve()?.law();
            finite("couplings", &coupling.parameters, any)?;
            if law.scope != Scope::Neighbours {
                let message = format!("`couplings` has `{}`, which couples no joints", law.slug);
                return Err(LearnedError::DoesNotFit(message));
            }
            if place("couplings", &coupling.joint)? + 1 == joints.len() {
                let message =
                    format!("`couplings` is on `{}`, which has no next joint", coupling.joint);
                return Err(LearnedError::DoesNotFit(message));
            }
        }
        for term in &self.transmissions {
            place("transmissions", &term.joint)?;
            let between = term.transmission;
            finite("transmissions", &[term.share, term.motor_inertia], any)?;
            finite("transmissions", &[between.gap, between.damping], 0.0)?;
            finite("transmissions", &[between.stiffness], f64::MIN_POSITIVE)?;
        }
        for term in &self.flexible {
            place("flexible", &term.joint)?;
            finite("flexible", &term.coefficients, any)?;
            if !term.is_whole() {
                let message = format!("`flexible` on `{}` is not whole", term.joint);
                return Err(LearnedError::DoesNotFit(message));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    const JOINTS: [&str; 2] = ["shoulder", "elbow"];

    /// What is said of a model file with this in its section.
    fn said(list: &str, value: Value) -> Result<Option<Learned>, String> {
        let mut learned = serde_json::to_value(Learned::nothing(JOINTS.len())).unwrap();
        learned[list] = value;
        let text = json!({ "learned": learned }).to_string();
        Learned::in_model_file(&text, &JOINTS).map_err(|error| error.to_string())
    }

    #[test]
    fn a_section_that_does_not_fit_is_refused() {
        assert!(said("delay_s", json!(0.01)).unwrap().is_some());
        // files from before friction could fade
        assert_eq!(said("fading_speed", json!([])).unwrap().unwrap().fading_speed, [0.0; 2]);
        assert_eq!(said("turning_travel", json!([])).unwrap().unwrap().turning_travel, [0.0; 2]);
        let hat =
            json!({ "joint": "elbow", "quantity": "position", "range": [0.0, 1.0], "knots": 3 });
        let structure = |joint: &str, axis: &Value, coefficients: &[f64]| {
            let basis = json!({ "factors": [], "axes": [axis] });
            json!([{ "joint": joint, "basis": basis, "coefficients": coefficients }])
        };
        assert!(said("flexible", structure("elbow", &hat, &[1.0, 2.0, 3.0])).is_ok());
        let mut no_knots = hat.clone();
        no_knots["knots"] = json!(0);
        let coupling = |effect: &str, joint: &str| json!([{ "effect": effect, "joint": joint, "parameters": [1.0, 0.1, 0.1] }]);
        assert!(said("couplings", coupling("joint_coupling", "shoulder")).is_ok());
        let between = json!({ "gap": 0.0, "stiffness": 0.0, "damping": 1.0 });
        let spring = json!([{ "joint": "elbow", "transmission": between, "motor_inertia": 0.1, "share": 1.0 }]);
        for (list, value, expected) in [
            ("gain", json!([1.0]), "`gain` has 1 entries, expected 2"),
            (
                "encoder_offset",
                json!([0.0, 0.0, 0.0]),
                "`encoder_offset` has 3 entries, expected 2",
            ),
            ("rigid_cutoff_hz", json!(0.0), "`rigid_cutoff_hz` has the number 0"),
            ("output_cutoff_hz", json!([null, -1.0]), "`output_cutoff_hz` has the number -1"),
            ("couplings", coupling("joint_coupling", "elbow"), "`elbow`, which has no next joint"),
            ("couplings", coupling("joint_coupling", "knee"), "unknown joint `knee`"),
            ("couplings", coupling("stribeck_friction", "elbow"), "couples no joints"),
            ("couplings", coupling("viscous_friction", "elbow"), "found 3 numbers"),
            ("transmissions", spring, "`transmissions` has the number 0"),
            ("flexible", structure("knee", &hat, &[1.0, 2.0, 3.0]), "unknown joint `knee`"),
            ("flexible", structure("elbow", &hat, &[1.0]), "`flexible` on `elbow` is not whole"),
            ("flexible", structure("elbow", &no_knots, &[]), "is not whole"),
            ("tilt_rad", json!("level"), "invalid type"),
        ] {
            let error = said(list, value.clone()).expect_err(&value.to_string());
            assert!(error.contains(expected), "{error}");
        }
    }
}
