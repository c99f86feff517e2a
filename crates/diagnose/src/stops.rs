//! Where a joint stops: its acceleration jumps there, and its friction is no function of its motion.
//!
//! Three things are known all the same. The motion before a stop is smooth by itself, and so is that after it. A drive
//! does not jump: its effort is continuous where a joint stops and where it breaks away, so while the joint rests it goes
//! from what it needed before to what it needs after. And what the drive follows goes on meanwhile: how far it runs while
//! friction reverses is told by the rests in which the joint turns back.

use armident_numeric::{Cholesky, dot};
use armident_recording::{Continuation, QUARTIC_TERMS, Quartics, ZeroPhaseLowPass, differentiate};

/// A speed below this many standard deviations of its noise has no sign...
const SIGN_DEVIATIONS: f64 = 5.0;
/// ... nor one below this share of the root mean square speed.
const SIGN_SHARE: f64 = 0.002;
/// A joint sticks below this share of the root mean square speed...
const STICK_SHARE: f64 = 0.006;
/// ... if it stays there this long \[s\].
const STICK_S: f64 = 0.03;
/// A joint rests while its recorded position stays within this many standard deviations of its noise...
const SAME_PLACE_DEVIATIONS: f64 = 6.0;
/// ... or of this many steps of its encoder...
const SAME_PLACE_STEPS: f64 = 1.5;
/// ... this long \[s\], where at its accelerations so far around \[s\] it would have gone this many times as
/// far...
const REST_S: f64 = 0.008;
const AROUND_S: f64 = 0.05;
const FAR: f64 = 5.0;
/// ... and where no quartic passes through all that is around, up to 1.5 deviations: a motion that comes near zero speed
/// and goes on is smooth.
const SMOOTH_DEVIATIONS: f64 = 1.5;
/// The rest begins and ends where the position is this near to its middle, in standard deviations of its noise.
const AT_REST_DEVIATIONS: f64 = 2.5;
/// Efforts are continued past a stop by so much of their mirror image \[s\].
const MIRRORED_S: f64 = 0.12;
/// What moves less long than this between two stops is not smoothed for itself \[s\].
const LEAST_PIECE_S: f64 = 0.1;
/// An arm stands at an end of a recording where so much of its motion there \[s\], smoothed with so much around \[s\],
/// says so by twice this logarithm of the likelihood.
const END_S: f64 = 0.03;
const ROUND_END_S: f64 = 1.0;
const CLEAR: f64 = 10.0;
/// First positions of a recording that tell whether it starts at rest: through so many \[s\], and through so few, a cubic
/// is laid. A speed of this share of the usual one is none.
const ONSET_S: f64 = 0.06;
const LEAST_ONSET: usize = 6;
const STILL_SHARE: f64 = 5e-3;
/// A drive gives up what its joint needed to slow down within this time of a rest \[s\].
const HELD_S: f64 = 0.3;
/// Friction fades to nothing in this time \[s\] when a joint slows down and goes on the same way, and in the second
/// one when it rests in between.
const DIP_S: f64 = 0.04;
const REST_DIP_S: f64 = 0.1;
/// A joint that breaks away has the acceleration of what its drive follows so much later \[s\].
const LATER_S: f64 = 0.03;

/// Position, velocity and acceleration of one joint.
pub(crate) struct SmoothMotion {
    pub(crate) position: Vec<f64>,
    pub(crate) velocity: Vec<f64>,
    pub(crate) acceleration: Vec<f64>,
}

/// What is recorded of the motion of one joint, on an even grid.
pub(crate) struct Channels<'a> {
    pub(crate) position: &'a [f64],
    /// to be used in place of the derivative of the position
    pub(crate) velocity: Option<&'a [f64]>,
    /// least difference of positions
    pub(crate) step: f64,
    pub(crate) rate_hz: f64,
    /// how position and velocity go on past the ends of the recording
    pub(crate) goes_on: [Continuation; 2],
    /// whether the joint stands at the first sample, and at the last
    pub(crate) stands: [bool; 2],
}

