//! Recordings: files and arrays in, arrays and files out.

use std::path::PathBuf;

use armident_commands::{ReadingOptions, expand, quality_notes, read_all};
use armident_recording::{
    Mapping, Quantity, RawColumns, ReadSettings, Recording as Recorded, encode,
    recording_of_columns, write_whole,
};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arrays;
use crate::error::{raised, wrong};
use crate::work::done;

/// Time stamps and joint channels of one measured run, checked as on the command line.
#[pyclass(frozen, module = "armident")]
pub(crate) struct Recording {
    pub(crate) recorded: Recorded,
}

/// Reads files, and the recordings in folders, with one mapping.
#[pyfunction]
#[pyo3(signature = (paths, mapping=None, topic=None))]
pub(crate) fn read(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    mapping: Option<PathBuf>,
    topic: Option<String>,
) -> PyResult<Vec<Recording>> {
    let read =
        done(py, move || read_all(&expand(&paths)?, &ReadingOptions { mapping, topic }, || ()))?;
    Ok(read.into_iter().map(|recorded| Recording { recorded }).collect())
}

#[pymethods]
impl Recording {
    /// Reads a file (CSV, MCAP, Parquet where built in).
    ///
    /// `mapping` is a TOML file that maps columns to joints, quantities and units; `topic` the joint state topic of an
    /// MCAP file.
    #[new]
    #[pyo3(signature = (path, *, mapping=None, topic=None))]
    fn new(
        py: Python<'_>,
        path: PathBuf,
        mapping: Option<PathBuf>,
        topic: Option<String>,
    ) -> PyResult<Self> {
        let mut read =
            done(py, move || read_all(&[path], &ReadingOptions { mapping, topic }, || ()))?;
        Ok(Self { recorded: read.remove(0) })
    }

    /// Recording in arrays, with the checks and repairs of a file.
    ///
    /// `time` [s] has shape (samples,), `joints` are names as in the URDF, and all others have shape (samples, joints):
    /// `position` [rad or m], `velocity` and `acceleration` per s and s², `effort` on the joint side [N m or N], `current`
    /// [A], `voltage` [V], `motor_position` divided by the gear ratio [rad or m], `temperature` [°C], `command` (the position that
    /// the joint's controller is given) [rad or m]. `source` names the recording in results.
    #[staticmethod]
    #[pyo3(signature = (time, joints, *, position=None, velocity=None, acceleration=None, effort=None, current=None,
        voltage=None, motor_position=None, temperature=None, command=None, source="arrays"))]
    fn from_arrays(
        py: Python<'_>,
        time: &Bound<'_, PyAny>,
        joints: Vec<String>,
        position: Option<Bound<'_, PyAny>>,
        velocity: Option<Bound<'_, PyAny>>,
        acceleration: Option<Bound<'_, PyAny>>,
        effort: Option<Bound<'_, PyAny>>,
        current: Option<Bound<'_, PyAny>>,
        voltage: Option<Bound<'_, PyAny>>,
        motor_position: Option<Bound<'_, PyAny>>,
        temperature: Option<Bound<'_, PyAny>>,
        command: Option<Bound<'_, PyAny>>,
        source: &str,
    ) -> PyResult<Self> {
        let given = [
            position,
            velocity,
            acceleration,
            effort,
            current,
            voltage,
            motor_position,
            temperature,
            command,
        ];
        let mut columns = vec![("t".to_owned(), arrays::column("time", time)?)];
        for (quantity, values) in Quantity::ALL.into_iter().zip(given) {
            let Some(values) = values else { continue };
            let values = arrays::columns(quantity.suffix(), &values, joints.len())?;
            let names = joints.iter().map(|joint| format!("{joint}/{quantity}"));
            columns.extend(names.zip(values));
        }
        checked(py, columns, None, source)
    }

    /// Recording in a table whose columns are named as those of a file, with the checks and repairs of a file.
    ///
    /// `table` is a pandas or Polars data frame, an Arrow table, or a dict of arrays, with a column `t` [s] and columns
    /// `<joint>/<quantity>`, or what the `mapping` (a TOML file) expects. `source` names the recording in results.
    #[staticmethod]
    #[pyo3(signature = (table, *, mapping=None, source="table"))]
    fn from_table(
        py: Python<'_>,
        table: &Bound<'_, PyAny>,
        mapping: Option<PathBuf>,
        source: &str,
    ) -> PyResult<Self> {
        // Arrow tables have `column_names`, data frames `columns`, dicts are iterated
        let names = match table.getattr_opt("column_names")? {
            Some(names) => names,
            None => table.getattr_opt("columns")?.unwrap_or_else(|| table.clone()),
        };
        let hint = "pass a data frame, an Arrow table, or a dict of arrays";
        let unnamed =
            |_: PyErr| wrong(py, "expected a table with named columns".to_owned(), source, hint);
        let mut columns = Vec::new();
        for name in names.try_iter().map_err(unnamed)? {
            let name = name?;
            let text = name.str()?.to_string();
            let values = arrays::column(&text, &table.get_item(&name).map_err(unnamed)?)?;
            columns.push((text, values));
        }
        checked(py, columns, mapping, source)
    }

    /// Path of the file, or a description.
    #[getter]
    fn source(&self) -> &str {
        &self.recorded.source
    }

    /// Names of the joints in order.
    #[getter]
    fn joints(&self) -> Vec<&str> {
        self.recorded.joint_names()
    }

    /// Time stamps [s], shape (samples,).
    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.recorded.time_s)
    }

    /// Repairs on reading, one sentence each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.recorded.notes.clone()
    }

    /// Columns of the file that are not used.
    #[getter]
    fn ignored_columns(&self) -> Vec<String> {
        self.recorded.ignored_columns.clone()
    }

    /// Samples of one quantity (`position`, `velocity`, `effort`, ...) of all joints in SI units, shape
    /// (samples, joints); None unless every joint has it.
    fn channel<'py>(
        &self,
        py: Python<'py>,
        quantity: &str,
    ) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let Some(known) = Quantity::ALL.into_iter().find(|known| known.suffix() == quantity) else {
            let known = Quantity::ALL.map(Quantity::suffix).join(", ");
            let hint = format!("pass one of {known}");
            return Err(wrong(py, format!("unknown quantity `{quantity}`"), "quantity", &hint));
        };
        let columns: Option<Vec<&[f64]>> =
            self.recorded.joints.iter().map(|joint| joint.channel(known)).collect();
        Ok(columns.map(|columns| arrays::rows(py, &columns)))
    }

    /// Gaps, stuck or saturated channels and other findings that reading keeps, one sentence each.
    fn quality_notes(&self) -> Vec<String> {
        quality_notes(std::slice::from_ref(&self.recorded))
    }

    /// Writes the recording in the format of the extension; returns the channels that the format cannot hold.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<Vec<String>> {
        let recorded = self.recorded.clone();
        done(py, move || {
            let encoded = encode(&recorded, &path)?;
            write_whole(&path, |file| std::io::Write::write_all(file, &encoded.bytes))
                .map_err(|error| armident_commands::Failure::unwritable(&path, &error))?;
            Ok(encoded.omitted)
        })
    }

    fn __len__(&self) -> usize {
        self.recorded.len()
    }

    fn __repr__(&self) -> String {
        let Recorded { source, time_s, joints, .. } = &self.recorded;
        let span = time_s.last().unwrap_or(&0.0) - time_s.first().unwrap_or(&0.0);
        format!(
            "<Recording {source}: {} joints, {} samples, {span:.4} s>",
            joints.len(),
            time_s.len()
        )
    }
}

