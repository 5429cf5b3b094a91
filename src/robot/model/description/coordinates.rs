//! Between the user's joint coordinates and the [`State`].
//!
//! | URDF type                       | position given          | position reported        | velocity             |
//! |---------------------------------|-------------------------|--------------------------|----------------------|
//! | revolute, continuous, prismatic | displacement            | the same                 | rate                 |
//! | planar                          | x, y, angle             | the same                 | rates                |
//! | spherical                       | roll, pitch, yaw        | quaternion w, x, y, z    | wx, wy, wz           |
//! | floating                        | x, y, z, roll, pitch, yaw | x, y, z, quaternion    | vx, vy, vz, wx, wy, wz |
//!
//! A position may be given as it is reported, too: with a quaternion, of any length but zero, for the turn.
//!
//! Everything is in the joint's frame on the parent. The numbers of a floating joint belong to the child *link* frame and its origin, whereas the
//! state holds the pose of the body's principal frame. Let `L` be the child link frame in the body:
//!
//! ```text
//!     X_body = X_link L⁻¹        v_body = v_link + ω × (p_body − p_link)        w = Rⱼᵀ ω        [m, m/s, rad/s]
//! ```

use crate::mechanism::description::closure::{Coordinate, Mimic};
use crate::mechanism::description::joint::{Pose, rotation_from_wxyz, wxyz_from_rotation};
use crate::mechanism::motion::state::State;
use crate::model::description::followers::Followed;
use crate::model::description::model_error::ModelError;
use crate::model::description::robot_model::{JointRecord, Model};
use crate::scene::UrdfJointKind;
use nalgebra::{Rotation3, Translation3, Vector3, Vector4};

/// The largest angle that a joint may start with (rad). There the next double is 1.5e-8 rad away, as far as anyone may want a
/// joint to be placed; much further out no step is short enough for the roundings.
const LARGEST_ANGLE: f64 = 1e8;

/// A moved joint may start this far from its motion [m, rad, m/s, rad/s], or this part of a larger number: runs keep to motions much better, and a
/// number of a program or of a file is rounded to 1e-12 and better.
const ON_MOTION: f64 = 1e-9;

/// A joint's reported position (at most a pose, seven numbers) and velocity (at most a twist, six).
#[derive(Clone, Copy, Debug, Default)]
pub struct JointCoordinates {
    position: [f64; 7],
    velocity: [f64; 6],
    counts: (usize, usize),
}

impl JointCoordinates {
    fn new(position: &[f64], velocity: &[f64]) -> Self {
        let mut coordinates = JointCoordinates { counts: (position.len(), velocity.len()), ..Self::default() };
        coordinates.position[..position.len()].copy_from_slice(position);
        coordinates.velocity[..velocity.len()].copy_from_slice(velocity);
        coordinates
    }

    /// Lengths and angles (m, rad), a quaternion as w, x, y, z, or a pose x, y, z, w, x, y, z.
    pub fn position(&self) -> &[f64] {
        &self.position[..self.counts.0]
    }

    /// Rates [m/s, rad/s]; of a pose the linear velocity, then the angular.
    pub fn velocity(&self) -> &[f64] {
        &self.velocity[..self.counts.1]
    }
}

impl Model {
    /// Every joint at zero displacement (as the URDF defines it), a floating base at its pose, at rest.
    pub fn zero_state(&self) -> State {
        let mut state = State::zero(&self.mechanism);
        for record in self.joints.iter().filter(|record| record.kind == UrdfJointKind::Floating) {
            let Some(body) = record.body else { continue };
            let link = if record.is_base { self.robots[record.robot].base_pose } else { Pose::identity() };
            let range = self.mechanism.bodies[body].joint.position_range();
            state.position[range].copy_from_slice(&pose_numbers(&(link * record.child_link_in_body.inverse())));
        }
        state
    }

    /// The state at time zero with the given joint positions and velocities ([`Model::initial_state_at`]).
    ///
    /// # Errors
    /// As of [`Model::initial_state_at`].
    pub fn initial_state(
        &self,
        positions: &[(String, Vec<f64>)],
        velocities: &[(String, Vec<f64>)],
        base_velocity: Option<[f64; 6]>,
    ) -> Result<State, ModelError> {
        self.initial_state_at(0.0, positions, velocities, base_velocity)
    }

