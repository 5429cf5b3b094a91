//! Looks at a step that is solved: stability, dampers, drag and samples inside it may ask for a shorter one.

use crate::instants::sampling::LastStep;
use crate::length::companion::STOPPED;
use crate::length::stepper::Stepper;
use crate::watching::pace::Pace;
use crate::watching::watch::FIRST_LOOK;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::state::State;

impl Stepper {
    /// The length (s) of a first step at a given pace in which hard dampers stop what they are about to stop at the start of a motion, if one of `length` seconds would
    /// let it ring. What moves less than the `tolerance` (m, rad) in a second may ring.
    pub fn settling_at_start(
        &mut self,
        mechanism: &Mechanism,
        state: &State,
        length: f64,
        tolerance: f64,
    ) -> Option<f64> {
        if !self.damped || !self.watch.listens() || self.watch.latest().is_some() {
            return None;
        }
        let transient = self.modes.transient(mechanism, state)?;
        if !self.watch.rings(transient, length) {
            return None;
        }
        self.watch.hear(transient, length, state.time);
        self.watch.take_settling(state.time, tolerance)
    }

    /// Looks at the fastest mode, and at what dampers are about to stop, in the state from which the first step of a motion begins, if it is time to
    /// look after that step: whoever begins from there again has looked already.
    pub fn look_ahead(&mut self, mechanism: &Mechanism, state: &State) {
        if self.ahead.is_none()
            && self.watch.latest().is_none()
            && let Some(iterations) = self.watch.is_due()
        {
            self.ahead = Some(self.modes.fastest(mechanism, state, iterations));
            self.ahead_of_dampers = Some(self.modes.transient(mechanism, state));
        }
    }

    /// The longest step that is safely stable (s), if the finished one of `length` seconds is beyond the limit, as far as is known when it is time to
    /// look: fast motions have grown in it.
    pub fn too_long_for_stability(&mut self, mechanism: &Mechanism, length: f64) -> Option<f64> {
        let iterations = self.watch.is_due()?;
        let mode = self.ahead.take().unwrap_or_else(|| self.modes.fastest(mechanism, &self.end, iterations));
        self.seen = Some(mode);
        self.watch.beyond_limit(mode, length)
    }

    /// The longest step from `state` beside the instants at which quadratic drag is not smooth (s), if the finished one of `length` seconds is longer;
    /// the iteration stops at increments of `stop` (rad, m).
    pub fn too_long_for_drag(&mut self, mechanism: &Mechanism, state: &State, length: f64, stop: f64) -> Option<f64> {
        let Stepper { kernel, tableau, end, inside, standstills, .. } = self;
        let last = LastStep { kernel: kernel.as_ref(), inner: tableau.stages - 1, origin: state, end, length };
        standstills.shorter(mechanism, [state, end], length, stop, |part, position, velocity| {
            inside.sample(mechanism, &last, part, position, velocity);
        })
    }

    /// Looks at the inside of the last step, of which the largest top Legendre coefficient is `legendre` (rad, m); returns the error of samples (m),
    /// where it is known.
    pub fn look_inside(&mut self, mechanism: &Mechanism, legendre: f64) -> Option<f64> {
        let Stepper { kernel, tableau, origin, end, inside, watch, length, .. } = self;
        let last = LastStep { kernel: kernel.as_ref(), inner: tableau.stages - 1, origin, end, length: *length };
        inside.look(mechanism, &last, self.damped && watch.is_too_hard(*length), legendre)
    }

    /// The largest error of samples in steps that were too long for a damper (m).
    pub fn ringing_inside(&self) -> f64 {
        self.inside.ringing()
    }

    /// The rates that hard dampers were about to stop at the start of the last step, as far as its end still has them, for a top Legendre coefficient of
    /// this size (rad, m): `15 E/h` [rad/s, m/s] if `h γ > 15`, and zero in shorter steps. Polynomials follow `e^{−γt}` in these alone.
    pub fn left_rate(&self, legendre: f64) -> f64 {
        if self.damped && self.length * self.watch.hardest() > STOPPED { legendre * STOPPED / self.length } else { 0.0 }
    }

    /// The rate at which the hardest damper of a tree stops something, as far as is known [1/s]. Zero with closures, which the exact method solves to 1e-10
    /// or less.
    pub fn decay(&self, mechanism: &Mechanism) -> f64 {
        if mechanism.has_closures() { 0.0 } else { self.watch.hardest() }
    }

    /// Whether dampers act, so that every step is looked at.
    pub fn is_damped(&self) -> bool {
        self.damped
    }

    /// Looks how near a step of this length is to the limit of stability, after a step that did not converge.
    pub fn look_after_failure(&mut self, mechanism: &Mechanism, state: &State, length: f64) {
        self.look(mechanism, state, FIRST_LOOK, length);
    }

    /// Tells the companion how hard the dampers are.
    pub(super) fn look_at_dampers(&mut self, mechanism: &Mechanism, state: &State) {
        if let Some(companion) = &mut self.companion
            && self.damped
        {
            companion.brake(self.modes.hardest_damper(mechanism, state, FIRST_LOOK));
        }
    }

    pub(super) fn look(&mut self, mechanism: &Mechanism, state: &State, iterations: usize, length: f64) {
        let Stepper { seen, modes, .. } = self;
        let mode = seen.take().unwrap_or_else(|| modes.fastest(mechanism, state, iterations));
        self.watch.see(mode, length, state.time);
        self.look_at_dampers(mechanism, state);
        let ahead = self.ahead_of_dampers.take();
        if self.watch.listens()
            && let Some(transient) = ahead.unwrap_or_else(|| self.modes.transient(mechanism, state))
        {
            self.watch.hear(transient, length, state.time);
        }
    }

    /// The pace of the motion at the end of the last step; `None` with forces and closures, which it does not know.
    pub fn pace(&mut self, mechanism: &Mechanism, state: &State) -> Option<Pace> {
        self.modes.pace(mechanism, state)
    }
}
