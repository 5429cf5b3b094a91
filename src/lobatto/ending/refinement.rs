//! Iterative refinement of the velocities at the end of a step, where rounding has lost too many digits of the articulated inertias.
//!
//! Beside a singular position of its coordinates, such as two axes of a gimbal that nearly coincide, the `d = sᵀ A s` of a joint is a small
//! difference of large numbers, and the rate of that joint is large and off by as large a part of itself as `d`. The momenta of the bodies keep all
//! their digits, and measure this error:
//!
//! ```text
//!     H(q̄) δ = Sᵀ (p̄ − M S v̄),   v̄ ← v̄ + δ        with the same factors, while |δ| falls;   |δ|² = δᵀ H δ
//!     2T = |v̄|² = Σ α₀² d by the factors,   = Σ (momentum · velocity) by the bodies        [J, in the unit of mass of the step]
//! ```
//!
//! If no digits are lost, both kinetic energies agree to 1e-14 of themselves, on chains with mass ratios of ten thousand, too. That is nearly
//! everywhere, and there is no more to do than to compare them. Source: N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd edition
//! (2002), chapter 12.

use crate::ending::velocities::{EndRows, Ending, Motion};
use crate::equations::residual::body_residual;
use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::{Arithmetic, Numbers};
use crate::plan::tree::Plan;
use crate::stages::factors::Factors;
use crate::stages::row_geometry::LookAhead;
use crate::stages::workspace::Stages;

/// Kinetic energies that differ by a larger part of them say that digits are lost.
const LOST: f64 = 1e-12;

/// A correction below this part of the velocities is the last: the next would be as much smaller again.
const SETTLED: f64 = 1e-8;

/// A correction has to be at most this part of the value it corrects: otherwise the factors do not even roughly belong to the mechanism.
const FALLS: f64 = 0.5;

/// There are no more corrections than this.
const ROUNDS: usize = 5;

/// Whether velocities of this square lack digits, with which the bodies have this kinetic energy (J, in the unit of mass of the step).
pub fn have_lost_digits(square: f64, kinetic: f64) -> bool {
    (0.5 * square - kinetic).abs() > LOST * kinetic
}

impl<E: Arithmetic<Real = f64>> Ending<E> {
    /// Refines the velocities that [`Ending::velocities`] has found at the end of a step under gravity alone, and of which the square was the `last`.
    #[inline(always)]
    pub fn refine<V: Numbers<One = E, Real = f64>>(
        &mut self,
        stages: &Stages<V>,
        gravity: &[f64; 3],
        velocity: &mut [f64],
        mut last: f64,
    ) {
        let (plans, start) = (&stages.plan, &stages.start);
        let mut carried = std::mem::take(&mut self.carried);
        for _ in 0..ROUNDS {
            let rows = self.rows::<V, true, false>(stages, gravity);
            self.factors.twists_at(plans, velocity, &mut carried);
            for (index, plan) in plans.bodies.iter().enumerate() {
                let (linear, angular) = carried[index];
                let known = &start.bodies[index];
                carried[index] = if let Some(pivot) = plan.pivot {
                    // Only the component along the axis is used.
                    (Vector::zero(), angular.times(E::splat(start.pivots[pivot].inertia)))
                } else if plan.slides {
                    (linear.times(E::splat(known.mass)), Vector::zero())
                } else {
                    let body = body_residual(&rows, index, plan, known, &LookAhead::new(()));
                    body.with_inertia().momentum(linear, angular)
                };
            }
            let left = EndRows { carried: Some(&carried), ..rows };
            self.factors.gather(plans, start, &left, &mut LookAhead::new(()));
            let square = self.factors.square().lane(0);
            // Also if either is no number.
            let falls = square <= FALLS * FALLS * last;
            if falls {
                self.factors.solve(
                    plans,
                    #[inline(always)]
                    |freedom, rate| velocity[freedom] += rate.lane(0),
                );
            }
            if !falls || square <= SETTLED * SETTLED * last {
                break;
            }
            last = square;
        }
        self.carried = carried;
    }
}

impl<E: Arithmetic> Factors<E> {
    /// `|x|²` of the solution of which the way to the root is done.
    #[inline(always)]
    pub(crate) fn square(&self) -> E {
        let mut square = E::zero();
        for joint in &self.eliminated {
            square = (joint.bias * joint.bias).mul_add(joint.inverse.reciprocal(), square);
        }
        square
    }
}

