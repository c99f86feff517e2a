//! What the diagnosis says changed, where a known load is added to real efforts.

use std::error::Error;
use std::path::Path;

use armident_diagnose::{DiagnoseError, DiagnoseRequest, Diagnosis, Finding, diagnose};
use armident_kinematics::InertialParameters;
use armident_model::ArmModel;
use armident_recording::{JointChannels, Recording};
use nalgebra::{Matrix3, Vector3};

use crate::diagnosis::named;
use crate::sets::{Data, part};

/// Parts of a set that are compared with each other.
struct Compared {
    set: &'static str,
    /// of files whose names hold it, one part each; none for thirds of the one recording
    parts: &'static [&'static str],
    /// what the parts are
    title: &'static str,
    /// \[kg\]
    loads_kg: &'static [f64],
    /// link that carries them; the last one if empty
    on_link: &'static str,
}

impl Compared {
    /// Thirds of the one recording of a set.
    const fn thirds(set: &'static str, loads_kg: &'static [f64], on_link: &'static str) -> Self {
        Self { set, parts: &[], title: "thirds", loads_kg, on_link }
    }
}

/// Recordings with what they are called.
type Part = (String, Vec<Recording>);

/// What is compared. Files in which something else than an effort is recorded (a set's `dataset.toml` says which)
/// are not.
const COMPARED: [Compared; 12] = [
    Compared::thirds("ur10-unisa", &[0.0, 1.0, 3.0], ""),
    Compared::thirds("panda-unisa", &[0.0, 0.5, 1.0], ""),
    Compared::thirds("staubli-tx40", &[0.0, 1.0, 3.0], ""),
    Compared::thirds("tiago-arm", &[0.0, 1.0, 2.0], ""),
    Compared::thirds("dfki-double-pendulum", &[0.0, 0.03, 0.1], ""),
    Compared {
        set: "dfki-double-pendulum",
        parts: &["train", "slow_small", "swing_torque1", "swing_torque2"],
        title: "motions",
        loads_kg: &[0.0, 0.1, 0.3],
        on_link: "",
    },
    Compared {
        set: "dfki-simple-pendulum",
        parts: &["ddp", "direct_collocation", "ilqr", "tracking"],
        title: "motions",
        loads_kg: &[0.0, 0.1, 0.3],
        on_link: "",
    },
    Compared {
        set: "bam-xl330",
        parts: &["kp100", "kp200", "kp400"],
        title: "gains of its controller",
        loads_kg: &[0.0, 0.1, 0.3],
        on_link: "",
    },
    Compared {
        set: "bam-xl330",
        parts: &["sin_sin", "up_and_down", "sin_time_square"],
        title: "motions",
        loads_kg: &[0.0, 0.1, 0.3],
        on_link: "",
    },
    Compared::thirds("ur10-unisa", &[3.0], "forearm_link"),
    Compared::thirds("panda-unisa", &[1.0], "panda_link4"),
    Compared::thirds("staubli-tx40", &[4.0], "link_3"),
];

/// R / k_t of the XL330 that the makers of its set publish.
const SERVO_V_PER_NM: f64 = 7.68;

/// What a diagnosis made of a load.
#[derive(Default)]
struct Tally {
    /// that carries the load
    link: String,
    compared: usize,
    right: usize,
    /// the load stands beside another body that it may be
    in_doubt: usize,
    /// a name that is not the load
    wrong: usize,
    /// numbers of the load within their 95 % interval
    in_interval: usize,
    lines: Vec<String>,
    /// confidence of each finding, and whether it is the load or may be it
    named: Vec<(f64, bool)>,
}

/// Findings of less confidence are not counted.
const COUNTED: f64 = 0.5;
/// Lowest confidences of the rows of the reliability table, the highest first.
const LEVELS: [f64; 4] = [0.95, 0.9, 0.7, COUNTED];

/// The tables.
pub(crate) fn print(folder: &Path) -> Result<(), Box<dyn Error>> {
    print_of(folder, |_| true)
}

/// The same without payloads: every finding is false.
pub(crate) fn print_placebos(folder: &Path) -> Result<(), Box<dyn Error>> {
    print_of(folder, |load_kg| load_kg == 0.0)
}

