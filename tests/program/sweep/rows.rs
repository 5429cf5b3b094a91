//! What is in the rows.

use super::{HEAD, MIXED, files, folder, number, sweep, table};
use crate::common::command::{catena, text};
use serde_json::Value;

const MASS: &str = "link.rod.mass";
const START: &str = "robot.pendulum.positions.hinge";
const END: &str = "end.joint.hinge.position";

#[test]
fn grids_multiply_the_last_one_fastest_and_samples_faster_still() {
    let folder = folder(
        "sweep_grid",
        &format!(
            "{HEAD}[[vary]]\nkey = \"rod.mass\"\nvalues = [1, 2]\n[[vary]]\nkey = \"positions.hinge\"\nlinear = {{ from = 0, to = 1, count = 3 }}\n\
             [[vary]]\nkey = \"hinge.damping\"\nlogarithmic = {{ from = 0.01, to = 1, count = 3 }}\n"
        )
        .replace("samples = 1", "samples = 2"),
    );
    sweep(&folder, &["-o", "out"]);
    let rows = table(&folder.join("out"));
    assert_eq!(rows.len(), 2 * 3 * 3 * 2);
    for (index, row) in rows.iter().enumerate() {
        assert_eq!(number(row, "index"), index as f64);
        assert_eq!(number(row, MASS), [1.0, 2.0][index / 18]);
        assert_eq!(number(row, START), [0.0, 0.5, 1.0][index / 6 % 3]);
        // The middle of equal ratios is the geometric mean, within rounding.
        assert!((number(row, "joint.hinge.damping") - [0.01, 0.1, 1.0][index / 2 % 3]).abs() < 1e-15);
        assert_eq!(row["status"], "done");
    }
}

#[test]
fn a_row_is_the_run_that_simulate_makes_of_these_numbers() {
    let folder = folder(
        "sweep_as_simulate",
        "[sweep]\nscene = \"scene.toml\"\n[[vary]]\ncsv = \"runs.csv\"\n[keep]\nend = [\"positions\", \"velocities\", \"tip.position\"]\n",
    );
    let scene = |damping: &str, length: &str| {
        format!(
            "[[robot]]\nurdf = \"pendulum.urdf\"\n[[joint]]\nname = \"hinge\"\ndamping = {damping}\n[[spring]]\nname = \"band\"\na = {{ link = \"tip\" }}\n\
             b = {{ link = \"world\", position = [0, 0, -3] }}\nstiffness = 5\nrest_length = {length}\n[simulation]\nduration = 0.5\ntolerance = 1e-7\n"
        )
    };
    std::fs::write(folder.join("scene.toml"), scene("0.3", "1")).unwrap();
    std::fs::write(
        folder.join("runs.csv"),
        "band.rest_length, hinge.damping, positions.hinge\n1.5,0.25,1\n0.75,0,-0.5\n",
    )
    .unwrap();
    sweep(&folder, &["-o", "out"]);
    let rows = table(&folder.join("out"));
    assert_eq!(rows.len(), 2);
    for (row, (length, damping, start)) in rows.iter().zip([("1.5", "0.25", "1"), ("0.75", "0", "-0.5")]) {
        std::fs::write(folder.join("one.toml"), scene(damping, length)).unwrap();
        let arguments = ["simulate", "one.toml", "--no-log", "--json", "--position", &format!("hinge={start}")];
        let output = catena(&folder, &arguments).output().unwrap();
        let report: Value =
            serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", text(&output.stderr)));
        let said =
            |path: &str| report.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {report}"));
        assert_eq!(number(row, END), said("/joints/hinge/position"));
        assert_eq!(number(row, "end.joint.hinge.velocity"), said("/joints/hinge/velocity"));
        assert_eq!(number(row, "end.link.tip.position.x"), said("/links/tip/position/0"));
        assert_eq!(number(row, "steps"), said("/steps"));
        assert_eq!(number(row, "estimated_error"), said("/accuracy/estimated"));
        assert_eq!(number(row, "time"), 0.5);
    }
}

