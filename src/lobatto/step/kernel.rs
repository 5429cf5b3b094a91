//! One step of the constrained Lobatto IIIA–IIIB scheme (2.5.11), at the price of a recursion.
//!
//! ```text
//!     guess θ                                             predictor.rs
//!     repeat:  poses of all stages from θ                 stage.rs         g(Q_i) = 0 to rounding at every iterate
//!                                                         first.rs         in single precision at first
//!              forces F_k, if there are any               applied.rs
//!              residual ρ_k, factors of H(q_k)            residual.rs, pivot.rs, articulated.rs
//!              or ρ_k alone, with factors kept            chord.rs
//!              or all of it for one body in flight        tumbler.rs
//!              δ_i = Σ_k Â_ik α_k,  H(q_k) α_k = −ρ_k     sweeps.rs
//!              θ ← Anderson(θ, δ)                         anderson.rs
//!     until |δ| is small enough
//!     velocity from H(q̄) v̄ = Sᵀ p̄                        ending.rs        (2.5.11h)
//! ```
//!
//! With closed loops, and where this does not converge (stiff springs, hard dampers), the iteration is the exact Newton
//! method with all stages coupled ([`crate::coupled::newton`]), and velocities are projected on the loops ([`crate::coupled::projection`]).

use crate::coupled::closing::Closing;
use crate::coupled::newton::Newton;
use crate::coupled::projection::Projection;
use crate::coupled::space::Space;
use crate::coupled::system::One;
use crate::ending::velocities::Ending;
use crate::numbers::lanes::{Lanes, in_lanes};
use crate::numbers::reductions::{larger, largest_coefficient, worst_freedom};
use crate::solve::anderson::Anderson;
use crate::solve::iteration;
use crate::solve::iteration::{Coupling, Equations, Exact, Guarded, exact_at_first, exact_rule};
use crate::solve::kept_factors::Chord;
use crate::solve::single_precision::{FirstIterations, widened};
use crate::stages::attempt::{Attempt, Guess, REFINED_BELOW, StopRule};
use crate::stages::pose::{Turn, largest_of_turn};
use crate::stages::predictor::Predictor;
use crate::stages::start::Start;
use crate::stages::workspace::{Stages, furthest_turn};
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::description::rules::Rule;

/// [`Step`](crate::step::step::Step) with the lanes of `V`.
pub struct Kernel<V: Lanes> {
    pub(crate) stages: Stages<V>,
    pub(crate) anderson: Anderson<V>,
    pub(crate) chord: Chord,
    pub(crate) first: FirstIterations<V>,
    pub(crate) predictor: Predictor<V>,
    /// The exact Newton method, from when it is needed first.
    pub(crate) newton: Option<Box<Newton<V>>>,
    /// For how many more steps the exact Newton method comes first.
    pub(crate) exact_for: usize,
    /// Where there are closures.
    pub(crate) closing: Option<Closing<Space<One>>>,
    pub(crate) tableau: &'static Tableau,
    /// Row of the inverse Legendre matrix for the stages 2 … s.
    pub(crate) top_legendre: V,
    /// Its entry for stage 1.
    pub(crate) first_legendre: f64,
    /// Whether this step is iterated so far that the rounding of the coefficients counts.
    pub(crate) refined: bool,
    pub(crate) gravity: [f64; 3],
    pub(crate) ending: Ending<<V as Lanes>::One>,
    pub(crate) velocity: Vec<f64>,
    pub(crate) displaced: Vec<f64>,
    /// The end of the finished step.
    pub(crate) end: Start,
}

impl<V: Lanes> Kernel<V> {
    /// The workspace for a mechanism and a scheme; `kept` are the rules that leave nothing out.
    pub fn new(mechanism: &Mechanism, tableau: &'static Tableau, kept: &[Rule]) -> Self {
        let stages = Stages::new(mechanism, tableau, kept);
        let iterated = mechanism.velocity_count - stages.plan.known();
        let ending = Ending::new(&stages.plan, mechanism.velocity_count, tableau);
        Kernel {
            anderson: Anderson::new(iterated),
            chord: Chord::NEW,
            first: FirstIterations::new(),
            predictor: Predictor::new(iterated, stages.plan.balls(), tableau),
            stages,
            top_legendre: V::from_slice(&tableau.top_legendre[1..]),
            first_legendre: tableau.top_legendre[0],
            newton: None,
            exact_for: exact_at_first(mechanism),
            closing: mechanism.has_closures().then(|| Closing::new(mechanism, Projection::new(mechanism))),
            tableau,
            refined: false,
            gravity: mechanism.gravity.into(),
            ending,
            velocity: vec![0.0; mechanism.velocity_count],
            displaced: vec![0.0; mechanism.velocity_count],
            end: Start::with_units(mechanism),
        }
    }

    /// Solves the stage equations of a step of length `step` from the start and a guess. Here, because the compiler puts what an iteration
    /// calls in its place in the file of the equations alone: a pendulum takes 1.02 of the time otherwise.
    pub(crate) fn solve(&mut self, mechanism: &Mechanism, step: f64, rule: &StopRule, guess: Guess) -> Attempt {
        self.stages.step = step;
        self.refined = rule.increment < REFINED_BELOW;
        self.first.allow(rule);
        let attempt = iteration::attempt(self, mechanism, rule, guess);
        if matches!(attempt, Attempt::Failed { .. }) {
            self.first.fail();
        }
        attempt
    }
}

