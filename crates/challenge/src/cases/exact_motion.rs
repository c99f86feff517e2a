//! The motion of a simulated arm, without sensors.

use armident_recording::{JointChannels, Recording};

use crate::arms::excitation::CONTROL_HZ;

/// An exact motion at the instants of a recording; joint-major.
pub(crate) struct Exact {
    pub(crate) time_s: Vec<f64>,
    pub(crate) position: Vec<Vec<f64>>,
    pub(crate) velocity: Vec<Vec<f64>>,
    pub(crate) acceleration: Vec<Vec<f64>>,
    /// As its channel shows it without lag and noise.
    pub(crate) effort: Vec<Vec<f64>>,
}

/// The motion at these instants; efforts that are held for a control cycle count for its middle.
pub(crate) fn exact_at(moved: &Recording, instants: &[f64]) -> Exact {
    let column = |pick: fn(&JointChannels) -> &Option<Vec<f64>>| -> Vec<&[f64]> {
        moved.joints.iter().map(|joint| pick(joint).as_deref().unwrap_or_default()).collect()
    };
    let (q, v) = (column(|j| &j.position), column(|j| &j.velocity));
    let u = column(|j| &j.effort);
    let last = moved.len() - 2;
    let place = |t: f64| {
        let k = ((t * CONTROL_HZ).floor().max(0.0) as usize).min(last);
        (k, t * CONTROL_HZ - k as f64)
    };
    let h = 1.0 / CONTROL_HZ;
    let each = |f: &dyn Fn(usize, usize, f64) -> f64| -> Vec<Vec<f64>> {
        (0..q.len())
            .map(|j| {
                let at = |t: &f64| {
                    let (k, share) = place(*t);
                    f(j, k, share)
                };
                instants.iter().map(at).collect()
            })
            .collect()
    };
    let line = |x: &[f64], k: usize, share: f64| x[k] + share * (x[k + 1] - x[k]);
    Exact {
        time_s: instants.to_vec(),
        position: each(&|j, k, s| {
            let (r, x) = (1.0 - s, q[j]);
            x[k] * r * r * (1.0 + 2.0 * s)
                + x[k + 1] * s * s * (1.0 + 2.0 * r)
                + h * s * r * (v[j][k] * r - v[j][k + 1] * s)
        }),
        velocity: each(&|j, k, share| line(v[j], k, share)),
        // that of a whole cycle, as the effort
        acceleration: each(&|j, k, share| {
            let x = |k: usize| (v[j][k + 1] - v[j][k]) / h;
            let (before, share) = about_middles(k, share);
            let before = before.min(last - 1);
            x(before) + share * (x(before + 1) - x(before))
        }),
        effort: each(&|j, k, share| {
            let (before, share) = about_middles(k, share);
            line(u[j], before, share)
        }),
    }
}

/// Place between the middles of control cycles of a place between their starts.
fn about_middles(k: usize, share: f64) -> (usize, f64) {
    if share >= 0.5 || k == 0 { (k, share - 0.5) } else { (k - 1, share + 0.5) }
}

/// Root mean square.
pub(crate) fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
