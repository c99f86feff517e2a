//! Moves the arm in software: trajectories in, recordings out, with encoder, noise and friction.
