//! Cases with concealed effects made by the simulator, and the score of a diagnosis against the truth.
//!
//! A *case* is a folder with the believed `robot.urdf`, the recordings `train_1.csv`, `train_2.csv`,
//! `holdout.csv`, `exam.csv`, and the answer `truth.json` ([`Truth`]). A *result* is a folder of the
//! same name with what the tool wrote: `out.json` ([`Answer`]) and the prediction `predicted.csv` of
//! the exam. [`score_cases`] compares the two, case by case, and sums up in a [`Scoreboard`].

mod accept;
mod answer;
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
mod sizes;
mod text;
mod truth;
mod truth_of;

pub use answer::{Answer, Estimate, Evidence, Finding, Fit, HoldoutRmse, Verdict};
pub use case::Case;
pub use error::ChallengeError;
pub use exam::{EDGE_S, ExamScore};
pub use generate::{CaseKind, CaseRequest, case_effects, generate};
pub use holdout::HoldoutScore;
pub use place::{Blame, Place};
pub use score::{CaseScore, EverydayScore, score_case, score_cases};
pub use scoreboard::{Bin, EffectRow, GroupScore, Rate, Scoreboard, Spread};
pub use truth::{
    EverydayFriction, Floors, Named, NoiseTruth, SampleRate, TrueEffect, Truth, VelocityTruth,
};
