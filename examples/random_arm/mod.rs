//! What the studies of simulated arms draw: links, motions and noise.

use armident_kinematics::InertialParameters;
use armident_recording::JointChannels;
use nalgebra::Matrix4;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

/// Harmonics of a motion.
const HARMONICS: usize = 5;

/// A link that is real and differs from a given one: its mass is stretched, sheared and moved by shares of
/// its own extent, whatever the direction; second moments of mass differ by `relative_error`.
pub(crate) fn drawn_link(
    link: &InertialParameters,
    relative_error: f64,
    random: &mut Pcg64,
) -> Result<InertialParameters, Box<dyn std::error::Error>> {
    let normal = Matrix4::from_fn(|_, _| StandardNormal.sample(random));
    // half, for what is on both sides counts twice
    let stretch = Matrix4::identity() + normal * (0.5 * relative_error);
    let root = link.pseudo_inertia().cholesky().ok_or("a link is not physically consistent")?.l();
    Ok(InertialParameters::from_pseudo_inertia(
        &(root * stretch * stretch.transpose() * root.transpose()),
    ))
}

/// A joint's exact motion: harmonics of `fundamental_hz` with random phases about a middle \[rad\], the same speed \[rad/s\] in each.
pub(crate) fn sum_of_sines(
    joint: &str,
    time_s: &[f64],
    fundamental_hz: f64,
    [middle, speed]: [f64; 2],
    random: &mut Pcg64,
) -> JointChannels {
    let phases: Vec<f64> =
        (0..HARMONICS).map(|_| random.random_range(0.0..std::f64::consts::TAU)).collect();
    let at = |t: f64| {
        let mut sum = (middle, 0.0, 0.0);
        for (k, phase) in phases.iter().enumerate() {
            let w = std::f64::consts::TAU * fundamental_hz * (k + 1) as f64;
            let (sin, cos) = (w * t + phase).sin_cos();
            sum.0 += speed / w * sin;
            sum.1 += speed * cos;
            sum.2 -= speed * w * sin;
        }
        sum
    };
    let column =
        |pick: fn((f64, f64, f64)) -> f64| Some(time_s.iter().map(|&t| pick(at(t))).collect());
    JointChannels {
        position: column(|s| s.0),
        velocity: column(|s| s.1),
        acceleration: column(|s| s.2),
        ..JointChannels::new(joint)
    }
}

/// Adds Gaussian noise: a share of the standard deviation of the values, with this correlation of neighbouring samples.
pub(crate) fn add_coloured_noise(
    values: &mut [f64],
    share: f64,
    correlation: f64,
    random: &mut Pcg64,
) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let spread = (values.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / count).sqrt();
    let mut noise = 0.0;
    for value in values {
        let fresh: f64 = StandardNormal.sample(random);
        noise = correlation * noise + (1.0 - correlation * correlation).sqrt() * fresh;
        *value += share * spread * noise;
    }
}
