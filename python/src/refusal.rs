//! Errors of the library as exceptions of Python, with the messages of the command line: `InputError` for wrong input, `RunError` for a run that
//! fails.

use catena::session::Error;
use pyo3::exceptions::{PyException, PyRuntimeError};
use pyo3::prelude::*;

/// An exception of the class of this name in `catena._errors`.
pub fn named(py: Python<'_>, class: &str, message: String) -> PyErr {
    let made =
        py.import("catena._errors").and_then(|errors| errors.getattr(class)).and_then(|class| class.call1((&message,)));
    match made {
        Ok(exception) => PyErr::from_value(exception),
        Err(_) => PyRuntimeError::new_err(message),
    }
}

/// The exception for wrong input.
pub fn input(py: Python<'_>, message: impl ToString) -> PyErr {
    named(py, "InputError", message.to_string())
}

/// The exception of an error; one that a controller raised is its cause. Exceptions that are no errors, as `KeyboardInterrupt` and `SystemExit`, come
/// out themselves.
pub fn refuse(py: Python<'_>, error: Error) -> PyErr {
    let cause = raised(&error).and_then(|failure| failure.downcast_ref::<PyErr>());
    if let Some(cause) = cause.filter(|cause| !cause.is_instance_of::<PyException>(py)) {
        return cause.clone_ref(py);
    }
    let class = if error.is_input() { "InputError" } else { "RunError" };
    let exception = named(py, class, error.to_string());
    if let Some(cause) = cause {
        exception.set_cause(py, Some(cause.clone_ref(py)));
    }
    exception
}

/// The failure of a controller.
fn raised(error: &Error) -> Option<&catena::session::ControllerFailure> {
    match error {
        Error::Controller { failure, .. } => Some(failure),
        Error::Beside { problem, .. } => raised(problem),
        _ => None,
    }
}
