//! The sets, and how they are read.

use std::error::Error;
use std::path::Path;

use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use armident_model::ArmModel;
use armident_motion::{Motion, MotionSettings};
use armident_recording::{
    JointChannels, Mapping, Quantity, Recording, RecordingError, read_csv, read_csv_mapped,
};

/// A set and its files.
pub(crate) struct Set {
    pub(crate) folder: &'static str,
    pub(crate) training: &'static [&'static str],
    /// none: a part of the training recording is kept out
    pub(crate) holdout: &'static [&'static str],
    /// makes efforts of what is recorded
    pub(crate) mapping: &'static str,
}

const TIAGO: &str = r#"
[[channel]]
column = "{joint}/current"
quantity = "effort"
unit = "A"
gain = { arm_1_joint = 13.6, arm_2_joint = 13.6, arm_3_joint = -8.7, arm_4_joint = -8.7, arm_5_joint = -20.6, arm_6_joint = -20.6, arm_7_joint = -20.6 }
[[channel]]
column = "{joint}/{quantity}"
"#;

/// All of them.
pub(crate) const SETS: [Set; 7] = [
    Set { folder: "ur10-unisa", training: &["train.csv"], holdout: &[], mapping: "" },
    Set { folder: "panda-unisa", training: &["train.csv"], holdout: &[], mapping: "" },
    Set { folder: "staubli-tx40", training: &["train.csv"], holdout: &[], mapping: "" },
    Set { folder: "tiago-arm", training: &["train.csv"], holdout: &[], mapping: TIAGO },
    Set { folder: "dfki-double-pendulum", training: &["train.csv"], holdout: &[], mapping: "" },
    Set {
        folder: "dfki-simple-pendulum",
        training: &["ddp.csv"],
        holdout: &["direct_collocation.csv"],
        mapping: "",
    },
    // voltages: errors are in V, back-EMF is viscous friction
    Set {
        folder: "bam-xl330",
        training: &["sin_sin_kp100.csv", "sin_sin_kp200.csv", "up_and_down_kp200.csv"],
        holdout: &["sin_sin_kp400.csv"],
        mapping: "",
    },
];

/// The set of a folder.
pub(crate) fn named(folder: &str) -> Option<&'static Set> {
    SETS.iter().find(|set| set.folder == folder)
}

/// Which stretch of a recording is kept out of the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum KeptOut {
    Last,
    First,
    Middle,
}

impl KeptOut {
    pub(crate) const ALL: [Self; 3] = [Self::Last, Self::First, Self::Middle];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Last => "last",
            Self::First => "first",
            Self::Middle => "middle",
        }
    }

    /// What is left of a recording, and the stretch of this share of its length.
    fn of(
        self,
        whole: &Recording,
        share: f64,
    ) -> Result<(Vec<Recording>, Vec<Recording>), RecordingError> {
        let (first, last) = (whole.time_s[0], whole.time_s[whole.len() - 1]);
        let at = |share: f64| first + share * (last - first);
        let between = |from: f64, to: f64| part(whole, |t| at(from) <= t && t < at(to));
        // beyond the last stamp
        const END: f64 = 2.0;
        let left = 1.0 - share;
        Ok(match self {
            Self::Last => (vec![between(0.0, left)?], vec![between(left, END)?]),
            Self::First => (vec![between(share, END)?], vec![between(0.0, share)?]),
            Self::Middle => {
                let (from, to) = (0.5 * left, 0.5 * (1.0 + share));
                (vec![between(0.0, from)?, between(to, END)?], vec![between(from, to)?])
            }
        })
    }
}

/// What a set's folder holds.
pub(crate) struct Data {
    pub(crate) model: ArmModel,
    /// of the plain fit
    pub(crate) cutoff_hz: f64,
    training: Vec<Recording>,
    holdout: Vec<Recording>,
}

impl Data {
    pub(crate) fn read(set: &Set, root: &Path) -> Result<Self, Box<dyn Error>> {
        Self::read_these(set, root, set.training, set.holdout)
    }

    /// A set with all its files of such names instead.
    pub(crate) fn read_files(
        set: &Set,
        root: &Path,
        parts: &[&str],
    ) -> Result<Self, Box<dyn Error>> {
        if parts.is_empty() {
            return Self::read(set, root);
        }
        let mut files = Vec::new();
        for entry in std::fs::read_dir(root.join(set.folder))? {
            let name = entry?.file_name().to_string_lossy().into_owned();
            if name.ends_with(".csv") && parts.iter().any(|part| name.contains(part)) {
                files.push(name);
            }
        }
        files.sort();
        let files: Vec<&str> = files.iter().map(String::as_str).collect();
        Self::read_these(set, root, &files, &[])
    }

