//! Stages, trajectories and momenta of the literal scheme are those of the discrete Lagrangian, and so are trajectories of
//! the fast kernel.

use super::moving_double_pendulum;
use crate::literal::coordinates::coordinates;
use crate::literal::scheme::Literal;
use crate::models::{self, Model};
use catena::lobatto::tableau::butcher::Tableau;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::forward_kinematics;
use catena::stepping::integrator::Lobatto;
use nalgebra::{DMatrix, DVector};

/// The discrete Lagrangian (2.5.12) of a mechanism of revolute joints, in joint angles and from its definition alone:
///
/// ```text
///     L_d(θ₀, θ₁) = ext h Σ_j b_j L(Q_j, Q̇_j),    Q_j = q(θ_j) by forward kinematics,   h Q̇_j = Σ_i D_ji Q_i
/// ```
///
/// where the polynomial through the stages gives the velocities and the inner stages are chosen on N so that the sum is
/// stationary. Nothing of (2.5.11) enters: no A, Ā, multipliers or momenta, only the nodes and weights.
struct DiscreteLagrangian<'a> {
    mechanism: &'a Mechanism,
    tableau: &'a Tableau,
    step: f64,
    mass: DVector<f64>,
    force: DVector<f64>,
    /// `D_ji` (s × s).
    derivative: DMatrix<f64>,
}

impl<'a> DiscreteLagrangian<'a> {
    fn new(mechanism: &'a Mechanism, tableau: &'a Tableau, step: f64) -> Self {
        let size = 12 * mechanism.bodies.len();
        let (mut mass, mut force) = (DVector::zeros(size), DVector::zeros(size));
        for (index, body) in mechanism.bodies.iter().enumerate() {
            mass.rows_mut(12 * index, 3).fill(body.mass);
            force.rows_mut(12 * index, 3).copy_from(&(mechanism.gravity * body.mass));
            for (column, moment) in models::second_moments(body).diagonal().iter().enumerate() {
                mass.rows_mut(12 * index + 3 + 3 * column, 3).fill(*moment);
            }
        }
        let (c, s) = (&tableau.nodes, tableau.stages);
        let apart = |i: usize| (0..s).filter(|&k| k != i).map(|k| c[i] - c[k]).product::<f64>();
        let mut derivative =
            DMatrix::from_fn(s, s, |j, i| if i == j { 0.0 } else { apart(j) / apart(i) / (c[j] - c[i]) });
        for j in 0..s {
            derivative[(j, j)] = -derivative.row(j).sum();
        }
        DiscreteLagrangian { mechanism, tableau, step, mass, force, derivative }
    }

    fn coordinates(&self, angles: &DVector<f64>) -> DVector<f64> {
        let mut bodies = vec![catena::mechanism::description::body_state::WORLD; self.mechanism.bodies.len()];
        forward_kinematics(self.mechanism, angles.as_slice(), &vec![0.0; angles.len()], &mut bodies);
        coordinates(&bodies).0
    }

    /// `dq/dθ` (12 n × degrees of freedom), one unit velocity at a time.
    fn tangents(&self, angles: &DVector<f64>) -> DMatrix<f64> {
        let columns: Vec<DVector<f64>> = (0..angles.len())
            .map(|joint| {
                let mut bodies = vec![catena::mechanism::description::body_state::WORLD; self.mechanism.bodies.len()];
                let mut unit = vec![0.0; angles.len()];
                unit[joint] = 1.0;
                forward_kinematics(self.mechanism, angles.as_slice(), &unit, &mut bodies);
                coordinates(&bodies).1
            })
            .collect();
        DMatrix::from_columns(&columns)
    }

    /// `h Σ_j b_j L(Q_j, Q̇_j)` for given stages in R¹²ⁿ [J s].
    fn action(&self, stages: &[DVector<f64>]) -> f64 {
        (0..stages.len())
            .map(|j| {
                let rate = self.rate(stages, j);
                let kinetic = 0.5 * rate.dot(&self.mass.component_mul(&rate));
                self.step * self.tableau.weights[j] * (kinetic + self.force.dot(&stages[j]))
            })
            .sum()
    }

    fn rate(&self, stages: &[DVector<f64>], j: usize) -> DVector<f64> {
        (0..stages.len()).map(|i| &stages[i] * (self.derivative[(j, i)] / self.step)).sum()
    }

    /// Derivative of the action with respect to stage k in R¹²ⁿ, the other stages held.
    fn action_gradient(&self, stages: &[DVector<f64>], k: usize) -> DVector<f64> {
        let inertial: DVector<f64> = (0..stages.len())
            .map(|j| {
                let weight = self.tableau.weights[j] * self.derivative[(j, k)];
                self.mass.component_mul(&self.rate(stages, j)) * weight
            })
            .sum();
        inertial + &self.force * (self.step * self.tableau.weights[k])
    }

