//! Contacts of which some imply others: their gaps as far as motions can change them, and the same compliance for all.
//!
//! If more than three contacts lie on one plane, some imply others: the contacts of a box, or of a car with four wheels. Let R (m × n) be the rates
//! of all gaps between two trees of bodies at one stage, for each motion of these trees; or between more of them, where contacts lead around, as of a
//! block between a wall and the jaw of a vice ([`crate::coupled::groups`]). The part of the gaps g that is orthogonal to the columns of R is changed by
//! no motion. That part is rounding, about 1e-17 m, and divided by ε it would be a force: in a step of 0.1 ms as large as a thousandth of the weight of
//! a box. The friction of sliding contacts then turns the box.
//!
//! ```text
//!     g ← Q Qᵀ g,     Q (m × r): an orthonormal basis of the columns of R      modified Gram–Schmidt, twice
//!     columns of R:   the six of the twist of each tree that floats, of two that float of one relative to the other;
//!                     one for each joint freedom that moves a contact
//! ```
//!
//! The remaining system has one solution: multipliers begin a step at zero, and with the same ε for every row z · λ = 0 for each z with zᵀ R = 0. So
//! pressures lie on a plane over the place of the points, as between rigid bodies with a foundation of equal springs that are as stiff as one likes.
//! Increments mix stages, `J_i η_i + ε Σ_k Â_ik dλ_k = −g_i`, and so they have that property only if the columns of R span the same at all stages: points of
//! a body do, crossings of edges do not. After each iteration `λ_k ← Q_k Q_kᵀ λ_k` at the rows' stages.
//! Where friction holds other contacts of such a group, their slips are among the rows: a wheel that floor and wall hold can bear any part of a weight.
//! Then the gaps and slips are reduced to what motions can change, and multipliers are left as they are.
//! Decisions at events follow the same law. Loops within a tree are not considered: contacts that only such loops make redundant keep their ε.
//!
//! Source of the basis: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th edition, section 5.2.8.

use crate::coupled::groups::{
    Between, Group, Rows, ancestors, first_of_tree, floating_trees, is_floating, sliding_groups,
};
use crate::numbers::lanes::{Lanes, MAX_LANES};
use crate::plan::elimination::TWIST;
use catena_mechanism::description::mechanism::Mechanism;
use std::ops::Range;

/// More equations than this between two trees may imply each other, if contacts slide among them.
const INDEPENDENT: usize = 3;
/// The rest of a column is rounding below this part of the largest of its kind, or of what the rate of a joint may be.
const ROUNDING: f64 = 1e-9;

/// The number of an equation with 1 or −1.
type Signed = (usize, f64);

/// The equations between trees.
#[derive(Clone, Debug)]
pub(crate) struct Dependent {
    /// Their rows.
    rows: Vec<usize>,
    /// For each tree that can move as a whole, relative to the other of two, the equations that it moves: with 1 at their second ends, with −1 at
    /// their first.
    floats: Vec<Vec<Signed>>,
    joints: Vec<JointColumn>,
    /// Whether they lead around, from tree to tree.
    around: bool,
    /// For every stage the columns of R, then of Q, one after the other. For every joint a bound of the square of its rate: with the force of the row in which
    /// it is largest, and the largest torque of all rows.
    columns: Vec<f64>,
    sizes: Vec<f64>,
    /// The largest squares of the columns of forces and of torques of each twist.
    largest: Vec<f64>,
    gaps: Vec<f64>,
    /// Whether some imply others where the gaps were seen last.
    implied: bool,
}

/// A freedom of a joint, and the equations it moves: their numbers, with 1 where it moves the second end and −1 where it moves the first.
#[derive(Clone, Debug)]
struct JointColumn {
    body: usize,
    freedom: usize,
    moves: Vec<Signed>,
}

impl Dependent {
    /// All groups of a mechanism in which contacts slide with friction, for the rows of its loops and then of its contacts; and the groups in which
    /// friction holds some contacts, too, with all rows of these: slips and turnings as well as gaps.
    pub fn all(mechanism: &Mechanism, rows_of_closure: &[Range<usize>]) -> [Vec<Self>; 2] {
        let [gaps, all] = [Rows::Gaps, Rows::All].map(|rows| sliding_groups(mechanism, rows_of_closure, rows));
        let larger = |group: &&Group, than: usize| group.rows.len() > than.max(INDEPENDENT);
        let holds = all.iter().zip(&gaps).filter(|(all, gaps)| larger(all, gaps.rows.len())).map(|(all, _)| all);
        let of = |group: &Group| Dependent::of(mechanism, group);
        [gaps.iter().filter(|group| larger(group, 0)).map(of).collect(), holds.map(of).collect()]
    }

