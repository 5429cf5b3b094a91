//! Loops that the joints between their ends cannot hold alone, because hinges are parallel or another loop needs them, too; and equations that
//! others imply, weak or whole closures, which are counted.

use super::run;
use crate::models::{body, frame};
use catena::instant::start::assembly::{assemble, redundancy};
use catena::mechanism::description::closure::{Attachment, Coordinate, LoopJoint, LoopKind, Mimic};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::energy::energy;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use nalgebra::{UnitQuaternion, Vector3};

/// A link of 1 kg whose joint is this far above its centre of mass, and this far below that of its parent (m).
fn link(name: &str, parent: Option<usize>, kind: JointKind, axis: Vector3<f64>, below: f64) -> Body {
    let joint = Joint::new(name, kind, frame(-below * Vector3::z(), axis), frame(0.15 * Vector3::z(), axis));
    body(name, parent, 1.0, Vector3::new(0.05, 0.06, 0.03), joint)
}

/// A loop that holds a point of a body where it is in this state.
fn pin(mechanism: &Mechanism, state: &State, (index, point): (usize, Vector3<f64>), to: Option<usize>) -> LoopJoint {
    let bodies = body_states(mechanism, state);
    let at = bodies[index].position + bodies[index].rotation * point;
    let local = to.map_or(at, |other| bodies[other].rotation.transpose() * (at - bodies[other].position));
    let end = |body, place| Attachment { body, frame: frame(place, Vector3::z()) };
    LoopJoint { name: "pin".into(), kind: LoopKind::Spherical, a: end(Some(index), point), b: end(to, local) }
}

/// A body of 5 kg that floats.
fn trunk() -> Body {
    let joint = Joint::new("base", JointKind::Floating, Pose::identity(), Pose::identity());
    body("trunk", None, 5.0, Vector3::new(0.06, 0.05, 0.03), joint)
}

/// A leg under a trunk that floats, bent at three parallel hinges, with its foot on a ball joint at the ground: three equations, of which
/// the hinges can fulfil two.
fn leg() -> (Mechanism, State) {
    let hinged = |name, parent| link(name, Some(parent), JointKind::Revolute, Vector3::y(), 0.15);
    let bodies = vec![trunk(), hinged("thigh", 0), hinged("shank", 1), hinged("foot", 2)];
    let mut mechanism = Mechanism::new("leg", Vector3::new(0.0, 0.0, -9.81), bodies).unwrap();
    let mut state = State::zero(&mechanism);
    state.position[7..].copy_from_slice(&[0.4, -0.7, 0.2]);
    state.velocity[..6].copy_from_slice(&[0.3, 0.2, 0.1, 0.5, 0.4, -0.6]);
    mechanism.loops.push(pin(&mechanism, &state, (3, Vector3::new(0.0, 0.0, -0.1)), None));
    (mechanism, state)
}

/// Two links on a ball joint and a hinge, of which a second ball joint locks the hinge (three equations, of which one is new), and a rod to
/// the world.
fn locked() -> (Mechanism, State) {
    let upper = link("upper", None, JointKind::Spherical, Vector3::z(), 0.0);
    let lower = link("lower", Some(0), JointKind::Revolute, Vector3::new(0.3, 1.0, 0.2), 0.2);
    let mut mechanism = Mechanism::new("locked", Vector3::new(0.0, 0.0, -9.81), vec![upper, lower]).unwrap();
    let mut state = State::zero(&mechanism);
    state.velocity.copy_from_slice(&[1.0, 0.5, -0.7, 0.0]);
    mechanism.loops.push(pin(&mechanism, &state, (1, Vector3::new(0.2, 0.1, 0.1)), Some(0)));
    let end = |body, place| Attachment { body, frame: frame(place, Vector3::z()) };
    let (a, b) = (end(None, Vector3::new(0.3, -0.4, -1.4)), end(Some(1), Vector3::new(0.1, 0.2, -0.2)));
    let place = |end: &Attachment| end.place(&body_states(&mechanism, &state)).0;
    let kind = LoopKind::Distance((place(&a) - place(&b)).norm());
    mechanism.loops.push(LoopJoint { name: "rod".into(), kind, a, b });
    (mechanism, state)
}

