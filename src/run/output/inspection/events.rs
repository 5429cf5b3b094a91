//! The events of a log as a table, in the order of the log, which is the order of time.

use crate::output::log::reading::decode::LoggedEvent;
use crate::output::log::reading::frames::{Visitor, visit};
use crate::output::log::reading::records::ReadError;
use crate::output::report::{EventEntry, KindCounts};
use serde::Serialize;
use std::fmt;
use std::path::Path;

/// All events of a log.
#[derive(Clone, Debug, Default, Serialize)]
pub struct LoggedEvents {
    /// The file.
    pub log: String,
    /// How many there are of each kind.
    pub counts: KindCounts,
    /// All of them.
    pub list: Vec<EventEntry>,
}

impl Visitor for LoggedEvents {
    fn event(&mut self, LoggedEvent { time, kind, what, impulse }: LoggedEvent) {
        self.counts.add(&kind, 1);
        self.list.push(EventEntry { time, kind, what, impulse });
    }
}

impl LoggedEvents {
    /// Reads a log from its beginning to its end; a log of a smooth run has no events.
    ///
    /// # Errors
    /// [`ReadError`] if it is not a log.
    pub fn read(log: &Path) -> Result<Self, ReadError> {
        let mut events = LoggedEvents { log: log.display().to_string(), ..LoggedEvents::default() };
        visit(log, &mut events)?;
        Ok(events)
    }
}

impl fmt::Display for LoggedEvents {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "{}: events: {}", self.log, self.counts.words())?;
        if self.list.is_empty() {
            return Ok(());
        }
        let width = |head: &str, words: &dyn Fn(&EventEntry) -> usize| {
            self.list.iter().map(words).max().unwrap_or(0).max(head.chars().count())
        };
        let kinds = width("kind", &|event| event.kind.chars().count());
        let joints = width("joint or a|b", &|event| event.what.chars().count());
        writeln!(out, "  {:>18}  {:kinds$}  {:joints$}  impulse [N m s, N s]", "time [s]", "kind", "joint or a|b")?;
        for EventEntry { time, kind, what, impulse } in &self.list {
            match impulse {
                Some(impulse) => writeln!(out, "  {time:>18.12}  {kind:kinds$}  {what:joints$}  {impulse:.6e}")?,
                None => writeln!(out, "  {time:>18.12}  {kind:kinds$}  {what}")?,
            }
        }
        Ok(())
    }
}
