//! From named channels to a checked recording: repairs on reading, and faults.

use crate::error::{Fault, RecordingError, plural};
use crate::finding::{Action, QualityIssue, QualityIssueKind, Span, percent};
use crate::foreign_rows::rows_of_zeros;
use crate::interpolation::{BRIDGED_STEPS, Interpolation};
use crate::limits::{
    LONGEST_STEP_S, MIN_SAMPLES, MISSING_RUN, MISSING_SHARE, REPEATED_SHARE, SHORTEST_STEP_S,
};
use crate::own_stamps::{Cells, Merged, one_stamp_one_row};
use crate::quantity::Quantity;
use crate::raw::RawColumns;
use crate::recording::{JointChannels, Recording};
use crate::spikes::{drop_outs, glitches, outliers, without_events};
use crate::timing::Timing;
use crate::unwrap::{is_wrap_of, unwrap_turns};
use crate::velocity_check;

/// A channel as read.
struct Channel {
    joint: String,
    quantity: Quantity,
    /// The column it comes from; none if it comes from several.
    column: Option<usize>,
    values: Vec<f64>,
}

impl Channel {
    fn name(&self) -> String {
        format!("{}/{}", self.joint, self.quantity)
    }
}

/// A recording before the checks: stamps may repeat, values may be NaN.
pub(crate) struct Import {
    raw: RawColumns,
    time_column: usize,
    time_s: Vec<f64>,
    channels: Vec<Channel>,
    pub(crate) notes: Vec<String>,
    pub(crate) ignored: Vec<String>,
    pub(crate) findings: Vec<QualityIssue>,
    /// Whether a mapping gave the columns their meaning.
    pub(crate) by_mapping: bool,
    /// Whether the unit of the stamps was stated, so that it need not be guarded.
    pub(crate) time_unit_is_stated: bool,
    /// Whether rows may be put into the order of time.
    pub(crate) sort: bool,
}

impl Import {
    /// Time stamps in seconds and no channel yet. `raw` has lines, names and texts for messages.
    pub(crate) fn new(raw: RawColumns, time_column: usize, time_s: Vec<f64>) -> Self {
        Self {
            raw,
            time_column,
            time_s,
            channels: Vec::new(),
            notes: Vec::new(),
            ignored: Vec::new(),
            findings: Vec::new(),
            by_mapping: false,
            time_unit_is_stated: false,
            sort: false,
        }
    }

    pub(crate) fn push(
        &mut self,
        joint: &str,
        quantity: Quantity,
        column: Option<usize>,
        values: Vec<f64>,
    ) {
        self.channels.push(Channel { joint: joint.to_owned(), quantity, column, values });
    }

    /// Repairs what is safe to repair and refuses the rest.
    pub(crate) fn finish(mut self) -> Result<Recording, RecordingError> {
        if let Some(error) =
            self.not_finite(|value| !value.is_finite(), |value| value.is_infinite())
        {
            return Err(error);
        }
        self.exclude_empty();
        self.sort_rows()?;
        self.merge_publishers();
        self.exclude_zeros();
        let rows = self.time_s.len();
        if let Some(error) = self.too_many_missing() {
            return Err(error);
        }
        let too_few = |found| Fault::TooFewSamples { found, required: MIN_SAMPLES };
        if rows < MIN_SAMPLES {
            return Err(self.fault(too_few(rows)));
        }
        self.drop_repeated()?;
        if self.time_s.len() < MIN_SAMPLES {
            return Err(self.fault(too_few(self.time_s.len())));
        }
        let timing = Timing::of(&self.time_s);
        self.check_seconds(&timing)?;
        self.interpolate_missing(&timing);
        self.unwrap_angles();
        self.repair_positions(&timing);
        self.repair_efforts(&timing);

        let (source, by_mapping) = (self.raw.source, self.by_mapping);
        let mut joints: Vec<JointChannels> = Vec::new();
        for channel in self.channels {
            let index =
                joints.iter().position(|joint| joint.name == channel.joint).unwrap_or_else(|| {
                    joints.push(JointChannels::new(&channel.joint));
                    joints.len() - 1
                });
            *joints[index].channel_mut(channel.quantity) = Some(channel.values);
        }
        let mut recording = Recording::new(source, self.time_s, joints)?;
        if let Some(finding) = velocity_check::refusal(&recording, &timing, by_mapping) {
            let quantity = finding.quantity.unwrap_or(Quantity::Position);
            let place = format!("{}/{quantity}", finding.joint.as_deref().unwrap_or_default());
            let fault = Fault::Refused(Box::new(finding));
            return Err(RecordingError::new(fault, &recording.source).in_column(&place));
        }
        recording.notes = self.notes;
        recording.ignored_columns = self.ignored;
        let repaired = self.findings.iter().filter(|finding| finding.action == Action::Repaired);
        recording.notes.extend(repaired.map(|finding| finding.message.clone()));
        recording.findings = self.findings;
        Ok(recording)
    }

