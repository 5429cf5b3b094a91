//! The rotors of joints: `armature` of a [[joint]] in a scene file, else what the URDF says.

use crate::model::coupling::builder::Builder;
use crate::scene::{Warning, WarningGroup};

impl Builder<'_> {
    /// The body and the armature [kg m² or kg] of every joint with a rotor.
    pub(crate) fn rotors(&self, warnings: &mut Vec<Warning>) -> Vec<(usize, f64)> {
        let mut rotors = Vec::new();
        let mut unsimulated = Vec::new();
        for of in self.urdf_joints() {
            let said = self.said(of.robot, &of.joint.name).and_then(|said| said.armature);
            let armature = said.or(of.joint.armature).unwrap_or(0.0);
            match of.coordinate(self) {
                Some(coordinate) if armature > 0.0 => rotors.push((coordinate.body, armature)),
                None if armature > 0.0 && of.moves() => {
                    let message =
                        "its armature is not simulated: only joints that turn about or slide along an axis have rotors";
                    unsimulated.push(of.stand().warning(message).in_group(WarningGroup::NotSimulated));
                }
                _ => {}
            }
        }
        warnings.extend(Warning::of_kind(unsimulated, "joint", "joints"));
        rotors
    }
}
