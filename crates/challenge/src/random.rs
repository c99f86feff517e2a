//! Random numbers from a seed.

use armident_effects::Draw;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

/// A stream of random numbers.
#[derive(Clone)]
pub(crate) struct RandomStream(Pcg64);

impl RandomStream {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    /// A stream of its own that follows from this one.
    pub(crate) fn branch(&mut self) -> Self {
        Self::new(self.0.random())
    }

    /// Uniform in the logarithm.
    pub(crate) fn log_between(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// One of several.
    pub(crate) fn choose<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.index(values.len())]
    }
}

impl Draw for RandomStream {
    fn uniform(&mut self) -> f64 {
        self.0.random::<f64>()
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    fn index(&mut self, count: usize) -> usize {
        self.0.random_range(0..count.max(1))
    }
}
