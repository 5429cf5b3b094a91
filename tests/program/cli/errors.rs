//! Input, usage and output that cannot be: the exit code, one line that names what is wrong, and no file touched.

use crate::common::command::{PENDULUM, assert_one_error, catena, folder, run, text};
use std::path::Path;

#[test]
fn bad_input_and_bad_usage_exit_with_2_and_one_line_and_touch_no_file() {
    let folder = folder("bad_input");
    std::fs::write(folder.join("empty.urdf"), "").expect("written");
    let junk: Vec<u8> = (0..4096_u32).map(|index| (index.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    std::fs::write(folder.join("junk.urdf"), junk).expect("written");
    let old_log = b"an old log, which is dear to its owner";
    std::fs::write(folder.join("out.mcap"), old_log).expect("written");
    let before = std::fs::read_dir(&folder).expect("readable").count();
    let cases: &[&[&str]] = &[
        &["missing.urdf"],
        &["empty.urdf"],
        &["junk.urdf"],
        &["."],
        &["pendulum.urdf", "--unknown"],
        &["pendulum.urdf", "--durration", "3"],
        &["pendulum.urdf", "--duration", "0"],
        &["pendulum.urdf", "--duration", "-1"],
        &["pendulum.urdf", "--duration", "inf"],
        &["pendulum.urdf", "--duration", "ten"],
        &["pendulum.urdf", "--rate", "0"],
        &["pendulum.urdf", "--rate", "1e300"],
        &["pendulum.urdf", "--tolerance", "NaN"],
        &["pendulum.urdf", "--tolerance", "-1e-6"],
        &["pendulum.urdf", "--stages", "0", "--step", "0.01"],
        &["pendulum.urdf", "--stages", "17", "--step", "0.01"],
        &["pendulum.urdf", "--stages", "3", "--step", "0"],
        &["pendulum.urdf", "--stages", "3"],
        &["pendulum.urdf", "--step", "0.01"],
        &["pendulum.urdf", "--stages", "3", "--step", "0.01", "--tolerance", "1e-6"],
        &["pendulum.urdf", "--base", "flying"],
        &["pendulum.urdf", "--base-pose", "1,2,3"],
        &["pendulum.urdf", "--base-velocity", "1,2,3,4,5,6"],
        &["pendulum.urdf", "--base", "floating", "--base-velocity", "1,2,3,4,5,6", "--velocity", "base=0,0,0,0,0,0"],
        &["pendulum.urdf", "--gravity", "0,0"],
        &["pendulum.urdf", "--gravity", "0,0,nan"],
        &["pendulum.urdf", "--position", "hinge"],
        &["pendulum.urdf", "--position", "hinge=1,2"],
        &["pendulum.urdf", "--position", "knee=1"],
        &["pendulum.urdf", "--velocity", "weld=1"],
        &["pendulum.urdf", "--package", "name"],
        &["pendulum.urdf", "--package", "name=no/such/folder"],
        &["pendulum.urdf", "--position", "hinge=1", "--position", "hinge=2"],
        &["pendulum.urdf", "--velocity", "hinge=1", "--velocity", "hinge=1"],
        &["pendulum.urdf", "--velocity", "hinge=1e300"],
        &["pendulum.urdf", "pendulum.urdf"],
        &[],
    ];
    for case in cases {
        let arguments = [&["simulate", "-o", "out.mcap"], *case].concat();
        assert_one_error(&run(&folder, &arguments), 2, &format!("{case:?}"));
        assert_eq!(std::fs::read(folder.join("out.mcap")).expect("still there"), old_log, "{case:?}");
    }
    assert_eq!(std::fs::read_dir(&folder).expect("readable").count(), before, "no file was added");
}

#[test]
fn an_output_that_cannot_be_is_refused_before_the_run() {
    let folder = folder("bad_output");
    for output in ["no/such/folder/out.mcap", ".", "-", "pendulum.urdf"] {
        let output = run(&folder, &["simulate", "pendulum.urdf", "-o", output, "--duration", "1e9"]);
        assert_one_error(&output, 2, "output");
    }
    for verb in [&["chart", "pendulum.urdf"][..], &["stress"]] {
        assert_one_error(&run(&folder, &[verb, &["-o", "-"]].concat()), 2, verb[0]);
        assert!(!folder.join("-").exists(), "{}", verb[0]);
    }
    let both = run(&folder, &["simulate", "pendulum.urdf", "-o", "out.mcap", "--no-log"]);
    assert_one_error(&both, 2, "-o and --no-log");
    let input = std::fs::read_to_string(folder.join("pendulum.urdf")).expect("still there");
    assert_eq!(input, PENDULUM, "the input is not replaced by its own log");
}

#[test]
fn a_log_replaces_no_file_that_the_run_is_made_from() {
    let folder = folder("made_from");
    let with_mesh = PENDULUM.replace("<box size=\"0.1 0.1 1\"/>", "<mesh filename=\"rod.stl\"/>");
    let scene = "[[robot]]\nurdf = \"rod.unfinished.urdf\"\n";
    let files = [("rod.unfinished.urdf", with_mesh.as_str()), ("rod.stl", "solid rod\nendsolid"), ("rod.toml", scene)];
    for (name, text) in files {
        std::fs::write(folder.join(name), text).expect("written");
    }
    // While it is written, the last one would be in the file of the URDF.
    for output in ["rod.unfinished.urdf", "rod.stl", "rod.toml", "../made_from/rod.stl", "rod.urdf"] {
        let refused = run(&folder, &["simulate", "rod.toml", "-o", output, "--duration", "0.1"]);
        assert_one_error(&refused, 2, output);
        assert!(text(&refused.stderr).contains("is made from"), "{}", text(&refused.stderr));
        for (name, before) in files {
            assert_eq!(std::fs::read_to_string(folder.join(name)).expect("still there"), before, "-o {output}");
        }
    }
    assert!(!folder.join("rod.urdf").exists());
}

#[test]
fn an_error_names_what_is_wrong() {
    let folder = folder("naming");
    std::fs::write(folder.join("far.urdf"), PENDULUM.replace("xyz=\"0 0 -0.5\"", "xyz=\"1e200 0 0\""))
        .expect("written");
    for (arguments, names) in [
        (["missing.urdf", "--rate", "1"], "missing.urdf"),
        (["pendulum.urdf", "--position", "knee=1"], "\"hinge\""),
        (["pendulum.urdf", "--durration", "1"], "'--duration'"),
        (["pendulum.urdf", "--step", "1"], "--stages"),
        (["pendulum.urdf", "--package", "name=no/such/folder"], "there is no folder \"no/such/folder\""),
        (["pendulum.urdf", "--velocity", "hinge=1e300"], "joint \"hinge\" starts so fast"),
        (["far.urdf", "--rate", "1"], "link \"rod\" is 1e200 m away"),
    ] {
        let output = run(&folder, &[&["simulate"], &arguments[..]].concat());
        assert!(text(&output.stderr).contains(names), "{arguments:?}: {}", text(&output.stderr));
    }
}

#[test]
fn a_joint_that_is_given_twice_is_named() {
    let folder = folder("twice");
    for option in ["--position", "--velocity"] {
        let output = run(&folder, &["simulate", "pendulum.urdf", option, "hinge=1", option, "hinge=2"]);
        let expected = format!("{option} is given twice for joint \"hinge\"");
        assert!(text(&output.stderr).contains(&expected), "{}", text(&output.stderr));
    }
}

#[test]
fn a_full_disk_is_an_error_that_names_the_file() {
    if !Path::new("/dev/full").exists() {
        println!("skipped: this system has no /dev/full");
        return;
    }
    let folder = folder("full");
    let output = run(&folder, &["simulate", "pendulum.urdf", "-o", "/dev/full", "--duration", "1"]);
    assert_one_error(&output, 1, "full disk");
    assert!(text(&output.stderr).contains("/dev/full"), "{}", text(&output.stderr));
}

#[cfg(unix)]
#[test]
fn the_report_of_a_run_whose_log_could_not_be_written_names_none() {
    let folder = folder("no_room");
    // Files of at most some kilobytes, as on a disk that is full.
    let program = env!("CARGO_BIN_EXE_catena");
    let limited =
        format!("trap '' XFSZ; ulimit -f 16; exec {program} simulate pendulum.urdf -o run.mcap --position hinge=1");
    let output = std::process::Command::new("sh").args(["-c", &limited]).current_dir(&folder).output().expect("runs");
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("cannot write run.mcap"), "{}", text(&output.stderr));
    assert!(
        text(&output.stdout).contains("energy") && !text(&output.stdout).contains("run.mcap"),
        "{}",
        text(&output.stdout)
    );
}

#[test]
fn folders_that_are_written_go_into_folders_that_exist_as_logs_do() {
    let folder = folder("no_parents");
    let verbs: [&[&str]; 4] = [
        &["simulate", "pendulum.urdf", "-o", "not/there/x"],
        &["chart", "pendulum.urdf", "--quick", "-o", "not/there/x"],
        &["stress", "--quick", "-o", "not/there/x"],
        &["manual", "not/there/x"],
    ];
    for verb in verbs {
        let output = run(&folder, verb);
        assert_one_error(&output, 2, verb[0]);
        assert!(text(&output.stderr).contains("there is no folder not/there"), "{}", text(&output.stderr));
        assert!(!folder.join("not").exists(), "{}", verb[0]);
    }
}

#[test]
fn a_standard_output_that_is_full_is_no_fault_of_the_input_for_any_verb() {
    let Ok(full) = std::fs::OpenOptions::new().write(true).open("/dev/full") else {
        println!("skipped: this system has no /dev/full");
        return;
    };
    let folder = folder("full_output");
    assert_eq!(run(&folder, &["simulate", "pendulum.urdf", "--duration", "0.1"]).status.code(), Some(0));
    let verbs: [&[&str]; 7] = [
        &["simulate", "pendulum.urdf", "--duration", "0.1", "--no-log"],
        &["model", "pendulum.urdf"],
        &["model", "pendulum.urdf", "--json"],
        &["inspect", "pendulum.mcap"],
        &["inspect", "pendulum.mcap", "pendulum.mcap"],
        &["inspect", "pendulum.mcap", "--at", "0.1", "--json"],
        &["replay", "pendulum.mcap"],
    ];
    for verb in verbs {
        let output = catena(&folder, verb).stdout(full.try_clone().expect("opened")).output().expect("runs");
        assert_one_error(&output, 1, verb[0]);
        assert!(text(&output.stderr).contains("cannot write to standard output"), "{}", text(&output.stderr));
    }
}

#[test]
fn a_warning_that_nobody_can_see_does_not_end_the_program() {
    let Ok(full) = std::fs::OpenOptions::new().write(true).open("/dev/full") else {
        println!("skipped: this system has no /dev/full");
        return;
    };
    let folder = folder("full_error");
    assert_eq!(run(&folder, &["simulate", "pendulum.urdf", "--duration", "0.1"]).status.code(), Some(0));
    let log = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    std::fs::write(folder.join("cut.mcap"), &log[..log.len() * 2 / 3]).expect("written");
    let output = catena(&folder, &["inspect", "cut.mcap", "--csv", "cut.csv"]).stderr(full).output().expect("runs");
    assert_eq!(output.status.code(), Some(0));
    assert!(folder.join("cut.csv").exists());
}

/// Two pendulums that float, in one scene.
const TWO: &str = "[[robot]]\nname = \"one\"\nurdf = \"pendulum.urdf\"\nbase = \"floating\"\n\
                   [[robot]]\nname = \"two\"\nurdf = \"pendulum.urdf\"\nbase = \"floating\"\n";

#[test]
fn a_velocity_of_the_base_is_refused_where_there_are_several() {
    let folder = folder("two_bases");
    std::fs::write(folder.join("two.toml"), TWO).expect("written");
    let start = ["simulate", "two.toml", "--no-log", "--duration", "0.1"];
    let output = run(&folder, &[&start[..], &["--base-velocity", "1,0,0,0,0,0"]].concat());
    assert_one_error(&output, 2, "--base-velocity");
    assert!(text(&output.stderr).contains("--velocity ROBOT/base"), "{}", text(&output.stderr));
    let output = run(&folder, &[&start[..], &["--velocity", "two/base=1,0,0,0,0,0"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

#[test]
fn a_loop_has_no_name_that_a_joint_or_another_loop_has() {
    let folder = folder("names");
    let closure = |name: &str| {
        format!(
            "[[loop]]\nname = \"{name}\"\ntype = \"spherical\"\n\
             a = {{ link = \"one/rod\", position = [0, 0, -1] }}\nb = {{ link = \"two/rod\", position = [0, 0, -1] }}\n"
        )
    };
    for (names, code) in [(&["tips"][..], 0), (&["one/hinge"], 2), (&["two/base"], 2), (&["one/weld"], 2)] {
        let scene = [TWO.to_string()].into_iter().chain(names.iter().map(|name| closure(name))).collect::<String>();
        std::fs::write(folder.join("two.toml"), scene).expect("written");
        let output = run(&folder, &["simulate", "two.toml", "--no-log", "--duration", "0.1"]);
        assert_eq!(output.status.code(), Some(code), "{names:?}: {}", text(&output.stderr));
        assert!(code == 0 || text(&output.stderr).contains("give it another"), "{}", text(&output.stderr));
    }
}

#[test]
fn a_link_with_the_name_of_the_world_is_a_link_like_others() {
    let folder = folder("world_link");
    std::fs::write(folder.join("pendulum.urdf"), PENDULUM.replace("\"rod\"", "\"world\"")).expect("written");
    let load =
        "[[robot]]\nurdf = \"pendulum.urdf\"\nbase = \"floating\"\n[[load]]\nlink = \"base\"\nforce = [1, 0, 0]\n";
    std::fs::write(folder.join("loaded.toml"), load).expect("written");
    let output = run(&folder, &["simulate", "loaded.toml", "--no-log", "--duration", "0.1"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

#[test]
fn a_log_is_looked_at_and_replayed_without_the_folders_that_its_run_had() {
    let folder = folder("packages");
    std::fs::create_dir(folder.join("meshes")).expect("made");
    let run_it = ["simulate", "pendulum.urdf", "--package", "name=meshes", "--duration", "0.2"];
    assert_eq!(run(&folder, &run_it).status.code(), Some(0));
    std::fs::remove_dir(folder.join("meshes")).expect("removed");
    for verb in [&["replay", "pendulum.mcap"][..], &["inspect", "pendulum.mcap", "--at", "0.1"]] {
        let output = run(&folder, verb);
        assert_eq!(output.status.code(), Some(0), "{verb:?}: {}", text(&output.stderr));
    }
}

#[test]
fn a_run_that_no_log_can_count_is_refused_with_one() {
    let folder = folder("ages");
    let long = ["simulate", "pendulum.urdf", "--stages", "2", "--step", "1e9", "--duration", "1e11", "--rate", "1e-10"];
    let output = run(&folder, &long);
    assert_one_error(&output, 2, "1e11 s");
    assert!(text(&output.stderr).contains("--no-log"), "{}", text(&output.stderr));
    assert!(!folder.join("pendulum.mcap").exists());
}

#[test]
fn no_two_outputs_are_one_file_and_nothing_is_written_then() {
    let folder = folder("outputs");
    assert_eq!(run(&folder, &["simulate", "pendulum.urdf", "--duration", "0.2"]).status.code(), Some(0));
    for (csv, plot) in [("both.svg", "both.svg"), ("table.csv", "pendulum.mcap"), ("./both.svg", "both.svg")] {
        let output = run(&folder, &["inspect", "pendulum.mcap", "--csv", csv, "--plot", plot]);
        assert_one_error(&output, 2, plot);
        assert!(!folder.join(csv).exists(), "{csv}");
    }
}

#[test]
fn energies_beyond_doubles_are_said_and_are_no_balance() {
    let folder = folder("energies");
    let output = run(
        &folder,
        &[
            "simulate",
            "pendulum.urdf",
            "--base",
            "floating",
            "--gravity",
            "0,0,-1e160",
            "--stages",
            "4",
            "--step",
            "0.01",
            "--duration",
            "1",
            "--no-log",
        ],
    );
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert!(said.contains("energies are beyond what a double holds"), "{said}");
    assert!(!said.contains("largest relative error 0.0e0"), "{said}");
}

#[test]
fn a_report_that_cannot_be_printed_does_not_hide_how_the_run_ended() {
    let Ok(full) = std::fs::OpenOptions::new().write(true).open("/dev/full") else {
        println!("skipped: this system has no /dev/full");
        return;
    };
    let folder = folder("full_report");
    let arguments = ["simulate", "pendulum.urdf", "--velocity", "hinge=1e100", "--no-log", "--json"];
    let output = catena(&folder, &arguments).stdout(full).output().expect("runs");
    assert_one_error(&output, 1, "failed");
    assert!(!text(&output.stderr).contains("standard output"), "{}", text(&output.stderr));
}

#[test]
fn colour_is_for_terminals_or_who_forces_it_and_never_where_no_color_is_set() {
    let folder = folder("colour");
    let told = |variables: &[(&str, &str)]| {
        let mut command = catena(&folder, &["simulate", "missing.urdf"]);
        command.env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE").envs(variables.iter().copied());
        text(&command.output().expect("catena runs").stderr).to_string()
    };
    let plain = told(&[]);
    assert!(plain.starts_with("catena: error: missing.urdf"), "{plain}");
    let coloured = told(&[("CLICOLOR_FORCE", "1")]);
    assert!(coloured.starts_with("catena: \u{1b}[1m\u{1b}[31merror:\u{1b}[0m missing.urdf"), "{coloured:?}");
    assert_eq!(told(&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]), plain);
}

#[test]
fn a_file_of_another_kind_is_told_from_a_broken_robot_and_negative_numbers_with_exponents_are_numbers() {
    let folder = folder("other_kinds");
    for name in ["run.py", "bowl.obj", "robot.json"] {
        std::fs::write(folder.join(name), "{ \"a\": 1 }\n").expect("written");
        let output = run(&folder, &["simulate", name, "--no-log"]);
        assert_one_error(&output, 2, name);
        assert!(text(&output.stderr).contains("neither a robot nor a scene"), "{}", text(&output.stderr));
    }
    let output = run(&folder, &["simulate", "pendulum.urdf", "--no-log", "--tolerance", "-1e-3"]);
    assert_one_error(&output, 2, "-1e-3");
    assert!(text(&output.stderr).contains("'-1e-3'") && text(&output.stderr).contains("greater than zero"));
}
