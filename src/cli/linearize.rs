//! `catena linearize`: linear equations of motion and their modes, about an equilibrium or an instant of a run.

use crate::cli::arguments::input::InputArgs;
use crate::cli::arguments::numbers::{Assignment, Coordinates, pairs, positive};
use crate::cli::logged_state::{LogInstant, LoggedStart, start_of};
use crate::cli::recorded::Recorded;
use crate::cli::tables::table::{Table, number};
use crate::cli::terminal::printing::{Failure, print, print_json};
use anyhow::anyhow;
use catena::mechanism::ground::words::counted;
use catena::session::{EigenvalueSlopes, Error, Linear, Mode, Model, Simulation};
use nalgebra::DMatrix;
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::io::Read as _;
use std::path::Path;

/// Linear equations of motion and their modes
#[derive(Clone, Debug, clap::Args)]
pub struct LinearizeArgs {
    /// The robot or scene, or the log of a run, which carries it; the other options of the input are for robots and scenes alone.
    #[command(flatten)]
    pub input: InputArgs,

    /// About which state: `rest`, the equilibrium near the start; `start`; or a time T [s] of the run [default: rest, of a log its end]
    #[arg(long, value_name = "rest|start|T")]
    at: Option<At>,

    /// Position of a joint at the start [rad, m] (repeatable)
    #[arg(long, value_name = "JOINT=VALUE")]
    position: Vec<Assignment>,

    /// Velocity of a joint at the start [rad/s, m/s] (repeatable)
    #[arg(long, value_name = "JOINT=VALUE")]
    velocity: Vec<Assignment>,

    /// Add the matrices of a discrete system with this step [s], inputs being held over a step
    #[arg(long, value_name = "S", allow_hyphen_values = true, value_parser = positive, requires = "json")]
    discrete: Option<f64>,

    /// Add the derivatives of all frequencies and eigenvalues by a number of the scene, with its key path (repeatable); about the equilibrium or the start
    #[arg(long, value_name = "KEY")]
    by: Vec<String>,

    /// The multipliers of the motion from the start on over this period [s], instead of modes
    #[arg(long, value_name = "T", value_parser = positive, conflicts_with_all = ["at", "by", "discrete"])]
    orbit: Option<f64>,

    /// Print one JSON object, with all matrices, instead of a table
    #[arg(long)]
    json: bool,
}

/// `--at`.
#[derive(Clone, Copy, Debug, PartialEq)]
enum At {
    Rest,
    Start,
    Time(f64),
}

impl std::str::FromStr for At {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "rest" => Ok(At::Rest),
            "start" => Ok(At::Start),
            "end" => Ok(At::Time(f64::INFINITY)),
            number => match number.parse::<f64>() {
                Ok(time) if time.is_finite() && time >= 0.0 => Ok(At::Time(time)),
                _ => Err(format!("{number:?} is no instant; give rest, start, or a time in s that is not negative")),
            },
        }
    }
}

/// Runs the verb.
///
/// # Errors
/// [`Failure`]: 2 for bad input and states without linear equations, 1 if a run to the instant fails.
pub fn run(args: &LinearizeArgs) -> Result<(), Failure> {
    if is_log(&args.input.input) {
        if !args.by.is_empty() || args.orbit.is_some() {
            return Err(Failure::input(anyhow!("--by and --orbit need the robot or scene itself, not a log of it")));
        }
        let linear = of_log(args)?;
        return if args.json { print_json(&as_json(args, &linear, &[])) } else { print(as_text(&linear, &[])) };
    }
    if let Some(period) = args.orbit {
        return print_orbit(args, &Given::of(args)?, period);
    }
    let (linear, slopes) = of_input(args)?;
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

/// Tolerance of the run of an orbit (m): multipliers are as accurate as its motion.
const OF_ORBIT: f64 = 1e-9;

fn print_orbit(args: &LinearizeArgs, given: &Given, period: f64) -> Result<(), Failure> {
    let found = given.run(args, period)?.tolerance(OF_ORBIT).multipliers()?;
    let turn = |value: &nalgebra::Complex<f64>| value.arg() / std::f64::consts::TAU;
    let growth = |value: &nalgebra::Complex<f64>| value.norm().ln() / found.period;
    if args.json {
        let value = |value: &nalgebra::Complex<f64>| json!({ "multiplier": [value.re, value.im], "size": value.norm(), "turn": turn(value), "growth": growth(value) });
        return print_json(&json!({
            "catena": env!("CARGO_PKG_VERSION"),
            "input": args.input.input.display().to_string(),
            "period": found.period,
            "apart": found.apart,
            "multipliers": found.values.iter().map(value).collect::<Vec<Value>>(),
            "warnings": found.warnings,
        }));
    }
    let mut text = String::new();
    // Writing into a String cannot fail.
    let _ = writeln!(text, "motion of {} s, whose end is {} from its start", number(found.period), number(found.apart));
    let mut table = Table::new("Multipliers", &["real", "imaginary", "size", "turn", "growth [1/s]"]);
    for value in &found.values {
        let columns = [value.re, value.im, value.norm(), turn(value), growth(value)];
        table.row(columns.map(number).to_vec());
    }
    table.write(&mut text);
    for warning in &found.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    print(text)
}

/// Whether a file begins as MCAP files do.
fn is_log(path: &Path) -> bool {
    let mut magic = [0; 5];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut magic));
    read.is_ok() && magic == *b"\x89MCAP"
}

