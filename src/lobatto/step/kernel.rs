//! One step of the constrained Lobatto IIIA–IIIB scheme (2.5.11), at the price of a recursion, in space or in a plane.
//!
//! ```text
//!     guess θ                                             predictor.rs
//!     repeat:  residual ρ_k and factors of H(q_k) at θ    spatial.rs, planar.rs
//!              δ_i = Σ_k Â_ik α_k,  H(q_k) α_k = −ρ_k
//!              θ ← Anderson(θ, δ)                         anderson.rs
//!     until |δ| is small enough                           iteration.rs
//!     velocity from H(q̄) v̄ = Sᵀ p̄                        kernel_step.rs     (2.5.11h)
//! ```
//!
//! with θ the displacements of the freedoms since the start of the step (rad, m) at the stages i = 2 … s, and ρ, H and α as in
//! [`crate::step::workspace`]. For closed loops, and for steps on which this does not converge (stiff springs, hard dampers), the iteration is the
//! exact Newton method with all stages coupled ([`crate::coupled::system`]), and velocities are projected on the loops
//! ([`crate::coupled::projection`]).

use crate::coupled::closing::Closing;
use crate::coupled::newton::{Newton, StageUnknowns};
use crate::coupled::projection::Projection;
use crate::coupled::system::One;
use crate::numbers::lanes::{Lanes, in_lanes};
use crate::numbers::reductions::{add_to, largest, largest_coefficient, worst_freedom};
use crate::solve::anderson::Anderson;
use crate::solve::iteration;
use crate::solve::iteration::{Coupling, Equations, Exact, Guarded, exact_at_first, exact_rule};
use crate::solve::kept_factors::Chord;
use crate::stages::attempt::{Attempt, Guess, REFINED_BELOW, StopRule};
use crate::stages::pose::Turn;
use crate::stages::predictor::Predictor;
use crate::step::carried::Carried;
use crate::step::workspace::Workspace;
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::Exchange;
use catena_mechanism::motion::state::State;

/// [`Step`](crate::step::interface::Step) with the lanes of `V`, over the equations of `W`.
#[derive(Clone)]
pub(crate) struct Kernel<V: Lanes, W: Workspace<V>> {
    pub(crate) workspace: W,
    pub(crate) anderson: Anderson<V>,
    pub(crate) chord: Chord,
    pub(crate) predictor: Predictor<V>,
    /// The exact Newton method, from when it is needed first.
    pub(crate) newton: Option<Box<Newton<V, W::Geometry<V>>>>,
    /// For how many more steps the exact Newton method comes first.
    pub(crate) exact_for: usize,
    /// Projections, if the mechanism has closures.
    pub(crate) closing: Option<Closing<W::Geometry<One>>>,
    pub(crate) tableau: &'static Tableau,
    /// Top row of the inverse Legendre matrix for the stages 2 … s.
    pub(crate) top_legendre: V,
    /// Whether this step is iterated so far that the rounding of the coefficients counts.
    pub(crate) refined: bool,
    pub(crate) velocity: Vec<f64>,
    pub(crate) displaced: Vec<f64>,
    /// Energy that dry friction of contacts took from the finished step, and the work of driven surfaces (J).
    pub(crate) at_contacts: Exchange,
    /// Work of the joints that are moved in time in the finished step (J).
    pub(crate) moving: f64,
    /// The time at the start of the step and its length (s), for motions in time.
    pub(crate) time: f64,
    pub(crate) length: f64,
    /// The motion carried beside the motion of the run.
    pub(crate) carried: Option<Box<Carried<V, W::Start>>>,
    /// The end of the finished step.
    pub(crate) end: W::Start,
}

impl<V: Lanes, W: Workspace<V>> Kernel<V, W> {
    /// The kernel for a mechanism and a scheme, of which the workspace is made.
    pub fn new(mechanism: &Mechanism, tableau: &'static Tableau, workspace: W) -> Self {
        let freedoms = mechanism.velocity_count;
        let iterated = freedoms - workspace.known();
        Kernel {
            anderson: Anderson::new(iterated),
            chord: Chord::NEW,
            predictor: Predictor::new(iterated, workspace.balls(), tableau),
            newton: None,
            exact_for: exact_at_first(mechanism),
            closing: mechanism.has_closures().then(|| {
                let geometry = workspace.geometry(mechanism, None);
                Closing::new(mechanism, Projection::of(mechanism, geometry, workspace.full_plan(mechanism)))
            }),
            tableau,
            top_legendre: V::from_slice(&tableau.top_legendre[1..]),
            refined: false,
            velocity: vec![0.0; freedoms],
            displaced: vec![0.0; freedoms],
            at_contacts: Exchange::default(),
            moving: 0.0,
            time: 0.0,
            length: 0.0,
            carried: None,
            end: W::new_start(mechanism),
            workspace,
        }
    }

    /// Number of lanes in use.
    pub(crate) fn active(&self) -> usize {
        self.tableau.stages - 1
    }

    /// Solves the stage equations of a step of length `step` from the start and a guess.
    pub(crate) fn solve(&mut self, mechanism: &Mechanism, step: f64, rule: &StopRule, guess: Guess) -> Attempt {
        self.workspace.set_step(step);
        self.length = step;
        self.workspace.begin_attempt(rule);
        self.refined = rule.increment < REFINED_BELOW;
        let attempt = iteration::attempt(self, mechanism, rule, guess);
        if matches!(attempt, Attempt::Failed { .. }) {
            self.workspace.end_failed();
        }
        attempt
    }
}

