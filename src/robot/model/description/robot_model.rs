//! A robot ready for simulation: the mechanism, and where every link and joint of the URDF is in it.
//!
//! Only parts that must move are bodies ([`crate::model::reduction::reduce`]); a link is a frame fixed in a body, or in the world:
//!
//! ```text
//!     R_link = R_body · L.R       p_link = x_body + R_body L.t       v_c = v_body + ω_body × R_body c
//! ```
//!
//! with the link frame `L` and the link's own centre of mass `c` in the body frame [m, m/s, rad/s].

use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::mechanism::Mechanism;
use crate::model::description::at_start::AtStart;
use crate::model::description::contact_pairs::ContactRecord;
use crate::scene::{Geometry, Robot, UrdfJointKind, Warning, warning_lines};
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The simulated mechanism, and the place of the robot of the URDF in it.
#[derive(Clone, Debug)]
pub struct Model {
    /// The bodies and joints that move.
    pub mechanism: Mechanism,
    /// Every link, robot after robot, in the order of the URDF.
    pub links: Vec<LinkFrame>,
    /// Every joint, robot after robot, in the order of the URDF; a floating base comes first.
    pub joints: Vec<JointRecord>,
    /// Everything that was left out or fused, and why.
    pub reductions: Vec<Reduction>,
    /// The warnings of the robots, the reduction and the scene.
    pub warnings: Vec<Warning>,
    /// The robots, at least one.
    pub robots: Vec<PlacedRobot>,
    /// The scene file, if there is one.
    pub scene: Option<SourceFile>,
    /// The CSV files of targets, in the order in which the scene was read.
    pub tables: Vec<SourceFile>,
    /// Which of the mechanism's joint dampers are the damping of the joints themselves; the others belong to springs.
    pub damping: Range<usize>,
    /// The motors whose targets are where a run starts.
    pub at_start: Vec<AtStart>,
    /// What became of shapes that may touch.
    pub contact: ContactRecord,
}

/// A robot as it was read, and where it is in the model.
#[derive(Clone, Debug)]
pub struct PlacedRobot {
    /// Its name in the scene.
    pub name: String,
    /// The start of the names of its links and joints: its name and a slash if there are several robots.
    pub prefix: String,
    /// Whether it is a `[[body]]`, which no file of its own describes.
    pub is_body: bool,
    /// Whether it is one more copy of the robot before it, from the same file.
    pub is_copy: bool,
    /// The URDF.
    pub robot: Robot,
    /// The start of the root link: its frame in the world.
    pub base_pose: Pose,
    /// Its links among the links of the model, in the order of the URDF.
    pub links: Range<usize>,
    /// Its joints among the joints of the model, in the order of the URDF; a floating base comes first.
    pub joints: Range<usize>,
}

/// A file and its text.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceFile {
    /// Its path.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
}

/// The place of a link of the URDF.
#[derive(Clone, Debug)]
pub struct LinkFrame {
    /// Name of the link.
    pub name: String,
    /// The body that carries it; `None` is the world.
    pub body: Option<usize>,
    /// The link frame in the body frame, or in the world.
    pub in_body: Pose,
    /// The link's own centre of mass (without mass, its frame's origin) in the body frame, or in the world (m).
    pub center_of_mass: Vector3<f64>,
    /// The link's own mass (kg).
    pub mass: f64,
    /// The joint above it.
    pub parent_joint: Option<String>,
}

/// The record of a joint of the URDF.
#[derive(Clone, Debug)]
pub struct JointRecord {
    /// Name of the joint.
    pub name: String,
    /// Its URDF type.
    pub kind: UrdfJointKind,
    /// Its robot, by index.
    pub robot: usize,
    /// Whether it is the joint of a floating base, which no URDF has.
    pub is_base: bool,
    /// The body it moves; `None` if it is fixed or was dropped.
    pub body: Option<usize>,
    /// Name of the parent link, or `world`.
    pub parent_link: String,
    /// Name of the child link.
    pub child_link: String,
    /// The body that carries the parent link; `None` is the world.
    pub parent_body: Option<usize>,
    /// The URDF joint frame (the child link's frame at zero displacement) in the parent's body frame, or in the world.
    pub frame_in_parent_body: Pose,
    /// The child link's frame in the body that carries it, or in the world.
    pub child_link_in_body: Pose,
}

/// Something of the URDF that is not a body or joint of the mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduction {
    /// Which rule applied.
    pub rule: ReductionRule,
    /// The link.
    pub link: String,
    /// The joint above it.
    pub joint: Option<String>,
    /// The body or `world` in which the link is now fixed.
    pub into: String,
}

/// The rules by which links and joints are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReductionRule {
    /// The root link does not move.
    FixedBase,
    /// The link is fixed to something that does not move.
    WeldedToWorld,
    /// The link is fixed to its parent.
    FusedWithParent,
    /// The link has no mass and carries no mass, so its motion is not determined.
    MasslessLeaf,
}

impl ReductionRule {
    /// All of them, in the order in which they are tried.
    pub const ALL: [ReductionRule; 4] = [
        ReductionRule::MasslessLeaf,
        ReductionRule::FixedBase,
        ReductionRule::WeldedToWorld,
        ReductionRule::FusedWithParent,
    ];