fn print_of(folder: &Path, wanted: impl Fn(f64) -> bool) -> Result<(), Box<dyn Error>> {
    println!("\n## Changes\n");
    println!(
        "Parts of a set are compared with each other (`--reference`): each part with each other one, and with \
         all others. The effort of a point mass at the centre of a link is added to the later part, as computed \
         by the dynamics. Without a payload every finding is false. Payloads of the XL330 are added to its \
         voltages with the published {SERVO_V_PER_NM} V/(N m). *Right* counts findings of a payload or an \
         inertia error of that link, *as alternative* other bodies with that link as an alternative, *other \
         findings* comparisons with any other finding, *in interval* right findings whose 95 % interval covers \
         the payload (its mass, or its first moment if no effort depends on the mass).\n"
    );
    println!(
        "| set | compared | payload [kg] | on | comparisons | right | as alternative | other findings | in interval |"
    );
    println!("| --- | --- | ---: | --- | ---: | ---: | ---: | ---: | ---: |");
    let (mut lines, mut named) = (Vec::new(), Vec::new());
    for compared in &COMPARED {
        for &load_kg in compared.loads_kg.iter().filter(|load_kg| wanted(**load_kg)) {
            let tally = compared.tally(folder, load_kg)?;
            println!(
                "| {} | {} | {load_kg} | {} | {} | {} | {} | {} | {} |",
                compared.set,
                compared.title,
                tally.link,
                tally.compared,
                tally.right,
                tally.in_doubt,
                tally.wrong,
                tally.in_interval
            );
            lines.extend(tally.lines);
            named.extend(tally.named);
        }
    }
    println!("\nAll comparisons together, by the confidence of the findings:\n");
    println!("| confidence | findings | of the payload, or with it as alternative |");
    println!("| ---: | ---: | ---: |");
    let mut below = f64::INFINITY;
    for level in LEVELS {
        let here: Vec<bool> = named
            .iter()
            .filter(|(c, _)| (level..below).contains(c))
            .map(|(_, right)| *right)
            .collect();
        let right = here.iter().filter(|right| **right).count();
        println!("| {level} and more | {} | {right} |", here.len());
        below = level;
    }
    println!("\nAll findings:\n");
    lines.iter().for_each(|line| println!("* {line}"));
    Ok(())
}

impl Compared {
    fn tally(&self, folder: &Path, load_kg: f64) -> Result<Tally, Box<dyn Error>> {
        let set = crate::sets::named(self.set).ok_or("no such set")?;
        let data = Data::read_files(set, folder, self.parts)?;
        let parts = self.parts_of(&data)?;
        let joints = &data.model.chain.joints;
        let carries = |link: &str| link == self.on_link || self.on_link.is_empty();
        let link = joints.iter().rposition(|joint| carries(&joint.child_link));
        let link = link.ok_or("no such link")?;
        let name = if load_kg > 0.0 { &*joints[link].child_link } else { "" };
        let mut tally = Tally { link: name.to_owned(), ..Tally::default() };
        for (later, (name, after)) in parts.iter().enumerate() {
            let others = || parts.iter().enumerate().filter(|(k, _)| *k != later);
            let mut before: Vec<Part> = others().map(|(_, part)| part.clone()).collect();
            let rest = others().flat_map(|(_, (_, recordings))| recordings.clone()).collect();
            before.push(("all others".to_owned(), rest));
            for (earlier, before) in before {
                let title = format!("{}, {name} against {earlier}, {load_kg} kg", self.set);
                tally.add(&title, &data.model, &before, after, (load_kg, link))?;
            }
        }
        Ok(tally)
    }

    fn parts_of(&self, data: &Data) -> Result<Vec<Part>, Box<dyn Error>> {
        if !self.parts.is_empty() {
            let of = |part: &&str| -> Vec<Recording> {
                data.all().filter(|r| r.source.contains(*part)).cloned().collect()
            };
            return Ok(self.parts.iter().map(|part| ((*part).to_owned(), of(part))).collect());
        }
        let whole = data.all().next().ok_or("no recording")?;
        let (first, last) = (whole.time_s[0], whole.time_s[whole.len() - 1]);
        let third = |k: i32| {
            let at = |share: i32| first + f64::from(share) / 3.0 * (last - first);
            Ok((format!("third {}", k + 1), vec![part(whole, |t| at(k) <= t && t < at(k + 1))?]))
        };
        (0..3).map(third).collect()
    }
}

