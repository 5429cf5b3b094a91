//! Rotors and damping of actuators of MJCF belong to the joint that an actuator drives with the gear G:
//!
//! ```text
//!     inertia + G² a [kg m² or kg],   damping + G² d [N m s/rad or N s/m]
//! ```
//!
//! with the actuator's `armature` a and `damping` d, whatever the range of its force is.
//!
//! Source: MuJoCo documentation, XML reference, `actuator`, and what MuJoCo 4.0 computes.

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::robot::UrdfJointKind;

impl Reader<'_> {
    /// Adds the rotors and the damping of an `<actuator>` to the joints.
    pub fn add_rotors(&mut self, actuators: &Element) -> Result<(), SceneError> {
        for given in &actuators.children {
            let (actuator, _) = self.defaults.actuator(given)?;
            let damping = self.linear(&actuator, "damping")?.unwrap_or(0.0);
            let armature = actuator.number("armature")?.unwrap_or(0.0);
            if damping == 0.0 && armature == 0.0 {
                continue;
            }
            let gear = actuator.list("gear", 1, 6)?.map_or(1.0, |gear| gear[0]);
            let name = actuator.text("joint").or_else(|| actuator.text("jointinparent"));
            let joints =
                self.trees.iter_mut().flat_map(|tree| &mut tree.joints).filter_map(|(_, joint)| joint.as_mut());
            let has_axis = |kind| kind != UrdfJointKind::Spherical;
            match joints.into_iter().find(|joint| Some(joint.name.as_str()) == name && has_axis(joint.kind)) {
                Some(joint) => {
                    joint.damping += gear * gear * damping;
                    joint.armature += gear * gear * armature;
                }
                None => {
                    let message =
                        "armature and damping of actuators on anything but hinges and slides are not simulated";
                    self.not_simulated(&actuator, message.to_string());
                }
            }
        }
        Ok(())
    }
}