/// Columns named as in a file, with the checks and repairs of a file.
fn checked(
    py: Python<'_>,
    columns: Vec<(String, Vec<f64>)>,
    mapping: Option<PathBuf>,
    source: &str,
) -> PyResult<Recording> {
    let expected = columns.first().map_or(0, |(_, values)| values.len());
    if let Some((name, values)) = columns.iter().find(|(_, values)| values.len() != expected) {
        let what =
            format!("expected {expected} samples as in the first column, found {}", values.len());
        return Err(wrong(py, what, name, "pass columns of equal length"));
    }
    let start = RawColumns::new(source);
    let raw = columns.into_iter().fold(start, |raw, (name, values)| raw.with(name, values));
    let recorded = done(py, move || {
        let mapping = mapping.as_deref().map(Mapping::load).transpose()?;
        let settings = ReadSettings { mapping: mapping.as_ref(), topic: None };
        Ok(recording_of_columns(raw, &settings)?)
    })?;
    Ok(Recording { recorded })
}

/// Recordings as the library takes them.
pub(crate) fn recorded(recordings: &[PyRef<'_, Recording>]) -> Vec<Recorded> {
    recordings.iter().map(|recording| recording.recorded.clone()).collect()
}

/// Recording with arrays of all joints, for predictions: `t`, and position, velocity and acceleration by joint.
pub(crate) fn of_motion(
    py: Python<'_>,
    joints: &[String],
    time_s: Vec<f64>,
    motion: [Vec<Vec<f64>>; 3],
) -> PyResult<Recorded> {
    let [position, velocity, acceleration] = motion;
    let channels = (joints.iter().zip(position).zip(velocity).zip(acceleration))
        .map(|(((name, position), velocity), acceleration)| armident_recording::JointChannels {
            position: Some(position),
            velocity: Some(velocity),
            acceleration: Some(acceleration),
            ..armident_recording::JointChannels::new(name)
        })
        .collect();
    Recorded::new("arrays", time_s, channels).map_err(|error| raised(py, &error.into()))
}