    /// The state at a time (s) with the given joint positions and velocities (user coordinates). Joints that mimic given ones follow them
    /// ([`crate::model::description::followers`]), locked joints are in their only position, joints that are moved in time are where they are then, and
    /// the rest is at zero. `base_velocity` is the velocity of the floating root link's frame origin, in the world (linear, angular).
    ///
    /// # Errors
    /// [`ModelError`] for joints that do not exist or do not move, for wrong counts of numbers, for angles without digits, and for moved joints that
    /// are given numbers off their motions.
    pub fn initial_state_at(
        &self,
        time: f64,
        positions: &[(String, Vec<f64>)],
        velocities: &[(String, Vec<f64>)],
        base_velocity: Option<[f64; 6]>,
    ) -> Result<State, ModelError> {
        let mut state = self.zero_state();
        state.time = time;
        let mut given = vec![false; self.mechanism.bodies.len()];
        for (name, values) in positions {
            let (record, body) = self.moving_joint(name)?;
            self.set_position(&mut state, record, values)?;
            given[body] = true;
        }
        for limit in self.mechanism.nonsmooth.limits.iter().filter(|limit| limit.lower == limit.upper) {
            // A locked joint that was not given is in its only position.
            if !std::mem::replace(&mut given[limit.coordinate.body], true) {
                state.position[limit.coordinate.position] = limit.lower;
            }
        }
        let mimics = &self.mechanism.mimics;
        let moved = || mimics.iter().filter(|mimic| mimic.is_moved());
        for mimic in moved() {
            let is_given = std::mem::replace(&mut given[mimic.follower.body], true);
            put_on_motion(mimic, is_given, &mut state.position[mimic.follower.position], mimic.motion(time, time)[0])?;
        }
        let place = |of: Coordinate| of.position;
        Followed { values: &mut state.position, place, offsets: true }.decide(mimics, given);
        let mut given = vec![false; self.mechanism.bodies.len()];
        if let Some(velocity) = base_velocity {
            let base = self.joints.first().filter(|record| self.is_base(record)).ok_or(ModelError::BaseDoesNotFloat)?;
            // The base joint's frame is the world.
            self.set_velocity(&mut state, base, &velocity)?;
        }
        for (name, values) in velocities {
            let (record, body) = self.moving_joint(name)?;
            self.set_velocity(&mut state, record, values)?;
            given[body] = true;
        }
        for mimic in moved() {
            let is_given = std::mem::replace(&mut given[mimic.follower.body], true);
            put_on_motion(mimic, is_given, &mut state.velocity[mimic.follower.freedom], mimic.motion(time, time)[1])?;
        }
        let place = |of: Coordinate| of.freedom;
        Followed { values: &mut state.velocity, place, offsets: false }.decide(mimics, given);
        Ok(state)
    }

    /// Puts the joints that are moved in time where they are at the time of a state, to the last bit.
    ///
    /// # Errors
    /// [`ModelError::Moved`] for a joint that is elsewhere by more than roundings.
    pub fn keep_to_motions(&self, state: &mut State) -> Result<(), ModelError> {
        let time = state.time;
        self.mechanism.mimics.iter().filter(|mimic| mimic.is_moved()).try_for_each(|mimic| {
            let [place, rate, _] = mimic.motion(time, time);
            put_on_motion(mimic, true, &mut state.position[mimic.follower.position], place)?;
            put_on_motion(mimic, true, &mut state.velocity[mimic.follower.freedom], rate)
        })
    }

    /// A joint's reported position and velocity, from the position and velocity vectors of a state. Empty for joints
    /// that do not move.
    pub fn joint_user_coordinates(&self, joint: usize, position: &[f64], velocity: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let coordinates = self.joint_coordinates(joint, position, velocity);
        (coordinates.position().to_vec(), coordinates.velocity().to_vec())
    }

