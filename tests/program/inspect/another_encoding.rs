//! A log whose messages are encoded in another way than those of today.

use super::simulate;
use crate::common::command::{assert_one_error, folder, run, text};
use std::collections::BTreeMap;
use std::io::Cursor;

/// The log with frames of another schema.
fn with_other_frames(bytes: &[u8]) -> Vec<u8> {
    let summary = mcap::Summary::read(bytes).expect("complete").expect("with a summary");
    let options = mcap::WriteOptions::new().library("catena 0.1.0").compression(None);
    let mut writer = options.create(Cursor::new(Vec::new())).expect("memory");
    for index in &summary.attachment_indexes {
        writer.attach(&mcap::read::attachment(bytes, index).expect("an attachment")).expect("memory");
    }
    for index in &summary.metadata_indexes {
        writer.write_metadata(&mcap::read::metadata(bytes, index).expect("metadata")).expect("memory");
    }
    for message in mcap::MessageStream::new(bytes).expect("a log") {
        let message = message.expect("a message");
        let (time, topic) = (message.log_time, message.channel.topic.as_str());
        let schema = message.channel.schema.as_ref().expect("a schema");
        let name = if topic == "/tf" { "other_msgs/msg/Frames" } else { &schema.name };
        let id = writer.add_schema(name, &schema.encoding, &schema.data).expect("memory");
        let channel_id = writer.add_channel(id, topic, "cdr", &BTreeMap::new()).expect("memory");
        let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, &message.data).expect("memory");
    }
    writer.finish().expect("memory");
    writer.into_inner().into_inner()
}

#[test]
fn a_log_of_another_encoding_is_not_replayed_and_the_error_says_why() {
    let folder = folder("another_encoding");
    simulate(&folder, &[]);
    let today = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    std::fs::write(folder.join("pendulum.mcap"), with_other_frames(&today)).expect("written");
    let output = run(&folder, &["replay", "pendulum.mcap"]);
    assert_one_error(&output, 1, "another encoding");
    let error = text(&output.stderr);
    assert!(error.contains("other_msgs/msg/Frames") && error.contains("tf2_msgs/msg/TFMessage"), "{error}");
}
