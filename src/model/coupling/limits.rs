//! The limits of joints, from `<limit lower upper>`, or from a `[[joint]]` of the scene file instead.

use crate::mechanism::description::closure::JointLimit;
use crate::model::coupling::builder::Builder;
use crate::model::description::model_error::ModelError;
use crate::scene::{Element, LimitChoice, SceneJoint, SceneRope, UrdfJoint, UrdfJointKind, Warning};

impl Builder<'_> {
    /// The settings of the scene file for a joint.
    pub(crate) fn said(&self, robot: usize, joint: &str) -> Option<&SceneJoint> {
        let joints = self.scene.map_or(&[][..], |scene| &scene.joints);
        joints.iter().find(|said| said.joint.robot == robot && said.joint.joint == joint)
    }

    /// Refuses a `[[joint]]` for a joint without the one coordinate that it is about.
    ///
    /// # Errors
    /// [`ModelError::Coupling`] with the line and the joint.
    pub(crate) fn check_scene_joints(&self) -> Result<(), ModelError> {
        for said in self.scene.iter().flat_map(|scene| &scene.joints) {
            let stand = self.stand(said.line, Element::Joint(said.name.clone()));
            self.coordinate(said.joint.robot, &said.joint.joint, &stand)?;
        }
        Ok(())
    }

    /// The limits of the winches of ropes: the motion of a winch that leaves them is refused.
    pub(crate) fn limits_of_winches(&self) -> Vec<JointLimit> {
        let ropes = self.scene.map_or(&[][..], |scene| &scene.ropes);
        let limit = |rope: &SceneRope| {
            let joint = rope.winch.as_ref()?;
            let stand = self.stand(rope.line, Element::Rope(rope.name.clone()));
            let coordinate = self.coordinate(joint.robot, &joint.joint, &stand).ok()?;
            Some(JointLimit { coordinate, lower: 0.0, upper: rope.length, restitution: 0.0 })
        };
        ropes.iter().filter_map(limit).collect()
    }

    /// The limits of all joints that turn about or slide along an axis.
    pub(crate) fn limits(&self, warnings: &mut Vec<Warning>) -> Vec<JointLimit> {
        let mut limits = Vec::new();
        let (mut empty, mut idle, mut moved) = (Vec::new(), Vec::new(), Vec::new());
        for of in self.urdf_joints() {
            let joint = of.joint;
            let Some(coordinate) = of.coordinate(self) else { continue };
            let said = self.said(of.robot, &joint.name);
            if self.is_moved(&of) {
                let has_limits = said.is_some_and(|said| said.limit.is_some()) || joint.own_limits().is_some();
                moved.extend(has_limits.then(|| self.left_out(&of, "limits are")));
                continue;
            }
            let range = match said.and_then(|said| said.limit) {
                Some(LimitChoice::Unlimited) => None,
                Some(LimitChoice::Range(lower, upper)) => {
                    (lower.is_finite() || upper.is_finite()).then_some((lower, upper))
                }
                None => {
                    empty.extend(empty_range(joint).map(|message| of.stand().warning(message)));
                    joint.own_limits()
                }
            };
            let restitution = said.and_then(|said| said.restitution);
            match (range, restitution) {
                (Some((lower, upper)), restitution) => {
                    limits.push(JointLimit { coordinate, lower, upper, restitution: restitution.unwrap_or(0.0) });
                }
                (None, Some(_)) => {
                    let line = said.map_or(joint.line, |said| said.line);
                    let stand = self.stand(line, Element::Joint(joint.name.clone()));
                    idle.push(stand.warning("its restitution does nothing, because it has no limits; give it a limit"));
                }
                (None, None) => {}
            }
        }
        warnings.extend(Warning::of_kind(empty, "joint", "joints"));
        warnings.extend(idle);
        warnings.extend(Warning::of_kind(moved, "joint", "joints"));
        limits
    }
}

/// The warning of a `<limit>` without a lower and an upper limit, or with both at zero.
fn empty_range(joint: &UrdfJoint) -> Option<&'static str> {
    let limit = joint.limit.filter(|_| matches!(joint.kind, UrdfJointKind::Revolute | UrdfJointKind::Prismatic))?;
    match (limit.lower, limit.upper) {
        (None, None) => Some("its <limit> has neither lower nor upper, so it has no limits; write both if it has"),
        (Some(lower), Some(upper)) if lower == 0.0 && upper == 0.0 => Some(
            "its <limit> has lower = upper = 0, which is taken for no limits; to lock it write limit = [0, 0] in a [[joint]] \
             of a scene file, or make it fixed",
        ),
        _ => None,
    }
}
