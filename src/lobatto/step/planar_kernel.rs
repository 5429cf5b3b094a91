//! A step of the scheme for mechanisms that move in a plane: three coordinates a body instead of six.
//!
//! The same scheme and the same iteration as in space ([`crate::step::kernel`]), with SO(2) embedded in R² where space has SO(3) in R⁹: what
//! it leaves out is zero there, so that both take the same steps, but for rounding. In reading order: [`start`], [`stage`],
//! [`articulated`], [`sweeps`], [`chord`], [`applied_plan`], [`applied`]; with closed loops, and where the recursion does not converge, the exact
//! Newton method with all stages coupled: [`newton`], [`coupled`], [`closure`].

use crate::coupled::closing::Closing;
use crate::coupled::projection::Projection;
use crate::coupled::system::One;
use crate::numbers::lanes::{Lanes, in_lanes};
use crate::numbers::reductions::{at_end, largest_coefficient, weigh, worst_freedom, write_ends};
use crate::planar::geometry::Flat;
use crate::planar::newton::PlanarNewton;
use crate::planar::start::{PlanarPlan, PlanarStart};
use crate::planar::workspace::PlanarStages;
use crate::solve::anderson::Anderson;
use crate::solve::iteration;
use crate::solve::iteration::{Coupling, Equations, Exact, Guarded, exact_at_first, exact_rule};
use crate::solve::kept_factors::Chord;
use crate::stages::attempt::{Attempt, Guess, REFINED_BELOW, StopRule};
use crate::stages::coefficients::Coefficients;
use crate::stages::momenta::MomentumWeights;
use crate::stages::pose::Turn;
use crate::stages::predictor::Predictor;
use crate::step::step::Step;
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::Exchange;
use catena_mechanism::motion::energy::Energy;
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::plane::Plane;

/// [`Step`] in a plane, with the lanes of `V`.
pub struct PlanarKernel<V: Lanes> {
    stages: PlanarStages<V>,
    coefficients: Coefficients<V>,
    weights: MomentumWeights<V>,
    anderson: Anderson<V>,
    chord: Chord,
    predictor: Predictor<V>,
    /// The exact Newton method, from when it is needed first.
    newton: Option<Box<PlanarNewton<V>>>,
    /// For how many more steps it comes first.
    exact_for: usize,
    /// Where there are closures.
    closing: Option<Closing<Flat<One>>>,
    plane: Plane,
    tableau: &'static Tableau,
    /// Row of the inverse Legendre matrix for the stages 2 … s.
    top_legendre: V,
    /// Whether this step is iterated so far that the rounding of the coefficients counts.
    refined: bool,
    velocity: Vec<f64>,
    displaced: Vec<f64>,
    /// The end of the finished step.
    end: PlanarStart,
}

impl<V: Lanes> PlanarKernel<V> {
    /// The workspace for a mechanism in its plane and a scheme.
    pub fn new(mechanism: &Mechanism, plane: &Plane, tableau: &'static Tableau) -> Self {
        let stages = PlanarStages::new(mechanism, plane, tableau);
        let freedoms = mechanism.velocity_count;
        PlanarKernel {
            coefficients: Coefficients::new(tableau),
            weights: MomentumWeights::new(tableau),
            anderson: Anderson::new(freedoms),
            chord: Chord::NEW,
            predictor: Predictor::new(freedoms, Vec::new(), tableau),
            newton: None,
            exact_for: exact_at_first(mechanism),
            closing: mechanism.has_closures().then(|| {
                let flat = Flat::new(mechanism, plane, One::zero(), false);
                Closing::new(mechanism, Projection::of(mechanism, flat, PlanarPlan::new(mechanism, plane)))
            }),
            plane: *plane,
            tableau,
            top_legendre: V::from_slice(&tableau.top_legendre[1..]),
            refined: false,
            velocity: vec![0.0; freedoms],
            displaced: vec![0.0; freedoms],
            end: PlanarStart::new(mechanism),
            stages,
        }
    }
}

/// The simplified iteration, with Anderson's acceleration.
impl<V: Lanes> Equations for PlanarKernel<V> {
    fn iterate(&mut self, settled: bool) -> f64 {
        let refines = self.refines();
        let (stages, coefficients) = (&mut self.stages, &self.coefficients);
        let gravity = stages.plan.gravity;
        let keeps = self.chord.keeps();
        // Vectors that carry the general sweeps alone are not compiled with the others.
        let increment = if V::GENERAL_ALONE || stages.applied.is_some() {
            if keeps {
                in_lanes!(V, stages.increments::<true, true, true>(coefficients, &gravity))
            } else {
                in_lanes!(V, stages.increments::<true, true, false>(coefficients, &gravity))
            }
        } else {
            match (keeps, refines && settled) {
                (_, true) => in_lanes!(V, stages.increments::<true, false, true>(coefficients, &gravity)),
                (true, false) => in_lanes!(V, stages.increments::<false, false, true>(coefficients, &gravity)),
                (false, false) => in_lanes!(V, stages.increments::<false, false, false>(coefficients, &gravity)),
            }
        };
        self.chord.see(increment);
        increment
    }

    fn refines(&self) -> bool {
        self.refined && !self.stages.is_general()
    }

    fn advance(&mut self) -> f64 {
        let (anderson, stages) = (&mut self.anderson, &mut self.stages);
        stages.largest = in_lanes!(V, anderson.advance(&mut stages.displacement, &stages.increment).largest());
        stages.largest
    }

    fn complete(&mut self) {
        let stages = &mut self.stages;
        in_lanes!(V, stages.advance());
    }

