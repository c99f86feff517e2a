//! Elastic transmissions and backlash: the recorded motor drives a link whose motion is not recorded.
//!
//! ```text
//! m(t) q̈ + b(t) = τ,   τ = K (θ - q) + D (θ̇ - q̇), or that beyond a gap;   effort = rigid(link) + J θ̈
//! ```
//!
//! `m` is the joint's own inertia and `b` all other efforts on it. The motion of the link follows from
//! that of the motor by one scalar differential equation a joint; the efforts of all joints follow from
//! the motion of the link.

use crate::design::compliant_link::{Posed, mean_inertia};
use armident_effects::{Effect, LawRole, LinkSide, RotorInertia};
use armident_model::{FittedTransmission, Load, MOST_TURNS};
use armident_numeric::dot;
use armident_recording::RecordingError;
use rayon::prelude::*;

use crate::design::candidate::{Candidate, CandidateKind, Location};
use crate::design::linear_problem::LinearProblem;
use crate::design::observations::JointColumns;
use crate::design::training::Design;

/// Resonances of the link behind a resting motor that are tried \[Hz\], and shares of critical damping.
const RESONANCES_HZ: [f64; 14] =
    [1.3, 1.6, 2.0, 2.5, 3.1, 3.9, 5.0, 6.5, 8.5, 11.0, 14.0, 18.0, 24.0, 32.0];
