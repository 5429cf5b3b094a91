//! The summary of a log: the settings of the run, its results, and the topics.

use crate::mechanism::ground::words;
use crate::mechanism::motion::gaps::worse;
use crate::output::log::reading::decode::{LogLine, LoggedEvent};
use crate::output::log::reading::frames::{Figures, Frame, Visitor, visit};
use crate::output::log::reading::reader::LogChannel;
use crate::output::log::reading::records::{Completeness, ReadError};
use crate::output::log::reading::recovery::{MISSING, RECOVERY};
use crate::output::log::recording::accuracy_lines::ACCURACY;
use crate::output::log::{is_locked, seconds};
use crate::output::report::{ERROR_AT_START, KindCounts, UNKNOWN, contact_words};
use serde::Serialize;
use std::collections::BTreeMap;
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
    /// The missing parts, if it is incomplete.
    #[serde(flatten)]
    pub completeness: Completeness,
    /// The missing parts of the log that it was recovered from, if it was recovered.
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
    /// How many events there are of each kind, in a log that has any place for them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub events: Option<EventSummary>,
    /// Energy over the run.
    pub energy: Option<EnergySummary>,
    /// Constraint violation over the run.
    pub constraint: Option<ConstraintSummary>,
    /// Contacts, in a log that has any place for them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact: Option<ContactSummary>,
    /// The error that is expected of positions (m), of the order of magnitude, if the log says it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimated_error: Option<f64>,
    /// The estimated error of its start (m), if that was in another log whose error is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimated_error_at_start: Option<f64>,
    /// Whether its start was in another log whose error is not known.
    #[serde(skip)]
    starts_anyhow: bool,
    /// The last line about the accuracy that was written during the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy_so_far: Option<String>,
    /// The cost of the steps.
    pub solver: Option<SolverSummary>,
    /// The topics of the log.
    pub topics: Vec<Topic>,
    /// The files that the log carries, and their lengths in bytes.
    pub attachments: BTreeMap<String, usize>,
    /// How the run was made.
    pub simulation: BTreeMap<String, String>,
    /// Warnings and errors.
    pub warnings: Vec<String>,
}

/// The events of a log, counted.
#[derive(Clone, Debug, Default, Serialize)]
pub struct EventSummary {
    /// How many there are of each kind.
    pub counts: KindCounts,
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
    /// Lost to dry friction since the start.
    pub friction: f64,
    /// Lost in impacts since the start.
    pub impacts: f64,
    /// Work put in since the start.
    pub work: f64,
    /// Largest deviation from the start, less the exchanged energy, relative to the largest kinetic energy; of all steps if the log is complete, else
    /// of its steps so far.
    pub max_relative_error: f64,
}

/// Largest constraint violations; of all steps if the log is complete, else of those that are in it.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ConstraintSummary {
    /// Largest error of positions [m, rad].
    pub max_position: f64,
    /// Largest error of velocities [m/s, rad/s].
    pub max_velocity: f64,
}

/// Contacts at the end of a run, and the worst of all.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct ContactSummary {
    /// How many are closed in the last sample.
    pub at_end: usize,
    /// How many of these slip.
    pub slipping: usize,
    /// The deepest overlap (m), of all steps if the log is complete, else of the samples that are in it.
    pub max_penetration: f64,
    /// The farthest of a force from its friction cone (N), of all steps, if the log says it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_cone_violation: Option<f64>,
}

impl ContactSummary {
    /// In words, as the report of a run has them.
    pub(crate) fn words(&self) -> String {
        contact_words(self.at_end, self.slipping, self.max_penetration, self.max_cone_violation)
    }
}

/// The cost of the steps.
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
    /// Dissipated, put in, lost to friction and in impacts (J).
    exchange: [f64; 4],
    largest_kinetic: f64,
    largest_deviation: f64,
    violation: Option<[f64; 2]>,
}

impl Visitor for Collector {
    fn frame(&mut self, frame: &Frame) -> ControlFlow<()> {
        let summary = &mut self.summary;
        summary.samples += 1;
        summary.duration = summary.duration.max(frame.time());
        // The last sample of a log that was cut may lack some messages.
        summary.links = summary.links.max(frame.links.len());
        summary.joints = summary.joints.max(frame.joints.names.len() + frame.multi_dof.names.len());
        if let Some(contact) = &mut summary.contact {
            contact.at_end = frame.contacts.len();
            contact.slipping = frame.contacts.iter().filter(|contact| contact.state == "slip").count();
            contact.max_penetration =
                frame.contacts.iter().map(|contact| -contact.gap).fold(contact.max_penetration, worse);
        }
        ControlFlow::Continue(())
    }

    fn figures(&mut self, figures: &Figures) {
        if let (Some([kinetic, _, total, exchange @ ..]), Some(balance)) = (figures.energy, figures.balance()) {
            self.exchange = exchange;
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
        if channel.topic == "/events" {
            self.summary.events.get_or_insert_default();
        }
        if channel.topic == "/contacts" {
            self.summary.contact.get_or_insert_default();
        }
    }

    fn event(&mut self, event: LoggedEvent) {
        self.summary.events.get_or_insert_default().counts.add(&event.kind, 1);
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
        if let Some(said) = line.text.strip_prefix(ACCURACY) {
            self.summary.accuracy_so_far = Some(said.to_string());
        } else if line.is_problem {
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
        summary.estimated_error = number("estimated_error");
        summary.estimated_error_at_start = number(ERROR_AT_START);
        summary.starts_anyhow = end.get(ERROR_AT_START).is_some_and(|error| error == UNKNOWN);
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
            friction: self.exchange[2],
            impacts: self.exchange[3],
            work: self.exchange[1],
            max_relative_error: number("energy_max_relative_error").unwrap_or(self.largest_deviation / scale),
        });
        summary.constraint = self.violation.map(|[position, velocity]| ConstraintSummary {
            max_position: number("constraint_max_position").unwrap_or(position),
            max_velocity: number("constraint_max_velocity").unwrap_or(velocity),
        });
        if let Some(contact) = &mut summary.contact {
            contact.max_penetration = number("contact_max_penetration").unwrap_or(contact.max_penetration);
            contact.max_cone_violation = number("contact_max_cone_violation");
        }
        if let (Some(steps), Some(iterations), Some(rejected_steps)) =
            (number("steps"), number("iterations"), number("rejected_steps"))
        {
            summary.solver = Some(SolverSummary { steps, iterations, rejected_steps });
        }
        summary
    }
}

impl Summary {
    /// The error to expect of positions in it (m), with that of its start; `None` if it is not known.
    pub fn error_of_samples(&self) -> Option<f64> {
        let own = self.estimated_error.filter(|_| !self.starts_anyhow)?;
        Some(own + self.estimated_error_at_start.unwrap_or(0.0))
    }

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

/// The entry of a log; a number without a row of zeros.
pub(crate) fn short(said: &str) -> String {
    said.parse().map_or_else(|_| said.to_string(), words::short)
}
