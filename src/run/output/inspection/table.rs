//! A log as a table of comma-separated values (RFC 4180): one row a sample, every column with its unit.
//!
//! | column                                   | what                                                         |
//! |------------------------------------------|--------------------------------------------------------------|
//! | `time [s]`                               | the instant                                                  |
//! | `JOINT.position [rad]`, `.velocity`, …   | every joint; those of several numbers have one column each   |
//! | `JOINT.effort`, `JOINT.reaction_force.x` | what it carries                                              |
//! | `JOINT.motor_effort [N m]`               | what its motor does, if it has one                           |
//! | `A\|B.contact_force.x [N]`, …            | force of B on A, for all that touch at any sample            |
//! | `LINK.x [m]`, …, `LINK.qw`, …            | every link frame in the world                                |
//! | `sensitivity_at [s]`, `dJOINT.position/dKEY`, … | derivatives at the end of the last step that has them, if the log does |
//! | `step_end [s]`, `energy.total [J]`, …    | figures at the end of the last step, which is not later       |

use crate::drawing::comma_separated::field;
use crate::output::inspection::joint_values::{JointKinds, contact_forces, joint_values};
use crate::output::log::reading::frame_stream::Frames;
use crate::output::log::reading::frames::{Frame, Slopes, Visitor, visit};
use crate::output::log::reading::reader::LogChannel;
use crate::output::log::reading::records::ReadError;
use crate::output::log::seconds;
use std::io::{self, Write};
use std::ops::ControlFlow;
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
    #[error(
        "at t = {time} s the log has {found} where the first sample has {expected}, and a table has the same columns in all rows"
    )]
    Shape { time: f64, found: String, expected: String },
    /// There are no samples.
    #[error("the log has no samples, so there is no table to write")]
    Empty,
}

/// Writes the table of a log.
///
/// # Errors
/// [`TableError`].
pub fn write_table(log: &Path, kinds: &JointKinds, out: &mut dyn Write) -> Result<(), TableError> {
    let mut columns: Vec<String> = Vec::new();
    let pairs = touching_pairs(log)?;
    for frame in Frames::of(log)? {
        let frame = frame?;
        let cells = cells(&frame, kinds, &pairs);
        if columns.is_empty() {
            columns = cells.iter().map(|(name, _)| name.clone()).collect();
            let names: Vec<String> = columns.iter().map(|name| field(name)).collect();
            write!(out, "{}\r\n", names.join(","))?;
        }
        let names = cells.iter().map(|(name, _)| name.as_str());
        if !names.eq(columns.iter().map(String::as_str)) {
            return Err(mismatch(&columns, &cells, frame.time()));
        }
        let numbers: Vec<String> =
            cells.iter().map(|(_, value)| value.map_or_else(String::new, |value| value.to_string())).collect();
        write!(out, "{}\r\n", numbers.join(","))?;
    }
    if columns.is_empty() { Err(TableError::Empty) } else { Ok(()) }
}

/// Collects the pairs that touch.
#[derive(Default)]
struct Touching {
    /// Whether the log has any place for contacts.
    may_touch: bool,
    pairs: Vec<String>,
}

impl Visitor for Touching {
    fn channel(&mut self, channel: &LogChannel) {
        self.may_touch |= channel.topic == "/contacts";
    }

    fn frame(&mut self, frame: &Frame) -> ControlFlow<()> {
        for (pair, _) in contact_forces(frame) {
            if !self.pairs.contains(&pair) {
                self.pairs.push(pair);
            }
        }
        // Channels come before the messages.
        if self.may_touch { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}

/// The pairs `a|b` that touch at any sample of a log, in the order in which they first do.
fn touching_pairs(log: &Path) -> Result<Vec<String>, ReadError> {
    let mut touching = Touching::default();
    visit(log, &mut touching)?;
    Ok(touching.pairs)
}

/// The first cell of a sample that does not belong to its column.
fn mismatch(columns: &[String], cells: &[(String, Option<f64>)], time: f64) -> TableError {
    let same = columns.iter().zip(cells).take_while(|(column, (name, _))| *column == name).count();
    let word = |name: Option<&String>| name.map_or("nothing more".to_string(), |name| format!("{name:?}"));
    let found = word(cells.get(same).map(|(name, _)| name));
    TableError::Shape { time, found, expected: word(columns.get(same)) }
}

/// The parts of the energy, in the order of the log.
const ENERGIES: [&str; 7] = ["kinetic", "potential", "total", "dissipated", "work", "friction", "impacts"];

/// Every number of a frame with the name of its column.
fn cells(frame: &Frame, kinds: &JointKinds, pairs: &[String]) -> Vec<(String, Option<f64>)> {
    let mut cells = vec![("time [s]".to_string(), Some(frame.time()))];
    for value in joint_values(frame, kinds) {
        let unit = value.quantity.unit();
        let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
        cells.push((format!("{}{unit}", value.name), Some(value.value)));
    }
    let forces = contact_forces(frame);
    for pair in pairs {
        let force = forces.iter().find(|(known, _)| known == pair).map_or([0.0; 3], |(_, force)| *force);
        for (axis, value) in ["x", "y", "z"].into_iter().zip(force) {
            cells.push((format!("{pair}.contact_force.{axis} [N]"), Some(value)));
        }
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
    if let Some(first) = frame.slopes.first() {
        cells.push(("sensitivity_at [s]".to_string(), Some(seconds(first.nanoseconds))));
    }
    for Slopes { key, by, .. } in &frame.slopes {
        for (what, values) in [("position", &by.positions), ("velocity", &by.velocities)] {
            let named = by.names.iter().zip(values);
            cells.extend(named.map(|(name, value)| (format!("d{name}.{what}/d{key}"), Some(*value))));
        }
    }
    let figures = &frame.figures;
    let known = figures.energy.is_some() || figures.violation.is_some();
    cells.push(("step_end [s]".to_string(), known.then_some(seconds(figures.nanoseconds))));
    for (place, name) in ENERGIES.into_iter().enumerate() {
        cells.push((format!("energy.{name} [J]"), figures.energy.map(|energy| energy[place])));
    }
    for (place, name) in ["position [m]", "velocity [m/s]"].into_iter().enumerate() {
        cells.push((format!("constraint.{name}"), figures.violation.map(|violation| violation[place])));
    }
    cells
}
