//! The batch estimator on a UR5 with friction, rotor inertia and offsets, all of them known.

#![allow(clippy::unwrap_used, reason = "tests")]

mod bench;

use armident_dynamics::inverse_dynamics_of_motion;
use armident_effects::{BASELINE, ReversalModel};
use armident_ident::{
    BatchEstimate, BatchProblem, BatchSettings, ConstantKind, StructureSearch, Term,
    dead_zone_shares, used_samples,
};
use armident_kinematics::InertialParameters;
use armident_model::{ArmModel, DeadZone};
use armident_motion::{Motion, MotionSettings};
use armident_recording::{JointChannels, Recording};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;

use bench::{Bench, Sines};

const SIGNS_ONLY: BatchSettings = BatchSettings { admissible_signs: true, link_prior: None };
const PRIOR_ONLY: BatchSettings = BatchSettings { admissible_signs: false, link_prior: Some(1.0) };
/// Viscous, Coulomb, offset, rotor inertia, per joint.
const EFFECTS: [[f64; 4]; 6] = [
    [12.0, 8.0, 0.5, 0.7],
    [10.0, 9.0, -0.8, 0.9],
    [7.5, 5.0, -1.25, 0.4],
    [1.8, 1.2, 0.1, 0.06],
    [1.6, 1.5, 0.0, 0.05],
    [1.4, 0.9, -0.2, 0.08],
];

impl Bench {
    /// Sums of three sines a joint with exact derivatives, 10 s at 100 Hz, driven by the inverse
    /// dynamics of the URDF, the effects given, and white noise.
    fn motion(&self, effects: &[[f64; 4]; 6], noise: Option<(f64, u64)>) -> Motion {
        let sines = Sines::new(1000, 0.0);
        let Sines { q, dq, ddq, .. } = &sines;
        let mut effort = inverse_dynamics_of_motion(&self.arm, q, dq, ddq);
        let mut random = noise
            .map(|(level, seed)| (Normal::new(0.0, level).unwrap(), Pcg64::seed_from_u64(seed)));
        for (j, [viscous, coulomb, offset, rotor]) in effects.iter().enumerate() {
            for (t, e) in effort[j].iter_mut().enumerate() {
                *e += viscous * dq[j][t] + coulomb * dq[j][t].signum() + offset + rotor * ddq[j][t];
                if let Some((normal, random)) = &mut random {
                    *e += normal.sample(random);
                }
            }
        }
        self.recorded("simulated", &sines, &effort)
    }

    /// True values of all terms: those of the URDF and the effects, merged ones added on.
    fn truth(&self, problem: &BatchProblem, effects: &[[f64; 4]; 6]) -> Vec<f64> {
        let constants = self.set.values(&self.arm.constants());
        // every law of the library has one parameter
        let value = |term: &Term| match *term {
            Term::Constant(k) => constants[k],
            Term::Effect { joint, effect, .. } => effects[joint][effect],
            Term::Shared { .. } | Term::Load { .. } => 0.0,
        };
        let mut truth: Vec<f64> = problem.terms.iter().map(value).collect();
        for merged in &problem.merged {
            for &(k, factor) in &merged.into {
                truth[k] += factor * value(&merged.term);
            }
        }
        truth
    }
}

#[track_caller]
fn assert_close(found: &[f64], expected: &[f64], tolerance: f64) {
    for (k, (f, e)) in found.iter().zip(expected).enumerate() {
        assert!((f - e).abs() <= tolerance * e.abs().max(1.0), "term {k}: {f}, true {e}");
    }
}

#[test]
fn exact_motion_gives_exact_values_with_any_prior() {
    let bench = Bench::new();
    let problem = BatchProblem::new(&bench.arm, &bench.set);
    let rows = problem.accumulate(&[&bench.motion(&EFFECTS, None)]);
    let truth = bench.truth(&problem, &EFFECTS);
    for settings in [BatchSettings::PLAIN, SIGNS_ONLY, PRIOR_ONLY, BatchSettings::default()] {
        let found = problem.estimate_with(&rows, &settings).unwrap();
        assert_eq!(found.rank, problem.terms.len());
        assert_close(&found.values, &truth, 1e-8);
        assert!(found.at_bound.iter().all(|held| !held));
        assert!(found.prior_share.iter().all(|share| *share < 1e-12));
    }
    assert_eq!(
        problem.estimate(&rows).unwrap().values,
        problem.estimate_with(&rows, &BatchSettings::default()).unwrap().values
    );
}

