//! The coefficients of the scheme, arranged in lanes.
//!
//! ```text
//!     residual of row k:  Σ_i B_ki …          increment of stage i:  δ_i = Σ_k Â_ik α_k          i, k = 2 … s
//! ```

use crate::numbers::arithmetic::Numbers;
use crate::numbers::lanes::MAX_LANES;
use crate::tableau::butcher::Tableau;
/// The coefficients of the scheme as lanes. Lane `j` of an unknown is stage `j + 2`; lane `j` of a residual is row `j + 2`, except that the last lane
/// is row 1. Both share their geometry, except for the last lane, whose row has the geometry of the start.
#[derive(Clone)]
pub struct Coefficients<V> {
    /// Number of lanes in use, s − 1.
    pub active: usize,
    /// B by columns.
    pub residual: [V; MAX_LANES],
    /// The rounding errors of B, by columns.
    pub residual_rest: [V; MAX_LANES],
    /// The rounding errors of the nodes.
    pub nodes_rest: V,
    /// Â by columns.
    pub solve: [V; MAX_LANES],
    /// Nodes c_2 … c_s.
    pub nodes: V,
    /// One if a row has its stage's geometry, zero if it has the geometry of the start.
    pub moved: V,
}

/// The stage (0 is the start) that a lane of a residual stands for, of `active` lanes in use.
pub fn row_stage(lane: usize, active: usize) -> usize {
    if lane + 1 == active { 0 } else { lane + 1 }
}

/// One in the lanes of residuals that have the geometry of their stage, zero in the lane of the start.
pub fn moved_rows<V: Numbers>(active: usize) -> V {
    let moved: Vec<f64> = (0..active).map(|lane| if row_stage(lane, active) == 0 { 0.0 } else { 1.0 }).collect();
    V::from_parts(&moved, &[])
}

impl<V: Numbers> Coefficients<V> {
    /// Arranges a tableau in lanes.
    pub fn new(tableau: &Tableau) -> Self {
        let active = tableau.stages - 1;
        let row_of_lane = |lane: usize| row_stage(lane, active);
        let mut residual = [V::zero(); MAX_LANES];
        let mut residual_rest = [V::zero(); MAX_LANES];
        let mut solve = [V::zero(); MAX_LANES];
        for column in 0..active {
            let rows: Vec<f64> =
                (0..active).map(|lane| tableau.b_matrix[row_of_lane(lane) * active + column]).collect();
            let rest: Vec<f64> =
                (0..active).map(|lane| tableau.remainders.b_matrix[row_of_lane(lane) * active + column]).collect();
            residual[column] = V::from_parts(&rows, &rest);
            residual_rest[column] = V::from_parts(&rest, &[]);
            let rows: Vec<f64> = (0..active).map(|lane| tableau.a_hat[lane * active + row_of_lane(column)]).collect();
            solve[column] = V::from_parts(&rows, &[]);
        }
        Coefficients {
            active,
            residual,
            residual_rest,
            nodes_rest: V::from_parts(&tableau.remainders.nodes[1..], &[]),
            solve,
            nodes: V::from_parts(&tableau.nodes[1..], &tableau.remainders.nodes[1..]),
            moved: moved_rows(active),
        }
    }
}