    /// The equations of a group.
    fn of(mechanism: &Mechanism, Group { pairs, rows }: &Group) -> Self {
        let mut floating: Vec<usize> = pairs.iter().flat_map(|pair| floating_trees(mechanism, pair)).collect();
        floating.sort_unstable();
        floating.dedup();
        // Two trees have a relative motion alone, and one tree has none.
        if let [[one, other]] = pairs[..] {
            floating.truncate(usize::from(one != other));
        }
        let moved_by = |tree: usize| {
            let of_row = |(number, (_, ends)): (usize, &Between)| {
                let [a, b] = ends.map(|end| first_of_tree(mechanism, end) == Some(tree));
                let sign = f64::from(u8::from(b)) - f64::from(u8::from(a));
                (sign != 0.0).then_some((number, sign))
            };
            rows.iter().enumerate().filter_map(of_row).collect::<Vec<_>>()
        };
        let floats: Vec<Vec<Signed>> = floating.into_iter().map(moved_by).collect();
        let mut joints: Vec<JointColumn> = Vec::new();
        for (number, (_, ends)) in rows.iter().enumerate() {
            for (end, sign) in ends.iter().zip([-1.0, 1.0]) {
                for body in end.iter().flat_map(|&body| ancestors(mechanism, body)) {
                    // The motions of a whole tree are known already, and move none of its own gaps.
                    if is_floating(mechanism, body) {
                        continue;
                    }
                    for freedom in mechanism.bodies[body].joint.velocity_range() {
                        match joints.iter_mut().find(|joint| joint.freedom == freedom) {
                            Some(joint) => joint.moves.push((number, sign)),
                            None => joints.push(JointColumn { body, freedom, moves: vec![(number, sign)] }),
                        }
                    }
                }
            }
        }
        let columns = TWIST * floats.len() + joints.len();
        Dependent {
            rows: rows.iter().map(|(row, _)| *row).collect(),
            largest: vec![0.0; 2 * floats.len()],
            floats,
            columns: vec![0.0; MAX_LANES * columns * rows.len()],
            sizes: vec![0.0; MAX_LANES * joints.len()],
            gaps: vec![0.0; rows.len()],
            implied: false,
            joints,
            around: pairs.len() > 1,
        }
    }

    /// Their rows.
    pub fn rows(&self) -> impl Iterator<Item = usize> {
        self.rows.iter().copied()
    }

    /// Whether they are between two trees alone, without joints.
    pub fn is_of_two_trees(&self) -> bool {
        self.joints.is_empty() && !self.around
    }

    /// Whether some of them implied others where the gaps were seen last.
    pub fn is_implied(&self) -> bool {
        self.implied
    }

    /// Reduces the gaps of `stages` stages to the part that motions change, unless all rows are independent; with the gradients and the screws of freedoms
    /// (body, freedom) at the columns' stages. Does not allocate.
    pub fn keep<V: Lanes>(
        &mut self,
        stages: usize,
        gradient: impl Fn(usize) -> [V; TWIST],
        gaps: &mut [V],
        screw: impl Fn(usize, usize) -> [V; TWIST],
    ) {
        self.implied = self.reduce(stages, gradient, gaps, screw) < self.rows.len();
    }

    /// The same for multipliers at the rows' stages, where some rows imply others.
    pub fn share<V: Lanes>(
        &mut self,
        stages: usize,
        gradient: impl Fn(usize) -> [V; TWIST],
        multipliers: &mut [V],
        screw: impl Fn(usize, usize) -> [V; TWIST],
    ) {
        if self.implied {
            self.reduce(stages, gradient, multipliers, screw);
        }
    }

