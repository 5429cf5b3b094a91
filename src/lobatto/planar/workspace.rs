//! The workspace of a step in a plane, and its operations: an iteration, and the end of the step.

use crate::numbers::lanes::Lanes;
use crate::numbers::reductions::{larger, largest_coefficient};
use crate::planar::algebra::Vector2;
use crate::planar::articulated::{Articulated2, Eliminated2};
use crate::planar::start::{PlanarPlan, PlanarStart};
use crate::stages::coefficients::Coefficients;
use crate::stages::forces::Applied;
use crate::stages::momenta::MomentumWeights;
use crate::stages::pose::Turn;
use crate::stages::unknowns::Unknowns;
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::joint::FreeRotation;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::structure::plane::Plane;

/// Turn and path of a body at the stages, and mixed.
#[derive(Clone, Copy)]
pub(crate) struct Turned<V> {
    /// κ and σ.
    pub cosine: V,
    pub sine: V,
    /// p and q.
    pub mixed_cosine: V,
    pub mixed_sine: V,
    /// a.
    pub path: Vector2<V>,
}

impl<V: Lanes> Turned<V> {
    pub fn zero() -> Self {
        let zero = V::zero();
        Turned { cosine: zero, sine: zero, mixed_cosine: zero, mixed_sine: zero, path: Vector2::zero() }
    }
}

/// The workspace of a step.
#[derive(Clone)]
pub(crate) struct PlanarStages<V> {
    pub plan: PlanarPlan,
    /// The known start of the step.
    pub start: PlanarStart,
    /// Displacement of every degree of freedom since the start: the unknowns.
    pub displacement: Vec<V>,
    /// Their latest increments.
    pub increment: Vec<V>,
    /// The largest displacement of any freedom at any stage, or more.
    pub largest: f64,
    /// One entry a body.
    pub turned: Vec<Turned<V>>,
    /// Arm from the parent's anchor at the rows' stages.
    pub arms: Vec<Vector2<V>>,
    pub eliminated: Vec<Eliminated2<V>>,
    /// Direction of each slide at the rows' stages.
    pub axes: Vec<Vector2<V>>,
    /// Slots of the children of branching bodies.
    pub slots: Vec<Articulated2<V>>,
    /// Twist of the branching bodies on the way back.
    pub twists: Vec<(Vector2<V>, V)>,
    /// Forces, if there are any.
    pub applied: Option<Box<Applied<V>>>,
    /// Displacement of each anchor since the start (m), if requested.
    pub anchors: Vec<Vector2<V>>,
    /// Force (N) on each body and torque about its anchor [N m] of all forces that do not act in joints; empty if there are no such forces.
    pub acting: Vec<(Vector2<V>, V)>,
    /// Length of the step (s).
    pub step: f64,
}

impl<V: Lanes> PlanarStages<V> {
    /// A workspace for a mechanism.
    pub fn new(mechanism: &Mechanism, plane: &Plane, tableau: &Tableau) -> Self {
        let plan = PlanarPlan::new(mechanism, plane);
        let (bodies, freedoms, slots) = (plan.bodies.len(), mechanism.velocity_count, plan.tree.slots);
        let pushed = if plan.forces.is_empty() { 0 } else { bodies };
        PlanarStages {
            start: PlanarStart::new(mechanism),
            displacement: vec![V::zero(); freedoms],
            increment: vec![V::zero(); freedoms],
            largest: f64::INFINITY,
            turned: vec![Turned::zero(); bodies],
            arms: vec![Vector2::zero(); bodies],
            eliminated: vec![Eliminated2::zero(); freedoms],
            axes: vec![Vector2::zero(); freedoms],
            slots: vec![Articulated2::zero(); slots],
            twists: vec![(Vector2::zero(), V::zero()); slots],
            applied: Applied::new(mechanism, tableau),
            anchors: vec![Vector2::zero(); bodies],
            acting: vec![(Vector2::zero(), V::zero()); pushed],
            plan,
            step: 0.0,
        }
    }

    /// The unknowns of the predictor.
    pub fn unknowns<'s>(&'s mut self, coefficients: &'s Coefficients<V>) -> Unknowns<'s, V> {
        Unknowns { displacement: &mut self.displacement, rates: &self.start.rates, step: self.step, coefficients }
    }

    /// Whether a step takes the most general sweeps: forces act, or there are no others ([`Lanes::GENERAL_ALONE`]). The choice of the sweeps writes
    /// this condition out: behind a call the compiler would know it too late.
    #[inline(always)]
    pub fn is_general(&self) -> bool {
        V::GENERAL_ALONE || self.applied.is_some()
    }

    /// One iteration: finds the increments, returns the largest; `REFINED` with twice the digits of the coefficients, `FORCED` with
    /// forces, `KEPT` with the factors of the iteration before.
    #[inline(always)]
    pub fn increments<const REFINED: bool, const FORCED: bool, const KEPT: bool>(
        &mut self,
        coefficients: &Coefficients<V>,
        gravity: &[f64; 3],
    ) -> f64 {
        let sweep = coefficients.residual_sweep(self.step, gravity);
        self.sweep_paths::<false, REFINED>(&sweep);
        if FORCED {
            self.sweep_applied(coefficients, false);
        }
        if KEPT {
            self.sweep_wrenches::<FORCED>(&sweep);
        } else {
            self.sweep_back::<false, FORCED>(&sweep);
        }
        let mut largest = V::zero();
        self.forward(
            #[inline(always)]
            |stages, freedom, alpha| {
                let increment = alpha.mix(&coefficients.solve);
                stages.increment[freedom] = increment;
                largest = increment.max_abs(largest);
            },
        );
        largest.largest()
    }

    /// The velocities at the end of the solved step.
    #[inline(always)]
    pub fn end_velocities<const REFINED: bool, const FORCED: bool>(
        &mut self,
        coefficients: &Coefficients<V>,
        weights: &MomentumWeights<V>,
        gravity: &[f64; 3],
        velocity: &mut [f64],
    ) {
        let momenta = weights.over(self.step, gravity);
        let sweep = momenta.sweep(coefficients, self.step);
        self.sweep_paths::<true, REFINED>(&sweep);
        if FORCED {
            self.sweep_applied(coefficients, true);
        }
        self.sweep_back::<true, FORCED>(&sweep);
        let last = coefficients.active - 1;
        self.forward(
            #[inline(always)]
            |_, freedom, rate| velocity[freedom] = rate.to_array().as_ref()[last],
        );
    }

    /// The largest top Legendre coefficient of the displacements, and of the sines and cosines of the turns.
    #[inline(always)]
    pub fn largest_coefficient(&self, top: V) -> f64 {
        let mut largest = largest_coefficient(&self.displacement, top);
        for turned in &self.turned {
            largest = larger(largest, self.plan.share * (turned.sine * top).sum().abs());
            largest = larger(largest, (turned.cosine * top).sum().abs());
        }
        largest
    }

    /// The joint that has turned furthest since the start.
    #[inline(always)]
    pub fn furthest_turn(&self) -> Turn {
        let mut furthest = Turn::default();
        for tree in &self.plan.tree.bodies {
            let freedom = tree.first_axis + tree.translations;
            if tree.rotation != FreeRotation::None {
                let angle = self.displacement[freedom].max_abs(V::zero()).largest();
                furthest = furthest.or(Turn { angle, freedom });
            }
        }
        furthest
    }
}
