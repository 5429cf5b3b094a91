//! Access to the number at a place of a scene.

use crate::mechanism::description::contact::Shape;
use crate::mechanism::description::nonsmooth::MotorLaw;
use crate::scene::body::Weight;
use crate::scene::contact_settings::Obstacle;
use crate::scene::coupling::{JointReference, Point, SpringPlace};
use crate::scene::description::{JointValues, STANDARD_GRAVITY, Scene};
use crate::scene::joint_settings::{LimitChoice, SceneJoint};
use crate::scene::loads::{Factor, LoadKind};
use crate::scene::parameters::place::{BodyNumber, LoadNumber, MotorNumber, Place, ShapeNumber, SpringNumber};
use crate::scene::parameters::slot::Slot;
use crate::scene::robot::{Geometry, Inertial, Limit, Pose, Shape as LinkShape, Surface, UrdfJoint};
use nalgebra::{Matrix3, Vector3};

impl Place {
    /// The number at this place of a scene; what the files leave out is put there as it is without them. `None` in a scene without the place.
    pub fn slot<'s>(&self, scene: &'s mut Scene) -> Option<Slot<'s>> {
        use Slot::{Number, Optional};
        Some(match self {
            Place::Gravity(axis) => Number(scene.gravity.get_or_insert(STANDARD_GRAVITY).get_mut(*axis)?),
            Place::BasePosition { robot, axis } => {
                Number(scene.robots.get_mut(*robot)?.pose.translation.vector.get_mut(*axis)?)
            }
            Place::BaseTurn { robot, angle } => Number(scene.robots.get_mut(*robot)?.rpy.get_mut(*angle)?),
            Place::BaseVelocity { robot, number } => {
                let robot = scene.robots.get_mut(*robot)?;
                Number(robot.velocity.get_or_insert(([0.0; 6], robot.line)).0.get_mut(*number)?)
            }
            Place::Body { robot, what } => {
                let body = scene.robots.get_mut(*robot)?.body.as_mut()?;
                match (what, &mut body.weight) {
                    (BodyNumber::Weight, Weight::Density(number) | Weight::Mass(number)) => Number(number),
                    (BodyNumber::Shape(what), _) => Number(of_geometry(&mut body.shape, *what)?),
                }
            }
            Place::Position { robot, joint, number, count } => {
                let robot = scene.robots.get_mut(*robot)?;
                Number(values(&mut robot.positions, joint, *count, robot.line)?.get_mut(*number)?)
            }
            Place::Velocity { robot, joint, number, count } => {
                let robot = scene.robots.get_mut(*robot)?;
                Number(values(&mut robot.velocities, joint, *count, robot.line)?.get_mut(*number)?)
            }
            Place::LinkFriction { robot, link } => Optional(&mut surface(scene, *robot, *link)?.friction),
            Place::LinkRestitution { robot, link } => Optional(&mut surface(scene, *robot, *link)?.restitution),
            Place::LinkMoment { robot, link, of } => Optional(surface(scene, *robot, *link)?.moments.get_mut(*of)?),
            Place::LinkSurface { robot, link, axis } => {
                let velocity = surface(scene, *robot, *link)?.velocity.get_or_insert(Vector3::zeros());
                Number(velocity.get_mut(*axis)?)
            }
            Place::Mass { robot, link } => Number(&mut inertial(scene, *robot, *link)?.mass),
            Place::CenterOfMass { robot, link, axis } => {
                Number(inertial(scene, *robot, *link)?.origin.translation.vector.get_mut(*axis)?)
            }
            Place::Inertia { robot, link, row, column } => {
                let matrix = &mut inertial(scene, *robot, *link)?.inertia;
                Slot::Symmetric { matrix, row: *row, column: *column }
            }
            Place::InertiaTurn { robot, link, angle } => Number(inertial(scene, *robot, *link)?.rpy.get_mut(*angle)?),
            Place::Collision { robot, link, shape, what } => {
                let link = scene.robots.get_mut(*robot)?.robot.links.get_mut(*link)?;
                of_collision(link.collisions.get_mut(*shape)?, *what)?
            }
            Place::Origin { robot, joint, axis } => {
                Number(of_urdf(scene, *robot, *joint)?.origin.translation.vector.get_mut(*axis)?)
            }
            Place::OriginTurn { robot, joint, angle } => Number(of_urdf(scene, *robot, *joint)?.rpy.get_mut(*angle)?),
            Place::Axis { robot, joint, axis } => Number(of_urdf(scene, *robot, *joint)?.given_axis.get_mut(*axis)?),
            Place::EffortBound { robot, joint } => Optional(&mut bounds(of_urdf(scene, *robot, *joint)?).effort),
            Place::SpeedBound { robot, joint } => Optional(&mut bounds(of_urdf(scene, *robot, *joint)?).velocity),
            Place::MimicMultiplier { robot, joint } => {
                Number(&mut of_urdf(scene, *robot, *joint)?.mimic.as_mut()?.multiplier)
            }
            Place::MimicOffset { robot, joint } => Number(&mut of_urdf(scene, *robot, *joint)?.mimic.as_mut()?.offset),
            Place::LowerLimit(of) => Number(limits(scene, of)?.0),
            Place::UpperLimit(of) => Number(limits(scene, of)?.1),
            Place::Restitution(of) => Optional(&mut settings(scene, of)?.0.restitution),
            Place::Friction(of) => {
                let (said, urdf) = settings(scene, of)?;
                said.friction = said.friction.or(urdf.dynamics.map(|dynamics| dynamics.friction));
                Optional(&mut said.friction)
            }
            Place::Damping(of) => {
                let (said, urdf) = settings(scene, of)?;
                said.damping = said.damping.or(urdf.dynamics.map(|dynamics| dynamics.damping));
                Optional(&mut said.damping)
            }
            Place::Armature(of) => {
                let (said, urdf) = settings(scene, of)?;
                said.armature = said.armature.or(urdf.armature);
                Optional(&mut said.armature)
            }
            Place::Motor { motor, what } => {
                let motor = scene.motors.get_mut(*motor)?;
                match (what, &mut motor.law) {
                    (MotorNumber::Kp, MotorLaw::Position { kp, .. }) => Number(kp),
                    (MotorNumber::Kd, MotorLaw::Position { kd, .. } | MotorLaw::Velocity { kd }) => Number(kd),
                    (MotorNumber::Target, _) => Slot::Target(&mut motor.target),
                    (MotorNumber::MaxEffort, _) => Optional(&mut motor.max_effort),
                    (MotorNumber::Period, _) => Number(&mut motor.period),
                    (MotorNumber::GravityCompensation, _) => Number(&mut motor.gravity_compensation),
                    _ => return None,
                }
            }
            Place::TargetTime { motor, entry } => Number(&mut entry_of(scene, *motor, *entry)?.0),
            Place::TargetValue { motor, entry } => Number(&mut entry_of(scene, *motor, *entry)?.1),
            Place::MotionTime { motion, entry } => {
                Number(&mut scene.motions.get_mut(*motion)?.table.as_mut()?.points.get_mut(*entry)?.0)
            }
            Place::MotionValue { motion, entry } => {
                Number(&mut scene.motions.get_mut(*motion)?.table.as_mut()?.points.get_mut(*entry)?.1)
            }
            Place::MotionParameter { motion, index } => {
                let formula = scene.motions.get_mut(*motion)?.position.as_formula_mut()?;
                Number(&mut formula.parameters_mut().get_mut(*index)?.1)
            }
            Place::MotionPosition(motion) => Slot::Target(&mut scene.motions.get_mut(*motion)?.position),
            Place::TargetParameter { motor, index } => {
                let formula = scene.motors.get_mut(*motor)?.target.as_formula_mut()?;
                Number(&mut formula.parameters_mut().get_mut(*index)?.1)
            }
            Place::Spring { spring, what } => {
                let spring = scene.springs.get_mut(*spring)?;
                match (what, &mut spring.place) {
                    (SpringNumber::Stiffness, _) => Number(&mut spring.stiffness),
                    (SpringNumber::Damping, _) => Number(&mut spring.damping),
                    (SpringNumber::Rest, SpringPlace::Points { rest_length, .. }) => Number(rest_length),
                    (SpringNumber::Rest, SpringPlace::Joint { rest, .. }) => Number(rest),
                }
            }
            Place::SpringEnd { spring, b, axis } => match &mut scene.springs.get_mut(*spring)?.place {
                SpringPlace::Points { a, b: end, .. } => at(if *b { end } else { a }, *axis)?,
                SpringPlace::Joint { .. } => return None,
            },
            Place::RopeLength(rope) => Number(&mut scene.ropes.get_mut(*rope)?.length),
            Place::RopeRestitution(rope) => Number(&mut scene.ropes.get_mut(*rope)?.restitution),
            Place::RopeStop(rope) => Number(&mut scene.ropes.get_mut(*rope)?.stop),
            Place::RopeEnd { rope, end, axis } => at(scene.ropes.get_mut(*rope)?.points.get_mut(*end)?, *axis)?,
            Place::LoopLength(of) => Optional(&mut scene.loops.get_mut(*of)?.length),
            Place::LoopEnd { of, b, axis } => {
                let closing = scene.loops.get_mut(*of)?;
                at(&mut if *b { &mut closing.b } else { &mut closing.a }.point, *axis)?
            }
            Place::LoopAxis { of, b, axis } => {
                let closing = scene.loops.get_mut(*of)?;
                let end = if *b { &mut closing.b } else { &mut closing.a };
                Number(end.given_axis.as_mut()?.get_mut(*axis)?)
            }
            Place::UrdfLoopAxis { robot, of, axis } => {
                let closing = scene.robots.get_mut(*robot)?.robot.loops.get_mut(*of)?;
                Number(closing.given_axis.get_mut(*axis)?)
            }
            Place::UrdfLoopEnd { robot, of, b, axis } => {
                let closing = scene.robots.get_mut(*robot)?.robot.loops.get_mut(*of)?;
                Number(closing.end_mut(*b).origin.translation.vector.get_mut(*axis)?)
            }
            Place::UrdfLoopTurn { robot, of, b, angle } => {
                let closing = scene.robots.get_mut(*robot)?.robot.loops.get_mut(*of)?;
                Number(closing.end_mut(*b).rpy.get_mut(*angle)?)
            }
            Place::LoadEffort(load) => match &mut scene.loads.get_mut(*load)?.kind {
                LoadKind::Joint { effort, .. } => Number(effort),
                LoadKind::Link { .. } => return None,
            },
            Place::Load { load, what } => {
                let load = scene.loads.get_mut(*load)?;
                match (what, &mut load.factor) {
                    (LoadNumber::From, _) => Number(load.from.as_mut()?),
                    (LoadNumber::Until, _) => Number(load.until.as_mut()?),
                    (LoadNumber::Factor, Factor::Number(factor)) => Number(factor),
                    (LoadNumber::Mean, Factor::Wave(wave)) => Number(&mut wave.mean),
                    (LoadNumber::Amplitude, Factor::Wave(wave)) => Number(&mut wave.amplitude),
                    (LoadNumber::Frequency, Factor::Wave(wave)) => Number(&mut wave.frequency),
                    (LoadNumber::Phase, Factor::Wave(wave)) => Number(&mut wave.phase),
                    _ => return None,
                }
            }
            Place::FactorTime { load, entry } => Number(&mut factor_of(scene, *load, *entry)?.0),
            Place::FactorValue { load, entry } => Number(&mut factor_of(scene, *load, *entry)?.1),
            Place::FactorParameter { load, index } => match &mut scene.loads.get_mut(*load)?.factor {
                Factor::Formula(formula) => Number(&mut formula.parameters_mut().get_mut(*index)?.1),
                _ => return None,
            },
            Place::CouplingTerm { coupling, term } => {
                Number(&mut scene.couplings.get_mut(*coupling)?.terms.get_mut(*term)?.1)
            }
            Place::CouplingOffset(coupling) => Number(&mut scene.couplings.get_mut(*coupling)?.offset),
            Place::Drag { drag, number } => Number(scene.drags.get_mut(*drag)?.numbers.get_mut(*number)?),
            Place::DragPosition { drag, axis } => at(&mut scene.drags.get_mut(*drag)?.point, *axis)?,
            Place::LoadForce { load, axis } => match &mut scene.loads.get_mut(*load)?.kind {
                LoadKind::Link { force, .. } => Number(force.get_mut(*axis)?),
                LoadKind::Joint { .. } => return None,
            },
            Place::LoadTorque { load, axis } => match &mut scene.loads.get_mut(*load)?.kind {
                LoadKind::Link { torque, .. } => Number(torque.get_mut(*axis)?),
                LoadKind::Joint { .. } => return None,
            },
            Place::LoadPosition { load, axis } => match &mut scene.loads.get_mut(*load)?.kind {
                LoadKind::Link { point, .. } => at(point, *axis)?,
                LoadKind::Joint { .. } => return None,
            },
            Place::ObstacleFriction(of) => Optional(&mut scene.contact.obstacles.get_mut(*of)?.friction),
            Place::ObstacleRestitution(of) => Optional(&mut scene.contact.obstacles.get_mut(*of)?.restitution),
            Place::ObstacleMoment { obstacle, of } => {
                Optional(scene.contact.obstacles.get_mut(*obstacle)?.moments.get_mut(*of)?)
            }
            Place::ObstacleSurface { obstacle, axis } => {
                Number(scene.contact.obstacles.get_mut(*obstacle)?.surface_velocity.get_mut(*axis)?)
            }
            Place::ObstaclePosition { obstacle, axis } => {
                Number(scene.contact.obstacles.get_mut(*obstacle)?.pose.translation.vector.get_mut(*axis)?)
            }
            Place::ObstacleTurn { obstacle, angle } => {
                Number(scene.contact.obstacles.get_mut(*obstacle)?.rpy.get_mut(*angle)?)
            }
            Place::ObstacleShape { obstacle, what } => of_obstacle(scene.contact.obstacles.get_mut(*obstacle)?, *what)?,
            Place::ObstacleNormal { obstacle, axis } => {
                Number(scene.contact.obstacles.get_mut(*obstacle)?.normal.get_mut(*axis)?)
            }
            Place::ContactFriction => Number(&mut scene.contact.friction),
            Place::ContactRestitution => Number(&mut scene.contact.restitution),
            Place::ContactMoment(of) => Number(scene.contact.moments.get_mut(*of)?),
            Place::PairMoment { rule, of } => Optional(scene.contact.rules.get_mut(*rule)?.moments.get_mut(*of)?),
            Place::SelfContact => Slot::Flag(&mut scene.contact.self_contact),
            Place::PairFriction(rule) => Optional(&mut scene.contact.rules.get_mut(*rule)?.friction),
            Place::PairRestitution(rule) => Optional(&mut scene.contact.rules.get_mut(*rule)?.restitution),
            Place::Duration => Optional(&mut scene.simulation.duration),
            Place::Tolerance => Optional(&mut scene.simulation.tolerance),
            Place::Stages => Slot::Count(&mut scene.simulation.fixed.as_mut()?.0),
            Place::Step => Number(&mut scene.simulation.fixed.as_mut()?.1),
            Place::Rate => Optional(&mut scene.simulation.rate),
        })
    }
}

