//! Projections on the closures: of the velocities at the end of a step, and of states interpolated inside it.

use crate::coupled::counted::Counted;
use crate::coupled::deciding::known_of_steps;
use crate::coupled::known::Known;
use crate::coupled::projection::Projection;
use crate::coupled::system::{Geometry, One};
use crate::equations::braking::Lean;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::Exchange;
use catena_mechanism::motion::state::State;
use std::sync::Arc;

/// The projection of a kernel on its closures, and a state to work with.
#[derive(Clone)]
pub(crate) struct Closing<G: Geometry<One>> {
    projection: Projection<G>,
    start: G::Start,
    state: State,
    /// The ranks counted in a state from which steps may start.
    counted: Option<Arc<Counted>>,
}

impl<G: Geometry<One>> Closing<G> {
    /// Closures without counted ranks yet, with the projection for a mechanism.
    pub fn new(mechanism: &Mechanism, mut projection: Projection<G>) -> Self {
        projection.take_motions(true);
        Closing { projection, start: G::start(mechanism), state: State::zero(mechanism), counted: None }
    }

    /// Takes the ranks counted at the start of the next steps.
    pub fn expect(&mut self, counted: Arc<Counted>) {
        self.counted = Some(counted);
    }

    /// Determines the ranks of the closures in a state from which steps start ([`crate::coupled::deciding`]).
    pub fn begin(&mut self, mechanism: &Mechanism, state: &State) {
        let counted = self.counted.take().filter(|counted| counted.is_at(state));
        let counted = counted.unwrap_or_else(|| Arc::new(Counted::at(mechanism, state)));
        let known = known_of_steps(&counted, mechanism, &mut self.projection, &mut self.start);
        self.projection.heed(known);
        self.state.copy_from(state);
        self.projection.place(mechanism, &mut self.start, &self.state);
        self.projection.find_empty(&self.start);
    }

    /// The ranks and flags of the closures, with the equations that were empty where the latest step ended.
    pub fn known(&self) -> &Known {
        self.projection.known()
    }

    /// Takes the friction of contacts at the end of a step, for the projection of its velocities.
    pub fn lean(&mut self, leans: &[Lean]) {
        self.projection.lean(leans);
    }

    /// Projects the velocities at the end of a step, which `start` has taken; returns the energy that friction dissipates there, and the work
    /// of driven surfaces (J). Does not allocate.
    pub fn velocities(&mut self, mechanism: &Mechanism, start: &G::Start, velocity: &mut [f64]) -> Exchange {
        self.projection.velocities(mechanism, start, velocity);
        let exchanged = self.projection.exchanged();
        self.projection.lean(&[]);
        exchanged
    }

    /// Number of equations that the others imply, or nearly imply, at the end that was projected last, if that had to be solved for.
    pub fn weak(&self) -> Option<usize> {
        self.projection.weak()
    }

    /// Work of the joints that are moved in time at the end of the step that was projected last (J): their impulses times their rates.
    pub fn moving_work(&self, start: &G::Start) -> f64 {
        let impulses = &self.projection.impulses()[self.projection.mimic_rows()];
        impulses.iter().zip(G::mimic_rates(start)).map(|(impulse, rate)| impulse * rate).sum()
    }

    /// Brings positions and velocities that were interpolated at a time (s) back on the closures. Does not allocate.
    pub fn project(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        let Closing { projection, start, state, .. } = self;
        state.time = time;
        state.position.copy_from_slice(position);
        state.velocity.copy_from_slice(velocity);
        state.compensation.fill(0.0);
        projection.positions(mechanism, start, state);
        projection.place(mechanism, start, state);
        projection.velocities_here(mechanism, start, &mut state.velocity);
        position.copy_from_slice(&state.position);
        velocity.copy_from_slice(&state.velocity);
    }
}
