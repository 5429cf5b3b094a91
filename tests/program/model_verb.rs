//! `catena model`: exit codes, tables and JSON.

use crate::common::command::{PENDULUM, folder, run, text};
use crate::common::scratch;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Output;

const ARM: &str = r#"<robot name="arm">
<link name="base"/>
<link name="upper"><inertial><origin xyz="0 0 0.5"/><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.15"/></inertial></link>
<link name="hand"/>
<joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/></joint>
<joint name="weld" type="fixed"><parent link="upper"/><child link="hand"/><origin xyz="0 0 1"/></joint>
<gazebo/>
</robot>"#;

fn catena(urdf: &Path, arguments: &[&str]) -> Output {
    run(urdf.parent().expect("a folder"), &[&["model"], arguments].concat())
}

/// A URDF file of this test's own.
fn urdf(name: &str, text: &str) -> PathBuf {
    let path = scratch(name).join("robot.urdf");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn the_json_names_bodies_joints_reductions_and_warnings() {
    let path = urdf("json", ARM);
    let output = catena(&path, &[path.to_str().unwrap(), "--json", "--gravity", "0,0,-1.62"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty());
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["robot"], "arm");
    assert_eq!(report["gravity"][2], -1.62);
    assert_eq!(report["model"]["links"], 3);
    assert_eq!(report["model"]["degrees_of_freedom"], 1);
    let body = &report["bodies"][0];
    assert_eq!(body["name"], "upper");
    assert_eq!(body["mass"], 2.0);
    assert_eq!(body["principal_inertia"], serde_json::json!([0.1, 0.2, 0.15]));
    assert_eq!(body["center_of_mass"], serde_json::json!([0.0, 0.0, 0.5]));
    assert_eq!(body["links"], serde_json::json!(["upper", "hand"]));
    assert_eq!(report["joints"][1]["body"], Value::Null);
    assert_eq!(report["links"][2]["body"], "upper");
    let rules: Vec<&str> =
        report["reductions"].as_array().unwrap().iter().map(|r| r["rule"].as_str().unwrap()).collect();
    assert_eq!(rules, ["fixed_base", "fused_with_parent"]);
    assert_eq!(report["warnings"].as_array().unwrap().len(), 1);
    assert!(report["warnings"][0].as_str().unwrap().ends_with(": ignored: line 7: <gazebo>"));
}

#[test]
fn the_tables_show_what_is_simulated_and_what_is_not() {
    let path = urdf("table", ARM);
    let output = catena(&path, &[path.to_str().unwrap(), "--base", "floating"]);
    assert_eq!(output.status.code(), Some(2), "the base has no mass");
    let output = catena(&path, &[path.to_str().unwrap()]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.starts_with("arm: 3 links → 1 body, 1 joint, 1 degree of freedom\n"), "{text}");
    let ignored = "Ignored tags and attributes:\n";
    for part in ["shoulder", "continuous", "2.000", "0.1000, 0.2000, 0.1500", "fixed to its parent", ignored] {
        assert!(text.contains(part), "{part:?} in {text}");
    }
}

#[test]
fn bad_input_is_one_line_on_standard_error_and_exit_code_2() {
    let path = urdf("bad", &ARM.replace("mass value=\"2\"", "mass value=\"two\""));
    for arguments in [vec![path.to_str().unwrap()], vec!["missing.urdf"], vec!["scene.toml"]] {
        let output = catena(&path, &arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty());
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.starts_with("catena: ") && text.trim_end().lines().count() == 1, "{text}");
        assert!(text.contains(arguments[0]), "{text}");
    }
    for arguments in
        [["a.urdf", "--gravity", "0,0"], ["a.urdf", "--base-pose", "0,0,0,0,0,x"], ["a.urdf", "--package", "x"]]
    {
        assert_eq!(catena(&path, &arguments).status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn what_acts_along_a_joint_has_the_units_of_the_joint() {
    let folder = folder("units");
    let damped = PENDULUM.replace("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 1 0\"/><dynamics damping=\"0.5\"/>");
    for (kind, unit) in [("continuous", "0.5000 N m s/rad"), ("prismatic", "0.5000 N s/m")] {
        std::fs::write(folder.join("damped.urdf"), damped.replace("continuous", kind)).expect("written");
        let output = run(&folder, &["model", "damped.urdf"]);
        let line = text(&output.stdout).lines().find(|line| line.contains("damper")).map(str::trim_end);
        assert!(line.is_some_and(|line| line.ends_with(unit)), "{kind}: {}", text(&output.stdout));
    }
}
