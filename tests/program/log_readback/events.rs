//! Logs of motions that are not smooth: events, efforts of motors and what friction and impacts took, as they happened.

use super::messages::Cdr;
use super::{Coasting, VELOCITY, arm, messages, of_topic};
use crate::common::command::{run as catena, text};
use crate::common::scratch;
use catena::mechanism::description::closure::{Coordinate, JointLimit};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::nonsmooth::{Motor, MotorLaw, Nonsmooth, SpeedLimit};
use catena::mechanism::description::target::Target;
use catena::mechanism::motion::event::{Event, EventKind};
use catena::mechanism::motion::inputs::Inputs;
use catena::mechanism::motion::integrator::{Integrator, MethodDescription, StepError, StepOutcome};
use catena::mechanism::motion::state::State;
use catena::model::Model;
use catena::output::log::reading::decode;
use catena::output::log::{Compared, Difference, Ending, LogOptions, Recorder};
use catena::output::report::SpeedWatch;
use catena::simulation::{Observer, RunOptions, run};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const STEP: f64 = 0.05;
/// What each step loses to friction and in impacts (J).
const FRICTION: f64 = 0.25;
const IMPACTS: f64 = 0.125;
/// Gain, target and period of the motors.
const GAIN: f64 = 4.0;
const TARGET: f64 = 0.5;
const PERIOD: f64 = 0.1;

fn coordinate(index: usize) -> Coordinate {
    Coordinate { body: index, position: index, freedom: index }
}

/// The arm with a sampled motor in its turning joint, a continuous one in its sliding one, a limit, and a speed that it exceeds.
fn driven_arm() -> Model {
    let mut model = arm();
    let motor = |index, period| Motor {
        coordinate: coordinate(index),
        law: MotorLaw::Position { kp: GAIN, kd: 0.0 },
        target: Target::constant(TARGET),
        max_effort: f64::INFINITY,
        period,
        held: None,
    };
    let speed = |index, speed| SpeedLimit { coordinate: coordinate(index), speed };
    model.mechanism.nonsmooth = Nonsmooth {
        limits: vec![JointLimit { coordinate: coordinate(0), lower: -1.0, upper: 1.0, restitution: 0.5 }],
        motors: vec![motor(0, PERIOD), motor(1, 0.0)],
        speeds: vec![speed(0, 1.0), speed(1, 0.5)],
        ..Nonsmooth::default()
    };
    model
}

/// What happens just before the end of the step with this number; an event a little more than a nanosecond's rounding can tell.
fn event(step: usize) -> Option<Event> {
    let time = step as f64 * STEP - 3e-11;
    match step {
        3 => Some(Event { time, kind: EventKind::LimitImpact, body: 0, pair: None, impulse: Some(-2.5) }),
        // At a sample.
        6 => Some(Event { time: 0.3, kind: EventKind::Stick, body: 1, pair: None, impulse: None }),
        7 => Some(Event { time, kind: EventKind::LimitImpact, body: 0, pair: None, impulse: Some(1e-3) }),
        _ => None,
    }
}

/// A motion at constant rates to which events happen.
struct Bumping {
    coasting: Coasting,
    steps: usize,
    /// How much later its events are (s).
    late: f64,
}

impl Bumping {
    fn new(late: f64) -> Self {
        Bumping { coasting: Coasting { step: STEP }, steps: 0, late }
    }
}

impl Integrator for Bumping {
    fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        let mut outcome = self.coasting.step(mechanism, inputs, state, until)?;
        self.steps += 1;
        (outcome.exchange.friction, outcome.exchange.impacts) = (FRICTION, IMPACTS);
        Ok(outcome)
    }

    fn dense(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        self.coasting.dense(mechanism, time, position, velocity);
    }

    fn description(&self) -> MethodDescription {
        self.coasting.description()
    }

    fn take_events(&mut self, events: &mut Vec<Event>) {
        events.extend(event(self.steps).map(|event| Event { time: event.time + self.late, ..event }));
    }
}

/// Ten steps and a shorter one, seen by these observers.
fn bump(model: &Model, bumping: &mut Bumping, observers: &mut [&mut dyn Observer]) {
    let mut state = model.zero_state();
    state.velocity.copy_from_slice(&VELOCITY);
    let options = RunOptions { duration: 0.52, rate: Some(60.0), interrupt: None };
    // An observer may break it off, and says so itself.
    let _ = run(&model.mechanism, &mut state, bumping, &options, observers);
}

