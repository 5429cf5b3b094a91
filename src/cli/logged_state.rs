//! The state of a model at an instant of a log, for `catena inspect --at` and `catena simulate --from`.

use anyhow::anyhow;
use catena::mechanism::motion::state::State;
use catena::model::Model;
use catena::output::log::START;
use catena::output::log::reading::frames::{Frame, Visitor, visit};
use catena::output::log::seconds;
use catena::output::page::BARE;
use catena::session::{HELD, HeldTargets};
use std::collections::{BTreeMap, HashMap};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// `LOG@T`: an instant of a log; without T its end.
#[derive(Clone, Debug, PartialEq)]
pub struct LogInstant {
    pub log: PathBuf,
    /// s after the start of the log's run; infinite for its end.
    pub time: f64,
}

impl std::str::FromStr for LogInstant {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (log, time) = text.rsplit_once('@').ok_or("give LOG@T, a log and a time in s, or LOG@end")?;
        let time = match time.trim() {
            "end" => f64::INFINITY,
            number => number
                .parse()
                .ok()
                .filter(|time: &f64| time.is_finite())
                .ok_or_else(|| format!("{number:?} is no time; give LOG@T with a time in s, or LOG@end"))?,
        };
        Ok(LogInstant { log: log.into(), time })
    }
}

/// Finds the frame nearest to a time, and when the run of the log started.
struct Nearest {
    time: f64,
    /// Whether the time counts from the start of the run.
    from_start: bool,
    /// Nanoseconds.
    start: u64,
    /// The targets of motors that hold their joints from the start on.
    held: HeldTargets,
    found: Option<Frame>,
}

impl Nearest {
    /// How far a frame is from the time (s).
    fn distance(&self, frame: &Frame) -> f64 {
        (self.time_of(frame) - self.time).abs()
    }

    /// The time of a frame, counted as wanted (s).
    fn time_of(&self, frame: &Frame) -> f64 {
        let start = if self.from_start { self.start } else { 0 };
        seconds(frame.nanoseconds.saturating_sub(start))
    }
}

impl Visitor for Nearest {
    fn frame(&mut self, frame: &Frame) -> ControlFlow<()> {
        // Up to the time every frame is nearer than those before, also where it is so far off that their distances round to the same.
        let is_past = self.time_of(frame) > self.time;
        if is_past && self.found.as_ref().is_some_and(|found| self.distance(found) <= self.distance(frame)) {
            return ControlFlow::Break(());
        }
        self.found = Some(frame.clone());
        ControlFlow::Continue(())
    }

    fn metadata(&mut self, name: &str, entries: &BTreeMap<String, String>) {
        if name == "simulation" {
            self.start = entries.get(START).and_then(|start| start.parse().ok()).unwrap_or(0);
            self.held = entries.get(HELD).and_then(|held| serde_json::from_str(held).ok()).unwrap_or_default();
        }
    }
}

fn nearest(log: &Path, time: f64, from_start: bool) -> anyhow::Result<(Frame, f64, HeldTargets)> {
    let mut nearest = Nearest { time, from_start, start: 0, held: HeldTargets::new(), found: None };
    visit(log, &mut nearest)?;
    let frame = nearest.found.take().ok_or_else(|| anyhow!("{}: there are no samples in it", log.display()))?;
    let time = nearest.time_of(&frame);
    Ok((frame, time, nearest.held))
}

/// The frame nearest to a time of the log (s), and its time.
///
/// # Errors
/// A log that cannot be read or has no samples.
pub fn nearest_frame(log: &Path, time: f64) -> anyhow::Result<(Frame, f64)> {
    nearest(log, time, false).map(|(frame, time, _)| (frame, time))
}

/// Positions and velocities of joints as reports give them, by name.
pub fn coordinates_of<'f>(model: &Model, frame: &'f Frame) -> HashMap<&'f str, (Vec<f64>, Vec<f64>)> {
    let mut joints: HashMap<&str, (Vec<f64>, Vec<f64>)> = HashMap::new();
    let scalar = &frame.joints;
    for ((name, &position), &velocity) in scalar.names.iter().zip(&scalar.positions).zip(&scalar.velocities) {
        joints.insert(name, (vec![position], vec![velocity]));
    }
    let others = &frame.multi_dof;
    for ((name, transform), twist) in others.names.iter().zip(&others.transforms).zip(&others.twists) {
        if let Some(coordinates) = model.coordinates_of_transform(name, transform, twist) {
            joints.insert(name, coordinates);
        }
    }
    joints
}

/// The state of a model in a frame, at a time (s).
///
/// # Errors
/// A frame without the joints of the model.
pub fn state_of(log: &Path, model: &Model, frame: &Frame, time: f64) -> anyhow::Result<State> {
    let joints = coordinates_of(model, frame);
    let coordinates = |name: &str| joints.get(name).map(|(q, w)| (q.as_slice(), w.as_slice()));
    model.state_of_report(time, coordinates).ok_or_else(|| {
        let why = if frame.has_joints() { "its samples are not of the model it carries" } else { BARE };
        anyhow!("{}: {why}", log.display())
    })
}

/// The state in which a run of a model goes on from the sample of a log that is nearest to a time (s); without a time from its end.
///
/// # Errors
/// As those of `--from`.
pub fn state_in_log(log: &Path, time: Option<f64>, model: &Model) -> anyhow::Result<State> {
    let time = time.unwrap_or(f64::INFINITY);
    if time.is_nan() {
        return Err(anyhow!("the time in {} is no number: give seconds after the start of its run", log.display()));
    }
    start_of(&LogInstant { log: log.into(), time }, model).map(|start| start.state)
}

/// Where a run goes on from a log.
pub struct LoggedStart {
    pub state: State,
    /// The efforts of motors there, by the names of their joints; empty for a log without motors.
    pub motors: HashMap<String, f64>,
    /// The targets of the motors that hold their joints at the start of the run.
    pub held: HeldTargets,
    /// Whether the log has a sample right at the instant that is asked for.
    pub is_there: bool,
}

/// The start of a run of a model that goes on from an instant of a log.
///
/// # Errors
/// A log that cannot be read, and one without a joint that moves in the model.
pub fn start_of(from: &LogInstant, model: &Model) -> anyhow::Result<LoggedStart> {
    let (frame, time, held) = nearest(&from.log, from.time, true)?;
    let joints = coordinates_of(model, &frame);
    if let Some(missing) = model.moving_joints().find(|name| !joints.contains_key(name)) {
        let why = if frame.has_joints() { "it is a log of another model" } else { BARE };
        return Err(anyhow!("{}: it has no joint {missing:?}: {why}", from.log.display()));
    }
    let state = state_of(&from.log, model, &frame, time)?;
    let motors = frame.motors.names.into_iter().zip(frame.motors.efforts).collect();
    // Times of a log are whole nanoseconds.
    Ok(LoggedStart { state, motors, held, is_there: from.time.is_infinite() || (time - from.time).abs() <= 1e-9 })
}
