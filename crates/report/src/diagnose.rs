//! The diagnosis for people and programs.

use std::collections::{BTreeMap, BTreeSet};

use armident_diagnose::{
    Books, ConstantEstimate, Diagnosis, DoubtfulChange, DriveGain, Errors, Finding, JointAtlas,
    NextMotion, Placebo,
};
use armident_effects::{Effect, SublinearViscousFriction, effect, is_less};
use armident_ident::checks::Check;
use armident_kinematics::DrivingAxisChain;
use serde::Serialize;

use crate::bar::Bars;
use crate::numbers::{significant, uncertain, unit_told};
use crate::small_terms::{SmallTerm, small_terms_text};
use crate::table::aligned;

/// What was diagnosed.
#[derive(Debug, Clone, Default)]
pub struct DiagnoseInputs {
    /// Recordings that were fitted.
    pub recordings: Vec<String>,
    /// Recordings kept out.
    pub holdout_recordings: Vec<String>,
    /// Recordings from before a change.
    pub reference_recordings: Vec<String>,
    /// Whether the robot was given as a model with effects of its own, which are no findings.
    pub beyond_a_model: bool,
    /// What reading the robot had to say.
    pub warnings: Vec<String>,
}

/// Errors of the efforts as recorded.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Fits {
    /// Of the recordings fitted.
    pub train: Option<Errors>,
    /// Of those kept out.
    pub holdout: Option<Errors>,
}

/// Result of `armident diagnose`.
#[derive(Debug, Serialize)]
pub struct DiagnoseReport {
    schema: &'static str,
    verdict: &'static str,
    sentence: String,
    robot: String,
    recordings: Vec<String>,
    holdout_recordings: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    reference_recordings: Vec<String>,
    joints: Vec<String>,
    books: BooksSaid,
    findings: Vec<Finding>,
    fit: Fits,
    effort_noise: BTreeMap<String, f64>,
    inertial_error: f64,
    /// standard errors between the links of the model and what was found, where no real bodies have that
    #[serde(skip_serializing_if = "Option::is_none")]
    links_off_standard_errors: Option<f64>,
    /// frequency below which all was compared \[Hz\], where the usual band does not hold
    #[serde(skip_serializing_if = "Option::is_none")]
    narrowed_to_hz: Option<f64>,
    /// what the model has beside the findings
    #[serde(skip_serializing_if = "Vec::is_empty")]
    small_terms: Vec<SmallTerm>,
    /// speeds below which dry friction fades \[rad/s or m/s\]
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    friction_fades_below: BTreeMap<String, f64>,
    /// travels since a reversal over which dry friction builds up \[rad or m\]
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    friction_builds_up_over: BTreeMap<String, f64>,
    /// coefficients of sub-linear viscous friction in the model \[N m (s/rad)^0.5 or N (s/m)^0.5\]
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    friction_bends: BTreeMap<String, f64>,
    /// speeds of the reference that joints now exceed \[rad/s or m/s\]: what is faster is not compared
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    beyond_reference: BTreeMap<String, f64>,
    /// with a reference: changes that are not certain enough to be named
    #[serde(skip_serializing_if = "Vec::is_empty")]
    doubtful_changes: Vec<DoubtfulChange>,
    /// joints on which the inertial errors of all links together matter
    inertias_matter_on: Vec<String>,
    atlas: Vec<JointAtlas>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    constants: Vec<ConstantEstimate>,
    /// joints on which more than noise is left over without a name
    unexplained: Vec<String>,
    /// joints of the hold-out that the model predicts worse than the robot as given
    #[serde(skip_serializing_if = "Vec::is_empty")]
    worse_on_holdout: Vec<String>,
    /// of the hold-out
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    whiteness_p: BTreeMap<String, f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    replay: Option<ReplayPair>,
    #[serde(skip_serializing_if = "Option::is_none")]
    placebo: Option<Placebo>,
    #[serde(skip_serializing_if = "Option::is_none")]
    next_motion: Option<NextMotionSaid>,
    warnings: Vec<String>,
}

/// Root mean square position error after recorded efforts drove the simulated arm over short windows,
/// by joint \[rad or m\].
#[derive(Debug, Clone, Serialize)]
pub struct ReplayPair {
    /// Length of a window.
    pub window_s: f64,
    /// With the believed model.
    pub before: BTreeMap<String, f64>,
    /// With the diagnosed one.
    pub after: BTreeMap<String, f64>,
}

