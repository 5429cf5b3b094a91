//! All limits and contacts that meet at an event, with the restitution that they have there: zero if impacts accumulate and end, or crowd.
//!
//! ```text
//!     left out in a crowd:   Σ ½ e² P |γ⁻|  (J)        P the plastic impulse (N s), γ⁻ the rate before [m/s]
//! ```

use crate::events::effects::contacts::Contacts;
use crate::events::effects::decision::Scene;
use crate::events::effects::impact::{Impulses, Meeting};
use crate::events::effects::memory::{Found, Memory};
use crate::events::effects::resting::energy;
use crate::instant::holding::blocks::{Block, Of};
use crate::instant::holding::elements::inward;
use crate::mechanism::motion::distance::size;
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::state::State;

/// Dry friction whose work over one radian or metre is this many times the energy of the scene holds a joint like a weld.
const UNMOVABLE: f64 = 1e3;

/// Everything that is met.
pub(crate) struct Gathered {
    /// Limits, then contacts.
    pub meetings: Vec<Meeting>,
    /// Impacts that end here, with the time of the last of infinitely many of them (s).
    pub ends: Vec<(Of, f64)>,
    /// The distance by which the omitted impacts would have moved bodies or joints (m or rad).
    pub left: f64,
}

/// Everything that is met: limits, then contacts; and which impacts end here.
pub(crate) fn gather_meetings(
    scene: &Scene,
    state: &State,
    memory: &mut Memory,
    found: &Found,
    rests: &[f64],
    contacts: &Contacts,
) -> Gathered {
    let (mut all, mut ends, mut left) = (Vec::new(), Vec::new(), 0.0);
    let crowded = memory.is_crowded(state.time);
    let mut most = None;
    for (index, joint) in scene.elements.joints.iter().enumerate() {
        let Some(side) = joint.side(joint.position(state)) else {
            let sticks = joint.friction > 0.0 && joint.rate(state) == 0.0;
            if sticks && joint.friction > *most.get_or_insert_with(|| most_borne(scene, state)) {
                let free = [f64::NEG_INFINITY, f64::INFINITY];
                let block = Block::of_joint(index, joint.coordinate.freedom, state.velocity.len(), 1.0, free);
                all.push(Meeting { block, restitution: 0.0, rest: rests[index] });
            }
            continue;
        };
        let (freedom, count) = (joint.coordinate.freedom, state.velocity.len());
        // A locked joint can be pushed both ways, and does not rebound.
        let least = if joint.is_locked() { f64::NEG_INFINITY } else { 0.0 };
        let block = Block::of_joint(index, freedom, count, inward(side), [least, f64::INFINITY]);
        let restitution = if crowded || joint.is_locked() { 0.0 } else { joint.restitution };
        let mut meeting = Meeting { block, restitution, rest: rests[index] };
        let rate = meeting.rate(&state.velocity);
        let known = &memory.joints[index];
        if rate < -meeting.rest
            && let Some((end, moves)) = known.accumulates(side, state.time, -rate, restitution, found.height)
        {
            left += moves;
            meeting.restitution = 0.0;
            ends.push((Of::Joint(index), end));
        }
        all.push(meeting);
    }
    let first = all.len();
    all.extend(contacts.meetings(scene, state, crowded));
    for (pair, known) in memory.pairs.iter() {
        let own = |meeting: &&mut Meeting| contacts.pair_of(meeting.block.of) == Some(pair);
        // Rates of what touches are roundings: a blow that passes through it does not end its impacts.
        let approaching = |meeting: &&mut Meeting| meeting.approaches(&state.velocity);
        let meeting = all[first..].iter_mut().filter(own).filter(approaching);
        let rate = meeting.map(|meeting| meeting.rate(&state.velocity)).fold(0.0_f64, f64::min);
        let restitution = scene.touching.pairs[pair].restitution;
        if rate < 0.0
            && let Some((end, moves)) = known.accumulates(Side::Lower, state.time, -rate, restitution, found.height)
        {
            // Friction shares its impulses among the flights.
            left += moves * (1.0 + scene.touching.pairs[pair].friction);
            all[first..].iter_mut().filter(own).for_each(|meeting| meeting.restitution = 0.0);
            ends.push((Of::Contact(pair), end));
        }
    }
    Gathered { meetings: all, ends, left }
}

/// The friction above which a joint at rest takes part in an impact as a fixed one [N m or N]. Over one radian or metre it takes [`UNMOVABLE`] times the kinetic
/// energy and the work of all weights over the size of the mechanism.
fn most_borne(scene: &Scene, state: &State) -> f64 {
    let weight = scene.whole.total_mass() * scene.whole.gravity.norm();
    UNMOVABLE * (energy(scene.whole, state).kinetic + weight * size(scene.whole, state))
}

/// Number of rebounds left out of an impact, in a crowd of impacts or of rounds of one, and their energy (J): `½ e² P |γ⁻|` each.
pub(crate) fn cut_in_crowd(
    scene: &Scene,
    memory: &mut Memory,
    time: f64,
    contacts: &Contacts,
    meetings: &[Meeting],
    rates: &[f64],
    impulses: &Impulses,
) -> (usize, f64) {
    let mut cut = (usize::from(impulses.cut > 0.0), impulses.cut);
    if !memory.is_crowded(time) {
        return cut;
    }
    for ((meeting, rate), impulse) in meetings.iter().zip(rates).zip(&impulses.normal) {
        let restitution = match (meeting.block.of, contacts.pair_of(meeting.block.of)) {
            (_, Some(pair)) => scene.touching.pairs[pair].restitution,
            (Of::Joint(joint), None) => scene.elements.joints[joint].restitution,
            (Of::Contact(_) | Of::Moment { .. }, None) => 0.0,
        };
        if *rate < -meeting.rest && restitution > 0.0 && *impulse > 0.0 {
            cut = (cut.0 + 1, cut.1 - 0.5 * restitution.powi(2) * impulse * rate);
        }
    }
    cut
}
