//! What is sound is read without a warning; what can be repaired, left out or not simulated is read with one.

use super::{GOOD_INERTIAL, joint, link, read, refused, robot, warned};
use catena::scene::{Geometry, Problem, Robot, UrdfJointKind};

#[test]
fn a_good_robot_is_read_without_any_warning() {
    let robot = read(&robot(GOOD_INERTIAL, r#"<origin xyz="1 2 3"/><axis xyz="0 1 0"/>"#, "")).unwrap();
    assert_eq!(robot.warnings, []);
    assert_eq!((robot.links.len(), robot.joints.len(), robot.root), (2, 1, Some(0)));
    assert_eq!(robot.joints[0].kind, UrdfJointKind::Continuous);
    assert_eq!(robot.joints[0].axis.as_slice(), [0.0, 1.0, 0.0]);
    assert_eq!(robot.joints[0].origin.translation.vector.as_slice(), [1.0, 2.0, 3.0]);
    assert_eq!(robot.links[1].inertial.as_ref().unwrap().mass, 1.0);
    assert_eq!((robot.links[1].line, robot.joints[0].line), (3, 4));
}

#[test]
fn a_message_reads_file_line_and_element() {
    let error = read(&robot("", r#"<axis xyz="0 0 0"/>"#, "")).unwrap_err();
    assert!(error.to_string().starts_with("robot.urdf:6: joint \"hinge\": the axis is zero"), "{error}");
    let robot = read(&robot(GOOD_INERTIAL, r#"<axis xyz="0 0 2"/>"#, "")).unwrap();
    assert!(robot.warnings[0].to_string().starts_with("robot.urdf:6: joint \"hinge\": the axis has length 2"));
}

#[test]
fn missing_limits_are_assumed_with_a_warning() {
    let revolute = |limit: &str| robot("", limit, "").replace("continuous", "revolute");
    let read_back =
        warned(&revolute(r#"<limit lower="-1" upper="2" effort="3"/>"#), "<limit> has no velocity", 6, joint("hinge"));
    let limit = read_back.joints[0].limit.unwrap();
    assert_eq!((limit.lower, limit.upper, limit.effort, limit.velocity), (Some(-1.0), Some(2.0), Some(3.0), None));
    warned(&revolute(r#"<limit velocity="1"/>"#), "<limit> has no effort", 6, joint("hinge"));
    warned(&revolute(""), "should have a <limit>", 4, joint("hinge"));
    // An infinite limit is no limit, and that is plain.
    let infinite = read(&revolute(r#"<limit lower="-inf" upper="inf" effort="1" velocity="inf"/>"#)).unwrap();
    assert_eq!(infinite.joints[0].limit.unwrap().upper, Some(f64::INFINITY));
}

#[test]
fn commas_between_numbers_are_read_as_spaces() {
    for text in ["0.07, 0, -0.69", "0.07,0,-0.69", "0.07 , 0,-0.69"] {
        let robot = warned(&robot("", &format!("<origin xyz=\"{text}\"/>"), ""), "commas", 6, joint("hinge"));
        assert_eq!(robot.joints[0].origin.translation.vector.as_slice(), [0.07, 0.0, -0.69]);
    }
}

#[test]
fn shapes_that_cannot_be_shown_are_left_out_alone() {
    let shape = |form: &str| {
        format!(
            "<visual><geometry><box size=\"1 2 3\"/></geometry></visual><collision><geometry>{form}</geometry></collision>"
        )
    };
    for (form, reason) in [
        ("<plane normal=\"0 0 1\"/>", "<plane> is no geometry"),
        ("<drake:capsule xmlns:drake=\"d\"/>", "<drake:capsule> is no geometry"),
        ("<mesh/>", "its mesh has no filename"),
        ("<mesh filename=\"\"/>", "its mesh has no filename"),
        ("", "it has no geometry"),
        ("<box size=\"1 1 1\"/><sphere radius=\"1\"/>", "its geometry is a <box> and a <sphere>"),
    ] {
        let robot = warned(&robot(&shape(form), "", ""), reason, 3, link("arm"));
        assert_eq!((robot.links[1].visuals.len(), robot.links[1].collisions.len()), (1, 0), "{form}");
        assert_eq!(robot.links[1].visuals[0].geometry, Geometry::Box { size: nalgebra::Vector3::new(1.0, 2.0, 3.0) });
    }
    let bad_color = r#"<visual><geometry><sphere radius="1"/></geometry><material name="m"><color rgba="1 0 x 1"/></material></visual>"#;
    let robot = warned(&robot(bad_color, "", ""), "its <material> was left out", 3, link("arm"));
    assert_eq!(robot.links[1].visuals[0].color, None);
}

#[test]
fn colors_come_from_the_visual_or_the_robot() {
    let visual = |material: &str| format!("<visual><geometry><sphere radius=\"1\"/></geometry>{material}</visual>");
    let own = visual(r#"<material><color rgba="1 0.5 0 1"/></material>"#);
    let named = visual(r#"<material name="blue"/>"#);
    let robot =
        read(&robot(&(own + &named), "", r#"<material name="blue"><color rgba="0 0 1 0.5"/></material>"#)).unwrap();
    let colors: Vec<_> = robot.links[1].visuals.iter().map(|visual| visual.color).collect();
    assert_eq!(colors, [Some([1.0, 0.5, 0.0, 1.0]), Some([0.0, 0.0, 1.0, 0.5])]);
}

#[test]
fn an_axis_is_normalised_with_a_warning() {
    let robot_with = |axis: &str| robot("", &format!("<axis xyz=\"{axis}\"/>"), "");
    let read_back = warned(&robot_with("0 3 4"), "the axis has length 5", 6, joint("hinge"));
    assert_eq!(read_back.joints[0].axis.as_slice(), [0.0, 0.6, 0.8]);
    let read_back = read(&robot_with("0.57735 0.57735 0.57735")).unwrap();
    assert!((read_back.joints[0].axis.norm() - 1.0).abs() < 1e-15);
    assert_eq!(read_back.warnings, [], "rounded unit vectors are not worth a warning");
    assert_eq!(read(&robot_with("0 0 1e-200")).unwrap().joints[0].axis.as_slice(), [0.0, 0.0, 1.0]);
}

#[test]
fn impossible_inertias_are_used_with_a_warning() {
    let thin = GOOD_INERTIAL.replace("izz=\"1\"", "izz=\"2.1\"");
    warned(&robot(&thin, "", ""), "the largest exceeds the sum", 3, link("arm"));
    let disc = GOOD_INERTIAL.replace("izz=\"1\"", "izz=\"2\"");
    assert_eq!(read(&robot(&disc, "", "")).unwrap().warnings, [], "a disc is possible");
    // Hidden in the products of inertia.
    let hidden = GOOD_INERTIAL.replace("ixy=\"0\"", "ixy=\"0.9\"");
    warned(&robot(&hidden, "", ""), "the largest exceeds the sum", 3, link("arm"));
    // A rod along (1, 1, 1), whose moment is zero but for rounding, as another is; said once of both links.
    let needle = r#"<inertial><mass value="1"/><inertia ixx="1e-6" ixy="1e-6" ixz="1e-6" iyy="1e-6" iyz="1e-6" izz="1e-6"/></inertial>"#;
    let second = format!(
        "<link name=\"c\">{needle}</link><joint name=\"second\" type=\"fixed\"><parent link=\"arm\"/><child link=\"c\"/></joint>"
    );
    let both = warned(&robot(needle, "", &second), "its inertia violates the triangle inequality", 3, link("arm"));
    let message = &both.warnings[0].message;
    assert!(message.contains(" 0.0000e0, 0.0000e0, 3.0000e-6 kg m²"), "{message}");
    assert!(message.ends_with("; the same for 1 more link"), "{message}");
    let no_products = GOOD_INERTIAL.replace("ixz=\"0\" ", "");
    warned(&robot(&no_products, "", ""), "<inertia> has no ixz; 0 is assumed", 3, link("arm"));
}

#[test]
fn what_is_not_simulated_is_said_once_for_each_kind() {
    let second = r#"<link name="c"/><joint name="second" type="revolute"><parent link="arm"/><child link="c"/><limit lower="0" upper="1" effort="1" velocity="1"/><dynamics damping="0.1"/><mimic joint="hinge"/></joint>"#;
    let third = r#"<link name="d"/><joint name="third" type="planar"><parent link="arm"/><child link="d"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint>"#;
    let more = format!("{second}{third}<gazebo/><gazebo reference=\"c\"/><transmission/><closure/>");
    let in_joint = r#"<limit effort="1" velocity="1"/><dynamics damping="1" friction="2"/><safety_controller/>"#;
    let collision = "<collision><geometry><sphere radius=\"1\"/></geometry></collision><contact/>";
    let robot = read(&robot(collision, in_joint, &more)).unwrap();
    let messages: Vec<String> = robot.warnings.iter().map(|w| format!("{}: {}", w.line.unwrap(), w.message)).collect();
    assert_eq!(
        messages,
        [
            "8: limits of 1 floating, planar or spherical joint are not simulated",
            "3: <contact> of <link>",
            "6: <safety_controller> of <joint>",
            "8: <gazebo> (2 times)",
            "8: <transmission>",
            "8: <closure>",
        ]
    );
}

#[test]
fn files_one_character_away_from_xml_are_read() {
    let text = robot("", "", "");
    let lines = |robot: &Robot| (robot.links[0].line, robot.joints[0].line);
    let late = read(&format!("\n\n<?xml version=\"1.0\"?>\n{text}")).unwrap();
    assert_eq!(lines(&late), (5, 7));
    let nul = read(&format!("{text}\0")).unwrap();
    assert!(nul.warnings[0].message.contains("control characters"));
    assert_eq!(lines(&read(&format!("\u{feff}{text}")).unwrap()), (2, 4));
    assert_eq!(lines(&read(&text.replace('\n', "\r\n")).unwrap()), (2, 4));
    let prefixed = robot("", "", "<sensor:camera/>");
    let prefixed = warned(&prefixed, "namespace prefix \"sensor\" is not declared", 8, None);
    assert!(prefixed.warnings.iter().any(|warning| warning.message == "<sensor:camera>"));
}

#[test]
fn prefixes_are_declared_in_the_outermost_element_whatever_stands_before_it() {
    let text = robot("", "", "<sensor:camera/>");
    for before in ["<!-- made from <robot> template -->", "<?xml version=\"1.0\"?><!----><?made from=\"<robot>\"?>"] {
        warned(&format!("{before}{text}"), "namespace prefix \"sensor\" is not declared", 8, None);
    }
    let other = text.replace("robot", "robots");
    assert_eq!(refused(&other, 1, None), Problem::NotRobot("robots".to_string()));
}

#[test]
fn strange_names_survive() {
    let name = "a &amp; &lt;b&gt; &quot;ü&quot; 'c'";
    let text = robot("", "", "").replace("\"arm\"", &format!("\"{name}\""));
    assert_eq!(read(&text).unwrap().links[1].name, "a & <b> \"ü\" 'c'");
}

#[test]
fn quaternions_are_read_from_version_1_1_and_exactly() {
    // A pitch of 89.9 degrees, where the detour by roll, pitch, yaw would lose milliradians.
    let half = 89.9_f64.to_radians() / 2.0;
    let origin = format!("<origin quat_xyzw=\"0 {} 0 {}\"/>", half.sin(), half.cos());
    let text = robot("", &origin, "");
    let old = warned(&text, "quat_xyzw is ignored", 6, joint("hinge"));
    assert_eq!(old.joints[0].origin.rotation.matrix(), &nalgebra::Matrix3::identity());
    let new = read(&text.replace("<robot ", "<robot version=\"1.1\" ")).unwrap();
    let wanted = nalgebra::Rotation3::from_euler_angles(0.0, 89.9_f64.to_radians(), 0.0);
    assert!((new.joints[0].origin.rotation.matrix() - wanted.matrix()).amax() < 1e-15);
    let both = text.replace("<robot ", "<robot version=\"1.1\" ").replace("<origin ", "<origin rpy=\"0 0 0\" ");
    assert!(matches!(refused(&both, 6, joint("hinge")), Problem::Number { .. }));
}

#[test]
fn quaternions_count_by_their_direction_however_long_they_are() {
    for length in [1e-320, 1e-200, 0.5, 1.0, 1e200, 1e308] {
        let origin = format!("<origin quat_xyzw=\"0 0 {length:e} {length:e}\"/>");
        let text = robot("", &origin, "").replace("<robot ", "<robot version=\"1.1\" ");
        let found = read(&text).unwrap().joints[0].origin.rotation;
        let wanted = nalgebra::Rotation3::from_euler_angles(0.0, 0.0, std::f64::consts::FRAC_PI_2);
        assert!((found.matrix() - wanted.matrix()).amax() < 1e-15, "{length:e}: {found}");
    }
    let zero = robot("", "<origin quat_xyzw=\"0 0 0 0\"/>", "").replace("<robot ", "<robot version=\"1.1\" ");
    assert!(matches!(refused(&zero, 6, joint("hinge")), Problem::Number { .. }));
}

#[test]
fn the_description_for_viewers_is_a_urdf_again() {
    let text = robot(GOOD_INERTIAL, r#"<origin xyz="1, 2, 3"/><limit effort="1"/>"#, "<gazebo/>");
    let first = read(&text).unwrap();
    let second = read(&first.description).unwrap();
    assert_eq!(second.joints[0].origin, first.joints[0].origin);
    assert_eq!(second.links[1].inertial.as_ref().unwrap().inertia, first.links[1].inertial.as_ref().unwrap().inertia);
    assert_eq!(first.source, text);
}
