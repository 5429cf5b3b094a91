//! The reduction keeps the physics: masses, centres, inertias and the pose of every link are those of the URDF.

use crate::common::{Numbers, literal_link_poses, rotation_angle};
use catena::kinematics::body_states;
use catena::model::{Base, JointKind, Model, ModelError, ModelOptions, Pose, ReductionRule};
use catena::scene::{Element, PackagePath, Robot, robot_from_text};
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use std::path::Path;
use std::time::{Duration, Instant};

fn read(text: &str) -> Robot {
    robot_from_text(text, Path::new("robot.urdf"), &PackagePath::default()).expect("a good URDF")
}

fn fixed(text: &str) -> Model {
    Model::new(read(text), &ModelOptions::default()).expect("a good model")
}

fn floating(text: &str, base_pose: Pose) -> Model {
    Model::new(read(text), &ModelOptions { base: Base::Floating, base_pose, ..Default::default() })
        .expect("a good model")
}

fn link(name: &str, mass: f64, center: &str, rpy: &str, moments: [f64; 3]) -> String {
    let [x, y, z] = moments;
    format!(
        r#"<link name="{name}"><inertial><origin xyz="{center}" rpy="{rpy}"/><mass value="{mass}"/><inertia ixx="{x}" ixy="0" ixz="0" iyy="{y}" iyz="0" izz="{z}"/></inertial></link>"#
    )
}

fn joint(name: &str, kind: &str, parent: &str, child: &str, xyz: &str, rpy: &str, axis: &str) -> String {
    format!(
        r#"<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/></joint>"#
    )
}

fn robot(parts: &[String]) -> String {
    format!("<robot name=\"r\">\n{}\n</robot>", parts.join("\n"))
}

/// A robot with every joint type, fixed joints between, skew frames and rotated inertias.
fn zoo() -> String {
    let kinds = ["revolute", "prismatic", "planar", "spherical", "floating", "continuous", "fixed"];
    let mut parts = vec![link("l0", 1.5, "0.1 0.2 -0.3", "0.1 0.2 0.3", [0.1, 0.2, 0.25])];
    for index in 1..22 {
        let s = index as f64;
        let name = format!("l{index}");
        let center = format!("{} {} {}", 0.1 * s.sin(), 0.1 * s.cos(), 0.05 * s);
        let rpy = format!("{} {} {}", s.sin(), (2.0 * s).cos(), 3.0 * (3.0 * s).sin());
        parts.push(link(&name, 0.3 + 0.1 * s, &center, &rpy, [0.02, 0.03 + 0.001 * s, 0.04]));
        let parent = format!("l{}", (index * 5) / 7);
        let axis = format!("{} {} {}", (5.0 * s).sin(), (7.0 * s).cos(), 0.4);
        let origin = format!("{} {} {}", 0.3 * (4.0 * s).sin(), 0.2, 0.1 * s);
        parts.push(joint(&format!("j{index}"), kinds[index % 7], &parent, &name, &origin, &rpy, &axis));
    }
    robot(&parts)
}

/// Random user coordinates for every moving joint.
fn random_positions(model: &Model, numbers: &mut Numbers) -> Vec<(String, Vec<f64>)> {
    let moving = model.joints.iter().filter_map(|joint| Some((joint, joint.body?)));
    moving
        .map(|(joint, body)| {
            // As many as there are degrees of freedom: roll, pitch, yaw for rotations.
            let count = model.mechanism.bodies[body].joint.kind.velocity_count();
            (joint.name.clone(), (0..count).map(|_| numbers.next(-1.5, 1.5)).collect())
        })
        .collect()
}

