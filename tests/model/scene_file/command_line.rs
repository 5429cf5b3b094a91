//! Scene files on the command line: what goes before what, what is refused, and what the log and `catena model` show.

use super::{TWO, build, folder};
use crate::common::command::{self, assert_one_error, run};
use catena::instant::exerting::rest::is_at_rest;
use serde_json::Value;
use std::path::Path;

#[test]
fn a_scene_of_one_robot_moves_as_the_robot_alone() {
    let folder = folder("alone");
    let text = "[scene]\ngravity = [0, 0, -1.62]\n[[robot]]\nname = \"x\"\nurdf = \"double.urdf\"\npositions = { elbow = 0.5 }";
    std::fs::write(folder.join("scene.toml"), text).unwrap();
    let links = |arguments: &[&str]| {
        let report = report(&folder, arguments);
        (report["links"].clone(), report["joints"].clone(), report["energy"].clone())
    };
    let method = ["--stages", "3", "--step", "0.01", "--duration", "1", "--no-log", "--json"];
    let of_scene = links(&[&["simulate", "scene.toml"], &method[..]].concat());
    let of_robot = links(
        &[&["simulate", "double.urdf", "--gravity", "0,0,-1.62", "--position", "elbow=0.5"], &method[..]].concat(),
    );
    assert_eq!(of_scene, of_robot);
}

