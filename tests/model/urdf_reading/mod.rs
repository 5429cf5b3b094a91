//! What the reader of URDFs refuses and what it repairs: every message names the file, the line, and the link or
//! joint.

mod meshes;
mod refusals;
mod repairs;
mod rotors;
mod rounded_angles;
mod surface_friction;

use catena::scene::{Element, PackagePath, Problem, Robot, SceneError, Warning, robot_from_text};
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
