//! A first-order step over a position in which joint coordinates are singular, made if no step of the scheme can be: gimbal lock.
//!
//! Near such a position the bodies move smoothly, and joints with almost parallel axes turn against each other at rates without bound. The step moves
//! the joints without these rates, and hands the motion of the bodies on:
//!
//! ```text
//!     H̃ = D^-½ H D^-½ = U Λ Uᵀ,  c = Uᵀ D^½ v₀              D: the diagonal of H, so that units do not count
//!     q₁ = q₀ + h D^-½ U c̃,      c̃_k = c_k, but no joint moves by more than 0.01 with a mode of Λ_k < 1e-4
//!     v₁ = Y(q₁) Σ Jᵀ(q₁) (m v + h (m g + F), R J Rᵀ ω + h T)        v, ω: of each body at q₀;   F, T: forces on it
//! ```
//!
//! so that the bodies are off by `h²` and by the small motion of the modes that were cut. Limits and friction follow as an event at the end. Y is the
//! response with all closures ([`crate::instant::dynamics::response`]).

use crate::events::effects::resting::energy;
use crate::events::integrator::Eventful;
use crate::events::modes::mode::JointMode;
use crate::instant::dynamics::mass_matrix::mass_matrix;
use crate::instant::holding::blocks::row_of_freedom;
use crate::instant::start::assembly::assemble_nearby;
use crate::mechanism::forces::total::{BodyWrench, body_wrenches, joint_efforts};
use crate::mechanism::motion::efforts::efforts_of_wrenches;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::StepOutcome;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector, Dyn, SymmetricEigen};

/// A mode of H̃ is light if its eigenvalue is below this: axes that are 14 mrad from parallel.
const LIGHT: f64 = 1e-4;
/// Light modes move a joint in one step by this much at most (rad or m).
const REACH: f64 = 1e-2;

impl Eventful {
    /// Makes such a step towards `until` from the start of the step that failed.
    pub(super) fn pass_singular(&mut self, inputs: Inputs, state: &mut State, until: f64) -> StepOutcome {
        let start = self.trial.origin.clone();
        state.copy_from(&start);
        let step = self.begin_first_order(start.time).min(until - start.time);
        let efforts = self.mode.driving_efforts(&self.model.elements, inputs, state);
        let momenta = self.momenta(&start, step);
        let moved: Vec<f64> = regular_rates(&mass_matrix(&self.model.whole, &start), &start.velocity, step);
        let moved: Vec<f64> = moved.iter().map(|rate| step * rate).collect();
        state.displace(&self.model.whole, &moved);
        state.time = start.time + step;
        self.put_within_limits(state);
        if self.model.whole.has_closures() {
            state.velocity.fill(0.0);
            // If it fails, a closure stays open by the error of a first-order step.
            let _ = assemble_nearby(&self.model.whole, state);
        }
        let velocity = self.velocities_of(momenta, &efforts, step, state);
        if velocity.iter().all(|rate| rate.is_finite()) {
            state.velocity.copy_from_slice(&velocity);
        } else {
            state.velocity.copy_from_slice(&start.velocity);
        }
        let work: f64 = efforts.iter().zip(&moved).map(|(effort, moved)| effort * moved).sum();
        self.bound(&start, state, work);
        self.tally.first_order = (self.tally.first_order.0 + 1, self.tally.first_order.1 + step);
        self.tally.unsolved += 1;
        self.see_jump(&start, state);
        self.progress.stepped_over = Some(state.clone());
        self.previous.outside.clear();
        self.previous.outside.extend_from_slice(inputs.efforts);
        let _ = self.pass_anew(inputs, state);
        let lost = energy(&self.model.whole, &start).total() + work - energy(&self.model.whole, state).total();
        let piece = self.workspaces.active_mut();
        piece.small = piece.moving.gather(&self.model.whole, state);
        self.tally.steps += 1;
        self.tally.stepped += step;
        StepOutcome::new(step, 1, self.exchange_of_balance(work, lost))
    }

    /// Whether the last step began near such a position.
    pub(super) fn starts_singular(&self) -> bool {
        let mass = mass_matrix(&self.model.whole, &self.trial.origin);
        modes(&mass).is_some_and(|(_, eigen)| eigen.eigenvalues.iter().any(|value| *value < LIGHT))
    }

    /// Whether joints are held while loops are closed: near a dead point the rest of a loop may move at rates without bound, or not at all.
    pub(super) fn holds_in_loops(&self) -> bool {
        let held = |mode: &JointMode| matches!(mode, JointMode::Held { .. });
        !self.model.whole.loops.is_empty() && self.mode.joints.iter().any(held)
    }

    /// Linear and angular momentum of each body about its centre of mass after the forces on it have acted for a step (s).
    fn momenta(&self, start: &State, step: f64) -> Vec<BodyWrench> {
        let bodies = body_states(&self.model.whole, start);
        let mut momenta = vec![BodyWrench::default(); bodies.len()];
        body_wrenches(&self.model.whole, start.time, &bodies, &mut momenta);
        for ((momentum, at), body) in momenta.iter_mut().zip(&bodies).zip(&self.model.whole.bodies) {
            let spin = at.rotation * body.inertia.component_mul(&(at.rotation.transpose() * at.angular_velocity));
            momentum.0 = body.mass * (at.velocity + step * self.model.whole.gravity) + step * momentum.0;
            momentum.1 = spin + step * momentum.1;
        }
        momenta
    }

