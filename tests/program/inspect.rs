//! `catena inspect`: what it says of a log is what the run reported.

use crate::common;
use serde_json::Value;
use std::path::Path;

use crate::common::command::{
    ENDLESS, assert_one_error, catena, folder, run, salvaged, salvaged_samples, text, wait_for,
};
use std::process::Stdio;

fn json(output: &std::process::Output) -> Value {
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

/// Simulates and returns the report.
fn simulate(folder: &Path, arguments: &[&str]) -> Value {
    json(&run(folder, &[&["simulate", "pendulum.urdf", "--json", "--duration", "1.5"], arguments].concat()))
}

fn inspect(folder: &Path, arguments: &[&str]) -> Value {
    json(&run(folder, &[&["inspect", "--json"], arguments].concat()))
}

fn assert_near(a: &Value, b: &Value, bound: f64, place: &str) {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>(), "{place}");
            a.iter().for_each(|(key, value)| assert_near(value, &b[key], bound, &format!("{place}.{key}")));
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{place}");
            a.iter().zip(b).for_each(|(a, b)| assert_near(a, b, bound, place));
        }
        _ => {
            let (a, b) = (a.as_f64().expect("a number"), b.as_f64().expect("a number"));
            assert!((a - b).abs() <= bound, "{place}: {a} {b}");
        }
    }
}

#[test]
fn the_end_of_a_log_is_what_the_report_says_of_it() {
    let folder = folder("end");
    let turning = ["--velocity", "hinge=1"];
    let report = simulate(&folder, &turning);
    for (at, nearest) in [("1e300", 1.5), ("-1e300", 0.0), ("0.51", 0.516666667), ("0.508", 0.5)] {
        assert_eq!(inspect(&folder, &["pendulum.mcap", "--at", at])["time"], nearest, "{at}");
    }
    let instant = inspect(&folder, &["pendulum.mcap", "--at", "1e9"]);
    assert_eq!(instant["time"], 1.5);
    for what in ["links", "joints"] {
        // Some roundings of numbers of one metre and some newtons: the log is written by other code, which turns by quaternions, and
        // link velocities are worked out again.
        assert_near(&instant[what], &report[what], 1e-14, what);
    }
    let floating = ["--base", "floating", "--base-velocity", "1,2,3,0.4,0.5,0.6", "--velocity", "hinge=1"];
    let report = simulate(&folder, &floating);
    let instant = inspect(&folder, &["pendulum.mcap", "--at", "1.5"]);
    for what in ["links", "joints"] {
        // The base is logged by its link and simulated by its body: two products of rotations, at lengths of some 10 m.
        assert_near(&instant[what], &report[what], 1e-12, what);
    }
}

#[test]
fn an_instant_of_a_closed_mechanism_has_its_loops_as_the_report_has_them() {
    let folder = folder("loops");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/slider_crank.toml");
    let report = json(&run(&folder, &["simulate", scene, "--duration", "0.5", "--json", "-o", "closed.mcap"]));
    let instant = inspect(&folder, &["closed.mcap", "--at", "0.5"]);
    let loops = report["loops"].as_object().expect("loops");
    assert!(!loops.is_empty());
    // The report knows the digits of the angles that their roundings leave out, logs do not; on forces of some 30 N.
    assert_near(&instant["loops"], &report["loops"], 1e-12, "loops");
    // The log has what the run found; nothing was worked out in its stead.
    assert!(loops.values().any(|one| one["reaction_force"][0] != 0.0), "{loops:?}");
    assert_eq!(instant["constraint"]["time"], 0.5);
    assert!(instant["constraint"]["position"].as_f64().expect("a number") <= 1e-12, "{}", instant["constraint"]);
    let output = run(&folder, &["inspect", "closed.mcap", "--at", "0.5"]);
    let words = text(&output.stdout);
    for name in loops.keys() {
        let line =
            words.split("  loops: ").nth(1).and_then(|loops| loops.lines().find(|line| line.contains(name.as_str())));
        assert!(line.is_some_and(|line| line.split_whitespace().count() == 8), "{words}");
    }
}

