//! `catena._catena.Run`: a run that goes on step by step, or to its end at once.

use crate::model::{Model, numbers, seven};
use crate::recorded::Recorded;
use crate::refusal::{input, refuse};
use crate::signals::Watcher;
use catena::session::{ControllerFailure, Error, HeldTargets, Moment, SharedRecording, Simulation};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadwriteArray1, ToPyArray};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A run.
#[pyclass(frozen, module = "catena._catena")]
pub struct Run {
    inner: Mutex<Option<Simulation>>,
    recording: SharedRecording,
    interrupt: Arc<AtomicBool>,
    /// q and v as they were written last: a later change by the user is another start.
    written: Mutex<[Vec<f64>; 2]>,
}

type Vector<'py> = Bound<'py, PyArray1<f64>>;
type Given<'py> = PyReadonlyArray1<'py, f64>;
type Written<'py> = PyReadwriteArray1<'py, f64>;

#[pymethods]
impl Run {
    #[new]
    #[pyo3(signature = (model, q, v, begin, held, held_at, duration, tolerance, fixed, rate, keep, log, record, figures, estimate))]
    #[expect(clippy::too_many_arguments, reason = "each is an option of its own")]
    fn new(
        py: Python<'_>,
        model: &Model,
        q: Given<'_>,
        v: Given<'_>,
        begin: f64,
        held: Option<Vec<Option<f64>>>,
        held_at: HeldTargets,
        duration: Option<f64>,
        tolerance: Option<f64>,
        fixed: Option<(usize, f64)>,
        rate: Option<f64>,
        keep: Vec<String>,
        log: Option<PathBuf>,
        record: bool,
        figures: bool,
        estimate: bool,
    ) -> PyResult<Self> {
        let mut simulation = Simulation::new(&model.inner).begin_at(begin).hold_targets(held_at);
        if let Some(tolerance) = tolerance {
            simulation = simulation.tolerance(tolerance);
        }
        if let Some((stages, step)) = fixed {
            simulation = simulation.fixed(stages, step);
        }
        if let Some(held) = held {
            simulation = simulation.hold_efforts(&held).map_err(|error| refuse(py, error))?;
        }
        if let Some(duration) = duration {
            simulation = simulation.duration(duration);
        }
        if let Some(rate) = rate {
            simulation = simulation.rate(rate);
        }
        for rule in keep {
            simulation = simulation.keep(rule.parse().map_err(|error| input(py, error))?);
        }
        if let Some(log) = log {
            simulation = simulation.log(log);
        }
        if !estimate {
            simulation = simulation.without_estimate();
        }
        if !figures {
            simulation = simulation.without_figures();
        }
        let recording = SharedRecording::default();
        if record {
            simulation = simulation.observe(recording.clone());
        }
        let interrupt = simulation.interrupt();
        simulation = simulation.observe(Watcher::new(interrupt.clone()));
        let (q, v) = (numbers(&q), numbers(&v));
        let simulation = py.detach(|| simulation.start_from(&q, &v)).map_err(|error| refuse(py, error))?;
        Ok(Run { inner: Mutex::new(Some(simulation)), recording, interrupt, written: Mutex::new([q, v]) })
    }

