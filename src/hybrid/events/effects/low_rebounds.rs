//! Rebounds that are too low to matter, and are left out after an impact.
//!
//! ```text
//!     left out:  γ⁺ > 0  with  (γ⁺)² ≤ 2 |a| · height           γ⁺ rate after the impact [m/s or rad/s], a acceleration under what pushes then
//!     ends:      t + 2 γ⁺/(|a| (1 − e))                         the last of the flights that would follow (s)
//! ```
//!
//! A contact without restitution that is kicked open, as of a can that rocks, may fly lower than the gap at which its shapes count as closed
//! ([`crate::events::modes::tolerances::AT_EVENT`]). Its impact is then late by up to that gap, and it gains the energy of that fall in each round. So after
//! one such flight the height is at least this gap.
//!
//! The impulses of all such flights and of the rest after them have the sum that an impact without restitution and the rest have, and so does their
//! friction. So a contact that slides is stopped by a pull along the impulse that it had, `n + P_T/P_N`, or along `n − μ t` if it was only kicked open. That takes
//! back the friction of its rebound, with restitution and without:
//!
//! ```text
//!     v⁺⁺ = v⁺ + Y W_Pᵀ x,     W_N Y W_Pᵀ x = −γ⁺            x ≤ 0 pulls (N s); rows of W_P are n + P_T/P_N or n − μ t of what slides, and n of what does not
//! ```
//!
//! What an impact with restitution has kicked open elsewhere is not stopped where that would take far more than the energy `Σ γ²/(2 D_ii)` of the rebounds, each
//! alone. A ball that rolls from one face of a mesh to the next leaves the first at a millimetre per second, and cannot be held by both: that would stop it.
//! Nor is what is not pulled back, with restitution or without: no flights bring it to rest. A link that turns over two points of its hull, 2e-6 m apart,
//! leaves the first at 5e-6 m/s, and would be stopped by 1000 N s.

use crate::events::effects::after_dampers::after_dampers;
use crate::events::effects::brakes::Brake;
use crate::events::effects::contacts::Contacts;
use crate::events::effects::decision::Scene;
use crate::events::effects::impact::{GAIN, Impulses, Meeting, collide};
use crate::events::effects::memory::Memory;
use crate::events::effects::resting::{bring_rows_to_rest, energy};
use crate::events::modes::tolerances::AT_EVENT;
use crate::instant::cone::bounded::minimise;
use crate::instant::cone::problem::Law;
use crate::instant::holding::blocks::{Of, Row, Rows};
use crate::instant::holding::touching::Touching;
use crate::mechanism::motion::state::State;
use nalgebra::DVector;

/// Rounds in which what kicks others open is brought to rest.
const CALMING: usize = 8;
/// Singular values below this part of the largest mobility are zero: points of a face imply each other.
const SINGULAR: f64 = 1e-11;

/// A stop takes more than the energies of the rebounds by this factor at most; points of one body that land together take a few times as much.
const MORE: f64 = 100.0;

/// A meeting that leaves too slowly to matter.
pub(crate) struct Low {
    /// Its number.
    pub index: usize,
    /// When the last of its flights would end (s): `t + 2 γ/(a (1 − e))`.
    pub until: f64,
    /// The height of the first one (m or rad).
    pub height: f64,
    /// Whether it is pulled back.
    returns: bool,
}

/// The gap at which the shapes of a pair count as closed (m), if it has no restitution and its last flight, which ends at this time (s), was too low to be
/// seen: the next flights are as low. Rebounds accumulate instead, with a ratio that is known. `rates` are those before the impacts [m/s or rad/s].
pub(crate) fn unseen_flight(
    (touching, memory, contacts): (&Touching, &Memory, &Contacts),
    meetings: &[Meeting],
    rates: &[f64],
    time: f64,
    pair: usize,
) -> Option<f64> {
    let of = &touching.pairs[pair];
    let (gap, last) = (of.within(AT_EVENT), memory.pairs.get(pair)?);
    let own = meetings.iter().zip(rates).filter(|(meeting, _)| contacts.pair_of(meeting.block.of) == Some(pair));
    let fastest = own.map(|(_, rate)| -rate).fold(0.0, f64::max);
    (of.restitution == 0.0 && last.is_low(time, fastest, gap)).then_some(gap)
}