    fn fault(&self, fault: Fault) -> RecordingError {
        RecordingError::new(fault, &self.raw.source)
    }

    /// A fault in a row of a column.
    fn fault_at(
        &self,
        fault: Fault,
        row: usize,
        column: Option<usize>,
        name: &str,
    ) -> RecordingError {
        let error = self.fault(fault);
        let error = match self.raw.line(row) {
            Some(line) => error.on_line(line),
            None => error,
        };
        error.in_column(column.map_or(name, |column| &self.raw.columns[column].name))
    }

    fn time_fault(&self, fault: Fault, row: Option<usize>) -> RecordingError {
        let name = &self.raw.columns[self.time_column].name;
        match row {
            Some(row) => self.fault_at(fault, row, Some(self.time_column), name),
            None => self.fault(fault).in_column(name),
        }
    }

    /// The first value that is refused, in stamps or channels, by row.
    fn not_finite(
        &self,
        refused_stamp: impl Fn(f64) -> bool,
        refused_value: impl Fn(f64) -> bool,
    ) -> Option<RecordingError> {
        let stamp = self.time_s.iter().position(|t| refused_stamp(*t));
        let stamp =
            stamp.map(|row| (row, Some(self.time_column), "t".to_owned(), self.time_s[row]));
        let value = self.channels.iter().filter_map(|channel| {
            let row = channel.values.iter().position(|value| refused_value(*value))?;
            Some((row, channel.column, channel.name(), channel.values[row]))
        });
        let (row, column, name, value) = stamp.into_iter().chain(value).min_by_key(|at| at.0)?;
        let text =
            column.map_or_else(|| value.to_string(), |column| self.raw.text(row, column, value));
        Some(self.fault_at(self.missing(text), row, column, &name))
    }

    /// The fault of a value that is not finite, by its text in the file.
    fn missing(&self, text: String) -> Fault {
        let (count, total) = self.count_not_finite();
        if text.is_empty() { Fault::EmptyField } else { Fault::NotFinite { text, count, total } }
    }

    /// Values that are not finite, and all.
    fn count_not_finite(&self) -> (usize, usize) {
        let of = |values: &[f64]| values.iter().filter(|value| !value.is_finite()).count();
        let columns = || {
            let channels = self.channels.iter().map(|channel| &channel.values[..]);
            channels.chain([&self.time_s[..]])
        };
        (columns().map(of).sum(), columns().map(<[f64]>::len).sum())
    }

    /// Sorts rows by time if requested, else refuses decreasing stamps.
    fn sort_rows(&mut self) -> Result<(), RecordingError> {
        let steps_back: Vec<usize> =
            (1..self.time_s.len()).filter(|k| self.time_s[*k] < self.time_s[k - 1]).collect();
        let Some(&first) = steps_back.first() else { return Ok(()) };
        let (count, total) = (steps_back.len(), self.time_s.len());
        if !self.sort {
            let (previous_s, found_s) = (self.time_s[first - 1], self.time_s[first]);
            let fault = Fault::TimeBackwards { previous_s, found_s, count, total };
            return Err(self.time_fault(fault, Some(first)));
        }
        let mut order: Vec<usize> = (0..total).collect();
        order.sort_by(|a, b| self.time_s[*a].total_cmp(&self.time_s[*b]));
        let sorted = |values: &[f64]| order.iter().map(|k| values[*k]).collect::<Vec<f64>>();
        let runs: Vec<(usize, usize)> = steps_back.iter().map(|k| (*k, *k)).collect();
        let spans = Span::of_runs(&self.time_s, &runs);
        self.time_s = sorted(&self.time_s);
        for channel in &mut self.channels {
            channel.values = sorted(&channel.values);
        }
        if !self.raw.lines.is_empty() {
            self.raw.lines = order.iter().map(|k| self.raw.lines[*k]).collect();
        }
        let message = format!(
            "time stamps decrease {count} time{} in {total} samples, first to t = {} s; rows sorted",
            plural(count),
            spans[0].from_s
        );
        let share = count as f64 / total as f64;
        let finding =
            QualityIssue::of_stamps(QualityIssueKind::UnsortedRows, Action::Repaired, share)
                .at(spans);
        self.findings.push(finding.with_message(message));
        Ok(())
    }

