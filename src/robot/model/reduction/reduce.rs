//! A [`Model`] from a [`Robot`]: only parts that must move are bodies.
//!
//! The rules, each a function of its own or of `rigid_groups`:
//!
//! 1. the base is fixed in the world, or floats on a joint of its own;
//! 2. links joined by fixed joints, or by joints that mimic one, are one body (mass, centre and inertia composed), or part of
//!    the world;
//! 3. a link without mass beyond which there is no mass is held still, with a warning, unless a mimic relation ties it to one with mass;
//! 4. a link without mass inside the tree stays a body, without mass;
//! 5. each body's frame is its principal inertia frame at its centre of mass;
//! 6. negative moments, and joints that can move without moving mass, are errors.

use crate::mechanism::description::composite::Composite;
use crate::mechanism::description::joint::{Joint, JointKind, Pose};
use crate::mechanism::description::mechanism::{Body, Mechanism};
use crate::mechanism::structure::definiteness::undetermined_body;
use crate::model::description::model_error::ModelError;
use crate::model::description::robot_model::{JointRecord, LinkFrame, Model, PlacedRobot, Reduction, ReductionRule};
use crate::model::reduction::constant_followers::fix_constant_followers;
use crate::model::reduction::joint_frame::{joint_frames, joint_kind};
use crate::model::reduction::rigid_groups::{
    Carrier, Group, GroupJoint, Groups, LinkTree, Moving, drop_massless_leaves,
};
use crate::model::reduction::tied_joints::{tied_inertia, tied_joints};
use crate::scene::{Element, Robot, STANDARD_GRAVITY, UrdfJointKind, WORLD_LINK, Warning};
use nalgebra::Vector3;
use std::collections::HashSet;

/// A moment whose radius of gyration is below this length [m] is the dust of a computation: zero.
const NEGLIGIBLE_GYRATION: f64 = 1e-9;

/// Whether the root link moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Base {
    /// It is fixed in the world.
    #[default]
    Fixed,
    /// It moves freely.
    Floating,
}

/// The choices of the user about a robot, besides its URDF.
#[derive(Clone, Copy, Debug)]
pub struct ModelOptions {
    /// Whether the root link moves.
    pub base: Base,
    /// The frame of the root link in the world; at the start if it floats.
    pub base_pose: Pose,
    /// Acceleration of gravity in the world [m/s²].
    pub gravity: Vector3<f64>,
}

impl Default for ModelOptions {
    fn default() -> Self {
        ModelOptions { base: Base::Fixed, base_pose: Pose::identity(), gravity: STANDARD_GRAVITY }
    }
}

impl Model {
    /// Reduces a robot to the parts that must be simulated.
    ///
    /// # Errors
    /// [`ModelError`] when the base cannot float, a motion has no or negative inertia, or a loop cannot be.
    pub fn new(robot: Robot, options: &ModelOptions) -> Result<Self, ModelError> {
        let mut model = Model::of_robot(robot, options)?;
        model.build_ranges(None)?;
        let start = model.initial_state(&[], &[], None)?;
        model.build_couplings(None, &start)?;
        Ok(model)
    }