    /// L_d: the inner stages by Newton's method on the gradient in joint angles, from the straight line.
    fn value(&self, start: &DVector<f64>, end: &DVector<f64>) -> f64 {
        let (s, dof) = (self.tableau.stages, start.len());
        let place = |inner: &DVector<f64>| -> Vec<DVector<f64>> {
            let mut angles = vec![start.clone()];
            angles.extend((0..s - 2).map(|k| inner.rows(k * dof, dof).into_owned()));
            angles.push(end.clone());
            angles
        };
        let gradient = |inner: &DVector<f64>| -> DVector<f64> {
            let angles = place(inner);
            let stages: Vec<DVector<f64>> = angles.iter().map(|stage| self.coordinates(stage)).collect();
            let mut all = DVector::zeros(inner.len());
            for (k, stage) in angles.iter().enumerate().take(s - 1).skip(1) {
                let own = self.tangents(stage).tr_mul(&self.action_gradient(&stages, k));
                all.rows_mut((k - 1) * dof, dof).copy_from(&own);
            }
            all
        };
        let mut inner = DVector::zeros((s - 2) * dof);
        for k in 1..s - 1 {
            inner.rows_mut((k - 1) * dof, dof).copy_from(&(start + (end - start) * self.tableau.nodes[k]));
        }
        // The Jacobian by differences is good to 1e-9, so each round gains eight digits; five are ample.
        for _ in 0..if s > 2 { 5 } else { 0 } {
            let columns: Vec<DVector<f64>> = (0..inner.len())
                .map(|index| {
                    let (mut ahead, mut behind) = (inner.clone(), inner.clone());
                    ahead[index] += 1e-5;
                    behind[index] -= 1e-5;
                    (gradient(&ahead) - gradient(&behind)) / 2e-5
                })
                .collect();
            inner -= DMatrix::from_columns(&columns).lu().solve(&gradient(&inner)).unwrap();
        }
        let stages: Vec<DVector<f64>> = place(&inner).iter().map(|angles| self.coordinates(angles)).collect();
        self.action(&stages)
    }
}

/// The angles of a mechanism of revolute joints, read from its bodies.
fn revolute_angles(mechanism: &Mechanism, q: &DVector<f64>) -> DVector<f64> {
    let bodies = crate::literal::coordinates::body_states(q, &DVector::zeros(q.len()));
    DVector::from_iterator(
        bodies.len(),
        mechanism.bodies.iter().zip(&bodies).map(|(body, own)| {
            let parent = body.parent.map_or(catena::mechanism::description::body_state::WORLD, |parent| bodies[parent]);
            let turn = body.joint.on_parent.rotation.matrix().transpose()
                * parent.rotation.transpose()
                * own.rotation
                * body.joint.on_child.rotation.matrix();
            turn[(1, 0)].atan2(turn[(0, 0)])
        }),
    )
}

#[test]
fn stages_make_the_discrete_action_stationary_and_multipliers_are_its_reactions() {
    // In R¹²ⁿ: D_{Q_k}(h Σ b_j L) = h b_k Dg(Q_k)ᵀ Λ_k for the inner stages of each step, and at the shared point
    // D₂L_d(q₀, q₁) + D₁L_d(q₁, q₂) = Dg(q₁)ᵀ λ, λ = h b_s Λ_s + h b_1 Λ_1 (2.5.8). Tangentially to N, with tangents
    // that come from forward kinematics, both sides vanish whatever Λ is.
    let model = moving_double_pendulum();
    let step = 0.05;
    for stages in [2, 3, 4, 5, 9] {
        let tableau = Tableau::of(stages).unwrap();
        let literal = Literal::new(&model.mechanism, tableau).unwrap();
        let discrete = DiscreteLagrangian::new(&model.mechanism, tableau, step);
        let first = literal.step(&model.bodies(), step).unwrap();
        let second = literal.step(&first.bodies, step).unwrap();
        // Rounding of the coordinates, amplified by M D b D / h: the largest such entry is that of B, times b, over h.
        let entry = tableau.b_matrix[0] * tableau.weights[0];
        let bound = 2e-15 * entry / step;
        let check = |what: &str, gradient: DVector<f64>, q: &DVector<f64>, reaction: DVector<f64>| {
            let full = (&gradient - literal.constraint_jacobian(q).tr_mul(&reaction)).amax();
            let tangential = discrete.tangents(&revolute_angles(&model.mechanism, q)).tr_mul(&gradient).amax();
            println!("s = {stages} {what}: {full:.1e} {tangential:.1e} of {:.1e}, bound {bound:.1e}", gradient.amax());
            assert!(full < bound && tangential < bound, "s = {stages}, {what}: {full:e} {tangential:e}");
        };
        for taken in [&first, &second] {
            for k in 1..stages - 1 {
                check(
                    "inner stage",
                    discrete.action_gradient(&taken.stage_coordinates, k),
                    &taken.stage_coordinates[k],
                    &taken.multipliers[k] * (step * tableau.weights[k]),
                );
            }
        }
        let last = stages - 1;
        check(
            "shared point",
            discrete.action_gradient(&first.stage_coordinates, last)
                + discrete.action_gradient(&second.stage_coordinates, 0),
            &second.stage_coordinates[0],
            (&first.multipliers[last] + &second.multipliers[0]) * (step * tableau.weights[0]),
        );
    }
}

