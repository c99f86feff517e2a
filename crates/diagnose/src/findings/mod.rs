//! Findings, and the model that results.

pub(crate) mod ablation;
pub(crate) mod confidence;
pub(crate) mod finding;
pub(crate) mod fitted_model;
pub(crate) mod from_commands;
pub(crate) mod geometry;
pub(crate) mod numbers;
pub(crate) mod placebo;
pub(crate) mod residual_map;
pub(crate) mod size;
