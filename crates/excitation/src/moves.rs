//! Parts that are made of moves from rest to rest: friction ladder, static holds, slow reversals.

use crate::clearance::poses;
use crate::information::Columns;
use crate::limits::MotionLimits;
use crate::sweep::Sweep;

/// Speeds of the friction ladder over the speed limit.
const LADDER: [f64; 5] = [0.02, 0.1, 0.3, 0.55, 0.8];
/// Length of one rung of the ladder at most \[s\], and share of the range it takes at most.
const RUNG_S: f64 = 2.0;
const RUNG_RANGE: f64 = 0.5;
/// Poses of the static holds, and how long each is held \[s\].
const POSES: usize = 12;
const HOLD_S: f64 = 1.5;
/// Slow reversals of a joint: how many, over which share of its range, at which share of its speed limit.
const REVERSALS: usize = 3;
const REVERSAL_RANGE: f64 = 0.04;
const REVERSAL_SPEED: f64 = 0.02;
/// Moves between the parts, over the speed limit.
const APPROACH: f64 = 0.3;
/// Still time before and after each part \[s\].
const STILL_S: f64 = 0.5;
/// Speed of moves between poses over the speed limit.
const BETWEEN_POSES: f64 = 0.5;

/// Moves of some joints at one time, and how long all are held afterwards.
#[derive(Debug, Clone)]
pub(crate) struct Segment {
    moves: Vec<(usize, Sweep)>,
    hold_s: f64,
}

impl Segment {
    fn still() -> Self {
        Self { moves: Vec::new(), hold_s: STILL_S }
    }

    fn duration_s(&self) -> f64 {
        self.moves.iter().map(|(_, sweep)| sweep.duration_s()).fold(0.0, f64::max) + self.hold_s
    }
}

/// Segments one after the other.
#[derive(Debug, Clone)]
pub(crate) struct Path {
    segments: Vec<Segment>,
    /// when each begins \[s\], and where the joints are
    begins: Vec<(f64, Vec<f64>)>,
    pub(crate) duration_s: f64,
}

impl Path {
    pub(crate) fn new(start: &[f64], segments: Vec<Segment>) -> Self {
        let (mut at, mut time_s) = (start.to_vec(), 0.0);
        let mut begins = Vec::with_capacity(segments.len());
        for segment in &segments {
            begins.push((time_s, at.clone()));
            time_s += segment.duration_s();
            for (joint, sweep) in &segment.moves {
                at[*joint] = sweep.at(f64::INFINITY)[0];
            }
        }
        Self { segments, begins, duration_s: time_s }
    }

    /// Position, velocity and acceleration of all joints at a time.
    pub(crate) fn state(&self, time_s: f64) -> [Vec<f64>; 3] {
        let which = self.begins.partition_point(|(begin, _)| *begin <= time_s).saturating_sub(1);
        let Some((begin_s, held)) = self.begins.get(which) else {
            return [0; 3].map(|_| Vec::new());
        };
        let zero = vec![0.0; held.len()];
        let mut state = [held.clone(), zero.clone(), zero];
        for (joint, sweep) in &self.segments[which].moves {
            for (column, x) in state.iter_mut().zip(sweep.at(time_s - begin_s)) {
                column[*joint] = x;
            }
        }
        state
    }

    /// The same at many times.
    pub(crate) fn columns(&self, time_s: &[f64]) -> Columns {
        let joints = self.begins.first().map_or(0, |(_, held)| held.len());
        let mut columns: Columns =
            [0, 1, 2].map(|_| vec![Vec::with_capacity(time_s.len()); joints]);
        for &t in time_s {
            for (column, values) in columns.iter_mut().zip(self.state(t)) {
                for (column, x) in column.iter_mut().zip(values) {
                    column.push(x);
                }
            }
        }
        columns
    }
}

/// What moves are made of: limits, the pose they begin and end in, and how far they go about it (1: as far as the ranges).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moves<'a> {
    pub(crate) limits: &'a [MotionLimits],
    pub(crate) home: &'a [f64],
    pub(crate) reach: f64,
}

impl Moves<'_> {
    fn sweep(&self, joint: usize, from: f64, to: f64, share: f64) -> (usize, Sweep) {
        let limits = &self.limits[joint];
        (joint, Sweep::new(from, to, share * limits.velocity, limits))
    }

    /// Room of a joint to both sides of the pose.
    fn room(&self, joint: usize) -> f64 {
        let (limits, home) = (&self.limits[joint], self.home[joint]);
        2.0 * (home - limits.lower).min(limits.upper - home).max(0.0)
    }

    pub(crate) fn ladder(&self) -> Path {
        let mut segments = vec![Segment::still()];
        for (joint, limits) in self.limits.iter().enumerate() {
            let middle = self.home[joint];
            let mut at = middle;
            let mut go = |to: f64, share: f64| {
                let moves = vec![self.sweep(joint, at, to, share)];
                segments.push(Segment { moves, hold_s: STILL_S });
                at = to;
            };
            for share in LADDER {
                let most = (RUNG_RANGE * limits.range()).min(share * limits.velocity * RUNG_S);
                let travel = self.reach * most.min(self.room(joint));
                go(middle - 0.5 * travel, APPROACH);
                go(middle + 0.5 * travel, share);
                go(middle - 0.5 * travel, share);
            }
            go(middle, APPROACH);
        }
        Path::new(self.home, segments)
    }

    pub(crate) fn reversals(&self) -> Path {
        let mut segments = vec![Segment::still()];
        for (joint, limits) in self.limits.iter().enumerate() {
            let travel = (REVERSAL_RANGE * limits.range()).min(self.room(joint));
            let (middle, half) = (self.home[joint], 0.5 * self.reach * travel);
            let mut at = middle;
            for k in 0..=2 * REVERSALS {
                let to = match k {
                    _ if k == 2 * REVERSALS => middle,
                    _ if k % 2 == 0 => middle + half,
                    _ => middle - half,
                };
                let moves = vec![self.sweep(joint, at, to, REVERSAL_SPEED)];
                segments.push(Segment { moves, hold_s: 0.0 });
                at = to;
            }
        }
        segments.push(Segment::still());
        Path::new(self.home, segments)
    }

    /// Poses spread over the ranges; a move that is not free is left out, so that there may be fewer.
    pub(crate) fn holds(&self, is_free: impl Fn(&Path) -> bool) -> Path {
        /// Poses that are tried for each that is held.
        const TRIED: usize = 6;
        let mut at = self.home.to_vec();
        let mut segments = vec![Segment::still()];
        let to_pose = |from: &[f64], to: &[f64]| {
            let moves = (0..to.len()).map(|j| self.sweep(j, from[j], to[j], BETWEEN_POSES));
            Segment { moves: moves.collect(), hold_s: HOLD_S }
        };
        let all = poses(self.limits, 1 + TRIED * POSES);
        for pose in all.into_iter().skip(1) {
            if segments.len() > POSES {
                break;
            }
            let go = to_pose(&at, &pose);
            let back = to_pose(&pose, self.home);
            // from each pose there is a way home
            if is_free(&Path::new(&at, vec![go.clone()])) && is_free(&Path::new(&pose, vec![back]))
            {
                segments.push(go);
                at = pose;
            }
        }
        segments.push(to_pose(&at, self.home));
        Path::new(self.home, segments)
    }
}
