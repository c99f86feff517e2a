//! `armident check`: recordings as they are have nothing wrong, spoiled copies of them have, and what.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::shared::{project, shared};
use crate::tool::{list, number, run, scratch, string, text};

/// A recording as text columns, to be spoiled.
#[derive(Clone)]
struct Table {
    header: Vec<String>,
    /// by columns; the first is the time
    columns: Vec<Vec<f64>>,
}

impl Table {
    fn read(path: &Path) -> Self {
        let content = std::fs::read_to_string(path).unwrap();
        let mut lines = content.lines();
        let header: Vec<String> = lines.next().unwrap().split(',').map(str::to_owned).collect();
        let mut columns = vec![Vec::new(); header.len()];
        for line in lines {
            for (column, field) in columns.iter_mut().zip(line.split(',')) {
                column.push(field.parse().unwrap());
            }
        }
        Self { header, columns }
    }

    fn write(&self, path: &Path) {
        let mut content = self.header.join(",") + "\n";
        for k in 0..self.columns[0].len() {
            let row: Vec<String> = self.columns.iter().map(|c| c[k].to_string()).collect();
            content += &(row.join(",") + "\n");
        }
        std::fs::write(path, content).unwrap();
    }

    /// Indices of the columns of a quantity, in the order of the file.
    fn of(&self, quantity: &str) -> Vec<usize> {
        (0..self.header.len()).filter(|&k| self.header[k].ends_with(quantity)).collect()
    }

    fn scaled(&self, columns: &[usize], factor: f64) -> Self {
        let mut table = self.clone();
        columns.iter().for_each(|&k| table.columns[k].iter_mut().for_each(|x| *x *= factor));
        table
    }

    /// The samples from one time to another \[s\].
    fn between(&self, from_s: f64, to_s: f64) -> Self {
        let inside = |k: &usize| (from_s..to_s).contains(&self.columns[0][*k]);
        let kept: Vec<usize> = (0..self.columns[0].len()).filter(inside).collect();
        let columns = self.columns.iter().map(|c| kept.iter().map(|&k| c[k]).collect()).collect();
        Self { header: self.header.clone(), columns }
    }

    fn swapped(&self, a: usize, b: usize) -> Self {
        let mut table = self.clone();
        table.columns.swap(a, b);
        table
    }

    /// Efforts that come later by this time.
    fn delayed(&self, delay_s: f64) -> Self {
        self.with_efforts_of(|t| t - delay_s)
    }

    /// Efforts by a clock that is fast by this share, and begins with the recording.
    fn by_fast_clock(&self, drift: f64) -> Self {
        let start_s = self.columns[0][0];
        self.with_efforts_of(|t| t + drift * (t - start_s))
    }

    /// Efforts of another time at every stamp, on straight lines between the samples.
    fn with_efforts_of(&self, time_s: impl Fn(f64) -> f64) -> Self {
        let mut table = self.clone();
        let time = &self.columns[0];
        for k in self.of("/effort") {
            table.columns[k] = time
                .iter()
                .map(|t| {
                    let at = time_s(*t);
                    let after = time.partition_point(|s| *s <= at).clamp(1, time.len() - 1);
                    let share = (at - time[after - 1]) / (time[after] - time[after - 1]);
                    let (a, b) = (self.columns[k][after - 1], self.columns[k][after]);
                    a + share.clamp(0.0, 1.0) * (b - a)
                })
                .collect();
        }
        table
    }

    /// Efforts through a low-pass of first order of this time constant \[s\], on straight lines between the samples.
    fn low_passed(&self, time_constant_s: f64) -> Self {
        let mut table = self.clone();
        for k in self.of("/effort") {
            let (effort, time) = (&self.columns[k], &self.columns[0]);
            for t in 1..effort.len() {
                let steps = (time[t] - time[t - 1]) / time_constant_s;
                let kept = (-steps).exp();
                let of_slope = 1.0 - (1.0 - kept) / steps;
                table.columns[k][t] = kept * table.columns[k][t - 1]
                    + (1.0 - kept) * effort[t - 1]
                    + of_slope * (effort[t] - effort[t - 1]);
            }
        }
        table
    }

