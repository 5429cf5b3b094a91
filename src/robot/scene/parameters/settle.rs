//! Values that follow from the numbers of a scene, computed after all numbers are set.
//!
//! A rotation follows from its roll, pitch and yaw, a unit axis from the axis as given, the target of a motor from its table, the surface of a mesh
//! from its scale: each as the reader of the file works it out, so that the bits are the same.

use crate::mechanism::description::contact::Shape;
use crate::mechanism::description::formula::Formula;
use crate::mechanism::description::target::Target;
use crate::meshes::collision_surface;
use crate::scene::contact_settings::Obstacle;
use crate::scene::description::Scene;
use crate::scene::error::{Element, Problem};
use crate::scene::joint_settings::LimitChoice;
use crate::scene::loads::{Factor, SceneLoad};
use crate::scene::numbers::{normalised, turn, turn_of_z};
use crate::scene::parameters::place::{Place, ShapeNumber};
use crate::scene::robot::Geometry;
use crate::scene::taken::TakenNumber;
use crate::scene::urdf_reading::inertia::impossible_inertia;
use nalgebra::Vector3;
use std::sync::Arc;

impl Place {
    /// Computes the values that follow from the number at this place and the numbers beside it.
    ///
    /// # Errors
    /// Why these numbers cannot be together.
    pub fn settle(&self, scene: &mut Scene) -> Result<(), String> {
        match *self {
            Place::BaseTurn { robot, .. } => {
                let robot = &mut scene.robots[robot];
                robot.pose.rotation = turn(robot.rpy);
            }
            Place::Body { robot, .. }
            | Place::LinkFriction { robot, .. }
            | Place::LinkRestitution { robot, .. }
            | Place::LinkMoment { robot, .. }
            | Place::LinkSurface { robot, .. } => {
                let placed = &mut scene.robots[robot];
                if let Some(body) = &placed.body {
                    let made = body.robot(&placed.name, &scene.path, placed.line);
                    placed.robot = made.map_err(|error| error.problem.to_string())?;
                } else if let Place::LinkFriction { link, .. } = *self {
                    let link = Element::Link(placed.robot.links[link].name.clone());
                    placed.robot.forget_taken(TakenNumber::Friction, &link);
                }
            }
            // A winch stands where its rope begins.
            Place::RopeEnd { rope, end: 1, .. } => {
                let rope = &scene.ropes[rope];
                if let (Some(winch), Some(first)) = (&rope.winch, rope.points.get(1)) {
                    scene.robots[winch.robot].pose.translation.vector = first.position;
                }
            }
            Place::Armature(ref of) => {
                let joint = Element::Joint(of.joint.clone());
                scene.robots[of.robot].robot.forget_taken(TakenNumber::Armature, &joint);
            }
            Place::Mass { robot, link } | Place::Inertia { robot, link, .. } => warn_of_inertia(scene, robot, link),
            Place::InertiaTurn { robot, link, .. } => {
                if let Some(inertial) = &mut scene.robots[robot].robot.links[link].inertial {
                    inertial.origin.rotation = turn(inertial.rpy);
                }
            }
            Place::Collision { robot, link, shape, what } => {
                let shape = &mut scene.robots[robot].robot.links[link].collisions[shape];
                match (what, &shape.geometry) {
                    (ShapeNumber::Turn(_), _) => shape.origin.rotation = turn(shape.rpy),
                    (ShapeNumber::Scale(_), Geometry::Mesh(mesh)) => check_scale(&mesh.scale)?,
                    _ => {}
                }
            }
            Place::OriginTurn { robot, joint, .. } => {
                let joint = &mut scene.robots[robot].robot.joints[joint];
                joint.origin.rotation = turn(joint.rpy);
            }
            Place::Axis { robot, joint, .. } => {
                let joint = &mut scene.robots[robot].robot.joints[joint];
                joint.axis = unit(&joint.given_axis)?;
            }
            Place::LowerLimit(ref of) | Place::UpperLimit(ref of) => {
                let said = scene.joints.iter().find(|joint| joint.joint == *of).and_then(|joint| joint.limit);
                if let Some(LimitChoice::Range(lower, upper)) = said {
                    LimitChoice::between(lower, upper)?;
                }
            }
            Place::TargetTime { motor, .. } | Place::TargetValue { motor, .. } => {
                let motor = &mut scene.motors[motor];
                if let Some(table) = &motor.table {
                    motor.target = table.target().map_err(|(_, reason)| reason)?;
                }
            }
            Place::CouplingTerm { coupling, term } if scene.couplings[coupling].terms[term].1 == 0.0 => {
                return Err("a coefficient of a coupling is not zero; leave its joint out".to_string());
            }
            Place::MotionTime { motion, .. } | Place::MotionValue { motion, .. } => {
                let motion = &mut scene.motions[motion];
                if let Some(table) = &motion.table {
                    table.target().map_err(|(_, reason)| reason)?;
                    motion.position = Target::smooth(&table.points).map_err(|error| error.to_string())?;
                }
            }
            Place::MotionParameter { motion, .. } => {
                scene.motions[motion].position.as_formula().map_or(Ok(()), Formula::check_start)?;
            }
            Place::TargetParameter { motor, .. } => {
                scene.motors[motor].target.as_formula().map_or(Ok(()), Formula::check_start)?;
            }
            Place::FactorParameter { load, .. } => {
                if let Factor::Formula(formula) = &scene.loads[load].factor {
                    formula.check_start()?;
                }
            }
            Place::FactorTime { load, .. } | Place::FactorValue { load, .. } => {
                if let Factor::Table(table) = &scene.loads[load].factor {
                    table.target().map_err(|(_, reason)| reason)?;
                }
            }
            Place::Load { load, .. } => {
                if let SceneLoad { from: Some(from), until: Some(until), .. } = scene.loads[load]
                    && from >= until
                {
                    return Err("a load ends after it begins: give a later until".to_string());
                }
            }
            Place::LoopAxis { of, b, .. } => {
                let closing = &mut scene.loops[of];
                let end = if b { &mut closing.b } else { &mut closing.a };
                end.axis = end.given_axis.as_ref().map(unit).transpose()?;
            }
            Place::UrdfLoopAxis { robot, of, .. } => {
                let closing = &mut scene.robots[robot].robot.loops[of];
                closing.axis = unit(&closing.given_axis)?;
            }
            Place::UrdfLoopTurn { robot, of, b, .. } => {
                let end = scene.robots[robot].robot.loops[of].end_mut(b);
                end.origin.rotation = turn(end.rpy);
            }
            Place::ObstacleNormal { obstacle, .. } => {
                let obstacle = &mut scene.contact.obstacles[obstacle];
                let normal = normalised(&obstacle.normal).ok_or("the normal of a half space must not be zero")?;
                obstacle.turn = turn_of_z(&normal);
                obstacle.pose.rotation = turn(obstacle.rpy) * obstacle.turn;
            }
            Place::ObstacleTurn { obstacle, .. } => {
                let obstacle = &mut scene.contact.obstacles[obstacle];
                obstacle.pose.rotation = turn(obstacle.rpy) * obstacle.turn;
            }
            Place::ObstacleShape { obstacle, what: ShapeNumber::Scale(_) } => {
                read_again(&mut scene.contact.obstacles[obstacle])?;
            }
            _ => {}
        }
        Ok(())
    }
}

