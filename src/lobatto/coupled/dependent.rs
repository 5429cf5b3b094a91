//! Contacts between two bodies of which some imply others: their gaps as far as bodies can have them, and the same compliance for all.
//!
//! Of more than six equations between two bodies, or of more than three contacts on one plane, some imply others. With the gradients R (m × 6) of
//! all of them at one stage no motion changes the part of the gaps g that is square to the columns of R. That part is rounding, about 1e-17 m, and
//! divided by ε it would be a force: in a step of 0.1 ms as large as a thousandth of what carries a box. Where contacts slide its friction turns the box.
//!
//! ```text
//!     g ← Q Qᵀ g,     Q (m × r): an orthonormal basis of the columns of R      modified Gram–Schmidt, twice
//! ```
//!
//! What is left has one answer: multipliers begin a step at zero, and with the same ε for every row z · λ = 0 for each z with zᵀ R = 0. So
//! pressures lie on a plane over the place of the points, as between rigid bodies with a foundation of equal springs that are as stiff as one likes.
//! Decisions at events follow the same law.
//!
//! Source of the basis: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th edition, section 5.2.8.

use crate::numbers::lanes::Lanes;
use crate::plan::elimination::TWIST;
use catena_mechanism::description::mechanism::Mechanism;
use std::ops::Range;

/// More equations than this between two bodies may imply each other, if contacts slide among them.
const INDEPENDENT: usize = 3;
/// What is left of a column is rounding below this part of the largest of its kind.
const ROUNDING: f64 = 1e-9;

/// The bodies at the ends of equations, and a row with 1 or −1.
type Ends = [Option<usize>; 2];
type Signed = (usize, f64);

/// The equations between two bodies.
#[derive(Clone, Debug)]
pub(crate) struct Dependent {
    /// Their rows, and −1 where the second of their ends is the first of the others: gaps change by the opposite of the gradient then.
    rows: Vec<Signed>,
    /// The columns of R, then of Q, one after the other.
    columns: Vec<f64>,
    gaps: Vec<f64>,
}

impl Dependent {
    /// Those of a mechanism in which contacts slide with friction, for the rows of its loops and then of its contacts.
    pub fn all(mechanism: &Mechanism, rows_of_closure: &[Range<usize>]) -> Vec<Self> {
        let rubs = |between: Ends| {
            let sorted = |[a, b]: Ends| if a < b { [a, b] } else { [b, a] };
            mechanism.rubbing().any(|joint| sorted([joint.a.body, joint.b.body]) == between)
        };
        let mut found: Vec<(Ends, Vec<Signed>)> = Vec::new();
        for (number, ([a, b], rows)) in mechanism.closing_ends().zip(rows_of_closure).enumerate() {
            let (ends, sign) = if a.body < b.body { ([a.body, b.body], 1.0) } else { ([b.body, a.body], -1.0) };
            // Of a contact the first row is its gap; what rolls has others, of rates.
            let count = if number < mechanism.loops.len() { rows.len() } else { 1 };
            let of_these = rows.clone().take(count).map(|row| (row, sign));
            match found.iter_mut().find(|(known, _)| *known == ends) {
                Some((_, all)) => all.extend(of_these),
                None => found.push((ends, of_these.collect())),
            }
        }
        let dependent = found.into_iter().filter(|(ends, rows)| rows.len() > INDEPENDENT && rubs(*ends));
        let new = |rows: Vec<Signed>| {
            let (columns, gaps) = (vec![0.0; TWIST * rows.len()], vec![0.0; rows.len()]);
            Dependent { rows, columns, gaps }
        };
        dependent.map(|(_, rows)| new(rows)).collect()
    }

    /// Their rows.
    pub fn rows(&self) -> impl Iterator<Item = usize> {
        self.rows.iter().map(|(row, _)| *row)
    }

