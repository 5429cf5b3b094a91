//! A second motion, computed in the steps of the run but without the errors that the iterations leave ([`Step::carry_on`]). The distance of the two
//! is the error that the run has made so far.
//!
//! The largest coefficient that the polynomials of a step omit is about `E`. A propagator `e^{−γ(h−t)}` takes its coefficient of the same degree to
//! the end of the step. Without dampers that is as small as `E` itself, and the error is of the size `E²`; a damper of the rate γ makes it
//!
//! ```text
//!     T = E κ(h γ) min(1, 15/(h γ)),     κ(z) = |Σ_j L_j (e^{−z(1 − c_j)} − e^{−z})|         (rad, m)
//! ```
//!
//! with the weights `L_j` of the top Legendre coefficient. If `e^{−hγ}` vanishes, the motion is the slow one behind the damper, and the fast part of
//! it has the size `1/(h γ)`.

use catena_lobatto::stages::attempt::Carrying;
use catena_lobatto::step::interface::Step;
use catena_lobatto::tableau::butcher::Tableau;
use catena_mechanism::description::forces::Forces;
use catena_mechanism::description::joint::FreeRotation;
use catena_mechanism::description::mechanism::{Body, Mechanism};
use catena_mechanism::motion::energy::Energy;
use catena_mechanism::motion::state::State;

/// The part of the distance of both motions that an iteration may leave.
const PART: f64 = 0.02;
/// Number of iterations after which an iteration may leave the larger part `REST`.
const MOST: usize = 2;
const REST: f64 = 0.05;
/// Increments may be left up to this part of the stop,
const OF_STOP: f64 = 1e-3;
/// and up to roundings (rad, m), where springs or dampers act.
const ROUNDINGS: f64 = 1e-15;
/// If h γ is above this, the fast motion at the start of a step has vanished at its end.
pub(super) const STOPPED: f64 = 15.0;
/// Steps of which E is above this part of the largest that is kept have a truncation that counts.
const TRUNCATED: f64 = 0.5;

/// The error at the end of a step consists of products of two coefficients that the polynomials leave out. There are n² such products for n degrees
/// of freedom, so the estimate grows like n² up to this n (`doc/decisions/004-error-estimated-along-the-run.md`).
const MANY_FREEDOMS: f64 = 8.0;

/// The companion: a second motion beside the motion of the run.
#[derive(Clone)]
pub struct Companion {
    state: State,
    /// Its state at the end of a finished step, if it went through it [with the run](Companion::finish).
    next: State,
    ahead: bool,
    /// The factor of the truncation error for few degrees of freedom, `min(1, n/8)²`.
    share: f64,
    begun: bool,
    /// Whether springs or dampers act.
    sprung: bool,
    /// The rate γ of the hardest damper [1/s].
    decay: f64,
    /// What an iteration may leave anyway (rad, m).
    least: f64,
    /// Truncation of the next step to be accepted (rad, m).
    truncation: f64,
    /// The weights of the stages 2 … s in a top Legendre coefficient, and room for the coefficients of each degree of freedom.
    top: &'static [f64],
    /// Where these stages are in the step.
    nodes: &'static [f64],
    coefficients: Vec<[f64; 2]>,
}

/// Whether any of these forces is a spring or a damper.
fn is_sprung(forces: &Forces) -> bool {
    let in_joints = !forces.joint_springs.is_empty() || !forces.joint_dampers.is_empty();
    in_joints || !forces.point_springs.is_empty() || !forces.drags.is_empty()
}

impl Companion {
    /// A companion that begins with the next step.
    pub(crate) fn new(mechanism: &Mechanism, tableau: &'static Tableau) -> Self {
        let freedoms = mechanism.velocity_count as f64 / MANY_FREEDOMS;
        Companion {
            state: State::zero(mechanism),
            next: State::zero(mechanism),
            ahead: false,
            share: freedoms.min(1.0).powi(2),
            begun: false,
            sprung: is_sprung(&mechanism.forces),
            decay: 0.0,
            least: ROUNDINGS,
            truncation: 0.0,
            top: &tableau.top_legendre[1..],
            nodes: &tableau.nodes[1..],
            coefficients: vec![[0.0; 2]; mechanism.velocity_count],
        }
    }

    /// Its state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Whether it goes along.
    pub(crate) fn has_begun(&self) -> bool {
        self.begun
    }

    /// Takes note of the rate at which the hardest damper stops something [1/s].
    pub(crate) fn brake(&mut self, decay: f64) {
        self.decay = decay;
    }