/// Meetings that leave too slowly to matter: `γ² ≤ 2 |a| · height` with the acceleration `a` that each has while the limits and contacts at rest
/// push, also once the transient in hard dampers is over ([`after_dampers`]). An element that is pulled back returns before it is higher than that; any
/// other leaves as well from rest. Elements that kick each other open without end come to rest in this way. An element that parted before the impacts, by its rate `before` [m/s or rad/s], is no rebound: a corner that
/// slides beyond a rim touches with an edge next, which leaves by the slip times the slope of the edge. A joint on its bound that parts by such a rate is
/// stopped if its flight is lower than a rounding of its position: no step would see it return, and the next one would carry it beyond the bound.
fn too_low(
    scene: &mut Scene,
    state: &State,
    meetings: &[Meeting],
    before: &[f64],
    efforts: &mut impl FnMut(&State) -> Vec<f64>,
    height: impl Fn(Of) -> f64,
) -> Vec<Low> {
    let is_rebound = |index: usize| {
        let meeting = &meetings[index];
        before[index] <= meeting.rest || (meeting.rate(&state.velocity) - before[index]).abs() > meeting.rest
    };
    let rounding = |index: usize| match meetings[index].block.of {
        Of::Joint(joint) => f64::EPSILON * scene.elements.joints[joint].position(state).abs(),
        Of::Contact(_) | Of::Moment { .. } => 0.0,
    };
    let leaves = |(index, meeting): (usize, &Meeting)| {
        (is_rebound(index) || rounding(index) > 0.0) && meeting.rate(&state.velocity) > meeting.rest
    };
    if !meetings.iter().enumerate().any(leaves) {
        return Vec::new();
    }
    let rests = meetings.iter().filter(|meeting| meeting.rate(&state.velocity).abs() <= meeting.rest);
    let rests: Vec<Row> = rests.map(|meeting| meeting.block.rows[0].clone()).collect();
    let free = pushed(scene, state, &efforts(state), &rests);
    let mut low = Vec::new();
    for (index, meeting) in meetings.iter().enumerate() {
        let (rate, gains) = (meeting.rate(&state.velocity), meeting.rate(&free));
        let pull = gains.abs();
        let most = if is_rebound(index) {
            height(meeting.block.of)
        } else if gains < 0.0 {
            rounding(index)
        } else {
            0.0
        };
        if rate > 0.0 && pull > 0.0 && rate * rate <= 2.0 * pull * most {
            if let Some(settled) = after_dampers(scene, state, &rests, 2.0 * rate / pull) {
                let (rate, free) =
                    (meeting.rate(&settled.velocity), pushed(scene, &settled, &efforts(&settled), &rests));
                if rate > meeting.rest && rate * rate > 2.0 * meeting.rate(&free).abs() * most {
                    continue;
                }
            }
            let until = state.time + 2.0 * rate / (pull * (1.0 - meeting.restitution));
            low.push(Low { index, until, height: rate * rate / (2.0 * pull), returns: gains < 0.0 });
        }
    }
    low
}

/// The accelerations in a state under these efforts, while resting limits and contacts push.
fn pushed(scene: &mut Scene, state: &State, efforts: &[f64], rests: &[Row]) -> Vec<f64> {
    let mut free = vec![0.0; state.velocity.len()];
    scene.response.accelerations(state, efforts, &mut free);
    if !rests.is_empty() {
        let rows = Rows::new(scene.response, state, rests.to_vec());
        let pushes = vec![(0.0, f64::INFINITY); rows.square.nrows()];
        rows.add(&minimise(&rows.square, &rows.rates(&free), &pushes).efforts, &mut free);
    }
    free
}

/// Brings to rest what leaves too slowly to matter after an impact on all meetings, which had these rates before, in rounds: what is stopped may kick others
/// open. `impulses` have the energies of all rounds afterwards; returns what has been stopped.
pub(crate) fn bring_low_to_rest(
    scene: &mut Scene,
    state: &mut State,
    (meetings, brakes): (&[Meeting], &[Brake]),
    impulses: &mut Impulses,
    before: &[f64],
    mut efforts: impl FnMut(&State) -> Vec<f64>,
    height: impl Fn(Of) -> f64,
) -> Vec<Low> {
    let mut all = Vec::new();
    for _ in 0..CALMING {
        let low = too_low(scene, state, meetings, before, &mut efforts, &height);
        let low = stop_unless_costly(scene, state, meetings, low, impulses);
        if low.is_empty() {
            break;
        }
        all.extend(low);
        let plastic: Vec<Meeting> =
            meetings.iter().map(|meeting| Meeting { restitution: 0.0, ..meeting.clone() }).collect();
        let Ok(more) = collide(scene, state, &plastic, brakes) else { break };
        impulses.lost += more.lost;
        impulses.driven += more.driven;
        impulses.slides += more.slides;
        for (sum, impulse) in impulses.normal.iter_mut().zip(more.normal) {
            *sum += impulse;
        }
    }
    all
}

/// Stops these. If some rebound or are not pulled back, and that takes far more than the energies of all, each alone, it stops only those that were struck,
/// or have no restitution and are pulled back; none if these are all. Returns what has been stopped.
fn stop_unless_costly(
    scene: &mut Scene,
    state: &mut State,
    meetings: &[Meeting],
    mut low: Vec<Low>,
    impulses: &mut Impulses,
) -> Vec<Low> {
    if low.is_empty() {
        return low;
    }
    let numbers = |low: &[Low]| low.iter().map(|low| low.index).collect::<Vec<usize>>();
    let accumulates = |low: &Low| low.returns && meetings[low.index].restitution == 0.0;
    let (all, was, had) = (numbers(&low), state.velocity.clone(), impulses.clone());
    let most = (!low.iter().all(accumulates)).then(|| MORE * energy_alone(scene, state, meetings, &all));
    stop(scene, state, meetings, &all, impulses);
    if most.is_none_or(|most| impulses.lost - had.lost <= most) {
        return low;
    }
    state.velocity = was;
    *impulses = had;
    low.retain(|low| accumulates(low) || impulses.normal[low.index] > 0.0);
    if low.len() == all.len() {
        return Vec::new();
    }
    if !low.is_empty() {
        stop(scene, state, meetings, &numbers(&low), impulses);
    }
    low
}

