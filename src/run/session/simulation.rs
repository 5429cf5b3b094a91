//! A run of a model in the library: a start, an accuracy, steps, and a report.

use crate::mechanism::description::rules::Rule;
use crate::output::log::LogOptions;
use crate::session::asked::Asked;
use crate::session::control::Control;
use crate::session::error::Error;
use crate::session::held_start::HeldTargets;
use crate::session::loaded::Assembled;
use crate::session::model::Model;
use crate::session::running::{Finish, Running};
use crate::simulation::Observer;
use std::cell::OnceCell;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

mod now;
mod orbit;
mod sensitivity;
mod state;
mod steps;

pub use orbit::Multipliers;
pub use sensitivity::{Backward, EventLost, EventSlope, Gradient, Lost, SampledEvent, Samples, Sensitivity};

/// A run of a model. Its settings come first; the first step begins the run.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
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
/// Between steps only [`set_efforts`](Simulation::set_efforts) and [`set_controller`](Simulation::set_controller) change the run. Its model cannot
/// change.
pub struct Simulation {
    model: Model,
    asked: Asked,
    positions: Vec<(String, Vec<f64>)>,
    velocities: Vec<(String, Vec<f64>)>,
    begin: f64,
    /// The efforts that sampled motors hold at the start, an entry a motor, or empty.
    held: Vec<Option<f64>>,
    /// The targets of the motors that hold their joints at the start of the run before.
    held_at: HeldTargets,
    kept: Vec<Rule>,
    log: Option<(PathBuf, LogOptions)>,
    observers: Vec<Box<dyn Observer>>,
    interrupt: Arc<AtomicBool>,
    figures: bool,
    /// Whether the program has given targets to motors.
    aimed: bool,
    control: Option<Control>,
    /// Efforts along the velocities of the state.
    efforts: Option<Vec<f64>>,
    started: OnceCell<Assembled>,
    running: Option<Running>,
    ended: Option<Finish>,
}

/// Numbers of joints.
type Starts = Vec<(String, Vec<f64>)>;

