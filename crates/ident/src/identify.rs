//! Identification of an arm from recordings: the one door to the batch fit.
//!
//! ```text
//! recordings -> motions -> structure -> estimate -> consistent links -> model
//! ```

mod currents;
mod error;
mod fit;
mod motions;
mod planned;
mod request;

use armident_model::{ArmModel, DeadZone};
use armident_motion::{Motion, common_cutoff_hz};
use armident_recording::Recording;

use crate::calibration::{DriveGains, SensedGear, dead_zone_shares, sensed_gears};
use crate::consistency::Consistent;
use crate::estimators::Estimator;
use crate::minimal_set::MinimalSet;
use crate::regression::{BatchEstimate, BatchProblem, JointFit, JointRows, Term, without_loads};
use crate::structure::Structure;
use currents::{Converted, efforts_of_currents, efforts_of_known_load};
use fit::{Recorded, cross_validate, fit};
pub(crate) use motions::motions_with_effort;

pub use error::IdentifyError;
pub use planned::{JointFriction, PlannedIdentification, PlannedRequest, identify_planned};
pub use request::{IdentifyRequest, Stage};

/// Identifies an arm: motions, structure, estimate, projection, model, and its errors.
///
/// ```
/// use armident_ident::{IdentifyRequest, identify};
/// use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
/// use armident_model::ArmModel;
/// use armident_recording::read_csv;
///
/// let project = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
/// let robot = load_urdf(&project.join("urdf/ur5.urdf"))?;
/// let chain = SerialChain::from_description(&robot, &ChainSelection::default())?;
/// let given = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
/// let train = [read_csv(project.join("examples/ur5/train.csv"))?];
/// let holdout = [read_csv(project.join("examples/ur5/holdout.csv"))?];
///
/// let request = IdentifyRequest { holdout: &holdout, ..IdentifyRequest::new(&given, &train) };
/// let found = identify(&request)?;
///
/// // the model predicts the hold-out to a tenth of the error of the URDF
/// let error = found.errors.holdout.as_ref().ok_or("no hold-out")?;
/// for (model, urdf) in error.iter().zip(&found.errors.given) {
///     assert!(model.rmse < 0.1 * urdf.rmse);
/// }
/// // every parameter has a name, a value and a standard error
/// let names = found.model.chain.joint_names();
/// let label = found.problem.label(&found.problem.terms[0], &names);
/// println!("{label}: {:.4} ± {:?}", found.estimate.values[0], found.estimate.standard_error(0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`IdentifyError`].
pub fn identify(request: &IdentifyRequest<'_>) -> Result<Identification, IdentifyError> {
    Prepared::of(request)?.fit(request.estimator)
}

/// The result of an identification.
#[derive(Debug, Clone)]
pub struct Identification {
    /// The identified model: consistent links and effects, or the estimate as it is.
    pub model: ArmModel,
    /// The parameters, chosen structure included.
    pub problem: BatchProblem,
    /// What was chosen; its settings have the estimated prior scale.
    pub structure: Structure,
    /// The estimate, in the order of the terms of the problem.
    pub estimate: BatchEstimate,
    /// The consistent links nearest to the estimate; none unless sought.
    pub consistent: Option<Consistent>,
    /// Values of the given model, in the order of the terms; effects are 0.
    pub given_values: Vec<f64>,
    /// Per joint whose channel has a dead zone, the share of samples with the repeated value.
    pub dead_zone_shares: Vec<Option<f64>>,
    /// Per joint, its dead zone.
    pub dead_zones: Vec<Option<DeadZone>>,
    /// Noise level of each joint's filtered channel \[N m or N\].
    pub effort_noise: Vec<f64>,
    /// Effort errors of the model and of the given one.
    pub errors: IdentifyErrors,
    /// Share by which recorded velocities lower the error; none where differentiated positions are used.
    pub velocity_gain: Option<f64>,
    /// Cut-off of the low-pass \[Hz\]; none where exact accelerations are recorded.
    pub cutoff_hz: Option<f64>,
    /// Gains of the drives whose currents are recorded; none where all joints have efforts.
    pub drive_gains: Option<DriveGains>,
    /// Efforts that the loads of known mass require over the recorded ones, and the relative standard error; none without
    /// such a load, or where currents are recorded.
    pub effort_of_load: Option<(f64, f64)>,
    /// Per joint, what lies between motor and torque sensor; none of joints without both channels.
    pub gears: Vec<Option<SensedGear>>,
    /// Training and hold-out recordings with efforts in place of currents; none where all joints have efforts.
    pub converted: Option<[Vec<Recording>; 2]>,
    /// Training motions as fitted.
    pub train_motions: Vec<Motion>,
    /// Hold-out motions as predicted.
    pub holdout_motions: Vec<Motion>,
    /// Rows of the training motions.
    pub rows: JointRows,
    /// Rows of the hold-out motions; none without any.
    pub holdout_rows: Option<JointRows>,
}

