//! The summary of a log as lines for people.

use crate::mechanism::ground::words::{counted, decimals};
use crate::output::inspection::summary::{Summary, short};
use std::fmt;

/// More warnings than this are only counted.
const SHOWN_WARNINGS: usize = 10;

/// Messages that come when there is something to say.
const WITHOUT_RATE: [&str; 3] = ["rcl_interfaces/msg/Log", "foxglove.Log", "catena_msgs/msg/Event"];

impl fmt::Display for Summary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let entry = |name: &str| self.simulation.get(name).map(String::as_str).filter(|text| !text.is_empty());
        writeln!(out, "{}: {}", self.log, self.state())?;
        write!(out, "  run         {}, ", entry("scene").or_else(|| entry("robot")).unwrap_or("?"))?;
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
        if let Some(events) = &self.events {
            let (total, words) = (events.counts.total(), events.counts.words());
            writeln!(out, "  events      {}", if total > 0 { format!("{total}: {words}") } else { words })?;
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
                "  constraint  largest error {:.1e} m, {:.1e} m/s",
                constraint.max_position, constraint.max_velocity
            )?;
        }
        if let Some(contact) = &self.contact {
            writeln!(out, "  contact     {}", contact.words())?;
        }
        for topic in &self.topics {
            write!(out, "  topic       {:24} {:8} messages", topic.topic, topic.messages)?;
            match topic.rate.filter(|_| !WITHOUT_RATE.contains(&topic.schema.as_str())) {
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
