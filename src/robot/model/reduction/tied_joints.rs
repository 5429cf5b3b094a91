//! Joints that move no mass, but whose motion is determined by a mimic relation to a joint that does.
//!
//! A mimic relation is `q_f = k q_l + c` between a follower f and its leader l:
//!
//! ```text
//!     l is determined                  ⟹  f is determined
//!     f is determined, and k ≠ 0       ⟹  l is determined
//! ```
//!
//! The rules are applied until no joint is added; joints that move mass are determined from the start. A link on a tied joint stays a body. So that
//! its joint has an equation of motion of its own, it has 1e-14 of the mass and inertia of its robot, which is rounding to everything else.

use crate::mechanism::description::composite::Composite;
use crate::mechanism::description::joint::{JointKind, Pose};
use crate::model::reduction::joint_frame::joint_kind;
use crate::model::reduction::rigid_groups::{Carrier, GroupJoint, Groups, LinkTree, Moving};
use crate::scene::Robot;
use nalgebra::{Matrix3, Vector3};
use std::collections::{HashMap, HashSet};

/// The part of a robot's mass and inertia that a massless link on a tied joint has.
const TIED: f64 = 1e-14;

/// The joints, by index, that move no mass but are tied to some that do.
pub fn tied_joints(robot: &Robot, tree: &LinkTree, moving: &Moving) -> HashSet<usize> {
    if robot.joints.iter().all(|joint| joint.mimic.is_none()) {
        return HashSet::new();
    }
    let groups = Groups::new(robot, tree, moving, &Pose::identity());
    let mut carries_mass = vec![false; groups.groups.len()];
    let (mut determined, mut massless) = (HashSet::new(), HashSet::new());
    for (index, group) in groups.groups.iter().enumerate().rev() {
        carries_mass[index] |= !groups.composite(robot, index).is_nothing();
        if let (true, Carrier::Group(parent)) = (carries_mass[index], group.parent) {
            carries_mass[parent] = true;
        }
        if let GroupJoint::Urdf(joint) = group.joint {
            if carries_mass[index] {
                determined.insert(joint)
            } else {
                massless.insert(joint)
            };
        }
    }
    let scalar = |joint: &usize| {
        matches!(joint_kind(robot.joints[*joint].kind), Some(JointKind::Revolute | JointKind::Prismatic))
    };
    massless.retain(scalar);
    let numbers: HashMap<&str, usize> =
        robot.joints.iter().enumerate().map(|(number, joint)| (joint.name.as_str(), number)).collect();
    let relations: Vec<(usize, usize, f64)> = robot
        .joints
        .iter()
        .enumerate()
        .filter_map(|(follower, joint)| {
            let mimic = joint.mimic.as_ref()?;
            Some((follower, *numbers.get(mimic.joint.as_str())?, mimic.multiplier))
        })
        .collect();
    let mut tied = HashSet::new();
    loop {
        let before = tied.len();
        for &(follower, leader, multiplier) in &relations {
            let known = |joint: usize, tied: &HashSet<usize>| determined.contains(&joint) || tied.contains(&joint);
            if known(leader, &tied) && massless.contains(&follower) {
                tied.insert(follower);
            }
            if known(follower, &tied) && massless.contains(&leader) && multiplier != 0.0 {
                tied.insert(leader);
            }
        }
        if tied.len() == before {
            return tied;
        }
    }
}

/// Mass and inertia of a massless link on a tied joint of this robot, at the origin of its frame.
pub fn tied_inertia(robot: &Robot) -> Composite {
    let inertials = || robot.links.iter().filter_map(|link| link.inertial.as_ref());
    let mass: f64 = inertials().map(|inertial| inertial.mass.max(0.0)).sum();
    let moment = inertials()
        .map(|inertial| inertial.inertia.amax().max(inertial.mass * inertial.origin.translation.vector.norm_squared()))
        .fold(0.0, f64::max);
    // A robot of point masses on its axes: a hundredth of a square metre stands for its size.
    let moment = if moment > 0.0 { moment } else { 1e-2 * mass };
    Composite { mass: TIED * mass, center: Vector3::zeros(), inertia: Matrix3::identity() * (TIED * moment) }
}