impl Identification {
    /// Values of the model, in the order of the terms: projected to consistent links if these were sought.
    pub fn values(&self) -> &[f64] {
        self.consistent.as_ref().map_or(&self.estimate.values, |found| &found.estimated)
    }
}

/// Effort errors per joint, on the filtered effort.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifyErrors {
    /// Of the model on the training recordings.
    pub train: Vec<JointFit>,
    /// Of the model on the hold-out; none without any.
    pub holdout: Option<Vec<JointFit>>,
    /// Of the given model without effects on the hold-out, or else on the training recordings.
    pub given: Vec<JointFit>,
    /// Of fits to the other training recordings; none unless sought and several.
    pub cross_validated: Option<Vec<JointFit>>,
}

/// Motions and structure of a request, ready for any estimator: [`identify`] in two steps, for comparisons.
pub struct Prepared<'a> {
    request: &'a IdentifyRequest<'a>,
    problem: BatchProblem,
    structure: Structure,
    dead_zone_shares: Vec<Option<f64>>,
    cutoff_hz: Option<f64>,
    converted: Option<Converted>,
    effort_of_load: Option<(f64, f64)>,
    gears: Vec<Option<SensedGear>>,
    train_motions: Vec<Motion>,
    holdout_motions: Vec<Motion>,
}

impl<'a> Prepared<'a> {
    /// Forms the motions and chooses the structure.
    ///
    /// # Errors
    /// [`IdentifyError`].
    pub fn of(request: &'a IdentifyRequest<'a>) -> Result<Self, IdentifyError> {
        (request.progress)(Stage::Motions);
        let model = request.model;
        let joints = model.chain.joint_names();
        let cutoff_hz = common_cutoff_hz(request.train, &joints, request.cutoff_hz)?;
        let arm = model.rigid_arm();
        let set = MinimalSet::of(&arm)?;
        let mut problem = BatchProblem::new(&arm, &set).with_loads(request.loads);
        let converted = efforts_of_currents(&mut problem, request, &joints, cutoff_hz)?;
        let effort_of_load = match &converted {
            Some(_) => None,
            None => efforts_of_known_load(&problem, request, &joints, cutoff_hz)?,
        };
        let [train, holdout] = with_efforts(request, converted.as_ref());
        let unloaded = |motion| without_loads(&arm, motion, request.loads);
        let decimated = |m: Motion| if request.decimate { m.thinned() } else { m };
        let fitted = |motions: Vec<Motion>| -> Vec<Motion> {
            motions.into_iter().map(unloaded).map(decimated).collect()
        };
        let train_motions = motions_with_effort(train, &joints, cutoff_hz)?;
        let gears = sensed_gears(request.train, &train_motions, &joints);
        let train_motions = fitted(train_motions);
        let holdout_motions = fitted(motions_with_effort(holdout, &joints, cutoff_hz)?);
        let dead_zone_shares = dead_zone_shares(train, &joints);
        problem = problem.with_dead_zones(dead_zone_shares.iter().map(Option::is_some).collect());
        (request.progress)(Stage::Structure);
        let all: Vec<&Motion> = train_motions.iter().collect();
        let structure = problem.choose_structure(&all, &request.settings, request.search)?;
        Ok(Self {
            request,
            problem,
            structure,
            dead_zone_shares,
            cutoff_hz,
            converted,
            effort_of_load,
            gears,
            train_motions,
            holdout_motions,
        })
    }

    /// The structure that the training recordings show.
    pub fn structure(&self) -> &Structure {
        &self.structure
    }

    /// Per joint whose channel has a dead zone, the share of samples with the repeated value.
    pub fn dead_zone_shares(&self) -> &[Option<f64>] {
        &self.dead_zone_shares
    }