    /// The same. Does not allocate.
    pub fn joint_coordinates(&self, joint: usize, position: &[f64], velocity: &[f64]) -> JointCoordinates {
        let record = &self.joints[joint];
        let Some(body) = record.body else { return JointCoordinates::default() };
        let joint = &self.mechanism.bodies[body].joint;
        let (q, w) = (&position[joint.position_range()], &velocity[joint.velocity_range()]);
        match record.kind {
            UrdfJointKind::Spherical => {
                let omega = rotation_from_wxyz(q) * Vector3::new(w[0], w[1], w[2]);
                JointCoordinates::new(&with_positive_w(q), omega.as_slice())
            }
            UrdfJointKind::Floating => {
                let body_pose = pose_from_numbers(q);
                let link_pose = body_pose * record.child_link_in_body;
                let omega = body_pose.rotation * Vector3::new(w[3], w[4], w[5]);
                let arm = link_pose.translation.vector - body_pose.translation.vector;
                let linear = Vector3::new(w[0], w[1], w[2]) + omega.cross(&arm);
                let twist = [linear.x, linear.y, linear.z, omega.x, omega.y, omega.z];
                JointCoordinates::new(&pose_numbers(&link_pose), &twist)
            }
            _ => JointCoordinates::new(q, w),
        }
    }

    /// Whether a record belongs to the floating base.
    pub fn is_base(&self, record: &JointRecord) -> bool {
        record.is_base
    }

    /// The record and body of a joint that moves.
    fn moving_joint(&self, name: &str) -> Result<(&JointRecord, usize), ModelError> {
        let known = || self.moving_joints().map(str::to_string).collect();
        let Some(record) = self.joints.iter().find(|record| record.name == name) else {
            return Err(ModelError::UnknownJoint { joint: name.to_string(), known: known() });
        };
        let reason = if record.kind == UrdfJointKind::Fixed { "it is fixed" } else { "nothing beyond it has mass" };
        match record.body {
            Some(body) => Ok((record, body)),
            None => Err(ModelError::JointDoesNotMove {
                joint: name.to_string(),
                reason: reason.to_string(),
                known: known(),
            }),
        }
    }

    /// Puts a joint at a position.
    pub fn set_position(&self, state: &mut State, record: &JointRecord, values: &[f64]) -> Result<(), ModelError> {
        check_numbers("position", record, position_names(record.kind), values)?;
        refuse_endless_turns(record, values)?;
        let Some(body) = record.body else { return Ok(()) };
        let position = &mut state.position[self.mechanism.bodies[body].joint.position_range()];
        match (record.kind, values.len()) {
            (UrdfJointKind::Spherical, 4) => position.copy_from_slice(&unit_quaternion(record, values)?),
            (UrdfJointKind::Spherical, _) => position.copy_from_slice(&wxyz_from_rpy(&values[..3])),
            (UrdfJointKind::Floating, count) => {
                let rotation = if count == 7 {
                    Rotation3::from_matrix_unchecked(rotation_from_wxyz(&unit_quaternion(record, &values[3..])?))
                } else {
                    Rotation3::from_euler_angles(values[3], values[4], values[5])
                };
                let link = Pose::from_parts(Translation3::new(values[0], values[1], values[2]), rotation);
                position.copy_from_slice(&pose_numbers(&(link * record.child_link_in_body.inverse())));
            }
            _ => position.copy_from_slice(values),
        }
        Ok(())
    }

    /// Gives a joint a velocity, once it is at its position.
    pub fn set_velocity(&self, state: &mut State, record: &JointRecord, values: &[f64]) -> Result<(), ModelError> {
        check_numbers("velocity", record, velocity_names(record.kind), values)?;
        let Some(body) = record.body else { return Ok(()) };
        let joint = &self.mechanism.bodies[body].joint;
        let position = &state.position[joint.position_range()];
        let numbers = match record.kind {
            UrdfJointKind::Spherical => {
                let spin = rotation_from_wxyz(position).transpose() * Vector3::new(values[0], values[1], values[2]);
                spin.as_slice().to_vec()
            }
            UrdfJointKind::Floating => {
                let body_pose = pose_from_numbers(position);
                let link_pose = body_pose * record.child_link_in_body;
                let omega = Vector3::new(values[3], values[4], values[5]);
                let arm = body_pose.translation.vector - link_pose.translation.vector;
                let linear = Vector3::new(values[0], values[1], values[2]) + omega.cross(&arm);
                let spin = body_pose.rotation.inverse() * omega;
                linear.iter().chain(spin.iter()).copied().collect()
            }
            _ => values.to_vec(),
        };
        state.velocity[joint.velocity_range()].copy_from_slice(&numbers);
        Ok(())
    }
}

/// Puts a moved joint where its motion has it; a given number that is another one is refused.
fn put_on_motion(mimic: &Mimic, is_given: bool, number: &mut f64, moved: f64) -> Result<(), ModelError> {
    if is_given && (*number - moved).abs() > ON_MOTION * moved.abs().max(1.0) {
        return Err(ModelError::Moved(mimic.name.clone()));
    }
    *number = moved;
    Ok(())
}

