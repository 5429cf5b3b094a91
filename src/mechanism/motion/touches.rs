//! Closed contacts at one instant: gap, slip and their accelerations.
//!
//! The material velocities of the bodies at the point of contact p differ by `u = v_b + ω_b × (p − x_b) − v_a − ω_a × (p − x_a)` [m/s]:
//!
//! ```text
//!     φ̇ = n · u                      u_T = u − (n · u) n
//!     u̇ = Σ ± (ẍ + ω̇ × (p − x) + ω × (ṗ − ẋ))            p moves on both surfaces
//!     (u · e)˙ = u̇ · e + u · (ω_a × e)                   along a tangent e that turns with a
//! ```
//!
//! Surfaces that move over their bodies add `w = R_b w_b − R_a w_a`, along the tangents alone:
//!
//! ```text
//!     u_T + w − n (n · w)                    (w · e − (n · w)(n · e))˙ = ẇ · e + w · ė − (n · w)(ṅ · e + n · ė),    ė = ω_a × e
//! ```
//!
//! The turning `ω = ω_b − ω_a` [rad/s] of rolling and spinning friction changes by
//!
//! ```text
//!     (ω · e)˙ = ω̇ · e − (ω · n)(ṅ · e) + ω_T · (ω_a × e)           (ω · n)˙ = ω̇ · n + ω · ṅ
//! ```
//!
//! φ, n and p are differentiated exactly: [`crate::motion::contact_geometry`] in numbers with derivatives ([`crate::ground::smooth`]). A contact with
//! features that make no pair has zeros.

use crate::description::body_state::{BodyState, WORLD};
use crate::description::closure::Attachment;
use crate::description::contact::TouchJoint;
use crate::ground::smooth::{Jet, Triple};
use crate::motion::contact_geometry::{Contact, Placed, contact};
use crate::motion::kinematics::BodyAcceleration;
use crate::motion::moving_points::{jets, moving_point, turned};
use crate::motion::reeved::{RopeMotion, rope_acceleration, rope_motion};
use nalgebra::Vector3;

/// How the features of a contact move against each other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TouchMotion {
    /// φ (m).
    pub gap: f64,
    /// φ̇ [m/s].
    pub rate: f64,
    /// n, from a to b, in the world.
    pub normal: Vector3<f64>,
    /// p in the world (m).
    pub point: Vector3<f64>,
    /// `u_T`: the slip of the surface of b on the surface of a at p [m/s].
    pub slip: Vector3<f64>,
}

/// Gap, normal, point of contact and slip of a contact.
pub fn touch_motion(joint: &TouchJoint, bodies: &[BodyState]) -> TouchMotion {
    let Some(pairing) = joint.touch.pairing() else { return TouchMotion::default() };
    if joint.is_reeved() {
        let RopeMotion { gap, rate, pull: normal, last: point } = rope_motion(pairing.reach, &joint.reeved, bodies);
        return TouchMotion { gap, rate, normal, point, slip: Vector3::zeros() };
    }
    let place = |end: &Attachment| {
        let (origin, axes) = end.place(bodies);
        Placed { origin: Triple(origin.into()), axis: Triple(axes.column(2).into_owned().into()) }
    };
    let first_axis = || Triple(joint.b.axes(bodies).column(0).into_owned().into());
    let Contact { gap, normal, point } =
        contact::<f64>(pairing, joint.touch.side, place(&joint.a), place(&joint.b), first_axis);
    let (normal, point) = (Vector3::from(normal.0), Vector3::from(point.0));
    let velocity = material(&joint.b, bodies, &point) - material(&joint.a, bodies, &point);
    let rate = normal.dot(&velocity);
    let slip = velocity - normal * rate;
    let slip = if joint.is_belt() { slip + belt(joint, bodies, &normal) } else { slip };
    TouchMotion { gap, rate, normal, point, slip }
}

/// The part of the surface velocities along the tangents of a contact with this normal, in the world [m/s].
pub fn belt(joint: &TouchJoint, bodies: &[BodyState], normal: &Vector3<f64>) -> Vector3<f64> {
    let surface = joint.surface_velocity(bodies);
    surface - normal * normal.dot(&surface)
}

/// Velocity of the material of a body at a point of the world [m/s].
fn material(end: &Attachment, bodies: &[BodyState], point: &Vector3<f64>) -> Vector3<f64> {
    let body = end.on(bodies);
    body.velocity + body.angular_velocity.cross(&(point - body.position))
}

