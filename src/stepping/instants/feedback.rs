//! Efforts that follow the state at every stage: the stage equations and the law of the efforts solved together.
//!
//! Let `e` be the efforts at all stages (m × s) [N m or N], `(q_j, v_j)(e)` the solution of the stage equations under them, and `f` a law:
//!
//! ```text
//!     e_j = f(t_j, q_j(e), v_j(e)),   j = 1..s
//!     (1 − h² Â ⊗ f_q Y − h Ā ⊗ f_v Y) δ = f − e,   e ← e + δ              simplified Newton
//! ```
//!
//! Y (n × m) are the accelerations per unit of effort and f_q, f_v the derivatives of the law, at the start of the step: by them stiff gains cost
//! iterations, not steps. The rates are the rates of dampers, `ẏ_j` of [`catena_lobatto::equations::forces`], for ball joints `ω = T(θ) θ̇`. Stage s
//! comes after the others, because Ā has no last column and Â no row of its own for it but the last. So the efforts are forces of the scheme, and its
//! order stays 2s − 2.

use crate::instants::stage_motion::stage_motion;
use catena_lobatto::stages::attempt::{Attempt, Guess, StopRule};
use catena_lobatto::step::interface::Step;
use catena_lobatto::tableau::butcher::Tableau;
use catena_mechanism::description::joint::FreeRotation;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::inputs::Feedback;
use catena_mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector, Vector3};

/// Corrections before an attempt has failed.
const CORRECTIONS: usize = 30;
/// Remainders below this part of the efforts that no longer fall are rounding.
const ROUNDING: f64 = 1e-10;
/// Efforts are solved to this part of the iteration stop of the step, relative to the largest of them.
const FINER: f64 = 0.1;
/// They are never known better than this.
const FINEST: f64 = 4.0 * f64::EPSILON;

/// Attempts a step of `length` seconds from a state under efforts that follow it; these at its end, added up, too [N or N m].
#[expect(clippy::too_many_arguments, reason = "those of every attempt, with the law")]
pub(crate) fn attempt(
    kernel: &mut dyn Step,
    tableau: &Tableau,
    mechanism: &Mechanism,
    feedback: &dyn Feedback,
    state: &State,
    length: f64,
    rule: &StopRule,
    guess: Guess,
) -> (Attempt, f64) {
    let (stages, count) = (tableau.stages, feedback.freedoms().len());
    let newton = newton_matrix(tableau, feedback, state, length).lu();
    let mut at_stages = AtStages::new(state, stages);
    let mut law = vec![0.0; count];
    feedback.efforts(state, &mut law);
    // Freedom after freedom, as the kernel takes them. The first guess is the linear response to the efforts of the law at the start: constant
    // efforts of stiff laws would throw a light body away within the step.
    let mut efforts = DVector::from_fn(count * stages, |place, _| law[place / stages]);
    newton.solve_mut(&mut efforts);
    let mut remainder = DVector::zeros(count * stages);
    let (mut spent, mut before, mut guess) = (0, f64::INFINITY, guess);
    for _ in 0..CORRECTIONS {
        kernel.change(feedback.freedoms(), efforts.as_slice());
        let attempt = kernel.attempt(mechanism, length, rule, guess).after(spent);
        if !matches!(attempt, Attempt::Converged { .. }) {
            return (attempt, 0.0);
        }
        (spent, guess) = (attempt.iterations(), Guess::Longer(length));
        let (mut largest, mut left) = (0.0_f64, 0.0_f64);
        at_stages.read(kernel, tableau, state, length);
        for stage in 0..stages {
            let time = state.time + length * tableau.nodes[stage];
            feedback.efforts(at_stages.state(mechanism, state, stage, time), &mut law);
            for (entry, &wanted) in law.iter().enumerate() {
                let place = entry * stages + stage;
                remainder[place] = wanted - efforts[place];
                largest = largest.max(wanted.abs());
                left = left.max(remainder[place].abs());
            }
        }
        let enough = (FINER * rule.increment).max(FINEST) * largest;
        if left <= enough || (left >= before && left <= ROUNDING * largest) {
            return (attempt, law.iter().map(|effort| effort.abs()).sum());
        }
        if !left.is_finite() || !newton.solve_mut(&mut remainder) {
            break;
        }
        efforts += &remainder;
        before = left;
    }
    let freedom = feedback.freedoms().first().copied().unwrap_or(0);
    (Attempt::Failed { iterations: spent, freedom, increment: before }, 0.0)
}

