//! A log as a table of comma-separated values (RFC 4180): one row a sample, every column with its unit.
//!
//! | column                                   | what                                                         |
//! |------------------------------------------|--------------------------------------------------------------|
//! | `time [s]`                               | the instant                                                  |
//! | `JOINT.position [rad]`, `.velocity`, …   | every joint; those of several numbers have one column each   |
//! | `JOINT.effort`, `JOINT.reaction_force.x` | what it carries                                              |
//! | `LINK.x [m]`, …, `LINK.qw`, …            | every link frame in the world                                |
//! | `step_end [s]`, `energy.total [J]`, …    | figures at the end of the last step, which is not later       |

use super::joint_values::{JointKinds, joint_values};
use crate::chart::comma_separated::field;
use crate::log::frames::{Frame, Frames};
use crate::log::reader::ReadError;
use crate::log::seconds;
use std::io::{self, Write};
use std::path::Path;

/// Why there is no table.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The log could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The table could not be written.
    #[error(transparent)]
    Write(#[from] io::Error),
    /// A sample is not of the same links and joints as the first.
    #[error("at t = {time} s the log has {found} numbers instead of {expected}")]
    Shape { time: f64, found: usize, expected: usize },
}

/// Writes the table of a log; returns the number of rows.
///
/// # Errors
/// [`TableError`].
pub fn write_table(log: &Path, kinds: &JointKinds, out: &mut dyn Write) -> Result<u64, TableError> {
    let mut columns = 0;
    let mut rows = 0;
    for frame in Frames::of(log)? {
        let frame = frame?;
        let cells = cells(&frame, kinds);
        if rows == 0 {
            columns = cells.len();
            let names: Vec<String> = cells.iter().map(|(name, _)| field(name)).collect();
            write!(out, "{}\r\n", names.join(","))?;
        }
        if cells.len() != columns {
            return Err(TableError::Shape { time: frame.time(), found: cells.len(), expected: columns });
        }
        let numbers: Vec<String> =
            cells.iter().map(|(_, value)| value.map_or_else(String::new, |value| value.to_string())).collect();
        write!(out, "{}\r\n", numbers.join(","))?;
        rows += 1;
    }
    Ok(rows)
}

/// Every number of a frame with the name of its column.
fn cells(frame: &Frame, kinds: &JointKinds) -> Vec<(String, Option<f64>)> {
    let mut cells = vec![("time [s]".to_string(), Some(frame.time()))];
    for value in joint_values(frame, kinds) {
        let unit = value.quantity.unit();
        let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
        cells.push((format!("{}{unit}", value.name), Some(value.value)));
    }
    for link in &frame.links {
        let [x, y, z] = link.position;
        let [qw, qx, qy, qz] = link.orientation;
        let name = &link.link;
        for (axis, value) in [("x [m]", x), ("y [m]", y), ("z [m]", z), ("qw", qw), ("qx", qx), ("qy", qy), ("qz", qz)]
        {
            cells.push((format!("{name}.{axis}"), Some(value)));
        }
    }
    let figures = &frame.figures;
    let known = figures.energy.is_some() || figures.violation.is_some();
    cells.push(("step_end [s]".to_string(), known.then_some(seconds(figures.nanoseconds))));
    for (place, name) in ["kinetic", "potential", "total", "dissipated", "work"].into_iter().enumerate() {
        cells.push((format!("energy.{name} [J]"), figures.energy.map(|energy| energy[place])));
    }
    for (place, name) in ["position [m]", "velocity [m/s]"].into_iter().enumerate() {
        cells.push((format!("constraint.{name}"), figures.violation.map(|violation| violation[place])));
    }
    cells
}