    /// Efforts less the gravity part of the URDF: prediction with less prediction without.
    fn without_gravity(&self, urdf: &Path, recording: &Path, folder: &Path) -> Self {
        let predicted = |gravity: &str| {
            let out = folder.join("predicted.csv");
            let mut args =
                vec!["predict", text(urdf), text(recording), "-o", text(&out), "--cutoff-hz", "10"];
            args.extend(["--gravity", gravity]);
            run(&args).fine();
            Self::read(&out)
        };
        let (with, without) = (predicted("0,0,-9.81"), predicted("0,0,0"));
        let mut table = self.clone();
        for (joint, k) in self.of("/effort").into_iter().enumerate() {
            for t in 0..table.columns[k].len() {
                table.columns[k][t] -= with.columns[joint + 1][t] - without.columns[joint + 1][t];
            }
        }
        table
    }
}

/// A robot with its recording and a place to spoil it.
struct Case {
    urdf: PathBuf,
    recording: PathBuf,
    table: Table,
    folder: PathBuf,
}

impl Case {
    fn new(name: &str, urdf: PathBuf, recording: PathBuf) -> Self {
        let table = Table::read(&recording);
        Self { urdf, recording, table, folder: scratch(&format!("check_{name}")) }
    }

    fn checked(&self, table: &Table) -> Value {
        let path = self.folder.join("spoiled.csv");
        table.write(&path);
        run(&["check", text(&self.urdf), text(&path), "--json", "-", "-q"]).fine().json()
    }
}

fn wrong(found: &Value) -> Vec<String> {
    list(&found["checks"])
        .iter()
        .filter(|c| c["verdict"] == "wrong")
        .map(|c| format!("{} {}: {}", c["topic"], c["joint"], string(&c["message"])))
        .collect()
}

/// Verdict and sentence on the effort column of a joint, from 0.
fn channel(found: &Value, joint: usize) -> (&str, &str) {
    let name = &found["joints"][joint];
    let check = list(&found["checks"])
        .iter()
        .find(|c| c["topic"] == "channel" && c["joint"] == *name)
        .unwrap();
    (string(&check["verdict"]), string(&check["message"]))
}

fn topic<'a>(found: &'a Value, topic: &str) -> &'a Value {
    list(&found["checks"]).iter().find(|c| c["topic"] == topic).unwrap()
}

/// Faults put into the columns of joints whose rigid body shows, from 0, each alone; `sure` faults are
/// wrong beyond doubt, the others at least doubtful.
fn faults_are_found(case: &Case, joints: &[usize], sure: bool) {
    let found_out = |verdict: &str| verdict == "wrong" || (!sure && verdict == "doubtful");
    let efforts = case.table.of("/effort");
    for &joint in joints {
        let found = case.checked(&case.table.scaled(&efforts[joint..=joint], -1.0));
        let (verdict, said) = channel(&found, joint);
        assert!(found_out(verdict) && said.contains("sign flipped"), "{joint}: {verdict} {said}");
        let found = case.checked(&case.table.scaled(&efforts[joint..=joint], 0.01));
        let (verdict, said) = channel(&found, joint);
        assert!(verdict == "wrong" && said.contains("another unit"), "{joint}: {verdict} {said}");
        for other in (0..efforts.len()).filter(|k| *k != joint) {
            let (verdict, said) = channel(&found, other);
            assert!(verdict != "wrong", "{joint} spoiled, {other}: {said}");
        }
    }
}

fn swaps_are_found(case: &Case, pairs: &[(usize, usize)]) {
    let efforts = case.table.of("/effort");
    for &(a, b) in pairs {
        let found = case.checked(&case.table.swapped(efforts[a], efforts[b]));
        let order = topic(&found, "order");
        assert_eq!(order["verdict"], "wrong", "{a} {b}: {order}");
        assert_eq!(found["channels"][a]["column"], found["joints"][b]);
        assert_eq!(found["channels"][b]["column"], found["joints"][a]);
    }
}

/// Gravity taken off shows on at least this many joints, and nothing else is named.
fn missing_gravity_is_found(case: &Case, least: usize) {
    let spoiled = case.table.without_gravity(&case.urdf, &case.recording, &case.folder);
    let found = case.checked(&spoiled);
    let n = list(&found["joints"]).len();
    let told: Vec<(&str, &str)> = (0..n).map(|j| channel(&found, j)).collect();
    let count = |says: &str| {
        told.iter().filter(|(v, m)| (*v == "wrong" || *v == "doubtful") && m.contains(says)).count()
    };
    // where other masses explain a joint as well, at least that gravity is missing
    let missing =
        told.iter().filter(|(_, m)| m.contains("less gravity than the URDF's links")).count();
    assert!(count("gravity is already compensated") + missing >= least, "{told:?}");
    assert_eq!(count("sign"), 0, "{told:?}");
}

