//! The Python module `catena._catena`: models, runs, their results, and the command line.
//!
//! Everything is worked out by `catena::session`, on which the command line builds, too. The convenient layer for Python (names of joints as keys,
//! tables, plots) is in `catena/*.py`.

mod derivatives;
mod model;
mod recorded;
mod refusal;
mod rollout;
mod run;
mod sensors;
mod signals;
mod sweep;

use pyo3::prelude::*;
use std::ffi::OsString;

/// The command line: the words from the name of the program on; returns the exit code.
#[pyfunction]
fn main(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| catena::cli::main_of(words))
}

#[pymodule]
fn _catena(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<model::Model>()?;
    module.add_class::<run::Run>()?;
    module.add_class::<run::State>()?;
    module.add_class::<sensors::Sensed>()?;
    module.add_class::<sensors::Noise>()?;
    module.add_class::<run::Batch>()?;
    module.add_class::<recorded::Recorded>()?;
    module.add_class::<rollout::Rolled>()?;
    module.add_class::<sweep::Sweep>()?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    module.add_function(wrap_pyfunction!(derivatives::discrete, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::merge, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::instructions, module)?)?;
    module.add_function(wrap_pyfunction!(rollout::rollout, module)?)
}
