//! Evenly sampled motion of the joints asked for, with the efforts that drove it.

use std::ops::Range;
use std::sync::Arc;

use crate::cutoff::default_cutoff_hz;
use crate::duplicate_frames::RepeatedFrames;
use crate::grid::EvenGrid;
use crate::low_pass::{DEFAULT_ORDER, ZeroPhaseLowPass};
use crate::noise_spectrum::noise_of;
use crate::observations::Observations;
use crate::standstill::dwells_of;
use armident_recording::{Fault, JointChannels, Quantity, Recording, RecordingError};

/// Where velocity and acceleration come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DerivativeSource {
    /// The recorded ones where velocity and acceleration of all joints are recorded (exact
    /// simulations), else the position.
    #[default]
    Auto,
    /// The filtered position, differentiated. Recorded velocities lag or are noisy.
    FromPosition,
    /// The recorded ones, which must be there.
    Recorded,
}

/// How a [`Motion`] is made.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionSettings {
    /// Cutoff of the low-pass \[Hz\]. Without one: no filter if the derivatives are the recorded
    /// ones, else [`default_cutoff_hz`].
    pub cutoff_hz: Option<f64>,
    /// Order of the low-pass, applied forward and backward.
    pub order: usize,
    /// Where velocity and acceleration come from.
    pub derivatives: DerivativeSource,
}

impl Default for MotionSettings {
    fn default() -> Self {
        Self { cutoff_hz: None, order: DEFAULT_ORDER, derivatives: DerivativeSource::Auto }
    }
}

/// Position, velocity, acceleration and effort of some joints on an even grid. Columns are
/// joint-major: `position[joint][sample]`, joints as asked for.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Names of the joints.
    pub joints: Vec<String>,
    /// Times of the even grid \[s\].
    pub time_s: Vec<f64>,
    /// Samples per second of the grid.
    pub rate_hz: f64,
    /// Filtered position \[rad or m\].
    pub position: Vec<Vec<f64>>,
    /// Velocity \[rad/s or m/s\].
    pub velocity: Vec<Vec<f64>>,
    /// Acceleration \[rad/s² or m/s²\].
    pub acceleration: Vec<Vec<f64>>,
    /// Effort on the grid, not filtered \[N m or N\]; none unless recorded for all joints.
    pub effort: Option<Vec<Vec<f64>>>,
    /// Effort through the same filter as the position \[N m or N\].
    pub effort_filtered: Option<Vec<Vec<f64>>>,
    /// Temperature of the drives on the grid, not filtered \[°C\]; empty where it is not recorded.
    pub temperature_c: Vec<Vec<f64>>,
    /// The low-pass; none if nothing was filtered.
    pub filter: Option<ZeroPhaseLowPass>,
    /// Where the recording comes from.
    pub source: String,
    /// Stamps of the recording \[s\].
    pub stamps_s: Vec<f64>,
    /// Those of the recording, and what was chosen here.
    pub notes: Vec<String>,
    /// Dwells of each joint, in samples.
    dwells: Vec<Vec<Range<usize>>>,
    grid: EvenGrid,
    /// what a thinned motion was thinned from, and by which factor
    fine: Option<(Arc<Motion>, usize)>,
}

/// Samples per second of a [thinned](Motion::thinned) motion over the cut-off: products of several
/// low-passed signals stay below half of it, and the low-pass of the lower rate is that of the higher
/// to 1 % where there is motion.
const THINNED_RATE_OVER_CUTOFF: f64 = 16.0;