const DAMPINGS: [f64; 2] = [0.02, 0.08];
/// Gaps tried on rotational joints \[rad\] and translational ones \[m\]: from, to, and the factor between: the
/// motion of a link in its gap is its own for every size.
const GAPS: (f64, f64, f64) = (3e-4, 3.2e-2, 1.2);
/// Adds the candidate of a transmission on a joint; gives its id. `near`: of each recording the load on a link that moved nearly
/// so, empty where none is known; afterwards on this one.
pub(crate) fn push_transmission(
    design: &Design<'_>,
    at: &[Posed<'_>],
    problem: &mut LinearProblem,
    law: &'static dyn Effect,
    joint: usize,
    shape: &[f64],
    near: &mut Vec<Option<Load>>,
) -> Option<usize> {
    let formed = formed(design, at, law, joint, shape, MOST_TURNS, near)?;
    let Formed { blocks, above_band } = formed;
    let column = problem.push_columns(vec![blocks]);
    Some(push_candidate(design, at, problem, (law, joint, shape), column, above_band))
}

/// The efforts of a transmission, beside a rigid one, in the band.
struct Formed {
    blocks: JointColumns,
    above_band: f64,
}

fn formed(
    design: &Design<'_>,
    at: &[Posed<'_>],
    law: &dyn Effect,
    joint: usize,
    shape: &[f64],
    most_turns: usize,
    near: &mut Vec<Option<Load>>,
) -> Option<Formed> {
    let transmission = FittedTransmission::of_law(law, shape, mean_inertia(at, joint))?;
    near.resize(at.len(), None);
    let pieces: Vec<Vec<Vec<f64>>> = at
        .par_iter()
        .zip(near)
        .map(|(at, near)| {
            let (mut efforts, load) =
                transmission.difference_in(at, joint, most_turns, near.as_ref())?;
            if load.is_some() {
                *near = load;
            }
            if transmission.gap == 0.0
                && let Some(sprung) = at.compliant_links().find(|s| s.joint() == joint)
            {
                for (effort, counted) in efforts.iter_mut().zip(sprung.counted()) {
                    effort.iter_mut().zip(counted).for_each(|(e, c)| *e -= c);
                }
            }
            Ok(at.all_recorded(efforts))
        })
        .collect::<Result<_, RecordingError>>()
        .ok()?;
    if pieces.iter().flatten().flatten().any(|x| !x.is_finite()) {
        return None;
    }
    Some(Formed {
        blocks: design.arm_blocks(&pieces),
        above_band: above_band(design, joint, &pieces),
    })
}

/// The candidate of a transmission whose column is there.
fn push_candidate(
    design: &Design<'_>,
    at: &[Posed<'_>],
    problem: &mut LinearProblem,
    (law, joint, shape): (&'static dyn Effect, usize, &[f64]),
    column: usize,
    above_band: f64,
) -> usize {
    let inertia: Vec<Vec<f64>> = at
        .iter()
        .filter_map(|at| RotorInertia.columns(&[], &at.joint(joint)).into_iter().next())
        .collect();
    let inertia = design.joint_blocks(joint, &inertia);
    let inertia = match problem.find_column(&inertia, problem.rigid) {
        Some(known) => known,
        None => problem.push_columns(vec![inertia]),
    };
    problem.candidates.push(Candidate {
        kind: CandidateKind::Law(law),
        location: Location { joints: vec![joint], window: None },
        shape: shape.to_vec(),
        columns: vec![column, inertia],
        searched: shape.len(),
        places: vec![LawRole::Inertia],
        transform: None,
        hidden: Vec::new(),
        above_band,
        is_of_size_one: law.law().has_link_side(LinkSide::Spring)
            && at.iter().any(|at| at.has_right_spring(joint)),
    });
    problem.candidates.len() - 1
}

/// Root mean square of an effort on a joint at all samples over that in the band, 1 or more. Bounded: how
/// sharp an impact is depends on flanks whose stiffness is assumed.
fn above_band(design: &Design<'_>, joint: usize, by_recording: &[Vec<Vec<f64>>]) -> f64 {
    const MOST: f64 = 4.0;
    let mean_square = |values: &[f64]| dot(values, values) / values.len().max(1) as f64;
    let (mut raw, mut band) = (0.0, 0.0);
    for (signals, efforts) in design.signals.iter().zip(by_recording) {
        raw += mean_square(&efforts[joint]);
        band += mean_square(&signals.band.rows(&efforts[joint]));
    }
    (raw / band.max(f64::MIN_POSITIVE)).sqrt().clamp(1.0, MOST)
}

/// Adds springs and gaps of all sizes on a joint; gives their ids.
pub(crate) fn offer(
    design: &Design<'_>,
    at: &[Posed<'_>],
    problem: &mut LinearProblem,
    joint: usize,
) -> Vec<usize> {
    let inertia = mean_inertia(at, joint);
    let laws = design.library.named().filter_map(|law| Some((law, law.law().link_side()?)));
    let sizes: Vec<(&'static dyn Effect, Vec<f64>)> =
        laws.flat_map(|(law, side)| sizes_of(side, inertia).map(move |s| (law, s))).collect();
    // one iteration shows which size is worth a closer look
    let of_size = |(law, shape): &(&'static dyn Effect, Vec<f64>)| {
        formed(design, at, *law, joint, shape, 1, &mut Vec::new())
    };
    let all: Vec<Option<Formed>> = sizes.par_iter().map(of_size).collect();
    let mut found = Vec::new();
    let mut columns = Vec::new();
    for (size, formed) in sizes.into_iter().zip(all) {
        let Some(Formed { blocks, above_band }) = formed else { continue };
        columns.push(blocks);
        found.push((size, above_band));
    }
    let first = problem.push_columns(columns);
    let places = found.into_iter().zip(first..);
    places
        .map(|(((law, shape), above_band), column)| {
            push_candidate(design, at, problem, (law, joint, &shape), column, above_band)
        })
        .collect()
}

/// Shapes of a transmission that are tried on a joint that moves this inertia.
fn sizes_of(side: LinkSide, inertia: f64) -> impl Iterator<Item = Vec<f64>> {
    let mut sizes = Vec::new();
    match side {
        LinkSide::Spring => {
            for hz in RESONANCES_HZ {
                for damping in DAMPINGS {
                    let rate = std::f64::consts::TAU * hz;
                    sizes.push(vec![inertia * rate * rate, 2.0 * damping * inertia * rate]);
                }
            }
        }
        LinkSide::Play => {
            let (mut gap, last, factor) = GAPS;
            while gap < last {
                sizes.push(vec![gap]);
                gap *= factor;
            }
        }
    }
    sizes.into_iter()
}
