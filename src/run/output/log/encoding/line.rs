//! Lines of text, as `rcl_interfaces/msg/Log` on `/rosout`, where ROS tools look for them.

use crate::output::log::encoding::cdr::CdrWriter;
use crate::output::log::encoding::severity::Severity;

/// The topic.
pub(crate) const TOPIC: &str = "/rosout";

/// The number in the message. Problems have the number of a warning or a larger one.
pub(crate) fn level(severity: Severity) -> u8 {
    match severity {
        Severity::Info => 20,
        Severity::Warning => 30,
        Severity::Error => 40,
    }
}

/// A line at a time of the log, encoded.
pub(crate) fn encode_line(nanoseconds: u64, severity: Severity, text: &str) -> Vec<u8> {
    let mut line = Vec::new();
    let mut writer = CdrWriter::begin(&mut line);
    writer.time(nanoseconds);
    writer.byte(level(severity));
    writer.string("catena");
    writer.string(text);
    // The line has no file, function and line number: the text names the place of the problem.
    writer.string("");
    writer.string("");
    writer.unsigned(0);
    line
}