/// What the recordings say of their own columns.
#[derive(Debug, Default, Serialize)]
struct BooksSaid {
    faults: Vec<Check>,
    drive_gains: Vec<DriveGain>,
    unchecked: Option<String>,
}

#[derive(Debug, Serialize)]
struct NextMotionSaid {
    file: Option<String>,
    description: Option<String>,
    told_apart: usize,
    pairs: usize,
    /// standard deviations of one recorded sample
    separation: Option<f64>,
}

impl DiagnoseReport {
    /// From a diagnosis and its errors.
    pub fn new(
        chain: &DrivingAxisChain,
        diagnosis: &Diagnosis,
        inputs: DiagnoseInputs,
        fit: Fits,
    ) -> Self {
        let unexplained: Vec<String> = diagnosis
            .atlas
            .iter()
            .filter(|joint| !joint.explained())
            .map(|joint| joint.joint.clone())
            .collect();
        let mut report = Self {
            verdict: match diagnosis.findings.is_empty()
                && unexplained.is_empty()
                && diagnosis.inertias_matter_on.is_empty()
            {
                true => "match",
                false => "mismatch",
            },
            unexplained,
            worse_on_holdout: Self::worse(&fit),
            joints: diagnosis.joints.clone(),
            findings: diagnosis.findings.clone(),
            fit,
            effort_noise: diagnosis.effort_noise.clone(),
            inertial_error: diagnosis.inertial_error,
            links_off_standard_errors: diagnosis.links_off,
            narrowed_to_hz: diagnosis.narrowed_to_hz,
            // with a reference, the model has all that was learned of that, small or not
            small_terms: match inputs.reference_recordings.is_empty() && !inputs.beyond_a_model {
                true => SmallTerm::of(chain, diagnosis),
                false => Vec::new(),
            },
            friction_fades_below: above_zero(diagnosis, &diagnosis.model.regularised_below()),
            friction_builds_up_over: above_zero(diagnosis, &diagnosis.model.presliding_travel()),
            friction_bends: diagnosis
                .model
                .sublinear_friction()
                .map(|(joint, c)| (joint.to_owned(), c))
                .collect(),
            beyond_reference: diagnosis.beyond_reference.clone(),
            doubtful_changes: diagnosis.doubtful_changes.clone(),
            inertias_matter_on: diagnosis.inertias_matter_on.clone(),
            atlas: diagnosis.atlas.clone(),
            constants: diagnosis.constants.as_ref().map_or_else(Vec::new, |c| c.constants.clone()),
            ..Self::empty(chain, inputs)
        };
        report.sentence = report.first_sentence();
        report
    }

    /// Of recordings whose columns are not what they are called: there is nothing to say of physics.
    pub fn of_wrong_books(chain: &DrivingAxisChain, books: &Books, inputs: DiagnoseInputs) -> Self {
        Self::empty(chain, inputs).with_books(books)
    }

    fn empty(chain: &DrivingAxisChain, inputs: DiagnoseInputs) -> Self {
        Self {
            schema: "armident.diagnosis/1",
            verdict: "match",
            sentence: String::new(),
            robot: chain.robot.clone(),
            recordings: inputs.recordings,
            holdout_recordings: inputs.holdout_recordings,
            reference_recordings: inputs.reference_recordings,
            joints: chain.joints.iter().map(|j| j.name.clone()).collect(),
            books: BooksSaid::default(),
            findings: Vec::new(),
            fit: Fits::default(),
            effort_noise: BTreeMap::new(),
            inertial_error: 0.0,
            links_off_standard_errors: None,
            narrowed_to_hz: None,
            small_terms: Vec::new(),
            friction_fades_below: BTreeMap::new(),
            friction_builds_up_over: BTreeMap::new(),
            friction_bends: BTreeMap::new(),
            beyond_reference: BTreeMap::new(),
            doubtful_changes: Vec::new(),
            inertias_matter_on: Vec::new(),
            atlas: Vec::new(),
            constants: Vec::new(),
            unexplained: Vec::new(),
            worse_on_holdout: Vec::new(),
            whiteness_p: BTreeMap::new(),
            replay: None,
            placebo: None,
            next_motion: None,
            warnings: inputs.warnings,
        }
    }

