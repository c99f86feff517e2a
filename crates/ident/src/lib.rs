//! Minimal inertia sets, experiment plans, and estimation with uncertainty (the paper's Algorithms 1, 2 and M; batch least squares).
