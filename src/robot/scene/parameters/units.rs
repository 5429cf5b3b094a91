//! The units that a number of a scene may be given in: angles and their rates, as its table in the scene file has it.

use crate::mechanism::description::nonsmooth::MotorLaw;
use crate::scene::coupling::{JointReference, SpringPlace};
use crate::scene::description::Scene;
use crate::scene::error::SceneError;
use crate::scene::parameters::Parameter;
use crate::scene::parameters::place::{MotorNumber, Place, ShapeNumber, SpringNumber};
use crate::scene::scene_reading::scene_numbers::{Quantity, Unit};

impl Scene {
    /// A number for a key path in SI units, from one that may have the unit of an angle.
    ///
    /// # Errors
    /// [`Problem::ParameterValue`](crate::scene::Problem::ParameterValue) for a unit that the number cannot have.
    pub fn number_of(&self, parameter: &Parameter, given: Quantity) -> Result<f64, SceneError> {
        given.of(parameter.place.unit(self)).map_err(|reason| self.refusal(parameter, given.number, reason))
    }
}

impl Place {
    /// The unit of the number at this place, if it is an angle or its rate.
    fn unit(&self, scene: &Scene) -> Unit {
        let rate_of = |is_angle: bool| if is_angle { Unit::AngleRate } else { Unit::Unwritten };
        let angle_of = |is_angle: bool| if is_angle { Unit::Angle } else { Unit::Unwritten };
        let named = |robot: usize, joint: &str, number: usize| {
            let joints = scene.robots.get(robot).map_or(&[][..], |of| &of.robot.joints);
            joints.iter().find(|one| one.name == joint).is_some_and(|one| one.kind.is_angle(number))
        };
        let turns = |of: &JointReference| named(of.robot, &of.joint, 0);
        match self {
            Place::BaseTurn { .. }
            | Place::InertiaTurn { .. }
            | Place::OriginTurn { .. }
            | Place::UrdfLoopTurn { .. }
            | Place::ObstacleTurn { .. }
            | Place::Collision { what: ShapeNumber::Turn(_), .. } => Unit::Angle,
            Place::BaseVelocity { number, .. } => rate_of(*number >= 3),
            Place::Position { robot, joint, number, .. } => angle_of(named(*robot, joint, *number)),
            Place::Velocity { robot, joint, number, .. } => rate_of(named(*robot, joint, *number)),
            Place::LowerLimit(of) | Place::UpperLimit(of) => angle_of(turns(of)),
            Place::SpeedBound { robot, joint } => {
                let joint = scene.robots.get(*robot).and_then(|of| of.robot.joints.get(*joint));
                rate_of(joint.is_some_and(|joint| joint.kind.is_angle(0)))
            }
            Place::Motor { motor, what: MotorNumber::Target } | Place::TargetValue { motor, .. } => {
                let motor = scene.motors.get(*motor);
                match motor.map(|motor| (motor.law, turns(&motor.joint))) {
                    Some((MotorLaw::Position { .. }, is_angle)) => angle_of(is_angle),
                    Some((MotorLaw::Velocity { .. }, is_angle)) => rate_of(is_angle),
                    _ => Unit::Unwritten,
                }
            }
            Place::MotionPosition(motion) | Place::MotionValue { motion, .. } => {
                angle_of(scene.motions.get(*motion).is_some_and(|motion| turns(&motion.joint)))
            }
            Place::Spring { spring, what: SpringNumber::Rest } => {
                match scene.springs.get(*spring).map(|spring| &spring.place) {
                    Some(SpringPlace::Joint { joint, .. }) => angle_of(turns(joint)),
                    _ => Unit::Unwritten,
                }
            }
            _ => Unit::Unwritten,
        }
    }
}
