//! The rows of a sweep: the source of the motion of a body's residual, and the mixtures of stages.
//!
//! The residual ([`crate::equations::residual`]) and the sweep over the tree ([`crate::solve::sweeps`]) are written once, for the rows of all stages,
//! one in each lane ([`StageRows`]), and for the momenta at the end of the step, in one lane alone ([`crate::ending::velocities`]).

use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::{Arithmetic, InLines, Numbers};
use crate::numbers::lanes::MAX_LANES;
use crate::numbers::rotations::Tilt;
use crate::plan::tree::Plan;
use crate::stages::articulated::Push;
use crate::stages::coefficients::Coefficients;
use crate::stages::forces::Applied;
use crate::stages::pose::{StagePose, Turned, rotation_vector};
use crate::stages::start::{BodyStart, Start};

/// The right-hand side of a sweep over the tree: the residuals of the rows of all stages ([`StageRows`]), or the momenta at the end of the step
/// ([`crate::ending::velocities`]).
pub trait Rows<V: Arithmetic> {
    /// Whether it is momenta.
    const MOMENTA: bool;
    /// Rotation and anchor displacement of a body.
    fn pose(&self, body: usize) -> StagePose<V>;
    /// One where a row has its stage's geometry.
    fn moved(&self) -> V;
    /// Tilt of the free axes of a ball joint, of which this is the first, against the axes of the body; `None` without tilt.
    fn tilt(&self, freedom: usize) -> Option<Tilt<V>>;
    /// Gravity's part of the mixed path.
    fn gravity(&self) -> Vector<V>;
    /// The mixed path of a centre of mass that has been `displaced` in these rows (m); for momenta its velocity [m/s], which needs all stages.
    fn path(&self, body: usize, known: &BodyStart<V::Real>, displaced: Vector<V>) -> Vector<V>;
    /// Whether the values of a body are stored while the one before it is mixed ([`crate::stages::row_geometry`]).
    const EARLY: bool;
    /// The values of a body that are to be mixed.
    type Ahead: Copy;
    /// The inputs of a body whose centre of mass has been `displaced` (m) and which has `turned` so far in these rows.
    fn ahead(&self, known: &BodyStart<V::Real>, displaced: Vector<V>, turned: Turned<V>) -> Self::Ahead;
    /// [`Rows::path`], and the mixed turn of a body; for momenta its rate [1/s].
    fn motion(&self, body: usize, known: &BodyStart<V::Real>, ahead: &Self::Ahead) -> (Vector<V>, Turned<V>);
    /// The mixed turn alone of a body that has `turned` so far in these rows; for momenta its rate [1/s].
    fn spin(&self, body: usize, known: &BodyStart<V::Real>, turned: Turned<V>) -> Turned<V>;
    /// The mixed sine and versine of a body that turned at this rate about this axis and has `turned` so far in these rows
    /// ([`crate::equations::pivot`]); for momenta their rates [1/s].
    fn swing(&self, body: usize, axis: &[V::Real; 3], rate: V::Real, turned: [V; 2]) -> [V; 2];
    /// The factor of applied forces: a time squared (s²), for momenta a time (s).
    fn forces(&self) -> V;
    /// Force and torque on a body besides gravity; `None` without such forces.
    fn wrench(&self, body: usize) -> Option<(Vector<V>, Vector<V>)>;
    /// The known part of a body's momentum and of its moment about the anchor ([`crate::ending::velocities`]); `None` if that is zero.
    #[inline(always)]
    fn carried(&self, _: usize) -> Option<(Vector<V>, Vector<V>)> {
        None
    }
    /// Effect of the forces in the joint along a degree of freedom, in the units of the residuals; `None` without forces.
    fn push(&self, freedom: usize) -> Option<Push<V>>;
}

/// The steady motion that displacements are compared with.
#[derive(Clone, Copy)]
pub struct Steady<V> {
    /// `h c_i`.
    times: V,
    /// The rounding error of `times`.
    rest: V,
}

impl<V: Arithmetic> Steady<V> {
    /// How far a displacement is ahead of a steady motion at the `rate` of the start: `displaced − h c_i rate`.
    #[inline(always)]
    pub fn ahead<const REFINED: bool>(&self, rate: V, displaced: V) -> V {
        let ahead = rate.neg_mul_add(self.times, displaced);
        if REFINED { rate.neg_mul_add(self.rest, ahead) } else { ahead }
    }

