//! Joints that a `[[motion]]` moves in time, as equations `q − r(t) = 0`.
//!
//! Limits and dry friction of such a joint, and of joints that follow it, change only the effort of the drive. They are left out with a warning.

use crate::mechanism::description::closure::Mimic;
use crate::model::coupling::builder::{Builder, UrdfJointOf};
use crate::model::description::model_error::ModelError;
use crate::scene::{Element, Warning, WarningGroup};

impl Builder<'_> {
    /// The equations of all moved joints.
    ///
    /// # Errors
    /// [`ModelError::Coupling`] with the line, for a joint without the one coordinate that it is about.
    pub(crate) fn motions(&self) -> Result<Vec<Mimic>, ModelError> {
        let all = self.scene.iter().flat_map(|scene| &scene.motions);
        let equations = all.map(|motion| {
            let stand = self.stand(motion.line, Element::Motion(motion.on.clone()));
            let joint = self.coordinate(motion.joint.robot, &motion.joint.joint, &stand)?;
            Ok(Mimic::moved(motion.on.clone(), joint, motion.position.clone()))
        });
        equations.collect()
    }

    /// Whether a joint is moved in time, or follows one that is.
    pub(crate) fn is_moved(&self, of: &UrdfJointOf) -> bool {
        let motions = self.scene.map_or(&[][..], |scene| &scene.motions);
        if motions.is_empty() {
            return false;
        }
        let joints = &self.model.robots[of.robot].robot.joints;
        let mut joint = Some(of.joint);
        // Chains of leaders are no longer than the list of joints.
        for _ in 0..=joints.len() {
            let Some(own) = joint else { return false };
            if motions.iter().any(|motion| motion.joint.robot == of.robot && motion.joint.joint == own.name) {
                return true;
            }
            joint = own.mimic.as_ref().and_then(|mimic| joints.iter().find(|other| other.name == mimic.joint));
        }
        false
    }

    /// The warning that something of a moved joint is left out.
    pub(crate) fn left_out(&self, of: &UrdfJointOf, what: &str) -> Warning {
        let message = format!("its {what} not simulated, because a [[motion]] moves it");
        of.stand().warning(&message).in_group(WarningGroup::NotSimulated)
    }
}
