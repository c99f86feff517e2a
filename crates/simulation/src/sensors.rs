//! What sensors make of an exact motion.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use armident_kinematics::JointKind;
use armident_recording::{JointChannels, Quantity, Recording};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use crate::error::SimulationError;
use crate::simulated_arm::SimulatedArm;
use crate::trajectory::missing;

/// Finest encoder \[bits\].
pub const MOST_ENCODER_BITS: u32 = 40;

/// White Gaussian noise on the effort channels.
#[derive(Debug, Clone, PartialEq)]
pub enum EffortNoise {
    /// Standard deviation of each joint by name \[N m or N\]; joints not named have none.
    Absolute(BTreeMap<String, f64>),
    /// Standard deviation as a share of the standard deviation of the joint's own effort over the
    /// recording.
    Relative(f64),
}

/// Sensors of an arm; the default ones are perfect.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sensors {
    /// Noise of the efforts.
    pub effort_noise: Option<EffortNoise>,
    /// Encoders on the joint side of `2^bits` counts per turn, or per metre on a translational
    /// joint.
    pub encoder_bits: Option<u32>,
    /// Seed of the noise. Joint `j` of the chain draws from stream `j` of the generator PCG XSL
    /// 128/64, whatever happens on other joints; values are the same on every platform up to rounding
    /// of `exp` and `ln`, and change only with a new minor version of `rand_distr`.
    pub seed: u64,
}

impl Sensors {
    /// The recording that these sensors take.
    ///
    /// With noise alone the motion stays exact. With encoders the position is rounded to counts,
    /// the velocity is the central difference of the rounded position (one-sided at the two ends),
    /// and there is no acceleration. Currents and voltages stay as they are.
    ///
    /// # Errors
    /// An inconsistent recording, or one with joints that the arm does not have; noise for a joint
    /// that is not recorded or has no effort, noise that is negative or not finite; encoders
    /// without a count or of more than [`MOST_ENCODER_BITS`] bits.
    pub fn apply(
        &self,
        arm: &SimulatedArm,
        recording: &Recording,
    ) -> Result<Recording, SimulationError> {
        recording.check()?;
        self.check(recording)?;
        let mut measured = recording.clone();
        for joint in &mut measured.joints {
            let Some(index) = arm.joints().iter().position(|name| *name == joint.name) else {
                return Err(SimulationError::OtherJoints {
                    what: "the recording",
                    found: recording.joint_names().into_iter().map(str::to_owned).collect(),
                    known: arm.joints().to_vec(),
                });
            };
            if let Some(bits) = self.encoder_bits {
                let range = match arm.rigid().joints[index].kind {
                    JointKind::Rotational => TAU,
                    JointKind::Translational => 1.0,
                };
                encode(joint, &recording.time_s, range / 2_f64.powi(bits as i32));
            }
            if let Some(sigma) = self.sigma(joint)
                && let Some(effort) = &mut joint.effort
            {
                let mut random = Pcg64::new(self.seed.into(), index as u128);
                for value in effort {
                    let normal: f64 = StandardNormal.sample(&mut random);
                    *value += sigma * normal;
                }
            }
        }
        measured.notes.extend(self.note());
        measured.check()?;
        Ok(measured)
    }

    fn check(&self, recording: &Recording) -> Result<(), SimulationError> {
        let setting =
            |setting, value, range: String| SimulationError::Setting { setting, value, range };
        if let Some(bits) = self.encoder_bits
            && !(1..=MOST_ENCODER_BITS).contains(&bits)
        {
            let range = format!("from 1 to {MOST_ENCODER_BITS}");
            return Err(setting("the encoder resolution [bits]", bits.into(), range));
        }
        let effort_of = |name: &str| recording.joint(name).and_then(|joint| joint.effort.as_ref());
        let (sigmas, names): (Vec<f64>, Vec<&str>) = match &self.effort_noise {
            None => return Ok(()),
            Some(EffortNoise::Relative(share)) => (vec![*share], recording.joint_names()),
            Some(EffortNoise::Absolute(sigmas)) => {
                (sigmas.values().copied().collect(), sigmas.keys().map(String::as_str).collect())
            }
        };
        if let Some(bad) = sigmas.into_iter().find(|s| !(s.is_finite() && *s >= 0.0)) {
            let range = "zero or a positive number".to_owned();
            return Err(setting("the standard deviation of the effort noise", bad, range));
        }
        match names.into_iter().find(|name| effort_of(name).is_none()) {
            Some(name) => Err(missing(recording, name, Quantity::Effort)),
            None => Ok(()),
        }
    }

