//! What is wrong with a sweep file is said on one line with its place, before anything is written.

use super::{HEAD, folder};
use crate::common::command::{assert_one_error, run, text};

#[test]
fn a_file_for_another_command_and_a_table_that_occurs_once_are_named_with_what_to_write() {
    let folder = folder("sweep_for_simulate", &format!("{HEAD}[[vary]]\nkey = \"rod.mass\"\nvalues = [1]\n"));
    std::fs::write(folder.join("scene.toml"), "[[robot]]\nurdf = \"pendulum.urdf\"\n").unwrap();
    std::fs::write(folder.join("contact.toml"), "[[robot]]\nurdf = \"pendulum.urdf\"\n[[contact]]\nfriction = 1\n")
        .unwrap();
    for (arguments, said) in [
        (&["simulate", "sweep.toml"][..], "this file describes a sweep: use catena sweep"),
        (&["sweep", "scene.toml", "-o", "rows"], "this file describes a scene: use catena simulate"),
        (&["simulate", "contact.toml"], "there is only one: write [contact]"),
    ] {
        let output = run(&folder, arguments);
        assert_one_error(&output, 2, said);
    }
}

#[test]
fn a_bad_sweep_file_is_refused_by_file_line_and_key_and_nothing_is_written() {
    let folder = folder("sweep_errors", "");
    let vary = |keys: &str| format!("{HEAD}[[vary]]\n{keys}\n");
    std::fs::write(folder.join("bad.csv"), "rod.mass,positions.hinge\n1,0\n2\n").unwrap();
    std::fs::write(folder.join("negative.csv"), "# runs\nrod.mass\n1\n# light\n-2\n").unwrap();
    std::fs::write(folder.join("unknown.csv"), "rod.mess\n1\n").unwrap();
    std::fs::write(folder.join("nan.csv"), "rod.mass\nNaN\n").unwrap();
    let mass = "key = \"rod.mass\"\n";
    for (sweep, said) in [
        ("".to_string(), "sweep.toml:1: missing field `sweep`"),
        ("[sweep]\nscene = \"none.urdf\"\n".to_string(), "sweep.toml:2: sweep.scene: none.urdf: cannot be read"),
        (
            "[sweep]\nscene = \"pendulum.urdf\"\nsample = 3\n".to_string(),
            "sweep.toml:3: sweep.sample: unknown field `sample`",
        ),
        (
            vary("key = \"rod.mas\"\nvalues = [1]"),
            "sweep.toml:9: vary.key: pendulum.urdf: no number of the scene is called \"rod.mas\"; the nearest are \"link.rod.mass\"",
        ),
        (vary(&format!("{mass}values = [1, nan]")), "sweep.toml:10: vary: link.rod.mass = NaN: NaN is not finite"),
        (vary(&format!("{mass}values = [1, -1]")), "sweep.toml:10: vary: link.rod.mass = -1: -1 must not be negative"),
        (vary(&format!("{mass}values = []")), "sweep.toml:10: vary.values: give at least one number"),
        (
            vary(&format!("{mass}linear = {{ from = 1, to = 2, count = 1 }}")),
            "sweep.toml:10: vary: 1 number from 1 to 2: give a count of at least 2",
        ),
        (
            vary(&format!("{mass}linear = {{ from = 1, to = inf, count = 3 }}")),
            "sweep.toml:10: vary: from 1 to inf: give finite numbers",
        ),
        (
            vary(&format!("{mass}logarithmic = {{ from = 0, to = 2, count = 3 }}")),
            "logarithmic spacing needs positive numbers",
        ),
        (vary(&format!("{mass}uniform = [2, 1]")), "sweep.toml:10: vary: [2, 1]: the lower bound comes first"),
        (vary(&format!("{mass}log_uniform = [0, 1]")), "give two positive bounds"),
        (vary(&format!("{mass}normal = [1, -1]")), "a standard deviation that is not negative"),
        (vary(mass), "sweep.toml:8: vary: give one of linear, logarithmic, values, uniform, log_uniform, normal, csv"),
        (vary(&format!("{mass}values = [1]\nuniform = [0, 1]")), "sweep.toml:8: vary: give one of"),
        (vary("values = [1]"), "sweep.toml:8: vary: give either its key or its keys"),
        (
            vary(&format!("{mass}values = [1]\n[[vary]]\n{mass}values = [2]")),
            "sweep.toml:12: vary.key: link.rod.mass varies twice",
        ),
        (
            vary("key = \"joint.hinge.friction\"\nrelative = true\nvalues = [1]"),
            "joint.hinge.friction is relative to nothing",
        ),
        (vary("csv = \"none.csv\""), "sweep.toml:9: vary.csv: none.csv: cannot be read"),
        (vary("csv = \"bad.csv\""), "bad.csv:3: 1 numbers for 2 key paths"),
        (vary("csv = \"negative.csv\""), "negative.csv:5: link.rod.mass = -2: -2 must not be negative"),
        (vary("csv = \"unknown.csv\""), "unknown.csv:1: pendulum.urdf: no number of the scene is called \"rod.mess\""),
        (vary("csv = \"nan.csv\""), "nan.csv:2: \"NaN\" is not a number"),
        (
            vary(&format!("{mass}uniform = [1, 2]")).replace("samples = 1\n", ""),
            "numbers are drawn, so it needs its samples",
        ),
        (HEAD.replace("samples = 1", "samples = 0"), "sweep.toml:3: sweep.samples: give at least 1"),
        (HEAD.replace("samples = 1", "samples = 9007199254740993"), "there are more than 9007199254740992 runs"),
        (HEAD.replace("step = 0.01", ""), "simulation.stages needs a step"),
        (
            format!("{HEAD}[keep]\nend = [\"tipp.position\"]\n"),
            "sweep.toml:9: keep.end: there is no \"tipp.position\" to keep; the nearest are \"link.tip.position\"",
        ),
        (
            format!("{HEAD}[keep]\ncurves = [\"positions\"]\nrate = 0\n"),
            "sweep.toml:10: keep.rate: 0 must be greater than zero",
        ),
    ] {
        std::fs::write(folder.join("sweep.toml"), &sweep).unwrap();
        let output = run(&folder, &["sweep", "sweep.toml", "-o", "out"]);
        assert_one_error(&output, 2, said);
        assert!(text(&output.stderr).contains(said), "{said}\n{}\n{sweep}", text(&output.stderr));
        assert!(!folder.join("out").exists(), "{said}");
    }
}

