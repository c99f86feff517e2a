//! Motion of links behind springs and play, integrated under the motion of their motors.

use armident_dynamics::{inertia_matrix, inverse_dynamics};
use armident_effects::resting_links;
use nalgebra::{DMatrix, DVector};

use crate::error::SimulationError;
use crate::simulated_arm::SimulatedArm;
use crate::stepper::{LONGEST_DECAY, LONGEST_VIBRATION};
use crate::trajectory::Trajectory;

/// Position, velocity and acceleration of all joints at one time.
type Instant = [Vec<f64>; 3];

/// The motion of the links when the motors follow a trajectory: the other joints move with it, the
/// links behind a transmission from where their weight twists it.
///
/// Between two samples the motors move on cubics; the links by the midpoint rule in parts that are
/// short beside their vibrations.
///
/// # Errors
/// [`NotPositiveDefinite`](SimulationError::NotPositiveDefinite) and
/// [`Diverged`](SimulationError::Diverged).
pub(crate) fn link_motion(
    arm: &SimulatedArm,
    trajectory: &Trajectory,
) -> Result<Trajectory, SimulationError> {
    let mut links = trajectory.clone();
    let sprung: Vec<usize> = (0..arm.dof()).filter(|&j| arm.transmission(j).is_some()).collect();
    if sprung.is_empty() || trajectory.is_empty() {
        return Ok(links);
    }
    let driven = Driven { arm, trajectory, sprung: &sprung };
    let start = resting_links(arm.rigid(), arm.transmissions(), &driven.sample(0)[0]);
    let mut q: DVector<f64> =
        DVector::from_iterator(sprung.len(), sprung.iter().map(|&j| start[j]));
    let mut v =
        DVector::from_iterator(sprung.len(), sprung.iter().map(|&j| trajectory.velocity[j][0]));
    for k in 0..trajectory.len() {
        if k > 0 {
            let step_s = trajectory.time_s[k] - trajectory.time_s[k - 1];
            let parts = driven.parts(k - 1, &q, &v, step_s)?;
            let h = step_s / parts as f64;
            for part in 0..parts {
                let share = |of: f64| (part as f64 + of) / parts as f64;
                let a = driven.acceleration(k - 1, share(0.0), &q, &v)?;
                let (mid_q, mid_v) = (&q + &v * (0.5 * h), &v + a * (0.5 * h));
                let a = driven.acceleration(k - 1, share(0.5), &mid_q, &mid_v)?;
                q += mid_v * h;
                v += a * h;
            }
        }
        let from = k.min(trajectory.len().saturating_sub(2));
        let a = driven.acceleration(from, (k - from) as f64, &q, &v)?;
        for (s, &j) in sprung.iter().enumerate() {
            links.position[j][k] = q[s];
            links.velocity[j][k] = v[s];
            links.acceleration[j][k] = a[s];
        }
    }
    Ok(links)
}

/// Links behind motors that move as prescribed.
struct Driven<'a> {
    arm: &'a SimulatedArm,
    trajectory: &'a Trajectory,
    sprung: &'a [usize],
}