    /// Time (s).
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.with(py, |simulation| Ok(simulation.time()))
    }

    /// When it ends (s).
    #[getter]
    fn end(&self, py: Python<'_>) -> PyResult<f64> {
        self.with(py, |simulation| Ok(simulation.end()))
    }

    /// Writes the present q and v into the memory of these arrays.
    fn look(&self, py: Python<'_>, mut q: Written<'_>, mut v: Written<'_>) -> PyResult<()> {
        let (q, v) = (q.as_slice_mut()?, v.as_slice_mut()?);
        self.with(py, |simulation| simulation.write_coordinates(q, v))?;
        let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        written[0].copy_from_slice(q);
        written[1].copy_from_slice(v);
        Ok(())
    }

    /// Whether it is at this time, and these are still q and v as they were written last.
    fn is_at(&self, py: Python<'_>, time: f64, q: Given<'_>, v: Given<'_>) -> PyResult<bool> {
        let now = self.with(py, |simulation| Ok(simulation.time()))?;
        let written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(time == now && q.as_slice()? == written[0] && v.as_slice()? == written[1])
    }

    /// Goes on from there as a new run would.
    fn place(&self, py: Python<'_>, time: f64, q: Given<'_>, v: Given<'_>) -> PyResult<()> {
        let (q, v) = (numbers(&q), numbers(&v));
        self.with(py, |simulation| simulation.place(time, &q, &v))?;
        *self.written.lock().unwrap_or_else(PoisonError::into_inner) = [q, v];
        Ok(())
    }

    /// Where it is, with all that the steps remember.
    fn state(&self, py: Python<'_>) -> PyResult<State> {
        Ok(State { inner: Mutex::new(self.with(py, Simulation::state)?) })
    }

    /// Goes on from there bit for bit.
    fn set_state(&self, py: Python<'_>, state: &State) -> PyResult<()> {
        let state = state.inner.lock().unwrap_or_else(PoisonError::into_inner);
        self.with(py, |simulation| simulation.set_state(&state))
    }

    /// Target, kp and kd by joint of the motors that hold their joints at the start of the run.
    fn held_targets(&self, py: Python<'_>) -> PyResult<HeldTargets> {
        self.with(py, |simulation| Ok(simulation.held_targets()))
    }

    /// The efforts that sampled motors hold until their next ticks, an entry a motor.
    fn held_efforts(&self, py: Python<'_>) -> PyResult<Vec<Option<f64>>> {
        self.with(py, |simulation| Ok(simulation.held_efforts()))
    }

    /// Gives the motor of a joint a target.
    fn set_target(&self, py: Python<'_>, joint: &str, target: f64) -> PyResult<()> {
        self.with(py, |simulation| simulation.set_target(joint, target))
    }

    /// What sensors measure now.
    fn sense(&self, py: Python<'_>) -> PyResult<crate::sensors::Sensed> {
        Ok(crate::sensors::Sensed { inner: self.with(py, |simulation| simulation.sense())? })
    }

    fn pose<'py>(&self, py: Python<'py>, link: &str) -> PyResult<Vector<'py>> {
        let pose = self.with(py, |simulation| simulation.pose(link))?;
        Ok(seven(&pose).to_pyarray(py))
    }

    /// Kinetic, potential, spring and load energy (J).
    fn energy(&self, py: Python<'_>) -> PyResult<[f64; 4]> {
        let energy = self.with(py, |simulation| simulation.energy())?;
        Ok([energy.kinetic, energy.potential, energy.spring, energy.load])
    }

    fn set_efforts(&self, py: Python<'_>, efforts: Given<'_>) -> PyResult<()> {
        let efforts = numbers(&efforts);
        self.with(py, |simulation| simulation.set_efforts(&efforts))
    }

    /// `controller(t, q, v)` is asked now and every period (s), and returns efforts, or `None` for zero efforts.
    fn set_controller(&self, py: Python<'_>, period: f64, controller: Py<PyAny>) -> PyResult<()> {
        let law = move |now: &Moment, efforts: &mut [f64]| -> Result<(), ControllerFailure> {
            Python::attach(|py| Ok(ask(py, &controller, now, efforts)?))
        };
        self.with(py, |simulation| simulation.set_fallible_controller(period, law))
    }

    fn step_to(&self, py: Python<'_>, time: f64) -> PyResult<()> {
        self.detached(py, |simulation| simulation.step_to(time))
    }

    fn run(&self, py: Python<'_>) -> PyResult<()> {
        self.detached(py, Simulation::run)
    }

    /// Ends the run, and returns its results.
    fn finish(&self, py: Python<'_>) -> PyResult<Recorded> {
        let simulation = self.lock(py)?.take();
        let Some(simulation) = simulation else { return Err(input(py, "the run has ended; start a new one")) };
        let finished = py.detach(|| simulation.finish_told());
        let (report, told, model) = finished.map_err(|error| refuse(py, error))?;
        Ok(Recorded::new(report, told, model, self.recording.take()))
    }
}

