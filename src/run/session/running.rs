//! A run between its opening and its report: the command line, programs and Python open and close their runs here.
//!
//! ```text
//!     Course ─begin─▶ Running (simulation, log, who watches) ─proceed─▶ steps, under a controller ─close─▶ Finish (report)
//! ```

use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::forces::JointLoad;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::state::State;
#[cfg(feature = "log")]
use crate::output::log::{Compared, Difference, LogError, Recorder};
use crate::output::log::{LogOptions, Severity};
use crate::output::report::{Report, SpeedWatch};
use crate::session::account::{Account, Begun, Closed, Ended, Told};
use crate::session::asked::Settled;
use crate::session::control::Control;
use crate::session::description::Origin;
use crate::session::error::Error;
use crate::session::model::Model;
use crate::session::other_steps::{Length, OtherSteps};
use crate::session::watch::Watch;
use crate::simulation::{Checkpoint, Observer, Simulation, SimulationOptions};
use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The settings of a run.
pub struct Course<'c> {
    /// The model.
    pub model: Model,
    /// Its duration, steps and sampling.
    pub settled: Settled,
    /// The start, and the ranks of the closures there.
    pub state: State,
    /// The ranks of the closures at the start.
    pub counted: Option<Arc<Counted>>,
    /// Disabled simplification rules.
    pub kept: Vec<Rule>,
    /// Ends the run after its current step when it is set.
    pub interrupt: Arc<AtomicBool>,
    /// Observers.
    pub others: Vec<Box<dyn Observer>>,
    /// Whether a program makes its steps, or decides on its efforts.
    pub stepped: bool,
    /// Whether it gives targets to motors.
    pub aimed: bool,
    /// Whether figures are wanted.
    pub figures: bool,
    /// Whether the same run with half the step tells the error, if it is made to its end in one call.
    pub checked: bool,
    /// Efforts along the velocities of the state.
    pub efforts: Option<&'c [f64]>,
    /// The place of the log, and its options.
    pub log: Option<(PathBuf, LogOptions)>,
    /// Who makes the run, and how.
    pub origin: Origin,
}

/// A run between its first step and its end.
pub struct Running {
    pub(crate) simulation: Simulation<'static>,
    model: Model,
    watch: Watch,
    begun: Begun,
    origin: Origin,
    output: Option<PathBuf>,
    /// The end of the run (s), and its length (s).
    pub(crate) end: f64,
    pub(crate) duration: f64,
    rate: f64,
    /// A copy from before the first step of a run that a program makes.
    fresh: Option<Checkpoint>,
    /// The same run in other steps before it is made, and its end.
    beside: Option<OtherSteps>,
    checked: Option<(State, Length)>,
}

/// A finished run.
pub struct Finish {
    /// The report.
    pub report: Report,
    /// The entries of its log besides the samples.
    pub told: Told,
    /// The model.
    pub model: Model,
    /// The end.
    pub state: State,
    /// The efforts that sampled motors hold there, an entry a motor.
    pub held: Vec<Option<f64>>,
    /// Observers.
    pub others: Vec<Box<dyn Observer>>,
}

impl Course<'_> {
    /// A run to its end from this state, with figures, and without a log.
    pub fn new(model: Model, settled: Settled, state: State, counted: Option<Arc<Counted>>) -> Self {
        Course {
            model,
            settled,
            state,
            counted,
            kept: Vec::new(),
            interrupt: Arc::default(),
            others: Vec::new(),
            stepped: false,
            aimed: false,
            figures: true,
            checked: false,
            efforts: None,
            log: None,
            origin: Origin::default(),
        }
    }
}

impl Running {
    /// Makes the simulation and its log.
    ///
    /// # Errors
    /// Invalid steps or efforts, or a log that cannot be created.
    pub fn begin(course: Course) -> Result<Self, Error> {
        let Course { model, settled, state, counted, kept, interrupt, others, stepped, aimed, log, origin, .. } =
            course;
        let Settled { duration, choice, rate } = settled;
        let (start, description) = (state.time, model.description());
        let options = SimulationOptions {
            switched_off: &kept,
            counted: counted.as_ref(),
            // A run cannot restart if a program has seen a part of it.
            stepped,
            figures: course.figures,
            ..SimulationOptions::new(duration, choice)
        };
        let beside =
            if stepped || !course.figures { None } else { Length::of(course.checked, choice, &description.mechanism) };
        let beside = beside.map(|length| (length, state.clone()));
        let account = Account::open(description, &state, settled);
        let mut simulation = Simulation::owning(model.shared().clone(), state, options, interrupt.clone())?;
        let begun = account.begun(description, counted.as_deref(), &simulation);
        let fresh = if stepped { simulation.checkpoint() } else { None };
        if let Some(efforts) = course.efforts {
            simulation.set_efforts(efforts)?;
        }
        let samples_speeds = course.figures && !stepped;
        let mut watch = Watch { recorder: None, speeds: SpeedWatch::new(description), others, samples_speeds };
        let mut output = None;
        if let Some((path, options)) = log {
            // Reactions follow from a state and the model alone, without the efforts of a program.
            let options = if stepped { options.without("/reactions") } else { options };
            let options = if stepped && aimed { options.without("/motors") } else { options };
            let mut recorder = begun.log(&path, description, &origin, &options, &interrupt)?;
            if stepped {
                recorder.say(Severity::Info, "without /reactions: a program drives this run");
            }
            (watch.recorder, output) = (Some(recorder), Some(path));
        }
        // Samples are taken only for observers that look at them.
        if watch.looks() {
            simulation.sample_at(rate);
        }
        let beside = beside.map(|(length, state)| OtherSteps {
            length,
            model: model.clone(),
            settled,
            state,
            counted,
            kept,
            interrupt,
        });
        let end = start + duration;
        Ok(Running {
            simulation,
            model,
            watch,
            begun,
            origin,
            output,
            end,
            duration,
            rate,
            fresh,
            beside,
            checked: None,
        })
    }

