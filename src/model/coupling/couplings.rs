//! Fills the lists of a mechanism that the tree does not have: loops, mimic relations, forces, limits, friction and motors.
//!
//! A frame given in a link frame `L` (in its body, [`LinkFrame::in_body`](crate::model::LinkFrame::in_body)) lies at `L X` in the body, or in the
//! world. The modules `loops`, `forces`, `joints`, `limits` and `motors` build each kind.

use crate::mechanism::description::nonsmooth::Nonsmooth;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::model::coupling::builder::Builder;
use crate::model::coupling::forces::{Load, Spring};
use crate::model::description::contact_pairs::RopeRecord;
use crate::model::description::model_error::ModelError;
use crate::model::description::robot_model::Model;
use crate::scene::{Scene, UrdfJointKind, Warning};
use std::collections::HashMap;

impl Model {
    /// Fills the mimic relations, limits and rotors, which need no start: where the robots start depends on them.
    ///
    /// # Errors
    /// [`ModelError::Coupling`] with the line of the joint.
    pub(crate) fn build_ranges(&mut self, scene: Option<&Scene>) -> Result<(), ModelError> {
        let builder = Builder { model: self, bodies: &[], dropped: &|_| false, scene };
        builder.check_scene_joints()?;
        let mut warnings = Vec::new();
        let mut mimics = builder.urdf_mimics(&mut warnings)?;
        mimics.extend(builder.relations()?);
        mimics.extend(builder.motions()?);
        let limits = builder.limits(&mut warnings);
        let of_winches = builder.limits_of_winches();
        let rotors = builder.rotors(&mut warnings);
        self.mechanism.mimics = mimics;
        self.mechanism.nonsmooth.limits.clone_from(&limits);
        self.mechanism.limits = limits;
        self.mechanism.limits.extend(of_winches);
        for (body, armature) in rotors {
            self.mechanism.bodies[body].joint.armature = armature;
        }
        self.warnings.extend(warnings);
        Ok(())
    }

    /// The one place where what files say of loops and forces becomes part of the mechanism.
    ///
    /// # Errors
    /// [`ModelError::Coupling`] with the line of the loop, spring, load or joint.
    pub(crate) fn build_couplings(&mut self, scene: Option<&Scene>, start: &State) -> Result<(), ModelError> {
        let bodies = body_states(&self.mechanism, start);
        let above = self.joints_above();
        let dropped = |link: usize| self.is_dropped(link, &above);
        let builder = Builder { model: self, bodies: &bodies, dropped: &dropped, scene };
        let mut loops = builder.urdf_loops()?;
        builder.add_scene_loops(&mut loops)?;
        let mut forces = self.mechanism.forces.clone();
        for spring in scene.iter().flat_map(|scene| &scene.springs) {
            match builder.spring(spring)? {
                Spring::Points(spring) => forces.point_springs.push(spring),
                Spring::Joint(spring, damper) => {
                    forces.joint_springs.extend(spring);
                    forces.joint_dampers.extend(damper);
                }
            }
        }
        for load in scene.iter().flat_map(|scene| &scene.loads) {
            match builder.load(load)? {
                Load::Joint(load) => forces.joint_loads.push(load),
                Load::Link(wrench) => forces.wrenches.push(wrench),
                Load::JointCourse(load) => forces.joint_courses.push(load),
                Load::LinkLoad(load) => forces.link_loads.push(load),
            }
        }
        for drag in scene.iter().flat_map(|scene| &scene.drags) {
            forces.drags.push(builder.drag(drag)?);
        }
        let ropes = scene.iter().flat_map(|scene| &scene.ropes).map(|rope| builder.rope(rope));
        let ropes = ropes.collect::<Result<Vec<RopeRecord>, ModelError>>()?;
        let mut warnings = Vec::new();
        let springs_dampers = forces.joint_dampers.len();
        forces.joint_dampers.extend(builder.dampers(&mut warnings));
        let damping = springs_dampers..forces.joint_dampers.len();
        let mut unbounded = Vec::new();
        let (motors, at_start) = builder.motors(&mut unbounded)?;
        warnings.extend(Warning::of_kind(unbounded, "motor", "motors"));
        forces.gravity_compensations = builder.gravity_compensations(&loops)?;
        let nonsmooth = Nonsmooth {
            limits: self.mechanism.nonsmooth.limits.clone(),
            friction: builder.friction(&mut warnings),
            motors,
            speeds: builder.speeds(),
            ..Nonsmooth::default()
        };
        self.mechanism.loops = loops;
        self.mechanism.nonsmooth = nonsmooth;
        self.mechanism.forces = forces;
        self.contact.ropes = ropes;
        self.damping = damping;
        self.at_start = at_start;
        self.warnings.extend(warnings);
        Ok(())
    }

    /// The joint above each link that has one, by name.
    fn joints_above(&self) -> HashMap<String, usize> {
        self.joints.iter().enumerate().map(|(index, joint)| (joint.child_link.clone(), index)).collect()
    }

    /// Whether a link was held still because no mass is beyond its joint.
    fn is_dropped(&self, link: usize, above: &HashMap<String, usize>) -> bool {
        let mut joint = above.get(&self.links[link].name);
        while let Some(&index) = joint {
            let record = &self.joints[index];
            if record.kind != UrdfJointKind::Fixed && record.body.is_none() {
                return true;
            }
            // A link may have the name of the world, in which the base floats.
            joint = if record.is_base { None } else { above.get(&record.parent_link) };
        }
        false
    }
}