/// A ball on a trunk that floats, in a sleeve: four equations for three freedoms. Of the two that hold the axis of the sleeve at its distance
/// from the ball the first is weak, because that is nearly along the axis that it is about, and implies the second with a large factor.
fn sleeve() -> (Mechanism, State) {
    let bodies = vec![trunk(), link("ball", Some(0), JointKind::Spherical, Vector3::z(), -0.2)];
    let mut mechanism = Mechanism::new("sleeve", Vector3::new(0.0, 0.0, -9.81), bodies).unwrap();
    let mut state = State::zero(&mechanism);
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(-0.6, -0.2, 0.5));
    state.position[7..].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
    let here = body_states(&mechanism, &state);
    let axis = Vector3::new(0.32, 0.68, 0.55);
    let local = |body: usize| frame(Vector3::zeros(), here[body].rotation.transpose() * axis).rotation;
    let place =
        Vector3::new(0.0, 0.0, 0.2) + 0.9 * axis + here[1].rotation * (local(1) * Vector3::new(0.3, 0.003, 0.0));
    let end = |body: usize| {
        let at = here[body].rotation.transpose() * (place - here[body].position);
        Attachment { body: Some(body), frame: Pose::from_parts(at.into(), local(body)) }
    };
    mechanism.loops.push(LoopJoint { name: "sleeve".into(), kind: LoopKind::Cylindrical, a: end(1), b: end(0) });
    (mechanism, state)
}

/// Two links under a trunk that floats: a ball joint locks the second hinge, with which the first one goes, so that a rod to the first link
/// holds nothing.
fn implied() -> (Mechanism, State) {
    let hinged = |name, parent, axis| link(name, Some(parent), JointKind::Revolute, axis, 0.2);
    let bodies = vec![trunk(), hinged("upper", 0, Vector3::x()), hinged("lower", 1, Vector3::y())];
    let mut mechanism = Mechanism::new("implied", Vector3::new(0.0, 0.0, -9.81), bodies).unwrap();
    let state = State::zero(&mechanism);
    mechanism.loops.push(pin(&mechanism, &state, (2, Vector3::new(0.2, 0.1, 0.1)), Some(1)));
    let end = |body, place| Attachment { body: Some(body), frame: frame(place, Vector3::z()) };
    let (a, b) = (end(1, Vector3::new(0.0, 0.3, -0.1)), end(0, Vector3::new(0.2, -0.2, 0.1)));
    let place = |end: &Attachment| end.place(&body_states(&mechanism, &state)).0;
    let kind = LoopKind::Distance((place(&a) - place(&b)).norm());
    mechanism.loops.push(LoopJoint { name: "rod".into(), kind, a, b });
    let coordinate = |body: usize| {
        let joint = &mechanism.bodies[body].joint;
        Coordinate { body, position: joint.position_index, freedom: joint.velocity_index }
    };
    let (follower, leader) = (coordinate(2), coordinate(1));
    mechanism.mimics.push(Mimic {
        name: "lower".into(),
        follower,
        leader,
        multiplier: 2.0,
        offset: 0.0,
        more: Vec::new(),
        over_time: None,
    });
    (mechanism, state)
}

#[test]
fn freedoms_are_counted_right_whatever_takes_them() {
    for ((mechanism, state), redundant, freedoms) in
        [(leg(), 0, 6), (locked(), 2, 2), (sleeve(), 1, 6), (implied(), 3, 6)]
    {
        let found = redundancy(&mechanism, &state);
        let name = &mechanism.name;
        assert_eq!((found.count(), found.degrees_of_freedom(&mechanism)), (redundant, freedoms), "{name}: {found:?}");
    }
}

#[test]
fn the_energy_is_kept_to_rounding_where_loops_end_in_the_world_however_short_the_steps() {
    for (mechanism, start) in [leg(), locked()] {
        let mut start = start;
        assemble(&mechanism, &mut start).unwrap();
        let total = |state: &State| energy(&mechanism, &body_states(&mechanism, state));
        let before = total(&start);
        for step in [1e-2, 1e-3, 1e-4] {
            let mut state = start.clone();
            run(&mechanism, &mut state, 6, step, 0.1);
            let off = (total(&state).total() - before.total()).abs() / before.kinetic;
            // Up to 1000 steps that round; 5e-5 with pivots that only regularisation keeps from zero.
            assert!(off < 1e-11, "{}, steps of {step} s: {off:.1e}", mechanism.name);
        }
    }
}
