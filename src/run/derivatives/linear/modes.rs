//! The modes of linear equations of motion: motions `x(t) = Re(z e^{λ t})`.
//!
//! ```text
//!     A z = λ z        frequency |Im λ|/2π [Hz],   damping ratio −Re λ/|λ|,   time constant 1/|Re λ| [s]
//! ```
//!
//! Without damping λ² = −σ for the eigenvalues σ of the symmetric `L⁻¹ K L⁻ᵀ` with `H = L Lᵀ`: zeros and equal frequencies are found to rounding.
//! Otherwise Schur's decomposition of A gives λ. The shape z is the singular vector of A − λ with the least singular value, or with one of the next
//! if an eigenvalue is met again.
//!
//! Contacts that roll leave fewer velocities η than positions ξ. At rest `ξ̇ = S η`, so that motions have the stiffness K S along the velocities, and
//! swing with the shapes S z.
//!
//! Free motions are the null space of K. Their zeros are counted there, because a double zero of A is only found to the root of a rounding:
//! a free motion without damping has two zeros, one with damping has one.
//!
//! Source: G. H. Golub, C. F. Van Loan, Matrix Computations, Johns Hopkins 2013, chapters 7 and 8.

use crate::derivatives::linear::linearised::Linearised;
use nalgebra::{Complex, DMatrix, DVector, Schur, SymmetricEigen};

/// Entries below this part of the largest are roundings: of damping, asymmetry, and singular values.
const ROUNDING: f64 = 1e-11;
/// Real parts below this part of |λ| say neither growth nor decay.
const NEUTRAL: f64 = 1e-10;
/// Eigenvalues this near to each other, as a part of the largest, are one.
const EQUAL: f64 = 1e-7;
/// Sweeps of Schur's decomposition, for each eigenvalue.
const SWEEPS: usize = 100;
/// Attempts of it.
const ATTEMPTS: usize = 10;

/// How a mode goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// It decays.
    Stable,
    /// It neither decays nor grows.
    Neutral,
    /// It grows.
    Unstable,
    /// It moves without a restoring force: λ = 0.
    Free,
}

impl Stability {
    /// The answer to whether it is stable.
    pub fn word(self) -> &'static str {
        match self {
            Stability::Stable => "yes",
            Stability::Neutral => "neutral",
            Stability::Unstable => "no",
            Stability::Free => "free",
        }
    }
}

/// A mode; those that swing stand for both λ and its conjugate.
#[derive(Clone, Debug)]
pub struct LinearMode {
    /// λ [1/s], its imaginary part not negative.
    pub eigenvalue: Complex<f64>,
    pub stability: Stability,
    /// z along all degrees of freedom (n), of norm one; the largest entry is real and positive.
    pub shape: DVector<Complex<f64>>,
}

impl LinearMode {
    /// Hz; zero for modes that do not swing.
    pub fn frequency(&self) -> f64 {
        self.eigenvalue.im / std::f64::consts::TAU
    }

    /// −Re λ/|λ|; `None` for free motions.
    pub fn damping_ratio(&self) -> Option<f64> {
        (self.stability != Stability::Free).then(|| -self.eigenvalue.re / self.eigenvalue.norm() + 0.0)
    }

    /// 1/|Re λ| (s); `None` where it neither decays nor grows.
    pub fn time_constant(&self) -> Option<f64> {
        matches!(self.stability, Stability::Stable | Stability::Unstable).then(|| 1.0 / self.eigenvalue.re.abs())
    }
}

/// The modes could not be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the eigenvalues of the linear equations were not found: its numbers are too far apart in size")]
pub struct NoModes;

impl Linearised {
    /// The modes, the slowest frequency first.
    ///
    /// # Errors
    /// [`NoModes`] where Schur's decomposition does not converge.
    pub fn modes(&self) -> Result<Vec<LinearMode>, NoModes> {
        if self.inertia.is_empty() {
            return Ok(Vec::new());
        }
        let mut modes = match self.undamped() {
            Some(modes) => modes,
            None => self.damped()?,
        };
        let order = |mode: &LinearMode| (mode.eigenvalue.norm(), mode.eigenvalue.re);
        modes.sort_by(|one, other| {
            let ((size, real), (other_size, other_real)) = (order(one), order(other));
            size.total_cmp(&other_size).then(real.total_cmp(&other_real))
        });
        Ok(modes)
    }

