//! `catena._catena.Recorded`: the results of a run, as arrays and files.

use crate::model::{numbers, seven};
use crate::refusal::{input, refuse};
use catena::drawing::files::write_text;
use catena::instant::exerting::reactions::Reactions;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::contact_point::ContactPoint;
use catena::mechanism::motion::energy::energy_with_forces;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::nalgebra::Vector3;
use catena::output::film::{FilmOptions, Format};
use catena::output::log::LogOptions;
use catena::output::report::Report;
use catena::session::{Model, Recording, Told, check_place};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, ToPyArray};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// How many logs this process has made for pages and films.
static LOGS: AtomicUsize = AtomicUsize::new(0);

/// A run that has ended.
#[pyclass(frozen, module = "catena._catena")]
pub struct Recorded {
    /// The report, as JSON and for people.
    report: String,
    text: String,
    /// The entries of its log; `None` of a run that was pickled.
    told: Option<Told>,
    /// The program that decided on efforts.
    controlled: Option<String>,
    model: Model,
    recording: Recording,
}

type Rows<'py> = Bound<'py, PyArray2<f64>>;
/// The sample, the names, numbers and state of each contact.
pub type Contacts<'py> = (Vec<usize>, Vec<String>, Rows<'py>, Vec<bool>);

/// The sample, pair, numbers and state of a contact.
type KeptContact = (usize, usize, Vec<f64>, bool);
type Numbers<'py> = Bound<'py, PyArray1<f64>>;
type Given<'py> = PyReadonlyArray1<'py, f64>;
/// The efforts that sampled motors hold at samples.
type Held = Vec<Option<f64>>;
type Parts<'py> = (Numbers<'py>, Numbers<'py>, Numbers<'py>, Vec<KeptContact>, Held, String, String, Option<String>);
type GivenParts<'py> = (Given<'py>, Given<'py>, Given<'py>, Vec<KeptContact>, Held, String, String, Option<String>);

fn vector(x: f64, y: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, y, z)
}

fn rows<'py>(py: Python<'py>, numbers: Vec<f64>, count: usize) -> PyResult<Rows<'py>> {
    let width = numbers.len().checked_div(count).unwrap_or(0);
    PyArray1::from_vec(py, numbers).reshape([count, width])
}

/// Contacts as columns, from their samples.
pub fn listed<'py, 'c>(
    py: Python<'py>,
    names: &[String],
    all: impl Iterator<Item = (usize, &'c ContactPoint)>,
) -> PyResult<Contacts<'py>> {
    let (mut samples, mut pairs, mut numbers, mut sticks) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (sample, point) in all {
        samples.push(sample);
        pairs.push(names[point.pair].clone());
        for vector in [&point.position, &point.normal, &point.force] {
            numbers.extend(vector.iter());
        }
        numbers.push(point.gap);
        sticks.push(point.sticks);
    }
    let count = samples.len();
    Ok((samples, pairs, rows(py, numbers, count)?, sticks))
}