    /// With what the recordings say of their own columns; the diagnosis is then of the other joints.
    #[must_use]
    pub fn with_books(mut self, books: &Books) -> Self {
        // one column may have a fault in every recording
        let columns: BTreeSet<Option<&str>> =
            books.faults.iter().map(|fault| fault.joint.as_deref()).collect();
        let counted = match columns.len() {
            0 => None,
            1 => Some(("a column is".to_owned(), "it")),
            n => Some((format!("{n} columns are"), "them")),
        };
        if let Some((count, them)) = counted {
            let others = match self.sentence.as_str() {
                "" => String::new(),
                others => format!("; without {them}, {others}"),
            };
            self.sentence =
                format!("the books are wrong: {count} not what the header says{others}");
            self.verdict = "mismatch";
        }
        self.books = BooksSaid {
            faults: books.faults.clone(),
            drive_gains: books.drive_gains.clone(),
            unchecked: books.unchecked.clone(),
        };
        self
    }

    /// With what recordings kept out say beside their errors.
    #[must_use]
    pub fn with_proof(
        mut self,
        whiteness_p: BTreeMap<String, f64>,
        replay: Option<ReplayPair>,
    ) -> Self {
        self.whiteness_p = whiteness_p;
        self.replay = replay;
        self
    }

    /// With what the selection makes of wrong terms.
    #[must_use]
    pub fn with_placebo(mut self, placebo: Option<Placebo>) -> Self {
        self.placebo = placebo;
        self
    }

    /// With the motion that tells findings from their alternatives, and the file it is in, if one was
    /// asked for.
    #[must_use]
    pub fn with_next_motion(mut self, asked: bool, found: Option<(String, NextMotion)>) -> Self {
        self.next_motion = asked.then_some(match found {
            Some((file, next)) => NextMotionSaid {
                file: Some(file),
                description: Some(next.description),
                told_apart: next.told_apart,
                pairs: next.pairs,
                separation: Some(next.separation),
            },
            None => NextMotionSaid {
                file: None,
                description: None,
                told_apart: 0,
                pairs: 0,
                separation: None,
            },
        });
        self
    }

    /// The page for people.
    pub fn text(&self, bars: Bars) -> String {
        let mut page = format!("{}: {}\n", self.robot, self.sentence);
        page.push_str(&self.books_text());
        for finding in &self.findings {
            page.push_str(&paragraph(finding));
        }
        page.push_str(&self.atlas_text());
        page.push_str(&self.model_text());
        page.push_str(&self.proof_text(bars));
        if let Some(Placebo { terms, improve, named, largest }) = &self.placebo {
            page.push_str(&format!(
                "\nOf {terms} wrong terms {improve} lower the error of stretches that were not fitted, and \
                 {named} would have been named; the largest matters {:.0} % of what a name asks for\n",
                100.0 * largest
            ));
        }
        page.push_str(&self.next_motion_text());
        page
    }

    /// What the model has beside what is named.
    fn model_text(&self) -> String {
        let mut text = String::new();
        if let Some(off) = self.links_off_standard_errors {
            text.push_str(&format!(
                "\nlinks: no real bodies have what was found; the model has the nearest ones, {} standard errors off\n",
                significant(off, 3, 0.0)
            ));
        }
        if !self.small_terms.is_empty() {
            text.push_str(&format!(
                "\nalso in the model, too small to be named: {}\n",
                small_terms_text(&self.small_terms)
            ));
        }
        if let Some(hz) = self.narrowed_to_hz {
            text.push_str(&format!(
                "\ncompared below {hz} Hz: above, efforts and motions do not go together as they do below\n"
            ));
        }
        if !self.beyond_reference.is_empty() {
            text.push_str(&format!(
                "\nnot compared: motion much faster than the reference's, which says nothing of friction there (rad/s or m/s): {}\n",
                by_joint_text(&self.beyond_reference)
            ));
        }
        for (maybe_before, why) in [
            (true, "may have been so before, which the reference does not show"),
            (false, "may be chance"),
        ] {
            let doubtful: Vec<String> = self
                .doubtful_changes
                .iter()
                .filter(|change| change.maybe_before == maybe_before)
                .map(|change| {
                    let title = titled(&change.effect, &change.joints, change.link.as_ref());
                    if maybe_before {
                        return title;
                    }
                    format!("{title} ({} %)", significant(100.0 * change.chance, 1, 0.0))
                })
                .collect();
            if !doubtful.is_empty() {
                text.push_str(&format!("\nnot named: {why}: {}\n", doubtful.join("; ")));
            }
        }
        if !self.friction_fades_below.is_empty() {
            text.push_str(&format!(
                "\ndry friction does not turn at once, it fades below (rad/s or m/s): {}\n",
                by_joint_text(&self.friction_fades_below)
            ));
        }
        if !self.friction_builds_up_over.is_empty() {
            text.push_str(&format!(
                "\ndry friction builds up over a travel since the last reversal (rad or m): {}\n",
                by_joint_text(&self.friction_builds_up_over)
            ));
        }
        if !self.friction_bends.is_empty() {
            let law = SublinearViscousFriction.law();
            text.push_str(&format!(
                "\nfriction grows more slowly than the speed: the model has {} with these coefficients (N m (s/rad)^0.5 or \
                 N (s/m)^0.5), the friction above is the line through it: {}\n",
                law.formula,
                by_joint_text(&self.friction_bends)
            ));
        }
        text
    }

