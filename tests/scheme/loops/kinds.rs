//! Every kind of loop joint, and mimic relations, allow the motions that they should.

use super::{frame, run, total_energy};
use catena::instant::exerting::reactions::Reactions;
use catena::instant::start::assembly::assemble;
use catena::mechanism::description::closure::{Attachment, Coordinate, LoopJoint, LoopKind, Mimic};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::energy::{energy, violation};
use catena::mechanism::motion::gaps::mimic_gap;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use nalgebra::Vector3;

fn lump(joint: Joint) -> Body {
    Body { name: "lump".into(), parent: None, mass: 2.0, inertia: Vector3::new(0.05, 0.08, 0.1), joint }
}

#[test]
fn a_loop_joint_moves_like_the_tree_joint_of_its_kind() {
    let on_world = frame(Vector3::new(0.3, -0.2, 0.5), Vector3::new(0.4, 1.1, -0.3));
    let on_body = frame(Vector3::new(-0.3, 0.1, 0.2), Vector3::new(-0.2, 0.5, 0.9));
    let gravity = Vector3::new(1.0, -2.0, -9.81);
    let kinds = [
        (JointKind::Revolute, LoopKind::Revolute, vec![3.0]),
        (JointKind::Prismatic, LoopKind::Prismatic, vec![0.7]),
        (JointKind::Spherical, LoopKind::Spherical, vec![1.0, -2.0, 3.0]),
        (JointKind::Planar, LoopKind::Planar, vec![0.5, -0.6, 2.0]),
    ];
    for (tree_kind, loop_kind, velocity) in kinds {
        let joint = Joint::new("joint", tree_kind, on_world, on_body);
        let tree = Mechanism::new("tree", gravity, vec![lump(joint)]).unwrap();
        let mut tree_state = State::zero(&tree);
        tree_state.velocity.copy_from_slice(&velocity);
        let start = body_states(&tree, &tree_state)[0];

        let free = Joint::new("free", JointKind::Floating, Pose::identity(), Pose::identity());
        let mut closed = Mechanism::new("closed", gravity, vec![lump(free)]).unwrap();
        let (a, b) = (Attachment { body: None, frame: on_world }, Attachment { body: Some(0), frame: on_body });
        closed.loops.push(LoopJoint { name: "closure".into(), kind: loop_kind, a, b });
        let mut state = State::zero(&closed);
        state.position[..3].copy_from_slice(start.position.as_slice());
        state.position[3..]
            .copy_from_slice(&catena::mechanism::description::joint::wxyz_from_rotation(&start.rotation));
        state.velocity[..3].copy_from_slice(start.velocity.as_slice());
        state.velocity[3..].copy_from_slice((start.rotation.transpose() * start.angular_velocity).as_slice());
        assemble(&closed, &mut state).unwrap();

        run(&tree, &mut tree_state, 5, 0.02, 0.4);
        let (_, gap) = run(&closed, &mut state, 5, 0.02, 0.4);
        let (expected, got) = (body_states(&tree, &tree_state)[0], body_states(&closed, &state)[0]);
        let apart = (expected.position - got.position).norm() + (expected.rotation - got.rotation).norm();
        let rates = (expected.velocity - got.velocity).norm();
        let carried = Reactions::new(&tree).at(&tree_state.position, &tree_state.velocity).0[0];
        let mut of_closed = Reactions::new(&closed);
        let loops = of_closed.at(&state.position, &state.velocity).1;
        // On a plane or a line the carried torque is taken about the point of the body, which is the anchor.
        let wrench = (loops[0].force - carried.force).norm() + (loops[0].torque - carried.torque).norm();
        assert!(wrench < 1e-9 * (1.0 + carried.force.norm()), "{tree_kind:?}: {wrench:e} of {carried:?}");
        // The same discrete motion: the multipliers of a joint do what its reduced coordinates do.
        assert!(apart < 1e-12 && rates < 1e-11, "{tree_kind:?}: {apart:e} {rates:e}");
        assert!(gap < 1e-14, "{tree_kind:?}: {gap:e}");
    }
}

