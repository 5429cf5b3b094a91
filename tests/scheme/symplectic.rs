//! The step is symplectic on T*N and time-reversible.

use crate::models::{self, Model};
use catena::kernels::step_for;
use catena::lobatto::numbers::lanes::Isa;
use catena::lobatto::stages::attempt::{Attempt, Guess, StopRule};
use catena::lobatto::step::interface::Step;
use catena::lobatto::tableau::butcher::Tableau;
use catena::mechanism::description::joint::JointKind;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::kinematics::forward_kinematics;
use catena::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};

/// Mass matrix in joint coordinates, from the kinetic energy of unit velocities (a quadratic form, so polarisation is
/// exact but for rounding).
fn mass_matrix(mechanism: &Mechanism, position: &[f64]) -> DMatrix<f64> {
    let count = mechanism.velocity_count;
    let kinetic = |velocity: &DVector<f64>| {
        let mut bodies = vec![catena::mechanism::description::body_state::WORLD; mechanism.bodies.len()];
        forward_kinematics(mechanism, position, velocity.as_slice(), &mut bodies);
        catena::mechanism::motion::energy::energy(mechanism, &bodies).kinetic
    };
    let unit = |index: usize| DVector::from_fn(count, |row, _| if row == index { 1.0 } else { 0.0 });
    DMatrix::from_fn(count, count, |i, j| 0.5 * (kinetic(&(unit(i) + unit(j))) - kinetic(&(unit(i) - unit(j)))))
}

/// The step as a map of canonical coordinates (q, p), p = M(q) q̇.
fn canonical_step(mechanism: &Mechanism, kernel: &mut dyn Step, step: f64, z: &DVector<f64>) -> DVector<f64> {
    let count = mechanism.velocity_count;
    let mut state = State::zero(mechanism);
    state.position.copy_from_slice(&z.as_slice()[..count]);
    let momentum = z.rows(count, count).into_owned();
    let velocity = mass_matrix(mechanism, &state.position).cholesky().unwrap().solve(&momentum);
    state.velocity.copy_from_slice(velocity.as_slice());
    kernel.begin(mechanism, &state);
    let attempt = kernel.attempt(mechanism, step, &StopRule::ROUNDING, Guess::Plain);
    assert!(matches!(attempt, Attempt::Converged { .. }), "{attempt:?}");
    kernel.finish(mechanism, &mut state);
    let momentum = mass_matrix(mechanism, &state.position) * DVector::from_row_slice(&state.velocity);
    DVector::from_iterator(2 * count, state.position.iter().copied().chain(momentum.iter().copied()))
}

/// Largest entry of ΦᵀJΦ − J for the Jacobian Φ of the step map.
fn symplectic_defect(model: &Model, stages: usize, step: f64) -> f64 {
    let mechanism = &model.mechanism;
    let count = mechanism.velocity_count;
    let mut kernel = step_for(mechanism, Tableau::of(stages).unwrap(), Isa::detect(), &[]);
    let momentum = mass_matrix(mechanism, &model.state.position) * DVector::from_row_slice(&model.state.velocity);
    let z = DVector::from_iterator(2 * count, model.state.position.iter().copied().chain(momentum.iter().copied()));
    let mut jacobian = DMatrix::zeros(2 * count, 2 * count);
    for column in 0..2 * count {
        // Central differences of two widths, extrapolated: truncation O(ε⁴) = 1e-12, rounding 1e-16/ε = 1e-13.
        let mut difference = |width: f64| {
            let mut shifted = z.clone();
            shifted[column] = z[column] + width;
            let ahead = canonical_step(mechanism, kernel.as_mut(), step, &shifted);
            shifted[column] = z[column] - width;
            (ahead - canonical_step(mechanism, kernel.as_mut(), step, &shifted)) / (2.0 * width)
        };
        let (wide, narrow) = (difference(2e-3), difference(1e-3));
        jacobian.set_column(column, &((4.0 * narrow - wide) / 3.0));
    }
    let mut structure = DMatrix::zeros(2 * count, 2 * count);
    for index in 0..count {
        structure[(index, count + index)] = 1.0;
        structure[(count + index, index)] = -1.0;
    }
    (jacobian.transpose() * &structure * jacobian - structure).amax()
}

#[test]
fn the_step_map_preserves_the_symplectic_form() {
    // The differences are good to some 1e-10; a step that is not symplectic misses by its local error, 1e-3 … 1e-6 here.
    // The last two move in a plane, with a kernel of their own.
    for model in [
        models::double_pendulum(),
        models::one_joint(JointKind::Planar),
        models::one_joint(JointKind::Prismatic),
        models::planar_chain(2),
    ] {
        for (stages, step) in [(2, 0.05), (3, 0.1), (5, 0.2)] {
            let defect = symplectic_defect(&model, stages, step);
            assert!(defect < 2e-9, "{} s={stages}: ΦᵀJΦ − J = {defect:.1e}", model.mechanism.name);
        }
    }
}

#[test]
fn a_step_forth_and_a_step_back_return_to_the_start() {
    for model in [models::double_pendulum(), models::floating_tree(), models::slow_heavy_top()] {
        for stages in [2, 3, 4, 5, 9] {
            let mechanism = &model.mechanism;
            let mut kernel = step_for(mechanism, Tableau::of(stages).unwrap(), Isa::detect(), &[]);
            let mut state = model.state.clone();
            for step in [0.03, -0.03] {
                kernel.begin(mechanism, &state);
                let attempt = kernel.attempt(mechanism, step, &StopRule::ROUNDING, Guess::Plain);
                assert!(matches!(attempt, Attempt::Converged { .. }), "{attempt:?}");
                kernel.finish(mechanism, &mut state);
            }
            let error = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // Rounding of two steps; the local error of s = 2 alone is 1e-4.
            let position = error(&state.position, &model.state.position);
            let velocity = error(&state.velocity, &model.state.velocity);
            assert!(position < 1e-13, "{} s={stages}: positions off by {position:.1e}", mechanism.name);
            assert!(velocity < 5e-12, "{} s={stages}: velocities off by {velocity:.1e}", mechanism.name);
        }
    }
}
