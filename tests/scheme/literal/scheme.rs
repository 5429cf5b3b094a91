//! The scheme (2.5.11) word for word: every coordinate, every constraint, every multiplier, one dense Newton iteration.
//!
//! This is the oracle of the tests, not a way to simulate: a step of n bodies costs O((s n)³). The fast solver eliminates most of these unknowns and
//! must give the same step to rounding.
//!
//! The coordinates of a body are `(x, R) ∈ R³ × R^{3×3} = R¹²` (the columns of R one after the other). Let `Σ = ½ tr(J) 1 − J` be its second-moment
//! matrix. Then the kinetic energy is `½ m |ẋ|² + ½ tr(Ṙ Σ Ṙᵀ) = ½ q̇ᵀ M q̇` with a constant diagonal M, and `p = M q̇` is `(m ẋ, Ṙ Σ)`. The
//! potential is `V = −Σ m gᵀ x`, and F are the forces besides gravity, which depend on the stages' positions and rates ([`crate::literal::forces`]):
//!
//! ```text
//!     Q̇_i = M⁻¹ P_i                                  (2.5.11a)        Q_i = q + h Σ_j a_ij Q̇_j      (2.5.11d)
//!     Ṗ_i = F_i − ∂V/∂q − Dg(Q_i)ᵀ Λ_i               (2.5.11b)        P_i = p + h Σ_j ā_ij Ṗ_j      (2.5.11e)
//!     0   = g(Q_i)                                   (2.5.11c)        q̄ = q + h Σ_i b_i Q̇_i         (2.5.11f)
//!     0   = Dg(q̄) M⁻¹ p̄                              (2.5.11h)        p̄ = p + h Σ_i b_i Ṗ_i         (2.5.11g)
//! ```
//!
//! for i = 1..s. Closed contacts ([`crate::literal::touches`]) add equations to g whose multipliers push along other directions than their gradients,
//! and of velocities. Newton's unknowns are the increments `Q_i − q` (i = 2..s) and `Λ_k` (k = 1..s−1); the other stage values follow from them by
//! the linear equations above, and Λ_s from (2.5.11h), which is linear.
//!
//! | symbol | meaning                                                                 | size, unit                   |
//! |--------|-------------------------------------------------------------------------|------------------------------|
//! | q, Q_i | positions and rotation matrices of all n bodies                         | 12 n; m and 1                |
//! | p, P_i | `(m ẋ, Ṙ Σ)` of all bodies                                              | 12 n; kg m/s and kg m²/s     |
//! | g      | `RᵀR = 1` (6 a body), then the joint's rows (6 − degrees of freedom); loops; contacts | d; m and 1     |
//! | Λ_i    | multipliers                                                             | d; N and N m                 |
//!
//! Source: T. M. Tyranowski, PhD thesis, California Institute of Technology, 2014, section 2.5 (`doc/method.md`).
//!
//! Every row of g is a polynomial of degree two, so its Jacobian and second derivative are exact and come from the
//! same list of coefficients. Σ must be positive definite here, because (2.5.11a) divides by it; the elimination of
//! `RᵀR = 1` that the fast solver uses only divides by J.

use crate::literal::constraints::{Quadratic, constraints};
use crate::literal::coordinates::{BODY_COORDINATES, body_states, coordinates};
use crate::literal::forces::stage_forces;
use crate::literal::touches::{TouchStages, TouchStep};
use catena::lobatto::tableau::butcher::Tableau;
use catena::mechanism::description::body_state::BodyState;
use catena::mechanism::description::mechanism::Mechanism;
use nalgebra::{DMatrix, DVector, Vector3};

/// Newton's method converges in about six iterations, and with kept matrices in about ten; many more mean that the step is too long for it.
const MAXIMUM_ITERATIONS: usize = 50;
/// A correction this small (metres, or entries of a rotation matrix) that stops shrinking is rounding.
const ROUNDING_LEVEL: f64 = 1e-10;