    /// `g ← Q Qᵀ g` at every stage, unless all rows are independent at the first; returns r there.
    fn reduce<V: Lanes>(
        &mut self,
        stages: usize,
        gradient: impl Fn(usize) -> [V; TWIST],
        values: &mut [V],
        screw: impl Fn(usize, usize) -> [V; TWIST],
    ) -> usize {
        let Dependent { rows, floats, joints, columns, sizes, .. } = self;
        let count = rows.len();
        let rigid = TWIST * floats.len();
        let per_stage = (rigid + joints.len()) * count;
        columns.fill(0.0);
        sizes.fill(0.0);
        let mut write = |column: usize, index: usize, lanes: V, sign: f64| {
            for (stage, value) in lanes.to_array().as_ref()[..stages].iter().enumerate() {
                columns[stage * per_stage + column * count + index] += sign * value;
            }
        };
        for (number, moves) in floats.iter().enumerate() {
            for &(index, sign) in moves {
                for (component, lanes) in gradient(rows[index]).iter().enumerate() {
                    write(TWIST * number + component, index, *lanes, sign);
                }
            }
        }
        let square = |of: &[V]| of.iter().fold(V::zero(), |sum, &part| part.mul_add(part, sum));
        // A contact in the plane of the axis of a roller has an arm that is rounding in every term: the arms of the others tell how large arms are.
        let arms = if joints.is_empty() { &[] } else { rows.as_slice() };
        let farthest = arms.iter().fold(V::zero(), |most, &row| square(&gradient(row)[3..]).max_abs(most));
        for (number, joint) in joints.iter().enumerate() {
            let screw = screw(joint.body, joint.freedom);
            let turning = farthest * square(&screw[3..]);
            for &(index, sign) in &joint.moves {
                let gradient = gradient(rows[index]);
                let rate = gradient.iter().zip(&screw).fold(V::zero(), |rate, (of, along)| of.mul_add(*along, rate));
                let size = square(&gradient[..3]).mul_add(square(&screw[..3]), turning);
                write(rigid + number, index, rate, sign);
                for (stage, size) in size.to_array().as_ref()[..stages].iter().enumerate() {
                    let known = &mut sizes[stage * joints.len() + number];
                    *known = known.max(*size);
                }
            }
        }
        let mut first = count;
        for stage in 0..stages {
            for (gap, &row) in self.gaps.iter_mut().zip(&self.rows) {
                *gap = values[row].to_array().as_ref()[stage];
            }
            let columns = &mut self.columns[stage * per_stage..][..per_stage];
            let sizes = &self.sizes[stage * self.joints.len()..][..self.joints.len()];
            let independent = project(columns, sizes, &mut self.largest, &mut self.gaps);
            if stage == 0 {
                first = independent;
            }
            if first == count {
                break;
            }
            for (&row, gap) in self.rows.iter().zip(&self.gaps) {
                let mut lanes = values[row].to_array();
                lanes.as_mut()[stage] = *gap;
                values[row] = V::from_array(lanes);
            }
        }
        first
    }
}

/// `g ← Q Qᵀ g`: replaces the columns by Q. Of each tree that floats three columns are forces and the next three torques, and `largest` has room for
/// the squares of both; the other columns belong to joints, and `sizes` has bounds of the squares of their entries. Returns r.
fn project(columns: &mut [f64], sizes: &[f64], largest: &mut [f64], gaps: &mut [f64]) -> usize {
    let count = gaps.len();
    let total = columns.len() / count;
    let rigid = total - sizes.len();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    largest.fill(0.0);
    for (number, column) in columns.chunks_exact(count).enumerate().take(rigid) {
        let of = &mut largest[number / 3];
        *of = of.max(dot(column, column));
    }
    let mut independent = 0;
    for number in 0..total {
        let (before, rest) = columns.split_at_mut(number * count);
        let column = &mut rest[..count];
        for _ in 0..2 {
            for other in before.chunks_exact(count) {
                let along = dot(column, other);
                column.iter_mut().zip(other).for_each(|(entry, other)| *entry -= along * other);
            }
        }
        let square = dot(column, column);
        let scale = if number < rigid { largest[number / 3] } else { sizes[number - rigid] };
        let is_rounding = square <= ROUNDING * ROUNDING * scale;
        let factor = if is_rounding || square == 0.0 { 0.0 } else { 1.0 / square.sqrt() };
        independent += usize::from(factor != 0.0);
        column.iter_mut().for_each(|entry| *entry *= factor);
    }
    // The result is summed from its parts. A difference from the whole would have the rounding of the whole.
    for column in columns.chunks_exact_mut(count) {
        let part = dot(column, gaps);
        column.iter_mut().for_each(|entry| *entry *= part);
    }
    gaps.fill(0.0);
    for column in columns.chunks_exact(count) {
        gaps.iter_mut().zip(column).for_each(|(gap, part)| *gap += part);
    }
    independent
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
        project(&mut on_a_plane(&points), &[], &mut [0.0; 2], &mut gaps);
        for (gap, tilted) in gaps.iter().zip(tilted) {
            // 1e-3 rounds at 1e-19, and the columns, 30 m for a box of 0.1 m, by 300 times that.
            assert!((gap - tilted).abs() < 1e-16, "{gap} instead of {tilted}");
        }
        let mut nothing = twisted.map(|side| 1e-17 * side);
        project(&mut on_a_plane(&points), &[], &mut [0.0; 2], &mut nothing);
        assert!(nothing.iter().all(|gap| gap.abs() < 1e-30), "{nothing:?}");
    }
}