/// Estimated delay \[s\] and half-width of its interval.
fn delay(found: &Value) -> (f64, f64) {
    let check = topic(found, "delay");
    let [low, high] = [0, 1].map(|k| number(&check["interval_95"][k]));
    (number(&check["value"]), 0.5 * (high - low))
}

/// A recording and the same with later efforts differ in delay by what was put in.
fn delays_are_found(case: &Case, delay_s: f64, tolerance_s: f64) -> Value {
    let (before, _) = delay(&case.checked(&case.table));
    let found = case.checked(&case.table.delayed(delay_s));
    let (after, _) = delay(&found);
    assert!((after - before - delay_s).abs() < tolerance_s, "{before} to {after}");
    found
}

fn bundled(name: &str) -> Case {
    Case::new(name, project("urdf/ur5.urdf"), project("examples/ur5/train.csv"))
}

#[test]
fn bundled_recording_passes_input_checks() {
    let case = bundled("as_is");
    let found = case.checked(&case.table);
    assert_eq!(found["schema"], "armident.check/2");
    assert_eq!(wrong(&found), Vec::<String>::new());
    for joint in 0..5 {
        assert_eq!(channel(&found, joint).0, "ok");
    }
    // its rigid body is a thousandth of its friction
    assert_eq!(channel(&found, 5).0, "cannot tell".replace(' ', "_"));
    let (delay_s, half_s) = delay(&found);
    assert!(delay_s.abs() < half_s && half_s < 2e-3, "{delay_s} {half_s}");
    assert_eq!(topic(&found, "rate")["verdict"], "ok");
    let effort = &list(&found["quality"][0]["channels"])[1];
    assert_eq!(effort["quantity"], "effort");
    // the elbow and its neighbours carry 1 % noise
    assert!((number(&effort["noise"]) - 0.45).abs() < 0.1, "{effort}");
}

#[test]
fn detects_faults_of_bundled_recording() {
    let case = bundled("faults");
    faults_are_found(&case, &[0, 2, 4], true);
    let efforts = case.table.of("/effort");
    // friction alone shows the sign
    let found = case.checked(&case.table.scaled(&efforts[5..], -1.0));
    assert_eq!(channel(&found, 5).0, "wrong");
    assert!(channel(&found, 5).1.contains("friction would drive"), "{:?}", channel(&found, 5));
    swaps_are_found(&case, &[(0, 1), (3, 4)]);
    missing_gravity_is_found(&case, 3);
    let found = case.checked(&case.table.scaled(&efforts, 0.01));
    for joint in 0..5 {
        assert!(channel(&found, joint).1.contains("another unit"), "{joint}");
    }
    let degrees = case.checked(&case.table.scaled(&case.table.of("/position"), 57.295_779_513));
    assert!(
        wrong(&degrees).iter().any(|w| w.contains("probably degrees")),
        "{:?}",
        wrong(&degrees)
    );
}

#[test]
fn detects_delays_of_bundled_recording() {
    let case = bundled("delays");
    let found = delays_are_found(&case, 0.005, 1e-3);
    assert_eq!(topic(&found, "delay")["verdict"], "wrong");
    delays_are_found(&case, 0.02, 2e-3);
}

/// A drive that filters its effort is late as with a delay, but its efforts are smaller too.
#[test]
fn low_pass_of_drives_is_no_delay() {
    let case = bundled("low_pass");
    let found = case.checked(&case.table.low_passed(0.03));
    let check = topic(&found, "delay");
    assert!(string(&check["message"]).contains("low-pass of"), "{check}");
    let (time_constant_s, half_s) = delay(&found);
    assert!((time_constant_s - 0.03).abs() < half_s.max(2e-3), "{time_constant_s} {half_s}");
    // efforts that are late alone are no low-pass
    let late = case.checked(&case.table.delayed(0.02));
    assert!(string(&topic(&late, "delay")["message"]).contains("effort lag"), "{late}");
}

/// A clock of the efforts that drifts is no delay, and recordings by one clock have none.
#[test]
fn drift_of_effort_clock_is_found() {
    let case = bundled("clock");
    for drift in [1.5e-3, -3e-3] {
        let found = case.checked(&case.table.by_fast_clock(drift));
        let check = topic(&found, "clock");
        assert_eq!(check["verdict"], "doubtful", "{check}");
        let [low, high] = [0, 1].map(|side| number(&check["interval_95"][side]));
        assert!(low < drift && drift < high && low * high > 0.0, "{check}");
        assert_ne!(topic(&found, "delay")["verdict"], "wrong", "{found}");
    }
    let by_one = case.checked(&case.table.delayed(0.02));
    assert!(list(&by_one["checks"]).iter().all(|check| check["topic"] != "clock"), "{by_one}");
}

