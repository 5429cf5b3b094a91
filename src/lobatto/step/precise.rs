//! Steps solved to 32 digits, so that conserved quantities do not drift by rounding in long runs.
//!
//! ```text
//!     θ        to sixteen digits                     kernel.rs, its iteration
//!     repeat:  poses of all stages from θ + e        to 32 digits, like all that follows
//!              residual ρ_k, factors of H(q_k) once, or kept
//!              δ_i = Σ_k Â_ik α_k,  H(q_k) α_k = −ρ_k
//!              e ← Anderson(e, δ)                    to sixteen digits: e is small
//!     until |δ| < 10⁻²²
//!     velocity from H(q̄) v̄ = Sᵀ p̄                    (2.5.11h)
//!     the start of the next step from the poses at the end of this one: nothing is rounded between steps
//! ```
//!
//! Iterative refinement, as of linear systems: the residual has all digits, and the correction needs few. The sweeps are the ones of
//! [`crate::step::kernel`], over [`Double`] lanes. Axes, arms and moments of inertia are carried along from step to step
//! ([`crate::step::precise_start`]), which loses 10⁻³² of them a step. The joint positions of the [`State`] are the sums of all displacements, with
//! compensation. Source of the refinement: C. B. Moler, J. ACM 14 (1967).

use crate::ending::velocities::Ending;
use crate::numbers::arithmetic::{Arithmetic, Numbers};
use crate::numbers::double::Double;
use crate::numbers::extended::Extended;
use crate::numbers::lanes::{Lanes, in_lanes};
use crate::numbers::reductions::worst_freedom;
use crate::solve::anderson::Anderson;
use crate::stages::attempt::{Attempt, Guess, StopRule};
use crate::stages::start::Start;
use crate::stages::workspace::Stages;
use crate::step::interface::Step;
use crate::step::kernel::Kernel;
use crate::step::precise_start::{carry, widen};
use crate::step::spatial::SpatialWorkspace;
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::description::rules::Rule;
use catena_mechanism::forces::total::Exchange;
use catena_mechanism::motion::energy::Energy;
use catena_mechanism::motion::state::State;

/// The refinement ends when all joint increments are at most this (rad, m): the last one leaves a tenth of it, and the velocity at the end of a step
/// has that up to 36 times over h.
const ENOUGH: f64 = 1e-22;
/// Increments below this that no longer fall are rounding.
const ROUNDING: f64 = 1e-20;
/// Most refinements of a step; where the iteration to sixteen digits has converged a few are enough.
const MOST: usize = 30;

/// [`Step`] with 32 digits, for trees under gravity alone.
#[derive(Clone)]
pub struct Precise<V: Lanes> {
    /// The same step to sixteen digits.
    coarse: Kernel<V, SpatialWorkspace<V>>,
    fine: Stages<Double<V>>,
    /// e: the part of the displacements beyond sixteen digits.
    correction: Vec<V>,
    /// δ.
    increment: Vec<V>,
    anderson: Anderson<V>,
    gravity: [f64; 3],
    ending: Ending<Double<V>>,
    /// Displacements at the end of the step.
    displaced: Vec<Extended>,
    /// The end of the finished step.
    end: Start<Extended>,
    /// Refinements that kept the factors of the one before, since somebody asked.
    kept: usize,
}

impl<V: Lanes> Precise<V> {
    /// The workspace for a tree under gravity and a scheme; `kept` are the disabled simplification rules.
    pub fn new(mechanism: &Mechanism, tableau: &'static Tableau, kept: &[Rule]) -> Self {
        let freedoms = mechanism.velocity_count;
        // The inverse of an inertia is not known to 32 digits.
        let kept = &[kept, &[Rule::Tumblers]].concat();
        let fine = Stages::unforced(mechanism, tableau, kept);
        Precise {
            coarse: Kernel::new(mechanism, tableau, SpatialWorkspace::new(mechanism, tableau, kept)),
            ending: Ending::new(&fine.plan, freedoms, tableau),
            fine,
            correction: vec![V::zero(); freedoms],
            increment: vec![V::zero(); freedoms],
            anderson: Anderson::new(freedoms),
            gravity: mechanism.gravity.into(),
            displaced: vec![Extended::ZERO; freedoms],
            end: Start::new(mechanism),
            kept: 0,
        }
    }

    /// Refines the solution of sixteen digits; the iterations it took, and how it ended.
    fn refine(&mut self) -> Result<usize, Attempt> {
        self.fine.step = self.coarse.workspace.stages.step;
        self.anderson.restart();
        self.correction.fill(V::zero());
        let mut previous = f64::INFINITY;
        for iteration in 1..=MOST {
            let increment = in_lanes!(V, self.iterate(iteration == 1));
            self.kept += usize::from(iteration > 1);
            in_lanes!(V, self.anderson.advance(&mut self.correction, &self.increment));
            if increment <= ENOUGH || (increment <= ROUNDING && increment > 0.5 * previous) {
                in_lanes!(V, self.place());
                return Ok(iteration);
            }
            previous = increment;
        }
        let freedom = worst_freedom(&self.increment);
        Err(Attempt::Failed { iterations: MOST, freedom, increment: previous })
    }

