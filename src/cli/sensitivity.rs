//! `catena sensitivity`: derivatives of a run by its start, its efforts and the numbers of its files, through its events.

use crate::cli::arguments::input::InputArgs;
use crate::cli::arguments::numbers::{Assignment, Coordinates, pairs, positive};
use crate::cli::arguments::outputs::output_file;
use crate::cli::tables::table::{Table, number};
use crate::cli::terminal::printing::{Failure, print, print_json};
use anyhow::Context as _;
use catena::drawing::comma_separated::field;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::ground::words::counted;
use catena::session::{Error, Model, Sensitivity, Simulation};
use clap::value_parser;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Derivatives of a run by its numbers
#[derive(Clone, Debug, clap::Args)]
pub struct SensitivityArgs {
    #[command(flatten)]
    pub input: InputArgs,

    /// A parameter: start.q, start.v (or start.q.JOINT), effort.JOINT, or a key path of `catena model INPUT --parameters`; with its standard deviation
    /// S the table has that of the motion (repeatable)
    #[arg(long, value_name = "KEY[=S]", required = true)]
    by: Vec<By>,

    /// Position of a joint at the start [rad, m] (repeatable)
    #[arg(long, value_name = "JOINT=VALUE")]
    position: Vec<Assignment>,

    /// Velocity of a joint at the start [rad/s, m/s] (repeatable)
    #[arg(long, value_name = "JOINT=VALUE")]
    velocity: Vec<Assignment>,

    /// Simulated time [s] [default: that of the scene, or 10]
    #[arg(long, value_name = "S", allow_hyphen_values = true, value_parser = positive)]
    duration: Option<f64>,

    /// Wanted accuracy of positions [m]; stages and step are chosen from it [default: 1e-6]
    #[arg(long, value_name = "E", allow_hyphen_values = true, value_parser = positive)]
    tolerance: Option<f64>,

    /// Stages of the scheme, of order 2S-2, with a fixed --step
    #[arg(long, value_name = "S", allow_hyphen_values = true, value_parser = value_parser!(u8).range(2..=16),
          requires = "step", conflicts_with = "tolerance")]
    stages: Option<u8>,

    /// Fixed step [s], with --stages
    #[arg(long, value_name = "H", allow_hyphen_values = true, value_parser = positive, requires = "stages")]
    step: Option<f64>,

    /// Write the run and its derivatives at all steps as a table of comma-separated values
    #[arg(short, long, value_name = "FILE.csv", value_parser = output_file())]
    output: Option<PathBuf>,

    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

/// A parameter with its standard deviation.
#[derive(Clone, Debug, PartialEq)]
pub struct By {
    pub key: String,
    pub deviation: Option<f64>,
}

impl std::str::FromStr for By {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.rsplit_once('=') {
            None if text.is_empty() => Err("give a key".into()),
            None => Ok(By { key: text.into(), deviation: None }),
            Some((key, deviation)) => Ok(By { key: key.into(), deviation: Some(positive(deviation)?) }),
        }
    }
}

/// Runs the verb.
///
/// # Errors
/// [`Failure`]: 2 for bad input and runs without derivatives, 1 if the run fails or the table cannot be written.
pub fn run(args: &SensitivityArgs) -> Result<(), Failure> {
    let loaded = args.input.load().map_err(Failure::input)?;
    args.input.refuse_warnings(&loaded.model).map_err(Failure::input)?;
    let model = Model::of_loaded(loaded, args.input.input.clone(), args.input.world.world());
    let settings = RunSettings {
        keep: &args.input.keep,
        duration: args.duration,
        tolerance: args.tolerance,
        fixed: args.stages.zip(args.step),
        start: [&args.position, &args.velocity],
    };
    let found = differentiate(settings.run(&model)?, &args.by, &[])?;
    if let Some(output) = &args.output {
        let written = std::fs::write(output, as_csv(&found));
        written.with_context(|| format!("{} cannot be written", output.display())).map_err(Failure::run)?;
    }
    let deviations = deviations(&args.by, &found);
    if args.json { print_json(&as_json(args, &found, &deviations)) } else { print(as_text(&found, &deviations)) }
}

