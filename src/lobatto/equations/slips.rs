//! Velocities of bodies at the stages, in the embedding of the scheme, for the slips of touching bodies.
//!
//! The displacement of the anchor a is Δa and the turn of a body N, since the start of the step, at the stages i = 2 … s; their rates at the start
//! are `v_a` [m/s] and `ω̂₀` [rad/s], and c is the node of a stage:
//!
//! ```text
//!     ȧ_j = v_a + h⁻¹ Σ_i (Ā B)_ji (Δa_i − h c_i v_a),     Ω_j = ω̂₀ + h⁻¹ Σ_i (Ā B)_ji (N_i − h c_i ω̂₀),     j = 1..s
//!     velocity of the material at the point p:   ȧ_j + Ω_j (1 + N_j)ᵀ (p − a_j)
//! ```
//!
//! `Ω_j (1 + N_j)ᵀ` is skew but for the error of the stages: it is the rate of the rotation matrix as the scheme has it, which constraints on
//! velocities must take for the order 2s − 2.
//!
//! Friction has the direction of a slip, and a slip that is slower than the error of its stage has an arbitrary direction. Most of this error is the
//! error of `Ṙ`, which turns with the body. So friction takes the velocity of the centre of mass x and an angular velocity ω of its own, which the
//! scheme integrates from the angular accelerations that the second rates of the rotation matrix have:
//!
//! ```text
//!     h² R̈_k R₀ᵀ = S_k = Σ_i B_ki (N_i − h c_i ω̂₀)                                       k = 1..s−1
//!     ω_j = ω₀ + h⁻¹ Σ_k ā_jk ½ vee(S_k (1 + N_k)ᵀ − (1 + N_k) S_kᵀ)                       j = 1..s
//!     velocity of the material at the point p:   ẋ_j + ω_j × (p − x_j)
//! ```
//!
//! As ω is one more variable of the partitioned scheme, the order is the same; under a constant torque it is exact from three stages on.

use crate::numbers::algebra::{Matrix, Vector};
use crate::numbers::lanes::{Lanes, MAX_LANES};
use crate::stages::coefficients::{moved_rows, row_stage};
use crate::stages::start::BodyStart;
use crate::tableau::butcher::Tableau;

/// The coefficients of the scheme that velocities need.
#[derive(Clone)]
pub(crate) struct StageMixing<V> {
    /// Number of stages coupled.
    pub active: usize,
    /// One if a row has the geometry of its stage, zero if it has the geometry of the start.
    pub moved: V,
    /// b of the rows.
    pub weights: V,
    /// Weights that extrapolate the rows to the end: the polynomial through their stages, evaluated there.
    pub ahead: V,
    /// `Ā B` by columns, for the columns' and for the rows' stages.
    velocity: [[V; MAX_LANES]; 2],
    /// B by columns i, for the rows.
    second: [V; MAX_LANES],
    /// Ā by columns k, the rows, for the columns' and for the rows' stages.
    rate: [[V; MAX_LANES]; 2],
    /// c_i.
    nodes: V,
    /// `a_ij` by columns j = 2 … s, and `a_i1`.
    integral: [V; MAX_LANES],
    start: V,
}

impl<V: Lanes> StageMixing<V> {
    /// The coefficients of a scheme.
    pub fn new(tableau: &Tableau) -> Self {
        let (stages, active) = (tableau.stages, tableau.stages - 1);
        let lanes = |value: &dyn Fn(usize) -> f64| V::from_slice(&(0..active).map(value).collect::<Vec<f64>>());
        let mut velocity = [[V::zero(); MAX_LANES]; 2];
        let (mut second, mut rate) = ([V::zero(); MAX_LANES], [[V::zero(); MAX_LANES]; 2]);
        let mut integral = [V::zero(); MAX_LANES];
        for column in 0..active {
            let of = |stage: usize| tableau.velocity[stage * active + column];
            velocity[0][column] = lanes(&|lane| of(lane + 1));
            velocity[1][column] = lanes(&|lane| of(row_stage(lane, active)));
            second[column] = lanes(&|lane| tableau.b_matrix[row_stage(lane, active) * active + column]);
            let of = |stage: usize| tableau.a_bar[stage * stages + row_stage(column, active)];
            rate[0][column] = lanes(&|lane| of(lane + 1));
            rate[1][column] = lanes(&|lane| of(row_stage(lane, active)));
            integral[column] = lanes(&|lane| tableau.a[(lane + 1) * stages + column + 1]);
        }
        StageMixing {
            active,
            moved: moved_rows(active),
            weights: lanes(&|lane| tableau.weights[row_stage(lane, active)]),
            ahead: lanes(&|lane| {
                let own = tableau.nodes[row_stage(lane, active)];
                let others = (0..active).map(|stage| tableau.nodes[stage]).filter(|other| *other != own);
                others.map(|other| (1.0 - other) / (own - other)).product()
            }),
            velocity,
            second,
            rate,
            nodes: lanes(&|lane| tableau.nodes[lane + 1]),
            integral,
            start: lanes(&|lane| tableau.a[(lane + 1) * stages]),
        }
    }

    /// `Σ_j a_ij x_j` over all stages, from x at the columns' and at the rows' stages, the last of which is the start.
    #[inline(always)]
    pub fn integrate(&self, [columns, rows]: [V; 2]) -> V {
        let first = V::splat(rows.to_array().as_ref()[self.active - 1]);
        self.start.mul_add(first, columns.mix(&self.integral))
    }
}

