//! What is no URDF, or says what cannot be, is refused with one clear error, and no damage makes the reader panic.

use super::{GOOD_INERTIAL, joint, link, read, refused, robot, warned};
use crate::common::scratch;
use catena::scene::{PackagePath, Problem, read_urdf};

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
fn reversed_limits_and_negative_friction_are_refused() {
    let limit = "<limit lower=\"1\" upper=\"-1\" effort=\"1\" velocity=\"1\"/>";
    for kind in ["revolute", "prismatic"] {
        let text = robot("", limit, "").replace("continuous", kind);
        assert_eq!(refused(&text, 6, joint("hinge")), Problem::ReversedLimits { lower: 1.0, upper: -1.0 });
    }
    // A continuous joint has no limits, which is said.
    warned(&robot("", limit, ""), "lower and upper limits of 1 continuous joint are not read", 4, None);
    let problem = refused(&robot("", "\n<dynamics friction=\"-0.5\"/>", ""), 7, joint("hinge"));
    assert_eq!(problem, Problem::NegativeFriction(-0.5));
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
    assert_eq!(refused("\n<sdf version=\"1.6\"/>", 2, None), Problem::Sdf);
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
