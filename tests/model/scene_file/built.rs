//! The mechanism is the one that the scene file says: its robots, loops, springs and loads.

use super::{DOUBLE, ONE, build, folder, refusal};
use catena::mechanism::description::closure::LoopKind;
use catena::mechanism::motion::gaps::loop_gaps;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::model::Model;
use nalgebra::Vector3;

/// The largest gap of the first loop.
fn gap(model: &Model, state: &State) -> f64 {
    loop_gaps(&model.mechanism.loops[0], &body_states(&model.mechanism, state)).largest().0
}

#[test]
fn several_robots_stand_side_by_side_under_their_own_names() {
    let folder = folder("several");
    let text = "[[robot]]\nname = \"left\"\nurdf = \"double.urdf\"\npositions = { elbow = 0.5 }\n\
                [[robot]]\nname = \"ball\"\nurdf = \"ball.urdf\"\nbase = \"floating\"\n\
                pose = { position = [1, 2, 3], rpy = [0, 0, 1] }\nvelocity = { linear = [0, 0, 1], angular = [0, 0, 2] }\n\
                [[robot]]\nname = \"right\"\nurdf = \"double.urdf\"\npose = { position = [0, 1, 0] }\nvelocities = { elbow = 3 }";
    let (model, _, state) = build(&folder, text);
    let mechanism = &model.mechanism;
    let names: Vec<&str> = mechanism.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["left/upper", "left/lower", "ball/ball", "right/upper", "right/lower"]);
    let parents: Vec<Option<usize>> = mechanism.bodies.iter().map(|body| body.parent).collect();
    assert_eq!(parents, [None, Some(0), None, None, Some(3)]);
    let moving: Vec<&str> = model.moving_joints().collect();
    assert_eq!(moving, ["left/shoulder", "left/elbow", "ball/base", "right/shoulder", "right/elbow"]);
    assert_eq!(model.link("right/weight").map(|link| model.links[link].body), Some(Some(4)));
    let base = &model.joints[model.joint("ball/base").unwrap()];
    assert_eq!((base.parent_link.as_str(), base.child_link.as_str(), base.robot), ("world", "ball/ball", 1));

    let bodies = body_states(mechanism, &state);
    let (place, _) = model.link_pose(&bodies, model.link("ball/ball").unwrap());
    assert!((place - Vector3::new(1.0, 2.0, 3.0)).amax() < 1e-15);
    // The centre of mass, 0.1 m off the origin, moves with both velocities.
    let (velocity, turn) = model.link_velocity(&bodies, model.link("ball/ball").unwrap());
    assert!((velocity - Vector3::new(-0.2 * 1.0_f64.sin(), 0.2 * 1.0_f64.cos(), 1.0)).amax() < 1e-15, "{velocity}");
    assert!((turn - Vector3::new(0.0, 0.0, 2.0)).amax() < 1e-15);
    let joint = |name: &str| model.joint_user_coordinates(model.joint(name).unwrap(), &state.position, &state.velocity);
    assert_eq!(joint("left/elbow"), (vec![0.5], vec![0.0]));
    assert_eq!(joint("right/elbow"), (vec![0.0], vec![3.0]));
    // Both files of the same robot say the same, once.
    let dropped = model.warnings.iter().filter(|warning| warning.message.contains("has mass")).count();
    assert_eq!(dropped, 1);
}

