//! The equations of a step as a [`Kernel`](crate::step::kernel::Kernel) sees them: the trait that the workspaces in space
//! ([`crate::step::spatial`]) and in a plane ([`crate::step::planar`]) implement.
//!
//! The displacements of the freedoms at the stages i = 2 … s are `θ_i` (rad, m), the residuals `ρ_k`, and `H(q_k)` is kept as factors:
//!
//! ```text
//!     simplified iteration      δ_i = Σ_k Â_ik α_k,   H(q_k) α_k = −ρ_k          [`Workspace::iterate`]
//!     exact Newton method       all rows k and stages i at once                  [`Workspace::place_stages`]
//!     velocities at the end     H(q̄) v̄ = Sᵀ p̄                                    [`Workspace::end_velocities`]    (2.5.11h)
//! ```
//!
//! The methods with a body of their own here are for features of space alone: freedoms that need no iteration, ball joints, iterations in single
//! precision, a body in free flight, the refinement of velocities. Their default bodies are exact for a mechanism without these.

use crate::coupled::newton::StageUnknowns;
use crate::coupled::system::{Geometry, Screw};
use crate::numbers::lanes::Lanes;
use crate::solve::kept_factors::Chord;
use crate::stages::attempt::StopRule;
use crate::stages::forces::Applied;
use crate::stages::pose::Turn;
use crate::stages::unknowns::Unknowns;
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::body_state::BodyState;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::energy::Energy;
use catena_mechanism::motion::state::State;