fn at(point: &mut Point, axis: usize) -> Option<Slot<'_>> {
    point.position.get_mut(axis).map(Slot::Number)
}

/// The last given numbers of a joint, which count; zeros if the scene gives no numbers.
fn values<'v>(given: &'v mut Vec<JointValues>, joint: &str, count: usize, line: usize) -> Option<&'v mut Vec<f64>> {
    let index = given.iter().rposition(|one| one.joint == joint).unwrap_or_else(|| {
        given.push(JointValues { joint: joint.to_string(), values: vec![0.0; count], line });
        given.len() - 1
    });
    given.get_mut(index).map(|one| &mut one.values)
}

/// Mass and inertia of a link; of one without, zeros at the origin of its frame.
fn inertial(scene: &mut Scene, robot: usize, link: usize) -> Option<&mut Inertial> {
    let link = scene.robots.get_mut(robot)?.robot.links.get_mut(link)?;
    let line = link.line;
    Some(link.inertial.get_or_insert_with(|| Inertial {
        origin: Pose::identity(),
        rpy: [0.0; 3],
        mass: 0.0,
        inertia: Matrix3::zeros(),
        line,
    }))
}

/// The surface of a link; of a body, what it is made from.
fn surface(scene: &mut Scene, robot: usize, link: usize) -> Option<&mut Surface> {
    let placed = scene.robots.get_mut(robot)?;
    match &mut placed.body {
        Some(body) => Some(&mut body.surface),
        None => Some(&mut placed.robot.links.get_mut(link)?.surface),
    }
}