impl Driven<'_> {
    fn sample(&self, k: usize) -> Instant {
        let Trajectory { position, velocity, acceleration, .. } = self.trajectory;
        [position, velocity, acceleration].map(|columns| columns.iter().map(|c| c[k]).collect())
    }

    /// The recorded joints at a share of the way from sample `k` to the next.
    fn between(&self, k: usize, share: f64) -> Instant {
        let samples = self.trajectory.len();
        let next = (k + 1).min(samples - 1);
        let h = self.trajectory.time_s[next] - self.trajectory.time_s[k];
        let ([q0, v0, a0], [q1, v1, a1]) = (self.sample(k), self.sample(next));
        let joints = 0..self.arm.dof();
        [
            joints.clone().map(|j| cubic(q0[j], v0[j], q1[j], v1[j], h, share)).collect(),
            joints.clone().map(|j| cubic(v0[j], a0[j], v1[j], a1[j], h, share)).collect(),
            joints.map(|j| a0[j] + share * (a1[j] - a0[j])).collect(),
        ]
    }

    /// Inertia of the sprung links, and the effort through their transmissions beyond what they need
    /// at zero acceleration.
    fn equations(
        &self,
        k: usize,
        share: f64,
        q: &DVector<f64>,
        v: &DVector<f64>,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let [motor_q, motor_v, mut a] = self.between(k, share);
        let (mut link_q, mut link_v) = (motor_q.clone(), motor_v.clone());
        for (s, &j) in self.sprung.iter().enumerate() {
            (link_q[j], link_v[j], a[j]) = (q[s], v[s], 0.0);
        }
        let rigid = inverse_dynamics(self.arm.rigid(), &link_q, &link_v, &a);
        let time = &self.trajectory.time_s;
        let next = (k + 1).min(time.len() - 1);
        let now_s = time[k] + share * (time[next] - time[k]);
        let contact = self.arm.contact_effort(now_s, &link_q);
        let driving = self.sprung.iter().map(|&j| {
            let transmitted = self.arm.transmission(j).map_or(0.0, |transmission| {
                transmission.effort(motor_q[j] - link_q[j], motor_v[j] - link_v[j])
            });
            transmitted - rigid[j] - contact.as_ref().map_or(0.0, |contact| contact[j])
        });
        let driving = DVector::from_iterator(self.sprung.len(), driving);
        let inertia = inertia_matrix(self.arm.rigid(), &link_q);
        (inertia.select_rows(self.sprung).select_columns(self.sprung), driving)
    }

    fn acceleration(
        &self,
        k: usize,
        share: f64,
        q: &DVector<f64>,
        v: &DVector<f64>,
    ) -> Result<DVector<f64>, SimulationError> {
        let (inertia, driving) = self.equations(k, share, q, v);
        let time_s = self.trajectory.time_s[k];
        let Some(factor) = inertia.cholesky() else {
            return Err(SimulationError::NotPositiveDefinite {
                time_s,
                q: self.between(k, share)[0].clone(),
            });
        };
        let acceleration = factor.solve(&driving);
        if acceleration.iter().all(|a| a.is_finite()) {
            return Ok(acceleration);
        }
        let joint = self.arm.joints()[self.sprung[0]].clone();
        Err(SimulationError::Diverged { joint, time_s, speed: v.amax() })
    }

    /// Parts of a step that are short beside the vibrations of the links.
    fn parts(
        &self,
        k: usize,
        q: &DVector<f64>,
        v: &DVector<f64>,
        step_s: f64,
    ) -> Result<usize, SimulationError> {
        let (inertia, _) = self.equations(k, 0.0, q, v);
        let Some(factor) = inertia.cholesky() else {
            let (time_s, q) = (self.trajectory.time_s[k], self.between(k, 0.0)[0].clone());
            return Err(SimulationError::NotPositiveDefinite { time_s, q });
        };
        let mobility = factor.inverse();
        let mut parts = 1.0_f64;
        for (s, &j) in self.sprung.iter().enumerate() {
            let Some(transmission) = self.arm.transmission(j) else { continue };
            let vibration = (transmission.stiffness * mobility[(s, s)]).sqrt();
            let decay = transmission.damping * mobility[(s, s)];
            parts = parts.max(step_s * vibration / LONGEST_VIBRATION);
            parts = parts.max(step_s * decay / LONGEST_DECAY);
        }
        Ok(parts.ceil() as usize)
    }
}

/// The cubic through two values with two slopes, `h` apart.
fn cubic(x0: f64, d0: f64, x1: f64, d1: f64, h: f64, share: f64) -> f64 {
    let (s, r) = (share, 1.0 - share);
    x0 * r * r * (1.0 + 2.0 * s) + x1 * s * s * (1.0 + 2.0 * r) + h * s * r * (d0 * r - d1 * s)
}
