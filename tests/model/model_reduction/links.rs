//! Every link is part of the body it should be, or of none, and moves as the URDF says.

use super::{fixed, floating, joint, link, random_positions, read, robot, zoo};
use crate::common::{Numbers, literal_link_poses, rotation_angle};
use catena::mechanism::description::joint::Pose;
use catena::mechanism::motion::kinematics::body_states;
use catena::model::{Base, Model, ModelError, ModelOptions, ReductionRule};
use catena::scene::Element;
use nalgebra::{Rotation3, Translation3, Vector3};

#[test]
fn every_link_is_where_the_urdf_puts_it() {
    let base_pose = Pose::from_parts(Translation3::new(1.0, -2.0, 3.0), Rotation3::from_euler_angles(0.3, -0.4, 2.0));
    let options = |base| ModelOptions { base, base_pose, ..Default::default() };
    let mut numbers = Numbers::new(1);
    for base in [Base::Fixed, Base::Floating] {
        let model = Model::new(read(&zoo()), &options(base)).unwrap();
        for sample in 0..20 {
            let mut positions = random_positions(&model, &mut numbers);
            if sample == 0 {
                positions.clear();
            }
            let state = model.initial_state(&positions, &[], None).unwrap();
            let bodies = body_states(&model.mechanism, &state);
            let base_at = positions.iter().find(|(name, _)| name == "base").map_or(base_pose, |(_, p)| {
                Pose::from_parts(Translation3::new(p[0], p[1], p[2]), Rotation3::from_euler_angles(p[3], p[4], p[5]))
            });
            for (index, literal) in literal_link_poses(&model.robots[0].robot, &base_at, &positions).iter().enumerate()
            {
                let (position, rotation) = model.link_pose(&bodies, index);
                let name = &model.links[index].name;
                assert!((position - literal.translation.vector).amax() < 1e-13, "{name} {base:?}");
                assert!(rotation_angle(&rotation, literal.rotation.matrix()) < 1e-13, "{name} {base:?}");
            }
        }
    }
}

#[test]
fn link_velocities_are_the_derivatives_of_link_poses() {
    let model = floating(&zoo(), Pose::identity());
    let mut numbers = Numbers::new(3);
    let positions = random_positions(&model, &mut numbers);
    let velocities = random_positions(&model, &mut numbers);
    let state = model.initial_state(&positions, &velocities, None).unwrap();
    let rates = state.velocity.clone();
    let before = body_states(&model.mechanism, &state);
    let moved = |sign: f64| {
        let mut moved = state.clone();
        moved.displace(&model.mechanism, &rates.iter().map(|rate| sign * 1e-5 * rate).collect::<Vec<_>>());
        body_states(&model.mechanism, &moved)
    };
    let (ahead, behind) = (moved(1.0), moved(-1.0));
    for index in 0..model.links.len() {
        let (velocity, angular) = model.link_velocity(&before, index);
        let (a, b) = (model.link_state(&ahead, index), model.link_state(&behind, index));
        assert!(((a.center_of_mass - b.center_of_mass) / 2e-5 - velocity).amax() < 1e-7);
        // The skew part of a small rotation is its rotation vector up to third order.
        let small = a.rotation * b.rotation.transpose();
        let skew = (small - small.transpose()) / 4e-5;
        let turned = Vector3::new(skew[(2, 1)], skew[(0, 2)], skew[(1, 0)]);
        assert!((turned - angular).amax() < 1e-7);
    }
}

#[test]
fn bodies_are_numbered_depth_first() {
    let model = fixed(&zoo());
    for (index, body) in model.mechanism.bodies.iter().enumerate() {
        assert!(body.parent.is_none_or(|parent| parent < index));
    }
    assert_eq!(model.links.len(), 22);
    let moving = model.robots[0].robot.joints.iter().filter(|joint| joint.kind.name() != "fixed").count();
    assert_eq!(model.mechanism.bodies.len(), moving);
}

