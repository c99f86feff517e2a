//! Single values that jump away from their channel and back: glitches, outliers and drop-outs.

use armident_numeric::{order_statistic, range};

/// A value is judged by the median of so many around it, which two bad ones do not move, ...
const WINDOW: usize = 5;
/// ... and by the middle of the values as far before as behind, for so many distances: a motion cancels in it.
const PAIRS: usize = 3;
/// Samples to either side that show how the channel usually moves there.
const AROUND: usize = 10;
/// A spike is so many median differences of samples to the middle of their neighbours away from it: of white noise 6
/// standard deviations. At least it is so many counts of a coarse channel away.
const FAR: f64 = 8.0;
/// Of quiet times so much of the median of the whole channel counts.
const QUIET: f64 = 0.75;
/// A spike is so many median steps away from the median of the window: where a motion or a step goes on it is 2 at most.
const FAR_STEPS: f64 = 4.0;
/// Quantile of the steps that are no repetition, which is one count of a coarse channel.
const COUNT_QUANTILE: f64 = 0.1;
/// Share of a channel above which spikes are how it is, and no exception.
const MOST: f64 = 0.02;
/// Share of a quick joint's steps (its 90 % quantile) below which it may rest or reverse: there friction may jump and
/// return within a sample.
const SLOW_SHARE: f64 = 0.05;
/// A joint that is slow for so many samples before and behind is at rest: it does not reverse.
const RESTING: usize = 5;
/// Noise of an effort, as a share of its range, from which on a jump at rest is a spike nevertheless.
const NOISY_SHARE: f64 = 1e-4;
/// Samples within which joints feel one event, and how many do: as many outliers by accident are rare.
const EVENT: usize = 3;
const EVENT_JOINTS: usize = 3;
/// Longest drop-out that is interpolated in rows: as the longest gap that a cubic bridges.
const LONGEST_DROP: usize = 10;
/// Both sides of a drop-out are above this quantile of the sizes that are not 0: a channel with a dead zone has no values
/// between it and 0.
const ABOVE_DEAD_ZONE: f64 = 0.2;

/// Samples of a position that are spikes, increasing.
pub(crate) fn glitches(position: &[f64]) -> Vec<usize> {
    few(spikes(position, |_, _| true), position.len())
}

/// Without spikes of a physical event: joints of an arm feel it together, within a few samples but not in one row as a bus
/// error has it. `spikes[channel]` increase.
pub(crate) fn without_events(spikes: &mut [Vec<usize>]) {
    let all = spikes.to_vec();
    let near = |k: usize| {
        let of_channel = |spikes: &Vec<usize>| {
            let first = spikes.partition_point(|other| other + EVENT < k);
            spikes[first..].iter().copied().take_while(|other| *other <= k + EVENT).collect()
        };
        all.iter().map(of_channel).filter(|near: &Vec<usize>| !near.is_empty()).collect::<Vec<_>>()
    };
    let is_event = |k: usize| {
        let near = near(k);
        near.len() >= EVENT_JOINTS && near.iter().flatten().any(|other| *other != k)
    };
    for channel in spikes {
        channel.retain(|k| !is_event(*k));
    }
}

/// Samples of an effort that are spikes, increasing; `position` is that of its joint, if there is one.
pub(crate) fn outliers(effort: &[f64], position: Option<&[f64]>) -> Vec<usize> {
    let range = range(effort);
    let n = effort.len();
    let moves = moving(position, n);
    let at_rest =
        |k: usize| (k.saturating_sub(RESTING)..(k + RESTING + 1).min(n)).all(|i| !moves(i));
    let found = spikes(effort, |k, noise| moves(k) || (noise >= NOISY_SHARE * range && at_rest(k)));
    few(found, effort.len())
}

/// Runs (first and last sample) in which an effort is exactly 0 while the joint moves and the effort before and after is not.
pub(crate) fn drop_outs(effort: &[f64], position: Option<&[f64]>) -> Vec<(usize, usize)> {
    let mut sizes: Vec<f64> = effort.iter().map(|e| e.abs()).filter(|e| *e > 0.0).collect();
    let place = (ABOVE_DEAD_ZONE * sizes.len() as f64) as usize;
    let (Some(above), Some(position), Some(count)) =
        (order_statistic(&mut sizes, place), position, count_of(effort))
    else {
        return Vec::new();
    };
    let moves = moving(Some(position), effort.len());
    let mut runs = Vec::new();
    let mut k = 1;
    while k < effort.len() {
        if effort[k] != 0.0 {
            k += 1;
            continue;
        }
        let first = k;
        while k < effort.len() && effort[k] == 0.0 {
            k += 1;
        }
        if k == effort.len() || k - first > LONGEST_DROP {
            continue;
        }
        let (before, after) = (effort[first - 1], effort[k]);
        let least = before.abs().min(after.abs());
        let largest = before.abs().max(after.abs());
        let goes_on = before * after > 0.0 && largest - least < 0.5 * largest;
        let is_far = least > above.max(FAR * count).max(FAR_STEPS * usual_step(effort, first));
        if goes_on && is_far && (first..k).all(&moves) {
            runs.push((first, k - 1));
        }
    }
    // of a channel that is often 0 in motion it is no exception
    let zeros = (0..effort.len()).filter(|k| effort[*k] == 0.0 && moves(*k)).count();
    if zeros as f64 > MOST * effort.len() as f64 { Vec::new() } else { runs }
}