impl Channels<'_> {
    /// Through a low-pass, from one end of the recording to the other.
    pub(crate) fn smooth(&self, low_pass: &ZeroPhaseLowPass) -> SmoothMotion {
        let (position, velocity) = self.series(low_pass);
        let whole = (0, self.position.len());
        smooth_piece(&position, velocity.as_ref(), whole, low_pass, self.rate_hz)
    }

    /// What was smoothed as a whole, with what lies between two stops smoothed for itself. A joint that comes to rest is continued as if it
    /// turned back the way it came, which keeps its acceleration up to where it stops; one that breaks away starts
    /// with none, and is smoothed together with the rest before.
    pub(crate) fn smooth_between(
        &self,
        rests: &[(usize, usize)],
        low_pass: &ZeroPhaseLowPass,
        mut motion: SmoothMotion,
    ) -> SmoothMotion {
        let pieces = pieces(rests, self.position.len(), self.rate_hz);
        if pieces.is_empty() {
            return motion;
        }
        let (position, velocity) = self.series(low_pass);
        for (start, end) in pieces {
            let piece =
                smooth_piece(&position, velocity.as_ref(), (start, end), low_pass, self.rate_hz);
            motion.position[start..end].copy_from_slice(&piece.position);
            motion.velocity[start..end].copy_from_slice(&piece.velocity);
            motion.acceleration[start..end].copy_from_slice(&piece.acceleration);
        }
        motion
    }

    fn series(&self, low_pass: &ZeroPhaseLowPass) -> (Series<'_>, Option<Series<'_>>) {
        let of = |values, k: usize, image| {
            Series::of(values, image, self.goes_on[k], self.stands, low_pass)
        };
        (of(self.position, 0, 1.0), self.velocity.map(|velocity| of(velocity, 1, -1.0)))
    }

    /// Twice the logarithm of how much likelier the motion at the ends of the recording is of a joint that stands there,
    /// which goes on as its mirror image, than of one that is in motion. `noise` is that of the position.
    fn stands_by(&self, low_pass: &ZeroPhaseLowPass, noise: f64) -> [f64; 2] {
        if noise <= 0.0 {
            return [0.0; 2];
        }
        let n = self.position.len();
        let near = ((END_S * self.rate_hz).ceil() as usize).min(n);
        let part = (ROUND_END_S * self.rate_hz).ceil() as usize;
        [0, 1].map(|end| {
            let from = [0, n.saturating_sub(part)][end];
            let position = &self.position[from..(from + part).min(n)];
            let misfit = |stands: bool| -> f64 {
                let stands = [stands && end == 0, stands && end == 1];
                let smooth = Self { position, velocity: None, stands, ..*self }.smooth(low_pass);
                let first = [0, position.len() - near][end];
                let off = |t: usize| (smooth.position[t] - position[t]) / noise;
                (first..first + near).map(|t| off(t).powi(2)).sum()
            };
            misfit(false) - misfit(true)
        })
    }

    /// Twice the logarithm of how much likelier the first positions are of a joint that starts at rest than of one whose
    /// speed there is as usual in the recording. `noise` is that of the position.
    fn starts_at_rest_by(&self, noise: f64) -> f64 {
        let near = ((ONSET_S * self.rate_hz).round() as usize).max(LEAST_ONSET + 1);
        if noise <= 0.0 || self.position.len() <= 2 * near {
            return 0.0;
        }
        let way = |(a, b): (&f64, &f64)| ((b - a) * self.rate_hz / near as f64).powi(2);
        let later = &self.position[near..];
        let usual = self.position.iter().zip(later).map(way).sum::<f64>() / later.len() as f64;
        let by = |samples: usize| -> Option<f64> {
            let Onset { speed, variance, left } =
                Onset::of(&self.position[..samples], self.rate_hz)?;
            // what a cubic does not follow of the motion counts as noise
            let still = noise.powi(2).max(left) * variance + STILL_SHARE.powi(2) * usual;
            let [resting, moving] =
                [still, still + usual].map(|v: f64| -v.ln() - speed.powi(2) / v);
            Some(resting - moving)
        };
        // a light joint is off at once: little of its start is smooth
        [near, LEAST_ONSET].into_iter().filter_map(by).fold(f64::MIN, f64::max)
    }

    /// Where the joint stays at one place though it would have left it at its accelerations around: among them the
    /// rests of stick and slip, too short to be seen in a filtered velocity. `noise` is that of the position.
    pub(crate) fn rests(&self, acceleration: &[f64], noise: f64) -> Vec<(usize, usize)> {
        // a joint that mostly stands still has no noise to tell its encoder's step by
        let deviation = noise.max(SAME_PLACE_STEPS / SAME_PLACE_DEVIATIONS * self.step);
        let mut found = rests(self.position, acceleration, deviation, self.rate_hz);
        for (start, end) in &mut found {
            let mut places = self.position[*start..*end].to_vec();
            let (_, middle, _) = places.select_nth_unstable_by((*end - *start) / 2, f64::total_cmp);
            let at_rest =
                |t: &usize| (self.position[*t] - *middle).abs() <= AT_REST_DEVIATIONS * deviation;
            (*start, *end) = (
                (*start..*end).find(at_rest).unwrap_or(*start),
                (*start..*end).rfind(at_rest).map_or(*end, |last| last + 1),
            );
        }
        found
    }
}