#[test]
fn massless_leaves_are_held_until_none_is_left() {
    let text = robot(&[
        "<link name=\"base\"/>".to_string(),
        link("arm", 1.0, "0 0 0.5", "0 0 0", [0.1, 0.1, 0.01]),
        "<link name=\"wrist\"/>".to_string(),
        "<link name=\"flange\"/>".to_string(),
        "<link name=\"tool\"/>".to_string(),
        joint("shoulder", "continuous", "base", "arm", "0 0 0", "0 0 0", "0 1 0"),
        joint("elbow", "continuous", "arm", "wrist", "0 0 1", "0.1 0 0", "0 1 0"),
        joint("weld", "fixed", "wrist", "flange", "0 0 0.1", "0 0 0.2", "0 1 0"),
        joint("slide", "prismatic", "flange", "tool", "0 0.3 0", "0 0 0", "0 0 1"),
    ]);
    let model = fixed(&text);
    assert_eq!(model.mechanism.bodies.len(), 1);
    let rules: Vec<_> = model.reductions.iter().map(|r| (r.link.as_str(), r.rule, r.into.as_str())).collect();
    assert_eq!(
        rules,
        [
            ("base", ReductionRule::FixedBase, "world"),
            ("wrist", ReductionRule::MasslessLeaf, "arm"),
            ("flange", ReductionRule::FusedWithParent, "arm"),
            ("tool", ReductionRule::MasslessLeaf, "arm"),
        ]
    );
    let dropped: Vec<_> = model.warnings.iter().filter(|w| w.message.contains("held at zero")).collect();
    let elements: Vec<_> = dropped.iter().map(|w| w.element.clone().unwrap()).collect();
    assert_eq!(elements, [Element::Link("wrist".to_string()), Element::Link("tool".to_string())]);
    assert_eq!(dropped[0].line, Some(4));

    // They follow the arm at zero displacement.
    let positions = [("shoulder".to_string(), vec![0.7])];
    let bodies = body_states(&model.mechanism, &model.initial_state(&positions, &[], None).unwrap());
    for (index, literal) in literal_link_poses(&model.robots[0].robot, &Pose::identity(), &positions).iter().enumerate()
    {
        assert!((model.link_pose(&bodies, index).0 - literal.translation.vector).amax() < 1e-14);
    }
    let refused = model.initial_state(&[("elbow".to_string(), vec![0.1])], &[], None).unwrap_err();
    assert!(matches!(&refused, ModelError::JointDoesNotMove { known, .. } if known == &["shoulder"]), "{refused}");
}

#[test]
fn a_massless_link_inside_the_tree_stays_a_body() {
    let text = robot(&[
        "<link name=\"base\"/>".to_string(),
        "<link name=\"cross\"/>".to_string(),
        link("arm", 1.0, "0 0 0.5", "0 0 0", [0.1, 0.1, 0.01]),
        joint("first", "continuous", "base", "cross", "0 0 0", "0 0 0", "1 0 0"),
        joint("second", "continuous", "cross", "arm", "0 0 0", "0 0 0", "0 1 0"),
    ]);
    let model = fixed(&text);
    let masses: Vec<f64> = model.mechanism.bodies.iter().map(|body| body.mass).collect();
    assert_eq!(masses, [0.0, 1.0]);
}

#[test]
fn links_welded_to_the_world_are_no_bodies() {
    let arm = link("arm", 1.0, "0 0 0.5", "0 0 0", [0.1, 0.1, 0.01]);
    let parts = [
        link("table", 20.0, "0 0 0", "0 0 0", [1.0, 1.0, 1.0]),
        arm,
        joint("weld", "fixed", "world", "table", "0 0 1", "0 0 0.5", "0 0 1"),
        joint("hinge", "continuous", "table", "arm", "0 0 0.1", "0 0 0", "0 1 0"),
    ];
    let declared = [vec!["<link name=\"world\"/>".to_string()], parts.to_vec()].concat();
    for (text, links) in [(robot(&parts), 2), (robot(&declared), 3)] {
        let model = fixed(&text);
        assert_eq!((model.links.len(), model.mechanism.bodies.len()), (links, 1));
        assert_eq!(model.mechanism.total_mass(), 1.0);
        let table = model.link("table").unwrap();
        assert_eq!(model.links[table].body, None);
        let bodies = body_states(&model.mechanism, &model.zero_state());
        assert!((model.link_pose(&bodies, table).0 - Vector3::new(0.0, 0.0, 1.0)).amax() < 1e-15);
        let arm = model.link("arm").unwrap();
        assert!((model.link_pose(&bodies, arm).0 - Vector3::new(0.0, 0.0, 1.1)).amax() < 1e-15);
        let refused = Model::new(read(&text), &ModelOptions { base: Base::Floating, ..Default::default() });
        assert!(matches!(refused, Err(ModelError::BaseIsWorld { .. })));
    }
}
