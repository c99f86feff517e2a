//! Where the effects that change the configuration itself are assumed to be.

use armident_effects::ReversalModel;

use crate::Spring;
use crate::reversal::SHARP;

/// Where laws that change the configuration itself are assumed to be.
#[derive(Debug, Clone, PartialEq)]
pub struct OperatingPoint {
    /// rotation vector of the base about x and y of the world \[rad\]
    pub tilt: [f64; 2],
    /// recorded minus true position \[rad or m\]
    pub offset: Vec<f64>,
    /// lag of the efforts \[s\]
    pub delay_s: f64,
    /// changes of the links' standard parameters, for links that move by themselves behind their motors: how
    /// they ring depends on what they really weigh
    pub links: Option<Vec<f64>>,
    /// beside which the columns of links are formed
    pub springs: Vec<Spring>,
    /// reversal model of each joint's dry friction
    pub reversals: Vec<ReversalModel>,
    /// of the effort channels: what the arm does beside the believed one is recorded with it as well
    pub gain: Vec<f64>,
}

impl OperatingPoint {
    /// Level, on time, with rigid joints and the given links.
    pub fn of(joints: usize) -> Self {
        let (offset, gain) = (vec![0.0; joints], vec![1.0; joints]);
        let (springs, reversals) = (Vec::new(), vec![SHARP; joints]);
        Self { tilt: [0.0; 2], offset, delay_s: 0.0, links: None, springs, reversals, gain }
    }
}
