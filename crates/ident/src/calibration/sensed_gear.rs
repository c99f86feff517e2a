//! What lies between the motor of a joint and its torque sensor, where the current of the one and the effort of the other are recorded.
//!
//! ```text
//! gain current = effort + viscous v + coulomb sign(v) + inertia a + offset
//! ```
//!
//! Method: least squares of the current, the noisier of the two, on the effort of the sensor and the motion, all through one low-pass;
//! neither the inertia of the links nor friction behind the sensor is in it. Standard errors by the jackknife over blocks of time.
//!
//! References: the equation of a drive as in M. Gautier, S. Briot, Global identification of joint drive gains and dynamic parameters
//! of robots, ASME J. Dyn. Syst. Meas. Control 136 (2014); the use of a sensor is own.

use armident_effects::directions;
use armident_inference::{FEWEST_BLOCKS, leave_one_out, student_t_975, variance};
use armident_motion::Motion;
use armident_numeric::AccumulatedQr;
use armident_recording::{Quantity, Recording};

use crate::regression::{RANK_CUT, blocks_of, used_s};

/// A number with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensedValue {
    /// Estimate.
    pub value: f64,
    /// Standard error.
    pub standard_error: f64,
}

/// Gear of a joint, between motor and torque sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensedGear {
    /// Whether the effort of the sensor determines the gain: the 95 % interval of the current per effort excludes 0. If not, nothing
    /// here is known in terms of effort.
    pub is_determined: bool,
    /// Effort at the joint per current: torque constant times gear ratio \[N m/A or N/A\].
    pub gain: SensedValue,
    /// Viscous friction \[N m s/rad or N s/m\].
    pub viscous: SensedValue,
    /// Coulomb friction \[N m or N\].
    pub coulomb: SensedValue,
    /// Inertia of motor and gear \[kg m2 or kg\].
    pub inertia: SensedValue,
    /// Effort of a current of 0 that the sensor does not show \[N m or N\].
    pub offset: SensedValue,
    /// RMS residual in terms of effort \[N m or N\].
    pub rms: f64,
}

/// The gears of an arm from recordings and their motions; none of joints without both channels in all recordings.
pub(crate) fn sensed_gears(
    recordings: &[Recording],
    motions: &[Motion],
    joints: &[&str],
) -> Vec<Option<SensedGear>> {
    let current = |recording: &Recording, joint: &str| -> Option<Vec<f64>> {
        let channels = recording.joint(joint)?;
        channels.channel(Quantity::Effort)?;
        channels.channel(Quantity::Current).map(<[f64]>::to_vec)
    };
    let gear = |(j, joint): (usize, &&str)| {
        let currents: Option<Vec<Vec<f64>>> =
            recordings.iter().map(|recording| current(recording, joint)).collect();
        SensedGear::of(motions, &currents?, j)
    };
    joints.iter().enumerate().map(gear).collect()
}

