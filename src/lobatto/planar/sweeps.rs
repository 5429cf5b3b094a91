//! The stage equations in a plane: poses, residuals and their solve, root to leaf, leaf to root, and root to leaf again.
//!
//! SO(2) is embedded in R² as `(cos, sin)`; `J` is the quarter turn. A body has turned by `φ_i` since the start of the step, with
//! `κ_i = cos φ_i − 1`, `σ_i = sin φ_i`; with the mixing matrix B, row k needs only these numbers of each body:
//!
//! ```text
//!     p_k = Σ_i B_ki κ_i,     q_k = Σ_i B_ki (σ_i − h c_i ω)
//!     a_k = a_k of the parent + (p + q J) arm of the parent's turn + Σ_i B_ki (d_i − h c_i ḋ)         [m]
//! ```
//!
//! because the displacement of an anchor is linear in the parent's `(κ, σ)`: the path from the root adds up mixed vectors, which space mixes for
//! every body. `d = Σ θ (1 + κ + σ J) e` are the slides; `a_k` begins at the root with `−h² g`. Then, about the anchor, with the geometry of the row,
//! `(1 + N_k) = (1 + κ_k) + σ_k J`, and r the arm to the centre of mass,
//!
//! ```text
//!     f_k = m a_k + (p_k + q_k J) m r                                              [kg m]
//!     e_k = I ((1 + κ_k) q_k − σ_k p_k) + (1 + N_k) m r × a_k                      [kg m²]
//! ```
//!
//! is the residual of [`crate::equations::residual`], whose third torque it is (I: about the anchor). The solve is the one of
//! [`crate::solve::sweeps`]; the momentum at the end of the step has the same residual, with the momentum weights in place of B.
//!
//! The sum along the path distinguishes these sweeps from the sweeps of space over other vectors: space mixes 12 numbers of every body, a plane two.
//! In the sweeps of space a chain of ten links in a plane takes 1.93 times as long: the table of [`crate::planar`].

use crate::planar::algebra::Vector2;
use crate::planar::articulated::Articulated2;
use crate::planar::body::PlanarBody;
use crate::planar::workspace::{PlanarStages, Turned};

use crate::numbers::lanes::Lanes;
use crate::numbers::series::{FEW, half_angle, half_angle_of_few};
use crate::plan::tree::Children;
use crate::stages::articulated::Push;
use crate::stages::rows::Sweep;
use catena_mechanism::description::joint::FreeRotation;

impl<V: Lanes> PlanarStages<V> {
    /// Root to leaf: turns and paths of all bodies.
    #[inline(always)]
    pub(crate) fn sweep_paths<const MOMENTUM: bool, const REFINED: bool>(&mut self, sweep: &Sweep<V>) {
        let few = self.largest <= FEW;
        let start = &self.start;
        for (index, (tree, flat)) in self.plan.tree.bodies.iter().zip(&self.plan.bodies).enumerate() {
            let known = &start.bodies[index];
            let (mut own, turns) = match tree.parent {
                Some(parent) => {
                    let mut own = self.turned[parent];
                    own.path = Vector2::splat(&known.arm).turned_plus(own.mixed_cosine, own.mixed_sine, own.path);
                    (own, true)
                }
                None => {
                    let [x, y, _] = sweep.gravity.0;
                    let path = Vector2([x, y]);
                    (Turned { path, ..Turned::zero() }, false)
                }
            };
            let rotation = tree.first_axis + tree.translations;
            if tree.translations > 0 {
                let mut slid = Vector2::zero();
                for freedom in tree.first_axis..rotation {
                    let axis = Vector2::splat(&start.axes[freedom]);
                    let axis = if turns { axis.turned_plus(own.cosine, own.sine, axis) } else { axis };
                    slid = axis.times_plus(self.displacement[freedom], slid);
                }
                let [x, y] = slid.0;
                let [u, v] = known.sliding;
                let mixed = Vector2([
                    mix_ahead::<V, MOMENTUM, REFINED>(sweep, x, u),
                    mix_ahead::<V, MOMENTUM, REFINED>(sweep, y, v),
                ]);
                own.path = own.path.plus(mixed);
                self.arms[index] = slid;
            }
            if tree.rotation != FreeRotation::None {
                let angle = self.displacement[rotation] * V::splat(flat.sign);
                let square = angle * angle;
                let (half_cosine, half_sine) = if few { half_angle_of_few(square) } else { half_angle(square) };
                let half_sine = half_sine * angle;
                let twice = half_sine + half_sine;
                let (cosine, sine) = (-(twice * half_sine), twice * half_cosine);
                (own.cosine, own.sine) = if turns {
                    let both = own.sine.neg_mul_add(sine, own.cosine.mul_add(cosine, cosine + own.cosine));
                    (both, own.sine.mul_add(cosine, own.cosine.mul_add(sine, sine + own.sine)))
                } else {
                    (cosine, sine)
                };
                [own.mixed_cosine] = sweep.mixed::<REFINED, 1>([own.cosine]);
                own.mixed_sine = mix_ahead::<V, MOMENTUM, REFINED>(sweep, own.sine, known.spin);
            }
            self.turned[index] = own;
        }
    }