#[test]
fn bad_usage_is_refused() {
    let folder = folder("sweep_usage", HEAD);
    for (arguments, said) in [
        (&["sweep", "sweep.toml"][..], "--output"),
        (&["sweep", "-o", "out"], "FILE.toml"),
        (&["sweep", "sweep.toml", "-o", "out", "--shard", "0/4"], "K from 1 to N"),
        (&["sweep", "sweep.toml", "-o", "out", "--shard", "5/4"], "K from 1 to N"),
        (&["sweep", "sweep.toml", "-o", "out", "--format", "xlsx"], "neither csv nor parquet"),
        (&["sweep", "sweep.toml", "-o", "-"], "give a folder"),
        (&["sweep", "sweep.toml", "-o", "out", "--jobs", "0"], "--jobs"),
        (&["sweep", "pendulum.urdf", "-o", "out"], "pendulum.urdf: this is a robot, and no sweep file"),
    ] {
        let output = run(&folder, arguments);
        assert_one_error(&output, 2, said);
        assert!(text(&output.stderr).contains(said), "{said}: {}", text(&output.stderr));
        assert!(!folder.join("out").exists());
    }
    if !cfg!(feature = "parquet") {
        let output = run(&folder, &["sweep", "sweep.toml", "-o", "out", "--format", "parquet"]);
        assert_one_error(&output, 2, "parquet");
        assert!(text(&output.stderr).contains("--features parquet"), "{}", text(&output.stderr));
    }
}
