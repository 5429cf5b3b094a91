//! Poses of links and wrenches of joints and loops at a few instants of a motion, for the samples of a log.
//!
//! Trees with only gravity and forces in joints are computed in lanes (`lobatto::instants::instants`). Mechanisms with closures, forces on bodies,
//! motors, dry friction or limits are computed one instant after the other, by [`crate::instant::exerting::reactions`]. The tests compare the lanes
//! with it.

use crate::instant::exerting::reactions::Reactions;
use crate::kernels::instants_for;
use crate::lobatto::instants::snapshot::{INSTANTS, Instants, LinkPlace, Row, Snapshots};
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::joint::{JointKind, wxyz_from_rotation};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::kinematics::forward_kinematics;
use nalgebra::Vector3;

/// The fastest way to look at a mechanism and its links.
pub enum View {
    /// Eight instants at once.
    Lanes(Box<dyn Instants>),
    /// One after the other.
    Serial(Box<SerialInstants>),
}

impl View {
    /// Sets up a mechanism and its links.
    pub fn new(mechanism: &Mechanism, links: &[LinkPlace]) -> Self {
        let forces = &mechanism.forces;
        let only_joints = forces.point_springs.is_empty() && forces.wrenches.is_empty();
        let only_joints = only_joints && forces.drags.is_empty() && forces.link_loads.is_empty() && !forces.change();
        let only_joints = only_joints && forces.gravity_compensations.is_empty();
        if only_joints && !mechanism.has_closures() && mechanism.nonsmooth.is_empty() {
            View::Lanes(instants_for(mechanism, links))
        } else {
            View::Serial(Box::new(SerialInstants::new(mechanism, links)))
        }
    }

    /// Takes the times of the instants that are looked at next (s).
    pub fn clock(&mut self, times: &[f64]) {
        match self {
            // Nothing changes in time in these mechanisms.
            View::Lanes(_) => {}
            View::Serial(serial) => {
                serial.times.clear();
                serial.times.extend_from_slice(times);
            }
        }
    }

    /// Takes the contacts of the instants that are looked at next, with their forces; `None` where they are not known.
    pub fn touch<'p>(&mut self, contacts: impl Iterator<Item = Option<&'p [ContactPoint]>>) {
        match self {
            // These mechanisms have no contacts.
            View::Lanes(_) => {}
            View::Serial(serial) => {
                serial.contacts.clear();
                serial.contacts.extend(contacts.map(|points| points.map(<[ContactPoint]>::to_vec)));
            }
        }
    }

    /// Takes the efforts of the motors at the instants that are looked at next [N m or N]: one entry a motor, instant after instant.
    pub fn drive(&mut self, motors: &[f64]) {
        match self {
            // These mechanisms have no motors.
            View::Lanes(_) => {}
            View::Serial(serial) => serial.drive(motors),
        }
    }
}

impl Instants for View {
    fn look(&mut self, positions: &[f64], velocities: &[f64], count: usize, out: &mut Snapshots) {
        match self {
            View::Lanes(lanes) => lanes.look(positions, velocities, count, out),
            View::Serial(serial) => serial.look(positions, velocities, count, out),
        }
    }
}

/// One instant after the other, for any mechanism.
pub struct SerialInstants {
    mechanism: Mechanism,
    links: Vec<LinkPlace>,
    bodies: Vec<BodyState>,
    reactions: Reactions<Mechanism>,
    /// The efforts of motors, instant after instant.
    motors: Vec<f64>,
    /// The times of the instants (s).
    times: Vec<f64>,
    /// The contacts of the instants, where they are known.
    contacts: Vec<Option<Vec<ContactPoint>>>,
}

impl SerialInstants {
    /// Sets up a mechanism and its links.
    pub fn new(mechanism: &Mechanism, links: &[LinkPlace]) -> Self {
        SerialInstants {
            links: links.to_vec(),
            bodies: vec![WORLD; mechanism.bodies.len()],
            reactions: Reactions::new(mechanism.clone()),
            motors: Vec::with_capacity(INSTANTS * mechanism.nonsmooth.motors.len()),
            times: Vec::with_capacity(INSTANTS),
            contacts: Vec::with_capacity(INSTANTS),
            mechanism: mechanism.clone(),
        }
    }

    /// Takes the efforts of the motors at the instants that are looked at next [N m or N]: one entry a motor, instant after instant.
    pub fn drive(&mut self, motors: &[f64]) {
        self.motors.clear();
        self.motors.extend_from_slice(motors);
    }

    fn look_at(&mut self, instant: usize, position: &[f64], velocity: &[f64], out: &mut Snapshots) {
        let SerialInstants { mechanism, links, bodies, reactions, motors, times, contacts } = self;
        let count = mechanism.nonsmooth.motors.len();
        reactions.clock(times.get(instant).copied().unwrap_or(0.0));
        reactions.touch(contacts.get(instant).and_then(|points| points.as_deref()));
        reactions.drive(motors.get(instant * count..(instant + 1) * count).unwrap_or_default());
        forward_kinematics(mechanism, position, velocity, bodies);
        for ((body, in_body), rows) in links.iter().zip(&mut out.poses) {
            let on = body.map_or(WORLD, |body| bodies[body]);
            let place = on.position + on.rotation * in_body.translation.vector;
            let turn = wxyz_from_rotation(&(on.rotation * in_body.rotation.matrix()));
            let numbers = place.iter().chain(&turn);
            rows.iter_mut().zip(numbers).for_each(|(row, &number)| row[instant] = number);
        }
        let (reactions, loops) = reactions.of_placed(position, velocity, bodies);
        let write = |rows: &mut [Row; 6], force: &Vector3<f64>, torque: &Vector3<f64>| {
            let numbers = force.iter().chain(torque.iter());
            rows.iter_mut().zip(numbers).for_each(|(row, &number)| row[instant] = number);
        };
        for (index, reaction) in reactions.iter().enumerate() {
            write(&mut out.wrenches[index], &reaction.force, &reaction.torque);
            let joint = &mechanism.bodies[index].joint;
            let axis = bodies[index].rotation * joint.on_child.rotation.matrix().column(2);
            let along = if joint.kind == JointKind::Prismatic { reaction.force } else { reaction.torque };
            out.efforts[index][instant] = along.dot(&axis);
        }
        loops.iter().zip(&mut out.loops).for_each(|(carried, rows)| write(rows, &carried.force, &carried.torque));
    }
}

impl Instants for SerialInstants {
    fn look(&mut self, positions: &[f64], velocities: &[f64], count: usize, out: &mut Snapshots) {
        let (position_count, velocity_count) = (self.mechanism.position_count, self.mechanism.velocity_count);
        for instant in 0..count {
            let position = &positions[instant * position_count..][..position_count];
            let velocity = &velocities[instant * velocity_count..][..velocity_count];
            self.look_at(instant, position, velocity, out);
        }
    }
}
