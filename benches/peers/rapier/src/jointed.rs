//! A mechanism in Rapier: bodies with joints, some with a motor, a force or a shape.

use crate::World;
use anyhow::{Context, Result, bail};
use rapier3d_f64::prelude::*;
use serde::Deserialize;

/// The part of a scene this runner needs; all poses are of the start, in the world, and of the centre of mass.
#[derive(Deserialize)]
pub struct Scene {
    pub duration: f64,
    pub gravity: [f64; 3],
    pub bodies: Vec<Body>,
}

#[derive(Deserialize)]
pub struct Body {
    /// −1 for the world.
    parent: i64,
    kind: String,
    mass: f64,
    principal_moments: [f64; 3],
    principal_frame: [f64; 4],
    origin: [f64; 3],
    quaternion: [f64; 4],
    linear_velocity: [f64; 3],
    angular_velocity: [f64; 3],
    /// The joint's frame on the parent, turned so that its x axis is the joint's axis.
    joint_on_parent: Frame,
    /// The same frame on the body at zero displacement.
    joint_on_body: Frame,
    /// Angle or displacement at the start, and its rate.
    position: f64,
    velocity: f64,
    /// A spring and a damper on the joint, in its own coordinate.
    #[serde(default)]
    motor: Option<Motor>,
    /// A constant force at the centre of mass, in the world.
    #[serde(default)]
    force: [f64; 3],
    /// Colliding shapes.
    #[serde(default)]
    pub shape: Option<Shape>,
}

/// `stiffness (target - q) - damping q'`.
#[derive(Deserialize)]
struct Motor {
    stiffness: f64,
    damping: f64,
    target: f64,
}

/// A ball or a box, at a place of the body.
#[derive(Deserialize)]
pub struct Shape {
    pub at: [f64; 3],
    pub quaternion: [f64; 4],
    pub radius: f64,
    /// Half sizes of a box.
    pub half: Option<[f64; 3]>,
}

#[derive(Deserialize)]
struct Frame {
    position: [f64; 3],
    quaternion: [f64; 4],
}

pub fn rotation([w, x, y, z]: [f64; 4]) -> Rotation {
    Rotation::from_xyzw(x, y, z, w).normalize()
}

pub fn pose(position: [f64; 3], quaternion: [f64; 4]) -> Pose {
    Pose::from_parts(Vector::from_array(position), rotation(quaternion))
}

/// Which of Rapier's two kinds of joint is used.
#[derive(Clone, Copy, PartialEq)]
pub enum Joints {
    Multibody,
    Impulse,
}

/// A mechanism, with the handle of each body.
pub struct Jointed {
    pub world: World,
    pub handles: Vec<RigidBodyHandle>,
}

impl Jointed {
    pub fn new(scene: &Scene, joints: Joints) -> Result<Self> {
        let mut made = Jointed { world: World::default(), handles: Vec::new() };
        let world = &mut made.world;
        let ground = world.bodies.insert(RigidBodyBuilder::fixed());
        for body in &scene.bodies {
            // Moments and axes are given, because the eigenvalues of small inertias come out wrong in the library.
            let mass = MassProperties::with_principal_inertia_frame(
                Vector::ZERO,
                body.mass,
                Vector::from_array(body.principal_moments),
                rotation(body.principal_frame),
            );
            let rigid = RigidBodyBuilder::dynamic()
                .pose(pose(body.origin, body.quaternion))
                .linvel(Vector::from_array(body.linear_velocity))
                .angvel(Vector::from_array(body.angular_velocity))
                .additional_mass_properties(mass)
                .gyroscopic_forces_enabled(true)
                .can_sleep(false);
            let handle = world.bodies.insert(rigid);
            world.bodies[handle].add_force(Vector::from_array(body.force), true);
            made.handles.push(handle);
            let (free, axis) = match body.kind.as_str() {
                "revolute" => (JointAxesMask::ANG_X, JointAxis::AngX),
                "prismatic" => (JointAxesMask::LIN_X, JointAxis::LinX),
                "floating" if body.parent < 0 => continue,
                other => bail!("no {other} joint here"),
            };
            let parent = usize::try_from(body.parent).map_or(ground, |index| made.handles[index]);
            let mut joint = GenericJoint::new(JointAxesMask::all() & !free);
            joint.set_local_frame1(pose(body.joint_on_parent.position, body.joint_on_parent.quaternion));
            joint.set_local_frame2(pose(body.joint_on_body.position, body.joint_on_body.quaternion));
            if let Some(Motor { stiffness, damping, target }) = body.motor {
                joint.set_motor_model(axis, MotorModel::ForceBased);
                joint.set_motor(axis, target, 0.0, stiffness, damping);
            }
            match joints {
                Joints::Impulse => {
                    world.impulse_joints.insert(parent, handle, joint, true);
                }
                Joints::Multibody => {
                    world.multibody_joints.insert(parent, handle, joint, true).context("a loop")?;
                }
            }
        }
        if joints == Joints::Multibody {
            made.set_joint_coordinates(scene);
        }
        Ok(made)
    }

    /// Multibody joints start at zero whatever the poses of their bodies say.
    fn set_joint_coordinates(&mut self, scene: &Scene) {
        for (body, &handle) in scene.bodies.iter().zip(&self.handles) {
            let Some(link) = self.world.multibody_joints.rigid_body_link(handle).copied() else { continue };
            let Some(multibody) = self.world.multibody_joints.get_multibody_mut(link.multibody) else { continue };
            multibody.damping_mut().fill(0.0);
            multibody.forward_kinematics(&self.world.bodies, true);
            if body.kind == "floating" {
                // The six rates of a root that moves freely come first.
                let twist = body.linear_velocity.iter().chain(&body.angular_velocity);
                multibody.generalized_velocity_mut().iter_mut().zip(twist).for_each(|(rate, &given)| *rate = given);
                continue;
            }
            // Degrees of freedom are numbered link by link.
            let place: usize = multibody.links().take(link.id).map(|link| link.joint().ndofs()).sum();
            let mut displacement = vec![0.0; multibody.ndofs()];
            displacement[place] = body.position;
            multibody.apply_displacements(&displacement);
            multibody.generalized_velocity_mut()[place] = body.velocity;
            multibody.forward_kinematics(&self.world.bodies, false);
            multibody.update_rigid_bodies(&mut self.world.bodies, true);
        }
    }
}
