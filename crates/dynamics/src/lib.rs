//! Composite bodies, inertia constants, inertia matrix, gravity, inverse and forward dynamics, and the torque regressor.
