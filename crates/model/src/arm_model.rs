//! An arm with everything that is known about it: what predictions, simulations and exports start from.

use armident_dynamics::RigidArm;
use armident_effects::{Effect, EffectOnJoint, Library, ReversalModel, SublinearViscousFriction};
use armident_kinematics::{DrivingAxisChain, InertialParameters};
use armident_motion::{Motion, with_recorded_velocity};
use armident_recording::Recording;
use serde::{Deserialize, Serialize};

use crate::dead_zone::DeadZone;
use crate::operating_point::OperatingPoint;
use crate::reversal::SHARP;
use crate::servo::ServoTerm;
use crate::smooth_term::SmoothTerm;
use crate::transmission::TransmissionTerm;

/// A chain with its links, effects on its joints, and the filter they were found with.
#[derive(Debug, Clone)]
pub struct ArmModel {
    /// Geometry, links and gravity.
    pub chain: DrivingAxisChain,
    /// Effects beyond the rigid body.
    pub effects: Vec<EffectOnJoint>,
    /// The laws of these effects, and those that a diagnosis against the model looks for.
    pub library: Library,
    /// Cut-off of the low-pass the model was estimated with \[Hz\]; predictions use it too.
    pub cutoff_hz: Option<f64>,
    /// Whether the model was fitted with recorded velocities in the place of differentiated positions;
    /// predictions use them too where a motion has them.
    pub recorded_velocities: bool,
    /// Reversal model of each joint's dry friction.
    pub reversals: Option<Vec<ReversalModel>>,
    /// Noise level of each joint's effort in the fit \[N m or N\], after the low-pass of `cutoff_hz` or, without one,
    /// as recorded; none for a URDF.
    pub effort_noise: Option<Vec<f64>>,
    /// What columns show that leave small efforts out, by joint; predictions of these columns follow it, the links and
    /// effects do not.
    pub shown: Option<Vec<Option<DeadZone>>>,
    /// The links before the fit, those of the URDF; none for a URDF itself.
    pub prior_links: Option<Vec<InertialParameters>>,
    /// Where the numbers come from, one sentence each.
    pub provenance: Vec<String>,
    /// Springy and loose transmissions.
    pub transmissions: Vec<TransmissionTerm>,
    /// Structure that no law explains.
    pub smooth_terms: Vec<SmoothTerm>,
    /// Rotation vector of the base about x and y of the world \[rad\].
    pub base_tilt_rad: [f64; 2],
    /// Recorded minus true position of each joint \[rad or m\].
    pub encoder_offset: Vec<f64>,
    /// Delay of the efforts \[s\].
    pub effort_delay_s: f64,
    /// Time constant of the low-pass of first order through which the efforts are reported \[s\]; 0 without one.
    pub effort_low_pass_s: f64,
    /// By which share the clock of the recorded efforts is faster than that of the positions.
    pub effort_clock_drift: f64,
    /// Gain of each effort channel.
    pub channel_gain: Vec<f64>,
    /// Low-passes of its predictions where it was fitted in a band, as a diagnosis does; none where it was fitted
    /// below [`cutoff_hz`](Self::cutoff_hz).
    pub band: Option<BandPrediction>,
    /// Gains of drives whose current is recorded instead of an effort, where recordings with a known load gave them.
    pub drive_gains: Option<DriveGainsKnown>,
    /// Position controllers of the joints, where recordings of commands gave them.
    pub servos: Vec<ServoTerm>,
}

/// Gains of drives, and how well they are known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DriveGainsKnown {
    /// Joints whose drive has a gain here.
    pub joints: Vec<String>,
    /// Effort over current \[N m/A or N/A\], one a joint.
    pub gain: Vec<f64>,
    /// Covariance of the logarithms of the gains, `[joint][joint]`: masses that follow from several drives err together.
    pub log_covariance: Vec<Vec<f64>>,
}

impl DriveGainsKnown {
    /// Gain of a joint \[N m/A or N/A\] and the standard error of its logarithm.
    pub fn of(&self, joint: &str) -> Option<(f64, f64)> {
        let at = self.joints.iter().position(|name| name == joint)?;
        Some((self.gain[at], self.log_covariance[at][at].sqrt()))
    }

    /// 95 % interval of the gain of a joint, lower end first.
    pub fn interval_95(&self, joint: &str) -> Option<[f64; 2]> {
        let (gain, error) = self.of(joint)?;
        let [a, b] = [-1.96, 1.96].map(|deviations| gain * (deviations * error).exp());
        Some([a.min(b), a.max(b)])
    }

    /// Whether there is a gain for every joint, and a variance that is none below zero.
    pub(crate) fn is_sound(&self) -> bool {
        let n = self.joints.len();
        let row = |(at, row): (usize, &Vec<f64>)| {
            row.len() == n && row.iter().all(|x| x.is_finite()) && row[at] >= 0.0
        };
        self.gain.len() == n
            && self.gain.iter().all(|gain| gain.is_finite() && *gain != 0.0)
            && self.log_covariance.len() == n
            && self.log_covariance.iter().enumerate().all(row)
    }
}

/// Low-passes of the prediction of a model that was fitted in a band.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BandPrediction {
    /// Cut-off for the rigid part \[Hz\]: above, differentiated encoders are mostly noise.
    pub rigid_cutoff_hz: f64,
    /// Cut-off for the whole prediction of each joint \[Hz\]: where differentiated encoders or the
    /// timing of impacts add more error than they explain.
    pub output_cutoff_hz: Vec<Option<f64>>,
}

