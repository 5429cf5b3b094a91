//! Motors of scene files; dry friction, largest efforts and largest speeds of URDF files.

use crate::mechanism::description::nonsmooth::{DryFriction, Motor, SpeedLimit};
use crate::model::coupling::builder::Builder;
use crate::model::description::model_error::ModelError;
use crate::scene::{Element, SceneMotor, Warning, WarningGroup};

impl Builder<'_> {
    /// The dry friction of `<dynamics friction>`, or what a `[[joint]]` says instead.
    pub(crate) fn friction(&self, warnings: &mut Vec<Warning>) -> Vec<DryFriction> {
        let mut all = Vec::new();
        let mut unsimulated = Vec::new();
        for of in self.urdf_joints() {
            let of_urdf = of.joint.dynamics.map_or(0.0, |dynamics| dynamics.friction);
            let effort = self.said(of.robot, &of.joint.name).and_then(|said| said.friction).unwrap_or(of_urdf);
            match of.coordinate(self) {
                Some(coordinate) if effort > 0.0 => all.push(DryFriction { coordinate, effort }),
                None if effort > 0.0 && of.moves() => {
                    let message = "its friction is not simulated: only joints that turn about or slide along an axis have friction";
                    unsimulated.push(of.stand().warning(message).in_group(WarningGroup::NotSimulated));
                }
                _ => {}
            }
        }
        warnings.extend(Warning::of_kind(unsimulated, "joint", "joints"));
        all
    }

    /// The speeds of `<limit velocity>`, which are watched. A zero stands for an unknown speed in many URDFs, and is left out.
    pub(crate) fn speeds(&self) -> Vec<SpeedLimit> {
        let speeds = self.urdf_joints().filter_map(|of| {
            let speed = of.joint.limit?.velocity.filter(|speed| *speed > 0.0 && speed.is_finite())?;
            Some(SpeedLimit { coordinate: of.coordinate(self)?, speed })
        });
        speeds.collect()
    }

    /// A motor of the scene file.
    ///
    /// # Errors
    /// [`ModelError::Coupling`] with the line, for a joint that has not one freedom.
    pub(crate) fn motor(&self, motor: &SceneMotor) -> Result<Motor, ModelError> {
        let stand = self.stand(motor.line, Element::Motor(motor.on.clone()));
        let coordinate = self.coordinate(motor.joint.robot, &motor.joint.joint, &stand)?;
        let joints = &self.model.robots[motor.joint.robot].robot.joints;
        let joint = joints.iter().find(|joint| joint.name == motor.joint.joint);
        // effort="0" is what writers of URDFs leave where they know of no bound, because URDF asks for the attribute.
        let of_urdf = joint.and_then(|joint| joint.limit?.effort).filter(|effort| *effort > 0.0);
        Ok(Motor {
            coordinate,
            law: motor.law,
            target: motor.target.clone(),
            max_effort: motor.max_effort.or(of_urdf).unwrap_or(f64::INFINITY),
            period: motor.period,
        })
    }
}
