//! Linear equations about an instant of a log, and the motion that goes on from there.
//!
//! The instant is data: of a log q and v stay, whatever numbers of the scene vary. Closures move them as those of a start.

use crate::cli::linearize_asked::{At, LinearizeArgs};
use crate::cli::logged_state::{LogInstant, LoggedStart, start_of};
use crate::cli::recorded::Recorded;
use crate::cli::terminal::printing::Failure;
use anyhow::anyhow;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::state::State;
use catena::session::{EigenvalueSlopes, Error, HeldTargets, Linear, Loaded, Model, Simulation};
use std::io::Read as _;
use std::path::Path;

/// Whether a file begins as MCAP files do.
pub(crate) fn is_log(path: &Path) -> bool {
    let mut magic = [0; 5];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut magic));
    read.is_ok() && magic == *b"\x89MCAP"
}

/// A model of a log at an instant of it.
pub(crate) struct OfLog {
    /// Its motors hold their joints as in the log.
    model: Model,
    state: State,
    /// Whether the equilibrium near it is wanted.
    settles: bool,
    /// The targets of motors that hold their joints from the start of the run on.
    held: HeldTargets,
    /// Rules that the run has left out.
    keep: Vec<Rule>,
}

impl OfLog {
    /// The instant that the arguments ask for.
    pub fn open(args: &LinearizeArgs) -> Result<Self, Failure> {
        let log = &args.input.input;
        if !args.position.is_empty() || !args.velocity.is_empty() {
            return Err(Failure::input(anyhow!(
                "--position and --velocity: a log has its own states; take one with --at T"
            )));
        }
        let Recorded { arguments, loaded, scene, .. } = Recorded::open(log).map_err(Failure::input)?;
        let time = match args.at {
            Some(At::Start) => 0.0,
            Some(At::Time(time)) => time,
            Some(At::Rest) | None => f64::INFINITY,
        };
        let instant = LogInstant { log: log.clone(), time };
        let LoggedStart { state, motors, held, .. } = start_of(&instant, &loaded.model).map_err(Failure::input)?;
        let mut loaded = holding(loaded, &state, &held);
        loaded.hold(&motors, state.time);
        let model = Model::of_loaded(loaded, log.clone(), arguments.input.world.world()).of_scene(scene);
        Ok(OfLog { model, state, settles: args.at == Some(At::Rest), held, keep: arguments.input.keep })
    }

    /// The linear equations, and the derivatives of their eigenvalues by some numbers.
    pub fn linear(&self, by: &[String]) -> Result<(Linear, Vec<EigenvalueSlopes>), Error> {
        let linear = self.model.linear_of_run(&self.state, &self.state, &[], self.settles)?;
        let keys: Vec<&str> = by.iter().map(String::as_str).collect();
        let slopes = self.model.eigenvalues_by(&linear, &keys, |model| self.of_other(model))?;
        Ok((linear, slopes))
    }

    /// The linear equations of the same scene with other numbers.
    fn of_other(&self, model: &Model) -> Result<Linear, Error> {
        let places = self.model.coordinates();
        let (q, v) = self.model.flat(&self.state);
        let start = [places.by_joint(&q, |joint| &joint.q), places.by_joint(&v, |joint| &joint.v)];
        let mut loaded = model.loaded().clone();
        loaded.model.keep(&self.keep);
        let state = loaded.assembled_at(self.state.time, &start[0], &start[1])?.state;
        let loaded = holding(loaded, &state, &self.held);
        let model = Model::of_loaded(loaded, model.path().to_path_buf(), Default::default());
        model.linear_of_run(&state, &state, &[], self.settles)
    }

    /// The run that goes on from there.
    pub fn run(&self, duration: f64) -> Result<Simulation, Error> {
        let (q, v) = self.model.flat(&self.state);
        let run = Simulation::new(&self.model).without_figures().duration(duration).begin_at(self.state.time);
        self.keep.iter().fold(run, |run, rule| run.keep(*rule)).start_from(&q, &v)
    }
}

/// A model whose motors hold their joints where the run of the log has started.
fn holding(mut loaded: Loaded, state: &State, held: &HeldTargets) -> Loaded {
    loaded.hold_start(state, held);
    loaded.model.at_start.clear();
    loaded
}