/// Σ γ²/(2 D_ii) of these meetings (J).
fn energy_alone(scene: &mut Scene, state: &State, meetings: &[Meeting], of: &[usize]) -> f64 {
    let first: Vec<Row> = of.iter().map(|&index| meetings[index].block.rows[0].clone()).collect();
    let rows = Rows::new(scene.response, state, first);
    let rates = rows.rates(&state.velocity);
    let mobilities = rows.square.diagonal();
    rates.iter().zip(mobilities.iter()).map(|(rate, mobility)| 0.5 * rate * rate / mobility).sum()
}

/// Stops these along their first rows, and keeps those that rest; adds the energies that this takes.
fn stop(scene: &mut Scene, state: &mut State, meetings: &[Meeting], low: &[usize], impulses: &mut Impulses) {
    let rests =
        |index: &usize| low.contains(index) || meetings[*index].rate(&state.velocity).abs() <= meetings[*index].rest;
    let stopped: Vec<usize> = (0..meetings.len()).filter(rests).collect();
    if !pull_back(scene, state, meetings, &stopped, impulses) {
        let first = stopped.iter().map(|&index| meetings[index].block.rows[0].clone()).collect();
        impulses.lost += bring_rows_to_rest(scene, state, first);
    }
    for index in stopped {
        if let Of::Joint(joint) = meetings[index].block.of {
            state.velocity[scene.elements.joints[joint].coordinate.freedom] = 0.0;
        }
    }
}

/// Stops these by pulls along their impulses if some of them slide; otherwise, or if such pulls would push or be larger than the impulses, as where friction
/// jams, the state stays as it is, and this is `false`.
fn pull_back(
    scene: &mut Scene,
    state: &mut State,
    meetings: &[Meeting],
    stopped: &[usize],
    impulses: &mut Impulses,
) -> bool {
    let slides: Vec<Option<Row>> = stopped.iter().map(|&index| sliding(meetings, index, impulses, state)).collect();
    if slides.iter().all(Option::is_none) {
        return false;
    }
    let first: Vec<Row> = stopped.iter().map(|&index| meetings[index].block.rows[0].clone()).collect();
    let along = slides.into_iter().zip(&first).map(|(slides, first)| slides.unwrap_or_else(|| first.clone()));
    let along = Rows::new(scene.response, state, along.collect());
    let rates = stopped.iter().map(|&index| -meetings[index].rate(&state.velocity));
    let square = along.responses(&first);
    let least = SINGULAR * square.amax();
    let Ok(pulls) = square.svd(true, true).solve(&DVector::from_iterator(first.len(), rates), least) else {
        return false;
    };
    let most: f64 = stopped.iter().map(|&index| impulses.normal[index]).sum();
    // NaN is no pull, either. Points that imply each other but for their friction would be stopped by pulls and pushes of any size.
    if !(-most..=0.0).contains(&pulls.sum()) || pulls.abs().sum() > most {
        return false;
    }
    let (kinetic, was) = (energy(scene.whole, state).kinetic, state.velocity.clone());
    along.add(pulls.as_slice(), &mut state.velocity);
    let driven = along.work_of_belts(pulls.as_slice());
    let lost = kinetic + driven - energy(scene.whole, state).kinetic;
    // A pull gives back what friction took in the impact, and no more.
    if impulses.lost + lost < -GAIN * kinetic {
        state.velocity = was;
        return false;
    }
    impulses.driven += driven;
    impulses.lost += lost;
    true
}

/// The direction of the impulse of a contact that slides after it, `n + P_T/P_N`; or `n − μ t` if it was kicked open, has none, and slides faster than it
/// leaves, so that the friction of its flights cannot stop it. `None` of others.
fn sliding(meetings: &[Meeting], index: usize, impulses: &Impulses, state: &State) -> Option<Row> {
    let Meeting { block, rest, .. } = &meetings[index];
    let start: usize = meetings[..index].iter().map(|meeting| meeting.block.rows.len()).sum();
    let &[normal, first, second] = impulses.rows.get(start..start + block.rows.len())? else { return None };
    let Law::Contact { friction } = block.law else { return None };
    let slip = [1, 2].map(|row: usize| block.rows[row].rate(&state.velocity));
    let speed = slip[0].hypot(slip[1]);
    let (along, least) = if normal > 0.0 {
        ([first / normal, second / normal], *rest)
    } else {
        let leaves = block.rows[0].rate(&state.velocity).abs();
        (slip.map(|slip| -friction * slip / speed), leaves.max(*rest))
    };
    (speed > least).then(|| Row::combined(&block.rows, &[1.0, along[0], along[1]]))
}
