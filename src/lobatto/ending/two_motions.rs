//! The velocities at the ends of two motions that have gone through the same step, at once: a run and its companion ([`crate::step::carrying`]).
//!
//! The recursion of [`crate::ending::velocities`] has one row, and so it leaves the registers empty but for one lane; each of its operations also
//! waits for the one before. One motion in each of two lanes takes as long for both as for one. The inputs from all stages are written down for one
//! motion after the other, because both are solved in the same workspace:
//!
//! ```text
//!     motion 0:  poses of all stages ──▶ last pose, weighted sums of each body ──┐ lane 0
//!     motion 1:  poses of all stages ──▶ last pose, weighted sums of each body ──┤ lane 1     H(q̄) v̄ = Sᵀ p̄        (2.5.11h)
//! ```
//!
//! Every lane has the bits of its motion alone. Trees under gravity alone have this.

use crate::ending::velocities::{Ending, spinning};
use crate::equations::pivot::turned_about;
use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::{Arithmetic, Numbers};
use crate::numbers::lanes::Lanes;
use crate::numbers::rotations::Tilt;
use crate::numbers::twofold::Twofold;
use crate::plan::tree::Plan;
use crate::stages::articulated::Push;
use crate::stages::factors::Factors;
use crate::stages::pose::{StagePose, Turned};
use crate::stages::row_geometry::LookAhead;
use crate::stages::rows::Rows;
use crate::stages::start::BodyStart;
use crate::stages::two_starts::TwoStarts;
use crate::stages::workspace::Stages;
use catena_mechanism::description::mechanism::Mechanism;

/// Inputs of the end from all stages of a body, motion by motion.
#[derive(Clone, Copy, Default)]
pub(crate) struct Recorded {
    /// `(w, u)` and the displacement of the anchor at the last stage.
    pose: [[f64; 2]; 7],
    /// The weighted sums of the deviation from steady motion, of the path and then of the turn; a body on a hinge that the world holds has sums of
    /// sine and versine.
    sums: [[f64; 2]; 12],
}

/// The workspace of the ends of two motions.
#[derive(Clone)]
pub(crate) struct TwoEndings<L> {
    /// Their starts, and the starts of the next step.
    pub(crate) starts: TwoStarts<L>,
    factors: Factors<Twofold<L>>,
    recorded: Vec<Recorded>,
}

/// Inputs that both ends share: how long gravity and forces count (s), and the same times gravity [m/s].
#[derive(Clone)]
pub(crate) struct TwoMomenta {
    impulse: f64,
    gravity: [f64; 3],
}

impl<E: Arithmetic<Real = f64>> Ending<E> {
    /// Coefficients that the ends of two motions over this step share.
    pub(crate) fn in_common(&self, step: f64, gravity: &[f64; 3]) -> TwoMomenta {
        let momenta = self.weights.over(step, gravity);
        TwoMomenta { impulse: momenta.impulse.lane(0), gravity: momenta.gravity.0.map(|side| side.lane(0)) }
    }

    /// Writes down the inputs of the end of this `motion` from all stages, of which the poses are known.
    #[inline(always)]
    pub(crate) fn record<V: Numbers<One = E, Real = f64>, L: Lanes, const REFINED: bool>(
        &self,
        stages: &Stages<V>,
        gravity: &[f64; 3],
        motion: usize,
        two: &mut TwoEndings<L>,
    ) {
        let rows = self.rows::<V, REFINED, false>(stages, gravity);
        let (plans, start) = (&stages.plan, &stages.start);
        for (index, recorded) in two.recorded.iter_mut().enumerate() {
            let (plan, known) = (&plans.bodies[index], &start.bodies[index]);
            let StagePose { w, u: Vector([x, y, z]), anchor: Vector([a, b, c]) } = rows.pose(index);
            write(&mut recorded.pose, motion, [w, x, y, z, a, b, c]);
            if plan.pivot.is_some() {
                let freedom = plan.first_axis;
                let [sine, versine] = turned_about(&stages.poses[index], &start.axes[freedom]);
                let ahead = rows.steady.ahead::<REFINED>(V::whole(start.rates[freedom]), sine);
                write(&mut recorded.sums, motion, rows.weighed([ahead, versine]));
            } else if plan.slides || plan.point {
                let ahead = rows.steady.path::<REFINED>(known, rows.displaced(index, known));
                write(&mut recorded.sums, motion, rows.weighed(ahead));
            } else {
                let turned = stages.poses[index].turned();
                let ahead = rows.steady.motion::<REFINED>(known, rows.displaced(index, known), turned);
                write(&mut recorded.sums, motion, rows.weighed(ahead));
            }
        }
    }
}

/// Writes the values of one motion.
#[inline(always)]
fn write<E: Arithmetic<Real = f64>, const N: usize>(recorded: &mut [[f64; 2]], motion: usize, values: [E; N]) {
    let mut index = 0;
    while index < N {
        recorded[index][motion] = values[index].lane(0);
        index += 1;
    }
}

