//! What recordings show of one finding, in the regime where its law lives.

use std::borrow::Cow;

use armident_effects::{LawRole, effect};
use armident_kinematics::JointKind;
use nalgebra::{Isometry3, Vector3};

use crate::canvas::Canvas;
use crate::drawing::{DrawnQuantity, FindingRegion, FindingTraces, FindingView, RecordingRole};
use crate::reduce::{rounded, rounded_some};
use crate::residual_maps::{self, Cells, Classes};
use crate::sheet::{Sheet, less};

const CLASSES: usize = 48;
const LEAST_SAMPLES: usize = 4;
/// Samples of a recording that are sorted into classes.
const SORTED: usize = 60_000;
/// A law acts where its effort is above this share of its largest.
pub(crate) const ACTS: f64 = 0.1;
/// Time around a reversal that is looked at \[s\].
const AROUND_S: f64 = 0.4;
/// Gravity patterns below this share of the largest are not drawn.
const LEAST_PATTERN: f64 = 0.05;

/// Where a finding is.
#[derive(Debug, Clone, Default)]
pub struct FindingPlace {
    /// Slug of the law, or a name the library does not know.
    pub effect: String,
    /// The joint on which it matters most, from 0.
    pub joint: usize,
    /// The link, by the joint that moves it, from 0.
    pub link: Option<usize>,
    /// Window of a contact \[s\].
    pub window_s: Option<[f64; 2]>,
    /// Name of the recording of the window, without folder and ending.
    pub recording: Option<String>,
    /// Force of a contact on the tip, in the base frame \[N\].
    pub force_n: Option<[f64; 3]>,
    /// Centre of a load in the frame of its link \[m\]; none: the centre of the given link.
    pub centre_m: Option<[f64; 3]>,
}

/// What residuals are sorted by.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Abscissa {
    Velocity,
    SinceReversal,
    Position,
    Acceleration,
    Load,
    EffortRate,
    Time,
    Gravity,
}

impl Abscissa {
    const OF_A_JOINT: [Self; 6] = [
        Self::Velocity,
        Self::SinceReversal,
        Self::Position,
        Self::Acceleration,
        Self::Load,
        Self::Time,
    ];

    /// Where the laws of a place live.
    fn of_place(place: LawRole) -> Self {
        match place {
            LawRole::Viscous | LawRole::Drag | LawRole::Shared => Self::Velocity,
            LawRole::Dry => Self::SinceReversal,
            LawRole::Constant
            | LawRole::Zero
            | LawRole::Ripple
            | LawRole::Gravity
            | LawRole::Unnamed => Self::Position,
            LawRole::Inertia => Self::Acceleration,
            LawRole::Gain => Self::Load,
            LawRole::Link => Self::Gravity,
            LawRole::Time => Self::EffortRate,
            LawRole::Contact | LawRole::Drive => Self::Time,
        }
    }

    fn label(self, joint: &str, position: &str, effort: &str) -> String {
        match self {
            Self::Velocity => format!("speed of {joint} [{position}/s]"),
            Self::SinceReversal => format!("time since the nearest reversal of {joint} [s]"),
            Self::Position => format!("position of {joint} [{position}]"),
            Self::Acceleration => format!("acceleration of {joint} [{position}/s2]"),
            Self::Load => format!("predicted effort of {joint} [{effort}]"),
            Self::EffortRate => format!("change of the effort of {joint} [{effort}/s]"),
            Self::Time => "time in the recording [s]".to_owned(),
            Self::Gravity => format!("effort of 1 kg at the load on {joint} [{effort}]"),
        }
    }
}

