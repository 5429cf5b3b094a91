//! The part of `catena model` about everything besides the trees: several robots, loops, mimic relations and forces.

use crate::cli::tables::table::{Table, number, triple};
use catena::instant::start::assembly::Redundancy;
use catena::mechanism::description::closure::{Attachment, Coordinate, LoopKind, Mimic};
use catena::mechanism::description::forces::JointDamper;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::ground::words::counted;
use catena::model::Model;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// The couplings as entries of the JSON report.
pub fn as_json(model: &Model, redundancy: &Redundancy) -> Vec<(&'static str, Value)> {
    let mechanism = &model.mechanism;
    let end = |end: &Attachment| {
        let z = end.frame.rotation.matrix().column(2).into_owned();
        json!({
            "body": body_name(mechanism, end.body),
            "position": end.frame.translation.vector.as_slice(),
            "axis": z.as_slice(),
        })
    };
    let point = |end: &Attachment| json!({"body": body_name(mechanism, end.body), "position": end.frame.translation.vector.as_slice()});
    let robots = model.robots.iter().map(|placed| {
        json!({
            "name": placed.name,
            "urdf": (!placed.is_body).then(|| placed.robot.path.display().to_string()),
            "base": if model.joints[placed.joints.clone()].iter().any(|joint| joint.is_base) { "floating" } else { "fixed" },
            "position": placed.base_pose.translation.vector.as_slice(),
        })
    });
    let loops = mechanism.loops.iter().map(|closing| {
        let length = if let LoopKind::Distance(length) = closing.kind { Some(length) } else { None };
        json!({
            "name": closing.name,
            "type": closing.kind.name(),
            "equations": closing.kind.rows(),
            "redundant": redundant_of(redundancy, &closing.name),
            "length": length,
            "a": end(&closing.a),
            "b": end(&closing.b),
        })
    });
    let moved = mechanism.mimics.iter().filter(|mimic| mimic.is_moved());
    let motions = moved
        .map(|mimic| json!({"joint": mimic.name, "position": mimic.motion(0.0, 0.0)[0], "over": over_time(mimic)}));
    let mimics = mechanism.mimics.iter().filter(|mimic| !mimic.is_moved()).map(|mimic| {
        json!({
            "joint": mimic.name,
            "leader": joint_name(mechanism, mimic.leader),
            "multiplier": mimic.multiplier,
            "offset": mimic.offset,
            "more": mimic.more.iter().map(|(own, ratio)| json!([joint_name(mechanism, *own), ratio])).collect::<Vec<_>>(),
        })
    });
    let forces = &mechanism.forces;
    let springs = forces.point_springs.iter().map(|spring| {
        json!({
            "name": spring.name,
            "stiffness": spring.stiffness,
            "damping": spring.damping,
            "rest_length": spring.rest_length,
            "a": point(&spring.a),
            "b": point(&spring.b),
        })
    });
    let joint_springs = forces.joint_springs.iter().map(|spring| {
        json!({
            "joint": joint_name(mechanism, spring.coordinate),
            "stiffness": spring.stiffness,
            "rest": spring.rest,
        })
    });
    let joint_dampers = dampers_of_joints(mechanism)
        .map(|damper| json!({"joint": joint_of(mechanism, damper.freedom).0, "damping": damper.coefficient}));
    let joint_loads = forces
        .joint_loads
        .iter()
        .map(|load| json!({"joint": joint_of(mechanism, load.freedom).0, "effort": load.effort}));
    let wrenches = forces.wrenches.iter().map(|wrench| {
        json!({
            "body": body_name(mechanism, Some(wrench.body)),
            "position": wrench.point.as_slice(),
            "force": wrench.force.as_slice(),
            "torque": wrench.torque.as_slice(),
        })
    });
    let joint_courses = forces
        .joint_courses
        .iter()
        .map(|load| json!({"joint": joint_of(mechanism, load.freedom).0, "effort": load.effort}));
    let link_loads = forces.link_loads.iter().map(|load| {
        json!({
            "body": body_name(mechanism, Some(load.body)),
            "position": load.point.as_slice(),
            "force": load.force.as_slice(),
            "torque": load.torque.as_slice(),
            "turns": load.turns,
            "changes": !load.course.is_constant(),
        })
    });
    let drags = forces.drags.iter().map(|drag| {
        json!({
            "body": body_name(mechanism, Some(drag.body)),
            "position": drag.point.as_slice(),
            "linear": drag.linear,
            "quadratic": drag.quadratic,
            "angular_linear": drag.angular_linear,
            "angular_quadratic": drag.angular_quadratic,
        })
    });
    vec![
        ("robots", robots.collect()),
        ("loops", loops.collect()),
        ("mimics", mimics.collect()),
        ("motions", motions.collect()),
        ("springs", springs.collect()),
        ("joint_springs", joint_springs.collect()),
        ("joint_dampers", joint_dampers.collect()),
        ("joint_loads", joint_loads.collect()),
        ("wrenches", wrenches.collect()),
        ("joint_courses", joint_courses.collect()),
        ("link_loads", link_loads.collect()),
        ("drags", drags.collect()),
    ]
}

