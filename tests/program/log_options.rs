//! What the user chooses about a log: its topics, its clock, its compression, and where meshes are.

use crate::common::command::{assert_one_error, folder, run, text};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Simulates a short motion into `NAME.mcap`, and returns the log.
fn simulate(folder: &Path, input: &str, name: &str, options: &[&str]) -> Vec<u8> {
    let log = format!("{name}.mcap");
    let words = ["simulate", input, "-o", &log, "--duration", "1", "--quiet"];
    let output = run(folder, &[&words[..], options].concat());
    assert_eq!(output.status.code(), Some(0), "{options:?}: {}", text(&output.stderr));
    std::fs::read(folder.join(log)).expect("a log")
}

fn messages(log: &[u8]) -> Vec<mcap::Message<'_>> {
    mcap::MessageStream::new(log).expect("a log").collect::<Result<_, _>>().expect("every message is readable")
}

fn topics(log: &[u8]) -> BTreeSet<String> {
    messages(log).into_iter().map(|message| message.channel.topic.clone()).collect()
}

fn inspect(folder: &Path, log: &str, options: &[&str]) -> Value {
    let output = run(folder, &[&["inspect", log, "--json"], options].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn replayed(folder: &Path, log: &str) {
    let output = run(folder, &["replay", log]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("identical"), "{}", text(&output.stdout));
}

#[test]
fn a_log_has_the_topics_that_were_chosen_and_what_was_said() {
    let folder = folder("topics");
    let log = simulate(&folder, "pendulum.urdf", "some", &["--topics", "tf,/energy"]);
    assert_eq!(topics(&log), ["/energy", "/rosout", "/tf"].map(str::to_string).into());
    assert_eq!(inspect(&folder, "some.mcap", &[])["samples"], 61);
    replayed(&folder, "some.mcap");
    let wrong = run(&folder, &["simulate", "pendulum.urdf", "--topics", "tf,poses"]);
    assert_eq!(wrong.status.code(), Some(2));
    let error = text(&wrong.stderr);
    assert!(error.contains("no topic \"poses\"") && error.contains("joint_states"), "{error}");
}

#[test]
fn a_log_starts_when_it_was_told_to_and_is_read_in_seconds_of_the_run() {
    let folder = folder("start");
    let motion = ["--velocity", "hinge=1"];
    let at_zero = simulate(&folder, "pendulum.urdf", "zero", &motion);
    let later =
        simulate(&folder, "pendulum.urdf", "later", &[&motion[..], &["--start-time", "1700000000.25"]].concat());
    const START: u64 = 1_700_000_000_250_000_000;
    for (early, late) in messages(&at_zero).iter().zip(&messages(&later)) {
        assert_eq!((early.log_time + START, &early.channel.topic), (late.log_time, &late.channel.topic));
        if early.channel.topic == "/joint_states" {
            let sec = i32::from_le_bytes(late.data[4..8].try_into().expect("four"));
            let nanosec = u32::from_le_bytes(late.data[8..12].try_into().expect("four"));
            assert_eq!(sec as u64 * 1_000_000_000 + u64::from(nanosec), late.log_time);
        }
    }
    let [zero, late] = ["zero.mcap", "later.mcap"].map(|log| {
        let mut instant = inspect(&folder, log, &["--at", "0.5"]);
        assert_eq!(instant.as_object_mut().expect("an object").remove("log"), Some(log.into()));
        instant
    });
    assert_eq!(zero, late);
    assert_eq!(inspect(&folder, "later.mcap", &[])["duration"], 1.0);
    replayed(&folder, "later.mcap");
    // What the clock said is in the log, so that it does not matter what it says now.
    simulate(&folder, "pendulum.urdf", "now", &["--start-time", "now"]);
    replayed(&folder, "now.mcap");
    for wrong in ["-1", "yesterday", "1e10"] {
        let output = run(&folder, &["simulate", "pendulum.urdf", &format!("--start-time={wrong}")]);
        assert_eq!(output.status.code(), Some(2), "{wrong}: {}", text(&output.stderr));
    }
    let output = run(&folder, &["simulate", "pendulum.urdf", "--start-time", "2e9", "--duration", "1.7e10"]);
    assert_one_error(&output, 2, "beyond the nanoseconds of a log");
}

#[test]
fn a_compressed_log_has_the_same_messages_in_fewer_bytes() {
    let folder = folder("compress");
    let motion = ["--velocity", "hinge=1", "--rate", "1000"];
    let plain = simulate(&folder, "pendulum.urdf", "plain", &motion);
    let packed = simulate(&folder, "pendulum.urdf", "packed", &[&motion[..], &["--compress"]].concat());
    let (plain_messages, packed_messages) = (messages(&plain), messages(&packed));
    assert_eq!(plain_messages.len(), packed_messages.len());
    for (plain, packed) in plain_messages.iter().zip(&packed_messages) {
        assert_eq!((plain.log_time, &plain.channel.topic), (packed.log_time, &packed.channel.topic));
        assert!(plain.data == packed.data, "{} at {}", plain.channel.topic, plain.log_time);
    }
    // Without the request names and constants are written once a chunk; with it, more than a third of the rest is saved.
    assert!(3 * packed.len() < 2 * plain.len(), "{} of {} bytes", packed.len(), plain.len());
    let whole: u64 = plain_messages.iter().map(|message| message.data.len() as u64).sum();
    // Names and zeros are more than half of the samples of a pendulum; headers and indexes of messages come to what is packed.
    assert!(3 * plain.len() as u64 <= 2 * whole, "{} bytes for messages of {whole}", plain.len());
    let summary = mcap::Summary::read(&packed).expect("complete").expect("with a summary");
    assert!(summary.chunk_indexes.iter().all(|chunk| chunk.compression == "zstd"));
    let indexed: u64 = summary
        .chunk_indexes
        .iter()
        .map(|chunk| {
            let of_chunk = summary.read_message_indexes(&packed, chunk).expect("indexes");
            of_chunk.values().map(|entries| entries.len() as u64).sum::<u64>()
        })
        .sum();
    assert_eq!(indexed, packed_messages.len() as u64);
    replayed(&folder, "packed.mcap");
}

/// Two triangles in a Collada file with two colours, one in an STL file, used twice with mirrored scales.
fn with_meshes(folder: &Path) -> PathBuf {
    let triangle = |x: f64| {
        format!("facet normal 0 0 1\nouter loop\nvertex {x} 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n")
    };
    std::fs::write(folder.join("part.stl"), format!("solid\n{}endsolid\n", triangle(0.0))).expect("written");
    let effect = |name: &str, color: &str| {
        format!(
            "<effect id=\"{name}-effect\"><profile_COMMON><technique sid=\"t\"><lambert><diffuse><color>{color}</color>\
             </diffuse></lambert></technique></profile_COMMON></effect>"
        )
    };
    let material = |name: &str| format!("<material id=\"{name}\"><instance_effect url=\"#{name}-effect\"/></material>");
    let polygons = |name: &str| {
        format!(
            "<polylist count=\"1\" material=\"{name}\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>\
             <vcount>3</vcount><p>0 1 2</p></polylist>"
        )
    };
    let collada = format!(
        "<COLLADA version=\"1.4.1\"><asset><unit meter=\"0.01\"/><up_axis>Y_UP</up_axis></asset>\
         <library_effects>{}{}</library_effects><library_materials>{}{}</library_materials>\
         <library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array id=\"a\" count=\"9\">0 0 0 100 0 0 0 100 50</float_array>\
         </source><vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>{}{}</mesh></geometry></library_geometries>\
         <library_visual_scenes><visual_scene id=\"s\"><node><instance_geometry url=\"#g\"/></node></visual_scene></library_visual_scenes>\
         <scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>",
        effect("red", "1 0 0 1"),
        effect("blue", "0 0 1 0.5"),
        material("red"),
        material("blue"),
        polygons("red"),
        polygons("blue"),
    );
    std::fs::write(folder.join("part.dae"), collada).expect("written");
    let mesh = |file: &str, scale: &str| {
        format!("<visual><geometry><mesh filename=\"{file}\" scale=\"{scale}\"/></geometry></visual>")
    };
    let looks = [mesh("part.dae", "1 1 1"), mesh("part.stl", "1 1 1"), mesh("part.stl", "-1 1 1")].concat();
    let collision = "<collision><geometry><mesh filename=\"part.stl\"/></geometry></collision>";
    let urdf = crate::common::command::PENDULUM
        .replace("<link name=\"tip\"/>", &format!("<link name=\"tip\">{looks}{collision}</link>"));
    let file = folder.join("meshes.urdf");
    std::fs::write(&file, urdf).expect("written");
    file
}

/// The text of the description in a log.
fn description(log: &[u8]) -> String {
    let messages = messages(log);
    let message = messages.iter().find(|message| message.channel.topic == "/robot_description").expect("a description");
    String::from_utf8(message.data[8..message.data.len() - 1].to_vec()).expect("UTF-8")
}

#[test]
fn meshes_are_in_the_log_linked_to_or_nowhere() {
    let folder = folder("meshes");
    with_meshes(&folder);
    let log = |place: &str| simulate(&folder, "meshes.urdf", place, &["--meshes", place]);
    let (embedded, linked, without) = (log("embed"), log("link"), log("none"));
    // A Collada file is there once more as GLB, and the description names that; an STL file is fine as it is.
    let glb: Vec<PathBuf> = std::fs::read_dir(folder.join("embed.meshes"))
        .expect("a folder")
        .map(|entry| entry.expect("there").path())
        .collect();
    let [glb] = &glb[..] else { panic!("{glb:?}") };
    assert!(description(&embedded).contains(&format!("\"file://{}\"", glb.display())), "{}", description(&embedded));
    assert!(description(&embedded).contains("part.stl\"") && !description(&embedded).contains("collision"));
    assert!(description(&linked).contains("part.dae\"") && !folder.join("link.meshes").exists());
    assert!(topics(&embedded).contains("/visual_markers") && topics(&linked).contains("/visual_markers"));
    assert!(!topics(&without).contains("/visual_markers") && !folder.join("none.meshes").exists());
    let markers = |log: &[u8]| {
        let messages = messages(log);
        let found = messages.iter().find(|message| message.channel.topic == "/visual_markers").expect("markers");
        found.data.to_vec()
    };
    // Corners in metres, of which y is what is up in the file: the axis is not heeded.
    let corner = [0.0, 1.0, 0.5].map(|value: f64| value.to_le_bytes()).concat();
    let has = |data: &[u8], what: &[u8]| data.windows(what.len()).any(|window| window == what);
    assert!(has(&markers(&embedded), &corner) && !has(&markers(&embedded), b"file://"));
    assert!(has(&markers(&linked), b"part.dae") && !has(&markers(&linked), &corner));
    for (log, bytes) in [("embed.mcap", &embedded), ("link.mcap", &linked), ("none.mcap", &without)] {
        replayed(&folder, log);
        let summary = mcap::Summary::read(bytes).expect("complete").expect("with a summary");
        assert_eq!(summary.chunk_indexes[0].compression, "zstd", "what never changes is compressed");
        assert!(
            summary.chunk_indexes[1..].iter().all(|chunk| chunk.compression == "lz4"),
            "samples repeat their names"
        );
    }
}

#[test]
fn a_mesh_that_cannot_be_read_is_a_warning_in_the_log_and_linked_to() {
    let folder = folder("broken_mesh");
    with_meshes(&folder);
    std::fs::write(folder.join("part.dae"), "<COLLADA><library").expect("written");
    let log = simulate(&folder, "meshes.urdf", "broken", &[]);
    let warnings = inspect(&folder, "broken.mcap", &[])["warnings"].to_string();
    assert!(warnings.contains("part.dae is not in the log"), "{warnings}");
    assert!(description(&log).contains("part.dae\"") && !folder.join("broken.meshes").exists());
}
