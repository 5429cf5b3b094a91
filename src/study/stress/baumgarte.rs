//! The constrained explicit integrator of the textbooks: multipliers for the accelerations, drift held down by Baumgarte's
//! stabilisation, RK4 in maximal coordinates. Dense, and meant for comparison only.
//!
//! Every joint, of the tree or of a loop, is a set of equations `g(q) = 0` between the coordinates `x` (m), `R` (as a unit
//! quaternion) of two bodies, with `ġ = G v` for the velocities `v = (ẋ [m/s], ω [rad/s])`. Differentiated twice and with damping and spring
//! terms that pull a violation back,
//!
//! ```text
//!     M a = f + Gᵀ λ                            M = diag(m, R J Rᵀ),  f gravity, springs and −ω × R J Rᵀ ω  [N, N m]
//!     G a = −Ġ v − 2 α ġ − β² g                 α = β = min(10, 1/h)  [1/s]
//!     (G M⁻¹ Gᵀ) λ = −Ġ v − 2 α ġ − β² g − G M⁻¹ f
//! ```
//!
//! solved by Gauss with partial pivots, as the textbooks do: G must have full rank. 10/s is in the middle of the usual range; beyond
//! 1/h the correction itself would be unstable.
//!
//! Source: J. Baumgarte, Stabilization of constraints and integrals of motion in dynamical systems, Computer Methods in
//! Applied Mechanics and Engineering 1 (1972) 1–16; P. E. Nikravesh, Computer-Aided Analysis of Mechanical Systems, 1988, section 13.3.

use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::closure::{Attachment, LoopJoint, LoopKind};
use crate::mechanism::description::joint::{JointKind, rotation_from_wxyz, wxyz_from_rotation};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::forces::total::{BodyWrench, Exchange, body_wrenches, powers};
use crate::mechanism::motion::gaps::{loop_gap_accelerations, loop_gaps};
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::{State, quaternion_product};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Largest number of bodies: beyond it dense matrices only waste time.
pub const LARGEST: usize = 20;

/// The usual constant of the stabilisation [1/s].
const USUAL: f64 = 10.0;

/// Numbers of one body in the vector y: x, quaternion, v, ω.
const ENTRIES: usize = 13;

/// Why the textbook method cannot go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BaumgarteError {
    /// Equations that the others imply.
    #[error(
        "at t = {time} s the equations of the constraints depend on each other, and the multipliers are not determined"
    )]
    Singular { time: f64 },
    /// The motion has gone to infinity.
    #[error("at t = {time} s the motion of body {body:?} is not finite")]
    NotFinite { time: f64, body: String },
}

/// The integrator with its state.
#[derive(Clone, Debug)]
pub struct Baumgarte<'m> {
    mechanism: &'m Mechanism,
    constraints: Vec<LoopJoint>,
    rows: usize,
    step: f64,
    time: f64,
    /// [`ENTRIES`] for each body, then the energy dissipated and the work put in (J).
    y: DVector<f64>,
}