impl Motion {
    /// Resamples, filters and differentiates the channels of `joints`.
    ///
    /// # Errors
    /// An inconsistent recording; no joint; a joint without recorded position, or without recorded
    /// derivatives where the settings ask for them; a recording that is mostly gaps; a cutoff or
    /// order that is not possible.
    pub fn from_recording(
        recording: &Recording,
        joints: &[&str],
        settings: &MotionSettings,
    ) -> Result<Self, RecordingError> {
        let fault = |fault| RecordingError::new(fault, &recording.source);
        recording.check()?;
        if joints.is_empty() {
            return Err(fault(Fault::NoJointsRequested));
        }
        let channels: Vec<&JointChannels> = joints
            .iter()
            .map(|name| recording.joint(name).ok_or_else(|| fault(unknown(name, recording))))
            .collect::<Result<_, _>>()?;
        let recorded = |quantity| channels.iter().all(|joint| joint.channel(quantity).is_some());
        let use_recorded = match settings.derivatives {
            DerivativeSource::Auto => {
                recorded(Quantity::Velocity) && recorded(Quantity::Acceleration)
            }
            DerivativeSource::FromPosition => false,
            DerivativeSource::Recorded => true,
        };

        let mut notes = recording.notes.clone();
        let grid = EvenGrid::of(recording)?;
        notes.extend(timing_note(&grid));
        let repeated = RepeatedFrames::of(recording);
        notes.extend(repeated.map(|repeated| repeated.finding(&recording.time_s).message));
        let on_grid = |quantity: Quantity| -> Result<Vec<Vec<f64>>, RecordingError> {
            channels
                .iter()
                .map(|joint| match joint.channel(quantity) {
                    Some(values) => Ok(grid.resample(values)),
                    None => Err(fault(missing(joint, quantity))),
                })
                .collect()
        };

        let rate_hz = grid.rate_hz();
        let raw_position = on_grid(Quantity::Position)?;
        let position_noise: Vec<f64> =
            raw_position.iter().map(|position| noise_of(position, rate_hz).deviation).collect();
        let cutoff_hz = match settings.cutoff_hz {
            None if use_recorded => None,
            None => {
                let cutoff_hz = default_cutoff_hz(&raw_position, rate_hz);
                notes.push(format!(
                    "low-pass cut-off {cutoff_hz:.1} Hz (from the motion's spectrum)"
                ));
                Some(cutoff_hz)
            }
            given => given,
        };
        let filter = cutoff_hz
            .map(|cutoff_hz| ZeroPhaseLowPass::new(settings.order, cutoff_hz, rate_hz))
            .transpose()
            .map_err(|error| error.of_source(&recording.source))?;
        let filtered = |mut columns: Vec<Vec<f64>>| {
            if let Some(filter) = &filter {
                filter.filter_columns_in_parallel(&mut columns);
            }
            columns
        };

        let (position, velocity, acceleration) = match &filter {
            Some(filter) if !use_recorded => {
                let smooth = filter.with_derivatives(&raw_position);
                let [mut position, mut velocity, mut acceleration] = [const { Vec::new() }; 3];
                for [q, dq, ddq] in smooth {
                    position.push(q);
                    velocity.push(dq);
                    acceleration.push(ddq);
                }
                (position, velocity, acceleration)
            }
            _ => (
                filtered(raw_position),
                filtered(on_grid(Quantity::Velocity)?),
                filtered(on_grid(Quantity::Acceleration)?),
            ),
        };
        let gain = filter.as_ref().map_or(0.0, ZeroPhaseLowPass::noise_gain_of_rate);
        let dwells = (velocity.iter().zip(position_noise))
            .map(|(velocity, noise)| dwells_of(velocity, noise * gain, rate_hz))
            .collect();
        let temperature_c = (channels.iter())
            .map(|joint| joint.channel(Quantity::Temperature).map(|t| grid.resample(t)))
            .map(Option::unwrap_or_default)
            .collect();
        let effort = recorded(Quantity::Effort).then(|| on_grid(Quantity::Effort)).transpose()?;
        if effort.is_none() {
            notes.extend(effort_note(&channels));
        }
        let effort_filtered = effort.clone().map(filtered);

        Ok(Self {
            joints: joints.iter().map(ToString::to_string).collect(),
            time_s: grid.time_s().to_vec(),
            rate_hz,
            position,
            velocity,
            acceleration,
            effort,
            effort_filtered,
            temperature_c,
            filter,
            source: recording.source.clone(),
            stamps_s: grid.stamps_s().to_vec(),
            notes,
            dwells,
            grid,
            fine: None,
        })
    }

    /// The same motion with every so many samples left out, at 16 times the cut-off: more tell nothing
    /// beyond it. What jumps between two samples is still formed from [all of them](Self::filtered_fine).
    /// Without a low-pass, or sampled as slowly already, it is the same.
    #[must_use]
    pub fn thinned(self) -> Self {
        let factor = self.filter.as_ref().map_or(1, |filter| {
            (self.rate_hz / (THINNED_RATE_OVER_CUTOFF * filter.cutoff_hz())).floor().max(1.0)
                as usize
        });
        if factor == 1 || self.fine.is_some() {
            return self;
        }
        let rate_hz = self.rate_hz / factor as f64;
        let lower = self
            .filter
            .as_ref()
            .map(|filter| ZeroPhaseLowPass::new(filter.order(), filter.cutoff_hz(), rate_hz));
        // a cut-off that is possible at the higher rate is at 16 times itself
        let Some(Ok(filter)) = lower else { return self };
        let every =
            |column: &[f64]| -> Vec<f64> { column.iter().step_by(factor).copied().collect() };
        let columns = |of: &[Vec<f64>]| -> Vec<Vec<f64>> { of.iter().map(|c| every(c)).collect() };
        Self {
            joints: self.joints.clone(),
            time_s: every(&self.time_s),
            rate_hz,
            position: columns(&self.position),
            velocity: columns(&self.velocity),
            acceleration: columns(&self.acceleration),
            effort: self.effort.as_deref().map(columns),
            effort_filtered: self.effort_filtered.as_deref().map(columns),
            temperature_c: columns(&self.temperature_c),
            filter: Some(filter),
            source: self.source.clone(),
            stamps_s: self.stamps_s.clone(),
            notes: self.notes.clone(),
            dwells: (self.dwells.iter())
                .map(|of| {
                    of.iter().map(|r| r.start.div_ceil(factor)..r.end.div_ceil(factor)).collect()
                })
                .collect(),
            grid: self.grid.clone(),
            fine: Some((Arc::new(self), factor)),
        }
    }

