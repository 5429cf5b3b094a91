//! What an event does: the state is put on it to the last bit, limits that are met give their impulses, and what is at rest is decided anew.
//!
//! ```text
//!     1. φ = 0 exactly: a position on its bound, a rate that is zero
//!     2. impacts on all limits that are met                                     impact.rs
//!     3. joints at rest: held or let go, all together                           decision.rs
//! ```
//!
//! An element whose impacts follow each other ever faster comes to rest at `t∞ = t_k + T_k/(1 − ρ)`, with the flight `T_k` that would follow and the ratio ρ
//! of two impacts. Where the greatest height that is left, `γ⁺²/(2 g)` with `g = 2 γ⁺/T`, is too small to matter, the impact is plastic.

use crate::events::decision::{Yielding, decide};
use crate::events::impact::{Row, collide};
use crate::events::mode::{JointMode, Mode, MotorMode};
use crate::events::watched::Watched;
use crate::instant::bounded::minimise;
use crate::instant::elements::{Elements, inward};
use crate::instant::response::Response;
use crate::mechanism::motion::event::{Event, EventKind, Side};
use crate::mechanism::motion::state::State;

/// Rates below this part of the fastest that a joint has had are zero.
const REST: f64 = 1e-12;
/// So are smaller ones than this [rad/s or m/s].
const SLOWEST: f64 = 1e-14;
/// So many impacts within [`CROWD_TIME`] end in one without restitution.
const CROWD: usize = 100;
/// Rounds in which limits that kick each other open are brought to rest.
const CALMING: usize = 8;
/// s.
const CROWD_TIME: f64 = 1e-4;
/// Impacts of one limit in a row before they are taken for the beginning of infinitely many.
const IN_A_ROW: usize = 3;

/// What is remembered of a joint from event to event.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JointMemory {
    /// The largest rate at an end of a step [rad/s or m/s].
    pub fastest: f64,
    /// The last impact: its bound, when (s), and the rate before.
    last: Option<(Side, f64, f64)>,
    /// Impacts on that bound in a row that have become weaker.
    in_a_row: usize,
}

/// What is remembered of the run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Memory {
    pub joints: Vec<JointMemory>,
    /// Impacts since the last quiet time, and when that was (s).
    crowd: (usize, f64),
}

/// An event as it is found.
pub(crate) struct Found<'f> {
    /// The functions that are zero.
    pub triggers: &'f [Watched],
    /// The greatest height that may be left when impacts accumulate (rad or m).
    pub height: f64,
}

/// What an event has done.
#[derive(Clone, Debug, Default)]
pub(crate) struct Done {
    pub events: Vec<Event>,
    /// Energy lost in impacts (J).
    pub lost: f64,
    /// Which joints and which motors have changed or begin from zero.
    pub joints: Vec<bool>,
    pub motors: Vec<bool>,
}

