//! `catena._catena.rollout`: many runs at once, without the lock of Python.

use crate::model::Model;
use crate::refusal::{input, refuse};
use crate::signals::watched;
use catena::session::{Rollout, Trajectories};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use std::sync::atomic::AtomicBool;

type Cube<'py> = Bound<'py, PyArray3<f64>>;
type Given<'py> = PyReadonlyArray1<'py, f64>;
/// The sample, the names, numbers and state of each contact.
type Contacts<'py> = (Vec<usize>, Vec<String>, Bound<'py, PyArray2<f64>>, Vec<bool>);

/// What many runs have left.
#[pyclass(get_all, module = "catena._catena")]
pub struct Rolled {
    times: Py<PyArray1<f64>>,
    q: Py<PyArray3<f64>>,
    v: Py<PyArray3<f64>>,
    energies: Option<Py<PyArray3<f64>>>,
    warnings: Vec<Vec<String>>,
    failures: Vec<(usize, String)>,
    contacts: Option<Vec<Py<PyAny>>>,
}

/// Runs the model from every row of q0 and v0.
#[pyfunction]
#[pyo3(signature = (model, q0, v0, duration, tolerance, fixed, rate, threads, period, efforts, targets, feedback, reference, params, contacts, energies, estimate))]
#[expect(clippy::too_many_arguments, reason = "each is an option of its own")]
pub fn rollout<'py>(
    py: Python<'py>,
    model: &Model,
    q0: PyReadonlyArray2<'py, f64>,
    v0: PyReadonlyArray2<'py, f64>,
    duration: Option<f64>,
    tolerance: Option<f64>,
    fixed: Option<(usize, f64)>,
    rate: Option<f64>,
    threads: usize,
    period: Option<f64>,
    efforts: Given<'py>,
    targets: Given<'py>,
    feedback: Given<'py>,
    reference: Given<'py>,
    params: Vec<(String, Vec<f64>)>,
    contacts: bool,
    energies: bool,
    estimate: bool,
) -> PyResult<Rolled> {
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
    let [efforts, targets, feedback, reference] =
        [efforts, targets, feedback, reference].map(|given| crate::model::numbers(&given));
    let interrupt = AtomicBool::new(false);
    let options = Rollout {
        duration,
        tolerance,
        no_estimate: !estimate,
        fixed,
        rate,
        threads,
        interrupt: Some(&interrupt),
        period,
        efforts: &efforts,
        targets: &targets,
        feedback: &feedback,
        reference: &reference,
        params: &params,
        energies,
        contacts,
    };
    let done = watched(py, &interrupt, || model.inner.rollout(&q0, &v0, &options))?;
    let done = done.map_err(|error| refuse(py, error))?;
    let samples = done.times.len();
    let contacts = contacts.then(|| listed(py, model, &done)).transpose()?;
    let Trajectories { times, q, v, energies: parts, warnings, failures, .. } = done;
    let cube = |numbers: Vec<f64>, width: usize| -> PyResult<Cube<'py>> {
        PyArray1::from_vec(py, numbers).reshape([runs, samples, width])
    };
    Ok(Rolled {
        times: times.to_pyarray(py).unbind(),
        q: cube(q, places.q_count())?.unbind(),
        v: cube(v, places.v_count())?.unbind(),
        energies: if energies { Some(cube(parts, 4)?.unbind()) } else { None },
        warnings,
        failures,
        contacts,
    })
}

/// The contacts of each run.
fn listed(py: Python<'_>, model: &Model, done: &Trajectories) -> PyResult<Vec<Py<PyAny>>> {
    let names = model.inner.contact_pairs();
    let of_run = |run: &Vec<(usize, Vec<_>)>| {
        let points = run.iter().flat_map(|(sample, points)| points.iter().map(move |point| (*sample, point)));
        let listed: Contacts<'_> = crate::recorded::listed(py, &names, points)?;
        Ok(listed.into_pyobject(py)?.into_any().unbind())
    };
    done.contacts.iter().map(of_run).collect()
}
