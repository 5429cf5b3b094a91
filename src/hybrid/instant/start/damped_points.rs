//! Rotors of joints whose dampers move next to no inertia, because their links are points of mass or have none.
//!
//! ```text
//!     λ = min  vᵀ H v / vᵀ D v  < 10⁻¹⁰ s      H mass matrix [kg m²], D dampers [N m s/rad], λ the shortest time constant (s)
//!     joints of this v get rotors   r = τ d     [kg m², or kg of slides];  d: the damper of the joint,  τ = 10⁻⁵ s
//! ```
//!
//! Three axes of a neck that meet near a point of mass leave a motion of the joints in which nothing moves. Dampers determine it, in a time of 1e-17 s. No
//! step sees that, but accelerations, impacts and the forces of limits would be roundings over 1e-18 kg m². With rotors it follows τ later, by 1e-5 m
//! at 1 m/s.
//!
//! Source: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th edition, section 8.7, for the symmetric-definite generalised eigenproblem.

use crate::instant::dynamics::mass_matrix::mass_matrix;
use crate::mechanism::description::mechanism::{Body, Mechanism};
use crate::mechanism::motion::state::State;
use nalgebra::DMatrix;

/// τ: the time in which the shortest motion of joints with such rotors decays (s).
pub const DECAY: f64 = 1e-5;
/// A motion with a shorter time constant than this gets rotors (s).
const SHORTEST: f64 = 1e-10;
/// A link whose radius of gyration about some axis is at most this counts as a point of mass (m).
const POINT: f64 = 1e-6;
/// A joint takes part in a motion if its rate, times the root of its damper, is at least this part of the largest.
const TAKES_PART: f64 = 1e-2;
/// Mechanisms with more degrees of freedom are not looked at.
const MOST: usize = 100;

/// A joint that gets a rotor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotor {
    /// The body behind the joint.
    pub body: usize,
    /// r_i [kg m² or kg].
    pub armature: f64,
    /// λ (s), of the shortest motion.
    pub time: f64,
}

/// The joints of a tree that get rotors at a state; none in which all dampers move enough.
pub fn rotors_of_dampers(mechanism: &Mechanism, state: &State) -> Vec<Rotor> {
    let dampers = &mechanism.forces.joint_dampers;
    let is_point = |body: &Body| body.inertia.min() <= POINT * POINT * body.mass;
    let count = mechanism.velocity_count;
    if dampers.is_empty() || mechanism.has_closures() || count > MOST || !mechanism.bodies.iter().any(is_point) {
        return Vec::new();
    }
    let mut damping = vec![0.0; count];
    for damper in dampers.iter().filter(|damper| damper.coefficient > 0.0) {
        let body = mechanism.body_of_freedom(damper.freedom);
        if body.is_some_and(|body| mechanism.bodies[body].joint.velocity_range().len() == 1) {
            damping[damper.freedom] += damper.coefficient;
        }
    }
    // H less the inertia of damped joints that decay in the shortest time, to which the rotors are added.
    let mut left = mass_matrix(mechanism, state);
    (0..count).for_each(|freedom| left[(freedom, freedom)] -= SHORTEST * damping[freedom]);
    if damping.iter().all(|damping| *damping == 0.0) || !left.iter().all(|entry| entry.is_finite()) {
        return Vec::new();
    }
    let (mut all, mut time) = (Vec::new(), None);
    while let Some((motion, least)) = short_motion(&left, &damping) {
        time.get_or_insert((SHORTEST + least).max(0.0));
        let largest = motion.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
        let mut more = (0..count)
            .filter(|&freedom| {
                damping[freedom] > 0.0 && !all.contains(&freedom) && motion[freedom].abs() >= TAKES_PART * largest
            })
            .collect::<Vec<_>>();
        if more.is_empty() {
            break;
        }
        more.iter().for_each(|&freedom| left[(freedom, freedom)] += DECAY * damping[freedom]);
        all.append(&mut more);
    }
    all.sort_unstable();
    let rotor = |&freedom: &usize| {
        let body = mechanism.body_of_freedom(freedom)?;
        Some(Rotor { body, armature: DECAY * damping[freedom], time: time.unwrap_or(SHORTEST) })
    };
    all.iter().filter_map(rotor).collect()
}

/// √D v of the motion v of damped joints with the most negative `vᵀ (H − λ₀ D + R) v` for `vᵀ D v = 1`, λ₀ the shortest time, and that value (s); joints
/// without dampers follow by the least kinetic energy. `None` if there is no negative one.
fn short_motion(left: &DMatrix<f64>, damping: &[f64]) -> Option<(Vec<f64>, f64)> {
    let damped: Vec<usize> = (0..damping.len()).filter(|&freedom| damping[freedom] > 0.0).collect();
    let free: Vec<usize> = (0..damping.len()).filter(|&freedom| damping[freedom] == 0.0).collect();
    let entry = |rows: &[usize], columns: &[usize]| {
        DMatrix::from_fn(rows.len(), columns.len(), |row, column| left[(rows[row], columns[column])])
    };
    let mut own = entry(&damped, &damped);
    if !free.is_empty() {
        let between = entry(&free, &damped);
        own -= between.transpose() * entry(&free, &free).cholesky()?.solve(&between);
    }
    let root: Vec<f64> = damped.iter().map(|&freedom| damping[freedom].sqrt()).collect();
    let scaled =
        DMatrix::from_fn(own.nrows(), own.ncols(), |row, column| own[(row, column)] / (root[row] * root[column]));
    let eigen = scaled.symmetric_eigen();
    let shortest = eigen.eigenvalues.imin();
    let least = eigen.eigenvalues[shortest];
    // Roundings of the largest are no motion of their own.
    if least >= -f64::EPSILON * eigen.eigenvalues.amax() * damped.len() as f64 {
        return None;
    }
    let mut motion = vec![0.0; damping.len()];
    for (place, &freedom) in damped.iter().enumerate() {
        motion[freedom] = eigen.eigenvectors[(place, shortest)];
    }
    Some((motion, least))
}
