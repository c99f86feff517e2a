//! Physics beyond the rigid body, one file an effect: law, parameters, regressor columns, look-alikes, export.
