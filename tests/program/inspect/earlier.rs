//! Logs of earlier versions, whose transforms and lines of text were messages of Foxglove and whose figures had no names.

use super::{json, simulate};
use crate::common::command::{assert_one_error, folder, run, text};
use catena::output::log::reading::decode;
use std::collections::BTreeMap;
use std::io::Cursor;

/// Name, encoding and data of a schema, and a message.
type Encoded = ([&'static str; 3], Vec<u8>);

/// A field of Protocol Buffers with a length (kind 2).
fn bytes(number: u8, content: &[u8]) -> Vec<u8> {
    assert!(content.len() < 1 << 14, "two bytes for the length");
    let length = [content.len() as u8 & 0x7f | 0x80, (content.len() >> 7) as u8];
    [&[number << 3 | 2][..], &length, content].concat()
}

/// The fields 1, 2, … of doubles (kind 1).
fn doubles(values: &[f64]) -> Vec<u8> {
    (1_u8..).zip(values).flat_map(|(number, value)| [&[number << 3 | 1][..], &value.to_le_bytes()].concat()).collect()
}

fn transforms(data: &[u8]) -> Encoded {
    let transform = |pose: decode::LinkPose| {
        let [w, x, y, z] = pose.orientation;
        let names = [bytes(2, b"world"), bytes(3, pose.link.as_bytes())].concat();
        let numbers = [bytes(4, &doubles(&pose.position)), bytes(5, &doubles(&[x, y, z, w]))].concat();
        bytes(1, &[names, numbers].concat())
    };
    let all = decode::transforms(data).expect("transforms").into_iter().flat_map(transform);
    (["foxglove.FrameTransforms", "protobuf", "of Foxglove"], all.collect())
}

fn line(data: &[u8]) -> Encoded {
    let decode::LogLine { is_problem, text } = decode::log_line(data).expect("a line");
    // The second field is the level: 2 of information, 3 of warnings.
    let level = [2 << 3, if is_problem { 3 } else { 2 }];
    (["foxglove.Log", "protobuf", "of Foxglove"], [&level[..], &bytes(3, text.as_bytes())].concat())
}

/// A `std_msgs/msg/Float64MultiArray` with the first `N` of the numbers.
fn array<const N: usize>(data: &[u8]) -> Encoded {
    let mut bytes = vec![0, 1, 0, 0];
    // One dimension, of the empty name, its size and stride; no offset; the count.
    for number in [1, 1_u32] {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    bytes.extend_from_slice(&[0; 4]);
    for number in [N as u32, N as u32, 0, N as u32] {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    bytes.resize(4 + (bytes.len() - 4).next_multiple_of(8), 0);
    let numbers: [f64; N] = decode::named_numbers(data).expect("numbers");
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    (["std_msgs/msg/Float64MultiArray", "ros2msg", "float64[] data"], bytes)
}

/// The log as an earlier version would have written it.
fn earlier(bytes: &[u8]) -> Vec<u8> {
    let summary = mcap::Summary::read(bytes).expect("complete").expect("with a summary");
    let options = mcap::WriteOptions::new().library("catena 0.1.0").compression(None);
    let mut writer = options.create(Cursor::new(Vec::new())).expect("memory");
    for index in &summary.attachment_indexes {
        writer.attach(&mcap::read::attachment(bytes, index).expect("an attachment")).expect("memory");
    }
    for index in &summary.metadata_indexes {
        let mut record = mcap::read::metadata(bytes, index).expect("metadata");
        record.metadata.remove("start");
        writer.write_metadata(&record).expect("memory");
    }
    let mut write = |time: u64, topic: &str, [name, encoding, definition]: [&str; 3], data: &[u8]| {
        let id = writer.add_schema(name, encoding, definition.as_bytes()).expect("memory");
        let encoding = if encoding == "protobuf" { encoding } else { "cdr" };
        let channel_id = writer.add_channel(id, topic, encoding, &BTreeMap::new()).expect("memory");
        let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, data).expect("memory");
    };
    for message in mcap::MessageStream::new(bytes).expect("a log") {
        let message = message.expect("a message");
        let (time, topic, data) = (message.log_time, message.channel.topic.as_str(), &message.data[..]);
        let (topic, (schema, data)) = match topic {
            "/visual_markers" => ("/scene", (["foxglove.SceneUpdate", "protobuf", "of Foxglove"], Vec::new())),
            "/tf" => (topic, transforms(data)),
            "/rosout" => ("/log", line(data)),
            // Those of smooth runs had five numbers.
            "/energy" => (topic, array::<5>(data)),
            "/constraint" => (topic, array::<2>(data)),
            "/solver" => (topic, array::<5>(data)),
            _ => {
                let schema = message.channel.schema.as_ref().expect("a schema");
                let definition = std::str::from_utf8(&schema.data).expect("UTF-8");
                write(time, topic, [&schema.name, &schema.encoding, definition], data);
                continue;
            }
        };
        write(time, topic, schema, &data);
    }
    writer.finish().expect("memory");
    writer.into_inner().into_inner()
}

#[test]
fn a_log_of_an_earlier_version_says_the_same_as_one_of_today() {
    let folder = folder("earlier");
    simulate(&folder, &["--velocity", "hinge=2"]);
    let today = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    std::fs::write(folder.join("earlier.mcap"), earlier(&today)).expect("written");
    let said = |arguments: &[&str]| {
        let both = ["pendulum.mcap", "earlier.mcap"];
        both.map(|log| json(&run(&folder, &[&["inspect", log, "--json"], arguments].concat())))
    };
    let [mut new, mut old] = said(&[]);
    assert_eq!((old["samples"].as_u64(), old["complete"].as_bool()), (Some(91), Some(true)));
    // What differs is what the file is, and the kinds of its messages.
    for key in ["log", "bytes", "topics"] {
        for summary in [&mut new, &mut old] {
            summary.as_object_mut().expect("an object").remove(key).expect(key);
        }
    }
    new["simulation"].as_object_mut().expect("an object").remove("start").expect("a start");
    assert_eq!(new, old);
    let [new, old] = said(&["--at", "0.7"]);
    assert_eq!([&new["time"], &new["links"], &new["joints"]], [&old["time"], &old["links"], &old["joints"]]);
    assert_eq!((new["time"].as_f64(), &new["constraint"]), (Some(0.7), &old["constraint"]));
    for log in ["pendulum", "earlier"] {
        let words = ["inspect", &format!("{log}.mcap"), "--csv", &format!("{log}.csv")];
        assert_eq!(run(&folder, &words).status.code(), Some(0));
    }
    let tables = ["pendulum.csv", "earlier.csv"].map(|table| std::fs::read(folder.join(table)).expect("a table"));
    assert!(tables[0] == tables[1]);
}

#[test]
fn a_log_of_an_earlier_version_is_not_replayed_and_the_error_says_why() {
    let folder = folder("earlier_replay");
    simulate(&folder, &[]);
    let today = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    std::fs::write(folder.join("pendulum.mcap"), earlier(&today)).expect("written");
    let output = run(&folder, &["replay", "pendulum.mcap"]);
    assert_one_error(&output, 1, "another encoding");
    let error = text(&output.stderr);
    assert!(error.contains("foxglove.FrameTransforms") && error.contains("tf2_msgs/msg/TFMessage"), "{error}");
}
