//! The [`State`] of reported joint coordinates: the inverse of [`Model::joint_user_coordinates`].

use crate::mechanism::description::joint::{Pose, rotation_from_wxyz, wxyz_from_rotation};
use crate::mechanism::motion::state::State;
use crate::model::description::robot_model::Model;
use crate::scene::UrdfJointKind;
use nalgebra::{Rotation3, Translation3, Vector3};

impl Model {
    /// The state in which the joints report these positions and velocities. `None` if the report lacks a joint that moves, or the joint has other
    /// counts of numbers.
    pub fn state_of_report<'r>(
        &self,
        time: f64,
        joints: impl Fn(&str) -> Option<(&'r [f64], &'r [f64])>,
    ) -> Option<State> {
        let mut state = self.zero_state();
        state.time = time;
        for record in &self.joints {
            let Some(body) = record.body else { continue };
            let (position, velocity) = joints(&record.name)?;
            let joint = &self.mechanism.bodies[body].joint;
            let (q, w) = match (record.kind, position, velocity) {
                (UrdfJointKind::Spherical, &[qw, qx, qy, qz], &[x, y, z]) => {
                    let turn = rotation_from_wxyz(&[qw, qx, qy, qz]);
                    (vec![qw, qx, qy, qz], (turn.transpose() * Vector3::new(x, y, z)).as_slice().to_vec())
                }
                (UrdfJointKind::Floating, &[x, y, z, qw, qx, qy, qz], &[vx, vy, vz, wx, wy, wz]) => {
                    let turn = Rotation3::from_matrix_unchecked(rotation_from_wxyz(&[qw, qx, qy, qz]));
                    let link = Pose::from_parts(Translation3::new(x, y, z), turn);
                    let at_body = link * record.child_link_in_body.inverse();
                    let omega = Vector3::new(wx, wy, wz);
                    let arm = at_body.translation.vector - link.translation.vector;
                    let linear = Vector3::new(vx, vy, vz) + omega.cross(&arm);
                    let spin = at_body.rotation.transpose() * omega;
                    let numbers = at_body.translation.vector.iter().copied();
                    let numbers = numbers.chain(wxyz_from_rotation(at_body.rotation.matrix()));
                    (numbers.collect(), linear.iter().chain(spin.iter()).copied().collect())
                }
                _ => (position.to_vec(), velocity.to_vec()),
            };
            let (positions, velocities) = (joint.position_range(), joint.velocity_range());
            if q.len() != positions.len() || w.len() != velocities.len() {
                return None;
            }
            state.position[positions].copy_from_slice(&q);
            state.velocity[velocities].copy_from_slice(&w);
        }
        Some(state)
    }

    /// The reported coordinates of a joint of several numbers, of which the log has a transform (translation, quaternion
    /// w, x, y, z) and a twist (linear, angular); `None` if there is no such joint.
    pub fn coordinates_of_transform(
        &self,
        joint: &str,
        (at, turn): &([f64; 3], [f64; 4]),
        (linear, angular): &([f64; 3], [f64; 3]),
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let record = &self.joints[self.joint(joint)?];
        match record.kind {
            UrdfJointKind::Spherical => Some((turn.to_vec(), angular.to_vec())),
            UrdfJointKind::Floating => Some(([&at[..], turn].concat(), [linear, angular.as_slice()].concat())),
            UrdfJointKind::Planar => {
                // The turn is about z.
                let angle = 2.0 * turn[3].atan2(turn[0]);
                Some((vec![at[0], at[1], angle], vec![linear[0], linear[1], angular[2]]))
            }
            _ => None,
        }
    }
}