impl SensedGear {
    /// Of joint `j`; `currents` at the stamps of the recordings. None where the motion does not separate the columns.
    fn of(motions: &[Motion], currents: &[Vec<f64>], j: usize) -> Option<Self> {
        let total_s = motions.iter().map(used_s).sum();
        let mut blocks = Vec::new();
        for (motion, current) in motions.iter().zip(currents) {
            let mut filtered =
                [motion.on_grid(current), directions(&motion.velocity[j]), vec![1.0; motion.len()]];
            motion.filter_columns(&mut filtered);
            let [current, direction, one] = filtered;
            let effort = &motion.effort_filtered.as_ref()?[j];
            let columns = [effort, &motion.velocity[j], &direction, &motion.acceleration[j], &one];
            let mut left_out = motion.at_rest(j);
            motion.unmeasured().into_iter().for_each(|of| left_out[of].fill(true));
            for of in blocks_of(motion, total_s) {
                let moving: Vec<usize> = of.filter(|t| !left_out[*t]).collect();
                let part = |column: &[f64]| moving.iter().map(|t| column[*t]).collect::<Vec<_>>();
                let mut block = AccumulatedQr::new(columns.len());
                block.push_columns(&columns.map(|column| part(column)), &part(&current));
                blocks.push(block);
            }
        }
        let mut all = AccumulatedQr::new(5);
        blocks.iter().for_each(|block| all.merge(block));
        let solved = all.solve(RANK_CUT).ok()?;
        if solved.rank < 5 || blocks.len() < FEWEST_BLOCKS {
            return None;
        }
        // over the current that the effort takes
        let number = |x: &[f64], k: usize| if k == 0 { 1.0 / x[0] } else { x[k] / x[0] };
        let without: Option<Vec<Vec<f64>>> = (leave_one_out(&blocks).iter())
            .map(|left| Some(left.solve(RANK_CUT).ok()?.solution))
            .collect();
        let without = without?;
        let error_of = |number: &dyn Fn(&[f64]) -> f64| {
            variance(&without.iter().map(|x| number(x)).collect::<Vec<_>>()).sqrt()
        };
        let quantile = student_t_975((blocks.len() - 1) as f64);
        let is_determined = solved.solution[0].abs() > quantile * error_of(&|x| x[0]);
        let value = |k: usize| SensedValue {
            value: number(&solved.solution, k),
            standard_error: error_of(&|x| number(x, k)),
        };
        let left = all.residual_sum_of_squares(&solved.solution) / all.rows() as f64;
        Some(Self {
            is_determined,
            gain: value(0),
            viscous: value(1),
            coulomb: value(2),
            inertia: value(3),
            offset: value(4),
            rms: left.sqrt() / solved.solution[0].abs(),
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod tests {
    use armident_motion::MotionSettings;
    use armident_recording::JointChannels;
    use rand::{RngExt, SeedableRng};

    use super::*;

    /// Efforts of a sensor and the current of a motor before a gear with friction: every number within three standard errors, and
    /// these a small part of it. A joint without current has no gear.
    #[test]
    fn gear_is_found_between_motor_and_sensor() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(7);
        let time_s: Vec<f64> = (0..6000).map(|k| k as f64 * 0.005).collect();
        let wave = |t: f64| 0.9 * (1.3 * t).sin() + 0.4 * (3.1 * t).sin();
        let speed = |t: f64| 0.9 * 1.3 * (1.3 * t).cos() + 0.4 * 3.1 * (3.1 * t).cos();
        let turn = |t: f64| -0.9 * 1.69 * (1.3 * t).sin() - 0.4 * 9.61 * (3.1 * t).sin();
        // the load has friction of its own behind the sensor
        let effort: Vec<f64> = (time_s.iter())
            .map(|&t| 20.0 * wave(t).cos() + 1.5 * turn(t) + 0.7 * speed(t).signum())
            .collect();
        let (gain, viscous, coulomb, inertia, offset) = (11.3, 3.0, 4.5, 0.8, -0.6);
        let current: Vec<f64> = (time_s.iter().zip(&effort))
            .map(|(&t, effort)| {
                let lost = viscous * speed(t) + coulomb * speed(t).signum() + inertia * turn(t);
                (effort + lost + offset) / gain + random.random_range(-0.05..0.05)
            })
            .collect();
        let joint = |name: &str| {
            let mut channels = JointChannels::new(name);
            let mut set =
                |quantity, values: &[f64]| *channels.channel_mut(quantity) = Some(values.to_vec());
            set(Quantity::Position, &time_s.iter().map(|t| wave(*t)).collect::<Vec<_>>());
            set(Quantity::Effort, &effort);
            if name == "sensed" {
                set(Quantity::Current, &current);
            }
            channels
        };
        let joints = ["sensed", "plain"].map(joint).to_vec();
        let recording = Recording::new("made", time_s.clone(), joints).unwrap();
        let names = ["sensed", "plain"];
        let motion = Motion::from_recording(&recording, &names, &MotionSettings::default());
        let found = sensed_gears(&[recording], &[motion.unwrap()], &names);
        assert!(found[1].is_none());
        let gear = found[0].unwrap();
        assert!(gear.is_determined);
        for (found, truth) in [
            (gear.gain, gain),
            (gear.viscous, viscous),
            (gear.coulomb, coulomb),
            (gear.inertia, inertia),
            (gear.offset, offset),
        ] {
            let off = (found.value - truth).abs();
            assert!(off < 3.0 * found.standard_error, "{truth}: {found:?}");
            assert!(found.standard_error < 0.05 * truth.abs(), "{truth}: {found:?}");
        }
    }
}