impl Tally {
    fn add(
        &mut self,
        title: &str,
        model: &ArmModel,
        before: &[Recording],
        after: &[Recording],
        (load_kg, link): (f64, usize),
    ) -> Result<(), Box<dyn Error>> {
        self.compared += 1;
        let after: Vec<Recording> =
            after.iter().map(|r| loaded(model, r, load_kg, link)).collect::<Result<_, _>>()?;
        let request = DiagnoseRequest { reference: before, ..DiagnoseRequest::new(model, &after) };
        let diagnosis = match diagnose(&request) {
            Err(DiagnoseError::WrongColumns(_)) => {
                self.lines.push(format!("{title}: failed input check"));
                return Ok(());
            }
            found => found?,
        };
        let carrier = &model.chain.joints[link];
        let place_m = carrier.child_link_in_e.inverse_transform_point(&carrier.link.com_m().into());
        let is_body = |effect: &str| ["payload", "link_inertia_error"].contains(&effect);
        let is_load = |finding: &&Finding| {
            is_body(&finding.effect) && finding.link.as_deref() == Some(&*carrier.child_link)
        };
        let may_be_load = |finding: &&Finding| {
            let mut others = finding.alternatives.iter();
            is_body(&finding.effect)
                && others
                    .any(|a| is_body(&a.effect) && a.link.as_deref() == Some(&*carrier.child_link))
        };
        let counted: Vec<&Finding> =
            diagnosis.findings.iter().filter(|finding| finding.confidence >= COUNTED).collect();
        let findings = || counted.iter().copied().filter(|_| load_kg > 0.0);
        let load = findings().find(is_load);
        let doubted = findings().find(|finding| load.is_none() && may_be_load(finding));
        self.right += usize::from(load.is_some());
        self.in_doubt += usize::from(doubted.is_some());
        let accounted = usize::from(load.or(doubted).is_some());
        self.wrong += usize::from(counted.len() > accounted);
        let accounts =
            |finding: &&Finding| load_kg > 0.0 && (is_load(finding) || may_be_load(finding));
        self.named.extend(counted.iter().map(|finding| (finding.confidence, accounts(finding))));
        self.in_interval +=
            usize::from(load.is_some_and(|load| holds(load, load_kg, &place_m.coords)));
        if !diagnosis.findings.is_empty() {
            self.lines.push(format!("{title}: {}", said(&diagnosis)));
        }
        Ok(())
    }
}

/// Whether a load is within what was said of it, as far as its numbers were.
fn holds(finding: &Finding, load_kg: f64, at_m: &Vector3<f64>) -> bool {
    let within = |name: &str, truth: f64, deviations: f64| {
        let said = finding.parameters.get(name);
        said.is_none_or(|said| {
            (said.value - truth).abs() <= deviations * said.stderr.unwrap_or(0.0)
        })
    };
    if let Some(mass) = ["mass", "delta_mass"].iter().find(|m| finding.parameters.contains_key(**m))
    {
        return within(mass, load_kg, 1.96);
    }
    // three numbers at most, 95 % together
    ["delta_mcx", "delta_mcy", "delta_mcz"]
        .iter()
        .zip(at_m.iter())
        .all(|(name, at)| within(name, load_kg * at, 2.39))
}

/// The recording with the effort of a load on a link.
fn loaded(
    model: &ArmModel,
    recording: &Recording,
    load_kg: f64,
    link: usize,
) -> Result<Recording, Box<dyn Error>> {
    let mut heavier = model.clone();
    let body = &mut heavier.chain.joints[link].link;
    *body = body.plus(&InertialParameters::from_com(load_kg, body.com_m(), Matrix3::zeros()));
    let [with, without] =
        [&heavier, model].map(|model| model.links_in_band().predict(recording, None));
    let (with, without) = (with?.efforts, without?.efforts);
    let mut changed = recording.clone();
    for (j, name) in model.chain.joint_names().iter().enumerate() {
        let Some(channels) = changed.joints.iter_mut().find(|c| c.name == **name) else { continue };
        let JointChannels { effort, voltage, .. } = channels;
        let recorded = match (effort, voltage) {
            (Some(effort), _) => Some((effort, 1.0)),
            (None, Some(voltage)) => Some((voltage, SERVO_V_PER_NM)),
            (None, None) => None,
        };
        let Some((column, per_nm)) = recorded else { continue };
        for ((x, with), without) in column.iter_mut().zip(&with[j]).zip(&without[j]) {
            *x += per_nm * (with - without);
        }
    }
    Ok(changed)
}

fn said(diagnosis: &Diagnosis) -> String {
    if diagnosis.findings.is_empty() {
        return "nothing".to_owned();
    }
    diagnosis.findings.iter().map(in_words).collect::<Vec<_>>().join("; ")
}

/// What, where, and the numbers of a load.
fn in_words(finding: &Finding) -> String {
    let numbers: Vec<String> = ["mass", "delta_mass", "delta_mcx", "delta_mcy", "delta_mcz"]
        .iter()
        .filter_map(|name| finding.parameters.get(name))
        .take(if finding.parameters.contains_key("mass") { 1 } else { 3 })
        .map(|of| format!("{:.3} +- {:.3} {}", of.value, of.stderr.unwrap_or(0.0), of.unit))
        .collect();
    let numbers = numbers.join(", ");
    format!("{} ({:.2}) {numbers}", named(finding), finding.confidence).trim_end().to_owned()
}