/// `1 − h² Â ⊗ f_q Y − h Ā ⊗ f_v Y`, entry after entry, each with its stages (m s × m s).
fn newton_matrix(tableau: &Tableau, feedback: &dyn Feedback, state: &State, length: f64) -> DMatrix<f64> {
    let (stages, count) = (tableau.stages, feedback.freedoms().len());
    let size = (count, state.velocity.len());
    let (mut by_position, mut by_rate) = (DMatrix::zeros(size.0, size.1), DMatrix::zeros(size.0, size.1));
    feedback.derivatives(state, &mut by_position, &mut by_rate);
    let mobility = feedback.mobility(state);
    let (by_position, by_rate) = (by_position * &mobility, by_rate * mobility);
    let active = stages - 1;
    // Displacements at stage 1 are zero, and the effort of stage s has no effect.
    let a_hat = |row: usize, column: usize| {
        if row == 0 || column == active { 0.0 } else { tableau.a_hat[(row - 1) * active + column] }
    };
    let a_bar = |row: usize, column: usize| tableau.a_bar[row * stages + column];
    DMatrix::from_fn(count * stages, count * stages, |row, column| {
        let (entry, stage, other, at) = (row / stages, row % stages, column / stages, column % stages);
        let answer = length * length * a_hat(stage, at) * by_position[(entry, other)]
            + length * a_bar(stage, at) * by_rate[(entry, other)];
        f64::from(u8::from(row == column)) - answer
    })
}

/// The angular velocity ω of a ball joint [rad/s] from its rotation vector θ since the start of the step and its rate: `ω = T(θ) θ̇`,
/// `T = 1 − k₁ θ̂ + k₂ θ̂²`, `k₁ = (1 − cos φ)/φ²`, `k₂ = (φ − sin φ)/φ³`, in the axes of the child.
fn angular_velocity(theta: Vector3<f64>, rate: Vector3<f64>) -> Vector3<f64> {
    let square = theta.norm_squared();
    let angle = square.sqrt();
    // The series where the differences cancel: the next terms are 1e-16 of these.
    let (first, second) = if angle < 1e-2 {
        (0.5 - square / 24.0 + square * square / 720.0, 1.0 / 6.0 - square / 120.0 + square * square / 5040.0)
    } else {
        (2.0 * (0.5 * angle).sin().powi(2) / square, (angle - angle.sin()) / (square * angle))
    };
    let turned = theta.cross(&rate);
    rate - first * turned + second * theta.cross(&turned)
}

/// The states at the stages of an attempt that has just been solved.
#[derive(Clone)]
struct AtStages {
    stages: usize,
    /// Freedom after freedom (n × s).
    displacements: Vec<f64>,
    rates: Vec<f64>,
    /// Displacements of one stage (n).
    displacement: Vec<f64>,
    state: State,
}

impl AtStages {
    fn new(state: &State, stages: usize) -> Self {
        let count = state.velocity.len();
        AtStages {
            stages,
            displacements: vec![0.0; count * stages],
            rates: vec![0.0; count * stages],
            displacement: vec![0.0; count],
            state: state.clone(),
        }
    }

    /// Takes the motion of all freedoms.
    fn read(&mut self, kernel: &dyn Step, tableau: &Tableau, start: &State, length: f64) {
        let AtStages { stages, displacements, rates, .. } = self;
        let places = displacements.chunks_mut(*stages).zip(rates.chunks_mut(*stages));
        for (freedom, (displacements, rates)) in places.enumerate() {
            stage_motion(kernel, tableau, freedom, (length, start.velocity[freedom]), displacements, rates);
        }
    }

    /// The state at stage `stage` (from 0), at a time (s).
    fn state(&mut self, mechanism: &Mechanism, start: &State, stage: usize, time: f64) -> &State {
        let AtStages { stages, displacements, rates, displacement, state } = self;
        for freedom in 0..displacement.len() {
            displacement[freedom] = displacements[freedom * *stages + stage];
            state.velocity[freedom] = rates[freedom * *stages + stage];
        }
        state.time = time;
        state.position.copy_from_slice(&start.position);
        state.compensation.copy_from_slice(&start.compensation);
        state.displace(mechanism, displacement);
        for body in &mechanism.bodies {
            let joint = &body.joint;
            if joint.kind.rotation() == FreeRotation::Ball {
                let last = joint.velocity_range().end;
                let vector = |values: &[f64]| Vector3::from_column_slice(&values[last - 3..last]);
                let spin = angular_velocity(vector(displacement), vector(&state.velocity));
                state.velocity[last - 3..last].copy_from_slice(spin.as_slice());
            }
        }
        state
    }
}
