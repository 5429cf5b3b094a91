//! Starts within joint limits: a state that is outside them is moved in, one whose loops close only outside them is closed inside, by
//! the least motion.
//!
//! A tree is moved by one convex quadratic programme, in the metric of its mass matrix H where it was wanted:
//!
//! ```text
//!     minimise  ½ dqᵀ H dq        subject to  lower ≤ q + dq ≤ upper
//! ```
//!
//! Closures are closed by Newton's method on their gaps with such a programme in every round,
//!
//! ```text
//!     minimise  ½ dqᵀ H dq + ½ ρ |J dq + g|²        subject to  lower ≤ q + dq ≤ upper,  |dq| ≤ ½
//! ```
//!
//! with the joint-space gradient J of the closures and their gaps g. The gaps are a penalty, not equations, because linearised equations
//! and limits may contradict each other far from the solution; each round leaves the part 1/ρ of a gap, so that the rounds close it.
//! A limit further away than the reach of a round is approached by that much.

use crate::instant::cone::bounded::minimise_definite;
use crate::instant::dynamics::mass_matrix::mass_matrix;
use crate::lobatto::coupled::projection::{Projected, Projection};
use crate::lobatto::stages::start::Start;
use crate::mechanism::description::closure::JointLimit;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};

/// Largest number of rounds.
const ROUNDS: usize = 60;
/// ρ, as a multiple of the ratio of the traces of H and JᵀJ.
const PENALTY: f64 = 1e6;
/// Largest change of a coordinate in one round (rad, m).
const REACH: f64 = 0.5;
/// Largest gap [m, rad] and excess over a limit [rad or m] of a state that needs no further round.
const CLOSED: f64 = 1e-13;

/// How far a state is beyond a limit [rad or m]; negative inside.
pub fn excess(limit: &JointLimit, state: &State) -> f64 {
    let position = state.position[limit.coordinate.position];
    (limit.lower - position).max(position - limit.upper)
}

/// Whether no limit is exceeded by more than `margin` [rad or m].
pub fn within(limits: &[JointLimit], state: &State, margin: f64) -> bool {
    limits.iter().all(|limit| excess(limit, state) <= margin)
}

/// The limit that a state exceeds most.
pub fn most_exceeded<'l>(limits: &'l [JointLimit], state: &State) -> Option<&'l JointLimit> {
    limits.iter().max_by(|one, other| excess(one, state).total_cmp(&excess(other, state)))
}

/// Moves a tree within limits; a joint that is moved onto a limit is exactly there. Says whether that was possible.
pub fn move_within(mechanism: &Mechanism, limits: &[JointLimit], state: &mut State) -> bool {
    let mass = mass_matrix(mechanism, state);
    let mut bounds = vec![(f64::NEG_INFINITY, f64::INFINITY); mechanism.velocity_count];
    for limit in limits {
        let position = state.position[limit.coordinate.position];
        bounds[limit.coordinate.freedom] = (limit.lower - position, limit.upper - position);
    }
    let change = minimise_definite(&mass, &vec![0.0; mechanism.velocity_count], &bounds).efforts;
    if !change.iter().all(|value| value.is_finite()) {
        return false;
    }
    state.displace(mechanism, &change);
    for limit in limits {
        let (slot, freedom) = (limit.coordinate.position, limit.coordinate.freedom);
        let held = [(bounds[freedom].0, limit.lower), (bounds[freedom].1, limit.upper)];
        if let Some((_, onto)) = held.into_iter().find(|(bound, _)| change[freedom] == *bound) {
            (state.position[slot], state.compensation[slot]) = (onto, 0.0);
        }
    }
    within(limits, state, 0.0)
}

/// Closes the loops of a state within limits; says how far it got.
pub fn close_within(
    mechanism: &Mechanism,
    limits: &[JointLimit],
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
        if (done.gap < CLOSED && within(limits, state, CLOSED)) || !done.gap.is_finite() {
            break;
        }
        let gradient = gradient(mechanism, projection, start, gaps.len());
        let mass = mass_matrix(mechanism, state);
        let square = gradient.transpose() * &gradient;
        let penalty = PENALTY * mass.trace() / square.trace().max(f64::MIN_POSITIVE);
        let quadratic = mass + penalty * square;
        let linear = penalty * gradient.transpose() * gaps;
        let mut bounds = vec![(-REACH, REACH); count];
        for limit in limits {
            let position = state.position[limit.coordinate.position];
            let reachable = |bound: f64| (bound - position).clamp(-REACH, REACH);
            bounds[limit.coordinate.freedom] = (reachable(limit.lower), reachable(limit.upper));
        }
        let change = minimise_definite(&quadratic, linear.as_slice(), &bounds).efforts;
        if !change.iter().all(|value| value.is_finite()) {
            break;
        }
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
