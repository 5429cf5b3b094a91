//! `catena inspect`: looks at a log, at one instant of it, at its curves, or at two logs side by side.
//!
//! Everything is read from the log. The velocities of links, which samples do not hold, are computed with the model that the log carries. If a log
//! was cut off or damaged, its readable part is shown, with a warning on standard error.

use crate::cli::inspect_files::{check_absent, check_ending, check_outputs, draw, kinds, recover_into, write_csv};
use crate::cli::inspect_follow::follow;
use crate::cli::logged_state::{coordinates_of, nearest_frame, state_of};
use crate::cli::recorded::Recorded;
use crate::cli::terminal::printing::{Failure, print, print_json, warn};
use anyhow::anyhow;
use catena::instant::holding::statuses::joint_statuses;
use catena::mechanism::ground::words::decimals;
use catena::output::inspection::compare::compare;
use catena::output::inspection::curves::curves;
use catena::output::inspection::events::LoggedEvents;
use catena::output::inspection::summary::Summary;
use catena::output::log::reading::decode::LoggedContact;
use catena::output::log::reading::frames::Frame;
use catena::output::log::seconds;
use catena::output::report::{JointReport, LinkReport, LoopReport, Numbers, as_object, carried_reports, link_reports};
use clap::Args;
use serde::Serialize;
use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The options of `catena inspect`.
#[derive(Args, Debug)]
pub struct InspectArgs {
    /// The log
    #[arg(value_name = "LOG.mcap")]
    log: PathBuf,

    /// Another log to compare with, link by link
    #[arg(value_name = "LOG.mcap", conflicts_with_all = ["at", "events", "csv", "plot", "recover", "follow"])]
    other: Option<PathBuf>,

    /// Show the links and joints at the logged instant nearest to T [s]
    #[arg(long, value_name = "T", allow_hyphen_values = true, value_parser = crate::cli::arguments::numbers::finite)]
    at: Option<f64>,

    /// Show the events: impacts on limits and of contacts, sticking and slipping, motors at their bounds
    #[arg(long, conflicts_with = "at")]
    events: bool,

    /// Write all samples as a table of comma-separated values
    #[arg(long, value_name = "FILE.csv", value_parser = crate::cli::arguments::outputs::output_file())]
    csv: Option<PathBuf>,

    /// Draw positions, velocities, energy error, constraint error, reactions and contact forces
    #[arg(long, value_name = "FILE.svg|FILE.png", value_parser = crate::cli::arguments::outputs::output_file())]
    plot: Option<PathBuf>,

    /// Draw those curves only that have one of these words in their titles or names, as `position,elbow` [default: all]
    #[arg(long, value_name = "WORD,…", value_delimiter = ',', requires = "plot")]
    curves: Vec<String>,

    /// Write all that can be read as a new, complete log, for viewers that need the index that a killed run did not write
    #[arg(long, value_name = "FILE.mcap", value_parser = crate::cli::arguments::outputs::output_file())]
    recover: Option<PathBuf>,

    /// Follow a log while a run writes it, with a line whenever there is something new
    #[arg(long, conflicts_with_all = ["at", "events", "csv", "plot", "recover"])]
    follow: bool,

    /// Print JSON: one object, with --follow one a line
    #[arg(long)]
    json: bool,
}

