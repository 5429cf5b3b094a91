//! The end of a step: its momenta and the joint velocities that carry them (2.5.11h), at the last stage alone.
//!
//! The projection `H(q̄) v̄ = Sᵀ p̄` is the Newton step's recursion ([`crate::solve::sweeps`]) with the momenta of the bodies in place of the
//! residuals. It has one row, so it is computed in one lane. Its inputs from all stages are weighted sums of the deviation of a body from the steady
//! motion of the start ([`crate::stages::momenta`]; symbols as in [`crate::equations::residual`]). If rounding has taken too many digits of the
//! velocities, they are refined (`refinement`).

use crate::equations::pivot::turned_about;
use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::{Arithmetic, Numbers};
use crate::numbers::rotations::Tilt;
use crate::plan::tree::Plan;
use crate::stages::articulated::Push;
use crate::stages::factors::Factors;
use crate::stages::momenta::{Momenta, MomentumWeights};
use crate::stages::pose::{StagePose, Turned};
use crate::stages::row_geometry::LookAhead;
use crate::stages::rows::{Rows, Steady, sums};
use crate::stages::start::BodyStart;
use crate::stages::workspace::Stages;
use crate::tableau::butcher::Tableau;

/// A twist of a body, or its momentum and the moment of it: the part at its anchor, and the angular part.
pub(crate) type Motion<E> = (Vector<E>, Vector<E>);

/// The workspace of the end of a step.
#[derive(Clone)]
pub struct Ending<E> {
    pub(crate) factors: Factors<E>,
    pub(crate) weights: MomentumWeights<E>,
    /// Momentum and moment of momentum about the anchor of each body at velocities that are to be refined; before, its twist.
    pub(crate) carried: Vec<Motion<E>>,
}

impl<E: Arithmetic> Ending<E> {
    /// Room for the end of the steps of a scheme.
    pub fn new(plan: &Plan, freedoms: usize, tableau: &Tableau) -> Self {
        Ending {
            factors: Factors::new(plan, freedoms),
            weights: MomentumWeights::new(tableau),
            carried: vec![(Vector::zero(), Vector::zero()); plan.bodies.len()],
        }
    }

    /// The row of the end of a step.
    #[inline(always)]
    pub(crate) fn rows<'s, V: Numbers<One = E, Real = E::Real>, const REFINED: bool, const FORCED: bool>(
        &self,
        stages: &'s Stages<V>,
        gravity: &[f64; 3],
    ) -> EndRows<'s, V, REFINED, FORCED> {
        let steady = stages.coefficients.steady(stages.step);
        EndRows { stages, steady, momenta: self.weights.over(stages.step, gravity), carried: None }
    }

    /// The velocities at the end of a solved step, of which the poses of all stages are known; `REFINED` with twice the digits of the
    /// coefficients, with forces (`FORCED`) after [`Stages::sweep_applied`] at the end; returns the square of them, `v̄ᵀ H v̄` ([`refinement`]).
    #[inline(always)]
    pub fn velocities<V: Numbers<One = E, Real = E::Real>, const REFINED: bool, const FORCED: bool>(
        &mut self,
        stages: &Stages<V>,
        gravity: &[f64; 3],
        velocity: &mut [V::Real],
    ) -> V::Real {
        let rows = self.rows::<V, REFINED, FORCED>(stages, gravity);
        self.factors.eliminate(&stages.plan, &stages.start, &rows, &mut LookAhead::new(()));
        let square = self.factors.square();
        self.factors.solve(
            &stages.plan,
            #[inline(always)]
            |freedom, rate| velocity[freedom] = rate.lane(0),
        );
        square.lane(0)
    }
}

/// The one row of the end.
pub(crate) struct EndRows<'s, V: Numbers, const REFINED: bool, const FORCED: bool> {
    pub(crate) stages: &'s Stages<V>,
    pub(crate) steady: Steady<V>,
    pub(crate) momenta: Momenta<V::One>,
    /// [`Rows::carried`].
    pub(crate) carried: Option<&'s [Motion<V::One>]>,
}

impl<V: Numbers, const REFINED: bool, const FORCED: bool> EndRows<'_, V, REFINED, FORCED> {
    #[inline(always)]
    fn last(&self) -> usize {
        self.stages.coefficients.active - 1
    }

    #[inline(always)]
    fn alone(&self, Vector([x, y, z]): Vector<V>) -> Vector<V::One> {
        let last = self.last();
        Vector([x.alone(last), y.alone(last), z.alone(last)])
    }

    /// Displacement of the centre of mass of a body at all stages (m).
    #[inline(always)]
    pub(crate) fn displaced(&self, body: usize, known: &BodyStart<V::Real>) -> Vector<V> {
        let pose = &self.stages.poses[body];
        if self.stages.plan.bodies[body].slides {
            pose.anchor
        } else {
            pose.turned().matrix().apply(Vector::splat(&known.com)).plus(pose.anchor)
        }
    }

    #[inline(always)]
    pub(crate) fn weighed<const N: usize>(&self, values: [V; N]) -> [V::One; N] {
        let weighed = V::weigh_all(values, &self.momenta.weights);
        if REFINED { sums(weighed, V::weigh_all(values, &self.momenta.rest)) } else { weighed }
    }
}

