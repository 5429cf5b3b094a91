//! `catena._catena.Sweep`: a sweep file that was read. Its shards are made without the lock of Python; `merge` puts their rows together.

use crate::refusal::named;
use crate::signals::watched;
use catena::scene::PackagePath;
use catena::study::sweep::{Done, Folder, Format, Shard, SweepError, Work, merge as merge_folders, read_sweep};
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::available_parallelism;

/// Result of `make`: runs made, failed runs, and index and reason of the first failure.
type Made = (u64, u64, Option<(u64, String)>);

/// A sweep file that was read, with all that it names.
#[pyclass(frozen, module = "catena._catena")]
pub struct Sweep {
    inner: catena::study::sweep::Sweep,
}

fn refuse(py: Python<'_>, error: &SweepError) -> PyErr {
    named(py, if error.is_input() { "InputError" } else { "RunError" }, error.to_string())
}

/// A format or shard, from its words.
fn parsed<T: FromStr<Err: ToString>>(py: Python<'_>, words: &str) -> PyResult<T> {
    words.parse().map_err(|error: T::Err| named(py, "InputError", error.to_string()))
}

fn format_of(py: Python<'_>, format: Option<&str>) -> PyResult<Format> {
    format.map_or(Ok(Format::DEFAULT), |format| parsed(py, format))
}

#[pymethods]
impl Sweep {
    #[new]
    fn new(py: Python<'_>, path: PathBuf, packages: BTreeMap<String, PathBuf>) -> PyResult<Self> {
        let packages = PackagePath::from_environment(packages.into_iter().collect());
        let inner = py.detach(|| read_sweep(&path, &packages)).map_err(|error| refuse(py, &error))?;
        Ok(Sweep { inner })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    #[getter]
    fn runs(&self) -> u64 {
        self.inner.runs
    }

    #[getter]
    fn fingerprint(&self) -> &str {
        &self.inner.fingerprint
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.inner.warnings.clone()
    }

    /// Makes the folder if it is missing, checks that it is of this sweep, and says how many rows it holds.
    fn rows_in(&self, py: Python<'_>, folder: PathBuf, format: Option<&str>) -> PyResult<u64> {
        let format = format_of(py, format)?;
        let opened = py.detach(|| Folder::open(&folder, &self.inner, Shard::WHOLE, format));
        Ok(opened.map_err(|error| refuse(py, &error))?.done())
    }

    /// Makes the runs of a shard (`K/N`) that its folder lacks, on `jobs` threads, or on all cores; calls `progress` twice a second with the number
    /// of rows on the disk and the number of all rows.
    #[pyo3(signature = (folder, shard, jobs, format, progress))]
    fn make(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        shard: &str,
        jobs: Option<usize>,
        format: Option<&str>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Made> {
        let (shard, format) = (parsed(py, shard)?, format_of(py, format)?);
        let jobs = jobs.unwrap_or_else(|| available_parallelism().map_or(1, usize::from));
        let interrupt = AtomicBool::new(false);
        // The exception raised by `progress`, which ends the work.
        let mut raised = None;
        let made = watched(py, &interrupt, || {
            let mut told = |done: &Done| {
                let Some(progress) = &progress else { return };
                if let Err(error) = Python::attach(|py| progress.call1(py, (done.done, done.runs))) {
                    raised.get_or_insert(error);
                    interrupt.store(true, Ordering::Relaxed);
                }
            };
            let mut folder = Folder::open(&folder, &self.inner, shard, format)?;
            Work { jobs, interrupt: &interrupt, told: &mut told }.finish(&self.inner, &mut folder)
        });
        if let Some(error) = raised {
            return Err(error);
        }
        let Done { made, failed, first_failure, .. } = made?.map_err(|error| refuse(py, &error))?;
        Ok((made, failed, first_failure))
    }
}

/// Puts the rows of all shards together, in the files that the whole would have; says how many rows and files there are.
#[pyfunction]
pub fn merge(py: Python<'_>, folders: Vec<PathBuf>, output: PathBuf) -> PyResult<(u64, usize)> {
    py.detach(|| merge_folders(&folders, &output)).map_err(|error| refuse(py, &error))
}

/// The vector instructions of this processor, on which the last bits of rows depend.
#[pyfunction]
pub fn instructions() -> String {
    catena::kernels::instructions()
}