    /// NaN beyond the limits of interpolation.
    fn too_many_missing(&self) -> Option<RecordingError> {
        let total = self.time_s.len();
        let refused = |channel: &&Channel| {
            let runs = runs_of_nan(&channel.values);
            let count: usize = runs.iter().map(|(from, to)| to - from + 1).sum();
            let at_an_end = |(from, to): &(usize, usize)| *from == 0 || *to + 1 == total;
            count as f64 > MISSING_SHARE * total as f64
                || runs.iter().any(|run| run.1 - run.0 >= MISSING_RUN || at_an_end(run))
        };
        let channel = self.channels.iter().filter(refused).min_by_key(|channel| {
            channel.values.iter().position(|value| value.is_nan()).unwrap_or(total)
        })?;
        let row = channel.values.iter().position(|value| value.is_nan())?;
        let text = channel
            .column
            .map_or_else(|| "NaN".to_owned(), |column| self.raw.text(row, column, f64::NAN));
        Some(self.fault_at(self.missing(text), row, channel.column, &channel.name()))
    }

    fn interpolate_missing(&mut self, timing: &Timing) {
        for channel in &mut self.channels {
            let runs = runs_of_nan(&channel.values);
            if runs.is_empty() {
                continue;
            }
            let present = |k: &usize| !channel.values[*k].is_nan();
            let known: Vec<usize> = (0..channel.values.len()).filter(present).collect();
            let known_s: Vec<f64> = known.iter().map(|k| self.time_s[*k]).collect();
            let known_values: Vec<f64> = known.iter().map(|k| channel.values[*k]).collect();
            let missing: Vec<usize> =
                (0..channel.values.len()).filter(|k| channel.values[*k].is_nan()).collect();
            let missing_s: Vec<f64> = missing.iter().map(|k| self.time_s[*k]).collect();
            let longest_s = BRIDGED_STEPS * timing.median_step_s;
            let filled = Interpolation::new(&known_s, &missing_s, longest_s).apply(&known_values);
            for (k, value) in missing.iter().zip(filled) {
                channel.values[*k] = value;
            }
            let share = missing.len() as f64 / channel.values.len() as f64;
            let spans = Span::of_runs(&self.time_s, &runs);
            let message = format!(
                "{} of {} values are NaN ({}), {}; interpolated",
                missing.len(),
                channel.values.len(),
                percent(share),
                Span::describe(&spans)
            );
            self.findings.push(
                QualityIssue::of_channel(
                    QualityIssueKind::MissingValues,
                    Action::Repaired,
                    &channel.joint,
                    channel.quantity,
                    share,
                )
                .at(spans)
                .with_message(message),
            );
        }
    }

    fn drop_repeated(&mut self) -> Result<(), RecordingError> {
        let total = self.time_s.len();
        let repeated: Vec<usize> =
            (1..total).filter(|k| self.time_s[*k] == self.time_s[k - 1]).collect();
        let Some(&first) = repeated.first() else { return Ok(()) };
        let count = repeated.len();
        if count as f64 > REPEATED_SHARE * total as f64 {
            return Err(self.time_fault(Fault::RepeatedStamps { count, total }, Some(first)));
        }
        let runs: Vec<(usize, usize)> = repeated.iter().map(|k| (*k, *k)).collect();
        let spans = Span::of_runs(&self.time_s, &runs);
        let message = format!(
            "{count} duplicate time stamp{} in {total} samples, first at t = {} s; dropped",
            plural(count),
            self.time_s[first]
        );
        let is_new = |k: &usize| *k == 0 || self.time_s[*k] != self.time_s[k - 1];
        self.keep_rows(&(0..total).filter(is_new).collect::<Vec<_>>());
        let share = count as f64 / total as f64;
        let finding =
            QualityIssue::of_stamps(QualityIssueKind::RepeatedStamps, Action::Repaired, share);
        self.findings.push(finding.at(spans).with_message(message));
        Ok(())
    }

