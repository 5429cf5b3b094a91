//! Of a log that was cut off or damaged everything that is left is shown and recovered, and it is said what is missing.

use super::{inspect, json, simulate};
use crate::common;
use crate::common::command::{assert_one_error, folder, run, text};
use serde_json::Value;
use std::io::Read;

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
        ["complete", "damaged", "lost_chunks", "log", "bytes", "recovered_from"].iter().for_each(|entry| {
            summary.as_object_mut().expect("an object").remove(*entry);
        });
    }
    assert_eq!(damaged, recovered);
    let output = run(&folder, &["inspect", "damaged.mcap", "--csv", "damaged.csv"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

/// The records in a frame of LZ4; how many of them there are after each of its blocks, and where that ends.
fn unpacked_blocks(frame: &[u8]) -> (Vec<u8>, Vec<(usize, usize)>) {
    let (mut records, mut blocks, mut end) = (Vec::new(), Vec::new(), 7);
    loop {
        let length = u32::from_le_bytes(frame[end..end + 4].try_into().expect("four bytes")) as usize;
        if length == 0 {
            return (records, blocks);
        }
        end += 4 + length;
        records.clear();
        // A frame that is cut ends in an error, after all that is whole in it.
        let _ = lz4::Decoder::new(&frame[..end]).expect("a frame").read_to_end(&mut records);
        blocks.push((records.len(), end));
    }
}

/// Where each message of a log ends, in bytes; those of a compressed chunk end with their block, or with the chunk.
fn ends_of_messages(log: &[u8]) -> Vec<usize> {
    let number =
        |bytes: &[u8], at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes")) as usize;
    let (mut ends, mut at) = (Vec::new(), 8);
    while at + 9 <= log.len() - 8 {
        let next = at + 9 + number(log, at + 1);
        if log[at] == 6 {
            // Two times, the size, the checksum, the name of the compression and the size with it come before the records.
            let name = at + 9 + 8 + 8 + 8 + 4;
            let start = name + 4 + usize::from(log[name]) + 8;
            let packed = &log[start..next];
            // What there is of the records once so many bytes of the chunk are there.
            let (records, blocks) = match &log[name + 4..start - 8] {
                b"zstd" => {
                    let records = zstd::decode_all(packed).expect("a frame");
                    let whole = (records.len(), packed.len());
                    (records, vec![whole])
                }
                b"lz4" => unpacked_blocks(packed),
                other => panic!("{other:?}"),
            };
            let mut inside = 0;
            while inside < records.len() {
                let end = inside + 9 + number(&records, inside + 1);
                if records[inside] == 5 {
                    let (_, block) = blocks.iter().find(|(there, _)| *there >= end).expect("in a block");
                    ends.push(start + block);
                }
                inside = end;
            }
        }
        at = next;
    }
    ends
}

#[test]
fn every_whole_block_before_a_cut_is_read_also_those_of_the_chunk_that_was_cut() {
    let folder = folder("torn");
    simulate(&folder, &["--rate", "100"]);
    let whole = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    let ends = ends_of_messages(&whole);
    let mut numbers = common::Numbers::new(11);
    let mut cuts: Vec<usize> = (0..12).map(|_| numbers.next(ends[0] as f64, whole.len() as f64) as usize).collect();
    // Just before and at the end of a message, the first of all and one in the middle of the samples.
    cuts.extend([ends[0], ends[ends.len() / 2]].iter().flat_map(|end| [end - 1, *end]));
    for cut in cuts {
        std::fs::write(folder.join("cut.mcap"), &whole[..cut]).expect("written");
        let summary = inspect(&folder, &["cut.mcap"]);
        let topics = summary["topics"].as_array().expect("topics");
        let messages = |topic: &Value| topic["messages"].as_u64().expect("a count");
        let found: u64 = topics.iter().map(messages).sum();
        let expected = |more: usize| ends.iter().filter(|end| **end + more <= cut).count() as u64;
        // The reader of LZ4 wants the four bytes behind a block, too, and holds back the last message until there is more.
        let expected = expected(4).saturating_sub(1)..=expected(0);
        assert!(expected.contains(&found), "{found} of {expected:?} messages, {cut} of {} bytes", whole.len());
        let words = run(&folder, &["inspect", "cut.mcap"]);
        assert!(text(&words.stdout).contains("TRUNCATED"), "{}", text(&words.stdout));
        // The last sample may lack messages: it is no row of the table, which would have other columns.
        let output = run(&folder, &["inspect", "cut.mcap", "--csv", "cut.csv"]);
        let code = if summary["samples"] == 0 { 2 } else { 0 };
        assert_eq!(output.status.code(), Some(code), "{cut}: {}", text(&output.stderr));
    }
}

#[test]
fn a_recovered_log_is_complete_and_has_everything_that_could_be_read() {
    let folder = folder("recovered");
    simulate(&folder, &["--rate", "100"]);
    let original = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    let ends = ends_of_messages(&original);
    std::fs::write(folder.join("cut.mcap"), &original[..ends[ends.len() * 3 / 5] + 1]).expect("written");
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
    assert!((original.len() / 2..original.len()).contains(&found.len()), "{} of {}", found.len(), original.len());
    assert!(found == original[..found.len()]);
    let index = mcap::Summary::read(&whole).expect("a log").expect("an index");
    assert_eq!(index.stats.expect("figures").message_count, found.len() as u64);
    let [mut cut, mut recovered] = ["cut.mcap", "whole.mcap"].map(|log| inspect(&folder, &[log]));
    assert_eq!((&cut["complete"], &recovered["complete"]), (&false.into(), &true.into()));
    let lacks = recovered["recovered_from"].as_str().expect("words");
    assert!(lacks.starts_with("TRUNCATED: it ends in the middle"), "{lacks}");
    for summary in [&mut cut, &mut recovered] {
        ["complete", "log", "bytes", "broken_off", "recovered_from"].iter().for_each(|entry| {
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

/// Where the top-level records of a log with this opcode begin and end.
fn records(log: &[u8], opcode: u8) -> Vec<std::ops::Range<usize>> {
    let (mut found, mut at) = (Vec::new(), 8);
    while at + 9 <= log.len() - 8 {
        let length = u64::from_le_bytes(log[at + 1..at + 9].try_into().expect("eight bytes")) as usize;
        if log[at] == opcode {
            found.push(at..at + 9 + length);
        }
        at += 9 + length;
    }
    found
}

const ATTACHMENT: u8 = 9;
const METADATA: u8 = 12;
const CHUNK: u8 = 6;

/// Where these words stand in a log.
fn place_of(log: &[u8], words: &str) -> usize {
    log.windows(words.len()).position(|window| window == words.as_bytes()).expect("the words")
}

#[test]
fn samples_beside_a_damaged_chunk_are_whole_or_none_also_where_it_is_the_first_that_has_any() {
    let folder = folder("first_samples");
    simulate(&folder, &["--rate", "1000"]);
    let whole = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    let chunks = records(&whole, CHUNK);
    assert!(chunks.len() > 3, "{}", chunks.len());
    // The first has the channels, so that nothing is left without it.
    for chunk in &chunks[1..] {
        let mut damaged = whole.clone();
        damaged[chunk.end - 100] ^= 1;
        std::fs::write(folder.join("damaged.mcap"), damaged).expect("written");
        std::fs::remove_file(folder.join("recovered.mcap")).ok();
        let output = run(&folder, &["inspect", "damaged.mcap", "--recover", "recovered.mcap", "--csv", "d.csv"]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let gap = inspect(&folder, &["damaged.mcap"])["lost_chunks"].clone();
        for log in ["damaged.mcap", "recovered.mcap"] {
            let summary = inspect(&folder, &[log]);
            assert_eq!((&summary["links"], &summary["joints"]), (&3.into(), &1.into()), "{log}");
            for end in ["after", "before"] {
                // Zero is said where there is nothing before.
                let Some(time) = gap[end].as_f64().filter(|time| *time > 0.0) else { continue };
                let found = inspect(&folder, &[log, "--at", &time.to_string()]);
                let at = found["time"].as_f64().expect("a time");
                assert!((at - time).abs() < 0.0025, "{log}: {at} instead of {time}");
                let expected = inspect(&folder, &["pendulum.mcap", "--at", &at.to_string()]);
                assert_eq!(
                    (&found["links"], &found["joints"]),
                    (&expected["links"], &expected["joints"]),
                    "{log}, {at}"
                );
            }
        }
        let said = inspect(&folder, &["recovered.mcap"])["recovered_from"].clone();
        assert!(said.as_str().is_some_and(|said| said.starts_with("DAMAGED: 1 chunk")), "{said}");
        let words = run(&folder, &["inspect", "recovered.mcap"]);
        assert!(text(&words.stdout).contains(": recovered from a log that was DAMAGED: 1 chunk"), "{words:?}");
    }
}

#[test]
fn a_record_that_is_damaged_is_passed_over_and_every_sample_is_shown() {
    let folder = folder("records");
    simulate(&folder, &[]);
    let whole = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    let expected = inspect(&folder, &["pendulum.mcap"]);
    // Text of the input, which has a checksum; the length of a name, which reaches beyond its record.
    let inside = records(&whole, ATTACHMENT)[0].start + 200;
    let length = records(&whole, METADATA)[0].start + 9 + 2;
    for place in [inside, length] {
        let mut damaged = whole.clone();
        damaged[place] ^= 1;
        std::fs::write(folder.join("damaged.mcap"), damaged).expect("written");
        let summary = inspect(&folder, &["damaged.mcap"]);
        assert_eq!(summary["samples"], expected["samples"]);
        assert_eq!((&summary["damaged"], &summary["lost_records"]["count"]), (&true.into(), &1.into()), "{summary}");
        std::fs::remove_file(folder.join("recovered.mcap")).ok();
        let output = run(&folder, &["inspect", "damaged.mcap", "--recover", "recovered.mcap"]);
        assert!(text(&output.stdout).contains("DAMAGED: 1 record cannot be read: "), "{}", text(&output.stdout));
        assert_eq!(inspect(&folder, &["recovered.mcap"])["samples"], expected["samples"]);
    }
}

#[test]
fn what_only_the_checksum_of_the_whole_can_tell_is_said() {
    let folder = folder("whole_checksum");
    simulate(&folder, &[]);
    let whole = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    let mut changed = whole.clone();
    let digit = place_of(&whole, "energy_max_relative_error") + "energy_max_relative_error".len() + 4;
    changed[digit] = if changed[digit] == b'9' { b'8' } else { b'9' };
    let twice = [&whole[..], &whole].concat();
    for (log, said) in [(changed, "not what was written"), (twice, "behind its end")] {
        std::fs::write(folder.join("changed.mcap"), log).expect("written");
        let summary = inspect(&folder, &["changed.mcap"]);
        assert_eq!((&summary["complete"], &summary["damaged"]), (&false.into(), &true.into()), "{said}");
        let words = run(&folder, &["inspect", "changed.mcap"]);
        assert!(text(&words.stdout).contains(said), "{}", text(&words.stdout));
        let output = run(&folder, &["replay", "changed.mcap"]);
        assert_eq!(output.status.code(), Some(1), "{said}: {}", text(&output.stdout));
    }
}

#[test]
fn no_length_that_a_log_claims_ends_the_program() {
    let folder = folder("lengths");
    simulate(&folder, &[]);
    let whole = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    for opcode in [ATTACHMENT, METADATA, CHUNK] {
        for length in [u64::MAX, u64::MAX - 8, 1 << 63, 1 << 40] {
            let mut damaged = whole.clone();
            let start = records(&whole, opcode)[0].start;
            damaged[start + 1..start + 9].copy_from_slice(&length.to_le_bytes());
            std::fs::write(folder.join("damaged.mcap"), damaged).expect("written");
            for arguments in [&["inspect", "damaged.mcap"][..], &["inspect", "damaged.mcap", "pendulum.mcap"]] {
                let output = run(&folder, arguments);
                assert_eq!(output.status.code(), Some(0), "{length}: {}", text(&output.stderr));
                let said = text(&output.stdout);
                assert!(said.contains("DAMAGED") || said.contains("TRUNCATED"), "{length}: {said}");
            }
            let replayed = run(&folder, &["replay", "damaged.mcap"]);
            assert!([Some(1), Some(2)].contains(&replayed.status.code()), "{length}: {}", text(&replayed.stderr));
        }
    }
    // A chunk that says that there is more in it than any memory holds.
    let mut damaged = whole.clone();
    let start = records(&whole, CHUNK)[0].start + 9 + 16;
    damaged[start..start + 8].copy_from_slice(&(1_u64 << 50).to_le_bytes());
    std::fs::write(folder.join("damaged.mcap"), damaged).expect("written");
    assert_eq!(run(&folder, &["inspect", "damaged.mcap"]).status.code(), Some(0));
}

#[test]
fn what_comes_before_a_message_that_says_nothing_is_shown_and_recovered() {
    let folder = folder("zeros");
    simulate(&folder, &["--rate", "1000"]);
    let whole = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    // What a power cut may leave: blocks that were never written, or belong to something else, wherever they begin in a message.
    for shift in 0..24 {
        let end = whole.len() / 2 + 29 * shift;
        let cut = [&whole[..end], &[if shift % 2 == 0 { 0 } else { 0xff }; 4096]].concat();
        std::fs::write(folder.join("cut.mcap"), cut).expect("written");
        std::fs::remove_file(folder.join("recovered.mcap")).ok();
        let output = run(&folder, &["inspect", "cut.mcap", "--recover", "recovered.mcap"]);
        assert_eq!(output.status.code(), Some(0), "{end}: {}", text(&output.stderr));
        for log in ["cut.mcap", "recovered.mcap"] {
            let samples = inspect(&folder, &[log])["samples"].as_u64().expect("a count");
            assert!((300..1500).contains(&samples), "{log}, {end}: {samples}");
        }
    }
}