fn of_log(args: &LinearizeArgs) -> Result<Linear, Failure> {
    let log = &args.input.input;
    if !args.position.is_empty() || !args.velocity.is_empty() {
        return Err(Failure::input(anyhow!(
            "--position and --velocity: a log has its own states; take one with --at T"
        )));
    }
    let recorded = Recorded::open(log).map_err(Failure::input)?;
    let time = match args.at {
        Some(At::Start) => 0.0,
        Some(At::Time(time)) => time,
        Some(At::Rest) | None => f64::INFINITY,
    };
    let instant = LogInstant { log: log.clone(), time };
    let LoggedStart { state, held, .. } = start_of(&instant, &recorded.loaded.model).map_err(Failure::input)?;
    let mut loaded = recorded.loaded;
    // Motors that hold their joints where a run starts do so where the run of the log has started.
    loaded.hold_start(&state, &held);
    loaded.model.at_start.clear();
    let model = Model::of_loaded(loaded, log.clone(), recorded.arguments.input.world.world());
    Ok(model.linear_of_run(&state, &state, &[], args.at == Some(At::Rest))?)
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
        return Err(Failure::input(anyhow!("--at end is for logs; give rest, start, or a time in s")));
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

fn as_text(linear: &Linear, slopes: &[EigenvalueSlopes]) -> String {
    let mut text = String::new();
    let at = match linear.iterations {
        Some(iterations) => {
            format!("about the equilibrium, found in {}", counted(iterations, "iteration", "iterations"))
        }
        None => format!("about t = {} s", number(linear.time)),
    };
    // Writing into a String cannot fail.
    let _ =
        writeln!(text, "{}: {}", counted(linear.names.len(), "independent coordinate", "independent coordinates"), at);
    if linear.velocities.len() < linear.names.len() {
        let count = counted(linear.velocities.len(), "of their velocities is", "of their velocities are");
        let _ = writeln!(text, "{count} independent, because contacts roll");
    }
    if linear.iterations.is_none() && linear.largest_acceleration > 0.0 {
        let _ =
            writeln!(text, "not an equilibrium: joints accelerate by up to {}", number(linear.largest_acceleration));
    }
    for (joint, reason) in &linear.stuck {
        let _ = writeln!(text, "{joint} is stuck: {reason}");
    }
    for joint in &linear.saturated {
        let _ = writeln!(text, "the motor of {joint} is at its bound");
    }
    if linear.sticking_contacts > 0 {
        let _ = writeln!(text, "{}", counted(linear.sticking_contacts, "contact sticks", "contacts stick"));
    }
    if linear.rolling_contacts > 0 {
        let _ = writeln!(text, "{}", counted(linear.rolling_contacts, "contact rolls", "contacts roll"));
    }
    if linear.sliding_contacts > 0 {
        let _ = writeln!(text, "{}", counted(linear.sliding_contacts, "contact slides", "contacts slide"));
    }
    let head = ["mode", "frequency [Hz]", "damping ratio", "time constant [s]", "stable", "largest parts"];
    let mut table = Table::new("Modes", &head);
    for (index, mode) in linear.modes.iter().enumerate() {
        table.row(vec![
            (index + 1).to_string(),
            number(mode.frequency),
            mode.damping_ratio.map_or(String::new(), number),
            mode.time_constant.map_or(String::new(), number),
            mode.stability.word().to_string(),
            largest_parts(linear, mode),
        ]);
    }
    table.write(&mut text);
    if !slopes.is_empty() {
        let head: Vec<String> = slopes.iter().map(|of| format!("d frequency/d {} [Hz per unit]", of.key)).collect();
        let head: Vec<&str> = std::iter::once("mode").chain(head.iter().map(String::as_str)).collect();
        let mut table = Table::new("Derivatives of frequencies", &head);
        for mode in 0..linear.modes.len() {
            let own = slopes.iter().map(|of| of.by[mode].map_or("none".into(), |by| number(by.im / TAU)));
            table.row(std::iter::once((mode + 1).to_string()).chain(own).collect());
        }
        table.write(&mut text);
    }
    text
}

/// The three largest parts of a mode.
fn largest_parts(linear: &Linear, mode: &Mode) -> String {
    const SHOWN: usize = 3;
    const LEAST: f64 = 0.1;
    let mut parts: Vec<usize> = (0..mode.shape.len()).collect();
    parts.sort_by(|&one, &other| mode.shape[other].norm().total_cmp(&mode.shape[one].norm()));
    let largest = parts.first().map_or(0.0, |&part| mode.shape[part].norm());
    let shown = parts.iter().take(SHOWN).filter(|&&part| mode.shape[part].norm() >= LEAST * largest);
    let worded = shown.map(|&part| {
        let value = mode.shape[part];
        let sign = if value.re < 0.0 { -1.0 } else { 1.0 };
        format!("{} {:.2}", linear.freedoms[part], sign * value.norm())
    });
    worded.collect::<Vec<_>>().join(", ")
}

fn as_json(args: &LinearizeArgs, linear: &Linear, slopes: &[EigenvalueSlopes]) -> Value {
    let modes: Vec<Value> = linear
        .modes
        .iter()
        .map(|mode| {
            json!({
                "eigenvalue": [mode.eigenvalue.re, mode.eigenvalue.im],
                "frequency": mode.frequency,
                "damping_ratio": mode.damping_ratio,
                "time_constant": mode.time_constant,
                "stable": mode.stability.word(),
                "shape": mode.shape.iter().map(|entry| [entry.re, entry.im]).collect::<Vec<_>>(),
            })
        })
        .collect();
    let stuck: Vec<Value> =
        linear.stuck.iter().map(|(joint, reason)| json!({ "joint": joint, "reason": reason })).collect();
    let mut report = json!({
        "catena": env!("CARGO_PKG_VERSION"),
        "input": args.input.input.display().to_string(),
        "time": linear.time,
        "equilibrium": linear.iterations.is_some(),
        "iterations": linear.iterations,
        "largest_acceleration": linear.largest_acceleration,
        "q": linear.q,
        "v": linear.v,
        "coordinates": linear.names,
        "units": linear.units,
        "velocities": linear.velocities,
        "A": rows(&linear.a),
        "freedoms": linear.freedoms,
        "B": rows(&linear.b),
        "targets": linear.targets,
        "B_targets": rows(&linear.b_targets),
        "inertia": rows(&linear.inertia),
        "damping": rows(&linear.damping),
        "stiffness": rows(&linear.stiffness),
        "modes": modes,
        "stuck": stuck,
        "saturated": linear.saturated,
        "sticking_contacts": linear.sticking_contacts,
        "rolling_contacts": linear.rolling_contacts,
        "sliding_contacts": linear.sliding_contacts,
    });
    if !slopes.is_empty() {
        let of = |of: &EigenvalueSlopes| {
            let by =
                of.by.iter().map(|by| by.map(|by| json!({ "eigenvalue": [by.re, by.im], "frequency": by.im / TAU })));
            json!({ "key": of.key, "modes": by.collect::<Vec<Option<Value>>>() })
        };
        report["by"] = slopes.iter().map(of).collect();
    }
    if let Some(step) = args.discrete {
        let (a, [b, b_targets]) = linear.discrete(step);
        report["discrete"] = json!({ "step": step, "A": rows(&a), "B": rows(&b), "B_targets": rows(&b_targets) });
    }
    report
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}