/// The prior is about another arm: the recordings decide.
#[test]
fn wrong_prior_does_not_bias_identified_parameters() {
    let bench = Bench::new();
    let mut wrong = bench.arm.clone();
    for link in &mut wrong.links {
        link.mass_kg *= 1.5;
        link.first_moment_kgm *= 0.5;
    }
    let problem = BatchProblem::new(&wrong, &bench.set);
    let rows = problem.accumulate(&[&bench.motion(&EFFECTS, None)]);
    let found = problem.estimate(&rows).unwrap();
    assert_close(&found.values, &bench.truth(&problem, &EFFECTS), 1e-8);
}

/// A drive that rounds its current to zero looks like a wrist without mass, and without noise.
#[test]
fn dead_zone_channel_does_not_bias_link_inertias() {
    let bench = Bench::new();
    let wrist = 3;
    let sines = Sines::new(1000, 0.0);
    let unrounded = bench.motion(&EFFECTS, Some((0.5, 3)));
    let mut effort = unrounded.effort.unwrap();
    // the last digit is all that is left
    effort[wrist].iter_mut().for_each(|e| *e *= 1e-5);
    let motion = bench.recorded("rounded", &sines, &effort);
    let plain = BatchProblem::new(&bench.arm, &bench.set);
    let truth = bench.truth(&plain, &EFFECTS);
    let worst = |problem: &BatchProblem| -> f64 {
        let found = problem.estimate_with(&problem.accumulate(&[&motion]), &SIGNS_ONLY).unwrap();
        let constants = (0..problem.terms.len())
            .filter(|&k| matches!(problem.terms[k], Term::Constant(_)))
            .map(|k| (found.values[k] - truth[k]).abs() / found.standard_error(k).unwrap());
        constants.fold(0.0, f64::max)
    };
    assert!(worst(&plain) > 100.0, "{}", worst(&plain));
    let down_weighted = plain.with_dead_zones((0..6).map(|joint| joint == wrist).collect());
    assert!(worst(&down_weighted) < 4.0, "{}", worst(&down_weighted));
}

/// The share and offset of a dead zone are estimated from the triangle, predicted sample by sample, and kept in a model
/// file.
#[test]
fn prediction_goes_through_dead_zone() {
    let (share, offset) = (0.08, 0.3);
    let bench = Bench::new();
    let wrist = 3;
    let sines = Sines::new(1000, 0.0);
    let mut effort = bench.motion(&EFFECTS, None).effort.unwrap();
    effort[wrist].iter_mut().for_each(|e| *e = share * *e + offset);
    let motion = bench.recorded("rounded", &sines, &effort);
    let problem = BatchProblem::new(&bench.arm, &bench.set)
        .with_dead_zones((0..6).map(|joint| joint == wrist).collect());
    let rows = problem.accumulate(&[&motion]);
    let truth = bench.truth(&problem, &EFFECTS);
    let dead_zones = problem.dead_zones(&rows, &truth);
    assert_eq!(dead_zones.iter().map(Option::is_some).position(|of| of), Some(wrist));
    let DeadZone { share: found, offset: beside } = dead_zones[wrist].unwrap();
    assert!((found - share).abs() < 1e-9 && (beside - offset).abs() < 1e-9, "{found} {beside}");
    assert!(problem.fit(&rows, &truth)[wrist].relative > 10.0);
    let fit = problem.fit_through_dead_zones(&rows, &truth, &dead_zones);
    assert!(fit.iter().all(|joint| joint.relative < 1e-8), "{fit:?}");

    let names = bench.model.chain.joint_names();
    let model = ArmModel {
        effects: problem.effects(&truth, &names),
        shown: Some(dead_zones),
        ..bench.set.applied_to(bench.model.clone(), &problem.constants(&truth))
    };
    let read = ArmModel::parse(&model.to_json().unwrap(), "model.json").unwrap();
    let predicted = read.predict_motion(&motion).unwrap();
    for (predicted, recorded) in predicted.iter().zip(&effort) {
        for t in used_samples(&motion) {
            assert!((predicted[t] - recorded[t]).abs() < 1e-6, "{} {}", predicted[t], recorded[t]);
        }
    }
    let bare = ArmModel { shown: None, ..model };
    let off = bare.predict_motion(&motion).unwrap()[wrist][500] - effort[wrist][500];
    assert!(off.abs() > 0.1, "{off}");
}

