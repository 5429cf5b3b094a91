//! Logs of what touches: contacts at every sample, their arrows, and events that name a pair.

use super::messages::Marker;
use super::{Coasting, VELOCITY, arm, messages, of_topic};
use crate::common::scratch;
use catena::mechanism::description::contact::{Collider, ContactPair, Shape};
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::contact_point::{ContactFigures, ContactPoint};
use catena::mechanism::motion::event::{Event, EventKind};
use catena::mechanism::motion::inputs::Inputs;
use catena::mechanism::motion::integrator::{Integrator, MethodDescription, StepError, StepOutcome};
use catena::mechanism::motion::state::State;
use catena::model::Model;
use catena::output::inspection::joint_values::JointKinds;
use catena::output::inspection::table::write_table;
use catena::output::log::reading::decode;
use catena::output::log::reading::decode::LoggedContact;
use catena::output::log::reading::frames::{Frame, Visitor, visit};
use catena::output::log::{Ending, LogOptions, Recorder};
use catena::simulation::{RunOptions, Summary, run};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

const STEP: f64 = 0.05;

/// The arm, whose slider may touch a floor and a wall.
fn touching_arm() -> Model {
    let mut model = arm();
    let collider = |name: &str, body| Collider::still(name, body, Pose::identity(), Shape::HalfSpace);
    let pair = |number, b| ContactPair::without_moments(number, [0, b], 0.5, 0.0);
    model.mechanism.nonsmooth.colliders =
        vec![collider("slider", Some(1)), collider("floor", None), collider("wall", None)];
    model.mechanism.nonsmooth.pairs = vec![pair(0, 1), pair(1, 2)].into();
    model
}

/// Touches the wall from 0.1 s on, and the floor as well from 0.2 s on; the force on the wall's contact is outside its cone by what the slide has moved.
struct Touching {
    coasting: Coasting,
    time: f64,
}

fn contacts(state: &State) -> Vec<ContactPoint> {
    let wall = ContactPoint {
        pair: 1,
        position: Vector3::new(1.0, 2.0, 3.0),
        normal: Vector3::x(),
        force: Vector3::new(10.0, 3.0, 4.0 + state.position[1].abs()),
        gap: -1e-3 * state.time,
        sticks: false,
    };
    let floor = ContactPoint { pair: 0, normal: Vector3::z(), force: Vector3::z(), sticks: true, gap: 0.0, ..wall };
    let from = |time: f64, point: ContactPoint| (state.time >= time).then_some(point);
    from(0.2, floor).into_iter().chain(from(0.1, wall)).collect()
}

impl Integrator for Touching {
    fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        let outcome = self.coasting.step(mechanism, inputs, state, until)?;
        self.time = state.time;
        Ok(outcome)
    }

    fn dense(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        self.coasting.dense(mechanism, time, position, velocity);
    }

    fn description(&self) -> MethodDescription {
        self.coasting.description()
    }

    fn take_events(&mut self, events: &mut Vec<Event>) {
        let (kind, time) = (EventKind::ContactImpact, self.time);
        events.push(Event { time, kind, body: 1, pair: Some(1), impulse: Some(2.5) });
    }

    fn contacts(&self, _: &Mechanism, state: &State, out: &mut Vec<ContactPoint>) {
        out.extend(contacts(state));
    }
}

/// A log of half a second with 60 samples a second.
fn log(name: &str) -> (PathBuf, Summary) {
    let path = scratch(name).join("touching.mcap");
    let model = touching_arm();
    let simulation = BTreeMap::from([("robot".to_string(), "arm".to_string())]);
    let mut recorder = Recorder::create(&path, &model, simulation, &LogOptions::default()).expect("the log is created");
    let mut state = model.zero_state();
    state.velocity.copy_from_slice(&VELOCITY);
    let options = RunOptions { duration: 0.5, rate: Some(60.0), interrupt: None };
    let mut integrator = Touching { coasting: Coasting { step: STEP }, time: 0.0 };
    let (summary, ended) = run(&model.mechanism, &mut state, &mut integrator, &options, &mut [&mut recorder]);
    ended.expect("nothing can fail");
    recorder.finish(Ending::default()).expect("the log is completed");
    (path, summary)
}

/// Collects the contacts of frames.
#[derive(Default)]
struct Frames(Vec<(f64, Vec<LoggedContact>)>);

impl Visitor for Frames {
    fn frame(&mut self, frame: &Frame) -> ControlFlow<()> {
        self.0.push((frame.time(), frame.contacts.clone()));
        ControlFlow::Continue(())
    }
}

fn frames(path: &Path) -> Vec<(f64, Vec<LoggedContact>)> {
    let mut frames = Frames::default();
    visit(path, &mut frames).expect("a log");
    frames.0
}