impl Canvas<'_> {
    /// What the recordings show of a finding. `without[k]` is the prediction, at the stamps of the k-th
    /// recording given to the canvas, of the last model without the finding; empty where it is not known.
    pub fn finding(&self, place: &FindingPlace, without: &[Vec<Vec<f64>>]) -> FindingTraces {
        let fitted = self.sheets.iter().any(|s| s.role == RecordingRole::Training);
        let pairs: Vec<Pair<'_>> = self
            .sheets
            .iter()
            .zip(without)
            .filter(|(sheet, without)| {
                let named = place.recording.as_ref().is_none_or(|name| {
                    let source = std::path::Path::new(&sheet.motion.source);
                    source.file_stem().is_some_and(|s| s.to_string_lossy() == *name)
                });
                !without.is_empty() && named && (sheet.role == RecordingRole::Training || !fitted)
            })
            .filter_map(|(sheet, without)| Pair::new(sheet, without))
            .map(|pair| match (place.window_s, place.force_n) {
                (Some(window_s), Some(force_n)) => self.in_contact(pair, window_s, force_n),
                _ => pair,
            })
            .collect();
        if pairs.is_empty() {
            return FindingTraces::default();
        }
        let (joints, share) = (0..self.chain.dof()).map(|j| acting(&pairs, j)).unzip();
        FindingTraces {
            joints,
            share,
            views: self.views(place, &pairs),
            regions: (0..self.chain.dof()).filter_map(|j| self.region(&pairs, j)).collect(),
        }
    }

    /// Where in the residual maps of a joint a finding acts; none where it does not act on the joint.
    fn region(&self, pairs: &[Pair<'_>], joint: usize) -> Option<FindingRegion> {
        let least = acts_above(pairs, joint)?;
        let fitted = self.fitted();
        let within = |cells: &Cells| {
            let acts: Vec<_> =
                pairs.iter().map(|p| move |k: usize| p.law[joint][k].abs() > least).collect();
            let sheets = pairs.iter().zip(&acts).filter(|(p, _)| !p.law[joint].is_empty());
            cells.where_most(sheets.map(|(p, acts)| (p.sheet, acts as &dyn Fn(usize) -> bool)))
        };
        let load_direction = match self.quantity() {
            DrawnQuantity::Effort => within(&residual_maps::load_direction(&fitted, joint)),
            DrawnQuantity::Position => Vec::new(),
        };
        let speed_position = within(&residual_maps::speed_position(&fitted, joint));
        Some(FindingRegion { joint, speed_position, load_direction })
    }

    /// Contacts are in no model: their effort `-J(q)^T F` is formed here, and taken off the residual.
    fn in_contact<'p>(
        &self,
        mut pair: Pair<'p>,
        window_s: [f64; 2],
        force_n: [f64; 3],
    ) -> Pair<'p> {
        let motion = &pair.sheet.motion;
        let mut with: Vec<Vec<f64>> = pair.with.to_vec();
        for k in 0..motion.len() {
            let t = motion.time_s[k] - motion.time_s[0];
            if !(window_s[0]..=window_s[1]).contains(&t) {
                continue;
            }
            let q: Vec<f64> = motion.position.iter().map(|q| q[k]).collect();
            let frames = self.chain.frames_in_base(&q);
            let Some(last) = frames.last() else { continue };
            let tip = (last * self.chain.tip_in_e).translation.vector;
            for (j, frame) in frames.iter().enumerate() {
                if pair.law[j].is_empty() {
                    continue;
                }
                let moved = displacement(frame, self.chain.joints[j].kind, &tip);
                pair.law[j][k] = -Vector3::from(force_n).dot(&moved);
                with[j][k] -= pair.law[j][k];
            }
        }
        pair.with = Cow::Owned(with);
        pair
    }

    fn views(&self, place: &FindingPlace, pairs: &[Pair<'_>]) -> Vec<FindingView> {
        let own = effect(&place.effect)
            .and_then(|e| e.law().roles.first().copied())
            .map_or(Abscissa::Position, Abscissa::of_place);
        if own == Abscissa::Gravity {
            return self.gravity_views(place, pairs);
        }
        let mut all = vec![own];
        all.extend(Abscissa::OF_A_JOINT.into_iter().filter(|a| *a != own));
        all.into_iter().filter_map(|a| self.view(place, pairs, place.joint, a)).collect()
    }

    /// The gravity pattern of a load on every joint that it loads, the one where it matters most first.
    fn gravity_views(&self, place: &FindingPlace, pairs: &[Pair<'_>]) -> Vec<FindingView> {
        let mut joints: Vec<usize> = (0..self.chain.dof()).collect();
        joints.sort_by_key(|j| *j != place.joint);
        let views = joints
            .into_iter()
            .filter_map(|j| self.view(place, pairs, j, Abscissa::Gravity))
            .collect::<Vec<_>>();
        let width = |v: &FindingView| match (v.x.first(), v.x.last()) {
            (Some(a), Some(b)) => b - a,
            _ => 0.0,
        };
        let widest = views.iter().map(width).fold(0.0_f64, f64::max);
        let mut kept: Vec<FindingView> =
            views.into_iter().filter(|v| width(v) > LEAST_PATTERN * widest).collect();
        kept.extend(self.view(place, pairs, place.joint, Abscissa::Acceleration));
        kept.extend(self.view(place, pairs, place.joint, Abscissa::Time));
        kept
    }

    fn view(
        &self,
        place: &FindingPlace,
        pairs: &[Pair<'_>],
        joint: usize,
        abscissa: Abscissa,
    ) -> Option<FindingView> {
        let mut samples: Vec<[f64; 4]> = Vec::new();
        for pair in pairs {
            if pair.law[joint].is_empty() {
                continue;
            }
            let x = self.abscissa(place, pair.sheet, joint, abscissa);
            let stride = pair.sheet.motion.len().div_ceil(SORTED).max(1);
            for k in (0..pair.sheet.motion.len()).step_by(stride) {
                let Some((x, sign)) = x(k) else { continue };
                let with = sign * pair.with[joint][k];
                let law = sign * pair.law[joint][k];
                samples.push([x, with + law, with, law]);
            }
        }
        let first = samples.first()?[0];
        // what does not vary sorts nothing
        if samples.len() < CLASSES || samples.iter().all(|s| (s[0] - first).abs() < 1e-9) {
            return None;
        }
        let classes = Classes::of(samples.iter().map(|s| &s[0]), CLASSES);
        let mut sorted: Vec<Vec<[f64; 4]>> = vec![Vec::new(); CLASSES];
        for sample in samples {
            sorted[classes.class(sample[0])].push(sample);
        }
        let mean = |column: usize| -> Vec<Option<f64>> {
            let means: Vec<Option<f64>> = sorted
                .iter()
                .map(|class| {
                    let sum: f64 = class.iter().map(|s| s[column]).sum();
                    (class.len() >= LEAST_SAMPLES).then(|| sum / class.len() as f64)
                })
                .collect();
            rounded_some(&means)
        };
        let spread = sorted
            .iter()
            .map(|class| {
                let mut values: Vec<f64> = class.iter().map(|s| s[1]).collect();
                values.sort_by(f64::total_cmp);
                let at = |share: f64| values[(share * (values.len() - 1) as f64).round() as usize];
                (values.len() >= LEAST_SAMPLES).then(|| {
                    let ends = rounded(&[at(0.1), at(0.9)]);
                    [ends[0], ends[1]]
                })
            })
            .collect();
        let names = &self.chain.joints[joint];
        let (position, effort) =
            if names.kind.is_rotational() { ("rad", "N m") } else { ("m", "N") };
        Some(FindingView {
            over: abscissa.label(&names.name, position, effort),
            joint,
            x: classes.middles(),
            without: mean(1),
            with: mean(2),
            spread,
            law: mean(3),
        })
    }

    /// Abscissa of a sample and the sign its residual is taken with; none: the sample is not looked at.
    fn abscissa<'s>(
        &'s self,
        place: &'s FindingPlace,
        sheet: &'s Sheet,
        joint: usize,
        abscissa: Abscissa,
    ) -> Box<dyn Fn(usize) -> Option<(f64, f64)> + 's> {
        let motion = &sheet.motion;
        match abscissa {
            Abscissa::Velocity => Box::new(move |k| Some((motion.velocity[joint][k], 1.0))),
            Abscissa::Position => Box::new(move |k| Some((motion.position[joint][k], 1.0))),
            Abscissa::Acceleration => Box::new(move |k| Some((motion.acceleration[joint][k], 1.0))),
            Abscissa::Load => Box::new(move |k| sheet.predicted.last().map(|p| (p[joint][k], 1.0))),
            Abscissa::EffortRate => {
                let load = sheet.predicted.last();
                Box::new(move |k| {
                    let load = &load?[joint];
                    let (a, b) = (k.saturating_sub(1), (k + 1).min(load.len() - 1));
                    Some(((load[b] - load[a]) * motion.rate_hz / (b - a) as f64, 1.0))
                })
            }
            Abscissa::Time => {
                let window = place.window_s.map(|[a, b]| {
                    let margin = 0.5 * (b - a);
                    [a - margin, b + margin]
                });
                Box::new(move |k| {
                    let t = motion.time_s[k] - motion.time_s[0];
                    window.is_none_or(|[a, b]| (a..=b).contains(&t)).then_some((t, 1.0))
                })
            }
            Abscissa::SinceReversal => {
                let reversals = reversals(&motion.velocity[joint]);
                Box::new(move |k| {
                    let after = reversals.partition_point(|r| r.0 <= k);
                    let near = [after.checked_sub(1), Some(after)];
                    let (at, sign) = near
                        .into_iter()
                        .flatten()
                        .filter_map(|i| reversals.get(i))
                        .min_by_key(|r| r.0.abs_diff(k))?;
                    let t = (k as f64 - *at as f64) / motion.rate_hz;
                    (t.abs() <= AROUND_S).then_some((t, *sign))
                })
            }
            Abscissa::Gravity => {
                let link = place.link.unwrap_or(self.chain.dof() - 1);
                let body = &self.chain.joints[link];
                let centre = match place.centre_m {
                    Some([x, y, z]) => {
                        (body.child_link_in_e * nalgebra::Point3::new(x, y, z)).coords
                    }
                    None if body.link.mass_kg > 0.0 => body.link.com_m(),
                    None => body.child_link_in_e.translation.vector,
                };
                let gravity = self.chain.gravity_base;
                Box::new(move |k| {
                    if joint > link {
                        return None;
                    }
                    let q: Vec<f64> = (0..=link).map(|j| motion.position[j][k]).collect();
                    let mut pose = self.chain.base_from_e0;
                    let mut axis = None;
                    for (j, q) in q.iter().enumerate() {
                        pose *= self.chain.parent_from_e(j, *q);
                        if j == joint {
                            axis = Some(pose);
                        }
                    }
                    let point = (pose * nalgebra::Point3::from(centre)).coords;
                    let moved = displacement(&axis?, self.chain.joints[joint].kind, &point);
                    Some((-gravity.dot(&moved), 1.0))
                })
            }
        }
    }
}

