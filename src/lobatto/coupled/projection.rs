//! Projection on the closures at one configuration, with the least motion in the metric of the mass matrix.
//!
//! ```text
//!     velocities:  H dv = Jᵀ μ,  J (v + dv) = 0                     (2.5.11h) for what the tree's joints do not say
//!     positions:   H dq = Jᵀ μ,  g(q) + J dq = 0, repeated          Newton's method
//! ```
//!
//! The proximal term of the solve leaves a part ε of every gap. So the solve is repeated, with the same factors, until the gaps are rounding.

use crate::coupled::equations::{equations, find_empty};
use crate::coupled::known::Known;
use crate::coupled::lent::{ROUNDS, Rounds, owed};
use crate::coupled::space::Space;
use crate::coupled::system::{Coupled, Geometry, One};
use crate::equations::braking::Lean;
use crate::numbers::lanes::Lanes;
use crate::plan::tree::Plan;
use catena_mechanism::description::joint::FreeRotation;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::Exchange;
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::ranks::rows::{Row, circuits};
use nalgebra::Vector3;

/// The number in the only lane.
fn one(value: One) -> f64 {
    value.to_array()[0]
}

/// Mobilities below this count as nearly implied: the ε of ordinary solves leaves some 1e-8 of every mobility, and a position one milliradian from a
/// singular one leaves 1e-6.
const WEAK: f64 = 1e-6;

/// After a correction smaller than this (rad or m) the factors are good for the next, of which they leave such a part; unless the gaps
/// show, beside a singular position, that they are not.
const NEAR: f64 = 1e-6;
/// Factors of a position nearby leave less than this part of the rates of the gaps.
const LEFT: f64 = 1e-3;

/// The workspace of projections, in space unless it is said otherwise.
#[derive(Clone)]
pub struct Projection<G: Geometry<One> = Space<One>> {
    coupled: Coupled<One>,
    geometry: G,
    plan: G::Plan,
    increment: Vec<One>,
    displacement: Vec<One>,
    correction: Vec<f64>,
    /// Second derivatives of the gaps.
    curvatures: Vec<f64>,
    /// The impulses of all rows on velocities that were projected last [N s, N m s].
    impulses: Vec<f64>,
    /// Whether velocities that were projected last had to be solved for.
    solved: bool,
    /// Whether velocities are those of joints that are moved in time, and no changes of velocities.
    moving: bool,
    /// Whether the factors at hand are good where positions were projected last.
    near: bool,
    /// Whether factors of a configuration beside those that follow are at hand.
    factored: bool,
    /// The bodies on the circuit of every loop, on the branches of its first and of its second end.
    circuits: Vec<[Vec<usize>; 2]>,
    /// The positions with the smallest gap so far, and their rounding errors.
    nearest: [Vec<f64>; 2],
}

/// How far a projection got.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Projected {
    /// Largest gap left (m, rad, or their rates).
    pub gap: f64,
    /// The closure that has it: the loops first, then the mimics.
    pub worst: usize,
    /// Largest correction of any freedom.
    pub correction: f64,
}

impl Projection {
    /// The workspace for a mechanism in space.
    pub fn new(mechanism: &Mechanism) -> Self {
        Projection::of(mechanism, Space::new(mechanism, None), Plan::new(mechanism))
    }

    /// The wrench of the multipliers on the second end of a loop: force (N) and torque [N m] about its point, in the world.
    pub fn loop_wrench(&self, closure: usize, multipliers: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
        let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
        for (row, multiplier) in multipliers.iter().enumerate() {
            if self.coupled.closure_of_row()[row] == closure {
                let [a, b, c, x, y, z] = self.coupled.direction(row);
                force += Vector3::new(a, b, c) * *multiplier;
                torque += Vector3::new(x, y, z) * *multiplier;
            }
        }
        let point = Vector3::from(self.geometry.end_point(closure));
        (force, torque - point.cross(&force))
    }
}

