//! Choosing the low-pass cutoff from the motion itself.

use std::f64::consts::LN_2;

use rayon::prelude::*;

use crate::grid::EvenGrid;
use crate::periodogram::Periodogram;
use crate::stuck::RESTING_RANGE;
use armident_numeric::{extremes, order_statistic};
use armident_recording::{MIN_SAMPLES, Quantity, Recording, RecordingError};

/// Share of the velocity power that lies below the band edge of a motion.
pub const POWER_SHARE: f64 = 0.999;
/// Cutoff over band edge: at this distance the fourth order, forward and backward, takes less than
/// 1e-5 of the amplitude at the band edge.
pub const CUTOFF_OVER_EDGE: f64 = 4.5;
/// Share of the velocity power that makes the main motion of a joint.
const MAIN_SHARE: f64 = 0.9;
/// Power of the noise in an acceleration over that of the acceleration, at most.
const ACCELERATION_NOISE: f64 = 1e-3;
/// Lowest cutoff chosen \[Hz\].
pub const LOWEST_CUTOFF_HZ: f64 = 1.0;
/// Highest cutoff at which a recording can be filtered along with faster ones, as a share of its sample rate: half of it is
/// none, and next to it the low-pass rings.
const POSSIBLE_SHARE: f64 = 0.4;
/// Highest cutoff chosen, as a share of the sample rate.
pub const HIGHEST_CUTOFF_SHARE: f64 = 0.2;

/// Bins to either side over which the spectrum is averaged before it is compared with the noise.
const SMOOTHING_BINS: usize = 4;
/// Multiple of the noise floor above which the averaged spectrum is motion.
const MOTION_OVER_NOISE: f64 = 30.0;

/// One cutoff \[Hz\] for all recordings of a fit: as given, or the largest that the spectra of `joints`
/// ask for, as far as the slowest of them can be filtered there; none where exact accelerations are recorded.
///
/// # Errors
/// A recording whose stamps make no grid.
pub fn common_cutoff_hz(
    recordings: &[Recording],
    joints: &[&str],
    given: Option<f64>,
) -> Result<Option<f64>, RecordingError> {
    let exact = |r: &Recording| {
        joints.iter().all(|j| {
            r.joint(j).is_some_and(|j| {
                j.channel(Quantity::Velocity).is_some()
                    && j.channel(Quantity::Acceleration).is_some()
            })
        })
    };
    if given.is_some() || recordings.iter().all(exact) {
        return Ok(given);
    }
    let (mut largest, mut possible) = (0.0_f64, f64::INFINITY);
    for recording in recordings {
        let grid = EvenGrid::of(recording)?;
        let positions: Vec<Vec<f64>> = joints
            .iter()
            .filter_map(|j| recording.joint(j)?.channel(Quantity::Position))
            .map(|column| grid.resample(column))
            .collect();
        largest = largest.max(default_cutoff_hz(&positions, grid.rate_hz()));
        possible = possible.min(POSSIBLE_SHARE * grid.rate_hz());
    }
    Ok(Some(largest.min(possible)))
}

/// The cutoff \[Hz\] for evenly sampled positions, one column per joint:
/// [`CUTOFF_OVER_EDGE`] times the highest [`band_edge_hz`] of the joints, not below
/// [`LOWEST_CUTOFF_HZ`] and not above [`HIGHEST_CUTOFF_SHARE`] of the rate.
///
/// Nor above the frequency up to which the noise of any joint's position, differentiated twice, has a
/// thousandth of the power of its acceleration: noise in the columns of a fit takes its share off the
/// inertias. But no joint is kept from its main motion, where 90 % of its velocity power lies, by the noise
/// of another.
pub fn default_cutoff_hz(positions: &[Vec<f64>], rate_hz: f64) -> f64 {
    let bands: Vec<Band> =
        positions.par_iter().filter_map(|position| Band::of(position, rate_hz)).collect();
    let highest = |of: fn(&Band) -> f64| bands.iter().map(of).fold(0.0, f64::max);
    let quiet_hz = bands.iter().map(|band| band.quiet_hz).fold(f64::INFINITY, f64::min);
    (CUTOFF_OVER_EDGE * highest(|band| band.edge_hz))
        .min(quiet_hz.max(CUTOFF_OVER_EDGE * highest(|band| band.main_hz)))
        .max(LOWEST_CUTOFF_HZ)
        .min(HIGHEST_CUTOFF_SHARE * rate_hz)
}

/// Frequency below which [`POWER_SHARE`] of the velocity power of a position signal lies \[Hz\];
/// none for a joint that rests, or of which nothing stands out of its noise.
///
/// The spectrum is that of the position without its straight line, under a Hann window. Its noise
/// floor is the median above a quarter of the sample rate, since the noise of quantisation is white
/// in the position. The motion reaches from its strongest frequency up until the averaged spectrum
/// stays below 30 times the floor for an octave: narrow lines further up are interference or
/// resonance, and would have much weight in the velocity. Up to there, the spectrum less the floor,
/// times the frequency squared, is the power of the velocity.
pub fn band_edge_hz(position: &[f64], rate_hz: f64) -> Option<f64> {
    Band::of(position, rate_hz).map(|band| band.edge_hz)
}