    fn read_these(
        set: &Set,
        root: &Path,
        training: &[&str],
        holdout: &[&str],
    ) -> Result<Self, Box<dyn Error>> {
        let folder = root.join(set.folder);
        let dataset: toml::Table = std::fs::read_to_string(folder.join("dataset.toml"))?.parse()?;
        let baseline = dataset.get("baseline").ok_or("no baseline")?;
        let cutoff_hz = baseline
            .get("filter_hz")
            .and_then(|f| f.as_float().or(f.as_integer().map(|i| i as f64)))
            .ok_or("no filter_hz")?;
        let joints: Vec<String> = baseline
            .get("joints")
            .or(dataset.get("joints"))
            .and_then(toml::Value::as_array)
            .ok_or("no joints")?
            .iter()
            .filter_map(|j| j.as_str().map(ToOwned::to_owned))
            .collect();
        let read = |file: &&str| -> Result<Recording, Box<dyn Error>> {
            let path = folder.join(file);
            Ok(if set.mapping.is_empty() {
                read_csv(&path)?
            } else {
                read_csv_mapped(&path, &Mapping::parse(set.mapping, "mapping")?)?
            })
        };
        let read_all = |files: &[&str]| -> Result<Vec<Recording>, Box<dyn Error>> {
            files.iter().map(read).collect()
        };
        let (training, holdout) = (read_all(training)?, read_all(holdout)?);
        let urdf = dataset.get("urdf").and_then(toml::Value::as_str).ok_or("no urdf")?;
        let robot = load_urdf(&folder.join(urdf))?;
        let selection =
            ChainSelection { recorded_joints: Some(joints), ..ChainSelection::default() };
        let chain = SerialChain::from_description(&robot, &selection)?;
        let model = ArmModel::from_chain(DrivingAxisChain::from_chain(&chain));
        Ok(Self { model, cutoff_hz, training, holdout })
    }

    /// What is fitted and what is kept out. Of a set of one recording a stretch of this share; of files those
    /// named, or as many others.
    pub(crate) fn split(
        &self,
        kept_out: KeptOut,
        share: f64,
    ) -> Result<(Vec<Recording>, Vec<Recording>), RecordingError> {
        if self.holdout.is_empty() {
            return kept_out.of(&self.training[0], share);
        }
        let mut files: Vec<Recording> = self.all().cloned().collect();
        let turn = KeptOut::ALL.iter().position(|k| *k == kept_out).unwrap_or(0);
        files.rotate_left(turn);
        let holdout = files.split_off(self.training.len());
        Ok((files, holdout))
    }

    /// Whether a stretch of a recording is kept out, and not files.
    pub(crate) fn is_one_recording(&self) -> bool {
        self.holdout.is_empty()
    }

    /// All that can be kept out in turn.
    pub(crate) fn turns(&self) -> &'static [KeptOut] {
        let files = self.training.len() + self.holdout.len();
        if files == 1 { &KeptOut::ALL } else { &KeptOut::ALL[..files.min(KeptOut::ALL.len())] }
    }

    /// Everything that was recorded.
    pub(crate) fn all(&self) -> impl Iterator<Item = &Recording> {
        self.training.iter().chain(&self.holdout)
    }

    /// Motions and efforts through the low-pass of the plain fit.
    pub(crate) fn motions(&self, recordings: &[Recording]) -> Result<Vec<Motion>, RecordingError> {
        let names = self.model.chain.joint_names();
        let settings =
            MotionSettings { cutoff_hz: Some(self.cutoff_hz), ..MotionSettings::default() };
        recordings.iter().map(|r| Motion::from_recording(r, &names, &settings)).collect()
    }
}

/// The samples whose stamps are wanted.
pub(crate) fn part(
    whole: &Recording,
    wanted: impl Fn(f64) -> bool,
) -> Result<Recording, RecordingError> {
    let keep = |column: &[f64]| -> Vec<f64> {
        column.iter().zip(&whole.time_s).filter(|(_, t)| wanted(**t)).map(|(x, _)| *x).collect()
    };
    let joints = whole
        .joints
        .iter()
        .map(|joint| {
            let mut cut = JointChannels::new(&joint.name);
            for quantity in Quantity::ALL {
                *cut.channel_mut(quantity) = joint.channel(quantity).map(keep);
            }
            cut
        })
        .collect();
    Recording::new(&whole.source, keep(&whole.time_s), joints)
}
