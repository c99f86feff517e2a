//! The finding of a distance between two axes that is not the given one.
//!
//! Statistic: what the distance explains of the residual of the joint that shows it best, in noise levels, over what it leaves
//! there, as for other effects; and its interval over the likelihood.
//! References: own.

use std::collections::BTreeMap;

use armident_effects::{Effect, LinkGeometryError};
use armident_ident::checks::{FrameLength, LinkLength};

use crate::findings::confidence::Evidence;
use crate::findings::finding::{Finding, FindingEvidence};
use crate::findings::numbers::Value;
use crate::selection::materiality::{LEAST, Materiality, SHARE_OF_EXCESS};

/// `noise`: that of one recorded effort sample of the joint that shows it \[N m or N\].
pub(crate) fn length_finding(found: &LinkLength, joints: &[String], noise: f64) -> Finding {
    let noise = noise.max(f64::MIN_POSITIVE);
    let explained = found.residual_given * (1.0 - found.residual_ratio.powi(2)).max(0.0).sqrt();
    let left = found.residual_given * found.residual_ratio;
    let excess = (left * left - noise * noise).max(0.0).sqrt();
    let materiality = Materiality {
        value: explained / noise,
        least: LEAST.max(SHARE_OF_EXCESS * excess / noise),
        joint: found.shown_by,
    };
    let stderr = Some(found.standard_error_m());
    let error_m = found.length_m - found.given_m;
    let size = Some(error_m.abs() / (2.0 * found.standard_error_m().max(f64::MIN_POSITIVE)));
    let evidence = Evidence { materiality: &materiality, size, left: None, behind: Vec::new() };
    let parameters = LinkGeometryError.law().parameters;
    let own = match found.along {
        FrameLength::Normal => parameters[0].name,
        FrameLength::Offset => parameters[1].name,
    };
    let length = |value: f64, stderr: Option<f64>| Value { value, stderr, unit: "m" };
    Finding {
        effect: LinkGeometryError.slug().to_owned(),
        joints: vec![joints[found.joint].clone()],
        link: None,
        window: None,
        recording: None,
        parameters: BTreeMap::from([
            (own, length(error_m, stderr)),
            ("length", length(found.length_m, stderr)),
            ("given_length", length(found.given_m, None)),
        ]),
        confidence: evidence.confidence(),
        confirmed: None,
        evidence: FindingEvidence {
            materiality: materiality.value,
            least_materiality: materiality.least,
            joint: joints[found.shown_by].clone(),
            size,
            variables: Vec::new(),
            character: None,
            holdout_gain: None,
        },
        alternatives: Vec::new(),
    }
}
