//! The origin of a number, for messages: the file, the line and the element that the number belongs to.

use crate::scene::description::Scene;
use crate::scene::error::Element;
use crate::scene::parameters::place::Place;
use std::path::PathBuf;

impl Place {
    /// The file, line and element that a message about the number is about.
    pub fn stand(&self, scene: &Scene) -> (PathBuf, Option<usize>, Option<Element>) {
        let here = |line: usize, element: Element| (scene.path.clone(), Some(line), Some(element));
        match self {
            Place::Mass { robot, link }
            | Place::CenterOfMass { robot, link, .. }
            | Place::InertiaTurn { robot, link, .. }
            | Place::LinkFriction { robot, link }
            | Place::LinkRestitution { robot, link }
            | Place::LinkMoment { robot, link, .. }
            | Place::LinkSurface { robot, link, .. }
            | Place::Inertia { robot, link, .. } => {
                let robot = &scene.robots[*robot].robot;
                let link = &robot.links[*link];
                let line = link.inertial.as_ref().map_or(link.line, |inertial| inertial.line);
                (robot.path.clone(), Some(line), Some(Element::Link(link.name.clone())))
            }
            Place::Collision { robot, link, shape, .. } => {
                let robot = &scene.robots[*robot].robot;
                let link = &robot.links[*link];
                (robot.path.clone(), Some(link.collisions[*shape].line), Some(Element::Link(link.name.clone())))
            }
            Place::Origin { robot, joint, .. }
            | Place::OriginTurn { robot, joint, .. }
            | Place::Axis { robot, joint, .. }
            | Place::EffortBound { robot, joint }
            | Place::SpeedBound { robot, joint }
            | Place::MimicMultiplier { robot, joint }
            | Place::MimicOffset { robot, joint } => {
                of_joint(scene, *robot, &scene.robots[*robot].robot.joints[*joint].name)
            }
            Place::Position { robot, joint, .. } | Place::Velocity { robot, joint, .. } => {
                of_joint(scene, *robot, joint)
            }
            Place::LowerLimit(of)
            | Place::UpperLimit(of)
            | Place::Restitution(of)
            | Place::Friction(of)
            | Place::Damping(of)
            | Place::Armature(of) => of_joint(scene, of.robot, &of.joint),
            Place::Body { robot, .. } => {
                let robot = &scene.robots[*robot];
                here(robot.line, Element::Body(robot.name.clone()))
            }
            Place::BasePosition { robot, .. } | Place::BaseTurn { robot, .. } | Place::BaseVelocity { robot, .. } => {
                let robot = &scene.robots[*robot];
                here(robot.line, Element::Robot(robot.name.clone()))
            }
            Place::MotionTime { motion, .. }
            | Place::MotionValue { motion, .. }
            | Place::MotionParameter { motion, .. }
            | Place::MotionPosition(motion) => {
                here(scene.motions[*motion].line, Element::Motion(scene.motions[*motion].on.clone()))
            }
            Place::Motor { motor, .. }
            | Place::TargetTime { motor, .. }
            | Place::TargetValue { motor, .. }
            | Place::TargetParameter { motor, .. } => {
                here(scene.motors[*motor].line, Element::Motor(scene.motors[*motor].on.clone()))
            }
            Place::Spring { spring, .. } | Place::SpringEnd { spring, .. } => {
                here(scene.springs[*spring].line, Element::Spring(scene.springs[*spring].name.clone()))
            }
            Place::RopeLength(rope)
            | Place::RopeRestitution(rope)
            | Place::RopeStop(rope)
            | Place::RopeEnd { rope, .. } => {
                here(scene.ropes[*rope].line, Element::Rope(scene.ropes[*rope].name.clone()))
            }
            Place::LoopLength(of) | Place::LoopEnd { of, .. } | Place::LoopAxis { of, .. } => {
                here(scene.loops[*of].line, Element::Loop(scene.loops[*of].name.clone()))
            }
            Place::UrdfLoopAxis { robot, of, .. }
            | Place::UrdfLoopEnd { robot, of, .. }
            | Place::UrdfLoopTurn { robot, of, .. } => {
                let robot = &scene.robots[*robot].robot;
                let closing = &robot.loops[*of];
                (robot.path.clone(), Some(closing.line), Some(Element::Loop(closing.name.clone())))
            }
            Place::CouplingTerm { coupling, .. } | Place::CouplingOffset(coupling) => {
                let of = &scene.couplings[*coupling];
                here(of.line, Element::Coupling(of.name.clone()))
            }
            Place::Drag { drag, .. } | Place::DragPosition { drag, .. } => {
                here(scene.drags[*drag].line, Element::Drag(scene.drags[*drag].on.clone()))
            }
            Place::LoadEffort(load)
            | Place::Load { load, .. }
            | Place::FactorTime { load, .. }
            | Place::FactorValue { load, .. }
            | Place::FactorParameter { load, .. }
            | Place::LoadForce { load, .. }
            | Place::LoadTorque { load, .. }
            | Place::LoadPosition { load, .. } => {
                here(scene.loads[*load].line, Element::Load(scene.loads[*load].on.clone()))
            }
            Place::ObstacleFriction(obstacle)
            | Place::ObstacleRestitution(obstacle)
            | Place::ObstacleMoment { obstacle, .. }
            | Place::ObstacleSurface { obstacle, .. }
            | Place::ObstaclePosition { obstacle, .. }
            | Place::ObstacleTurn { obstacle, .. }
            | Place::ObstacleShape { obstacle, .. }
            | Place::ObstacleNormal { obstacle, .. } => {
                let obstacle = &scene.contact.obstacles[*obstacle];
                (scene.path.clone(), obstacle.line, Some(Element::Obstacle(obstacle.name.clone())))
            }
            Place::PairFriction(rule) | Place::PairRestitution(rule) | Place::PairMoment { rule, .. } => {
                (scene.path.clone(), Some(scene.contact.rules[*rule].line), None)
            }
            Place::Gravity(_)
            | Place::ContactFriction
            | Place::ContactRestitution
            | Place::ContactMoment(_)
            | Place::SelfContact
            | Place::Duration
            | Place::Tolerance
            | Place::Stages
            | Place::Step
            | Place::Rate => (scene.path.clone(), None, None),
        }
    }
}

fn of_joint(scene: &Scene, robot: usize, joint: &str) -> (PathBuf, Option<usize>, Option<Element>) {
    let robot = &scene.robots[robot].robot;
    let line = robot.joints.iter().find(|one| one.name == joint).map(|one| one.line);
    (robot.path.clone(), line, Some(Element::Joint(joint.to_string())))
}