/// One number or several numbers for a joint.
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
    /// A run with the settings of the model's file, or else 10 s at a tolerance of 1e-6 m.
    pub fn new(model: &Model) -> Self {
        Simulation {
            model: model.clone(),
            asked: Asked::default(),
            positions: Vec::new(),
            velocities: Vec::new(),
            begin: 0.0,
            held: Vec::new(),
            held_at: HeldTargets::new(),
            kept: Vec::new(),
            log: None,
            observers: Vec::new(),
            interrupt: Arc::default(),
            figures: true,
            aimed: false,
            control: None,
            efforts: None,
            started: OnceCell::new(),
            running: None,
            ended: None,
        }
    }

    /// Sets the wanted accuracy of positions (m), from which stages and steps are chosen.
    #[must_use]
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        (self.asked.tolerance, self.asked.fixed) = (Some(tolerance), None);
        self
    }

    /// Leaves out the estimate of the error, for about half of the time: each step keeps to its share of the tolerance.
    #[must_use]
    pub fn without_estimate(mut self) -> Self {
        self.asked.no_estimate = true;
        self
    }

    /// Sets fixed steps of this length (s) with this number of stages.
    #[must_use]
    pub fn fixed(mut self, stages: usize, step: f64) -> Self {
        (self.asked.tolerance, self.asked.fixed) = (None, Some((stages, step)));
        self
    }

    /// Sets the simulated time (s).
    #[must_use]
    pub fn duration(mut self, duration: f64) -> Self {
        self.asked.duration = Some(duration);
        self
    }

    /// Sets the samples per simulated second, for the log and other observers.
    #[must_use]
    pub fn rate(mut self, rate: f64) -> Self {
        self.asked.rate = Some(rate);
        self
    }

    /// Disables a simplification rule.
    #[must_use]
    pub fn keep(mut self, rule: Rule) -> Self {
        self.kept.push(rule);
        if rule == Rule::Wheels {
            self.model = self.model.keeping(&[rule]);
            self.started = OnceCell::new();
        }
        self
    }

    /// Sets positions of joints at the start, one number per coordinate of the joint (rad, m). The other joints start as in the file. Loops are
    /// then closed.
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

    /// Sets velocities of joints at the start [rad/s, m/s]. The other joints start as in the file.
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

    /// Sets all of q and v at the start ([`Coordinates`](crate::session::Coordinates)). Joints that are moved in time must be where they are at the time
    /// of the start, which [`Simulation::begin_at`] sets before.
    ///
    /// # Errors
    /// As of [`Simulation::start`].
    pub fn start_from(self, q: &[f64], v: &[f64]) -> Result<Self, Error> {
        let places = self.model.coordinates();
        places.check("q", q, places.q_count(), |joint| &joint.q)?;
        places.check("v", v, places.v_count(), |joint| &joint.v)?;
        let (positions, velocities) = self.listed(q, v);
        self.start_at(positions, velocities)
    }

    /// q and v by joints.
    fn listed(&self, q: &[f64], v: &[f64]) -> (Starts, Starts) {
        let places = self.model.coordinates();
        (places.by_joint(q, |joint| &joint.q), places.by_joint(v, |joint| &joint.v))
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

    /// Sets the time of the start (s), to continue another run.
    #[must_use]
    pub fn begin_at(mut self, time: f64) -> Self {
        self.begin = time;
        self.started = OnceCell::new();
        self
    }

    /// Sets what sampled motors hold at the start, if that is between their ticks, until the next ones [N m or N]: an entry a motor, in the order of
    /// [`Model::motor_names`]. [`State::held_efforts`](crate::session::State::held_efforts) and [`Simulation::held_efforts`] of the run before give them.
    /// A motor without an entry works out its effort at the start.
    ///
    /// # Errors
    /// A wrong number of entries, and efforts that are not finite.
    pub fn hold_efforts(mut self, efforts: &[Option<f64>]) -> Result<Self, Error> {
        let wanted = self.model.description().mechanism.nonsmooth.motors.len();
        if efforts.len() != wanted {
            return Err(Error::Count { what: "held efforts, one a motor", given: efforts.len(), wanted });
        }
        if let Some(&value) = efforts.iter().flatten().find(|effort| !effort.is_finite()) {
            return Err(Error::Option { option: "a held effort", value, wanted: "give a finite number" });
        }
        self.held = efforts.to_vec();
        Ok(self)
    }

    /// Lets motors that hold their joints where a run starts hold them where the run before has done so: what [`Simulation::held_targets`] of it
    /// gives. Joints that are not among them are held where this run starts.
    #[must_use]
    pub fn hold_targets(mut self, targets: HeldTargets) -> Self {
        self.held_at = targets;
        self
    }

    /// Writes the run to an MCAP file, from its first step on. An existing log is replaced only by a complete one.
    #[cfg(feature = "log")]
    #[must_use]
    pub fn log(self, path: impl Into<PathBuf>) -> Self {
        self.log_with(path, LogOptions::default())
    }

    /// Writes a log with options for topics, meshes and size.
    #[cfg(feature = "log")]
    #[must_use]
    pub fn log_with(mut self, path: impl Into<PathBuf>, options: LogOptions) -> Self {
        self.log = Some((path.into(), options));
        self
    }

    /// Adds an observer.
    #[must_use]
    pub fn observe(mut self, observer: impl Observer + 'static) -> Self {
        self.observers.push(Box::new(observer));
        self
    }

    /// Leaves out the figures of the report: energies, constraint errors and times of steps, for steps that cost less.
    #[must_use]
    pub fn without_figures(mut self) -> Self {
        self.figures = false;
        self
    }

    /// A flag that ends the run after its current step when it is set.
    pub fn interrupt(&self) -> Arc<AtomicBool> {
        self.interrupt.clone()
    }

    /// Its model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The assembled start.
    fn started(&self) -> Result<&Assembled, Error> {
        if let Some(started) = self.started.get() {
            return Ok(started);
        }
        let started = self.model.loaded().assembled_at(self.begin, &self.positions, &self.velocities)?;
        Ok(self.started.get_or_init(|| started))
    }
}