    /// [`Steady::ahead`] of the path of a centre of mass.
    #[inline(always)]
    pub fn path<const REFINED: bool>(&self, known: &BodyStart<V::Real>, displaced: Vector<V>) -> [V; 3] {
        let (Vector([u, v, w]), Vector([x, y, z])) = (Vector::<V>::splat(&known.velocity), displaced);
        [self.ahead::<REFINED>(u, x), self.ahead::<REFINED>(v, y), self.ahead::<REFINED>(w, z)]
    }

    /// [`Steady::path`], then the same of the turn of a body: its vector and its products.
    #[inline(always)]
    pub fn motion<const REFINED: bool>(
        &self,
        known: &BodyStart<V::Real>,
        displaced: Vector<V>,
        turned: Turned<V>,
    ) -> [V; 12] {
        let [a, b, c] = self.path::<REFINED>(known, displaced);
        let [x, y, z, xx, xy, xz, yy, yz, zz] = self.spin::<REFINED>(known, turned);
        [a, b, c, x, y, z, xx, xy, xz, yy, yz, zz]
    }

    /// The turn of a body: its vector and its products.
    #[inline(always)]
    pub fn spin<const REFINED: bool>(&self, known: &BodyStart<V::Real>, turned: Turned<V>) -> [V; 9] {
        let Vector([u, v, w]) = Vector::<V>::splat(&known.spin);
        let Turned { products: [xx, xy, xz, yy, yz, zz], vector: [x, y, z] } = turned;
        let [x, y, z] = [self.ahead::<REFINED>(u, x), self.ahead::<REFINED>(v, y), self.ahead::<REFINED>(w, z)];
        [x, y, z, xx, xy, xz, yy, yz, zz]
    }
}

/// Data that all bodies of a sweep share.
pub struct Sweep<'s, V> {
    /// Mixing matrix of the sweep, by columns.
    pub columns: &'s [V; MAX_LANES],
    /// The rounding errors of `columns`.
    pub rest: &'s [V; MAX_LANES],
    /// The steady motion.
    pub steady: Steady<V>,
    /// One where a row has its stage's geometry.
    pub moved: V,
    /// The part of gravity in the mixed displacement of a centre of mass.
    pub gravity: Vector<V>,
    /// The factor of applied forces: h², or the impulse's `h b_s`.
    pub forces: V,
}

impl<V: Numbers> Sweep<'_, V> {
    /// Several values mixed by the matrix of the sweep.
    #[inline(always)]
    pub fn mixed<const REFINED: bool, const N: usize>(&self, values: [V; N]) -> [V; N] {
        let mixed = V::mix_all(values, self.columns);
        if REFINED { sums(mixed, V::mix_all(values, self.rest)) } else { mixed }
    }

    /// [`Sweep::mixed`] of values that are in memory.
    #[inline(always)]
    pub fn mixed_stored<const REFINED: bool, const N: usize>(&self, values: &InLines<V::Stored, N>) -> [V; N] {
        let mixed = V::mix_stored(values, self.columns);
        if REFINED { sums(mixed, V::mix_stored(values, self.rest)) } else { mixed }
    }
}

impl<V: Numbers> Coefficients<V> {
    /// Data of the residual that all bodies of a step share.
    #[inline(always)]
    pub fn residual_sweep(&self, step: f64, gravity: &[f64; 3]) -> Sweep<'_, V> {
        let square = V::splat(-step) * V::splat(step);
        Sweep {
            columns: &self.residual,
            rest: &self.residual_rest,
            steady: self.steady(step),
            moved: self.moved,
            gravity: Vector(gravity.map(V::splat)).times(square),
            forces: -square,
        }
    }

    /// The steady motion over a step.
    #[inline(always)]
    pub fn steady(&self, step: f64) -> Steady<V> {
        let step = V::splat(step);
        let times = self.nodes * step;
        Steady { times, rest: self.nodes_rest.mul_add(step, self.nodes.lost(step, times)) }
    }
}

/// Sums, one by one.
#[inline(always)]
pub(crate) fn sums<V: Arithmetic, const N: usize>(mut values: [V; N], others: [V; N]) -> [V; N] {
    let mut index = 0;
    while index < N {
        values[index] = values[index] + others[index];
        index += 1;
    }
    values
}

