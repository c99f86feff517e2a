//! Smooth terms: linear B-splines of one or two variables, times functions of velocities, for structure that no
//! law of the library explains. They predict; they do not explain, and decay to zero beyond what they were fitted to.

use serde::{Deserialize, Serialize};

use crate::posed_recording::PosedRecording;

/// A recorded quantity of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AxisQuantity {
    /// Position.
    Position,
    /// Velocity.
    Velocity,
}

/// Knots along a quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SmoothAxis {
    /// Joint.
    pub joint: String,
    /// AxisQuantity of the joint.
    pub quantity: AxisQuantity,
    /// First and last knot.
    pub range: [f64; 2],
    /// Number of knots.
    pub knots: usize,
}

/// A function of a joint's velocity that multiplies the hats.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpeedFactor {
    /// Joint.
    pub joint: String,
    /// FactorForm.
    pub form: FactorForm,
    /// Speed at which a saturating form turns \[rad/s or m/s\].
    pub scale: f64,
    /// Fastest speed that it was fitted to \[rad/s or m/s\]; not in the models of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fastest: Option<f64>,
}

/// Distance over which a term without a law decays to zero beyond what it was fitted to, as a share of that range.
const DECAY: f64 = 0.5;

/// Share of a term that is left so far beyond its range.
fn decayed(beyond: f64, range: f64) -> f64 {
    (1.0 - beyond.max(0.0) / (DECAY * range)).clamp(0.0, 1.0)
}

/// Forms of a [`SpeedFactor`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FactorForm {
    /// `v`
    Linear,
    /// `v |v|`
    SignedSquare,
    /// `v³`
    Cube,
    /// `v / (1 + (v / scale)²)`
    Saturating,
    /// `|v|`
    Size,
    /// `v²`
    Square,
    /// Direction of motion, `sign(v)`, bridged where the joint stops.
    Direction,
}

impl SpeedFactor {
    fn value(&self, v: f64, direction: f64) -> f64 {
        match self.form {
            FactorForm::Direction => direction,
            FactorForm::Linear => v,
            FactorForm::SignedSquare => v * v.abs(),
            FactorForm::Cube => v * v * v,
            FactorForm::Saturating => v / (1.0 + (v / self.scale).powi(2)),
            FactorForm::Size => v.abs(),
            FactorForm::Square => v * v,
        }
    }

    /// The value, held at that of the fastest speed beyond it, and decaying there.
    fn bounded(&self, v: f64, direction: f64) -> f64 {
        match self.fastest {
            Some(fastest) if v.abs() > fastest => {
                self.value(v.clamp(-fastest, fastest), direction)
                    * decayed(v.abs() - fastest, fastest)
            }
            _ => self.value(v, direction),
        }
    }
}

/// Products of factors and hats.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SmoothBasis {
    /// Factors.
    pub factors: Vec<SpeedFactor>,
    /// Axes of hats: none, one, or two.
    pub axes: Vec<SmoothAxis>,
}

/// A flexible description with its numbers, as a model file holds it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SmoothTerm {
    /// Joint whose effort it describes.
    pub joint: String,
    /// Functions.
    pub basis: SmoothBasis,
    /// Their coefficients \[N m or N over the unit of the factors\].
    pub coefficients: Vec<f64>,
}

impl SmoothTerm {
    /// Whether there is a coefficient for every function, and knots for every axis.
    pub fn is_whole(&self) -> bool {
        let axes = &self.basis.axes;
        let spans = |axis: &SmoothAxis| {
            let [first, last] = axis.range;
            axis.knots >= 2 && first < last && (last - first).is_finite()
        };
        let size = axes.iter().try_fold(1_usize, |size, axis| size.checked_mul(axis.knots));
        axes.len() <= 2 && axes.iter().all(spans) && size == Some(self.coefficients.len())
    }