    fn first_sentence(&self) -> String {
        let change = !self.reference_recordings.is_empty();
        let mut sentence = match (self.findings.len(), change) {
            // what no law explains is no nothing
            (0, _) if !self.unexplained.is_empty() => self.unexplained_clause(change),
            (0, false) if !self.inertias_matter_on.is_empty() => self.inertias_clause(),
            (0, false) => "the recordings show nothing that the model leaves out".to_owned(),
            (1, false) => "the recordings show one effect that the model leaves out".to_owned(),
            (n, false) => format!("the recordings show {n} effects that the model leaves out"),
            (0, true) => "the recordings show no change against the reference".to_owned(),
            (1, true) => "the recordings show one change against the reference".to_owned(),
            (n, true) => format!("the recordings show {n} changes against the reference"),
        };
        let of =
            |confirmed| self.findings.iter().filter(|f| f.confirmed == Some(confirmed)).count();
        let (yes, no) = (of(true), of(false));
        match (yes, no) {
            (0, 0) => {}
            (_, 0) => sentence.push_str(", and the hold-out confirms it"),
            (0, _) => sentence.push_str("; the hold-out does not confirm it"),
            (_, no) => sentence.push_str(&format!("; the hold-out confirms all but {no} of them")),
        }
        if !self.findings.is_empty() && !self.unexplained.is_empty() {
            sentence.push_str(&format!("; {}", self.left_clause()));
        }
        if !self.worse_on_holdout.is_empty() {
            sentence.push_str(&format!(
                "; the hold-out is predicted worse than by the robot as given on {}",
                self.worse_on_holdout.join(", ")
            ));
        }
        sentence
    }

    /// Joints on which what was learned does not hold for the motion that was kept out.
    fn worse(fit: &Fits) -> Vec<String> {
        // less is the scatter of a short hold-out
        const CLEARLY: f64 = 1.1;
        let Some(errors) = &fit.holdout else { return Vec::new() };
        let worse = |(joint, after): &(&String, &f64)| {
            errors.before.get(*joint).is_some_and(|before| **after > CLEARLY * before)
        };
        errors.after.iter().filter(worse).map(|(joint, _)| joint.clone()).collect()
    }

    /// Instead of findings where all links are off by a little.
    fn inertias_clause(&self) -> String {
        format!(
            "the recordings show no single effect that the model leaves out, but its inertias are off by about \
             {} %, which matters on {}",
            significant(100.0 * self.inertial_error, 2, 0.0),
            self.inertias_matter_on.join(", ")
        )
    }

    /// Instead of findings.
    fn unexplained_clause(&self, change: bool) -> String {
        let of = match change {
            true => "the recordings show no change that can be named against the reference",
            false => "no effect that can be named explains the recordings",
        };
        format!("{of}; {}", self.left_clause())
    }

    /// How much is left over without an explanation, and where.
    fn left_clause(&self) -> String {
        let of = |name: &String| {
            let joint = self.atlas.iter().find(|a| a.joint == *name);
            joint.map_or(0.0, JointAtlas::left_over_noise)
        };
        // a channel that was smoothed before it was recorded has next to no noise: the number says nothing more
        const MANY: f64 = 100.0;
        let most = self.unexplained.iter().map(of).fold(0.0, f64::max);
        let times = match most < MANY {
            true => format!("up to {}", significant(most, 2, 0.0)),
            false => format!("more than {MANY}"),
        };
        format!("{times} times the noise of {} is left unexplained", self.unexplained.join(", "))
    }

