//! Robots: URDF and model files in, efforts and files out.

use std::collections::BTreeMap;
use std::path::PathBuf;

use armident_commands::{ChainOptions, Failure, GivenRobot, predict};
use armident_model::ArmModel;
use armident_recording::{MIN_SAMPLES, Recording as Recorded};
use armident_simulation::{SimulatedArm, Trajectory, inverse};
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::arrays;
use crate::error::{raised, wrong};
use crate::recording::{Recording, of_motion};
use crate::work::done;

/// Time between rows of arrays without times [s].
const STEP_S: f64 = 0.01;

/// A robot arm: from a URDF, or a model that was identified or diagnosed.
#[pyclass(frozen, module = "armident")]
pub(crate) struct Robot {
    pub(crate) given: GivenRobot,
}

impl Robot {
    fn arm(&self, py: Python<'_>) -> PyResult<ArmModel> {
        self.given.arm(None).map_err(|failure| raised(py, &failure))
    }
}

fn names(model: &ArmModel) -> Vec<String> {
    model.chain.joint_names().into_iter().map(str::to_owned).collect()
}

#[pymethods]
impl Robot {
    /// Reads a URDF, or a model file (`.json`).
    #[new]
    #[pyo3(signature = (path, *, base=None, tip=None, lock=None, gravity=None, snap_rpy=None))]
    fn new(
        py: Python<'_>,
        path: PathBuf,
        base: Option<String>,
        tip: Option<String>,
        lock: Option<BTreeMap<String, f64>>,
        gravity: Option<[f64; 3]>,
        snap_rpy: Option<f64>,
    ) -> PyResult<Self> {
        let chain = ChainOptions {
            base,
            tip,
            lock: lock.unwrap_or_default().into_iter().collect(),
            gravity,
            snap_rpy_rad: snap_rpy.unwrap_or(ChainOptions::default().snap_rpy_rad),
        };
        Ok(Self { given: done(py, move || GivenRobot::open(&path, chain))? })
    }

    /// Path of the file, or a description of a model in memory.
    #[getter]
    fn source(&self) -> &str {
        &self.given.source
    }

    /// Whether it is a model that was identified or diagnosed.
    #[getter]
    fn is_model(&self) -> bool {
        self.given.is_model()
    }

    /// Names of the joints of the arm in order.
    #[getter]
    fn joints(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(names(&self.arm(py)?))
    }

    /// Effects on joints beyond the rigid body: law, joint, parameters in the units of the law.
    #[getter]
    fn effects(&self, py: Python<'_>) -> PyResult<Vec<(String, String, Vec<f64>)>> {
        let effects = self.arm(py)?.effects;
        Ok(effects.into_iter().map(|on| (on.effect, on.joint, on.parameters)).collect())
    }

    /// What a model holds that `predict` of arrays lacks, one sentence each.
    #[getter]
    fn omitted_from_arrays(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let arm = self.arm(py)?;
        Ok(if arm.band.is_some() { arm.simulated().1 } else { Vec::new() })
    }

    /// Writes the model as JSON, for every command that takes a robot.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let arm = self.arm(py)?;
        done(py, move || arm.save(&path).map_err(|error| Failure::unwritable(&path, &error)))
    }

    /// Efforts of a motion, shape (samples, joints) [N m or N].
    #[pyo3(signature = (q, v=None, a=None, *, t=None, cutoff_hz=None))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        v: Option<&Bound<'py, PyAny>>,
        a: Option<&Bound<'py, PyAny>>,
        t: Option<&Bound<'py, PyAny>>,
        cutoff_hz: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let efforts = match (q.cast::<Recording>(), v, a) {
            (Ok(motion), None, None) if t.is_none() => {
                let (given, motion) = (self.given.clone(), motion.get().recorded.clone());
                done(py, move || Ok(predict(&given, &motion, cutoff_hz)?.channels))?
            }
            (Err(_), Some(v), Some(a)) if cutoff_hz.is_none() => {
                return self.predict_arrays(py, [q, v, a], t);
            }
            _ => {
                let what = "expected a recording, or arrays q, v and a".to_owned();
                let hint = "call predict(recording, cutoff_hz=...) or predict(q, v, a, t=...)";
                return Err(wrong(py, what, "predict", hint));
            }
        };
        let columns: Vec<&[f64]> =
            efforts.joints.iter().filter_map(|joint| joint.effort.as_deref()).collect();
        Ok(arrays::rows(py, &columns))
    }

    fn __repr__(&self) -> String {
        let kind = if self.given.is_model() { "model" } else { "URDF" };
        format!("<Robot {} ({kind})>", self.given.source)
    }
}

impl Robot {
    fn predict_arrays<'py>(
        &self,
        py: Python<'py>,
        motion: [&Bound<'py, PyAny>; 3],
        t: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let arm = self.arm(py)?;
        let joints = names(&arm);
        let mut columns = [const { Vec::new() }; 3];
        for ((name, values), columns) in ["q", "v", "a"].into_iter().zip(motion).zip(&mut columns) {
            *columns = arrays::columns(name, values, joints.len())?;
        }
        let samples = columns[0].first().map_or(0, Vec::len);
        let mut time_s = match t {
            Some(t) => arrays::column("t", t)?,
            None => (0..samples).map(|k| k as f64 * STEP_S).collect(),
        };
        for (name, found) in
            [("v", columns[1][0].len()), ("a", columns[2][0].len()), ("t", time_s.len())]
        {
            if found != samples {
                let what = format!("expected {samples} samples as in q, found {found}");
                return Err(wrong(py, what, name, "pass one row a sample in q, v, a and t"));
            }
        }
        if samples == 0 {
            return Ok(arrays::rows(py, &vec![&[] as &[f64]; joints.len()]));
        }
        // the last row is repeated where there are fewer than a recording has
        for column in columns.iter_mut().flatten() {
            let last = column[samples - 1];
            column.resize(samples.max(MIN_SAMPLES), last);
        }
        for k in samples..MIN_SAMPLES {
            time_s.push(time_s[k - 1] + STEP_S);
        }
        let motion = of_motion(py, &joints, time_s, columns)?;
        let efforts = done(py, move || efforts_of(&arm, &joints, &motion))?;
        let columns: Vec<&[f64]> = efforts.iter().map(|effort| &effort[..samples]).collect();
        Ok(arrays::rows(py, &columns))
    }
}

/// Efforts of recorded positions, velocities and accelerations as they are. A model that was fitted in a band predicts
/// from positions alone: its arm in software takes its place.
fn efforts_of(
    arm: &ArmModel,
    joints: &[String],
    motion: &Recorded,
) -> Result<Vec<Vec<f64>>, Failure> {
    if arm.band.is_none() {
        return Ok(arm.predict(motion, None)?.efforts);
    }
    let (simulated, _) = arm.simulated();
    let arm = SimulatedArm::on_chain(&simulated.chain, &simulated.effects)?;
    let trajectory = Trajectory::from_recording(motion, joints, &BTreeMap::new())?;
    let recording = inverse(&arm, &trajectory)?;
    Ok(recording.joints.into_iter().filter_map(|joint| joint.effort).collect())
}