/// A diagnosis undoes how the drives report their efforts: it names what it names without, and predicts efforts as they show them.
#[test]
fn diagnosis_sees_through_low_pass_and_clock_of_efforts() {
    let case = bundled("reported_efforts");
    let holdout = Table::read(&project("examples/ur5/holdout.csv"));
    let diagnosed = |name: &str, change: &dyn Fn(&Table) -> Table| -> Value {
        let files = [("train", &case.table), ("holdout", &holdout)].map(|(part, table)| {
            let path = case.folder.join(format!("{part}_{name}.csv"));
            change(table).write(&path);
            path
        });
        let [train, holdout] = &files;
        let args = ["diagnose", text(&case.urdf), text(train), "--holdout", text(holdout)];
        run(&[&args[..], &["--no-replay", "--json", "-", "-q"]].concat()).fine().json()
    };
    let names = |found: &Value| -> Vec<String> {
        let name = |f: &Value| format!("{} {}", string(&f["effect"]), f["joints"]);
        let mut names: Vec<String> = list(&found["findings"]).iter().map(name).collect();
        names.sort();
        names
    };
    let as_it_is = diagnosed("as_it_is", &Table::clone);
    assert!(as_it_is["effort_low_pass"].is_null() && as_it_is["effort_clock"].is_null());
    let low_passed = diagnosed("low_passed", &|table| table.low_passed(0.03));
    let time_constant_s = number(&low_passed["effort_low_pass"]["time_constant_s"]);
    assert!((time_constant_s - 0.03).abs() < 3e-3, "{}", low_passed["effort_low_pass"]);
    let drifting = diagnosed("drifting", &|table| table.by_fast_clock(1.5e-3));
    let [low, high] = [0, 1].map(|k| number(&drifting["effort_clock"]["interval_95"][k]));
    assert!(low < 1.5e-3 && 1.5e-3 < high && low > 0.0, "{}", drifting["effort_clock"]);
    assert_eq!(names(&low_passed), names(&as_it_is));
    assert!(names(&drifting).iter().all(|name| !name.starts_with("time_delay")), "{drifting}");
    for found in [low_passed, drifting] {
        // noise is filtered too
        for (joint, before) in as_it_is["fit"]["holdout"]["after"].as_object().unwrap() {
            let after = number(&found["fit"]["holdout"]["after"][joint]);
            assert!(after < 1.1 * number(before), "{joint}: {before} to {after}");
        }
    }
}

/// An upper arm of 0.425 m that the robot file makes 0.6 m long: found by `check` with its interval, corrected and named by
/// `diagnose`, which then names what it names with the right file.
#[test]
fn wrong_length_is_found_and_corrected() {
    let case = bundled("length");
    let right = std::fs::read_to_string(&case.urdf).unwrap();
    let origin = "xyz=\"-0.425 0 0\"";
    assert!(right.contains(origin));
    let wrong = case.folder.join("long.urdf");
    std::fs::write(&wrong, right.replace(origin, "xyz=\"-0.6 0 0\"")).unwrap();
    let (train, other) = (project("examples/ur5/train.csv"), project("examples/ur5/holdout.csv"));
    let diagnosed = |urdf: &Path| -> Value {
        run(&[
            "diagnose",
            text(urdf),
            text(&train),
            text(&other),
            "--no-replay",
            "--json",
            "-",
            "-q",
        ])
        .fine()
        .json()
    };
    let geometry = |found: &Value| -> Option<Value> {
        list(&found["checks"]).iter().find(|c| c["topic"] == "geometry").cloned()
    };
    let checked = |urdf: &Path| -> Value {
        run(&["check", text(urdf), text(&train), text(&other), "--json", "-", "-q"]).fine().json()
    };
    assert!(geometry(&checked(&case.urdf)).is_none());
    let found = geometry(&checked(&wrong)).unwrap();
    assert_eq!(found["verdict"], "wrong", "{found}");
    let ends = list(&found["interval_95"]).iter().map(number).collect::<Vec<f64>>();
    let length = number(&found["value"]);
    assert!((length.abs() / 0.425 - 1.0).abs() < 0.05, "{found}");
    assert!(ends[0] <= length && length <= ends[1], "{found}");

    let (as_it_is, found) = (diagnosed(&case.urdf), diagnosed(&wrong));
    let names = |found: &Value| -> Vec<String> {
        let findings = list(&found["findings"]).iter();
        let others = findings.filter(|f| f["effect"] != "link_geometry_error");
        let mut names: Vec<String> =
            others.map(|f| format!("{} {}", string(&f["effect"]), f["joints"])).collect();
        names.sort();
        names
    };
    assert_eq!(names(&found), names(&as_it_is));
    let finding =
        list(&found["findings"]).iter().find(|f| f["effect"] == "link_geometry_error").unwrap();
    assert_eq!(finding["joints"][0], "elbow_joint");
    assert!(number(&finding["confidence"]) > 0.8, "{finding}");
    for (joint, before) in as_it_is["fit"]["train"]["after"].as_object().unwrap() {
        let after = number(&found["fit"]["train"]["after"][joint]);
        assert!(after < 1.1 * number(before), "{joint}: {before} to {after}");
    }
}

