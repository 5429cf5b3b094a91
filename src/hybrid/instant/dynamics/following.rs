//! Velocities and accelerations of a tree in which joints follow others by ratios, and no loop closes.
//!
//! ```text
//!     J v = 0,   one row v_f − m v_l for each follower f of a leader l           X = H⁻¹ Jᵀ  (n × k),   A = J X  (k × k)
//!     x − X A⁻¹ J x:  of x = H⁻¹ τ the answer Y τ; of accelerations of the tree those that fit J a = 0; of velocities the nearest in the metric of H
//! ```
//!
//! H (n × n) is the mass matrix, J (k × n). J is constant, so that X is worked out once in a state, and an effort costs one solve with H and k
//! products. A is symmetric and positive definite if each joint follows in one way only.

use crate::mechanism::description::closure::Mimic;
use crate::mechanism::description::mechanism::Mechanism;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// A second round takes out what roundings of the first have left.
const ROUNDS: usize = 2;

/// The workspace of one mechanism.
#[derive(Clone)]
pub(crate) struct Following {
    /// Freedoms of the follower and of its leader, and their ratio m.
    rows: Vec<(usize, usize, f64)>,
    /// X.
    columns: DMatrix<f64>,
    /// The factor of A.
    factor: Cholesky<f64, Dyn>,
}

impl Following {
    /// The projection in the state for which `respond` makes H⁻¹ τ of efforts τ; `None` if loops close, if joints
    /// are moved in time, or if the rows are not independent.
    pub fn at(mechanism: &Mechanism, mut respond: impl FnMut(&[f64], &mut [f64])) -> Option<Self> {
        let several = mechanism.mimics.iter().any(|mimic| !mimic.more.is_empty());
        if several || !mechanism.loops.is_empty() || mechanism.mimics.is_empty() || mechanism.moves_joints() {
            return None;
        }
        let row = |mimic: &Mimic| (mimic.follower.freedom, mimic.leader.freedom, mimic.multiplier);
        let rows: Vec<(usize, usize, f64)> = mechanism.mimics.iter().map(row).collect();
        let (count, freedoms) = (rows.len(), mechanism.velocity_count);
        let mut columns = DMatrix::zeros(freedoms, count);
        let (mut efforts, mut answer) = (vec![0.0; freedoms], vec![0.0; freedoms]);
        for (index, &(follower, leader, ratio)) in rows.iter().enumerate() {
            efforts.fill(0.0);
            efforts[follower] += 1.0;
            efforts[leader] -= ratio;
            respond(&efforts, &mut answer);
            columns.column_mut(index).copy_from_slice(&answer);
        }
        let half = DMatrix::from_fn(count, count, |row, column| rate(rows[row], columns.column(column).as_slice()));
        let factor = Cholesky::new(0.5 * (&half + half.transpose()))?;
        Some(Following { rows, columns, factor })
    }

    /// Makes x fit the rows, by the least change in the metric of H: Y τ of H⁻¹ τ.
    pub fn follow(&self, values: &mut [f64]) {
        for _ in 0..ROUNDS {
            let rates = self.rows.iter().map(|&row| rate(row, values));
            let multipliers = self.factor.solve(&DVector::from_iterator(self.rows.len(), rates));
            for (column, multiplier) in self.columns.column_iter().zip(multipliers.iter()) {
                values.iter_mut().zip(column.iter()).for_each(|(value, part)| *value -= part * multiplier);
            }
        }
    }
}

/// J v of one row.
fn rate((follower, leader, ratio): (usize, usize, f64), velocity: &[f64]) -> f64 {
    velocity[follower] - ratio * velocity[leader]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::dynamics::mass_matrix::mass_matrix;
    use crate::instant::dynamics::mass_matrix::tests::tree;
    use crate::instant::dynamics::response_on_tree::ResponseOnTree;
    use crate::mechanism::description::closure::Coordinate;
    use crate::mechanism::description::joint::JointKind;
    use crate::mechanism::motion::state::State;

    #[test]
    fn answers_are_those_of_the_freedoms_that_followers_leave() {
        let mut mechanism = tree(&[
            (None, JointKind::Floating, 0.3),
            (Some(0), JointKind::Revolute, 0.5),
            (Some(1), JointKind::Prismatic, 0.1),
            (Some(0), JointKind::Revolute, 0.7),
            (Some(3), JointKind::Revolute, 0.9),
        ]);
        let coordinate = |body: usize| {
            let joint = &mechanism.bodies[body].joint;
            Coordinate { body, position: joint.position_index, freedom: joint.velocity_index }
        };
        let freedom = |body: usize| coordinate(body).freedom;
        // Two follow one, and one of them leads another.
        let ratios = [(2, 1, -1.3), (3, 1, 0.7), (4, 3, 2.0)];
        let (count, leader) = (mechanism.velocity_count, freedom(1));
        let mut allowed = DMatrix::<f64>::zeros(count, 7);
        (0..6).for_each(|base| allowed[(base, base)] = 1.0);
        for (body, factor) in [(1, 1.0), (2, -1.3), (3, 0.7), (4, 1.4)] {
            allowed[(freedom(body), 6)] = factor;
        }
        let mimics = ratios.map(|(follower, leader, multiplier)| Mimic {
            name: String::new(),
            follower: coordinate(follower),
            leader: coordinate(leader),
            multiplier,
            offset: 0.0,
            more: Vec::new(),
            over_time: None,
        });
        assert_eq!(leader, 6);
        mechanism.mimics = mimics.into();
        let state = State::zero(&mechanism);
        let inner = allowed.transpose() * mass_matrix(&mechanism, &state) * &allowed;
        let expected = &allowed * inner.try_inverse().expect("masses") * allowed.transpose();
        let mut response = ResponseOnTree::new(&mechanism);
        response.place(&state);
        let mut answer = vec![0.0; count];
        for unit in 0..count {
            let mut efforts = vec![0.0; count];
            efforts[unit] = 1.0;
            response.answer(&efforts, &mut answer);
            for row in 0..count {
                let (found, right) = (answer[row], expected[(row, unit)]);
                assert!((found - right).abs() < 1e-13 * expected.amax(), "{row}, {unit}: {found}, not {right}");
            }
            assert!(ratios.iter().all(|&(f, l, m)| (answer[freedom(f)] - m * answer[freedom(l)]).abs() < 1e-15));
        }
    }
}
