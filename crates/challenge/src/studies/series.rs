//! Many cases: which ones, and each made, diagnosed and scored.

use std::panic::resume_unwind;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use armident_effects::Draw;
use armident_recording::write_csv;
use rayon::ThreadPoolBuilder;

use crate::arms::bundled::Arm;
use crate::cases::generate::generate;
use crate::cases::request::{CaseRequest, case_effects, hideable};
use crate::contract::files::write_text;
use crate::contract::kind::CaseKind;
use crate::error::ChallengeError;
use crate::hidden::variants::perturbable;
use crate::random::RandomStream;
use crate::score::case_score::CaseScore;
use crate::score::rules::score_submission;
use crate::submission::{Submission, SubmissionTask, solve};

/// Arms that are tried for a case.
const MOST_ARMS: usize = 5;
/// Inertial errors of a null case that has some.
const NULL_BACKGROUND: [f64; 2] = [0.02, 0.05];
/// Keep the draws of field and change cases apart from those of clean ones.
const FIELD_SEEDS: u64 = 500_000;
const HARD_SEEDS: u64 = 600_000;
const CHANGE_SEEDS: u64 = 700_000;
/// Keeps the seeds of two series apart.
const SERIES_SEEDS: u64 = 1_000_003;

/// Kinds of cases in a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeriesKind {
    /// Clean ones.
    Clean,
    /// Field cases, of which some are nulls.
    Field,
    /// No effect: in turn exact, with inertial errors, with baseline friction, and with both.
    Null,
    /// Clean and field cases in turn.
    Mixed,
    /// Field cases with more effects and poorer recordings.
    Hard,
    /// Arms before and after a change.
    Change,
}

/// A series of cases. The same series gives the same cases.
#[derive(Debug, Clone)]
pub struct CaseSeries {
    /// How many.
    pub cases: u64,
    /// Random seed.
    pub seed: u64,
    /// Of which kind.
    pub kind: SeriesKind,
    /// What every case hides; where it is empty, all effects take turns.
    pub effects: Vec<String>,
    /// The robot; random ones of [`Arm::all`] if it is not given.
    pub arm: Option<Arm>,
    /// Whether only laws with a variant are hidden, by that variant.
    pub perturbed: bool,
    /// Naming margin of every effect; random if it is not given.
    pub margin: Option<f64>,
}

impl CaseSeries {
    /// The cases to be made.
    pub fn orders(&self) -> Vec<Order> {
        (0..self.cases).map(|k| self.order(k)).collect()
    }

    fn order(&self, k: u64) -> Order {
        let of = |field: bool| if field { CaseKind::Field } else { CaseKind::Clean };
        let (kind, turn) = match self.kind {
            SeriesKind::Clean => (CaseKind::Clean, k),
            SeriesKind::Field => (CaseKind::Field, k),
            SeriesKind::Null => (of(k % 4 >= 2), k),
            SeriesKind::Mixed => (of(k % 2 == 1), k / 2),
            SeriesKind::Hard => (CaseKind::Hard, k),
            SeriesKind::Change => (CaseKind::Change, k),
        };
        let field = matches!(kind, CaseKind::Field | CaseKind::Hard);
        let seed = self.seed.wrapping_mul(SERIES_SEEDS).wrapping_add(turn);
        let seed = seed.wrapping_add(match kind {
            CaseKind::Clean => 0,
            CaseKind::Field => FIELD_SEEDS,
            CaseKind::Hard => HARD_SEEDS,
            CaseKind::Change => CHANGE_SEEDS,
        });
        let mut random = RandomStream::new(seed ^ 0xa12b);
        let effects = if self.kind == SeriesKind::Null {
            Vec::new()
        } else if !self.effects.is_empty() {
            self.effects.clone()
        } else if self.perturbed {
            let can_be_hidden = hideable(kind);
            let there: Vec<&str> = perturbable()
                .into_iter()
                .filter(|slug| !field || can_be_hidden.contains(slug))
                .collect();
            vec![there[(turn % there.len() as u64) as usize].to_owned()]
        } else {
            case_effects(kind, seed)
        };
        let background = (self.kind == SeriesKind::Null).then(|| {
            let drawn = random.between(NULL_BACKGROUND[0], NULL_BACKGROUND[1]);
            if k % 2 == 1 { drawn } else { 0.0 }
        });
        let letter = match (self.kind, kind) {
            (SeriesKind::Null, _) => 'n',
            (_, CaseKind::Field) => 'f',
            (_, CaseKind::Clean) => 'c',
            (_, CaseKind::Hard) => 'h',
            (_, CaseKind::Change) => 'w',
        };
        Order {
            name: format!("{letter}{:04}", k + 1),
            seed,
            kind,
            effects,
            background,
            perturbed: self.perturbed,
            margin: self.margin,
            arms: self.arm.as_ref().map_or_else(|| by_chance(&mut random), |arm| vec![arm.clone()]),
        }
    }
}