impl<V: Numbers, const REFINED: bool, const FORCED: bool> Rows<V::One> for EndRows<'_, V, REFINED, FORCED> {
    const MOMENTA: bool = true;
    const EARLY: bool = false;
    /// Empty: one lane alone takes the poses of all stages.
    type Ahead = ();
    #[inline(always)]
    fn pose(&self, body: usize) -> StagePose<V::One> {
        let StagePose { w, u, anchor } = self.stages.poses[body];
        StagePose { w: w.alone(self.last()), u: self.alone(u), anchor: self.alone(anchor) }
    }
    #[inline(always)]
    fn moved(&self) -> V::One {
        V::One::splat(1.0)
    }
    #[inline(always)]
    fn tilt(&self, _: usize) -> Option<Tilt<V::One>> {
        None
    }
    #[inline(always)]
    fn gravity(&self) -> Vector<V::One> {
        self.momenta.gravity
    }
    #[inline(always)]
    fn path(&self, body: usize, known: &BodyStart<V::Real>, _: Vector<V::One>) -> Vector<V::One> {
        let ahead = self.steady.path::<REFINED>(known, self.displaced(body, known));
        Vector(self.weighed(ahead)).plus(Vector::splat(&known.velocity))
    }
    #[inline(always)]
    fn ahead(&self, _: &BodyStart<V::Real>, _: Vector<V::One>, _: Turned<V::One>) {}
    #[inline(always)]
    fn motion(&self, body: usize, known: &BodyStart<V::Real>, (): &()) -> (Vector<V::One>, Turned<V::One>) {
        let turned = self.stages.poses[body].turned();
        let ahead = self.steady.motion::<REFINED>(known, self.displaced(body, known), turned);
        let [x, y, z, turned @ ..] = self.weighed(ahead);
        (Vector([x, y, z]).plus(Vector::splat(&known.velocity)), spinning(known, Turned::joined(turned)))
    }
    #[inline(always)]
    fn spin(&self, body: usize, known: &BodyStart<V::Real>, _: Turned<V::One>) -> Turned<V::One> {
        let ahead = self.steady.spin::<REFINED>(known, self.stages.poses[body].turned());
        spinning(known, Turned::joined(self.weighed(ahead)))
    }
    #[inline(always)]
    fn swing(&self, body: usize, axis: &[V::Real; 3], rate: V::Real, _: [V::One; 2]) -> [V::One; 2] {
        let [sine, versine] = turned_about(&self.stages.poses[body], axis);
        let ahead = self.steady.ahead::<REFINED>(V::whole(rate), sine);
        let [sines, versines] = self.weighed([ahead, versine]);
        [sines + V::One::whole(rate), versines]
    }
    #[inline(always)]
    fn forces(&self) -> V::One {
        self.momenta.impulse
    }
    #[inline(always)]
    fn wrench(&self, body: usize) -> Option<(Vector<V::One>, Vector<V::One>)> {
        let applied = if FORCED { self.stages.applied.as_ref()? } else { return None };
        let (force, torque) = applied.wrenches[body];
        Some((self.alone(force), self.alone(torque)))
    }
    #[inline(always)]
    fn carried(&self, body: usize) -> Option<Motion<V::One>> {
        self.carried.map(|carried| carried[body])
    }
    #[inline(always)]
    fn push(&self, freedom: usize) -> Option<Push<V::One>> {
        let applied = if FORCED { self.stages.applied.as_ref()? } else { return None };
        // The resistance of dampers is among the efforts.
        let push = Push {
            effort: applied.efforts[freedom].alone(self.last()) * self.momenta.impulse,
            inertia: V::One::zero(),
        };
        Some(match applied.rotor(freedom) {
            None => push,
            Some((carried, inertia)) => push.plus(carried.alone(self.last()), V::One::splat(inertia)),
        })
    }
}

/// The rate of a turn from how far it is ahead of a steady one.
#[inline(always)]
pub(crate) fn spinning<E: Arithmetic>(known: &BodyStart<E::Real>, ahead: Turned<E>) -> Turned<E> {
    let Vector(vector) = Vector(ahead.vector).plus(Vector::splat(&known.spin));
    Turned { vector, ..ahead }
}
