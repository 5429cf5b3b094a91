//! Links of one tree that cannot meet, by proof from the limits of the joints between them.
//!
//! Shapes a and b are in balls of radii ρ_a, ρ_b about centers c_a, c_b. The center c goes up the chain of joints to the common ancestor of both
//! bodies. For joint positions in `m ± δ`, all places of a center at height z and distance r from the axis of a joint lie in a ball:
//!
//! ```text
//!     revolute    center r cos δ in the direction m, radius r sin δ      (δ ≥ π/2: center on the axis, radius r)       [m]
//!     prismatic   center moved by m, radius δ          spherical   center of the joint, radius |c|
//! ```
//!
//! The radii of all joints of both chains add up to D. The shapes stay apart if `|c_a − c_b| > D + ρ_a + ρ_b` on every box of joint positions. Boxes
//! are halved along the joint with the largest radius until the bound holds, or the balls overlap at the middle of a box, or a count is reached.
//!
//! Source: R. E. Moore, Interval Analysis, Prentice-Hall 1966 (subdivision); the balls are elementary geometry.

use crate::mechanism::description::contact::{Collider, Shape};
use crate::mechanism::description::joint::{Joint, JointKind, Pose};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::ground::matrices::times;
use nalgebra::{Point3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Boxes of joint positions that are looked at for one pair, at most.
const BOXES: usize = 500;
/// Joints between two shapes, at most: these boxes are too few for more.
const JOINTS: usize = 6;
/// The relative rounding error of a bound.
const MARGIN: f64 = 1e-9;

/// A ball (m).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    /// Its center.
    pub center: Vector3<f64>,
    /// Its radius.
    pub radius: f64,
}

/// A ball about all points of a shape, in the frame of its body.
pub(crate) fn ball_about(collider: &Collider) -> Ball {
    let about = |points: &[Vector3<f64>]| {
        let Some(first) = points.first() else { return (Vector3::zeros(), 0.0) };
        let (low, high) = points.iter().fold((*first, *first), |(low, high), point| (low.inf(point), high.sup(point)));
        let middle = 0.5 * (low + high);
        (middle, points.iter().map(|point| (point - middle).norm()).fold(0.0, f64::max))
    };
    let (middle, radius) = match &collider.shape {
        Shape::HalfSpace => (Vector3::zeros(), f64::INFINITY),
        Shape::Sphere { radius } => (Vector3::zeros(), *radius),
        Shape::Capsule { radius, half } => (Vector3::zeros(), radius + half),
        Shape::Cylinder { radius, half } => (Vector3::zeros(), radius.hypot(*half)),
        Shape::Box { half } => (Vector3::zeros(), half.norm()),
        Shape::Ellipsoid { radii } => (Vector3::zeros(), radii.max()),
        Shape::Hollow { .. } => (Vector3::zeros(), f64::INFINITY),
        Shape::Point => (Vector3::zeros(), 0.0),
        Shape::Hull(points) => about(points),
        Shape::Mesh(surface) => about(&surface.vertices),
    };
    Ball { center: (collider.pose * Point3::from(middle)).coords, radius }
}

/// The positions of a joint: middle and half width (rad, m), and the sines and cosines of both, which boxes share.
#[derive(Clone, Copy, Debug)]
struct Interval {
    middle: f64,
    half: f64,
    /// Sine and cosine of the middle.
    turn: (f64, f64),
    /// r cos δ and r sin δ over r, where the joint turns.
    shrink: f64,
    grow: f64,
}

impl Interval {
    fn new(middle: f64, half: f64) -> Self {
        let (shrink, grow) = if half < FRAC_PI_2 { (half.cos(), half.sin()) } else { (0.0, 1.0) };
        Interval { middle, half, turn: middle.sin_cos(), shrink, grow }
    }

    /// The middle alone.
    fn centre(self) -> Self {
        Interval { half: 0.0, shrink: 1.0, grow: 0.0, ..self }
    }

    /// Its lower and its upper half.
    fn halves(self) -> [Self; 2] {
        let low = Interval::new(self.middle - 0.5 * self.half, 0.5 * self.half);
        let middle = self.middle + 0.5 * self.half;
        [low, Interval { middle, turn: middle.sin_cos(), ..low }]
    }
}

/// A joint on the way up.
struct Link {
    /// The body that hangs on it.
    body: usize,
    kind: JointKind,
    /// The poses that lead from the axes of that body to those of the joint, and on to those of the body before it.
    into: Pose,
    out: Pose,
}

/// The joints from a body up to a common ancestor.
struct Chain {
    joints: Vec<Link>,
}