/// Twelve numbers of a body, in memory.
pub type Stored<V> = InLines<<V as Numbers>::Stored, 12>;

/// The rows of all stages, with (`FORCED`) or without forces besides gravity, `REFINED` with twice the digits of the coefficients.
pub struct StageRows<'s, V: Numbers, const REFINED: bool, const FORCED: bool> {
    /// Data that all bodies share.
    pub sweep: Sweep<'s, V>,
    /// The tree.
    pub plan: &'s Plan,
    /// One entry a body.
    pub poses: &'s [StagePose<V>],
    /// One entry a degree of freedom.
    pub displacement: &'s [V],
    /// The start of the step.
    pub start: &'s Start<V::Real>,
    /// The forces, if there are any.
    pub applied: Option<&'s Applied<V>>,
    /// Length of the step (s).
    pub step: f64,
}

impl<V: Numbers, const REFINED: bool, const FORCED: bool> StageRows<'_, V, REFINED, FORCED> {
    /// The rotation vector of a ball joint, of which this is the first freedom, in these rows (rad).
    #[inline(always)]
    pub(crate) fn rotation(&self, freedom: usize) -> Vector<V> {
        rotation_vector(self.start, self.displacement, freedom).times(self.sweep.moved)
    }
}

impl<V: Numbers, const REFINED: bool, const FORCED: bool> Rows<V> for StageRows<'_, V, REFINED, FORCED> {
    const MOMENTA: bool = false;
    const EARLY: bool = V::STORES_EARLY;
    type Ahead = Stored<V>;
    #[inline(always)]
    fn pose(&self, body: usize) -> StagePose<V> {
        self.poses[body]
    }
    #[inline(always)]
    fn moved(&self) -> V {
        self.sweep.moved
    }
    #[inline(always)]
    fn tilt(&self, freedom: usize) -> Option<Tilt<V>> {
        Some(Tilt::of(self.rotation(freedom)))
    }
    #[inline(always)]
    fn gravity(&self) -> Vector<V> {
        self.sweep.gravity
    }
    #[inline(always)]
    fn path(&self, _: usize, known: &BodyStart<V::Real>, displaced: Vector<V>) -> Vector<V> {
        Vector(self.sweep.mixed::<REFINED, 3>(self.sweep.steady.path::<REFINED>(known, displaced)))
    }
    #[inline(always)]
    fn ahead(&self, known: &BodyStart<V::Real>, displaced: Vector<V>, turned: Turned<V>) -> Self::Ahead {
        V::store_all(self.sweep.steady.motion::<REFINED>(known, displaced, turned))
    }
    #[inline(always)]
    fn motion(&self, _: usize, _: &BodyStart<V::Real>, ahead: &Self::Ahead) -> (Vector<V>, Turned<V>) {
        let [x, y, z, turned @ ..] = self.sweep.mixed_stored::<REFINED, 12>(ahead);
        (Vector([x, y, z]), Turned::joined(turned))
    }
    #[inline(always)]
    fn spin(&self, _: usize, known: &BodyStart<V::Real>, turned: Turned<V>) -> Turned<V> {
        Turned::joined(self.sweep.mixed::<REFINED, 9>(self.sweep.steady.spin::<REFINED>(known, turned)))
    }
    #[inline(always)]
    fn swing(&self, _: usize, _: &[V::Real; 3], rate: V::Real, [sine, versine]: [V; 2]) -> [V; 2] {
        let ahead = self.sweep.steady.ahead::<REFINED>(V::whole(rate), sine);
        self.sweep.mixed::<REFINED, 2>([ahead, versine])
    }
    #[inline(always)]
    fn forces(&self) -> V {
        self.sweep.forces
    }
    #[inline(always)]
    fn wrench(&self, body: usize) -> Option<(Vector<V>, Vector<V>)> {
        let applied = if FORCED { self.applied? } else { return None };
        Some(applied.wrenches[body])
    }
    #[inline(always)]
    fn push(&self, freedom: usize) -> Option<Push<V>> {
        let applied = if FORCED { self.applied? } else { return None };
        let inertia = applied.shares * V::splat(self.step * applied.resistance[freedom]);
        let push = Push { effort: applied.efforts[freedom] * self.sweep.forces, inertia };
        Some(match applied.rotor(freedom) {
            None => push,
            Some((carried, inertia)) => push.plus(carried, V::splat(inertia)),
        })
    }
}
