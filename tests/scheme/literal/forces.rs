//! Forces besides gravity in the literal scheme: from the maximal coordinates of all stages to forces in R¹² a body.
//!
//! Dampers and springs act on scalars y(q): the displacement of a joint, the components of a ball joint's rotation since the start of the step, the
//! distance of two points. The rate of y at the stages is the rate of a coordinate without mass in (2.5.11): with the unknown impulses r, which stand
//! for its `Ṗ_j / m`,
//!
//! ```text
//!     ẏ_i = ẏ₀ + h Σ_j ā_ij r_j,      y_i = y₀ + h Σ_j a_ij ẏ_j          i = 1..s,   r_s left out: ā_is = 0
//! ```
//!
//! The forces that follow go to the bodies as wrenches `(f, n)` about their centres of mass, in R¹² `(f, ½ n̂ R)`. This file shares no code with
//! [`catena::lobatto::equations::forces`], for which it is the oracle. A joint angle is taken between −π and π at the start of the step, because R¹² does not
//! count turns.

use crate::literal::coordinates::{BODY_COORDINATES, body_states};
use catena::lobatto::tableau::butcher::Tableau;
use catena::mechanism::description::body_state::{BodyState, WORLD};
use catena::mechanism::description::closure::Attachment;
use catena::mechanism::description::forces::PointSpring;
use catena::mechanism::description::joint::FreeRotation;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::forces::point_spring::Line;
use catena::mechanism::forces::total::scalar_coordinate;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// The bodies at all stages of a step, the first of which is its start.
struct Stages<'a> {
    mechanism: &'a Mechanism,
    tableau: &'a Tableau,
    step: f64,
    /// Bodies with the velocities of the start of the step, which count at the first stage only.
    bodies: Vec<Vec<BodyState>>,
}

/// The place of a degree of freedom: its body, and its axis in the joint frame.
struct Freedom {
    body: usize,
    axis: usize,
    /// A translation, an angle, or a component of a ball's rotation.
    kind: FreedomKind,
}

#[derive(PartialEq)]
enum FreedomKind {
    Translation,
    Angle,
    Ball,
}

/// `F_1 … F_s` (12 n each) without gravity, from the start `(q, q̇)` of a step and the increments `Q_i − q` of its stages.
pub(crate) fn stage_forces(
    mechanism: &Mechanism,
    tableau: &Tableau,
    q: &DVector<f64>,
    velocity: &DVector<f64>,
    increments: &[DVector<f64>],
    step: f64,
) -> Vec<DVector<f64>> {
    let stages = Stages {
        mechanism,
        tableau,
        step,
        bodies: increments.iter().map(|increment| body_states(&(q + increment), velocity)).collect(),
    };
    let mut forces = vec![DVector::zeros(q.len()); increments.len()];
    if mechanism.forces.is_empty() {
        return forces;
    }
    let given = &mechanism.forces;
    for damper in &given.joint_dampers {
        let rates = stages.rates(damper.freedom);
        stages.add_efforts(damper.freedom, &mut forces, |stage| -damper.coefficient * rates[stage]);
    }
    for spring in &given.joint_springs {
        let freedom = spring.coordinate.freedom;
        stages.add_efforts(freedom, &mut forces, |stage| {
            -spring.stiffness * (stages.displacement(freedom, None, stage) - spring.rest)
        });
    }
    for load in &given.joint_loads {
        stages.add_efforts(load.freedom, &mut forces, |_| load.effort);
    }
    for spring in &given.point_springs {
        stages.add_point_spring(spring, &mut forces);
    }
    for wrench in &given.wrenches {
        for (bodies, force) in stages.bodies.iter().zip(&mut forces) {
            let arm = bodies[wrench.body].rotation * wrench.point;
            add_wrench(force, Some(wrench.body), bodies, wrench.force, wrench.torque + arm.cross(&wrench.force));
        }
    }
    forces
}

