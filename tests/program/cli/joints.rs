//! Limits, friction and motors on the command line: what is shown, left out, refused, and claimed never to matter.

use crate::common::command::{PENDULUM, assert_one_error, folder, run, text};
use serde_json::{Value, json};
use std::path::PathBuf;

/// A folder with the pendulum as a limited joint with friction and damping, and a scene of it.
fn limited(name: &str, scene: &str) -> PathBuf {
    let folder = folder(name);
    let joint = "type=\"revolute\"><limit lower=\"-1\" upper=\"2\" effort=\"3\" velocity=\"4\"/>\
                 <dynamics damping=\"0.5\" friction=\"0.25\"/>";
    std::fs::write(folder.join("limited.urdf"), PENDULUM.replace("type=\"continuous\">", joint)).expect("written");
    std::fs::write(folder.join("scene.toml"), format!("[[robot]]\nurdf = \"limited.urdf\"\n{scene}")).expect("written");
    folder
}

fn model(folder: &std::path::Path, arguments: &[&str]) -> Value {
    let output = run(folder, &[&["model", "--json"], arguments].concat());
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&output.stderr)))
}

#[test]
fn the_model_lists_limits_friction_motors_and_speeds() {
    let motor = "[[motor]]\njoint = \"hinge\"\nkind = \"position\"\ntarget = [[0, 0.5], [1, 1]]\nkp = 100\nkd = 5\n\
                 [[joint]]\nname = \"hinge\"\nrestitution = 0.5\nlimit = [-1, inf]\n";
    let folder = limited("listed", motor);
    let report = model(&folder, &["scene.toml"]);
    let limit = json!({"joint": "hinge", "lower": -1.0, "upper": null, "restitution": 0.5, "lower_never_reached": null,
                       "upper_never_reached": null});
    assert_eq!(report["limits"], json!([limit]));
    assert_eq!(report["friction"], json!([{"joint": "hinge", "effort": 0.25, "never_matters": null}]));
    assert_eq!(report["speeds"], json!([{"joint": "hinge", "speed": 4.0}]));
    let motor = json!({"joint": "hinge", "kind": "position", "kp": 100.0, "kd": 5.0, "target": 0.5, "target_changes": true,
                       "max_effort": 3.0, "period": 0.0, "gravity_compensation": 0.0});
    assert_eq!(report["motors"], json!([motor]));
    let output = run(&folder, &["model", "scene.toml"]);
    let table = text(&output.stdout);
    for part in
        ["-1.000 to inf rad", "0.2500 N m", "4.000 rad/s", "100.0 N m/rad", "0.5000 rad at t = 0, then changing"]
    {
        assert!(table.contains(part), "{part:?} in {table}");
    }
}

