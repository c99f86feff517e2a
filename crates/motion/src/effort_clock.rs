//! Efforts that are recorded by a clock of their own, which runs faster or slower than that of the positions.

use crate::band_motion::BandMotion;
use crate::decimate::between;

/// What a clock that is fast by the share `drift` records of an effort on an even grid: after `t` seconds the effort at
/// `t (1 + drift)`. Both clocks begin with the recording.
pub fn by_clock(effort: &[f64], drift: f64) -> Vec<f64> {
    if drift == 0.0 {
        return effort.to_vec();
    }
    (0..effort.len()).map(|t| between(effort, t as f64 * (1.0 + drift))).collect()
}

impl BandMotion {
    /// With its efforts as they were at the times of the positions, where their clock is fast by the share `drift`.
    #[must_use]
    pub fn before_clock(mut self, drift: f64) -> Self {
        for effort in &mut self.effort {
            *effort = by_clock(effort, (1.0 + drift).recip() - 1.0);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// After 20 s a clock that is 500 ppm fast is 10 ms ahead, and what it recorded is put back.
    #[test]
    fn fast_clock_records_ahead() {
        let wave = |t: f64| (6.0 * t).sin();
        let exact: Vec<f64> = (0..2100).map(|k| wave(f64::from(k) / 100.0)).collect();
        let recorded = by_clock(&exact, 5e-4);
        assert!((recorded[2000] - wave(20.01)).abs() < 1e-4, "{}", recorded[2000]);
        let back = by_clock(&recorded, 1.0 / 1.0005 - 1.0);
        for (back, exact) in back[2..2090].iter().zip(&exact[2..]) {
            assert!((back - exact).abs() < 1e-4, "{back} {exact}");
        }
    }
}
