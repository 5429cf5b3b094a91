//! The summary of a log: how the run was made, how it went, and what there is to see.

use crate::mechanism::ground::words;
use crate::mechanism::ground::words::{counted, decimals};
use crate::mechanism::motion::gaps::worse;
use crate::output::log::decode::LogLine;
use crate::output::log::frames::{Figures, Frame, Visitor, visit};
use crate::output::log::reader::LogChannel;
use crate::output::log::records::{Completeness, ReadError};
use crate::output::log::recovery::{MISSING, RECOVERY};
use crate::output::log::{is_locked, seconds};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;
use std::ops::ControlFlow;
use std::path::Path;

/// Everything about a log that fits on a screen.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Summary {
    /// The file.
    pub log: String,
    /// Its length.
    pub bytes: u64,
    /// Whether all of it is there.
    pub complete: bool,
    /// What is missing, if something is.
    #[serde(flatten)]
    pub completeness: Completeness,
    /// What was missing of the log that it was recovered from, if it was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recovered_from: Option<String>,
    /// Whether a run is writing it.
    pub being_written: bool,
    /// How the run ended: `finished`, `interrupted`, `failed`; `null` if the log does not say.
    pub outcome: Option<String>,
    /// Simulated time of the last sample (s).
    pub duration: f64,
    /// Number of samples.
    pub samples: u64,
    /// Samples per simulated second that were asked for.
    pub rate: Option<f64>,
    /// Number of links and of joints that move.
    pub links: usize,
    /// Joints that move.
    pub joints: usize,
    /// Energy over the run.
    pub energy: Option<EnergySummary>,
    /// Constraint violation over the run.
    pub constraint: Option<ConstraintSummary>,
    /// What the steps took.
    pub solver: Option<SolverSummary>,
    /// What there is to see.
    pub topics: Vec<Topic>,
    /// The files that the log carries, and their lengths in bytes.
    pub attachments: BTreeMap<String, usize>,
    /// How the run was made.
    pub simulation: BTreeMap<String, String>,
    /// Warnings and errors.
    pub warnings: Vec<String>,
}

/// Energy (J) at both ends and its error in between.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct EnergySummary {
    /// Total energy at the start.
    pub initial: f64,
    /// Total energy at the end of the last step.
    pub r#final: f64,
    /// Dissipated since the start.
    pub dissipated: f64,
    /// Work put in since the start.
    pub work: f64,
    /// Largest deviation from the start, less what was exchanged, relative to the largest kinetic energy; of all steps
    /// if the log is complete, else of those that are in it.
    pub max_relative_error: f64,
}

/// Largest constraint violations; of all steps if the log is complete, else of those that are in it.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ConstraintSummary {
    /// Of positions [m, rad].
    pub max_position: f64,
    /// Of velocities [m/s, rad/s].
    pub max_velocity: f64,
}

/// What the steps took.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct SolverSummary {
    /// Accepted steps.
    pub steps: f64,
    /// Iterations of all steps.
    pub iterations: f64,
    /// Steps that were thrown away.
    pub rejected_steps: f64,
}

/// A topic.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Topic {
    /// Its name.
    pub topic: String,
    /// The kind of its messages.
    pub schema: String,
    /// How many there are.
    pub messages: u64,
    /// Messages per simulated second between the first and the last.
    pub rate: Option<f64>,
    /// Nanoseconds of the first and the last message.
    #[serde(skip)]
    range: (u64, u64),
}

/// Collects a summary.
#[derive(Default)]
struct Collector {
    summary: Summary,
    end: BTreeMap<String, String>,
    initial: Option<f64>,
    last_energy: f64,
    exchange: [f64; 2],
    largest_kinetic: f64,
    largest_deviation: f64,
    violation: Option<[f64; 2]>,
}

impl Visitor for Collector {
    fn frame(&mut self, frame: &Frame) -> ControlFlow<()> {
        let summary = &mut self.summary;
        summary.samples += 1;
        summary.duration = summary.duration.max(frame.time());
        // Of the last sample of a log that was cut some messages may be missing.
        summary.links = summary.links.max(frame.links.len());
        summary.joints = summary.joints.max(frame.joints.names.len() + frame.multi_dof.names.len());
        ControlFlow::Continue(())
    }