#[test]
fn loops_springs_and_loads_find_links_that_are_fused_into_bodies_or_the_world() {
    let folder = folder("fused");
    let text = "[[robot]]\nname = \"arm\"\nurdf = \"double.urdf\"\npositions = { shoulder = 0.7, elbow = -0.4 }\n\
                [[loop]]\ntype = \"spherical\"\na = { link = \"weight\", position = [0.1, 0.2, 0.3] }\nb = { link = \"base\", position = [1, 2, 3] }\n\
                [[spring]]\na = { link = \"arm/weight\" }\nb = { link = \"upper\" }\nstiffness = 5\nrest_length = 0.1\n\
                [[load]]\nlink = \"weight\"\nposition = [0.1, 0, 0]\nforce = [1, 2, 3]\n\
                [[load]]\njoint = \"arm/elbow\"\neffort = 4\n\
                [[spring]]\njoint = \"elbow\"\nstiffness = 6\ndamping = 7\nrest = 8";
    let (model, _, state) = build(&folder, text);
    let bodies = body_states(&model.mechanism, &state);
    let frame = |link: &str| model.link_pose(&bodies, model.link(link).unwrap());
    let at = |link: &str, point: [f64; 3]| {
        let (place, axes) = frame(link);
        place + axes * Vector3::from(point)
    };
    let [closing] = &model.mechanism.loops[..] else { panic!("one loop") };
    assert_eq!((closing.name.as_str(), closing.kind), ("loop1", LoopKind::Spherical));
    assert_eq!((closing.a.body, closing.b.body), (Some(1), None));
    // Frames go through the principal axes of the bodies, which are turned: a rounding or two at a distance of 2 m.
    assert!((closing.a.place(&bodies).0 - at("weight", [0.1, 0.2, 0.3])).amax() < 1e-15);
    assert!((closing.b.place(&bodies).0 - Vector3::new(1.0, 2.0, 3.0)).amax() == 0.0);
    let forces = &model.mechanism.forces;
    assert!((forces.point_springs[0].a.place(&bodies).0 - at("weight", [0.0; 3])).amax() < 1e-15);
    assert!((forces.point_springs[0].b.place(&bodies).0 - at("upper", [0.0; 3])).amax() < 1e-15);
    let wrench = &forces.wrenches[0];
    let point = bodies[wrench.body].position + bodies[wrench.body].rotation * wrench.point;
    assert!((point - at("weight", [0.1, 0.0, 0.0])).amax() < 1e-15);
    assert_eq!(wrench.force, Vector3::new(1.0, 2.0, 3.0));
    assert_eq!((forces.joint_loads[0].freedom, forces.joint_loads[0].effort), (1, 4.0));
    let spring = &forces.joint_springs[0];
    assert_eq!((spring.coordinate.freedom, spring.stiffness, spring.rest), (1, 6.0, 8.0));
    assert_eq!((forces.joint_dampers[0].freedom, forces.joint_dampers[0].coefficient), (1, 7.0));
}

#[test]
fn loops_that_keep_an_orientation_take_it_from_the_start_of_the_file() {
    let folder = folder("orientation");
    let text = |kind: &str, axes: bool| {
        let axis = if axes { ", axis = [0, 1, 0]" } else { "" };
        // The tip of the lower rod is at (sin, 0, cos)-wise somewhere; the loop's point in the world is put there below.
        format!(
            "{ONE}positions = {{ shoulder = 0.7, elbow = -0.4 }}\n[[loop]]\ntype = \"{kind}\"\n\
             a = {{ link = \"lower\"{axis} }}\nb = {{ link = \"world\", position = [-0.644217687237691, 0, -0.764842187284489]{axis} }}"
        )
    };
    for (kind, axes) in [("prismatic", true), ("fixed", true), ("fixed", false)] {
        let (model, _, state) = build(&folder, &text(kind, axes));
        let gap = gap(&model, &state);
        assert!(gap < 1e-14, "{kind} {axes}: {gap:e}");
    }
    // And a rod without a length is as long as its ends are apart.
    let (model, _, state) = build(&folder, &text("distance", false).replace("-0.764842187284489", "2"));
    let LoopKind::Distance(length) = model.mechanism.loops[0].kind else { panic!("a distance") };
    assert!((length - 2.764842187284489).abs() < 1e-14, "{length}");
    assert!(gap(&model, &state) < 1e-15);
    let longer = text("distance", false) + "\nlength = 1.5";
    assert_eq!(build(&folder, &longer).0.mechanism.loops[0].kind, LoopKind::Distance(1.5));
}

