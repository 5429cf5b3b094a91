//! Computes the coefficients of the Lobatto IIIA–IIIB pair with about 32 digits.
//!
//! The nodes `c₁ = 0 < … < c_s = 1` are the zeros of `x (1 − x) P′_{s−1}(2x − 1)` with the Legendre polynomial P; the weights integrate polynomials
//! of degree 2s − 3 exactly. Let `ℓ_j` be the Lagrange polynomials of the nodes and `D_ij = ℓ_j′(c_i)` their differentiation matrix:
//!
//! ```text
//!     a_ij = ∫₀^{c_i} ℓ_j                        IIIA, collocation                      (2.5.11d)
//!     ā_ij = b_j (1 − a_ji / b_i)                IIIB, from symplecticity               (2.5.11e)
//!     Â    = (A Ā)[2..s, 1..s−1]                 Q_i = q₀ + h c_i v₀ + h² Σ_k Â_ik M⁻¹ F_k
//!     B    = Â⁻¹ = −(diag(b)⁻¹ Dᵀ diag(b) D)[1..s−1, 2..s]
//!     w_i  = Σ_{k<s} b_k B_ki = Σ_j b_j D_js D_ji            momentum weights, i = 2..s
//!     Ā B                                                    stage velocities from stage positions
//! ```
//!
//! The second form of B is why no matrix is inverted here. Along a polynomial with the values `Q_i` the stage
//! equations say that the discrete action `Σ_j b_j ½ |Σ_i D_ji Q_i|² h⁻¹ − …` (2.5.12) is stationary in every `Q_k`
//! (k = 2..s−1) and has the derivative `−p₀` with respect to `Q₁`; differentiating it gives the rows of B at once.
//! (Inverting Â in doubles leaves an error of 7e-9 in B at s = 9, which is a steady drift of the energy.)
//! Everything else is closed form as well, by the discrete orthogonality of the Legendre polynomials on the nodes:
//!
//! ```text
//!     b_i = 1 / (s (s−1) P_{s−1}(ξ_i)²),   ξ = 2c − 1,       ℓ_j = b_j Σ_{k<s} P_k(ξ_j) P_k / γ_k
//!     γ_k = 1 / (2k+1) for k < s−1,   γ_{s−1} = 1 / (s−1),   ∫₀^x P_k = (P_{k+1} − P_{k−1}) / (2 (2k+1)) at 2x − 1
//! ```
//!
//! Sources: T. M. Tyranowski, PhD thesis, California Institute of Technology, 2014, (2.5.11) and (2.5.12); E. Hairer, C. Lubich, G. Wanner,
//! "Geometric Numerical Integration", sections II.1, IV.2 and VII.1; the pair (b, D) on Gauss–Lobatto nodes is textbook spectral elements.

use crate::numbers::extended::Extended;

/// The fields of [`Tableau`](crate::tableau::butcher::Tableau) before rounding.
#[derive(Clone)]
pub(crate) struct Exact {
    pub nodes: Vec<Extended>,
    pub weights: Vec<Extended>,
    pub a: Vec<Extended>,
    pub a_bar: Vec<Extended>,
    pub a_hat: Vec<Extended>,
    pub b_matrix: Vec<Extended>,
    pub momentum_weights: Vec<Extended>,
    pub velocity: Vec<Extended>,
    pub top_legendre: Vec<Extended>,
}

