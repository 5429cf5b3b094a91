//! Gaps of loop joints, closed contacts and mimics at one instant: the check of every run. Gaps of loops and contacts come from the maximal
//! coordinates alone.
//!
//! Equations as in the table of [`crate::description::closure::LoopJoint`]; rates by differentiating them. With `d = P_b − P_a`,
//!
//! ```text
//!     d/dt (d · u_a)   = ḋ · u_a + d · (ω_a × u_a)            [m/s]
//!     d/dt (u_a · w_b) = (ω_a − ω_b) · (u_a × w_b)            [rad/s]
//!     d/dt (d·d − L²)/2L = d · ḋ / L                          [m/s]
//! ```

use crate::description::body_state::BodyState;
use crate::description::closure::{Attachment, LoopJoint, LoopKind, Mimic};
use crate::description::contact::{Grip, Moment, TouchJoint};
use crate::description::mechanism::Mechanism;
use crate::motion::kinematics::BodyAcceleration;
use crate::motion::state::State;
use crate::motion::touches::{tangents, touch_accelerations, touch_motion, turning_accelerations};
use nalgebra::{Matrix3, Vector3};

/// The gaps of one closure and their rates; the first `count` entries are in use.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gaps {
    /// Number of equations.
    pub count: usize,
    /// `g`: m, or sines of angles.
    pub position: [f64; 6],
    /// `ġ`: m/s, or rad/s.
    pub velocity: [f64; 6],
}

impl Gaps {
    fn push(&mut self, position: f64, velocity: f64) {
        self.position[self.count] = position;
        self.velocity[self.count] = velocity;
        self.count += 1;
    }

    /// The largest gap and the largest rate.
    pub fn largest(&self) -> (f64, f64) {
        let of = |numbers: &[f64; 6]| numbers[..self.count].iter().fold(0.0, |most, gap| worse(most, gap.abs()));
        (of(&self.position), of(&self.velocity))
    }
}

/// The larger of two numbers, and NaN if one of them is NaN.
#[inline]
pub fn worse(one: f64, other: f64) -> f64 {
    if one.is_nan() || other.is_nan() { f64::NAN } else { one.max(other) }
}

/// One end of a loop in the world.
struct End {
    point: Vector3<f64>,
    rate: Vector3<f64>,
    axes: Matrix3<f64>,
    spin: Vector3<f64>,
}

impl End {
    fn new(end: &Attachment, bodies: &[BodyState]) -> Self {
        let (point, rate) = end.point(bodies);
        End { point, rate, axes: end.axes(bodies), spin: end.on(bodies).angular_velocity }
    }

    fn axis(&self, axis: usize) -> Vector3<f64> {
        self.axes.column(axis).into_owned()
    }
}

/// The gaps of a loop joint.
pub fn loop_gaps(joint: &LoopJoint, bodies: &[BodyState]) -> Gaps {
    let (a, b) = (End::new(&joint.a, bodies), End::new(&joint.b, bodies));
    let (apart, rate) = (b.point - a.point, b.rate - a.rate);
    let mut gaps = Gaps::default();
    for &axis in joint.kind.slides() {
        let along = a.axis(axis);
        gaps.push(apart.dot(&along), rate.dot(&along) + apart.dot(&a.spin.cross(&along)));
    }
    for &(on_a, on_b) in joint.kind.squares() {
        let (first, second) = (a.axis(on_a), b.axis(on_b));
        gaps.push(first.dot(&second), (a.spin - b.spin).dot(&first.cross(&second)));
    }
    if let LoopKind::Distance(length) = joint.kind {
        gaps.push((apart.norm_squared() - length * length) / (2.0 * length), apart.dot(&rate) / length);
    }
    gaps
}