/// A joint of a URDF.
fn of_urdf(scene: &mut Scene, robot: usize, joint: usize) -> Option<&mut UrdfJoint> {
    scene.robots.get_mut(robot)?.robot.joints.get_mut(joint)
}

/// The `<limit>` of a joint; an empty one is added if it is missing.
fn bounds(joint: &mut UrdfJoint) -> &mut Limit {
    joint.limit.get_or_insert(Limit { lower: None, upper: None, effort: None, velocity: None })
}

/// Time and value of an entry of a motor's table.
fn entry_of(scene: &mut Scene, motor: usize, entry: usize) -> Option<&mut (f64, f64)> {
    scene.motors.get_mut(motor)?.table.as_mut()?.points.get_mut(entry)
}

/// A number of a collision shape of a link.
fn of_collision(shape: &mut LinkShape, what: ShapeNumber) -> Option<Slot<'_>> {
    Some(Slot::Number(match what {
        ShapeNumber::Friction => return Some(Slot::Optional(&mut shape.surface.friction)),
        ShapeNumber::Restitution => return Some(Slot::Optional(&mut shape.surface.restitution)),
        ShapeNumber::Moment(of) => return shape.surface.moments.get_mut(of).map(Slot::Optional),
        ShapeNumber::SurfaceVelocity(axis) => shape.surface.velocity.as_mut()?.get_mut(axis)?,
        ShapeNumber::Position(axis) => shape.origin.translation.vector.get_mut(axis)?,
        ShapeNumber::Turn(angle) => shape.rpy.get_mut(angle)?,
        of_geometry_alone => of_geometry(&mut shape.geometry, of_geometry_alone)?,
    }))
}