    /// Leaf to root, after [`PlanarStages::sweep_paths`] with the same sweep: residuals or momenta, and the articulated
    /// factorisation of all rows.
    #[inline(always)]
    pub(crate) fn sweep_back<const MOMENTUM: bool, const FORCED: bool>(&mut self, sweep: &Sweep<V>) {
        let one = V::splat(1.0);
        let mut carried = Articulated2::zero();
        for index in (0..self.plan.bodies.len()).rev() {
            let (tree, flat) = (&self.plan.tree.bodies[index], &self.plan.bodies[index]);
            let known = &self.start.bodies[index];
            let turned = &self.turned[index];
            let (along, across) = row_turn::<V, MOMENTUM>(sweep, turned);
            let (mass, inertia) = (V::splat(known.mass), V::splat(known.inertia));
            let (heavy, force, torque) = own_residual(known, turned, (along, across));
            // Known exactly, the inertia would round differently from the momentum, and always to the same side.
            let inertia = if MOMENTUM { across.mul_add(across, along * along) * inertia } else { inertia };
            let (mut force, mut torque) = if MOMENTUM { (force.times(-one), -torque) } else { (force, torque) };
            if FORCED {
                (force, torque) = self.less_acting(index, sweep, force, torque);
            }
            let zero = V::zero();
            let own = Articulated2 { mass: [mass, zero, mass], coupling: heavy.quarter_turn(), inertia, force, torque };
            let mut total = match tree.children {
                Children::None => own,
                Children::Next => own.plus(&carried),
                Children::Slot(slot) => own.plus(&self.slots[slot]),
            };

            let rotation = tree.first_axis + tree.translations;
            if tree.rotation != FreeRotation::None {
                let push = self.push::<MOMENTUM, FORCED>(sweep, rotation, flat.sign);
                self.eliminated[rotation] = if tree.parent.is_none() && tree.translations == 0 {
                    total.solve_rotation(push)
                } else {
                    total.eliminate_rotation(push)
                };
            }
            let parent = match tree.parent {
                Some(parent) => Some(row_turn::<V, MOMENTUM>(sweep, &self.turned[parent])),
                None => None,
            };
            for freedom in (tree.first_axis..rotation).rev() {
                let axis = Vector2::splat(&self.start.axes[freedom]);
                let axis = match parent {
                    Some((along, across)) => axis.turned(along, across),
                    None => axis,
                };
                self.axes[freedom] = axis;
                let push = self.push::<MOMENTUM, FORCED>(sweep, freedom, 1.0);
                self.eliminated[freedom] = total.eliminate_translation(axis, push);
            }
            if let Some((along, across)) = parent {
                let arm = Vector2::splat(&known.arm).turned(along, across);
                let arm = if tree.translations > 0 { self.arms[index].times_plus(sweep.moved, arm) } else { arm };
                self.arms[index] = arm;
                let shifted = total.shifted(arm);
                match tree.parent_collects {
                    Children::Slot(slot) if !tree.first_collected => {
                        self.slots[slot] = self.slots[slot].plus(&shifted);
                    }
                    Children::Slot(slot) => self.slots[slot] = shifted,
                    _ => carried = shifted,
                }
            }
        }
    }

