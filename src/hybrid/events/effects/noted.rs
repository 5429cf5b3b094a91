//! The list of events at an instant: impacts, and the changes from one mode to the next.

use crate::events::effects::contacts::Contacts;
use crate::events::effects::decision::Scene;
use crate::events::effects::impact::Meeting;
use crate::events::effects::memory::{Done, Memory};
use crate::events::finding::watched::Watched;
use crate::events::modes::mode::{Closed, JointMode, Mode};
use crate::instant::cone::problem::Law;
use crate::instant::holding::blocks::Of;
use crate::instant::holding::elements::Elements;
use crate::instant::holding::per_pair::PerPair;
use crate::mechanism::description::nonsmooth::Motor;
use crate::mechanism::motion::event::{Event, EventKind, Side};
use std::collections::BTreeSet;

/// Rates and impulses along the first rows of the meetings.
pub(crate) struct Met<'m> {
    pub meetings: &'m [Meeting],
    /// Rates before [rad/s or m/s].
    pub rates: &'m [f64],
    /// N m s or N s.
    pub impulses: &'m [f64],
    /// Infinite sequences of impacts that end here, each with the time of its last impact (s). A contact is named by its pair.
    pub ends: &'m [(Of, f64)],
    /// The functions that are zero.
    pub stopped: &'m [Watched],
}

impl Met<'_> {
    fn end(&self, of: Of, time: f64) -> f64 {
        self.ends.iter().find(|(own, _)| *own == of).map_or(time, |(_, end)| *end)
    }
}

/// The side of a motor's bound that an effort is at or beyond: 1, −1, or 0 within it.
pub(crate) fn side_of_bound(motor: &Motor, effort: f64) -> i8 {
    let reached = effort.abs() >= motor.max_effort;
    if reached && effort > 0.0 { 1 } else { -i8::from(reached) }
}

/// Notes that a motor reaches its bound (±1) at an instant (s), or comes back from it (0); from one bound to the other is both.
pub(crate) fn note_bound(motor: &Motor, [was, is]: [i8; 2], time: f64, events: &mut Vec<Event>) {
    if was == is {
        return;
    }
    let kinds = [(was, EventKind::Unsaturation), (is, EventKind::Saturation)];
    let body = motor.coordinate.body;
    let at_bound = kinds.into_iter().filter(|(side, _)| *side != 0);
    events.extend(at_bound.map(|(_, kind)| Event { time, kind, body, pair: None, impulse: None }));
}

/// Notes the impacts of an instant (s).
pub(crate) fn note_impacts(
    scene: &Scene,
    memory: &mut Memory,
    time: f64,
    contacts: &Contacts,
    met: &Met,
    done: &mut Done,
) {
    let mut pairs: PerPair<(f64, f64)> = PerPair::default();
    for ((meeting, &rate), &impulse) in met.meetings.iter().zip(met.rates).zip(met.impulses) {
        // A joint that is held both ways has met no limit.
        let bilateral = matches!(meeting.block.law, Law::Interval { lower: f64::NEG_INFINITY, .. });
        if impulse <= 0.0 || bilateral {
            continue;
        }
        match meeting.block.of {
            Of::Joint(index) => {
                let joint = &scene.elements.joints[index];
                let lower = meeting.block.rows[0][joint.coordinate.freedom] > 0.0;
                let side = if lower { Side::Lower } else { Side::Upper };
                done.joints[index] = true;
                memory.remember(Of::Joint(index), side, time, -rate);
                let (kind, body) = (EventKind::LimitImpact, joint.owner(side));
                done.events.push(Event { time, kind, body, pair: None, impulse: Some(impulse) });
            }
            of @ (Of::Contact(_) | Of::Moment { .. }) => {
                let Some(pair) = contacts.pair_of(of) else { continue };
                let (sum, fastest) = pairs.of(pair);
                *sum += impulse;
                // Roundings are no approach.
                if -rate > meeting.rest {
                    *fastest = fastest.max(-rate);
                }
            }
        }
    }
    for (pair, &(sum, rate)) in pairs.iter().filter(|(_, (sum, _))| *sum > 0.0) {
        *done.pairs.of(pair) = true;
        // A pair at rest passes on the impulses of others.
        if rate > 0.0 {
            memory.remember(Of::Contact(pair), Side::Lower, time, rate);
            done.events.push(of_pair(scene, pair, time, EventKind::ContactImpact, Some(sum)));
        }
    }
}

/// Notes the impulses of contacts that jam, each of a pair (N s): impacts without a collision.
pub(crate) fn note_seized(scene: &Scene, time: f64, impulses: &[(usize, f64)], done: &mut Done) {
    let mut pairs: PerPair<f64> = PerPair::default();
    impulses.iter().for_each(|&(pair, impulse)| *pairs.of(pair) += impulse);
    for (pair, &impulse) in pairs.iter().filter(|(_, impulse)| **impulse > 0.0) {
        *done.pairs.of(pair) = true;
        done.events.push(of_pair(scene, pair, time, EventKind::ContactImpact, Some(impulse)));
    }
}

