//! Cases with concealed effects made by the simulator, and the score of a diagnosis against the truth.
//!
//! A *case* is a folder with the believed `robot.urdf`, the recordings `train_1.csv`, `train_2.csv`,
//! `holdout.csv`, `exam.csv`, and the answer `truth.json` ([`Truth`]). A *result* is a folder of the
//! same name with what the tool wrote: `out.json` ([`Answer`]) and the prediction `predicted.csv` of
//! the exam.
//!
//! # Making cases
//!
//! [`generate`] draws a workspace, four exciting trajectories from rest, sensors, the true inertials and
//! effects from a seed; drives the true arm along the trajectories by the feed-forward of the believed one
//! and a controller of each joint (2 kHz); and records positions by encoders, velocities lagged or noisy,
//! efforts with coloured noise. A [field](CaseKind::Field) case adds friction on every joint, errors of
//! every inertial, uneven clocks and lost samples. A [change](CaseKind::Change) case is a field arm with two more
//! recordings from before what is concealed came, and before it warmed up or cooled down.
//!
//! An effect is as large as makes its *naming margin* a number drawn between two and eleven: the RMS of its
//! torque over noise on the most affected joint, after least squares have taken away what the rigid-body
//! columns and plain friction explain (of a field case over what stick phases leave of the noise; of a
//! wrong body over the torque of the other inertial errors instead of the rigid-body columns). Where no
//! joint shows it between 1.5 and 16 the case is refused ([`ChallengeError::Invisible`]).
//!
//! `truth.json` tells how well one could do: [`Floors`].
//!
//! Not modelled: controllers with integral action, flexible links, temperatures, saturation.
//!
//! # A series
//!
//! [`Series`] says which cases, [`run`] makes, diagnoses and scores them in memory: the diagnosis gets a
//! [`Paper`] that holds neither the answer nor the efforts of the exam. A [`Study`] is a series, or several,
//! with a table of what came out.
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
//! # Scoring
//!
//! [`score_cases`] compares truths and results case by case and sums up in a [`Scoreboard`]. A pair is an
//! effect at a place ([`Blame`]). Findings below a confidence of 0.5 do not count. What an effect
//! tolerates is tolerated beside its right name only; a case with more false names than effects is
//! credited with nothing.

mod accept;
mod answer;
mod arms;
mod background;
mod case;
mod draft;
mod error;
mod exam;
mod excitation;
mod floors;
mod generate;
mod holdout;
mod observe;
mod own_laws;
mod place;
mod random;
mod recorder;
mod robot;
mod score;
mod scoreboard;
mod series;
mod sitting;
mod sizes;
mod study;
mod text;
mod truth;
mod truth_of;

pub use answer::{Answer, Estimate, Evidence, Finding, Fit, HoldoutRmse, Verdict};
pub use arms::Arm;
pub use case::Case;
pub use draft::PERTURBED;
pub use error::ChallengeError;
pub use exam::{EDGE_S, ExamScore};
pub use generate::{CaseKind, CaseRequest, case_effects, concealable, generate};
pub use holdout::HoldoutScore;
pub use place::{Blame, Place};
pub use score::{CaseScore, EverydayScore, score_case, score_cases, score_sitting};
pub use scoreboard::{Bin, EffectRow, GroupScore, Rate, Scoreboard, Spread};
pub use series::{Order, Outcome, Series, SeriesKind, run};
pub use sitting::{LearnedFromPaper, Paper, Sitting, sit};
pub use study::Study;
pub use truth::{
    EverydayFriction, Floors, Named, NoiseTruth, SampleRate, TrueEffect, Truth, VelocityTruth,
};
