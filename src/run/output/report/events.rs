//! The events of a run, counted and listed, and the state of joints at its end (on a limit, stuck).

use crate::mechanism::ground::words::counted;
use crate::mechanism::motion::event::{Event, EventCounts, EventKind, JointStatus};
use crate::model::Model;
use crate::output::report::contact::pair_name;
use crate::simulation::Finished;
use serde::{Serialize, Serializer};

/// The kinds of events in the order of reports, with their words for one and for several.
const KINDS: [(&str, &str, &str); EventKind::ALL.len()] = [
    ("limit_impact", "limit impact", "limit impacts"),
    ("contact_impact", "contact impact", "contact impacts"),
    ("rest", "rest", "rests"),
    ("release", "release", "releases"),
    ("stick", "stick", "sticks"),
    ("slip", "slip", "slips"),
    ("reversal", "reversal", "reversals"),
    ("saturation", "saturation", "saturations"),
    ("unsaturation", "end of saturation", "ends of saturation"),
];

/// How many events there were of each kind, in the order of reports.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KindCounts(Vec<(String, usize)>);

impl Serialize for KindCounts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(kind, count)| (kind, count)))
    }
}

impl Default for KindCounts {
    fn default() -> Self {
        KindCounts(KINDS.iter().map(|(name, ..)| (name.to_string(), 0)).collect())
    }
}

impl KindCounts {
    /// The counts of a run.
    pub(crate) fn new(counts: &EventCounts) -> Self {
        let mut all = KindCounts::default();
        EventKind::ALL.iter().for_each(|&kind| all.add(kind.name(), counts.of(kind)));
        all
    }

    /// Counts more events of a kind. Kinds that this version does not know come last.
    pub(crate) fn add(&mut self, kind: &str, count: usize) {
        match self.0.iter_mut().find(|(name, _)| name == kind) {
            Some((_, sum)) => *sum += count,
            None => self.0.push((kind.to_string(), count)),
        }
    }

    /// The number of events of all kinds.
    pub fn total(&self) -> usize {
        self.0.iter().map(|(_, count)| count).sum()
    }

    /// Those that are not zero, in words: `3 limit impacts, 1 stick`.
    pub fn words(&self) -> String {
        let happened = self.0.iter().filter(|(_, count)| *count > 0);
        let words: Vec<String> = happened
            .map(|(name, count)| match KINDS.iter().find(|(known, ..)| known == name) {
                Some((_, one, several)) => counted(*count, one, several),
                None => format!("{count} {name}"),
            })
            .collect();
        if words.is_empty() { "none".to_string() } else { words.join(", ") }
    }
}

/// One event.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EventEntry {
    /// When (s).
    pub time: f64,
    /// The kind of the event.
    pub kind: String,
    /// The joint of the event, or the two names `a|b` of a contact.
    pub what: String,
    /// The impulse of an impact along the joint, positive into the allowed range [N m s or N s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impulse: Option<f64>,
}

impl EventEntry {
    /// An event of a run of this model.
    pub(crate) fn new(model: &Model, event: &Event) -> Self {
        EventEntry {
            time: event.time,
            kind: event.kind.name().to_string(),
            what: event_name(model, event),
            impulse: event.impulse,
        }
    }
}

/// To what an event happened, as reports and logs name it: the pair `a|b` that touches, or else the joint of the body.
fn event_name(model: &Model, event: &Event) -> String {
    event.pair.map_or_else(|| joint_name(model, event.body).to_string(), |pair| pair_name(model, pair))
}

/// The name of the joint that carries a body, as reports and logs have it.
pub(crate) fn joint_name(model: &Model, body: usize) -> &str {
    let record = model.joints.iter().find(|record| record.body == Some(body));
    let of_mechanism = || model.mechanism.bodies.get(body).map_or("", |body| body.joint.name.as_str());
    record.map_or_else(of_mechanism, |record| record.name.as_str())
}

/// The events of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EventReport {
    /// How many there were of each kind.
    pub counts: KindCounts,
    /// The first thousand, in order of time.
    pub list: Vec<EventEntry>,
    /// Whether the mechanism has anything that can make events; otherwise the lines for people do not mention them.
    #[serde(skip)]
    pub is_nonsmooth: bool,
}

impl EventReport {
    /// The events of a run of this model.
    #[doc(hidden)]
    pub fn new(model: &Model, finished: &Finished) -> Self {
        EventReport {
            counts: KindCounts::new(&finished.summary.events),
            list: finished.events.iter().map(|event| EventEntry::new(model, event)).collect(),
            is_nonsmooth: !model.mechanism.nonsmooth.is_empty(),
        }
    }
}

/// The state of a joint at the end of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct JointStatusReport {
    /// The limit on which it rests: `lower` or `upper`.
    pub limit: Option<&'static str>,
    /// The state of its dry friction: `stuck` or `sliding`.
    pub friction: Option<&'static str>,
    /// The effort of its motor [N m or N].
    pub effort: Option<f64>,
}

impl From<&JointStatus> for JointStatusReport {
    fn from(status: &JointStatus) -> Self {
        JointStatusReport {
            limit: status.limit.map(|side| side.name()),
            friction: status.friction.map(|state| state.name()),
            effort: status.effort,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_every_kind_of_event_in_json_and_only_those_that_happened_in_words() {
        let mut counts = EventCounts::default();
        for kind in [EventKind::LimitImpact, EventKind::LimitImpact, EventKind::Stick] {
            counts.count(kind);
        }
        let mut report = KindCounts::new(&counts);
        let json = serde_json::to_string(&report).unwrap();
        assert_eq!(
            json,
            "{\"limit_impact\":2,\"contact_impact\":0,\"rest\":0,\"release\":0,\"stick\":1,\"slip\":0,\"reversal\":0,\
             \"saturation\":0,\"unsaturation\":0}"
        );
        assert_eq!((report.words().as_str(), report.total()), ("2 limit impacts, 1 stick", 3));
        assert_eq!(KindCounts::default().words(), "none");
        report.add("lightning", 2);
        assert_eq!((report.words().as_str(), report.total()), ("2 limit impacts, 1 stick, 2 lightning", 5));
    }

    #[test]
    fn an_event_without_an_impulse_has_no_such_key() {
        let entry = |impulse| EventEntry { time: 0.25, kind: "stick".to_string(), what: "hinge".to_string(), impulse };
        let json = |impulse| serde_json::to_string(&entry(impulse)).unwrap();
        assert_eq!(json(None), r#"{"time":0.25,"kind":"stick","what":"hinge"}"#);
        assert_eq!(json(Some(-1.5)), r#"{"time":0.25,"kind":"stick","what":"hinge","impulse":-1.5}"#);
    }
}