impl Exact {
    /// The coefficients for a number of stages, two at least.
    pub fn new(stages: usize) -> Exact {
        let (s, inner) = (stages, stages - 1);
        let one = Extended::ONE;
        let number = |value: usize| Extended::from(value);
        let points = lobatto_points(s);
        // P_k(ξ_i) for k = 0..s, one row a node.
        let legendre: Vec<Vec<Extended>> = points.iter().map(|&point| legendre_values(point, s)).collect();
        let top: Vec<Extended> = legendre.iter().map(|values| values[inner]).collect();

        let nodes: Vec<Extended> = points.iter().map(|&point| (point + one) / number(2)).collect();
        let weights: Vec<Extended> = top.iter().map(|&value| one / (number(s * inner) * value * value)).collect();
        let top_legendre: Vec<Extended> = top.iter().map(|&value| one / (number(s) * value)).collect();

        let a = matrix(s, s, |i, j| {
            let series: Extended =
                (0..s).map(|k| legendre[j][k] * legendre_integral(&legendre[i], points[i], k, s)).sum();
            weights[j] * series
        });
        let a_bar = matrix(s, s, |i, j| weights[j] * (one - a[j * s + i] / weights[i]));
        let a_hat = matrix(inner, inner, |i, k| (0..s).map(|j| a[(i + 1) * s + j] * a_bar[j * s + k]).sum());

        // ℓ_j′(ξ_i) = P_{s−1}(ξ_i) / (P_{s−1}(ξ_j) (ξ_i − ξ_j)); the rows sum to zero because constants have no slope, and the slope with respect to
        // c is twice the slope with respect to ξ.
        let mut derivative =
            matrix(s, s, |i, j| if i == j { Extended::ZERO } else { top[i] / (top[j] * (nodes[i] - nodes[j])) });
        for i in 0..s {
            derivative[i * s + i] = -derivative[i * s..(i + 1) * s].iter().copied().sum::<Extended>();
        }
        let stiffness = |k: usize, i: usize| -> Extended {
            (0..s).map(|j| weights[j] * derivative[j * s + k] * derivative[j * s + i]).sum()
        };
        let b_matrix = matrix(inner, inner, |k, i| -(stiffness(k, i + 1) / weights[k]));
        // The last column of Ā is zero: the force of the last stage moves no other.
        let velocity = matrix(s, inner, |j, i| (0..inner).map(|k| a_bar[j * s + k] * b_matrix[k * inner + i]).sum());
        let momentum_weights = (1..s).map(|i| stiffness(inner, i)).collect();
        Exact { nodes, weights, a, a_bar, a_hat, b_matrix, momentum_weights, velocity, top_legendre }
    }
}

/// A row-major matrix from a function of row and column.
fn matrix(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> Extended) -> Vec<Extended> {
    (0..rows * columns).map(|index| entry(index / columns, index % columns)).collect()
}

/// `P_0(ξ) … P_degree(ξ)` by the three-term recurrence `(k+1) P_{k+1} = (2k+1) ξ P_k − k P_{k−1}`.
fn legendre_values(point: Extended, degree: usize) -> Vec<Extended> {
    let mut values = vec![Extended::ONE, point];
    for k in 1..degree {
        let next = Extended::from(2 * k + 1) * point * values[k] - Extended::from(k) * values[k - 1];
        values.push(next / Extended::from(k + 1));
    }
    values
}

/// `γ_k⁻¹ ∫₀^c P_k(2x − 1) dx` for `ξ = 2c − 1` and the values of the polynomials there, with γ the discrete norms.
fn legendre_integral(values: &[Extended], point: Extended, k: usize, stages: usize) -> Extended {
    if k == 0 {
        return (point + Extended::ONE) / Extended::from(2usize);
    }
    let twice_integral_times_norm = values[k + 1] - values[k - 1];
    let over_continuous_norm = twice_integral_times_norm / Extended::from(2usize);
    if k < stages - 1 {
        over_continuous_norm
    } else {
        over_continuous_norm * Extended::from(stages - 1) / Extended::from(2 * k + 1)
    }
}

