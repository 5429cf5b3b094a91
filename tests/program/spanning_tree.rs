//! Which joints are cut is the program's choice; what it says of them is the file's.

use crate::common::command::{folder, run, text};
use serde_json::Value;
use std::path::PathBuf;

/// Writes a row of four-bars whose couplers hang on each other and whose cranks are pinned to the ground by loops.
fn path(test: &str, count: usize) -> PathBuf {
    let folder = folder(test);
    let rod = |name: &str, centre: &str, moments: [f64; 3]| {
        let [xx, yy, zz] = moments;
        format!(
            "<link name='{name}'><inertial><origin xyz='{centre}'/><mass value='1'/>\
             <inertia ixx='{xx}' iyy='{yy}' izz='{zz}' ixy='0' ixz='0' iyz='0'/></inertial></link>"
        )
    };
    let crank = |index: usize, centre: &str| rod(&format!("crank{index}"), centre, [0.0834, 0.0833, 1e-4]);
    let hinge = |child: &str, parent: &str, at: &str| {
        format!(
            "<joint name='{child}' type='continuous'><parent link='{parent}'/><child link='{child}'/><origin xyz='{at}'/>\
             <axis xyz='0 -1 0'/></joint>"
        )
    };
    let mut urdf = format!("<robot name='path'><link name='base'/>{}", crank(0, "0 0 0.5"));
    urdf += &hinge("crank0", "base", "0 0 0");
    let mut scene = "[scene]\nname = \"path\"\n[[robot]]\nname = \"bars\"\nurdf = \"path.urdf\"\n[robot.velocities]\ncrank0 = -9.0\n".to_string();
    let mut loops = String::new();
    for index in 0..count {
        let (own, next) = (format!("coupler{index}"), format!("crank{}", index + 1));
        let (parent, at) = match index {
            0 => ("crank0".to_string(), "0 0 1"),
            _ => (format!("coupler{}", index - 1), "1 0 0"),
        };
        urdf += &(rod(&own, "0.5 0 0", [1e-4, 0.0833, 0.0834]) + &hinge(&own, &parent, at));
        urdf += &(crank(index + 1, "0 0 -0.5") + &hinge(&next, &own, "1 0 0"));
        scene += &format!("{own} = {}\n{next} = -9.0\n", if index == 0 { 9.0 } else { 0.0 });
        loops += &format!(
            "[[loop]]\nname = \"foot{next}\"\ntype = \"revolute\"\na = {{ link = \"{next}\", position = [0, 0, -1], axis = [0, 1, 0] }}\n\
             b = {{ link = \"world\", position = [{}, 0, 0], axis = [0, 1, 0] }}\n",
            index + 1
        );
    }
    std::fs::write(folder.join("path.urdf"), urdf + "</robot>").expect("written");
    std::fs::write(folder.join("scene.toml"), scene + &loops).expect("written");
    folder
}

fn report(folder: &std::path::Path, arguments: &[&str]) -> Value {
    let output = run(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_str(text(&output.stdout)).expect("one JSON object")
}

#[test]
fn the_model_verb_says_which_joints_are_cut_in_place_of_loops_and_keeps_the_tree_on_demand() {
    let folder = path("cut", 8);
    let cut = |arguments: &[&str]| {
        let model = report(&folder, &[&["model", "scene.toml", "--json"], arguments].concat());
        let names = |key: &str| -> Vec<String> {
            let names = model["spanning_tree"][key].as_array().expect("a list").iter();
            names.map(|name| name.as_str().expect("a name").to_string()).collect()
        };
        (names("cut_joints"), names("joined_loops"))
    };
    let (joints, loops) = cut(&[]);
    assert_eq!((joints.len(), loops.len()), (8, 8), "{joints:?} {loops:?}");
    assert!(joints.iter().all(|name| name.starts_with('c')) && loops.iter().all(|name| name.starts_with("footcrank")));
    assert_eq!(cut(&["--keep", "tree"]), (Vec::new(), Vec::new()));
    let output = run(&folder, &["model", "scene.toml"]);
    let tables = text(&output.stdout);
    assert!(tables.contains("joint that is cut") && tables.contains("--keep tree"), "{tables}");
}

#[test]
fn reports_have_the_names_and_numbers_of_the_file_whichever_joints_are_cut() {
    let folder = path("names", 8);
    let run = |arguments: &[&str]| {
        let arguments =
            [&["simulate", "scene.toml", "--duration", "0.6", "--tolerance", "1e-9", "--no-log", "--json"], arguments];
        report(&folder, &arguments.concat())
    };
    let (own, kept) = (run(&[]), run(&["--keep", "tree"]));
    for part in ["joints", "loops", "links"] {
        let (own, kept) = (own[part].as_object().expect("a map"), kept[part].as_object().expect("a map"));
        assert!(own.keys().eq(kept.keys()), "{part}");
        for (name, numbers) in own {
            for (key, number) in numbers.as_object().expect("a map") {
                // Both runs are within 1e-9 m; forces of some thousand newtons follow from places and rates.
                let allowed = if key.starts_with("reaction") { 1e-4 } else { 1e-6 };
                let values = |value: &Value| match value {
                    Value::Array(all) => all.iter().filter_map(Value::as_f64).collect(),
                    other => other.as_f64().into_iter().collect::<Vec<_>>(),
                };
                for (a, b) in values(number).into_iter().zip(values(&kept[name][key])) {
                    assert!((a - b).abs() < allowed, "{part} {name} {key}: {a} and {b}");
                }
            }
        }
    }
    assert!(own["loops"]["footcrank3"]["gap"].as_f64().expect("a gap") < 1e-12);
}
