//! The state kept from event to event: impacts that follow each other ever faster, and crowds of events.
//!
//! Infinitely many impacts with flights `T_k` and a ratio ρ of two speeds end at `t∞ = t_k + T_k ρ/(1 − ρ)`.

use crate::events::effects::impact::Meeting;
use crate::events::finding::watched::Watched;
use crate::instant::holding::blocks::Of;
use crate::instant::holding::per_pair::PerPair;
use crate::instant::holding::touching::Contact;
use crate::mechanism::motion::event::{Event, Side};

/// Impacts within [`CROWD_TIME`] that end in one without restitution.
const CROWD: usize = 100;
/// s.
const CROWD_TIME: f64 = 1e-4;
/// Impacts of one limit in a row before they are taken for the beginning of infinitely many.
const IN_A_ROW: usize = 3;

/// The memory of a joint or a pair from event to event.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ImpactMemory {
    /// The largest rate of a joint at an end of a step [rad/s or m/s].
    pub fastest: f64,
    /// The last impact: its bound, when (s), and the rate before.
    last: Option<(Side, f64, f64)>,
    /// Impacts on that bound in a row that have become weaker.
    in_a_row: usize,
    /// When they end.
    ends: Option<Ends>,
    /// The end of the last of the flights that were left out (s).
    pub in_flight_until: Option<f64>,
}

/// Predicted end of an infinite sequence of weakening impacts (s).
#[derive(Clone, Copy, Debug)]
struct Ends {
    best: f64,
    last: f64,
    /// How far the best was from the one before it.
    apart: f64,
}

/// The memory of the run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Memory {
    pub joints: Vec<ImpactMemory>,
    pub pairs: PerPair<ImpactMemory>,
    /// The largest speed of any body at an end of a step [m/s].
    pub fastest: f64,
    /// The largest kinetic energy at an end of a step, in scenes where shapes may touch (J).
    pub kinetic: f64,
    /// Impacts since the last quiet time, and when that was (s).
    crowd: (usize, f64),
}

/// An event as it is found.
pub(crate) struct Found<'f> {
    /// The functions that are zero.
    pub triggers: &'f [Watched],
    /// The greatest height that may be left when impacts accumulate (rad or m).
    pub height: f64,
    /// Whether contacts are looked for everywhere: at the start of a run.
    pub anew: bool,
    /// Whether a slip falls straight to its stop within the shortest step from the state on.
    pub brief: bool,
}

/// The effects of an event.
#[derive(Clone, Debug, Default)]
pub(crate) struct Done {
    pub events: Vec<Event>,
    /// Energy lost in impacts, and the work of driven surfaces in them (J).
    pub lost: f64,
    pub driven: f64,
    /// Number of rebounds that were left out, and the energy that they would have given back (J).
    pub cut: (usize, f64),
    /// The distance by which that can move bodies or joints if impacts accumulate (m or rad).
    pub left: f64,
    /// The velocity that a blow may have changed otherwise, because elements would still bounce in flights that were left out [m/s].
    pub speed_in_doubt: f64,
    /// The same, because the law of impact could not be solved to its accuracy.
    pub speed_of_unsolved: f64,
    /// Which joints, motors and pairs have changed or begin from zero.
    pub joints: Vec<bool>,
    pub motors: Vec<bool>,
    pub pairs: PerPair<bool>,
    /// The limits and contacts that met, and the contacts by their numbers.
    pub meetings: Vec<Meeting>,
    pub contacts: Vec<Contact>,
    /// Number of laws that could not be solved to their accuracy.
    pub unsolved: usize,
    /// What cannot be kept apart, because joints are moved in time; a contact is named by its pair.
    pub blocked: Option<Of>,
    /// Whether the contacts that touch could not be decided at all: no mode follows in which the scheme can go on.
    pub undecided: bool,
}

impl Memory {
    /// The memory at the start of a run with this number of joints.
    pub fn new(joints: usize) -> Self {
        Memory {
            joints: vec![ImpactMemory::default(); joints],
            pairs: PerPair::default(),
            fastest: 0.0,
            kinetic: 0.0,
            crowd: (0, f64::NEG_INFINITY),
        }
    }

    pub(crate) fn is_crowded(&mut self, time: f64) -> bool {
        if time - self.crowd.1 > CROWD_TIME {
            self.crowd = (0, time);
        }
        self.crowd.0 > CROWD
    }