#[test]
fn fusing_a_fixed_joint_gives_the_composite_body_computed_by_hand() {
    // Two point-symmetric masses of 2 kg and 1 kg, 3 m apart along y of the first link: the centre is 1 m from the
    // first, and I = Σ I_i + m₁ 1² + m₂ 2² = 6 kg m² more across y. The second link is turned by 90° about z, so its
    // moments about x and y change places.
    let text = robot(&[
        "<link name=\"base\"/>".to_string(),
        link("a", 2.0, "0 0 0", "0 0 0", [1.0, 2.0, 2.5]),
        link("b", 1.0, "0 0 0", "0 0 0", [0.3, 0.5, 0.7]),
        joint("hinge", "continuous", "base", "a", "0 0 1", "0 0 0", "1 0 0"),
        joint("weld", "fixed", "a", "b", "0 3 0", "0 0 1.5707963267948966", "1 0 0"),
    ]);
    let model = fixed(&text);
    assert_eq!(model.mechanism.bodies.len(), 1);
    let body = &model.mechanism.bodies[0];
    assert_eq!((body.name.as_str(), body.mass), ("a", 3.0));
    let wanted = Vector3::new(1.0 + 0.5 + 6.0, 2.0 + 0.3, 2.5 + 0.7 + 6.0);
    assert!((body.inertia - wanted).amax() < 1e-14, "{}", body.inertia);
    // The link frames: a is 1 m below the centre along y, b 2 m above it and turned.
    assert!((model.links[1].in_body.translation.vector - Vector3::new(0.0, -1.0, 0.0)).amax() < 1e-15);
    assert!((model.links[2].in_body.translation.vector - Vector3::new(0.0, 2.0, 0.0)).amax() < 1e-15);
    let turn = Rotation3::from_euler_angles(0.0, 0.0, std::f64::consts::FRAC_PI_2);
    assert!((model.links[2].in_body.rotation.matrix() - turn.matrix()).amax() < 1e-15);
    let reductions: Vec<_> = model.reductions.iter().map(|r| (r.rule, r.link.as_str(), r.into.as_str())).collect();
    assert_eq!(reductions, [(ReductionRule::FixedBase, "base", "world"), (ReductionRule::FusedWithParent, "b", "a")]);
}