/// How a body moves at stages.
#[derive(Clone, Copy)]
pub(crate) struct BodyRate<V> {
    /// ȧ.
    anchor: Vector<V>,
    /// `Ω (1 + N)ᵀ`.
    spin: Matrix<V>,
}

impl<V: Lanes> BodyRate<V> {
    /// A body that does not move.
    pub fn zero() -> Self {
        BodyRate { anchor: Vector::zero(), spin: Matrix::zero() }
    }

    /// The rates of a body in a step of this length, from its turn and the displacement of its anchor: at the columns' and at the rows' stages.
    #[inline(always)]
    pub fn of(
        mixing: &StageMixing<V>,
        step: f64,
        known: &BodyStart,
        turn: &Matrix<V>,
        displaced: Vector<V>,
    ) -> [Self; 2] {
        let (times, inverse) = (mixing.nodes * V::splat(step), V::splat(1.0 / step));
        let spin: Vector<V> = Vector::splat(&known.spin);
        // The anchor is at −com from the centre of mass.
        let anchor = Vector::splat(&known.velocity).minus(spin.cross(Vector::splat(&known.com)));
        let skew = skew(spin).0;
        let mut rates = [BodyRate::zero(); 2];
        for ((rate, columns), moved) in rates.iter_mut().zip(&mixing.velocity).zip([V::splat(1.0), mixing.moved]) {
            for axis in 0..3 {
                let ahead = anchor.0[axis].neg_mul_add(times, displaced.0[axis]);
                rate.anchor.0[axis] = ahead.mix(columns).mul_add(inverse, anchor.0[axis]);
            }
            let mut turning = Matrix(skew);
            for (i, row) in turning.0.iter_mut().enumerate() {
                for (j, entry) in row.iter_mut().enumerate() {
                    let ahead = skew[i][j].neg_mul_add(times, turn.0[i][j]);
                    *entry = ahead.mix(columns).mul_add(inverse, skew[i][j]);
                }
            }
            let turned = turn.times(moved).rows();
            for (i, row) in turning.rows().iter().enumerate() {
                for (j, turned) in turned.iter().enumerate() {
                    rate.spin.0[i][j] = row.dot_plus(*turned, turning.0[i][j]);
                }
            }
        }
        rates
    }

    /// The rates for slips: the velocity of the centre of mass, and the angular velocity integrated from the angular accelerations.
    #[inline(always)]
    pub fn of_slips(
        mixing: &StageMixing<V>,
        step: f64,
        known: &BodyStart,
        turn: &Matrix<V>,
        displaced: Vector<V>,
    ) -> [Self; 2] {
        let (times, inverse) = (mixing.nodes * V::splat(step), V::splat(1.0 / step));
        let [start, spin]: [Vector<V>; 2] = [Vector::splat(&known.velocity), Vector::splat(&known.spin)];
        let com = Vector::splat(&known.com);
        let center = turn.apply_plus(com, displaced);
        let [turning, turned] = [skew(spin), *turn].map(|matrix: Matrix<V>| matrix.rows());
        let row = |axis: usize| {
            Vector([0, 1, 2].map(|other: usize| {
                turning[axis].0[other].neg_mul_add(times, turned[axis].0[other]).mix(&mixing.second)
            }))
        };
        // The rows of S and of 1 + N, at the rows' stages.
        let second = [row(0), row(1), row(2)];
        let turned = turn.times(mixing.moved).rows();
        let entry = |i: usize, j: usize| second[i].dot_plus(turned[j], second[i].0[j]);
        let acceleration = Vector([(2, 1), (0, 2), (1, 0)].map(|(i, j)| (entry(i, j) - entry(j, i)) * V::splat(0.5)));
        let mut rates = [BodyRate::zero(); 2];
        let sides = rates.iter_mut().zip(mixing.velocity.iter().zip(&mixing.rate)).zip([V::splat(1.0), mixing.moved]);
        for ((own, (velocity, rate)), moved) in sides {
            let of = |axis: usize| {
                let ahead = start.0[axis].neg_mul_add(times, center.0[axis]);
                ahead.mix(velocity).mul_add(inverse, start.0[axis])
            };
            let center = Vector([of(0), of(1), of(2)]);
            let spin =
                Vector([0, 1, 2].map(|axis: usize| acceleration.0[axis].mix(rate).mul_add(inverse, spin.0[axis])));
            // The anchor is at −com from the centre of mass.
            let com = turn.times(moved).apply_plus(com, com);
            *own = BodyRate { anchor: center.minus(spin.cross(com)), spin: skew(spin) };
        }
        rates
    }

    /// Angular velocity: the skew part of the rate [rad/s].
    #[inline(always)]
    pub fn spin(&self) -> Vector<V> {
        let [[_, b, c], [d, _, f], [g, h, _]] = self.spin.0;
        Vector([h - f, c - g, d - b]).times(V::splat(0.5))
    }

    /// Velocity of the material at an arm from the anchor (m).
    #[inline(always)]
    pub fn at(&self, arm: Vector<V>) -> Vector<V> {
        self.spin.apply_plus(arm, self.anchor)
    }
}

/// The cross product with a vector as a matrix.
#[inline(always)]
fn skew<V: Lanes>(v: Vector<V>) -> Matrix<V> {
    let [p, q, r] = v.0;
    let zero = V::zero();
    Matrix([[zero, -r, q], [r, zero, -p], [-q, p, zero]])
}