    /// The reason, for people.
    pub fn reason(self) -> &'static str {
        match self {
            ReductionRule::FixedBase => "the base is fixed",
            ReductionRule::WeldedToWorld => "fixed to the world",
            ReductionRule::FusedWithParent => "fixed to its parent",
            ReductionRule::MasslessLeaf => "no mass, and nothing with mass beyond it: held at zero displacement",
        }
    }

    /// A name for programs.
    pub fn name(self) -> &'static str {
        match self {
            ReductionRule::FixedBase => "fixed_base",
            ReductionRule::WeldedToWorld => "welded_to_world",
            ReductionRule::FusedWithParent => "fused_with_parent",
            ReductionRule::MasslessLeaf => "massless_leaf",
        }
    }
}

/// The motion of one link, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkState {
    /// Origin of the link frame (m).
    pub position: Vector3<f64>,
    /// Axes of the link frame, as columns.
    pub rotation: Matrix3<f64>,
    /// The link's own centre of mass (m).
    pub center_of_mass: Vector3<f64>,
    /// Velocity of the centre of mass [m/s].
    pub linear_velocity: Vector3<f64>,
    /// Angular velocity [rad/s].
    pub angular_velocity: Vector3<f64>,
}

impl Model {
    /// The warnings as people read them: parts that are not simulated, odd parts of the file, and one line for all ignored parts.
    pub fn warning_lines(&self) -> impl Iterator<Item = String> {
        warning_lines(&self.warnings).into_iter().map(|(_, line)| line)
    }

    /// The file it was read from: the scene file, or the URDF of the only robot.
    pub fn path(&self) -> &Path {
        self.scene.as_ref().map_or(&self.robots[0].robot.path, |scene| &scene.path)
    }

    /// All files it is made from: the scene file, the URDFs, the tables, the meshes that were found, and the meshes of obstacles.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let robots = || self.robots.iter().map(|placed| &placed.robot);
        let links = robots().flat_map(|robot| &robot.links);
        let shapes = links.flat_map(|link| link.visuals.iter().chain(&link.collisions));
        let meshes = shapes.filter_map(|shape| match &shape.geometry {
            Geometry::Mesh(mesh) => mesh.resolved.as_deref(),
            _ => None,
        });
        let scene = self.scene.iter().map(|scene| &*scene.path);
        let tables = self.tables.iter().map(|table| &*table.path);
        let obstacles = self.contact.settings.obstacles.iter().filter_map(|obstacle| obstacle.mesh.as_ref());
        let obstacles = obstacles.map(|mesh| &*mesh.path);
        scene.chain(robots().map(|robot| &*robot.path)).chain(tables).chain(meshes).chain(obstacles)
    }

    /// The file that a robot was read from, by its place among the files of all robots.
    pub(crate) fn file_of(&self, robot: usize) -> usize {
        let before = self.robots[..=robot].iter().filter(|placed| !placed.is_copy && !placed.is_body).count();
        before.saturating_sub(1)
    }

    /// The only robot, or the only body where there is no robot: options for one robot are about it.
    pub fn only_robot(&self) -> Option<usize> {
        let mut robots = (0..self.robots.len()).filter(|&robot| !self.robots[robot].is_body);
        match (robots.next(), robots.next()) {
            (None, _) if self.robots.len() == 1 => Some(0),
            (only, None) => only,
            _ => None,
        }
    }

    /// The index of the link with this name.
    pub fn link(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }

    /// The index of the joint with this name.
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// Origin (m) and rotation of a link frame in the world.
    pub fn link_pose(&self, bodies: &[BodyState], link: usize) -> (Vector3<f64>, Matrix3<f64>) {
        let LinkState { position, rotation, .. } = self.link_state(bodies, link);
        (position, rotation)
    }

    /// Velocity of a link's centre of mass [m/s] and its angular velocity [rad/s], in the world.
    pub fn link_velocity(&self, bodies: &[BodyState], link: usize) -> (Vector3<f64>, Vector3<f64>) {
        let LinkState { linear_velocity, angular_velocity, .. } = self.link_state(bodies, link);
        (linear_velocity, angular_velocity)
    }

    /// Pose and motion of a link, from the states of the bodies ([`crate::mechanism::motion::kinematics::body_states`]).
    pub fn link_state(&self, bodies: &[BodyState], link: usize) -> LinkState {
        let link = &self.links[link];
        let body = link.body.map_or(&WORLD, |body| &bodies[body]);
        let arm = body.rotation * link.center_of_mass;
        LinkState {
            position: body.position + body.rotation * link.in_body.translation.vector,
            rotation: body.rotation * link.in_body.rotation.matrix(),
            center_of_mass: body.position + arm,
            linear_velocity: body.velocity + body.angular_velocity.cross(&arm),
            angular_velocity: body.angular_velocity,
        }
    }

    /// Names of the joints that move.
    pub fn moving_joints(&self) -> impl Iterator<Item = &str> {
        self.joints.iter().filter(|joint| joint.body.is_some()).map(|joint| joint.name.as_str())
    }
}