#[test]
fn loops_without_a_tree_joint_of_their_kind_stay_closed_and_conserve_energy() {
    let on_world = frame(Vector3::new(0.0, 0.0, 0.5), Vector3::new(0.1, 0.2, 0.3));
    let kinds = [
        (LoopKind::Cylindrical, on_world, 4),
        (
            LoopKind::Universal,
            on_world * frame(Vector3::zeros(), Vector3::new(std::f64::consts::FRAC_PI_2, 0.0, 0.0)),
            4,
        ),
        (LoopKind::Distance(0.5), frame(Vector3::new(0.5, 0.0, 0.5), Vector3::zeros()), 1),
        (LoopKind::Fixed, on_world, 6),
    ];
    for (kind, on_world, rows) in kinds {
        let place = frame(Vector3::new(0.0, 0.0, 0.5), Vector3::new(0.1, 0.2, 0.3));
        let arm = frame(Vector3::new(0.2, 0.0, 0.1), Vector3::zeros());
        let free = Joint::new("free", JointKind::Floating, place, arm);
        let mut closed = Mechanism::new("closed", Vector3::new(0.0, 0.0, -9.81), vec![lump(free)]).unwrap();
        let (a, b) = (Attachment { body: None, frame: on_world }, Attachment { body: Some(0), frame: arm });
        closed.loops.push(LoopJoint { name: "closure".into(), kind, a, b });
        assert_eq!(kind.rows(), rows);
        let mut state = State::zero(&closed);
        state.velocity.copy_from_slice(&[0.3, -0.2, 0.4, 1.0, 2.0, -1.5]);
        assemble(&closed, &mut state).unwrap();
        let start = total_energy(&closed, &state);
        let kinetic = energy(&closed, &body_states(&closed, &state)).kinetic;
        let (_, gap) = run(&closed, &mut state, 6, 0.01, 0.5);
        assert!(gap < 1e-14, "{kind:?}: {gap:e}");
        // Order 10 at h = 0.01 and rates of a few rad/s: below rounding.
        let drift = (total_energy(&closed, &state) - start).abs();
        assert!(drift < 1e-11, "{kind:?}: {drift:e}");
        if kind == LoopKind::Fixed {
            assert!(kinetic < 1e-25, "{kinetic:e}");
        }
    }
}

/// Two pendulums side by side whose angles are geared: the second turns `ratio` times as far, plus an offset.
fn geared(ratio: f64, offset: f64) -> (Mechanism, State) {
    let hinge = |name: &str| {
        let on_world = frame(Vector3::zeros(), Vector3::x() * std::f64::consts::FRAC_PI_2);
        let on_body = frame(Vector3::new(-0.5, 0.0, 0.0), Vector3::x() * std::f64::consts::FRAC_PI_2);
        Joint::new(name, JointKind::Revolute, on_world, on_body)
    };
    let bodies = ["first", "second"].map(|name| lump(hinge(name)));
    let mut mechanism = Mechanism::new("geared", Vector3::new(0.0, 0.0, -9.81), bodies.to_vec()).unwrap();
    let coordinate = |body| Coordinate { body, position: body, freedom: body };
    mechanism.mimics.push(Mimic {
        name: "second".into(),
        follower: coordinate(1),
        leader: coordinate(0),
        multiplier: ratio,
        offset,
        more: Vec::new(),
        over_time: None,
    });
    let mut state = State::zero(&mechanism);
    state.position.copy_from_slice(&[0.2, ratio * 0.2 + offset]);
    (mechanism, state)
}

#[test]
fn a_mimic_joint_follows_exactly_and_its_pair_moves_as_one_angle() {
    let (ratio, offset) = (-1.7, 0.4);
    let (mechanism, mut state) = geared(ratio, offset);
    let (mut angle, mut rate) = (0.2, 0.0);
    run(&mechanism, &mut state, 6, 0.02, 2.0);
    // Lagrange's equation of one angle: J (1 + r²) q̈ = −m g l (cos q + r cos(r q + o)).
    let inertia = 0.08 + 2.0 * 0.25;
    let pull =
        |q: f64| -2.0 * 9.81 * 0.5 * (q.cos() + ratio * (ratio * q + offset).cos()) / (inertia * (1.0 + ratio * ratio));
    let step = 1e-4;
    for _ in 0..20_000 {
        let (k1, l1) = (rate, pull(angle));
        let (k2, l2) = (rate + 0.5 * step * l1, pull(angle + 0.5 * step * k1));
        let (k3, l3) = (rate + 0.5 * step * l2, pull(angle + 0.5 * step * k2));
        let (k4, l4) = (rate + step * l3, pull(angle + step * k3));
        angle += step / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
        rate += step / 6.0 * (l1 + 2.0 * (l2 + l3) + l4);
    }
    let (gap, gap_rate) = mimic_gap(&mechanism.mimics[0], &state);
    assert!(gap.abs() < 1e-14 && gap_rate.abs() < 1e-13, "{gap:e} {gap_rate:e}");
    assert!((state.position[0] - angle).abs() < 1e-10, "{} {angle}", state.position[0]);
    assert!((state.velocity[0] - rate).abs() < 1e-9, "{} {rate}", state.velocity[0]);
}

#[test]
fn the_violation_of_a_run_counts_mimic_relations() {
    let (mechanism, mut state) = geared(-1.7, 0.4);
    state.position[1] += 1e-3;
    state.compensation[1] = 1e-17;
    state.velocity[1] += 0.5;
    let found = violation(&mechanism, &state, &body_states(&mechanism, &state));
    assert!((found.position - 1e-3).abs() < 1e-15 && found.velocity == 0.5, "{found:?}");
}