/// Whether no position of the joints within their limits brings two shapes of one tree together.
pub(crate) fn never_meet_within_limits(
    mechanism: &Mechanism,
    bodies: [Option<usize>; 2],
    [ball_a, ball_b]: [Ball; 2],
) -> bool {
    let [up_a, up_b] = chains(mechanism, bodies);
    let joints: Vec<&Link> = up_a.joints.iter().chain(&up_b.joints).collect();
    if joints.len() > JOINTS || !(ball_a.radius + ball_b.radius).is_finite() {
        return false;
    }
    let Some(first) = joints.iter().map(|joint| interval(mechanism, joint.body)).collect::<Option<Vec<Interval>>>()
    else {
        return false;
    };
    let count = up_a.joints.len();
    // The radii that the joints add, and by how much the balls are apart.
    let apart = |intervals: &[Interval], radii: &mut Vec<f64>| {
        radii.clear();
        let center_a = climb(&up_a, &intervals[..count], ball_a.center, radii);
        let center_b = climb(&up_b, &intervals[count..], ball_b.center, radii);
        let reach = radii.iter().sum::<f64>() + ball_a.radius + ball_b.radius;
        let scale = reach + center_a.norm() + center_b.norm();
        (center_a - center_b).norm() - reach - MARGIN * scale
    };
    let mut left = vec![first];
    let mut radii = Vec::with_capacity(joints.len());
    let mut middles = Vec::with_capacity(joints.len());
    for _ in 0..BOXES {
        let Some(mut intervals) = left.pop() else { return true };
        if apart(&intervals, &mut radii) > 0.0 {
            continue;
        }
        let splits = |joint: &usize| joints[*joint].kind != JointKind::Spherical;
        let widest = (0..joints.len()).filter(splits).max_by(|&one, &other| radii[one].total_cmp(&radii[other]));
        middles.clear();
        middles.extend(intervals.iter().map(|of| of.centre()));
        let Some(widest) = widest.filter(|&widest| radii[widest] > 0.0) else { return false };
        if apart(&middles, &mut radii) <= 0.0 {
            return false;
        }
        let mut other = intervals.clone();
        let [low, high] = intervals[widest].halves();
        (intervals[widest], other[widest]) = (low, high);
        left.extend([intervals, other]);
    }
    false
}

/// The joints from each of two bodies up to their nearest common ancestor, or to the world.
fn chains(mechanism: &Mechanism, ends: [Option<usize>; 2]) -> [Chain; 2] {
    let mut chains = [Chain { joints: Vec::new() }, Chain { joints: Vec::new() }];
    let mut here = ends;
    // A parent has a smaller number than its children.
    while here[0] != here[1] {
        let side = usize::from(here[1] > here[0]);
        let Some(body) = here[side] else { break };
        let Joint { kind, on_parent, on_child, .. } = &mechanism.bodies[body].joint;
        chains[side].joints.push(Link { body, kind: *kind, into: on_child.inverse(), out: *on_parent });
        here[side] = mechanism.bodies[body].parent;
    }
    chains
}

/// The positions of the joint of a body; `None` where they have no bound.
fn interval(mechanism: &Mechanism, body: usize) -> Option<Interval> {
    let limit = mechanism.nonsmooth.limits.iter().find(|limit| limit.coordinate.body == body);
    let [lower, upper] = limit.map_or([f64::NEG_INFINITY, f64::INFINITY], |limit| [limit.lower, limit.upper]);
    let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower));
    match mechanism.bodies[body].joint.kind {
        JointKind::Revolute if half < PI => Some(Interval::new(middle, half)),
        JointKind::Revolute => Some(Interval::new(0.0, PI)),
        JointKind::Prismatic if half.is_finite() => Some(Interval::new(middle, half)),
        JointKind::Spherical => Some(Interval::new(0.0, PI)),
        _ => None,
    }
}

/// Takes the center of a ball up a chain of joints, each with an interval of positions, whose radii are added to the list.
fn climb(chain: &Chain, intervals: &[Interval], center: Vector3<f64>, radii: &mut Vec<f64>) -> Vector3<f64> {
    let at = |frame: &Pose, point: Vector3<f64>| times(frame.rotation.matrix(), &point) + frame.translation.vector;
    chain.joints.iter().zip(intervals).fold(center, |center, (link, interval)| {
        let (middle, radius) = swept(link.kind, at(&link.into, center), interval);
        radii.push(radius);
        at(&link.out, middle)
    })
}

