//! The report of a motion that is not smooth, made by hand: its events, where its energy went, and what its joints are up to.

use catena::mechanism::description::closure::{Coordinate, JointLimit};
use catena::mechanism::forces::total::Exchange;
use catena::mechanism::motion::event::{Event, EventCounts, EventKind, FrictionState, JointStatus, Side};
use catena::mechanism::motion::integrator::MethodDescription;
use catena::model::{Model, ModelOptions};
use catena::output::report::{
    ConstraintReport, ContactsReport, EnergyReport, EventReport, MethodReport, ModelReport, Report, joint_reports,
};
use catena::scene::{PackagePath, robot_from_text};
use catena::simulation::{Finished, Summary};
use serde_json::{Value, json};
use std::path::Path;

use crate::common::command::PENDULUM;

/// Three events of a pendulum, which in the end rests on its upper limit.
fn finished(model: &Model) -> Finished {
    let event = |time, kind, impulse| Event { time, kind, body: 0, pair: None, impulse };
    let events = vec![
        event(0.25, EventKind::LimitImpact, Some(-1.5)),
        event(0.5, EventKind::LimitImpact, Some(-0.25)),
        event(0.75, EventKind::Rest, None),
    ];
    let mut counts = EventCounts::default();
    events.iter().for_each(|event| counts.count(event.kind));
    let exchange = Exchange { dissipated: 1.0, work: 2.0, friction: 0.5, impacts: 0.25 };
    Finished {
        held: Vec::new(),
        state: model.zero_state(),
        summary: Summary { events: counts, exchange, ..Summary::default() },
        method: MethodDescription::fixed("by hand", 2, 2, 0.1),
        islands: Vec::new(),
        events,
        joints: vec![JointStatus {
            limit: Some(Side::Upper),
            friction: Some(FrictionState::Stuck),
            effort: Some(-3.5),
        }],
        contacts: Vec::new(),
        accuracy: Vec::new(),
        end: 0.0,
        parts: (1, 0),
    }
}

fn pendulum() -> Model {
    let robot = robot_from_text(PENDULUM, Path::new("pendulum.urdf"), &PackagePath::default()).expect("a robot");
    Model::new(robot, &ModelOptions::default()).expect("a model")
}

fn report(model: &Model) -> Report {
    let finished = finished(model);
    let joints = joint_reports(model, &finished.state, &finished.joints);
    Report {
        catena: "",
        input: String::new(),
        scene: String::new(),
        start: 0.0,
        duration: 1.0,
        method: MethodReport::new(&finished.method, finished.state.time),
        model: ModelReport::default(),
        steps: 10,
        iterations: 10,
        kept_factor_iterations: 0,
        rejected_steps: 0,
        rejected: Default::default(),
        located_attempts: 0,
        exact_newton_steps: 0,
        wall_seconds: 1.0,
        cpu_seconds: 1.0,
        solve_cpu_seconds: 1.0,
        accuracy: None,
        no_accuracy: None,
        step_error: None,
        from_log: None,
        events: EventReport::new(model, &finished),
        contact: ContactsReport::default(),
        energy: EnergyReport::new(&finished.summary),
        constraint: ConstraintReport::new(&finished.summary),
        links: Vec::new(),
        joints,
        loops: Vec::new(),
        islands: Vec::new(),
        warnings: Vec::new(),
        log: None,
    }
}

#[test]
fn json_has_events_where_the_energy_went_and_what_joints_are_up_to() {
    let report = serde_json::to_value(report(&pendulum())).expect("JSON");
    assert_eq!(
        report["events"]["list"],
        json!([
            {"time": 0.25, "kind": "limit_impact", "what": "hinge", "impulse": -1.5},
            {"time": 0.5, "kind": "limit_impact", "what": "hinge", "impulse": -0.25},
            {"time": 0.75, "kind": "rest", "what": "hinge"},
        ])
    );
    assert_eq!(
        report["events"]["counts"],
        json!({"limit_impact": 2, "contact_impact": 0, "rest": 1, "release": 0, "stick": 0, "slip": 0, "reversal": 0,
               "saturation": 0, "unsaturation": 0})
    );
    for (part, expected) in [("dissipated", 1.0), ("friction", 0.5), ("impacts", 0.25), ("work", 2.0)] {
        assert_eq!(report["energy"][part], expected, "{part}");
    }
    let hinge = &report["joints"]["hinge"];
    assert_eq!(
        [&hinge["limit"], &hinge["friction"], &hinge["effort"]],
        [&json!("upper"), &json!("stuck"), &json!(-3.5)]
    );
    assert_ne!(hinge["position"], Value::Null);
}

#[test]
fn lines_for_people_have_events_and_losses_only_of_a_mechanism_that_can_have_any() {
    let mut model = pendulum();
    let smooth = report(&model).to_string();
    assert!(!smooth.contains("events") && !smooth.contains("friction"), "{smooth}");
    assert!(
        smooth.contains("              1.00 J dissipated by dampers, 2.00 J from motors and loads, 0 J in springs\n"),
        "{smooth}"
    );
    let coordinate = Coordinate { body: 0, position: 0, freedom: 0 };
    model.mechanism.nonsmooth.limits = vec![JointLimit { coordinate, lower: -1.0, upper: 1.0, restitution: 0.0 }];
    let words = report(&model).to_string();
    assert!(words.contains("  events      2 limit impacts, 1 rest\n"), "{words}");
    let parts = "1.00 J dissipated by dampers, 0.500 J by dry friction, 0.250 J lost in impacts, 2.00 J from motors and loads, 0 J in springs";
    assert!(words.contains(&format!("              {parts}\n")), "{words}");
    let line = |words: &str| words.lines().filter(|line| !line.contains("events") && !line.contains(" J ")).count();
    assert_eq!(line(&words), line(&smooth), "nothing else is said");
}
