//! Steps of a mechanism without its locked joints. The caller sees the coordinates of the whole mechanism only.
//!
//! ```text
//!     Mechanism ─ instant/holding/locked.rs ─▶ Mechanism without locked joints
//!     State ─ gather ─▶ own State ── step ──▶ own State ─ spread ─▶ State
//! ```

use crate::events::Eventful;
use crate::instant::holding::locked::Locked;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::event::{Event, JointStatus};
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Cost, Integrator, MethodDescription, StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::simulation::method::narrowed_inputs::NarrowedInputs;
use crate::simulation::method::run_steps::RunSteps;
use crate::stepping::step_maker::{StepFigures, StepMaker};

/// An integrator of the joints that are not locked.
pub(crate) struct WithoutLocked {
    locked: Locked,
    inside: Box<dyn RunSteps>,
    /// The mechanism of the last step, with its locked joints.
    whole: Mechanism,
    own: State,
    inputs: NarrowedInputs,
    /// Room for dense output.
    position: Vec<f64>,
    velocity: Vec<f64>,
}

impl WithoutLocked {
    /// Steps of `inside`, which was made for the mechanism of [`Locked::mechanism`].
    pub fn new(whole: &Mechanism, locked: Locked, inside: Box<dyn RunSteps>) -> Self {
        let own = State::zero(locked.mechanism());
        WithoutLocked {
            inputs: NarrowedInputs::new(whole, locked.held()),
            position: own.position.clone(),
            velocity: own.velocity.clone(),
            own,
            inside,
            whole: whole.clone(),
            locked,
        }
    }

    /// The number of a motor of the whole among the motors of joints that are not locked; `None` if its joint is locked.
    fn motor(&self, motor: usize) -> Option<usize> {
        let moves = |at: &usize| !self.locked.held().is_held[self.whole.nonsmooth.motors[*at].coordinate.body];
        (motor < self.whole.nonsmooth.motors.len() && moves(&motor)).then(|| (0..motor).filter(moves).count())
    }
}

impl Integrator for WithoutLocked {
    fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        if self.whole.gravity != mechanism.gravity || !self.whole.forces.are_those_of(&mechanism.forces) {
            self.whole = mechanism.clone();
            self.locked.renew(mechanism);
        }
        let WithoutLocked { locked, inside, own, .. } = self;
        if let Some((body, by)) = locked.misplaced(mechanism, state) {
            let joint = mechanism.bodies[body].joint.name.clone();
            return Err(StepError::OutsideLimit { time: state.time, joint, by });
        }
        locked.gather(mechanism, state, own);
        let step = |inputs: Inputs| inside.step(locked.mechanism(), inputs, own, until);
        let outcome = self.inputs.within(mechanism, locked.held(), inputs, state, step)?;
        locked.spread(mechanism, own, state);
        Ok(outcome)
    }

    fn dense(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        let WithoutLocked { locked, inside, position: own_position, velocity: own_velocity, .. } = self;
        inside.dense(locked.mechanism(), time, own_position, own_velocity);
        locked.held().spread_positions(mechanism, own_position, position);
        locked.held().spread_velocities(mechanism, own_velocity, velocity);
        locked.place_locked(mechanism, position);
    }

    fn begins_again(&self) -> bool {
        self.inside.begins_again()
    }

    fn take_abandoned(&mut self) -> Cost {
        self.inside.take_abandoned()
    }

    fn description(&self) -> MethodDescription {
        self.inside.description()
    }

    fn take_events(&mut self, events: &mut Vec<Event>) {
        let first = events.len();
        self.inside.take_events(events);
        events[first..].iter_mut().for_each(|event| event.body = self.locked.held().head(event.body));
    }

    fn joint_status(&self, mechanism: &Mechanism, state: &State, body: usize) -> JointStatus {
        match self.locked.held().headed_by(body) {
            Some(own) => {
                let mut asked = self.own.clone();
                self.locked.gather(mechanism, state, &mut asked);
                self.inside.joint_status(self.locked.mechanism(), &asked, own)
            }
            None => self.locked.status(mechanism, state, body).unwrap_or_default(),
        }
    }

    fn contacts(&self, mechanism: &Mechanism, state: &State, out: &mut Vec<ContactPoint>) {
        let mut asked = self.own.clone();
        self.locked.gather(mechanism, state, &mut asked);
        self.inside.contacts(self.locked.mechanism(), &asked, out);
    }

    fn held_efforts(&self, inside: bool, out: &mut Vec<Option<f64>>) {
        let mut own = Vec::new();
        self.inside.held_efforts(inside, &mut own);
        let moves = (0..self.whole.nonsmooth.motors.len()).map(|motor| self.motor(motor));
        out.extend(moves.map(|motor| motor.and_then(|motor| own.get(motor).copied().flatten())));
    }
}

impl StepMaker for WithoutLocked {
    fn figures(&self) -> StepFigures {
        self.inside.figures()
    }

    fn accompany(&mut self, mechanism: &Mechanism) -> bool {
        !mechanism.has_closures() && self.inside.accompany(self.locked.mechanism())
    }

    fn leave_companion(&mut self) {
        self.inside.leave_companion();
    }

    fn place_companion(&self, state: &mut State) -> bool {
        let mut own = self.own.clone();
        self.locked.gather(&self.whole, state, &mut own);
        let is_placed = self.inside.place_companion(&mut own);
        if is_placed {
            self.locked.spread(&self.whole, &own, state);
        }
        is_placed
    }
}

impl RunSteps for WithoutLocked {
    fn duplicate(&self) -> Box<dyn RunSteps> {
        let WithoutLocked { locked, inside, whole, own, inputs, position, velocity } = self;
        Box::new(WithoutLocked {
            locked: locked.clone(),
            inside: inside.duplicate(),
            whole: whole.clone(),
            own: own.clone(),
            inputs: inputs.clone(),
            position: position.clone(),
            velocity: velocity.clone(),
        })
    }

    fn events(&self) -> Option<&Eventful> {
        self.inside.events()
    }

    fn events_mut(&mut self) -> Option<&mut Eventful> {
        self.inside.events_mut()
    }

    fn aim(&mut self, motor: usize, value: f64) {
        if let Some(own) = self.motor(motor) {
            self.inside.aim(own, value);
        }
    }
}