#[test]
fn what_is_drawn_follows_from_seed_and_index_whatever_the_threads() {
    let folder = folder("sweep_random", MIXED);
    sweep(&folder, &["-o", "one", "--jobs", "1"]);
    sweep(&folder, &["-o", "three", "--jobs", "3"]);
    let one = files(&folder.join("one"));
    assert_eq!(
        one.keys().collect::<Vec<_>>(),
        [
            "rows-0000000000000000-0000000000000009.csv",
            "rows-0000000000000010-0000000000000019.csv",
            "rows-0000000000000020-0000000000000023.csv"
        ]
    );
    assert!(one == files(&folder.join("three")), "byte for byte");
    let starts: Vec<f64> = table(&folder.join("one")).iter().map(|row| number(row, START)).collect();
    assert!(starts.iter().all(|start| (-1.0..1.0).contains(start)));
    assert!(starts.windows(2).all(|pair| pair[0] != pair[1]), "{starts:?}");
    std::fs::write(folder.join("sweep.toml"), MIXED.replace("seed = 3", "seed = 4")).unwrap();
    sweep(&folder, &["-o", "other"]);
    let other: Vec<f64> = table(&folder.join("other")).iter().map(|row| number(row, START)).collect();
    assert!(starts.iter().zip(&other).all(|(start, other)| start != other));
}

#[test]
fn several_keys_vary_together_and_relative_ones_are_multiples_of_what_the_file_says() {
    let folder = folder(
        "sweep_relative",
        &format!(
            "{HEAD}[[vary]]\nkeys = [\"rod.mass\", \"rod.inertia.ixx\", \"rod.inertia.iyy\"]\nrelative = true\nvalues = [0.5, 2]\n"
        ),
    );
    sweep(&folder, &["-o", "out"]);
    let rows = table(&folder.join("out"));
    let numbers = |row| [MASS, "link.rod.inertia.ixx", "link.rod.inertia.iyy"].map(|column| number(row, column));
    assert_eq!(rows.iter().map(numbers).collect::<Vec<_>>(), [[0.5, 0.05, 0.05], [2.0, 0.2, 0.2]]);
}

#[test]
fn what_a_loop_holds_is_taken_from_the_start_of_each_run() {
    // The distance of the tip from a point of the world, which the file does not say: it locks the hinge where it starts.
    let folder = folder(
        "sweep_loop",
        "[sweep]\nscene = \"scene.toml\"\n[[vary]]\nkey = \"positions.hinge\"\nvalues = [0.25, 0.5]\n",
    );
    let scene = "[[robot]]\nurdf = \"pendulum.urdf\"\n[[loop]]\ntype = \"distance\"\na = { link = \"tip\" }\nb = { link = \"world\", position = [3, 0, 0] }\n\
        [simulation]\nduration = 0.3\n";
    std::fs::write(folder.join("scene.toml"), scene).unwrap();
    sweep(&folder, &["-o", "out"]);
    let ends: Vec<f64> = table(&folder.join("out")).iter().map(|row| number(row, END)).collect();
    // The gap of a loop is rounding, some 1e-16 m.
    assert!((ends[0] - 0.25).abs() < 1e-14 && (ends[1] - 0.5).abs() < 1e-14, "{ends:?}");
}