impl<G: Geometry<One>> Projection<G> {
    /// The workspace for a mechanism in its geometry.
    pub fn of(mechanism: &Mechanism, geometry: G, plan: G::Plan) -> Self {
        let mut coupled = Coupled::of_one(mechanism, &geometry);
        // Room for the flags that every solve finds.
        coupled.known.empty = vec![false; coupled.closure_of_row().len()];
        Projection {
            curvatures: vec![0.0; coupled.closure_of_row().len()],
            impulses: vec![0.0; coupled.closure_of_row().len()],
            solved: false,
            moving: false,
            near: false,
            factored: false,
            nearest: [vec![0.0; mechanism.position_count], vec![0.0; mechanism.position_count]],
            circuits: circuits(mechanism),
            coupled,
            geometry,
            plan,
            increment: vec![One::zero(); mechanism.velocity_count],
            displacement: vec![One::zero(); mechanism.velocity_count],
            correction: vec![0.0; mechanism.velocity_count],
        }
    }

    /// Takes a state as a start. Does not allocate.
    pub(crate) fn place(&self, mechanism: &Mechanism, start: &mut G::Start, state: &State) {
        G::place(&self.plan, start, mechanism, state);
    }

    /// The gaps and gradients at the start of a step.
    fn evaluate(&mut self, start: &G::Start) {
        self.geometry.begin(&self.plan, start);
        self.coupled.begin();
        self.coupled.evaluate(&self.geometry);
        for (row, &gap) in self.coupled.mimic_rows().zip(G::mimic_gaps(start)) {
            self.coupled.gaps[row] = One::splat(gap);
        }
    }

    /// The rates of the gaps for the velocities of the freedoms.
    fn evaluate_rates(&mut self, mechanism: &Mechanism, start: &G::Start, velocity: &[f64]) {
        self.coupled.twists_of(&self.geometry, &self.plan, start, velocity);
        self.coupled.rates();
        let moved = G::mimic_rates(start);
        for ((row, mimic), moved) in self.coupled.mimic_rows().zip(&mechanism.mimics).zip(moved) {
            let rate = velocity[mimic.follower.freedom] - mimic.multiplier * velocity[mimic.leader.freedom];
            let rate = mimic.more.iter().fold(rate, |rate, (own, ratio)| rate - ratio * velocity[own.freedom]);
            self.coupled.gaps[row] = One::splat(if self.moving { rate - moved } else { rate });
        }
        if let Some(touching) = self.geometry.touching().filter(|touching| touching.exchanges()) {
            let Coupled { gaps, rows_of_loop, loops, .. } = &mut self.coupled;
            for (first, carried) in touching.carried(&rows_of_loop[*loops - touching.len()..*loops]) {
                carried.into_iter().enumerate().for_each(|(axis, rate)| gaps[first + axis] = gaps[first + axis] + rate);
            }
        }
    }

    /// Whether the velocities that follow are those of joints that are moved in time. Else they are changes of velocities, such as the answer to an
    /// impulse, and joints that are moved have none.
    pub fn take_motions(&mut self, moving: bool) {
        self.moving = moving;
    }

    /// The impulse of every equation on the velocities that were projected last [N s or N m s].
    pub(crate) fn impulses(&self) -> &[f64] {
        &self.impulses
    }

    /// The rows of the mimics.
    pub(crate) fn mimic_rows(&self) -> std::ops::Range<usize> {
        self.coupled.mimic_rows()
    }

    /// The largest gap as of the latest evaluation, and the closure that has it.
    pub fn largest_gap(&self) -> (f64, usize) {
        let mut worst = (0.0, 0);
        for (gap, &closure) in self.coupled.gaps.iter().zip(self.coupled.closure_of_row()) {
            let gap = one(*gap).abs();
            if gap > worst.0 || gap.is_nan() {
                worst = (gap, closure);
            }
        }
        worst
    }

