//! The part of `catena model` about joints: limits, dry friction, watched speeds, and motors.

use crate::cli::tables::table::{Table, number};
use catena::instant::start::unreachable::{never_reached, never_slides};
use catena::mechanism::description::closure::Coordinate;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::nonsmooth::{Motor, MotorLaw};
use catena::mechanism::motion::state::State;
use catena::model::Model;
use serde_json::{Value, json};
use std::collections::BTreeMap;

const LOCKED: &str = "the joint cannot move";

/// Limits, friction, speeds and motors as entries of the JSON report; infinite values are null.
pub fn as_json(model: &Model, start: &State) -> Vec<(&'static str, Value)> {
    let mechanism = &model.mechanism;
    let nonsmooth = &mechanism.nonsmooth;
    let name = |coordinate: Coordinate| mechanism.bodies[coordinate.body].joint.name.as_str();
    let finite = |value: f64| value.is_finite().then_some(value);
    let limits = nonsmooth.limits.iter().zip(never_reached(mechanism, start)).map(|(limit, never)| {
        json!({
            "joint": name(limit.coordinate),
            "lower": finite(limit.lower),
            "upper": finite(limit.upper),
            "restitution": limit.restitution,
            "lower_never_reached": never.lower,
            "upper_never_reached": never.upper,
        })
    });
    let friction = nonsmooth.friction.iter().zip(never_slides(mechanism)).map(|(friction, never)| {
        json!({
            "joint": name(friction.coordinate),
            "effort": friction.effort,
            "never_matters": never.then_some(LOCKED),
        })
    });
    let speeds = nonsmooth.speeds.iter().map(|limit| json!({"joint": name(limit.coordinate), "speed": limit.speed}));
    let motors = nonsmooth.motors.iter().map(|motor| {
        let (kp, kd) = motor.law.gains();
        json!({
            "joint": name(motor.coordinate),
            "kind": kind(motor),
            "kp": matches!(motor.law, MotorLaw::Position { .. }).then_some(kp),
            "kd": (motor.law != MotorLaw::Effort).then_some(kd),
            "target": motor.target.value(0.0),
            "target_changes": !motor.target.is_constant(),
            "max_effort": finite(motor.max_effort),
            "period": motor.period,
            "gravity_compensation": held_part(mechanism, motor),
        })
    });
    let rotors = mechanism.rotors();
    let armatures =
        rotors.map(|(freedom, armature)| json!({"joint": mechanism.joint_of_freedom(freedom), "armature": armature}));
    vec![
        ("armatures", armatures.collect()),
        ("limits", limits.collect()),
        ("friction", friction.collect()),
        ("speeds", speeds.collect()),
        ("motors", motors.collect()),
    ]
}

/// The same as tables for people.
pub fn tables(model: &Model, start: &State) -> [Table; 2] {
    let mechanism = &model.mechanism;
    let nonsmooth = &mechanism.nonsmooth;
    let mut rows: BTreeMap<usize, [Vec<String>; 5]> = BTreeMap::new();
    let mut put = |coordinate: Coordinate, column: usize, cell: String| {
        rows.entry(coordinate.freedom).or_default()[column].push(cell);
    };
    for (limit, never) in nonsmooth.limits.iter().zip(never_reached(mechanism, start)) {
        let (length, _) = units(mechanism, limit.coordinate);
        put(limit.coordinate, 0, format!("{} to {} {length}", number(limit.lower), number(limit.upper)));
        put(limit.coordinate, 1, number(limit.restitution));
        if limit.lower == limit.upper {
            put(limit.coordinate, 4, "locked".to_string());
        }
        for (end, reason) in [("lower", never.lower), ("upper", never.upper)] {
            if let Some(reason) = reason {
                put(limit.coordinate, 4, format!("{end} limit never reached: {reason}"));
            }
        }
    }
    for (friction, never) in nonsmooth.friction.iter().zip(never_slides(mechanism)) {
        let (_, effort) = units(mechanism, friction.coordinate);
        put(friction.coordinate, 2, format!("{} {effort}", number(friction.effort)));
        if never {
            put(friction.coordinate, 4, format!("friction never matters: {LOCKED}"));
        }
    }
    for limit in &nonsmooth.speeds {
        let (length, _) = units(mechanism, limit.coordinate);
        put(limit.coordinate, 3, format!("{} {length}/s", number(limit.speed)));
    }
    for (freedom, armature) in mechanism.rotors() {
        let unit = if mechanism
            .body_of_freedom(freedom)
            .is_some_and(|body| mechanism.bodies[body].joint.kind.unit(0) == "m")
        {
            "kg"
        } else {
            "kg m²"
        };
        rows.entry(freedom).or_default()[4].push(format!("rotor of {} {unit}", number(armature)));
    }
    let mut joints = Table::new(
        "Limits and friction of joints",
        &["joint", "limits", "restitution", "friction", "speed watched", "note"],
    );
    for (freedom, cells) in rows {
        let name = mechanism.joint_of_freedom(freedom);
        let cells = cells.into_iter().map(|cell| cell.join("; "));
        joints.row(std::iter::once(name.to_string()).chain(cells).collect());
    }

    let mut motors =
        Table::new("Motors", &["motor of", "kind", "target", "kp", "kd", "largest effort", "period", "weight held"]);
    for motor in &nonsmooth.motors {
        let (length, effort) = units(mechanism, motor.coordinate);
        let unit = match motor.law {
            MotorLaw::Position { .. } => length.to_string(),
            MotorLaw::Velocity { .. } => format!("{length}/s"),
            MotorLaw::Effort => effort.to_string(),
        };
        let when = if motor.target.is_constant() { "" } else { " at t = 0, then changing" };
        let (kp, kd) = motor.law.gains();
        let position = matches!(motor.law, MotorLaw::Position { .. });
        let given = |is: bool, text: String| if is { text } else { String::new() };
        motors.row(vec![
            mechanism.bodies[motor.coordinate.body].joint.name.clone(),
            kind(motor).to_string(),
            format!("{} {unit}{when}", number(motor.target.value(0.0))),
            given(position, format!("{} {effort}/{length}", number(kp))),
            given(motor.law != MotorLaw::Effort, format!("{} {effort} s/{length}", number(kd))),
            if motor.max_effort.is_finite() {
                format!("{} {effort}", number(motor.max_effort))
            } else {
                "none".to_string()
            },
            if motor.period > 0.0 { format!("{} s", number(motor.period)) } else { "continuous".to_string() },
            given(held_part(mechanism, motor) > 0.0, number(held_part(mechanism, motor))),
        ]);
    }
    [joints, motors]
}

/// The part of the weight beyond its joint that is held besides the law of a motor.
fn held_part(mechanism: &Mechanism, motor: &Motor) -> f64 {
    let mut held = mechanism.forces.gravity_compensations.iter();
    held.find(|held| held.freedom == motor.coordinate.freedom).map_or(0.0, |held| held.factor)
}

fn kind(motor: &Motor) -> &'static str {
    match motor.law {
        MotorLaw::Position { .. } => "position",
        MotorLaw::Velocity { .. } => "velocity",
        MotorLaw::Effort => "effort",
    }
}

/// The units of the position and the effort of a coordinate.
fn units(mechanism: &Mechanism, coordinate: Coordinate) -> (&'static str, &'static str) {
    let joint = &mechanism.bodies[coordinate.body].joint;
    let length = joint.kind.unit(coordinate.freedom - joint.velocity_index);
    (length, if length == "m" { "N" } else { "N m" })
}
