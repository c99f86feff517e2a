//! Arrays of numbers, whatever Python has them in.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::error::wrong;

fn as_floats<'py>(values: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let numpy = values.py().import("numpy")?;
    numpy.call_method1("ascontiguousarray", (values, numpy.getattr("float64")?))
}

/// One column of numbers.
pub(crate) fn column(name: &str, values: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let py = values.py();
    let hint = "pass one number a sample";
    let array = as_floats(values)
        .map_err(|error| wrong(py, format!("cannot be read as numbers: {error}"), name, hint))?;
    match array.cast::<PyArray1<f64>>() {
        Ok(array) => array.to_vec().map_err(PyErr::from),
        Err(_) => {
            let shape = array.getattr("shape")?;
            Err(wrong(py, format!("expected shape (samples,), found {shape}"), name, hint))
        }
    }
}

/// Columns of a table with one row a sample: `[column][sample]`. `width` is the number of columns expected.
pub(crate) fn columns(
    name: &str,
    values: &Bound<'_, PyAny>,
    width: usize,
) -> PyResult<Vec<Vec<f64>>> {
    let py = values.py();
    let hint = "pass one row a sample and one column a joint, in the order of the joints";
    let array = as_floats(values)
        .map_err(|error| wrong(py, format!("cannot be read as numbers: {error}"), name, hint))?;
    match array.cast::<PyArray2<f64>>() {
        Ok(array) if array.shape()[1] == width => {
            let readonly = array.readonly();
            let view = readonly.as_array();
            Ok(view.columns().into_iter().map(|column| column.to_vec()).collect())
        }
        _ => {
            let shape = array.getattr("shape")?;
            Err(wrong(py, format!("expected shape (samples, {width}), found {shape}"), name, hint))
        }
    }
}

/// Rows of samples from columns: shape (samples, columns).
pub(crate) fn rows<'py>(py: Python<'py>, columns: &[&[f64]]) -> Bound<'py, PyArray2<f64>> {
    let samples = columns.first().map_or(0, |column| column.len());
    let at = |[sample, column]: [usize; 2]| columns[column][sample];
    let rows = numpy::ndarray::Array2::from_shape_fn([samples, columns.len()], |(s, c)| at([s, c]));
    PyArray2::from_owned_array(py, rows)
}
