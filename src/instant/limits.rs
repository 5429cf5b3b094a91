//! Assembly within joint limits: where the closed configuration that the projection finds lies beyond a limit, one that does
//! not, by the least motion in every round.
//!
//! Newton's method on the gaps with a convex quadratic programme in every round, solved by clarabel,
//!
//! ```text
//!     minimise  ½ dqᵀ H dq + ½ ρ |J dq + g|²        subject to  lower ≤ q + dq ≤ upper,  |dq| ≤ ½
//! ```
//!
//! with the mass matrix H, the joint-space gradient J of the closures and their gaps g. The gaps are a penalty, not
//! equations, because linearised equations and limits may contradict each other far from the solution; each round leaves the part
//! 1/ρ of a gap, so that the rounds close it.

use crate::lobatto::coupled::projection::{Projected, Projection};
use crate::lobatto::stages::start::Start;
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::kinematics::forward_kinematics;
use crate::mechanism::motion::state::State;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};
use nalgebra::{DMatrix, DVector};

/// Largest number of rounds.
const ROUNDS: usize = 60;
/// ρ, as a multiple of the ratio of the traces of H and JᵀJ.
const PENALTY: f64 = 1e6;
/// Largest change of a coordinate in one round (rad, m).
const REACH: f64 = 0.5;
/// A position this far beyond its limit [rad, m] is at it: limits are written with few digits.
const AT_LIMIT: f64 = 1e-6;

/// Whether every coordinate that has limits is within them.
pub fn within_limits(mechanism: &Mechanism, state: &State) -> bool {
    mechanism.limits.iter().all(|limit| {
        let position = state.position[limit.coordinate.position];
        position >= limit.lower - AT_LIMIT && position <= limit.upper + AT_LIMIT
    })
}

/// Closes the loops of a state that is within its limits, and stays there; says how far it got.
pub fn close_within_limits(
    mechanism: &Mechanism,
    projection: &mut Projection,
    start: &mut Start,
    state: &mut State,
) -> Projected {
    let count = mechanism.velocity_count;
    let mut done = Projected::default();
    for _ in 0..ROUNDS {
        start.set(mechanism, state);
        let gaps = DVector::from_vec(projection.gaps(start));
        (done.gap, done.worst) = projection.largest_gap();
        if done.gap < 1e-13 || !done.gap.is_finite() {
            break;
        }
        let gradient = gradient(mechanism, projection, start, gaps.len());
        let mass = mass_matrix(mechanism, state);
        let square = gradient.transpose() * &gradient;
        let penalty = PENALTY * mass.trace() / square.trace().max(f64::MIN_POSITIVE);
        let quadratic = mass + penalty * square;
        let linear = penalty * gradient.transpose() * gaps;
        let mut bounds = vec![(-REACH, REACH); count];
        for limit in &mechanism.limits {
            let position = state.position[limit.coordinate.position];
            let (low, high) = &mut bounds[limit.coordinate.freedom];
            (*low, *high) = (low.max(limit.lower - position), high.min(limit.upper - position));
        }
        let Some(change) = minimise_in_box(&quadratic, &linear, &bounds) else { break };
        state.displace(mechanism, &change);
        done.correction = change.iter().fold(done.correction, |most, value| most.max(value.abs()));
    }
    done
}

/// The joint-space gradient of all equations: a column a freedom.
fn gradient(mechanism: &Mechanism, projection: &mut Projection, start: &Start, rows: usize) -> DMatrix<f64> {
    let count = mechanism.velocity_count;
    let mut gradient = DMatrix::zeros(rows, count);
    let mut unit = vec![0.0; count];
    for freedom in 0..count {
        unit[freedom] = 1.0;
        gradient.set_column(freedom, &DVector::from_vec(projection.gap_rates(mechanism, start, &unit)));
        unit[freedom] = 0.0;
    }
    gradient
}

/// `H = Σ_b m v_iᵀ v_j + ω_iᵀ R J Rᵀ ω_j` from the velocities of all bodies for every freedom alone.
fn mass_matrix(mechanism: &Mechanism, state: &State) -> DMatrix<f64> {
    let count = mechanism.velocity_count;
    let mut unit = vec![0.0; count];
    let velocities: Vec<Vec<BodyState>> = (0..count)
        .map(|freedom| {
            let mut bodies = vec![WORLD; mechanism.bodies.len()];
            unit[freedom] = 1.0;
            forward_kinematics(mechanism, &state.position, &unit, &mut bodies);
            unit[freedom] = 0.0;
            bodies
        })
        .collect();
    let entry = |first: usize, second: usize| -> f64 {
        let pairs = velocities[first].iter().zip(&velocities[second]);
        mechanism.bodies.iter().zip(pairs).fold(0.0, |sum, (body, (one, other))| {
            let turn = one.rotation.transpose();
            let spins =
                (turn * one.angular_velocity).component_mul(&body.inertia).dot(&(turn * other.angular_velocity));
            sum + body.mass * one.velocity.dot(&other.velocity) + spins
        })
    };
    DMatrix::from_fn(count, count, entry)
}

/// The minimum of `½ xᵀ Q x + cᵀ x` in a box; `None` if the solver finds none.
fn minimise_in_box(quadratic: &DMatrix<f64>, linear: &DVector<f64>, bounds: &[(f64, f64)]) -> Option<Vec<f64>> {
    let count = bounds.len();
    let upper_triangle: Vec<Vec<f64>> = (0..count)
        .map(|row| (0..count).map(|column| if column >= row { quadratic[(row, column)] } else { 0.0 }).collect())
        .collect();
    let both_sides: Vec<Vec<f64>> = [1.0, -1.0]
        .iter()
        .flat_map(|&side| {
            (0..count).map(move |row| (0..count).map(|column| if column == row { side } else { 0.0 }).collect())
        })
        .collect();
    let limits: Vec<f64> = bounds.iter().map(|(_, high)| *high).chain(bounds.iter().map(|(low, _)| -low)).collect();
    let cones = [SupportedConeT::NonnegativeConeT(2 * count)];
    let settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
    let mut solver = DefaultSolver::new(
        &CscMatrix::from(&upper_triangle),
        linear.as_slice(),
        &CscMatrix::from(&both_sides),
        &limits,
        &cones,
        settings,
    )
    .ok()?;
    solver.solve();
    // Interior points stop a little short of the box, or a little outside it.
    let solution = solver.solution.x.iter().zip(bounds).map(|(value, (low, high))| value.max(*low).min(*high));
    let solution: Vec<f64> = solution.collect();
    solution.iter().all(|value| value.is_finite()).then_some(solution)
}
