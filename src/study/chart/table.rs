//! The numbers of a chart as CSV, and the numbers of other programs read back.
//!
//! | column                             | meaning                                                        | foreign files |
//! |------------------------------------|----------------------------------------------------------------|---------------|
//! | `scene`                            | name of the scene: the input's file name without ending        | needed        |
//! | `method`                           | any name; it is the label of the curve                         | needed        |
//! | `setting`                          | `step=…` (s) or `tolerance=…`                                  |               |
//! | `error`                            | distance of the end from the reference (m), [`crate::mechanism::motion::distance`] | needed        |
//! | `cpu_seconds_per_simulated_second` | CPU time of the integration loop / simulated time              | needed        |
//! | `steps`, `iterations`, `rejected_steps` | accepted steps; iterations or evaluations; attempts thrown away |          |
//! | `energy_error`                     | energy error at the end / largest kinetic energy               |               |
//! | `ended`                            | `done`, or how it failed                                       |               |
//!
//! Columns are found by their names in the first line, in any order; others are skipped. An unknown number is empty.

use crate::chart::timing::Ended;
use crate::drawing::comma_separated::{field, records};
use crate::drawing::error::ChartError;
use std::path::Path;

/// One run of one method.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Name of the scene.
    pub scene: String,
    /// Name of the method ([`crate::chart::Method::id`], or the name of a foreign program).
    pub method: String,
    /// The setting of the method.
    pub setting: String,
    /// Distance of the end from the reference (m); NaN if there is no end.
    pub error: f64,
    /// CPU seconds of the integration loop per simulated second; NaN if the run did not end.
    pub cpu_seconds_per_simulated_second: f64,
    /// Accepted steps.
    pub steps: Option<usize>,
    /// Iterations of the nonlinear solve, or evaluations of the right-hand side.
    pub iterations: Option<usize>,
    /// Attempts thrown away.
    pub rejected_steps: Option<usize>,
    /// Energy error at the end relative to the largest kinetic energy.
    pub energy_error: f64,
    /// How the run ended.
    pub ended: Ended,
}

impl Measurement {
    /// Error and cost, if the run came to an end that can be drawn on logarithmic axes.
    pub fn point(&self) -> Option<(f64, f64)> {
        let (error, cost) = (self.error, self.cpu_seconds_per_simulated_second);
        (self.ended == Ended::Done && error.is_finite() && error >= 0.0 && cost.is_finite() && cost > 0.0)
            .then_some((error, cost))
    }
}

const COLUMNS: [&str; 10] = [
    "scene",
    "method",
    "setting",
    "error",
    "cpu_seconds_per_simulated_second",
    "steps",
    "iterations",
    "rejected_steps",
    "energy_error",
    "ended",
];
const NEEDED: [&str; 4] = ["scene", "method", "error", "cpu_seconds_per_simulated_second"];

/// The measurements as CSV, all digits kept.
pub fn write_csv(measurements: &[Measurement]) -> String {
    let number = |value: f64| if value.is_finite() { format!("{value:e}") } else { String::new() };
    let count = |value: Option<usize>| value.map_or(String::new(), |count| count.to_string());
    let mut text = COLUMNS.join(",") + "\n";
    for measurement in measurements {
        let fields = [
            field(&measurement.scene),
            field(&measurement.method),
            field(&measurement.setting),
            number(measurement.error),
            number(measurement.cpu_seconds_per_simulated_second),
            count(measurement.steps),
            count(measurement.iterations),
            count(measurement.rejected_steps),
            number(measurement.energy_error),
            field(&measurement.ended.to_string()),
        ];
        text += &fields.join(",");
        text.push('\n');
    }
    text
}

/// Reads a file of measurements, ours or foreign.
///
/// # Errors
/// [`ChartError::Read`], or [`ChartError::Csv`] with the line and the defect.
pub fn read_csv(path: &Path) -> Result<Vec<Measurement>, ChartError> {
    let text = std::fs::read_to_string(path).map_err(|reason| ChartError::Read { path: path.to_path_buf(), reason })?;
    parse_csv(&text).map_err(|(line, problem)| ChartError::Csv { path: path.to_path_buf(), line, problem })
}

/// The measurements in the text of a CSV file.
///
/// # Errors
/// The line and its defect.
pub fn parse_csv(text: &str) -> Result<Vec<Measurement>, (usize, String)> {
    // Spreadsheets put a byte order mark in front.
    let mut records = records(text.trim_start_matches('\u{feff}'))?;
    // Comments, as in other tables.
    records.retain(|(_, fields)| !fields.first().is_some_and(|field| field.trim_start().starts_with('#')));
    let Some(((_, header), rows)) = records.split_first() else {
        return Err((1, format!("empty; the first line must name the columns {}", NEEDED.join(", "))));
    };
    let place = |name: &str| header.iter().position(|column| column.trim() == name);
    if let Some(missing) = NEEDED.iter().find(|name| place(name).is_none()) {
        return Err((1, format!("there is no column {missing:?}; {} are needed", NEEDED.join(", "))));
    }
    rows.iter()
        .map(|(line, row)| {
            if row.len() != header.len() {
                return Err((*line, format!("{} fields, but {} columns", row.len(), header.len())));
            }
            let text = |name: &str| place(name).map_or("", |column| row[column].trim());
            let number = |name: &str| match text(name) {
                "" => Ok(f64::NAN),
                word => word.parse::<f64>().map_err(|_| (*line, format!("{name}: {word:?} is not a number"))),
            };
            let count = |name: &str| match text(name) {
                "" => Ok(None),
                word => word.parse().map(Some).map_err(|_| (*line, format!("{name}: {word:?} is not a whole number"))),
            };
            Ok(Measurement {
                scene: text("scene").to_string(),
                method: text("method").to_string(),
                setting: text("setting").to_string(),
                error: number("error")?,
                cpu_seconds_per_simulated_second: number("cpu_seconds_per_simulated_second")?,
                steps: count("steps")?,
                iterations: count("iterations")?,
                rejected_steps: count("rejected_steps")?,
                energy_error: number("energy_error")?,
                ended: ended(text("ended")),
            })
        })
        .collect()
}

/// The inverse of its display; whatever other programs say that is not `done` is a failure.
fn ended(text: &str) -> Ended {
    let cut = text.strip_prefix("cut at t = ").and_then(|rest| rest.strip_suffix(" s: too slow"));
    match (text, cut.and_then(|time| time.parse().ok())) {
        ("" | "done", _) => Ended::Done,
        ("interrupted", _) => Ended::Interrupted,
        (_, Some(time)) => Ended::Cut { time },
        _ => Ended::Failed(text.strip_prefix("failed: ").unwrap_or(text).to_string()),
    }
}