    /// Root to leaf: `α` of every degree of freedom.
    #[inline(always)]
    pub(crate) fn forward(&mut self, mut take: impl FnMut(&mut Self, usize, V)) {
        let mut twist = (Vector2::zero(), V::zero());
        for index in 0..self.plan.bodies.len() {
            let tree = &self.plan.tree.bodies[index];
            let (first, translations, children) = (tree.first_axis, tree.translations, tree.children);
            let (rotation, sign) = (tree.rotation, self.plan.bodies[index].sign);
            match tree.parent_collects {
                Children::None => twist = (Vector2::zero(), V::zero()),
                Children::Next => twist.0 = self.arms[index].quarter_turn().times_plus(twist.1, twist.0),
                Children::Slot(slot) => {
                    twist = self.twists[slot];
                    twist.0 = self.arms[index].quarter_turn().times_plus(twist.1, twist.0);
                }
            }
            for freedom in first..first + translations {
                let joint = self.eliminated[freedom];
                let alpha = joint.torque_ratio.neg_mul_add(twist.1, joint.force_ratio.dot_from(twist.0, joint.bias));
                twist.0 = self.axes[freedom].times_plus(alpha, twist.0);
                take(self, freedom, alpha);
            }
            if rotation != FreeRotation::None {
                let joint = self.eliminated[first + translations];
                let still = joint.force_ratio.dot_from(twist.0, joint.bias);
                let alpha = joint.torque_ratio.neg_mul_add(twist.1, still);
                twist.1 = twist.1 + alpha;
                take(self, first + translations, alpha * V::splat(sign));
            }
            if let Children::Slot(slot) = children {
                self.twists[slot] = twist;
            }
        }
    }

    /// A residual wrench less the forces that act on the body.
    #[inline(always)]
    pub(crate) fn less_acting(&self, body: usize, sweep: &Sweep<V>, force: Vector2<V>, torque: V) -> (Vector2<V>, V) {
        match self.acting.get(body) {
            Some((pull, turn)) => {
                let scale = sweep.forces;
                (pull.times_minus(scale, force), turn.neg_mul_add(scale, torque))
            }
            None => (force, torque),
        }
    }

    /// The part of a force along a degree of freedom, in the sense of the plane.
    #[inline(always)]
    pub(crate) fn push<const MOMENTUM: bool, const FORCED: bool>(
        &self,
        sweep: &Sweep<V>,
        freedom: usize,
        sign: f64,
    ) -> Option<Push<V>> {
        match &self.applied {
            Some(applied) if FORCED => {
                let push = Push {
                    effort: applied.efforts[freedom] * V::splat(sign) * sweep.forces,
                    inertia: applied.shares
                        * V::splat(if MOMENTUM { 0.0 } else { self.step * applied.resistance[freedom] }),
                };
                Some(match applied.rotor(freedom) {
                    None => push,
                    Some((carried, inertia)) => push.plus(carried * V::splat(sign), V::splat(inertia)),
                })
            }
            _ => None,
        }
    }
}

/// `(1 + N_k) m r`, `f_k` and `e_k` of a body with this turn `1 + N_k` at the rows' stages.
#[inline(always)]
pub(crate) fn own_residual<V: Lanes>(
    known: &PlanarBody,
    turned: &Turned<V>,
    (along, across): (V, V),
) -> (Vector2<V>, Vector2<V>, V) {
    let heavy_start = Vector2::splat(&known.heavy);
    let heavy = heavy_start.turned(along, across);
    let (cosine, sine, path) = (turned.mixed_cosine, turned.mixed_sine, turned.path);
    let force = heavy_start.turned_plus(cosine, sine, path.times(V::splat(known.mass)));
    let torque = heavy.cross_plus(path, across.neg_mul_add(cosine, along * sine) * V::splat(known.inertia));
    (heavy, force, torque)
}

/// The turn of a body at the rows' stages, as cosine and sine.
#[inline(always)]
pub(crate) fn row_turn<V: Lanes, const MOMENTUM: bool>(sweep: &Sweep<V>, turned: &Turned<V>) -> (V, V) {
    let one = V::splat(1.0);
    match MOMENTUM {
        true => (one + turned.cosine, turned.sine),
        false => (turned.cosine.mul_add(sweep.moved, one), turned.sine * sweep.moved),
    }
}

/// Mixes the deviation of a displacement from a constant velocity; for momenta, with that velocity.
#[inline(always)]
fn mix_ahead<V: Lanes, const MOMENTUM: bool, const REFINED: bool>(
    sweep: &Sweep<V>,
    displacement: V,
    velocity: f64,
) -> V {
    let velocity = V::splat(velocity);
    let [mixed] = sweep.mixed::<REFINED, 1>([sweep.steady.ahead::<REFINED>(velocity, displacement)]);
    if MOMENTUM { mixed + velocity } else { mixed }
}