    /// The modes by the symmetric problem; `None` if there is damping, or forces without a potential.
    fn undamped(&self) -> Option<Vec<LinearMode>> {
        let Linearised { inertia, damping, .. } = self;
        let (stiffness, scale) = (&self.along_velocities(), self.scale());
        let rubs = self.scaled(damping).amax() > ROUNDING * scale.sqrt();
        let circulates = self.scaled(&(stiffness - stiffness.transpose())).amax() > ROUNDING * scale;
        if rubs || circulates || self.turns() {
            return None;
        }
        let lower = inertia.clone().cholesky()?.l();
        let half = lower.solve_lower_triangular(&(0.5 * (stiffness + stiffness.transpose())))?;
        let symmetric = lower.solve_lower_triangular(&half.transpose())?;
        let SymmetricEigen { eigenvalues, eigenvectors } =
            (0.5 * (&symmetric + symmetric.transpose())).symmetric_eigen();
        let shapes = lower.transpose().solve_upper_triangular(&eigenvectors)?;
        let mut modes = if self.rolls() { self.free_motions() } else { Vec::new() };
        for (index, &square) in eigenvalues.iter().enumerate() {
            let shape = self.places(&shapes.column(index).map(|entry| Complex::new(entry, 0.0)));
            let mut add = |eigenvalue, stability| modes.push(self.mode(eigenvalue, stability, &shape));
            if square.abs() <= ROUNDING * scale {
                if !self.rolls() {
                    add(Complex::new(0.0, 0.0), Stability::Free);
                }
            } else if square > 0.0 {
                add(Complex::new(0.0, square.sqrt()), Stability::Neutral);
            } else {
                add(Complex::new(-(-square).sqrt(), 0.0), Stability::Stable);
                add(Complex::new((-square).sqrt(), 0.0), Stability::Unstable);
            }
        }
        Some(modes)
    }

    /// The modes by the eigenvalues of A.
    fn damped(&self) -> Result<Vec<LinearMode>, NoModes> {
        // At rest free motions are counted apart, and the velocities swing alone.
        let alone = self.rolls() && !self.turns();
        let state = if alone { self.of_velocities() } else { self.state.clone() };
        let (count, d) = (state.nrows(), self.independent.len());
        let mut balanced = state.clone();
        nalgebra::linalg::balancing::balance_parlett_reinsch(&mut balanced);
        let mut values = eigenvalues(balanced)?;
        values.sort_by(|one, other| one.norm().total_cmp(&other.norm()));
        let largest = values.iter().map(|value| value.norm()).fold(0.0, f64::max);
        let zeros = self.zeros();
        values[..zeros].fill(Complex::new(0.0, 0.0));
        let mut modes: Vec<LinearMode> = self.free_motions().into_iter().collect();
        let complex = state.map(|entry| Complex::new(entry, 0.0));
        let mut before: Vec<Complex<f64>> = Vec::new();
        for &value in values[zeros..].iter().filter(|value| value.im >= 0.0) {
            let again = before.iter().filter(|other| (*other - value).norm() <= EQUAL * largest).count();
            before.push(value);
            let shifted = &complex - DMatrix::from_diagonal_element(count, count, value);
            let decomposed = shifted.try_svd(false, true, f64::EPSILON, 0).ok_or(NoModes)?;
            let rows = decomposed.v_t.ok_or(NoModes)?;
            // The singular values are sorted, the largest first.
            let row = count.saturating_sub(1 + again);
            let own = rows.row(row).adjoint();
            let shape = if alone {
                self.places(&own.rows(0, self.rates.len()).into_owned())
            } else {
                own.rows(0, d).into_owned()
            };
            let stability = match value.re {
                re if re.abs() <= NEUTRAL * value.norm() => Stability::Neutral,
                re if re < 0.0 => Stability::Stable,
                _ => Stability::Unstable,
            };
            modes.push(self.mode(value, stability, &shape));
        }
        Ok(modes)
    }

    /// The free motions: the null space of K.
    fn free_motions(&self) -> Vec<LinearMode> {
        let null = self.null_space();
        let of = |shape: nalgebra::DVectorView<f64>| {
            self.mode(Complex::new(0.0, 0.0), Stability::Free, &shape.map(|entry| Complex::new(entry, 0.0)))
        };
        null.column_iter().map(|column| of(column.as_view())).collect()
    }

    /// How often zero is an eigenvalue, at rest: along the velocities if some contacts roll.
    fn zeros(&self) -> usize {
        let own = self.along_velocities();
        let weights = self.weights();
        let (right, left) =
            (self.null_space_of(&own, &weights, &weights), self.null_space_of(&own.transpose(), &weights, &weights));
        if right.is_empty() {
            return 0;
        }
        let rubbing = left.tr_mul(&(&self.damping * &right));
        let braked = rubbing.rank(ROUNDING * self.damping.amax().max(f64::MIN_POSITIVE));
        (2 * right.ncols() - braked).min(self.state.nrows())
    }

    /// Null vectors of K in columns; without any where ball joints turn.
    fn null_space(&self) -> DMatrix<f64> {
        let weights = self.weights();
        let across = if self.rolls() { self.weights_of_places() } else { weights.clone() };
        self.null_space_of(&self.stiffness, &weights, &across)
    }

