//! Exciting trajectories and the controller that follows them.

use std::f64::consts::TAU;

use armident_dynamics::{inertia_matrix, inverse_dynamics_of_motion};
use armident_effects::Draw;
use armident_simulation::{TrackingGains, Trajectory};

use crate::arms::robot::Robot;
use crate::random::RandomStream;

/// Control cycle \[Hz\].
pub(crate) const CONTROL_HZ: f64 = 2000.0;
/// Simulated beyond the end of a recording \[s\]: efforts that lead come from there.
pub(crate) const AFTER_S: f64 = 0.05;
/// Largest travel to either side \[rad\].
const MOST_TRAVEL_RAD: f64 = 1.0;
/// Largest share of the limits: position, speed, effort.
const SHARE_OF_LIMITS: [f64; 3] = [0.42, 0.55, 0.6];
/// Tracking error that a joint's unmodelled effort may cause \[rad or m\].
const TRACKING_ERROR: f64 = 0.006;
/// Travel of a joint that barely moves \[rad or m\].
const STILL_TRAVEL: f64 = 0.03;
/// Standstill before the motion, and its rise \[s\].
const REST_S: f64 = 0.1;
const RISE_S: f64 = 1.0;

/// Where the trajectories of a case play: centre and travel of each joint.
pub(crate) struct Workspace {
    centre: Vec<f64>,
    travel: Vec<f64>,
}

impl Workspace {
    pub(crate) fn draw(robot: &Robot, random: &mut RandomStream) -> Self {
        let (mut centre, mut travel) = (Vec::new(), Vec::new());
        for (j, joint) in robot.chain.joints.iter().enumerate() {
            let wide = if robot.is_rotational(j) { 1.6 } else { 0.3 };
            let low = joint.limits.lower.unwrap_or(-wide);
            let high = joint.limits.upper.unwrap_or(wide);
            let half = 0.5 * (high - low);
            let most = if robot.is_rotational(j) { MOST_TRAVEL_RAD } else { 0.45 };
            let size = (SHARE_OF_LIMITS[0] * half * 2.0).min(most * random.between(0.7, 1.0));
            let size = size.min(0.9 * half);
            let play = (half - size).min(if robot.is_rotational(j) { 0.8 } else { half });
            let middle = 0.5 * (low + high);
            // arms whose limits are whole turns stay near their zero
            let middle = if half > 3.0 { middle.clamp(-0.5, 0.5) } else { middle };
            centre.push(middle + play * random.between(-0.8, 0.8));
            travel.push(size);
        }
        Self { centre, travel }
    }

    /// Leaves a joint almost where it is.
    pub(crate) fn hold_still(&mut self, joint: usize) {
        self.travel[joint] = self.travel[joint].min(STILL_TRAVEL);
    }
}

/// Position, velocity and acceleration of a unit motion.
struct Sines {
    terms: Vec<[f64; 3]>,
}

impl Sines {
    fn draw(random: &mut RandomStream) -> Self {
        let count = 5 + random.index(3);
        let terms = (0..count)
            .map(|_| {
                let omega = TAU * random.log_between(0.1, 1.1);
                let size = random.between(0.4, 1.0) * omega.powf(-0.6);
                [size, omega, random.between(0.0, TAU)]
            })
            .collect();
        Self { terms }
    }

    fn at(&self, t: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for [size, omega, phase] in &self.terms {
            let (sin, cos) = (omega * t + phase).sin_cos();
            sum[0] += size * sin;
            sum[1] += size * omega * cos;
            sum[2] -= size * omega * omega * sin;
        }
        sum
    }
}

/// The rise from 0 to 1 with its derivatives: a polynomial of fifth order.
fn rise(t: f64) -> [f64; 3] {
    let x = ((t - REST_S) / RISE_S).clamp(0.0, 1.0);
    let value = x * x * x * (10.0 + x * (6.0 * x - 15.0));
    let slope = 30.0 * x * x * (1.0 - x) * (1.0 - x) / RISE_S;
    let curve = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / (RISE_S * RISE_S);
    [value, slope, curve]
}

