//! Work without the interpreter.

use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use armident_commands::Failure;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::error::raised;

/// How long Ctrl-C waits at most.
const ATTENTION: Duration = Duration::from_millis(50);
/// Stack of the working thread, as large as that of a program's main thread.
const STACK: usize = 8 << 20;

/// Does work in a thread of its own, without the interpreter, and looks for Ctrl-C meanwhile. Work that was interrupted
/// has no way to stop: it continues to its end, and its result is dropped.
pub(crate) fn done<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let (sender, receiver) = mpsc::channel();
    std::thread::Builder::new()
        .name("armident".to_owned())
        .stack_size(STACK)
        .spawn(move || {
            // after Ctrl-C there is no receiver
            let _ = sender.send(work());
        })
        .map_err(|error| PyRuntimeError::new_err(format!("cannot start a thread: {error}")))?;
    // a receiver cannot be shared, but it can be lent to the waiting closure
    let receiver = std::sync::Mutex::new(receiver);
    loop {
        let received = py.detach(|| match receiver.lock() {
            Ok(receiver) => receiver.recv_timeout(ATTENTION),
            Err(_) => Err(RecvTimeoutError::Disconnected),
        });
        match received {
            Ok(result) => return result.map_err(|failure| raised(py, &failure)),
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("the work ended without a result"));
            }
        }
    }
}