/// The simplified iteration, with Anderson's acceleration.
impl<V: Lanes> Equations for Kernel<V> {
    fn iterate(&mut self, settled: bool) -> f64 {
        let refines = self.refines();
        let stages = &mut self.stages;
        let gravity = &self.gravity;
        if let Some(increment) = self.first.iterate(stages, &mut self.chord, gravity) {
            return increment;
        }
        self.first.hand_over(stages);
        if stages.plan.tumbles {
            return if refines && settled {
                in_lanes!(V, stages.tumble::<true>(gravity).largest())
            } else {
                in_lanes!(V, stages.tumble::<false>(gravity).largest())
            };
        }
        in_lanes!(V, stages.sweep_poses());
        if stages.applied.is_some() {
            in_lanes!(V, stages.sweep_applied(false));
        }
        let keeps = self.chord.keeps();
        // Vectors that carry the general sweeps alone are not compiled with the others.
        if V::GENERAL_ALONE || stages.applied.is_some() {
            if keeps {
                in_lanes!(V, stages.sweep_forced_wrenches(gravity));
            } else {
                in_lanes!(V, stages.sweep_forced_residual(gravity));
            }
        } else {
            match (keeps, refines && settled) {
                // Increments that settle are small.
                (_, true) => in_lanes!(V, stages.sweep_wrenches::<true>(gravity)),
                (true, false) => in_lanes!(V, stages.sweep_wrenches::<false>(gravity)),
                (false, false) => in_lanes!(V, stages.sweep_residual(gravity)),
            }
        }
        let increment = in_lanes!(V, stages.sweep_increments().largest());
        self.chord.see(increment);
        increment
    }

    fn refines(&self) -> bool {
        self.refined && !self.stages.is_general()
    }

    fn advance(&mut self) -> f64 {
        let (anderson, stages) = (&mut self.anderson, &mut self.stages);
        let known = stages.plan.known();
        in_lanes!(V, anderson.advance(&mut stages.displacement[known..], &stages.increment[known..]).largest())
    }

    fn complete(&mut self) {
        let stages = &mut self.stages;
        in_lanes!(V, stages.advance());
    }

    /// The scheme represents a step by polynomials of the rotation matrices' entries, so that these count as well as the joint
    /// displacements: a steady spin is a straight line in joint coordinates and no polynomial at all in R⁹.
    fn legendre(&self) -> f64 {
        let (stages, top, start) = (&self.stages, self.top_legendre, self.first_legendre);
        in_lanes!(V, {
            // Loops, because closures over vectors are not inlined here.
            let mut largest = largest_coefficient(&stages.displacement[stages.plan.known()..], top);
            match self.first.latest() {
                Some(poses) => {
                    for pose in poses {
                        largest = larger(largest, largest_of_turn(&widened::<V>(pose), top, start));
                    }
                }
                None => {
                    for pose in &stages.poses {
                        largest = larger(largest, largest_of_turn(pose, top, start));
                    }
                }
            }
            largest
        })
    }

    fn joint_legendre(&self) -> f64 {
        let (stages, top) = (&self.stages, self.top_legendre);
        in_lanes!(V, largest_coefficient(&stages.displacement[stages.plan.known()..], top))
    }

    fn worst_freedom(&self) -> usize {
        worst_freedom(&self.stages.increment)
    }

    fn furthest_turn(&self) -> Turn {
        in_lanes!(V, furthest_turn(&self.stages))
    }
}

/// The exact Newton method takes the start and the length of the step from [`Kernel::stages`], and leaves the solution there.
impl<V: Lanes> Guarded for Kernel<V> {
    fn guess(&mut self, guess: Guess) {
        let (stages, predictor) = (&mut self.stages, &mut self.predictor);
        in_lanes!(V, predictor.guess(stages.unknowns(), guess));
    }

    fn restart(&mut self) {
        self.chord.restart();
        self.first.begin(&self.stages.start, self.stages.step);
        self.anderson.restart();
    }

    fn solve_exactly(&mut self, mechanism: &Mechanism, rule: &StopRule) -> Attempt {
        let newton = self.newton.get_or_insert_with(|| Box::new(Newton::new(mechanism, self.tableau)));
        if self.stages.plan.tumbles {
            in_lanes!(V, self.stages.place_tumbler(&self.gravity));
        }
        newton.begin(&self.stages);
        self.first.leave();
        iteration::solve(&mut Exact(self), &exact_rule(mechanism, rule))
    }

    fn exact_for(&mut self) -> &mut usize {
        &mut self.exact_for
    }
}

impl<V: Lanes> Coupling for Kernel<V> {
    fn couple(&mut self) -> f64 {
        let Kernel { stages, newton: Some(newton), gravity, .. } = self else { return f64::NAN };
        newton.take_geometry(stages);
        in_lanes!(V, newton.residual(stages, gravity));
        newton.solve(stages)
    }

    fn add_increments(&mut self) -> f64 {
        let stages = &mut self.stages;
        in_lanes!(V, stages.advance())
    }
}