impl<L: Lanes<Array = [f64; 2]>> TwoEndings<L> {
    /// Room for a tree.
    pub(crate) fn new(plan: &Plan, mechanism: &Mechanism) -> Self {
        TwoEndings {
            starts: TwoStarts::new(mechanism),
            factors: Factors::new(plan, mechanism.velocity_count),
            recorded: vec![Recorded::default(); plan.bodies.len()],
        }
    }

    /// The velocities of both motions after both were [recorded](Ending::record); returns the squares of them, `v̄ᵀ H v̄`.
    pub(crate) fn velocities(&mut self, plan: &Plan, momenta: &TwoMomenta, velocities: [&mut [f64]; 2]) -> [f64; 2] {
        L::apart(
            #[inline(always)]
            || {
                let TwoEndings { starts, factors, recorded } = self;
                let rows = TwoRows::<L> {
                    recorded,
                    impulse: Twofold::splat(momenta.impulse),
                    gravity: Vector(momenta.gravity.map(Twofold::splat)),
                };
                factors.eliminate(plan, &starts.start, &rows, &mut LookAhead::new(()));
                let square = factors.square();
                let [first, second] = velocities;
                factors.solve(
                    plan,
                    #[inline(always)]
                    |freedom, rate| [first[freedom], second[freedom]] = rate.lane(0),
                );
                square.lane(0)
            },
        )
    }
}

/// The one row of the end of both motions.
struct TwoRows<'s, L> {
    recorded: &'s [Recorded],
    impulse: Twofold<L>,
    gravity: Vector<Twofold<L>>,
}

impl<L: Lanes<Array = [f64; 2]>> TwoRows<'_, L> {
    #[inline(always)]
    fn turn(&self, body: usize) -> Turned<Twofold<L>> {
        let [_, _, _, turned @ ..] = self.recorded[body].sums;
        Turned::joined(loaded(turned))
    }
}

#[inline(always)]
fn loaded<L: Lanes<Array = [f64; 2]>, const N: usize>(values: [[f64; 2]; N]) -> [Twofold<L>; N] {
    let mut out = [Twofold(<L as Lanes>::zero()); N];
    let mut index = 0;
    while index < N {
        out[index] = Twofold::whole(values[index]);
        index += 1;
    }
    out
}

impl<L: Lanes<Array = [f64; 2]>> Rows<Twofold<L>> for TwoRows<'_, L> {
    const MOMENTA: bool = true;
    const EARLY: bool = false;
    type Ahead = ();
    #[inline(always)]
    fn pose(&self, body: usize) -> StagePose<Twofold<L>> {
        let [w, x, y, z, a, b, c] = loaded(self.recorded[body].pose);
        StagePose { w, u: Vector([x, y, z]), anchor: Vector([a, b, c]) }
    }
    #[inline(always)]
    fn moved(&self) -> Twofold<L> {
        Twofold::splat(1.0)
    }
    #[inline(always)]
    fn tilt(&self, _: usize) -> Option<Tilt<Twofold<L>>> {
        None
    }
    #[inline(always)]
    fn gravity(&self) -> Vector<Twofold<L>> {
        self.gravity
    }
    #[inline(always)]
    fn path(&self, body: usize, known: &BodyStart<[f64; 2]>, _: Vector<Twofold<L>>) -> Vector<Twofold<L>> {
        let [x, y, z, ..] = self.recorded[body].sums;
        Vector(loaded([x, y, z])).plus(Vector::splat(&known.velocity))
    }
    #[inline(always)]
    fn ahead(&self, _: &BodyStart<[f64; 2]>, _: Vector<Twofold<L>>, _: Turned<Twofold<L>>) {}
    #[inline(always)]
    fn motion(&self, body: usize, known: &BodyStart<[f64; 2]>, (): &()) -> (Vector<Twofold<L>>, Turned<Twofold<L>>) {
        (self.path(body, known, Vector::zero()), spinning(known, self.turn(body)))
    }
    #[inline(always)]
    fn spin(&self, body: usize, known: &BodyStart<[f64; 2]>, _: Turned<Twofold<L>>) -> Turned<Twofold<L>> {
        spinning(known, self.turn(body))
    }
    #[inline(always)]
    fn swing(&self, body: usize, _: &[[f64; 2]; 3], rate: [f64; 2], _: [Twofold<L>; 2]) -> [Twofold<L>; 2] {
        let [sines, versines, ..] = self.recorded[body].sums;
        let [sines, versines] = loaded([sines, versines]);
        [sines + Twofold::whole(rate), versines]
    }
    #[inline(always)]
    fn forces(&self) -> Twofold<L> {
        self.impulse
    }
    #[inline(always)]
    fn wrench(&self, _: usize) -> Option<(Vector<Twofold<L>>, Vector<Twofold<L>>)> {
        None
    }
    #[inline(always)]
    fn push(&self, _: usize) -> Option<Push<Twofold<L>>> {
        None
    }
}