/// Notes which joints are held and let go.
pub fn note_joints(elements: &Elements, time: f64, [before, after]: [&Mode; 2], met: &Met, done: &mut Done) {
    for (index, joint) in elements.joints.iter().enumerate() {
        let (was, is) = (before.joints[index], after.joints[index]);
        let kind = match (was, is) {
            (JointMode::Free { .. }, JointMode::Held { on: Some(side) }) => {
                Some((EventKind::Rest, met.end(Of::Joint(index), time), joint.owner(side)))
            }
            (JointMode::Held { on: Some(side) }, JointMode::Free { .. }) => {
                Some((EventKind::Release, time, joint.owner(side)))
            }
            (JointMode::Free { .. }, JointMode::Held { on: None }) => {
                Some((EventKind::Stick, time, joint.coordinate.body))
            }
            (JointMode::Held { on: None }, JointMode::Free { .. }) => {
                Some((EventKind::Slip, time, joint.coordinate.body))
            }
            (JointMode::Free { sliding: from }, JointMode::Free { sliding: to }) if from * to < 0 => {
                let hit = met.meetings.iter().zip(met.impulses);
                let hit = hit.into_iter().any(|(met, impulse)| met.block.of == Of::Joint(index) && *impulse > 0.0);
                (!hit).then_some((EventKind::Reversal, time, joint.coordinate.body))
            }
            _ => None,
        };
        done.joints[index] |= was != is;
        if let Some((kind, time, body)) = kind {
            done.events.push(Event { time, kind, body, pair: None, impulse: None });
        }
    }
}

/// The mode of a pair.
#[derive(Clone, Copy, PartialEq)]
enum PairMode {
    Open,
    Slides,
    Sticks,
}

/// Notes which pairs close and part, stick and slide.
pub fn note_pairs(scene: &Scene, time: f64, [before, after]: [&Mode; 2], met: &Met, done: &mut Done) {
    let of = |mode: &Mode, pair: usize| {
        let own = mode.contacts.iter().filter(|closed| closed.contact.pair == pair);
        own.fold(PairMode::Open, |known, closed| match closed.slides {
            None => PairMode::Sticks,
            Some(_) if known == PairMode::Open => PairMode::Slides,
            Some(_) => known,
        })
    };
    // The others stay open.
    let closed = before.contacts.iter().chain(&after.contacts).map(|closed| closed.contact.pair);
    let seams = before.seams.iter().chain(&after.seams).map(|contact| contact.pair);
    for pair in closed.chain(seams).collect::<BTreeSet<usize>>() {
        let features = |mode: &Mode| {
            let own = mode.contacts.iter().filter(|closed| closed.contact.pair == pair);
            let seams = mode.seams.iter().filter(|contact| contact.pair == pair);
            own.map(|closed| (closed.contact.features, closed.slides.is_some(), closed.held_turns()))
                .chain(seams.map(|contact| (contact.features, false, [0; 2])))
                .collect::<Vec<_>>()
        };
        *done.pairs.of(pair) |= features(before) != features(after);
        let (was, is) = (of(before, pair), of(after, pair));
        let stops = |trigger: &Watched| match *trigger {
            Watched::Slips(contact) => before.contacts[contact].contact.pair == pair,
            Watched::SlipsTogether(of) => of == pair,
            _ => false,
        };
        let kind = match (was, is) {
            (PairMode::Open, PairMode::Slides | PairMode::Sticks) => Some(EventKind::Rest),
            (PairMode::Slides | PairMode::Sticks, PairMode::Open) => Some(EventKind::Release),
            (PairMode::Slides, PairMode::Sticks) => Some(EventKind::Stick),
            (PairMode::Sticks, PairMode::Slides) => Some(EventKind::Slip),
            (PairMode::Slides, PairMode::Slides) if met.stopped.iter().any(stops) => Some(EventKind::Reversal),
            _ => None,
        };
        let held = |mode: &Mode| {
            let own = mode.contacts.iter().filter(|closed| closed.contact.pair == pair);
            own.map(Closed::held_turns).fold([0, 0], |sum, held| [0, 1].map(|index: usize| sum[index] + held[index]))
        };
        let kind = kind.or_else(|| match (held(before), held(after)) {
            _ if was == PairMode::Open => None,
            ([rolls, spins], [now_rolls, now_spins]) if now_rolls > rolls || now_spins > spins => {
                Some(EventKind::Stick)
            }
            ([rolls, spins], [now_rolls, now_spins]) if now_rolls < rolls || now_spins < spins => Some(EventKind::Slip),
            _ => None,
        });
        if let Some(kind) = kind {
            let time = if kind == EventKind::Rest { met.end(Of::Contact(pair), time) } else { time };
            done.events.push(of_pair(scene, pair, time, kind, None));
        }
    }
}

/// An event of a pair.
fn of_pair(scene: &Scene, pair: usize, time: f64, kind: EventKind, impulse: Option<f64>) -> Event {
    let pair = &scene.touching.pairs[pair];
    let body = pair.bodies[1].or(pair.bodies[0]).unwrap_or_default();
    Event { time, kind, body, pair: Some(pair.number), impulse }
}