/// The unit vector along an axis.
fn unit(given: &Vector3<f64>) -> Result<Vector3<f64>, String> {
    normalised(given).ok_or_else(|| Problem::ZeroAxis.to_string())
}

fn check_scale(scale: &Vector3<f64>) -> Result<(), String> {
    let zero = scale.iter().any(|factor| *factor == 0.0);
    if zero { Err("the scale of a mesh must not be zero".to_string()) } else { Ok(()) }
}

/// The mesh of an obstacle with its scale.
fn read_again(obstacle: &mut Obstacle) -> Result<(), String> {
    check_scale(&obstacle.scale)?;
    if let Some(mesh) = &obstacle.mesh {
        let surface = collision_surface(&mesh.path, &mesh.bytes, &obstacle.scale).map_err(|error| error.to_string())?;
        obstacle.shape = Shape::Mesh(Arc::new(surface));
    }
    Ok(())
}

/// Adds the warning about an inertia that no body has.
fn warn_of_inertia(scene: &mut Scene, robot: usize, link: usize) {
    let robot = &mut scene.robots[robot].robot;
    let link = &robot.links[link];
    let warning = link.inertial.as_ref().and_then(|inertial| {
        let owner = Element::Link(link.name.clone());
        impossible_inertia(&robot.path, inertial.line, &owner, inertial.mass, &inertial.inertia)
    });
    robot.warnings.extend(warning.filter(|warning| !robot.warnings.contains(warning)));
}