    /// Solves for the present gaps; with new factors for this configuration, or again with the present ones.
    fn solve(&mut self, start: &G::Start, again: bool) {
        let Projection { coupled, geometry, plan, .. } = self;
        coupled.keep_gaps_of_motions(geometry, plan, start, &self.displacement);
        if again {
            coupled.solve_again(G::tree(plan), &mut self.increment);
        } else {
            find_empty(coupled, geometry, plan, start, &self.circuits);
            coupled.solve(geometry, plan, start, &self.displacement, &mut self.increment);
            self.factored = true;
        }
        for (correction, increment) in self.correction.iter_mut().zip(&self.increment) {
            *correction = one(*increment);
        }
    }

    /// Projects velocities at the configuration of `start`. Does not allocate.
    pub fn velocities(&mut self, mechanism: &Mechanism, start: &G::Start, velocity: &mut [f64]) -> Projected {
        self.near = false;
        self.velocities_here(mechanism, start, velocity)
    }

    /// The same where velocities were projected last, with the factors of that.
    pub fn velocities_again(&mut self, mechanism: &Mechanism, start: &G::Start, velocity: &mut [f64]) -> Projected {
        self.near = self.solved;
        self.velocities_here(mechanism, start, velocity)
    }

    /// Forgets the factors: the configurations that follow are not beside the last one.
    pub fn go_elsewhere(&mut self) {
        self.factored = false;
    }

    /// Projects velocities at a configuration beside the one that was factored last since [`Projection::go_elsewhere`], with these factors.
    pub fn velocities_beside(&mut self, mechanism: &Mechanism, start: &G::Start, velocity: &mut [f64]) -> Projected {
        self.near = self.factored;
        self.velocities_here(mechanism, start, velocity)
    }

    /// The same where positions were projected last, with the factors of that if they are good there.
    pub(crate) fn velocities_here(
        &mut self,
        mechanism: &Mechanism,
        start: &G::Start,
        velocity: &mut [f64],
    ) -> Projected {
        let nearby = std::mem::take(&mut self.near);
        self.evaluate(start);
        let mut done = Projected::default();
        self.solved = false;
        self.impulses.fill(0.0);
        // The matrix with friction is not symmetric, and its factors are not kept for another right-hand side.
        let leans = self.geometry.touching().is_some_and(|touching| !touching.leaning().is_empty());
        let mut rounds = Rounds::default();
        let mut first = 0.0;
        for round in 0..ROUNDS {
            self.evaluate_rates(mechanism, start, velocity);
            (done.gap, done.worst) = self.largest_gap();
            if !rounds.go_on(done.gap, owed(&self.coupled.known, &self.correction, velocity)) {
                break;
            }
            self.coupled.owe(&self.correction, round > 0);
            // Beside a singular position the factors of one nearby are not good.
            let stale = nearby && round == 1 && done.gap > LEFT * first;
            first = if round == 0 { done.gap } else { first };
            self.solve(start, (nearby || round > 0) && !stale && !leans);
            self.solved = true;
            for (impulse, increment) in self.impulses.iter_mut().zip(self.coupled.multiplier_increments()) {
                *impulse += one(*increment);
            }
            for (rate, correction) in velocity.iter_mut().zip(&self.correction) {
                *rate += correction;
                done.correction = done.correction.max(correction.abs());
            }
        }
        // The rates of locked freedoms become zero only now, so that the moving ones have received their share of the momenta.
        if !self.coupled.known.still.is_empty() {
            self.coupled.known.still_freedoms().for_each(|freedom| velocity[freedom] = 0.0);
            self.evaluate_rates(mechanism, start, velocity);
            (done.gap, done.worst) = self.largest_gap();
        }
        done
    }