/// The control cycles of a recording and of what is simulated beyond its end \[s\].
fn control_times(duration_s: f64) -> Vec<f64> {
    let samples = ((duration_s + AFTER_S) * CONTROL_HZ).round() as usize + 1;
    (0..samples).map(|k| k as f64 / CONTROL_HZ).collect()
}

/// A random trajectory from rest, inside the limits of position, speed and given effort.
pub(crate) fn exciting(
    robot: &Robot,
    workspace: &Workspace,
    duration_s: f64,
    random: &mut RandomStream,
) -> Trajectory {
    let time_s = control_times(duration_s);
    let mut unit: [Vec<Vec<f64>>; 3] = std::array::from_fn(|_| Vec::new());
    for _ in 0..robot.dof() {
        let sines = Sines::draw(random);
        let columns: Vec<[f64; 3]> = time_s
            .iter()
            .map(|&t| {
                let ([s, ds, dds], [r, dr, ddr]) = (sines.at(t), rise(t));
                [s * r, ds * r + s * dr, dds * r + 2.0 * ds * dr + s * ddr]
            })
            .collect();
        for (d, unit) in unit.iter_mut().enumerate() {
            unit.push(columns.iter().map(|c| c[d]).collect());
        }
    }
    let largest = |column: &[f64]| column.iter().fold(1e-12_f64, |a, x| a.max(x.abs()));
    let scale: Vec<f64> = (0..robot.dof())
        .map(|j| {
            let by_travel = workspace.travel[j] / largest(&unit[0][j]);
            let speed = robot.chain.joints[j].limits.velocity;
            let by_speed =
                speed.map_or(f64::INFINITY, |v| SHARE_OF_LIMITS[1] * v / largest(&unit[1][j]));
            by_travel.min(by_speed)
        })
        .collect();
    let mut less = 1.0;
    loop {
        let column = |d: usize, j: usize| -> Vec<f64> {
            let offset = if d == 0 { workspace.centre[j] } else { 0.0 };
            unit[d][j].iter().map(|x| offset + less * scale[j] * x).collect()
        };
        let columns =
            |d: usize| -> Vec<Vec<f64>> { (0..robot.dof()).map(|j| column(d, j)).collect() };
        let trajectory = Trajectory {
            joints: robot.names.clone(),
            position: columns(0),
            velocity: columns(1),
            acceleration: columns(2),
            source: "exciting".to_owned(),
            notes: Vec::new(),
            time_s: time_s.clone(),
        };
        if less < 0.5 || within_efforts(robot, &trajectory) {
            return trajectory;
        }
        less *= 0.85;
    }
}