impl Stages<'_> {
    fn freedom(&self, freedom: usize) -> Freedom {
        let body = self.mechanism.body_of_freedom(freedom).unwrap_or(0);
        let joint = &self.mechanism.bodies[body].joint;
        let offset = freedom - joint.velocity_index;
        let translations = joint.kind.translation_axes();
        let (axis, kind) = match translations.get(offset) {
            Some(&axis) => (axis, FreedomKind::Translation),
            None if joint.kind.rotation() == FreeRotation::AboutZ => (2, FreedomKind::Angle),
            None => (offset - translations.len(), FreedomKind::Ball),
        };
        Freedom { body, axis, kind }
    }

    /// Parent and child of a joint at a stage.
    fn pair(&self, body: usize, stage: usize) -> (BodyState, BodyState) {
        let bodies = &self.bodies[stage];
        (self.mechanism.bodies[body].parent.map_or(WORLD, |parent| bodies[parent]), bodies[body])
    }

    /// Joint frames on parent and child, and the gap of their origins.
    fn frames(&self, body: usize, stage: usize) -> (Matrix3<f64>, Matrix3<f64>, Vector3<f64>) {
        let (parent, child) = self.pair(body, stage);
        let joint = &self.mechanism.bodies[body].joint;
        let gap = child.position + child.rotation * joint.on_child.translation.vector
            - parent.position
            - parent.rotation * joint.on_parent.translation.vector;
        (parent.rotation * joint.on_parent.rotation.matrix(), child.rotation * joint.on_child.rotation.matrix(), gap)
    }

    /// Rotation of a joint at a stage since the start of the step, in the child's joint frame (rotation vector).
    fn turned(&self, body: usize, stage: usize) -> Vector3<f64> {
        let relative = |stage: usize| {
            let (on_parent, on_child, _) = self.frames(body, stage);
            on_parent.transpose() * on_child
        };
        rotation_vector(&(relative(0).transpose() * relative(stage)))
    }

    /// Displacement of a freedom at a stage: from the zero of the joint, or from the value `since` at the start.
    fn displacement(&self, freedom: usize, since: Option<f64>, stage: usize) -> f64 {
        let Freedom { body, axis, kind } = self.freedom(freedom);
        match kind {
            FreedomKind::Translation => {
                let (on_parent, _, gap) = self.frames(body, stage);
                on_parent.column(axis).dot(&gap) - since.unwrap_or(0.0)
            }
            FreedomKind::Angle | FreedomKind::Ball => {
                let start = match since {
                    Some(_) => 0.0,
                    None => {
                        let (on_parent, on_child, _) = self.frames(body, 0);
                        rotation_vector(&(on_parent.transpose() * on_child))[axis]
                    }
                };
                start + self.turned(body, stage)[axis]
            }
        }
    }

    /// `ẏ_1 … ẏ_s` of a scalar with these displacements since the start and this rate there.
    fn scalar_rates(&self, displacements: &[f64], start_rate: f64) -> Vec<f64> {
        let (s, h) = (self.tableau.stages, self.step);
        // y_i − y₀ − h c_i ẏ₀ = h² Σ_j a_ij Σ_k ā_jk r_k for i = 2..s, k = 1..s−1.
        let twice = DMatrix::from_fn(s - 1, s - 1, |i, k| {
            (0..s).map(|j| self.tableau.a[(i + 1) * s + j] * self.tableau.a_bar[j * s + k]).sum::<f64>() * h * h
        });
        let ahead = DVector::from_fn(s - 1, |i, _| displacements[i + 1] - h * self.tableau.nodes[i + 1] * start_rate);
        let impulses = twice.lu().solve(&ahead).unwrap_or_else(|| DVector::from_element(s - 1, f64::NAN));
        let rate = |j: usize| -> f64 { (0..s - 1).map(|k| self.tableau.a_bar[j * s + k] * impulses[k]).sum() };
        (0..s).map(|j| start_rate + h * rate(j)).collect()
    }

    /// Rates of a freedom at all stages.
    fn rates(&self, freedom: usize) -> Vec<f64> {
        let Freedom { body, axis, kind } = self.freedom(freedom);
        let (parent, child) = self.pair(body, 0);
        let (on_parent, on_child, _) = self.frames(body, 0);
        let joint = &self.mechanism.bodies[body].joint;
        match kind {
            FreedomKind::Translation => {
                let start = self.displacement(freedom, None, 0);
                let along: Vec<f64> =
                    (0..self.bodies.len()).map(|stage| self.displacement(freedom, Some(start), stage)).collect();
                let arm = child.rotation * joint.on_child.translation.vector;
                let anchor = child.position + arm;
                let slip = child.velocity + child.angular_velocity.cross(&arm)
                    - parent.velocity
                    - parent.angular_velocity.cross(&(anchor - parent.position));
                self.scalar_rates(&along, on_parent.column(axis).dot(&slip))
            }
            FreedomKind::Angle | FreedomKind::Ball => {
                let spin = on_child.transpose() * (child.angular_velocity - parent.angular_velocity);
                let turns: Vec<Vector3<f64>> = (0..self.bodies.len()).map(|stage| self.turned(body, stage)).collect();
                let components: Vec<Vec<f64>> = (0..3)
                    .map(|axis| {
                        let along: Vec<f64> = turns.iter().map(|turn| turn[axis]).collect();
                        self.scalar_rates(&along, spin[axis])
                    })
                    .collect();
                let rate = |stage: usize| Vector3::from_fn(|axis, _| components[axis][stage]);
                (0..turns.len()).map(|stage| body_rate(&turns[stage], &rate(stage))[axis]).collect()
            }
        }
    }

    /// An effort along a freedom at every stage: equal and opposite wrenches on child and parent.
    fn add_efforts(&self, freedom: usize, forces: &mut [DVector<f64>], effort: impl Fn(usize) -> f64) {
        debug_assert!(scalar_coordinate(self.mechanism, freedom).is_none_or(|found| found.freedom == freedom));
        let Freedom { body, axis, kind } = self.freedom(freedom);
        let parent_index = self.mechanism.bodies[body].parent;
        for (stage, force) in forces.iter_mut().enumerate() {
            let (parent, child) = self.pair(body, stage);
            let (on_parent, on_child, _) = self.frames(body, stage);
            let arm = child.rotation * self.mechanism.bodies[body].joint.on_child.translation.vector;
            let bodies = &self.bodies[stage];
            if kind == FreedomKind::Translation {
                let push = on_parent.column(axis) * effort(stage);
                let lever = child.position + arm - parent.position;
                add_wrench(force, Some(body), bodies, push, arm.cross(&push));
                add_wrench(force, parent_index, bodies, -push, -lever.cross(&push));
            } else {
                let torque = on_child.column(axis) * effort(stage);
                add_wrench(force, Some(body), bodies, Vector3::zeros(), torque);
                add_wrench(force, parent_index, bodies, Vector3::zeros(), -torque);
            }
        }
    }

    fn add_point_spring(&self, spring: &PointSpring, forces: &mut [DVector<f64>]) {
        let lines: Vec<Line> = self.bodies.iter().map(|bodies| spring.line(bodies)).collect();
        let growths: Vec<f64> = lines.iter().map(|line| line.length - lines[0].length).collect();
        let rates = self.scalar_rates(&growths, lines[0].rate);
        for (stage, force) in forces.iter_mut().enumerate() {
            let bodies = &self.bodies[stage];
            let pull = lines[stage].direction * spring.tension(lines[stage].length, rates[stage]);
            let mut push = |end: &Attachment, push: Vector3<f64>| {
                if let Some(body) = end.body {
                    let arm = end.point(bodies).0 - bodies[body].position;
                    add_wrench(force, Some(body), bodies, push, arm.cross(&push));
                }
            };
            push(&spring.a, pull);
            push(&spring.b, -pull);
        }
    }
}

