//! Moves the arm in software: trajectories in, recordings out, with encoder, noise and friction.
//!
//! # Equations
//!
//! ```text
//! M(q) q̈ + b(q, q̇) + λ = τ        λ_j ∈ Fc_j Sign(q̇_j)        Sign(0) = [-1, 1]
//! ```
//!
//! `M` is the inertia matrix with the inertias that effects add on its diagonal, `b` the Coriolis,
//! centrifugal and gravity efforts and the efforts of effects that are smooth in position and
//! velocity, `λ` dry friction with its level `Fc`, `τ` the efforts of the motors. A joint at rest
//! stays exactly at rest while friction can hold it.
//!
//! * [`inverse`] gives the efforts of a [`Trajectory`]: no integration, exact in every sample.
//! * [`forward`] gives the motion that recorded efforts cause; [`ForwardStepper`] is its inside, one
//!   step at a time, for controllers in the loop; [`track`] is the usual one of them.
//! * [`Sensors`] turn the exact recording into one that encoders and noisy torque sensors take.
//!
//! # Scheme
//!
//! Without dry friction: Runge-Kutta of fourth order with fixed step.
//!
//! With dry friction: steps at the level of velocities, in which friction is implicit. A half step
//! gives the velocity `v_m` in the middle; with `M` and `b` at `q + h v / 2` and `v_m`, and the
//! effort of the middle of the step,
//!
//! ```text
//! M (v⁺ - v) = h (τ - b - λ),   λ_j ∈ Fc_j Sign(v⁺_j),   q⁺ = q + h (v + v⁺) / 2
//! ```
//!
//! This inclusion has exactly one solution; it is found to rounding, by pivoting, for all joints at
//! once. Sticking joints get `v⁺_j = 0` exactly. While no joint stops or reverses the scheme is of
//! second order. A stop or reversal inside a step is placed at the end of the step, so a step that
//! has one is done again in up to 16 parts: each reversal leaves a velocity error of at most twice
//! the friction impulse of a sixteenth of a step, a stop none.
//!
//! # Limits
//!
//! Both schemes are explicit in `b`: viscous friction `c` on an inertia `M` needs steps below
//! `2 M / c`. Integration is not adaptive; the error is judged by halving the step. Joint limits,
//! contacts and motor saturation are not modelled. Dry friction depends on nothing but the
//! direction. Effects with states of their own (presliding, elastic gears, backlash) and effects
//! that depend on time are not supported.
//!
//! # Example
//!
//! ```
//! use armident_dynamics::RigidArm;
//! use armident_effects::EffectOnJoint;
//! use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};
//! use armident_recording::{JointChannels, Recording};
//! use armident_simulation::{ArmState, ForwardSettings, SimulatedArm, forward};
//!
//! let urdf = r#"<robot name="slider"><link name="base"/>
//!   <link name="cart"><inertial><mass value="2"/>
//!     <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
//!   <joint name="rail" type="prismatic"><parent link="base"/><child link="cart"/>
//!     <axis xyz="1 0 0"/><limit effort="100" velocity="10"/></joint></robot>"#;
//! let chain = SerialChain::from_description(
//!     &parse_urdf(urdf, "slider.urdf")?,
//!     &ChainSelection::default(),
//! )?;
//! let chain = DrivingAxisChain::from_chain(&chain);
//! let friction = EffectOnJoint {
//!     effect: "coulomb_friction".into(),
//!     joint: "rail".into(),
//!     parameters: vec![3.0],
//! };
//! let arm = SimulatedArm::new(RigidArm::from_chain(&chain), &chain.joint_names(), &[friction])?;
//!
//! // a push of 5 N for one second, then nothing: 1 m/s2 forward, 1.5 m/s2 back to rest
//! let time_s: Vec<f64> = (0..300).map(|k| 0.01 * f64::from(k)).collect();
//! let push = time_s.iter().map(|t| if *t < 1.0 { 5.0 } else { 0.0 }).collect();
//! let rail = JointChannels { effort: Some(push), ..JointChannels::new("rail") };
//! let efforts = Recording::new("push", time_s, vec![rail])?;
//!
//! let start = ArmState::at_rest(vec![0.0]);
//! let motion = forward(&arm, &efforts, start, &ForwardSettings::default())?;
//! let rail = motion.joint("rail").expect("the only joint");
//! let (position, velocity) = (rail.position.as_ref(), rail.velocity.as_ref());
//! assert_eq!(velocity.map(|v| v[299]), Some(0.0));
//! assert!(position.is_some_and(|q| (q[299] - (0.5 + 1.0 / 3.0)).abs() < 0.02));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(test)]
mod bad_inputs;
mod dry_friction;
mod error;
mod forward;
mod inverse;
mod motion_log;
mod sensors;
mod simulated_arm;
mod step_effort;
mod stepper;
#[cfg(test)]
mod test_arms;
mod tracking;
mod trajectory;

pub use error::SimulationError;
pub use forward::{DEFAULT_STEP_S, ForwardSettings, forward};
pub use inverse::inverse;
pub use sensors::{EffortNoise, MOST_ENCODER_BITS, Sensors};
pub use simulated_arm::{EffectWithParameters, SimulatedArm};
pub use step_effort::StepEffort;
pub use stepper::{ArmState, ForwardStepper, HIGHEST_SPEED};
pub use tracking::{TrackingGains, track};
pub use trajectory::{MOST_SAMPLES, Trajectory};
