//! Choosing the low-pass cutoff from the motion itself.

use std::f64::consts::{LN_2, PI};

use realfft::RealFftPlanner;

/// Share of the velocity power that lies below the band edge of a motion.
pub const POWER_SHARE: f64 = 0.999;
/// Cutoff over band edge: at this distance the fourth order, forward and backward, takes less than
/// 1e-5 of the amplitude at the band edge.
pub const CUTOFF_OVER_EDGE: f64 = 4.5;
/// Lowest cutoff chosen \[Hz\].
pub const LOWEST_CUTOFF_HZ: f64 = 1.0;
/// Highest cutoff chosen, as a share of the sample rate.
pub const HIGHEST_CUTOFF_SHARE: f64 = 0.2;

/// Bins to either side over which the spectrum is averaged before it is compared with the noise.
const SMOOTHING_BINS: usize = 4;
/// Multiple of the noise floor that counts as motion.
const SIGNAL_OVER_NOISE: f64 = 4.0;
/// A joint moves if its power is at least this multiple of its noise power.
const MOVING_OVER_NOISE: f64 = 100.0;

/// The cutoff \[Hz\] for evenly sampled positions, one column per joint:
/// [`CUTOFF_OVER_EDGE`] times the highest [`band_edge_hz`] of the joints, not below
/// [`LOWEST_CUTOFF_HZ`] and not above [`HIGHEST_CUTOFF_SHARE`] of the rate.
pub fn default_cutoff_hz(positions: &[Vec<f64>], rate_hz: f64) -> f64 {
    let edge_hz =
        positions.iter().filter_map(|position| band_edge_hz(position, rate_hz)).fold(0.0, f64::max);
    (CUTOFF_OVER_EDGE * edge_hz).max(LOWEST_CUTOFF_HZ).min(HIGHEST_CUTOFF_SHARE * rate_hz)
}

/// Frequency below which [`POWER_SHARE`] of the velocity power of a position signal lies \[Hz\];
/// none for a joint that does not move above its noise.
///
/// The spectrum is that of the position, its line through the ends of motion taken off, under a
/// Hann window. Its noise floor is the median above a quarter of the sample rate (noise of
/// quantisation is white in the position). What stands four times above the floor, less the floor,
/// times the frequency squared, is the spectrum of the velocity.
pub fn band_edge_hz(position: &[f64], rate_hz: f64) -> Option<f64> {
    let power = windowed_power(position)?;
    let upper_half = &power[power.len() / 2..];
    // the median of an exponentially distributed periodogram is ln 2 of its mean
    let floor = median(upper_half) / LN_2;

    let motion: Vec<f64> = (1..power.len())
        .map(|k| {
            let from = k.saturating_sub(SMOOTHING_BINS).max(1);
            let near = &power[from..(k + SMOOTHING_BINS + 1).min(power.len())];
            let mean = near.iter().sum::<f64>() / near.len() as f64;
            if mean > SIGNAL_OVER_NOISE * floor { (power[k] - floor).max(0.0) } else { 0.0 }
        })
        .collect();
    let moving: f64 = motion.iter().sum();
    if moving <= 0.0 || moving < MOVING_OVER_NOISE * floor * motion.len() as f64 {
        return None;
    }
    let velocity = |k: usize| ((k + 1) as f64).powi(2) * motion[k];
    let total: f64 = (0..motion.len()).map(velocity).sum();
    let mut below = 0.0;
    let edge = (0..motion.len()).find(|&k| {
        below += velocity(k);
        below >= POWER_SHARE * total
    })?;
    Some((edge + 1) as f64 * rate_hz / position.len() as f64)
}

/// Periodogram of the detrended signal under a Hann window, arbitrary scale.
fn windowed_power(signal: &[f64]) -> Option<Vec<f64>> {
    let n = signal.len();
    if n < 8 {
        return None;
    }
    let middle = 0.5 * (n - 1) as f64;
    let mean = signal.iter().sum::<f64>() / n as f64;
    let lever = |k: usize| k as f64 - middle;
    let moment: f64 = signal.iter().enumerate().map(|(k, x)| lever(k) * (x - mean)).sum();
    let slope = moment / (0..n).map(|k| lever(k).powi(2)).sum::<f64>();
    let mut windowed: Vec<f64> = signal
        .iter()
        .enumerate()
        .map(|(k, x)| {
            let hann = (PI * (k as f64 + 0.5) / n as f64).sin().powi(2);
            hann * (x - mean - slope * lever(k))
        })
        .collect();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let mut spectrum = transform.make_output_vec();
    transform.process(&mut windowed, &mut spectrum).ok()?;
    Some(spectrum.iter().map(realfft::num_complex::Complex::norm_sqr).collect())
}

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE_HZ: f64 = 250.0;

    fn motion(edge_hz: f64, step: f64) -> Vec<f64> {
        (0..5000)
            .map(|k| {
                let t = f64::from(k) / RATE_HZ;
                let x = 0.8 * (2.0 * PI * 0.31 * t).sin() + 0.1 * (2.0 * PI * edge_hz * t).cos();
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

    #[test]
    fn a_joint_at_rest_has_no_say() {
        let random = |k: i32| (f64::from(k) * 12.9898).sin() * 43_758.545_3;
        let noise: Vec<f64> = (0..3000).map(|k| 1e-5 * random(k).fract()).collect();
        assert_eq!(band_edge_hz(&noise, RATE_HZ), None);
        assert_eq!(band_edge_hz(&[1.0; 100], RATE_HZ), None);
        assert_eq!(band_edge_hz(&[0.0; 3], RATE_HZ), None);
        let moving = motion(2.3, 1e-5);
        assert_eq!(
            default_cutoff_hz(&[moving.clone(), vec![0.3; 5000]], RATE_HZ),
            default_cutoff_hz(&[moving], RATE_HZ)
        );
    }
}
