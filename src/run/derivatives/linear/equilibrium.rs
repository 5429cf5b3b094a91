//! The equilibrium near a state, in independent coordinates.
//!
//! ```text
//!     r = Tᵀ (ρ(q, 0, 0) − τ) = 0,   g(q) = 0          T (n × d): motions that the closures, and contacts that roll, allow
//!     K = Tᵀ ∂(ρ − Gᵀλ)/∂q T,        λ = G_D⁻ᵀ (ρ − τ)_D
//!
//!     near the start     K ξ = −r                         Newton's method; least norm where K is singular
//!     otherwise          ξ = −Σ x (xᵀ r)/|σ|              downhill, with K x = σ H x
//! ```
//!
//! Newton's method finds the equilibrium nearest to the start, stable or not: a pendulum that starts near the top stays there. If it leaves the
//! neighbourhood of the start, the search goes downhill instead, along the forces, to a stable equilibrium. No motion of an iteration is larger than
//! a bound, because far from the root the linear equations say little; the bound is doubled while they foresee the force after a motion.
//!
//! Source: J. Nocedal, S. J. Wright, Numerical Optimization, Springer 2006, chapters 3 and 11.

use crate::derivatives::linear::equations::{By, Equations, Point};
use crate::derivatives::linear::independent::BothIndependent;
use crate::derivatives::linear::linearised::weights;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};

/// Iterations; from a state whose joints are within a radian about ten are made.
const ITERATIONS: usize = 300;
/// No coordinate moves further in one iteration (rad or m), unless the linear equations have foreseen the force after the last motion.
const LARGEST_MOTION: f64 = 0.3;
/// They have if they are off by less than this part of the force before it: springs, and no pendulums.
const FORESEEN: f64 = 1e-3;
/// Newton's method stays within this distance of where it starts (rad or m).
const NEAR: f64 = 0.5;
/// Newton's method takes over for motions this small (rad or m).
const NEARLY_THERE: f64 = 1e-2;
/// Motions this small (rad or m) that do not shrink any more are rounding.
const ROUNDING: f64 = 1e-9;
/// Singular values and stiffnesses below this part of the largest are zero.
const RANK: f64 = 1e-12;
/// The same for the gradient of closures, some of which are redundant.
const CLOSED: f64 = 1e-9;
/// Iterations that bring a state onto its closures.
const CLOSING: usize = 30;
/// Efforts out of balance beyond this part of the largest effort are no rounding.
const BALANCED: f64 = 1e-9;
/// A motion is halved while the force along it turns against it by more than this part.
const OVERSHOT: f64 = 0.5;

/// No equilibrium was found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EquilibriumError {
    /// The iteration has not converged.
    #[error(
        "no equilibrium was found near the start: after {ITERATIONS} iterations the effort along joint {joint:?} is {lacking:.3e} N m or N \
         out of balance; start nearer to one with --position, or take an instant with --at start or --at T"
    )]
    NotFound {
        /// The joint whose effort is the furthest from balance.
        joint: String,
        /// N m or N.
        lacking: f64,
    },
}

/// The search of one mechanism.
struct Search<'m> {
    mechanism: &'m Mechanism,
    equations: Equations,
    efforts: &'m DVector<f64>,
    weights: Vec<f64>,
}

/// The equations of rest in one state.
struct Rest {
    /// T.
    motions: DMatrix<f64>,
    /// r (d).
    forces: DVector<f64>,
    /// ρ − τ, and ρ − τ − Gᵀ λ along all freedoms (n).
    unbalanced: DVector<f64>,
    lacking: DVector<f64>,
    stiffness: DMatrix<f64>,
    inertia: DMatrix<f64>,
    /// The largest effort among those that balance.
    scale: f64,
}