/// A run between two steps, as a value.
#[pyclass(frozen, module = "catena._catena")]
pub struct State {
    inner: Mutex<catena::session::State>,
}

/// Runs side by side.
#[pyclass(frozen, module = "catena._catena")]
pub struct Batch {
    inner: Mutex<catena::session::Batch>,
}

#[pymethods]
impl Batch {
    #[new]
    #[pyo3(signature = (run, count, threads))]
    fn new(py: Python<'_>, run: &Run, count: usize, threads: usize) -> PyResult<Self> {
        let batch = run.with(py, |simulation| catena::session::Batch::new(simulation, count, threads))?;
        Ok(Batch { inner: Mutex::new(batch) })
    }

    /// One run begins from there at time zero.
    fn place(&self, py: Python<'_>, run: usize, q: Given<'_>, v: Given<'_>) -> PyResult<()> {
        let mut batch = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
        batch.place(run, &numbers(&q), &numbers(&v)).map_err(|error| refuse(py, error))
    }

    /// All go on for a duration (s) under efforts and targets, whose arrays may be empty, and write q and v; those that fail, and why.
    fn step(
        &self,
        py: Python<'_>,
        duration: f64,
        efforts: Given<'_>,
        targets: Given<'_>,
        mut q: Written<'_>,
        mut v: Written<'_>,
    ) -> PyResult<Vec<(usize, String)>> {
        let (efforts, targets) = (numbers(&efforts), numbers(&targets));
        let (q, v) = (q.as_slice_mut()?, v.as_slice_mut()?);
        let failed = py.detach(|| {
            let mut batch = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
            let failed = batch.step(duration, &efforts, &targets)?;
            batch.write_coordinates(q, v)?;
            Ok(failed)
        });
        let failed: Vec<(usize, Error)> = failed.map_err(|error| refuse(py, error))?;
        Ok(failed.into_iter().map(|(run, error)| (run, error.to_string())).collect())
    }
}

/// Asks a controller of Python.
fn ask(py: Python<'_>, controller: &Py<PyAny>, now: &Moment, efforts: &mut [f64]) -> PyResult<()> {
    let answer = controller.bind(py).call1((now.time, now.q.to_pyarray(py), now.v.to_pyarray(py)))?;
    if answer.is_none() {
        return Ok(());
    }
    let count = |given: usize| match given == efforts.len() {
        true => Ok(()),
        false => Err(input(py, format!("it returned {given} efforts for {} degrees of freedom", efforts.len()))),
    };
    if let Ok(array) = answer.cast::<PyArray1<f64>>() {
        let array = array.readonly();
        count(array.len()?)?;
        efforts.iter_mut().zip(array.as_array()).for_each(|(effort, given)| *effort = *given);
        return Ok(());
    }
    let given = answer.extract::<Vec<f64>>()?;
    count(given.len())?;
    efforts.copy_from_slice(&given);
    Ok(())
}

impl Run {
    /// The simulation; a controller that asks for it while it is asked gets an error, not a deadlock.
    fn lock(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Option<Simulation>>> {
        self.inner.try_lock().map_err(|_| {
            input(py, "the run is being made: nothing can be asked of it from its controller or another thread")
        })
    }

    fn with<R>(&self, py: Python<'_>, work: impl FnOnce(&mut Simulation) -> Result<R, Error>) -> PyResult<R> {
        match &mut *self.lock(py)? {
            Some(simulation) => work(simulation).map_err(|error| refuse(py, error)),
            None => Err(input(py, "the run has ended; start a new one")),
        }
    }

    /// Work without the lock of Python.
    fn detached(&self, py: Python<'_>, work: impl FnOnce(&mut Simulation) -> Result<(), Error> + Send) -> PyResult<()> {
        let mut held = self.lock(py)?;
        let Some(simulation) = &mut *held else { return Err(input(py, "the run has ended; start a new one")) };
        match py.detach(|| work(simulation)) {
            Ok(()) => Ok(()),
            Err(error) if error.is_interruption() && self.interrupt.load(Ordering::Relaxed) => {
                Err(PyKeyboardInterrupt::new_err(error.to_string()))
            }
            Err(error) => Err(refuse(py, error)),
        }
    }
}