impl BandPrediction {
    /// Cut-off for the rigid part \[Hz\], unless training recordings ask for a lower one.
    const RIGID_HZ: f64 = 14.0;

    /// The default of an arm with so many joints.
    pub fn of(joints: usize) -> Self {
        Self { rigid_cutoff_hz: Self::RIGID_HZ, output_cutoff_hz: vec![None; joints] }
    }
}

impl ArmModel {
    /// The controller of each joint, from base to tip; none unless every joint has one.
    pub fn servo_of_each_joint(&self) -> Option<Vec<&ServoTerm>> {
        let of = |name: &str| self.servos.iter().find(|term| term.joint == name);
        self.chain.joint_names().into_iter().map(of).collect()
    }

    /// The model a URDF describes: its rigid body and nothing else.
    pub fn from_chain(chain: DrivingAxisChain) -> Self {
        let provenance = vec![format!("inertials of {}", chain.source)];
        let joints = chain.dof();
        Self {
            chain,
            effects: Vec::new(),
            library: Library::standard().clone(),
            cutoff_hz: None,
            recorded_velocities: false,
            reversals: None,
            effort_noise: None,
            shown: None,
            prior_links: None,
            provenance,
            transmissions: Vec::new(),
            smooth_terms: Vec::new(),
            base_tilt_rad: [0.0; 2],
            encoder_offset: vec![0.0; joints],
            effort_delay_s: 0.0,
            effort_low_pass_s: 0.0,
            effort_clock_drift: 0.0,
            channel_gain: vec![1.0; joints],
            band: None,
            drive_gains: None,
            servos: Vec::new(),
        }
    }

    /// The same with the laws of another library.
    #[must_use]
    pub fn with_library(self, library: Library) -> Self {
        Self { library, ..self }
    }

    /// The links and the arm they are on, and nothing else that the model holds.
    #[must_use]
    pub fn links_only(&self) -> Self {
        let Self { cutoff_hz, recorded_velocities, .. } = *self;
        Self {
            cutoff_hz,
            recorded_velocities,
            effort_noise: self.effort_noise.clone(),
            prior_links: self.prior_links.clone(),
            provenance: self.provenance.clone(),
            library: self.library.clone(),
            drive_gains: self.drive_gains.clone(),
            ..Self::from_chain(self.chain.clone())
        }
    }

    /// The same, to be compared with recordings in a band.
    #[must_use]
    pub fn links_in_band(&self) -> Self {
        Self { band: Some(BandPrediction::of(self.chain.dof())), ..self.links_only() }
    }

    /// Whether there is nothing but links: what a URDF gives.
    pub fn is_links_only(&self) -> bool {
        let measured = self.encoder_offset.iter().chain(&self.base_tilt_rad);
        self.effects.is_empty()
            && self.transmissions.is_empty()
            && self.smooth_terms.is_empty()
            && measured
                .chain([&self.effort_delay_s, &self.effort_low_pass_s, &self.effort_clock_drift])
                .all(|x| *x == 0.0)
            && self.channel_gain.iter().all(|g| *g == 1.0)
    }

    /// Effects on single joints.
    pub fn joint_effects(&self) -> impl Iterator<Item = &EffectOnJoint> {
        self.effects.iter().filter(|on| on.other_joint.is_none())
    }

    /// Effects of two neighbouring joints.
    pub fn pair_effects(&self) -> impl Iterator<Item = &EffectOnJoint> {
        self.effects.iter().filter(|on| on.other_joint.is_some())
    }

    /// Coefficients of sublinear viscous friction, by joint.
    pub fn sublinear_friction(&self) -> impl Iterator<Item = (&str, f64)> {
        let sublinear = self.effects.iter().filter(|on| is_sublinear(&on.effect));
        sublinear.map(|on| (on.joint.as_str(), on.parameters[0]))
    }

    /// Speed of each joint below which its dry friction is regularised \[rad/s or m/s\]; 0 where it is not.
    pub fn regularised_below(&self) -> Vec<f64> {
        self.of_reversals(|reversal| reversal.regularised_below())
    }

    /// Travel of each joint after a reversal over which its dry friction builds up \[rad or m\]; 0 where it does not.
    pub fn presliding_travel(&self) -> Vec<f64> {
        self.of_reversals(|reversal| reversal.presliding_travel())
    }

    fn of_reversals(&self, of: impl Fn(&ReversalModel) -> f64) -> Vec<f64> {
        match &self.reversals {
            Some(reversals) => reversals.iter().map(of).collect(),
            None => vec![0.0; self.chain.dof()],
        }
    }

    /// Where the model has what changes the configuration itself.
    pub fn operating_point(&self) -> OperatingPoint {
        OperatingPoint {
            tilt: self.base_tilt_rad,
            offset: self.encoder_offset.clone(),
            delay_s: self.effort_delay_s,
            // those of the chain already
            links: None,
            springs: Vec::new(),
            reversals: self.reversals.clone().unwrap_or_else(|| vec![SHARP; self.chain.dof()]),
            gain: self.channel_gain.clone(),
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
        let mut model = self.links_only();
        model.reversals.clone_from(&self.reversals);
        model.effort_noise = None;
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
}

/// Whether a law is sublinear viscous friction.
pub fn is_sublinear(slug: &str) -> bool {
    slug == SublinearViscousFriction.law().slug
}