/// The zeros of `(1 − ξ²) P′_{s−1}(ξ)`, increasing, symmetric about 0.
fn lobatto_points(stages: usize) -> Vec<Extended> {
    let degree = stages - 1;
    let mut points = vec![Extended::ZERO; stages];
    points[degree] = Extended::ONE;
    points[0] = -Extended::ONE;
    for upper in stages.div_ceil(2)..degree {
        // Chebyshev–Lobatto points lie between the same neighbours, which is near enough for Newton's method.
        let mut point = Extended::from((std::f64::consts::PI * (degree - upper) as f64 / degree as f64).cos());
        // Five steps reach 32 digits from a start good to two; three more are cheap and leave no doubt.
        for _ in 0..8 {
            // Newton on (1 − ξ²) P′ = n (P_{n−1} − ξ P_n), whose derivative is −n (n+1) P_n.
            let values = legendre_values(point, degree);
            let residual = values[degree - 1] - point * values[degree];
            point = point + residual / (Extended::from(stages) * values[degree]);
        }
        points[upper] = point;
        points[degree - upper] = -point;
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tableau::butcher::{MAXIMUM_STAGES, MINIMUM_STAGES};

    /// Bound on the errors of exact identities: 32 digits, less the factor 2·10⁴ of the largest entry of B and a few hundred operations.
    const EXACT: f64 = 1e-24;

    fn power(base: Extended, exponent: usize) -> Extended {
        (0..exponent).fold(Extended::ONE, |product, _| product * base)
    }

    fn inverse(value: usize) -> Extended {
        Extended::ONE / Extended::from(value)
    }

    fn assert_zero(value: Extended, what: &str) {
        assert!(value.abs().rounded() < EXACT, "{what}: {:e}", value.abs().rounded());
    }

    fn all(mut check: impl FnMut(usize, Exact)) {
        for stages in MINIMUM_STAGES..=MAXIMUM_STAGES {
            check(stages, Exact::new(stages));
        }
    }

    #[test]
    fn weights_integrate_polynomials_of_degree_2s_minus_3() {
        all(|s, exact| {
            let moment =
                |k: usize| -> Extended { (0..s).map(|i| exact.weights[i] * power(exact.nodes[i], k - 1)).sum() };
            for k in 1..=2 * s - 2 {
                assert_zero(moment(k) - inverse(k), &format!("s = {s}, k = {k}"));
            }
            // One degree more must fail, or the nodes would be Gauss–Legendre's, which do not contain the ends.
            assert!((moment(2 * s - 1) - inverse(2 * s - 1)).abs().rounded() > EXACT, "s = {s}");
        });
    }

    #[test]
    fn first_matrix_is_the_collocation_method_of_the_nodes() {
        // C(s): Σ_j a_ij c_j^{k−1} = c_i^k / k for k = 1..s, which determines A.
        all(|s, exact| {
            for (i, k) in (0..s).flat_map(|i| (1..=s).map(move |k| (i, k))) {
                let sum: Extended = (0..s).map(|j| exact.a[i * s + j] * power(exact.nodes[j], k - 1)).sum();
                assert_zero(sum - power(exact.nodes[i], k) * inverse(k), &format!("s = {s}, i = {i}, k = {k}"));
            }
        });
    }

    #[test]
    fn second_matrix_satisfies_d_of_s() {
        // D(s): Σ_i b_i c_i^{k−1} ā_ij = b_j (1 − c_j^k) / k for k = 1..s, which determines Ā.
        all(|s, exact| {
            for (j, k) in (0..s).flat_map(|j| (1..=s).map(move |k| (j, k))) {
                let sum: Extended =
                    (0..s).map(|i| exact.weights[i] * power(exact.nodes[i], k - 1) * exact.a_bar[i * s + j]).sum();
                let wanted = exact.weights[j] * (Extended::ONE - power(exact.nodes[j], k)) * inverse(k);
                assert_zero(sum - wanted, &format!("s = {s}, j = {j}, k = {k}"));
            }
        });
    }

    #[test]
    fn pair_is_symplectic_and_symmetric() {
        all(|s, exact| {
            let (b, a, a_bar) = (&exact.weights, &exact.a, &exact.a_bar);
            for (i, j) in (0..s).flat_map(|i| (0..s).map(move |j| (i, j))) {
                let symplectic = b[i] * a_bar[i * s + j] + b[j] * a[j * s + i] - b[i] * b[j];
                assert_zero(symplectic, &format!("symplectic, s = {s}, ({i}, {j})"));
                for matrix in [a, a_bar] {
                    let mirrored = matrix[(s - 1 - i) * s + s - 1 - j];
                    assert_zero(mirrored + matrix[i * s + j] - b[j], &format!("symmetric, s = {s}, ({i}, {j})"));
                }
            }
        });
    }

    #[test]
    fn structure_that_makes_the_constrained_scheme_solvable() {
        // Q₁ = q₀, Q_s = q̄, and the last force does not act on the stages (text after 2.5.11).
        all(|s, exact| {
            for j in 0..s {
                assert_zero(exact.a[j], "first row of A");
                assert_zero(exact.a[(s - 1) * s + j] - exact.weights[j], "last row of A");
                assert_zero(exact.a_bar[j * s + s - 1], "last column of the second matrix");
                assert_zero(exact.a_bar[j * s] - exact.weights[0], "first column of the second matrix");
            }
        });
    }

    #[test]
    fn closed_form_of_b_is_the_inverse_of_a_hat() {
        all(|s, exact| {
            let n = s - 1;
            for (k, l) in (0..n).flat_map(|k| (0..n).map(move |l| (k, l))) {
                let product: Extended = (0..n).map(|i| exact.b_matrix[k * n + i] * exact.a_hat[i * n + l]).sum();
                let identity = if k == l { Extended::ONE } else { Extended::ZERO };
                assert_zero(product - identity, &format!("s = {s}, ({k}, {l})"));
            }
        });
    }

    #[test]
    fn momentum_weights_and_row_sums_are_those_of_b() {
        all(|s, exact| {
            let n = s - 1;
            for i in 0..n {
                let sum: Extended = (0..n).map(|k| exact.weights[k] * exact.b_matrix[k * n + i]).sum();
                assert_zero(sum - exact.momentum_weights[i], &format!("s = {s}, i = {i}"));
            }
            for k in 0..n {
                // Σ_i B_ki c_i = −b_k⁻¹ Σ_j b_j D_jk, because the nodes have slope 1; and Σ_j b_j D_jk = ∫ ℓ_k′ = −1, 0, …, 0.
                let sum: Extended = (0..n).map(|i| exact.b_matrix[k * n + i] * exact.nodes[i + 1]).sum();
                let wanted = if k == 0 { Extended::ONE / exact.weights[0] } else { Extended::ZERO };
                assert_zero(sum - wanted, &format!("s = {s}, row {k}"));
            }
        });
    }

    #[test]
    fn stage_velocities_move_the_stages_to_where_they_are() {
        // Q_i − q₀ = h Σ_j a_ij V_j: A times Ā B is the identity on the stages 2 … s.
        all(|s, exact| {
            let n = s - 1;
            for (i, l) in (0..n).flat_map(|i| (0..n).map(move |l| (i, l))) {
                let moved: Extended = (0..s).map(|j| exact.a[(i + 1) * s + j] * exact.velocity[j * n + l]).sum();
                let identity = if i == l { Extended::ONE } else { Extended::ZERO };
                assert_zero(moved - identity, &format!("s = {s}, ({i}, {l})"));
            }
        });
    }

    #[test]
    fn top_legendre_row_picks_the_highest_coefficient() {
        all(|s, exact| {
            for k in 0..s {
                let sum: Extended = (0..s)
                    .map(|i| {
                        exact.top_legendre[i] * legendre_values(exact.nodes[i] + exact.nodes[i] - Extended::ONE, s)[k]
                    })
                    .sum();
                let wanted = if k == s - 1 { Extended::ONE } else { Extended::ZERO };
                assert_zero(sum - wanted, &format!("s = {s}, P_{k}"));
            }
        });
    }
}
