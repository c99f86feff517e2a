//! Random effects: what a law draws to be hidden in a simulated case.

use armident_dynamics::{RigidArm, inertia_matrix};
use armident_kinematics::JointKind;
use nalgebra::Isometry3;

/// A stream of random numbers.
pub trait Draw {
    /// Uniform from 0 to 1.
    fn uniform(&mut self) -> f64;

    /// Standard normal.
    fn normal(&mut self) -> f64;

    /// Uniform below `count`; 0 of nothing.
    fn index(&mut self, count: usize) -> usize;

    /// Uniform between two numbers.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// True with this probability.
    fn chance(&mut self, probability: f64) -> bool {
        self.uniform() < probability
    }

    /// 1 or -1.
    fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// One of several numbers, which are at least one.
    fn one_of(&mut self, values: &[f64]) -> f64 {
        values[self.index(values.len())]
    }
}

/// Motion and size of one joint, from which sizes of effects follow.
#[derive(Debug, Clone, Copy)]
pub struct JointSize {
    /// Rotation or translation.
    pub kind: JointKind,
    /// Mean of the planned position \[rad or m\].
    pub position_mean: f64,
    /// Standard deviation of the planned position \[rad or m\].
    pub position_deviation: f64,
    /// Standard deviation of the planned velocity \[rad/s or m/s\].
    pub speed: f64,
    /// Standard deviation of the planned acceleration \[rad/s2 or m/s2\].
    pub acceleration: f64,
    /// Standard deviation of the effort noise \[N m or N\].
    pub noise: f64,
    /// Effort range of the given arm \[N m or N\].
    pub effort_range: f64,
    /// Dry friction that the joint has or would have \[N m or N\].
    pub dry_level: f64,
    /// Viscous friction that the joint has or would have \[N m s/rad or N s/m\].
    pub viscous: f64,
}

impl JointSize {
    /// Dry friction to build a special law on: that of the joint, at least four noise levels \[N m or N\].
    pub fn visible_dry_level(&self) -> f64 {
        self.dry_level.max(4.0 * self.noise)
    }
}

/// The arm and motion that effects are drawn for.
#[derive(Debug, Clone)]
pub struct DrawContext<'a> {
    /// The true arm.
    pub arm: &'a RigidArm,
    /// Pose of the URDF frame of each joint's child link in `E_i`.
    pub link_in_e: Vec<Isometry3<f64>>,
    /// Joints from base to tip, at least one.
    pub joints: Vec<JointSize>,
    /// Length of a training recording \[s\].
    pub duration_s: f64,
    /// Number of training recordings.
    pub recordings: usize,
}

impl DrawContext<'_> {
    /// Number of joints.
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// Any joint, and a sign: what most laws draw first.
    pub fn draw_joint(&self, random: &mut dyn Draw) -> (usize, f64) {
        (random.index(self.dof()), random.sign())
    }

    /// Inertia of the arm about a joint at the mean position \[kg m2 or kg\].
    pub fn inertia(&self, joint: usize) -> f64 {
        let centre: Vec<f64> = self.joints.iter().map(|joint| joint.position_mean).collect();
        inertia_matrix(self.arm, &centre)[(joint, joint)]
    }
}

/// Parameters as a function of the size.
type OfSize<T> = Box<dyn Fn(f64) -> T + Send + Sync>;

/// An effect up to its size, a positive number in which its effort grows.
pub struct DrawnEffect {
    /// Joint, or the joint that moves its link; any for an effect of the whole arm.
    pub joint: usize,
    /// The second of two neighbours.
    pub other_joint: Option<usize>,
    /// Start and end of a contact \[s\].
    pub window_s: Option<[f64; 2]>,
    /// Training recording of a contact, from 0.
    pub recording: Option<usize>,
    /// Size to start from.
    pub start: f64,
    /// Largest size.
    pub most: f64,
    parameters: OfSize<Vec<f64>>,
    travel: Option<OfSize<f64>>,
    breakaway: Option<OfSize<f64>>,
}

impl DrawnEffect {
    /// An effect on a joint with a size to start from and its parameters at a size; as large as one likes.
    pub fn new(
        joint: usize,
        start: f64,
        parameters: impl Fn(f64) -> Vec<f64> + Send + Sync + 'static,
    ) -> Self {
        Self {
            joint,
            other_joint: None,
            window_s: None,
            recording: None,
            start,
            most: f64::INFINITY,
            parameters: Box::new(parameters),
            travel: None,
            breakaway: None,
        }
    }

    /// The same, not larger than this.
    #[must_use]
    pub fn at_most(self, most: f64) -> Self {
        Self { most, ..self }
    }

    /// The same with a second joint.
    #[must_use]
    pub fn with_neighbour(self, other: usize) -> Self {
        Self { other_joint: Some(other), ..self }
    }

    /// The same in a window of one recording \[s\].
    #[must_use]
    pub fn in_window(self, recording: usize, window_s: [f64; 2]) -> Self {
        Self { recording: Some(recording), window_s: Some(window_s), ..self }
    }

    /// The same, building up over a travel at a size \[rad or m\].
    #[must_use]
    pub fn over_travel(self, travel: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Self {
        Self { travel: Some(Box::new(travel)), ..self }
    }

    /// The same, with a breakaway effort over that of Coulomb friction at a size.
    #[must_use]
    pub fn with_breakaway(self, ratio: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Self {
        Self { breakaway: Some(Box::new(ratio)), ..self }
    }

    /// The same with other parameters, from those it has.
    #[must_use]
    pub fn map_parameters(self, f: impl Fn(Vec<f64>) -> Vec<f64> + Send + Sync + 'static) -> Self {
        let parameters = self.parameters;
        Self { parameters: Box::new(move |size| f(parameters(size))), ..self }
    }

    /// Parameters at a size, in the order of the law.
    pub fn parameters(&self, size: f64) -> Vec<f64> {
        (self.parameters)(size)
    }

    /// Travel over which the effect builds up at a size \[rad or m\]; infinite where it needs none.
    pub fn travel(&self, size: f64) -> f64 {
        self.travel.as_ref().map_or(f64::INFINITY, |travel| travel(size))
    }

    /// Largest static friction of the joint at a size, over that of baseline friction.
    pub fn breakaway(&self, size: f64) -> f64 {
        self.breakaway.as_ref().map_or(1.0, |ratio| ratio(size))
    }
}
