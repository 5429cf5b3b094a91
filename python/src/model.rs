//! `catena.Model`: a robot or scene, and its equations of motion.

use crate::derivatives::{linear_equations, lost};
use crate::refusal::{input, refuse};
use catena::model::Left;
use catena::nalgebra::{DMatrix, DVector};
use catena::scene::Touching;
use catena::session::{Backward, Error, Hold, JointPlace, Loader, Lost, Simulation};
use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray1, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;

/// A robot or scene, ready to be simulated.
#[pyclass(frozen, module = "catena._catena")]
pub struct Model {
    pub inner: catena::session::Model,
}

pub type Vector<'py> = Bound<'py, PyArray1<f64>>;
type Matrix<'py> = Bound<'py, PyArray2<f64>>;
pub type Given<'py> = PyReadonlyArray1<'py, f64>;
/// Multipliers as real and imaginary parts, how far the end is from the start, and warnings.
type Multiplied = (Vec<(f64, f64)>, f64, Vec<String>);

/// Numbers of an array, whatever its strides.
pub fn numbers(given: &Given<'_>) -> Vec<f64> {
    given.as_array().iter().copied().collect()
}

fn matrix<'py>(py: Python<'py>, matrix: &DMatrix<f64>) -> PyResult<Matrix<'py>> {
    let rows: Vec<Vec<f64>> = matrix.row_iter().map(|row| row.iter().copied().collect()).collect();
    Ok(PyArray2::from_vec2(py, &rows)?)
}

/// Numbers along v, or the reason for their absence.
fn vector<'py>(py: Python<'py>, numbers: Result<DVector<f64>, Error>) -> PyResult<Vector<'py>> {
    Ok(numbers.map_err(|error| refuse(py, error))?.as_slice().to_pyarray(py))
}

/// A few numbers, or why there are none.
pub fn few<'py, const N: usize>(
    py: Python<'py>,
    numbers: Result<catena::nalgebra::SVector<f64, N>, Error>,
) -> PyResult<Vector<'py>> {
    Ok(numbers.map_err(|error| refuse(py, error))?.as_slice().to_pyarray(py))
}

#[pymethods]
impl Model {
    #[new]
    #[pyo3(signature = (path, floating, base_pose, gravity, floor, contact, without, packages, params, hold, keyframe))]
    #[expect(clippy::too_many_arguments, reason = "each is an option of its own")]
    fn new(
        py: Python<'_>,
        path: PathBuf,
        floating: bool,
        base_pose: Option<[f64; 6]>,
        gravity: Option<[f64; 3]>,
        floor: Option<f64>,
        contact: Option<String>,
        without: Vec<String>,
        packages: BTreeMap<String, PathBuf>,
        params: BTreeMap<String, f64>,
        hold: Option<(Option<f64>, Option<f64>, Option<f64>)>,
        keyframe: Option<String>,
    ) -> PyResult<Self> {
        let mut loader = Loader::default();
        if let Some((kp, kd, gravity)) = hold {
            loader = loader.hold(Hold { kp, kd, gravity });
        }
        if let Some(name) = keyframe {
            loader = loader.keyframe(&name);
        }
        if floating {
            loader = loader.floating();
        }
        if let Some(pose) = base_pose {
            loader = loader.base_pose(pose);
        }
        if let Some(gravity) = gravity {
            loader = loader.gravity(gravity);
        }
        if let Some(height) = floor {
            loader = loader.floor(height);
        }
        if let Some(touching) = contact {
            loader = loader.contact(touching.parse::<Touching>().map_err(|error| input(py, error))?);
        }
        for left in without {
            loader = loader.without(left.parse::<Left>().map_err(|error| input(py, error))?);
        }
        for (name, folder) in packages {
            loader = loader.package(&name, folder);
        }
        for (key, number) in params {
            loader = loader.set(&key, number);
        }
        let inner = py.detach(|| loader.load(path)).map_err(|error| refuse(py, error))?;
        Ok(Model { inner })
    }

    #[getter]
    fn path(&self) -> PathBuf {
        self.inner.path().to_path_buf()
    }

