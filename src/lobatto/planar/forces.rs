//! Forces in a plane at all stages at once: those of [`crate::equations::forces`], with lines and wrenches projected.

use crate::numbers::lanes::Lanes;
use crate::planar::algebra::Vector2;
use crate::planar::force_plan::ForcesStart;
use crate::planar::workspace::PlanarStages;
use crate::stages::coefficients::Coefficients;
use crate::stages::force_motion::{Motion, Place};
use crate::stages::forces::Applied;
use catena_mechanism::forces::point_spring::NO_LENGTH;
use catena_mechanism::forces::total::Exchange;

impl<V: Lanes> PlanarStages<V> {
    /// After [`PlanarStages::sweep_paths`]: the forces of the rows; for a solved step, those at its `end`, in the last active lane,
    /// with the energy exchanged in the step.
    #[inline(always)]
    pub(crate) fn sweep_applied(&mut self, coefficients: &Coefficients<V>, end: bool) {
        let Some(mut applied) = self.applied.take() else { return };
        if !self.plan.forces.is_empty() {
            self.sweep_anchors();
        }
        let (mut dissipated, mut work) = (0.0, 0.0);
        // One call in a loop, so that there is one copy of it.
        for at_end in [false, true] {
            if at_end && !end {
                break;
            }
            let place = if at_end { applied.end } else { applied.rows };
            let powers = self.evaluate(&mut applied, coefficients, &place, end);
            dissipated += self.step * powers.dissipated;
            work += self.step * powers.work;
        }
        if end {
            work += applied.driven_work(&self.displacement, coefficients.active);
            applied.exchange = Exchange { dissipated, work };
        }
        self.applied = Some(applied);
    }

    /// Root to leaf: how far each anchor has moved since the start, at all stages.
    #[inline(always)]
    pub(crate) fn sweep_anchors(&mut self) {
        for (index, tree) in self.plan.tree.bodies.iter().enumerate() {
            let known = &self.start.bodies[index];
            let (mut moved, slid_with) = match tree.parent {
                Some(parent) => {
                    let turned = &self.turned[parent];
                    let arm = Vector2::splat(&known.arm);
                    (arm.turned_plus(turned.cosine, turned.sine, self.anchors[parent]), Some(turned))
                }
                None => (Vector2::zero(), None),
            };
            for freedom in tree.first_axis..tree.first_axis + tree.translations {
                let axis = Vector2::splat(&self.start.axes[freedom]);
                let axis = match slid_with {
                    Some(turned) => axis.turned_plus(turned.cosine, turned.sine, axis),
                    None => axis,
                };
                moved = axis.times_plus(self.displacement[freedom], moved);
            }
            self.anchors[index] = moved;
        }
    }

    /// The forces in one place; where one has to `account` for them, their powers, weighted.
    #[inline(always)]
    fn evaluate(
        &mut self,
        applied: &mut Applied<V>,
        coefficients: &Coefficients<V>,
        place: &Place<V>,
        account: bool,
    ) -> Exchange {
        let ForcesStart { extensions, lines, arms } = &self.start.applied;
        let motion = Motion {
            displacement: &self.displacement,
            rates: &self.start.rates,
            extensions,
            times: coefficients.nodes * V::splat(self.step),
            inverse: V::splat(1.0 / self.step),
        };
        let mut dissipated = applied.evaluate_scalars(&motion, place);
        let mut work = V::zero();
        self.acting.fill((Vector2::zero(), V::zero()));
        for (line, known) in self.plan.forces.lines.iter().zip(lines) {
            let mut swings = [Vector2::zero(); 2];
            let mut moves = [Vector2::zero(); 2];
            for side in 0..2 {
                if let Some(body) = line.ends[side].body {
                    let turned = &self.turned[body];
                    swings[side] = Vector2::splat(&known.arms[side]).turned(turned.cosine, turned.sine);
                    moves[side] = swings[side].plus(self.anchors[body]);
                }
            }
            let change = moves[1].minus(moves[0]);
            let separation = Vector2::splat(&known.separation);
            let stretched = separation.plus(change);
            let square = stretched.dot_plus(stretched, V::splat(known.square + NO_LENGTH));
            let along = separation.plus(stretched).dot(change);
            let taut = line.law.stretched(&motion, place, square, along, (known.length, known.rate));
            dissipated = taut.braking.mul_add(taut.rate, dissipated);
            let pull = change.times_plus(place.moved, separation).times(taut.per_length).times(taut.tension);
            for side in 0..2 {
                if let Some(body) = line.ends[side].body {
                    let force = if side == 0 { pull } else { pull.times(V::splat(-1.0)) };
                    let arm = swings[side].times_plus(place.moved, Vector2::splat(&known.arms[side]));
                    let sum = &mut self.acting[body];
                    sum.0 = sum.0.plus(force);
                    sum.1 = arm.cross_plus(force, sum.1);
                }
            }
        }
        for (wrench, arm) in self.plan.forces.wrenches.iter().zip(arms) {
            let turned = &self.turned[wrench.body];
            let (cosine, sine) = (turned.cosine * place.moved, turned.sine * place.moved);
            let arm = Vector2::splat(arm);
            let lever = arm.turned_plus(cosine, sine, arm);
            let (force, torque) = (Vector2::splat(&wrench.force), V::splat(wrench.torque));
            let sum = &mut self.acting[wrench.body];
            sum.0 = sum.0.plus(force);
            sum.1 = lever.cross_plus(force, sum.1 + torque);
            if account && wrench.torque != 0.0 {
                // The skew part of Ω (1 + N)ᵀ, with Ω as it comes from the stages.
                let along = turned.cosine.mix(&place.velocity) * motion.inverse;
                let across = motion.rate(place, turned.sine, self.start.bodies[wrench.body].spin);
                let spin = sine.neg_mul_add(along, cosine.mul_add(across, across));
                work = torque.mul_add(spin, work);
            }
        }
        if account {
            Exchange { dissipated: (dissipated * place.weights).sum(), work: (work * place.weights).sum() }
        } else {
            Exchange::default()
        }
    }
}