/// Carries out an event; `efforts` writes the efforts from outside and of motors for a mode and state.
pub(crate) fn transit(
    elements: &Elements,
    mode: &mut Mode,
    response: &mut Response,
    state: &mut State,
    memory: &mut Memory,
    found: &Found,
    mut efforts: impl FnMut(&Mode, &State) -> Vec<f64>,
) -> Done {
    let mut done = Done {
        joints: vec![false; elements.joints.len()],
        motors: vec![false; elements.motors.len()],
        ..Done::default()
    };
    let before = mode.clone();
    let time = state.time;
    let mut yielding = Yielding::default();
    for trigger in found.triggers {
        match *trigger {
            // It needs less than the least that can act: it goes forward.
            Watched::Bears(index, Side::Lower) => yielding.joints.push((index, 1)),
            Watched::Bears(index, Side::Upper) => yielding.joints.push((index, -1)),
            Watched::Margin => yielding.all = true,
            _ => {}
        }
    }
    settle(elements, mode, state, found.triggers, &mut done);
    let rests: Vec<f64> = memory.joints.iter().map(|joint| SLOWEST.max(REST * joint.fastest)).collect();
    for (joint, &rest) in elements.joints.iter().zip(&rests) {
        let rate = &mut state.velocity[joint.coordinate.freedom];
        if rate.abs() <= rest {
            *rate = 0.0;
        }
    }
    let (rows, ends) = rows(elements, state, memory, found, &rests);
    let rates: Vec<f64> = rows.iter().map(|row| row.inward * state.velocity[row.freedom]).collect();
    let mut impact = collide(response, state, &rows);
    done.lost = impact.lost;
    for _ in 0..CALMING {
        let known = efforts(mode, state);
        let low = too_low(response, state, &rows, &known, found.height);
        if low.is_empty() {
            break;
        }
        done.lost += stop(response, state, &rows, &low);
        let plastic: Vec<Row> = rows.iter().map(|row| Row { restitution: 0.0, ..*row }).collect();
        let more = collide(response, state, &plastic);
        done.lost += more.lost;
        for (sum, impulse) in impact.impulses.iter_mut().zip(more.impulses) {
            *sum += impulse;
        }
    }
    for (index, row) in rows.iter().enumerate() {
        if impact.impulses[index] <= 0.0 {
            continue;
        }
        let side = if row.inward > 0.0 { Side::Lower } else { Side::Upper };
        done.joints[row.joint] = true;
        memory.remember(row.joint, side, time, -rates[index]);
        let body = elements.joints[row.joint].owner(side);
        done.events.push(Event { time, kind: EventKind::LimitImpact, body, impulse: Some(impact.impulses[index]) });
    }
    for (joint, &rest) in elements.joints.iter().zip(&rests) {
        let rate = &mut state.velocity[joint.coordinate.freedom];
        if rate.abs() <= rest || joint.is_locked() {
            *rate = 0.0;
        }
    }
    let known = efforts(mode, state);
    decide(elements, mode, response, state, &known, &yielding);
    for index in 0..elements.joints.len() {
        let joint = &elements.joints[index];
        let (was, is) = (before.joints[index], mode.joints[index]);
        let end = ends.iter().find(|(joint, _)| *joint == index).map_or(time, |(_, end)| *end);
        let kind = match (was, is) {
            (JointMode::Free { .. }, JointMode::Held { on: Some(side) }) => {
                Some((EventKind::Rest, end, joint.owner(side)))
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
                let met = rows.iter().zip(&impact.impulses).any(|(row, impulse)| row.joint == index && *impulse > 0.0);
                (!met).then_some((EventKind::Reversal, time, joint.coordinate.body))
            }
            _ => None,
        };
        done.joints[index] |= was != is;
        if let Some((kind, time, body)) = kind {
            done.events.push(Event { time, kind, body, impulse: None });
        }
    }
    done
}

/// The rows that leave their limits so slowly that it does not matter: `γ² ≤ 2 |a| · height` with the acceleration `a` that they have freely. If they are
/// pulled back they would be back before they are higher than that, and if not they leave as well from rest. Where limits kick each other open
/// without end, that is how they come to rest.
fn too_low(response: &mut Response, state: &State, rows: &[Row], efforts: &[f64], height: f64) -> Vec<usize> {
    if !rows.iter().any(|row| row.inward * state.velocity[row.freedom] > row.rest) {
        return Vec::new();
    }
    let mut free = vec![0.0; state.velocity.len()];
    response.accelerations(state, efforts, &mut free);
    let low = |row: &Row| {
        let (rate, pull) = (row.inward * state.velocity[row.freedom], free[row.freedom].abs());
        rate > 0.0 && rate * rate <= 2.0 * pull * height
    };
    (0..rows.len()).filter(|&index| low(&rows[index])).collect()
}

/// Stops these rows, and keeps those that rest; returns the kinetic energy that this takes (J).
fn stop(response: &mut Response, state: &mut State, rows: &[Row], low: &[usize]) -> f64 {
    let rests = |index: &usize| low.contains(index) || state.velocity[rows[*index].freedom].abs() <= rows[*index].rest;
    let stopped: Vec<usize> = (0..rows.len()).filter(rests).collect();
    let freedoms: Vec<usize> = stopped.iter().map(|&index| rows[index].freedom).collect();
    let (columns, square) = response.matrix(state, &freedoms);
    let rates: Vec<f64> = freedoms.iter().map(|&freedom| state.velocity[freedom]).collect();
    let unbounded = vec![(f64::NEG_INFINITY, f64::INFINITY); rates.len()];
    let impulses = minimise(&square, &rates, &unbounded).efforts;
    let mut lost = 0.0;
    for (column, (&impulse, &rate)) in impulses.iter().zip(&rates).enumerate() {
        lost -= 0.5 * rate * impulse;
        for (freedom, rate) in state.velocity.iter_mut().enumerate() {
            *rate += columns[(freedom, column)] * impulse;
        }
    }
    freedoms.iter().for_each(|&freedom| state.velocity[freedom] = 0.0);
    lost
}

