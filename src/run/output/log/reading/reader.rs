//! A log as a row of items: channels, messages, metadata and attachments in their order.

use crate::output::log::encoding::ending::FINISHED;
use crate::output::log::encoding::names::{END, LIBRARY, OUTCOME, start_of};
use crate::output::log::reading::records::{Completeness, Found, ReadError, read_records};
use mcap::records::Record;
use mcap::sans_io::{SummaryReadEvent, SummaryReader, SummaryReaderOptions};
use mcap::{McapError, parse_record};
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::ControlFlow;
use std::path::Path;

/// A channel of a log.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LogChannel {
    /// Its topic.
    pub topic: String,
    /// Name of the schema, empty without one.
    pub schema: String,
    /// How messages are encoded: `cdr`.
    pub encoding: String,
}

/// An item of a log, in its order.
pub enum Item<'i> {
    /// The program that wrote it.
    Library(&'i str),
    /// A channel that messages may follow of.
    Channel(&'i LogChannel),
    /// A message; `time` in nanoseconds since the start of the run.
    Message { channel: &'i LogChannel, time: u64, data: &'i [u8] },
    /// A metadata record.
    Metadata { name: &'i str, entries: &'i BTreeMap<String, String> },
    /// An attachment.
    Attachment { name: &'i str, media_type: &'i str, data: &'i [u8] },
    /// A chunk that cannot be read, and why.
    LostChunk(&'i str),
}

/// Shows a log to `visit`, item by item, until it breaks off, the log ends, or cannot be read any further; `None` if it
/// was broken off.
///
/// # Errors
/// [`ReadError`] if it is not a log at all.
pub fn read_log(
    path: &Path,
    mut visit: impl FnMut(Item<'_>) -> ControlFlow<()>,
) -> Result<Option<Completeness>, ReadError> {
    let (mut schemas, mut channels) = (HashMap::<u16, String>::new(), HashMap::<u16, LogChannel>::new());
    let mut start = 0;
    read_records(path, &mut |found| {
        let record = match found {
            Found::Record(record) => record,
            Found::LostChunk(reason) => return Ok(visit(Item::LostChunk(reason))),
        };
        Ok(match record {
            Record::Header(header) => visit(Item::Library(&header.library)),
            Record::Schema { header, .. } => {
                schemas.insert(header.id, header.name);
                ControlFlow::Continue(())
            }
            Record::Channel(channel) => {
                let schema = schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                let known = LogChannel { topic: channel.topic, schema, encoding: channel.message_encoding };
                let is_new = channels.get(&channel.id) != Some(&known);
                let known = channels.entry(channel.id).insert_entry(known);
                if is_new { visit(Item::Channel(known.get())) } else { ControlFlow::Continue(()) }
            }
            Record::Message { header, data } => match channels.get(&header.channel_id) {
                Some(channel) => {
                    let time = header.log_time.saturating_sub(start);
                    visit(Item::Message { channel, time, data: &data })
                }
                None => return Err(no_channel(header.channel_id)),
            },
            Record::Metadata(metadata) => {
                start = start_of(&metadata).unwrap_or(start);
                visit(Item::Metadata { name: &metadata.name, entries: &metadata.metadata })
            }
            Record::Attachment { header, data, .. } => {
                visit(Item::Attachment { name: &header.name, media_type: &header.media_type, data: &data })
            }
            _ => ControlFlow::Continue(()),
        })
    })
}

/// The defect of a message whose channel was not described before.
pub(crate) fn no_channel(channel: u16) -> String {
    format!("a message of channel {channel}, which does not exist")
}

/// Whether a file is a log of ours that lacks its end or says that its run did not finish.
pub(crate) fn is_unfinished(path: &Path) -> bool {
    let mut library = String::new();
    let started = read_log(path, |item| {
        if let Item::Library(name) = item {
            library = name.to_string();
        }
        ControlFlow::Break(())
    });
    if started.is_err() || !library.starts_with(LIBRARY) {
        return false;
    }
    match last_words(path) {
        // A complete log that does not say how its run ended may be dear to its owner.
        Ok(Some(words)) => words.is_some_and(|words| words.get(OUTCOME).is_none_or(|outcome| outcome != FINISHED)),
        // There is no index, or it is damaged.
        Ok(None) | Err(_) => !says_finished(path),
    }
}

/// Whether a log says, somewhere in all that can be read of it, that its run has finished.
fn says_finished(path: &Path) -> bool {
    let mut finished = false;
    // An unreadable log tells no outcome.
    let _ = read_log(path, |item| {
        if let Item::Metadata { name: END, entries } = item {
            finished = entries.get(OUTCOME).is_some_and(|outcome| outcome == FINISHED);
        }
        ControlFlow::Continue(())
    });
    finished
}

/// The entries of a log about its end, read from the summary; `None` without a summary, `Some(None)` without such entries.
#[allow(clippy::option_option, reason = "there are three cases")]
fn last_words(path: &Path) -> Result<Option<Option<BTreeMap<String, String>>>, McapError> {
    let mut file = File::open(path)?;
    let size = file.metadata()?.len();
    let mut reader = SummaryReader::new_with_options(SummaryReaderOptions::default().with_file_size(size));
    while let Some(event) = reader.next_event() {
        match event? {
            SummaryReadEvent::ReadRequest(wanted) => {
                let count = file.read(reader.insert(wanted))?;
                reader.notify_read(count);
            }
            SummaryReadEvent::SeekRequest(to) => {
                let position = file.seek(to)?;
                reader.notify_seeked(position);
            }
        }
    }
    let Some(summary) = reader.finish() else { return Ok(None) };
    let Some(index) = summary.metadata_indexes.iter().rev().find(|index| index.name == END) else {
        return Ok(Some(None));
    };
    file.seek(SeekFrom::Start(index.offset))?;
    let mut record = Vec::new();
    file.take(index.length).read_to_end(&mut record)?;
    match record.split_at_checked(9).map(|(head, body)| parse_record(head[0], body)) {
        Some(Ok(Record::Metadata(metadata))) => Ok(Some(Some(metadata.metadata))),
        _ => Ok(Some(None)),
    }
}