#[test]
fn what_is_left_out_is_not_in_the_model_and_does_not_move_the_start() {
    let folder =
        limited("left_out", "positions = { hinge = 3 }\n[[motor]]\njoint = \"hinge\"\nkind = \"effort\"\ntarget = 1\n");
    let counts = |arguments: &[&str]| {
        let report = model(&folder, &[&["scene.toml"], arguments].concat());
        let count = |key: &str| report[key].as_array().map_or(0, Vec::len);
        let moved = report["warnings"].to_string().contains("outside its limits -1 to 2 rad: moved by -1.000000 rad");
        (["limits", "friction", "joint_dampers", "motors"].map(count), moved)
    };
    assert_eq!(counts(&[]), ([1, 1, 1, 1], true));
    assert_eq!(counts(&["--without", "limits"]), ([0, 1, 1, 1], false));
    assert_eq!(counts(&["--without", "friction", "--without", "damping"]), ([1, 0, 0, 1], true));
    assert_eq!(counts(&["--without", "motors", "--without", "contact"]), ([1, 1, 1, 0], true));
    let output = run(&folder, &["simulate", "scene.toml", "--without", "gravity"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("limits, friction, damping, motors, contact"), "{}", text(&output.stderr));
}

#[test]
fn wrong_joints_motors_and_tables_write_nothing() {
    let folder = limited("wrong", "");
    std::fs::write(folder.join("gap.csv"), "0,1\n\n1,2\n").expect("written");
    for (keys, place) in [
        ("[[motor]]\njoint = \"knee\"\nkind = \"effort\"\ntarget = 1\n", "scene.toml:4: motor on \"knee\": "),
        ("[[motor]]\njoint = \"hinge\"\nkind = \"effort\"\ntarget = \"gap.csv\"\n", "gap.csv:2: motor on \"hinge\": "),
        ("[[joint]]\nname = \"hinge\"\nlimit = [2, 1]\n", "scene.toml:5: joint \"hinge\": joint.limit: "),
    ] {
        std::fs::write(folder.join("scene.toml"), format!("[[robot]]\nurdf = \"limited.urdf\"\n{keys}"))
            .expect("written");
        std::fs::write(folder.join("scene.mcap"), "kept").expect("written");
        let output = run(&folder, &["simulate", "scene.toml"]);
        assert_one_error(&output, 2, keys);
        assert!(text(&output.stderr).contains(place), "{}", text(&output.stderr));
        assert_eq!(std::fs::read_to_string(folder.join("scene.mcap")).expect("there"), "kept");
    }
    let reversed = PENDULUM.replace(
        "type=\"continuous\">",
        "type=\"revolute\">\n<limit lower=\"1\" upper=\"-1\" effort=\"1\" velocity=\"1\"/>",
    );
    std::fs::write(folder.join("reversed.urdf"), reversed).expect("written");
    let output = run(&folder, &["simulate", "reversed.urdf"]);
    assert_one_error(&output, 2, "reversed limits");
    assert!(
        text(&output.stderr).contains("reversed.urdf:6: joint \"hinge\": its lower limit 1"),
        "{}",
        text(&output.stderr)
    );
    assert!(!folder.join("reversed.mcap").exists());
}

#[test]
fn limits_that_cannot_be_reached_and_friction_that_cannot_matter_are_said_where_that_is_proved() {
    let never = |folder: &std::path::Path, input: &str| -> Vec<(bool, bool)> {
        let report = model(folder, &[input]);
        let limits = report["limits"].as_array().expect("limits").iter();
        limits.map(|limit| (!limit["lower_never_reached"].is_null(), !limit["upper_never_reached"].is_null())).collect()
    };
    // From 0.5 rad at rest the pendulum cannot come to −1 rad nor to 2 rad; at 4 rad/s it can reach the first, and with a motor both.
    let at = |keys: &str| limited("energy", &format!("positions = {{ hinge = 0.5 }}\n{keys}"));
    assert_eq!(never(&at(""), "scene.toml"), [(true, true)]);
    assert_eq!(never(&at("velocities = { hinge = 4 }"), "scene.toml"), [(false, true)]);
    assert_eq!(never(&at("velocities = { hinge = 30 }"), "scene.toml"), [(false, false)]);
    let motor = "[[motor]]\njoint = \"hinge\"\nkind = \"effort\"\ntarget = 1\n";
    assert_eq!(never(&at(motor), "scene.toml"), [(false, false)]);
    assert_eq!(never(&at("[[load]]\njoint = \"hinge\"\neffort = 1\n"), "scene.toml"), [(false, false)]);
    // A locked joint has friction that never matters.
    let folder = limited("locked", "[[joint]]\nname = \"hinge\"\nlimit = [0.5, 0.5]\n");
    assert_eq!(model(&folder, &["scene.toml"])["friction"][0]["never_matters"], "the joint cannot move");
    // A follower between −1 and 0.5 when its leader is between −0.5 and 1: of its own limits −2 and 0.4 it can reach one.
    let inertial = "<inertial><origin xyz=\"0 0 -0.5\"/><mass value=\"1\"/>\
                    <inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";
    let joint = |name: &str, child: &str, range: &str, more: &str| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><parent link=\"base\"/><child link=\"{child}\"/><axis xyz=\"0 1 0\"/>\
             <limit {range} effort=\"1\" velocity=\"1\"/>{more}</joint>"
        )
    };
    let pair = format!(
        "<robot name=\"pair\"><link name=\"base\"/><link name=\"a\">{inertial}</link><link name=\"b\">{inertial}</link>{}{}</robot>",
        joint("leader", "a", "lower=\"-0.5\" upper=\"1\"", ""),
        joint("follower", "b", "lower=\"-2\" upper=\"0.4\"", "<mimic joint=\"leader\" multiplier=\"-1\"/>")
    );
    std::fs::write(folder.join("pair.urdf"), pair).expect("written");
    // The follower's 0.4 stops the leader at −0.4, before its own −0.5.
    assert_eq!(never(&folder, "pair.urdf"), [(true, false), (true, false)]);
}
