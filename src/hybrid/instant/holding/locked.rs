//! Joints that are locked for ever, and the mechanism without them.
//!
//! ```text
//!     lower_i ≤ q_i ≤ upper_i   of a joint and of all joints that follow it, written as bounds of its own position q        [rad or m]
//!     max lower_i = min upper_i = q*    ⟹    q = q*, q̇ = 0 for ever
//! ```
//!
//! Such a joint is no source of events. Its body is part of its parent, as if the joint were fixed ([`crate::instant::holding::held`]), so that
//! starts, impacts, accelerations and energies equal the results of the fixed joint. The state of the file still has its coordinate: q*, at rest.
//!
//! If each joint of a mechanism is locked, no body is left, and the mechanism stays as it is.

use crate::instant::holding::elements::Elements;
use crate::instant::holding::held::Held;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::event::{JointStatus, Side};
use crate::mechanism::motion::state::State;

/// A locked joint may be off its position by this much [rad or m]: the remaining error of closing loops.
const OFF: f64 = 1e-9;

/// A mechanism without its locked joints.
#[derive(Clone)]
pub struct Locked {
    held: Held,
    elements: Elements,
    /// Positions of the locked joints; zero displacement elsewhere.
    place: State,
}

impl Locked {
    /// The locked joints of a mechanism; `None` if no joint is locked, or each of them.
    pub fn of(whole: &Mechanism) -> Option<Self> {
        if whole.nonsmooth.limits.is_empty() {
            return None;
        }
        let elements = Elements::new(whole);
        let (is_held, place) = locked_joints(whole, &elements);
        if is_held.iter().all(|held| *held) || !is_held.contains(&true) {
            return None;
        }
        let held = Held::for_ever(whole, &place, is_held);
        Some(Locked { held, elements, place })
    }

    /// The same joints after other forces have begun to act.
    pub fn renew(&mut self, whole: &Mechanism) {
        self.held = Held::for_ever(whole, &self.place, self.held.is_held.clone());
    }

    /// The mechanism of the joints that are not locked.
    pub fn mechanism(&self) -> &Mechanism {
        &self.held.mechanism
    }

    /// The places of the bodies and coordinates of the whole in it.
    pub fn held(&self) -> &Held {
        &self.held
    }

    /// Takes over the state of the whole. Does not allocate.
    pub fn gather(&self, whole: &Mechanism, state: &State, own: &mut State) {
        own.time = state.time;
        self.held.gather_positions(whole, &state.position, &mut own.position);
        self.held.gather_positions(whole, &state.compensation, &mut own.compensation);
        self.held.gather_velocities(whole, &state.velocity, &mut own.velocity);
    }

    /// Writes the state of the whole: locked joints are in their places, at rest. Does not allocate.
    pub fn spread(&self, whole: &Mechanism, own: &State, state: &mut State) {
        self.held.spread(whole, own, state);
        self.place_locked(whole, &mut state.position);
        for slot in self.slots(whole) {
            state.compensation[slot] = 0.0;
        }
    }

    /// Puts the locked joints in their places.
    pub fn place_locked(&self, whole: &Mechanism, position: &mut [f64]) {
        for slot in self.slots(whole) {
            position[slot] = self.place.position[slot];
        }
    }

    /// The first locked joint, by its body, that a state does not have in its place, and by how much [rad or m].
    pub fn misplaced(&self, whole: &Mechanism, state: &State) -> Option<(usize, f64)> {
        let off = |body: usize| {
            let slot = whole.bodies[body].joint.position_index;
            (body, (state.position[slot] - self.place.position[slot]).abs())
        };
        self.bodies().map(off).find(|&(_, off)| off.is_nan() || off > OFF)
    }

    /// The bodies whose joints are locked.
    pub fn bodies(&self) -> impl Iterator<Item = usize> + '_ {
        self.held.is_held.iter().enumerate().filter(|(_, held)| **held).map(|(body, _)| body)
    }

    /// The status of the joint of a body, if it is locked.
    pub fn status(&self, whole: &Mechanism, state: &State, body: usize) -> Option<JointStatus> {
        if !self.held.is_held[body] {
            return None;
        }
        let of = self.elements.joints.iter().filter(|joint| joint.is_locked());
        let mut status = of.filter_map(|joint| joint.status(body, Some(joint.side(joint.position(state))))).next()?;
        let motor = whole.nonsmooth.motors.iter().find(|motor| motor.coordinate.body == body);
        status.effort = motor.map(|motor| {
            let at = motor.coordinate;
            // A sampled motor still has the effort of its last tick.
            let tick = if motor.period > 0.0 { motor.next_instant(state.time) - motor.period } else { state.time };
            motor.effort(tick, state.position[at.position], state.velocity[at.freedom])
        });
        Some(status)
    }

    /// The places of the locked joints among the positions: each has one.
    fn slots(&self, whole: &Mechanism) -> impl Iterator<Item = usize> {
        self.bodies().map(|body| whole.bodies[body].joint.position_index)
    }
}

/// For each body whether its joint is locked, and a state with these joints in their places.
fn locked_joints(whole: &Mechanism, elements: &Elements) -> (Vec<bool>, State) {
    let mut is_held = vec![false; whole.bodies.len()];
    let mut place = State::zero(whole);
    for joint in elements.joints.iter().filter(|joint| joint.leaves_one_position()) {
        for member in &joint.members {
            is_held[member.coordinate.body] = true;
        }
        joint.put_on(Side::Lower, &mut place);
    }
    (is_held, place)
}

/// The bodies whose joints are locked for ever.
pub fn locked_bodies(mechanism: &Mechanism) -> Vec<usize> {
    let (is_held, _) = locked_joints(mechanism, &Elements::new(mechanism));
    (0..is_held.len()).filter(|&body| is_held[body]).collect()
}