/// The names of the numbers of a position.
pub fn position_names(kind: UrdfJointKind) -> &'static str {
    match kind {
        UrdfJointKind::Revolute | UrdfJointKind::Continuous => "angle",
        UrdfJointKind::Prismatic => "length",
        UrdfJointKind::Planar => "x,y,angle",
        UrdfJointKind::Spherical => "roll,pitch,yaw",
        UrdfJointKind::Floating => "x,y,z,roll,pitch,yaw",
        UrdfJointKind::Fixed => "",
    }
}

/// The names of the numbers of a velocity.
pub fn velocity_names(kind: UrdfJointKind) -> &'static str {
    match kind {
        UrdfJointKind::Revolute | UrdfJointKind::Continuous | UrdfJointKind::Prismatic => "rate",
        UrdfJointKind::Planar => "vx,vy,rate",
        UrdfJointKind::Spherical => "wx,wy,wz",
        UrdfJointKind::Floating => "vx,vy,vz,wx,wy,wz",
        UrdfJointKind::Fixed => "",
    }
}

fn check_numbers(
    what: &'static str,
    record: &JointRecord,
    wanted: &'static str,
    values: &[f64],
) -> Result<(), ModelError> {
    let joint = record.name.clone();
    let quaternion = match record.kind {
        UrdfJointKind::Spherical if what == "position" => Some(4),
        UrdfJointKind::Floating if what == "position" => Some(7),
        _ => None,
    };
    if values.len() != wanted.split(',').count() && Some(values.len()) != quaternion {
        return Err(ModelError::WrongCount { what, joint, kind: record.kind.name(), wanted, given: values.len() });
    }
    if values.iter().any(|value| !value.is_finite()) {
        return Err(ModelError::NotFinite { what, joint });
    }
    Ok(())
}

/// A quaternion w, x, y, z of length one.
fn unit_quaternion(record: &JointRecord, values: &[f64]) -> Result<[f64; 4], ModelError> {
    let q = Vector4::new(values[0], values[1], values[2], values[3]);
    let length = q.norm();
    if !(length > f64::MIN_POSITIVE && length.is_finite()) {
        return Err(ModelError::NoRotation { joint: record.name.clone() });
    }
    // One of length one stays as it is.
    let unit = if (length - 1.0).abs() <= f64::EPSILON { q } else { q / length };
    Ok(with_positive_w(unit.as_slice()))
}

/// Refuses angles of too many turns. Only joints whose position in the state is an angle are checked; the others keep a rotation.
fn refuse_endless_turns(record: &JointRecord, values: &[f64]) -> Result<(), ModelError> {
    let angle = match (record.kind, values) {
        (UrdfJointKind::Revolute | UrdfJointKind::Continuous, &[angle]) | (UrdfJointKind::Planar, &[_, _, angle]) => {
            angle
        }
        _ => return Ok(()),
    };
    if angle.abs() > LARGEST_ANGLE {
        return Err(ModelError::TurnedTooOften { joint: record.name.clone(), angle, largest: LARGEST_ANGLE });
    }
    Ok(())
}

fn wxyz_from_rpy(rpy: &[f64]) -> [f64; 4] {
    wxyz_from_rotation(Rotation3::from_euler_angles(rpy[0], rpy[1], rpy[2]).matrix())
}

/// x, y, z, and the quaternion w, x, y, z of a pose.
fn pose_numbers(pose: &Pose) -> [f64; 7] {
    let (t, q) = (pose.translation.vector, wxyz_from_rotation(pose.rotation.matrix()));
    [t.x, t.y, t.z, q[0], q[1], q[2], q[3]]
}

fn pose_from_numbers(numbers: &[f64]) -> Pose {
    let rotation = Rotation3::from_matrix_unchecked(rotation_from_wxyz(&numbers[3..7]));
    Pose::from_parts(Translation3::new(numbers[0], numbers[1], numbers[2]), rotation)
}

/// The quaternion with w ≥ 0 of the two quaternions of a rotation.
fn with_positive_w(q: &[f64]) -> [f64; 4] {
    let sign = if q[0] < 0.0 { -1.0 } else { 1.0 };
    [sign * q[0], sign * q[1], sign * q[2], sign * q[3]]
}