    fn check_seconds(&self, timing: &Timing) -> Result<(), RecordingError> {
        let median_step_s = timing.median_step_s;
        let Some((unit, factor)) = not_seconds(median_step_s) else { return Ok(()) };
        if self.time_unit_is_stated {
            return Ok(());
        }
        let median_step = format!("{median_step_s:.3e}").parse().unwrap_or(median_step_s);
        let by_mapping = self.by_mapping;
        Err(self.time_fault(Fault::NotSeconds { median_step, unit, factor, by_mapping }, None))
    }

    fn unwrap_angles(&mut self) {
        for channel in &mut self.channels {
            if !matches!(channel.quantity, Quantity::Position | Quantity::MotorPosition) {
                continue;
            }
            let jumps = unwrap_turns(&mut channel.values);
            if jumps.is_empty() {
                continue;
            }
            let runs: Vec<(usize, usize)> = jumps.iter().map(|k| (*k, *k)).collect();
            let spans = Span::of_runs(&self.time_s, &runs);
            let message = format!(
                "angle wraps {} time{} in {} samples, first at t = {:.3} s; unwrapped",
                jumps.len(),
                plural(jumps.len()),
                channel.values.len(),
                spans[0].from_s
            );
            let share = jumps.len() as f64 / channel.values.len() as f64;
            self.findings.push(
                QualityIssue::of_channel(
                    QualityIssueKind::WrappedAngle,
                    Action::Repaired,
                    &channel.joint,
                    channel.quantity,
                    share,
                )
                .at(spans)
                .with_message(message),
            );
        }
    }

    /// Excludes channels without a single value.
    fn exclude_empty(&mut self) {
        let is_empty = |channel: &Channel| channel.values.iter().all(|value| value.is_nan());
        let total = self.channels.len();
        let (empty, kept): (Vec<Channel>, Vec<Channel>) =
            std::mem::take(&mut self.channels).into_iter().partition(is_empty);
        self.channels = kept;
        // without any value the file itself is the fault
        if empty.is_empty() || self.channels.is_empty() {
            self.channels.extend(empty);
            return;
        }
        let names: Vec<String> = empty.iter().map(Channel::name).collect();
        let message = format!("columns without a value left out: {}", names.join(", "));
        let share = empty.len() as f64 / total as f64;
        let finding =
            QualityIssue::of_stamps(QualityIssueKind::EmptyColumns, Action::Repaired, share);
        self.findings.push(finding.with_message(message));
    }

    /// Brings channels that stand in rows of their own stamps to the rows of the positions.
    fn merge_publishers(&mut self) {
        let values: Vec<&[f64]> = self.channels.iter().map(|c| &c.values[..]).collect();
        if values.iter().all(|values| !values.iter().any(|value| value.is_nan())) {
            return;
        }
        let first = one_stamp_one_row(&self.time_s, &values);
        for (k, &row) in first.iter().enumerate().filter(|(k, row)| *k != **row) {
            for channel in &mut self.channels {
                if !channel.values[k].is_nan() {
                    channel.values[row] = channel.values[k];
                }
            }
        }
        let own: Vec<usize> = (0..first.len()).filter(|k| first[*k] == *k).collect();
        self.keep_rows(&own);
        let cells: Vec<Cells<'_>> = (self.channels.iter())
            .map(|c| Cells {
                is_position: c.quantity == Quantity::Position,
                is_drive: c.quantity.is_of_drive(),
                values: &c.values,
            })
            .collect();
        let Some(Merged { base, rows, interpolated }) = Merged::of(&self.time_s, &cells) else {
            return;
        };
        let total = self.time_s.len();
        let moved: Vec<usize> = interpolated.iter().map(|(channel, _)| *channel).collect();
        let what = self.described(&moved);
        self.keep_rows(&rows);
        for (channel, values) in interpolated {
            self.channels[channel].values = values;
        }
        let others = total - rows.len();
        let message = match moved[..] {
            [] => format!("rows without a value of any joint left out: {others} of {total}"),
            _ => format!(
                "{what} in rows of their own stamps ({others} of {total} rows, of another publisher); interpolated onto the {} \
                 rows of {}",
                rows.len(),
                self.channels[base].quantity
            ),
        };
        let share = others as f64 / total as f64;
        let finding = QualityIssue::of_stamps(QualityIssueKind::OwnStamps, Action::Repaired, share);
        self.findings.push(finding.with_message(message));
    }