/// Joint angles at the start, after one and after two steps.
type Solver = fn(&Model, &Tableau, f64) -> [DVector<f64>; 3];

fn literal_angles(model: &Model, tableau: &Tableau, step: f64) -> [DVector<f64>; 3] {
    let literal = Literal::new(&model.mechanism, tableau).unwrap();
    let first = literal.step(&model.bodies(), step).unwrap();
    let second = literal.step(&first.bodies, step).unwrap();
    [&first.stage_coordinates[0], &second.stage_coordinates[0], &second.stage_coordinates[tableau.stages - 1]]
        .map(|q| revolute_angles(&model.mechanism, q))
}

fn fast_angles(model: &Model, tableau: &Tableau, step: f64) -> [DVector<f64>; 3] {
    let mut lobatto = Lobatto::fixed(&model.mechanism, tableau.stages, step).unwrap();
    let mut state = model.state.clone();
    let mut angles = vec![DVector::from_row_slice(&state.position)];
    for _ in 0..2 {
        lobatto.advance(&model.mechanism, &mut state, f64::INFINITY).unwrap();
        angles.push(DVector::from_row_slice(&state.position));
    }
    [angles[0].clone(), angles[1].clone(), angles[2].clone()]
}

#[test]
fn trajectories_satisfy_the_discrete_euler_lagrange_equations() {
    // (2.5.8) on N, without multipliers: d/dθ₁ [L_d(θ₀, θ₁) + L_d(θ₁, θ₂)] = 0 with L_d as a function of its two end
    // points only, its inner stages solved for anew at every evaluation, and differentiated by difference quotients.
    let model = moving_double_pendulum();
    let step = 0.05;
    for (stages, solver) in [
        (2, literal_angles as Solver),
        (3, literal_angles),
        (4, literal_angles),
        (2, fast_angles),
        (3, fast_angles),
        (4, fast_angles),
        (5, fast_angles),
    ] {
        let tableau = Tableau::of(stages).unwrap();
        let discrete = DiscreteLagrangian::new(&model.mechanism, tableau, step);
        let [start, middle, end] = solver(&model, tableau, step);
        for joint in 0..middle.len() {
            // A quotient of fourth order: error ε⁴ of the fifth derivative (1e-12 here) and 1e-16/ε of rounding.
            let width = 2e-3;
            let both = |offset: f64| {
                let mut moved = middle.clone();
                moved[joint] += offset * width;
                (discrete.value(&start, &moved), discrete.value(&moved, &end))
            };
            let [m2, m1, p1, p2] = [-2.0, -1.0, 1.0, 2.0].map(both);
            let slope = |m2: f64, m1: f64, p1: f64, p2: f64| (m2 - 8.0 * m1 + 8.0 * p1 - p2) / (12.0 * width);
            let (of_first, of_second) = (slope(m2.0, m1.0, p1.0, p2.0), slope(m2.1, m1.1, p1.1, p2.1));
            println!("s = {stages}, joint {joint}: {of_first:.3e} + {of_second:.3e} = {:.1e}", of_first + of_second);
            assert!((of_first + of_second).abs() < 1e-10, "s = {stages}: {of_first} + {of_second}");
            // −D₁L_d and D₂L_d are the momentum, which is far from zero: the sum cancels because the equations hold.
            assert!(of_first.abs() > 0.1);
        }
    }
}

#[test]
fn start_and_end_momenta_are_the_derivatives_of_the_discrete_lagrangian() {
    // p = −D₁L_d and p̄ = D₂L_d on the tangent space of N, where the multipliers do not act.
    let model = moving_double_pendulum();
    let step = 0.05;
    let tableau = Tableau::of(4).unwrap();
    let literal = Literal::new(&model.mechanism, tableau).unwrap();
    let discrete = DiscreteLagrangian::new(&model.mechanism, tableau, step);
    let taken = literal.step(&model.bodies(), step).unwrap();
    for (stage, sign, momentum) in [(0, -1.0, &taken.start_momentum), (3, 1.0, &taken.end_momentum)] {
        let q = &taken.stage_coordinates[stage];
        let tangents = discrete.tangents(&revolute_angles(&model.mechanism, q));
        let gradient = discrete.action_gradient(&taken.stage_coordinates, stage) * sign;
        let error = tangents.tr_mul(&(gradient - momentum)).amax();
        // Rounding of coordinates over the step, times 30 for the entries of b D.
        assert!(error < 1e-13, "stage {stage}: {error:e}");
    }
}