/// Joints that rest or move one way, and what they leave open, are named.
#[test]
fn reports_poor_excitation() {
    let case = bundled("lazy");
    let position = case.table.of("/position");
    let mut table = case.table.clone();
    table.columns[position[0]].fill(0.3);
    let found = case.checked(&table);
    let rests = list(&found["checks"]).iter().any(|c| {
        c["joint"] == "shoulder_pan_joint" && string(&c["message"]).starts_with("does not move")
    });
    assert!(rests, "{found}");
    let open = list(&found["constants"]).iter().find(|c| c["label"] == "U1_33").unwrap();
    assert_eq!(open["verdict"], "cannot_tell");
    assert!(string(&open["reason"]).contains("does not move"), "{open}");
}

/// A second of motion has fewer independent samples than the arm has unknowns: whatever is fitted to it leaves
/// next to nothing over, and that says nothing against the columns.
#[test]
fn short_recordings_cause_no_false_alarm() {
    let case = bundled("seconds");
    for second in 0..11 {
        let from_s = f64::from(second);
        let found = case.checked(&case.table.between(from_s, from_s + 1.0));
        assert_eq!(wrong(&found), Vec::<String>::new(), "from {second} s");
    }
}

#[test]
fn reports_efforts_beyond_limits() {
    let case = bundled("beyond");
    let efforts = case.table.of("/effort");
    let found = case.checked(&case.table.scaled(&efforts[..1], 1000.0));
    let beyond = |joint: &str| {
        let of_joint = |c: &&Value| {
            c["joint"] == joint && string(&c["message"]).contains("times the URDF effort limit")
        };
        list(&found["checks"]).iter().filter(of_joint).count()
    };
    assert_eq!(beyond("shoulder_pan_joint"), 1);
    assert_eq!(beyond("shoulder_lift_joint"), 0);
}

#[test]
fn wrong_verdicts_are_warnings() {
    let args = ["check", "urdf/ur5.urdf", "examples/ur5/train.csv", "--mapping"];
    let ran = run(&[&args[..], &["examples/ur5/wrong.toml", "--fail-on", "warning"]].concat());
    assert_eq!(ran.code, 3, "{}", ran.stderr);
    assert_eq!(ran.stderr.matches("[check-wrong]").count(), 2, "{}", ran.stderr);
}

fn real(test: &str, folder: &str, urdf: &str) -> Option<Case> {
    let data = shared(test, &format!("data/{folder}"))?;
    Some(Case::new(&format!("{test}_{folder}"), data.join(urdf), data.join("train.csv")))
}