    /// Channels in words: all of some quantities, or one after the other.
    fn described(&self, channels: &[usize]) -> String {
        let mut quantities: Vec<Quantity> = Vec::new();
        for channel in channels {
            let quantity = self.channels[*channel].quantity;
            if !quantities.contains(&quantity) {
                quantities.push(quantity);
            }
        }
        let is_all = (self.channels.iter().enumerate())
            .all(|(k, channel)| channels.contains(&k) == quantities.contains(&channel.quantity));
        let names: Vec<String> = if is_all {
            quantities.iter().map(ToString::to_string).collect()
        } else {
            channels.iter().map(|channel| self.channels[*channel].name()).collect()
        };
        names.join(", ")
    }

    /// Excludes rows of zeros of another publisher.
    fn exclude_zeros(&mut self) {
        let of = |are_positions: bool| -> Vec<&[f64]> {
            let is_one =
                |channel: &&Channel| (channel.quantity == Quantity::Position) == are_positions;
            self.channels.iter().filter(is_one).map(|channel| &channel.values[..]).collect()
        };
        let zeros = rows_of_zeros(&of(true), &of(false));
        if zeros.is_empty() {
            return;
        }
        let total = self.time_s.len();
        let share = zeros.len() as f64 / total as f64;
        let runs = runs_of(&zeros);
        let spans = Span::of_runs(&self.time_s, &runs);
        let message = format!(
            "{} row{} of zeros, of another publisher, between rows of motion ({}), {}; left out",
            zeros.len(),
            plural(zeros.len()),
            percent(share),
            Span::describe(&spans)
        );
        self.keep_rows(&(0..total).filter(|k| zeros.binary_search(k).is_err()).collect::<Vec<_>>());
        let finding =
            QualityIssue::of_stamps(QualityIssueKind::RowsOfZeros, Action::Repaired, share);
        self.findings.push(finding.at(spans).with_message(message));
    }

    /// Keeps these rows, increasing.
    fn keep_rows(&mut self, rows: &[usize]) {
        if rows.len() == self.time_s.len() {
            return;
        }
        let kept = |values: &[f64]| rows.iter().map(|k| values[*k]).collect::<Vec<f64>>();
        self.time_s = kept(&self.time_s);
        for channel in &mut self.channels {
            channel.values = kept(&channel.values);
        }
        if !self.raw.lines.is_empty() {
            self.raw.lines = rows.iter().map(|k| self.raw.lines[*k]).collect();
        }
    }

    /// Interpolates single positions that jump away and back.
    fn repair_positions(&mut self, timing: &Timing) {
        let mut is_repaired = false;
        for k in 0..self.channels.len() {
            let channel = &self.channels[k];
            if !matches!(channel.quantity, Quantity::Position | Quantity::MotorPosition) {
                continue;
            }
            let samples: Vec<usize> = (glitches(&channel.values).into_iter())
                .filter(|sample| !is_wrap_of(&channel.values, *sample))
                .collect();
            if samples.is_empty() {
                continue;
            }
            let largest = self.replace(k, &samples, timing);
            let what = format!("jump away and back by up to {largest:.2}, as bus errors do");
            self.report_replaced(k, QualityIssueKind::Glitches, &samples, &what);
            is_repaired = true;
        }
        if is_repaired {
            // glitches hide that an angle wraps
            self.unwrap_angles();
        }
    }