    /// Over a motion; joints that are not there count as resting at 0.
    pub fn effort(
        &self,
        at: &PosedRecording<'_>,
        index: impl Fn(&str) -> Option<usize>,
    ) -> Vec<f64> {
        let hats = self.basis.hats(at, &index);
        let value = |there: &[(usize, f64)]| {
            there.iter().map(|(function, weight)| self.coefficients[*function] * weight).sum()
        };
        hats.chunks_exact(self.basis.overlap()).map(value).collect()
    }
}

impl SmoothBasis {
    /// Names of the recorded columns it depends on.
    pub fn variables(&self) -> Vec<String> {
        let mut names: Vec<String> = self
            .axes
            .iter()
            .map(|axis| match axis.quantity {
                AxisQuantity::Position => format!("{}/position", axis.joint),
                AxisQuantity::Velocity => format!("{}/velocity", axis.joint),
            })
            .chain(self.factors.iter().map(|f| format!("{}/velocity", f.joint)))
            .collect();
        names.sort();
        names.dedup();
        names
    }

    /// Number of functions.
    pub fn size(&self) -> usize {
        self.axes.iter().map(|a| a.knots).product()
    }

    /// Product of the factors over a motion; joints that are not there rest.
    pub fn factor_values(
        &self,
        at: &PosedRecording<'_>,
        index: &impl Fn(&str) -> Option<usize>,
    ) -> Vec<f64> {
        let mut product = vec![1.0; at.signals.len()];
        for factor in &self.factors {
            let joint = index(&factor.joint);
            for (t, p) in product.iter_mut().enumerate() {
                let of = |values: &[Vec<f64>]| joint.map_or(0.0, |j| values[j][t]);
                *p *= factor.bounded(of(&at.signals.velocity), of(&at.signals.direction));
            }
        }
        product
    }

    /// How many functions are not zero at a sample: hats overlap in pairs along each axis.
    pub fn overlap(&self) -> usize {
        1 << self.axes.len()
    }

    /// The functions that are not zero and their values, [`Self::overlap`] a sample.
    pub fn hats(
        &self,
        at: &PosedRecording<'_>,
        index: &impl Fn(&str) -> Option<usize>,
    ) -> Vec<(usize, f64)> {
        let axes: Vec<Option<&[f64]>> = self
            .axes
            .iter()
            .map(|axis| {
                index(&axis.joint).map(|j| match axis.quantity {
                    AxisQuantity::Position => at.position[j].as_slice(),
                    AxisQuantity::Velocity => at.signals.velocity[j].as_slice(),
                })
            })
            .collect();
        let factors = self.factor_values(at, index);
        let mut hats = Vec::with_capacity(factors.len() * self.overlap());
        for (t, factor) in factors.into_iter().enumerate() {
            let first = hats.len();
            hats.push((0, factor));
            for (axis, values) in self.axes.iter().zip(&axes) {
                let span = (axis.knots - 1) as f64;
                let x = (values.map_or(0.0, |v| v[t]) - axis.range[0])
                    / (axis.range[1] - axis.range[0])
                    * span;
                let beyond = (-x).max(x - span);
                let within = decayed(beyond, span);
                let x = x.clamp(0.0, span);
                let left = (x.floor() as usize).min(axis.knots - 2);
                let share = x - left as f64;
                for k in first..hats.len() {
                    let (cell, weight) = hats[k];
                    hats[k] = (cell * axis.knots + left, weight * within * (1.0 - share));
                    hats.push((cell * axis.knots + left + 1, weight * within * share));
                }
            }
        }
        hats
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_decay_beyond_their_fastest_speed() {
        let cubic = SpeedFactor {
            joint: "joint".to_owned(),
            form: FactorForm::Cube,
            scale: 1.0,
            fastest: Some(2.0),
        };
        assert_eq!(cubic.bounded(-2.0, -1.0), -8.0);
        assert_eq!(cubic.bounded(2.5, 1.0), 4.0);
        assert_eq!(cubic.bounded(3.5, 1.0), 0.0);
        let unbounded = SpeedFactor { fastest: None, ..cubic };
        assert_eq!(unbounded.bounded(3.0, 1.0), 27.0);
    }
}
