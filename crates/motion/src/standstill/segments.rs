//! A recording cut where its joint stops: what lies between two stops is smooth, and smoothed for itself.

use crate::{EndExtension, ZeroPhaseLowPass, differentiate};

use super::{Channels, SmoothMotion, Standstill};
use crate::decimate::between;

/// Efforts are continued past a stop by so much of their mirror image \[s\].
const MIRRORED_S: f64 = 0.12;
/// What moves less long than this between two stops is not smoothed for itself \[s\].
const LEAST_PIECE_S: f64 = 0.1;

impl Channels<'_> {
    /// Through a low-pass, from one end of the recording to the other.
    pub(crate) fn smooth(&self, low_pass: &ZeroPhaseLowPass) -> SmoothMotion {
        let (position, velocity) = self.series(low_pass);
        smooth_piece(&position, velocity.as_ref(), &Piece::WHOLE, low_pass, self.rate_hz)
    }

    /// What was smoothed as a whole, with what lies between two stops smoothed for itself: a joint that stops is continued
    /// as if it went back the way it came, which keeps its acceleration up to there.
    pub(crate) fn smooth_between(
        &self,
        stops: &[Standstill],
        low_pass: &ZeroPhaseLowPass,
        mut motion: SmoothMotion,
    ) -> SmoothMotion {
        let pieces = pieces(stops, self.position.len(), self.rate_hz);
        if pieces.is_empty() {
            return motion;
        }
        let (position, velocity) = self.series(low_pass);
        for stop in stops.iter().filter(|stop| stop.stops()) {
            let (start, end) = stop.samples();
            let place = position.pivot(stop);
            motion.position[start..end].fill(place);
            motion.velocity[start..end].fill(0.0);
            motion.acceleration[start..end].fill(0.0);
        }
        for piece in pieces {
            let (start, end) = piece.samples(self.position.len());
            let piece = smooth_piece(&position, velocity.as_ref(), &piece, low_pass, self.rate_hz);
            motion.position[start..end].copy_from_slice(&piece.position);
            motion.velocity[start..end].copy_from_slice(&piece.velocity);
            motion.acceleration[start..end].copy_from_slice(&piece.acceleration);
        }
        motion
    }

    fn series(
        &self,
        low_pass: &ZeroPhaseLowPass,
    ) -> (ChannelSeries<'_>, Option<ChannelSeries<'_>>) {
        let of = |values, k: usize, kind| {
            ChannelSeries::of(values, kind, self.extensions[k], self.stands, low_pass)
        };
        let velocity = self.velocity.map(|velocity| of(velocity, 1, Kind::Velocity));
        (of(self.position, 0, Kind::Position), velocity)
    }
}

/// What lies between two stops.
struct Piece {
    after: Option<Standstill>,
    before: Option<Standstill>,
}

impl Piece {
    const WHOLE: Self = Self { after: None, before: None };

    /// Its samples, `[start, end)`, of so many.
    fn samples(&self, all: usize) -> (usize, usize) {
        let start = self.after.map_or(0, |stop| stop.samples().1);
        (start, self.before.map_or(all, |stop| stop.samples().0))
    }
}

/// A recording cut where its joint stops, without what is too short to be smoothed for itself; nothing if it never
/// does.
fn pieces(stops: &[Standstill], samples: usize, rate_hz: f64) -> Vec<Piece> {
    let stops: Vec<Standstill> = stops.iter().copied().filter(Standstill::stops).collect();
    if stops.is_empty() {
        return Vec::new();
    }
    let least = (LEAST_PIECE_S * rate_hz).max(2.0) as usize;
    (0..=stops.len())
        .map(|k| Piece { after: k.checked_sub(1).map(|k| stops[k]), before: stops.get(k).copied() })
        .filter(|piece| {
            let (start, end) = piece.samples(samples);
            end >= start + least
        })
        .collect()
}

/// What a channel is: it says how its image behind a stop looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// Position: mirrored about the standstill.
    Position,
    /// Velocity.
    Velocity,
    /// Effort.
    Effort,
}

impl Kind {
    /// In a motion that goes back the way it came.
    fn mirrored(self, x: f64) -> f64 {
        if self == Self::Velocity { -x } else { x }
    }

    /// In a motion that came from the other side of a pivot.
    fn turned(self, x: f64, pivot: f64) -> f64 {
        if self == Self::Velocity { x } else { 2.0 * pivot - x }
    }
}

/// A channel, and how it goes on past the ends of its recording.
pub struct ChannelSeries<'a> {
    values: &'a [f64],
    kind: Kind,
    before: Vec<f64>,
    after: Vec<f64>,
    /// samples to continue by
    margin: usize,
}