/// Whether a joint moves at a sample; everywhere if its position is not recorded. At the ends its step to the one neighbour shows it:
/// a joint that reverses there has a jump of friction, too.
fn moving(position: Option<&[f64]>, samples: usize) -> impl Fn(usize) -> bool {
    let speed = |k: usize| {
        let at = |k: usize| position?.get(k).copied();
        let step = |from: Option<f64>, to: Option<f64>| Some((to? - from?).abs());
        let (before, here, behind) = (k.checked_sub(1).and_then(at), at(k), at(k + 1));
        step(before, behind)
            .or_else(|| step(before, here).or_else(|| step(here, behind)).map(|step| 2.0 * step))
    };
    let speeds: Vec<Option<f64>> = (0..samples).map(speed).collect();
    let mut known: Vec<f64> = speeds.iter().copied().flatten().collect();
    let place = known.len() * 9 / 10;
    let quick = order_statistic(&mut known, place).unwrap_or(0.0);
    move |k| speeds[k].is_none_or(|speed| speed > SLOW_SHARE * quick)
}

fn few(found: Vec<usize>, samples: usize) -> Vec<usize> {
    if found.len() as f64 > MOST * samples as f64 { Vec::new() } else { found }
}

/// Spikes at samples that are judged, given the noise around them.
fn spikes(values: &[f64], is_judged: impl Fn(usize, f64) -> bool) -> Vec<usize> {
    let n = values.len();
    let Some(count) = count_of(values).filter(|_| n > 2 * AROUND) else { return Vec::new() };
    let off: Vec<f64> = (0..n).map(|k| off_neighbours(values, k)).collect();
    let middle = n / 2;
    let of_all = order_statistic(&mut off.clone(), middle).unwrap_or(0.0);
    let is_spike = |k: &usize| {
        if off[*k] <= FAR * count.max(QUIET * of_all) {
            return false;
        }
        // at the ends the window does not lie around the sample
        let from = k.saturating_sub(WINDOW / 2).min(n - WINDOW);
        let mut near: [f64; WINDOW] = std::array::from_fn(|i| values[from + i]);
        near.sort_unstable_by(f64::total_cmp);
        let off_median = (values[*k] - near[WINDOW / 2]).abs();
        let mut around = off[k.saturating_sub(AROUND)..(k + AROUND + 1).min(n)].to_vec();
        let middle = around.len() / 2;
        let noise = order_statistic(&mut around, middle).unwrap_or(0.0);
        off[*k] > FAR * noise
            && off_median > (FAR_STEPS * usual_step(values, *k)).max(FAR * count)
            && is_judged(*k, noise)
    };
    (0..n).filter(is_spike).collect()
}

/// Distance of a sample to the middle of its neighbours: the median over pairs as far before as behind. Of the first and the last
/// sample half their distance to the line through two samples, one twice as far as the other: white noise makes as much of it.
fn off_neighbours(values: &[f64], at: usize) -> f64 {
    let last = values.len() - 1;
    let to_line = |near: usize, far: usize| 0.5 * (values[at] - 2.0 * values[near] + values[far]);
    let pair = |m: usize| match at {
        0 => Some(to_line(m, 2 * m)),
        _ if at == last => Some(to_line(last - m, last - 2 * m)),
        _ => {
            let (before, behind) = (values[at.checked_sub(m)?], values.get(at + m)?);
            Some(values[at] - 0.5 * (before + behind))
        }
    };
    let mut off: Vec<f64> = (1..=PAIRS).filter_map(pair).collect();
    off.sort_unstable_by(f64::total_cmp);
    // of two the smaller: one of them may be of a bad sample
    match off[..] {
        [] => 0.0,
        [one] => one.abs(),
        [a, b] => a.abs().min(b.abs()),
        _ => off[off.len() / 2].abs(),
    }
}

/// Median step around a sample.
fn usual_step(values: &[f64], at: usize) -> f64 {
    let (from, to) = (at.saturating_sub(AROUND), (at + AROUND).min(values.len() - 1));
    let mut steps: Vec<f64> =
        values[from..=to].windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let middle = steps.len() / 2;
    order_statistic(&mut steps, middle).unwrap_or(0.0)
}