#[test]
fn every_sample_has_the_contacts_of_its_own_instant() {
    let (path, _) = log("contacts_logged");
    let frames = frames(&path);
    assert_eq!(frames.len(), 31);
    for (sample, (_, logged)) in frames.iter().enumerate().skip(1) {
        let time = sample as f64 / 60.0;
        let mut state = touching_arm().zero_state();
        state.time = time;
        state.position[1] = VELOCITY[1] * time;
        let expected = contacts(&state);
        assert_eq!(logged.len(), expected.len(), "at {time} s");
        for (logged, expected) in logged.iter().zip(expected) {
            let b = ["floor", "wall"][expected.pair];
            assert_eq!((logged.a.as_str(), logged.b.as_str()), ("slider", b));
            assert_eq!(Vector3::from(logged.position), expected.position);
            assert_eq!(Vector3::from(logged.normal), expected.normal);
            // At ends of steps the positions are sums of increments, with some roundings of half a metre.
            assert!((Vector3::from(logged.force) - expected.force).norm() < 1e-15, "{logged:?} {expected:?}");
            assert_eq!(
                (logged.gap, logged.state.as_str()),
                (expected.gap, if expected.sticks { "stick" } else { "slip" })
            );
        }
    }
    // Nobody has asked an integrator yet that has not stepped.
    assert!(frames[0].1.is_empty());
}

#[test]
fn arrows_stand_where_contacts_are_and_are_as_long_as_forces_are_large() {
    let (path, _) = log("arrows_logged");
    let bytes = std::fs::read(path).expect("a log");
    let messages = messages(&bytes);
    let scenes = of_topic(&messages, "/contact_forces");
    assert_eq!(scenes.len(), 31);
    let weight = touching_arm().mechanism.total_mass() * 9.81;
    for (message, logged) in scenes.iter().zip(of_topic(&messages, "/contacts")) {
        assert_eq!(message.log_time, logged.log_time);
        let markers = Marker::read_all(message);
        let contacts = decode::contacts(&logged.data).expect("contacts");
        let [deletion, arrows @ ..] = markers.as_slice() else { panic!("{markers:?}") };
        assert_eq!((deletion.action, arrows.len()), (3, contacts.len()), "what was there before is deleted");
        for (number, (arrow, contact)) in (1..).zip(arrows.iter().zip(contacts)) {
            assert_eq!((arrow.kind, arrow.action, arrow.number, arrow.frame.as_str()), (0, 0, number, "world"));
            assert_eq!(arrow.pose, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
            let [from, to] = arrow.points[..] else { panic!("{arrow:?}") };
            assert_eq!(from, contact.position);
            let drawn = Vector3::from(to) - Vector3::from(from);
            // Roundings of coordinates up to 4 m.
            let expected = 0.5 / weight * Vector3::from(contact.force);
            assert!((drawn - expected).norm() < 2e-15, "{drawn} {expected}");
        }
    }
}

#[test]
fn an_event_of_a_pair_is_called_after_both_shapes() {
    let (path, summary) = log("pairs_named");
    let bytes = std::fs::read(path).expect("a log");
    let messages = messages(&bytes);
    let events = of_topic(&messages, "/events");
    assert_eq!((events.len(), summary.steps > 9), (summary.steps, true));
    for message in events {
        let event = decode::event(&message.data).expect("an event");
        assert_eq!(
            (event.kind.as_str(), event.what.as_str(), event.impulse),
            ("contact_impact", "slider|wall", Some(2.5))
        );
    }
}

#[test]
fn the_summary_has_the_deepest_overlap_and_the_farthest_of_a_force_from_its_cone_at_ends_of_steps() {
    let (_, summary) = log("figures_summed");
    // At the end, where the force of the wall is (10, 3, 4.25): tangential 5.2022 N, of which friction may be 5 N.
    let ContactFigures { penetration, cone_violation, .. } = summary.contact;
    assert!((penetration - 0.5e-3).abs() < 1e-18, "{penetration}");
    let expected = 3.0_f64.hypot(4.25) - 5.0;
    // Roundings of a sum of ten steps and of a root.
    assert!((cone_violation - expected).abs() < 1e-14, "{cone_violation} {expected}");
}

#[test]
fn a_table_has_the_forces_of_all_pairs_that_touch_at_any_sample_and_zero_where_they_do_not() {
    let (path, _) = log("table_written");
    let mut table = Vec::new();
    write_table(&path, &JointKinds::default(), &mut table).expect("a table");
    // One unit has a comma of its own.
    let table = String::from_utf8(table).expect("text").replace("[N m, N]", "[N m or N]");
    let mut rows = table.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let head = rows.next().expect("a head");
    let column =
        |name: &str| head.iter().position(|known| *known == name).unwrap_or_else(|| panic!("{name} in {head:?}"));
    let (wall, floor) = (column("slider|wall.contact_force.x [N]"), column("slider|floor.contact_force.z [N]"));
    for (sample, row) in rows.enumerate() {
        let time = sample as f64 / 60.0;
        let expected = |from: f64, force: &'static str| if time >= from { force } else { "0" };
        assert_eq!((row[wall], row[floor]), (expected(0.1, "10"), expected(0.2, "1")), "at {time} s");
    }
}
