//! Efforts on a mechanism, and the accelerations they cause, on another spanning tree than the file's.
//!
//! Along coordinates that both trees have the same efforts act. An effort `w` along the rates `q̇ = a · (B ω_relative)` of a joint that is cut acts
//! as the wrenches on both of its bodies that do the same work:
//!
//! ```text
//!     sliding along the axis e at the anchor p       force  w e on the child, −w e on the parent, both at p
//!     turning about the axis z                       torque w z on the child, −w z on the parent
//! ```

use crate::description::body_state::{BodyState, WORLD};
use crate::description::joint::Joint;
use crate::description::mechanism::{Body, Mechanism};
use crate::forces::total::BodyWrench;
use crate::ground::matrices::{product, times};
use crate::motion::efforts::efforts_of_wrenches;
use crate::motion::joint_accelerations::joint_accelerations;
use crate::motion::kinematics::{BodyAcceleration, body_accelerations, joint_rates, place_bodies};
use crate::motion::state::State;
use crate::structure::other_tree::OtherTree;

impl OtherTree {
    /// Takes the efforts along degrees of freedom that both trees have [N m or N]. Does not allocate.
    pub fn take_common_efforts(&self, efforts: &[f64], own: &mut [f64]) {
        own.fill(0.0);
        for [_, (here, there)] in &self.same {
            own[here.clone()].copy_from_slice(&efforts[there.clone()]);
        }
    }

    /// Takes the efforts along all degrees of freedom of the file's tree, in a state of this one [N m or N].
    pub fn take_efforts(&mut self, file: &Mechanism, state: &State, efforts: &[f64], own: &mut [f64]) {
        self.take_common_efforts(efforts, own);
        let acts =
            |body: &usize| efforts[file.bodies[*body].joint.velocity_range()].iter().any(|&effort| effort != 0.0);
        if !self.computed.iter().any(&acts) {
            return;
        }
        place_bodies(&self.mechanism, state, &mut self.bodies);
        let mut wrenches = vec![BodyWrench::default(); self.bodies.len()];
        for body in self.computed.iter().copied().filter(acts) {
            let Body { parent, joint, .. } = &file.bodies[body];
            let parent = parent.map(|parent| self.of_file[parent]);
            let ends = [parent, Some(self.of_file[body])];
            exert(joint, ends, &self.bodies, &efforts[joint.velocity_range()], &mut wrenches);
        }
        let mut room = vec![0.0; own.len()];
        efforts_of_wrenches(&self.mechanism, &self.bodies, &mut wrenches, &mut room);
        own.iter_mut().zip(room).for_each(|(own, effort)| *own += effort);
    }

    /// Writes the accelerations of the file's joints for the accelerations here, in a state of both.
    pub fn give_accelerations(
        &mut self,
        file: &Mechanism,
        [state, own]: [&State; 2],
        own_accelerations: &[f64],
        accelerations: &mut [f64],
    ) {
        for [_, (here, there)] in &self.same {
            accelerations[there.clone()].copy_from_slice(&own_accelerations[here.clone()]);
        }
        if self.computed.is_empty() {
            return;
        }
        place_bodies(&self.mechanism, own, &mut self.bodies);
        let mut of_bodies = vec![BodyAcceleration::default(); self.bodies.len()];
        body_accelerations(&self.mechanism, &self.bodies, &own.velocity, own_accelerations, &mut of_bodies);
        for &body in &self.computed {
            let Body { parent, joint, .. } = &file.bodies[body];
            let parent = parent.map(|parent| self.of_file[parent]);
            let own = self.of_file[body];
            let places = [parent.map_or(&WORLD, |parent| &self.bodies[parent]), &self.bodies[own]];
            let motion = [parent.map_or_else(BodyAcceleration::default, |parent| of_bodies[parent]), of_bodies[own]];
            let freedoms = joint.velocity_range();
            joint_accelerations(joint, places, motion, &state.velocity[freedoms.clone()], &mut accelerations[freedoms]);
        }
    }
}

/// Adds the wrenches of efforts along a joint's own freedoms on its parent and its child, about their centres of mass. Returns the wrench on its
/// child: the force (N) and the torque about its anchor [N m].
pub fn exert(
    joint: &Joint,
    ends: [Option<usize>; 2],
    bodies: &[BodyState],
    efforts: &[f64],
    wrenches: &mut [BodyWrench],
) -> BodyWrench {
    let [parent, child] = ends.map(|end| end.map_or(&WORLD, |body| &bodies[body]));
    let on_parent = product(&parent.rotation, joint.on_parent.rotation.matrix());
    let on_child = product(&child.rotation, joint.on_child.rotation.matrix());
    let anchor = child.position + times(&child.rotation, &joint.on_child.translation.vector);
    // As rates are, efforts are along the axes.
    let (force, torque) = joint_rates(joint, efforts);
    let (force, torque) = (times(&on_parent, &force), times(&on_child, &torque));
    for (end, sign) in ends.into_iter().zip([-1.0, 1.0]) {
        if let Some(body) = end {
            wrenches[body].0 += sign * force;
            wrenches[body].1 += sign * (torque + (anchor - bodies[body].position).cross(&force));
        }
    }
    (force, torque)
}