    fn figures(&mut self, figures: &Figures) {
        if let (Some([kinetic, _, total, dissipated, work]), Some(balance)) = (figures.energy, figures.balance()) {
            self.exchange = [dissipated, work];
            let initial = *self.initial.get_or_insert(balance);
            self.last_energy = total;
            self.largest_kinetic = self.largest_kinetic.max(kinetic);
            self.largest_deviation = worse(self.largest_deviation, (balance - initial).abs());
        }
        if let Some([position, velocity]) = figures.violation {
            let largest = self.violation.get_or_insert_default();
            *largest = [worse(largest[0], position), worse(largest[1], velocity)];
        }
        if let Some([_, _, steps, iterations, rejected]) = figures.solver {
            let solver = self.summary.solver.get_or_insert_default();
            solver.steps += steps;
            solver.iterations += iterations;
            solver.rejected_steps += rejected;
        }
    }

    fn channel(&mut self, channel: &LogChannel) {
        let topic = Topic { topic: channel.topic.clone(), schema: channel.schema.clone(), ..Topic::default() };
        if !self.summary.topics.iter().any(|known| known.topic == topic.topic) {
            self.summary.topics.push(topic);
        }
    }

    fn message(&mut self, channel: &LogChannel, nanoseconds: u64) {
        if let Some(topic) = self.summary.topics.iter_mut().find(|topic| topic.topic == channel.topic) {
            // Logs of others may go back in time.
            let (first, last) = if topic.messages == 0 { (nanoseconds, nanoseconds) } else { topic.range };
            topic.range = (first.min(nanoseconds), last.max(nanoseconds));
            topic.messages += 1;
        }
    }

    fn line(&mut self, _: u64, line: LogLine) {
        if line.is_problem {
            self.summary.warnings.push(line.text);
        }
    }

    fn metadata(&mut self, name: &str, entries: &BTreeMap<String, String>) {
        match name {
            "simulation" => self.summary.simulation.clone_from(entries),
            "end" => self.end.clone_from(entries),
            RECOVERY => self.summary.recovered_from = entries.get(MISSING).cloned(),
            _ => {}
        }
    }

    fn attachment(&mut self, name: &str, _: &str, data: &[u8]) {
        self.summary.attachments.insert(name.to_string(), data.len());
    }
}

impl Collector {
    fn finish(self) -> Summary {
        let Collector { mut summary, end, .. } = self;
        let number = |name: &str| end.get(name).and_then(|text| text.parse::<f64>().ok());
        summary.outcome = end.get("outcome").cloned();
        summary.rate = summary.simulation.get("rate").and_then(|rate| rate.parse().ok());
        for topic in &mut summary.topics {
            let span = seconds(topic.range.1 - topic.range.0);
            topic.rate = (topic.messages > 1 && span > 0.0).then(|| (topic.messages - 1) as f64 / span);
        }
        let scale = if self.largest_kinetic > 0.0 { self.largest_kinetic } else { 1.0 };
        // The record at the end is of all steps, the messages of those that were sampled.
        summary.energy = self.initial.map(|initial| EnergySummary {
            initial,
            r#final: number("energy_final").unwrap_or(self.last_energy),
            dissipated: self.exchange[0],
            work: self.exchange[1],
            max_relative_error: number("energy_max_relative_error").unwrap_or(self.largest_deviation / scale),
        });
        summary.constraint = self.violation.map(|[position, velocity]| ConstraintSummary {
            max_position: number("constraint_max_position").unwrap_or(position),
            max_velocity: number("constraint_max_velocity").unwrap_or(velocity),
        });
        if let (Some(steps), Some(iterations), Some(rejected_steps)) =
            (number("steps"), number("iterations"), number("rejected_steps"))
        {
            summary.solver = Some(SolverSummary { steps, iterations, rejected_steps });
        }
        summary
    }
}

impl Summary {
    /// Reads a log from its beginning to its end.
    ///
    /// # Errors
    /// [`ReadError`] if it is not a log.
    pub fn read(log: &Path) -> Result<Self, ReadError> {
        let mut collector = Collector::default();
        let completeness = visit(log, &mut collector)?;
        let mut summary = collector.finish();
        summary.log = log.display().to_string();
        summary.bytes = std::fs::metadata(log).map_or(0, |file| file.len());
        summary.being_written = is_locked(log);
        // The collector never breaks off.
        summary.completeness = completeness.unwrap_or_default();
        summary.complete = summary.completeness.is_complete();
        Ok(summary)
    }