    /// Takes note of a step of `length` seconds that is solved: its E, the largest that would be, and the E that goes with the iteration `stop` (rad,
    /// m). The local error falls like E², which is chosen equal to the error of the stop ([`crate::length::control`]), but for dampers.
    pub(crate) fn see(&mut self, length: f64, legendre: f64, limit: f64, wanted: f64, stop: f64) {
        let counts = legendre > TRUNCATED * limit;
        let smooth = if counts { self.share * stop * (legendre / wanted).powi(2) } else { 0.0 };
        self.truncation = smooth.max(legendre * self.propagated(length * self.decay));
        self.least = (OF_STOP * stop).max(ROUNDINGS);
    }

    /// `κ(z) min(1, 15/z)`.
    fn propagated(&self, z: f64) -> f64 {
        if z <= 0.0 {
            return 0.0;
        }
        let weights = self.top.iter().zip(self.nodes);
        let top: f64 = weights.map(|(top, node)| top * ((z * (node - 1.0)).exp() - (-z).exp())).sum();
        top.abs() * (STOPPED / z).min(1.0)
    }

    /// Begins where the run begins.
    pub(crate) fn begin(&mut self, kernel: &mut dyn Step, mechanism: &Mechanism, state: &State) {
        self.begun = true;
        self.state.copy_from(state);
        kernel.begin_to_carry(mechanism, state);
    }

    /// Finishes the solved step of the run from `state` to `time` (s), of which `end` is to become the end, and goes through it, both at once;
    /// returns the energy at the end. `None`, without any effect, if the step cannot do that.
    pub(crate) fn finish(
        &mut self,
        kernel: &mut dyn Step,
        mechanism: &Mechanism,
        state: &State,
        end: &mut State,
        time: f64,
    ) -> Option<Energy> {
        let carrying = self.carrying(kernel, mechanism, state, false, time);
        self.next.copy_from(&self.state);
        let energy = kernel.finish_both(mechanism, end, &mut self.next, &carrying);
        self.next.time = time;
        self.ahead = energy.is_some();
        energy
    }

    /// Stays where it is: the run has finished a step alone.
    pub(crate) fn wait(&mut self) {
        self.ahead = false;
    }

    /// Goes through the finished step of the run from `state` to `time` (s), if it has not yet.
    pub(crate) fn follow(
        &mut self,
        kernel: &mut dyn Step,
        mechanism: &Mechanism,
        state: &State,
        exactly: bool,
        time: f64,
    ) {
        if std::mem::take(&mut self.ahead) {
            kernel.keep_carried();
            std::mem::swap(&mut self.state, &mut self.next);
            return;
        }
        let carrying = self.carrying(kernel, mechanism, state, exactly, time);
        kernel.carry_on(mechanism, &mut self.state, &carrying);
        self.state.time = time;
    }

    /// How it goes through the solved step of the run.
    fn carrying(
        &mut self,
        kernel: &dyn Step,
        mechanism: &Mechanism,
        state: &State,
        exactly: bool,
        time: f64,
    ) -> Carrying {
        let pairs = self.state.position.iter().zip(&state.position);
        let apart = pairs.map(|(own, other)| (own - other).abs()).fold(0.0, f64::max);
        let mut truncation = self.truncation;
        if truncation > 0.0 && !self.parts_further(kernel, mechanism, state, time - state.time) {
            truncation = 0.0;
        }
        Carrying {
            apart,
            part: PART,
            most: MOST,
            rest: REST,
            sprung: self.sprung,
            least: self.least,
            exactly,
            truncation,
        }
    }

    /// Whether the truncation, whose sign is unknown, takes the motions further apart over a step of `length` seconds. They part in the directions in
    /// which errors grow. If truncation brought them together there by chance, the estimate would lose the error.
    fn parts_further(&mut self, kernel: &dyn Step, mechanism: &Mechanism, state: &State, length: f64) -> bool {
        kernel.weigh_displacements([self.top, self.top], &mut self.coefficients);
        let mut along = 0.0;
        for Body { joint, .. } in &mechanism.bodies {
            let ball = joint.kind.rotation() == FreeRotation::Ball;
            let scalars = joint.kind.velocity_count() - if ball { 3 } else { 0 };
            for offset in 0..joint.kind.velocity_count() {
                let freedom = joint.velocity_index + offset;
                let mut apart = length * (self.state.velocity[freedom] - state.velocity[freedom]);
                // For ball joints the rates suffice.
                if offset < scalars {
                    let entry = joint.position_index + offset;
                    apart += self.state.position[entry] - state.position[entry];
                }
                along += self.coefficients[freedom][0] * apart;
            }
        }
        along >= 0.0
    }
}