    /// The motion of these samples and no others.
    #[must_use]
    pub fn without_fine(mut self) -> Self {
        self.fine = None;
        self
    }

    /// The motion with all samples.
    pub fn fine(&self) -> &Self {
        self.fine.as_ref().map_or(self, |(fine, _)| fine)
    }

    /// Puts columns formed from [all samples](Self::fine) through the filter, and brings them to the samples
    /// of this motion.
    pub fn filtered_fine(&self, mut columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        self.fine().filter_columns(&mut columns);
        let thinned = |column: Vec<f64>| match &self.fine {
            Some((_, factor)) => column.into_iter().step_by(*factor).collect(),
            None => column,
        };
        columns.into_iter().map(thinned).collect()
    }

    /// Number of samples on the grid.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Puts regressor columns on the grid through the filter that the effort went through;
    /// leaves them alone if there is none.
    pub fn filter_columns(&self, columns: &mut [Vec<f64>]) {
        if let Some(filter) = &self.filter {
            filter.filter_columns(columns);
        }
    }

    /// The samples `of` as observations of the effort of a joint: a rest is one.
    pub fn observations(&self, joint: usize, of: Range<usize>) -> Observations {
        Observations::new(&self.dwells[joint], of)
    }

    /// Whether a joint rests, at every sample.
    pub fn at_rest(&self, joint: usize) -> Vec<bool> {
        let mut at_rest = vec![false; self.len()];
        for rest in &self.dwells[joint] {
            at_rest[rest.start..rest.end.min(self.len())].fill(true);
        }
        at_rest
    }

    /// Share of independent samples in a filtered column of white noise; 1 without a filter.
    pub fn independent_share(&self) -> f64 {
        self.filter.as_ref().map_or(1.0, ZeroPhaseLowPass::independent_share)
    }

    /// A recorded channel of this recording brought to the grid, not filtered.
    pub fn on_grid(&self, at_stamps: &[f64]) -> Vec<f64> {
        self.grid.resample(at_stamps)
    }

    /// A column on the grid brought back to the stamps of the recording.
    pub fn at_stamps(&self, values: &[f64]) -> Vec<f64> {
        self.grid.at_stamps(values)
    }

    /// Samples in which efforts are not what was measured, with a period of the cut-off about gaps: not to be fitted.
    pub fn unmeasured(&self) -> Vec<Range<usize>> {
        let smear_s = self.filter.as_ref().map_or(0.0, |filter| 1.0 / filter.cutoff_hz());
        let place = |t: f64| self.time_s.partition_point(|time| *time < t);
        let samples = |(from_s, to_s): (f64, f64)| place(from_s)..place(to_s);
        self.grid.unmeasured_s(smear_s).into_iter().map(samples).collect()
    }

    /// The grid and the timing of the stamps it was made from.
    pub fn grid(&self) -> &EvenGrid {
        &self.grid
    }
}

fn unknown(name: &str, recording: &Recording) -> Fault {
    let wanted = name.to_lowercase();
    let similarity = |candidate: &str| strsim::jaro_winkler(&wanted, &candidate.to_lowercase());
    let nearest = recording
        .joint_names()
        .into_iter()
        .map(|candidate| (similarity(candidate), candidate))
        .filter(|(similarity, _)| *similarity > 0.7)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate.to_owned());
    let recorded = recording.joint_names().into_iter().map(str::to_owned).collect();
    Fault::UnknownJoint { joint: name.to_owned(), nearest, recorded }
}

fn missing(joint: &JointChannels, quantity: Quantity) -> Fault {
    let recorded = joint.channels().map(|(quantity, _)| quantity).collect();
    Fault::MissingChannel { joint: joint.name.clone(), quantity, recorded }
}

/// What the resampling did, if anything.
fn timing_note(grid: &EvenGrid) -> Option<String> {
    let timing = grid.timing();
    // stamps that are not used are a finding of the quality report
    if timing.is_even || grid.sampling_clock().is_some() {
        return None;
    }
    let longest = timing.gaps.iter().max_by(|a, b| a.length_s.total_cmp(&b.length_s));
    let gaps = longest.map_or(String::new(), |longest| {
        let count = timing.gaps.len();
        let (length_ms, at_s) = (1e3 * longest.length_s, longest.at_s);
        format!(
            "; {count} gap{}, longest {length_ms:.1} ms at t = {at_s:.3} s",
            if count == 1 { "" } else { "s" }
        )
    });
    Some(format!(
        "uneven time stamps (jitter {:.1} %{gaps}); resampled at {:.2} Hz",
        100.0 * timing.jitter,
        grid.rate_hz()
    ))
}

/// Which joints keep the motion from having efforts, if only some do.
fn effort_note(joints: &[&JointChannels]) -> Option<String> {
    let lacking: Vec<&str> = joints
        .iter()
        .filter(|joint| joint.effort.is_none())
        .map(|joint| joint.name.as_str())
        .collect();
    (lacking.len() < joints.len())
        .then(|| format!("efforts ignored: none recorded for {}", lacking.join(", ")))
}