#[test]
fn an_instant_is_the_nearest_that_was_logged() {
    let folder = folder("instant");
    simulate(&folder, &["--rate", "10"]);
    for (asked, found) in [("0.349", 0.3), ("0.351", 0.4), ("-5", 0.0), ("0.7", 0.7)] {
        let instant = inspect(&folder, &["pendulum.mcap", "--at", asked]);
        assert!((instant["time"].as_f64().expect("a time") - found).abs() < 1e-9, "{asked}: {}", instant["time"]);
    }
}

#[test]
fn the_summary_has_the_figures_of_the_report() {
    let folder = folder("summary");
    let report = simulate(&folder, &["--velocity", "hinge=1"]);
    let summary = inspect(&folder, &["pendulum.mcap"]);
    assert_eq!(summary["complete"], true);
    assert_eq!(summary["outcome"], "finished");
    assert_eq!(summary["duration"], 1.5);
    assert_eq!(summary["samples"], 91);
    for figure in ["initial", "final", "dissipated", "work", "max_relative_error"] {
        assert_eq!(summary["energy"][figure], report["energy"][figure], "{figure}");
    }
    assert_eq!(summary["constraint"], report["constraint"]);
    for count in ["steps", "iterations", "rejected_steps"] {
        assert_eq!(summary["solver"][count].as_f64(), report[count].as_f64(), "{count}");
    }
    assert_eq!(summary["warnings"], report["warnings"]);
    assert_eq!(summary["attachments"]["pendulum.urdf"], common::command::PENDULUM.len());
    let words = run(&folder, &["inspect", "pendulum.mcap"]);
    for said in ["complete", "/joint_states", "91 samples", " links, 1 moving joint\n", "energy", "constraint"] {
        assert!(text(&words.stdout).contains(said), "{said}: {}", text(&words.stdout));
    }
}

#[test]
fn a_log_that_was_cut_off_is_shown_up_to_there_and_said_to_be_truncated() {
    let folder = folder("cut");
    simulate(&folder, &["--rate", "100"]);
    let whole = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    let (mut samples, mut readable) = (0, 0);
    for part in 0..=20 {
        std::fs::write(folder.join("cut.mcap"), &whole[..whole.len() * part / 20]).expect("written");
        let output = run(&folder, &["inspect", "cut.mcap", "--json"]);
        if output.status.code() == Some(0) {
            let summary = json(&output);
            let now = summary["samples"].as_u64().expect("a count");
            assert!(now >= samples, "a longer log has no fewer samples");
            samples = now;
            readable += 1;
            assert_eq!(summary["complete"] == true, part == 20, "{part}");
            let words = run(&folder, &["inspect", "cut.mcap"]);
            assert_eq!(text(&words.stdout).contains("TRUNCATED"), part < 20, "{}", text(&words.stdout));
        } else {
            assert_one_error(&output, 2, "cut");
        }
    }
    assert!(samples == 151 && readable >= 19, "{samples} {readable}");
}

#[test]
fn a_comparison_names_the_log_that_is_damaged_or_cut() {
    let folder = folder("broken");
    simulate(&folder, &["--rate", "1000"]);
    let whole = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 1;
    let cut = whole[..whole.len() / 2].to_vec();
    let in_the_middle = format!("TRUNCATED: it ends in the middle, after {} bytes", cut.len());
    for (bytes, missing) in [(damaged, "DAMAGED: 1 chunk between t = "), (cut, in_the_middle.as_str())] {
        std::fs::write(folder.join("broken.mcap"), bytes).expect("written");
        let comparison = inspect(&folder, &["pendulum.mcap", "broken.mcap"]);
        assert!(comparison["only_a"].as_u64() > Some(0) && comparison["only_b"] == 0, "{comparison}");
        assert_eq!(comparison["missing_a"], Value::Null);
        assert!(comparison["missing_b"].as_str().is_some_and(|said| said.starts_with(missing)), "{comparison}");
        let words = run(&folder, &["inspect", "pendulum.mcap", "broken.mcap"]);
        let said = format!("broken.mcap is {missing}");
        assert!(text(&words.stdout).contains(&said), "{}", text(&words.stdout));
    }
}