    /// One refinement from the corrections at hand: the increments to sixteen of their own digits; the largest.
    #[inline(always)]
    fn iterate(&mut self, factorise: bool) -> f64 {
        self.place();
        if factorise {
            self.fine.sweep_residual(&self.gravity);
        } else {
            self.fine.sweep_wrenches::<false>(&self.gravity);
        }
        let largest = self.fine.sweep_increments().largest();
        for (own, fine) in self.increment.iter_mut().zip(&self.fine.increment) {
            *own = fine.rounded();
        }
        largest
    }

    /// The poses of all stages for the corrections at hand.
    #[inline(always)]
    fn place(&mut self) {
        let known = self.coarse.workspace.stages.displacement.iter().zip(&self.correction);
        for (fine, (&rounded, &rest)) in self.fine.displacement.iter_mut().zip(known) {
            *fine = Double::widened(rounded) + Double::widened(rest);
        }
        self.fine.sweep_poses();
    }
}

impl<V: Lanes> Step for Precise<V> {
    fn duplicate(&self) -> Box<dyn Step> {
        Box::new(self.clone())
    }

    fn begin(&mut self, mechanism: &Mechanism, state: &State) {
        self.coarse.begin(mechanism, state);
        let Stages { plan, start, .. } = &mut self.fine;
        in_lanes!(V, widen::<V>(plan, &self.coarse.workspace.stages.start, &self.gravity, start));
    }

    fn energy(&self) -> Energy {
        self.coarse.energy()
    }

    fn has_past(&self) -> bool {
        self.coarse.has_past()
    }

    fn attempt(&mut self, mechanism: &Mechanism, step: f64, rule: &StopRule, guess: Guess) -> Attempt {
        let attempt = self.coarse.attempt(mechanism, step, rule, guess);
        if !matches!(attempt, Attempt::Converged { .. }) {
            return attempt;
        }
        match self.refine() {
            Ok(refinements) => attempt.after(refinements),
            Err(failure) => failure.after(attempt.iterations()),
        }
    }

    fn finish(&mut self, mechanism: &Mechanism, state: &mut State) -> Energy {
        let Precise { fine, ending, gravity, end, displaced, .. } = self;
        in_lanes!(V, ending.velocities::<Double<V>, false, false>(fine, gravity, &mut end.rates));
        in_lanes!(V, carry::<V>(fine, gravity, end));
        let last = fine.coefficients.active - 1;
        for (own, displacement) in displaced.iter_mut().zip(&fine.displacement) {
            *own = displacement.lane(last);
        }
        self.coarse.arrive(mechanism, state, displaced, &end.rates)
    }

    fn exchange(&self) -> Exchange {
        Exchange::default()
    }

    fn take_kept(&mut self) -> usize {
        self.coarse.take_kept() + std::mem::take(&mut self.kept)
    }

    fn redundant(&self) -> Option<usize> {
        None
    }

    fn close(&mut self, _: &Mechanism, _: f64, _: &mut [f64], _: &mut [f64]) {}

    fn accept(&mut self) {
        self.coarse.accept();
        std::mem::swap(&mut self.fine.start, &mut self.end);
    }

    fn weigh_displacements(&self, weights: [&[f64]; 2], sums: &mut [[f64; 2]]) {
        self.coarse.weigh_displacements(weights, sums);
    }

    fn last_displacement(&self, freedom: usize) -> f64 {
        self.coarse.last_displacement(freedom)
    }