    /// One more impact, of a joint or of a pair.
    pub(crate) fn remember(&mut self, of: Of, side: Side, time: f64, rate: f64) {
        self.crowd.0 += 1;
        let known = match of {
            Of::Joint(joint) => &mut self.joints[joint],
            Of::Contact(pair) | Of::Moment { contact: pair, .. } => self.pairs.of(pair),
        };
        let weaker = known.last.is_some_and(|(before, _, faster)| before == side && rate < faster);
        known.in_a_row = if weaker { known.in_a_row + 1 } else { 0 };
        known.ends = known.predicted(time, rate).filter(|_| weaker);
        known.last = Some((side, time, rate));
        known.in_flight_until = None;
    }

    /// Elements whose flights from now on are left out, each with the end of the last one (s). A contact is named by its pair.
    pub(crate) fn omit_flights(&mut self, flights: &[(Of, f64)]) {
        for &(of, until) in flights {
            let known = match of {
                Of::Joint(joint) => &mut self.joints[joint],
                Of::Contact(pair) | Of::Moment { contact: pair, .. } => self.pairs.of(pair),
            };
            known.in_flight_until = Some(until);
        }
    }
}

impl ImpactMemory {
    /// Whether the flight since the last impact, which ends at this time (s) with this rate, was no higher than a gap (rad or m): `γ T/4`.
    pub(crate) fn is_low(&self, time: f64, rate: f64, gap: f64) -> bool {
        self.last.is_some_and(|(_, last, _)| time > last && 0.25 * rate * (time - last) <= gap)
    }

    /// Predicted end of an infinite sequence of impacts, the last one at this time (s) with this rate: the best prediction so far, and the last.
    /// Early impacts know less of the later ratios, and late ones less of their flight times; two consecutive predictions that agree most are the
    /// best.
    fn predicted(&self, time: f64, rate: f64) -> Option<Ends> {
        let (_, last, faster) = self.last?;
        let ratio = rate / faster;
        let now = time + (time - last) * ratio / (1.0 - ratio);
        now.is_finite().then_some(match self.ends {
            Some(Ends { best, last, apart }) if (now - last).abs() >= apart => Ends { best, last: now, apart },
            Some(Ends { last, .. }) => Ends { best: now, last: now, apart: (now - last).abs() },
            None => Ends { best: now, last: now, apart: f64::INFINITY },
        })
    }

    /// The end of an infinite sequence of impacts that includes this one (s), if the remaining flights are too low to matter, and the distance that
    /// they would cover together (m or rad): each flight as high as `γ⁺²/(2 g)`, less by ρ² than the one before.
    pub(crate) fn accumulates(
        &self,
        side: Side,
        time: f64,
        rate: f64,
        restitution: f64,
        height: f64,
    ) -> Option<(f64, f64)> {
        let (before, last, faster) = self.last?;
        let flight = time - last;
        // A limit may be met without speed in a blow on another one: the impact after it is not weaker.
        if before != side || self.in_a_row < IN_A_ROW || rate >= faster || restitution == 0.0 || flight <= 0.0 {
            return None;
        }
        let rebound = restitution * rate;
        // In the flight that would follow, as in the last one.
        let acceleration = (restitution * faster + rate) / flight;
        let ends = self.predicted(time, rate).filter(|_| rebound * rebound <= 2.0 * acceleration * height)?;
        let first = rebound * rebound / (2.0 * acceleration);
        let ratio = rate / faster;
        Some((ends.best, first / (1.0 - ratio * ratio)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_impact_after_one_without_speed_keeps_its_restitution() {
        let mut memory = Memory::new(1);
        // Each bounce takes half as long as the one before, so that all end at 2 s.
        for (time, rate) in [(0.0, 1.0), (1.0, 0.5), (1.5, 0.25), (1.75, 0.125)] {
            memory.remember(Of::Joint(0), Side::Lower, time, rate);
        }
        let accumulates =
            |memory: &Memory, time, rate| memory.joints[0].accumulates(Side::Lower, time, rate, 0.5, 1.0).is_some();
        assert!(accumulates(&memory, 1.875, 0.0625));
        // A blow on another limit reaches this one while the joint rests on it: v⁻ = 0, written with a minus.
        memory.remember(Of::Joint(0), Side::Lower, 1.875, -0.0);
        assert!(!accumulates(&memory, 1.9, 0.1));
    }
}