/// Puts the state on the event, and changes the motors that are at it.
fn settle(elements: &Elements, mode: &mut Mode, state: &mut State, triggers: &[Watched], done: &mut Done) {
    let time = state.time;
    for &trigger in triggers {
        match trigger {
            Watched::Gap(index, side) => {
                elements.joints[index].put_on(side, state);
                done.joints[index] = true;
            }
            Watched::Slide(index) => {
                state.velocity[elements.joints[index].coordinate.freedom] = 0.0;
                done.joints[index] = true;
            }
            Watched::Bears(index, _) => done.joints[index] = true,
            Watched::Margin => {
                for (joint, mode) in done.joints.iter_mut().zip(&mode.joints) {
                    *joint |= matches!(mode, JointMode::Held { .. });
                }
            }
            Watched::Motor(index, side) => {
                mode.motors[index] = MotorMode::Saturated(if side == Side::Upper { 1 } else { -1 });
                done.motors[index] = true;
                let body = elements.motors[index].coordinate.body;
                done.events.push(Event { time, kind: EventKind::Saturation, body, impulse: None });
            }
            Watched::Excess(index) => {
                mode.motors[index] = MotorMode::Unbounded;
                done.motors[index] = true;
                let body = elements.motors[index].coordinate.body;
                done.events.push(Event { time, kind: EventKind::Unsaturation, body, impulse: None });
            }
        }
    }
}

/// The rows of all limits that are met; and for joints whose impacts end here, when the last of infinitely many would be (s).
fn rows(
    elements: &Elements,
    state: &State,
    memory: &mut Memory,
    found: &Found,
    rests: &[f64],
) -> (Vec<Row>, Vec<(usize, f64)>) {
    let (mut rows, mut ends) = (Vec::new(), Vec::new());
    let crowded = memory.is_crowded(state.time);
    for (index, joint) in elements.joints.iter().enumerate() {
        let Some(side) = joint.side(joint.position(state)) else { continue };
        let (freedom, inward) = (joint.coordinate.freedom, inward(side));
        let rate = inward * state.velocity[freedom];
        let mut restitution = if crowded { 0.0 } else { joint.restitution };
        if rate < 0.0
            && let Some(end) = memory.joints[index].accumulates(side, state.time, -rate, restitution, found.height)
        {
            restitution = 0.0;
            ends.push((index, end));
        }
        rows.push(Row { joint: index, freedom, inward, restitution, rest: rests[index] });
    }
    (rows, ends)
}

impl Memory {
    /// Nothing has happened to so many joints.
    pub fn new(joints: usize) -> Self {
        Memory { joints: vec![JointMemory::default(); joints], crowd: (0, f64::NEG_INFINITY) }
    }

    fn is_crowded(&mut self, time: f64) -> bool {
        if time - self.crowd.1 > CROWD_TIME {
            self.crowd = (0, time);
        }
        self.crowd.0 > CROWD
    }

    fn remember(&mut self, joint: usize, side: Side, time: f64, rate: f64) {
        self.crowd.0 += 1;
        let joint = &mut self.joints[joint];
        let weaker = joint.last.is_some_and(|(before, _, faster)| before == side && rate < faster);
        joint.in_a_row = if weaker { joint.in_a_row + 1 } else { 0 };
        joint.last = Some((side, time, rate));
    }
}

impl JointMemory {
    /// When infinitely many impacts of which this is one would end, if too little is left of them to matter.
    fn accumulates(&self, side: Side, time: f64, rate: f64, restitution: f64, height: f64) -> Option<f64> {
        let (before, last, faster) = self.last?;
        let (ratio, flight) = (rate / faster, time - last);
        if before != side || self.in_a_row < IN_A_ROW || ratio >= 1.0 || restitution == 0.0 || flight <= 0.0 {
            return None;
        }
        let rebound = restitution * rate;
        // The flight that would follow, with the acceleration of the last one.
        let acceleration = (restitution * faster + rate) / flight;
        let next = flight * ratio;
        (rebound * rebound <= 2.0 * acceleration * height).then(|| time + next / (1.0 - ratio))
    }
}