/// The ball about all places of a point in the frame of a joint.
fn swept(kind: JointKind, point: Vector3<f64>, interval: &Interval) -> (Vector3<f64>, f64) {
    let Interval { middle, half, turn: (sin, cos), shrink, grow } = *interval;
    match kind {
        JointKind::Revolute => {
            let turned = Vector3::new(cos * point.x - sin * point.y, sin * point.x + cos * point.y, 0.0);
            (turned * shrink + Vector3::new(0.0, 0.0, point.z), point.xy().norm() * grow)
        }
        JointKind::Prismatic => (point + Vector3::new(0.0, 0.0, middle), half),
        JointKind::Spherical if half > 0.0 => (Vector3::zeros(), point.norm()),
        // At one position, or without a bound, which `interval` refuses.
        _ => (point, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::closure::{Coordinate, JointLimit};
    use crate::mechanism::description::mechanism::Body;
    use crate::mechanism::motion::kinematics::body_states;
    use crate::mechanism::motion::state::State;
    use nalgebra::{Rotation3, Translation3};

    fn at(x: f64, y: f64, z: f64) -> Pose {
        Pose::from_parts(Translation3::new(x, y, z), Rotation3::identity())
    }

    /// Three links of one metre along x at position zero, each turning about z by at most these angles (rad); joints are at the near ends.
    fn arm(limits: [f64; 2]) -> Mechanism {
        let body = |parent: Option<usize>| Body {
            name: "link".to_string(),
            parent,
            mass: 1.0,
            inertia: Vector3::repeat(1.0),
            joint: Joint::new(
                "joint",
                JointKind::Revolute,
                at(if parent.is_some() { 0.5 } else { 0.0 }, 0.0, 0.0),
                at(-0.5, 0.0, 0.0),
            ),
        };
        let bodies = vec![body(None), body(Some(0)), body(Some(1))];
        let mut mechanism = Mechanism::new("arm", Vector3::zeros(), bodies).expect("an arm");
        mechanism.nonsmooth.limits = (0..2)
            .map(|joint| JointLimit {
                coordinate: Coordinate { body: joint + 1, position: joint + 1, freedom: joint + 1 },
                lower: -limits[joint],
                upper: limits[joint],
                restitution: 0.0,
            })
            .collect();
        mechanism
    }

    fn ball(body: usize, radius: f64) -> Collider {
        Collider::still("", Some(body), at(0.5, 0.0, 0.0), Shape::Sphere { radius })
    }

    fn never_meet(mechanism: &Mechanism, one: &Collider, other: &Collider) -> bool {
        never_meet_within_limits(mechanism, [one.body, other.body], [one, other].map(ball_about))
    }

    #[test]
    fn tips_are_proved_apart_if_they_come_no_nearer_than_a_fifth_of_their_distance_and_never_where_they_meet() {
        // The tips of the first and third link are |1 + e^{iq}| = 2 cos(q/2) apart, with the angle q of the third joint.
        for limit in [0.5, 1.5, 2.5, 3.0] {
            let least = 2.0 * f64::cos(0.5 * limit);
            for (radius, never) in [(0.4 * least, true), (0.51 * least, false)] {
                let (one, other) = (ball(0, radius), ball(2, radius));
                assert_eq!(never_meet(&arm([PI, limit]), &one, &other), never, "{limit} {radius}");
            }
        }
        // Without limits they meet.
        assert!(!never_meet(&arm([f64::INFINITY; 2]), &ball(0, 0.01), &ball(2, 0.01)));
    }

    #[test]
    fn no_position_within_the_limits_contradicts_a_proof() {
        for (limits, radius) in [([0.4, 2.0], 0.3), ([1.0, 2.2], 0.2), ([2.0, 0.5], 0.45), ([3.0, 2.9], 0.1)] {
            let mechanism = arm(limits);
            let (one, other) = (ball(0, radius), ball(2, radius));
            let mut least = f64::INFINITY;
            for i in 0..=40 {
                for j in 0..=40 {
                    let mut state = State::zero(&mechanism);
                    state.position[1] = limits[0] * (f64::from(i) / 20.0 - 1.0);
                    state.position[2] = limits[1] * (f64::from(j) / 20.0 - 1.0);
                    let bodies = body_states(&mechanism, &state);
                    let place = |of: &Collider, body: usize| {
                        bodies[body].position + bodies[body].rotation * of.pose.translation.vector
                    };
                    least = least.min((place(&one, 0) - place(&other, 2)).norm() - 2.0 * radius);
                }
            }
            assert_eq!(never_meet(&mechanism, &one, &other), least > 0.0, "{limits:?} {least}");
        }
    }
}