#[test]
fn total_mass_centre_and_inertia_are_the_sums_over_links() {
    let base_pose = Pose::from_parts(Translation3::new(1.0, -2.0, 3.0), Rotation3::from_euler_angles(0.3, -0.4, 2.0));
    let model = floating(&zoo(), base_pose);
    let mut numbers = Numbers::new(7);
    for state in [model.zero_state(), model.initial_state(&random_positions(&model, &mut numbers), &[], None).unwrap()]
    {
        let bodies = body_states(&model.mechanism, &state);
        // From the bodies.
        let (mut mass, mut center, mut inertia) = (0.0, Vector3::zeros(), Matrix3::zeros());
        let about_origin = |m: f64, c: Vector3<f64>| (Matrix3::identity() * c.norm_squared() - c * c.transpose()) * m;
        for (body, state) in model.mechanism.bodies.iter().zip(&bodies) {
            mass += body.mass;
            center += state.position * body.mass;
            let turned = state.rotation * Matrix3::from_diagonal(&body.inertia) * state.rotation.transpose();
            inertia += turned + about_origin(body.mass, state.position);
        }
        // From the links, by the URDF.
        let (mut link_mass, mut link_center, mut link_inertia) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for (index, link) in model.robots[0].robot.links.iter().enumerate() {
            let (position, rotation) = model.link_pose(&bodies, index);
            let own = link.inertial.as_ref().unwrap();
            let at = position + rotation * own.origin.translation.vector;
            let turn = rotation * own.origin.rotation.matrix();
            link_mass += own.mass;
            link_center += at * own.mass;
            link_inertia += turn * own.inertia * turn.transpose() + about_origin(own.mass, at);
            assert!((model.link_state(&bodies, index).center_of_mass - at).amax() < 1e-13);
        }
        assert!((mass - link_mass).abs() < 1e-13 * mass);
        assert!((center - link_center).amax() < 1e-13 * center.amax());
        assert!((inertia - link_inertia).amax() < 1e-13 * inertia.amax());
    }
}

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
fn the_body_frame_is_the_principal_frame_of_tiny_parts_too() {
    // A grain of 1 mg whose inertia is given in turned axes; the moments must come back to rounding.
    let rotation = Rotation3::from_euler_angles(0.4, 0.9, -2.0).into_inner();
    let moments = Vector3::new(2e-9, 3e-9, 4e-9);
    let i = rotation * Matrix3::from_diagonal(&moments) * rotation.transpose();
    let inertia = format!(
        r#"<link name="grain"><inertial><mass value="1e-6"/><inertia ixx="{:e}" ixy="{:e}" ixz="{:e}" iyy="{:e}" iyz="{:e}" izz="{:e}"/></inertial></link>"#,
        i[(0, 0)],
        i[(0, 1)],
        i[(0, 2)],
        i[(1, 1)],
        i[(1, 2)],
        i[(2, 2)]
    );
    let model = floating(&robot(&[inertia]), Pose::identity());
    let body = &model.mechanism.bodies[0];
    let mut sorted: Vec<f64> = body.inertia.iter().copied().collect();
    sorted.sort_by(f64::total_cmp);
    for (found, wanted) in sorted.iter().zip(moments.iter()) {
        assert!((found / wanted - 1.0).abs() < 1e-14, "{found} is not {wanted}");
    }
    let axes = model.links[0].in_body.inverse().rotation.into_inner();
    let back = axes * Matrix3::from_diagonal(&body.inertia) * axes.transpose();
    assert!((back - i).amax() < 1e-14 * 4e-9);
    assert!((axes.determinant() - 1.0).abs() < 1e-14);
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

#[test]
fn negative_inertias_are_refused_unless_fusing_mends_them() {
    let bad = link("bad", 1.0, "0 0 0", "0 0 0", [-0.1, 1.0, 1.0]);
    let alone = robot(&[
        "<link name=\"base\"/>".to_string(),
        bad.clone(),
        joint("hinge", "continuous", "base", "bad", "0 0 0", "0 0 0", "0 1 0"),
    ]);
    match Model::new(read(&alone), &ModelOptions::default()).unwrap_err() {
        ModelError::NegativeInertia { line, link, moments, mass, .. } => {
            assert_eq!((line, link.as_str(), moments, mass), (3, "bad", [-0.1, 1.0, 1.0], 1.0));
        }
        other => panic!("{other}"),
    }
    let mended = robot(&[
        "<link name=\"base\"/>".to_string(),
        link("good", 1.0, "0 0 0", "0 0 0", [1.0, 1.0, 1.0]),
        bad,
        joint("hinge", "continuous", "base", "good", "0 0 0", "0 0 0", "0 1 0"),
        joint("weld", "fixed", "good", "bad", "0 0 0", "0 0 0", "0 1 0"),
    ]);
    assert!((fixed(&mended).mechanism.bodies[0].inertia - Vector3::new(0.9, 2.0, 2.0)).amax() < 1e-15);
}

#[test]
fn point_masses_move_but_motions_without_inertia_are_refused() {
    let point = |center: &str| {
        robot(&[
            "<link name=\"base\"/>".to_string(),
            link("bob", 1.0, center, "0 0 0", [0.0, 0.0, 0.0]),
            joint("hinge", "continuous", "base", "bob", "0 0 0", "0 0 0", "0 1 0"),
        ])
    };
    assert_eq!(fixed(&point("0 0 -1")).mechanism.bodies.len(), 1);
    for on_the_axis in ["0 0 0", "0 2 0"] {
        match Model::new(read(&point(on_the_axis)), &ModelOptions::default()).unwrap_err() {
            ModelError::NoInertia { line, element, child, .. } => {
                assert_eq!((line, element, child.as_str()), (4, Element::Joint("hinge".to_string()), "bob"));
            }
            other => panic!("{other}"),
        }
    }
    // Two joints about one axis with nothing between: only their sum is determined.
    let text = robot(&[
        "<link name=\"base\"/>".to_string(),
        "<link name=\"ring\"/>".to_string(),
        link("arm", 1.0, "0 0 0.5", "0 0 0", [0.1, 0.1, 0.01]),
        joint("first", "continuous", "base", "ring", "0 0 0", "0 0 0", "0 1 0"),
        joint("second", "continuous", "ring", "arm", "0 0 0", "0 0 0", "0 1 0"),
    ]);
    assert!(matches!(
        Model::new(read(&text), &ModelOptions::default()).unwrap_err(),
        ModelError::NoInertia { element: Element::Joint(name), .. } if name == "first"
    ));
}

#[test]
fn motions_that_joints_further_out_undo_are_found_through_links_without_mass() {
    let point = |name: &str| link(name, 1.0, "0.3 0 0.5", "0 0 0", [0.0; 3]);
    let nothing = |name: &str| format!("<link name=\"{name}\"/>");
    let chain = |[upper, middle]: [String; 2], kinds: [&str; 3], arm: &str| {
        let [one, two, three] = kinds;
        let text = robot(&[
            nothing("base"),
            upper,
            middle,
            point("lower"),
            joint("one", one, "base", "upper", "0 0 0", "0 0 0", "0 0 1"),
            joint("two", two, "upper", "middle", arm, "0 0 0", "0 0 1"),
            joint("three", three, "middle", "lower", arm, "0 0 0", "0 0 1"),
        ]);
        match Model::new(read(&text), &ModelOptions::default()) {
            Ok(model) => model.mechanism.bodies.len().to_string(),
            Err(ModelError::NoInertia { element: Element::Joint(name), .. }) => name,
            Err(other) => panic!("{other}"),
        }
    };
    let hinges = ["continuous"; 3];
    // Two hinges put a point anywhere in the plane: the third has nothing left to do, unless there is a mass on the way.
    assert_eq!(chain([nothing("upper"), nothing("middle")], hinges, "1 0 0"), "one");
    assert_eq!(chain([point("upper"), nothing("middle")], hinges, "1 0 0"), "3");
    assert_eq!(chain([nothing("upper"), point("middle")], hinges, "1 0 0"), "3");
    // Hinges about one line, and a slide along it between them.
    let slide_between = ["continuous", "prismatic", "continuous"];
    assert_eq!(chain([nothing("upper"), nothing("middle")], slide_between, "0 0 1"), "one");
    assert_eq!(chain([point("upper"), nothing("middle")], slide_between, "0 0 1"), "3");
    // Two slides along one line, the inner one with nothing of its own.
    assert_eq!(chain([nothing("upper"), nothing("middle")], ["continuous", "prismatic", "prismatic"], "0 0 1"), "two");
}

#[test]
fn thousands_of_point_masses_are_looked_at_in_no_time() {
    let count = 3000;
    let mut elements = vec!["<link name=\"l0\"/>".to_string()];
    for number in 1..=count {
        let (name, above) = (format!("l{number}"), format!("l{}", number - 1));
        elements.push(link(&name, 1.0, "0 0 -0.1", "0 0 0", [0.0; 3]));
        elements.push(joint(&format!("j{number}"), "continuous", &above, &name, "0 0 -0.1", "0 0 0", "0 1 0"));
    }
    let robot = read(&robot(&elements));
    let clock = Instant::now();
    let model = Model::new(robot, &ModelOptions::default()).unwrap();
    let took = clock.elapsed();
    assert_eq!(model.mechanism.bodies.len(), count);
    // With work that grows as the cube of their number it is minutes.
    assert!(took < Duration::from_secs(5), "{took:?}");
}

#[test]
fn user_coordinates_come_back() {
    let base_pose = Pose::from_parts(Translation3::new(1.0, -2.0, 3.0), Rotation3::from_euler_angles(0.3, -0.4, 2.0));
    let model = floating(&zoo(), base_pose);
    let mut numbers = Numbers::new(11);
    for _ in 0..20 {
        let positions = random_positions(&model, &mut numbers);
        let velocities = random_positions(&model, &mut numbers);
        let state = model.initial_state(&positions, &velocities, None).unwrap();
        for ((name, given), (_, rates)) in positions.iter().zip(&velocities) {
            let joint = model.joint(name).unwrap();
            let (position, velocity) = model.joint_user_coordinates(joint, &state.position, &state.velocity);
            let kind = model.mechanism.bodies[model.joints[joint].body.unwrap()].joint.kind;
            let wanted: Vec<f64> = match kind {
                JointKind::Spherical => quaternion(given).to_vec(),
                JointKind::Floating => [given[..3].to_vec(), quaternion(&given[3..]).to_vec()].concat(),
                _ => given.clone(),
            };
            close(&position, &wanted, 1e-13, name);
            close(&velocity, rates, 1e-13, name);
        }
    }
    // Joints that do not move have no coordinates.
    let weld = model.joints.iter().position(|joint| joint.kind.name() == "fixed").unwrap();
    let state = model.zero_state();
    assert_eq!(model.joint_user_coordinates(weld, &state.position, &state.velocity), (vec![], vec![]));
}

fn quaternion(rpy: &[f64]) -> [f64; 4] {
    let q = UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]);
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    [sign * q.w, sign * q.i, sign * q.j, sign * q.k]
}