/// A number of a geometry.
fn of_geometry(geometry: &mut Geometry, what: ShapeNumber) -> Option<&mut f64> {
    Some(match (what, geometry) {
        (
            ShapeNumber::Radius,
            Geometry::Sphere { radius } | Geometry::Cylinder { radius, .. } | Geometry::Capsule { radius, .. },
        ) => radius,
        (ShapeNumber::Length, Geometry::Cylinder { length, .. } | Geometry::Capsule { length, .. }) => length,
        (ShapeNumber::Size(axis), Geometry::Box { size }) => size.get_mut(axis)?,
        (ShapeNumber::Radii(axis), Geometry::Ellipsoid { radii }) => radii.get_mut(axis)?,
        (ShapeNumber::Scale(axis), Geometry::Mesh(mesh)) => mesh.scale.get_mut(axis)?,
        _ => return None,
    })
}

/// An entry of the factor of a load: time and value.
fn factor_of(scene: &mut Scene, load: usize, entry: usize) -> Option<&mut (f64, f64)> {
    match &mut scene.loads.get_mut(load)?.factor {
        Factor::Table(table) => table.points.get_mut(entry),
        _ => None,
    }
}

/// A number of the shape of an obstacle.
fn of_obstacle(obstacle: &mut Obstacle, what: ShapeNumber) -> Option<Slot<'_>> {
    Some(match (what, &mut obstacle.shape) {
        (
            ShapeNumber::Radius,
            Shape::Sphere { radius } | Shape::Capsule { radius, .. } | Shape::Cylinder { radius, .. },
        ) => Slot::Number(radius),
        (ShapeNumber::Length, Shape::Capsule { half, .. } | Shape::Cylinder { half, .. }) => Slot::Half(half),
        (ShapeNumber::Size(axis), Shape::Box { half }) => Slot::Half(half.get_mut(axis)?),
        (ShapeNumber::Radii(axis), Shape::Ellipsoid { radii }) => Slot::Number(radii.get_mut(axis)?),
        (ShapeNumber::Scale(axis), Shape::Mesh(_)) => Slot::Number(obstacle.scale.get_mut(axis)?),
        _ => return None,
    })
}

