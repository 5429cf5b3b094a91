//! Contact on the command line: the floor, which pairs are looked at, what is shown of them, and what a log carries of it.

use crate::common::command::{PENDULUM, assert_one_error, folder, run, text};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

const FLOOR: &str = "[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n";

/// A folder with the pendulum, a ball at the end of its rod, and a scene of it whose pivot is 2.2 m above z = 0.
fn touching(name: &str, scene: &str) -> PathBuf {
    let folder = folder(name);
    let ball = "<link name=\"tip\"><collision><geometry><sphere radius=\"0.1\"/></geometry></collision></link>";
    std::fs::write(folder.join("touching.urdf"), PENDULUM.replace("<link name=\"tip\"/>", ball)).expect("written");
    let text = format!("[[robot]]\nurdf = \"touching.urdf\"\npose = {{ position = [0, 0, 2.2] }}\n{scene}");
    std::fs::write(folder.join("scene.toml"), text).expect("written");
    folder
}

fn model(folder: &Path, arguments: &[&str]) -> Value {
    let output = run(folder, &[&["model", "--json"], arguments].concat());
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&output.stderr)))
}

/// The pairs, and the names of the rules that left out others.
fn pairs(folder: &Path, arguments: &[&str]) -> (Vec<String>, Vec<String>) {
    let contact = model(folder, arguments)["contact"].take();
    let name = |pair: &Value, key: &str| pair[key].as_str().expect("a name").to_string();
    let list = |key: &str| contact[key].as_array().expect("a list").clone();
    let pairs = list("pairs").iter().map(|pair| format!("{}|{}", name(pair, "a"), name(pair, "b"))).collect();
    (pairs, list("never_touch").iter().map(|pair| name(pair, "rule")).collect())
}

#[test]
fn a_floor_is_put_where_it_is_said_and_a_file_is_not_taken_for_its_height() {
    let folder = touching("floor", "");
    // The ball reaches down to 1.1 m below the pivot.
    let one = (vec!["tip|floor".to_string()], vec![]);
    let never = (vec![], vec!["out_of_reach".to_string()]);
    for (arguments, expected) in [
        (&["--floor", "touching.urdf"][..], &one),
        (&["touching.urdf", "--floor"], &one),
        (&["touching.urdf", "--floor", "-1.09"], &one),
        (&["touching.urdf", "--floor=-1.09"], &one),
        (&["--floor", "-1.11", "touching.urdf"], &never),
        (&["--floor", "scene.toml"], &never),
        (&["scene.toml", "--floor", "1.11"], &one),
        (&["scene.toml", "--floor", "1.11", "--contact", "all"], &one),
    ] {
        assert_eq!(&pairs(&folder, arguments), expected, "{arguments:?}");
    }
    let nothing = (vec![], vec![]);
    for arguments in [&["scene.toml"][..], &["touching.urdf"], &["touching.urdf", "--floor", "--without", "contact"]] {
        assert_eq!(pairs(&folder, arguments), nothing, "{arguments:?}");
    }
    let contact = model(&folder, &["touching.urdf", "--floor", "-1"])["contact"].take();
    assert_eq!(contact["touching"], "all");
    assert_eq!(contact["pairs"], json!([{"a": "tip", "b": "floor", "friction": 0.5, "restitution": 0.0}]));
    let shape = |index: usize| contact["shapes"][index].clone();
    let ball = json!({"name": "tip", "obstacle": false, "body": "rod", "shape": "sphere", "radius": 0.1,
                      "position": [0.0, 0.0, -0.5], "orientation": [1.0, 0.0, 0.0, 0.0]});
    assert_eq!(shape(0), ball);
    let floor = json!({"name": "floor", "obstacle": true, "body": "world", "shape": "half_space",
                       "position": [0.0, 0.0, -1.0], "orientation": [1.0, 0.0, 0.0, 0.0]});
    assert_eq!(shape(1), floor);
}

