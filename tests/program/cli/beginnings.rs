//! Inputs from standard input and from xacro, starts from a log, and warnings that are errors.

use crate::common::command::{PENDULUM, assert_one_error, folder, run, run_with_input, text};
use serde_json::Value;

const MOTION: [&str; 5] = ["simulate", "pendulum.urdf", "--velocity=hinge=1", "--tolerance=1e-10", "--no-log"];

/// One line on standard error that says this.
fn refused(output: &std::process::Output, exit_code: i32, what: &str) {
    assert_one_error(output, exit_code, what);
    assert!(text(&output.stderr).contains(what), "{what}: {}", text(&output.stderr));
}

fn json(output: &std::process::Output) -> Value {
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("a report")
}

#[test]
fn a_robot_or_scene_on_standard_input_is_the_same_as_in_a_file() {
    let folder = folder("standard_input");
    std::fs::write(folder.join("pendulum.urdf"), PENDULUM).expect("written");
    let scene = "[[robot]]\nurdf = \"pendulum.urdf\"\nvelocities = { hinge = 1 }\n";
    let file = json(&run(&folder, &[&MOTION[..], &["--json", "--duration=1"]].concat()));
    let piped = json(&run_with_input(
        &folder,
        &["simulate", "-", "--velocity=hinge=1", "--tolerance=1e-10", "--no-log", "--json", "--duration=1"],
        PENDULUM,
    ));
    let of_scene = json(&run_with_input(
        &folder,
        &["simulate", "-", "--tolerance=1e-10", "--no-log", "--json", "--duration=1"],
        scene,
    ));
    for other in [&piped, &of_scene] {
        assert_eq!(other["joints"], file["joints"]);
        assert_eq!(other["energy"], file["energy"]);
    }
    assert_eq!(run_with_input(&folder, &["simulate", "-", "--duration=1"], scene).status.code(), Some(0));
    let output = run(&folder, &["replay", "stdin.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    refused(&run_with_input(&folder, &["simulate", "-"], ""), 2, "-: the file is empty");
}

#[test]
fn a_run_goes_on_from_an_instant_of_a_log_as_the_run_of_the_log_did() {
    let folder = folder("from_log");
    std::fs::write(folder.join("pendulum.urdf"), PENDULUM).expect("written");
    let whole = json(&run(&folder, &[&MOTION[..4], &["-o", "whole.mcap", "--duration=2", "--json"]].concat()));
    let on = ["simulate", "pendulum.urdf", "--from", "whole.mcap@0.5", "--tolerance=1e-10", "--duration=1.5"];
    let rest = json(&run(&folder, &[&on[..], &["-o", "rest.mcap", "--json"]].concat()));
    assert_eq!(rest["duration"], whole["duration"], "it goes on at the time of the log");
    assert_eq!((&whole["start"], &rest["start"]), (&0.0.into(), &0.5.into()));
    let said = run(&folder, &[&on[..], &["-o", "rest.mcap"]].concat());
    assert!(text(&said.stdout).contains(": 1.5 s simulated in"), "{}", text(&said.stdout));
    let before = std::fs::read(folder.join("whole.mcap")).expect("a log");
    refused(&run(&folder, &[&on[..], &["-o", "whole.mcap"]].concat()), 2, "which it would replace");
    assert!(std::fs::read(folder.join("whole.mcap")).expect("a log") == before, "the log was changed");
    let at_end = |report: &Value, what: &str| report["joints"]["hinge"][what].as_f64().expect("a number");
    // Both are within their tolerances of 1e-10 m at a radius of at most 1 m; samples of the log are interpolated to the same.
    for what in ["position", "velocity"] {
        let difference = (at_end(&rest, what) - at_end(&whole, what)).abs();
        assert!(difference < 1e-8, "{what}: {difference:e}");
    }
    // A floating base with its turned frame starts from its last sample as it ended.
    let floating = ["simulate", "pendulum.urdf", "--base=floating", "--base-velocity=1,0,2,0.1,0.2,0.3", "--json"];
    let whole = json(&run(&folder, &[&floating[..], &["-o", "free.mcap", "--duration=1"]].concat()));
    let on = [
        "simulate",
        "pendulum.urdf",
        "--base=floating",
        "--from=free.mcap@end",
        "--duration=1e-6",
        "--json",
        "--no-log",
    ];
    let rest = json(&run(&folder, &on));
    for joint in ["base", "hinge"] {
        let numbers = |report: &Value| -> Vec<f64> {
            let velocity = &report["joints"][joint]["velocity"];
            let all = velocity.as_array().cloned().unwrap_or_else(|| vec![velocity.clone()]);
            all.iter().map(|number| number.as_f64().expect("a number")).collect()
        };
        for (rest, whole) in numbers(&rest).iter().zip(numbers(&whole)) {
            // A microsecond of accelerations of some 10 m/s² and 10 rad/s².
            assert!((rest - whole).abs() < 1e-4, "{joint}: {rest} {whole}");
        }
    }
    let between = run(&folder, &[&MOTION[..2], &["--from=whole.mcap@0.508", "--duration=0.1", "--no-log"]].concat());
    assert!(text(&between.stdout).contains("no sample at 0.508 s"), "{}", text(&between.stdout));
    refused(&run(&folder, &["replay", "rest.mcap"]), 2, "it went on from the log whole.mcap");
    refused(&run(&folder, &["simulate", "pendulum.urdf", "--from=whole.mcap"]), 2, "LOG@T");
    refused(
        &run(&folder, &["simulate", "pendulum.urdf", "--base=floating", "--from=whole.mcap@1"]),
        2,
        "no joint \"base\"",
    );
}

#[test]
fn a_run_that_goes_on_from_a_log_between_ticks_of_a_motor_holds_the_effort_of_the_log() {
    let folder = folder("from_log_between_ticks");
    std::fs::write(folder.join("pendulum.urdf"), PENDULUM).expect("written");
    let motor = "[[motor]]\njoint = \"hinge\"\nkind = \"position\"\ntarget = 1.0\nkp = 8.0\nkd = 0.5\nperiod = 0.05\n";
    let scene = format!("[scene]\ngravity = [0, 0, 0]\n\n[[robot]]\nurdf = \"pendulum.urdf\"\n\n{motor}");
    std::fs::write(folder.join("scene.toml"), scene).expect("written");
    let made = |arguments: &[&str]| {
        json(&run(&folder, &[&["simulate", "scene.toml", "--tolerance=1e-9", "--json"][..], arguments].concat()))
    };
    let of = |report: &Value, what: &str| report["joints"]["hinge"][what].as_f64().expect("a number");
    let told = |report: &Value| {
        let warnings = report["warnings"].as_array().cloned().unwrap_or_default();
        warnings.iter().filter(|line| line.as_str().is_some_and(|line| line.contains("between its ticks"))).count()
    };
    let whole = made(&["--duration=0.7", "-o", "whole.mcap"]);
    made(&["--duration=0.33", "-o", "part.mcap"]);
    // 22/60 s is a sample of the whole; times of a log are whole nanoseconds, in which the pendulum moves by less than 1e-8 rad.
    for (from, rest, most) in [("part.mcap@end", "0.37", 1e-13), ("whole.mcap@0.366666667", "0.333333333", 3e-8)] {
        let on = made(&["--from", from, "--duration", rest, "-o", "rest.mcap"]);
        for what in ["position", "velocity"] {
            let apart = (of(&on, what) - of(&whole, what)).abs();
            assert!(apart < most, "{from}: {what} differs by {apart:e}");
        }
        assert_eq!(told(&on), 0, "{from}");
    }
    // It goes on from there, too.
    let on = ["--from", "rest.mcap@0.55", "--duration", "0.001", "--no-log"];
    assert_eq!(told(&made(&on)), 0);
    // A log without motors does not know it.
    made(&["--duration=0.33", "-o", "bare.mcap", "--topics", "/joint_states"]);
    let anew = made(&["--from", "bare.mcap@end", "--duration", "0.37", "--no-log"]);
    assert_eq!(told(&anew), 1);
    assert!((of(&anew, "position") - of(&whole, "position")).abs() > 1e-4);
}

#[test]
fn a_run_that_goes_on_from_a_log_holds_joints_where_the_first_run_began() {
    let folder = folder("from_log_held");
    std::fs::write(folder.join("pendulum.urdf"), PENDULUM).expect("written");
    let given = "[[motor]]\njoint = \"hinge\"\nkind = \"position\"\ntarget = \"start\"\nkp = 8.0\nkd = 0.5\n";
    let robot = "[[robot]]\nurdf = \"pendulum.urdf\"\npositions = { hinge = 0.5 }\nvelocities = { hinge = 1.0 }\n";
    // Gains that are given, and gains of `--hold`, which follow from the inertia at the start.
    for (name, motor, hold) in [("given", given, None), ("tuned", "", Some("--hold"))] {
        std::fs::write(folder.join("scene.toml"), format!("{robot}\n{motor}")).expect("written");
        let made = |arguments: &[&str]| {
            let all = ["simulate", "scene.toml", "--tolerance=1e-10", "--rate=100", "--json"].into_iter();
            let all: Vec<&str> = all.chain(hold).chain(arguments.iter().copied()).collect();
            json(&run(&folder, &all))
        };
        let of = |report: &Value, what: &str| report["joints"]["hinge"][what].as_f64().expect("a number");
        let whole = made(&["--duration=0.5", "-o", "whole.mcap"]);
        made(&["--from=whole.mcap@0.1", "--duration=0.2", "-o", "part.mcap"]);
        // A log of a run without such motors has no targets, and no warning is given.
        std::fs::write(folder.join("limp.toml"), robot).expect("written");
        run(&folder, &["simulate", "limp.toml", "--duration=0.1", "-o", "limp.mcap"]);
        let on = made(&["--from=limp.mcap@end", "--duration=0.01", "--no-log"]);
        assert!(on["warnings"].as_array().is_none_or(Vec::is_empty), "{}", on["warnings"]);
        // Motions about the same instant of both logs: their modes in the digits that are printed, and how fast the joint accelerates.
        let about = |log: &str| text(&run(&folder, &["linearize", log, "--at", "0.2"]).stdout).to_string();
        let [part, whole_run] = ["part.mcap", "whole.mcap"].map(about);
        assert!(part.contains("frequency") && part.lines().last() == whole_run.lines().last(), "{part}{whole_run}");
        let accelerates = |said: &str| -> f64 {
            let number = said.split("by up to ").nth(1).and_then(|rest| rest.split_whitespace().next());
            number.and_then(|number| number.parse().ok()).expect("an acceleration")
        };
        // Positions that are 1e-8 rad apart as below, gains of up to 4000/s², and four digits. Another target would be rad/s² off.
        let [part_rate, whole_rate] = [&part, &whole_run].map(|said| accelerates(said));
        assert!((part_rate - whole_rate).abs() < 1e-4 + 1e-3 * whole_rate, "{part}{whole_run}");
        // The second is from a log that went on itself; times in it are those of the motion.
        for (from, rest) in [("whole.mcap@0.1", "0.4"), ("part.mcap@0.2", "0.3")] {
            let on = made(&["--from", from, "--duration", rest, "--no-log"]);
            for what in ["position", "velocity"] {
                let apart = (of(&on, what) - of(&whole, what)).abs();
                // Tolerances of 1e-10 m at a radius of at most 1 m, and rates of some 60 rad/s.
                assert!(apart < 1e-8, "{name}, {from}: {what} differs by {apart:e}");
            }
        }
    }
}

#[test]
fn warnings_are_errors_if_they_are_asked_to_be() {
    let folder = folder("strict");
    std::fs::write(folder.join("pendulum.urdf"), PENDULUM).expect("written");
    let odd = PENDULUM.replace("</robot>", "<sensor/><camera/></robot>");
    std::fs::write(folder.join("odd.urdf"), odd).expect("written");
    let strict = |file, verb: &'static str| run(&folder, &[verb, file, "--strict"]);
    assert_eq!(strict("pendulum.urdf", "model").status.code(), Some(0));
    refused(&strict("odd.urdf", "model"), 2, "--strict: odd.urdf: ignored: ");
    refused(&strict("odd.urdf", "simulate"), 2, "--strict: odd.urdf: ignored: ");
    assert!(!folder.join("odd.mcap").exists(), "no run was made");
}

#[test]
#[cfg(unix)]
fn xacro_is_expanded_by_its_program_and_without_it_the_error_says_how_to_get_it() {
    use crate::common::command::catena;
    use std::os::unix::fs::PermissionsExt;
    let folder = folder("xacro");
    let source =
        PENDULUM.replacen('>', " xmlns:xacro='http://www.ros.org/wiki/xacro'><xacro:arg name='a' default='1'/>", 1);
    std::fs::write(folder.join("arm.urdf.xacro"), source).expect("written");
    std::fs::write(folder.join("expanded"), PENDULUM).expect("written");
    let with_path =
        |path: &str, arguments: &[&str]| catena(&folder, arguments).env("PATH", path).output().expect("catena runs");
    let arguments = ["simulate", "arm.urdf.xacro", "--velocity=hinge=1", "--duration=0.1"];
    refused(&with_path("/nowhere", &arguments), 2, "arm.urdf.xacro: it is xacro, and the program `xacro`");
    assert!(text(&with_path("/nowhere", &arguments).stderr).contains("pip install xacro"));
    let bin = folder.join("bin");
    std::fs::create_dir_all(&bin).expect("a folder");
    let program = |script: &str| {
        std::fs::write(bin.join("xacro"), format!("#!/bin/sh\n{script}\n")).expect("written");
        std::fs::set_permissions(bin.join("xacro"), std::fs::Permissions::from_mode(0o755)).expect("executable");
    };
    let path = format!("{}:/usr/bin:/bin", bin.display());
    program("test \"$1\" = arm.urdf.xacro && cat expanded");
    let output = with_path(&path, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    // The log carries the expanded robot: no program is needed to make the run again.
    let output = with_path("/nowhere", &["replay", "arm.urdf.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    program("echo 'undefined name: x' >&2; exit 2");
    refused(&with_path(&path, &arguments), 2, "the program `xacro` cannot expand it: undefined name: x");
    // The reason comes before the file in which it is.
    program(
        "printf \"error: name 'x' is not defined\\nwhen evaluating expression 'x'\\nwhen processing file: arm\\n\" >&2; exit 2",
    );
    let said = "cannot expand it: name 'x' is not defined; when evaluating expression 'x'\n";
    refused(&with_path(&path, &arguments), 2, said);
    // Arguments are handed on, and are among the arguments that make the run again.
    program("test \"$2\" = mass:=3 && cat expanded");
    let output = with_path(&path, &[&arguments[..], &["--xacro", "mass:=3"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    refused(&with_path(&path, &[&arguments[..], &["--xacro", "mass=3"]].concat()), 2, "give NAME:=VALUE");
    // Standard input is handed on, too.
    program("test \"$1\" = /dev/stdin && grep -q xacro:arg && cat expanded");
    let source = std::fs::File::open(folder.join("arm.urdf.xacro")).expect("the source");
    let mut piped = catena(&folder, &["simulate", "-", "--no-log", "--quiet"]);
    let output = piped.env("PATH", &path).stdin(source).output().expect("catena runs");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

#[test]
fn a_rope_that_is_too_short_for_the_start_is_named_with_what_it_lacks() {
    let folder = folder("short_rope");
    std::fs::write(
        folder.join("rope.toml"),
        "[[body]]\nname = \"load\"\nshape = { type = \"sphere\", radius = 0.1 }\nmass = 1\n[[rope]]\nlength = 1.5\n\
         points = [{ link = \"world\", position = [0, 0, 1.9] }, { link = \"load\", position = [0, 0, 0] }]\n",
    )
    .expect("written");
    let output = run(&folder, &["simulate", "rope.toml", "--duration", "0.01", "--no-log"]);
    let said = text(&output.stdout);
    let wanted = "rope \"rope1\" is 4.0e-1 m too short for where \"load\" starts: initial positions were adjusted to it, by up to 4.0e-1 rad or m";
    assert!(said.contains(wanted), "{said}");
}
