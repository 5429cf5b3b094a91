//! The parts of an MJCF file, read: trees of links, geoms, joints, and what couples and drives them.

use crate::scene::mjcf_reading::activations::{Activation, Drive, Driving};
use crate::scene::mjcf_reading::grips::Grip;
use crate::scene::mjcf_reading::mass::MassOf;
use crate::scene::robot::{Geometry, Pose, UrdfJointKind};
use nalgebra::Vector3;
use std::cell::OnceCell;
use std::collections::HashMap;

/// A child of the world with all that it carries.
#[derive(Debug)]
pub(crate) struct Tree {
    pub name: String,
    /// Whether it floats: its pose is where it starts.
    pub floats: bool,
    pub pose: Pose,
    /// The frame of its base whose motion a keyframe gives.
    pub free_frame: FreeFrame,
    /// Velocity of its base in the world: linear, angular [m/s, rad/s].
    pub velocity: Option<[f64; 6]>,
    /// Damping of the velocity of its base [N s/m], and of its spin [N m s].
    pub damping: f64,
    pub links: Vec<Link>,
    pub joints: Vec<(Between, Option<Joint>)>,
    /// The inertia of each joint at the start ([`super::tuning`]), once it was asked for.
    pub inertias: OnceCell<HashMap<String, f64>>,
}

/// A frame of a free body ([`super::free_frames`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FreeFrame {
    Body,
    /// The inertial frame in the body.
    Inertial(Pose),
    /// An inertial frame whose axes are not known here.
    Unread,
}

impl FreeFrame {
    /// The pose of the body where this frame has a pose.
    pub fn body_at(&self, pose: &Pose) -> Pose {
        match self {
            FreeFrame::Inertial(frame) => pose * frame.inverse(),
            FreeFrame::Body | FreeFrame::Unread => *pose,
        }
    }

    /// The velocity and the spin of the body at a pose, both in the world, from the velocity of this frame in the world and its spin in its axes.
    pub fn velocity_of(&self, body: &Pose, velocity: Vector3<f64>, spin: Vector3<f64>) -> [f64; 6] {
        let (spin, back) = match self {
            FreeFrame::Inertial(frame) => {
                (body.rotation * (frame.rotation * spin), body.rotation * -frame.translation.vector)
            }
            FreeFrame::Body | FreeFrame::Unread => (body.rotation * spin, Vector3::zeros()),
        };
        let velocity = velocity + spin.cross(&back);
        [velocity.x, velocity.y, velocity.z, spin.x, spin.y, spin.z]
    }
}

/// A link, read.
#[derive(Debug)]
pub(crate) struct Link {
    pub name: String,
    pub mass: Option<MassOf>,
    /// The part of its weight that a force at its centre of mass holds.
    pub held: f64,
    pub geoms: Vec<Geom>,
    pub line: usize,
}

/// What a joint joins, and its frame in the parent.
#[derive(Debug)]
pub(crate) struct Between {
    pub parent: String,
    pub child: String,
    pub origin: Pose,
}

/// A body at the start, for what names it.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    /// Its robot; `None` where it does not move, so that its points are points of the world.
    pub tree: Option<usize>,
    pub pose: Pose,
}

/// A geom, read.
#[derive(Clone, Debug)]
pub(crate) struct Geom {
    pub name: Option<String>,
    pub form: Form,
    /// Its frame in its body.
    pub pose: Pose,
    pub touches: bool,
    /// The bits of `contype` and `conaffinity`.
    pub masks: [u32; 2],
    pub is_shown: bool,
    pub color: Option<[f64; 4]>,
    pub grip: Grip,
}

impl Geom {
    /// Whether it is a shape of a link that may touch.
    pub fn can_touch(&self) -> bool {
        self.touches && matches!(self.form, Form::Solid(_))
    }

    /// Whether it is an ellipsoid.
    pub fn is_ellipsoid(&self) -> bool {
        matches!(self.form, Form::Solid(Geometry::Ellipsoid { .. }))
    }
}

impl Link {
    /// Whether it touches as ellipsoids do.
    pub fn is_round(&self) -> bool {
        self.geoms.iter().any(|geom| geom.can_touch() && geom.is_ellipsoid())
    }
}