/// Moves a state by the displacements of a solved step, to the velocities there (2.5.11h), and takes it as the next start. `square` is the result of
/// [`Workspace::end_velocities`], which wrote `velocity` and completed the displacements.
pub(crate) fn land<V: Lanes, W: Workspace<V>>(
    workspace: &mut W,
    square: Option<f64>,
    displaced: &[f64],
    velocity: &mut [f64],
    mechanism: &Mechanism,
    state: &mut State,
    end: &mut W::Start,
) {
    state.displace(mechanism, displaced);
    state.velocity.copy_from_slice(velocity);
    workspace.set_end(end, mechanism, state);
    if let Some(square) = square
        && workspace.refine_velocities(end, square, velocity)
    {
        state.velocity.copy_from_slice(velocity);
        workspace.set_end(end, mechanism, state);
    }
}

/// The simplified iteration, with Anderson's acceleration.
impl<V: Lanes, W: Workspace<V>> Equations for Kernel<V, W> {
    fn iterate(&mut self, settled: bool) -> f64 {
        let refined = settled && self.refines();
        if let Some(increment) = self.workspace.iterate_specially(&mut self.chord, refined) {
            return increment;
        }
        let keeps = self.chord.keeps();
        let increment = self.workspace.iterate(keeps, refined);
        self.chord.see(increment);
        increment
    }

    fn refines(&self) -> bool {
        self.refined && !self.workspace.is_general()
    }

    fn advance(&mut self) -> f64 {
        let (anderson, known) = (&mut self.anderson, self.workspace.known());
        let (displacement, increment) = self.workspace.advanced();
        let largest = in_lanes!(V, anderson.advance(&mut displacement[known..], &increment[known..]).largest());
        self.workspace.bound(largest);
        largest
    }

    fn complete(&mut self) {
        self.add_increments();
    }

    fn slowest_slide(&self) -> f64 {
        let rubbing = self.newton.as_ref().and_then(|newton| newton.rubbing());
        rubbing.map_or(f64::INFINITY, |touching| touching.slowest_slide())
    }

    fn legendre(&self) -> f64 {
        self.workspace.legendre(self.top_legendre)
    }

    fn joint_legendre(&self) -> f64 {
        let (iterated, top) = (&self.workspace.displacement()[self.workspace.known()..], self.top_legendre);
        in_lanes!(V, largest_coefficient(iterated, top))
    }

    fn worst_freedom(&self) -> usize {
        worst_freedom(self.workspace.increment())
    }

    fn furthest_turn(&self) -> Turn {
        self.workspace.furthest_turn()
    }
}

impl<V: Lanes, W: Workspace<V>> Kernel<V, W> {
    /// Makes the exact Newton method, if it is not there yet.
    pub(crate) fn make_exact(&mut self, mechanism: &Mechanism) {
        let Kernel { workspace, newton, tableau, .. } = self;
        newton.get_or_insert_with(|| {
            let geometry = workspace.geometry(mechanism, Some(tableau));
            Box::new(Newton::new(mechanism, geometry, tableau))
        });
    }
}

impl<V: Lanes, W: Workspace<V>> Guarded for Kernel<V, W> {
    fn guess(&mut self, guess: Guess) {
        let Kernel { predictor, workspace, closing, .. } = self;
        let unknowns = workspace.unknowns();
        in_lanes!(V, predictor.guess(unknowns, guess));
        if let Some(closing) = closing {
            // Increments do not take back a displacement by the roundings of their velocities, and extrapolation multiplies it by some hundred a
            // step.
            let (displacement, _) = workspace.advanced();
            closing.known().locked_freedoms().for_each(|freedom| displacement[freedom] = V::zero());
        }
        if W::TAKES_BOUND {
            let displacement = workspace.displacement();
            let largest = in_lanes!(V, largest(displacement));
            workspace.bound(largest);
        }
    }

    fn restart(&mut self) {
        self.chord.restart();
        self.workspace.begin_iteration();
        self.anderson.restart();
    }

    fn solve_exactly(&mut self, mechanism: &Mechanism, rule: &StopRule) -> Attempt {
        self.make_exact(mechanism);
        let Kernel { workspace, newton: Some(newton), closing, time, .. } = self else {
            return Attempt::Failed { iterations: 0, freedom: 0, increment: f64::NAN };
        };
        workspace.begin_exactly();
        newton.clock(*time);
        let StageUnknowns { plan, start, .. } = workspace.stage_unknowns();
        newton.begin(plan, start, closing.as_ref().map(Closing::known));
        iteration::solve(&mut Exact(self), &exact_rule(mechanism, rule))
    }

    fn exact_for(&mut self) -> &mut usize {
        &mut self.exact_for
    }
}

/// The exact Newton method takes the start and the length of the step from [`Kernel::workspace`], and leaves the solution there.
impl<V: Lanes, W: Workspace<V>> Coupling for Kernel<V, W> {
    fn couple(&mut self) -> f64 {
        let Kernel { workspace, newton: Some(newton), .. } = self else { return f64::NAN };
        let (geometry, bias) = newton.bodies();
        workspace.place_stages(geometry, bias);
        newton.solve(workspace.stage_unknowns())
    }

    fn add_increments(&mut self) -> f64 {
        let (displacement, increment) = self.workspace.advanced();
        let largest = in_lanes!(V, add_to(displacement, increment));
        self.workspace.bound(largest);
        largest
    }
}