#[test]
fn detects_dead_zone_among_normal_channels() {
    let sines = Sines::new(1000, 0.0);
    let names = ["dead", "live"];
    let of = |dead: [bool; 2]| {
        let channels = (0..2).map(|j| JointChannels {
            position: Some(sines.q[j].clone()),
            effort: Some(sines.q[j].iter().map(|q| if dead[j] { 0.0 } else { *q }).collect()),
            ..JointChannels::new(names[j])
        });
        let recording = Recording::new("log", sines.time_s.clone(), channels.collect()).unwrap();
        dead_zone_shares(&[recording], &names).iter().map(Option::is_some).collect::<Vec<_>>()
    };
    assert_eq!(of([false, false]), [false, false]);
    assert_eq!(of([true, false]), [true, false]);
    // no channel without a dead zone would remain
    assert_eq!(of([true, true]), [false, false]);
}

/// The rotor of joint 1 turns with link 1: one constant.
#[test]
fn first_rotor_inertia_is_merged_into_constant() {
    let bench = Bench::new();
    let problem = BatchProblem::new(&bench.arm, &bench.set);
    let names: Vec<String> =
        bench.model.chain.joint_names().iter().map(|n| (*n).to_owned()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let first = &problem.merged[0];
    assert_eq!(problem.label(&first.term, &names), "rotor_inertia(shoulder_pan_joint)");
    let [(k, factor)] = first.into[..] else { unreachable!("{:?}", first.into) };
    let Term::Constant(constant) = problem.terms[k] else { unreachable!("an effect") };
    let constant = &bench.set.constants[constant];
    assert_eq!((constant.joint, constant.quantity), (0, ConstantKind::U33));
    assert!((factor - 1.0).abs() < 1e-9, "{factor}");
}

#[test]
fn inadmissible_sign_is_held_at_zero_without_error() {
    let bench = Bench::new();
    let problem = BatchProblem::new(&bench.arm, &bench.set);
    let mut effects = EFFECTS;
    effects[3][3] = -0.4; // rotor inertia
    effects[4][1] = -0.5; // Coulomb friction
    effects[4][2] = -0.5; // an offset may be negative
    let rows = problem.accumulate(&[&bench.motion(&effects, Some((0.05, 1)))]);
    let term = |joint, effect| {
        let wanted = Term::Effect { joint, effect, parameter: 0 };
        problem.terms.iter().position(|t| *t == wanted).unwrap()
    };
    let violated = [term(3, 3), term(4, 1)];

    let plain = problem.estimate_with(&rows, &BatchSettings::PLAIN).unwrap();
    assert!(violated.iter().all(|&k| plain.values[k] < -0.1 && plain.standard_error(k).is_some()));
    let held = problem.estimate_with(&rows, &SIGNS_ONLY).unwrap();
    for k in violated {
        assert!(held.at_bound[k] && held.values[k] == 0.0 && held.standard_error(k).is_none());
        assert!((0..problem.terms.len()).all(|j| held.covariance[(k, j)] == 0.0));
    }
    for (k, term) in problem.terms.iter().enumerate() {
        if let Term::Effect { effect, .. } = *term
            && BASELINE[effect].law().slug != "torque_offset"
        {
            assert!(held.values[k] >= 0.0);
        }
        assert_eq!(held.at_bound[k], held.standard_error(k).is_none());
    }
    assert!(held.values[term(4, 2)] < -0.1);
    assert_eq!(held.rank, plain.rank);

    // the bounds are the best ones: no residual falls along an admissible direction
    let weighted = |values: &[f64]| -> f64 {
        let fits = problem.fit(&rows, values);
        fits.iter().zip(&held.effort_noise).map(|(f, s)| (f.rmse / s).powi(2)).sum()
    };
    let best = weighted(&held.values);
    for k in 0..problem.terms.len() {
        for step in [-1e-4, 1e-4] {
            if held.at_bound[k] && step < 0.0 {
                continue;
            }
            let mut values = held.values.clone();
            values[k] += step;
            assert!(weighted(&values) >= best * (1.0 - 1e-9), "term {k} by {step}");
        }
    }
}

#[test]
fn inactive_bounds_change_no_bit() {
    let bench = Bench::new();
    let problem = BatchProblem::new(&bench.arm, &bench.set);
    let rows = problem.accumulate(&[&bench.motion(&EFFECTS, Some((0.02, 7)))]);
    let plain = problem.estimate_with(&rows, &BatchSettings::PLAIN).unwrap();
    let bound = problem.estimate_with(&rows, &SIGNS_ONLY).unwrap();
    assert!(bound.at_bound.iter().all(|held| !held));
    assert_eq!(plain.values, bound.values);
    assert_eq!(plain.effort_noise, bound.effort_noise);
    assert_eq!(plain.covariance, bound.covariance);
}

/// A motion of one joint does not identify the others' constants: they equal the prior then, with its large
/// standard error.
#[test]
fn unidentified_parameters_equal_prior() {
    let bench = Bench::new();
    let problem = BatchProblem::new(&bench.arm, &bench.set);
    let whole = bench.motion(&EFFECTS, Some((0.05, 3)));
    let mut still = whole.clone();
    for joint in 0..5 {
        still.position[joint].fill(0.3);
        still.velocity[joint].fill(0.0);
        still.acceleration[joint].fill(0.0);
    }
    let rigid = inverse_dynamics_of_motion(
        &bench.arm,
        &still.position,
        &still.velocity,
        &still.acceleration,
    );
    let constants = bench.set.values(&bench.arm.constants());
    // exact or with noise: the prior is right here
    for level in [0.0, 0.05] {
        let normal = Normal::new(0.0, level).unwrap();
        let mut random = Pcg64::seed_from_u64(11);
        let mut with_noise = |e: &f64| e + normal.sample(&mut random);
        let effort = rigid.iter().map(|e| e.iter().map(&mut with_noise).collect()).collect();
        still.effort_filtered = Some(effort);
        let rows = problem.accumulate(&[&still]);
        let found = problem.estimate_with(&rows, &PRIOR_ONLY).unwrap();
        assert!(found.rank < problem.terms.len() - 20, "{}", found.rank);
        for (k, truth) in constants.iter().enumerate() {
            if found.undetermined[k] > 0.999 {
                let off = (found.values[k] - truth).abs();
                assert!(off <= 1e-9 + 0.5 * found.standard_error(k).unwrap(), "{k}: {off}");
            }
        }
        if level > 0.0 {
            let open = (0..constants.len()).filter(|&k| found.prior_share[k] > 0.9).count();
            assert!(open > 10, "{:?}", found.prior_share);
        }
    }
    // the prior share is smaller of a moving arm, and smaller with less noise
    let prior_share = |motion: &Motion| -> f64 {
        let found = problem.estimate_with(&problem.accumulate(&[motion]), &PRIOR_ONLY).unwrap();
        found.prior_share.iter().sum::<f64>() / constants.len() as f64
    };
    let [rests, moves, quiet] = [
        prior_share(&still),
        prior_share(&whole),
        prior_share(&bench.motion(&EFFECTS, Some((5e-4, 3)))),
    ];
    assert!(moves < 0.6 * rests && quiet < 0.1, "{rests} {moves} {quiet}");
}

/// The prior scale is how far the links differ from the URDF.
#[test]
fn prior_scale_tracks_urdf_error() {
    let bench = Bench::new();
    let motion = bench.motion(&EFFECTS, Some((0.05, 3)));
    let prior_scale = |factor: fn(usize) -> f64| {
        let mut described = bench.arm.clone();
        for (k, link) in described.links.iter_mut().enumerate() {
            *link = InertialParameters::from_array(&link.to_array().map(|x| factor(k) * x));
        }
        let mut problem = BatchProblem::new(&described, &bench.set);
        let chosen = problem
            .choose_structure(&[&motion], &BatchSettings::default(), StructureSearch::NOTHING)
            .unwrap();
        chosen.settings.link_prior.unwrap()
    };
    assert!(prior_scale(|_| 1.0) < 0.15, "0.1 is the least that is tried");
    // links heavier and lighter by a share: between a scale at which the density explains it with the shape (0.8 x^2 of ten
    // dimensions) and one at which four of the ten errors of the shape do
    let third = prior_scale(|k| if k % 2 == 0 { 4.0 / 3.0 } else { 2.0 / 3.0 });
    let two_thirds = prior_scale(|k| if k % 2 == 0 { 5.0 / 3.0 } else { 1.0 / 3.0 });
    for (found, share) in [(third, 1.0 / 3.0), (two_thirds, 2.0 / 3.0)] {
        let expected = share * 0.08_f64.sqrt()..share * 0.4_f64.sqrt();
        assert!(expected.contains(&found), "{found} {expected:?}");
    }
}

/// Two joints have friction that grows with the root of their speed: these are found, and no others.
#[test]
fn distinguishes_sublinear_from_linear_viscous_friction() {
    const SUBLINEAR: [(usize, f64); 2] = [(1, 6.0), (3, 1.5)];
    let bench = Bench::new();
    for seed in 0..4 {
        let mut motion = bench.motion(&EFFECTS, Some((0.3, seed)));
        let velocity = motion.velocity.clone();
        let effort = motion.effort_filtered.as_mut().unwrap();
        for (joint, coefficient) in SUBLINEAR {
            let added = velocity[joint].iter().map(|v| coefficient * v / (v.abs() + 1e-3).sqrt());
            effort[joint].iter_mut().zip(added).for_each(|(e, b)| *e += b);
        }
        let mut problem = BatchProblem::new(&bench.arm, &bench.set);
        let baseline = problem.terms.len();
        let search = StructureSearch { couplings: false, sublinear: true };
        let settings = BatchSettings::default();
        let chosen = problem.choose_structure(&[&motion], &settings, search).unwrap();
        let joints: Vec<usize> = chosen.sublinear.iter().map(|found| found.joint).collect();
        assert!(SUBLINEAR.iter().all(|(joint, _)| joints.contains(joint)), "{seed}: {joints:?}");
        // of four others one in forty by chance
        assert!(joints.len() <= SUBLINEAR.len() + 1, "{seed}: {joints:?}");
        let found = problem.estimate(&problem.accumulate(&[&motion])).unwrap();
        assert_eq!(problem.terms.len(), baseline + joints.len());
        for (k, joint) in (baseline..).zip(&joints) {
            let of_joint = SUBLINEAR.iter().find(|(j, _)| j == joint);
            let (value, error) = (found.values[k], found.standard_error(k).unwrap());
            let off = value - of_joint.map_or(0.0, |(_, c)| *c);
            assert!(off.abs() < 4.0 * error, "{seed}, {joint}: {value} +- {error}");
        }
    }
}

/// Of joints with dry friction only, one has presliding friction, the others Coulomb friction; a model file keeps which.
#[test]
fn distinguishes_presliding_from_coulomb_friction() {
    const TRAVELS: usize = 1;
    const TRAVEL_RAD: f64 = 0.01;
    const LEVEL: f64 = 9.0;
    let bench = Bench::new();
    let sines = Sines::new(4000, 0.0);
    let mut effort = inverse_dynamics_of_motion(&bench.arm, &sines.q, &sines.dq, &sines.ddq);
    let mut random = Pcg64::seed_from_u64(7);
    let noise = Normal::new(0.0, 0.05).unwrap();
    for (j, effort) in effort.iter_mut().enumerate() {
        let turn = if j == TRAVELS {
            ReversalModel::presliding(TRAVEL_RAD)
        } else {
            ReversalModel::regularised(0.0)
        };
        let direction = turn.directions(&sines.q[j], &sines.dq[j]);
        let friction = direction.iter().map(|d| LEVEL * d + noise.sample(&mut random));
        effort.iter_mut().zip(friction).for_each(|(e, f)| *e += f);
    }
    let names = bench.model.chain.joint_names();
    let channels = (0..6).map(|j| JointChannels {
        position: Some(sines.q[j].clone()),
        effort: Some(effort[j].clone()),
        ..JointChannels::new(names[j])
    });
    let recording = Recording::new("made", sines.time_s.clone(), channels.collect()).unwrap();
    let motion = Motion::from_recording(&recording, &names, &MotionSettings::default()).unwrap();
    let mut problem = BatchProblem::new(&bench.arm, &bench.set);
    let settings = BatchSettings::default();
    problem.choose_structure(&[&motion], &settings, StructureSearch::NOTHING).unwrap();
    let turns = problem.reversals.clone().unwrap();
    let travels: Vec<usize> =
        (0..6).filter(|&joint| turns[joint].presliding_travel() > 0.0).collect();
    assert_eq!(travels, [TRAVELS], "{turns:?}");
    let travel = turns[TRAVELS].presliding_travel();
    assert!((0.5..2.0).contains(&(travel / TRAVEL_RAD)), "{travel}");

    let found = problem.estimate(&problem.accumulate(&[&motion])).unwrap();
    let model = ArmModel {
        effects: problem.effects(&found.values, &names),
        reversals: Some(turns),
        ..bench.set.applied_to(bench.model.clone(), &problem.constants(&found.values))
    };
    let read = ArmModel::parse(&model.to_json().unwrap(), "model.json").unwrap();
    let read_turn = read.reversals.as_ref().unwrap()[TRAVELS];
    assert!((read_turn.presliding_travel() / travel - 1.0).abs() < 1e-12, "{read_turn:?}");
    let error = |model: &ArmModel| {
        let predicted = &model.predict_motion(&motion).unwrap()[TRAVELS];
        let used = used_samples(&motion);
        let squares =
            used.clone().map(|t| (predicted[t] - effort[TRAVELS][t]).powi(2)).sum::<f64>();
        (squares / used.len() as f64).sqrt()
    };
    let sharp = ArmModel { reversals: None, ..read.clone() };
    assert!(error(&read) < 0.7 * error(&sharp), "{} {}", error(&read), error(&sharp));
}

#[test]
fn intervals_have_nominal_coverage() {
    let bench = Bench::new();
    let problem = BatchProblem::new(&bench.arm, &bench.set);
    let truth = bench.truth(&problem, &EFFECTS);
    let inside = |found: &BatchEstimate| -> (usize, usize) {
        let errors = (0..truth.len()).filter_map(|k| found.standard_error(k).map(|e| (k, e)));
        let hits = errors.map(|(k, e)| (found.values[k] - truth[k]).abs() <= found.quantile_95 * e);
        hits.fold((0, 0), |(hits, all), hit| (hits + usize::from(hit), all + 1))
    };
    let mut pooled = [(0, 0); 3];
    for seed in 0..60 {
        let rows = problem.accumulate(&[&bench.motion(&EFFECTS, Some((0.3, seed)))]);
        let settings = [BatchSettings::PLAIN, PRIOR_ONLY, BatchSettings::default()];
        for (pooled, settings) in pooled.iter_mut().zip(settings) {
            let (hits, all) = inside(&problem.estimate_with(&rows, &settings).unwrap());
            *pooled = (pooled.0 + hits, pooled.1 + all);
        }
    }
    for (hits, all) in pooled {
        let coverage = hits as f64 / all as f64;
        assert!((0.92..=0.98).contains(&coverage), "{coverage} of {all}");
    }
}

/// The samples of a filtered motion, dealt out to any number of accumulators in any order.
#[test]
fn estimate_is_invariant_to_row_partition() {
    let bench = Bench::new();
    let sines = Sines::new(1500, 0.0);
    let effort = inverse_dynamics_of_motion(&bench.arm, &sines.q, &sines.dq, &sines.ddq);
    let exact = bench.recorded("simulated", &sines, &effort);
    let names: Vec<&str> = exact.joints.iter().map(String::as_str).collect();
    let joints = names.iter().zip(&exact.position).zip(&effort).enumerate();
    let channels = joints.map(|(j, ((name, position), effort))| {
        let mut channels = JointChannels::new(*name);
        let noise = |t: usize| 0.02 * ((7 * t * t + 13 * t * j) as f64).sin();
        channels.position = Some(position.clone());
        channels.effort = Some(effort.iter().enumerate().map(|(t, e)| e + noise(t)).collect());
        channels
    });
    let recording = Recording::new("sines", exact.time_s.clone(), channels.collect()).unwrap();
    let settings = MotionSettings { cutoff_hz: Some(6.0), ..MotionSettings::default() };
    let motion = Motion::from_recording(&recording, &names, &settings).unwrap();
    let problem = BatchProblem::new(&bench.arm, &bench.set);
    let whole = problem.estimate(&problem.accumulate(&[&motion])).unwrap();
    let used = used_samples(&motion);
    assert!(motion.filter.is_some() && used.len() > 1000);
    let mut random = Pcg64::seed_from_u64(4);
    for count in [1, 2, 7, 40] {
        let mut cuts: Vec<usize> = (1..count).map(|_| random.random_range(used.clone())).collect();
        cuts.extend([used.start, used.end]);
        cuts.sort_unstable();
        let mut parts: Vec<_> = cuts.windows(2).map(|pair| pair[0]..pair[1]).collect();
        parts.sort_by_key(|part| (part.start * 7919) % 101);
        let mut rows = problem.accumulate_part(&motion, parts[0].clone());
        for part in &parts[1..] {
            rows.merge(&problem.accumulate_part(&motion, part.clone()));
        }
        let merged = problem.estimate(&rows).unwrap();
        for (k, (a, b)) in whole.values.iter().zip(&merged.values).enumerate() {
            let error = whole.standard_error(k).unwrap_or(0.0);
            assert!((a - b).abs() <= 1e-9 * (a.abs() + error), "{count} parts, term {k}: {a} {b}");
        }
        for (a, b) in whole.train.iter().zip(&merged.train) {
            assert!((a.rmse / b.rmse - 1.0).abs() < 1e-9, "{count} parts: {a:?} {b:?}");
        }
    }
}
