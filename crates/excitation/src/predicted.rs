//! Standard errors before the arm has moved.

use serde::Serialize;

use crate::information::{Information, JOINT_LAWS, Parameters};

/// What the suite will tell about one parameter.
#[derive(Debug, Clone, Serialize)]
pub struct PredictedError {
    /// Label of the constant, or slug of the law.
    pub name: String,
    /// Its joint.
    pub joint: String,
    /// Unit.
    pub unit: String,
    /// Value of the given model; none for a law of the joint.
    pub value: Option<f64>,
    /// Standard error from the given recordings alone.
    pub from_given: Option<f64>,
    /// Standard error from the training motion alone.
    pub from_train: Option<f64>,
    /// Standard error from the given recordings and all motions of the fit.
    pub from_suite: f64,
}

/// Predicted standard errors of all parameters.
pub(crate) fn errors(
    parameters: &Parameters<'_>,
    names: &[String],
    parts: [Option<&Information>; 2],
    suite: Option<&Information>,
) -> Vec<PredictedError> {
    let Some(suite) = suite.map(Information::standard_errors) else { return Vec::new() };
    let [of_given, of_train] = parts.map(|part| part.map(Information::standard_errors));
    let constants =
        parameters.set.constants.iter().zip(parameters.values()).map(|(constant, value)| {
            let unit = constant.unit().to_owned();
            (constant.label(), constant.joint, unit, Some(*value))
        });
    let laws = (0..names.len()).flat_map(|joint| {
        JOINT_LAWS.iter().map(move |law| {
            let kind = parameters.arm.joints[joint].kind;
            let unit = law.law().parameters.first().map_or("", |p| p.unit(kind)).to_owned();
            (law.law().slug.to_owned(), joint, unit, None)
        })
    });
    constants
        .chain(laws)
        .enumerate()
        .map(|(k, (name, joint, unit, value))| PredictedError {
            name,
            joint: names[joint].clone(),
            unit,
            value,
            from_given: of_given.as_ref().map(|of| of[k]),
            from_train: of_train.as_ref().map(|of| of[k]),
            from_suite: suite[k],
        })
        .collect()
}