/// The second derivatives of the equations of a loop joint, for given accelerations of the bodies:
///
/// ```text
///     (d·u)″ = d̈·u + 2 ḋ·u̇ + d·ü        (u·w)″ = ü·w + 2 u̇·ẇ + u·ẅ        ((d·d − L²)/2L)″ = (d·d̈ + ḋ·ḋ)/L
/// ```
pub fn loop_gap_accelerations(
    joint: &LoopJoint,
    bodies: &[BodyState],
    accelerations: &[BodyAcceleration],
) -> ([f64; 6], usize) {
    let (a, b) = (End::new(&joint.a, bodies), End::new(&joint.b, bodies));
    let second = |end: &Attachment, here: &End| match end.body {
        None => (Vector3::zeros(), Vector3::zeros()),
        Some(body) => {
            let arm = here.point - bodies[body].position;
            let (linear, angular) = accelerations[body];
            (linear + angular.cross(&arm) + here.spin.cross(&here.spin.cross(&arm)), angular)
        }
    };
    let ((point_a, angular_a), (point_b, angular_b)) = (second(&joint.a, &a), second(&joint.b, &b));
    let (apart, rate, acceleration) = (b.point - a.point, b.rate - a.rate, point_b - point_a);
    // An axis, its first and its second derivative.
    let axis = |end: &End, angular: &Vector3<f64>, axis: usize| {
        let along = end.axis(axis);
        let turning = end.spin.cross(&along);
        (along, turning, angular.cross(&along) + end.spin.cross(&turning))
    };
    let (mut out, mut count) = ([0.0; 6], 0);
    let mut push = |value: f64| {
        out[count] = value;
        count += 1;
    };
    for &slide in joint.kind.slides() {
        let (u, du, ddu) = axis(&a, &angular_a, slide);
        push(acceleration.dot(&u) + 2.0 * rate.dot(&du) + apart.dot(&ddu));
    }
    for &(on_a, on_b) in joint.kind.squares() {
        let ((u, du, ddu), (w, dw, ddw)) = (axis(&a, &angular_a, on_a), axis(&b, &angular_b, on_b));
        push(ddu.dot(&w) + 2.0 * du.dot(&dw) + u.dot(&ddw));
    }
    if let LoopKind::Distance(length) = joint.kind {
        push((apart.dot(&acceleration) + rate.norm_squared()) / length);
    }
    (out, count)
}

/// The equations of a contact and their rates: its gap, and for one that rolls two of velocities, which have no gap; then those of moments that hold.
pub fn touch_gaps(joint: &TouchJoint, bodies: &[BodyState]) -> Gaps {
    let mut gaps = Gaps::default();
    if joint.touch.rows() > 0 {
        let motion = touch_motion(joint, bodies);
        gaps.push(motion.gap, motion.rate);
        if joint.touch.grip == Grip::Rolls {
            tangents(&motion.normal).iter().for_each(|tangent| gaps.push(0.0, motion.slip.dot(tangent)));
        }
        if joint.moments.rows() > 0 {
            let turning = joint.turning(bodies);
            let held = joint.held_turns(&motion.normal, &tangents(&motion.normal));
            held.for_each(|along| gaps.push(0.0, turning.dot(&along)));
        }
    }
    gaps
}

/// The second derivatives of the equations of all closures at a time (s), loops before contacts before mimics, for given accelerations of the joints
/// and of the bodies.
pub fn gap_accelerations(
    mechanism: &Mechanism,
    time: f64,
    bodies: &[BodyState],
    joints: &[f64],
    accelerations: &[BodyAcceleration],
    out: &mut [f64],
) {
    let mut row = 0;
    for joint in &mechanism.loops {
        let (values, count) = loop_gap_accelerations(joint, bodies, accelerations);
        out[row..row + count].copy_from_slice(&values[..count]);
        row += count;
    }
    for joint in &mechanism.touches {
        let (count, all) = (joint.touch.rows(), joint.rows());
        if count > 0 {
            let tangents = tangents(&touch_motion(joint, bodies).normal);
            let values = touch_accelerations(joint, bodies, accelerations, &tangents);
            out[row..row + count].copy_from_slice(&values[..count]);
            if all > count {
                let [first, second, normal] = turning_accelerations(joint, bodies, accelerations, &tangents);
                let across = if joint.moments.rolling == Moment::Holds { &[first, second][..] } else { &[] };
                let held = across.iter().chain((joint.moments.spinning == Moment::Holds).then_some(&normal));
                out[row + count..row + all].iter_mut().zip(held).for_each(|(out, value)| *out = *value);
            }
        }
        row += all;
    }
    for (out, mimic) in out[row..].iter_mut().zip(&mechanism.mimics) {
        *out = joints[mimic.follower.freedom] - mimic.multiplier * joints[mimic.leader.freedom];
        *out -= mimic.motion(time, time)[2];
        mimic.more.iter().for_each(|(own, ratio)| *out -= ratio * joints[own.freedom]);
    }
}

/// The gap of a mimic relation (rad or m), with all digits of the positions, and its rate.
#[inline]
pub fn mimic_gap(mimic: &Mimic, state: &State) -> (f64, f64) {
    let [follows, leads] = [mimic.follower, mimic.leader].map(|of| of.position);
    let rest = state.compensation[follows] - mimic.multiplier * state.compensation[leads];
    let gap = state.position[follows] - mimic.multiplier * state.position[leads] - mimic.offset + rest;
    let rate = state.velocity[mimic.follower.freedom] - mimic.multiplier * state.velocity[mimic.leader.freedom];
    let (gap, rate) = match &mimic.over_time {
        None => (gap, rate),
        Some(motion) => {
            let [place, speed, _] = motion.motion(state.time, state.time);
            (gap - place, rate - speed)
        }
    };
    mimic.more.iter().fold((gap, rate), |(gap, rate), (own, ratio)| {
        let (position, rest) = (state.position[own.position], state.compensation[own.position]);
        (gap - ratio * position - ratio * rest, rate - ratio * state.velocity[own.freedom])
    })
}
