//! What the reader of URDFs refuses and what it repairs: every message names the file, the line, and the link or
//! joint.

use catena::scene::{
    Element, Geometry, PackagePath, Problem, Robot, SceneError, UrdfJointKind, Warning, read_urdf, robot_from_text,
    robot_without_meshes,
};
use std::path::{Path, PathBuf};

const FILE: &str = "robot.urdf";

fn read(text: &str) -> Result<Robot, SceneError> {
    robot_from_text(text, Path::new(FILE), &PackagePath::default())
}

/// Two links and a joint; `inertial`, `joint` and `more` are put in on lines 3, 6 and 8.
fn robot(inertial: &str, joint: &str, more: &str) -> String {
    format!(
        "<robot name=\"r\">\n<link name=\"base\"/>\n<link name=\"arm\">{inertial}</link>\n<joint name=\"hinge\" \
         type=\"continuous\">\n<parent link=\"base\"/><child link=\"arm\"/>\n{joint}\n</joint>\n{more}\n</robot>\n"
    )
}

const GOOD_INERTIAL: &str =
    r#"<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>"#;

/// Reads what must be refused and checks where the error is; returns the problem.
#[track_caller]
fn refused(text: &str, line: usize, element: Option<Element>) -> Problem {
    let error = read(text).expect_err("must be refused");
    assert_eq!(error.file, PathBuf::from(FILE), "{error}");
    assert_eq!(error.line, Some(line), "{error}");
    assert_eq!(error.element, element, "{error}");
    assert!(error.to_string().starts_with(&format!("{FILE}:{line}: ")), "{error}");
    assert!(!error.to_string().contains('\n'), "one line: {error}");
    *error.problem
}

/// Reads what must be read with a warning that contains `part`, and checks where the warning is.
#[track_caller]
fn warned(text: &str, part: &str, line: usize, element: Option<Element>) -> Robot {
    let robot = read(text).expect("must be read");
    let found: Vec<&Warning> = robot.warnings.iter().filter(|warning| warning.message.contains(part)).collect();
    assert_eq!(found.len(), 1, "one warning with {part:?} in {:#?}", robot.warnings);
    assert_eq!(found[0].file, PathBuf::from(FILE));
    assert_eq!(found[0].line, Some(line), "{}", found[0]);
    assert_eq!(found[0].element, element, "{}", found[0]);
    robot
}

fn link(name: &str) -> Option<Element> {
    Some(Element::Link(name.to_string()))
}

fn joint(name: &str) -> Option<Element> {
    Some(Element::Joint(name.to_string()))
}

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
fn numbers_must_be_numbers() {
    for bad in ["1 2 oops", "1 2 3 oops", "1 2", "1 2 3 4", "", "nan 0 0", "inf 0 0", "1e999 0 0", "1,2 3", "0,5 1 2,5"]
    {
        let problem = refused(&robot("", &format!("<origin xyz=\"{bad}\"/>"), ""), 6, joint("hinge"));
        assert!(matches!(&problem, Problem::Number { attribute, .. } if attribute == "xyz"), "{bad}: {problem}");
    }
    for bad in ["x", "nan", "inf", "1 2", "", "-"] {
        let inertial = GOOD_INERTIAL.replace("mass value=\"1\"", &format!("mass value=\"{bad}\""));
        assert!(matches!(refused(&robot(&inertial, "", ""), 3, link("arm")), Problem::Number { .. }), "{bad}");
        let inertial = GOOD_INERTIAL.replace("iyy=\"1\"", &format!("iyy=\"{bad}\""));
        assert!(matches!(refused(&robot(&inertial, "", ""), 3, link("arm")), Problem::Number { .. }), "{bad}");
    }
    for element in [
        "<limit lower=\"-1.57.\" effort=\"1\" velocity=\"1\"/>",
        "<dynamics damping=\"nan\"/>",
        "<mimic joint=\"hinge\" multiplier=\"a\"/>",
    ] {
        assert!(matches!(refused(&robot("", element, ""), 6, joint("hinge")), Problem::Number { .. }), "{element}");
    }
    let shape = r#"<visual><geometry><mesh filename="a.stl" scale="1 1 1 1"/></geometry></visual>"#;
    assert!(matches!(refused(&robot(shape, "", ""), 3, link("arm")), Problem::Number { .. }));
}