#[test]
fn the_tables_of_the_model_show_shapes_obstacles_and_pairs_and_why_others_never_touch() {
    let rules = "[contact]\nfriction = 0.25\n[[contact.pair]]\na = \"tip\"\nb = \"wall\"\nignore = true\n";
    let wall = "[[obstacle]]\nname = \"wall\"\nshape = { type = \"box\", size = [1, 2, 3] }\n";
    let folder = touching(
        "tables",
        &format!("{}{wall}{rules}", FLOOR.replace("space\" }", "space\" }\npose = { position = [0, 0, 1.2] }")),
    );
    let output = run(&folder, &["model", "scene.toml"]);
    let said = text(&output.stdout);
    for part in ["radius 0.1000", "half space", "1.000, 2.000, 3.000", "0.2500", "[[contact.pair]] of line 13"] {
        assert!(said.contains(part), "{part:?} in {said}");
    }
    let silent = |arguments: &[&str], why: &str| {
        let output = run(&folder, &[&["model", "touching.urdf"], arguments].concat());
        let said = format!("the collision shapes of 1 link touch nothing: {why}");
        assert!(text(&output.stdout).contains(&said), "{}", text(&output.stdout));
        assert!(!text(&output.stdout).contains("warning"), "{}", text(&output.stdout));
    };
    silent(&[], "there is no obstacle (--floor gives one)");
    silent(&["--without", "contact"], "contact is left out");
    silent(&["--contact", "none"], "contact is left out");
}

#[test]
fn wrong_contact_writes_nothing() {
    let folder = touching("wrong_contact", FLOOR);
    std::fs::write(folder.join("scene.mcap"), "kept").expect("written");
    for (arguments, part) in [
        (&["--floor"][..], "the scene has an obstacle \"floor\" already"),
        (&["--floor", "nan"], "is not finite"),
        (&["--floor=low"], "\"low\" is not a number"),
        (&["--contact", "some"], "\"some\" is not one of: none, environment, all"),
        (&["--contact"], "--contact"),
    ] {
        let output = run(&folder, &[&["simulate", "scene.toml"], arguments].concat());
        assert_one_error(&output, 2, &format!("{arguments:?}"));
        assert!(text(&output.stderr).contains(part), "{}", text(&output.stderr));
    }
    let output = run(&folder, &["simulate", "touching.urdf", "--floor", "--contact", "none"]);
    assert_one_error(&output, 2, "a floor that nothing touches");
    assert!(text(&output.stderr).contains("--contact environment"), "{}", text(&output.stderr));
    let scene = std::fs::read_to_string(folder.join("scene.toml")).expect("there");
    for (wrong, part) in [
        ("friction = -1\n", "scene.toml:7: obstacle \"floor\": obstacle.friction: -1 must not be negative"),
        ("[[contact.pair]]\na = \"foot*\"\nb = \"floor\"\nfriction = 1\n", "scene.toml:7: contact of \"foot*\" and"),
        ("[[obstacle]]\nshape = { type = \"mesh\", file = \"none.stl\" }\n", "scene.toml:8: obstacle \"obstacle2\": "),
    ] {
        std::fs::write(folder.join("scene.toml"), format!("{scene}{wrong}")).expect("written");
        let output = run(&folder, &["simulate", "scene.toml"]);
        assert_one_error(&output, 2, wrong);
        assert!(text(&output.stderr).contains(part), "{}", text(&output.stderr));
    }
    assert_eq!(std::fs::read_to_string(folder.join("scene.mcap")).expect("there"), "kept");
    assert!(!folder.join("touching.mcap").exists());
}

