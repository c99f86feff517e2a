//! An estimator that is not in the library goes through `identify` as those of the library do.

use armident_ident::estimators::{ALL, Estimator, EstimatorError, TrainingData};
use armident_ident::{
    BatchEstimate, BatchProblem, BatchSettings, EstimateNote, IdentifyError, IdentifyRequest,
    identify,
};
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_model::ArmModel;
use armident_recording::{Recording, read_csv};

use crate::shared::project;

/// Weighted least squares with the noise of each joint as its maker states it \[N m or N\].
#[derive(Debug)]
struct NominalNoise {
    levels: Vec<f64>,
}

const REMARK: &str = "weights from nominal noise levels";

impl Estimator for NominalNoise {
    fn name(&self) -> &'static str {
        "nominal"
    }

    fn title(&self) -> &'static str {
        "least squares with nominal noise"
    }

    fn description(&self) -> &'static str {
        "weighted least squares, weights from nominal noise levels"
    }

    fn fit(
        &self,
        problem: &BatchProblem,
        data: &TrainingData<'_>,
        settings: &BatchSettings,
    ) -> Result<BatchEstimate, EstimatorError> {
        if self.levels.len() != problem.arm().dof() {
            return Err(EstimatorError::Unsuitable {
                estimator: self.name(),
                message: format!("{} noise levels", self.levels.len()),
                hint: "give one noise level per joint".to_owned(),
                source: None,
            });
        }
        let mut found = problem.estimate_at_noise(data.rows, settings, self.levels.clone())?;
        problem.jackknife(data.rows, settings, &mut found)?;
        found.notes.push(EstimateNote::Remark(REMARK.to_owned()));
        Ok(found)
    }
}

fn given() -> ArmModel {
    let robot = load_urdf(&project("urdf/ur5.urdf")).unwrap();
    let chain = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
    ArmModel::from_chain(DrivingAxisChain::from_chain(&chain))
}

fn recording(name: &str) -> [Recording; 1] {
    [read_csv(project(&format!("examples/ur5/{name}.csv"))).unwrap()]
}

#[test]
fn estimator_from_outside_identifies_an_arm() {
    let (model, train, holdout) = (given(), recording("train"), recording("holdout"));
    let nominal = NominalNoise { levels: vec![0.05, 0.1, 0.05, 0.01, 0.01, 0.01] };
    assert!(ALL.iter().all(|estimator| estimator.name() != nominal.name()));
    let request = IdentifyRequest {
        holdout: &holdout,
        estimator: &nominal,
        ..IdentifyRequest::new(&model, &train)
    };
    let found = identify(&request).unwrap();
    let errors = found.errors.holdout.as_ref().unwrap();
    for (model, urdf) in errors.iter().zip(&found.errors.given) {
        assert!(model.rmse < 0.1 * urdf.rmse, "{model:?} {urdf:?}");
    }
    assert_eq!(found.estimate.notes, [EstimateNote::Remark(REMARK.to_owned())]);
    let terms = found.problem.terms.len();
    assert!((0..terms).filter_map(|k| found.estimate.standard_error(k)).all(|e| e > 0.0));
}

#[test]
fn error_of_outside_estimator_is_reported() {
    let (model, train) = (given(), recording("train"));
    let nominal = NominalNoise { levels: vec![0.05] };
    let request = IdentifyRequest { estimator: &nominal, ..IdentifyRequest::new(&model, &train) };
    let error = identify(&request).unwrap_err();
    assert!(
        matches!(error, IdentifyError::Estimator(EstimatorError::Unsuitable { .. })),
        "{error}"
    );
}