#[pymethods]
impl Recorded {
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.recording.times.to_pyarray(py)
    }

    /// q and v of all samples.
    fn coordinates<'py>(&self, py: Python<'py>) -> PyResult<(Rows<'py>, Rows<'py>)> {
        let places = self.model.coordinates();
        let count = self.recording.times.len();
        let (wide, narrow) = (places.q_count(), places.v_count());
        let (mut q, mut v) = (vec![0.0; count * wide], vec![0.0; count * narrow]);
        for sample in 0..count {
            let (position, velocity) = self.recording.sample(sample);
            let (q, v) = (&mut q[sample * wide..][..wide], &mut v[sample * narrow..][..narrow]);
            places.write(self.model.description(), position, velocity, q, v);
        }
        Ok((rows(py, q, count)?, rows(py, v, count)?))
    }

    /// Kinetic, potential, spring and load energy of all samples (J).
    fn energies<'py>(&self, py: Python<'py>) -> PyResult<Rows<'py>> {
        let mechanism = self.mechanism();
        let of = |state: State| {
            let energy = energy_with_forces(mechanism, &state.position, &body_states(mechanism, &state));
            [energy.kinetic, energy.potential, energy.spring, energy.load]
        };
        rows(py, self.states().flat_map(of).collect(), self.recording.times.len())
    }

    /// x, y, z, w, x, y, z of a link frame in all samples.
    fn poses<'py>(&self, py: Python<'py>, link: &str) -> PyResult<Rows<'py>> {
        let description = self.model.description();
        let Some(index) = description.link(link) else {
            let error = self.model.pose(link, &[]).err();
            return Err(error.map_or_else(|| input(py, link), |error| refuse(py, error)));
        };
        let of = |state: State| {
            let (at, turn) = description.link_pose(&body_states(&description.mechanism, &state), index);
            let turn = catena::nalgebra::Rotation3::from_matrix_unchecked(turn);
            seven(&catena::prelude::Pose::from_parts(at.into(), turn))
        };
        rows(py, self.states().flat_map(of).collect(), self.recording.times.len())
    }

    /// Force and torque of the parent on the child at a joint, in the world, in all samples [N, N m].
    fn reactions<'py>(&self, py: Python<'py>, joint: &str) -> PyResult<Rows<'py>> {
        if let Some(by) = &self.controlled {
            let why = format!("reactions do not follow from states of a run whose efforts a program decides: {by}");
            return Err(input(py, why));
        }
        let description = self.model.description();
        let record = description.joint(joint).and_then(|joint| description.joints[joint].body);
        let Some(body) = record else {
            let known = self.model.joint_names().join(", ");
            return Err(input(py, format!("there is no joint {joint:?} that moves; there are {known}")));
        };
        let mechanism = self.mechanism();
        let mut carried = Reactions::new(mechanism);
        let mut all = Vec::with_capacity(6 * self.recording.times.len());
        for (sample, state) in self.states().enumerate() {
            let motors = mechanism.nonsmooth.motors.iter().enumerate();
            let held = self.recording.held_at(sample);
            let effort = |at: catena::mechanism::description::closure::Coordinate| {
                (state.position[at.position], state.velocity[at.freedom])
            };
            let efforts: Vec<f64> = motors
                .map(|(index, motor)| {
                    let (position, velocity) = effort(motor.coordinate);
                    let held = held.get(index).copied().flatten();
                    held.unwrap_or_else(|| motor.effort(state.time, position, velocity))
                })
                .collect();
            carried.drive(&efforts);
            let (reactions, _) = carried.at(&state.position, &state.velocity);
            all.extend(reactions[body].force.iter().chain(reactions[body].torque.iter()));
        }
        rows(py, all, self.recording.times.len())
    }

    /// The closed contacts of all samples, a row each: the index of the sample; the pair `a|b`; point (m), normal from b to a, force on a (N), all in
    /// the world, and gap (m); whether it sticks.
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Contacts<'py>> {
        let names = self.model.contact_pairs();
        let all =
            self.recording.contacts().flat_map(|(sample, points)| points.iter().map(move |point| (sample, point)));
        listed(py, &names, all)
    }

    /// The report as JSON.
    #[getter]
    fn report(&self) -> &str {
        &self.report
    }

    /// The report for people.
    #[getter]
    fn text(&self) -> &str {
        &self.text
    }

    /// The pickled parts besides the model: times, positions and velocities of the state, contacts, efforts that motors hold, report, text, and who decided on
    /// efforts.
    fn parts<'py>(&self, py: Python<'py>) -> PyResult<Parts<'py>> {
        let Recorded { recording, report, text, controlled, .. } = self;
        let [times, positions, velocities] =
            [&recording.times, &recording.positions, &recording.velocities].map(|numbers| numbers.to_pyarray(py));
        let points = recording.contacts().flat_map(|(sample, points)| points.iter().map(move |point| (sample, point)));
        let kept = points.map(|(sample, point)| {
            let vectors = [point.position, point.normal, point.force];
            let numbers = vectors.iter().flat_map(|vector| vector.iter().copied()).chain([point.gap]).collect();
            (sample, point.pair, numbers, point.sticks)
        });
        let (kept, held) = (kept.collect(), recording.held.clone());
        Ok((times, positions, velocities, kept, held, report.clone(), text.clone(), controlled.clone()))
    }

    /// A run from its pickled parts.
    #[staticmethod]
    fn of_parts(py: Python<'_>, model: &crate::model::Model, parts: GivenParts<'_>) -> PyResult<Self> {
        let (times, positions, velocities, kept, held, report, text, controlled) = parts;
        let mut recording = Recording::default();
        recording.times = numbers(&times);
        recording.positions = numbers(&positions);
        recording.velocities = numbers(&velocities);
        recording.held = held;
        for (sample, pair, numbers_of, sticks) in kept {
            let [x, y, z, nx, ny, nz, fx, fy, fz, gap] = <[f64; 10]>::try_from(numbers_of)
                .map_err(|numbers| input(py, format!("a contact of {} numbers, not 10", numbers.len())))?;
            let (position, normal, force) = (vector(x, y, z), vector(nx, ny, nz), vector(fx, fy, fz));
            recording.add_contact(sample, ContactPoint { pair, position, normal, force, gap, sticks });
        }
        Ok(Recorded { report, text, told: None, controlled, model: model.inner.clone(), recording })
    }

    fn save_log(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| self.write(&path)).map_err(|error| refuse(py, error))
    }

    /// The page of the run.
    fn page(&self, py: Python<'_>, mesh_limit: usize) -> PyResult<String> {
        self.with_log(py, |log| catena::cli::page_of_log(log, mesh_limit))
    }

    fn save_page(&self, py: Python<'_>, path: PathBuf, mesh_limit: usize) -> PyResult<()> {
        check_place(&path).map_err(|error| refuse(py, error))?;
        let text = self.page(py, mesh_limit)?;
        py.detach(|| write_text(&path, &text)).map_err(|error| input(py, error))
    }

    /// Writes a film of the run with these options; returns the number of pictures.
    #[expect(clippy::too_many_arguments, reason = "each is an option of its own")]
    fn save_film(
        &self,
        py: Python<'_>,
        path: PathBuf,
        size: Option<[usize; 2]>,
        rate: f64,
        speed: f64,
        times: Vec<f64>,
        view: &str,
        browser: bool,
        mesh_limit: usize,
    ) -> PyResult<usize> {
        check_place(&path).map_err(|error| refuse(py, error))?;
        let format = Format::of(&path).map_err(|error| input(py, error))?;
        let view = view.parse().map_err(|error| input(py, error))?;
        let size = size.unwrap_or(format.usual_size());
        let options = FilmOptions { size, rate, speed, view, times, mesh_limit };
        let film = |log: &Path| catena::cli::film_of_log(log, &path, &options, browser, &mut |_, _| {});
        Ok(self.with_log(py, film)?.pictures)
    }
}