/// The second derivative of the gap of a contact, and the derivatives of its slip along two tangents that turn with the first body, for given
/// accelerations of the bodies [m/s²].
pub fn touch_accelerations(
    joint: &TouchJoint,
    bodies: &[BodyState],
    accelerations: &[BodyAcceleration],
    tangents: &[Vector3<f64>; 2],
) -> [f64; 3] {
    if joint.is_reeved() {
        return [rope_acceleration(&joint.reeved, bodies, accelerations), 0.0, 0.0];
    }
    let Some((ends, Contact { gap, point, normal })) = moving_contact(joint, bodies, accelerations) else {
        return [0.0; 3];
    };
    let [here, moves] = value_and_rate(&point);
    let [of_a, of_b] = ends.each_ref().map(|end| end.material(&here, &moves));
    let (velocity, acceleration) = (of_b.0 - of_a.0, of_b.1 - of_a.1);
    let turning = |tangent: &Vector3<f64>| ends[0].body.angular_velocity.cross(tangent);
    let along = |tangent: &Vector3<f64>| acceleration.dot(tangent) + velocity.dot(&turning(tangent));
    if joint.is_belt() {
        let surfaces = [joint.a.axes(bodies) * joint.surfaces[0], joint.b.axes(bodies) * joint.surfaces[1]];
        let spins = ends.each_ref().map(|end| end.body.angular_velocity);
        let surface = surfaces[1] - surfaces[0];
        let change = spins[1].cross(&surfaces[1]) - spins[0].cross(&surfaces[0]);
        let [normal, turns] = value_and_rate(&normal);
        let carried = |tangent: &Vector3<f64>| {
            let tangent_turns = turning(tangent);
            change.dot(tangent) + surface.dot(&tangent_turns)
                - normal.dot(&surface) * (turns.dot(tangent) + normal.dot(&tangent_turns))
        };
        return [gap.second, along(&tangents[0]) + carried(&tangents[0]), along(&tangents[1]) + carried(&tangents[1])];
    }
    [gap.second, along(&tangents[0]), along(&tangents[1])]
}

/// The derivatives of the turning `ω = ω_b − ω_a` along two tangents, and along the normal, for given accelerations of the bodies [rad/s²].
pub fn turning_accelerations(
    joint: &TouchJoint,
    bodies: &[BodyState],
    accelerations: &[BodyAcceleration],
    tangents: &[Vector3<f64>; 2],
) -> [f64; 3] {
    let Some((ends, Contact { normal, .. })) = moving_contact(joint, bodies, accelerations) else { return [0.0; 3] };
    let [normal, turns] = value_and_rate(&normal);
    let turning = joint.turning(bodies);
    let change = ends[1].acceleration.1 - ends[0].acceleration.1;
    let spin = turning.dot(&normal);
    let across = turning - normal * spin;
    let along = |tangent: &Vector3<f64>| {
        change.dot(tangent) - spin * turns.dot(tangent) + across.dot(&ends[0].body.angular_velocity.cross(tangent))
    };
    [along(&tangents[0]), along(&tangents[1]), change.dot(&normal) + turning.dot(&turns)]
}

/// The ends of a contact with the motion of their bodies, and the contact with its derivatives; `None` for features that make no pair.
fn moving_contact<'b>(
    joint: &TouchJoint,
    bodies: &'b [BodyState],
    accelerations: &[BodyAcceleration],
) -> Option<([Moving<'b>; 2], Contact<Jet>)> {
    let pairing = joint.touch.pairing()?;
    let ends = [&joint.a, &joint.b].map(|end| Moving::new(end, bodies, accelerations));
    let [a, b] = ends.each_ref().map(|end| end.placed);
    let contact = contact(pairing, joint.touch.side, a, b, || ends[1].axis(&joint.b, bodies, 0));
    Some((ends, contact))
}

/// A vector and its first derivative.
fn value_and_rate(of: &Triple<Jet>) -> [Vector3<f64>; 2] {
    [of.0.map(|part| part.value), of.0.map(|part| part.rate)].map(Vector3::from)
}

/// An end of a contact with the motion of its body.
struct Moving<'b> {
    body: &'b BodyState,
    acceleration: BodyAcceleration,
    placed: Placed<Jet>,
}

impl<'b> Moving<'b> {
    fn new(end: &Attachment, bodies: &'b [BodyState], accelerations: &[BodyAcceleration]) -> Self {
        let body = end.body.map_or(&WORLD, |body| &bodies[body]);
        let acceleration = end.body.map_or((Vector3::zeros(), Vector3::zeros()), |body| accelerations[body]);
        let (linear, angular) = acceleration;
        let (origin, axes) = end.place(bodies);
        let origin = moving_point(body, [&linear, &angular], &origin);
        let axis = jets(turned(body, &angular, &axes.column(2).into_owned()));
        Moving { body, acceleration, placed: Placed { origin, axis } }
    }

    /// An axis of the frame of this end with its derivatives.
    fn axis(&self, end: &Attachment, bodies: &[BodyState], axis: usize) -> Triple<Jet> {
        jets(turned(self.body, &self.acceleration.1, &end.axes(bodies).column(axis).into_owned()))
    }

    /// Velocity of the material at a point [m/s], and the derivative of it while the point moves [m/s²].
    fn material(&self, point: &Vector3<f64>, moves: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let BodyState { position, velocity, angular_velocity, .. } = self.body;
        let (linear, angular) = self.acceleration;
        let arm = point - position;
        let acceleration = linear + angular.cross(&arm) + angular_velocity.cross(&(moves - velocity));
        (velocity + angular_velocity.cross(&arm), acceleration)
    }
}

/// Two unit vectors that are square to a normal and to each other: the same ones for the same normal.
pub fn tangents(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let axis = if normal.x.abs() <= 0.6 { Vector3::x() } else { Vector3::y() };
    let first = (axis - normal * normal.dot(&axis)).normalize();
    [first, normal.cross(&first)]
}