/// The couplings as tables for people.
pub fn tables(model: &Model, redundancy: &Redundancy) -> Vec<Table> {
    let mechanism = &model.mechanism;
    let mut loops = Table::new("Closed loops", &["loop", "type", "between", "and", "equations", "redundant"]);
    for closing in &mechanism.loops {
        let length = if let LoopKind::Distance(length) = closing.kind { format!(" {length} m") } else { String::new() };
        loops.row(vec![
            closing.name.clone(),
            format!("{}{length}", closing.kind.name()),
            body_name(mechanism, closing.a.body).to_string(),
            body_name(mechanism, closing.b.body).to_string(),
            closing.kind.rows().to_string(),
            redundant_of(redundancy, &closing.name).to_string(),
        ]);
    }

    let mut mimics = Table::new("Joints that follow others", &["joint", "follows", "times", "plus"]);
    for mimic in mechanism.mimics.iter().filter(|mimic| !mimic.is_moved()) {
        let leader = joint_name(mechanism, mimic.leader).to_string();
        mimics.row(vec![mimic.name.clone(), leader, number(mimic.multiplier), number(mimic.offset)]);
        for (own, ratio) in &mimic.more {
            let leader = format!("and {}", joint_name(mechanism, *own));
            mimics.row(vec![String::new(), leader, number(*ratio), String::new()]);
        }
    }

    let forces = &mechanism.forces;
    let mut springs = Table::new("Springs", &["spring", "between", "and", "stiffness", "damping", "free at"]);
    for spring in &forces.point_springs {
        springs.row(vec![
            spring.name.clone(),
            body_name(mechanism, spring.a.body).to_string(),
            body_name(mechanism, spring.b.body).to_string(),
            format!("{} N/m", number(spring.stiffness)),
            format!("{} N s/m", number(spring.damping)),
            format!("{} m", number(spring.rest_length)),
        ]);
    }

    let mut acting = Table::new("What acts on joints and bodies", &["on", "acts", "how"]);
    for spring in &forces.joint_springs {
        let (joint, length, effort) = joint_of(mechanism, spring.coordinate.freedom);
        let how = format!("{} {effort}/{length}, free at {} {length}", number(spring.stiffness), number(spring.rest));
        acting.row(vec![joint.to_string(), "spring".to_string(), how]);
    }
    for damper in dampers_of_joints(mechanism) {
        let (joint, length, effort) = joint_of(mechanism, damper.freedom);
        let how = format!("{} {effort} s/{length}", number(damper.coefficient));
        acting.row(vec![joint.to_string(), "damper".to_string(), how]);
    }
    for load in &forces.joint_loads {
        let (joint, _, effort) = joint_of(mechanism, load.freedom);
        acting.row(vec![joint.to_string(), "effort".to_string(), format!("{} {effort}", number(load.effort))]);
    }
    for wrench in &forces.wrenches {
        let how = format!("force {} N, torque {} N m", triple(&wrench.force), triple(&wrench.torque));
        acting.row(vec![body_name(mechanism, Some(wrench.body)).to_string(), "wrench".to_string(), how]);
    }
    for load in &forces.joint_courses {
        let (joint, _, effort) = joint_of(mechanism, load.freedom);
        let how = format!("{} {effort} times a factor over time", number(load.effort));
        acting.row(vec![joint.to_string(), "effort".to_string(), how]);
    }
    for load in &forces.link_loads {
        let axes = if load.turns { " with the axes of the body" } else { "" };
        let over_time = if load.course.is_constant() { "" } else { ", times a factor over time" };
        let (force, torque) = (triple(&load.force), triple(&load.torque));
        let how = format!("force {force} N, torque {torque} N m{axes}{over_time}");
        acting.row(vec![body_name(mechanism, Some(load.body)).to_string(), "load".to_string(), how]);
    }
    for drag in &forces.drags {
        let (linear, quadratic) = (number(drag.linear), number(drag.quadratic));
        let how = format!("{linear} N s/m, {quadratic} N s²/m²");
        acting.row(vec![body_name(mechanism, Some(drag.body)).to_string(), "drag".to_string(), how]);
    }
    let mut motions = Table::new("Joints that are moved in time", &["joint", "position at t = 0", "over time"]);
    for mimic in mechanism.mimics.iter().filter(|mimic| mimic.is_moved()) {
        motions.row(vec![mimic.name.clone(), number(mimic.motion(0.0, 0.0)[0]), over_time(mimic)]);
    }
    vec![loops, mimics, motions, springs, acting]
}