    /// Projects the positions of a state, and takes it as a start. Does not allocate.
    pub fn positions(&mut self, mechanism: &Mechanism, start: &mut G::Start, state: &mut State) -> Projected {
        let mut done = Projected::default();
        let mut best = f64::INFINITY;
        let mut stalled = 0;
        let mut near = false;
        self.near = false;
        for _ in 0..ROUNDS {
            self.place(mechanism, start, state);
            self.evaluate(start);
            (done.gap, done.worst) = self.largest_gap();
            // Newton's first rounds may overshoot; rounding stalls.
            stalled = if done.gap < 0.5 * best { 0 } else { stalled + 1 };
            near &= done.gap < 0.1 * best;
            if done.gap < best {
                best = done.gap;
                self.nearest[0].copy_from_slice(&state.position);
                self.nearest[1].copy_from_slice(&state.compensation);
            }
            if done.gap == 0.0 || (stalled > 0 && done.gap < 1e-14) || stalled > 8 || !done.gap.is_finite() {
                break;
            }
            self.coupled.owe(&self.correction, false);
            self.solve(start, near);
            self.coupled.settle_lent(G::tree(&self.plan), &mut self.increment, &mut self.correction);
            self.shorten();
            state.displace(mechanism, &self.correction);
            let largest = self.correction.iter().fold(0.0_f64, |largest, correction| largest.max(correction.abs()));
            done.correction = done.correction.max(largest);
            near = largest < NEAR;
            self.near = near;
        }
        // The last round may have rounded more than it has closed.
        if best < done.gap || done.gap.is_nan() && best.is_finite() {
            state.position.copy_from_slice(&self.nearest[0]);
            state.compensation.copy_from_slice(&self.nearest[1]);
            self.place(mechanism, start, state);
            self.evaluate(start);
            (done.gap, done.worst) = self.largest_gap();
        }
        done
    }

    /// Keeps a correction within half a radian, where the equations still mean something.
    fn shorten(&mut self) {
        let turns = |plan: &crate::plan::tree::BodyPlan| {
            let first = plan.first_axis + plan.translations;
            match plan.rotation {
                FreeRotation::None => first..first,
                FreeRotation::AboutZ => first..first + 1,
                FreeRotation::Ball => first..first + 3,
            }
        };
        let rotations = G::tree(&self.plan).bodies.iter().flat_map(turns);
        let largest = rotations.map(|freedom| self.correction[freedom].abs()).fold(0.0, f64::max);
        if largest > 0.5 {
            for correction in &mut self.correction {
                *correction *= 0.5 / largest;
            }
        }
    }

    /// Corrects joint accelerations so that the closures hold, `H da = Jᵀ μ`, `J a + J̇ v = 0`, where `second_derivatives` writes the second
    /// derivatives of all equations for accelerations; sums μ [N or N m] in `multipliers`. Does not allocate.
    pub fn accelerations(
        &mut self,
        start: &G::Start,
        acceleration: &mut [f64],
        multipliers: &mut [f64],
        second_derivatives: impl FnMut(&[f64], &mut [f64]),
    ) {
        self.go_elsewhere();
        self.accelerations_beside(start, acceleration, multipliers, second_derivatives);
    }

    /// The same at a configuration beside the one that was factored last since [`Projection::go_elsewhere`], with these factors: the closures hold, and
    /// a correction is off by the part of it by which the equations of both configurations differ.
    pub fn accelerations_beside(
        &mut self,
        start: &G::Start,
        acceleration: &mut [f64],
        multipliers: &mut [f64],
        mut second_derivatives: impl FnMut(&[f64], &mut [f64]),
    ) {
        self.evaluate(start);
        multipliers.fill(0.0);
        let beside = self.factored;
        let (mut rounds, mut first) = (Rounds::default(), 0.0);
        for round in 0..ROUNDS {
            second_derivatives(acceleration, &mut self.curvatures);
            for (gap, &value) in self.coupled.gaps.iter_mut().zip(&self.curvatures) {
                *gap = One::splat(value);
            }
            let (gap, _) = self.largest_gap();
            if !rounds.go_on(gap, owed(&self.coupled.known, &self.correction, acceleration)) {
                break;
            }
            self.coupled.owe(&self.correction, round > 0);
            let stale = beside && round == 1 && gap > LEFT * first;
            first = if round == 0 { gap } else { first };
            self.solve(start, (beside || round > 0) && !stale);
            for (value, correction) in acceleration.iter_mut().zip(&self.correction) {
                *value += correction;
            }
            for (sum, increment) in multipliers.iter_mut().zip(self.coupled.multiplier_increments()) {
                *sum += one(*increment);
            }
        }
        // Only now, because the multipliers have the forces that hold them.
        for freedom in self.coupled.known.still_freedoms() {
            acceleration[freedom] = 0.0;
        }
    }

