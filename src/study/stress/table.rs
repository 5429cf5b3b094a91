//! The map as comma-separated values, and as text for a terminal.

use crate::drawing::comma_separated::field;
use crate::stress::cell::{Ended, Verdict};
use crate::stress::map::Map;
use std::fmt::Write;

const COLUMNS: [&str; 14] = [
    "problem",
    "difficulty",
    "method",
    "setting",
    "verdict",
    "end_error_m",
    "energy_error",
    "cpu_seconds",
    "ended",
    "error_name",
    "error_time_s",
    "warning",
    "size_m",
    "answer",
];

/// Every cell of some maps as CSV, all digits kept; NaN and infinities are left empty.
pub fn write_csv(maps: &[Map]) -> String {
    let number = |value: f64| if value.is_finite() { format!("{value:e}") } else { String::new() };
    let mut text = COLUMNS.join(",") + "\n";
    for map in maps {
        let problem = &map.thinned.problem;
        for cell in &map.cells {
            let row = map.thinned.places.iter().position(|&place| place == cell.place);
            let answer = row.and_then(|row| map.answers.get(row));
            let (ended, name, time) = match &cell.ended {
                Ended::Survived => (String::new(), "", f64::NAN),
                Ended::Failed(failure) => (failure.message.clone(), failure.name, failure.time),
                Ended::TimedOut { time } => (format!("cut at t = {time} s"), "", *time),
                Ended::NotApplicable(reason) => ((*reason).to_string(), "", f64::NAN),
            };
            let fields = [
                problem.name.to_string(),
                field(problem.difficulties[cell.place]),
                cell.method.id(),
                cell.setting.to_string(),
                cell.verdict.word().to_string(),
                number(cell.end_error),
                number(cell.energy_error),
                number(cell.cpu_seconds),
                field(&ended),
                name.to_string(),
                number(time),
                field(cell.warning.as_deref().unwrap_or("")),
                number(answer.map_or(f64::NAN, |answer| answer.size)),
                field(answer.map_or("", |answer| answer.refusal.unwrap_or(&answer.source))),
            ];
            text += &fields.join(",");
            text.push('\n');
        }
    }
    text
}

/// How many cells of each method ended how, problem by problem.
pub fn summary(maps: &[Map]) -> String {
    let mut text = format!("{:<20} {:<20}", "problem", "method");
    for verdict in Verdict::ALL {
        let _ = write!(text, " {:>14}", verdict.word());
    }
    text.push('\n');
    for map in maps {
        for method in map.methods {
            let _ = write!(text, "{:<20} {:<20}", map.thinned.problem.name, method.id());
            for verdict in Verdict::ALL {
                let _ = write!(text, " {:>14}", map.count(method, verdict));
            }
            text.push('\n');
        }
    }
    let defects: usize = maps.iter().map(|map| map.defects().count()).sum();
    let _ = writeln!(text, "cells of catena that ended in garbage without an error or a warning: {defects}");
    text
}
