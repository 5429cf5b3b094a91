//! The file: the same bytes for the same run, an index and checksums that are right, and readable while it is written.

use super::{Onlooker, URDF, log, log_seen_by, messages, of_topic};
use crate::common::scratch;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

/// Long enough for several chunks.
#[test]
fn the_same_run_gives_the_same_bytes() {
    let first = log("first.mcap", 60.0);
    let chunks = mcap::Summary::read(&first).expect("complete").expect("with a summary").chunk_indexes;
    assert!(chunks.len() >= 3, "{} chunks", chunks.len());
    assert!(chunks.iter().all(|chunk| chunk.uncompressed_size <= 1 << 18), "{chunks:?}");
    assert!(first == log("second.mcap", 60.0));
}

#[test]
fn the_summary_leads_to_every_message_attachment_and_record_and_all_checksums_are_right() {
    let bytes = log("summary.mcap", 30.0);
    let summary = mcap::Summary::read(&bytes).expect("the checksum of the summary is right").expect("there is one");
    let statistics = summary.stats.as_ref().expect("there are statistics");
    let in_order = messages(&bytes);
    assert_eq!(statistics.message_count, in_order.len() as u64);
    assert_eq!((statistics.message_start_time, statistics.message_end_time), (0, 30_000_000_000));
    assert_eq!(statistics.chunk_count as usize, summary.chunk_indexes.len());
    for channel in summary.channels.values() {
        let count = of_topic(&in_order, &channel.topic).len() as u64;
        assert_eq!(statistics.channel_message_counts.get(&channel.id), Some(&count), "{}", channel.topic);
        assert!(channel.schema.is_some(), "{}", channel.topic);
    }
    let mut found = 0;
    for chunk in &summary.chunk_indexes {
        for (channel, entries) in summary.read_message_indexes(&bytes, chunk).expect("the index is where it should be")
        {
            for entry in entries {
                let message = summary.seek_message(&bytes, chunk, &entry).expect("a message is where the index says");
                assert_eq!((&message.channel.topic, message.log_time), (&channel.topic, entry.log_time));
                found += 1;
            }
        }
        // Reading a chunk to its end checks its checksum.
        for message in summary.stream_chunk(&bytes, chunk).expect("a chunk is where the index says") {
            let time = message.expect("the checksum of the chunk is right").log_time;
            assert!((chunk.message_start_time..=chunk.message_end_time).contains(&time));
        }
    }
    assert_eq!(found, in_order.len());
    assert_eq!((summary.attachment_indexes.len(), summary.metadata_indexes.len()), (1, 3));
    for index in &summary.attachment_indexes {
        let attachment = mcap::read::attachment(&bytes, index).expect("the checksum of the attachment is right");
        assert_eq!((&attachment.name, &*attachment.data), (&"arm.urdf".to_string(), URDF.as_bytes()));
    }
    for index in &summary.metadata_indexes {
        assert_eq!(mcap::read::metadata(&bytes, index).expect("a record").name, index.name);
    }
    // The checksum of everything before the summary is in the record before that.
    let options = LinearReaderOptions::default().with_validate_data_section_crc(true);
    let (mut reader, mut rest) = (LinearReader::new_with_options(options), &bytes[..]);
    let mut checksums = 0;
    while let Some(event) = reader.next_event() {
        match event.expect("all checksums are right") {
            LinearReadEvent::ReadRequest(wanted) => {
                let (now, later) = rest.split_at(wanted.min(rest.len()));
                reader.insert(now.len()).copy_from_slice(now);
                reader.notify_read(now.len());
                rest = later;
            }
            LinearReadEvent::Record { opcode: mcap::records::op::DATA_END, data } => {
                // Zero would stand for none.
                assert_ne!(data, [0; 4]);
                checksums += 1;
            }
            LinearReadEvent::Record { .. } => {}
        }
    }
    assert_eq!(checksums, 1);
}

/// What a killed run leaves behind is what is in the file at that time.
#[test]
fn all_but_the_last_second_is_readable_before_the_log_is_complete_and_leaves_no_trace() {
    let mut onlooker = Onlooker { path: Some(scratch("log").join("onlooker.mcap")), seen: 0 };
    let bytes = log_seen_by("onlooker.mcap", 60.0, &mut onlooker);
    assert!(onlooker.seen >= 31, "{} of the 31 samples up to t = 0.5 s", onlooker.seen);
    assert!(bytes == log("undisturbed.mcap", 60.0));
}