    /// Lets the multipliers of contacts push beside their gradients in the projections that follow; an empty list makes them push along the
    /// gradients.
    pub(crate) fn lean(&mut self, leans: &[Lean]) {
        if let Some(touching) = self.geometry.touching_mut() {
            touching.lean(leans);
        }
    }

    /// Energy that the friction at the end of a step dissipated in the latest projection of velocities, and the work of driven surfaces (J).
    pub(crate) fn exchanged(&self) -> Exchange {
        let mut exchange = Exchange::default();
        let Some(touching) = self.geometry.touching() else { return exchange };
        let touches = self.coupled.rows_of_touches(touching);
        for (lean, rows) in touching.leaning().iter().zip(touches).filter(|(_, rows)| !rows.is_empty()) {
            exchange.friction += lean.slip * self.impulses[rows.start];
            exchange.work += lean.belt * self.impulses[rows.start];
        }
        for (first, carried) in touching.carried(touches) {
            let [along, across] = carried.map(one);
            exchange.work -= along * self.impulses[first] + across * self.impulses[first + 1];
        }
        exchange
    }

    /// Takes over the flags from kinematics, but for the equations that are empty, which every solve finds itself.
    pub fn heed(&mut self, known: Known) {
        let empty = std::mem::take(&mut self.coupled.known.empty);
        self.coupled.known = Known { empty, ..known };
    }

    /// The ranks and flags of the closures, with the equations that were empty at the latest solve.
    pub fn known(&self) -> &Known {
        &self.coupled.known
    }

    /// Number of equations that the others imply, or nearly imply, where velocities were projected last; `None` where they needed no
    /// solve, which alone would have told.
    pub fn weak(&self) -> Option<usize> {
        let weak = |left: &&f64| left.is_nan() || left.abs() <= WEAK;
        self.solved.then(|| self.coupled.left_over.iter().filter(weak).count())
    }

    /// Finds the equations that are empty at the start of a step.
    pub fn find_empty(&mut self, start: &G::Start) {
        self.evaluate(start);
        find_empty(&mut self.coupled, &self.geometry, &self.plan, start, &self.circuits);
    }

    /// The equations at the start of a step, dimensionless with the sizes of the loops and the lengths of the freedoms, without the mimic relations.
    pub fn equations(&mut self, start: &G::Start, sizes: &[f64], lengths: &[f64]) -> Vec<Row> {
        self.evaluate(start);
        equations(&self.coupled, &self.geometry, &self.plan, start, &self.circuits, [sizes, lengths])
    }

    /// The gaps of all equations at the start of a step.
    pub fn gaps(&mut self, start: &G::Start) -> Vec<f64> {
        self.evaluate(start);
        self.coupled.gaps.iter().map(|&gap| one(gap)).collect()
    }

    /// The rates of the gaps for velocities of the freedoms, after [`Projection::gaps`].
    pub fn gap_rates(&mut self, mechanism: &Mechanism, start: &G::Start, velocity: &[f64]) -> Vec<f64> {
        self.evaluate_rates(mechanism, start, velocity);
        self.coupled.gaps.iter().map(|&gap| one(gap)).collect()
    }

    /// Number of equations of all closures.
    pub fn row_count(&self) -> usize {
        self.coupled.closure_of_row().len()
    }
}