/// Some arms in random order.
fn by_chance(random: &mut RandomStream) -> Vec<Arm> {
    let mut all = Arm::all();
    let mut chosen = Vec::new();
    while chosen.len() < MOST_ARMS && !all.is_empty() {
        chosen.push(all.swap_remove(random.index(all.len())));
    }
    chosen
}

/// A case to be made, on the first of some arms that shows its effects.
#[derive(Debug, Clone)]
pub struct Order {
    /// Name of the case.
    pub name: String,
    /// Random seed.
    pub seed: u64,
    /// Clean, field or change.
    pub kind: CaseKind,
    /// What it hides.
    pub effects: Vec<String>,
    /// Relative standard deviation of the inertial errors of every link; random if it is not given.
    pub background: Option<f64>,
    /// Whether laws that have a variant are replaced by it.
    pub perturbed: bool,
    /// Naming margin of every effect; random if it is not given.
    pub margin: Option<f64>,
    /// Robots to try.
    pub arms: Vec<Arm>,
}

/// What became of an order.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The score; nothing where no arm shows the effects.
    pub score: Option<CaseScore>,
    /// How long the diagnosis took on one thread \[s\]; 0 where there is none.
    pub seconds: f64,
}

/// Makes, diagnoses and scores cases, as many at a time as there are threads. The diagnosis gets a
/// [`SubmissionTask`] and nothing else. With a folder, the cases go to `cases/` in it and the results of the diagnosis
/// to `results/`. `done` is called after every case.
///
/// # Errors
/// A robot or effect that cannot be used, a folder that cannot be written.
pub fn run(
    orders: &[Order],
    keep: Option<&Path>,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<Outcome>, ChallengeError> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let workers = threads.min(orders.len()).max(1);
    let next = AtomicUsize::new(0);
    let results: Mutex<Vec<Option<Result<Outcome, ChallengeError>>>> =
        Mutex::new(orders.iter().map(|_| None).collect());
    let work = || -> Result<(), ChallengeError> {
        // a diagnosis that has a core of its own does not wait for others
        let pool = ThreadPoolBuilder::new()
            .num_threads((threads / workers).max(1))
            .build()
            .map_err(|error| ChallengeError::Threads { reason: error.to_string() })?;
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            let Some(order) = orders.get(k) else { return Ok(()) };
            let outcome = pool.install(|| serve(order, keep));
            if outcome.is_err() {
                // nobody starts another
                next.store(orders.len(), Ordering::Relaxed);
            }
            if let Ok(mut results) = results.lock() {
                results[k] = Some(outcome);
            }
            done();
        }
    };
    std::thread::scope(|scope| {
        let running: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        // a panic is a defect of ours, and goes on as what it is
        running
            .into_iter()
            .try_for_each(|worker| worker.join().unwrap_or_else(|panic| resume_unwind(panic)))
    })?;
    let results = results
        .into_inner()
        .map_err(|error| ChallengeError::Threads { reason: error.to_string() })?;
    results.into_iter().flatten().collect()
}

fn serve(order: &Order, keep: Option<&Path>) -> Result<Outcome, ChallengeError> {
    for arm in &order.arms {
        let case = match generate(&CaseRequest {
            name: order.name.clone(),
            robot: arm.name.clone(),
            robot_urdf: arm.urdf.clone(),
            seed: order.seed,
            kind: order.kind,
            effects: order.effects.clone(),
            background: order.background,
            perturbed: order.perturbed,
            margin: order.margin,
        }) {
            Ok(case) => case,
            // the next arm is tried
            Err(ChallengeError::Invisible { .. } | ChallengeError::Simulation(_)) => continue,
            Err(other) => return Err(other),
        };
        let submission = solve(&SubmissionTask::of(&case));
        if let Some(folder) = keep {
            case.write(&folder.join("cases").join(&order.name))?;
            if let Ok(submission) = &submission {
                write_submission(submission, &folder.join("results").join(&order.name))?;
            }
        }
        let seconds = submission.as_ref().map_or(0.0, |submission| submission.seconds);
        let score = score_submission(&case, submission.as_ref().map_err(Clone::clone));
        return Ok(Outcome { score: Some(score), seconds });
    }
    Ok(Outcome { score: None, seconds: 0.0 })
}

/// Writes what the program would have written, into a folder, which is made.
fn write_submission(submission: &Submission, folder: &Path) -> Result<(), ChallengeError> {
    std::fs::create_dir_all(folder).map_err(ChallengeError::io("written", folder))?;
    let write = |name: &str, text: &str| write_text(&folder.join(name), text);
    write("out.json", &submission.out_json)?;
    let Some(model) = &submission.model else { return Ok(()) };
    write("model.json", &model.model_json)?;
    Ok(write_csv(folder.join("predicted.csv"), &model.predicted)?)
}
