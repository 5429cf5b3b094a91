//! Motors of scene files; dry friction, largest efforts and largest speeds of URDF files.

use crate::mechanism::description::nonsmooth::{DryFriction, Motor, SpeedLimit};
use crate::model::coupling::builder::Builder;
use crate::model::description::at_start::AtStart;
use crate::model::description::model_error::ModelError;
use crate::scene::{Element, SceneMotor, Warning, WarningGroup};

impl Builder<'_> {
    /// The dry friction of `<dynamics friction>`, or what a `[[joint]]` says instead.
    pub(crate) fn friction(&self, warnings: &mut Vec<Warning>) -> Vec<DryFriction> {
        let mut all = Vec::new();
        let (mut unsimulated, mut moved) = (Vec::new(), Vec::new());
        for of in self.urdf_joints() {
            let of_urdf = of.joint.dynamics.map_or(0.0, |dynamics| dynamics.friction);
            let effort = self.said(of.robot, &of.joint.name).and_then(|said| said.friction).unwrap_or(of_urdf);
            match of.coordinate(self) {
                Some(_) if effort > 0.0 && self.is_moved(&of) => moved.push(self.left_out(&of, "friction is")),
                Some(coordinate) if effort > 0.0 => all.push(DryFriction { coordinate, effort }),
                None if effort > 0.0 && of.moves() => {
                    let message = "its friction is not simulated: only joints that turn about or slide along an axis have friction";
                    unsimulated.push(of.stand().warning(message).in_group(WarningGroup::NotSimulated));
                }
                _ => {}
            }
        }
        warnings.extend(Warning::of_kind(unsimulated, "joint", "joints"));
        warnings.extend(Warning::of_kind(moved, "joint", "joints"));
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

    /// The motors of the scene file, and what those among them aim at that aim at the start.
    ///
    /// # Errors
    /// [`ModelError::Coupling`] with the line, for a joint that has not one freedom.
    pub(crate) fn motors(&self, unbounded: &mut Vec<Warning>) -> Result<(Vec<Motor>, Vec<AtStart>), ModelError> {
        let (mut motors, mut at_start) = (Vec::new(), Vec::new());
        for given in self.scene.iter().flat_map(|scene| &scene.motors) {
            let record = self.record(given.joint.robot, &given.joint.joint);
            if given.lenient && record.is_none_or(|record| record.body.is_none()) {
                continue;
            }
            if given.at_start {
                at_start.push(AtStart { motor: motors.len(), frequency: given.frequency });
            }
            motors.push(self.motor(given, unbounded)?);
        }
        Ok((motors, at_start))
    }

    /// A motor of the scene file, and a warning if its bound is read as unbounded.
    fn motor(&self, motor: &SceneMotor, unbounded: &mut Vec<Warning>) -> Result<Motor, ModelError> {
        let stand = self.stand(motor.line, Element::Motor(motor.on.clone()));
        let coordinate = self.coordinate(motor.joint.robot, &motor.joint.joint, &stand)?;
        let joints = &self.model.robots[motor.joint.robot].robot.joints;
        let joint = joints.iter().find(|joint| joint.name == motor.joint.joint);
        // effort="0" is what writers of URDFs leave where they know of no bound, because URDF asks for the attribute.
        let written = joint.and_then(|joint| joint.limit?.effort);
        let of_urdf = written.filter(|effort| *effort > 0.0);
        if motor.max_effort.is_none() && written == Some(0.0) {
            let message = "the effort=\"0\" of its joint in the URDF file is read as no bound; max_effort in this [[motor]] sets one";
            unbounded.push(stand.warning(message));
        }
        Ok(Motor {
            coordinate,
            law: motor.law,
            target: motor.target.clone(),
            max_effort: motor.max_effort.or(of_urdf).unwrap_or(f64::INFINITY),
            period: motor.period,
            held: None,
        })
    }
}