    /// The tree of a robot alone, without what couples its joints.
    pub(crate) fn of_robot(mut robot: Robot, options: &ModelOptions) -> Result<Self, ModelError> {
        refuse_bad_options(&robot, options)?;
        fix_constant_followers(&mut robot);
        let tree = LinkTree::new(&robot);
        let mut moving = Moving::all(&robot, options.base == Base::Floating);
        let tied = tied_joints(&robot, &tree, &moving);
        let dropped = drop_massless_leaves(&robot, &tree, &mut moving, &tied);
        let groups = Groups::new(&robot, &tree, &moving, &options.base_pose);
        refuse_overflow(&robot, &groups)?;
        let base_name = base_joint_name(&robot);
        let build = Build { robot: &robot, tree: &tree, groups: &groups, options, base_name: &base_name, tied: &tied };

        let mut principal = Vec::with_capacity(groups.groups.len());
        for index in 0..groups.groups.len() {
            principal.push(build.principal(index)?);
        }
        let bodies = (0..groups.groups.len()).map(|index| build.body(index, &principal)).collect();
        let mechanism = Mechanism::new(&robot.name, options.gravity, bodies)?;
        if let Some(body) = undetermined_body(&mechanism) {
            return Err(build.no_inertia(body));
        }
        let links = (0..robot.links.len()).map(|link| build.link_frame(link, &principal)).collect();
        let joints = build.joint_records(&moving, &principal);
        let reductions = build.reductions(&dropped);
        let mut warnings = robot.warnings.clone();
        warnings.extend(dropped.iter().map(|&(head, joint)| build.massless_warning(head, joint)));
        let robots = vec![PlacedRobot {
            name: robot.name.clone(),
            prefix: String::new(),
            is_body: false,
            is_copy: false,
            links: 0..robot.links.len(),
            joints: 0..joints.len(),
            base_pose: options.base_pose,
            robot,
        }];
        Ok(Model {
            mechanism,
            links,
            joints,
            reductions,
            warnings,
            robots,
            scene: None,
            tables: Vec::new(),
            damping: 0..0,
            at_start: Vec::new(),
            contact: Default::default(),
        })
    }
}

fn refuse_bad_options(robot: &Robot, options: &ModelOptions) -> Result<(), ModelError> {
    if options.base == Base::Floating && robot.root_is_world() {
        return Err(ModelError::BaseIsWorld { file: robot.path.clone(), robot: robot.name.clone() });
    }
    if options.base_pose.to_homogeneous().iter().any(|number| !number.is_finite()) {
        return Err(ModelError::OptionNotFinite("base pose"));
    }
    if options.gravity.iter().any(|number| !number.is_finite()) {
        return Err(ModelError::OptionNotFinite("gravity"));
    }
    Ok(())
}

/// Sums and products of finite numbers may be infinite; the derivations below must not start from infinite values.
fn refuse_overflow(robot: &Robot, groups: &Groups) -> Result<(), ModelError> {
    let refuse = |link: usize| {
        let (line, name) = (robot.links[link].line, robot.links[link].name.clone());
        Err(ModelError::Overflow { file: robot.path.clone(), line, link: name })
    };
    for (link, pose) in groups.in_carrier.iter().enumerate() {
        if !pose.translation.vector.iter().all(|number| number.is_finite()) {
            return refuse(link);
        }
    }
    for (index, group) in groups.groups.iter().enumerate() {
        let composite = groups.composite(robot, index);
        let mut numbers = composite.inertia.iter().chain(composite.center.iter()).chain([&composite.mass]);
        if !numbers.all(|number| number.is_finite()) {
            return refuse(group.head);
        }
    }
    Ok(())
}

/// The name of the joint of a floating base: one that no joint of the URDF has.
fn base_joint_name(robot: &Robot) -> String {
    let taken = |name: &str| robot.joints.iter().any(|joint| joint.name == name);
    let root = robot.root.map_or(WORLD_LINK, |root| robot.links[root].name.as_str());
    let mut name = "base".to_string();
    if taken(&name) {
        name = format!("{root}_floating_base");
    }
    while taken(&name) {
        name.push('_');
    }
    name
}

/// The common data of all rules.
struct Build<'b> {
    robot: &'b Robot,
    tree: &'b LinkTree,
    groups: &'b Groups,
    options: &'b ModelOptions,
    base_name: &'b str,
    /// Joints that move no mass and are tied to some that do.
    tied: &'b HashSet<usize>,
}

/// The mass of a body and its principal frame in the frame of its head link.
struct Principal {
    mass: f64,
    frame: Pose,
    moments: Vector3<f64>,
}