    /// The rates with which the bodies have these momenta in a state, with efforts along the joints for a step (s); held joints stay at rest.
    fn velocities_of(&mut self, mut momenta: Vec<BodyWrench>, efforts: &[f64], step: f64, state: &State) -> Vec<f64> {
        let count = self.model.whole.velocity_count;
        let (mut impulses, mut own) = (vec![0.0; count], vec![0.0; count]);
        let bodies = body_states(&self.model.whole, state);
        efforts_of_wrenches(&self.model.whole, &bodies, &mut momenta, &mut impulses);
        joint_efforts(
            &self.model.whole,
            self.trial.origin.time,
            (&state.position, &self.trial.origin.velocity),
            &bodies,
            &mut own,
        );
        for (freedom, armature) in self.model.whole.rotors() {
            impulses[freedom] += armature * self.trial.origin.velocity[freedom];
        }
        for (impulse, (own, effort)) in impulses.iter_mut().zip(own.iter().zip(efforts)) {
            *impulse += step * (own + effort);
        }
        let held = self.model.elements.joints.iter().zip(&self.mode.joints);
        let held = held.filter(|(_, mode)| matches!(mode, JointMode::Held { .. }));
        let freedoms: Vec<usize> = held.map(|(joint, _)| joint.coordinate.freedom).collect();
        let mut rows = vec![impulses.into()];
        rows.extend(freedoms.iter().map(|&freedom| row_of_freedom(count, freedom, 1.0)));
        let answers = self.workspaces.response.answers(state, &rows);
        let mut velocity = answers.column(0).into_owned();
        if !freedoms.is_empty() {
            let columns = answers.columns(1, freedoms.len());
            let square =
                DMatrix::from_fn(freedoms.len(), freedoms.len(), |row, column| columns[(freedoms[row], column)]);
            let rates = DVector::from_fn(freedoms.len(), |row, _| velocity[freedoms[row]]);
            let largest = square.amax();
            if let Ok(back) = square.svd(true, true).solve(&rates, 1e-12 * largest) {
                velocity -= columns * back;
            }
            freedoms.iter().for_each(|&freedom| velocity[freedom] = 0.0);
        }
        velocity.as_slice().to_vec()
    }

    /// Puts joints that a step has moved beyond their limits onto them.
    fn put_within_limits(&self, state: &mut State) {
        for joint in &self.model.elements.joints {
            if let Some(side) = joint.sides().find(|&side| joint.gap(side, joint.position(state)) < 0.0) {
                joint.put_on(side, state);
            }
        }
    }
}

/// D^½, and the modes of H̃; `None` without freedoms, and if a number is not finite.
fn modes(mass: &DMatrix<f64>) -> Option<(Vec<f64>, SymmetricEigen<f64, Dyn>)> {
    let count = mass.nrows();
    if count == 0 || !mass.iter().all(|number| number.is_finite()) {
        return None;
    }
    let scale: Vec<f64> = (0..count).map(|row| mass[(row, row)].max(0.0).sqrt()).collect();
    let inverse: Vec<f64> = scale.iter().map(|scale| if *scale > 0.0 { 1.0 / scale } else { 0.0 }).collect();
    let scaled = DMatrix::from_fn(count, count, |row, column| mass[(row, column)] * inverse[row] * inverse[column]);
    Some((scale, scaled.symmetric_eigen()))
}

/// Rates without the part of light modes by which a joint would move by more than [`REACH`] in a step (s).
fn regular_rates(mass: &DMatrix<f64>, velocity: &[f64], step: f64) -> Vec<f64> {
    let count = mass.nrows();
    if !velocity.iter().all(|rate| rate.is_finite()) {
        return velocity.to_vec();
    }
    let Some((scale, eigen)) = modes(mass) else { return velocity.to_vec() };
    let inverse: Vec<f64> = scale.iter().map(|scale| if *scale > 0.0 { 1.0 / scale } else { 0.0 }).collect();
    let mut regular = velocity.to_vec();
    for (mode, &value) in eigen.eigenvalues.iter().enumerate().filter(|(_, value)| **value < LIGHT) {
        let shape = eigen.eigenvectors.column(mode);
        let part: f64 = (0..count).map(|row| shape[row] * scale[row] * velocity[row]).sum();
        let rates: Vec<f64> = (0..count).map(|row| part * shape[row] * inverse[row]).collect();
        let moved = rates.iter().fold(0.0_f64, |most, rate| most.max((step * rate).abs()));
        if moved > REACH {
            let cut = 1.0 - REACH / moved;
            regular.iter_mut().zip(&rates).for_each(|(rate, light)| *rate -= cut * light);
        }
        debug_assert!(value.is_finite());
    }
    regular
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_of_joints_that_turn_against_each_other_are_cut_and_their_sum_stays() {
        // Two axes through one body of unit inertia, at an angle of 1e-6, and a third joint across.
        let cosine = 1.0 - 0.5e-12;
        let mass = DMatrix::from_row_slice(3, 3, &[1.0, cosine, 0.0, cosine, 1.0, 0.0, 0.0, 0.0, 1.0]);
        let velocity = [1e7 + 2.0, 1.0 - 1e7, -11.0];
        let found = regular_rates(&mass, &velocity, 1e-6);
        // The difference is cut so that each joint moves by 0.01; the sum and the joint across are rounded in 1e7.
        assert!((found[0] + found[1] - 3.0).abs() < 1e-6, "{found:?}");
        assert!((found[0] - found[1]).abs() < 2.1 * REACH / 1e-6, "{found:?}");
        assert!((found[2] + 11.0).abs() < 1e-6, "{found:?}");
        // Slow ones stay as they are.
        assert_eq!(regular_rates(&mass, &[3.0, -2.0, 1.0], 1e-6), [3.0, -2.0, 1.0]);
    }
}
