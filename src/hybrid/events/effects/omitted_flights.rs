//! Blows that come while an element would still bounce in flights that are left out, too low to matter by themselves.
//!
//! ```text
//!     t < t∞:   the element is a little above its bound when the blow comes.
//!     v_A  one impact with the element on its bound          v_B  one without it, then one of everything, as the element is reached a moment later
//!     δv = max over probes |v_A − v_B|  [m/s]                the motion at t is in doubt by  Σ δv_k (t − t_k)  (m)
//! ```
//!
//! Simultaneous impacts are not continuous: which element is reached first decides their result, however low the flight is. The run takes v_A, and
//! the estimate of its error includes the doubt, unless a run that leaves out less refutes it.
//!
//! Source: Ch. Glocker, Set-Valued Force Laws, Springer 2001, chapter 9, on the sequence of simultaneous impacts.

use crate::events::effects::brakes::Brake;
use crate::events::effects::contacts::Contacts;
use crate::events::effects::decision::Scene;
use crate::events::effects::impact::{Meeting, collide};
use crate::events::effects::memory::Memory;
use crate::instant::holding::blocks::Of;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::distance::{distance, probes_of_bodies};
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use nalgebra::Vector3;

/// The numbers of the meetings at rest that would be in a flight which is left out.
fn in_flight(memory: &Memory, contacts: &Contacts, meetings: &[Meeting], velocity: &[f64], time: f64) -> Vec<usize> {
    let until = |of: Of| match (of, contacts.pair_of(of)) {
        (Of::Joint(joint), _) => memory.joints[joint].in_flight_until,
        (_, Some(pair)) => memory.pairs.get(pair).and_then(|known| known.in_flight_until),
        (Of::Contact(_) | Of::Moment { .. }, None) => None,
    };
    let rests = |meeting: &Meeting| meeting.rate(velocity).abs() <= meeting.rest;
    let flies = |meeting: &Meeting| until(meeting.block.of).is_some_and(|until| time < until) && rests(meeting);
    (0..meetings.len()).filter(|&index| flies(&meetings[index])).collect()
}

/// The largest difference that such elements make to the velocity of any body [m/s]: `before` is the velocity before the impact on all these meetings,
/// and `after` the state after it.
pub(crate) fn speed_in_doubt(
    scene: &mut Scene,
    memory: &Memory,
    contacts: &Contacts,
    (meetings, brakes): (&[Meeting], &[Brake]),
    before: &[f64],
    after: &State,
) -> f64 {
    let flying = in_flight(memory, contacts, meetings, before, after.time);
    if flying.is_empty() || before == after.velocity {
        return 0.0;
    }
    let others = meetings.iter().enumerate().filter(|(index, _)| !flying.contains(index));
    let others: Vec<Meeting> = others.map(|(_, meeting)| meeting.clone()).collect();
    let mut state = State { velocity: before.to_vec(), ..after.clone() };
    let solved = collide(scene, &mut state, &others, brakes).and_then(|_| collide(scene, &mut state, meetings, brakes));
    if solved.is_err() {
        return 0.0;
    }
    change_of_speed(scene, &state.velocity, after)
}

/// The largest difference between the velocities of any body [m/s] with the velocity `before` instead of its own in a state.
pub(crate) fn change_of_speed(scene: &Scene, before: &[f64], after: &State) -> f64 {
    let state = State { velocity: before.to_vec(), ..after.clone() };
    distance(&probe_velocities(scene.whole, &state), &probe_velocities(scene.whole, after))
}

/// The velocities of the probes of all bodies [m/s]: a probe `x + ρ R e` has the velocity `v + ρ [ω]× R e`.
pub(crate) fn probe_velocities(mechanism: &Mechanism, state: &State) -> Vec<Vector3<f64>> {
    let mut rates: Vec<BodyState> = body_states(mechanism, state);
    for body in &mut rates {
        body.position = body.velocity;
        body.rotation = body.angular_velocity.cross_matrix() * body.rotation;
    }
    probes_of_bodies(mechanism, &rates)
}
