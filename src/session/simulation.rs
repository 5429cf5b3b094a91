//! A run of a model, as programs make it: a start, an accuracy, steps, and a report.

use crate::mechanism::description::rules::Rule;
use crate::output::log::LogOptions;
use crate::output::report::Report;
use crate::session::account::Told;
use crate::session::asked::Asked;
use crate::session::control::{Control, Moment};
use crate::session::description::Origin;
use crate::session::error::{ControllerFailure, Error};
use crate::session::loaded::Assembled;
use crate::session::model::Model;
#[cfg(feature = "log")]
use crate::session::place::{check_log, check_place};
use crate::session::running::{Course, Finish, Running};
use crate::session::words::words;
use crate::simulation::{InputError, Observer, RunError};
use std::cell::OnceCell;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

mod now;

/// Of runs that step by step a program has made.
const STEPPED: &str = "a program has stepped it";

/// A run of a model. First it is told what to be; with its first step it begins.
///
/// ```
/// use catena::prelude::*;
///
/// let model = Model::load("robots/double_pendulum.urdf")?;
/// let mut simulation = Simulation::new(&model).tolerance(1e-8).duration(2.0).start([("shoulder", 0.5)])?;
/// simulation.step_to(1.0)?;
/// let tip = simulation.pose("lower_arm")?.translation;
/// assert!(tip.z < 0.0, "it hangs");
/// simulation.step_to(2.0)?;
/// assert!(simulation.finish()?.energy.max_relative_error < 1e-7);
/// # Ok::<(), catena::session::Error>(())
/// ```
///
/// What changes between steps goes through the run: [`set_efforts`](Simulation::set_efforts) and
/// [`set_controller`](Simulation::set_controller). The model it runs cannot be changed.
pub struct Simulation {
    model: Model,
    asked: Asked,
    positions: Vec<(String, Vec<f64>)>,
    velocities: Vec<(String, Vec<f64>)>,
    begin: f64,
    kept: Vec<Rule>,
    log: Option<(PathBuf, LogOptions)>,
    observers: Vec<Box<dyn Observer>>,
    interrupt: Arc<AtomicBool>,
    control: Option<Control>,
    /// Along the velocities of the state.
    efforts: Option<Vec<f64>>,
    started: OnceCell<Assembled>,
    running: Option<Running>,
    ended: Option<Finish>,
}

/// A number, or several, for a joint.
pub trait JointValue {
    /// The numbers.
    fn numbers(self) -> Vec<f64>;
}

impl JointValue for f64 {
    fn numbers(self) -> Vec<f64> {
        vec![self]
    }
}

impl JointValue for Vec<f64> {
    fn numbers(self) -> Vec<f64> {
        self
    }
}

impl<const N: usize> JointValue for [f64; N] {
    fn numbers(self) -> Vec<f64> {
        self.to_vec()
    }
}

impl Simulation {
    /// A run of a model, as its file says or else with 10 s at a tolerance of 1e-6 m.
    pub fn new(model: &Model) -> Self {
        Simulation {
            model: model.clone(),
            asked: Asked::default(),
            positions: Vec::new(),
            velocities: Vec::new(),
            begin: 0.0,
            kept: Vec::new(),
            log: None,
            observers: Vec::new(),
            interrupt: Arc::default(),
            control: None,
            efforts: None,
            started: OnceCell::new(),
            running: None,
            ended: None,
        }
    }