/// Adds a wrench about the centre of mass to the force in R¹².
fn add_wrench(
    sum: &mut DVector<f64>,
    body: Option<usize>,
    bodies: &[BodyState],
    force: Vector3<f64>,
    torque: Vector3<f64>,
) {
    let Some(body) = body else { return };
    let first = BODY_COORDINATES * body;
    let turning = torque.cross_matrix() * bodies[body].rotation * 0.5;
    for row in 0..3 {
        sum[first + row] += force[row];
    }
    for (entry, value) in sum.rows_mut(first + 3, 9).iter_mut().zip(turning.iter()) {
        *entry += value;
    }
}

/// The rotation vector of a rotation by less than half a turn.
fn rotation_vector(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let skew = 0.5
        * Vector3::new(
            rotation[(2, 1)] - rotation[(1, 2)],
            rotation[(0, 2)] - rotation[(2, 0)],
            rotation[(1, 0)] - rotation[(0, 1)],
        );
    let sine = skew.norm();
    let angle = sine.atan2(0.5 * (rotation.trace() - 1.0));
    if sine < 1e-12 { skew } else { skew * (angle / sine) }
}

/// Body-frame angular velocity of `exp(θ)` for the rate of θ.
fn body_rate(theta: &Vector3<f64>, rate: &Vector3<f64>) -> Vector3<f64> {
    // Σ (−1)ⁿ θ̂ⁿ θ̇ / (n+1)!, which converges for every θ and needs no case for small ones.
    let (mut term, mut sum) = (*rate, *rate);
    for n in 1..40 {
        term = -theta.cross(&term) / (n as f64 + 1.0);
        sum += term;
    }
    sum
}