    /// Goes on from a checkpoint, with the efforts that it knows; returns `false` if it is of other settings.
    pub(crate) fn restore(&mut self, kept: &Checkpoint) -> bool {
        self.end = kept.state().time + self.duration;
        self.begun.knows_efforts();
        self.simulation.restore(kept)
    }

    /// Goes on from another state as a new run would; stays as it is and returns `false` if that needs a new one.
    pub(crate) fn place(&mut self, state: &State) -> bool {
        let Some(fresh) = &self.fresh else { return false };
        let placed = self.simulation.place(fresh, state);
        if placed {
            self.end = state.time + self.duration;
        }
        placed
    }

    /// Makes the run to its end, and beside it the one in other steps, if there is one.
    ///
    /// # Errors
    /// A step, an observer, or the log that fails.
    pub fn run(&mut self) -> Result<(), Error> {
        let Running { simulation, watch, beside, checked, .. } = self;
        let mut run = || watch.as_list(|observers| simulation.run_before(observers)).map_err(Error::from);
        let Some(other) = beside.take() else { return run() };
        std::thread::scope(|scope| {
            let other = scope.spawn(|| other.end());
            let ended = run();
            *checked = other.join().ok().flatten();
            ended
        })
    }

    /// Makes steps until `until` (s) or the end of the run, under a controller if there is one.
    ///
    /// # Errors
    /// A step, an observer, the log or the controller that fails.
    pub(crate) fn proceed(&mut self, model: &Model, control: Option<&mut Control>, until: f64) -> Result<(), Error> {
        let end = self.end;
        let Some(control) = control else {
            // Only a run that proceeds to its end in one call can restart.
            if until >= end {
                return self.run();
            }
            let Running { simulation, watch, .. } = self;
            return watch.as_list(|observers| simulation.step_before(until, observers)).map_err(Error::from);
        };
        let until = until.min(end);
        let Running { simulation, watch, .. } = self;
        watch.as_list(|observers| {
            simulation.together(|simulation| {
                while simulation.state().time < until {
                    if control.is_due(simulation.state().time) {
                        control.ask(model, simulation.state())?;
                        simulation.set_efforts(control.of_state())?;
                    }
                    simulation.step_before(control.next().min(until), observers)?;
                }
                Ok(())
            })
        })
    }

    /// Holds the run against a log that the same run has written, from its first step on.
    ///
    /// # Errors
    /// As of [`Recorder::compare`].
    #[cfg(feature = "log")]
    pub fn compare(&mut self, log: &std::path::Path, options: &LogOptions) -> Result<(), LogError> {
        let stages = self.simulation.description().stages as f64;
        let mut recorder = Recorder::compare(log, self.model.description(), stages, options)?;
        if self.simulation.tells_at_once() {
            recorder.wait_for_the_end();
        }
        self.watch.recorder = Some(recorder);
        self.simulation.sample_at(self.rate);
        Ok(())
    }

    /// How far the run is the same as that log.
    #[cfg(feature = "log")]
    pub fn compared(self) -> (Compared, Result<(), Difference>) {
        self.watch.recorder.map_or((Compared::default(), Ok(())), Recorder::compared)
    }

    /// Ends the run without a report, and returns its observers.
    pub(crate) fn into_others(self) -> Vec<Box<dyn Observer>> {
        self.watch.others
    }

    /// Ends the run with the outcome `ended`, and completes its log; reactions include these efforts.
    pub fn close(self, ended: Result<(), Error>, efforts: Option<&[f64]>) -> (Finish, Result<(), Error>) {
        let Running { simulation, model, watch, begun, origin, output, checked, .. } = self;
        let finished = simulation.finish();
        let Watch { recorder, speeds, others, .. } = watch;
        let (state, held) = (finished.state.clone(), finished.held.clone());
        let loaded = under_efforts(&model, efforts);
        let (checked, speeds, output) = (checked.as_ref(), speeds.as_ref(), output.as_deref());
        let ended = Ended { finished, ended, checked, speeds, recorder, output };
        let input = model.path().display().to_string();
        let Closed { report, ended, told } = begun.close(&loaded, input, &origin, ended);
        (Finish { report, told, model, state, held, others }, ended)
    }
}

/// The model with the efforts as loads, so that reactions include them.
pub(crate) fn under_efforts<'m>(model: &'m Model, efforts: Option<&[f64]>) -> Cow<'m, crate::model::Model> {
    let description = model.description();
    let acting = || efforts.into_iter().flatten().enumerate().filter(|(_, effort)| **effort != 0.0);
    if acting().next().is_none() {
        return Cow::Borrowed(description);
    }
    let mut loaded = description.clone();
    loaded.mechanism.forces.joint_loads.extend(acting().map(|(freedom, &effort)| JointLoad { freedom, effort }));
    Cow::Owned(loaded)
}