#[test]
fn a_run_that_fails_is_a_row_with_its_reason() {
    let folder = folder(
        "sweep_failures",
        &format!("{HEAD}[[vary]]\nkey = \"rod.mass\"\nnormal = [0.5, 1.0]\n").replace("samples = 1", "samples = 30"),
    );
    let output = catena(&folder, &["sweep", "sweep.toml", "--format", "csv", "-o", "out"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    let rows = table(&folder.join("out"));
    let (failed, done): (Vec<_>, Vec<_>) = rows.iter().partition(|row| number(row, MASS) < 0.0);
    // A third of these masses is negative: both kinds are there whatever the seed.
    assert!(failed.len() > 3 && done.len() > 10, "{} {}", failed.len(), done.len());
    for row in &failed {
        assert_eq!((&*row["status"], &*row[END], &*row["steps"]), ("failed", "", ""));
        assert!(
            row["reason"].contains("link.rod.mass = -") && row["reason"].ends_with("must not be negative"),
            "{}",
            row["reason"]
        );
    }
    assert!(done.iter().all(|row| row["status"] == "done" && number(row, "time") == 0.3));
    let said = text(&output.stderr);
    assert!(
        said.contains(&format!(
            "{} of 30 runs failed; the first is that of index {}",
            failed.len(),
            failed[0]["index"]
        )),
        "{said}"
    );
}

#[test]
fn curves_extremes_and_events_are_those_of_the_run() {
    // Dropped from 1 m, with a restitution of a half: impacts at √(2/g) and then after half of twice that, and so on.
    let folder = folder(
        "sweep_kept",
        "[sweep]\nscene = \"scene.toml\"\n[simulation]\nduration = 1.0\n[[vary]]\nkey = \"pose.position.z\"\nvalues = [2, 6]\n\
         [keep]\nend = [\"ball.position\"]\ncurves = [\"ball.position\", \"energy.kinetic\"]\nextremes = [\"link.ball.position.z\"]\nrate = 10\nevents = \"list\"\n",
    );
    let ball = r#"<robot name="ball"><link name="ball"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
        <collision><geometry><sphere radius="1"/></geometry></collision></link></robot>"#;
    std::fs::write(folder.join("ball.urdf"), ball).unwrap();
    let scene = "[[robot]]\nurdf = \"ball.urdf\"\nbase = \"floating\"\n[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\nrestitution = 0.5\n";
    std::fs::write(folder.join("scene.toml"), scene).unwrap();
    sweep(&folder, &["-o", "out"]);
    let rows = table(&folder.join("out"));
    let list = |row: usize, column: &str| -> Vec<Value> {
        serde_json::from_str(&rows[row][column]).unwrap_or_else(|_| panic!("{}", rows[row][column]))
    };
    let numbers = |row, column| -> Vec<f64> { list(row, column).iter().map(|value| value.as_f64().unwrap()).collect() };
    let fall = (2.0 / 9.81f64).sqrt();
    let impacts = numbers(0, "event.time");
    // Times of events are located to rounding: some hundreds of it.
    assert!((impacts[0] - fall).abs() < 1e-12 && (impacts[1] - 2.0 * fall).abs() < 1e-12, "{impacts:?}");
    assert_eq!(number(&rows[0], "events.contact_impact"), impacts.len() as f64);
    assert_eq!(
        (&list(0, "event.kind")[0], &list(0, "event.what")[0]),
        (&"contact_impact".into(), &"ball|floor".into())
    );
    assert!((numbers(0, "event.impulse")[0] - 1.5 * 9.81 * fall).abs() < 1e-11);
    assert_eq!((number(&rows[1], "events.contact_impact"), list(1, "event.time").len()), (0.0, 0));
    let times = numbers(0, "curve.time");
    assert_eq!(times.len(), 11);
    assert!(times.iter().enumerate().all(|(index, time)| (time - 0.1 * index as f64).abs() < 1e-12), "{times:?}");
    for (time, height) in times.iter().zip(numbers(1, "curve.link.ball.position.z")) {
        // A free fall is exact but for rounding.
        assert!((height - (6.0 - 4.905 * time * time)).abs() < 1e-12, "{time} {height}");
    }
    assert_eq!(numbers(1, "curve.link.ball.position.z").last(), Some(&number(&rows[1], "end.link.ball.position.z")));
    assert_eq!(number(&rows[1], "max.link.ball.position.z"), 6.0);
    assert_eq!(number(&rows[1], "max_time.link.ball.position.z"), 0.0);
    assert_eq!(number(&rows[1], "min.link.ball.position.z"), number(&rows[1], "end.link.ball.position.z"));
    assert_eq!(number(&rows[1], "min_time.link.ball.position.z"), 1.0);
}

#[test]
fn a_dry_run_says_what_the_whole_takes_and_writes_nothing() {
    let folder = folder("sweep_dry", MIXED);
    // The usual command, with one word more: its folder is not made.
    let usual = ["sweep", "sweep.toml", "-o", "dry", "--shard", "2/2", "--format", "csv", "--json", "--dry-run"];
    let output = catena(&folder, &usual).output().unwrap();
    let said: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", text(&output.stderr)));
    assert_eq!(
        (&said["sweep_runs"], &said["runs"], &said["tried"], &said["failed"]),
        (&24.into(), &12.into(), &12.into(), &0.into())
    );
    // Twelve rows from the middle of the second file of ten on.
    assert_eq!(said["files"], 2);
    sweep(&folder, &["-o", "out"]);
    let bytes: usize = files(&folder.join("out"))
        .values()
        .map(|bytes| bytes.len() - bytes.iter().position(|&byte| byte == b'\n').unwrap() - 1)
        .sum();
    // The mean of half of them is within a tenth of that of all: rows differ by digits alone.
    let mean = bytes as f64 / 24.0;
    assert!((said["bytes_per_row"].as_f64().unwrap() / mean - 1.0).abs() < 0.1, "{mean} {said}");
    assert!(said["seconds_per_run"].as_f64().unwrap() > 0.0);
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 3, "the robot, the sweep, and what was made on purpose");
}

#[test]
fn the_example_beside_the_robots_can_be_made() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/pendulum_sweep.toml");
    let folder = folder("sweep_example", "");
    let output = catena(&folder, &["sweep", file, "-o", "out", "--format", "csv"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let rows = table(&folder.join("out"));
    assert_eq!(rows.len(), 600);
    for row in &rows {
        let [least, last, most] =
            ["min.joint.elbow.velocity", "robot.double_pendulum.velocities.elbow", "max.joint.elbow.velocity"]
                .map(|of| number(row, of));
        assert!(row["status"] == "done" && least <= last && last <= most, "the start is one of the samples: {row:?}");
    }
}