/// The workspace of a step: all data that has lanes.
pub(crate) trait Workspace<V: Lanes>: Clone + Send + Sync + 'static {
    /// Constants of the mechanism.
    type Plan: Clone + Send + Sync;
    /// Quantities of the equations at the known state.
    type Start: Clone + Send + Sync;
    /// Bodies and closures at all stages, for the exact Newton method, and at one configuration, for projections on the closures.
    type Geometry<L: Lanes>: Geometry<L, Plan = Self::Plan, Start = Self::Start> + Clone + Send + Sync;

    /// Room for the start of a step.
    fn new_start(mechanism: &Mechanism) -> Self::Start;
    /// Energy at a start (J).
    fn energy(start: &Self::Start) -> Energy;
    /// The bodies at a start, where they are placed in space.
    fn bodies(_start: &Self::Start) -> Option<&[BodyState]> {
        None
    }
    /// The constants, with the simplification rules disabled.
    fn full_plan(&self, mechanism: &Mechanism) -> Self::Plan;
    /// The bodies and closures: at all stages of a scheme, with the lines of springs, or without it at one configuration.
    fn geometry<L: Lanes>(&self, mechanism: &Mechanism, tableau: Option<&Tableau>) -> Self::Geometry<L>;

    /// The start of the step.
    fn start(&self) -> &Self::Start;
    /// The same, to be exchanged.
    fn start_mut(&mut self) -> &mut Self::Start;
    /// Takes a state as the start of the next step, and forgets the motion before.
    fn begin(&mut self, mechanism: &Mechanism, state: &State);
    /// Takes the state at the end of a step as a start.
    fn set_end(&self, end: &mut Self::Start, mechanism: &Mechanism, state: &State);

    /// Displacements of all freedoms since the start at the stages 2 … s (rad, m).
    fn displacement(&self) -> &[V];
    /// Their latest increments (rad, m).
    fn increment(&self) -> &[V];
    /// Both, to be advanced.
    fn advanced(&mut self) -> (&mut [V], &[V]);
    /// The freedoms that are iterated, from which the predictor guesses and learns.
    fn unknowns(&mut self) -> Unknowns<'_, V>;
    /// Number of freedoms, the first ones, that need no iteration.
    fn known(&self) -> usize {
        0
    }
    /// The first rotation of every ball joint, counted from the first freedom that is iterated.
    fn balls(&self) -> Vec<usize> {
        Vec::new()
    }
    /// The forces besides gravity, if there are any.
    fn applied(&self) -> Option<&Applied<V>>;
    /// The same, to be driven.
    fn applied_mut(&mut self) -> Option<&mut Applied<V>>;
    /// Whether [`Workspace::bound`] says anything new.
    const TAKES_BOUND: bool = false;
    /// The largest displacement of the iterate (rad, m) is at most this.
    fn bound(&mut self, _largest: f64) {}

    /// Makes room for iterations in single precision, if steps with increments down to `stop` (rad, m) have any.
    fn prepare_single(&mut self, _mechanism: &Mechanism, _tableau: &Tableau, _stop: f64) {}
    /// Takes the length of the step (s).
    fn set_step(&mut self, step: f64);
    /// An attempt begins, of which this rule ends the iteration.
    fn begin_attempt(&mut self, _rule: &StopRule) {}
    /// The attempt has not converged.
    fn end_failed(&mut self) {}
    /// The iteration begins.
    fn begin_iteration(&mut self) {}
    /// All iterations that follow in this attempt are in double precision.
    fn leave_single(&mut self) {}

    /// Whether the last iteration of a finished step has left factors that the next may keep.
    fn has_factors(&self) -> bool {
        true
    }

    /// Whether the most general sweeps are taken, which have both halves of the coefficients' digits.
    fn is_general(&self) -> bool;
    /// An iteration of another kind than [`Workspace::iterate`], if it is the turn of one: finds the increments, returns the largest.
    fn iterate_specially(&mut self, _chord: &mut Chord, _refined: bool) -> Option<f64> {
        None
    }
    /// The simplified iteration from the displacements at hand: finds the increments, returns the largest; with the factors of the last
    /// one if it `keeps` them, `refined` with both halves of the coefficients' digits.
    fn iterate(&mut self, keeps: bool, refined: bool) -> f64;
    /// The exact Newton method follows, from the displacements at hand.
    fn begin_exactly(&mut self) {}
    /// Places the bodies at the present displacements, and writes their residuals there, for the exact Newton method.
    fn place_stages(&mut self, geometry: &mut Self::Geometry<V>, bias: &mut [Screw<V>]);
    /// The unknowns of that method, after [`Workspace::place_stages`].
    fn stage_unknowns(&mut self) -> StageUnknowns<'_, V, Self::Geometry<V>>;

    /// E of the iterate: the largest top Legendre coefficient of the displacements, for which `top` has the weights, and of the bodies'
    /// rotation matrices. The scheme represents a step by polynomials of these, too: a steady spin is a straight line in joint
    /// coordinates and no polynomial at all in R⁹.
    fn legendre(&self, top: V) -> f64;
    /// The joint that has turned furthest since the start.
    fn furthest_turn(&self) -> Turn;

    /// The velocities at the end of the solved step (2.5.11h); returns their square `v̄ᵀ H v̄` where rounding may have taken digits of them
    /// that [`Workspace::refine_velocities`] brings back.
    fn end_velocities(&mut self, refined: bool, velocity: &mut [f64]) -> Option<f64>;
    /// Refines these velocities, of which this is the square, if they need it, with the start that `end` has taken of them; whether
    /// they have changed.
    fn refine_velocities(&mut self, _end: &Self::Start, _square: f64, _velocity: &mut [f64]) -> bool {
        false
    }

    /// Makes room for the ends of two motions at once ([`crate::ending::two_motions`]); whether there is any.
    fn prepare_two(&mut self, _mechanism: &Mechanism) -> bool {
        false
    }
    /// Writes down the inputs of the end of this motion from the solved step.
    fn record_end(&mut self, _refined: bool, _motion: usize) {}
    /// The velocities of both motions at the ends that were written down, and their squares; the second began at `beside`.
    fn two_velocities(&mut self, _beside: &Self::Start, _velocities: [&mut [f64]; 2]) -> [f64; 2] {
        [f64::NAN; 2]
    }
    /// [`Workspace::set_end`] of both.
    fn set_two_ends(&mut self, _ends: [&mut Self::Start; 2], _mechanism: &Mechanism, _states: [&State; 2]) {}
    /// The next step of both begins at these ends, or at others.
    fn accept_two(&mut self, _ends: bool) {}
    /// Whether velocities of this square have to be [refined](Workspace::refine_velocities) at this end.
    fn lacks_digits(&self, _end: &Self::Start, _square: f64) -> bool {
        false
    }
}