    /// Standard deviation of the noise of a joint \[N m or N\].
    fn sigma(&self, joint: &JointChannels) -> Option<f64> {
        match self.effort_noise.as_ref()? {
            EffortNoise::Absolute(sigmas) => sigmas.get(&joint.name).copied(),
            EffortNoise::Relative(share) => {
                let effort = joint.effort.as_ref()?;
                let count = effort.len() as f64;
                let mean = effort.iter().sum::<f64>() / count;
                let variance = effort.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / count;
                Some(share * variance.sqrt())
            }
        }
    }

    fn note(&self) -> Option<String> {
        let seed = self.seed;
        let noise = match &self.effort_noise {
            None => None,
            Some(EffortNoise::Relative(share)) => Some(format!(
                "effort noise of {} % of the effort's deviation, seed {seed}",
                100.0 * share
            )),
            Some(EffortNoise::Absolute(sigmas)) => {
                let list: Vec<String> =
                    sigmas.iter().map(|(name, sigma)| format!("{name} {sigma}")).collect();
                Some(format!("effort noise of {}, seed {seed}", list.join(", ")))
            }
        };
        let encoder = self.encoder_bits.map(|bits| {
            format!("position by encoders of {bits} bits, velocity by its central differences")
        });
        let parts: Vec<String> = [encoder, noise].into_iter().flatten().collect();
        (!parts.is_empty()).then(|| parts.join("; "))
    }
}