#[track_caller]
fn close(found: &[f64], wanted: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), wanted.len(), "{what}");
    for (found, wanted) in found.iter().zip(wanted) {
        assert!((found - wanted).abs() < tolerance, "{what}: {found} is not {wanted}");
    }
}

#[test]
fn a_floating_base_starts_at_its_pose_with_the_velocity_of_its_origin() {
    let base_pose = Pose::from_parts(Translation3::new(1.0, -2.0, 3.0), Rotation3::from_euler_angles(0.3, -0.4, 2.0));
    let text = robot(&[link("box", 2.0, "0.5 0 0", "0.1 0.2 0.3", [0.1, 0.2, 0.25])]);
    let model = floating(&text, base_pose);
    let state = model.initial_state(&[], &[], Some([1.0, 2.0, 3.0, 0.1, 0.2, 0.3])).unwrap();
    let bodies = body_states(&model.mechanism, &state);
    let (position, rotation) = model.link_pose(&bodies, 0);
    assert!((position - base_pose.translation.vector).amax() < 1e-15);
    assert!((rotation - base_pose.rotation.matrix()).amax() < 1e-15 * 2.0);
    let (linear, angular) = model.link_velocity(&bodies, 0);
    let omega = Vector3::new(0.1, 0.2, 0.3);
    let arm = base_pose.rotation * Vector3::new(0.5, 0.0, 0.0);
    assert!((angular - omega).amax() < 1e-15);
    assert!((linear - (Vector3::new(1.0, 2.0, 3.0) + omega.cross(&arm))).amax() < 1e-14);
    let (_, velocity) = model.joint_user_coordinates(0, &state.position, &state.velocity);
    close(&velocity, &[1.0, 2.0, 3.0, 0.1, 0.2, 0.3], 1e-14, "base");
    assert_eq!(model.joints[0].name, "base");

    let fixed_base = fixed(&robot(&[link("box", 2.0, "0 0 0", "0 0 0", [0.1, 0.2, 0.25])]));
    let refused = fixed_base.initial_state(&[], &[], Some([0.0; 6])).unwrap_err();
    assert_eq!(refused, ModelError::BaseDoesNotFloat);
}

