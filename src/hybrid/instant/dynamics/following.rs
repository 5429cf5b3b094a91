//! Velocities and accelerations of a tree in which joints follow others by ratios or are moved in time, and no loop closes.
//!
//! ```text
//!     J v = r,   one row v_f − m v_l for each follower f of a leader l, and one row v_f for each moved joint f     X = H⁻¹ Jᵀ (n × k),  A = J X (k × k)
//!     x − X A⁻¹ (J x − r):  of x = H⁻¹ τ the answer Y τ; of accelerations of the tree those that fit; of velocities the nearest in the metric of H
//! ```
//!
//! H (n × n) is the mass matrix, J (k × n); r is zero of followers and of answers, the rate of a moved joint among velocities, and its acceleration among
//! accelerations. J is constant, so that X is worked out once in a state, and an effort costs one solve with H and k products. A is symmetric and
//! positive definite if each joint follows or is moved in one way only.

use crate::mechanism::description::closure::Mimic;
use crate::mechanism::description::mechanism::Mechanism;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// A second round takes out what roundings of the first have left.
const ROUNDS: usize = 2;

/// What is to fit the rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fitted {
    /// Answers to efforts and impulses, which moved joints do not have.
    Answers,
    /// Velocities.
    Velocities,
    /// Accelerations.
    Accelerations,
}

/// One row of J.
#[derive(Clone)]
struct Row {
    /// The freedoms of the follower and of its leader, and their ratio m; a moved joint is both, with the ratio 0.
    follower: usize,
    leader: usize,
    ratio: f64,
    /// The rate and acceleration of a moved joint.
    motion: Option<[f64; 2]>,
}

/// The workspace of one mechanism.
#[derive(Clone)]
pub(crate) struct Following {
    rows: Vec<Row>,
    /// X.
    columns: DMatrix<f64>,
    /// The factor of A.
    factor: Cholesky<f64, Dyn>,
}

impl Following {
    /// The projection at a time (s), in the state for which `respond` makes H⁻¹ τ of efforts τ; `None` if loops close, if the rows are not independent,
    /// or if one of them does not move any inertia.
    pub fn at(mechanism: &Mechanism, time: f64, mut respond: impl FnMut(&[f64], &mut [f64])) -> Option<Self> {
        let several = mechanism.mimics.iter().any(|mimic| !mimic.more.is_empty());
        if several || !mechanism.loops.is_empty() || mechanism.mimics.is_empty() {
            return None;
        }
        let rows: Vec<Row> = mechanism.mimics.iter().map(|mimic| Row::of(mimic, time)).collect();
        let (count, freedoms) = (rows.len(), mechanism.velocity_count);
        let mut columns = DMatrix::zeros(freedoms, count);
        let (mut efforts, mut answer) = (vec![0.0; freedoms], vec![0.0; freedoms]);
        for (index, row) in rows.iter().enumerate() {
            efforts.fill(0.0);
            efforts[row.follower] += 1.0;
            efforts[row.leader] -= row.ratio;
            respond(&efforts, &mut answer);
            columns.column_mut(index).copy_from_slice(&answer);
        }
        let half = DMatrix::from_fn(count, count, |row, column| rows[row].rate(columns.column(column).as_slice()));
        if !half.iter().all(|entry| entry.is_finite()) {
            return None;
        }
        let factor = Cholesky::new(0.5 * (&half + half.transpose()))?;
        Some(Following { rows, columns, factor })
    }

    /// Makes x fit the rows, by the least change in the metric of H: Y τ of H⁻¹ τ.
    pub fn follow(&self, what: Fitted, values: &mut [f64]) {
        for _ in 0..ROUNDS {
            let rates = self.rows.iter().map(|row| row.rate(values) - row.wanted(what));
            let multipliers = self.factor.solve(&DVector::from_iterator(self.rows.len(), rates));
            for (column, multiplier) in self.columns.column_iter().zip(multipliers.iter()) {
                values.iter_mut().zip(column.iter()).for_each(|(value, part)| *value -= part * multiplier);
            }
        }
        for row in self.rows.iter().filter(|row| row.motion.is_some()) {
            values[row.follower] = row.wanted(what);
        }
    }

    /// Whether no joint follows one of another tree, with the tree of each degree of freedom.
    pub fn stays_in_trees(&self, of_freedoms: &[usize]) -> bool {
        self.rows.iter().all(|row| of_freedoms[row.follower] == of_freedoms[row.leader])
    }
}

