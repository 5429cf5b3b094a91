//! The linear equations of motion about a state.
//!
//! Small deviations ξ (d) of the independent coordinates, and η (e) of the independent velocities, move all others along with the closures. Without
//! contacts that roll both are the same freedoms; contacts that roll leave fewer velocities than positions, e < d:
//!
//! ```text
//!     δq = T ξ                     G T = 0 for the closures of positions
//!     δv = V η + W ξ               G V = 0,  G W = −∂(G v)/∂q T,  W_E = 0        E: the independent velocities
//!     ξ̇  = V_I η + (W + N T)_I ξ   N: −ŵ for each ball joint that turns at w; zero at rest
//!
//!     [ M  −P ] [δa]     [ ∂(ρ − Pλ)/∂q δq + ∂(ρ − Pλ)/∂v δv − δτ ]
//!     [ G   0 ] [δλ] = − [ ∂g̈/∂q δq + ∂g̈/∂v δv                   ]        M = ∂ρ/∂a
//!
//!     (ξ̇, η̇) = A (ξ, η) + B δτ        H = Vᵀ M V,   K = −H A_ηξ,   C = −H A_ηη
//! ```
//!
//! Only independent rows of G are solved. At rest K is the tangent stiffness (with the geometric one of all forces), and C the damping.
//!
//! | symbol  | meaning                                             | size                |
//! |---------|-----------------------------------------------------|---------------------|
//! | A       | the matrix of the state                             | (d + e) × (d + e)   |
//! | B       | accelerations per unit of effort along each freedom | (d + e) × n         |
//! | H, C, K | inertia, damping, stiffness                         | e × e, e × e, e × d |
//!
//! Source: A. A. Shabana, Dynamics of Multibody Systems, Cambridge 2020, chapter 3 (the coordinate split); J. I. Neimark, N. A. Fufaev, Dynamics of
//! Nonholonomic Systems, AMS 1972, chapter 5 (rolling).

use crate::derivatives::linear::equations::{By, Equations, Point};
use crate::derivatives::linear::independent::BothIndependent;
use crate::mechanism::description::joint::FreeRotation;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector, Vector3};

/// The linear equations of motion about a state; the table of the module says which matrices they are.
#[derive(Clone, Debug)]
pub struct Linearised {
    /// The independent degrees of freedom, by their entries among all (d).
    pub independent: Vec<usize>,
    /// The independent velocities E, some of these degrees of freedom (e).
    pub rates: Vec<usize>,
    /// T (n × d).
    pub motions: DMatrix<f64>,
    /// V (n × e).
    pub rolling: DMatrix<f64>,
    /// A.
    pub state: DMatrix<f64>,
    /// B.
    pub input: DMatrix<f64>,
    /// H (e × e).
    pub inertia: DMatrix<f64>,
    /// C (e × e).
    pub damping: DMatrix<f64>,
    /// K (e × d).
    pub stiffness: DMatrix<f64>,
    /// The accelerations in the state itself (n): zero at an equilibrium.
    pub accelerations: DVector<f64>,
    /// W (n × d).
    pub followed: DMatrix<f64>,
    /// δa by ξ and η (n × (d + e)).
    pub accelerated: DMatrix<f64>,
    /// δa by δτ (n × n).
    pub by_effort: DMatrix<f64>,
    /// The size of stiffnesses over inertias whose roundings are in K, by the forces of contacts [1/s²]: they may have no stiffness at all.
    pub pressed: f64,
}

/// Why a state has no linear equations.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LinearError {
    /// Some motion moves no mass.
    #[error(
        "some motion of the joints moves no mass here: give every moving link a mass, or a start off the singular position of its loops"
    )]
    Singular,
    /// Forces that the linear equations do not know.
    #[error(
        "linear equations know no drag, no loads that change in time or turn with a link, and no gravity compensation of motors: leave these out of the scene"
    )]
    Unknown,
    /// Pressures that friction needs are not unique.
    #[error(
        "closed contacts slide with friction here, and their pressures are not unique: linear equations need as few contacts as bear the load; \
         take an instant without some of them"
    )]
    Shared,
    /// A number is not finite.
    #[error("the equations of motion are not finite numbers here: a spring between points may have no length")]
    NotFinite,
}

/// Followers are likelier to be dependent, and driven joints are likelier not to be.
const LIKELIER: f64 = 1e2;