#[test]
fn unexpanded_xacro_is_named() {
    let problem = refused(&robot("", r#"<origin xyz="$(optenv X 0) 0 0"/>"#, ""), 6, joint("hinge"));
    assert!(problem.to_string().contains("xacro"), "{problem}");
    let text = "<robot name=\"r\" xmlns:xacro=\"http://ros.org/wiki/xacro\">\n<xacro:macro/>\n</robot>";
    assert!(matches!(refused(text, 2, None), Problem::Xacro(_)));
}

#[test]
fn a_zero_axis_is_refused_only_where_it_matters() {
    assert_eq!(refused(&robot("", r#"<axis xyz="0 0 0"/>"#, ""), 6, joint("hinge")), Problem::ZeroAxis);
    for kind in ["fixed", "floating", "spherical"] {
        let text = robot("", r#"<axis xyz="0 0 0"/>"#, "").replace("continuous", kind);
        assert!(read(&text).is_ok(), "{kind}");
    }
}

#[test]
fn a_negative_mass_is_refused() {
    let inertial = GOOD_INERTIAL.replace("mass value=\"1\"", "mass value=\"-2\"");
    assert_eq!(refused(&robot(&inertial, "", ""), 3, link("arm")), Problem::NegativeMass(-2.0));
}

#[test]
fn a_robot_without_links_is_refused() {
    assert_eq!(refused("<robot name=\"r\">\n</robot>", 1, None), Problem::NoLinks);
}

#[test]
fn names_must_be_there_and_unique() {
    let missing = |attribute: &str, element: &str| Problem::MissingAttribute {
        element: element.to_string(),
        attribute: attribute.to_string(),
    };
    assert_eq!(refused("<robot>\n<link/>\n</robot>", 2, None), missing("name", "link"));
    let text = robot("", "", "").replace("name=\"hinge\" ", "");
    assert_eq!(refused(&text, 4, None), missing("name", "joint"));
    let text = robot("", "", "").replace("type=\"continuous\"", "");
    assert_eq!(refused(&text, 4, joint("hinge")), missing("type", "joint"));
    let twice = robot("", "", r#"<link name="arm"/>"#);
    assert_eq!(refused(&twice, 8, link("arm")), Problem::DuplicateName { first_line: 3 });
    let more = r#"<link name="c"/><joint name="hinge" type="fixed"><parent link="arm"/><child link="c"/></joint>"#;
    assert_eq!(refused(&robot("", "", more), 8, joint("hinge")), Problem::DuplicateName { first_line: 4 });
}

#[test]
fn required_elements_are_named() {
    let text = robot("", "", "").replace("<child link=\"arm\"/>", "");
    let problem = Problem::MissingElement { parent: "joint".to_string(), element: "child".to_string() };
    assert_eq!(refused(&text, 4, joint("hinge")), problem);
    let problem = Problem::MissingElement { parent: "inertial".to_string(), element: "mass".to_string() };
    let inertial = GOOD_INERTIAL.replace("<mass value=\"1\"/>", "");
    assert_eq!(refused(&robot(&inertial, "", ""), 3, link("arm")), problem);
    let inertial = GOOD_INERTIAL.replace("izz=\"1\"", "");
    let problem = Problem::MissingAttribute { element: "inertia".to_string(), attribute: "izz".to_string() };
    assert_eq!(refused(&robot(&inertial, "", ""), 3, link("arm")), problem);
}

#[test]
fn only_the_joint_types_of_urdf_are_known() {
    let text = robot("", "", "").replace("continuous", "ball");
    assert_eq!(refused(&text, 4, joint("hinge")), Problem::JointType("ball".to_string()));
}

#[test]
fn links_must_exist() {
    let text = robot("", "", "").replace("<parent link=\"base\"/>", "<parent link=\"nobody\"/>");
    let problem = Problem::UnknownLink { role: "parent", name: "nobody".to_string() };
    assert_eq!(refused(&text, 4, joint("hinge")), problem);
    let text = robot("", "", "").replace("<child link=\"arm\"/>", "<child link=\"nobody\"/>");
    let problem = Problem::UnknownLink { role: "child", name: "nobody".to_string() };
    assert_eq!(refused(&text, 4, joint("hinge")), problem);
}

#[test]
fn a_link_has_one_parent() {
    let more = r#"<joint name="second" type="fixed"><parent link="base"/><child link="arm"/></joint>"#;
    let problem = Problem::TwoParents { first: "hinge".to_string(), second: "second".to_string() };
    assert_eq!(refused(&robot("", "", more), 8, link("arm")), problem);
}

#[test]
fn cycles_are_refused_and_shown() {
    let more = r#"<joint name="back" type="fixed"><parent link="arm"/><child link="base"/></joint>"#;
    let Problem::Cycle { path } = refused(&robot("", "", more), 2, link("base")) else { panic!("a cycle") };
    assert_eq!(path, ["base", "arm", "base"]);
    // A cycle beside a sound tree.
    let more = r#"<link name="c"/><joint name="self" type="fixed"><parent link="c"/><child link="c"/></joint>"#;
    let Problem::Cycle { path } = refused(&robot("", "", more), 8, link("c")) else { panic!("a cycle") };
    assert_eq!(path, ["c", "c"]);
}

#[test]
fn several_roots_are_refused_unless_they_hang_on_the_world() {
    let problem = refused(&robot("", "", r#"<link name="lost"/>"#), 8, link("lost"));
    assert_eq!(problem, Problem::SeveralRoots(vec!["base".to_string(), "lost".to_string()]));

    let on_world = r#"<joint name="weld" type="fixed"><parent link="world"/><child link="base"/></joint>"#;
    let robot_on_world = read(&robot("", "", on_world)).unwrap();
    assert_eq!(robot_on_world.root, None);
    assert!(robot_on_world.root_is_world());

    let lost = format!("{on_world}<link name=\"lost\"/>");
    let problem = refused(&robot("", "", &lost), 8, link("lost"));
    assert_eq!(problem, Problem::SeveralRoots(vec!["world".to_string(), "lost".to_string()]));

    let two_on_world = format!(
        "{on_world}<link name=\"other\"/><joint name=\"weld2\" type=\"fixed\"><parent link=\"world\"/><child \
         link=\"other\"/></joint>"
    );
    assert!(read(&robot("", "", &two_on_world)).is_ok());

    let declared = robot("", "", "").replace("\"base\"", "\"world\"");
    let declared = read(&declared).unwrap();
    assert_eq!((declared.root, declared.root_is_world()), (Some(0), true));
}

#[test]
fn files_that_are_no_urdf_give_one_clear_error() {
    for empty in ["", "   \n\n ", "\u{feff}", "\0\0"] {
        let error = read(empty).unwrap_err();
        assert_eq!((error.line, *error.problem), (None, Problem::Empty), "{empty:?}");
    }
    assert_eq!(refused("\n<sdf version=\"1.6\"/>", 2, None), Problem::NotRobot("sdf".to_string()));
    assert!(matches!(refused("<robot>\n<link name=\"a\">\n</robot>", 3, None), Problem::Xml(_)));
    assert!(matches!(refused("<robot>\n<link name=\"a\"/>\n", 2, None), Problem::Xml(_)));
    assert!(matches!(refused("version https://git-lfs.github.com/spec/v1\n", 1, None), Problem::Xml(_)));
    assert!(matches!(refused("<!DOCTYPE robot>\n<robot/>", 1, None), Problem::Xml(_)));

    let folder = scratch("files");
    let missing = read_urdf(&folder.join("missing.urdf"), &PackagePath::default()).unwrap_err();
    assert!(matches!(*missing.problem, Problem::Unreadable(_)));
    assert!(missing.to_string().contains("missing.urdf: cannot be read: "), "{missing}");
    assert!(matches!(*read_urdf(&folder, &PackagePath::default()).unwrap_err().problem, Problem::Unreadable(_)));
    let binary = folder.join("binary.urdf");
    std::fs::write(&binary, [b'<', b'a', b'\n', 0xff, 0xfe, 0x00]).unwrap();
    let error = read_urdf(&binary, &PackagePath::default()).unwrap_err();
    assert_eq!((error.line, *error.problem), (Some(2), Problem::NotText(3)));
}

#[test]
fn no_damaged_file_makes_the_reader_panic() {
    let text = robot(
        GOOD_INERTIAL,
        r#"<origin xyz="1, 2, 3" rpy="0 0 1"/><axis xyz="0 1 0"/><limit lower="0" upper="1"/>"#,
        "<gazebo><x y='&lt;'/></gazebo>",
    );
    for cut in (0..text.len()).filter(|&cut| text.is_char_boundary(cut)) {
        let _ = read(&text[..cut]);
        let _ = read(&text[cut..]);
        for replacement in ["<", "\"", "&", "\0", "é", "9", ""] {
            let mut damaged = text.clone();
            damaged.replace_range(cut..cut + 1, replacement);
            let _ = read(&damaged);
        }
    }
    // Nesting as deep as this must not exhaust the stack either.
    let deep = format!("<robot><link name=\"a\">{}{}</link></robot>", "<x>".repeat(3000), "</x>".repeat(3000));
    let _ = read(&deep);
}

#[test]
fn repeated_elements_are_refused_unless_they_agree() {
    let axis = r#"<axis xyz="0 1 0"/>"#;
    warned(&robot("", &format!("{axis}{axis}"), ""), "<axis> is given twice", 6, joint("hinge"));
    let problem = refused(&robot("", &format!("{axis}<axis xyz=\"1 0 0\"/>"), ""), 6, joint("hinge"));
    assert!(matches!(problem, Problem::RepeatedElement { first_line: 6, .. }), "{problem}");
    let problem = refused(
        &robot(&GOOD_INERTIAL.replace("</inertial>", "<mass value=\"2\"/></inertial>"), "", ""),
        3,
        link("arm"),
    );
    assert!(matches!(problem, Problem::RepeatedElement { .. }), "{problem}");
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
fn a_lower_limit_above_the_upper_one_is_not_used_and_said() {
    let text = robot(GOOD_INERTIAL, "<limit lower=\"1\" upper=\"-1\" effort=\"1\" velocity=\"1\"/>", "")
        .replace("continuous", "revolute");
    warned(&text, "its lower limit 1 is above its upper limit -1, so neither is used", 6, joint("hinge"));
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
    let both = warned(&robot(needle, "", &second), "no body has the principal moments of inertia", 3, link("arm"));
    let message = &both.warnings[0].message;
    assert!(message.contains(" 0.0000e0, 0.0000e0, 3.0000e-6 kg m²"), "{message}");
    assert!(message.ends_with("; so it is with 1 more link"), "{message}");
    let no_products = GOOD_INERTIAL.replace("ixz=\"0\" ", "");
    warned(&robot(&no_products, "", ""), "<inertia> has no ixz; 0 is assumed", 3, link("arm"));
}

#[test]
fn what_is_not_simulated_is_said_once_for_each_kind() {
    let second = r#"<link name="c"/><joint name="second" type="revolute"><parent link="arm"/><child link="c"/><limit lower="0" upper="1" effort="1" velocity="1"/><dynamics damping="0.1"/><mimic joint="hinge"/></joint>"#;
    let more = format!("{second}<gazebo/><gazebo reference=\"c\"/><transmission/><closure/>");
    let in_joint = r#"<limit effort="1" velocity="1"/><dynamics damping="1" friction="2"/><safety_controller/>"#;
    let collision = "<collision><geometry><sphere radius=\"1\"/></geometry></collision><contact/>";
    let robot = read(&robot(collision, in_joint, &more)).unwrap();
    let messages: Vec<String> = robot.warnings.iter().map(|w| format!("{}: {}", w.line.unwrap(), w.message)).collect();
    assert_eq!(
        messages,
        [
            "4: joint limits of 2 joints are not simulated",
            "4: joint friction of 1 joint is not simulated",
            "3: contacts (collision shapes) of 1 link are not simulated",
            "3: <contact> of <link> is not read",
            "6: <safety_controller> of <joint> is not read",
            "8: <gazebo> (2 times) is not read",
            "8: <transmission> is not read",
            "8: <closure> is not read",
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
    assert!(prefixed.warnings.iter().any(|warning| warning.message == "<sensor:camera> is not read"));
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

/// A folder of this test's own.
fn scratch(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("catena-urdf-reading-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn packages_are_looked_for_in_the_documented_order() {
    let root = scratch("packages");
    let urdf_folder = root.join("ws/bot_description/urdf");
    let places = [
        ("--package", root.join("given")),
        ("ROS_PACKAGE_PATH", root.join("ros/bot_description")),
        ("AMENT_PREFIX_PATH", root.join("ament/bot_description")),
        ("AMENT_PREFIX_PATH share", root.join("ament/share/bot_description")),
        ("above the URDF", root.join("ws/bot_description")),
    ];
    for folder in places.iter().map(|(_, folder)| folder).chain([&urdf_folder]) {
        std::fs::create_dir_all(folder.join("meshes")).unwrap();
    }
    let packages = PackagePath {
        packages: vec![("bot_description".to_string(), root.join("given"))],
        ros_package_path: vec![root.join("nowhere"), root.join("ros")],
        ament_prefix_path: vec![root.join("ament")],
    };
    let visual = r#"<visual><geometry><mesh filename="package://bot_description/meshes/a.stl" scale="1 2 3"/></geometry></visual>"#;
    let text = robot(visual, "", "");
    let path = urdf_folder.join("bot.urdf");

    let missing = robot_from_text(&text, &path, &packages).unwrap();
    let warning = missing.warnings.iter().find(|warning| warning.message.contains("not found")).unwrap();
    assert_eq!((warning.line, &warning.element), (Some(3), &link("arm")));
    // From the last place to the first, each found file takes precedence over those after it.
    for (what, folder) in places.iter().rev() {
        let mesh = folder.join("meshes/a.stl");
        assert!(warning.message.contains(&mesh.display().to_string()), "{what} is listed in {warning}");
        std::fs::write(&mesh, "solid").unwrap();
        let robot = robot_from_text(&text, &path, &packages).unwrap();
        let Geometry::Mesh(found) = &robot.links[1].visuals[0].geometry else { panic!("a mesh") };
        assert_eq!(found.resolved.as_ref(), Some(&mesh), "{what}");
        assert_eq!(found.scale.as_slice(), [1.0, 2.0, 3.0]);
        assert!(robot.description.contains(&format!("file://{}", mesh.display())), "{}", robot.description);
        assert!(robot.warnings.is_empty());
    }
    std::fs::remove_dir_all(&root).unwrap();
}

#[test]
fn no_mesh_is_looked_for_where_nobody_needs_it() {
    let folder = scratch("without_meshes");
    std::fs::write(folder.join("a.stl"), "solid").unwrap();
    let visual = |mesh: &str| format!("<visual><geometry><mesh filename=\"{mesh}\"/></geometry></visual>");
    let text = robot(&format!("{GOOD_INERTIAL}{}{}", visual("a.stl"), visual("missing.stl")), "", "");
    let robot = robot_without_meshes(&text, &folder.join(FILE)).unwrap();
    let resolved = robot.links[1].visuals.iter().map(|visual| match &visual.geometry {
        Geometry::Mesh(mesh) => mesh.resolved.clone(),
        other => panic!("{other:?} is no mesh"),
    });
    assert_eq!(resolved.collect::<Vec<_>>(), [None, None]);
    assert!(robot.warnings.is_empty(), "{:?}", robot.warnings);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn missing_meshes_are_reported_once_for_each_package() {
    let visual = |name: &str| format!("<visual><geometry><mesh filename=\"{name}\"/></geometry></visual>");
    let visuals: String = ["package://p/a", "package://p/b", "c.stl", "http://x/y.stl", "c.stl"].map(visual).concat();
    let robot = read(&robot(&visuals, "", "")).unwrap();
    let messages: Vec<&str> = robot.warnings.iter().map(|warning| warning.message.as_str()).collect();
    assert_eq!(messages.len(), 3, "{messages:#?}");
    assert!(messages[0].starts_with("the mesh \"package://p/a\" was not found; tried "), "{}", messages[0]);
    assert!(messages[0].ends_with("; nor were 1 more of package://p"), "{}", messages[0]);
    assert_eq!(messages[1], "the mesh \"c.stl\" was not found; tried c.stl");
    assert_eq!(messages[2], "the mesh \"http://x/y.stl\" is not a local file (http://)");
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