/// Does what the arguments say.
///
/// # Errors
/// [`Failure`]: 2 if a log cannot be read, 1 if a file cannot be written.
pub fn run(arguments: &InspectArgs) -> Result<(), Failure> {
    let log = &arguments.log;
    if let Some(other) = &arguments.other {
        let comparison = compare(log, other).map_err(Failure::input)?;
        return if arguments.json { print_json(&comparison) } else { print(comparison) };
    }
    if arguments.follow {
        return follow(log, arguments.json);
    }
    let files = [&arguments.csv, &arguments.plot, &arguments.recover];
    let shows_more = arguments.at.is_some() || arguments.events || files.iter().any(|file| file.is_some());
    if let Some(plot) = &arguments.plot {
        check_ending(plot).map_err(Failure::input)?;
    }
    if let Some(whole) = &arguments.recover {
        check_absent(whole).map_err(Failure::input)?;
    }
    check_outputs(log, &files.into_iter().flatten().map(PathBuf::as_path).collect::<Vec<_>>())
        .map_err(Failure::input)?;
    let summary = Summary::read(log).map_err(Failure::input)?;
    if shows_more && !summary.complete {
        warn(format_args!("{}: {}", log.display(), summary.state()));
    }
    if summary.samples == 0 && (arguments.at.is_some() || arguments.csv.is_some()) {
        return Err(Failure::input(anyhow!("{}: there are no samples in it", log.display())));
    }
    let figure = match &arguments.plot {
        Some(_) => Some(curves(log, &kinds(log), &arguments.curves).map_err(Failure::input)?),
        None => None,
    };
    if figure.as_ref().is_some_and(|figure| figure.pictures.is_empty()) {
        return Err(Failure::input(anyhow!("{}: the log has nothing that could be drawn", log.display())));
    }
    if let Some(time) = arguments.at {
        show_instant(log, &summary, time, arguments.json)?;
    }
    if arguments.events {
        let events = LoggedEvents::read(log).map_err(Failure::input)?;
        if arguments.json { print_json(&events) } else { print(&events) }?;
    }
    if let Some(table) = &arguments.csv {
        write_csv(log, table).map_err(Failure::run)?;
    }
    if let (Some(figure), Some(plot)) = (&figure, &arguments.plot) {
        draw(figure, plot).map_err(Failure::run)?;
    }
    if let Some(whole) = &arguments.recover {
        let said = recover_into(log, whole, &summary)?;
        if !arguments.json {
            print(said)?;
        }
    }
    // The output with --json is one object, whatever files are written.
    match (shows_more, arguments.json) {
        (true, false) => Ok(()),
        (true, true) if arguments.at.is_some() || arguments.events => Ok(()),
        (_, true) => print_json(&summary),
        (false, false) => print(&summary),
    }
}

/// One instant of a log, as the report of a run shows its end.
#[derive(Serialize)]
struct LoggedInstant {
    log: String,
    time: f64,
    #[serde(serialize_with = "as_object")]
    links: Vec<(String, LinkReport)>,
    #[serde(serialize_with = "as_object")]
    joints: Vec<(String, JointReport)>,
    #[serde(serialize_with = "as_object", skip_serializing_if = "Vec::is_empty")]
    loops: Vec<(String, LoopReport)>,
    /// The efforts of the motors [N m or N].
    #[serde(serialize_with = "as_object", skip_serializing_if = "Vec::is_empty")]
    motors: Vec<(String, f64)>,
    /// The closed contacts.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    contacts: Vec<LoggedContact>,
    /// At the end of the last step up to there.
    constraint: Option<Violation>,
}

/// The largest violation of all constraints, as the log has it.
#[derive(Serialize)]
struct Violation {
    /// End of the step (s).
    time: f64,
    /// The error of positions (m, rad).
    position: f64,
    /// The error of velocities [m/s, rad/s].
    velocity: f64,
}

/// Says that a time is before or beyond all samples (s): those from `first` to `last`, of which `found` is the nearest.
fn outside([first, last]: [f64; 2], time: f64, found: f64) -> Option<String> {
    // Times of a log are whole nanoseconds.
    if (time - found).abs() <= 1e-9 {
        return None;
    }
    if time > last {
        return Some(format!("t = {time} s is beyond its end; its last sample is at t = {found} s"));
    }
    (time < first).then(|| format!("t = {time} s is before its first sample, at t = {found} s"))
}

fn show_instant(log: &Path, summary: &Summary, time: f64, json: bool) -> Result<(), Failure> {
    let (frame, found) = nearest_frame(log, time).map_err(Failure::input)?;
    let (_, first) = nearest_frame(log, f64::MIN).map_err(Failure::input)?;
    if let Some(said) = outside([first, summary.duration], time, found) {
        warn(format_args!("{}: {said}", log.display()));
    }
    let recorded = Recorded::open(log).map_err(Failure::input)?;
    let instant = instant(log, &frame, &recorded).map_err(Failure::input)?;
    if json { print_json(&instant) } else { print(words(&instant)) }
}