/// The settings of a run that command lines with derivatives share.
pub struct RunSettings<'a> {
    /// Rules that are switched off.
    pub keep: &'a [Rule],
    /// s.
    pub duration: Option<f64>,
    /// m.
    pub tolerance: Option<f64>,
    /// Stages, and the step (s).
    pub fixed: Option<(u8, f64)>,
    /// Positions and velocities.
    pub start: [&'a [Assignment]; 2],
}

impl RunSettings<'_> {
    /// A run of a model with them.
    ///
    /// # Errors
    /// Unknown joints at the start, and numbers with units that they do not have.
    pub fn run(&self, model: &Model) -> Result<Simulation, Failure> {
        let mut run = self.keep.iter().fold(Simulation::new(model), |run, rule| run.keep(*rule));
        if let Some(duration) = self.duration {
            run = run.duration(duration);
        }
        if let Some(tolerance) = self.tolerance {
            run = run.tolerance(tolerance);
        }
        if let Some((stages, step)) = self.fixed {
            run = run.fixed(stages.into(), step);
        }
        let given = |given, are| pairs(given, model.description(), are).map_err(Failure::input);
        let positions = given(self.start[0], Coordinates::Positions)?;
        let velocities = given(self.start[1], Coordinates::Velocities)?;
        Ok(run.start(positions)?.velocities(velocities)?)
    }
}

/// The derivatives of a run by parameters, at the ends of its steps and at some times (s).
///
/// # Errors
/// Unknown parameters, and runs without derivatives.
pub fn differentiate(run: Simulation, by: &[By], times: &[f64]) -> Result<Sensitivity, Error> {
    let keys: Vec<&str> = by.iter().map(|by| by.key.as_str()).collect();
    run.sensitivity_at(&keys, times)
}

/// The standard deviations of all parameters.
pub fn deviations(by: &[By], found: &Sensitivity) -> Vec<Option<f64>> {
    found.keys.iter().map(|key| deviation(by, key)).collect()
}

/// The standard deviation of a parameter; `start.q` stands for all of its freedoms.
fn deviation(by: &[By], key: &str) -> Option<f64> {
    let of = |by: &&By| key == by.key || key.strip_prefix(by.key.as_str()).is_some_and(|rest| rest.starts_with('.'));
    by.iter().find(of).and_then(|by| by.deviation)
}

/// The standard deviation of a freedom at a step, by parameters that are independent; `None` without deviations.
fn spread(row: impl Iterator<Item = f64>, deviations: &[Option<f64>]) -> Option<f64> {
    let known = row.zip(deviations).filter_map(|(slope, deviation)| Some((slope * (*deviation)?).powi(2)));
    let squares: Vec<f64> = known.collect();
    (!squares.is_empty()).then(|| squares.iter().sum::<f64>().sqrt())
}

/// The derivatives at the end, as tables.
pub fn as_text(found: &Sensitivity, deviations: &[Option<f64>]) -> String {
    let mut text = String::new();
    let time = found.times.last().copied().unwrap_or_default();
    let spreads = deviations.iter().any(Option::is_some);
    let mut head = vec!["freedom".to_string(), "q".to_string()];
    if spreads {
        head.push("standard deviation".to_string());
    }
    head.extend(found.keys.iter().map(|key| format!("dq/d {key}")));
    // Writing into a String cannot fail.
    let _ = writeln!(text, "derivatives at t = {} s, {}", number(time), counted(found.events.len(), "event", "events"));
    let mut table = Table::new("Derivatives", &head.iter().map(String::as_str).collect::<Vec<&str>>());
    let (Some(q), Some(dq)) = (found.q.last(), found.dq.last()) else { return text };
    for (row, name) in found.freedoms.iter().enumerate() {
        // Ball joints have more positions than freedoms.
        let value = if q.len() == found.freedoms.len() { number(q[row]) } else { String::new() };
        let mut fields = vec![name.clone(), value];
        if spreads {
            fields.push(spread(dq.row(row).iter().copied(), deviations).map_or(String::new(), number));
        }
        fields.extend(dq.row(row).iter().map(|slope| number(*slope)));
        table.row(fields);
    }
    table.write(&mut text);
    let mut table = Table::new("Validity", &["parameter", "valid within", "until"]);
    for (column, key) in found.keys.iter().enumerate() {
        let within = found.valid_within[column];
        let within = if within.is_finite() { number(within) } else { "no event".to_string() };
        table.row(vec![key.clone(), within, found.bounded_by[column].clone()]);
    }
    table.write(&mut text);
    for warning in &found.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    text
}

