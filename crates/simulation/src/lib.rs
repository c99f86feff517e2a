//! Moves the arm in software: trajectories in, recordings out, with encoder, noise and friction.
//!
//! # Equations
//!
//! ```text
//! M(q) q̈ + b(t, q, q̇, z) + Wᵀ λ = τ     λ_k ∈ F_k(|s_k|, load) Sign(s_k)     s = W q̇
//! Sign(0) = [-1, 1]
//! ```
//!
//! `M` is the inertia matrix with the inertias that effects add on its diagonal, `b` the Coriolis,
//! centrifugal and gravity efforts, contacts on the tip, and the efforts of effects that are smooth in
//! time, position and velocity or in their deflection `z`; `λ` is dry friction with its level `F`,
//! which may differ by direction and depend on speed and load; `τ` are the efforts of the motors. `W`
//! picks the joints, and the common speeds of joints that share a transmission. A joint at rest stays
//! exactly at rest while friction can hold it.
//!
//! A joint with elasticity or play has two rows, the link's and the motor's, with the effort of spring,
//! damper and flanks between them. What is recorded, controlled and rubbed is the motor.
//!
//! Efforts go in and come out as recorded: with the gains and the delay of their channels. A wrong
//! encoder zero is another zero of the arm, so that positions are recorded ones too.
//!
//! * [`inverse`] gives the efforts of a [`Trajectory`]: no integration, exact in every sample.
//! * [`forward`] gives the motion that recorded efforts cause; [`ForwardStepper`] is its inside, one
//!   step at a time, for controllers in the loop; [`track`] is the usual one of them.
//! * [`closed_loop`] gives the motion that commands of position controllers cause; [`ServoJoint`] is one joint of it while
//!   the others move as recorded.
//! * [`Sensors`] turn the exact recording into one that encoders and noisy torque sensors take.
//!
//! # Scheme
//!
//! Without dry friction and memory: Runge-Kutta of fourth order with fixed step.
//!
//! Else: steps at the level of velocities, in which friction is implicit. A half step
//! gives the velocity `v_m` in the middle; with `M` and `b` at `q + h v / 2` and `v_m`, and the
//! effort of the middle of the step,
//!
//! ```text
//! M (v⁺ - v) = h (τ - b - Wᵀ λ),   λ_k ∈ F_k Sign(s⁺_k),   q⁺ = q + h (v + v⁺) / 2
//! ```
//!
//! This inclusion has exactly one solution; it is found to rounding, by pivoting, for all joints at
//! once. Sticking joints get `v⁺_j = 0` exactly. While no joint stops or reverses the scheme is of
//! second order. A stop or reversal inside a step is placed at the end of the step, so a step that
//! has one is done again in up to 16 parts: each reversal leaves a velocity error of at most twice
//! the friction impulse of a sixteenth of a step, a stop none. Levels are those of the speed in the
//! middle of the step; loads and the levels that depend on them are iterated until they agree.
//! Deflections follow the travel, exactly while it is one-way. Steps of arms with a transmission are
//! divided so that its fastest vibration has more than forty; so are those in which a deflection carries,
//! from a reversal until it is saturated.
//!
//! # Limits
//!
//! Both schemes are explicit in `b`: viscous friction `c` on an inertia `M` needs steps below
//! `2 M / c`. Integration is not adaptive; the error is judged by halving the step. Joint limits
//! and motor saturation are not modelled.
//!
//! # Example
//!
//! ```
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
//! let friction = EffectOnJoint::new("coulomb_friction", "rail", [3.0]);
//! let arm = SimulatedArm::on_chain(&chain, &[friction])?;
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
mod closed_loop;
mod drive_temperature;
mod dry_friction;
mod equations;
mod error;
mod forward;
mod inverse;
mod lines;
mod motion_log;
mod sensors;
mod servo_joint;
mod simulated_arm;
mod step_effort;
mod stepper;
#[cfg(test)]
mod test_arms;
mod tracking;
mod trajectory;
mod transmission;

pub use closed_loop::{closed_loop, closed_loop_over};
pub use error::SimulationError;
pub use forward::{DEFAULT_STEP_S, ForwardSettings, forward};
pub use inverse::inverse;
pub use sensors::{EffortNoise, MOST_ENCODER_BITS, Sensors};
pub use servo_joint::{JointDrive, ServoJoint};
pub use simulated_arm::{CONTACT_RAMP_S, EffectWithParameters, SimulatedArm};
pub use step_effort::StepEffort;
pub use stepper::{ArmState, ForwardStepper, HIGHEST_SPEED};
pub use tracking::{TrackingGains, track};
pub use trajectory::{MOST_SAMPLES, Trajectory};
