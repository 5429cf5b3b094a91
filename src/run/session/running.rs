//! A run of a program between its first step and its report.
//!
//! ```text
//!     Course ─begin─▶ Running (simulation, log, who watches) ─proceed─▶ steps, under a controller ─close─▶ Finish (report)
//! ```

use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::forces::JointLoad;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::state::State;
use crate::output::log::{LogOptions, Severity};
use crate::output::report::{Report, SpeedWatch};
use crate::session::account::{Account, Begun, Closed, Ended, Told};
use crate::session::asked::Settled;
use crate::session::control::Control;
use crate::session::description::Origin;
use crate::session::engine::{Engine, Held, Watch};
use crate::session::error::Error;
use crate::session::model::Model;
use crate::simulation::{Checkpoint, Observer, Simulation, SimulationOptions};
use self_cell::MutBorrow;
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The settings of a run.
pub(crate) struct Course<'c> {
    pub model: Model,
    pub settled: Settled,
    /// The start, and the ranks of the closures there.
    pub state: State,
    pub counted: Option<Arc<Counted>>,
    /// Disabled simplification rules.
    pub kept: Vec<Rule>,
    pub interrupt: Arc<AtomicBool>,
    /// Observers.
    pub others: Vec<Box<dyn Observer>>,
    /// Whether a program controls the run.
    pub driven: bool,
    /// Whether a program makes its steps, or decides on its efforts.
    pub stepped: bool,
    /// Whether it gives targets to motors.
    pub aimed: bool,
    /// Whether figures are wanted.
    pub figures: bool,
    /// Efforts along the velocities of the state.
    pub efforts: Option<&'c [f64]>,
    pub log: Option<(PathBuf, LogOptions)>,
    pub origin: Origin,
}

/// A run between its first step and its end.
pub(crate) struct Running {
    pub engine: Engine,
    begun: Begun,
    origin: Origin,
    /// The end of the run (s), and its length (s).
    pub end: f64,
    pub duration: f64,
    /// A copy from before the first step of a run that a program makes.
    fresh: Option<Checkpoint>,
}

/// A finished run.
pub(crate) struct Finish {
    pub report: Report,
    pub told: Told,
    pub model: Model,
    pub state: State,
    /// Observers.
    pub others: Vec<Box<dyn Observer>>,
}

impl Running {
    /// Makes the simulation and its log.
    ///
    /// # Errors
    /// Invalid steps or efforts, or a log that cannot be created.
    pub fn begin(course: Course) -> Result<Self, Error> {
        let Course {
            model,
            settled,
            state,
            counted,
            kept,
            interrupt,
            others,
            driven,
            stepped,
            aimed,
            figures,
            efforts,
            log,
            origin,
        } = course;
        let Settled { duration, choice, rate } = settled;
        let start = state.time;
        let (mut begun, mut fresh) = (None, None);
        let watch = Watch { recorder: None, speeds: SpeedWatch::new(model.description()), others };
        // Reactions follow from a state and the model alone, without the efforts of a program.
        let log = log.map(|(path, options)| match driven {
            true if aimed => (path, options.without("/reactions").without("/motors")),
            true => (path, options.without("/reactions")),
            false => (path, options),
        });
        let held = Held { model, kept, interrupt: interrupt.clone(), counted, watch: MutBorrow::new(watch) };
        let engine = Engine::try_new(held, |held| {
            let description = held.model.description();
            let options = SimulationOptions {
                switched_off: &held.kept,
                interrupt: Some(&held.interrupt),
                counted: held.counted.as_ref(),
                // A run cannot restart if a program has seen a part of it.
                stepped,
                figures,
                ..SimulationOptions::new(duration, choice)
            };
            let account = Account::open(description, &state, settled);
            let mut simulation = Simulation::new(&description.mechanism, state, options)?;
            let known = account.begun(description, held.counted.as_deref(), &simulation);
            fresh = if stepped { simulation.checkpoint() } else { None };
            if let Some(efforts) = efforts {
                simulation.set_efforts(efforts)?;
            }
            let watch = held.watch.borrow_mut();
            if let Some((path, options)) = &log {
                let mut recorder = known.log(path, description, &origin, options, &interrupt)?;
                if driven {
                    recorder.say(Severity::Info, "without /reactions: a program drives this run");
                }
                watch.recorder = Some(recorder);
            }
            begun = Some(known);
            if watch.looks() {
                simulation.sample_at(rate);
            }
            if !watch.is_empty() {
                simulation.observe(watch);
            }
            Ok::<_, Error>(Some(simulation))
        })?;
        let begun = begun.ok_or(Error::Over(start))?;
        Ok(Running { engine, begun, origin, end: start + duration, duration, fresh })
    }

    /// Goes on from another state as a new run would; stays as it is and returns `false` if that needs a new one.
    pub fn place(&mut self, state: &State) -> bool {
        let Running { engine, fresh: Some(fresh), end, duration, .. } = self else { return false };
        let placed = engine.with_mut(|simulation| simulation.place(fresh, state)).unwrap_or(false);
        if placed {
            *end = state.time + *duration;
        }
        placed
    }

    /// Makes steps until `until` (s) or the end of the run, under a controller if there is one.
    ///
    /// # Errors
    /// A step, an observer, the log or the controller that fails.
    pub fn proceed(&mut self, model: &Model, control: Option<&mut Control>, until: f64) -> Result<(), Error> {
        // Only a run that proceeds to its end in one call can restart.
        let to_the_end = until >= self.end;
        let until = until.min(self.end);
        self.engine
            .with_mut(|simulation| {
                let Some(control) = control else {
                    let ended = if to_the_end { simulation.run() } else { simulation.step_to(until) };
                    return ended.map_err(Error::from);
                };
                simulation.together(|simulation| {
                    while simulation.state().time < until {
                        if control.is_due(simulation.state().time) {
                            control.ask(model, simulation.state())?;
                            simulation.set_efforts(control.of_state())?;
                        }
                        simulation.step_to(control.next().min(until))?;
                    }
                    Ok(())
                })
            })
            .unwrap_or(Ok(()))
    }

    /// Ends the run with the outcome `ended`, and completes its log at `output`; reactions include these efforts.
    pub fn close(
        self,
        ended: Result<(), Error>,
        efforts: Option<&[f64]>,
        output: Option<&Path>,
    ) -> (Option<Finish>, Result<(), Error>) {
        let Running { engine, begun, origin, .. } = self;
        let Some((finished, held)) = engine.finish() else { return (None, ended) };
        let Held { model, watch, .. } = held;
        let Watch { recorder, speeds, others } = watch.into_inner();
        let state = finished.state.clone();
        let loaded = under_efforts(&model, efforts);
        let ended = Ended { finished, ended, checked: None, speeds: speeds.as_ref(), recorder, output };
        let input = model.path().display().to_string();
        let Closed { report, ended, told } = begun.close(&loaded, input, &origin, ended);
        (Some(Finish { report, told, model, state, others }), ended)
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