    /// Null vectors of a matrix of stiffness in columns, with the weights of its rows and columns.
    fn null_space_of(&self, matrix: &DMatrix<f64>, down: &DVector<f64>, across: &DVector<f64>) -> DMatrix<f64> {
        let d = matrix.ncols();
        if self.turns() {
            return DMatrix::zeros(d, 0);
        }
        // Rows of zeros make a null space of all columns.
        let scaled = DMatrix::from_fn(d, d, |row, column| {
            if row < matrix.nrows() { down[row] * matrix[(row, column)] * across[column] } else { 0.0 }
        });
        let least = ROUNDING * self.scale();
        let decomposed = scaled.svd(false, true);
        let Some(rows) = decomposed.v_t else { return DMatrix::zeros(d, 0) };
        let null: Vec<usize> = (0..d).filter(|&index| decomposed.singular_values[index] <= least).collect();
        // Back from scaled coordinates.
        DMatrix::from_fn(d, null.len(), |row, column| across[row] * rows[(null[column], row)])
    }

    /// Whether ball joints or the contacts that roll turn in the state itself.
    fn turns(&self) -> bool {
        let d = self.independent.len();
        self.state.view((0, 0), (d, d)).amax() > 0.0
    }

    /// Whether there are fewer velocities than positions.
    fn rolls(&self) -> bool {
        self.rates.len() < self.independent.len()
    }

    /// S (d × e).
    fn sliding(&self) -> DMatrix<f64> {
        let (d, e) = (self.independent.len(), self.rates.len());
        self.state.view((0, d), (d, e)).into_owned()
    }

    /// K S (e × e).
    fn along_velocities(&self) -> DMatrix<f64> {
        if self.rolls() { &self.stiffness * self.sliding() } else { self.stiffness.clone() }
    }

    /// `[0 1; −H⁻¹ K S, −H⁻¹ C]`: the motions along the velocities, at rest.
    fn of_velocities(&self) -> DMatrix<f64> {
        let (d, e) = (self.independent.len(), self.rates.len());
        let mut matrix = DMatrix::zeros(2 * e, 2 * e);
        matrix.view_mut((0, e), (e, e)).fill_with_identity();
        matrix.view_mut((e, 0), (e, e)).copy_from(&(self.state.view((d, 0), (e, d)) * self.sliding()));
        matrix.view_mut((e, e), (e, e)).copy_from(&self.state.view((d, d), (e, e)));
        matrix
    }

    /// The shape along the positions for one along the velocities.
    fn places(&self, shape: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
        if self.rolls() { self.sliding().map(|entry| Complex::new(entry, 0.0)) * shape } else { shape.clone() }
    }

    /// `H_ii^{−1/2}`: coordinates in which all inertias are about one.
    fn weights(&self) -> DVector<f64> {
        self.inertia.diagonal().map(|inertia| 1.0 / inertia.max(f64::MIN_POSITIVE).sqrt())
    }

    /// The same of positions: how far each one moves with velocities whose inertias are about one.
    fn weights_of_places(&self) -> DVector<f64> {
        let (sliding, weights) = (self.sliding(), self.weights());
        let moved: Vec<f64> = sliding.row_iter().map(|row| row.transpose().component_mul(&weights).norm()).collect();
        let largest = moved.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        DVector::from_iterator(
            moved.len(),
            moved.iter().map(|&way| if way > ROUNDING * largest { way } else { largest }),
        )
    }

    fn scaled(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        let weights = self.weights();
        DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |row, column| {
            weights[row] * matrix[(row, column)] * weights[column]
        })
    }

    /// The size of K in these coordinates [1/s²].
    fn scale(&self) -> f64 {
        self.scaled(&self.along_velocities()).amax().max(self.pressed).max(f64::MIN_POSITIVE)
    }

    /// A mode with its shape along all degrees of freedom.
    fn mode(&self, eigenvalue: Complex<f64>, stability: Stability, shape: &DVector<Complex<f64>>) -> LinearMode {
        let whole = self.motions.map(|entry| Complex::new(entry, 0.0)) * shape;
        let largest = whole.iter().copied().fold(Complex::new(0.0, 0.0), |largest, entry| {
            if entry.norm() > largest.norm() * (1.0 + NEUTRAL) { entry } else { largest }
        });
        let norm = whole.norm();
        let turn = if norm > 0.0 { largest.conj() / (largest.norm() * norm) } else { Complex::new(1.0, 0.0) };
        LinearMode { eigenvalue, stability, shape: whole * turn }
    }
}

/// The eigenvalues of a matrix. The sweeps may stand still on matrices that turn vectors into each other; then they begin again after a reflection
/// `1 − 2 u uᵀ/uᵀu` of both sides, which leaves the eigenvalues as they are.
fn eigenvalues(mut matrix: DMatrix<f64>) -> Result<Vec<Complex<f64>>, NoModes> {
    let count = matrix.nrows();
    for attempt in 1..=ATTEMPTS {
        if let Some(schur) = Schur::try_new(matrix.clone(), f64::EPSILON, SWEEPS * count) {
            return Ok(schur.complex_eigenvalues().iter().copied().collect());
        }
        let normal = DVector::from_fn(count, |row, _| ((attempt * (row + 1)) as f64).sin());
        let reflection = DMatrix::identity(count, count) - &normal * normal.transpose() * (2.0 / normal.norm_squared());
        matrix = &reflection * matrix * &reflection;
    }
    Err(NoModes)
}
