//! A second motion, computed in the steps of the run but without the errors that the iterations leave ([`Step::carry_on`]). The distance of the
//! two is the error that the run has made so far.

use catena_lobatto::stages::attempt::Carrying;
use catena_lobatto::step::interface::Step;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::state::State;

/// What an iteration may leave of what parts the motions,
const PART: f64 = 0.02;
/// and after so many of them it may leave more.
const MOST: usize = 2;
const REST: f64 = 0.05;
/// Steps of which E is above this part of the largest that is kept have a truncation that counts.
const TRUNCATED: f64 = 0.5;

/// The error at the end of a step consists of products of two coefficients that the polynomials leave out. There are n² such products for n degrees
/// of freedom, so the estimate grows like n² up to this n (`doc/findings/2026-11-24-honest-both-ways.md`).
const MANY_FREEDOMS: f64 = 8.0;

/// The motion beside that of the run.
pub struct Companion {
    state: State,
    /// The factor of the truncation error for few degrees of freedom, `min(1, n/8)²`.
    share: f64,
    begun: bool,
    /// Truncation of the next step to be accepted (rad, m).
    truncation: f64,
}

impl Companion {
    /// None so far: it begins with the next step.
    pub(crate) fn new(mechanism: &Mechanism) -> Self {
        let freedoms = mechanism.velocity_count as f64 / MANY_FREEDOMS;
        Companion { state: State::zero(mechanism), share: freedoms.min(1.0).powi(2), begun: false, truncation: 0.0 }
    }

    /// Where it is.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Whether it goes along.
    pub(crate) fn has_begun(&self) -> bool {
        self.begun
    }

    /// Takes note of a step that is going to be kept: its E, the largest that would be, and the E that goes with the iteration `stop` (rad, m). The local
    /// error falls like E², which is chosen to be that of the stop ([`crate::control`]).
    pub(crate) fn see(&mut self, legendre: f64, limit: f64, wanted: f64, stop: f64) {
        let counts = legendre > TRUNCATED * limit;
        self.truncation = if counts { self.share * stop * (legendre / wanted).powi(2) } else { 0.0 };
    }

    /// Begins where the run begins.
    pub(crate) fn begin(&mut self, kernel: &mut dyn Step, mechanism: &Mechanism, state: &State) {
        self.begun = true;
        self.state.copy_from(state);
        kernel.begin_to_carry(mechanism, state);
    }

    /// Goes through the finished step of the run from `state` to `time` (s).
    pub(crate) fn follow(
        &mut self,
        kernel: &mut dyn Step,
        mechanism: &Mechanism,
        state: &State,
        exactly: bool,
        time: f64,
    ) {
        let pairs = self.state.position.iter().zip(&state.position);
        let apart = pairs.map(|(own, other)| (own - other).abs()).fold(0.0, f64::max);
        let carrying = Carrying { apart, part: PART, most: MOST, rest: REST, exactly, truncation: self.truncation };
        kernel.carry_on(mechanism, &mut self.state, &carrying);
        self.state.time = time;
    }
}