/// Moves a state to an equilibrium, under efforts τ (n); `stops` ends the search in a state. Returns the number of iterations.
///
/// # Errors
/// [`EquilibriumError`] where the iteration does not converge.
pub fn settle(
    mechanism: &Mechanism,
    state: &mut State,
    efforts: &DVector<f64>,
    driven: &[usize],
    stops: &mut dyn FnMut(&State) -> bool,
) -> Result<usize, EquilibriumError> {
    state.velocity.fill(0.0);
    if mechanism.velocity_count == 0 {
        return Ok(0);
    }
    let weights = weights(mechanism, driven);
    let search = Search { mechanism, equations: Equations::new(mechanism), efforts, weights };
    let mut near = state.clone();
    if let Some(iterations) = search.newton(&mut near) {
        state.copy_from(&near);
        return Ok(iterations);
    }
    let mut length = LARGEST_MOTION;
    let mut before: Option<(DVector<f64>, [f64; 2])> = None;
    for iteration in 1..=ITERATIONS {
        let Some(rest) = search.rest(state) else { break };
        if let Some((motion, [slope, foreseen])) = &before {
            // The force along the last motion, after it.
            let turned = rest.unbalanced.dot(motion);
            length = if turned > OVERSHOT * slope.abs() {
                0.5 * length
            } else if foreseen > slope && (turned - foreseen).abs() <= FORESEEN * slope.abs() {
                // What has no stiffness has no equilibrium to hurry to.
                2.0 * length
            } else {
                (2.0 * length).min(LARGEST_MOTION)
            };
        }
        let Some(motion) = rest.downhill() else { break };
        let size = motion.amax();
        if size <= NEARLY_THERE {
            let mut there = state.clone();
            if let Some(more) = search.newton(&mut there) {
                state.copy_from(&there);
                return Ok(iteration + more);
            }
        }
        let motion = motion * (length / size.max(length));
        let stiffens = motion.dot(&(&rest.stiffness * &motion));
        let motion = &rest.motions * motion;
        let slope = rest.unbalanced.dot(&motion);
        search.displace(state, &motion);
        before = Some((motion, [slope, slope + stiffens]));
        if stops(state) {
            return Ok(iteration);
        }
    }
    let lacking = search.rest(state).map_or_else(|| DVector::zeros(1), |rest| rest.lacking);
    let worst = lacking.iamax();
    Err(EquilibriumError::NotFound { joint: mechanism.joint_of_freedom(worst).to_string(), lacking: lacking[worst] })
}

