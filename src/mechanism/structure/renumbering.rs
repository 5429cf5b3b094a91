//! New numbers for the bodies and coordinates of a mechanism, in everything that refers to them: closures, forces, limits, friction, motors.

use crate::description::closure::Coordinate;
use crate::description::mechanism::Mechanism;
use crate::description::nonsmooth::Nonsmooth;

/// Maps from old numbers to new ones.
pub struct Renumbering<'r> {
    /// For bodies.
    pub body: &'r dyn Fn(usize) -> usize,
    /// For entries of the position vector.
    pub position: &'r dyn Fn(usize) -> usize,
    /// For entries of the velocity vector.
    pub freedom: &'r dyn Fn(usize) -> usize,
}

impl Renumbering<'_> {
    /// Gives everything its new numbers but the bodies, which have theirs, and the colliders. A coordinate belongs to the body whose joint has it
    /// now.
    pub fn apply(&self, mechanism: &mut Mechanism) {
        let Mechanism { bodies, loops, touches, mimics, forces, limits, nonsmooth, .. } = mechanism;
        let loop_ends = loops.iter_mut().flat_map(|joint| [&mut joint.a, &mut joint.b]);
        let contact_ends =
            touches.iter_mut().flat_map(|joint| [&mut joint.a, &mut joint.b].into_iter().chain(&mut joint.reeved));
        let spring_ends = forces.point_springs.iter_mut().flat_map(|spring| [&mut spring.a, &mut spring.b]);
        for end in loop_ends.chain(contact_ends).chain(spring_ends) {
            end.body = end.body.map(self.body);
        }
        let Nonsmooth { limits: stops, friction, motors, speeds, colliders: _, pairs: _, reevings: _ } = nonsmooth;
        let coordinates = mimics.iter_mut().flat_map(|mimic| {
            let more = mimic.more.iter_mut().map(|(own, _)| own);
            [&mut mimic.follower, &mut mimic.leader].into_iter().chain(more)
        });
        let coordinates = coordinates.chain(limits.iter_mut().chain(stops).map(|limit| &mut limit.coordinate));
        let coordinates = coordinates.chain(friction.iter_mut().map(|friction| &mut friction.coordinate));
        let coordinates = coordinates.chain(motors.iter_mut().map(|motor| &mut motor.coordinate));
        let coordinates = coordinates.chain(speeds.iter_mut().map(|limit| &mut limit.coordinate));
        for own in coordinates.chain(forces.joint_springs.iter_mut().map(|spring| &mut spring.coordinate)) {
            let (position, freedom) = ((self.position)(own.position), (self.freedom)(own.freedom));
            let after = bodies.partition_point(|body| body.joint.velocity_index <= freedom);
            *own = Coordinate { body: after.saturating_sub(1), position, freedom };
        }
        forces.joint_dampers.iter_mut().for_each(|damper| damper.freedom = (self.freedom)(damper.freedom));
        forces.joint_loads.iter_mut().for_each(|load| load.freedom = (self.freedom)(load.freedom));
        forces.wrenches.iter_mut().for_each(|wrench| wrench.body = (self.body)(wrench.body));
        forces.joint_courses.iter_mut().for_each(|load| load.freedom = (self.freedom)(load.freedom));
        forces.link_loads.iter_mut().for_each(|load| load.body = (self.body)(load.body));
        let holding = forces.gravity_compensations.iter_mut();
        holding.for_each(|holding| holding.freedom = (self.freedom)(holding.freedom));
        forces.drags.iter_mut().for_each(|drag| drag.body = (self.body)(drag.body));
    }
}
