//! The state from which a step goes on, and the forces that the kernel knows: a kernel begins anew where either has changed.

use crate::instants::inside::has_dampers;
use crate::length::outside::Outside;
use crate::length::stepper::Stepper;
use crate::watching::modes::Modes;
use crate::watching::watch::Watch;
use catena_lobatto::step::interface::Step;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::inputs::Inputs;
use catena_mechanism::motion::state::State;
use std::sync::Arc;

impl Stepper {
    /// Goes on with another kernel of the same scheme, which has no past.
    pub fn replace_kernel(&mut self, kernel: Box<dyn Step>) {
        self.kernel = kernel;
        self.left_at = None;
        self.met = false;
    }

    /// Whether the kernel knows all that acts now: it was made for this gravity and these forces, and for efforts if there are any.
    #[inline]
    pub fn knows(&self, mechanism: &Mechanism, inputs: Inputs) -> bool {
        let driven = mechanism.forces.driven || self.outside.driven.is_some() || inputs.is_none();
        driven && self.outside.is_that_of(mechanism)
    }

    /// Takes note of changed forces, and returns the mechanism for which a kernel is to be made.
    pub fn learn(&mut self, mechanism: &Mechanism, inputs: Inputs) -> Arc<Mechanism> {
        let was_driven = self.outside.driven.is_some();
        self.outside = Outside::new(mechanism);
        let mut now = mechanism.clone();
        if was_driven || !inputs.is_none() {
            now.forces.driven = true;
        }
        let now = Arc::new(now);
        if now.forces.driven && !mechanism.forces.driven {
            self.outside.driven = Some(now.clone());
        }
        self.watch = Watch::new(self.tableau, !now.is_unforced());
        self.damped = has_dampers(&now.forces);
        self.modes = Modes::new(&now);
        now
    }

    /// The mechanism as the kernel knows it, if that is not the one that the caller has.
    pub fn driven(&self) -> Option<Arc<Mechanism>> {
        self.outside.driven.clone()
    }

    /// Starts anew if the state is not the end of the last step; returns whether that was so.
    pub fn meet(&mut self, mechanism: &Mechanism, state: &State) -> bool {
        let met = std::mem::take(&mut self.met) && *state == self.end;
        let moved = !met && (self.left_at != Some(state.time) || *state != self.end);
        if moved {
            if let Some(counted) = self.counted.take() {
                self.kernel.expect_at(counted);
            }
            self.kernel.begin(mechanism, state);
            // A companion that has begun does not know the state to which the motion was moved.
            self.companion = self.companion.take().filter(|companion| !companion.has_begun());
            if let Some(companion) = &mut self.companion {
                companion.begin(self.kernel.as_mut(), mechanism, state);
            }
            self.watch.forget();
            self.modes.forget();
            (self.ahead, self.ahead_of_dampers) = (None, None);
            if let Some(known) = self.kernel.known() {
                self.modes.heed(known);
                self.ranks.hear(known.weak, mechanism, state.time);
            }
            self.look_at_dampers(mechanism, state);
        }
        moved
    }

    /// Meets a state before the step that goes on from there, which does not meet it again.
    pub fn meet_before(&mut self, mechanism: &Mechanism, state: &State) -> bool {
        let moved = self.meet(mechanism, state);
        self.end.copy_from(state);
        self.met = true;
        moved
    }
}