/// Whether the arm stands at the ends of a recording, as it does where its drives are switched on: all its joints
/// together say so clearly. `noises` are those of the positions.
pub(crate) fn stands_at_ends(
    joints: &[Channels<'_>],
    noises: &[f64],
    low_pass: &ZeroPhaseLowPass,
) -> [bool; 2] {
    let mut sums = [0.0; 2];
    for (joint, noise) in joints.iter().zip(noises) {
        for (sum, x) in sums.iter_mut().zip(joint.stands_by(low_pass, *noise)) {
            *sum += x;
        }
    }
    sums.map(|sum| sum > CLEAR)
}

/// Whether an arm starts to move at the first sample or rests there: all its joints together say so clearly, also where
/// they are off so suddenly that their motion is none of joints that [stand](stands_at_ends). `noises` are those of the
/// positions.
pub(crate) fn starts_at_rest(joints: &[Channels<'_>], noises: &[f64]) -> bool {
    let by = joints.iter().zip(noises).map(|(joint, noise)| joint.starts_at_rest_by(*noise));
    by.sum::<f64>() > CLEAR
}

/// Speed of a motion at its first sample.
struct Onset {
    speed: f64,
    /// of the speed, for positions of variance 1
    variance: f64,
    /// variance of the positions about the cubic
    left: f64,
}

impl Onset {
    /// Of the cubic through some positions.
    fn of(positions: &[f64], rate_hz: f64) -> Option<Self> {
        const TERMS: usize = 4;
        let samples = positions.len() as f64;
        let powers = |k: usize| -> [f64; TERMS] {
            let x = k as f64 / samples;
            [1.0, x, x * x, x * x * x]
        };
        let sum = |of: &dyn Fn(usize) -> f64| (0..positions.len()).map(of).sum::<f64>();
        let factor = Cholesky::of(TERMS, |a, b| sum(&|k| powers(k)[a] * powers(k)[b]))?;
        let way = |k: usize| positions[k] - positions[0];
        let rhs: Vec<f64> = (0..TERMS).map(|a| sum(&|k| powers(k)[a] * way(k))).collect();
        let cubic = factor.solve(&rhs);
        let left = sum(&|k| (way(k) - dot(&cubic, &powers(k))).powi(2));
        let per_second = rate_hz / samples;
        Some(Self {
            speed: cubic[1] * per_second,
            variance: factor.inverse_diagonal()[1] * per_second.powi(2),
            left: left / (samples - TERMS as f64),
        })
    }
}

/// A recording cut where its joint stops, without what is too short to be smoothed for itself; nothing if it never
/// does.
fn pieces(rests: &[(usize, usize)], samples: usize, rate_hz: f64) -> Vec<(usize, usize)> {
    let stops = rests.iter().map(|(start, _)| *start).filter(|start| *start > 0);
    let cuts: Vec<usize> = [0].into_iter().chain(stops).chain([samples]).collect();
    if cuts.len() == 2 {
        return Vec::new();
    }
    let least = (LEAST_PIECE_S * rate_hz).max(2.0) as usize;
    cuts.windows(2).map(|c| (c[0], c[1])).filter(|(start, end)| end - start >= least).collect()
}

/// A channel, and how it goes on past the ends of its recording.
pub(crate) struct Series<'a> {
    values: &'a [f64],
    /// sign of its mirror image about a stop: positions keep theirs, speeds change it
    image: f64,
    before: Vec<f64>,
    after: Vec<f64>,
    /// samples to continue by
    margin: usize,
}

impl<'a> Series<'a> {
    /// Continued as is said; by its mirror image where the joint stands.
    pub(crate) fn of(
        values: &'a [f64],
        image: f64,
        goes_on: Continuation,
        stands: [bool; 2],
        low_pass: &ZeroPhaseLowPass,
    ) -> Self {
        let (mut before, margin) = goes_on.past_ends(values, low_pass);
        let after = before.split_off(margin + values.len());
        before.truncate(margin);
        let mut series = Self { values, image, before, after, margin };
        if stands[0] {
            series.before = series.image_before(0);
        }
        if stands[1] {
            series.after = series.image_after(0, values.len() - 1);
        }
        series
    }

    /// What would be before a first sample, were that a mirror.
    fn image_before(&self, first: usize) -> Vec<f64> {
        let last = self.values.len() - 1;
        (1..=self.margin).rev().map(|k| self.image * self.values[(first + k).min(last)]).collect()
    }

    /// What would be behind a mirror, of the samples from a first one on.
    fn image_after(&self, first: usize, mirror: usize) -> Vec<f64> {
        let before = |k: usize| self.values[mirror.saturating_sub(k).max(first)];
        (1..=self.margin).map(|k| self.image * before(k)).collect()
    }

    /// All of it continued, and the number of samples in front.
    pub(crate) fn whole(&self) -> (Vec<f64>, usize) {
        self.piece((0, self.values.len()))
    }

    /// Samples `[start, end)` continued past their ends; a stop is a mirror. Gives the number of samples in front.
    fn piece(&self, (start, end): (usize, usize)) -> (Vec<f64>, usize) {
        let mut all = if start == 0 { self.before.clone() } else { self.image_before(start) };
        let front = all.len();
        all.extend_from_slice(&self.values[start..end]);
        if end == self.values.len() {
            all.extend_from_slice(&self.after);
        } else {
            // the first sample of the rest is the mirror
            all.push(if self.image > 0.0 { self.values[end] } else { 0.0 });
            all.extend(self.image_after(start, end));
        }
        (all, front)
    }
}

fn smooth_piece(
    position: &Series<'_>,
    velocity: Option<&Series<'_>>,
    piece: (usize, usize),
    low_pass: &ZeroPhaseLowPass,
    rate_hz: f64,
) -> SmoothMotion {
    let (position, front) = position.piece(piece);
    let position = low_pass.filter(&position);
    let velocity = match velocity {
        Some(recorded) => low_pass.filter(&recorded.piece(piece).0),
        None => differentiate(&position, rate_hz),
    };
    let inner = front..front + piece.1 - piece.0;
    SmoothMotion {
        acceleration: differentiate(&velocity, rate_hz)[inner.clone()].to_vec(),
        velocity: velocity[inner.clone()].to_vec(),
        position: position[inner].to_vec(),
    }
}

/// Direction of motion, bridged where the speed has no sure sign, and where the joint sticks.
///
/// Between two directions the friction of a stopped joint goes from one level to the other, and a line
/// is the best guess; between two equal ones it gives way in between, but not at once where the joint rests.
pub(crate) fn directions_and_stops(
    velocity: &[f64],
    acceleration: &[f64],
    rests: &[(usize, usize)],
    noise: f64,
    rate_hz: f64,
) -> (Vec<f64>, Vec<bool>) {
    let n = velocity.len();
    let rms = (velocity.iter().map(|v| v * v).sum::<f64>() / n.max(1) as f64).sqrt();
    let threshold = (SIGN_DEVIATIONS * noise).max(SIGN_SHARE * rms);
    let mut velocity = velocity.to_vec();
    let mut resting = vec![false; n];
    for (start, end) in rests {
        velocity[*start..*end].fill(0.0);
        resting[*start..*end].fill(true);
    }
    let mut direction: Vec<f64> =
        velocity.iter().map(|v| if v.abs() >= threshold { v.signum() } else { 0.0 }).collect();
    let bridge = |(start, end): (usize, usize)| {
        let mut within = rests.iter().filter(|(from, to)| *from < end && start < *to);
        let first = within.next();
        let last = within.next_back().or(first);
        Bridge {
            start,
            end,
            before: if start == 0 { 0.0 } else { direction[start - 1] },
            after: if end == n { 0.0 } else { direction[end] },
            rest: first.zip(last).map(|(first, last)| (first.0.max(start), last.1.min(end))),
        }
    };
    let bridges: Vec<Bridge> = spells(&velocity, threshold).into_iter().map(bridge).collect();
    let turning_speed = turning_speed(&bridges, acceleration, rate_hz);
    for bridge in &bridges {
        bridge.cross(&mut direction, acceleration, turning_speed, rate_hz);
    }
    let mut stuck = resting;
    for (start, end) in spells(&velocity, threshold.max(STICK_SHARE * rms)) {
        if (end - start) as f64 >= STICK_S * rate_hz {
            stuck[start..end].fill(true);
        }
    }
    (direction, stuck)
}

/// Samples in which the speed has no sure sign, `[start, end)`, the directions before and after, and the rest within.
struct Bridge {
    start: usize,
    end: usize,
    before: f64,
    after: f64,
    rest: Option<(usize, usize)>,
}

impl Bridge {
    fn turns(&self) -> bool {
        self.before * self.after < 0.0
    }

    /// Sets the directions in between.
    fn cross(
        &self,
        direction: &mut [f64],
        acceleration: &[f64],
        turning_speed: Option<f64>,
        rate_hz: f64,
    ) {
        let Self { before, after, .. } = *self;
        // where the joint rests, and only there, friction is no longer that of before, not yet that of after
        let (start, end) = self.rest.unwrap_or((self.start, self.end));
        direction[self.start..start].fill(before);
        direction[end..self.end].fill(after);
        let length = (end - start + 1) as f64;
        let dip = match self.rest {
            Some(_) => (REST_DIP_S * rate_hz).min(length),
            None => (DIP_S * rate_hz).max(1.0),
        };
        let pushed_back = (self.rest)
            .zip(turning_speed)
            .filter(|_| before * after > 0.0 && length < HELD_S * rate_hz)
            .map(|(rest, speed)| reference_speed(rest, acceleration, rate_hz).map(|v| v / speed));
        for (t, direction) in direction.iter_mut().enumerate().take(end).skip(start) {
            let (from_start, to_end) = ((t - start + 1) as f64, (end - t) as f64);
            let x = from_start / length;
            let between = if self.turns() {
                before + (after - before) * x
            } else if let Some([rising, falling]) = pushed_back {
                before + 2.0 * (rising * x * (1.0 - x).powi(2) - falling * x * x * (1.0 - x))
            } else {
                before * (1.0 - from_start / dip).max(0.0) + after * (1.0 - to_end / dip).max(0.0)
            };
            *direction = between.clamp(-1.0, 1.0);
        }
    }
}

/// Speed by which what the drive follows runs on while friction goes from one level to the other: the acceleration
/// with which a joint came to rest, times the rest, at the median of the rests in which it turned back. The stiffer
/// the drive, the less.
fn turning_speed(bridges: &[Bridge], acceleration: &[f64], rate_hz: f64) -> Option<f64> {
    let turned = bridges.iter().filter(|b| b.turns());
    let mut speeds: Vec<f64> = turned
        .filter_map(|b| b.rest)
        .map(|(start, end)| acceleration[start - 1].abs() * (end - start) as f64 / rate_hz)
        .collect();
    let half = speeds.len() / 2;
    (!speeds.is_empty()).then(|| *speeds.select_nth_unstable_by(half, f64::total_cmp).1)
}

/// What the drive follows while its joint rests goes on with the accelerations of before and after: the two
/// coefficients of its speed, a cubic that is zero at both ends.
fn reference_speed((start, end): (usize, usize), acceleration: &[f64], rate_hz: f64) -> [f64; 2] {
    let length_s = (end - start) as f64 / rate_hz;
    let later = end + (LATER_S * rate_hz).round() as usize;
    let [before, after] = [start.saturating_sub(1), later.min(acceleration.len() - 1)];
    [acceleration[before] * length_s, acceleration[after] * length_s]
}

/// Stretches in which a joint stays at one place though at its accelerations around it would have left: the
/// rests of stick and slip, too short to be seen in a filtered velocity.
fn rests(
    position: &[f64],
    acceleration: &[f64],
    deviation: f64,
    rate_hz: f64,
) -> Vec<(usize, usize)> {
    let resolution = SAME_PLACE_DEVIATIONS * deviation;
    let least = (REST_S * rate_hz).ceil().max(4.0) as usize;
    let around = (AROUND_S * rate_hz).round() as usize;
    let n = position.len();
    let mut found = Vec::new();
    let mut start = 0;
    while start + least <= n {
        let (mut low, mut high) = (position[start], position[start]);
        let mut end = start;
        while end < n {
            low = low.min(position[end]);
            high = high.max(position[end]);
            if high - low > resolution {
                break;
            }
            end += 1;
        }
        if end - start < least {
            start += 1;
            continue;
        }
        let near = &acceleration[start.saturating_sub(around)..(end + around).min(n)];
        let square = near.iter().map(|a| a * a).sum::<f64>() / near.len() as f64;
        // turning back at that acceleration in the middle of the stretch
        let turned = square.sqrt() * ((end - start) as f64 / rate_hz).powi(2) / 8.0;
        let window = &position[start.saturating_sub(around)..(end + around).min(n)];
        if turned > FAR * resolution && !is_smooth(window, SMOOTH_DEVIATIONS * deviation) {
            found.push((start, end));
        }
        start = end;
    }
    found
}

/// Whether a quartic leaves no more than that.
fn is_smooth(position: &[f64], noise: f64) -> bool {
    let n = position.len();
    let Some(quartics) = Quartics::of_length(n, 0.0) else { return true };
    let quartic = quartics.through(position);
    let squares = position.iter().enumerate().map(|(k, q)| (q - quartic(k as f64)).powi(2));
    squares.sum::<f64>() <= (n - QUARTIC_TERMS) as f64 * noise * noise
}

/// Stretches of samples with a speed below a threshold.
fn spells(velocity: &[f64], threshold: f64) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = None;
    for (t, v) in velocity.iter().enumerate() {
        match (v.abs() < threshold || threshold == 0.0, start) {
            (true, None) => start = Some(t),
            (false, Some(from)) => {
                found.push((from, t));
                start = None;
            }
            _ => {}
        }
    }
    found.extend(start.map(|from| (from, velocity.len())));
    found
}