    #[getter]
    fn name(&self) -> &str {
        &self.inner.description().mechanism.name
    }

    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        self.inner.joint_names()
    }

    #[getter]
    fn link_names(&self) -> Vec<&str> {
        self.inner.link_names()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.inner.warnings()
    }

    #[getter]
    fn motor_names(&self) -> Vec<&str> {
        self.inner.motor_names()
    }

    /// Names `a|b` of the pairs of shapes that may touch.
    fn contact_pairs(&self) -> Vec<String> {
        self.inner.contact_pairs()
    }

    /// First and last entry of each joint in q.
    fn q_places(&self) -> Vec<(&str, usize, usize)> {
        self.places(|joint| &joint.q)
    }

    /// First and last entry of each joint in v.
    fn v_places(&self) -> Vec<(&str, usize, usize)> {
        self.places(|joint| &joint.v)
    }

    fn start<'py>(&self, py: Python<'py>) -> PyResult<(Vector<'py>, Vector<'py>)> {
        let (q, v) = self.inner.start().map_err(|error| refuse(py, error))?;
        Ok((q.to_pyarray(py), v.to_pyarray(py)))
    }

    /// q and v in the sample of a log that is nearest to a time (s), or in its last one.
    fn logged<'py>(&self, py: Python<'py>, log: PathBuf, time: Option<f64>) -> PyResult<(Vector<'py>, Vector<'py>)> {
        let (description, places) = (self.inner.description(), self.inner.coordinates());
        let state = py.detach(|| catena::cli::state_in_log(&log, time, description));
        let state = state.map_err(|error| input(py, format!("{error:#}")))?;
        let (mut q, mut v) = (vec![0.0; places.q_count()], vec![0.0; places.v_count()]);
        places.write(description, &state.position, &state.velocity, &mut q, &mut v);
        // The next run begins at time zero, with its moved joints where they are then.
        self.inner.put_on_motions(0.0, &mut q, &mut v).map_err(|error| refuse(py, error))?;
        Ok((q.to_pyarray(py), v.to_pyarray(py)))
    }

    fn params(&self, py: Python<'_>) -> PyResult<Vec<(String, Option<f64>)>> {
        self.inner.params().map_err(|error| refuse(py, error))
    }

    fn with_params(&self, py: Python<'_>, params: BTreeMap<String, f64>) -> PyResult<Self> {
        let inner = py.detach(|| self.inner.with_params(params)).map_err(|error| refuse(py, error))?;
        Ok(Model { inner })
    }

    fn mass_matrix<'py>(&self, py: Python<'py>, q: Given<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, &self.inner.mass_matrix(&numbers(&q)).map_err(|error| refuse(py, error))?)
    }

    fn jacobian<'py>(&self, py: Python<'py>, link: &str, q: Given<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, &self.inner.jacobian(link, &numbers(&q)).map_err(|error| refuse(py, error))?)
    }

    fn point_jacobian<'py>(
        &self,
        py: Python<'py>,
        link: &str,
        point: [f64; 3],
        q: Given<'py>,
    ) -> PyResult<Matrix<'py>> {
        matrix(py, &self.inner.point_jacobian(link, point, &numbers(&q)).map_err(|error| refuse(py, error))?)
    }

    fn point_velocity<'py>(
        &self,
        py: Python<'py>,
        link: &str,
        point: [f64; 3],
        q: Given<'py>,
        v: Given<'py>,
    ) -> PyResult<Vector<'py>> {
        few(py, self.inner.point_velocity(link, point, &numbers(&q), &numbers(&v)))
    }

    fn point_acceleration<'py>(
        &self,
        py: Python<'py>,
        link: &str,
        point: [f64; 3],
        q: Given<'py>,
        v: Given<'py>,
        a: Given<'py>,
    ) -> PyResult<Vector<'py>> {
        few(py, self.inner.point_acceleration(link, point, &numbers(&q), &numbers(&v), &numbers(&a)))
    }

    fn center_of_mass<'py>(&self, py: Python<'py>, q: Given<'py>) -> PyResult<Vector<'py>> {
        few(py, self.inner.center_of_mass(&numbers(&q)))
    }

    fn center_of_mass_jacobian<'py>(&self, py: Python<'py>, q: Given<'py>) -> PyResult<Matrix<'py>> {
        matrix(py, &self.inner.center_of_mass_jacobian(&numbers(&q)).map_err(|error| refuse(py, error))?)
    }

    fn momentum<'py>(&self, py: Python<'py>, q: Given<'py>, v: Given<'py>) -> PyResult<Vector<'py>> {
        few(py, self.inner.momentum(&numbers(&q), &numbers(&v)))
    }

    #[pyo3(signature = (q, v, a, joints))]
    fn inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: Given<'py>,
        v: Given<'py>,
        a: Given<'py>,
        joints: Option<Vec<String>>,
    ) -> PyResult<Vector<'py>> {
        let (q, v, a) = (numbers(&q), numbers(&v), numbers(&a));
        let Some(joints) = joints else { return vector(py, self.inner.inverse_dynamics(&q, &v, &a)) };
        let joints: Vec<&str> = joints.iter().map(String::as_str).collect();
        vector(py, self.inner.inverse_dynamics_by(&joints, &q, &v, &a))
    }

    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: Given<'py>,
        v: Given<'py>,
        efforts: Given<'py>,
    ) -> PyResult<Vector<'py>> {
        vector(py, self.inner.forward_dynamics(&numbers(&q), &numbers(&v), &numbers(&efforts)))
    }

    fn gravity_efforts<'py>(&self, py: Python<'py>, q: Given<'py>) -> PyResult<Vector<'py>> {
        vector(py, self.inner.gravity_efforts(&numbers(&q)))
    }

    /// Linear equations of motion about q, v and efforts, or about the equilibrium near q, with the derivatives of their eigenvalues by some numbers.
    #[pyo3(signature = (q, v, efforts, rest, by))]
    fn linearize<'py>(
        &self,
        py: Python<'py>,
        q: Option<Given<'py>>,
        v: Option<Given<'py>>,
        efforts: Option<Given<'py>>,
        rest: bool,
        by: Vec<String>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let [q, v, efforts] = [q, v, efforts].map(|given| given.map(|given| numbers(&given)));
        let found = py.detach(|| {
            let of = |model: &catena::session::Model| {
                if rest {
                    return model.linearize_at_rest(q.as_deref());
                }
                let start = model.start()?;
                let q = q.as_ref().unwrap_or(&start.0);
                let v = v.as_ref().unwrap_or(&start.1);
                model.linearize(q, v, efforts.as_deref().unwrap_or(&[]))
            };
            let linear = of(&self.inner)?;
            let keys: Vec<&str> = by.iter().map(String::as_str).collect();
            let slopes = self.inner.eigenvalues_by(&linear, &keys, of)?;
            Ok::<_, Error>((linear, slopes))
        });
        let (linear, slopes) = found.map_err(|error| refuse(py, error))?;
        let out = linear_equations(py, &linear)?;
        let by = PyDict::new(py);
        for of in &slopes {
            by.set_item(&of.key, of.by.iter().map(|by| by.map(|by| (by.re, by.im))).collect::<Vec<_>>())?;
        }
        out.set_item("by", by)?;
        Ok(out)
    }

    /// The multipliers of the motion from q and v on over a period (s): pairs of real and imaginary parts, how far the end is from the start, warnings.
    #[pyo3(signature = (period, q, v, tolerance, fixed))]
    fn multipliers(
        &self,
        py: Python<'_>,
        period: f64,
        q: Option<Given<'_>>,
        v: Option<Given<'_>>,
        tolerance: Option<f64>,
        fixed: Option<(usize, f64)>,
    ) -> PyResult<Multiplied> {
        let given = [q, v].map(|given| given.map(|given| numbers(&given)));
        let found = py.detach(|| self.differentiated(given, period, tolerance, fixed)?.multipliers());
        let found = found.map_err(|error| refuse(py, error))?;
        Ok((found.values.iter().map(|value| (value.re, value.im)).collect(), found.apart, found.warnings))
    }

    /// A run and its derivatives by these keys at the end of each of its steps, some of which are at these times.
    #[pyo3(signature = (keys, q, v, duration, tolerance, fixed, times))]
    #[expect(clippy::too_many_arguments, reason = "each is an option of its own")]
    fn sensitivity<'py>(
        &self,
        py: Python<'py>,
        keys: Vec<String>,
        q: Option<Given<'py>>,
        v: Option<Given<'py>>,
        duration: f64,
        tolerance: Option<f64>,
        fixed: Option<(usize, f64)>,
        times: Option<Given<'py>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let [q, v] = [q, v].map(|given| given.map(|given| numbers(&given)));
        let times = times.map_or_else(Vec::new, |given| numbers(&given));
        let found = py.detach(|| {
            let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
            self.differentiated([q, v], duration, tolerance, fixed)?.sensitivity_at(&keys, &times)
        });
        let run = found.map_err(|error| refuse(py, error))?;
        let out = PyDict::new(py);
        let steps = run.times.len();
        let array = |of: &[DMatrix<f64>]| {
            let (rows, columns) = of.first().map_or((0, 0), |one| one.shape());
            let entry = |(step, row, column): (usize, usize, usize)| of[step][(row, column)];
            PyArray3::from_owned_array(py, numpy::ndarray::Array3::from_shape_fn((steps, rows, columns), entry))
        };
        out.set_item("t", run.times.to_pyarray(py))?;
        out.set_item("q", PyArray2::from_vec2(py, &run.q)?)?;
        out.set_item("v", PyArray2::from_vec2(py, &run.v)?)?;
        out.set_item("dq", array(&run.dq))?;
        out.set_item("dv", array(&run.dv))?;
        out.set_item("keys", &run.keys)?;
        out.set_item("freedoms", &run.freedoms)?;
        let events: PyResult<Vec<Bound<'py, PyDict>>> = (run.events.iter())
            .map(|event| {
                let one = PyDict::new(py);
                one.set_item("t", event.time)?;
                one.set_item("what", &event.what)?;
                one.set_item("dt", event.by.to_pyarray(py))?;
                one.set_item("rate", event.rate)?;
                one.set_item("q", event.q.to_pyarray(py))?;
                one.set_item("v", event.v.to_pyarray(py))?;
                one.set_item("dq", matrix(py, &event.dq)?)?;
                one.set_item("dv", matrix(py, &event.dv)?)?;
                Ok(one)
            })
            .collect();
        out.set_item("events", events?)?;
        out.set_item("valid_within", run.valid_within.to_pyarray(py))?;
        out.set_item("bounded_by", &run.bounded_by)?;
        out.set_item("warnings", &run.warnings)?;
        Ok(out)
    }

    /// `loss` takes t, q, v and the events of the samples, and gives its value with its derivatives.
    #[pyo3(signature = (keys, times, loss, q, v, duration, tolerance, fixed, every))]
    #[expect(clippy::too_many_arguments, reason = "each is an option of its own")]
    fn gradient<'py>(
        &self,
        py: Python<'py>,
        keys: Vec<String>,
        times: Given<'py>,
        loss: Py<PyAny>,
        q: Option<Given<'py>>,
        v: Option<Given<'py>>,
        duration: f64,
        tolerance: Option<f64>,
        fixed: Option<(usize, f64)>,
        every: usize,
    ) -> PyResult<(f64, Vec<String>, Vector<'py>, Vec<String>)> {
        let [q, v] = [q, v].map(|given| given.map(|given| numbers(&given)));
        let times = numbers(&times);
        let mut raised = None;
        let found = py.detach(|| {
            let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
            let asked = Backward { keys: &keys, times: &times, every };
            let run = self.differentiated([q, v], duration, tolerance, fixed)?;
            // A loss without derivatives is refused; the exception comes in its place.
            run.gradient(&asked, |samples| {
                lost(&loss, samples).unwrap_or_else(|error| {
                    raised = Some(error);
                    Lost::default()
                })
            })
        });
        if let Some(error) = raised {
            return Err(error);
        }
        let found = found.map_err(|error| refuse(py, error))?;
        Ok((found.value, found.keys, found.by.to_pyarray(py), found.warnings))
    }

    /// x, y, z, w, x, y, z of a link frame.
    fn pose<'py>(&self, py: Python<'py>, link: &str, q: Given<'py>) -> PyResult<Vector<'py>> {
        let pose = self.inner.pose(link, &numbers(&q)).map_err(|error| refuse(py, error))?;
        Ok(seven(&pose).to_pyarray(py))
    }
}

