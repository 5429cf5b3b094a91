//! Bodies have the masses and inertias of their links, and what these cannot move is refused by name.

use super::{fixed, floating, joint, link, random_positions, read, robot, zoo};
use crate::common::Numbers;
use catena::mechanism::description::joint::Pose;
use catena::mechanism::motion::kinematics::body_states;
use catena::model::{Base, Model, ModelError, ModelOptions, ReductionRule};
use catena::scene::Element;
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};
use std::time::{Duration, Instant};

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
fn a_rod_without_any_width_is_refused_on_every_joint_that_lets_it_spin_about_itself_however_it_lies() {
    for kind in ["continuous", "spherical", "floating"] {
        for turn in ["0 0 0", "0.3 -1.2 2.5", "2 0.7 -0.4"] {
            let text = robot(&[
                "<link name=\"base\"/>".to_string(),
                link("rod", 1.0, "0 0 0", "0 0 0", [0.0, 0.1, 0.1]),
                joint("joint", kind, "base", "rod", "0 0 0", turn, "1 0 0"),
            ]);
            let refused = matches!(
                Model::new(read(&text), &ModelOptions::default()),
                Err(ModelError::NoInertia { element: Element::Joint(name), .. }) if name == "joint"
            );
            assert!(refused, "{kind}, turned by {turn}");
            // A glass fibre of a micrometre spins.
            let fibre = text.replace("ixx=\"0\"", "ixx=\"1e-13\"");
            assert!(fibre != text && Model::new(read(&fibre), &ModelOptions::default()).is_ok(), "{kind}, {turn}");
        }
    }
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
