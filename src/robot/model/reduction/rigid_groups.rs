//! Which links move together: the tree of links, cut at the joints that move.
//!
//! A group is a set of links rigidly joined; its head is the link below the moving joint. Groups are numbered depth
//! first, as the mechanism needs it.

use crate::mechanism::description::composite::Composite;
use crate::mechanism::description::joint::Pose;
use crate::scene::{Robot, UrdfJointKind};
use std::collections::{HashMap, HashSet};

/// The links of a robot depth first, with the joint and the link above each.
pub struct LinkTree {
    /// All links, parents first, subtrees contiguous.
    pub order: Vec<usize>,
    /// The joint above each link.
    pub joint_above: Vec<Option<usize>>,
    /// The link above each link; `None` for the root and for children of an undeclared world.
    pub parent: Vec<Option<usize>>,
}

/// The carrier of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carrier {
    /// The world.
    World,
    /// A group, by index.
    Group(usize),
}

/// The joint above a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroupJoint {
    /// The floating base.
    Base,
    /// A joint of the URDF, by index.
    Urdf(usize),
}

/// Links that move as one.
pub struct Group {
    /// The link below the group's joint.
    pub head: usize,
    /// The joint above.
    pub joint: GroupJoint,
    /// The carrier of the joint.
    pub parent: Carrier,
    /// The links, the head first.
    pub members: Vec<usize>,
}

/// All groups, and where each link is.
pub struct Groups {
    /// Depth first.
    pub groups: Vec<Group>,
    /// The carrier of each link.
    pub carrier: Vec<Carrier>,
    /// Each link's frame in the frame of its group's head link, or in the world.
    pub in_carrier: Vec<Pose>,
}

/// Which joints move.
#[derive(Clone)]
pub struct Moving {
    /// Whether the root link floats.
    pub base: bool,
    /// For each joint of the URDF.
    pub joints: Vec<bool>,
}

impl LinkTree {
    /// The tree of a validated robot.
    pub fn new(robot: &Robot) -> Self {
        let by_name: HashMap<&str, usize> =
            robot.links.iter().enumerate().map(|(index, link)| (link.name.as_str(), index)).collect();
        let mut tree = LinkTree {
            order: Vec::with_capacity(robot.links.len()),
            joint_above: vec![None; robot.links.len()],
            parent: vec![None; robot.links.len()],
        };
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); robot.links.len()];
        let mut roots: Vec<usize> = robot.root.into_iter().collect();
        for (index, joint) in robot.joints.iter().enumerate() {
            let Some(&child) = by_name.get(joint.child.as_str()) else { continue };
            tree.joint_above[child] = Some(index);
            tree.parent[child] = by_name.get(joint.parent.as_str()).copied();
            match tree.parent[child] {
                Some(parent) => children[parent].push(child),
                None => roots.push(child),
            }
        }
        // A stack instead of recursion: chains may be longer than the call stack.
        let mut stack: Vec<usize> = roots.into_iter().rev().collect();
        while let Some(link) = stack.pop() {
            tree.order.push(link);
            stack.extend(children[link].iter().rev());
        }
        tree
    }
}

impl Moving {
    /// All joints that URDF lets move.
    pub fn all(robot: &Robot, floating_base: bool) -> Self {
        let joints = robot.joints.iter().map(|joint| joint.kind != UrdfJointKind::Fixed).collect();
        Moving { base: floating_base, joints }
    }
}

impl Groups {
    /// Cuts the tree at the moving joints; `base_pose` places the root link in the world.
    pub fn new(robot: &Robot, tree: &LinkTree, moving: &Moving, base_pose: &Pose) -> Self {
        let mut groups = Groups {
            groups: Vec::new(),
            carrier: vec![Carrier::World; robot.links.len()],
            in_carrier: vec![Pose::identity(); robot.links.len()],
        };
        for &link in &tree.order {
            match tree.joint_above[link] {
                None if moving.base => groups.begin(link, GroupJoint::Base, Carrier::World),
                None => groups.in_carrier[link] = *base_pose,
                Some(joint) if moving.joints[joint] => {
                    let parent = tree.parent[link].map_or(Carrier::World, |parent| groups.carrier[parent]);
                    groups.begin(link, GroupJoint::Urdf(joint), parent);
                }
                Some(joint) => {
                    groups.in_carrier[link] = groups.joint_frame(robot, tree, joint, link, base_pose);
                    groups.carrier[link] = tree.parent[link].map_or(Carrier::World, |parent| groups.carrier[parent]);
                    if let Carrier::Group(group) = groups.carrier[link] {
                        groups.groups[group].members.push(link);
                    }
                }
            }
        }
        groups
    }

    /// The URDF frame of the joint above `link`, in what carries the parent link.
    pub fn joint_frame(&self, robot: &Robot, tree: &LinkTree, joint: usize, link: usize, base_pose: &Pose) -> Pose {
        let parent = tree.parent[link].map_or(base_pose, |parent| &self.in_carrier[parent]);
        parent * robot.joints[joint].origin
    }

    /// The mass of a group, in the frame of its head link.
    pub fn composite(&self, robot: &Robot, group: usize) -> Composite {
        let parts: Vec<Composite> = self.groups[group]
            .members
            .iter()
            .filter_map(|&link| {
                let inertial = robot.links[link].inertial.as_ref()?;
                Some(Composite::part(inertial.mass, &inertial.inertia, &(self.in_carrier[link] * inertial.origin)))
            })
            .collect();
        Composite::of(&parts)
    }

    fn begin(&mut self, head: usize, joint: GroupJoint, parent: Carrier) {
        self.carrier[head] = Carrier::Group(self.groups.len());
        self.groups.push(Group { head, joint, parent, members: vec![head] });
    }
}

/// Holds still every joint beyond which there is no mass and that is not `tied` to one that moves some, because its motion is not determined. Returns
/// the heads dropped.
pub fn drop_massless_leaves(
    robot: &Robot,
    tree: &LinkTree,
    moving: &mut Moving,
    tied: &HashSet<usize>,
) -> Vec<(usize, GroupJoint)> {
    let groups = Groups::new(robot, tree, moving, &Pose::identity());
    let mut carries_mass = vec![false; groups.groups.len()];
    let mut dropped = Vec::new();
    // Children have larger numbers than parents, so one pass backwards also finds parents that are left without
    // children.
    for (index, group) in groups.groups.iter().enumerate().rev() {
        if !carries_mass[index] && groups.composite(robot, index).is_nothing() {
            if matches!(group.joint, GroupJoint::Urdf(joint) if tied.contains(&joint)) {
                continue;
            }
            match group.joint {
                GroupJoint::Base => moving.base = false,
                GroupJoint::Urdf(joint) => moving.joints[joint] = false,
            }
            dropped.push((group.head, group.joint));
        } else if let Carrier::Group(parent) = group.parent {
            carries_mass[parent] = true;
        }
    }
    dropped.reverse();
    dropped
}