/// Poses, joint coordinates and reactions as they are in the log; the rest follows from them.
fn instant(log: &Path, frame: &Frame, recorded: &Recorded) -> anyhow::Result<LoggedInstant> {
    let model = &recorded.loaded.model;
    let joints = coordinates_of(model, frame);
    let state = state_of(log, model, frame, frame.time())?;
    let mut links = link_reports(model, &state);
    let poses: HashMap<&str, _> = frame.links.iter().map(|pose| (pose.link.as_str(), pose)).collect();
    for (name, link) in &mut links {
        if let Some(pose) = poses.get(name.as_str()) {
            (link.position, link.orientation) = (pose.position, pose.orientation);
        }
    }
    let mechanism = &model.mechanism;
    let logged: HashMap<&str, f64> =
        frame.motors.names.iter().map(String::as_str).zip(frame.motors.efforts.iter().copied()).collect();
    let efforts = mechanism.nonsmooth.motors.iter().map(|motor| {
        let record = model.joints.iter().find(|record| record.body == Some(motor.coordinate.body))?;
        logged.get(record.name.as_str()).copied()
    });
    let efforts: Vec<Option<f64>> = efforts.collect();
    let statuses = joint_statuses(mechanism, &state, &efforts);
    let (mut reports, mut loops) = carried_reports(model, &state, &statuses);
    let reactions: HashMap<&str, _> =
        frame.reactions.names.iter().map(String::as_str).zip(&frame.reactions.wrenches).collect();
    for (name, joint) in &mut reports {
        if let Some((position, velocity)) = joints.get(name.as_str()) {
            (joint.position, joint.velocity) = (position.clone().into(), velocity.clone().into());
        }
        if let Some((force, torque)) = reactions.get(name.as_str()) {
            (joint.reaction_force, joint.reaction_torque) = (*force, *torque);
        }
    }
    // The gaps follow from the joints' coordinates, as in the report.
    for (name, closing) in &mut loops {
        if let Some((force, torque)) = reactions.get(name.as_str()) {
            (closing.reaction_force, closing.reaction_torque) = (*force, *torque);
        }
    }
    let figures = &frame.figures;
    let constraint = figures.violation.map(|[position, velocity]| Violation {
        time: seconds(figures.nanoseconds),
        position,
        velocity,
    });
    let motors = frame.motors.names.iter().cloned().zip(frame.motors.efforts.iter().copied()).collect();
    let log = log.display().to_string();
    Ok(LoggedInstant {
        log,
        time: frame.time(),
        links,
        joints: reports,
        loops,
        motors,
        contacts: frame.contacts.clone(),
        constraint,
    })
}

/// The instant for people.
fn words(instant: &LoggedInstant) -> String {
    let listed = |numbers: &[f64]| {
        numbers.iter().map(|number| format!("{:>11}", decimals(*number))).collect::<Vec<_>>().join(" ")
    };
    let mut text = format!("{}: t = {} s\n", instant.log, instant.time);
    let names = instant.links.iter().map(|link| &link.0).chain(instant.joints.iter().map(|joint| &joint.0));
    let names = names.chain(instant.loops.iter().map(|closing| &closing.0));
    let width = names.map(|name| name.chars().count()).max().unwrap_or(0);
    // Writing into a string does not fail.
    let _ = writeln!(text, "  links: position [m], orientation (w, x, y, z)");
    for (name, link) in &instant.links {
        let _ = writeln!(text, "    {name:width$}  {}   {}", listed(&link.position), listed(&link.orientation));
    }
    let _ = writeln!(text, "  joints: position, velocity; reaction force [N], torque [N m] in the world");
    for (name, joint) in &instant.joints {
        let numbers = |numbers: &Numbers| match numbers {
            Numbers::One(number) => listed(&[*number]),
            Numbers::Many(numbers) => listed(numbers),
        };
        let (position, velocity) = (numbers(&joint.position), numbers(&joint.velocity));
        let (force, torque) = (listed(&joint.reaction_force), listed(&joint.reaction_torque));
        let _ = writeln!(text, "    {name:width$}  {position}, {velocity}; {force}, {torque}");
    }
    if !instant.loops.is_empty() {
        let _ = writeln!(text, "  loops: gap [m, sine of an angle]; reaction force [N], torque [N m] in the world");
    }
    for (name, LoopReport { gap, reaction_force, reaction_torque }) in &instant.loops {
        let (force, torque) = (listed(reaction_force), listed(reaction_torque));
        let _ = writeln!(text, "    {name:width$}  {gap:>11.1e}; {force}, {torque}");
    }
    if !instant.motors.is_empty() {
        let _ = writeln!(text, "  motors: effort [N m, N]");
    }
    for (name, effort) in &instant.motors {
        let _ = writeln!(text, "    {name:width$}  {}", listed(&[*effort]));
    }
    if !instant.contacts.is_empty() {
        let _ = writeln!(text, "  contacts: position [m]; force [N] on the first, in the world; gap [m]");
    }
    for LoggedContact { a, b, position, force, gap, state, .. } in &instant.contacts {
        let (position, force) = (listed(position), listed(force));
        let _ = writeln!(text, "    {:width$}  {position}; {force}; {gap:>11.1e}, {state}", format!("{a}|{b}"));
    }
    if let Some(Violation { time, position, velocity }) = &instant.constraint {
        let _ = writeln!(
            text,
            "  constraint error at the end of the last step, t = {time} s: {position:.1e} m, {velocity:.1e} m/s"
        );
    }
    text
}
