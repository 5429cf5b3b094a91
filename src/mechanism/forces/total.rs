//! All forces on a mechanism in a state: efforts, wrenches, energies and powers.
//!
//! Forces in joints act along the degrees of freedom, all others as wrenches on bodies, in the axes of the world. Springs, and loads that have a
//! potential, give energy back; dampers dissipate; a load without a potential puts work into the mechanism. So
//! `T + V_gravity + V_spring + V_load + dissipated − work` is constant.

use crate::description::body_state::BodyState;
use crate::description::closure::Coordinate;
use crate::description::joint::FreeRotation;
use crate::description::mechanism::Mechanism;
use crate::forces::line_of_action::common_end;
use nalgebra::Vector3;
use std::ops::AddAssign;

/// Energy (J) stored in forces that have a potential, besides gravity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stored {
    /// In springs.
    pub spring: f64,
    /// In constant forces and efforts.
    pub load: f64,
}

/// Energy that went out of the mechanism and into it by forces without a potential: in joules over some time, or in
/// watts at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exchange {
    /// Turned into heat by dampers.
    pub dissipated: f64,
    /// Put in by motors, efforts from outside, and torques that have no potential.
    pub work: f64,
    /// Turned into heat by dry friction.
    pub friction: f64,
    /// Lost in impacts.
    pub impacts: f64,
}

impl Exchange {
    /// The energy that the mechanism has lost in all, less the work put in.
    #[inline]
    pub fn lost(&self) -> f64 {
        (self.dissipated - self.work) + self.friction + self.impacts
    }
}

impl AddAssign for Exchange {
    fn add_assign(&mut self, more: Exchange) {
        self.dissipated += more.dissipated;
        self.work += more.work;
        self.friction += more.friction;
        self.impacts += more.impacts;
    }
}

/// A force (N) and a torque about the centre of mass [N m] on a body, in the axes of the world.
pub type BodyWrench = (Vector3<f64>, Vector3<f64>);

/// The scalar coordinate whose rate a degree of freedom is; `None` for the three rotations of a ball joint.
pub fn scalar_coordinate(mechanism: &Mechanism, freedom: usize) -> Option<Coordinate> {
    let body = mechanism.body_of_freedom(freedom)?;
    let joint = &mechanism.bodies[body].joint;
    let offset = freedom - joint.velocity_index;
    let scalars = match joint.kind.rotation() {
        FreeRotation::Ball => joint.kind.translation_axes().len(),
        FreeRotation::None | FreeRotation::AboutZ => joint.kind.velocity_count(),
    };
    (offset < scalars).then_some(Coordinate { body, position: joint.position_index + offset, freedom })
}

/// At a time (s) the efforts of all forces in joints along the degrees of freedom [N m or N], written into `efforts`, at positions which place the
/// bodies.
pub fn joint_efforts(
    mechanism: &Mechanism,
    time: f64,
    (position, velocity): (&[f64], &[f64]),
    bodies: &[BodyState],
    efforts: &mut [f64],
) {
    let forces = &mechanism.forces;
    efforts.fill(0.0);
    for damper in &forces.joint_dampers {
        efforts[damper.freedom] += damper.effort(velocity[damper.freedom]);
    }
    for spring in &forces.joint_springs {
        efforts[spring.coordinate.freedom] += spring.effort(position[spring.coordinate.position]);
    }
    for load in &forces.joint_loads {
        efforts[load.freedom] += load.effort;
    }
    for load in &forces.joint_courses {
        efforts[load.freedom] += load.effort * load.course.value(time, time);
    }
    for holding in &forces.gravity_compensations {
        efforts[holding.freedom] += holding.effort(mechanism, bodies);
    }
}

/// At a time (s) the wrenches of all other forces on the bodies, written into `wrenches` (one entry a body).
pub fn body_wrenches(mechanism: &Mechanism, time: f64, bodies: &[BodyState], wrenches: &mut [BodyWrench]) {
    wrenches.fill((Vector3::zeros(), Vector3::zeros()));
    for spring in &mechanism.forces.point_springs {
        let force = spring.force(&spring.line(bodies));
        let ends = [&spring.a, &spring.b];
        let places = ends.map(|end| end.point(bodies).0);
        let common = common_end(places, ends.map(|end| end.body.map(|body| bodies[body].position)));
        for (side, force) in [-force, force].into_iter().enumerate() {
            if let Some(body) = ends[side].body {
                let at = common.map_or(side, |(end, _)| end);
                let arm = places[at] - bodies[body].position;
                wrenches[body].0 += force;
                wrenches[body].1 += arm.cross(&force);
            }
        }
    }
    for wrench in &mechanism.forces.wrenches {
        wrenches[wrench.body].0 += wrench.force;
        wrenches[wrench.body].1 += wrench.torque_about_center(&bodies[wrench.body]);
    }
    let loads = mechanism.forces.link_loads.iter();
    let loads = loads.map(|load| (load.body, load.wrench(load.course.value(time, time), &bodies[load.body])));
    let drags = mechanism.forces.drags.iter().map(|drag| (drag.body, drag.wrench(&bodies[drag.body])));
    for (body, (force, torque)) in loads.chain(drags) {
        wrenches[body].0 += force;
        wrenches[body].1 += torque;
    }
}

/// The stored energy at joint positions, which place the bodies.
#[inline]
pub fn stored(mechanism: &Mechanism, position: &[f64], bodies: &[BodyState]) -> Stored {
    let forces = &mechanism.forces;
    let mut stored = Stored::default();
    for spring in &forces.joint_springs {
        stored.spring += spring.energy(position[spring.coordinate.position]);
    }
    for spring in &forces.point_springs {
        stored.spring += spring.energy(spring.line(bodies).length);
    }
    for load in &forces.joint_loads {
        if let Some(coordinate) = scalar_coordinate(mechanism, load.freedom) {
            stored.load += load.potential(position[coordinate.position]);
        }
    }
    for wrench in &forces.wrenches {
        stored.load += wrench.potential(&bodies[wrench.body]);
    }
    stored
}

/// The powers (W) of forces without a potential at a time (s).
pub fn powers(mechanism: &Mechanism, time: f64, velocity: &[f64], bodies: &[BodyState]) -> Exchange {
    let forces = &mechanism.forces;
    let mut powers = Exchange::default();
    for damper in &forces.joint_dampers {
        powers.dissipated += damper.dissipated_power(velocity[damper.freedom]);
    }
    for spring in &forces.point_springs {
        powers.dissipated += spring.dissipated_power(spring.line(bodies).rate);
    }
    for load in &forces.joint_loads {
        if scalar_coordinate(mechanism, load.freedom).is_none() {
            powers.work += load.power(velocity[load.freedom]);
        }
    }
    for wrench in &forces.wrenches {
        powers.work += wrench.power(&bodies[wrench.body].angular_velocity);
    }
    for load in &forces.joint_courses {
        powers.work += load.effort * load.course.value(time, time) * velocity[load.freedom];
    }
    for load in &forces.link_loads {
        powers.work += load.power(load.course.value(time, time), &bodies[load.body]);
    }
    for drag in &forces.drags {
        powers.dissipated += drag.dissipated_power(&bodies[drag.body]);
    }
    for holding in &forces.gravity_compensations {
        powers.work += holding.effort(mechanism, bodies) * velocity[holding.freedom];
    }
    powers
}
