//! Keyframes of MJCF: positions, velocities, controls and activations of everything, with which a run starts.
//!
//! `qpos` has for a free joint x, y, z and the quaternion, for a ball its quaternion, for others one number. `qvel` has for a free joint the velocity
//! in the world and the angular velocity in the axes of the body, for a ball the angular velocity in its axes, for others one number. The frame of a free
//! joint may be the inertial one ([`super::free_frames`]).

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::orientation::{quaternion, roll_pitch_yaw};
use crate::scene::mjcf_reading::parts::{FreeFrame, Moving};
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::robot::{Pose, UrdfJointKind};
use nalgebra::{Rotation3, Translation3, Vector3};

impl Reader<'_> {
    /// Starts as a keyframe says.
    pub fn start_at(&mut self, key: &Element) -> Result<(), SceneError> {
        let counts = |moving: &Moving| match moving {
            Moving::Free(_) => (7, 6),
            Moving::Joint(_, _, UrdfJointKind::Spherical) => (4, 3),
            Moving::Joint(..) => (1, 1),
        };
        let order = self.order.clone();
        let (nq, nv) = order.iter().map(counts).fold((0, 0), |(nq, nv), (q, v)| (nq + q, nv + v));
        let position = key.list("qpos", nq, nq)?;
        let velocity = key.list("qvel", nv, nv)?;
        let zero = || key.error("qpos", "a quaternion is zero".to_string());
        let (mut at, mut on) = (0, 0);
        let mut unread = Vec::new();
        for moving in &order {
            let (q, v) = counts(moving);
            let position = position.as_ref().map(|all| &all[at..at + q]);
            let velocity = velocity.as_ref().map(|all| &all[on..on + v]);
            (at, on) = (at + q, on + v);
            match moving {
                Moving::Free(tree) => {
                    let tree = &mut self.trees[*tree];
                    let frame = tree.free_frame;
                    if frame == FreeFrame::Unread && (position.is_some() || velocity.is_some()) {
                        unread.push(tree.name.clone());
                    }
                    if let Some(&[x, y, z, ref turn @ ..]) = position {
                        let turn = quaternion(turn).ok_or_else(zero)?;
                        tree.pose = frame.body_at(&Pose::from_parts(Translation3::new(x, y, z), turn));
                    }
                    if let Some(&[vx, vy, vz, wx, wy, wz]) = velocity {
                        let (velocity, spin) = (Vector3::new(vx, vy, vz), Vector3::new(wx, wy, wz));
                        tree.velocity = Some(frame.velocity_of(&tree.pose, velocity, spin));
                    }
                }
                Moving::Joint(tree, name, UrdfJointKind::Spherical) => {
                    let turn = position.map_or(Some(Rotation3::identity()), quaternion).ok_or_else(zero)?;
                    if position.is_some() {
                        self.positions.push((*tree, name.clone(), roll_pitch_yaw(&turn).to_vec()));
                    }
                    if let Some(&[x, y, z]) = velocity {
                        let spin = turn * Vector3::new(x, y, z);
                        self.velocities.push((*tree, name.clone(), spin.as_slice().to_vec()));
                    }
                }
                Moving::Joint(tree, name, _) => {
                    let reference = self.references.get(name).map_or(0.0, |(_, reference)| *reference);
                    let own = |all: &[f64]| all.first().copied().unwrap_or_default();
                    self.positions.extend(position.map(|q| (*tree, name.clone(), vec![own(q) - reference])));
                    self.velocities.extend(velocity.map(|v| (*tree, name.clone(), vec![own(v)])));
                }
            }
        }
        for body in unread {
            let message = format!(
                "the keyframe gives the inertial frame of body {body:?}, as align or alignfree says; it is read as the frame of the body"
            );
            self.odd(key, message);
        }
        if let Some(controls) = key.list("ctrl", self.controls, self.controls)? {
            for (number, motor) in &mut self.motors {
                if let Some(control) = controls.get(*number) {
                    motor.control = *control;
                }
            }
        }
        if let Some(given) = key.list("act", self.activations, self.activations)? {
            for activation in self.motors.iter_mut().filter_map(|(_, motor)| motor.activation.as_mut()) {
                activation.start = given.get(activation.number).copied().unwrap_or_default();
            }
        }
        if key.text("mpos").is_some() {
            self.odd(key, "its mpos and mquat are not read".to_string());
        }
        Ok(())
    }
}