/// Displacement of a point of the base frame when the joint of a frame moves by one.
fn displacement(frame: &Isometry3<f64>, kind: JointKind, point: &Vector3<f64>) -> Vector3<f64> {
    let axis = frame.rotation * Vector3::z();
    if kind.is_rotational() { axis.cross(&(point - frame.translation.vector)) } else { axis }
}

/// Samples at which a joint turns round, with its direction afterwards; a joint that stops and goes on
/// the same way does not.
fn reversals(velocity: &[f64]) -> Vec<(usize, f64)> {
    const REST: f64 = 0.02;
    let rest = REST * velocity.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let mut found = Vec::new();
    let mut last: Option<(usize, f64)> = None;
    for (k, v) in velocity.iter().enumerate() {
        if v.abs() <= rest {
            continue;
        }
        if let Some((at, sign)) = last
            && sign != v.signum()
        {
            // the middle of the rest between the two
            found.push(((at + k) / 2, v.signum()));
        }
        last = Some((k, v.signum()));
    }
    found
}

/// Residual with a finding, and the finding's own effort, by joint.
struct Pair<'a> {
    sheet: &'a Sheet,
    with: Cow<'a, [Vec<f64>]>,
    law: Vec<Vec<f64>>,
}

impl<'a> Pair<'a> {
    fn new(sheet: &'a Sheet, without: &[Vec<f64>]) -> Option<Self> {
        let law = sheet
            .predicted
            .last()?
            .iter()
            .zip(without)
            .zip(&sheet.measured)
            .map(|((with, without), measured)| {
                if measured.is_empty() {
                    Vec::new()
                } else {
                    less(with, &sheet.motion.on_grid(without))
                }
            })
            .collect();
        Some(Self { sheet, with: Cow::Borrowed(sheet.residual.last()?), law })
    }
}