    /// Fits by an estimator, projects, and builds the model.
    ///
    /// # Errors
    /// [`IdentifyError`].
    pub fn fit(&self, estimator: &dyn Estimator) -> Result<Identification, IdentifyError> {
        let Self { request, problem, structure, .. } = self;
        let (model, settings) = (request.model, &structure.settings);
        let [train, holdout] = with_efforts(request, self.converted.as_ref());
        (request.progress)(Stage::Fit);
        let recorded = [
            Recorded { recordings: train, motions: &self.train_motions },
            Recorded { recordings: holdout, motions: &self.holdout_motions },
        ];
        let fitted = fit(problem, model, estimator, settings, recorded)?;
        let motions: Vec<&Motion> = fitted.train.iter().collect();
        let cross_validated = if request.cross_validate && motions.len() > 1 {
            Some(cross_validate(problem, model, estimator, settings, &motions)?)
        } else {
            None
        };
        (request.progress)(Stage::Projection);
        let estimate = &fitted.estimate;
        let consistent =
            if request.project { Some(problem.nearest_consistent(estimate)?) } else { None };
        let values = consistent.as_ref().map_or(&estimate.values, |found| &found.estimated);
        let dead_zones = problem.dead_zones(&fitted.rows, values);
        let error = |rows| problem.fit_through_dead_zones(rows, values, &dead_zones);
        let given_values = problem.given_values();
        let errors = IdentifyErrors {
            train: error(&fitted.rows),
            holdout: fitted.holdout_rows.as_ref().map(error),
            given: problem.fit(fitted.holdout_rows.as_ref().unwrap_or(&fitted.rows), &given_values),
            cross_validated,
        };
        let mut effort_noise = estimate.effort_noise.clone();
        for ((noise, fit), dead_zone) in effort_noise.iter_mut().zip(&errors.train).zip(&dead_zones)
        {
            // in terms of the channel, as its predictions are
            if dead_zone.is_some() {
                *noise = fit.rmse;
            }
        }
        let names = model.chain.joint_names();
        let mut found = match &consistent {
            Some(consistent) => ArmModel {
                effects: problem.consistent_effects(consistent, &names),
                ..model.clone().with_links(&consistent.links)
            },
            None => ArmModel {
                effects: problem.effects(&estimate.values, &names),
                ..problem.set().applied_to(model.clone(), &problem.constants(&estimate.values))
            },
        };
        found.cutoff_hz = self.cutoff_hz;
        found.recorded_velocities = fitted.velocity_gain.is_some();
        found.reversals = problem.reversals.clone();
        found.effort_noise = Some(effort_noise.clone());
        found.shown = dead_zones.iter().any(Option::is_some).then(|| dead_zones.clone());
        let gains = self.converted.as_ref().and_then(|converted| converted.gains.known(&names));
        found.drive_gains = gains.or_else(|| model.drive_gains.clone());
        let sources: Vec<&str> = train.iter().map(|r| r.source.as_str()).collect();
        found.provenance.push(format!("fitted to {}", sources.join(", ")));
        Ok(Identification {
            model: found,
            problem: problem.clone(),
            structure: structure.clone(),
            consistent,
            given_values,
            dead_zone_shares: self.dead_zone_shares.clone(),
            dead_zones,
            effort_noise,
            errors,
            velocity_gain: fitted.velocity_gain,
            cutoff_hz: self.cutoff_hz,
            drive_gains: self.converted.as_ref().map(|converted| converted.gains.clone()),
            effort_of_load: self.effort_of_load,
            gears: self.gears.clone(),
            converted: self.converted.as_ref().map(|c| [c.train.clone(), c.holdout.clone()]),
            estimate: fitted.estimate,
            train_motions: fitted.train,
            holdout_motions: fitted.holdout,
            rows: fitted.rows,
            holdout_rows: fitted.holdout_rows,
        })
    }
}

/// Training and hold-out recordings with efforts, recorded or converted from currents.
fn with_efforts<'r>(
    request: &IdentifyRequest<'r>,
    converted: Option<&'r Converted>,
) -> [&'r [Recording]; 2] {
    match converted {
        Some(converted) => [&converted.train, &converted.holdout],
        None => [request.train, request.holdout],
    }
}

impl BatchProblem {
    /// Values of the arm as it was given, in the order of the terms: constants of its links, 0 for the others.
    pub(crate) fn given_values(&self) -> Vec<f64> {
        let constants = self.set().values(&self.arm().constants());
        let of_term = |term: &Term| match *term {
            Term::Constant(k) => constants[k],
            Term::Effect { .. } | Term::Shared { .. } | Term::Load { .. } => 0.0,
        };
        self.terms.iter().map(of_term).collect()
    }
}
