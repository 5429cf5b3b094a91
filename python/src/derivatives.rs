//! Linear equations of motion as Python has them, and the loss of a gradient.

use crate::model::{Given, numbers};
use catena::nalgebra::DMatrix;
use catena::session::{EventLost, Linear, Lost, Mode, Samples};
use numpy::{PyArray2, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;

/// Linear equations of motion, by name.
pub fn linear_equations<'py>(py: Python<'py>, linear: &Linear) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let matrices = [
        ("A", &linear.a),
        ("B", &linear.b),
        ("B_targets", &linear.b_targets),
        ("inertia", &linear.inertia),
        ("damping", &linear.damping),
        ("stiffness", &linear.stiffness),
    ];
    for (name, of) in matrices {
        let array = PyArray2::from_owned_array(
            py,
            numpy::ndarray::Array2::from_shape_fn(of.shape(), |(row, column)| of[(row, column)]),
        );
        out.set_item(name, array)?;
    }
    out.set_item("names", &linear.names)?;
    out.set_item("units", &linear.units)?;
    out.set_item("velocities", &linear.velocities)?;
    out.set_item("freedoms", &linear.freedoms)?;
    out.set_item("targets", &linear.targets)?;
    out.set_item("q", linear.q.to_pyarray(py))?;
    out.set_item("v", linear.v.to_pyarray(py))?;
    out.set_item("largest_acceleration", linear.largest_acceleration)?;
    out.set_item("iterations", linear.iterations)?;
    out.set_item("stuck", linear.stuck.iter().cloned().collect::<BTreeMap<_, _>>())?;
    out.set_item("saturated", &linear.saturated)?;
    let kinds = [linear.sticking_contacts, linear.rolling_contacts, linear.sliding_contacts];
    ["sticking_contacts", "rolling_contacts", "sliding_contacts"]
        .iter()
        .zip(kinds)
        .try_for_each(|(name, count)| out.set_item(name, count))?;
    let modes: Vec<_> = linear.modes.iter().collect();
    let parts = |of: &dyn Fn(&Mode) -> f64| modes.iter().map(|mode| of(mode)).collect::<Vec<f64>>().to_pyarray(py);
    out.set_item("eigenvalues_re", parts(&|mode| mode.eigenvalue.re))?;
    out.set_item("eigenvalues_im", parts(&|mode| mode.eigenvalue.im))?;
    let shapes: Vec<Vec<(f64, f64)>> =
        modes.iter().map(|mode| mode.shape.iter().map(|entry| (entry.re, entry.im)).collect()).collect();
    out.set_item("shapes", shapes)?;
    out.set_item("stable", modes.iter().map(|mode| mode.stability.word()).collect::<Vec<_>>())?;
    Ok(out)
}

/// A_d, and B_d of efforts and of targets, of a system whose inputs are held over a step (s).
#[pyfunction]
pub fn discrete<'py>(
    py: Python<'py>,
    a: PyReadonlyArray2<'py, f64>,
    b: PyReadonlyArray2<'py, f64>,
    b_targets: PyReadonlyArray2<'py, f64>,
    step: f64,
) -> [Bound<'py, PyArray2<f64>>; 3] {
    let given = [a, b, b_targets].map(|of| {
        let of = of.as_array();
        DMatrix::from_fn(of.nrows(), of.ncols(), |row, column| of[(row, column)])
    });
    let (a, [b, b_targets]) = catena::session::discrete(&given[0], [&given[1], &given[2]], step);
    [a, b, b_targets].map(|of| {
        let entry = |(row, column)| of[(row, column)];
        PyArray2::from_owned_array(py, numpy::ndarray::Array2::from_shape_fn(of.shape(), entry))
    })
}

/// The answer of a loss: its value, its derivatives by q and v of the samples, and its derivatives by events with their numbers.
pub fn lost(loss: &Py<PyAny>, samples: &Samples) -> PyResult<Lost> {
    type Rows<'py> = PyReadonlyArray2<'py, f64>;
    type OfEvent<'py> = (usize, f64, Option<Given<'py>>, Option<Given<'py>>);
    Python::attach(|py| {
        let events: PyResult<Vec<Bound<'_, PyDict>>> = (samples.events.iter())
            .map(|event| {
                let one = PyDict::new(py);
                one.set_item("t", event.time)?;
                one.set_item("what", &event.what)?;
                one.set_item("q", event.q.to_pyarray(py))?;
                one.set_item("v", event.v.to_pyarray(py))?;
                Ok(one)
            })
            .collect();
        let [q, v] = [&samples.q, &samples.v].map(|of| PyArray2::from_vec2(py, of));
        let said = loss.call1(py, (samples.times.to_pyarray(py), q?, v?, events?))?;
        let (value, by_q, by_v, by_events): (f64, Rows<'_>, Rows<'_>, Vec<OfEvent<'_>>) = said.extract(py)?;
        let rows = |of: &Rows<'_>| of.as_array().rows().into_iter().map(|row| row.to_vec()).collect();
        let part = |of: Option<Given<'_>>| of.map_or_else(Vec::new, |of| numbers(&of));
        let by_events = by_events
            .into_iter()
            .map(|(event, time, by_q, by_v)| EventLost { event, time, by_q: part(by_q), by_v: part(by_v) })
            .collect();
        Ok(Lost { value, by_q: rows(&by_q), by_v: rows(&by_v), by_events })
    })
}