impl Build<'_> {
    /// Composes a group's links into one body.
    fn principal(&self, group: usize) -> Result<Principal, ModelError> {
        let mut composite: Composite = self.groups.composite(self.robot, group);
        if composite.is_nothing()
            && matches!(self.groups.groups[group].joint, GroupJoint::Urdf(joint) if self.tied.contains(&joint))
        {
            composite = tied_inertia(self.robot);
        }
        let (frame, mut moments) = composite.principal();
        let dust = (composite.mass * NEGLIGIBLE_GYRATION.powi(2)).max(1e-15 * moments.amax());
        for moment in moments.iter_mut() {
            if moment.abs() <= dust {
                *moment = 0.0;
            }
        }
        if moments.min() < 0.0 {
            let Group { head, members, .. } = &self.groups.groups[group];
            let link = &self.robot.links[*head];
            let fused = members[1..].iter().map(|&member| self.robot.links[member].name.clone()).collect();
            return Err(ModelError::NegativeInertia {
                file: self.robot.path.clone(),
                line: link.inertial.as_ref().map_or(link.line, |inertial| inertial.line),
                link: link.name.clone(),
                fused,
                mass: composite.mass,
                moments: moments.into(),
            });
        }
        Ok(Principal { mass: composite.mass, frame, moments })
    }

    /// A frame given in the frame of a group's head link (or in the world), in the body frame (or in the world).
    fn in_body(&self, carrier: Carrier, frame: &Pose, principal: &[Principal]) -> Pose {
        match carrier {
            Carrier::World => *frame,
            Carrier::Group(group) => principal[group].frame.inv_mul(frame),
        }
    }

    /// The body of a group, with the joint to its parent.
    fn body(&self, index: usize, principal: &[Principal]) -> Body {
        let group = &self.groups.groups[index];
        let child_link = self.in_body(Carrier::Group(index), &Pose::identity(), principal);
        let (name, kind, axis, on_parent) = match group.joint {
            GroupJoint::Base => (self.base_name, JointKind::Floating, Vector3::z(), Pose::identity()),
            GroupJoint::Urdf(joint) => {
                let urdf = &self.robot.joints[joint];
                let frame = self.groups.joint_frame(self.robot, self.tree, joint, group.head, &self.options.base_pose);
                let on_parent = self.in_body(group.parent, &frame, principal);
                // Fixed joints head no group.
                let kind = joint_kind(urdf.kind).unwrap_or(JointKind::Revolute);
                (urdf.name.as_str(), kind, urdf.axis, on_parent)
            }
        };
        let (on_parent, on_child) = joint_frames(kind, &axis, &on_parent, &child_link);
        Body {
            name: self.robot.links[group.head].name.clone(),
            parent: body_of(group.parent),
            mass: principal[index].mass,
            inertia: principal[index].moments,
            joint: Joint::new(name, kind, on_parent, on_child),
        }
    }

    fn link_frame(&self, link: usize, principal: &[Principal]) -> LinkFrame {
        let carrier = self.groups.carrier[link];
        let in_body = self.in_body(carrier, &self.groups.in_carrier[link], principal);
        let inertial = self.robot.links[link].inertial.as_ref().filter(|inertial| inertial.mass > 0.0);
        let center = inertial.map_or(Vector3::zeros(), |inertial| inertial.origin.translation.vector);
        LinkFrame {
            name: self.robot.links[link].name.clone(),
            body: body_of(carrier),
            in_body,
            center_of_mass: in_body.rotation * center + in_body.translation.vector,
            mass: inertial.map_or(0.0, |inertial| inertial.mass),
            parent_joint: match self.tree.joint_above[link] {
                Some(joint) => Some(self.robot.joints[joint].name.clone()),
                None => (carrier != Carrier::World).then(|| self.base_name.to_string()),
            },
        }
    }

    fn joint_records(&self, moving: &Moving, principal: &[Principal]) -> Vec<JointRecord> {
        let mut records = Vec::with_capacity(self.robot.joints.len() + 1);
        let below: std::collections::HashMap<usize, usize> =
            self.tree.order.iter().filter_map(|&link| Some((self.tree.joint_above[link]?, link))).collect();
        if let Some(root) = self.robot.root.filter(|_| moving.base) {
            records.push(JointRecord {
                name: self.base_name.to_string(),
                kind: UrdfJointKind::Floating,
                robot: 0,
                is_base: true,
                body: body_of(self.groups.carrier[root]),
                parent_link: WORLD_LINK.to_string(),
                child_link: self.robot.links[root].name.clone(),
                parent_body: None,
                frame_in_parent_body: Pose::identity(),
                child_link_in_body: self.in_body(self.groups.carrier[root], &Pose::identity(), principal),
            });
        }
        for (index, joint) in self.robot.joints.iter().enumerate() {
            let Some(&child) = below.get(&index) else { continue };
            let parent = self.tree.parent[child].map_or(Carrier::World, |parent| self.groups.carrier[parent]);
            let frame = self.groups.joint_frame(self.robot, self.tree, index, child, &self.options.base_pose);
            let carrier = self.groups.carrier[child];
            records.push(JointRecord {
                name: joint.name.clone(),
                kind: joint.kind,
                robot: 0,
                is_base: false,
                body: body_of(carrier).filter(|_| moving.joints[index]),
                parent_link: joint.parent.clone(),
                child_link: joint.child.clone(),
                parent_body: body_of(parent),
                frame_in_parent_body: self.in_body(parent, &frame, principal),
                child_link_in_body: self.in_body(carrier, &self.groups.in_carrier[child], principal),
            });
        }
        records
    }

    /// Every link that heads no body, with the rule that left it out.
    fn reductions(&self, dropped: &[(usize, GroupJoint)]) -> Vec<Reduction> {
        let is_head = |link: usize| match self.groups.carrier[link] {
            Carrier::World => false,
            Carrier::Group(group) => self.groups.groups[group].head == link,
        };
        let massless: std::collections::HashSet<usize> = dropped.iter().map(|&(head, _)| head).collect();
        let rule_of = |link: usize| match (self.tree.joint_above[link], self.groups.carrier[link]) {
            _ if massless.contains(&link) => ReductionRule::MasslessLeaf,
            (None, _) => ReductionRule::FixedBase,
            (_, Carrier::World) => ReductionRule::WeldedToWorld,
            (_, Carrier::Group(_)) => ReductionRule::FusedWithParent,
        };
        let left_out = self.tree.order.iter().filter(|&&link| !is_head(link));
        left_out
            .map(|&link| Reduction {
                rule: rule_of(link),
                link: self.robot.links[link].name.clone(),
                joint: self.tree.joint_above[link].map(|joint| self.robot.joints[joint].name.clone()),
                into: match self.groups.carrier[link] {
                    Carrier::World => WORLD_LINK.to_string(),
                    Carrier::Group(group) => self.robot.links[self.groups.groups[group].head].name.clone(),
                },
            })
            .collect()
    }

    fn massless_warning(&self, head: usize, joint: GroupJoint) -> Warning {
        let link = &self.robot.links[head];
        let joint = match joint {
            GroupJoint::Base => "the floating base".to_string(),
            GroupJoint::Urdf(joint) => format!("joint {:?}", self.robot.joints[joint].name),
        };
        let file = self.robot.path.clone();
        let element = Some(Element::Link(link.name.clone()));
        let message = format!("neither it nor anything beyond it has mass, so {joint} is held at zero displacement");
        Warning::odd(&file, Some(link.line), element, message)
    }

    fn no_inertia(&self, body: usize) -> ModelError {
        let group = &self.groups.groups[body];
        let child = self.robot.links[group.head].name.clone();
        let (line, name) = match group.joint {
            GroupJoint::Base => (self.robot.links[group.head].line, self.base_name.to_string()),
            GroupJoint::Urdf(joint) => (self.robot.joints[joint].line, self.robot.joints[joint].name.clone()),
        };
        ModelError::NoInertia { file: self.robot.path.clone(), line, element: Element::Joint(name), child }
    }
}

fn body_of(carrier: Carrier) -> Option<usize> {
    match carrier {
        Carrier::World => None,
        Carrier::Group(group) => Some(group),
    }
}