#[test]
fn an_axis_that_is_not_of_length_one_is_normalised_with_a_warning() {
    let folder = folder("axis");
    let text = format!(
        "{ONE}[[loop]]\ntype = \"cylindrical\"\na = {{ link = \"lower\", axis = [0, 3, 4] }}\n\
         b = {{ link = \"world\", axis = [0, 0.6, 0.8] }}"
    );
    let (model, _, _) = build(&folder, &text);
    let warnings: Vec<String> = model.warnings.iter().map(ToString::to_string).collect();
    let axis: Vec<&String> = warnings.iter().filter(|warning| warning.contains("has length")).collect();
    assert!(axis.len() == 1 && axis[0].contains("scene.toml:5: loop \"loop1\": the axis has length 5"), "{warnings:?}");
    let z = model.mechanism.loops[0].b.frame.rotation.matrix().column(2).into_owned();
    assert!((z - Vector3::new(0.0, 0.6, 0.8)).amax() < 1e-15);
}

#[test]
fn loop_joints_of_a_urdf_close_loops() {
    let folder = folder("loop_joint");
    // As Dojo and RigidBodyDynamics.jl write it: the axis in the frames of both ends.
    let closing = r#"<loop_joint name="closure" type="continuous"><axis xyz="0 1 0"/>
      <link1 link="weight" rpy="0 0 -0.5" xyz="0 0 0"/><link2 link="base" xyz="0.1 0 -2"/><dynamics damping="1"/></loop_joint>"#;
    let urdf = DOUBLE.replace("</robot>", &format!("{closing}</robot>"));
    std::fs::write(folder.join("closed.urdf"), &urdf).unwrap();
    let (model, _, state) = build(&folder, "[[robot]]\nurdf = \"closed.urdf\"");
    let [closed] = &model.mechanism.loops[..] else { panic!("one loop") };
    assert_eq!((closed.name.as_str(), closed.kind), ("closure", LoopKind::Revolute));
    assert!(gap(&model, &state) < 1e-15);
    assert!(model.warnings.iter().any(|warning| warning.message.contains("damping of a joint that closes a loop")));
    // Viewers get the tree.
    assert!(!model.robots[0].robot.description.contains("loop_joint"));

    for (wrong, right, message) in [
        ("type=\"continuous\"><axis", "type=\"free\"><axis", "type \"free\" is not one of revolute"),
        ("link=\"weight\"", "link=\"wait\"", "its link1 link \"wait\" does not exist"),
        ("<link2 link=\"base\" xyz=\"0.1 0 -2\"/>", "", "<loop_joint> has no <link2>"),
        ("<axis xyz=\"0 1 0\"/>\n", "<axis xyz=\"0 0 0\"/>\n", "the axis is zero"),
    ] {
        std::fs::write(folder.join("closed.urdf"), urdf.replace(wrong, right)).unwrap();
        let refused = refusal(&folder, "[[robot]]\nurdf = \"closed.urdf\"");
        assert!(refused.contains(message) && refused.contains("closed.urdf:1"), "{refused}");
        assert!(refused.contains("loop \"closure\""), "{refused}");
    }
}

#[test]
fn loop_joints_end_at_the_same_world_as_the_joints_of_the_tree() {
    let folder = folder("loop_joint_to_world");
    let closing = r#"<loop_joint name="closure" type="continuous"><axis xyz="0 1 0"/>
      <link1 link="weight" rpy="0 0 -0.5"/><link2 link="world" xyz="0.1 0 -2"/></loop_joint></robot>"#;
    let declared = DOUBLE.replace("\"base\"", "\"world\"").replace("</robot>", closing);
    let undeclared = declared.replace("<link name=\"world\"/>", "");
    for urdf in [declared, undeclared] {
        std::fs::write(folder.join("closed.urdf"), urdf).unwrap();
        let pose = "pose = { position = [0.5, 0.2, 1], rpy = [0.3, 0.2, 0.1] }";
        let (model, _, state) = build(&folder, &format!("[[robot]]\nurdf = \"closed.urdf\"\n{pose}\n"));
        let gap = gap(&model, &state);
        assert!(gap < 1e-15, "{gap}");
    }
}
