//! Known loads on the last link in some of the recordings.
//!
//! Method: the effort of a load of known mass and centre is subtracted from the recorded one. Where its centre is known
//! with an error only, its first moments and moments of inertia are unknowns of the recordings with the load, with a
//! Gaussian prior.
//!
//! References: M. Gautier, S. Briot, Global identification of joint drive gains and dynamic parameters of robots, ASME J.
//! Dyn. Sys. Meas. Control 136 (2014); the prior is own.

use armident_dynamics::{RigidArm, inverse_dynamics_of_motion};
use armident_kinematics::{DrivingAxisChain, InertialParameters};
use armident_motion::Motion;
use nalgebra::{Matrix3, Vector3};

/// A load on the last link.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownLoad {
    /// Recordings that have it, by their source.
    pub sources: Vec<String>,
    /// Mass \[kg\].
    pub mass_kg: f64,
    /// Its point mass in the frame of the last joint.
    pub body: InertialParameters,
    /// Standard deviation of each coordinate of its centre \[m\]; at 0 it is a point at its centre.
    pub centre_error_m: f64,
}

impl KnownLoad {
    /// A load by its mass and the centre of mass in the URDF frame of the link that the last joint
    /// moves. Without a centre it is anywhere about the origin of that frame, at the mean length of the
    /// arm's links.
    pub fn new(
        chain: &DrivingAxisChain,
        source: impl Into<String>,
        mass_kg: f64,
        centre_m: Option<[f64; 3]>,
        centre_error_m: f64,
    ) -> Self {
        let centre = Vector3::from(centre_m.unwrap_or_default());
        let point = InertialParameters::from_com(mass_kg, centre, Matrix3::zeros());
        let body = match chain.joints.last() {
            Some(last) => point.expressed_in(&last.child_link_in_e),
            None => point,
        };
        let centre_error_m = match centre_m {
            Some(_) => centre_error_m,
            None => length_of_links(&RigidArm::from_chain(chain)),
        };
        Self { sources: vec![source.into()], mass_kg, body, centre_error_m }
    }

    /// Whether a recording has it.
    pub fn is_on(&self, source: &str) -> bool {
        self.sources.iter().any(|s| s == source)
    }

    /// Effort that the load takes, joint-major, not filtered.
    pub fn effort(&self, arm: &RigidArm, motion: &Motion) -> Vec<Vec<f64>> {
        effort_of_body(arm, &self.body, motion)
    }

    /// Standard deviations of its first moments and moments of inertia, in the order
    /// of the ten parameters behind the mass.
    pub(crate) fn errors(&self) -> [f64; 9] {
        let first = self.mass_kg * self.centre_error_m;
        let reach = self.body.com_m().norm() + self.centre_error_m;
        let second = first * reach;
        [first, first, first, second, second, second, second, second, second]
    }
}

/// Mean radius of gyration of the links about their joints; that of an arm without inertia is 0.1 m.
fn length_of_links(arm: &RigidArm) -> f64 {
    let lengths: Vec<f64> = (arm.links.iter().filter(|link| link.mass_kg > 0.0))
        .map(|link| (0.5 * link.inertia_origin_kgm2.trace().abs() / link.mass_kg).sqrt())
        .filter(|length| *length > 0.0)
        .collect();
    if lengths.is_empty() { 0.1 } else { lengths.iter().sum::<f64>() / lengths.len() as f64 }
}

/// Effort of a body in the frame of the last joint over a motion, joint-major \[N m or N\], not filtered.
pub(crate) fn effort_of_body(
    arm: &RigidArm,
    body: &InertialParameters,
    motion: &Motion,
) -> Vec<Vec<f64>> {
    let mut alone = arm.clone();
    alone.links.fill(InertialParameters::zero());
    if let Some(last) = alone.links.last_mut() {
        *last = *body;
    }
    inverse_dynamics_of_motion(&alone, &motion.position, &motion.velocity, &motion.acceleration)
}

/// The motion with its efforts minus those of the loads that its recording has.
#[must_use]
pub fn without_loads(arm: &RigidArm, motion: Motion, loads: &[KnownLoad]) -> Motion {
    let mut motion = motion;
    for load in loads.iter().filter(|load| load.is_on(&motion.source)) {
        let mut own = load.effort(arm, &motion);
        let take_off = |from: &mut Option<Vec<Vec<f64>>>, own: &[Vec<f64>]| {
            for (effort, own) in from.iter_mut().flatten().zip(own) {
                for (effort, own) in effort.iter_mut().zip(own) {
                    *effort -= own;
                }
            }
        };
        take_off(&mut motion.effort, &own);
        motion.filter_columns(&mut own);
        take_off(&mut motion.effort_filtered, &own);
    }
    motion
}