/// Why the literal scheme could not be set up or could not make a step.
#[derive(Clone, Debug, PartialEq)]
pub enum LiteralError {
    /// The mass matrix in R¹² is singular or indefinite, so (2.5.11a) cannot be formed: mass (kg) and second moments (kg m²) must be positive.
    Mass { body: String, mass: f64, moments: [f64; 3] },
    /// Newton's matrix is singular for a step of this length (s).
    Singular { step: f64 },
    /// A contact is of features that the literal scheme has no gap of.
    Features,
    /// Newton's iteration did not reach rounding for a step of this length (s).
    NotConverged { step: f64, correction: f64 },
}

/// One step of the scheme with all its stages.
#[derive(Clone, Debug)]
pub struct LiteralStep {
    /// The next state.
    pub bodies: Vec<BodyState>,
    /// `p`, the momentum the step started with (12 n).
    pub start_momentum: DVector<f64>,
    /// `p̄`, the momentum it ended with (12 n).
    pub end_momentum: DVector<f64>,
    /// `Q_1 … Q_s`, each 12 n; the first is the start and the last the end of the step.
    pub stage_coordinates: Vec<DVector<f64>>,
    /// `Λ_1 … Λ_s`, each d: multipliers of the contacts last.
    pub multipliers: Vec<DVector<f64>>,
    /// Newton iterations.
    pub iterations: usize,
}

/// The literal scheme for one mechanism and one tableau.
#[derive(Clone, Debug)]
pub struct Literal<'a> {
    pub(crate) mechanism: &'a Mechanism,
    pub(crate) tableau: &'a Tableau,
    /// Diagonal of M (12 n).
    pub(crate) mass: DVector<f64>,
    /// `−∂V/∂q` (12 n), constant for gravity.
    force: DVector<f64>,
    /// The rows of g but for contacts.
    pub(crate) constraints: Vec<Quadratic>,
}

impl<'a> Literal<'a> {
    /// Writes out the mass matrix and every constraint.
    ///
    /// # Errors
    /// [`LiteralError::Mass`] if a mass or a second moment of a body is not positive.
    pub fn new(mechanism: &'a Mechanism, tableau: &'a Tableau) -> Result<Self, LiteralError> {
        let size = BODY_COORDINATES * mechanism.bodies.len();
        let (mut mass, mut force) = (DVector::zeros(size), DVector::zeros(size));
        for (index, body) in mechanism.bodies.iter().enumerate() {
            let moments = Vector3::repeat(0.5 * body.inertia.sum()) - body.inertia;
            if body.mass <= 0.0 || moments.min() <= 0.0 {
                let body_name = body.name.clone();
                return Err(LiteralError::Mass { body: body_name, mass: body.mass, moments: moments.into() });
            }
            let first = BODY_COORDINATES * index;
            for row in 0..3 {
                mass[first + row] = body.mass;
                force[first + row] = body.mass * mechanism.gravity[row];
                for column in 0..3 {
                    mass[first + 3 + 3 * column + row] = moments[column];
                }
            }
        }
        Ok(Literal { mechanism, tableau, mass, force, constraints: constraints(mechanism) })
    }

    /// `g(q + increment) − g(q)` (d), without cancellation.
    fn constraint_change(&self, q: &DVector<f64>, increment: &DVector<f64>) -> DVector<f64> {
        DVector::from_iterator(self.constraints.len(), self.constraints.iter().map(|row| row.change(q, increment)))
    }