    /// Interpolates single efforts that jump away and back, and short drop-outs to 0; none beside accelerations, which only
    /// simulations have: their efforts jump where their motion does.
    fn repair_efforts(&mut self, timing: &Timing) {
        if self.channels.iter().any(|channel| channel.quantity == Quantity::Acceleration) {
            return;
        }
        let drives: Vec<usize> =
            (0..self.channels.len()).filter(|k| self.channels[*k].quantity.is_of_drive()).collect();
        for &k in &drives {
            let dropped: Vec<usize> = (drop_outs(&self.channels[k].values, self.position_of(k)))
                .into_iter()
                .flat_map(|(from, to)| from..=to)
                .collect();
            if !dropped.is_empty() {
                self.replace(k, &dropped, timing);
                let what = "are exactly 0 while the joint moves (drop-outs)";
                self.report_replaced(k, QualityIssueKind::DropOuts, &dropped, what);
            }
        }
        let mut spikes: Vec<Vec<usize>> = (drives.iter())
            .map(|k| outliers(&self.channels[*k].values, self.position_of(*k)))
            .collect();
        without_events(&mut spikes);
        for (k, samples) in drives.into_iter().zip(spikes) {
            if !samples.is_empty() {
                let largest = self.replace(k, &samples, timing);
                let what = format!("jump away and back by up to {largest:.3} (outliers)");
                self.report_replaced(k, QualityIssueKind::Outliers, &samples, &what);
            }
        }
    }

    /// Position of the joint of a channel.
    fn position_of(&self, channel: usize) -> Option<&[f64]> {
        let joint = &self.channels[channel].joint;
        let is_it = |c: &&Channel| c.joint == *joint && c.quantity == Quantity::Position;
        self.channels.iter().find(is_it).map(|c| &c.values[..])
    }

    /// Interpolates these samples of a channel from the others; the largest change.
    fn replace(&mut self, channel: usize, samples: &[usize], timing: &Timing) -> f64 {
        let values = &mut self.channels[channel].values;
        let known: Vec<usize> =
            (0..values.len()).filter(|k| samples.binary_search(k).is_err()).collect();
        let known_s: Vec<f64> = known.iter().map(|k| self.time_s[*k]).collect();
        let known_values: Vec<f64> = known.iter().map(|k| values[*k]).collect();
        let samples_s: Vec<f64> = samples.iter().map(|k| self.time_s[*k]).collect();
        let longest_s = BRIDGED_STEPS * timing.median_step_s;
        let new = Interpolation::new(&known_s, &samples_s, longest_s).apply(&known_values);
        let mut largest = 0.0_f64;
        for (k, new) in samples.iter().zip(new) {
            largest = largest.max((values[*k] - new).abs());
            values[*k] = new;
        }
        largest
    }

    fn report_replaced(
        &mut self,
        channel: usize,
        kind: QualityIssueKind,
        samples: &[usize],
        what: &str,
    ) {
        let channel = &self.channels[channel];
        let total = channel.values.len();
        let share = samples.len() as f64 / total as f64;
        let spans = Span::of_runs(&self.time_s, &runs_of(samples));
        let message = format!(
            "{} of {total} values {what} ({}), {}; interpolated",
            samples.len(),
            percent(share),
            Span::describe(&spans)
        );
        let finding = QualityIssue::of_channel(
            kind,
            Action::Repaired,
            &channel.joint,
            channel.quantity,
            share,
        );
        self.findings.push(finding.at(spans).with_message(message));
    }
}

/// First and last of each run of successive samples.
fn runs_of(samples: &[usize]) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for &k in samples {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == k => *last = k,
            _ => runs.push((k, k)),
        }
    }
    runs
}

/// First and last sample of each run of NaN.
fn runs_of_nan(values: &[f64]) -> Vec<(usize, usize)> {
    let missing: Vec<usize> = (0..values.len()).filter(|k| values[*k].is_nan()).collect();
    runs_of(&missing)
}

/// Apparent unit of stamps with this median step, and the factor to seconds; none for seconds.
pub(crate) fn not_seconds(median_step: f64) -> Option<(&'static str, f64)> {
    match median_step {
        step if step >= 5e5 => Some(("nanoseconds", 1e-9)),
        step if step >= 5e2 => Some(("microseconds", 1e-6)),
        1.0 => Some(("sample numbers or milliseconds", 1e-3)),
        step if step >= LONGEST_STEP_S => Some(("milliseconds", 1e-3)),
        step if step <= SHORTEST_STEP_S => Some(("days", 86_400.0)),
        _ => None,
    }
}
