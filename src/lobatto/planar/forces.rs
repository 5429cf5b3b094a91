//! Forces in a plane at all stages at once: efforts along freedoms and springs as in space ([`crate::equations::forces`],
//! [`crate::equations::springs`]), and wrenches (force F, torque M about the normal) at an arm r from the anchor:
//!
//! ```text
//!     f = F  (N),   t = M + ((1 + N) r) × F  [N m],   power of M:  M φ̇  (W)
//! ```
//!
//! with `φ̇` from the rates of cosine and sine, `κ̇` and `σ̇`, by the scheme: `φ̇ = (1 + κ) σ̇ − σ κ̇`.

use crate::equations::holding::add_holding;
use crate::equations::loads::{LoadedBodies, add_loads};
use crate::equations::springs::{BodiesAtStages, add_springs};
use crate::numbers::lanes::Lanes;
use crate::planar::algebra::Vector2;
use crate::planar::force_plan::ForcesStart;
use crate::planar::workspace::PlanarStages;
use crate::stages::coefficients::Coefficients;
use crate::stages::force_motion::{Motion, Place};
use crate::stages::forces::Applied;
use catena_mechanism::forces::total::Exchange;

impl<V: Lanes> PlanarStages<V> {
    /// After [`PlanarStages::sweep_paths`]: the forces of the rows; for a solved step, the forces at its `end`, in the last active lane, with the
    /// energy exchanged in the step.
    #[inline(always)]
    pub(crate) fn sweep_applied(&mut self, coefficients: &Coefficients<V>, end: bool) {
        let Some(mut applied) = self.applied.take() else { return };
        if !self.plan.forces.is_empty() {
            self.sweep_anchors();
        }
        applied.evaluate_places(
            self.step,
            end,
            #[inline(always)]
            |applied, place, at_end| self.evaluate(applied, coefficients, place, at_end, end),
        );
        if end {
            applied.exchange.work += applied.driven_work(&self.displacement, coefficients.active);
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
        end: bool,
        account: bool,
    ) -> Exchange {
        let ForcesStart { extensions, lines, arms, loads, holding } = &self.start.applied;
        let motion = Motion {
            displacement: &self.displacement,
            rates: &self.start.rates,
            extensions,
            times: coefficients.nodes * V::splat(self.step),
            inverse: V::splat(1.0 / self.step),
            step: self.step,
            since: applied.time,
            coefficients,
        };
        let (mut dissipated, mut work) = applied.evaluate_scalars(&motion, place, end);
        let mut acting = std::mem::take(&mut self.acting);
        acting.fill((Vector2::zero(), V::zero()));
        let springs = self.plan.forces.lines.iter().zip(lines);
        let springs = springs.map(|(line, known)| ([line.ends[0].body, line.ends[1].body], &line.law, known));
        dissipated = add_springs(self, springs, &motion, place, &mut acting, dissipated);
        for (wrench, arm) in self.plan.forces.wrenches.iter().zip(arms) {
            let turned = &self.turned[wrench.body];
            let (cosine, sine) = (turned.cosine * place.moved, turned.sine * place.moved);
            let arm = Vector2::splat(arm);
            let lever = arm.turned_plus(cosine, sine, arm);
            let (force, torque) = (Vector2::splat(&wrench.force), V::splat(wrench.torque));
            let sum = &mut acting[wrench.body];
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
        let [x, y, _] = self.plan.gravity;
        let holding = applied.plan.holding.iter().zip(holding);
        work = add_holding(self, holding, &[x, y], &motion, place, &mut applied.efforts, work);
        let loads = applied.plan.on_bodies.iter().zip(loads);
        (dissipated, work) = add_loads(self, loads, &motion, place, &mut acting, (dissipated, work));
        self.acting = acting;
        if account {
            let [dissipated, work] = [dissipated, work].map(|power| (power * place.weights).sum());
            Exchange { dissipated, work, ..Exchange::default() }
        } else {
            Exchange::default()
        }
    }
}

impl<V: Lanes> LoadedBodies<V> for PlanarStages<V> {
    type Torque = f64;

    #[inline(always)]
    fn torque(&self, _: usize, torque: &f64, _: bool, _: &Place<V>) -> V {
        V::splat(*torque)
    }

    #[inline(always)]
    fn spin(&self, body: usize, motion: &Motion<V>, place: &Place<V>) -> V {
        let turned = &self.turned[body];
        let (cosine, sine) = (turned.cosine * place.moved, turned.sine * place.moved);
        let along = turned.cosine.mix(&place.velocity) * motion.inverse;
        let across = motion.rate(place, turned.sine, self.start.bodies[body].spin);
        sine.neg_mul_add(along, cosine.mul_add(across, across))
    }

    #[inline(always)]
    fn scaled(axial: V, factor: V) -> V {
        axial * factor
    }

    #[inline(always)]
    fn sum(a: V, b: V) -> V {
        a + b
    }

    #[inline(always)]
    fn along(a: V, b: V, start: V) -> V {
        a.mul_add(b, start)
    }
}

impl<V: Lanes> BodiesAtStages<V> for PlanarStages<V> {
    type Vector = Vector2<V>;

    #[inline(always)]
    fn swing(&self, body: usize, arm: &[f64; 2]) -> Vector2<V> {
        let turned = &self.turned[body];
        Vector2::splat(arm).turned(turned.cosine, turned.sine)
    }

    #[inline(always)]
    fn anchor(&self, body: usize) -> Vector2<V> {
        self.anchors[body]
    }
}