fn as_csv(found: &Sensitivity) -> String {
    let mut text = String::from("time");
    let columns = |kind: &str| -> Vec<String> {
        let pairs = found.freedoms.iter().flat_map(|name| found.keys.iter().map(move |key| (name, key)));
        pairs.map(|(name, key)| field(&format!("d{kind}.{name}/d.{key}"))).collect()
    };
    // Ball joints have more positions than freedoms, and as many velocities.
    let count = found.q.first().map_or(0, Vec::len);
    for index in 0..count {
        let named = found.freedoms.get(index).filter(|_| count == found.freedoms.len());
        let name = named.map_or_else(|| index.to_string(), Clone::clone);
        text += &format!(",{}", field(&format!("q.{name}")));
    }
    found.freedoms.iter().for_each(|name| text += &format!(",{}", field(&format!("v.{name}"))));
    columns("q").iter().chain(&columns("v")).for_each(|name| text += &format!(",{name}"));
    text.push('\n');
    for (step, time) in found.times.iter().enumerate() {
        text += &time.to_string();
        found.q[step].iter().chain(&found.v[step]).for_each(|value| text += &format!(",{value}"));
        for of in [&found.dq[step], &found.dv[step]] {
            of.row_iter().for_each(|row| row.iter().for_each(|value| text += &format!(",{value}")));
        }
        text.push('\n');
    }
    text
}

/// The derivatives at the end, and how far they hold.
pub fn end_as_json(found: &Sensitivity, deviations: &[Option<f64>]) -> Value {
    let last = |of: &[nalgebra::DMatrix<f64>]| -> Vec<Vec<f64>> {
        let rows = of.last().into_iter().flat_map(|last| last.row_iter());
        rows.map(|row| row.iter().copied().collect()).collect()
    };
    // JSON has no infinity.
    let within: Vec<Option<f64>> = found.valid_within.iter().map(|&of| of.is_finite().then_some(of)).collect();
    json!({
        "keys": found.keys,
        "deviations": deviations,
        "freedoms": found.freedoms,
        "time": found.times.last(),
        "dq": last(&found.dq),
        "dv": last(&found.dv),
        "valid_within": within,
        "bounded_by": found.bounded_by,
        "warnings": found.warnings,
    })
}

fn as_json(args: &SensitivityArgs, found: &Sensitivity, deviations: &[Option<f64>]) -> Value {
    let rows = |of: &[nalgebra::DMatrix<f64>]| -> Vec<Vec<Vec<f64>>> {
        of.iter().map(|one| one.row_iter().map(|row| row.iter().copied().collect()).collect()).collect()
    };
    let events = found.events.iter();
    let events =
        events.map(|event| json!({ "time": event.time, "what": event.what, "dt": event.by, "rate": event.rate }));
    // JSON has no infinity.
    let within: Vec<Option<f64>> = found.valid_within.iter().map(|&of| of.is_finite().then_some(of)).collect();
    json!({
        "catena": env!("CARGO_PKG_VERSION"),
        "input": args.input.input.display().to_string(),
        "keys": found.keys,
        "deviations": deviations,
        "freedoms": found.freedoms,
        "times": found.times,
        "q": found.q,
        "v": found.v,
        "dq": rows(&found.dq),
        "dv": rows(&found.dv),
        "events": events.collect::<Vec<Value>>(),
        "valid_within": within,
        "bounded_by": found.bounded_by,
        "warnings": found.warnings,
    })
}