#[test]
fn a_report_has_contacts_and_a_log_carries_the_meshes_that_may_touch() {
    let folder = touching("carried", "");
    let triangles = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let ball = "<sphere radius=\"0.1\"/>";
    let urdf = std::fs::read_to_string(folder.join("touching.urdf")).expect("there");
    std::fs::write(folder.join("touching.urdf"), urdf.replace(ball, "<mesh filename=\"tip.obj\"/>")).expect("written");
    std::fs::write(folder.join("tip.obj"), triangles).expect("written");
    std::fs::write(folder.join("far.obj"), triangles).expect("written");
    let obstacle =
        "[[obstacle]]\nshape = { type = \"mesh\", file = \"far.obj\" }\npose = { position = [0.7, 0, 1.4] }\n";
    let scene = std::fs::read_to_string(folder.join("scene.toml")).expect("there") + obstacle;
    std::fs::write(folder.join("scene.toml"), scene).expect("written");
    let output = run(&folder, &["simulate", "scene.toml", "--duration", "0.1", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(report["contact"], json!({"max_penetration": 0.0, "max_cone_violation": 0.0, "points": []}));
    let output = run(&folder, &["inspect", "scene.mcap", "--json"]);
    let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let length = Some(triangles.len() as u64);
    assert_eq!(summary["attachments"]["tip.obj"].as_u64(), length);
    assert_eq!(summary["attachments"]["far.obj"].as_u64(), length);
    let topics: Vec<&str> =
        summary["topics"].as_array().expect("topics").iter().filter_map(|t| t["topic"].as_str()).collect();
    assert!(topics.contains(&"/contacts") && topics.contains(&"/contact_forces"), "{topics:?}");
    // The files themselves are not needed any more.
    std::fs::remove_file(folder.join("tip.obj")).expect("removed");
    std::fs::remove_file(folder.join("far.obj")).expect("removed");
    let output = run(&folder, &["replay", "scene.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let output = run(&folder, &["inspect", "scene.mcap", "--at", "0.05", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    // Where nothing can touch, no mesh is carried and none is missed.
    let output = run(&folder, &["simulate", "touching.urdf", "--duration", "0.1", "--json"]);
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(!report["warnings"].to_string().contains("touches nothing"), "{}", report["warnings"]);
}

#[test]
fn a_start_inside_a_floor_is_moved_out_and_said() {
    let folder = touching("inside", "");
    // Turned a little, so that there is a way out, and hanging straight, where no small motion lifts the ball, which is 0.1 m inside.
    for turned in ["hinge=0.1", "hinge=0"] {
        let arguments =
            ["scene.toml", "--floor", "1.2", "--position", turned, "--duration", "0.01", "--no-log", "--json"];
        let output = run(&folder, &[&["simulate"], &arguments[..]].concat());
        let report: Value =
            serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", text(&output.stderr)));
        let warnings = report["warnings"].as_array().expect("a list");
        let said = |warning: &Value| warning.as_str().is_some_and(|warning| warning.contains("inside each other"));
        assert!(warnings.iter().any(said), "{turned}: {warnings:?}");
        let overlap = report["contact"]["max_penetration"].as_f64().expect("a number");
        assert!(overlap < 1e-12, "{turned}: {overlap}");
    }
}

/// Adds the robot whose tip has this mesh.
fn with_mesh(folder: &Path, file: &str) {
    let urdf = std::fs::read_to_string(folder.join("touching.urdf")).expect("there");
    let mesh = format!("<mesh filename=\"{file}\"/>");
    std::fs::write(folder.join("bad.urdf"), urdf.replace("<sphere radius=\"0.1\"/>", &mesh)).expect("written");
}

#[test]
fn a_mesh_of_a_link_that_is_missing_touches_nothing_and_the_run_says_where() {
    let folder = touching("missing_mesh", "");
    with_mesh(&folder, "none.obj");
    let arguments = ["simulate", "bad.urdf", "--floor", "-1", "--duration", "0.1", "--no-log", "--json"];
    let output = run(&folder, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let said: Vec<&str> = report["warnings"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    let about: Vec<&&str> = said.iter().filter(|warning| warning.contains("so this shape touches nothing")).collect();
    assert_eq!(about.len(), 1, "{said:?}");
    for part in ["bad.urdf:", "link \"tip\"", "none.obj", "was not found"] {
        assert!(about[0].contains(part), "{part:?} in {}", about[0]);
    }
}

#[test]
fn a_mesh_of_a_link_that_is_there_and_no_shape_ends_every_verb_with_exit_code_two_and_writes_nothing() {
    let folder = touching("bad_meshes", "");
    std::fs::write(folder.join("line.obj"), "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n").expect("written");
    std::fs::write(folder.join("cut.stl"), [7; 90]).expect("written");
    for (file, reason) in [("line.obj", "has an area"), ("cut.stl", "it is cut off")] {
        with_mesh(&folder, file);
        let count = || std::fs::read_dir(&folder).expect("a folder").count();
        let before = count();
        for arguments in [
            &["simulate", "bad.urdf", "--floor", "-1", "--duration", "0.1"][..],
            &["simulate", "bad.urdf", "--floor", "-1", "--duration", "0.1", "--report", "page.html", "-o", "log.mcap"],
            &["model", "bad.urdf", "--floor", "-1"],
            &["model", "bad.urdf", "--floor", "-1", "-o", "model.html"],
        ] {
            let output = run(&folder, arguments);
            assert_one_error(&output, 2, file);
            for part in ["bad.urdf:", "link \"tip\"", file, "cannot be used", reason, "collision = \"none\""] {
                assert!(text(&output.stderr).contains(part), "{part:?} in {}", text(&output.stderr));
            }
            assert_eq!(count(), before, "{file}: nothing was written");
        }
        // Without contact the same robot runs.
        let output = run(&folder, &["simulate", "bad.urdf", "--duration", "0.1", "--no-log"]);
        assert_eq!(output.status.code(), Some(0), "{file}: {}", text(&output.stderr));
    }
}

#[cfg(unix)]
#[test]
fn a_mesh_that_may_not_be_read_is_there_and_an_error() {
    use std::os::unix::fs::PermissionsExt;
    let folder = touching("unreadable_mesh", "");
    with_mesh(&folder, "closed.stl");
    std::fs::write(folder.join("closed.stl"), [0; 84]).expect("written");
    std::fs::set_permissions(folder.join("closed.stl"), std::fs::Permissions::from_mode(0o000)).expect("closed");
    if std::fs::read(folder.join("closed.stl")).is_ok() {
        println!("skipped: the user of the tests may read everything");
        return;
    }
    let output = run(&folder, &["simulate", "bad.urdf", "--floor", "-1", "--no-log"]);
    assert_one_error(&output, 2, "a mesh without permission");
    assert!(
        text(&output.stderr).contains("\"closed.stl\" cannot be used: it cannot be read"),
        "{}",
        text(&output.stderr)
    );
}

#[test]
fn one_collision_shape_of_a_link_can_be_left_out_and_the_others_touch() {
    let folder = touching("one_shape", "");
    let urdf = std::fs::read_to_string(folder.join("touching.urdf")).expect("there");
    let line = "<collision><geometry><mesh filename=\"line.obj\"/></geometry></collision></link>";
    let two = urdf.replace("</collision></link>", &format!("</collision>{line}"));
    std::fs::write(folder.join("two.urdf"), two).expect("written");
    std::fs::write(folder.join("line.obj"), "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n").expect("written");
    let floor = FLOOR.replace("space\" }", "space\" }\npose = { position = [0, 0, 1.2] }");
    let scene = |links: &str| {
        let robot = "[[robot]]\nurdf = \"two.urdf\"\npose = { position = [0, 0, 2.2] }\n";
        std::fs::write(folder.join("scene.toml"), format!("{robot}{floor}{links}")).expect("written");
    };
    let link = |rest: &str| format!("[[link]]\nname = \"tip\"\n{rest}\n");
    scene("");
    let output = run(&folder, &["model", "scene.toml"]);
    assert_one_error(&output, 2, "a line");
    // The error says what to write, and that helps.
    for part in ["name = \"tip\"", "shape = 2", "collision = \"none\""] {
        assert!(text(&output.stderr).contains(part), "{part:?} in {}", text(&output.stderr));
    }
    scene(&link("shape = 2\ncollision = \"none\""));
    assert_eq!(pairs(&folder, &["scene.toml"]), (vec!["tip|floor".to_string()], vec![]));
    // What is said of a shape goes before what is said of the link.
    scene(&(link("collision = \"none\"") + &link("shape = 1\ncollision = \"hull\"")));
    assert_eq!(pairs(&folder, &["scene.toml"]), (vec!["tip|floor".to_string()], vec![]));
    scene(&link("collision = \"none\""));
    assert_eq!(pairs(&folder, &["scene.toml"]), (vec![], vec![]));
    let none = "collision = \"none\"";
    for (links, part) in [
        (link(&format!("shape = 3\n{none}")), "no collision shape 3: they are counted from 1, and it has 2"),
        (link(&format!("shape = 0\n{none}")), "no collision shape 0"),
        (link(&format!("shape = 2\n{none}")).repeat(2), "already has the [[link]]"),
        (link(none).repeat(2), "already has the [[link]]"),
    ] {
        scene(&links);
        let output = run(&folder, &["model", "scene.toml"]);
        assert_one_error(&output, 2, &links);
        assert!(text(&output.stderr).contains(part), "{part:?} in {}", text(&output.stderr));
    }
}

#[test]
fn a_contact_pair_that_changes_nothing_is_a_warning_with_its_line_and_the_reason() {
    let folder = touching("pairs_of_nothing", "");
    let robot = |name: &str, x: f64| {
        format!("[[robot]]\nname = \"{name}\"\nurdf = \"touching.urdf\"\npose = {{ position = [{x}, 0, 2.2] }}\n")
    };
    let robots = robot("one", 0.0) + &robot("two", 3.0) + FLOOR;
    let pair = |a: &str, b: &str| format!("[[contact.pair]]\na = \"{a}\"\nb = \"{b}\"\nfriction = 0.9\n");
    let warnings = |contact: &str, pair: &str| -> Vec<String> {
        std::fs::write(folder.join("scene.toml"), format!("{robots}{contact}{pair}")).expect("written");
        let output = run(&folder, &["simulate", "scene.toml", "--duration", "0.01", "--no-log", "--json"]);
        let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let all = report["warnings"].as_array().expect("a list").iter().filter_map(Value::as_str);
        all.filter(|warning| warning.contains("changes nothing")).map(str::to_string).collect()
    };
    let (default, environment) = ("", "[contact]\npairs = \"environment\"\n");
    let (all, none) = ("[contact]\npairs = \"all\"\n", "[contact]\npairs = \"none\"\n");
    for (contact, rule, reason) in [
        (environment, pair("one/tip", "two/tip"), Some("pairs = \"environment\"")),
        (default, pair("one/tip", "two/tip"), None),
        (default, pair("one/*", "one/tip"), Some("a link does not touch itself")),
        (all, pair("one/tip", "one/tip"), Some("a link does not touch itself")),
        (all, pair("fl*", "floor"), Some("obstacles do not touch each other")),
        (all, pair("one/tip", "two/tip"), None),
        (all, pair("one/tip", "*"), None),
        (default, pair("floor", "*/tip"), None),
        (none, pair("one/tip", "two/tip"), None),
    ] {
        let said = warnings(contact, &rule);
        assert_eq!(said.len(), usize::from(reason.is_some()), "{rule}: {said:?}");
        if let Some(reason) = reason {
            let line = format!("scene.toml:{}: contact of", 12 + contact.lines().count());
            assert!(said[0].contains(reason) && said[0].contains(&line), "{reason}, {line}: {}", said[0]);
        }
    }
}

#[test]
fn a_robot_without_collision_shapes_above_a_floor_is_a_warning() {
    let folder = folder("no_shapes");
    let link = |shape: &str| {
        format!(
            "<link name=\"rod\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" \
             iyz=\"0\"/></inertial>{shape}</link>"
        )
    };
    let warnings = |shape: &str, more: &[&str]| -> Vec<String> {
        std::fs::write(folder.join("rod.urdf"), format!("<robot name=\"rod\">{}</robot>", link(shape)))
            .expect("written");
        let arguments = ["simulate", "rod.urdf", "--base", "floating", "--duration", "0.01", "--no-log", "--json"];
        let output = run(&folder, &[&arguments[..], more].concat());
        let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let all = report["warnings"].as_array().expect("a list").iter().filter_map(Value::as_str);
        all.filter(|warning| warning.contains("nothing touches")).map(str::to_string).collect()
    };
    let ball = "<collision><geometry><sphere radius=\"0.1\"/></geometry></collision>";
    let said = warnings("", &["--floor=-1"]);
    assert!(
        said.len() == 1 && said[0].contains("no link of robot \"rod\"") && said[0].contains("\"floor\""),
        "{said:?}"
    );
    assert_eq!(warnings(ball, &["--floor=-1"]).len() + warnings("", &[]).len(), 0);
}

#[test]
fn a_log_has_the_forces_of_what_stands_from_its_first_sample_on_and_curves_name_every_pair() {
    let folder = folder("standing");
    let robot = |name: &str| format!("{}/robots/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let rover = robot("rover_turns");
    let output = run(&folder, &["simulate", &rover, "--duration", "0.1", "-o", "rover.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let output = run(&folder, &["inspect", "rover.mcap", "--at", "0", "--json"]);
    let sample: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let contacts = sample["contacts"].as_array().expect("contacts");
    let up: f64 = contacts.iter().map(|contact| contact["force"][2].as_f64().expect("a force")).sum();
    // 12 kg; the solver of contacts is exact to 1e-10.
    assert!(contacts.len() == 8 && (up - 12.0 * 9.81).abs() < 1e-8, "{} contacts, {up} N", contacts.len());
    // Of contacts alone there are curves and a table, but no place of anything.
    let topics = ["--topics", "contacts,contact_forces"];
    run(&folder, &[&["simulate", &rover, "--duration", "0.1", "-o", "contacts.mcap"], &topics[..]].concat());
    for arguments in [&["inspect", "contacts.mcap", "--at", "0"][..], &["report", "contacts.mcap", "-o", "page.html"]] {
        let output = run(&folder, arguments);
        assert_one_error(&output, 2, &format!("{arguments:?}"));
        assert!(
            text(&output.stderr).contains("with tf, joint_states and multi_dof_joint_states"),
            "{}",
            text(&output.stderr)
        );
    }
    let output = run(&folder, &["inspect", "contacts.mcap", "--csv", "contacts.csv"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let gripper = robot("gripper_holds_box");
    run(&folder, &["simulate", &gripper, "--duration", "0.2", "-o", "gripper.mcap"]);
    let output = run(&folder, &["inspect", "gripper.mcap", "--plot", "curves.svg", "--curves", "contact"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let curves = std::fs::read_to_string(folder.join("curves.svg")).expect("there");
    for name in ["gripper/left_finger|box/box", "gripper/right_finger|box/box"] {
        assert!(curves.contains(name), "{name}");
    }
    // What does not touch yet has a force of zero, so that the axis begins there.
    assert!(curves.contains(">0</text>") || curves.contains(">\n0\n</text>"), "no label 0 on the axis of forces");
}

#[test]
fn links_of_one_robot_touch_but_for_those_that_joints_join_or_keep_apart_and_those_that_overlap_by_design() {
    let folder = folder("itself");
    let ball = |name: &str, x: f64| {
        let origin = format!("<origin xyz=\"{x} 0 0\"/>");
        let inertia = "<inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>";
        format!(
            "<link name=\"{name}\"><inertial><mass value=\"1\"/>{inertia}</inertial><collision>{origin}<geometry><sphere radius=\"0.1\"/></geometry></collision></link>"
        )
    };
    let joint = |kind: &str, parent: &str, child: &str, x: f64| {
        format!(
            "<joint name=\"{parent}{child}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/><origin xyz=\"{x} 0 0\"/>\
             <axis xyz=\"0 0 1\"/><limit lower=\"-0.5\" upper=\"0.5\" effort=\"0\" velocity=\"0\"/></joint>"
        )
    };
    // a and d are one body; a, b, c, e follow each other, by hinges; the ball of e is in that of b.
    let parts = [ball("a", 0.0), ball("d", 0.0), ball("b", 0.25), ball("c", 0.0), ball("e", 0.0)].concat()
        + &[joint("fixed", "a", "d", -0.5), joint("revolute", "a", "b", 0.3)].concat()
        + &[joint("revolute", "b", "c", 0.3), joint("revolute", "c", "e", 0.05)].concat();
    std::fs::write(folder.join("itself.urdf"), format!("<robot name=\"itself\">{parts}</robot>")).expect("written");
    let floor = ["a", "d", "b", "c", "e"].map(|link| format!("{link}|floor"));
    let rules =
        ["one_body", "neighbours", "out_of_reach", "out_of_reach", "neighbours", "out_of_reach", "out_of_reach"];
    let rules = [&rules[..], &["neighbours", "neighbours", "overlap"]].concat();
    let given = ["itself.urdf", "--base", "floating", "--floor", "-1"];
    assert_eq!(pairs(&folder, &given), (floor.to_vec(), rules.iter().map(|rule| (*rule).to_string()).collect()));
    let off = [&given[..], &["--set", "contact.self_contact=0"]].concat();
    assert_eq!(pairs(&folder, &off), (floor.to_vec(), vec![]));
    // The warning names the pair, and says what keeps it.
    let output = run(&folder, &[&["model"], &given[..]].concat());
    assert!(text(&output.stdout).contains("do not touch each other: \"b\" and \"e\"; a [[contact.pair]]"));
    let scene = "[[robot]]\nurdf = \"itself.urdf\"\nbase = \"floating\"\n[contact]\nself_contact = true\n";
    std::fs::write(folder.join("scene.toml"), scene).expect("written");
    assert_eq!(pairs(&folder, &["scene.toml"]), (vec![], rules.iter().map(|rule| (*rule).to_string()).collect()));
    let kept = format!("{scene}[[contact.pair]]\na = \"e\"\nb = \"b\"\nignore = false\n");
    std::fs::write(folder.join("scene.toml"), kept).expect("written");
    assert_eq!(pairs(&folder, &["scene.toml"]).0, ["b|e"]);
    // Without limits a and d meet c and e.
    let free = [&given[..], &["--without", "limits"]].concat();
    assert_eq!(pairs(&folder, &free).0.len(), 5 + 4);
    let wrong = [&["model"], &given[..], &["--set", "contact.self_contact=2"]].concat();
    let output = run(&folder, &wrong);
    assert_one_error(&output, 2, "self_contact");
    assert!(text(&output.stderr).contains("must be 1 (yes) or 0 (no)"), "{}", text(&output.stderr));
}