    /// Leaves of the gaps of so many stages what motions change, with the gradients at the columns' stages. Does not allocate.
    pub fn keep<V: Lanes>(&mut self, stages: usize, gradients: &[[[V; TWIST]; 2]], gaps: &mut [V]) {
        let count = self.rows.len();
        for stage in 0..stages {
            for (index, &(row, sign)) in self.rows.iter().enumerate() {
                for (component, lanes) in gradients[row][0].iter().enumerate() {
                    self.columns[component * count + index] = sign * lanes.to_array().as_ref()[stage];
                }
                self.gaps[index] = gaps[row].to_array().as_ref()[stage];
            }
            project(&mut self.columns, &mut self.gaps);
            for (&(row, _), gap) in self.rows.iter().zip(&self.gaps) {
                let mut lanes = gaps[row].to_array();
                lanes.as_mut()[stage] = *gap;
                gaps[row] = V::from_array(lanes);
            }
        }
    }
}

/// `g ← Q Qᵀ g`: makes Q of the columns, three of forces and three of torques, in their place.
fn project(columns: &mut [f64], gaps: &mut [f64]) {
    let count = gaps.len();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut largest = [0.0_f64; 2];
    for (number, column) in columns.chunks_exact(count).enumerate() {
        let of = &mut largest[number / 3];
        *of = of.max(dot(column, column));
    }
    for number in 0..TWIST {
        let (before, rest) = columns.split_at_mut(number * count);
        let column = &mut rest[..count];
        for _ in 0..2 {
            for other in before.chunks_exact(count) {
                let along = dot(column, other);
                column.iter_mut().zip(other).for_each(|(entry, other)| *entry -= along * other);
            }
        }
        let square = dot(column, column);
        let is_rounding = square <= ROUNDING * ROUNDING * largest[number / 3];
        let factor = if is_rounding || square == 0.0 { 0.0 } else { 1.0 / square.sqrt() };
        column.iter_mut().for_each(|entry| *entry *= factor);
    }
    // The sum of its parts: not what is left after taking the rest away, which would be rounded by that.
    let mut kept = [0.0; TWIST];
    for (part, column) in kept.iter_mut().zip(columns.chunks_exact(count)) {
        *part = dot(column, gaps);
    }
    gaps.fill(0.0);
    for (part, column) in kept.iter().zip(columns.chunks_exact(count)) {
        gaps.iter_mut().zip(column).for_each(|(gap, entry)| *gap += part * entry);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gradients of contacts at these points of a plane that faces up, by columns.
    fn on_a_plane(points: &[[f64; 2]]) -> Vec<f64> {
        let zeros = || points.iter().map(|_| 0.0);
        let columns = zeros().chain(zeros()).chain(points.iter().map(|_| 1.0));
        columns.chain(points.iter().map(|[_, y]| *y)).chain(points.iter().map(|[x, _]| -x)).chain(zeros()).collect()
    }

    #[test]
    fn gaps_of_a_motion_are_kept_and_what_no_motion_changes_is_left_out() {
        // A box far from the common origin, and turned.
        let (cosine, sine) = (0.3_f64.cos(), 0.3_f64.sin());
        let corners = [[-0.2, -0.1], [0.2, -0.1], [0.2, 0.1], [-0.2, 0.1]];
        let points = corners.map(|[x, y]: [f64; 2]| [30.0 + cosine * x - sine * y, -7.0 + sine * x + cosine * y]);
        let tilted = points.map(|[x, y]| 1e-6 + 2e-6 * x - 3e-6 * y);
        let twisted = [1.0, -1.0, 1.0, -1.0];
        let mut gaps = [0, 1, 2, 3].map(|corner: usize| tilted[corner] + 1e-3 * twisted[corner]);
        project(&mut on_a_plane(&points), &mut gaps);
        for (gap, tilted) in gaps.iter().zip(tilted) {
            // 1e-3 rounds at 1e-19, and the columns, 30 m for a box of 0.1 m, by 300 times that.
            assert!((gap - tilted).abs() < 1e-16, "{gap} instead of {tilted}");
        }
        let mut nothing = twisted.map(|side| 1e-17 * side);
        project(&mut on_a_plane(&points), &mut nothing);
        assert!(nothing.iter().all(|gap| gap.abs() < 1e-30), "{nothing:?}");
    }
}
