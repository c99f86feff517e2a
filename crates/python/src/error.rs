//! Failures as Python exceptions.

use armident_commands::Failure;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

pyo3::create_exception!(
    armident,
    ArmidentError,
    PyValueError,
    "What failed, in three lines: `what` was expected and found, `place` (file, line or column, joint), `hint` (what to do)."
);

/// The exception of a failure.
pub(crate) fn raised(py: Python<'_>, failure: &Failure) -> PyErr {
    let error = ArmidentError::new_err(failure.to_string());
    let value = error.value(py);
    let set = || -> PyResult<()> {
        value.setattr("what", failure.what())?;
        value.setattr("place", failure.place())?;
        value.setattr("hint", failure.hint())
    };
    match set() {
        Ok(()) => error,
        Err(error) => error,
    }
}

/// The exception of a wrong argument.
pub(crate) fn wrong(py: Python<'_>, what: String, place: &str, hint: &str) -> PyErr {
    raised(py, &Failure::new(what, place, Some(hint)))
}

/// Raises `ArmidentError`.
#[pyfunction]
pub(crate) fn refuse(py: Python<'_>, what: String, place: &str, hint: &str) -> PyResult<()> {
    Err(wrong(py, what, place, hint))
}
