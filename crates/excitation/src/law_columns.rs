//! Columns of the laws of the library on planned motions.

use armident_dynamics::RigidArm;
use armident_effects::{
    ArmColumns, Effect, JointMotion, MotionScale, Scan, Scope, WholeArmMotion, directions_with,
};
use armident_kinematics::DrivingAxisChain;

use crate::information::{Columns, REST_SPEED};

/// A law at its location.
#[derive(Clone, Copy)]
pub(crate) struct PlacedLaw {
    pub(crate) law: &'static dyn Effect,
    /// the joint, the first of two neighbours, or the joint that moves the link
    pub(crate) joint: usize,
}

/// A planned motion with what laws need of it.
pub(crate) struct PlannedMotion<'a> {
    pub(crate) columns: &'a Columns,
    pub(crate) rigid_effort: Vec<Vec<f64>>,
    time_s: Vec<f64>,
    rate_hz: f64,
}

impl<'a> PlannedMotion<'a> {
    pub(crate) fn new(columns: &'a Columns, rigid_effort: Vec<Vec<f64>>, rate_hz: f64) -> Self {
        let samples = columns[0].first().map_or(0, Vec::len);
        let time_s = (0..samples).map(|k| k as f64 / rate_hz).collect();
        Self { columns, rigid_effort, time_s, rate_hz }
    }

    /// Size of a joint's motion.
    pub(crate) fn scale(&self, arm: &RigidArm, joint: usize) -> MotionScale {
        MotionScale {
            kind: arm.joints[joint].kind,
            speed_rms: root_mean_square(&self.columns[1][joint], 0.0),
            position_deviation: deviation(&self.columns[0][joint]),
            duration_s: self.duration_s(),
            temperature_c: None,
        }
    }

    /// Length \[s\].
    pub(crate) fn duration_s(&self) -> f64 {
        self.time_s.last().copied().unwrap_or(0.0)
    }

    /// Columns of a law for a shape `[column][joint][sample]`; an empty column list on a joint that it does not act on.
    pub(crate) fn law(
        &self,
        chain: &DrivingAxisChain,
        arm: &RigidArm,
        placed: PlacedLaw,
        shape: &[f64],
    ) -> ArmColumns {
        let PlacedLaw { law, joint } = placed;
        let n = arm.dof();
        let directions: Vec<Vec<f64>> =
            self.columns[1].iter().map(|v| directions_with(v, REST_SPEED)).collect();
        let of = |j: usize| JointMotion {
            kind: arm.joints[j].kind,
            time_s: &self.time_s,
            position: &self.columns[0][j],
            velocity: &self.columns[1][j],
            acceleration: &self.columns[2][j],
            direction: &directions[j],
            rigid_effort: &self.rigid_effort[j],
            temperature_c: &[],
        };
        let on = |parts: &mut dyn Iterator<Item = (usize, Vec<f64>)>| {
            let mut all = vec![Vec::new(); n];
            parts.for_each(|(j, column)| all[j] = column);
            all
        };
        match law.law().scope {
            Scope::Joint => law
                .columns(shape, &of(joint))
                .into_iter()
                .map(|column| on(&mut std::iter::once((joint, column))))
                .collect(),
            Scope::Neighbours if joint + 1 < n => law
                .pair_columns(shape, &of(joint), &of(joint + 1))
                .into_iter()
                .map(|[a, b]| on(&mut [(joint, a), (joint + 1, b)].into_iter()))
                .collect(),
            Scope::Neighbours => Vec::new(),
            Scope::ThroughJoint | Scope::Link | Scope::Arm => {
                let motion = WholeArmMotion {
                    arm,
                    base_from_e0: chain.base_from_e0,
                    tip_in_last_m: chain.tip_in_e.translation.vector,
                    rate_hz: self.rate_hz,
                    position: &self.columns[0],
                    velocity: &self.columns[1],
                    acceleration: &self.columns[2],
                    rigid_effort: &self.rigid_effort,
                };
                law.arm_columns(joint, &motion)
            }
        }
    }
}

/// Where a law acts on an arm of so many joints; nowhere for laws that estimators find by a scan or a simulation.
pub(crate) fn places(law: &'static dyn Effect, joints: usize) -> Vec<PlacedLaw> {
    if law.law().scan != Scan::Columns {
        return Vec::new();
    }
    let at =
        |joints: std::ops::Range<usize>| joints.map(|joint| PlacedLaw { law, joint }).collect();
    match law.law().scope {
        Scope::Joint | Scope::ThroughJoint | Scope::Link => at(0..joints),
        Scope::Neighbours => at(0..joints.saturating_sub(1)),
        Scope::Arm => at(0..1),
    }
}

pub(crate) fn root_mean_square(values: &[f64], about: f64) -> f64 {
    let squares: f64 = values.iter().map(|x| (x - about).powi(2)).sum();
    (squares / values.len().max(1) as f64).sqrt()
}

pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

pub(crate) fn deviation(values: &[f64]) -> f64 {
    root_mean_square(values, mean(values))
}