    /// How complete the log is, in words.
    pub fn state(&self) -> String {
        if let (true, Some(missing)) = (self.complete, &self.recovered_from) {
            return format!("recovered from a log that was {missing}");
        }
        match (&self.outcome, self.completeness.missing()) {
            _ if self.being_written => "still being written".to_string(),
            (_, Some(missing)) => format!("{missing}; everything else is shown"),
            (Some(outcome), None) => {
                format!("complete, the run {}", if outcome == "finished" { "has finished" } else { outcome.as_str() })
            }
            (None, None) => "whole, but without a record of how the run ended: it may have broken off".to_string(),
        }
    }
}

/// What a log says, if that is a number without a row of zeros.
pub(crate) fn short(said: &str) -> String {
    said.parse().map_or_else(|_| said.to_string(), words::short)
}

/// More warnings than this are only counted.
const SHOWN_WARNINGS: usize = 10;

impl fmt::Display for Summary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let entry = |name: &str| self.simulation.get(name).map(String::as_str).filter(|text| !text.is_empty());
        writeln!(out, "{}: {}", self.log, self.state())?;
        write!(out, "  run         {}, ", entry("robot").unwrap_or("?"))?;
        let last = self.duration;
        write!(out, "t = 0 to {last} s")?;
        if let Some(asked) = entry("duration").and_then(|text| text.parse::<f64>().ok()).filter(|asked| *asked > last) {
            write!(out, " of {asked} s")?;
        }
        write!(out, ", {} samples", self.samples)?;
        match self.rate {
            Some(rate) => writeln!(out, ", {rate} a second")?,
            None => writeln!(out)?,
        }
        writeln!(
            out,
            "  model       {}, {}",
            counted(self.links, "link", "links"),
            counted(self.joints, "moving joint", "moving joints")
        )?;
        if let Some(method) = entry("method") {
            write!(out, "  method      {method}")?;
            for (name, word) in
                [("stages", "stages"), ("order", "order"), ("tolerance", "tolerance"), ("step", "step [s]")]
            {
                if let Some(value) = entry(name) {
                    write!(out, ", {word} {}", short(value))?;
                }
            }
            writeln!(out)?;
        }
        if let Some(solver) = &self.solver {
            writeln!(
                out,
                "  steps       {}, {} iterations, {} rejected",
                solver.steps, solver.iterations, solver.rejected_steps
            )?;
        }
        if let Some(energy) = &self.energy {
            writeln!(
                out,
                "  energy      {} J at the start, largest relative error {:.1e}",
                decimals(energy.initial),
                energy.max_relative_error
            )?;
        }
        if let Some(constraint) = &self.constraint {
            writeln!(
                out,
                "  constraint  largest violation {:.1e} m, {:.1e} m/s",
                constraint.max_position, constraint.max_velocity
            )?;
        }
        for topic in &self.topics {
            write!(out, "  topic       {:24} {:8} messages", topic.topic, topic.messages)?;
            match topic.rate.filter(|_| topic.schema != "foxglove.Log") {
                Some(rate) => writeln!(out, " {:8.2} a second   {}", rate, topic.schema)?,
                None => writeln!(out, " {:8} {:8}   {}", "", "", topic.schema)?,
            }
        }
        for (name, length) in &self.attachments {
            writeln!(out, "  attachment  {name}, {length} bytes")?;
        }
        if let Some(version) = entry("version") {
            writeln!(out, "  made by     catena {version}: {}", entry("command_line").unwrap_or("?"))?;
        }
        if let Some(hash) = entry("input_sha256") {
            writeln!(out, "  input       SHA-256 {hash}")?;
        }
        for warning in self.warnings.iter().take(SHOWN_WARNINGS) {
            writeln!(out, "  warning     {warning}")?;
        }
        if self.warnings.len() > SHOWN_WARNINGS {
            writeln!(out, "  warning     and {} more", self.warnings.len() - SHOWN_WARNINGS)?;
        }
        Ok(())
    }
}