/// What a drive gives, or the acceleration that this answers: it does not jump where its joint stops, but goes on in a line
/// while the joint rests.
pub(crate) fn held(values: &[f64], rests: &[(usize, usize)], rate_hz: f64) -> Vec<f64> {
    let mut held = values.to_vec();
    for &(start, end) in rests.iter().filter(|(start, _)| *start > 0) {
        let more = values[start - 1] - values[start];
        let length = ((end - start + 1) as f64).min(HELD_S * rate_hz);
        for (k, held) in held[start..end].iter_mut().enumerate() {
            *held += more * (1.0 - (k + 1) as f64 / length).max(0.0);
        }
    }
    held
}

/// A low-pass that leaves what jumps where a joint stops as it is.
pub(crate) fn filter_between(
    values: &[f64],
    rests: &[(usize, usize)],
    low_pass: &ZeroPhaseLowPass,
    rate_hz: f64,
) -> Vec<f64> {
    let margin = (MIRRORED_S * rate_hz).round() as usize;
    // the filter has its own way past the ends of a recording
    let series = Series { values, image: 1.0, before: Vec::new(), after: Vec::new(), margin };
    let mut smooth = low_pass.filter(values);
    for (start, end) in pieces(rests, values.len(), rate_hz) {
        let (all, front) = series.piece((start, end));
        let filtered = low_pass.filter(&all);
        smooth[start..end].copy_from_slice(&filtered[front..front + end - start]);
    }
    smooth
}

