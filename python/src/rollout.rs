//! `catena._catena.rollout`: many runs at once, without the lock of Python.

use crate::model::Model;
use crate::refusal::{input, refuse};
use crate::signals::watched;
use catena::session::Rollout;
use numpy::{PyArray1, PyArray3, PyArrayMethods, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use std::sync::atomic::AtomicBool;

type Cube<'py> = Bound<'py, PyArray3<f64>>;
type Done<'py> = (Bound<'py, PyArray1<f64>>, Cube<'py>, Cube<'py>, Vec<(usize, String)>);

/// Runs the model from every row of q0 and v0.
#[pyfunction]
#[pyo3(signature = (model, q0, v0, duration, tolerance, stages, step, rate, threads))]
#[expect(clippy::too_many_arguments, reason = "each is an option of its own")]
pub fn rollout<'py>(
    py: Python<'py>,
    model: &Model,
    q0: PyReadonlyArray2<'py, f64>,
    v0: PyReadonlyArray2<'py, f64>,
    duration: Option<f64>,
    tolerance: Option<f64>,
    stages: Option<usize>,
    step: Option<f64>,
    rate: Option<f64>,
    threads: usize,
) -> PyResult<Done<'py>> {
    if stages.is_some() != step.is_some() || (tolerance.is_some() && step.is_some()) {
        return Err(input(py, "give a tolerance, or stages and step"));
    }
    let places = model.inner.coordinates();
    for (what, given, wanted) in
        [("q0", q0.as_array().ncols(), places.q_count()), ("v0", v0.as_array().ncols(), places.v_count())]
    {
        if given != wanted {
            return Err(input(py, format!("{what}: rows of {given} numbers where {wanted} are wanted")));
        }
    }
    let (runs, rows) = (q0.as_array().nrows(), v0.as_array().nrows());
    if runs != rows {
        return Err(input(py, format!("q0 has {runs} rows and v0 {rows}: give a row of each for every run")));
    }
    let (q0, v0): (Vec<f64>, Vec<f64>) =
        (q0.as_array().iter().copied().collect(), v0.as_array().iter().copied().collect());
    let interrupt = AtomicBool::new(false);
    let fixed = stages.zip(step);
    let options = Rollout { duration, tolerance, fixed, rate, threads, interrupt: Some(&interrupt) };
    let done = watched(py, &interrupt, || model.inner.rollout(&q0, &v0, &options))?;
    let done = done.map_err(|error| refuse(py, error))?;
    let samples = done.times.len();
    let q = PyArray1::from_vec(py, done.q).reshape([runs, samples, places.q_count()])?;
    let v = PyArray1::from_vec(py, done.v).reshape([runs, samples, places.v_count()])?;
    Ok((done.times.to_pyarray(py), q, v, done.failures))
}