impl Model {
    /// A run whose derivatives are wanted, from q and v on.
    fn differentiated(
        &self,
        [q, v]: [Option<Vec<f64>>; 2],
        duration: f64,
        tolerance: Option<f64>,
        fixed: Option<(usize, f64)>,
    ) -> Result<Simulation, Error> {
        let mut run = Simulation::new(&self.inner).duration(duration);
        if let Some(tolerance) = tolerance {
            run = run.tolerance(tolerance);
        }
        if let Some((stages, step)) = fixed {
            run = run.fixed(stages, step);
        }
        if q.is_some() || v.is_some() {
            let start = self.inner.start()?;
            run = run.start_from(&q.unwrap_or(start.0), &v.unwrap_or(start.1))?;
        }
        Ok(run)
    }

    fn places(&self, range: impl Fn(&JointPlace) -> &Range<usize>) -> Vec<(&str, usize, usize)> {
        let joints = self.inner.coordinates().joints().iter();
        joints.map(|joint| (joint.name.as_str(), range(joint).start, range(joint).end)).collect()
    }
}

/// A pose as x, y, z, w, x, y, z.
pub fn seven(pose: &catena::prelude::Pose) -> [f64; 7] {
    let at = pose.translation.vector;
    let [w, x, y, z] = catena::mechanism::description::joint::wxyz_from_rotation(pose.rotation.matrix());
    [at.x, at.y, at.z, w, x, y, z]
}