    fn books_text(&self) -> String {
        let mut text = String::new();
        for fault in &self.books.faults {
            let place = fault.joint.as_ref().map_or(String::new(), |joint| format!("{joint}: "));
            text.push_str(&format!("\n{place}{}\n", fault.message));
            if let Some(advice) = &fault.advice {
                text.push_str(&format!("  -> {advice}\n"));
            }
        }
        if let Some(why) = &self.books.unchecked {
            text.push_str(&format!("The columns were not checked: {why}\n"));
        }
        if !self.books.drive_gains.is_empty() {
            text.push_str(
                "\nGains of drives, as the robot's masses ask for (only ratios of efforts are sure)\n",
            );
            let rows: Vec<Vec<String>> = self
                .books
                .drive_gains
                .iter()
                .map(|g| {
                    let [low, high] = g.interval_95.map(|x| significant(x, 3, 0.0));
                    let gain = if g.determined {
                        significant(g.gain, 3, 0.0)
                    } else {
                        "not determined: the joint is left out".to_owned()
                    };
                    vec![g.joint.clone(), g.quantity.to_owned(), gain, low, high]
                })
                .collect();
            text.push_str(&aligned(&["joint", "recorded", "gain", "95 % from", "to"], &rows, 2));
        }
        text
    }

    /// Where the mismatch is, one line a joint.
    fn atlas_text(&self) -> String {
        if self.atlas.is_empty() {
            return String::new();
        }
        let rows: Vec<Vec<String>> = self
            .atlas
            .iter()
            .map(|joint| {
                let share = |left: f64| {
                    let share = 1.0 - (left / joint.before).powi(2);
                    format!("{:.0} %", 100.0 * share.max(0.0))
                };
                let goes_with = match (joint.symmetries.first(), joint.regimes.first()) {
                    // below a tenth nothing is told
                    (Some(s), _) if s.share_before > 0.1 => {
                        format!("{} {:.0} %: {}", s.function, 100.0 * s.share_before, s.points_to)
                    }
                    (_, Some(r)) if r.share_before > 0.1 => {
                        format!("{} {:.0} %", r.variable.replace('_', " "), 100.0 * r.share_before)
                    }
                    _ => "-".to_owned(),
                };
                vec![
                    joint.joint.clone(),
                    significant(joint.before, 3, 0.0),
                    share(joint.rigid),
                    share(joint.after),
                    significant(joint.after / joint.noise.max(f64::MIN_POSITIVE), 3, 0.0),
                    goes_with,
                ]
            })
            .collect();
        let head = ["joint", "left over", "by links", "by all", "left/noise", "goes most with"];
        format!(
            "\nWhere (training, in the band: what the robot as given leaves over, how much of it its links \
             and all that was found explain)\n{}",
            aligned(&head, &rows, 1)
        )
    }

    /// Errors on the hold-out, or else on what was fitted.
    fn proof_text(&self, bars: Bars) -> String {
        let Some(errors) = self.fit.holdout.as_ref().or(self.fit.train.as_ref()) else {
            return String::new();
        };
        let proven = self.fit.holdout.is_some();
        let kind = if proven { "hold-out" } else { "training" };
        let mut head = vec!["joint", "before", "rigid", "after", "noise"];
        if proven {
            head.push("white, p");
        }
        head.push("after/before");
        let mut rows = Vec::new();
        for joint in &self.joints {
            let of = |m: &BTreeMap<String, f64>, digits: usize| {
                m.get(joint).map_or_else(|| "-".to_owned(), |x| significant(*x, digits, 0.0))
            };
            let maps = [&errors.before, &errors.rigid, &errors.after, &self.effort_noise];
            let mut row = vec![joint.clone()];
            row.extend(maps.map(|m| of(m, 3)));
            if proven {
                row.push(of(&self.whiteness_p, 2));
            }
            let ends = errors.before.get(joint).zip(errors.after.get(joint));
            row.push(ends.map_or_else(String::new, |(before, after)| bars.left(*before, *after)));
            rows.push(row);
        }
        let mut text = format!(
            "\nError of the {kind} efforts as recorded (RMS, N m or N)\n{}",
            aligned(&head, &rows, 1)
        );
        if let Some(replay) = &self.replay {
            let rows: Vec<Vec<String>> = self
                .joints
                .iter()
                .map(|joint| {
                    let of = |m: &BTreeMap<String, f64>| {
                        m.get(joint).map_or_else(|| "-".to_owned(), |x| significant(*x, 3, 0.0))
                    };
                    vec![joint.clone(), of(&replay.before), of(&replay.after)]
                })
                .collect();
            text.push_str(&format!(
                "\nPosition error after recorded efforts drive the simulated arm for {} s (RMS, rad or \
                 m)\n{}",
                replay.window_s,
                aligned(&["joint", "before", "after"], &rows, 1)
            ));
        }
        text
    }

