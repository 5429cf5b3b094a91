//! What has a plane and what has none, and which equations closures have there.

use super::{KINDS, Lies, closure, random_loops};
use crate::common::Numbers;
use crate::in_plane::random_tree;
use crate::models;
use catena::mechanism::description::closure::{LoopJoint, LoopKind};
use catena::mechanism::description::joint::JointKind;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::mechanism::structure::planar_loops::PlanarEquation;
use catena::mechanism::structure::plane::Plane;
use nalgebra::{Rotation3, Vector3};

#[test]
fn only_what_joints_keep_in_a_plane_has_one() {
    let has = |mechanism: &Mechanism| Plane::of(mechanism).is_some();
    for seed in 0..40 {
        let mut numbers = Numbers::new(seed);
        let normal = Vector3::from_fn(|_, _| numbers.next(-1.0, 1.0));
        let mut model = random_tree(seed, 30, normal.normalize());
        let plane = Plane::of(&model.mechanism).unwrap_or_else(|| panic!("tree {seed} has no plane"));
        assert!(plane.normal().cross(&normal.normalize()).norm() < 1e-13, "tree {seed}: {plane:?}");

        // A joint that is off by little more than rounding leaves the plane by as much.
        let joint = &mut model.mechanism.bodies[seed as usize % 30].joint;
        joint.on_parent.rotation *= Rotation3::new(Vector3::new(3e-12, 4e-12, 0.0));
        assert!(!has(&model.mechanism), "tree {seed}");
    }
    for kind in models::JOINT_KINDS {
        // Two slides always have a plane, two hinges that are not parallel never.
        assert_eq!(has(&models::one_joint(kind).mechanism), kind == JointKind::Prismatic, "{kind:?}");
    }
    assert!(has(&models::chain(1).mechanism) && !has(&models::chain(2).mechanism));

    let chain = models::planar_chain(3).mechanism;
    assert!(has(&chain));
    for (name, forces) in models::every_force(&chain) {
        assert!(has(&Mechanism { forces, ..chain.clone() }), "{name}");
    }
    assert!(!has(&Mechanism::new("nothing", models::gravity(), Vec::new()).expect("nothing")));
}

#[test]
fn redundant_equations_vanish_in_the_plane() {
    for (seed, (kind, lies, rows)) in KINDS.into_iter().enumerate() {
        let model = random_loops(seed as u64, kind, lies);
        let plane = Plane::of(&model.mechanism).expect("a plane");
        let zero = body_states(&model.mechanism, &State::zero(&model.mechanism));
        let equations = plane.equations(&model.mechanism.loops[0], &zero).expect("fits");
        assert_eq!(equations.len(), rows, "{kind:?} {lies:?}: {equations:?}");
        for equation in equations {
            let directions = match equation {
                PlanarEquation::Slide(along) => vec![along],
                PlanarEquation::Square(on_a, on_b) => vec![on_a, on_b],
                PlanarEquation::Distance { .. } => vec![],
            };
            for direction in directions {
                assert!((direction.norm() - 1.0).abs() < 1e-14 && direction.dot(&plane.normal()).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn closures_that_leave_the_plane_have_none() {
    let tree = random_tree(3, 8, Vector3::new(0.3, -0.5, 0.7));
    let mut numbers = Numbers::new(5);
    let ends = [Some(7), Some(2)];
    let has = |joint: LoopJoint| Plane::of(&Mechanism { loops: vec![joint], ..tree.mechanism.clone() }).is_some();
    let oblique =
        [LoopKind::Revolute, LoopKind::Prismatic, LoopKind::Cylindrical, LoopKind::Universal, LoopKind::Planar];
    for kind in oblique {
        assert!(!has(closure(&tree, kind, Lies::Oblique, ends, &mut numbers)), "{kind:?}");
    }
    let level = [
        (LoopKind::Revolute, Lies::Along),
        (LoopKind::Universal, Lies::Across),
        (LoopKind::Spherical, Lies::Oblique),
        (LoopKind::Fixed, Lies::Oblique),
        (LoopKind::Prismatic, Lies::Across),
        (LoopKind::Cylindrical, Lies::Across),
        (LoopKind::Planar, Lies::Along),
    ];
    let normal = Plane::of(&tree.mechanism).expect("a plane").normal();
    let bodies = body_states(&tree.mechanism, &tree.state);
    for (kind, lies) in level {
        let joint = closure(&tree, kind, lies, ends, &mut numbers);
        assert!(has(joint.clone()), "{kind:?} {lies:?}");
        // One end higher than the other, by more than rounding.
        let mut uneven = joint.clone();
        uneven.a.frame.translation.vector += bodies[7].rotation.transpose() * normal * 1e-9;
        assert!(!has(uneven), "{kind:?} {lies:?} at different heights");
        let mut leaning = joint;
        leaning.a.frame.rotation *= Rotation3::new(Vector3::new(1e-9, 2e-9, 0.0));
        assert_eq!(has(leaning), kind == LoopKind::Spherical, "{kind:?} {lies:?} with axes that are off");
    }
    for (kind, lies) in
        [(LoopKind::Prismatic, Lies::Along), (LoopKind::Cylindrical, Lies::Along), (LoopKind::Planar, Lies::Across)]
    {
        let mut joint = closure(&tree, kind, lies, ends, &mut numbers);
        joint.a.frame.translation.vector += bodies[7].rotation.transpose() * normal * 0.3;
        assert!(has(joint), "{kind:?} {lies:?} slides along the normal");
    }
}