#[test]
fn of_a_log_with_a_damaged_chunk_everything_else_is_shown_and_recovered() {
    let folder = folder("chunk");
    simulate(&folder, &["--rate", "1000"]);
    let mut log = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    let half = log.len() / 2;
    log[half..half + 8].fill(0xff);
    std::fs::write(folder.join("damaged.mcap"), &log).expect("written");
    let [mut damaged, whole] = ["damaged.mcap", "pendulum.mcap"].map(|log| inspect(&folder, &[log]));
    assert_eq!(
        (&damaged["complete"], &damaged["damaged"], &damaged["broken_off"]),
        (&false.into(), &true.into(), &Value::Null)
    );
    let lost = damaged["lost_chunks"].clone();
    assert_eq!(lost["count"], 1, "{lost}");
    let [after, before] = ["after", "before"].map(|end| lost[end].as_f64().expect("a time"));
    // A chunk is a quarter of a megabyte, which is some four hundred samples; those at its ends lack messages.
    assert!(0.1 < after && after + 0.1 < before && before < 1.4, "{lost}");
    let missed = whole["samples"].as_u64().expect("a count") - damaged["samples"].as_u64().expect("a count");
    let gap = ((before - after) * 1000.0).round() as u64;
    assert!((gap - 1..=gap + 1).contains(&missed), "{missed} samples in {lost}");
    assert_eq!((&damaged["outcome"], &damaged["duration"]), (&"finished".into(), &1.5.into()));
    assert_eq!(inspect(&folder, &["damaged.mcap", "--at", "1.4"])["time"], 1.4);

    let said = format!("DAMAGED: 1 chunk between t = {after} s and t = {before} s cannot be read: ");
    let words = run(&folder, &["inspect", "damaged.mcap"]);
    assert!(text(&words.stdout).contains(&said), "{}", text(&words.stdout));
    let output = run(&folder, &["inspect", "damaged.mcap", "--recover", "whole.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains(&said), "{}", text(&output.stdout));
    let mut recovered = inspect(&folder, &["whole.mcap"]);
    assert_eq!(recovered["complete"], true);
    for summary in [&mut damaged, &mut recovered] {
        ["complete", "damaged", "lost_chunks", "log", "bytes"].iter().for_each(|entry| {
            summary.as_object_mut().expect("an object").remove(*entry);
        });
    }
    assert_eq!(damaged, recovered);
    let output = run(&folder, &["inspect", "damaged.mcap", "--csv", "damaged.csv"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

/// Where each message of a log of uncompressed chunks ends, in bytes, and its channel.
fn ends_of_messages(log: &[u8]) -> Vec<(usize, u16)> {
    let number = |at: usize| u64::from_le_bytes(log[at..at + 8].try_into().expect("eight bytes")) as usize;
    let (mut ends, mut at) = (Vec::new(), 8);
    while at + 9 <= log.len() - 8 {
        let next = at + 9 + number(at + 1);
        if log[at] == 6 {
            // Two times, two sizes, the checksum and no compression come before the records.
            let mut inside = at + 9 + 8 + 8 + 8 + 4 + 4 + 8;
            while inside < next {
                let end = inside + 9 + number(inside + 1);
                if log[inside] == 5 {
                    ends.push((end, u16::from_le_bytes([log[inside + 9], log[inside + 10]])));
                }
                inside = end;
            }
        }
        at = next;
    }
    ends
}

#[test]
fn every_whole_message_before_a_cut_is_read_also_those_of_the_chunk_that_was_cut() {
    let folder = folder("torn");
    simulate(&folder, &["--rate", "100"]);
    let whole = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    let ends = ends_of_messages(&whole);
    let channels: std::collections::BTreeSet<u16> = ends.iter().map(|(_, channel)| *channel).collect();
    let mut numbers = common::Numbers::new(11);
    let mut cuts: Vec<usize> = (0..12).map(|_| numbers.next(ends[0].0 as f64, whole.len() as f64) as usize).collect();
    // Just before and at the end of a message, the first of all and one in the middle of the samples.
    cuts.extend([ends[0].0, ends[ends.len() / 2].0].iter().flat_map(|end| [end - 1, *end]));
    for cut in cuts {
        std::fs::write(folder.join("cut.mcap"), &whole[..cut]).expect("written");
        let summary = inspect(&folder, &["cut.mcap"]);
        let topics = summary["topics"].as_array().expect("topics");
        let mut found: Vec<u64> = topics.iter().map(|topic| topic["messages"].as_u64().expect("a count")).collect();
        let count = |channel| ends.iter().filter(|(end, of)| *end <= cut && of == channel).count() as u64;
        let mut expected: Vec<u64> = channels.iter().map(count).collect();
        // Channels without a message are in the chunks too, or not yet.
        [&mut found, &mut expected].into_iter().for_each(|counts| {
            counts.retain(|count| *count > 0);
            counts.sort_unstable();
        });
        assert_eq!(found, expected, "{cut} of {} bytes", whole.len());
        let words = run(&folder, &["inspect", "cut.mcap"]);
        assert!(text(&words.stdout).contains("TRUNCATED"), "{}", text(&words.stdout));
        // The last sample may lack messages: it is no row of the table, which would have other columns.
        let output = run(&folder, &["inspect", "cut.mcap", "--csv", "cut.csv"]);
        assert_eq!(output.status.code(), Some(0), "{cut}: {}", text(&output.stderr));
    }
}

#[test]
fn a_recovered_log_is_complete_and_has_everything_that_could_be_read() {
    let folder = folder("recovered");
    simulate(&folder, &["--rate", "100"]);
    let original = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    std::fs::write(folder.join("cut.mcap"), &original[..original.len() * 3 / 5]).expect("written");
    let output = run(&folder, &["inspect", "cut.mcap", "--recover", "whole.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let whole = std::fs::read(folder.join("whole.mcap")).expect("a log");
    let [original, found] = [&original, &whole].map(|log| {
        let messages = mcap::MessageStream::new(log).expect("a log").map(|message| message.expect("whole"));
        let known = |message: mcap::Message| {
            let schema = message.channel.schema.clone().expect("a schema");
            (
                message.channel.topic.clone(),
                schema.name.clone(),
                schema.data.to_vec(),
                message.log_time,
                message.data.to_vec(),
            )
        };
        messages.map(known).collect::<Vec<_>>()
    });
    // There are indexes among the bytes behind the cut, so that more than half of the messages are before it.
    assert!((original.len() / 2..original.len()).contains(&found.len()), "{} of {}", found.len(), original.len());
    assert!(found == original[..found.len()]);
    let index = mcap::Summary::read(&whole).expect("a log").expect("an index");
    assert_eq!(index.stats.expect("figures").message_count, found.len() as u64);
    let [mut cut, mut recovered] = ["cut.mcap", "whole.mcap"].map(|log| inspect(&folder, &[log]));
    assert_eq!((&cut["complete"], &recovered["complete"]), (&false.into(), &true.into()));
    for summary in [&mut cut, &mut recovered] {
        ["complete", "log", "bytes", "broken_off"].iter().for_each(|entry| {
            summary.as_object_mut().expect("an object").remove(*entry);
        });
    }
    assert_eq!(cut, recovered);
    // Its run can be made again, and it is not written over.
    assert_eq!(run(&folder, &["replay", "whole.mcap"]).status.code(), Some(0));
    assert_one_error(&run(&folder, &["inspect", "cut.mcap", "--recover", "whole.mcap"]), 2, "there already");
    assert!(std::fs::read(folder.join("whole.mcap")).expect("a log") == whole);
}

#[test]
fn a_log_that_ends_inside_a_sample_has_the_joints_of_the_samples_before() {
    let folder = folder("inside");
    simulate(&folder, &[]);
    let whole = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    let messages: Vec<_> =
        mcap::MessageStream::new(&whole).expect("a log").map(|message| message.expect("whole")).collect();
    let last = messages.iter().rposition(|message| message.channel.topic == "/tf").expect("samples");
    let mut writer =
        mcap::Writer::new(std::fs::File::create(folder.join("inside.mcap")).expect("a file")).expect("a log");
    messages[..=last].iter().for_each(|message| writer.write(message).expect("written"));
    writer.finish().expect("written");
    let (inside, whole) = (inspect(&folder, &["inside.mcap"]), inspect(&folder, &["pendulum.mcap"]));
    for what in ["links", "joints"] {
        assert_eq!(inside[what], whole[what], "{what}");
    }
    // The sample that lacks messages is none, and no row of a table, which would have other columns.
    assert_eq!(inside["samples"].as_u64(), whole["samples"].as_u64().map(|samples| samples - 1));
    let table = run(&folder, &["inspect", "inside.mcap", "--csv", "inside.csv"]);
    assert_eq!(table.status.code(), Some(0), "{}", text(&table.stderr));
}

#[test]
fn the_table_has_a_row_for_every_sample_and_units_in_its_head() {
    let folder = folder("table");
    let report = simulate(&folder, &["--velocity", "hinge=1"]);
    let output = run(&folder, &["inspect", "pendulum.mcap", "--csv", "out.csv"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let table = std::fs::read_to_string(folder.join("out.csv")).expect("a table");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 1 + 91);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()));
    let last = |column: &str| -> f64 {
        let place =
            rows[0].iter().position(|name| *name == column).unwrap_or_else(|| panic!("{column}: {:?}", rows[0]));
        rows[91][place].parse().expect("a number")
    };
    assert_eq!(last("time [s]"), 1.5);
    assert_eq!(last("hinge.position [rad]"), report["joints"]["hinge"]["position"].as_f64().expect("a number"));
    assert_eq!(last("hinge.velocity [rad/s]"), report["joints"]["hinge"]["velocity"].as_f64().expect("a number"));
    // The log takes frames from quaternions, the report from matrices: roundings of a metre.
    assert_near(&last("tip.z [m]").into(), &report["links"]["tip"]["position"][2], 1e-15, "tip.z");
    assert_eq!(last("energy.total [J]"), report["energy"]["final"].as_f64().expect("a number"));
}

#[test]
fn curves_are_drawn_with_units_and_names() {
    let folder = folder("plot");
    simulate(&folder, &["--velocity", "hinge=1"]);
    let output = run(&folder, &["inspect", "pendulum.mcap", "--plot", "out.svg"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let svg = std::fs::read_to_string(folder.join("out.svg")).expect("a picture");
    for said in ["hinge", "rad/s", "Energy error", "Constraint violation", "Reaction forces", "simulated time [s]"] {
        assert!(svg.contains(said), "{said}");
    }
    assert_eq!(run(&folder, &["inspect", "pendulum.mcap", "--plot", "out.png"]).status.code(), Some(0));
    let png = std::fs::read(folder.join("out.png")).expect("a picture");
    assert!(png.starts_with(b"\x89PNG") && png.len() > 10_000);
}

#[test]
fn two_logs_are_compared_link_by_link() {
    let folder = folder("compare");
    simulate(&folder, &["-o", "a.mcap"]);
    simulate(&folder, &["-o", "same.mcap"]);
    simulate(&folder, &["-o", "turned.mcap", "--base-pose", "0.3,0.4,0,0,0,0.5"]);
    let same = inspect(&folder, &["a.mcap", "same.mcap"]);
    assert_eq!((&same["identical"], &same["instants"]), (&Value::Bool(true), &91.into()));
    let turned = inspect(&folder, &["a.mcap", "turned.mcap"]);
    assert_eq!(turned["identical"], false);
    let base = &turned["links"][0];
    // By construction half a metre and half a radian, at all times.
    assert!((base["distance"].as_f64().expect("a number") - 0.5).abs() < 1e-12, "{base}");
    assert!((base["angle"].as_f64().expect("a number") - 0.5).abs() < 1e-12, "{base}");
    assert_eq!(base["first_difference"], 0.0);
    let words = run(&folder, &["inspect", "a.mcap", "turned.mcap"]);
    assert!(text(&words.stdout).contains("different"), "{}", text(&words.stdout));
}

#[test]
fn logs_of_which_nothing_can_be_compared_are_not_identical() {
    let folder = folder("apart");
    simulate(&folder, &["-o", "a.mcap"]);
    let renamed = common::command::PENDULUM
        .replace("\"base\"", "\"foot\"")
        .replace("\"rod\"", "\"leg\"")
        .replace("\"tip\"", "\"toe\"");
    std::fs::write(folder.join("pendulum.urdf"), renamed).expect("written");
    simulate(&folder, &["-o", "b.mcap"]);
    let comparison = inspect(&folder, &["a.mcap", "b.mcap"]);
    assert_eq!((&comparison["instants"], &comparison["identical"]), (&91.into(), &Value::Bool(false)), "{comparison}");
    let words = run(&folder, &["inspect", "a.mcap", "b.mcap"]);
    assert!(text(&words.stdout).contains("a.mcap and b.mcap: no link in common\n"), "{}", text(&words.stdout));
}

#[cfg(unix)]
#[test]
fn a_log_is_followed_until_its_run_ends() {
    let folder = folder("follow");
    let log = folder.join("pendulum.mcap");
    let arguments = [&["simulate", "pendulum.urdf", "--velocity", "hinge=1"], &ENDLESS[..]].concat();
    let mut child = catena(&folder, &arguments).spawn().expect("runs");
    wait_for(&mut child, "a log with samples", || salvaged_samples(&log) > 10);
    let mut follower = catena(&folder, &["inspect", "pendulum.mcap", "--follow", "--json"])
        .stdout(Stdio::from(std::fs::File::create(folder.join("followed")).expect("made")))
        .spawn()
        .expect("runs");
    let lines = || std::fs::read_to_string(folder.join("followed")).expect("there").lines().count();
    wait_for(&mut follower, "three looks", || lines() >= 3);
    child.kill().expect("killed");
    child.wait().expect("ends");
    assert!(follower.wait().expect("ends").success());
    let followed = std::fs::read_to_string(folder.join("followed")).expect("there");
    let samples: Vec<u64> = followed
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).expect("JSON")["samples"].as_u64().expect("a count"))
        .collect();
    assert!(samples.is_sorted(), "{samples:?}");
    // The last sample may have been saved in part, which is no sample.
    let bytes = std::fs::read(&log).expect("a log");
    let whole = ["/tf", "/joint_states", "/reactions"].map(|topic| salvaged(&bytes, topic).len());
    assert_eq!(*samples.last().expect("a look") as usize, *whole.iter().min().expect("three"));
}

#[test]
fn bad_usage_is_one_line_and_touches_no_file() {
    let folder = folder("bad");
    simulate(&folder, &[]);
    let before = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    std::fs::write(folder.join("words.mcap"), "not a log at all").expect("written");
    let cases: &[&[&str]] = &[
        &["missing.mcap"],
        &["words.mcap"],
        &["."],
        &["pendulum.urdf"],
        &["pendulum.mcap", "words.mcap"],
        &["pendulum.mcap", "--at", "soon"],
        &["pendulum.mcap", "--plot", "picture.gif"],
        &["pendulum.mcap", "--plot", "-"],
        &["pendulum.mcap", "--csv", "-"],
        &["pendulum.mcap", "--recover", "-"],
        &["pendulum.mcap", "--csv", "pendulum.mcap"],
        &["pendulum.mcap", "--follow", "--csv", "a.csv"],
        &["pendulum.mcap", "pendulum.mcap", "--at", "1"],
        &[],
    ];
    for case in cases {
        assert_one_error(&run(&folder, &[&["inspect"], *case].concat()), 2, &format!("{case:?}"));
    }
    let output = run(&folder, &["inspect", "pendulum.mcap", "--csv", "-"]);
    assert!(text(&output.stderr).contains("standard output is not supported"), "{}", text(&output.stderr));
    assert!(!folder.join("-").exists());
    assert_eq!(run(&folder, &["inspect", "pendulum.mcap", "--csv", "./-"]).status.code(), Some(0));
    assert_one_error(&run(&folder, &["inspect", "pendulum.mcap", "--csv", "no/such/a.csv"]), 1, "no folder");
    assert!(std::fs::read(folder.join("pendulum.mcap")).expect("a log") == before);
}