fn report(folder: &Path, arguments: &[&str]) -> Value {
    let output = run(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn the_command_line_goes_before_the_scene_file_and_that_before_the_defaults() {
    let folder = folder("overrides");
    let text = "[scene]\nname = \"swing\"\ngravity = [0, 0, -2]\n[[robot]]\nurdf = \"pendulum.urdf\"\n\
                positions = { hinge = 0.5 }\nvelocities = { hinge = 0.25 }\n\
                [simulation]\nduration = 0.5\nstages = 3\nstep = 0.0625\nrate = 10\n";
    std::fs::write(folder.join("scene.toml"), text).unwrap();
    let quick = |extra: &[&str]| report(&folder, &[&["simulate", "scene.toml", "--no-log", "--json"], extra].concat());
    let plain = quick(&[]);
    assert_eq!((&plain["scene"], &plain["duration"]), (&Value::from("swing"), &Value::from(0.5)));
    assert_eq!((&plain["method"]["stages"], &plain["method"]["step"]), (&Value::from(3), &Value::from(0.0625)));
    let start = |report: &Value| report["energy"]["initial"].as_f64().unwrap();
    // Of the rod: m l² about the hinge, and its centre 0.5 m below.
    let energy = |angle: f64, rate: f64, gravity: f64| 0.5 * (0.1 + 0.25) * rate * rate - 0.5 * gravity * angle.cos();
    assert!((start(&plain) - energy(0.5, 0.25, 2.0)).abs() < 1e-14);
    assert!((start(&quick(&["--gravity", "0,0,-3"])) - energy(0.5, 0.25, 3.0)).abs() < 1e-14);
    assert!((start(&quick(&["--position", "hinge=1"])) - energy(1.0, 0.25, 2.0)).abs() < 1e-14);
    assert!((start(&quick(&["--velocity", "hinge=1"])) - energy(0.5, 1.0, 2.0)).abs() < 1e-14);
    assert_eq!(quick(&["--duration", "0.25"])["duration"], 0.25);
    let tolerance = quick(&["--tolerance", "1e-3"]);
    assert_eq!(
        (&tolerance["method"]["adaptive"], &tolerance["method"]["tolerance"]),
        (&Value::from(true), &Value::from(1e-3))
    );
    let fixed = quick(&["--stages", "4", "--step", "0.125"]);
    assert_eq!((&fixed["method"]["stages"], &fixed["method"]["step"]), (&Value::from(4), &Value::from(0.125)));
    let moved = quick(&["--base-pose", "1,2,3,0,0,0"]);
    assert_eq!(moved["links"]["base"]["position"], serde_json::json!([1.0, 2.0, 3.0]));
}

#[test]
fn a_spring_whose_ends_coincide_at_the_start_is_refused_and_is_not_at_rest() {
    let folder = folder("undirected");
    let text = "[[robot]]\nurdf = \"pendulum.urdf\"\n[[spring]]\nstiffness = 5\nrest_length = 1\n\
                a = { link = \"rod\", position = [0, 0, -1] }\nb = { link = \"world\", position = [0, 0, -1] }";
    std::fs::write(folder.join("coincide.toml"), text).unwrap();
    let refused = run(&folder, &["simulate", "coincide.toml", "--no-log"]);
    assert_one_error(&refused, 2, "coincide");
    let message = command::text(&refused.stderr);
    assert!(message.contains("coincide.toml: spring \"spring1\": its ends coincide"), "{message}");
    report(
        &folder,
        &["simulate", "coincide.toml", "--no-log", "--json", "--position", "hinge=0.1", "--duration", "0.1"],
    );
    let (model, _, state) = build(&folder, text);
    assert!(!is_at_rest(&model.mechanism, &state));
    // Without a rest length it is at rest there.
    let (model, _, state) = build(&folder, &text.replace("rest_length = 1", "rest_length = 0"));
    assert!(is_at_rest(&model.mechanism, &state));
}

#[test]
fn one_base_for_several_robots_and_what_is_not_simulated_yet_end_with_2_and_no_file() {
    let folder = folder("refused");
    std::fs::write(folder.join("two.toml"), TWO).unwrap();
    let closing =
        "[[loop]]\ntype = \"distance\"\na = { link = \"left/tip\" }\nb = { link = \"world\", position = [0, 0, 5] }\n";
    std::fs::write(folder.join("closed.toml"), TWO.to_string() + closing).unwrap();
    let before = std::fs::read_dir(&folder).unwrap().count();
    for (arguments, message) in [
        (vec!["simulate", "two.toml", "--base", "floating"], "two.toml has 2"),
        (vec!["simulate", "two.toml", "--base-pose", "0,0,1,0,0,0"], "two.toml has 2"),
        (vec!["simulate", "two.toml", "--base-velocity", "0,0,1,0,0,0"], "is for one robot; there are 2"),
        (vec!["simulate", "two.toml", "--position", "hinge=1"], "\"left/hinge\", \"right/hinge\""),
        (
            vec!["chart", "closed.toml", "-o", "charts"],
            "closed.toml: a chart measures against methods in joint coordinates",
        ),
    ] {
        let output = run(&folder, &arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(
            error.starts_with("catena: error: ") && error.contains(message) && error.lines().count() == 1,
            "{error}"
        );
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), before);
}

#[test]
fn the_log_of_several_robots_describes_each_under_its_own_name() {
    let folder = folder("log");
    std::fs::write(folder.join("two.toml"), TWO.to_string() + "[simulation]\nduration = 0.1\n").unwrap();
    report(&folder, &["simulate", "two.toml", "--json", "--stages", "3", "--step", "0.01"]);
    let bytes = std::fs::read(folder.join("two.mcap")).unwrap();
    let messages: Vec<mcap::Message> = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap).collect();
    let description = |topic: &str| {
        let message = messages.iter().find(|message| message.channel.topic == topic).expect(topic);
        String::from_utf8_lossy(&message.data).into_owned()
    };
    for robot in ["left", "right"] {
        let urdf = description(&format!("/{robot}/robot_description"));
        for name in [
            format!("<link name=\"{robot}/rod\""),
            format!("<parent link=\"{robot}/base\""),
            format!("<child link=\"{robot}/rod\""),
            format!("<joint name=\"{robot}/hinge\""),
        ] {
            assert!(urdf.contains(&name), "{name} in {urdf}");
        }
    }
    // Its looks are in the frames of the transforms.
    let looks = description("/visual_markers");
    assert!(looks.contains("left/rod") && looks.contains("right/rod"));
    let transforms = description("/tf");
    assert!(transforms.contains("left/rod") && transforms.contains("right/tip"));
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let mut attached: Vec<&str> = summary.attachment_indexes.iter().map(|index| index.name.as_str()).collect();
    attached.sort_unstable();
    assert_eq!(attached, ["left/pendulum.urdf", "right/pendulum.urdf", "two.toml"]);
}

#[test]
fn the_model_verb_shows_robots_loops_springs_and_loads() {
    let folder = folder("model_verb");
    let text = TWO.to_string()
        + "[[loop]]\nname = \"rod\"\ntype = \"distance\"\na = { link = \"left/rod\", position = [0, 0, -1] }\nb = { link = \"right/rod\", position = [0.6, 0, -0.2] }\n\
           [[spring]]\na = { link = \"left/tip\" }\nb = { link = \"world\" }\nstiffness = 3\nrest_length = 0.5\n\
           [[load]]\njoint = \"right/hinge\"\neffort = 2\n";
    std::fs::write(folder.join("scene.toml"), text).unwrap();
    let report = report(&folder, &["model", "scene.toml", "--json"]);
    assert_eq!(report["robots"][1]["name"], "right");
    assert_eq!(report["model"]["loops"], 1);
    assert_eq!(
        (&report["loops"][0]["type"], &report["loops"][0]["length"]),
        (&Value::from("distance"), &Value::from(1.0))
    );
    assert_eq!(report["loops"][0]["b"]["body"], "right/rod");
    assert_eq!(
        (&report["springs"][0]["stiffness"], &report["springs"][0]["b"]["body"]),
        (&Value::from(3.0), &Value::from("world"))
    );
    assert_eq!(
        (&report["joint_loads"][0]["joint"], &report["joint_loads"][0]["effort"]),
        (&Value::from("right/hinge"), &Value::from(2.0))
    );
    let table = String::from_utf8(run(&folder, &["model", "scene.toml"]).stdout).unwrap();
    for part in ["1 degree of freedom, 1 loop with 1 equation\n", "distance 1 m", "3.000 N/m", "right/hinge", "effort"]
    {
        assert!(table.contains(part), "{part:?} in {table}");
    }
}