impl<'m> Baumgarte<'m> {
    /// For one mechanism from a start, which need not satisfy its loops, with a fixed step (s).
    ///
    /// # Errors
    /// Why the method does not know such a mechanism.
    pub fn new(mechanism: &'m Mechanism, start: &State, step: f64) -> Result<Self, &'static str> {
        let forces = &mechanism.forces;
        if mechanism.bodies.len() > LARGEST {
            return Err("dense matrices: at most 20 bodies");
        }
        if mechanism.bodies.iter().any(|body| body.mass <= 0.0 || body.inertia.min() <= 0.0) {
            return Err("it inverts the mass matrix: every body needs mass and inertia");
        }
        let free_joints =
            forces.joint_dampers.is_empty() && forces.joint_springs.is_empty() && forces.joint_loads.is_empty();
        let free_joints = free_joints && !forces.change();
        if !free_joints || !mechanism.mimics.is_empty() {
            return Err("it has no joint coordinates, which forces in joints and mimic relations need");
        }
        let constraints: Vec<LoopJoint> = tree_constraints(mechanism).chain(mechanism.loops.iter().cloned()).collect();
        let rows = constraints.iter().map(|joint| joint.kind.rows()).sum();
        let mut y = DVector::zeros(ENTRIES * mechanism.bodies.len() + 2);
        for (index, body) in body_states(mechanism, start).iter().enumerate() {
            let mut own = y.rows_mut(ENTRIES * index, ENTRIES);
            own.fixed_rows_mut::<3>(0).copy_from(&body.position);
            own.fixed_rows_mut::<4>(3).copy_from_slice(&wxyz_from_rotation(&body.rotation));
            own.fixed_rows_mut::<3>(7).copy_from(&body.velocity);
            own.fixed_rows_mut::<3>(10).copy_from(&body.angular_velocity);
        }
        Ok(Baumgarte { mechanism, constraints, rows, step, time: start.time, y })
    }

    /// The time reached (s).
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The bodies there.
    pub fn bodies(&self) -> Vec<BodyState> {
        bodies_of(&self.y)
    }

    /// Energy dissipated, and work put in since the start (J).
    pub fn exchange(&self) -> Exchange {
        let n = self.y.len();
        Exchange { dissipated: self.y[n - 2], work: self.y[n - 1], ..Exchange::default() }
    }

    /// Number of unknowns of the linear system, which sets the cost of a step.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// One step towards `until` (s).
    ///
    /// # Errors
    /// [`BaumgarteError`]; the state is then that before the step.
    pub fn advance(&mut self, until: f64) -> Result<(), BaumgarteError> {
        let remaining = until - self.time;
        // A rest that is longer than the step by rounding only is taken whole.
        let (h, time) =
            if remaining <= self.step * 1.000_000_1 { (remaining, until) } else { (self.step, self.time + self.step) };
        let k1 = self.derivative(&self.y)?;
        let k2 = self.derivative(&(&self.y + &k1 * (0.5 * h)))?;
        let k3 = self.derivative(&(&self.y + &k2 * (0.5 * h)))?;
        let k4 = self.derivative(&(&self.y + &k3 * h))?;
        let mut end = &self.y + (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
        for (index, body) in self.mechanism.bodies.iter().enumerate() {
            let mut own = end.rows_mut(ENTRIES * index, ENTRIES);
            if own.iter().any(|value| !value.is_finite()) {
                return Err(BaumgarteError::NotFinite { time: self.time, body: body.name.clone() });
            }
            let mut quaternion = own.fixed_rows_mut::<4>(3);
            let norm = quaternion.norm();
            quaternion /= norm;
        }
        self.y = end;
        self.time = time;
        Ok(())
    }

    /// ẏ.
    fn derivative(&self, y: &DVector<f64>) -> Result<DVector<f64>, BaumgarteError> {
        let (mechanism, bodies) = (self.mechanism, bodies_of(y));
        let mut wrenches = vec![BodyWrench::default(); bodies.len()];
        body_wrenches(mechanism, 0.0, &bodies, &mut wrenches);
        let mut inverses = Vec::with_capacity(bodies.len());
        // The accelerations of the bodies without constraints: M⁻¹ f.
        let mut free = DVector::zeros(6 * bodies.len());
        for (index, (body, state)) in mechanism.bodies.iter().zip(&bodies).enumerate() {
            let spin = state.rotation.transpose() * state.angular_velocity;
            let momentum = state.rotation * body.inertia.component_mul(&spin);
            let inverse =
                state.rotation * Matrix3::from_diagonal(&body.inertia.map(|j| 1.0 / j)) * state.rotation.transpose();
            let torque = wrenches[index].1 - state.angular_velocity.cross(&momentum);
            free.fixed_rows_mut::<3>(6 * index).copy_from(&(mechanism.gravity + wrenches[index].0 / body.mass));
            free.fixed_rows_mut::<3>(6 * index + 3).copy_from(&(inverse * torque));
            inverses.push((1.0 / body.mass, inverse));
        }
        let (jacobian, right) = self.constraint_rows(&bodies, &free);
        // Gᵀ with M⁻¹ in front.
        let mut response = jacobian.transpose();
        for (index, (inverse_mass, inverse)) in inverses.iter().enumerate() {
            let mut linear = response.fixed_rows_mut::<3>(6 * index);
            linear *= *inverse_mass;
            let turned = inverse * response.fixed_rows::<3>(6 * index + 3);
            response.fixed_rows_mut::<3>(6 * index + 3).copy_from(&turned);
        }
        let accelerations = if self.rows == 0 {
            free
        } else {
            let singular = BaumgarteError::Singular { time: self.time };
            let multipliers = (&jacobian * &response).lu().solve(&right).ok_or(singular)?;
            free + response * multipliers
        };
        let mut slope = DVector::zeros(y.len());
        for (index, state) in bodies.iter().enumerate() {
            let mut own = slope.rows_mut(ENTRIES * index, ENTRIES);
            let half: Vector3<f64> = 0.5 * state.angular_velocity;
            let turning = quaternion_product(
                &[0.0, half.x, half.y, half.z],
                y.rows(ENTRIES * index + 3, 4).clone_owned().as_slice(),
            );
            own.fixed_rows_mut::<3>(0).copy_from(&state.velocity);
            own.fixed_rows_mut::<4>(3).copy_from_slice(&turning);
            own.fixed_rows_mut::<6>(7).copy_from(&accelerations.fixed_rows::<6>(6 * index));
        }
        let exchange = powers(mechanism, 0.0, &vec![0.0; mechanism.velocity_count], &bodies);
        let n = y.len();
        (slope[n - 2], slope[n - 1]) = (exchange.dissipated, exchange.work);
        Ok(slope)
    }

    /// G, and the right side of the equations for the multipliers.
    fn constraint_rows(&self, bodies: &[BodyState], free: &DVector<f64>) -> (DMatrix<f64>, DVector<f64>) {
        let alpha = USUAL.min(1.0 / self.step);
        let still = vec![(Vector3::zeros(), Vector3::zeros()); bodies.len()];
        let mut probe = bodies.to_vec();
        probe.iter_mut().for_each(|body| (body.velocity, body.angular_velocity) = Default::default());
        let mut jacobian = DMatrix::zeros(self.rows, 6 * bodies.len());
        let mut right = DVector::zeros(self.rows);
        let mut first = 0;
        for joint in &self.constraints {
            let gaps = loop_gaps(joint, bodies);
            // If the bodies are not accelerated, the second derivative is Ġ v.
            let (bias, _) = loop_gap_accelerations(joint, bodies, &still);
            for row in 0..gaps.count {
                right[first + row] = -bias[row] - 2.0 * alpha * gaps.velocity[row] - alpha * alpha * gaps.position[row];
            }
            for body in [joint.a.body, joint.b.body].into_iter().flatten() {
                // ġ is linear in the velocities: a unit velocity gives a column.
                for axis in 0..6 {
                    let unit = Vector3::ith(axis % 3, 1.0);
                    let velocities = if axis < 3 { (unit, Vector3::zeros()) } else { (Vector3::zeros(), unit) };
                    (probe[body].velocity, probe[body].angular_velocity) = velocities;
                    let column = loop_gaps(joint, &probe).velocity;
                    for row in 0..gaps.count {
                        jacobian[(first + row, 6 * body + axis)] = column[row];
                    }
                }
                (probe[body].velocity, probe[body].angular_velocity) = Default::default();
            }
            first += gaps.count;
        }
        right -= &jacobian * free;
        (jacobian, right)
    }
}

/// The joints of the tree as joints between two frames; a floating joint has no equations.
fn tree_constraints(mechanism: &Mechanism) -> impl Iterator<Item = LoopJoint> + '_ {
    mechanism.bodies.iter().enumerate().filter_map(|(index, body)| {
        let kind = match body.joint.kind {
            JointKind::Revolute => LoopKind::Revolute,
            JointKind::Prismatic => LoopKind::Prismatic,
            JointKind::Planar => LoopKind::Planar,
            JointKind::Spherical => LoopKind::Spherical,
            JointKind::Floating => return None,
        };
        Some(LoopJoint {
            name: body.joint.name.clone(),
            kind,
            a: Attachment { body: body.parent, frame: body.joint.on_parent },
            b: Attachment { body: Some(index), frame: body.joint.on_child },
        })
    })
}

fn bodies_of(y: &DVector<f64>) -> Vec<BodyState> {
    let body = |index: usize| {
        let own = y.rows(ENTRIES * index, ENTRIES);
        BodyState {
            position: own.fixed_rows::<3>(0).into_owned(),
            rotation: rotation_from_wxyz(own.fixed_rows::<4>(3).into_owned().as_slice()),
            velocity: own.fixed_rows::<3>(7).into_owned(),
            angular_velocity: own.fixed_rows::<3>(10).into_owned(),
        }
    };
    (0..y.len() / ENTRIES).map(body).collect()
}