/// Moves between random points with standstills, at the pace of the slowest joint.
pub(crate) fn point_to_point(
    robot: &Robot,
    workspace: &Workspace,
    duration_s: f64,
    random: &mut RandomStream,
) -> Trajectory {
    let time_s = control_times(duration_s);
    // start and length of each move, and where it goes
    let mut moves: Vec<(f64, f64, Vec<f64>)> = Vec::new();
    let mut at = workspace.centre.clone();
    let mut t = REST_S;
    while t < duration_s {
        let to: Vec<f64> = (0..robot.dof())
            .map(|j| workspace.centre[j] + workspace.travel[j] * random.between(-1.0, 1.0))
            .collect();
        // the fastest speed of the rise of fifth order is 15/8 of the mean
        let needed = |j: usize| {
            let speed = robot.chain.joints[j].limits.velocity.unwrap_or(MOST_TRAVEL_RAD);
            1.875 * (to[j] - at[j]).abs() / (SHARE_OF_LIMITS[1] * speed)
        };
        let length = (0..robot.dof()).map(needed).fold(0.8, f64::max) * random.between(1.0, 1.6);
        moves.push((t, length, to.clone()));
        at = to;
        t += length + random.between(0.3, 1.5);
    }
    loop {
        let column = |j: usize| -> [Vec<f64>; 3] {
            let mut columns: [Vec<f64>; 3] =
                std::array::from_fn(|_| Vec::with_capacity(time_s.len()));
            let (mut from, mut next) = (workspace.centre[j], 0);
            for &t in &time_s {
                while next + 1 < moves.len() && t >= moves[next + 1].0 {
                    from = moves[next].2[j];
                    next += 1;
                }
                let (start, length, to) = &moves[next];
                let span = to[j] - from;
                let [r, dr, ddr] = rise((t - start) / length * RISE_S + REST_S);
                columns[0].push(from + span * r);
                columns[1].push(span * dr * RISE_S / length);
                columns[2].push(span * ddr * (RISE_S / length).powi(2));
            }
            columns
        };
        let mut of: [Vec<Vec<f64>>; 3] = std::array::from_fn(|_| Vec::new());
        for j in 0..robot.dof() {
            for (of, column) in of.iter_mut().zip(column(j)) {
                of.push(column);
            }
        }
        let [position, velocity, acceleration] = of;
        let trajectory = Trajectory {
            joints: robot.names.clone(),
            position,
            velocity,
            acceleration,
            source: "point to point".to_owned(),
            notes: Vec::new(),
            time_s: time_s.clone(),
        };
        let slowest = moves.iter().map(|(_, length, _)| *length).fold(0.0, f64::max);
        if slowest > duration_s || within_efforts(robot, &trajectory) {
            return trajectory;
        }
        // later and slower
        let mut late = 0.0;
        for (start, length, _) in &mut moves {
            *start += late;
            late += 0.2 * *length;
            *length *= 1.2;
        }
    }
}

fn within_efforts(robot: &Robot, trajectory: &Trajectory) -> bool {
    let Trajectory { position, velocity, acceleration, .. } = trajectory;
    let efforts = inverse_dynamics_of_motion(&robot.arm(), position, velocity, acceleration);
    efforts.iter().zip(&robot.chain.joints).all(|(effort, joint)| {
        let most = joint.limits.effort.map_or(f64::INFINITY, |limit| SHARE_OF_LIMITS[2] * limit);
        effort.iter().all(|effort| effort.abs() <= most)
    })
}

/// Gains with which efforts of this size that the feed-forward does not know cause small errors, as far
/// as the control cycle allows.
pub(crate) fn gains(robot: &Robot, plan: &Trajectory, unknown: &[f64]) -> TrackingGains {
    const SLOWEST_HZ: f64 = 2.0;
    const FASTEST_PER_CYCLE: f64 = 0.2;
    let arm = robot.arm();
    // what a joint moves while the others give way, in the lightest of some poses
    let mut inertia = vec![f64::INFINITY; robot.dof()];
    for k in (0..plan.len()).step_by((plan.len() / 30).max(1)) {
        let q: Vec<f64> = plan.position.iter().map(|column| column[k]).collect();
        if let Some(factor) = inertia_matrix(&arm, &q).cholesky() {
            for (least, mobility) in inertia.iter_mut().zip(&factor.inverse().diagonal()) {
                *least = least.min(1.0 / mobility);
            }
        }
    }
    let stiffness = |j: usize| {
        let slowest = inertia[j] * (TAU * SLOWEST_HZ).powi(2);
        let fastest = inertia[j] * (FASTEST_PER_CYCLE * CONTROL_HZ).powi(2);
        (unknown[j] / TRACKING_ERROR).clamp(slowest, fastest)
    };
    let proportional: Vec<f64> = (0..robot.dof()).map(stiffness).collect();
    let derivative = proportional.iter().zip(&inertia).map(|(p, m)| 1.6 * (p * m).sqrt()).collect();
    TrackingGains { proportional, derivative }
}