#[test]
fn real_recordings_pass_input_checks() {
    for (folder, urdf, training) in [
        ("ur10-unisa", "ur10.urdf", "train.csv"),
        ("panda-unisa", "panda.urdf", "train.csv"),
        ("staubli-tx40", "tx40.urdf", "train.csv"),
        ("tiago-arm", "tiago_schunk.urdf", "train.csv"),
        ("dfki-double-pendulum", "double_pendulum.urdf", "train.csv"),
        ("dfki-simple-pendulum", "simple_pendulum.urdf", "ddp.csv"),
        ("bam-xl330", "xl330_pendulum.urdf", "sin_sin_kp100.csv"),
    ] {
        let Some(data) = shared("check", &format!("data/{folder}")) else { return };
        let (urdf, training) = (data.join(urdf), data.join(training));
        let found =
            run(&["check", text(&urdf), text(&training), "--json", "-", "-q"]).fine().json();
        let wrong = wrong(&found);
        if folder == "tiago-arm" {
            // currents of the wrist are 0 where they are below one step
            assert_eq!(wrong.len(), 3, "{wrong:?}");
            for (said, joint) in wrong.iter().zip(["arm_5_joint", "arm_6_joint", "arm_7_joint"]) {
                assert!(said.contains(&format!("{joint}/effort: is exactly 0 in")), "{said}");
            }
            // published factors of arm 2 to 4 [N m/A]
            for (joint, published) in [(2, 13.6), (3, -8.7)] {
                let gain = &found["channels"][joint]["gain_95"];
                let (low, high) = (number(&gain[0]), number(&gain[1]));
                assert!(low < 1.0 / published && 1.0 / published < high, "{joint}: {gain}");
            }
        } else {
            assert_eq!(wrong, Vec::<String>::new(), "{folder}");
        }
    }
}

/// Three and six seconds of real motion: friction laws that are not quite those of the joint leave over what
/// free constants can imitate, and that is no fault of the columns.
#[test]
fn pieces_of_real_recordings_pass_input_checks() {
    for (folder, urdf) in [("ur10-unisa", "ur10.urdf"), ("panda-unisa", "panda.urdf")] {
        let Some(case) = real("pieces", folder, urdf) else { return };
        for length_s in [3.0, 6.0] {
            for piece in 0..(12.0 / length_s) as usize {
                let from_s = piece as f64 * length_s;
                let found = case.checked(&case.table.between(from_s, from_s + length_s));
                let of_columns = |w: &String| !w.starts_with("\"delay");
                let said: Vec<String> = wrong(&found).into_iter().filter(of_columns).collect();
                assert_eq!(said, Vec::<String>::new(), "{folder}, {length_s} s from {from_s} s");
            }
        }
    }
}

#[test]
fn detects_faults_of_real_recordings() {
    if let Some(ur10) = real("faults", "ur10-unisa", "ur10.urdf") {
        faults_are_found(&ur10, &[0, 1, 2], true);
        swaps_are_found(&ur10, &[(0, 1), (1, 2), (4, 5)]);
        delays_are_found(&ur10, 0.005, 1e-3);
    }
    if let Some(tx40) = real("faults", "staubli-tx40", "tx40.urdf") {
        faults_are_found(&tx40, &[0, 1, 2], true);
        swaps_are_found(&tx40, &[(0, 1), (1, 2)]);
        // these two share a transmission: exchanged, they leave more than half of the residual
        let efforts = tx40.table.of("/effort");
        let found = tx40.checked(&tx40.table.swapped(efforts[4], efforts[5]));
        assert_ne!(topic(&found, "order")["verdict"], "ok");
        missing_gravity_is_found(&tx40, 2);
        delays_are_found(&tx40, 0.005, 2.5e-3);
    }
    // torque sensors behind the friction, at 30 Hz
    if let Some(panda) = real("faults", "panda-unisa", "panda.urdf") {
        faults_are_found(&panda, &[1, 4], false);
        swaps_are_found(&panda, &[(0, 1), (1, 2), (4, 5)]);
        missing_gravity_is_found(&panda, 3);
    }
}

/// Simulated arms with one effect each: none of them is a fault of the books but the delays.
#[test]
fn effects_cause_no_false_alarm() {
    for (case, delay_s) in [
        ("d01", None),
        ("d02", None),
        ("d09", None),
        ("d17", None),
        ("d22", Some(-0.01325)),
        ("d30", Some(0.00575)),
        ("f01", None),
        ("f08", None),
    ] {
        let Some(folder) = shared("check", &format!("challenge/dev/{case}")) else { return };
        let (urdf, training) = (folder.join("robot.urdf"), folder.join("train_1.csv"));
        let found =
            run(&["check", text(&urdf), text(&training), "--json", "-", "-q"]).fine().json();
        match delay_s {
            None => assert_eq!(wrong(&found), Vec::<String>::new(), "{case}"),
            Some(true_s) => {
                assert_eq!(topic(&found, "delay")["verdict"], "wrong", "{case}");
                let (found_s, half_s) = delay(&found);
                assert!((found_s - true_s).abs() < half_s, "{case}: {found_s} +- {half_s}");
                assert_eq!(wrong(&found).len(), 1, "{case}");
            }
        }
    }
}