/// Where the motion of a joint lies in frequency.
#[derive(Debug, Clone, Copy)]
struct Band {
    /// [`band_edge_hz`].
    edge_hz: f64,
    /// Frequency below which a share of 0.9 of the velocity power lies.
    main_hz: f64,
    /// Cutoff at which noise has [`ACCELERATION_NOISE`] of the power of the acceleration.
    quiet_hz: f64,
}

impl Band {
    fn of(position: &[f64], rate_hz: f64) -> Option<Self> {
        let [smallest, largest] = extremes(position.iter().copied());
        if position.len() < MIN_SAMPLES || largest - smallest < RESTING_RANGE {
            return None;
        }
        let power = Periodogram::new(position.len()).of(position).to_vec();
        let measured = noise_power(&power);
        let rounding = f64::EPSILON * largest.abs().max(smallest.abs());
        let floor = measured.max(rounding.powi(2));

        let averaged = |k: usize| {
            let from = k.saturating_sub(SMOOTHING_BINS).max(1);
            let near = &power[from..(k + SMOOTHING_BINS + 1).min(power.len())];
            near.iter().sum::<f64>() / near.len() as f64
        };
        let strongest = (1..power.len()).max_by(|a, b| power[*a].total_cmp(&power[*b]))?;
        let mut last = None;
        for k in strongest..power.len() {
            if averaged(k) > MOTION_OVER_NOISE * floor {
                last = Some(k);
            } else if k > 2 * last? {
                break;
            }
        }
        let last = last?;
        let velocity = |k: usize| (k as f64).powi(2) * (power[k] - floor).max(0.0);
        let total: f64 = (1..=last).map(velocity).sum();
        let below = |share: f64| {
            let mut below = 0.0;
            (1..=last).find(|&k| {
                below += velocity(k);
                below >= share * total
            })
        };
        let (main, edge) = (below(MAIN_SHARE)?, below(POWER_SHARE)?);
        let acceleration: f64 = (1..=edge).map(|k| (k as f64).powi(2) * velocity(k)).sum();
        let mut noise = 0.0;
        let quiet = (1..power.len()).find(|&k| {
            noise += (k as f64).powi(4) * floor;
            noise > ACCELERATION_NOISE * acceleration
        });
        let in_hz = |k: usize| k as f64 * rate_hz / position.len() as f64;
        Some(Self {
            edge_hz: in_hz(edge),
            main_hz: in_hz(main),
            quiet_hz: in_hz(quiet.unwrap_or(power.len())),
        })
    }
}

/// Mean power of a bin of white noise, from the upper half of the bins.
fn noise_power(power: &[f64]) -> f64 {
    // the median of an exponentially distributed periodogram is ln 2 of its mean
    let mut upper = power[power.len() / 2..].to_vec();
    let middle = upper.len() / 2;
    order_statistic(&mut upper, middle).unwrap_or_default() / LN_2
}

