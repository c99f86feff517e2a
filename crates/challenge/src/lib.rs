//! Cases with hidden effects made by the simulator, and the score of a diagnosis against the truth.
//!
//! A *case* is a folder with the given `robot.urdf`, the recordings `train_1.csv`, `train_2.csv`,
//! `holdout.csv`, `exam.csv`, and the truth `truth.json` ([`Truth`]). A *result* is a folder of the
//! same name with what the tool wrote: `out.json` ([`Answer`]) and the prediction `predicted.csv` of
//! the exam.
//!
//! # Making cases
//!
//! [`generate`] draws a workspace, four exciting trajectories from rest, sensors, the true inertials and
//! effects from a seed; drives the true arm along the trajectories by the feed-forward of the given one
//! and a controller of each joint (2 kHz); and records positions by encoders, velocities lagged or noisy,
//! efforts with coloured noise. A [field](CaseKind::Field) case adds friction on every joint, errors of
//! every inertial, uneven clocks and lost samples. A [change](CaseKind::Change) case is a field arm with two more
//! recordings from before the hidden effect came, and before it warmed up or cooled down.
//!
//! An effect is scaled to a *naming margin* drawn between two and eleven: the RMS of its
//! torque over noise on the most affected joint, after least squares have removed what the rigid-body
//! columns and baseline friction explain (of a field case over the noise that stick phases add to; of an
//! inertial error over the torque of the other inertial errors instead of the rigid-body columns). Where no
//! joint shows it between 1.5 and 16 the case is rejected ([`ChallengeError::Invisible`]). Laws draw their own constants
//! ([`Effect::draw`](armident_effects::Effect::draw)).
//!
//! `truth.json` has the errors that bound any answer: [`Floors`].
//!
//! Not modelled: controllers with integral action, flexible links, temperatures, saturation.
//!
//! # A series
//!
//! [`CaseSeries`] lists cases, [`run`] makes, diagnoses and scores them in memory: the diagnosis gets a
//! [`SubmissionTask`] that holds neither the truth nor the efforts of the exam. A [`Study`] is a series, or several,
//! with a table of the results.
//!
//! ```
//! use armident_challenge::{Arm, CaseKind, CaseRequest, generate};
//!
//! let arm = Arm::named("scara").unwrap();
//! let case = generate(&CaseRequest {
//!     name: "case".to_owned(),
//!     robot: arm.name,
//!     robot_urdf: arm.urdf,
//!     seed: 3,
//!     kind: CaseKind::Clean,
//!     effects: vec!["coulomb_friction".to_owned()],
//!     background: None,
//!     perturbed: false,
//!     margin: None,
//! })?;
//! assert_eq!(case.truth.effects[0].effect, "coulomb_friction");
//! assert!(case.exam.len() > 100);
//! # Ok::<(), armident_challenge::ChallengeError>(())
//! ```
//!
//! # Arms without efforts
//!
//! A [`CommandSeries`] simulates arms of five to seven joints behind position controllers of unknown stiffness, with a delay of all
//! commands, damping and rotors, and hides dry friction, static friction, friction by load and offsets. Nulls have the
//! controllers alone. The diagnosis gets commands and positions.
//!
//! # Scoring
//!
//! [`score_cases`] compares truths and results case by case and sums up in a [`Scoreboard`]. A pair is an
//! effect at a place ([`Blame`]). Findings below a confidence of 0.5 do not count. What an effect
//! tolerates is tolerated beside its right name only; a case with more false positives than effects
//! scores zero.

mod arms;
mod cases;
mod commands;
mod contract;
mod error;
mod hidden;
mod random;
mod score;
mod studies;
mod submission;

pub use arms::bundled::Arm;
pub use cases::generate::{generate, generate_in};
pub use cases::request::{CaseRequest, case_effects, hideable};
pub use commands::command_score::{CommandScore, ControllerEstimate, NamedEffect};
pub use commands::command_series::{CommandScoreboard, CommandSeries};
pub use contract::answer::{
    Answer, AnswerEstimate, AnswerFinding, AnswerVerdict, Evidence, Fit, HoldoutRmse,
};
pub use contract::case::Case;
pub use contract::kind::CaseKind;
pub use contract::truth::{
    BaselineFriction, EDGE_S, Floors, Named, NoiseTruth, SampleRate, TrueEffect, Truth,
    VelocityTruth,
};
pub use error::ChallengeError;
pub use hidden::variants::perturbable;
pub use score::blame::{Blame, Place};
pub use score::case_score::{BaselineScore, CaseScore};
pub use score::exam::ExamScore;
pub use score::holdout::HoldoutScore;
pub use score::rules::{score_case, score_submission};
pub use score::scoreboard::{
    EffectScore, GroupScore, Rate, ReliabilityBin, Scoreboard, Spread, score_cases,
};
pub use studies::series::{CaseSeries, Order, Outcome, SeriesKind, run};
pub use studies::study::Study;
pub use submission::{Submission, SubmissionTask, SubmittedModel, solve};