impl Recorded {
    pub fn new(report: Report, told: Told, model: Model, recording: Recording) -> Self {
        let json = serde_json::to_string(&report).unwrap_or_default();
        let controlled = told.controlled().map(str::to_string);
        Recorded { report: json, text: report.to_string(), told: Some(told), controlled, model, recording }
    }

    fn mechanism(&self) -> &Mechanism {
        &self.model.description().mechanism
    }

    fn states(&self) -> impl Iterator<Item = State> {
        (0..self.recording.times.len()).map(|sample| {
            let (position, velocity) = self.recording.sample(sample);
            let compensation = vec![0.0; position.len()];
            State {
                time: self.recording.times[sample],
                position: position.to_vec(),
                velocity: velocity.to_vec(),
                compensation,
            }
        })
    }

    /// Works with a log of the run, which is removed afterwards.
    fn with_log<R: Send>(&self, py: Python<'_>, work: impl FnOnce(&Path) -> anyhow::Result<R> + Send) -> PyResult<R> {
        let worked = py.detach(|| {
            // A log has a folder of its own, because meshes may lie beside it.
            let number = LOGS.fetch_add(1, Ordering::Relaxed);
            let folder = std::env::temp_dir().join(format!("catena-run-{}-{number}", std::process::id()));
            let log = folder.join("run.mcap");
            let made = std::fs::create_dir_all(&folder).map_err(anyhow::Error::from);
            let worked = made.and_then(|()| Ok(self.write(&log)?)).and_then(|()| work(&log));
            // A folder that stays is in the folder of temporary files.
            let _ = std::fs::remove_dir_all(&folder);
            worked
        });
        worked.map_err(|error| input(py, format!("{error:#}")))
    }

    fn write(&self, path: &Path) -> Result<(), catena::session::Error> {
        let told = self.told.as_ref().ok_or(catena::session::Error::Pickled)?;
        told.write(path, self.model.description(), &self.recording, &LogOptions::default())
    }
}
