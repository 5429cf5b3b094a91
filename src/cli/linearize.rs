//! `catena linearize`: linear equations of motion and their modes, about an equilibrium or an instant of a run.

pub use crate::cli::linearize_asked::LinearizeArgs;

use crate::cli::arguments::numbers::{Coordinates, pairs};
use crate::cli::linearize_asked::At;
use crate::cli::linearize_of_log::{OfLog, is_log};
use crate::cli::linearize_orbit::print_orbit;
use crate::cli::linearize_told::{as_json, as_text};
use crate::cli::terminal::printing::{Failure, print, print_json};
use anyhow::anyhow;
use catena::session::{EigenvalueSlopes, Error, Linear, Model, Simulation};

/// Runs the verb.
///
/// # Errors
/// [`Failure`]: 2 for bad input and states without linear equations, 1 if a run to the instant fails.
pub fn run(args: &LinearizeArgs) -> Result<(), Failure> {
    if args.orbit.is_some() && args.at == Some(At::Rest) {
        return Err(Failure::input(anyhow!("--orbit is for motions: give --at start or a time in s, not rest")));
    }
    let of_log = if is_log(&args.input.input) { Some(OfLog::open(args)?) } else { None };
    if let Some(period) = args.orbit {
        let run = match &of_log {
            Some(log) => log.run(period)?,
            None => orbit_of_input(args, &Given::of(args)?, period)?,
        };
        return print_orbit(args, run);
    }
    let (linear, slopes) = match &of_log {
        Some(log) => log.linear(&args.by)?,
        None => of_input(args)?,
    };
    if args.json { print_json(&as_json(args, &linear, &slopes)) } else { print(as_text(&linear, &slopes)) }
}

/// A model and its start.
struct Given {
    model: Model,
    positions: Vec<(String, Vec<f64>)>,
    velocities: Vec<(String, Vec<f64>)>,
}

impl Given {
    fn of(args: &LinearizeArgs) -> Result<Self, Failure> {
        let loaded = args.input.load().map_err(Failure::input)?;
        args.input.refuse_warnings(&loaded.model).map_err(Failure::input)?;
        let model = Model::of_loaded(loaded, args.input.input.clone(), args.input.world.world());
        let given = |given, are| pairs(given, model.description(), are).map_err(Failure::input);
        let positions = given(&args.position, Coordinates::Positions)?;
        let velocities = given(&args.velocity, Coordinates::Velocities)?;
        Ok(Given { model, positions, velocities })
    }

    /// A run from the start on.
    fn run(&self, args: &LinearizeArgs, duration: f64) -> Result<Simulation, Failure> {
        let run = Simulation::new(&self.model).without_figures().duration(duration);
        let run = args.input.keep.iter().fold(run, |run, rule| run.keep(*rule));
        Ok(run.start(self.positions.clone())?.velocities(self.velocities.clone())?)
    }

    /// The start of a model, and its linear equations there or about the equilibrium near it.
    fn linear(&self, model: &Model, settled: bool) -> Result<Linear, Error> {
        let start = model.loaded().assembled(&self.positions, &self.velocities, None)?.state;
        model.linear_of_state(&start, &[], settled)
    }
}

/// The run of a motion that comes back, from the start or from an instant of a run.
fn orbit_of_input(args: &LinearizeArgs, given: &Given, period: f64) -> Result<Simulation, Failure> {
    let time = match args.at {
        Some(At::Time(time)) if time.is_infinite() => return Err(end_of_no_log()),
        Some(At::Time(time)) if time > 0.0 => time,
        _ => return given.run(args, period),
    };
    let mut run = given.run(args, time)?;
    run.run()?;
    let (q, v) = run.coordinates()?;
    // Motors that hold their joints where a run starts hold them where this one has started.
    let run = given
        .run(args, period)?
        .begin_at(run.time())
        .hold_targets(run.held_targets())
        .hold_efforts(&run.held_efforts())?;
    Ok(run.start_from(&q, &v)?)
}

fn end_of_no_log() -> Failure {
    Failure::input(anyhow!("--at end is for logs; give rest, start, or a time in s"))
}

fn of_input(args: &LinearizeArgs) -> Result<(Linear, Vec<EigenvalueSlopes>), Failure> {
    let given = Given::of(args)?;
    let model = &given.model;
    let (time, settled) = match args.at {
        None | Some(At::Rest) => (0.0, true),
        Some(At::Start) => (0.0, false),
        Some(At::Time(time)) => (time, false),
    };
    if time.is_infinite() {
        return Err(end_of_no_log());
    }
    if time == 0.0 {
        let linear = given.linear(model, settled)?;
        let keys: Vec<&str> = args.by.iter().map(String::as_str).collect();
        let slopes = model.eigenvalues_by(&linear, &keys, |model| given.linear(model, settled))?;
        return Ok((linear, slopes));
    }
    if !args.by.is_empty() {
        return Err(Failure::input(anyhow!(
            "--by is for --at rest and --at start: states of a run move with its numbers"
        )));
    }
    let start = model.loaded().assembled(&given.positions, &given.velocities, None)?.state;
    let mut run = given.run(args, time)?;
    run.run()?;
    let (q, v) = run.coordinates()?;
    let mut state = model.state_at(&q, Some(&v))?;
    state.time = run.time();
    Ok((model.linear_of_run(&start, &state, &[], false)?, Vec::new()))
}
