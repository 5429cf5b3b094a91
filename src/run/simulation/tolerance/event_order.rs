//! Whether two runs of one motion meet the same events: the same kinds in the same order, for each joint and each pair of shapes.
//!
//! Instants differ by the errors of the runs, and so does the number of accumulating impacts: successive impacts of a joint count once while they
//! become weaker. The order of events of different joints is not compared, because independent islands have no common order.

use crate::mechanism::motion::event::{Event, EventKind};
use std::collections::BTreeMap;

/// When the first event happens that only one of the runs meets (s).
pub(crate) fn first_difference(one: &[Event], other: &[Event]) -> Option<f64> {
    let [one, other] = [one, other].map(by_joint);
    let nothing = Vec::new();
    let differences = one.keys().chain(other.keys()).filter_map(|body| {
        let [one, other] = [&one, &other].map(|of| of.get(body).unwrap_or(&nothing));
        let same = one.iter().zip(other).take_while(|(a, b)| a.kind == b.kind).count();
        let times = [one, other].into_iter().filter_map(|events| events.get(same)).map(|event| event.time);
        times.min_by(f64::total_cmp)
    });
    differences.min_by(f64::total_cmp)
}

/// The events of each joint and pair; successive impacts that become weaker count as one.
fn by_joint(events: &[Event]) -> BTreeMap<(usize, Option<usize>), Vec<Event>> {
    let mut joints: BTreeMap<(usize, Option<usize>), Vec<Event>> = BTreeMap::new();
    for event in events {
        let joint = joints.entry((event.body, event.pair)).or_default();
        match joint.last_mut() {
            Some(last) if last.kind == event.kind && is_impact(event.kind) && event.impulse < last.impulse => {
                last.impulse = event.impulse;
            }
            _ => joint.push(*event),
        }
    }
    joints
}

fn is_impact(kind: EventKind) -> bool {
    matches!(kind, EventKind::LimitImpact | EventKind::ContactImpact)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_are_the_same_whatever_their_number_of_accumulating_impacts_and_other_where_a_kind_is() {
        // Later impacts are weaker.
        let list = |events: &[(f64, EventKind, usize)]| -> Vec<Event> {
            let event = |&(time, kind, body)| Event { time, kind, body, pair: None, impulse: Some(2.0 - time) };
            events.iter().map(event).collect()
        };
        use EventKind::{LimitImpact, Rest, Slip, Stick};
        let one = list(&[(1.0, LimitImpact, 0), (1.1, Stick, 1), (1.2, LimitImpact, 0), (1.3, Rest, 0)]);
        let same = list(&[(1.0, LimitImpact, 0), (1.2999, Rest, 0), (1.1, Stick, 1)]);
        assert_eq!(first_difference(&one, &same), None);
        let longer = list(&[(1.0, LimitImpact, 0), (1.3, Rest, 0), (1.1, Stick, 1), (1.4, Slip, 1)]);
        assert_eq!(first_difference(&one, &longer), Some(1.4));
        let other = list(&[(1.0, LimitImpact, 0), (1.3, Slip, 0), (1.1, Stick, 1)]);
        assert_eq!(first_difference(&one, &other), Some(1.3));
    }
}