/// The least that successive samples differ by, if they do.
pub(crate) fn least_step(position: &[f64]) -> f64 {
    let steps = position.windows(2).map(|p| (p[1] - p[0]).abs()).filter(|step| *step > 0.0);
    steps.reduce(f64::min).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::kinematics_filter;

    const RATE_HZ: f64 = 400.0;

    /// Slows down at 3 rad/s2, rests from 0.5 s for as long as is said, and breaks away with an acceleration that grows from
    /// nothing, back or on the same way.
    fn stopping(rest_s: f64, way: f64) -> Vec<f64> {
        let position = |t: f64| {
            let later = (t - 0.5 - rest_s).max(0.0);
            -1.5 * (0.5 - t).max(0.0).powi(2) - way * 5.0 * later.powi(3)
        };
        (0..600).map(|k| position(f64::from(k) / RATE_HZ)).collect()
    }

    fn channels(position: &[f64]) -> Channels<'_> {
        let goes_on = Continuation::of(position, 2, &kinematics_filter(RATE_HZ).unwrap());
        let (goes_on, stands) = ([goes_on; 2], [false; 2]);
        Channels { position, velocity: None, step: 0.0, rate_hz: RATE_HZ, goes_on, stands }
    }

    /// Up to the last sample before a stop the acceleration is what it was, at the rest there is none; a filter over
    /// all of it is half off at the stop.
    #[test]
    fn a_stop_keeps_its_acceleration() {
        let position = stopping(0.1, 1.0);
        let low_pass = kinematics_filter(RATE_HZ).unwrap();
        let blurred = channels(&position).smooth(&low_pass);
        let rests = channels(&position).rests(&blurred.acceleration, 1e-6);
        let &[(start, end)] = rests.as_slice() else { panic!("{rests:?}") };
        assert!((199..=201).contains(&start) && (240..=247).contains(&end), "{rests:?}");
        let whole = channels(&position).smooth(&low_pass);
        let sharp = channels(&position).smooth_between(&rests, &low_pass, whole);
        let before = start - 1;
        assert!((sharp.acceleration[before] + 3.0).abs() < 0.15, "{}", sharp.acceleration[before]);
        assert!(
            (blurred.acceleration[before] + 3.0).abs() > 0.8,
            "{}",
            blurred.acceleration[before]
        );
        assert!(sharp.acceleration[start + 3..end - 10].iter().all(|a| a.abs() < 0.1));
        let held = held(&sharp.acceleration, &rests, RATE_HZ);
        let middle = usize::midpoint(start, end);
        assert!((held[middle] + 1.5).abs() < 0.15, "{}", held[middle]);
        assert_eq!(held[end..], sharp.acceleration[end..]);
    }

    /// Joints that are off at once start at rest; the same motion cut out of its middle does not.
    #[test]
    fn a_sudden_start_is_one_from_rest() {
        const STEP: f64 = 1e-5;
        // 0.3 rad/s within some 10 ms, and a sine beside
        let position =
            |t: f64| 0.3 * (t - 0.01 * (1.0 - (-t / 0.01).exp())) + 0.2 * (1.0 - (2.0 * t).cos());
        let arm_from = |start_s: f64| -> Vec<Vec<f64>> {
            let of = |j: usize| {
                let at = |k: usize| (1.0 + 0.3 * j as f64) * position(start_s + k as f64 / RATE_HZ);
                (0..2000).map(|k| (at(k) / STEP).round() * STEP).collect()
            };
            (0..3).map(of).collect()
        };
        let rests = |positions: Vec<Vec<f64>>| {
            let joints: Vec<Channels<'_>> = positions.iter().map(|q| channels(q)).collect();
            starts_at_rest(&joints, &[STEP / 12.0_f64.sqrt(); 3])
        };
        assert!(rests(arm_from(0.0)));
        assert!(!rests(arm_from(0.02)));
        assert!(!rests(arm_from(1.0)));
    }

    /// While a joint rests and turns back its friction reverses in a line. Where it goes on the same way, friction gives
    /// way as far as what the drive follows runs back meanwhile: nothing to speak of for a soft drive, whose joint
    /// turned back in a longer rest.
    #[test]
    fn friction_of_a_joint_that_rests() {
        let joined = |turning_s: f64| -> Vec<f64> {
            let (turns, goes_on) = (stopping(turning_s, 1.0), stopping(0.1, -1.0));
            let offset = turns[599] - goes_on[0];
            // the end of the first and the start of the second move fast and differently: cut there
            turns.iter().copied().chain(goes_on.iter().map(|q| q + offset)).collect()
        };
        let middles = |turning_s: f64| -> [f64; 2] {
            let position = joined(turning_s);
            let low_pass = kinematics_filter(RATE_HZ).unwrap();
            let motion = channels(&position).smooth(&low_pass);
            let rests = channels(&position).rests(&motion.acceleration, 1e-6);
            assert_eq!(rests.len(), 2, "{rests:?}");
            let motion = channels(&position).smooth_between(&rests, &low_pass, motion);
            let SmoothMotion { velocity, acceleration, .. } = &motion;
            let (direction, stuck) =
                directions_and_stops(velocity, acceleration, &rests, 1e-6, RATE_HZ);
            [0, 1].map(|k| {
                let middle = usize::midpoint(rests[k].0, rests[k].1);
                assert!(stuck[middle]);
                direction[middle]
            })
        };
        let [turned, goes_on] = middles(0.02);
        assert!(turned.abs() < 0.3 && goes_on < 0.0, "{turned} {goes_on}");
        let [turned, goes_on] = middles(0.29);
        assert!(turned.abs() < 0.05 && goes_on > 0.7, "{turned} {goes_on}");
    }

    /// Holds of 25 ms between slides of 60 ms are found; the smooth reversals of a sine are not rests.
    #[test]
    fn holds_between_slides_are_rests() {
        const RATE_HZ: f64 = 400.0;
        let slides = |t: f64| {
            let (cycle, phase) = ((t / 0.085).floor(), t % 0.085);
            let x = ((phase - 0.025) / 0.06).max(0.0);
            0.02 * (cycle + x * x * (3.0 - 2.0 * x))
        };
        let twice = |values: &[f64]| -> Vec<f64> {
            let second = |w: &[f64]| (w[2] - 2.0 * w[1] + w[0]) * RATE_HZ * RATE_HZ;
            let inner = values.windows(3).map(second);
            std::iter::once(0.0).chain(inner).chain([0.0]).collect()
        };
        let sampled = |of: &dyn Fn(f64) -> f64| -> Vec<f64> {
            (0..800).map(|k| of(f64::from(k) / RATE_HZ)).collect()
        };
        let position = sampled(&slides);
        let found = rests(&position, &twice(&position), 2e-5 / SAME_PLACE_DEVIATIONS, RATE_HZ);
        // 2 s hold 23 of them; the first samples of a slide are still at the place
        assert!((20..=24).contains(&found.len()), "{found:?}");
        assert!(found.iter().all(|(start, end)| (8..=14).contains(&(end - start))), "{found:?}");
        let sine = sampled(&|t: f64| (3.0 * t).sin());
        assert_eq!(rests(&sine, &twice(&sine), 2e-5 / SAME_PLACE_DEVIATIONS, RATE_HZ), []);
        // nor is a speed that touches zero and goes on
        let through = sampled(&|t: f64| 0.4 * (t - 1.0).powi(3) + 0.02 * (t - 1.0).powi(4));
        assert_eq!(rests(&through, &twice(&through), 1e-5, RATE_HZ), []);
        // a joint at rest is none of stick and slip either
        assert_eq!(rests(&[0.5; 800], &[0.0; 800], 2e-5 / SAME_PLACE_DEVIATIONS, RATE_HZ), []);
    }
}
