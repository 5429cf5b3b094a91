//! Motors with `gravity_compensation`: an effort besides the law of the motor holds a part of the weight beyond its joint.
//!
//! A joint that follows the joint of the motor adds its own weight: the relation hands the effort on. A loop around a joint makes the share of the
//! joint ambiguous, and is refused.

use crate::mechanism::description::closure::LoopJoint;
use crate::mechanism::description::forces::GravityCompensation;
use crate::model::coupling::builder::Builder;
use crate::model::description::coupling_error::CouplingProblem;
use crate::model::description::model_error::ModelError;
use crate::scene::Element;

impl Builder<'_> {
    /// The efforts that hold weights, each joint once.
    ///
    /// # Errors
    /// [`ModelError::Coupling`] with the line of the motor, for a joint in a loop.
    pub(crate) fn gravity_compensations(&self, loops: &[LoopJoint]) -> Result<Vec<GravityCompensation>, ModelError> {
        let mechanism = &self.model.mechanism;
        let mut all: Vec<GravityCompensation> = Vec::new();
        let motors = self.scene.iter().flat_map(|scene| &scene.motors);
        for motor in motors.filter(|motor| motor.gravity_compensation > 0.0) {
            let record = self.record(motor.joint.robot, &motor.joint.joint);
            if motor.lenient && record.is_none_or(|record| record.body.is_none()) {
                continue;
            }
            let stand = self.stand(motor.line, Element::Motor(motor.on.clone()));
            let mut joints = vec![self.coordinate(motor.joint.robot, &motor.joint.joint, &stand)?];
            let mut next = 0;
            while let Some(&leader) = joints.get(next) {
                let simple = mechanism.mimics.iter().filter(|mimic| mimic.more.is_empty() && mimic.leader == leader);
                for follower in simple.map(|mimic| mimic.follower) {
                    if !joints.contains(&follower) {
                        joints.push(follower);
                    }
                }
                next += 1;
            }
            for joint in joints {
                let inside = mechanism.subtree(joint.body);
                let is_beyond = |body: Option<usize>| body.is_some_and(|body| inside.contains(&body));
                if let Some(closing) = loops.iter().find(|of| is_beyond(of.a.body) != is_beyond(of.b.body)) {
                    let joint = mechanism.bodies[joint.body].joint.name.clone();
                    return Err(stand.refuse(CouplingProblem::WeightInLoop { joint, closing: closing.name.clone() }));
                }
                if all.iter().all(|other| other.freedom != joint.freedom) {
                    all.push(GravityCompensation { freedom: joint.freedom, factor: motor.gravity_compensation });
                }
            }
        }
        Ok(all)
    }
}