/// The smallest usual step of a channel; none if it is constant.
fn count_of(values: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = (values.windows(2).map(|pair| (pair[1] - pair[0]).abs()))
        .filter(|step| *step > 0.0)
        .collect();
    let place = (COUNT_QUANTILE * steps.len() as f64) as usize;
    order_statistic(&mut steps, place)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(n: usize) -> Vec<f64> {
        let mut state = 5_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as f64 / (1_u64 << 31) as f64
        };
        (0..n).map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0).collect()
    }

    fn swing(n: usize, step: f64) -> Vec<f64> {
        let motion = |t: f64| 0.7 * (0.05 * t).sin() + 0.2 * (0.31 * t).cos();
        (0..n)
            .map(|k| motion(k as f64))
            .map(|q| if step > 0.0 { (q / step).round() * step } else { q })
            .collect()
    }

    #[test]
    fn single_values_that_jump_away_are_found() {
        for step in [0.0, 1e-5, 2e-3] {
            let mut position = swing(2000, step);
            for (k, off) in [(40, 2.6), (41, -0.9), (700, 1.4), (1900, -3.0)] {
                position[k] += off;
            }
            assert_eq!(glitches(&position), [40, 41, 700, 1900]);
        }
        // in the first and last rows too, one at a time
        for k in [0, 1, 2, 1997, 1998, 1999] {
            let mut position = swing(2000, 1e-5);
            position[k] -= 1.9;
            assert_eq!(glitches(&position), [k]);
        }
        let mut effort: Vec<f64> =
            noise(4000).iter().zip(swing(4000, 0.0)).map(|(e, q)| 0.2 * e + 10.0 * q).collect();
        effort[77] += 5.0;
        effort[3000] -= 4.0;
        assert_eq!(outliers(&effort, Some(&swing(4000, 0.0))), [77, 3000]);
    }

    #[test]
    fn motion_rest_reversals_and_noise_are_no_spikes() {
        let saw: Vec<f64> = (0..900).map(|k| (k % 60 - 30_i32).abs().into()).collect();
        let square: Vec<f64> = (0..900).map(|k| if k % 50 < 25 { 0.0 } else { 4.0 }).collect();
        let counts: Vec<f64> = (0..900).map(|k| if k % 97 == 0 { 1e-4 } else { 0.0 }).collect();
        let mut starts = vec![0.0; 300];
        starts.extend((0..300).map(|k| 1e-4 * f64::from(k * k)));
        for (values, what) in [
            (swing(2000, 0.0), "motion"),
            (swing(2000, 1e-3), "coarse motion"),
            (noise(50_000), "noise"),
            (saw, "reversals"),
            (square, "steps"),
            (counts, "one count at rest"),
            (starts, "start from rest"),
            (vec![1.0; 300], "constant"),
            (vec![], "nothing"),
        ] {
            assert!(glitches(&values).is_empty(), "{what}");
            assert!(outliers(&values, None).is_empty(), "{what}");
        }
        // friction that is gone for the one sample at which an exact motion stands
        let position: Vec<f64> = (-300..300).map(|k| f64::from(k).powi(3)).collect();
        let mut effort: Vec<f64> = (0..600).map(|k| 4.0 + 1e-3 * f64::from(k)).collect();
        effort[300] -= 2.0;
        assert!(outliers(&effort, Some(&position)).is_empty());
    }

    #[test]
    fn events_that_several_joints_feel_stay() {
        let mut spikes = vec![vec![10, 50, 90], vec![12, 50], vec![11, 50], vec![200]];
        without_events(&mut spikes);
        assert_eq!(spikes, [vec![50, 90], vec![50], vec![50], vec![200]]);
    }

    #[test]
    fn drop_outs_are_not_dead_zones_or_dwells() {
        let position = swing(2000, 0.0);
        let full: Vec<f64> =
            swing(2000, 0.0).iter().zip(noise(2000)).map(|(q, e)| 10.0 * q + 0.02 * e).collect();
        let mut dropped = full.clone();
        let loud = |k: &usize| full[*k].abs() > 5.0;
        let rows: Vec<usize> =
            (100..2000).step_by(400).filter_map(|k| (k..k + 300).find(loud)).collect();
        for k in &rows {
            dropped[*k..k + 3].fill(0.0);
        }
        let found = drop_outs(&dropped, Some(&position));
        assert_eq!(found, rows.iter().map(|k| (*k, k + 2)).collect::<Vec<_>>());
        assert!(found.len() >= 4);
        assert!(drop_outs(&full, Some(&position)).is_empty());
        assert!(drop_outs(&dropped, Some(&vec![0.4; 2000])).is_empty());
        let dead: Vec<f64> = full.iter().map(|e| if e.abs() < 3.0 { 0.0 } else { *e }).collect();
        assert!(drop_outs(&dead, Some(&position)).is_empty());
    }
}