/// Standard deviation of the white noise in evenly sampled values: from the median of the spectrum
/// above a quarter of the sample rate, so that motion below and narrow lines do not count.
pub(crate) fn noise_sigma(values: &[f64]) -> Option<f64> {
    if values.len() < MIN_SAMPLES {
        return None;
    }
    let sigma = noise_power(Periodogram::new(values.len()).of(values)).sqrt();
    sigma.is_finite().then_some(sigma)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    const RATE_HZ: f64 = 250.0;

    struct Pcg(u64);

    impl Pcg {
        fn new(seed: u64) -> Self {
            Self(seed)
        }

        /// Sum of twelve uniform numbers.
        fn normal(&mut self) -> f64 {
            let mut uniform = || {
                self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (self.0 >> 33) as f64 / (1_u64 << 31) as f64
            };
            (0..12).map(|_| uniform()).sum::<f64>() - 6.0
        }
    }

    /// A swing at a third of the highest frequency, in steps.
    fn motion(edge_hz: f64, step: f64) -> Vec<f64> {
        (0..5000)
            .map(|k| {
                let angle = 2.0 * PI * edge_hz * f64::from(k) / RATE_HZ;
                let x = 0.8 * (angle / 3.0).sin() + 0.2 * (angle / 1.6).sin() + 0.1 * angle.cos();
                if step > 0.0 { (x / step).round() * step } else { x }
            })
            .collect()
    }

    #[test]
    fn finds_the_fastest_part_of_the_motion() {
        for step in [0.0, 1e-5, 1e-3] {
            for edge_hz in [0.9, 2.3, 5.1] {
                let found_hz = band_edge_hz(&motion(edge_hz, step), RATE_HZ).unwrap();
                assert!((found_hz - edge_hz).abs() < 0.15, "{found_hz} for {edge_hz}, {step}");
            }
        }
    }

    #[test]
    fn noise_is_measured_beside_the_motion() {
        let mut state = 7_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        };
        let noisy: Vec<f64> = motion(5.1, 0.0).iter().map(|x| x + 0.01 * uniform()).collect();
        let sigma = 0.01 / 12.0_f64.sqrt();
        assert!((noise_sigma(&noisy).unwrap() / sigma - 1.0).abs() < 0.1);
        assert_eq!(noise_sigma(&[1.0; 100]), Some(0.0));
    }

    #[test]
    fn interference_far_above_the_motion_is_left_out() {
        let mut position = motion(2.3, 1e-5);
        for (k, x) in position.iter_mut().enumerate() {
            *x += 5e-3 * (2.0 * PI * 61.0 * k as f64 / RATE_HZ).sin();
        }
        assert!((band_edge_hz(&position, RATE_HZ).unwrap() - 2.3).abs() < 0.15);
    }

    #[test]
    fn the_cutoff_follows_the_fastest_joint_and_is_limited() {
        let cutoff = |edges: &[f64]| {
            let positions: Vec<Vec<f64>> = edges.iter().map(|edge| motion(*edge, 1e-5)).collect();
            default_cutoff_hz(&positions, RATE_HZ)
        };
        assert!((cutoff(&[1.1, 3.0]) - 13.5).abs() < 0.7);
        assert_eq!(cutoff(&[40.0]), 50.0);
        let slow: Vec<f64> = (0..5000).map(|k| (1e-3 * f64::from(k)).sin()).collect();
        assert_eq!(default_cutoff_hz(&[slow], RATE_HZ), 1.0);
    }

    /// White noise of standard deviation `s` has the power `s² (2 π)⁴ f⁵ / (5 · rate/2)` in the
    /// acceleration below `f`; a sine of amplitude `a` and frequency `g` has `½ a² (2 π g)⁴`.
    #[test]
    fn noise_of_the_acceleration_limits_the_cutoff() {
        let mut random = Pcg::new(3);
        let (amplitude, slow_hz): (f64, f64) = (0.8, 1.3);
        let mut noisy = |sigma: f64| -> Vec<f64> {
            (0..20_000)
                .map(|k| {
                    let angle = 2.0 * PI * f64::from(k) / RATE_HZ;
                    // some motion an octave higher, which reaches for a high cutoff
                    let fast = 0.05 * (2.4 * angle).sin();
                    amplitude * (slow_hz * angle).sin() + fast + sigma * random.normal()
                })
                .collect()
        };
        let acceleration =
            0.5 * (amplitude * slow_hz.powi(2)).powi(2) + 0.5 * (0.05 * 2.4_f64.powi(2)).powi(2);
        for sigma in [1e-4_f64, 4e-3] {
            let limit_hz: f64 = ACCELERATION_NOISE * acceleration * 2.5 * RATE_HZ / sigma.powi(2);
            let expected_hz = limit_hz.powf(0.2).min(CUTOFF_OVER_EDGE * 2.4);
            let found_hz = default_cutoff_hz(&[noisy(sigma)], RATE_HZ);
            assert!((found_hz / expected_hz - 1.0).abs() < 0.1, "{found_hz} {expected_hz}");
        }
        // a joint that hardly moves keeps no other from its motion
        let still: Vec<f64> = noisy(1e-3).iter().map(|x| 0.01 * x).collect();
        let coarse: Vec<f64> = still.iter().map(|x| (x / 2e-3).round() * 2e-3).collect();
        let found_hz = default_cutoff_hz(&[motion(5.1, 1e-5), coarse], RATE_HZ);
        assert!(found_hz > 4.5 * 1.7, "{found_hz}");
    }

    #[test]
    fn a_joint_at_rest_has_no_say() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as f64 / (1_u64 << 31) as f64
        };
        let noise: Vec<f64> = (0..3000).map(|_| 2e-3 * random()).collect();
        assert_eq!(band_edge_hz(&noise, RATE_HZ), None);
        assert_eq!(band_edge_hz(&[1.0; 100], RATE_HZ), None);
        assert_eq!(band_edge_hz(&[0.0, 1.0, 0.0], RATE_HZ), None);
        let one_count: Vec<f64> = (0..500).map(|k| if k < 200 { 0.0 } else { 1e-4 }).collect();
        assert_eq!(band_edge_hz(&one_count, RATE_HZ), None);
        let moving = motion(2.3, 1e-5);
        assert_eq!(
            default_cutoff_hz(&[moving.clone(), vec![0.3; 5000]], RATE_HZ),
            default_cutoff_hz(&[moving], RATE_HZ)
        );
    }
}