    fn accelerations(&mut self, step: f64, out: &mut [f64]) {
        self.coarse.accelerations(step, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vectors::portable::Portable;
    use catena_mechanism::description::joint::{Joint, JointKind, Pose};
    use catena_mechanism::description::mechanism::Body;
    use nalgebra::{Rotation3, Translation3, Vector3};

    const RATES: [f64; 7] = [1.0, -2.0, 0.5, 1.5, -1.0, 0.8, -0.6];

    /// Three bodies askew: on a hinge, on a joint of a kind, on a ball.
    fn arm(kind: JointKind) -> Mechanism {
        let body = |name: &str, parent, kind, tilt| {
            let on_parent = Pose::from_parts(
                Translation3::new(0.3 * tilt, 0.1, -0.2),
                Rotation3::from_euler_angles(0.3 + tilt, -0.4, 0.5 * tilt),
            );
            let on_child =
                Pose::from_parts(Translation3::new(-0.4, 0.05, 0.1), Rotation3::from_euler_angles(0.1, tilt, 0.2));
            let joint = Joint::new(name, kind, on_parent, on_child);
            Body { name: name.into(), parent, mass: 1.0 + tilt, inertia: Vector3::new(0.03, 0.05, 0.06), joint }
        };
        let bodies = vec![
            body("first", None, JointKind::Revolute, 0.7),
            body("second", Some(0), kind, 0.2),
            body("ball", Some(1), JointKind::Spherical, 0.4),
        ];
        Mechanism::new("arm", Vector3::new(0.0, 1.0, -9.81), bodies).unwrap()
    }

    fn moving(mechanism: &Mechanism) -> State {
        let mut state = State::zero(mechanism);
        state.velocity.copy_from_slice(&RATES[..mechanism.velocity_count]);
        state
    }

    /// Rates to 32 digits after `steps` steps, and as many back again if `and_back` is set.
    fn rates(kind: JointKind, stages: usize, step: f64, steps: usize, and_back: bool) -> Vec<Extended> {
        let mechanism = arm(kind);
        let mut state = moving(&mechanism);
        let mut precise = Precise::<Portable<8>>::new(&mechanism, Tableau::of(stages).unwrap(), &[]);
        precise.begin(&mechanism, &state);
        let directions: &[f64] = if and_back { &[1.0, -1.0] } else { &[1.0] };
        for direction in directions {
            for _ in 0..steps {
                let attempt = precise.attempt(&mechanism, direction * step, &StopRule::ROUNDING, Guess::Plain);
                assert!(matches!(attempt, Attempt::Converged { .. }), "{attempt:?}");
                precise.finish(&mechanism, &mut state);
                precise.accept();
            }
        }
        precise.fine.start.rates
    }

    #[test]
    fn what_turns_together_keeps_its_shape_over_four_thousand_steps() {
        // Hinges, because a slide is soon far away.
        let mechanism = arm(JointKind::Revolute);
        let (mut state, tableau) = (moving(&mechanism), Tableau::of(9).unwrap());
        let mut precise = Precise::<Portable<8>>::new(&mechanism, tableau, &[]);
        precise.begin(&mechanism, &state);
        let shape = |precise: &Precise<Portable<8>>| {
            let Start { bodies, axes, .. } = &precise.fine.start;
            let square = |a: &[Extended; 3], b: &[Extended; 3]| (0..3).map(|axis| a[axis] * b[axis]).sum::<Extended>();
            let coms = bodies.iter().map(|body| square(&body.com, &body.com));
            let traces = bodies.iter().map(|body| body.sigma[0] + body.sigma[3] + body.sigma[5]);
            let axes = axes.iter().zip(&axes[1..]).flat_map(|(a, b)| [square(a, a), square(b, b)]);
            coms.chain(traces).chain(axes).collect::<Vec<Extended>>()
        };
        let before = shape(&precise);
        for _ in 0..4000 {
            let attempt = precise.attempt(&mechanism, 0.05, &StopRule::ROUNDING, Guess::Plain);
            assert!(matches!(attempt, Attempt::Converged { .. }), "{attempt:?}");
            precise.finish(&mechanism, &mut state);
            precise.accept();
        }
        // Ten roundings of 1e-32 a step, at random; axes that are not made unit vectors again leave ten times as much after every further
        // two thousand steps, 1.6e-28 here.
        let off = largest_difference(&before, &shape(&precise));
        assert!(off < 1e-29, "{off:.1e}");
    }

    fn largest_difference(a: &[Extended], b: &[Extended]) -> f64 {
        a.iter().zip(b).map(|(&a, &b)| (a - b).rounded().abs()).fold(0.0, f64::max)
    }

    #[test]
    fn the_order_of_the_scheme_holds_far_below_the_rounding_of_doubles() {
        // Order 16 for nine stages, a bit more or less while the next term of the error counts. Coefficients, series, axes or moments of inertia of
        // sixteen digits would leave 1e-16, whatever the step.
        let [coarse, fine, finest] =
            [8, 16, 32].map(|steps| rates(JointKind::Revolute, 9, 0.5 / steps as f64, steps, false));
        let (first, second) = (largest_difference(&coarse, &fine), largest_difference(&fine, &finest));
        let order = (first / second).log2();
        assert!(second < 1e-19 && (15.0..17.0).contains(&order), "{first:.1e}, {second:.1e}: order {order}");
    }

    #[test]
    fn a_run_turned_round_returns_to_its_start_to_eighteen_digits() {
        let there_and_back = rates(JointKind::Planar, 5, 0.02, 40, true);
        let start = RATES.map(Extended::from);
        let off = largest_difference(&there_and_back, &start);
        // 80 steps, each of which ends its refinement at some 1e-22 of a displacement, which velocities have over h = 0.02 s times 10.
        assert!(off < 1e-18, "{off:.1e}");
    }
}