#[test]
fn the_name_of_the_floating_base_is_free() {
    let text = robot(&[
        link("trunk", 2.0, "0 0 0", "0 0 0", [0.1, 0.2, 0.25]),
        link("arm", 2.0, "0 0 1", "0 0 0", [0.1, 0.2, 0.25]),
        joint("base", "continuous", "trunk", "arm", "0 0 0", "0 0 0", "0 1 0"),
    ]);
    let model = floating(&text, Pose::identity());
    let names: Vec<&str> = model.moving_joints().collect();
    assert_eq!(names, ["trunk_floating_base", "base"]);
}

#[test]
fn wrong_initial_conditions_are_named() {
    let model = fixed(&robot(&[
        "<link name=\"base\"/>".to_string(),
        link("arm", 1.0, "0 0 0.5", "0 0 0", [0.1, 0.1, 0.01]),
        "<link name=\"tip\"/>".to_string(),
        joint("ball", "spherical", "base", "arm", "0 0 0", "0 0 0", "0 1 0"),
        joint("weld", "fixed", "arm", "tip", "0 0 0", "0 0 0", "0 1 0"),
    ]));
    let position = |name: &str, values: &[f64]| model.initial_state(&[(name.to_string(), values.to_vec())], &[], None);
    let velocity = |name: &str, values: &[f64]| model.initial_state(&[], &[(name.to_string(), values.to_vec())], None);
    let text = position("bull", &[0.0]).unwrap_err().to_string();
    assert_eq!(text, "there is no joint \"bull\"; the joints that move are \"ball\"");
    let text = position("weld", &[0.0]).unwrap_err().to_string();
    assert_eq!(text, "joint \"weld\" does not move (it is fixed); the joints that move are \"ball\"");
    let text = position("ball", &[0.0]).unwrap_err().to_string();
    assert_eq!(text, "the position of spherical joint \"ball\" needs 3 numbers (roll,pitch,yaw), not 1");
    let text = velocity("ball", &[0.0; 4]).unwrap_err().to_string();
    assert_eq!(text, "the velocity of spherical joint \"ball\" needs 3 numbers (wx,wy,wz), not 4");
    assert!(matches!(velocity("ball", &[0.0, f64::NAN, 0.0]), Err(ModelError::NotFinite { .. })));
    assert!(position("ball", &[0.1, 0.2, 0.3]).is_ok());
}