    /// `Dg(q)` (d × 12 n).
    pub fn constraint_jacobian(&self, q: &DVector<f64>) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(self.constraints.len(), q.len());
        for (index, row) in self.constraints.iter().enumerate() {
            row.add_gradient(q, |column, entry| jacobian[(index, column)] += entry);
        }
        jacobian
    }

    /// One step of length `step` (s), which may be negative, from a state that satisfies all constraints.
    ///
    /// `g(Q_i) = 0` is imposed as `g(Q_i) − g(q) = 0`, which is the same because (2.5.11) assumes `g(q) = 0`: the defect that
    /// rounding leaves in q, some 1e-16, would otherwise be pushed out within one step, at a speed of 1e-16/h, and spoil
    /// the comparison of velocities. In a long run of literal steps these defects add up like a random walk.
    ///
    /// # Errors
    /// [`LiteralError::NotConverged`] or [`LiteralError::Singular`] if the step is too long for Newton's method from
    /// the start `Q_i = q + h c_i q̇`.
    pub fn step(&self, bodies: &[BodyState], step: f64) -> Result<LiteralStep, LiteralError> {
        let (q, velocity) = coordinates(bodies);
        let p = self.mass.component_mul(&velocity);
        let contacts = TouchStep { mechanism: self.mechanism, tableau: self.tableau, q: &q, velocity: &velocity, step };
        let touch = |increments: &[DVector<f64>]| contacts.at(increments).ok_or(LiteralError::Features);
        // Zero increments from q and zero multipliers would do; the straight line saves an iteration.
        let mut increments: Vec<DVector<f64>> = self.tableau.nodes.iter().map(|c| &velocity * (step * c)).collect();
        let ends = touch(&vec![DVector::zeros(q.len()); self.tableau.stages])?.ends;
        let scale = self.multiplier_scale(&stacked(&self.constraint_jacobian(&q), &ends)) / (step * step);
        let (s, n, g, d) = (self.tableau.stages, q.len(), self.constraints.len(), scale.len());
        let mut multipliers = vec![DVector::zeros(d); s];

        let mut last_correction = f64::INFINITY;
        let mut kept = None;
        for iteration in 1..=MAXIMUM_ITERATIONS {
            let touching = touch(&increments)?;
            let jacobians = self.directions(&q, &increments, &touching);
            let forces = self.forces(&q, &velocity, &increments, step);
            let (_, collocated) = self.stage_values(&p, step, &forces, &jacobians, &multipliers);
            let mut residual = DVector::zeros((s - 1) * (n + d));
            for i in 1..s {
                let first = (s - 1) * n + (i - 1) * d;
                residual.rows_mut((i - 1) * n, n).copy_from(&(&increments[i] - &collocated[i]));
                residual.rows_mut(first, g).copy_from(&self.constraint_change(&q, &increments[i]));
                residual.rows_mut(first + g, d - g).copy_from(&touching.rows[i]);
            }
            let factors = match kept.take() {
                Some(factors) => factors,
                None => {
                    let mut newton_matrix = self.newton_matrix(step, &jacobians, &multipliers, &scale);
                    self.add_force_derivatives(&q, &velocity, &increments, step, &forces, &mut newton_matrix);
                    self.add_touch_derivatives(&contacts, &increments, &touching, &multipliers, &mut newton_matrix)
                        .ok_or(LiteralError::Features)?;
                    newton_matrix.lu()
                }
            };
            let correction = factors.solve(&residual).ok_or(LiteralError::Singular { step })?;
            for i in 1..s {
                increments[i] -= correction.rows((i - 1) * n, n);
                multipliers[i - 1] -= correction.rows((s - 1) * n + (i - 1) * d, d).component_mul(&scale);
            }
            // The largest entry; a NaN, which `amax` would lose, is the largest of all.
            let size = correction.iter().map(|entry| entry.abs()).max_by(f64::total_cmp).unwrap_or(0.0);
            if !size.is_finite() {
                return Err(LiteralError::NotConverged { step, correction: size });
            }
            if size < ROUNDING_LEVEL && size > 0.25 * last_correction || size == 0.0 {
                return self.finish(&contacts, &increments, multipliers, iteration);
            }
            // The residual alone decides which solution this is; its matrix is kept while corrections fall tenfold.
            kept = (size < 0.1 * last_correction).then_some(factors);
            last_correction = size;
        }
        Err(LiteralError::NotConverged { step, correction: last_correction })
    }

    /// `Dg(Q_i)` of all stages, with the pulls of the contacts below.
    fn directions(&self, q: &DVector<f64>, increments: &[DVector<f64>], touching: &TouchStages) -> Vec<DMatrix<f64>> {
        let of = |(increment, pulls): (&DVector<f64>, &DMatrix<f64>)| {
            stacked(&self.constraint_jacobian(&(q + increment)), pulls)
        };
        increments.iter().zip(&touching.pulls).map(of).collect()
    }

    /// The forces of all stages, gravity included.
    pub(crate) fn forces(
        &self,
        q: &DVector<f64>,
        velocity: &DVector<f64>,
        increments: &[DVector<f64>],
        step: f64,
    ) -> Vec<DVector<f64>> {
        let mut forces = stage_forces(self.mechanism, self.tableau, q, velocity, increments, step);
        forces.iter_mut().for_each(|force| *force += &self.force);
        forces
    }

    /// `P_i` by (2.5.11b, e), and `Q_i − q` by (2.5.11a, d), from the multipliers and `Dg(Q_i)` of all stages.
    fn stage_values(
        &self,
        p: &DVector<f64>,
        step: f64,
        forces: &[DVector<f64>],
        jacobians: &[DMatrix<f64>],
        multipliers: &[DVector<f64>],
    ) -> (Vec<DVector<f64>>, Vec<DVector<f64>>) {
        let s = self.tableau.stages;
        let momentum_rates: Vec<DVector<f64>> =
            (0..s).map(|i| &forces[i] - jacobians[i].tr_mul(&multipliers[i])).collect();
        let momenta: Vec<DVector<f64>> = (0..s)
            .map(|i| (0..s).fold(p.clone(), |sum, j| sum + &momentum_rates[j] * (step * self.tableau.a_bar[i * s + j])))
            .collect();
        let rates: Vec<DVector<f64>> = momenta.iter().map(|momentum| momentum.component_div(&self.mass)).collect();
        let increments = (0..s)
            .map(|i| {
                (0..s).fold(DVector::zeros(p.len()), |sum, j| sum + &rates[j] * (step * self.tableau.a[i * s + j]))
            })
            .collect();
        (momenta, increments)
    }

    /// The last multiplier by the projection (2.5.11h), and the end of the step.
    fn finish(
        &self,
        contacts: &TouchStep,
        increments: &[DVector<f64>],
        mut multipliers: Vec<DVector<f64>>,
        iterations: usize,
    ) -> Result<LiteralStep, LiteralError> {
        let &TouchStep { q, velocity, step, .. } = contacts;
        let (s, b) = (self.tableau.stages, &self.tableau.weights);
        let stage_coordinates: Vec<DVector<f64>> = increments.iter().map(|increment| q + increment).collect();
        let touching = contacts.at(increments).ok_or(LiteralError::Features)?;
        let jacobians = self.directions(q, increments, &touching);
        let p = self.mass.component_mul(velocity);
        let forces = self.forces(q, velocity, increments, step);
        let mut end_momentum = p.clone();
        for i in 0..s {
            end_momentum += (&forces[i] - jacobians[i].tr_mul(&multipliers[i])) * (step * b[i]);
        }
        // Twice, so that the rounding error of the first solution is projected away too.
        let gradient = stacked(&self.constraint_jacobian(&stage_coordinates[s - 1]), &touching.ends);
        let carried = touching.carried.clone().insert_rows(0, self.constraints.len(), 0.0);
        for _ in 0..2 {
            let correction = self
                .project(&gradient, &jacobians[s - 1], &end_momentum, &carried)
                .ok_or(LiteralError::Singular { step })?;
            end_momentum -= jacobians[s - 1].tr_mul(&correction);
            multipliers[s - 1] += correction / (step * b[s - 1]);
        }
        let velocity = end_momentum.component_div(&self.mass);
        Ok(LiteralStep {
            bodies: body_states(&stage_coordinates[s - 1], &velocity),
            start_momentum: p,
            end_momentum,
            stage_coordinates,
            multipliers,
            iterations,
        })
    }

    /// The impulse μ with `G M⁻¹ (p − G̃ᵀ μ) = w` for the gradients G, the directions G̃ in which multipliers push and the rates w of belts; `None` if
    /// the rows depend on each other.
    fn project(
        &self,
        gradient: &DMatrix<f64>,
        directions: &DMatrix<f64>,
        momentum: &DVector<f64>,
        carried: &DVector<f64>,
    ) -> Option<DVector<f64>> {
        let mut weighted = gradient.clone();
        for (mut column, mass) in weighted.column_iter_mut().zip(self.mass.iter()) {
            column /= *mass;
        }
        (&weighted * directions.transpose()).lu().solve(&(weighted * momentum - carried))
    }
}

/// One matrix above the other.
fn stacked(above: &DMatrix<f64>, below: &DMatrix<f64>) -> DMatrix<f64> {
    let mut both = above.clone().resize_vertically(above.nrows() + below.nrows(), 0.0);
    both.rows_mut(above.nrows(), below.nrows()).copy_from(below);
    both
}
