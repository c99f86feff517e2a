//! From recordings and predictions to what is drawn of them.

use armident_kinematics::DrivingAxisChain;
use armident_motion::quality;
use armident_recording::{Recording, RecordingError};

use crate::drawing::{
    Channel, Drawing, DrawnQuantity, EffortTraces, JointName, JointResidual, Map, Quality,
    RecordingRole, RecordingTraces, Skeleton,
};
use crate::reduce::{rounded, samples_per_pair, smallest_and_largest};
use crate::sheet::{Compared, Sheet};
use crate::{residual_maps, spectrum};

/// Values of all series of the traces together: bounds the size of a page whatever is recorded.
const TRACE_VALUES: usize = 420_000;
/// Values of one series, at least and at most.
const SERIES_VALUES: [usize; 2] = [300, 4000];
/// Poses of the arm that are kept.
const POSES: usize = 240;

/// What is drawn of some recordings of one arm.
pub struct Canvas<'a> {
    pub(crate) chain: &'a DrivingAxisChain,
    pub(crate) sheets: Vec<Sheet>,
    models: Vec<String>,
    quality: Vec<Quality>,
}

impl<'a> Canvas<'a> {
    /// `models` names the models that `compared` holds predictions of, the given one first.
    ///
    /// # Errors
    /// A recording without the positions of the joints, or mostly gaps.
    pub fn new(
        chain: &'a DrivingAxisChain,
        models: &[&str],
        compared: &[Compared<'_>],
    ) -> Result<Self, RecordingError> {
        let joints = chain.joint_names();
        let sheets = compared.iter().map(|c| Sheet::new(&joints, c)).collect::<Result<_, _>>()?;
        Ok(Self {
            chain,
            sheets,
            models: models.iter().map(ToString::to_string).collect(),
            quality: compared.iter().map(|c| quality_of(c.recording, c.role)).collect(),
        })
    }

    /// Recordings that were fitted; all where none was.
    pub(crate) fn fitted(&self) -> Vec<&Sheet> {
        let training: Vec<&Sheet> =
            self.sheets.iter().filter(|s| s.role == RecordingRole::Training).collect();
        if training.is_empty() { self.sheets.iter().collect() } else { training }
    }

    /// The drawing, without findings.
    pub fn drawing(&self) -> Drawing {
        Drawing {
            joints: joint_names(self.chain),
            quantity: self.quantity(),
            models: self.models.clone(),
            recordings: self.traces(),
            residuals: (0..self.chain.dof()).map(|j| self.residual(j)).collect(),
            skeleton: self.skeleton(),
            quality: self.quality.clone(),
            ..Drawing::default()
        }
    }

    pub(crate) fn quantity(&self) -> DrawnQuantity {
        self.sheets.first().map(|sheet| sheet.quantity).unwrap_or_default()
    }

    fn traces(&self) -> Vec<RecordingTraces> {
        let series = self.chain.dof() * (1 + 2 * self.models.len());
        let samples: usize = self.sheets.iter().map(|s| s.motion.len()).sum();
        self.sheets
            .iter()
            .map(|sheet| {
                // long recordings get more of the values than short ones
                let share = sheet.motion.len() as f64 / samples.max(1) as f64;
                let values = (share * (TRACE_VALUES / series.max(1)) as f64) as usize;
                let points = values.clamp(SERIES_VALUES[0], SERIES_VALUES[1]);
                let block = samples_per_pair(sheet.motion.len(), points);
                let reduced = |x: &[f64]| rounded(&smallest_and_largest(x, block));
                let of = |all: &[Vec<Vec<f64>>], j: usize| {
                    all.iter().map(|model| reduced(&model[j])).collect()
                };
                let half = if block <= 1 { 1.0 } else { 0.5 * block as f64 };
                RecordingTraces {
                    source: sheet.motion.source.clone(),
                    role: sheet.role,
                    duration_s: sheet.motion.len() as f64 / sheet.motion.rate_hz,
                    step_s: half / sheet.motion.rate_hz,
                    samples_per_pair: block,
                    joints: (0..self.chain.dof())
                        .filter(|_| !sheet.measured.is_empty())
                        .map(|j| EffortTraces {
                            measured: reduced(&sheet.measured[j]),
                            predicted: of(&sheet.predicted, j),
                            residual: of(&sheet.residual, j),
                        })
                        .collect(),
                }
            })
            .collect()
    }

    fn residual(&self, joint: usize) -> JointResidual {
        let sheets = self.fitted();
        let measured: Vec<f64> =
            sheets.iter().flat_map(|s| s.of(&s.measured[joint]).iter().copied()).collect();
        if measured.is_empty() {
            return JointResidual::default();
        }
        let mean = measured.iter().sum::<f64>() / measured.len() as f64;
        let variance: f64 = measured.iter().map(|m| (m - mean).powi(2)).sum();
        let rms = (0..self.models.len())
            .map(|m| {
                let squares: f64 =
                    sheets.iter().flat_map(|s| s.of(&s.residual[m][joint])).map(|r| r * r).sum();
                (squares / measured.len() as f64).sqrt()
            })
            .collect();
        let (autocorrelation, white_bound) = spectrum::autocorrelation(&sheets, joint);
        JointResidual {
            effort_deviation: (variance / measured.len() as f64).sqrt(),
            rms,
            speed_position: residual_maps::speed_position(&sheets, joint).mean_residuals(&sheets),
            load_direction: match self.quantity() {
                DrawnQuantity::Effort => {
                    residual_maps::load_direction(&sheets, joint).mean_residuals(&sheets)
                }
                DrawnQuantity::Position => Map::default(),
            },
            time: residual_maps::time(&sheets, joint),
            spectrum: spectrum::spectrum(&sheets, joint),
            orders: spectrum::orders(&sheets, joint, self.chain.joints[joint].kind),
            autocorrelation,
            white_bound,
        }
    }

    /// The arm over the first recording, in the frames of the URDF.
    fn skeleton(&self) -> Option<Skeleton> {
        let motion = &self.sheets.first()?.motion;
        let n = self.chain.dof();
        let stride = motion.len().div_ceil(POSES).max(1);
        let at: Vec<usize> = (0..motion.len()).step_by(stride).collect();
        let millimetres = |x: f64| (x * 1e3).round() / 1e3 + 0.0;
        let points_m = at
            .iter()
            .map(|&k| {
                let q: Vec<f64> = (0..n).map(|j| motion.position[j][k]).collect();
                let links = self.chain.child_links_in_base(&q);
                let frames = self.chain.frames_in_base(&q);
                let tip = frames.last().map(|e| e * self.chain.tip_in_e);
                let origins = links.iter().chain(&tip).map(|pose| {
                    let p = pose.translation.vector;
                    [millimetres(p.x), millimetres(p.y), millimetres(p.z)]
                });
                [[0.0; 3]].into_iter().chain(origins).collect()
            })
            .collect();
        Some(Skeleton {
            source: motion.source.clone(),
            time_s: at
                .iter()
                .map(|&k| ((motion.time_s[k] - motion.time_s[0]) * 1e3).round() / 1e3)
                .collect(),
            points_m,
        })
    }
}

fn joint_names(chain: &DrivingAxisChain) -> Vec<JointName> {
    chain
        .joints
        .iter()
        .map(|j| {
            let (position, effort) =
                if j.kind.is_rotational() { ("rad", "N m") } else { ("m", "N") };
            JointName {
                name: j.name.clone(),
                position_unit: position.to_owned(),
                effort_unit: effort.to_owned(),
                link: j.child_link.clone(),
            }
        })
        .collect()
}

fn quality_of(recording: &Recording, role: RecordingRole) -> Quality {
    let found = quality(recording);
    Quality {
        source: found.source,
        role,
        samples: found.samples,
        rate_hz: found.timing.rate_hz,
        duration_s: found.timing.duration_s,
        jitter: found.timing.jitter,
        gaps: found.timing.gaps.len(),
        longest_gap_s: found.timing.gaps.iter().map(|g| g.length_s).fold(0.0, f64::max),
        findings: recording
            .notes
            .iter()
            .cloned()
            .chain(found.findings.iter().map(|f| match &f.advice {
                Some(advice) => format!("{} ({advice})", f.message),
                None => f.message.clone(),
            }))
            .collect(),
        channels: found
            .channels
            .iter()
            .map(|c| Channel {
                name: format!("{}/{}", c.joint, c.quantity),
                smallest: c.smallest,
                largest: c.largest,
                noise: c.noise,
                step: c.step,
                saturated_share: c.saturated_share,
                stuck_share: c.stuck_share,
            })
            .collect(),
    }
}