impl<E: Arithmetic<Real = f64>> Factors<E> {
    /// Root to leaf: the twist of every body at these velocities.
    #[inline(always)]
    fn twists_at(&self, plans: &Plan, velocity: &[f64], twists: &mut [Motion<E>]) {
        for (index, plan) in plans.bodies.iter().enumerate() {
            let (mut linear, mut angular) = (Vector::zero(), Vector::zero());
            if let Some(parent) = plan.parent {
                angular = twists[parent].1;
                linear = angular.cross_plus(self.arms[index], twists[parent].0);
            }
            for freedom in plan.freedoms() {
                let (axis, rate) = (self.eliminated[freedom].axis, E::splat(velocity[freedom]));
                if freedom < plan.first_axis + plan.translations {
                    linear = axis.times_plus(rate, linear);
                } else {
                    angular = axis.times_plus(rate, angular);
                }
            }
            twists[index] = (linear, angular);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::lanes::{Isa, Lanes};
    use crate::tableau::butcher::Tableau;
    use crate::vectors::portable::Portable;
    use crate::vectors::x86::Avx256;
    use catena_mechanism::description::joint::{Joint, JointKind, Pose};
    use catena_mechanism::description::mechanism::{Body, Mechanism};
    use catena_mechanism::motion::state::State;
    #[cfg(target_arch = "x86_64")]
    use nalgebra::{Rotation3, Translation3, Vector3};

    /// Bodies that are eliminated in every possible way, on frames that are not aligned with each other.
    fn every_kind_of_body() -> Mechanism {
        use JointKind::{Floating, Planar, Prismatic, Revolute, Spherical};
        let kinds: [(JointKind, Option<usize>, Vector3<f64>); 9] = [
            (Revolute, None, Vector3::new(0.05, 0.08, 0.1)),
            (Spherical, Some(0), Vector3::new(0.06, 0.07, 0.1)),
            (Revolute, Some(0), Vector3::repeat(0.04)),
            (Prismatic, None, Vector3::new(0.05, 0.08, 0.1)),
            (Prismatic, Some(3), Vector3::new(0.05, 0.08, 0.1)),
            (Planar, Some(4), Vector3::new(0.04, 0.08, 0.1)),
            (Floating, None, Vector3::new(0.05, 0.08, 0.1)),
            (Prismatic, Some(6), Vector3::new(0.05, 0.08, 0.1)),
            (Revolute, Some(7), Vector3::new(0.05, 0.08, 0.1)),
        ];
        let bodies = kinds.iter().enumerate().map(|(index, &(kind, parent, inertia))| {
            let frame = |at: f64| {
                let turn = Rotation3::from_euler_angles(at, 0.4 * index as f64 - 0.3 * at, 0.5 - at);
                Pose::from_parts(Translation3::new(0.3 * at, -0.1, 0.05 * index as f64), turn)
            };
            let joint = Joint::new(&format!("joint {index}"), kind, frame(0.7), frame(-0.5));
            Body { name: format!("body {index}"), parent, mass: 1.0 + 0.1 * index as f64, inertia, joint }
        });
        Mechanism::new("every kind", Vector3::new(1.0, -2.0, -9.0), bodies.collect()).unwrap()
    }

    fn velocities_that_are_off_come_back<V: Lanes>() {
        let mechanism = every_kind_of_body();
        let plan = Plan::lean(&mechanism, &[]);
        assert!(plan.bodies[0].pivot.is_some() && plan.bodies[3].slides && plan.bodies[4].slides);
        let tableau = Tableau::of(V::COUNT.min(8) + 1).unwrap();
        let mut state = State::zero(&mechanism);
        for (index, rate) in state.velocity.iter_mut().enumerate() {
            *rate = 2.0 * (index as f64).sin();
        }
        let mut stages = Stages::<V>::planned(plan.clone(), &mechanism, tableau);
        stages.start.set(&mechanism, &state);
        stages.step = 0.05;
        let gravity = mechanism.gravity.into();
        let mut velocity = vec![0.0; mechanism.velocity_count];
        let mut ending = Ending::new(&plan, velocity.len(), tableau);
        V::run(|| {
            for _ in 0..3 {
                stages.sweep_poses();
                stages.sweep_residual(&gravity);
                stages.sweep_increments();
                stages.advance();
            }
            stages.sweep_poses();
            let square = ending.velocities::<V, true, false>(&stages, &gravity, &mut velocity);
            let solved = velocity.clone();
            for (index, rate) in velocity.iter_mut().enumerate() {
                *rate += 0.01 * (3.0 * index as f64).cos();
            }
            ending.refine(&stages, &gravity, &mut velocity, square);
            for (index, (refined, solved)) in velocity.iter().zip(&solved).enumerate() {
                // Some roundings of rates of ten.
                assert!((refined - solved).abs() < 1e-13, "rate {index}: {refined} and {solved}");
            }
        });
    }

    #[test]
    fn velocities_that_are_off_come_back_to_those_of_the_momenta_for_every_kind_of_body() {
        // This test has vectors of arrays and of registers; `tests/scheme/refinement.rs` and `tests/program/stress.rs` have the others.
        velocities_that_are_off_come_back::<Portable<4>>();
        #[cfg(target_arch = "x86_64")]
        if Isa::detect() != Isa::Portable {
            velocities_that_are_off_come_back::<Avx256>();
        }
    }

    #[test]
    fn digits_are_lost_where_kinetic_energies_differ_and_not_at_rest_nor_of_what_is_no_number() {
        assert!(have_lost_digits(2.0, 1.0 + 1e-11) && have_lost_digits(2.0, 1.0 - 1e-11));
        assert!(!have_lost_digits(2.0, 1.0 + 1e-13) && !have_lost_digits(0.0, 0.0) && !have_lost_digits(f64::NAN, 1.0));
    }
}