impl Row {
    fn of(mimic: &Mimic, time: f64) -> Self {
        let (follower, leader) = (mimic.follower.freedom, mimic.leader.freedom);
        if mimic.is_moved() {
            let [_, rate, acceleration] = mimic.motion(time, time);
            return Row { follower, leader: follower, ratio: 0.0, motion: Some([rate, acceleration]) };
        }
        Row { follower, leader, ratio: mimic.multiplier, motion: None }
    }

    /// J x.
    fn rate(&self, values: &[f64]) -> f64 {
        values[self.follower] - self.ratio * values[self.leader]
    }

    /// r.
    fn wanted(&self, what: Fitted) -> f64 {
        let [rate, acceleration] = self.motion.unwrap_or([0.0; 2]);
        match what {
            Fitted::Answers => 0.0,
            Fitted::Velocities => rate,
            Fitted::Accelerations => acceleration,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::dynamics::mass_matrix::mass_matrix;
    use crate::instant::dynamics::mass_matrix::tests::tree;
    use crate::instant::dynamics::response_on_tree::ResponseOnTree;
    use crate::mechanism::description::closure::Coordinate;
    use crate::mechanism::description::formula::Formula;
    use crate::mechanism::description::joint::JointKind;
    use crate::mechanism::description::target::Target;
    use crate::mechanism::motion::state::State;

    /// The answer to a unit effort along one of so many freedoms.
    fn answer_to(response: &mut ResponseOnTree, unit: usize, count: usize) -> Vec<f64> {
        let (mut efforts, mut answer) = (vec![0.0; count], vec![0.0; count]);
        efforts[unit] = 1.0;
        response.answer(&efforts, &mut answer);
        answer
    }

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
        for unit in 0..count {
            let answer = answer_to(&mut response, unit, count);
            for row in 0..count {
                let (found, right) = (answer[row], expected[(row, unit)]);
                assert!((found - right).abs() < 1e-13 * expected.amax(), "{row}, {unit}: {found}, not {right}");
            }
            assert!(ratios.iter().all(|&(f, l, m)| (answer[freedom(f)] - m * answer[freedom(l)]).abs() < 1e-15));
        }
    }

    #[test]
    fn a_joint_that_is_moved_has_its_motion_and_others_answer_as_if_it_were_fixed() {
        let mut mechanism = tree(&[
            (None, JointKind::Floating, 0.3),
            (Some(0), JointKind::Revolute, 0.5),
            (Some(1), JointKind::Prismatic, 0.1),
        ]);
        let joint = &mechanism.bodies[1].joint;
        let moved = Coordinate { body: 1, position: joint.position_index, freedom: joint.velocity_index };
        let curve = Formula::new("0.3*sin(4*t) + 0.5*t^2", &[]).expect("a formula");
        mechanism.mimics = vec![Mimic::moved("moved".into(), moved, Target::formula(curve))];
        let (count, freedom) = (mechanism.velocity_count, moved.freedom);
        let mut state = State { time: 0.7, ..State::zero(&mechanism) };
        let mass = mass_matrix(&mechanism, &state);
        let others: Vec<usize> = (0..count).filter(|&other| other != freedom).collect();
        let inverse = mass.select_rows(&others).select_columns(&others).try_inverse().expect("masses");
        let mut response = ResponseOnTree::new(&mechanism);
        response.place(&state);
        for unit in 0..count {
            let answer = answer_to(&mut response, unit, count);
            for (row, &of) in others.iter().enumerate() {
                let right = others.iter().position(|&other| other == unit).map_or(0.0, |column| inverse[(row, column)]);
                assert!(
                    (answer[of] - right).abs() < 1e-13 * inverse.amax(),
                    "{of}, {unit}: {}, not {right}",
                    answer[of]
                );
            }
            assert_eq!(answer[freedom], 0.0, "{unit}");
        }
        let speed = 1.2 * (4.0 * state.time).cos() + state.time;
        let gains = 1.0 - 4.8 * (4.0 * state.time).sin();
        // At rest without gravity and forces, all accelerations are those that the moved joint asks for.
        let mut answer = vec![0.0; count];
        response.accelerations(&state, &vec![0.0; count], &mut answer);
        let pushed = &mass * DVector::from_column_slice(&answer);
        assert!((answer[freedom] - gains).abs() < 1e-13);
        assert!(others.iter().all(|&other| pushed[other].abs() < 1e-13 * pushed.amax()), "{pushed}");
        response.close_velocities(&mut state);
        let pushed = &mass * DVector::from_column_slice(&state.velocity);
        assert!((state.velocity[freedom] - speed).abs() < 1e-13);
        assert!(others.iter().all(|&other| pushed[other].abs() < 1e-13 * pushed.amax()), "{pushed}");
    }
}