/// The part of the first line after the degrees of freedom.
pub fn summary(model: &Model) -> String {
    let mechanism = &model.mechanism;
    let mut text = String::new();
    if !mechanism.loops.is_empty() {
        let equations: usize = mechanism.loops.iter().map(|closing| closing.kind.rows()).sum();
        let loops = counted(mechanism.loops.len(), "loop", "loops");
        // Writing into a String cannot fail.
        let _ = write!(text, ", {loops} with {}", counted(equations, "equation", "equations"));
    }
    let moved = mechanism.mimics.iter().filter(|mimic| mimic.is_moved()).count();
    if moved > 0 {
        let _ = write!(text, ", {}", counted(moved, "moved joint", "moved joints"));
    }
    let mimics = mechanism.mimics.len() - moved;
    if mimics > 0 {
        let _ = write!(text, ", {}", counted(mimics, "mimic relation", "mimic relations"));
    }
    text
}

/// How many equations of a closure the others imply.
fn redundant_of(redundancy: &Redundancy, closure: &str) -> usize {
    redundancy.redundant.iter().filter(|(name, _)| name == closure).map(|(_, count)| count).sum()
}

fn body_name(mechanism: &Mechanism, body: Option<usize>) -> &str {
    body.map_or("world", |body| mechanism.bodies[body].name.as_str())
}

fn joint_name(mechanism: &Mechanism, coordinate: Coordinate) -> &str {
    &mechanism.bodies[coordinate.body].joint.name
}

/// The dampers in joints, one for the three of a ball.
fn dampers_of_joints(mechanism: &Mechanism) -> impl Iterator<Item = &JointDamper> {
    mechanism.forces.joint_dampers.iter().filter(|damper| {
        let joint = mechanism.body_of_freedom(damper.freedom).map(|body| &mechanism.bodies[body].joint);
        joint.is_none_or(|joint| joint.velocity_index == damper.freedom)
    })
}

/// The joint that a degree of freedom belongs to, and the units of its position and its effort.
fn joint_of(mechanism: &Mechanism, freedom: usize) -> (&str, &'static str, &'static str) {
    mechanism.body_of_freedom(freedom).map_or(("", "", ""), |body| {
        let joint = &mechanism.bodies[body].joint;
        let unit = joint.kind.unit(freedom - joint.velocity_index);
        (joint.name.as_str(), unit, if unit == "m" { "N" } else { "N m" })
    })
}

/// The formula of a joint that is moved in time, or that it has a table.
fn over_time(mimic: &Mimic) -> String {
    let motion = mimic.over_time.as_ref();
    let formula = motion.and_then(|motion| motion.as_formula()).map(|formula| formula.text().to_string());
    formula.unwrap_or_else(|| {
        if motion.is_some_and(|motion| motion.is_constant()) { "constant" } else { "a table" }.to_string()
    })
}