#[test]
fn a_continuous_joint_has_no_limits_whatever_its_file_says() {
    let limits = |kind: &str, range: &str| {
        let limit = format!("<limit {range} effort=\"1\" velocity=\"1\"/></joint>");
        let text = robot(&[
            "<link name=\"base\"/>".to_string(),
            link("arm", 1.0, "0 0 0.5", "0 0 0", [0.1, 0.1, 0.01]),
            joint("hinge", kind, "base", "arm", "0 0 0", "0 0 0", "0 1 0").replace("</joint>", &limit),
        ]);
        let model = fixed(&text);
        let said = model.warnings.iter().filter(|warning| {
            warning.message == "lower and upper limits of 1 continuous joint are not read" && warning.line == Some(4)
        });
        let limits: Vec<_> = model.mechanism.limits.iter().map(|limit| (limit.lower, limit.upper)).collect();
        (limits, said.count())
    };
    let range = "lower=\"-0.5\" upper=\"0.25\"";
    assert_eq!(limits("revolute", range), (vec![(-0.5, 0.25)], 0));
    assert_eq!(limits("continuous", range), (vec![], 1));
    assert_eq!(limits("revolute", "lower=\"-0.5\""), (vec![(-0.5, f64::INFINITY)], 0));
    // What leaves nothing or everything free is no range.
    for nothing in ["", "lower=\"0\" upper=\"0\"", "lower=\"-inf\" upper=\"inf\""] {
        assert_eq!(limits("revolute", nothing), (vec![], 0), "{nothing}");
        assert_eq!(limits("continuous", nothing), (vec![], 0), "{nothing}");
    }
}

#[test]
fn angles_without_digits_are_refused_and_lengths_are_not() {
    let start = |kind: &str, values: &[f64]| {
        let text = robot(&[
            "<link name=\"base\"/>".to_string(),
            link("arm", 1.0, "0 0 0.5", "0 0 0", [0.1, 0.1, 0.01]),
            joint("shoulder", kind, "base", "arm", "0 0 0", "0 0 0", "0 1 0"),
        ]);
        fixed(&text).initial_state(&[("shoulder".to_string(), values.to_vec())], &[], None)
    };
    let refused = start("continuous", &[-1e300]).unwrap_err().to_string();
    assert!(refused.starts_with("the position of joint \"shoulder\" is -1e300 rad"), "{refused}");
    for (kind, values) in [("revolute", &[1.01e8][..]), ("planar", &[0.0, 0.0, 1.01e8])] {
        assert!(matches!(start(kind, values), Err(ModelError::TurnedTooOften { .. })), "{kind}");
    }
    assert_eq!(start("continuous", &[1e8]).unwrap().position, [1e8]);
    assert_eq!(start("prismatic", &[1e9]).unwrap().position, [1e9]);
    assert_eq!(start("planar", &[1e9, -1e9, 1.0]).unwrap().position, [1e9, -1e9, 1.0]);
    assert!(start("spherical", &[1e300, 0.0, 0.0]).is_ok());
}

#[test]
fn numbers_that_overflow_are_refused() {
    let text = robot(&[
        "<link name=\"base\"/>".to_string(),
        "<link name=\"a\"/>".to_string(),
        link("b", 1.0, "0 0 0", "0 0 0", [1.0, 1.0, 1.0]),
        joint("one", "fixed", "base", "a", "1e308 0 0", "0 0 0", "0 0 1"),
        joint("two", "fixed", "a", "b", "1e308 0 0", "0 0 0", "0 0 1"),
    ]);
    let refused = Model::new(read(&text), &ModelOptions::default()).unwrap_err();
    assert!(matches!(&refused, ModelError::Overflow { line: 4, link, .. } if link == "b"), "{refused}");
    let heavy = robot(&[
        link("a", 1e308, "0 0 0", "0 0 0", [1.0, 1.0, 1.0]),
        link("b", 1e308, "0 0 0", "0 0 0", [1.0, 1.0, 1.0]),
        joint("weld", "fixed", "a", "b", "0 0 0", "0 0 0", "0 0 1"),
    ]);
    let options = ModelOptions { base: Base::Floating, ..Default::default() };
    assert!(matches!(Model::new(read(&heavy), &options), Err(ModelError::Overflow { line: 2, .. })));
}