/// Effort of a finding on a joint above which it acts; none where it does not act on the joint.
fn acts_above(pairs: &[Pair<'_>], joint: usize) -> Option<f64> {
    let largest = pairs.iter().flat_map(|p| &p.law[joint]).fold(0.0_f64, |m, f| m.max(f.abs()));
    let scale =
        pairs.iter().flat_map(|p| &p.sheet.measured[joint]).fold(0.0_f64, |m, e| m.max(e.abs()));
    (largest > 1e-9 * scale).then_some(ACTS * largest)
}

/// Root mean squares without and with a finding where it acts on a joint, and the share of samples.
fn acting(pairs: &[Pair<'_>], joint: usize) -> (Option<[f64; 2]>, f64) {
    let Some(least) = acts_above(pairs, joint) else { return (None, 0.0) };
    let (mut without, mut with, mut count) = (0.0, 0.0, 0.0_f64);
    for pair in pairs {
        for (f, r) in pair.law[joint].iter().zip(&pair.with[joint]) {
            if f.abs() > least {
                without += (r + f).powi(2);
                with += r * r;
                count += 1.0;
            }
        }
    }
    let rms = |squares: f64| (squares / count.max(1.0)).sqrt();
    let samples: usize = pairs.iter().map(|p| p.law[joint].len()).sum();
    (Some([rms(without), rms(with)]), count / samples.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reversals_are_changes_of_sign() {
        let velocity: Vec<f64> = (0..1000).map(|k| (f64::from(k) * 0.02).cos()).collect();
        let found = reversals(&velocity);
        // cos turns at 0.02 k = π/2 + n π
        let expected: Vec<usize> =
            (0..6).map(|n| ((0.5 + f64::from(n)) * std::f64::consts::PI / 0.02) as usize).collect();
        assert_eq!(found.len(), expected.len());
        for ((at, _), expected) in found.iter().zip(expected) {
            assert!(at.abs_diff(expected) <= 2, "{at} {expected}");
        }
        assert_eq!(found[0].1, -1.0);
        // a stop is no reversal
        let dips: Vec<f64> = velocity.iter().map(|v| v.abs() + 0.001).collect();
        assert!(reversals(&dips).is_empty());
    }
}
