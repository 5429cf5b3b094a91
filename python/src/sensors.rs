//! `catena._catena.Sensed` and `Noise`: readings of sensors at one instant, and what disturbs them.

use crate::model::{Vector, few, numbers};
use crate::refusal::refuse;
use numpy::{PyReadonlyArray1, ToPyArray};
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};

/// What sensors measure at one instant.
#[pyclass(frozen, module = "catena._catena")]
pub struct Sensed {
    pub inner: catena::session::Sensed,
}

#[pymethods]
impl Sensed {
    #[pyo3(signature = (link, place))]
    fn imu<'py>(&self, py: Python<'py>, link: &str, place: [f64; 3]) -> PyResult<Vector<'py>> {
        few(py, self.inner.imu(link, place))
    }

    fn joint_effort(&self, py: Python<'_>, joint: &str) -> PyResult<f64> {
        self.inner.joint_effort(joint).map_err(|error| refuse(py, error))
    }

    fn wrench<'py>(&self, py: Python<'py>, joint: &str) -> PyResult<Vector<'py>> {
        few(py, self.inner.wrench(joint))
    }

    fn contact_force<'py>(&self, py: Python<'py>, link: &str) -> PyResult<Vector<'py>> {
        few(py, self.inner.contact_force(link))
    }

    fn touches(&self, py: Python<'_>, link: &str) -> PyResult<bool> {
        self.inner.touches(link).map_err(|error| refuse(py, error))
    }
}

/// Noise of a sensor.
#[pyclass(frozen, module = "catena._catena")]
pub struct Noise {
    inner: Mutex<catena::session::Noise>,
}

#[pymethods]
impl Noise {
    #[new]
    #[pyo3(signature = (bias, deviation, seed))]
    fn new(bias: f64, deviation: f64, seed: u64) -> Self {
        Noise { inner: Mutex::new(catena::session::Noise::new(bias, deviation, seed)) }
    }

    /// Readings with noise.
    fn add<'py>(&self, py: Python<'py>, readings: PyReadonlyArray1<'py, f64>) -> Vector<'py> {
        let mut readings = numbers(&readings);
        self.inner.lock().unwrap_or_else(PoisonError::into_inner).add(&mut readings);
        readings.to_pyarray(py)
    }
}