/// What a geom is.
#[derive(Clone, Debug)]
pub(crate) enum Form {
    /// Below the plane through the origin across z.
    Plane,
    Solid(Geometry),
    /// A height field: the name of the file that its mesh would have.
    Field(String),
    /// What touches nothing and is not shown here.
    Other,
}

/// A joint, read.
#[derive(Clone, Debug)]
pub(crate) struct Joint {
    pub name: String,
    pub kind: UrdfJointKind,
    /// Its point in the body (m).
    pub place: Vector3<f64>,
    pub axis: Vector3<f64>,
    /// The position that MuJoCo gives it at the start, where it is zero here [rad or m].
    pub reference: f64,
    pub limit: Option<(f64, f64)>,
    pub damping: f64,
    pub friction: f64,
    /// Inertia of its rotor [kg m² or kg].
    pub armature: f64,
    /// Stiffness, and the position at which its spring is free, counted as here.
    pub spring: Option<(f64, f64)>,
    /// Time constant (s) and damping ratio, from which stiffness and damping follow, and where the spring is free.
    pub spring_damper: Option<[f64; 3]>,
    /// Its `springref`, counted as here.
    pub rest: f64,
    /// Whom it follows: the leader, the multiplier and the offset.
    pub mimic: Option<(String, f64, f64)>,
    pub line: usize,
}

/// A body, `None` for the world, and a point of it (m).
pub(crate) type End = (Option<String>, Vector3<f64>);

/// A loop that a constraint closes.
#[derive(Debug)]
pub(crate) struct Closing {
    pub name: Option<String>,
    /// `spherical` or `fixed`.
    pub kind: &'static str,
    pub ends: [End; 2],
}

/// A tendon with a greatest length.
#[derive(Debug)]
pub(crate) struct Rope {
    pub name: Option<String>,
    /// Its ends, and the sites between.
    pub points: Vec<End>,
    /// m.
    pub length: f64,
}

/// A tendon that pulls as a spring and a damper.
#[derive(Debug)]
pub(crate) struct Spring {
    pub ends: [End; 2],
    /// N/m.
    pub stiffness: f64,
    /// N s/m.
    pub damping: f64,
    /// Its length without force (m).
    pub rest: f64,
}

/// `Σ coefficient · position = offset` over joints.
#[derive(Debug)]
pub(crate) struct Relation {
    pub name: Option<String>,
    pub joints: Vec<(String, f64)>,
    pub offset: f64,
}

/// A motor.
#[derive(Debug)]
pub(crate) struct Motor {
    pub joint: String,
    /// What its effort is without and with control, or activation.
    pub drive: Drive,
    /// Damping for each unit of its control.
    pub brake: f64,
    /// Control at the start, and its bounds.
    pub control: f64,
    pub control_range: Option<(f64, f64)>,
    /// Its own dynamics, if it has any.
    pub activation: Option<Activation>,
    pub max_effort: Option<f64>,
}

impl Motor {
    /// The kind of the motors of a joint in a scene file, their stiffness and damping together, and how they are driven: one has an activation at most.
    pub fn law<'m>(motors: impl Iterator<Item = &'m Motor>) -> (&'static str, Drive, Driving) {
        let mut drive = Drive { kp: 0.0, kd: 0.0, constant: 0.0, gain: 0.0 };
        let mut active = None;
        for motor in motors {
            let control =
                motor.control_range.map_or(motor.control, |(lower, upper)| motor.control.max(lower).min(upper));
            let Drive { kp, kd, constant, gain } = motor.drive;
            drive.kp += kp;
            drive.kd += kd + motor.brake * control;
            drive.constant += constant;
            match &motor.activation {
                Some(activation) => (drive.gain, active) = (gain, Some((activation, control))),
                None => drive.constant += gain * control,
            }
        }
        let driving = match active {
            Some((activation, control)) => activation.driving(&drive, control),
            None => Driving { target: format!("{:?}", drive.at_rest(0.0)), load: None },
        };
        let kind = match (drive.kp > 0.0, drive.kd > 0.0) {
            (true, _) => "position",
            (false, true) => "velocity",
            (false, false) => "effort",
        };
        (kind, drive, driving)
    }
}

/// What has coordinates, in the order of `qpos`.
#[derive(Clone, Debug)]
pub(crate) enum Moving {
    /// The base of a tree.
    Free(usize),
    Joint(usize, String, UrdfJointKind),
}