/// Rounds the position to counts and derives the velocity from it.
fn encode(joint: &mut JointChannels, time_s: &[f64], count: f64) {
    let Some(position) = &mut joint.position else { return };
    for value in position.iter_mut() {
        *value = (*value / count).round() * count;
    }
    let last = position.len() - 1;
    let slope = |k: usize| {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(last));
        (position[after] - position[before]) / (time_s[after] - time_s[before])
    };
    joint.velocity = Some((0..=last).map(slope).collect());
    joint.acceleration = None;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inverse::inverse;
    use crate::test_arms::{harmonic, stanford};

    const SAMPLES: usize = 20_000;

    fn exact() -> (SimulatedArm, Recording) {
        let arm = stanford(&[]);
        let recording = inverse(&arm, &harmonic(arm.joints(), SAMPLES, 1e-3)).unwrap();
        (arm, recording)
    }

    fn noise(arm: &SimulatedArm, exact: &Recording, sensors: &Sensors) -> Vec<Vec<f64>> {
        let measured = sensors.apply(arm, exact).unwrap();
        let joints = measured.joints.iter().zip(&exact.joints);
        let difference = joints.map(|(m, e)| {
            let efforts = m.effort.as_ref().unwrap().iter().zip(e.effort.as_ref().unwrap());
            efforts.map(|(m, e)| m - e).collect()
        });
        difference.collect()
    }

    fn deviation(values: &[f64]) -> f64 {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
    }

    fn absolute(sigmas: &[(&str, f64)], seed: u64) -> Sensors {
        let sigmas = sigmas.iter().map(|(name, sigma)| ((*name).to_owned(), *sigma)).collect();
        Sensors { effort_noise: Some(EffortNoise::Absolute(sigmas)), seed, ..Sensors::default() }
    }

    #[test]
    fn noise_is_white_with_given_deviation() {
        let (arm, exact) = exact();
        let relative = |seed| Sensors {
            effort_noise: Some(EffortNoise::Relative(0.05)),
            seed,
            ..Sensors::default()
        };
        let (a, b) = (noise(&arm, &exact, &relative(1)), noise(&arm, &exact, &relative(2)));
        let correlation = |x: &[f64], y: &[f64]| {
            let sum: f64 = x.iter().zip(y).map(|(x, y)| x * y).sum();
            sum / (x.len() as f64 * deviation(x) * deviation(y))
        };
        let bound = 4.5 / (SAMPLES as f64).sqrt();
        for j in 0..6 {
            let sigma = 0.05 * deviation(exact.joints[j].effort.as_ref().unwrap());
            assert!((deviation(&a[j]) / sigma - 1.0).abs() < bound);
            assert!(a[j].iter().sum::<f64>().abs() / (SAMPLES as f64) < bound * sigma);
            assert!(correlation(&a[j], &b[j]).abs() < bound);
            assert!(correlation(&a[j][1..], &a[j][..SAMPLES - 1]).abs() < bound);
            for other in 0..j {
                assert!(correlation(&a[j], &a[other]).abs() < bound);
            }
        }
    }

    #[test]
    fn noise_depends_on_seed_and_joint_only() {
        let (arm, exact) = exact();
        let alone = noise(&arm, &exact, &absolute(&[("joint_3", 0.5)], 7));
        let both = noise(&arm, &exact, &absolute(&[("joint_1", 2.0), ("joint_3", 0.5)], 7));
        assert_eq!(alone[2], both[2]);
        assert!(alone[0].iter().all(|e| *e == 0.0));
        assert_ne!(alone[2], noise(&arm, &exact, &absolute(&[("joint_3", 0.5)], 8))[2]);
        // the same joints in another order
        let mut turned = exact.clone();
        turned.joints.reverse();
        let found = noise(&arm, &turned, &absolute(&[("joint_3", 0.5)], 7));
        assert_eq!(alone[2], found[3]);
        let motion = |r: &Recording| r.joints[2].acceleration.clone();
        let measured = absolute(&[("joint_3", 0.5)], 7).apply(&arm, &exact).unwrap();
        assert_eq!(motion(&measured), motion(&exact));
        assert_eq!(measured.notes, ["effort noise of joint_3 0.5, seed 7"]);
    }

    #[test]
    fn noise_does_not_change() {
        let mut random = Pcg64::new(7, 2);
        let first: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(&mut random));
        assert_eq!(first, [-1.0915030303245723, -1.93055516587367, 0.39418438405328804]);
    }

    #[test]
    fn encoders_round_to_the_nearest_count() {
        let (arm, exact) = exact();
        let sensors = Sensors { encoder_bits: Some(14), ..Sensors::default() };
        let measured = sensors.apply(&arm, &exact).unwrap();
        for (j, (found, exact)) in measured.joints.iter().zip(&exact.joints).enumerate() {
            let count = if j == 2 { 1.0 } else { TAU } / 16384.0;
            let position = found.position.as_ref().unwrap();
            let mut errors: Vec<f64> = position
                .iter()
                .zip(exact.position.as_ref().unwrap())
                .map(|(f, e)| (f - e) / count)
                .collect();
            assert!(position.iter().all(|p| (p / count - (p / count).round()).abs() < 1e-9));
            // the distribution function of errors spread evenly over one count
            errors.sort_by(f64::total_cmp);
            for (k, error) in errors.iter().enumerate() {
                assert!(error.abs() <= 0.5 + 1e-9);
                let expected = (k as f64 + 0.5) / SAMPLES as f64 - 0.5;
                assert!((error - expected).abs() < 0.03, "joint {j}: {error} {expected}");
            }
            let velocity = found.velocity.as_ref().unwrap();
            assert!((velocity[9] - (position[10] - position[8]) / 0.002).abs() < 1e-9);
            assert!(found.acceleration.is_none() && found.effort == exact.effort);
        }
    }
}