    /// The wanted accuracy of positions (m): stages and steps are chosen from it.
    #[must_use]
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        (self.asked.tolerance, self.asked.fixed) = (Some(tolerance), None);
        self
    }

    /// Steps of this length (s), of the scheme with so many stages.
    #[must_use]
    pub fn fixed(mut self, stages: usize, step: f64) -> Self {
        (self.asked.tolerance, self.asked.fixed) = (None, Some((stages, step)));
        self
    }

    /// Simulated time (s).
    #[must_use]
    pub fn duration(mut self, duration: f64) -> Self {
        self.asked.duration = Some(duration);
        self
    }

    /// Samples per simulated second, for the log and other observers.
    #[must_use]
    pub fn rate(mut self, rate: f64) -> Self {
        self.asked.rate = Some(rate);
        self
    }

    /// Switches off a rule that leaves something out of the computation.
    #[must_use]
    pub fn keep(mut self, rule: Rule) -> Self {
        self.kept.push(rule);
        self
    }

    /// Positions of joints at the start, as many numbers as each has coordinates (rad, m); the others are as the file says. Loops are closed from there.
    ///
    /// # Errors
    /// Joints that do not exist or do not move, wrong counts of numbers, numbers that are not finite, loops that do not close.
    pub fn start<N: Into<String>, V: JointValue>(
        self,
        positions: impl IntoIterator<Item = (N, V)>,
    ) -> Result<Self, Error> {
        let given = positions.into_iter().map(|(joint, value)| (joint.into(), value.numbers())).collect();
        let velocities = self.velocities.clone();
        self.start_at(given, velocities)
    }

    /// Velocities of joints at the start [rad/s, m/s]; the others are as the file says.
    ///
    /// # Errors
    /// As of [`Simulation::start`].
    pub fn velocities<N: Into<String>, V: JointValue>(
        self,
        velocities: impl IntoIterator<Item = (N, V)>,
    ) -> Result<Self, Error> {
        let given = velocities.into_iter().map(|(joint, value)| (joint.into(), value.numbers())).collect();
        let positions = self.positions.clone();
        self.start_at(positions, given)
    }

    /// All of q and v at the start ([`Coordinates`](crate::session::Coordinates)).
    ///
    /// # Errors
    /// As of [`Simulation::start`].
    pub fn start_from(self, q: &[f64], v: &[f64]) -> Result<Self, Error> {
        let places = self.model.coordinates();
        places.check("q", q, places.q_count(), |joint| &joint.q)?;
        places.check("v", v, places.v_count(), |joint| &joint.v)?;
        let (positions, velocities) = (places.by_joint(q, |joint| &joint.q), places.by_joint(v, |joint| &joint.v));
        self.start_at(positions, velocities)
    }

    fn start_at(
        mut self,
        positions: Vec<(String, Vec<f64>)>,
        velocities: Vec<(String, Vec<f64>)>,
    ) -> Result<Self, Error> {
        (self.positions, self.velocities) = (positions, velocities);
        self.started = OnceCell::new();
        self.started()?;
        Ok(self)
    }

    /// The time at which it starts (s), for runs that go on where another ended.
    #[must_use]
    pub fn begin_at(mut self, time: f64) -> Self {
        self.begin = time;
        self.started = OnceCell::new();
        self
    }

    /// Writes the run to an MCAP file, from its first step on. A log that is there is replaced only when it is sure that it will be one.
    #[cfg(feature = "log")]
    #[must_use]
    pub fn log(self, path: impl Into<PathBuf>) -> Self {
        self.log_with(path, LogOptions::default())
    }

    /// The same with a choice of topics, meshes and size.
    #[cfg(feature = "log")]
    #[must_use]
    pub fn log_with(mut self, path: impl Into<PathBuf>, options: LogOptions) -> Self {
        self.log = Some((path.into(), options));
        self
    }

    /// Somebody watches the run.
    #[must_use]
    pub fn observe(mut self, observer: impl Observer + 'static) -> Self {
        self.observers.push(Box::new(observer));
        self
    }

    /// A flag that ends the run after its current step once somebody sets it.
    pub fn interrupt(&self) -> Arc<AtomicBool> {
        self.interrupt.clone()
    }

    /// Efforts on the joints from now on, along v, besides the forces of the model [N m or N]. Those on ball and floating joints turn with the child.
    ///
    /// # Errors
    /// [`Error::Input`] for another number of efforts and for what is not finite; [`Error::Over`] when the run is.
    pub fn set_efforts(&mut self, efforts: &[f64]) -> Result<(), Error> {
        let places = self.model.coordinates();
        let wanted = places.v_count();
        if efforts.len() != wanted {
            return Err(InputError::Count { given: efforts.len(), wanted }.into());
        }
        if let Some(index) = efforts.iter().position(|effort| !effort.is_finite()) {
            let joint = places.joints().iter().find(|joint| joint.v.contains(&index));
            let joint = joint.map_or(String::new(), |joint| joint.name.clone());
            return Err(InputError::NotFinite { joint, effort: efforts[index] }.into());
        }
        if let Some(over) = &self.ended {
            return Err(Error::Over(over.state.time));
        }
        let mut of_state = vec![0.0; wanted];
        let model = self.model.clone();
        self.look(|state| {
            model.coordinates().efforts_of_state(model.description(), &state.position, efforts, &mut of_state)
        })?;
        if let Some(running) = &mut self.running {
            running.engine.with_mut(|simulation| simulation.set_efforts(&of_state)).transpose()?;
        }
        self.efforts = Some(of_state);
        Ok(())
    }

    /// Somebody decides on efforts from now on: asked now and after every `period` (s), for efforts along v that are held in between; they are zero
    /// unless they are written. The same state must give the same efforts for a run to be the same twice.
    ///
    /// # Errors
    /// [`Error::Option`] for a period that is none.
    pub fn set_controller(
        &mut self,
        period: f64,
        mut controller: impl FnMut(&Moment, &mut [f64]) + Send + 'static,
    ) -> Result<(), Error> {
        self.set_fallible_controller(period, move |moment, efforts| {
            controller(moment, efforts);
            Ok(())
        })
    }

    /// The same, for controllers that may fail, which ends the run.
    ///
    /// # Errors
    /// As of [`Simulation::set_controller`].
    pub fn set_fallible_controller(
        &mut self,
        period: f64,
        controller: impl FnMut(&Moment, &mut [f64]) -> Result<(), ControllerFailure> + Send + 'static,
    ) -> Result<(), Error> {
        let now = self.time();
        self.control = Some(Control::new(&self.model, now, period, Box::new(controller))?);
        Ok(())
    }

    /// Makes steps until `time` (s), exactly.
    ///
    /// # Errors
    /// A time behind the run or beyond its end; what is wrong with how the run is to be made; a step, an observer, the log or a controller that
    /// fails. The log is complete up to there, and the run over.
    pub fn step_to(&mut self, time: f64) -> Result<(), Error> {
        self.begin(STEPPED)?;
        let (now, end) = (self.time(), self.end());
        if !(time >= now && time <= end) {
            return Err(Error::OutOfRun { wanted: time, time: now, end });
        }
        self.proceed(time)
    }

    /// Makes steps to the end of the run.
    ///
    /// # Errors
    /// As of [`Simulation::step_to`].
    pub fn run(&mut self) -> Result<(), Error> {
        self.begin("")?;
        self.proceed(f64::INFINITY)
    }

    /// Ends the run where it is, completes its log, and says what became of it.
    ///
    /// # Errors
    /// A run that cannot begin, and a log that cannot be completed.
    pub fn finish(mut self) -> Result<Report, Error> {
        self.end_here()?;
        self.ended.take().map(|over| over.report).ok_or(Error::Over(self.begin))
    }

    /// The same, with what a log of the run would say, and the model with all warnings.
    #[doc(hidden)]
    pub fn finish_told(mut self) -> Result<(Report, Told, Model), Error> {
        self.end_here()?;
        let over = self.ended.take().ok_or(Error::Over(self.begin))?;
        Ok((over.report, over.told, over.model))
    }

    fn end_here(&mut self) -> Result<(), Error> {
        if self.ended.is_none() {
            self.begin(STEPPED)?;
            self.close(Ok(()))?;
        }
        Ok(())
    }

    /// What was made of the start.
    fn started(&self) -> Result<&Assembled, Error> {
        if let Some(started) = self.started.get() {
            return Ok(started);
        }
        let mut started = self.model.loaded().assembled(&self.positions, &self.velocities, None)?;
        started.state.time = self.begin;
        Ok(self.started.get_or_init(|| started))
    }

    /// Begins the run if it has not, `driven` by what its log cannot tell unless that is empty.
    fn begin(&mut self, driven: &str) -> Result<(), Error> {
        if let Some(over) = &self.ended {
            return Err(Error::Over(over.state.time));
        }
        if self.running.is_some() {
            return Ok(());
        }
        let settled = self.asked.settle(&self.model.loaded().simulation)?;
        let Assembled { state, counted, warnings } = self.started()?.clone();
        let model = self.model.warned(warnings);
        #[cfg(feature = "log")]
        if let Some((path, options)) = &self.log {
            check_place(path)?;
            check_log(path, model.description(), self.begin + settled.duration, options)?;
        }
        let driven = match (&self.control, &self.efforts) {
            (Some(_), _) => "a controller of a program has driven it",
            (_, Some(_)) => "efforts of a program have driven it",
            _ if self.begin != 0.0 => "it went on where another run had ended",
            _ => driven,
        };
        let origin = self.origin(driven);
        let log = self.log.clone();
        let others = std::mem::take(&mut self.observers);
        let course = Course {
            model,
            settled,
            state,
            counted,
            kept: self.kept.clone(),
            interrupt: self.interrupt.clone(),
            others,
            driven: self.control.is_some() || self.efforts.is_some() || origin.driven.as_deref() == Some(STEPPED),
            efforts: self.efforts.as_deref(),
            log,
            origin,
        };
        self.running = Some(Running::begin(course)?);
        Ok(())
    }

    /// How this run can be made again.
    fn origin(&self, driven: &str) -> Origin {
        let Simulation { model, asked, kept, positions, velocities, .. } = self;
        let mut arguments = words(model.path(), model.world(), asked, kept, positions, velocities);
        match &self.log {
            Some((path, _)) => arguments.push(format!("--output={}", path.display())),
            None => arguments.push("--no-log".to_string()),
        }
        let command_line = format!("catena {}", arguments.join(" "));
        Origin { command_line, arguments, driven: (!driven.is_empty()).then(|| driven.to_string()) }
    }

    /// Makes steps until `until` (s) or the end of the run, under the controller; what fails ends the run.
    fn proceed(&mut self, until: f64) -> Result<(), Error> {
        let Simulation { model, running, control, begin, .. } = self;
        let running = running.as_mut().ok_or(Error::Over(*begin))?;
        match running.proceed(model, control.as_mut(), until) {
            Ok(()) => Ok(()),
            Err(error) => self.close(Err(error)),
        }
    }

    /// Ends the run, and completes its log.
    fn close(&mut self, ended: Result<(), Error>) -> Result<(), Error> {
        let Some(running) = self.running.take() else { return ended };
        let of_state = match (&self.control, &self.efforts) {
            (Some(control), _) => Some(control.of_state()),
            (None, Some(of_state)) => Some(&of_state[..]),
            _ => None,
        };
        let output = self.log.as_ref().map(|(path, _)| path.as_path());
        let (finish, ended) = running.close(ended, of_state, output);
        self.ended = finish;
        ended
    }
}

impl Drop for Simulation {
    /// A run that nobody finished has a log that is complete up to there, and says that it was interrupted.
    fn drop(&mut self) {
        if self.running.is_some() {
            let time = self.time();
            // Nobody is left to be told.
            let _ = self.close(Err(Error::Run(RunError::Interrupted { time })));
        }
    }
}