/// The `[[joint]]` of a joint, made if it is missing, and the joint of the URDF.
fn settings<'s>(scene: &'s mut Scene, of: &JointReference) -> Option<(&'s mut SceneJoint, &'s UrdfJoint)> {
    let robot = scene.robots.get(of.robot)?;
    let urdf = robot.robot.joints.iter().find(|joint| joint.name == of.joint)?;
    let index = scene.joints.iter().position(|said| said.joint == *of).unwrap_or_else(|| {
        let (joint, name, line) = (of.clone(), of.joint.clone(), robot.line);
        scene.joints.push(SceneJoint {
            joint,
            name,
            limit: None,
            restitution: None,
            friction: None,
            damping: None,
            armature: None,
            line,
        });
        scene.joints.len() - 1
    });
    Some((scene.joints.get_mut(index)?, urdf))
}

/// The limits of a joint; infinite if it has no limits.
fn limits<'s>(scene: &'s mut Scene, of: &JointReference) -> Option<(&'s mut f64, &'s mut f64)> {
    let (said, urdf) = settings(scene, of)?;
    let limit = said.limit.get_or_insert_with(|| {
        let (lower, upper) = urdf.own_limits().unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        LimitChoice::Range(lower, upper)
    });
    if *limit == LimitChoice::Unlimited {
        *limit = LimitChoice::Range(f64::NEG_INFINITY, f64::INFINITY);
    }
    match limit {
        LimitChoice::Range(lower, upper) => Some((lower, upper)),
        LimitChoice::Unlimited => None,
    }
}