impl Linearised {
    /// About a state on its closures, under efforts τ (n) along the degrees of freedom; those that are driven stay independent if they can.
    ///
    /// # Errors
    /// [`LinearError`] for motions without mass, and numbers that are not finite.
    pub fn about(
        mechanism: &Mechanism,
        state: &State,
        efforts: &DVector<f64>,
        driven: &[usize],
    ) -> Result<Self, LinearError> {
        if mechanism.velocity_count == 0 {
            return Ok(Linearised::of_nothing());
        }
        let equations = Equations::new(mechanism);
        let (n, m) = (mechanism.velocity_count, equations.rows());
        let (still, unloaded) = (DVector::zeros(n), DVector::zeros(m));
        let at_rest = Point { state, accelerations: &still, multipliers: &unloaded };
        let values = equations.at(&at_rest);
        let by_velocity = equations.derivatives(&at_rest, By::Velocities);
        let mass = equations.derivatives(&at_rest, By::Accelerations).efforts;
        let gradient = &by_velocity.closures[1];
        let of_positions = equations.of_positions();
        let split = BothIndependent::of(gradient, of_positions, &weights(mechanism, driven));
        let BothIndependent { positions, velocities: split } = split.ok_or(LinearError::Singular)?;
        if equations.share_friction(&split.rows) {
            return Err(LinearError::Shared);
        }
        let pushes = equations.pushes(&at_rest, gradient).select_columns(&split.rows);
        let rows = gradient.select_rows(&split.rows);
        let solver = Bordered::new(&mass, &rows, &pushes).ok_or(LinearError::Singular)?;
        // The motion of the state itself.
        let [forces, second] = [efforts - values.efforts.column(0), -values.closures[2].column(0)];
        let found = solver.solve(
            &DMatrix::from_column_slice(n, 1, forces.as_slice()),
            &DMatrix::from_column_slice(m, 1, second.as_slice()).select_rows(&split.rows),
        );
        let (accelerations, found) = found.ok_or(LinearError::Singular)?;
        let accelerations = accelerations.column(0).into_owned();
        let mut multipliers = DVector::zeros(m);
        split.rows.iter().zip(found.iter()).for_each(|(&row, &push)| multipliers[row] = push);
        if accelerations.iter().chain(multipliers.iter()).any(|number| !number.is_finite()) {
            return Err(LinearError::NotFinite);
        }
        let point = Point { state, accelerations: &accelerations, multipliers: &multipliers };
        let by_position = equations.derivatives(&point, By::Positions);
        let by_velocity = equations.derivatives(&point, By::Velocities);
        let (d, e) = (positions.independent.len(), split.independent.len());
        let motions = positions.motions(&gradient.rows(0, of_positions).into_owned()).ok_or(LinearError::Singular)?;
        let rolling = split.motions(gradient).ok_or(LinearError::Singular)?;
        let bent = -(&by_position.closures[1] * &motions);
        let turned = split.solve(gradient, &bent, &DMatrix::zeros(e, d)).ok_or(LinearError::Singular)?;
        let along = |by_position: &DMatrix<f64>, by_velocity: &DMatrix<f64>| {
            let mut columns = DMatrix::zeros(by_position.nrows(), d + e);
            columns.columns_mut(0, d).copy_from(&(by_position * &motions + by_velocity * &turned));
            columns.columns_mut(d, e).copy_from(&(by_velocity * &rolling));
            columns
        };
        let forces = -along(&by_position.efforts, &by_velocity.efforts);
        let second = -along(&by_position.closures[2], &by_velocity.closures[2]).select_rows(&split.rows);
        let (by_state, _) = solver.solve(&forces, &second).ok_or(LinearError::Singular)?;
        let (by_effort, _) = solver
            .solve(&DMatrix::identity(n, n), &DMatrix::zeros(split.rows.len(), n))
            .ok_or(LinearError::Singular)?;
        let mut matrix = DMatrix::zeros(d + e, d + e);
        let turning = turning(mechanism, state) * &motions;
        // W is zero along the independent velocities.
        let turning = if d > e { turning + &turned } else { turning }.select_rows(&positions.independent);
        matrix.view_mut((0, 0), (d, d)).copy_from(&turning);
        matrix.view_mut((0, d), (d, e)).copy_from(&rolling.select_rows(&positions.independent));
        matrix.view_mut((d, 0), (e, d + e)).copy_from(&by_state.select_rows(&split.independent));
        let mut input = DMatrix::zeros(d + e, n);
        input.view_mut((d, 0), (e, n)).copy_from(&by_effort.select_rows(&split.independent));
        if matrix.iter().chain(input.iter()).any(|number| !number.is_finite()) {
            return Err(LinearError::NotFinite);
        }
        let inertia = rolling.tr_mul(&(&mass * &rolling));
        Ok(Linearised {
            stiffness: -(&inertia * matrix.view((d, 0), (e, d))),
            damping: -(&inertia * matrix.view((d, d), (e, e))),
            inertia,
            independent: positions.independent,
            rates: split.independent,
            motions,
            rolling,
            state: matrix,
            input,
            accelerations,
            followed: turned,
            accelerated: by_state,
            by_effort,
            pressed: pressed(mechanism, &mass, &multipliers.as_slice()[equations.closures()..]),
        })
    }
}