    fn legendre(&self) -> f64 {
        let (stages, top) = (&self.stages, self.top_legendre);
        in_lanes!(V, stages.largest_coefficient(top))
    }

    fn joint_legendre(&self) -> f64 {
        let (stages, top) = (&self.stages, self.top_legendre);
        in_lanes!(V, largest_coefficient(&stages.displacement, top))
    }

    fn worst_freedom(&self) -> usize {
        worst_freedom(&self.stages.increment)
    }

    fn furthest_turn(&self) -> Turn {
        let stages = &self.stages;
        in_lanes!(V, stages.furthest_turn())
    }
}

impl<V: Lanes> Guarded for PlanarKernel<V> {
    fn guess(&mut self, guess: Guess) {
        let (stages, predictor, coefficients) = (&mut self.stages, &mut self.predictor, &self.coefficients);
        in_lanes!(V, {
            predictor.guess(stages.unknowns(coefficients), guess);
            stages.measure();
        });
    }

    fn restart(&mut self) {
        self.chord.restart();
        self.anderson.restart();
    }

    fn solve_exactly(&mut self, mechanism: &Mechanism, rule: &StopRule) -> Attempt {
        let PlanarKernel { plane, tableau, .. } = self;
        let newton = self.newton.get_or_insert_with(|| Box::new(PlanarNewton::new(mechanism, plane, tableau)));
        newton.begin(&self.stages);
        iteration::solve(&mut Exact(self), &exact_rule(mechanism, rule))
    }

    fn exact_for(&mut self) -> &mut usize {
        &mut self.exact_for
    }
}

impl<V: Lanes> Coupling for PlanarKernel<V> {
    fn couple(&mut self) -> f64 {
        let PlanarKernel { stages, newton: Some(newton), coefficients, .. } = self else { return f64::NAN };
        newton.iterate(stages, coefficients)
    }

    fn add_increments(&mut self) -> f64 {
        self.complete();
        self.stages.largest
    }
}

impl<V: Lanes> Step for PlanarKernel<V> {
    fn begin(&mut self, mechanism: &Mechanism, state: &State) {
        self.stages.start.set(&self.stages.plan, mechanism, state);
        self.predictor.forget();
        self.chord = Chord::NEW;
        self.exact_for = exact_at_first(mechanism);
    }

    fn drive(&mut self, efforts: &[f64]) {
        if let Some(applied) = &mut self.stages.applied {
            applied.drive(efforts);
        }
    }

    fn energy(&self) -> Energy {
        self.stages.start.energy
    }

    fn has_past(&self) -> bool {
        self.predictor.has_past()
    }

    fn attempt(&mut self, mechanism: &Mechanism, step: f64, rule: &StopRule, guess: Guess) -> Attempt {
        self.stages.step = step;
        self.refined = rule.increment < REFINED_BELOW;
        iteration::attempt(self, mechanism, rule, guess)
    }

    fn finish(&mut self, mechanism: &Mechanism, state: &mut State) -> Energy {
        let PlanarKernel { stages, velocity, coefficients, weights, .. } = self;
        let gravity = stages.plan.gravity;
        if V::GENERAL_ALONE || stages.applied.is_some() {
            in_lanes!(V, stages.end_velocities::<true, true>(coefficients, weights, &gravity, velocity));
        } else if self.refined {
            in_lanes!(V, stages.end_velocities::<true, false>(coefficients, weights, &gravity, velocity));
        } else {
            in_lanes!(V, stages.end_velocities::<false, false>(coefficients, weights, &gravity, velocity));
        }
        write_ends(&stages.displacement, coefficients.active, &mut self.displaced);
        state.displace(mechanism, &self.displaced);
        state.velocity.copy_from_slice(velocity);
        self.end.set(&stages.plan, mechanism, state);
        if let Some(closing) = &mut self.closing {
            closing.velocities(mechanism, &self.end, &mut state.velocity);
            self.end.set(&stages.plan, mechanism, state);
        }
        self.end.energy
    }

    fn exchange(&self) -> Exchange {
        self.stages.applied.as_ref().map_or(Exchange::default(), |applied| applied.exchange)
    }

    fn take_kept(&mut self) -> usize {
        self.chord.take_count()
    }

    fn redundant(&self) -> Option<usize> {
        self.closing.as_ref().and_then(Closing::weak)
    }

    fn close(&mut self, mechanism: &Mechanism, position: &mut [f64], velocity: &mut [f64]) {
        if let Some(closing) = &mut self.closing {
            closing.project(mechanism, position, velocity);
        }
    }

    fn accept(&mut self) {
        let (stages, predictor, coefficients) = (&mut self.stages, &mut self.predictor, &self.coefficients);
        in_lanes!(V, predictor.learn(stages.unknowns(coefficients)));
        std::mem::swap(&mut self.stages.start, &mut self.end);
    }

    fn weigh_displacements(&self, weights: [&[f64]; 2], sums: &mut [[f64; 2]]) {
        weigh(&self.stages.displacement, weights, sums);
    }

    fn last_displacement(&self, freedom: usize) -> f64 {
        at_end(self.stages.displacement[freedom], self.coefficients.active)
    }

    fn accelerations(&mut self, step: f64, out: &mut [f64]) {
        self.stages.step = step;
        self.guess(Guess::Plain);
        self.chord.restart();
        self.iterate(false);
        write_ends(&self.stages.increment, self.coefficients.active, out);
        for out in out {
            *out = 2.0 * *out / (step * step);
        }
    }
}
