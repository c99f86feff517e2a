//! The Python module `armident._armident`: robots, recordings and the commands of [`armident_commands`]. The package
//! `armident` (`python/armident`) adds keyword arguments with their documentation, and results with attributes.

// doc comments are the documentation in Python, in which [s] is a unit
#![allow(rustdoc::broken_intra_doc_links)]
// functions of Python get their arguments as values
#![allow(clippy::needless_pass_by_value)]

mod answer;
mod arrays;
mod commands;
mod error;
mod recording;
mod robot;
mod work;

/// Robots, recordings, and commands that turn them into results.
#[pyo3::pymodule]
mod _armident {
    #[pymodule_export]
    use crate::answer::Answer;
    #[pymodule_export]
    use crate::commands::{
        accumulate, check, convert, diagnose, excite, export, fleet, identify, info, merge,
        one_to_convert, params, predict, schemas, simulate, validate,
    };
    #[pymodule_export]
    use crate::error::{ArmidentError, refuse};
    #[pymodule_export]
    use crate::recording::{Recording, read};
    #[pymodule_export]
    use crate::robot::Robot;

    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        use pyo3::types::PyModuleMethods;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