/// A log of ten steps and a shorter one, with samples that do not fit them; somebody else watches, too.
fn log(folder: &Path, model: &Model, watch: &mut dyn Observer) -> PathBuf {
    let path = folder.join("driven.mcap");
    let simulation = [("robot", "arm"), ("arguments", r#"["simulate", "arm.urdf"]"#)];
    let simulation: BTreeMap<String, String> =
        simulation.into_iter().map(|(name, said)| (name.to_string(), said.to_string())).collect();
    let mut recorder = Recorder::create(&path, model, simulation, &LogOptions::default()).expect("the log is created");
    bump(model, &mut Bumping::new(0.0), &mut [&mut recorder, watch]);
    recorder.finish(Ending::default()).expect("the log is completed");
    path
}

fn watched_log(folder: &Path) -> (PathBuf, Vec<String>) {
    let model = driven_arm();
    let mut watch = SpeedWatch::new(&model).expect("speeds are given");
    let path = log(folder, &model, &mut watch);
    (path, watch.warning().into_iter().collect())
}

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(watched_log(&scratch(name)).0).expect("a log")
}

#[test]
fn events_are_logged_when_they_happen_with_their_joint_and_impulse() {
    let bytes = bytes("events_logged");
    let messages = messages(&bytes);
    let events = of_topic(&messages, "/events");
    let names = ["turn", "slide"];
    let expected: Vec<Event> = (0..10).filter_map(event).collect();
    assert_eq!((events.len(), expected.len()), (3, 3));
    for (message, expected) in events.iter().zip(expected) {
        let stamp = (expected.time * 1e9).round() as u64;
        assert_eq!(message.log_time, stamp);
        let mut cdr = Cdr::new(message);
        assert_eq!(u64::from(cdr.unsigned()) * 1_000_000_000 + u64::from(cdr.unsigned()), stamp);
        assert_eq!(cdr.string(), "");
        assert_eq!(f64::from_le_bytes(cdr.take()), expected.time, "to the last digit");
        assert_eq!((cdr.string().as_str(), cdr.string().as_str()), (expected.kind.name(), names[expected.body]));
        let impulse = f64::from_le_bytes(cdr.take());
        assert!(expected.impulse.map_or(impulse.is_nan(), |expected| impulse == expected), "{impulse}");
        cdr.assert_ended();
    }
    let times: Vec<u64> = messages.iter().map(|message| message.log_time).collect();
    assert!(times.is_sorted(), "{times:?}");
}

#[test]
fn motors_are_logged_at_every_sample_and_sampled_ones_with_the_effort_of_their_last_tick() {
    let bytes = bytes("motors_logged");
    let messages = messages(&bytes);
    let motors = of_topic(&messages, "/motors");
    assert_eq!(motors.len(), of_topic(&messages, "/tf").len());
    for message in motors {
        let time = message.log_time as f64 * 1e-9;
        let mut cdr = Cdr::new(message);
        let _stamp = (cdr.unsigned(), cdr.unsigned());
        assert_eq!((cdr.string(), cdr.strings()), (String::new(), vec!["turn".to_string(), "slide".to_string()]));
        assert_eq!((cdr.doubles(), cdr.doubles()), (Vec::new(), Vec::new()), "no positions and velocities");
        let efforts = cdr.doubles();
        cdr.assert_ended();
        let tick = (time / PERIOD + 1e-7).floor() * PERIOD;
        let expected = [tick, time].into_iter().zip(VELOCITY).map(|(time, rate)| GAIN * (TARGET - rate * time));
        for (effort, expected) in efforts.into_iter().zip(expected) {
            // The times of log and samples differ by half a nanosecond.
            assert!((effort - expected).abs() < 1e-8, "{effort} and not {expected} at {time} s");
        }
    }
}

#[test]
fn the_energy_topic_has_what_friction_and_impacts_took() {
    let bytes = bytes("energy_logged");
    let messages = messages(&bytes);
    let step = (STEP * 1e9) as u64;
    let energies = of_topic(&messages, "/energy");
    for message in &energies {
        // The end of a step, or a nanosecond before it where it has an event.
        let (ended, is_before) = (message.log_time.div_ceil(step), (message.log_time + 1).is_multiple_of(step));
        let mut cdr = Cdr::new(message);
        let _header = (cdr.unsigned(), cdr.unsigned(), cdr.string());
        // Dissipated, work put in, lost to friction, lost in impacts.
        let before_impacts = if is_before { 1.0 } else { 0.0 };
        let lost = [0.0, 0.0, ended as f64 * FRICTION, (ended as f64 - before_impacts) * IMPACTS];
        assert_eq!(cdr.numbers::<7>()[3..], lost, "{} ns", message.log_time);
        cdr.assert_ended();
    }
    let before = energies.iter().filter(|message| (message.log_time + 1).is_multiple_of(step));
    // Of three steps with events one ends at a sample, after which there is no nanosecond left.
    assert_eq!(before.count(), 2);
}

#[test]
fn a_motion_without_losses_between_impacts_has_one_energy_from_each_impact_to_the_next_in_its_log() {
    let folder = scratch("between_impacts");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/bouncing_pendulum.toml");
    let scene = scene.to_str().expect("a path in Unicode");
    let run =
        catena(&folder, &["simulate", scene, "--quiet", "--duration", "2.5", "--rate", "7", "--output", "log.mcap"]);
    assert_eq!(run.status.code(), Some(0), "{}", text(&run.stderr));
    let bytes = std::fs::read(folder.join("log.mcap")).expect("a log");
    let messages = messages(&bytes);
    let energies: Vec<(u64, f64, f64)> = (of_topic(&messages, "/energy").into_iter())
        .map(|message| {
            let mut cdr = Cdr::new(message);
            let _header = (cdr.unsigned(), cdr.unsigned(), cdr.string());
            let [_, _, total, _, _, _, impacts] = cdr.numbers::<7>();
            (message.log_time, total, impacts)
        })
        .collect();
    let mut jumps = 0;
    for two in energies.windows(2) {
        let [(from, before, lost), (to, after, more)] = [two[0], two[1]];
        let jumps_here = to == from + 1;
        jumps += usize::from(jumps_here);
        // The balance of the run is kept to 1e-9 of some joules; the impacts of this pendulum until 2.5 s take more than 1e-3 J.
        assert_eq!((after - before).abs() > 1e-8, jumps_here, "{from} to {to} ns: {before} and {after} J");
        assert!((after - before + more - lost).abs() < 1e-8, "{from} to {to} ns: {before} and {after} J");
    }
    assert_eq!(jumps, of_topic(&messages, "/events").len());
    assert!(jumps >= 3, "{jumps} impacts");
}

#[test]
fn a_smooth_mechanism_has_a_log_without_events_and_motors() {
    let bytes = super::log("smooth.mcap", 0.2);
    let summary = mcap::Summary::read(&bytes).expect("a complete log").expect("with a summary");
    let topics: Vec<&str> = summary.channels.values().map(|channel| channel.topic.as_str()).collect();
    assert!(!topics.contains(&"/events") && !topics.contains(&"/motors"), "{topics:?}");
}

#[test]
fn joints_that_were_faster_than_their_largest_speed_are_named_with_both() {
    let (_, warnings) = watched_log(&scratch("speeds"));
    // The slide moves at its largest speed, which is not beyond it.
    let expected = "joint \"turn\" moves at up to 1.25 rad/s, its <limit velocity> is 1: it is watched, not enforced";
    assert_eq!(warnings, [expected]);
    assert!(SpeedWatch::new(&arm()).is_none(), "nothing to watch");
}

#[test]
fn inspect_lists_and_counts_the_events_of_a_log() {
    let folder = scratch("inspect_events");
    watched_log(&folder);
    let of = |arguments: &[&str]| {
        let output = catena(&folder, &[&["inspect", "driven.mcap"], arguments].concat());
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
        text(&output.stdout).to_string()
    };
    let json = |arguments: &[&str]| serde_json::from_str::<Value>(&of(arguments)).expect("one JSON object");
    let listed = json(&["--events", "--json"]);
    assert_eq!((&listed["counts"]["limit_impact"], &listed["counts"]["stick"]), (&2.into(), &1.into()));
    assert_eq!(listed["counts"]["contact_impact"], 0);
    let list = listed["list"].as_array().expect("a list");
    assert_eq!(list.len(), 3);
    assert_eq!(list[0]["time"], event(3).expect("an event").time);
    assert_eq!(list[0]["kind"], "limit_impact");
    assert_eq!((&list[0]["what"], &list[0]["impulse"]), (&"turn".into(), &(-2.5).into()));
    assert_eq!((&list[1]["what"], list[1].get("impulse")), (&"slide".into(), None));
    let table = of(&["--events"]);
    assert!(table.starts_with("driven.mcap: events: 2 limit impacts, 1 stick\n"), "{table}");
    assert!(table.lines().any(|line| line.contains("limit_impact  turn") && line.ends_with("-2.500000e0")), "{table}");
    assert_eq!(table.lines().count(), 5, "{table}");
    let summary = json(&["--json"]);
    assert_eq!(summary["events"]["counts"], listed["counts"]);
    assert_eq!((&summary["energy"]["friction"], &summary["energy"]["impacts"]), (&2.75.into(), &1.375.into()));
    assert!(of(&[]).contains("  events      3: 2 limit impacts, 1 stick\n"), "{}", of(&[]));
    let instant = json(&["--at", "0.25", "--json"]);
    assert_eq!(instant["time"], 0.25);
    // The last tick is at 0.2 s.
    let effort = instant["motors"]["turn"].as_f64().expect("an effort");
    assert!((effort - GAIN * (TARGET - 0.2 * VELOCITY[0])).abs() < 1e-8, "{effort}");
    assert!(of(&["--at", "0.25"]).contains("  motors: effort [N m, N]\n"));
    of(&["--csv", "driven.csv", "--plot", "driven.svg", "--recover", "whole.mcap"]);
    let head = std::fs::read_to_string(folder.join("driven.csv")).expect("a table");
    for column in ["turn.motor_effort [N m]", "slide.motor_effort [N]", "energy.friction [J]", "energy.impacts [J]"] {
        assert!(head.lines().next().is_some_and(|head| head.contains(column)), "{column}");
    }
    let svg = std::fs::read_to_string(folder.join("driven.svg")).expect("a picture");
    assert!(svg.contains("ticks: 3 events") && svg.contains("Motor efforts, turning"));
    let recovered = catena(&folder, &["inspect", "whole.mcap", "--events"]);
    assert!(text(&recovered.stdout).contains("2 limit impacts, 1 stick"), "{}", text(&recovered.stdout));
    let both = catena(&folder, &["inspect", "driven.mcap", "--events", "--at", "0.1"]);
    assert_eq!(both.status.code(), Some(2));
}

#[test]
fn a_run_whose_events_are_a_rounding_later_is_not_the_run_of_the_log() {
    let (path, _) = watched_log(&scratch("events_compared"));
    let model = driven_arm();
    let compare = |late: f64| -> (Compared, Result<(), Difference>) {
        let mut recorder = Recorder::compare(&path, &model, f64::NAN, &LogOptions::default()).expect("a thread");
        bump(&model, &mut Bumping::new(late), &mut [&mut recorder]);
        recorder.compared()
    };
    let (compared, same) = compare(0.0);
    assert_eq!(same, Ok(()));
    assert!(compared.messages > 33 * 4, "{compared:?}");
    let differs = compare(1e-15).1.expect_err("it differs").to_string();
    assert!(differs.starts_with("/events differs at t = 0.15 s"), "{differs}");
}

#[test]
fn an_event_that_was_cut_anywhere_is_an_error() {
    let bytes = bytes("events_cut");
    let messages = messages(&bytes);
    let data = &of_topic(&messages, "/events")[0].data;
    let whole = decode::event(data).expect("an event");
    assert_eq!((whole.kind.as_str(), whole.what.as_str(), whole.impulse), ("limit_impact", "turn", Some(-2.5)));
    assert!((0..data.len()).all(|length| decode::event(&data[..length]).is_err()));
}

#[test]
fn a_log_has_every_event_of_the_report_and_says_when_it_was() {
    let input = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/repro/events/limits216.toml");
    if !input.is_file() {
        println!("skipped: there is no ../shared/repro/events");
        return;
    }
    let folder = scratch("events");
    let input = input.to_str().expect("a path in Unicode");
    // Two trees that nothing connects, with thousands of impacts; some limits are met without speed.
    let run = catena(&folder, &["simulate", input, "--json", "--quiet", "--output", "all.mcap"]);
    assert_eq!(run.status.code(), Some(0), "{}", text(&run.stderr));
    let report: Value = serde_json::from_slice(&run.stdout).expect("a report");
    let log: Value = serde_json::from_slice(&catena(&folder, &["inspect", "all.mcap", "--events", "--json"]).stdout)
        .expect("the events of the log");
    assert!(report["events"]["counts"]["limit_impact"].as_u64() > Some(1000), "{}", report["events"]["counts"]);
    assert_eq!(report["events"]["counts"], log["counts"]);
    let times = log["list"].as_array().expect("a list").iter().map(|event| event["time"].as_f64());
    let times: Option<Vec<f64>> = times.collect();
    let times = times.expect("every event has a time");
    assert!(times.iter().all(|time| (0.0..=0.664).contains(time)));
}
