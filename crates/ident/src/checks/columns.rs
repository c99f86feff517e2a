//! What an effort column shows alone, without a model: that it is one number, or has no sign.

use armident_motion::{Motion, RESTING_RANGE};
use armident_recording::Recording;

use super::excitation::activity;

/// Speed of a direction as a share of the RMS speed: below it a joint turns or is at rest.
const SLOW_SHARE: f64 = 0.1;
/// Reversals of a joint in which an effort with a sign would have changed it at least once.
const REVERSALS: usize = 4;
/// Size as a share of the 95 % quantile of the column at which it is near zero, and beyond which it has left it: a
/// magnitude comes down to zero at every change of sign and goes up again.
const NEAR_ZERO: f64 = 0.05;
const FAR_FROM_ZERO: f64 = 0.25;
/// Returns to zero without one value beyond it that are no accident: each is one in two.
const RETURNS: usize = 5;

/// What a column shows alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Alone {
    /// Nothing against it.
    Sound,
    /// One number in each recording.
    Constant(f64),
    /// Never below zero, or never above, though the joint reverses: a magnitude.
    Magnitude {
        /// 1 where it is never below zero, -1 where never above
        side: f64,
        /// times that it came back to zero
        returns: usize,
    },
}

impl Alone {
    /// Whether the column shows nothing of its joint.
    pub(super) fn is_mute(self) -> bool {
        self != Self::Sound
    }
}

/// What the effort columns of `names` show alone.
pub(super) fn alone(recordings: &[Recording], motions: &[Motion], names: &[&str]) -> Vec<Alone> {
    let of = |(j, name): (usize, &&str)| {
        let columns: Vec<&[f64]> = recordings
            .iter()
            .filter_map(|r| r.joint(name)?.effort.as_deref())
            .filter(|c| !c.is_empty())
            .collect();
        let is_constant = |c: &&[f64]| c.iter().all(|x| *x == c[0]);
        match columns.first() {
            None => Alone::Sound,
            Some(first) if columns.iter().all(is_constant) => Alone::Constant(first[0]),
            Some(_) => magnitude(&columns, motions, j),
        }
    };
    let mut all: Vec<Alone> = names.iter().enumerate().map(of).collect();
    // an arm whose columns all have one side, some of which come back to zero: the logger takes signs off
    let moves = |j: usize| activity(motions, j).range >= RESTING_RANGE;
    let is_varied = |j: &usize| moves(*j) && !matches!(all[*j], Alone::Constant(_));
    let varied: Vec<usize> = (0..names.len()).filter(is_varied).collect();
    let is_magnitude = |j: &usize| matches!(all[*j], Alone::Magnitude { .. });
    let columns =
        |j: usize| recordings.iter().filter_map(move |r| r.joint(names[j])?.effort.as_deref());
    let one_sided =
        |j: &usize| side_of(&columns(*j).collect::<Vec<_>>()).is_some_and(|side| side > 0.0);
    if varied.iter().filter(|j| is_magnitude(j)).count() > 1 && varied.iter().all(one_sided) {
        for j in varied {
            if all[j] == Alone::Sound {
                all[j] = Alone::Magnitude { side: 1.0, returns: 0 };
            }
        }
    }
    all
}

/// The side of zero on which all values are; none where both are.
fn side_of(columns: &[&[f64]]) -> Option<f64> {
    let has = |side: f64| columns.iter().any(|c| c.iter().any(|x| side * x > 0.0));
    match (has(1.0), has(-1.0)) {
        (true, false) => Some(1.0),
        (false, true) => Some(-1.0),
        _ => None,
    }
}

/// The motion with numbers without meaning instead of constant efforts: least squares of a column that is explained to the
/// last digit have no noise level. Nothing is reported of these columns but that they are constant.
pub(super) fn with_stand_ins(motion: &Motion, alone: &[Alone]) -> Motion {
    let mut filled = motion.clone();
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let noise: Vec<f64> = (0..motion.len()).map(|k| (golden * k as f64).fract() - 0.5).collect();
    let mut filtered = vec![noise.clone()];
    motion.filter_columns(&mut filtered);
    for (j, _) in alone.iter().enumerate().filter(|(_, a)| matches!(a, Alone::Constant(_))) {
        for (efforts, with) in
            [(&mut filled.effort, &noise), (&mut filled.effort_filtered, &filtered[0])]
        {
            if let Some(efforts) = efforts {
                efforts[j].clone_from(with);
            }
        }
    }
    filled
}

fn magnitude(columns: &[&[f64]], motions: &[Motion], joint: usize) -> Alone {
    let Some(side) = side_of(columns) else { return Alone::Sound };
    let moves = activity(motions, joint).range >= RESTING_RANGE;
    let reversals: usize = motions.iter().map(|m| reversals(&m.velocity[joint])).sum();
    if !moves || reversals < REVERSALS {
        return Alone::Sound;
    }
    let mut sizes: Vec<f64> = columns.iter().flat_map(|c| c.iter().map(|x| x.abs())).collect();
    sizes.sort_by(f64::total_cmp);
    let large = sizes[(0.95 * (sizes.len() - 1) as f64) as usize];
    let returns = columns.iter().map(|c| returns_to_zero(c, large)).sum();
    if returns < RETURNS { Alone::Sound } else { Alone::Magnitude { side, returns } }
}

/// Times that a column comes from afar to near zero, and not in one step: that is a sample dropped out.
fn returns_to_zero(column: &[f64], large: f64) -> usize {
    let (mut is_far, mut before, mut count) = (false, 0.0_f64, 0);
    for x in column {
        if x.abs() > FAR_FROM_ZERO * large {
            is_far = true;
        } else if is_far && x.abs() < NEAR_ZERO * large && before.abs() < FAR_FROM_ZERO * large {
            is_far = false;
            count += 1;
        }
        before = *x;
    }
    count
}

/// Changes of the direction of motion.
fn reversals(velocity: &[f64]) -> usize {
    let square = velocity.iter().map(|v| v * v).sum::<f64>() / velocity.len().max(1) as f64;
    let least = SLOW_SHARE * square.sqrt();
    let (mut direction, mut count) = (0.0, 0);
    for v in velocity.iter().filter(|v| v.abs() > least) {
        if direction != 0.0 && v.signum() != direction {
            count += 1;
        }
        direction = v.signum();
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn returns_are_counted_from_afar() {
        let wave: Vec<f64> = (0..400).map(|k| (0.1 * f64::from(k)).sin().abs()).collect();
        assert_eq!(returns_to_zero(&wave, 1.0), 12);
        let offset: Vec<f64> = wave.iter().map(|x| x + 0.2).collect();
        assert_eq!(returns_to_zero(&offset, 1.2), 0);
        let dropped_out: Vec<f64> = (0..400).map(|k| if k % 20 == 0 { 0.0 } else { 1.0 }).collect();
        assert_eq!(returns_to_zero(&dropped_out, 1.0), 0);
    }

    #[test]
    fn reversals_ignore_rest() {
        let wave: Vec<f64> = (0..400).map(|k| (0.1 * f64::from(k)).cos()).collect();
        assert_eq!(reversals(&wave), 13);
        let one_way: Vec<f64> = wave.iter().map(|v| v.max(-0.01)).collect();
        assert_eq!(reversals(&one_way), 0);
    }
}