impl<'a> ChannelSeries<'a> {
    /// Continued as is said; by its mirror image where the joint stands.
    pub fn of(
        values: &'a [f64],
        kind: Kind,
        extensions: EndExtension,
        stands: [bool; 2],
        low_pass: &ZeroPhaseLowPass,
    ) -> Self {
        let (mut before, margin) = extensions.past_ends(values, low_pass);
        let after = before.split_off(margin + values.len());
        before.truncate(margin);
        let mut series = Self { values, kind, before, after, margin };
        if stands[0] {
            series.before = series.before(0, 0.0, |x| kind.mirrored(x));
        }
        if stands[1] {
            series.after = series.after(0, values.len(), (values.len() - 1) as f64);
        }
        series
    }

    /// Where a joint rests, or what is recorded where it breaks away.
    fn pivot(&self, stop: &Standstill) -> f64 {
        let (start, end) = stop.samples();
        if self.kind == Kind::Position && start < end {
            self.values[start..end].iter().sum::<f64>() / (end - start) as f64
        } else {
            between(self.values, stop.to)
        }
    }

    /// Images of what is behind a place, for samples in front of one.
    fn before(&self, start: usize, place: f64, image: impl Fn(f64) -> f64) -> Vec<f64> {
        let last = (self.values.len() - 1) as f64;
        let behind = |k: usize| (2.0 * place - start as f64 + k as f64).min(last);
        (1..=self.margin).rev().map(|k| image(between(self.values, behind(k)))).collect()
    }

    /// Mirror images about a place of what is from a first sample on, for samples from `end` on.
    fn after(&self, first: usize, end: usize, place: f64) -> Vec<f64> {
        let in_front = |k: usize| (2.0 * place - (end + k) as f64).max(first as f64);
        let image = |k: usize| self.kind.mirrored(between(self.values, in_front(k)));
        (0..self.margin).map(image).collect()
    }

    /// All of it continued, and the number of samples in front.
    pub fn whole(&self) -> (Vec<f64>, usize) {
        self.piece(&Piece::WHOLE)
    }

    /// A piece continued past its ends. A stop is a mirror to what is before it; what breaks away from a rest starts
    /// without acceleration, and goes on the other way round. Gives the number of samples in front.
    fn piece(&self, piece: &Piece) -> (Vec<f64>, usize) {
        let (start, end) = piece.samples(self.values.len());
        let mut all = match &piece.after {
            None => self.before.clone(),
            Some(stop) if stop.to > stop.from => {
                let pivot = self.pivot(stop);
                self.before(start, stop.to, |x| self.kind.turned(x, pivot))
            }
            Some(turn) => self.before(start, turn.to, |x| self.kind.mirrored(x)),
        };
        let front = all.len();
        all.extend_from_slice(&self.values[start..end]);
        match &piece.before {
            None => all.extend_from_slice(&self.after),
            Some(stop) => all.extend(self.after(start, end, stop.from)),
        }
        (all, front)
    }
}

fn smooth_piece(
    position: &ChannelSeries<'_>,
    velocity: Option<&ChannelSeries<'_>>,
    piece: &Piece,
    low_pass: &ZeroPhaseLowPass,
    rate_hz: f64,
) -> SmoothMotion {
    let (start, end) = piece.samples(position.values.len());
    let (position, front) = position.piece(piece);
    let back = position.len() - front - (end - start);
    let position = low_pass.filter(&position);
    let velocity = match velocity {
        Some(recorded) => low_pass.filter(&recorded.piece(piece).0),
        None => differentiate(&position, rate_hz),
    };
    let inner = front..position.len() - back;
    SmoothMotion {
        acceleration: differentiate(&velocity, rate_hz)[inner.clone()].to_vec(),
        velocity: velocity[inner.clone()].to_vec(),
        position: position[inner].to_vec(),
    }
}

/// A low-pass that leaves what jumps where a joint stops as it is.
pub fn filter_between(
    values: &[f64],
    stops: &[Standstill],
    low_pass: &ZeroPhaseLowPass,
    rate_hz: f64,
) -> Vec<f64> {
    let margin = (MIRRORED_S * rate_hz).round() as usize;
    // the filter has its own way past the ends of a recording
    let series =
        ChannelSeries { values, kind: Kind::Effort, before: Vec::new(), after: Vec::new(), margin };
    let mut smooth = low_pass.filter(values);
    for stop in stops.iter().filter(|stop| stop.stops()) {
        let (start, end) = stop.samples();
        smooth[start..end].copy_from_slice(&values[start..end]);
    }
    for piece in pieces(stops, values.len(), rate_hz) {
        let (all, front) = series.piece(&piece);
        let (start, end) = piece.samples(values.len());
        let filtered = low_pass.filter(&all);
        smooth[start..end].copy_from_slice(&filtered[front..front + end - start]);
    }
    smooth
}