    fn next_motion_text(&self) -> String {
        match &self.next_motion {
            None => String::new(),
            Some(NextMotionSaid {
                file: Some(file),
                description: Some(motion),
                told_apart,
                pairs,
                separation: Some(by),
            }) => format!(
                "\nThe motion that best tells the findings from their alternatives is in {file}:\n{motion}; \
                 it tells {told_apart} of {pairs} apart, efforts differ by {} times the noise of a sample \
                 (median)\n",
                significant(*by, 2, 0.0),
            ),
            Some(_) if self.findings.iter().all(|f| f.alternatives.is_empty()) => {
                "\nNo further motion is needed: no finding has an alternative\n".to_owned()
            }
            Some(_) => "\nNo motion inside the limits tells the findings from their alternatives\n"
                .to_owned(),
        }
    }
}

fn paragraph(finding: &Finding) -> String {
    let value = |name: &str| finding.parameters.get(name).map(|v| v.value);
    let less = if is_less(&finding.effect, value) { "less " } else { "" };
    let title = titled(&finding.effect, &finding.joints, finding.link.as_ref());
    let mut text = format!("\n{less}{title}");
    let confirmed = match finding.confirmed {
        Some(true) => ", confirmed",
        Some(false) => ", NOT confirmed by the hold-out",
        None => "",
    };
    text.push_str(&format!(" (confidence {:.2}{confirmed})\n", finding.confidence));
    for (name, value) in &finding.parameters {
        let number = match value.stderr {
            Some(stderr) => {
                let (number, error) = uncertain(value.value, stderr);
                format!("{number} +- {error}")
            }
            None => significant(value.value, 3, 0.0),
        };
        let line = format!("  {name} {number} {}", unit_told(value.unit));
        text.push_str(&format!("{}\n", line.trim_end()));
    }
    if !finding.evidence.variables.is_empty() {
        text.push_str(&format!("  depends on {}\n", finding.evidence.variables.join(", ")));
    }
    if let Some(character) = &finding.evidence.character {
        let mut traits = vec![character.kind.to_owned()];
        // below a half it is one trait among others
        const MOST: f64 = 0.5;
        if character.memory_share > MOST {
            traits.push("with memory of the last reversal".to_owned());
        }
        if character.drift_share > MOST {
            traits.push("drifting".to_owned());
        }
        if character.wave[1] > MOST {
            traits.push(format!("a wave of {} cycles in the position", character.wave[0]));
        }
        text.push_str(&format!("  {}\n", traits.join(", ")));
    }
    for alternative in &finding.alternatives {
        text.push_str(&format!(
            "  or {}",
            titled(&alternative.effect, &alternative.joints, alternative.link.as_ref())
        ));
        match alternative.separated_by {
            Some(motion) => text.push_str(&format!("; told apart by {motion}\n")),
            None => text.push_str("; a motion that tells them apart: --next-motion DIR\n"),
        }
    }
    text
}

/// An effect with its place.
fn titled(slug: &str, joints: &[String], link: Option<&String>) -> String {
    let title = effect(slug).map_or("structure without a name", |e| e.law().title);
    let place = link.cloned().unwrap_or_else(|| joints.join(", "));
    if place.is_empty() { title.to_owned() } else { format!("{title} on {place}") }
}

/// Joints with their speeds.
/// Those of some numbers, one a joint, that are not 0.
fn above_zero(diagnosis: &Diagnosis, numbers: &[f64]) -> BTreeMap<String, f64> {
    let pairs = diagnosis.joints.iter().cloned().zip(numbers.iter().copied());
    pairs.filter(|(_, number)| *number > 0.0).collect()
}

fn by_joint_text(speeds: &BTreeMap<String, f64>) -> String {
    let of_joint =
        |(joint, speed): (&String, &f64)| format!("{joint} {}", significant(*speed, 2, 0.0));
    speeds.iter().map(of_joint).collect::<Vec<_>>().join(", ")
}
