//! Placebo test: how often the selection accepts terms known to be wrong.
//!
//! A placebo is a law of the library on a joint, its columns shifted in time within each recording: as many
//! parameters, the same spectrum, and no relation to the efforts.

use armident_effects::{Baseline, LawRole, Scope};
use serde::Serialize;

use crate::design::candidate::{Candidate, CandidateKind, Location};
use crate::design::training::Design;
use crate::regression::fit_set::fit_set;
use crate::selection::cross_validation::usefulness;
use crate::selection::materiality::{materiality, surrogate_threshold_beside};
use crate::selection::solution::Selection;

/// Steps of the golden ratio spread the shifts, whatever their number.
const GOLDEN: f64 = 0.618_033_988_75;

/// Result of the placebo test.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Placebo {
    /// Terms tried.
    pub terms: usize,
    /// Those that lower the cross-validated error by more than its standard error.
    pub improve: usize,
    /// Those that would have been reported: useful, material, and of a lower score.
    pub named: usize,
    /// Largest ratio of materiality to its threshold.
    pub largest: f64,
}

pub(crate) fn placebo(design: &Design<'_>, selection: &mut Selection, terms: usize) -> Placebo {
    let at = design.at(&selection.point);
    let laws: Vec<_> = design
        .library
        .named()
        .filter(|law| {
            law.law().scope == Scope::Joint && law.law().baseline != Some(Baseline::Offset)
        })
        .collect();
    let threshold = surrogate_threshold_beside(&selection.metric(), &selection.estimate);
    let mut found = Placebo::default();
    for k in 0..terms {
        let joint = k % design.joints();
        let law = laws[(k / design.joints() + k) % laws.len()];
        let shapes = law.shapes(&design.scale[joint]);
        let Some(shape) = shapes.get(k % shapes.len().max(1)) else { continue };
        // between a quarter and three quarters of the recording
        let shift = 0.25 + 0.5 * ((GOLDEN * (k + 1) as f64) % 1.0);
        let pieces: Vec<Vec<Vec<f64>>> = at
            .iter()
            .map(|at| {
                let mut columns = law.columns(shape, &at.joint(joint));
                for column in &mut columns {
                    let by = (shift * column.len() as f64) as usize;
                    column.rotate_left(by);
                }
                columns
            })
            .collect();
        let count = pieces.first().map_or(0, Vec::len);
        let columns: Vec<usize> = (0..count)
            .map(|c| {
                let column: Vec<Vec<f64>> = pieces.iter().map(|p| p[c].clone()).collect();
                let blocks = design.joint_blocks(joint, &column);
                selection.problem.push_columns(vec![blocks])
            })
            .collect();
        if columns.is_empty() {
            continue;
        }
        selection.problem.candidates.push(Candidate {
            kind: CandidateKind::Law(law),
            location: Location { joints: vec![joint], window: None },
            shape: shape.clone(),
            columns,
            searched: shape.len(),
            places: vec![LawRole::Unnamed],
            transform: None,
            hidden: Vec::new(),
            above_band: 1.0,
            is_of_size_one: false,
        });
        let candidate = selection.problem.candidates.len() - 1;
        found.terms += 1;
        let metric = selection.metric();
        let set = [selection.estimate.set.as_slice(), &[candidate]].concat();
        // an inadmissible term is rejected, as in the selection
        let Some(with) = fit_set(&metric, set) else { continue };
        let useful = usefulness(&metric, &with, candidate).is_some_and(|u| u > 1.0);
        let (size, _) = materiality(&metric, &with, candidate, &selection.point, &threshold);
        found.improve += usize::from(useful);
        found.largest = found.largest.max(size.ratio());
        let shorter = with.score < selection.estimate.score;
        found.named += usize::from(useful && shorter && size.ratio() >= 1.0);
    }
    found
}