impl Linearised {
    /// The empty equations of a mechanism whose joints are all held.
    fn of_nothing() -> Self {
        let none = DMatrix::zeros(0, 0);
        Linearised {
            independent: Vec::new(),
            rates: Vec::new(),
            motions: none.clone(),
            rolling: none.clone(),
            state: none.clone(),
            input: none.clone(),
            inertia: none.clone(),
            damping: none.clone(),
            stiffness: none.clone(),
            accelerations: DVector::zeros(0),
            followed: none.clone(),
            accelerated: none.clone(),
            by_effort: none,
            pressed: 0.0,
        }
    }
}

/// `|λ| / √(m J)` for the largest force of a contact, the lightest body and the least moment of inertia along a freedom.
fn pressed(mechanism: &Mechanism, mass: &DMatrix<f64>, forces: &[f64]) -> f64 {
    let force = forces.iter().fold(0.0, |largest: f64, force| largest.max(force.abs()));
    let lightest =
        mechanism.bodies.iter().map(|body| body.mass).filter(|&mass| mass > 0.0).fold(f64::INFINITY, f64::min);
    let least = mass.diagonal().iter().copied().fold(f64::INFINITY, f64::min);
    if force > 0.0 { force / (lightest * least).sqrt() } else { 0.0 }
}

/// The weights with which degrees of freedom are chosen to depend on others (n).
pub(super) fn weights(mechanism: &Mechanism, driven: &[usize]) -> Vec<f64> {
    let mut weights = vec![1.0; mechanism.velocity_count];
    mechanism.mimics.iter().for_each(|mimic| weights[mimic.follower.freedom] *= LIKELIER);
    driven.iter().for_each(|&freedom| weights[freedom] /= LIKELIER);
    weights
}

/// N (n × n): a slight turn δ of a ball joint that turns at w grows as δ̇ = δw − w × δ, all about the axes of the child.
fn turning(mechanism: &Mechanism, state: &State) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(mechanism.velocity_count, mechanism.velocity_count);
    for body in mechanism.bodies.iter().filter(|body| body.joint.kind.rotation() == FreeRotation::Ball) {
        let first = body.joint.velocity_index + body.joint.kind.translation_axes().len();
        let spin = Vector3::from_column_slice(&state.velocity[first..first + 3]);
        matrix.view_mut((first, first), (3, 3)).copy_from(&-spin.cross_matrix());
    }
    matrix
}

/// The mass matrix bordered by the closures, factored.
struct Bordered {
    factors: nalgebra::LU<f64, nalgebra::Dyn, nalgebra::Dyn>,
    freedoms: usize,
}

impl Bordered {
    /// With the directions in which the multipliers of the rows push.
    fn new(mass: &DMatrix<f64>, rows: &DMatrix<f64>, pushes: &DMatrix<f64>) -> Option<Self> {
        let (m, n) = rows.shape();
        let mut matrix = DMatrix::zeros(n + m, n + m);
        matrix.view_mut((0, 0), (n, n)).copy_from(mass);
        matrix.view_mut((0, n), (n, m)).copy_from(&-pushes);
        matrix.view_mut((n, 0), (m, n)).copy_from(rows);
        let factors = matrix.lu();
        factors.is_invertible().then_some(Bordered { factors, freedoms: n })
    }

    /// δa and δλ for both parts of the right-hand side, column by column.
    fn solve(&self, forces: &DMatrix<f64>, second: &DMatrix<f64>) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let n = self.freedoms;
        let mut right = DMatrix::zeros(n + second.nrows(), forces.ncols());
        right.rows_mut(0, n).copy_from(forces);
        right.rows_mut(n, second.nrows()).copy_from(second);
        let found = self.factors.solve(&right)?;
        Some((found.rows(0, n).into_owned(), found.rows(n, second.nrows()).into_owned()))
    }
}