impl Search<'_> {
    /// Moves a state, and brings it onto its closures by the least motions.
    fn displace(&self, state: &mut State, motion: &DVector<f64>) {
        state.displace(self.mechanism, motion.as_slice());
        let (n, m, closed) = (self.mechanism.velocity_count, self.equations.rows(), self.equations.of_positions());
        let (still, unloaded) = (DVector::zeros(n), DVector::zeros(m));
        let mut last = f64::INFINITY;
        for _ in 0..if closed > 0 { CLOSING } else { 0 } {
            let point = Point { state, accelerations: &still, multipliers: &unloaded };
            let gap = self.equations.at(&point).closures[0].rows(0, closed).column(0).into_owned();
            let gradient = self.equations.derivatives(&point, By::Velocities).closures[1].rows(0, closed).into_owned();
            let Some(motion) = least_norm(&gradient, &-&gap, CLOSED) else { break };
            let size = motion.amax();
            if !size.is_finite() || size < ROUNDING && size >= 0.25 * last {
                break;
            }
            last = size;
            state.displace(self.mechanism, motion.as_slice());
        }
    }

    /// Newton's method near a state; the number of iterations if it converges there.
    fn newton(&self, state: &mut State) -> Option<usize> {
        let mut last = f64::INFINITY;
        let mut way = DVector::zeros(self.mechanism.velocity_count);
        for iteration in 1..=ITERATIONS {
            let rest = self.rest(state)?;
            let motion = &rest.motions * least_norm(&rest.stiffness, &-&rest.forces, RANK)?;
            let size = motion.amax();
            let motion = motion * (LARGEST_MOTION / size.max(LARGEST_MOTION));
            way += &motion;
            if way.amax() > NEAR {
                return None;
            }
            self.displace(state, &motion);
            if size < ROUNDING && size >= 0.25 * last || size == 0.0 {
                return (rest.lacking.amax() <= BALANCED * rest.scale).then_some(iteration);
            }
            last = size;
        }
        None
    }

    /// The equations of rest in a state; `None` if they are no finite numbers or singular.
    fn rest(&self, state: &State) -> Option<Rest> {
        let (n, m) = (self.mechanism.velocity_count, self.equations.rows());
        let (still, unloaded) = (DVector::zeros(n), DVector::zeros(m));
        let point = Point { state, accelerations: &still, multipliers: &unloaded };
        let values = self.equations.at(&point);
        let gradient = self.equations.derivatives(&point, By::Velocities).closures[1].clone();
        let mass = self.equations.derivatives(&point, By::Accelerations).efforts;
        let split = BothIndependent::of(&gradient, self.equations.of_positions(), &self.weights)?.velocities;
        let motions = split.motions(&gradient)?;
        let lacking = values.efforts.column(0) - self.efforts;
        let multipliers = split.multipliers(&gradient, &lacking)?;
        let point = Point { state, accelerations: &still, multipliers: &multipliers };
        let by_position = self.equations.derivatives(&point, By::Positions).efforts;
        let pushes = gradient.tr_mul(&multipliers);
        let scale = values.efforts.amax().max(self.efforts.amax()).max(pushes.amax()).max(by_position.amax());
        let rest = Rest {
            forces: motions.tr_mul(&lacking),
            stiffness: motions.tr_mul(&(by_position * &motions)),
            inertia: motions.tr_mul(&(mass * &motions)),
            unbalanced: lacking.clone(),
            lacking: lacking - pushes,
            scale: scale.max(f64::MIN_POSITIVE),
            motions,
        };
        let numbers = rest.forces.iter().chain(rest.stiffness.iter());
        let are_finite = numbers.chain(rest.inertia.iter()).all(|number| number.is_finite());
        are_finite.then_some(rest)
    }
}

impl Rest {
    /// The motion downhill (d).
    fn downhill(&self) -> Option<DVector<f64>> {
        if self.forces.is_empty() {
            return Some(self.forces.clone());
        }
        let lower = self.inertia.clone().cholesky()?.l();
        let half = lower.solve_lower_triangular(&(0.5 * (&self.stiffness + self.stiffness.transpose())))?;
        let symmetric = lower.solve_lower_triangular(&half.transpose())?;
        let eigen = (0.5 * (&symmetric + symmetric.transpose())).symmetric_eigen();
        let forces = eigen.eigenvectors.tr_mul(&lower.solve_lower_triangular(&self.forces)?);
        let stiffest = eigen.eigenvalues.amax();
        let least = RANK * stiffest.max(forces.amax()).max(f64::MIN_POSITIVE);
        // Without stiffness, a force moves as far as it may, and a rounding does not.
        let along = forces.zip_map(&eigen.eigenvalues, |force, stiffness| match stiffness.abs() {
            stiffness if stiffness > least => -force / stiffness,
            _ if force.abs() > BALANCED * self.scale => -force / least,
            _ => 0.0,
        });
        lower.transpose().solve_upper_triangular(&(eigen.eigenvectors * along))
    }
}

/// The least ξ with `K ξ = b`, or nearest to it; singular values below a part of the largest are zero.
fn least_norm(matrix: &DMatrix<f64>, right: &DVector<f64>, rank: f64) -> Option<DVector<f64>> {
    if matrix.is_empty() {
        return Some(DVector::zeros(matrix.ncols()));
    }
    let decomposed = matrix.clone().try_svd(true, true, f64::EPSILON, 0)?;
    let least = rank * decomposed.singular_values.max();
    decomposed.solve(right, least).ok()
}
