//! The equations of motion of a model's tree at one instant, in the coordinates q, v of [`Coordinates`](crate::session::Coordinates).
//!
//! ```text
//!     M(q) a = τ + f(q, v)          a = dv/dt,  f: gravity, springs, dampers, loads, centrifugal and Coriolis forces
//!     v_link = J(q) v               velocity of a link frame's origin, then its angular velocity, in the world
//! ```
//!
//! Closed loops, limits, dry friction, motors and contacts are left out: a run computes their forces. With the velocities u of a state, v = T u: M
//! = T⁻ᵀ H T⁻¹, J = J_u T⁻¹.
//!
//! Source: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapters 5 to 7.

use crate::instant::dynamics::mass_matrix::mass_matrix;
use crate::mechanism::description::body_state::WORLD;
use crate::mechanism::motion::kinematics::forward_kinematics;
use crate::mechanism::motion::state::State;
use crate::reduced::ReducedOde;
use crate::scene::UrdfJointKind;
use crate::session::error::Error;
use crate::session::model::Model;
use nalgebra::{DMatrix, DVector, Vector3};

impl Model {
    /// The mass matrix M (n × n), symmetric [kg, kg m, kg m²].
    ///
    /// # Errors
    /// A wrong length of q, and numbers that are not finite.
    pub fn mass_matrix(&self, q: &[f64]) -> Result<DMatrix<f64>, Error> {
        let state = self.state_at(q, None)?;
        Ok(self.mass_matrix_at(&state))
    }

    /// The Jacobian of a link (6 × n): velocity of its frame's origin [m/s], then its angular velocity [rad/s], in the world, for v.
    ///
    /// # Errors
    /// An unknown link, a wrong length of q, and numbers that are not finite.
    pub fn jacobian(&self, link: &str, q: &[f64]) -> Result<DMatrix<f64>, Error> {
        let link = self.link_index(link)?;
        let state = self.state_at(q, None)?;
        let (description, count) = (self.description(), state.velocity.len());
        let mut bodies = vec![WORLD; description.mechanism.bodies.len()];
        let mut unit = vec![0.0; count];
        let mut jacobian = DMatrix::zeros(6, count);
        for freedom in 0..count {
            unit[freedom] = 1.0;
            forward_kinematics(&description.mechanism, &state.position, &unit, &mut bodies);
            unit[freedom] = 0.0;
            let moved = description.link_state(&bodies, link);
            let origin = moved.linear_velocity + moved.angular_velocity.cross(&(moved.position - moved.center_of_mass));
            jacobian.fixed_view_mut::<3, 1>(0, freedom).copy_from(&origin);
            jacobian.fixed_view_mut::<3, 1>(3, freedom).copy_from(&moved.angular_velocity);
        }
        Ok(match self.inverse_map(&state) {
            None => jacobian,
            Some(inverse) => jacobian * inverse,
        })
    }

    /// The efforts τ (n) that give the accelerations a = dv/dt (n) besides gravity, springs, dampers and loads [N m or N].
    ///
    /// # Errors
    /// Wrong lengths, and numbers that are not finite.
    pub fn inverse_dynamics(&self, q: &[f64], v: &[f64], a: &[f64]) -> Result<DVector<f64>, Error> {
        let state = self.state_at(q, Some(v))?;
        self.coordinates().check("a", a, v.len(), |joint| &joint.v)?;
        let missing = DVector::from_column_slice(a) - self.free_accelerations(&state);
        Ok(self.mass_matrix_at(&state) * missing)
    }

    /// The accelerations dv/dt (n) under efforts τ (n), gravity, springs, dampers and loads.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, and a mass matrix that is singular.
    pub fn forward_dynamics(&self, q: &[f64], v: &[f64], efforts: &[f64]) -> Result<DVector<f64>, Error> {
        let state = self.state_at(q, Some(v))?;
        self.coordinates().check("efforts", efforts, v.len(), |joint| &joint.v)?;
        let free = self.free_accelerations(&state);
        let factors = self.mass_matrix_at(&state).cholesky().ok_or(Error::SingularMass)?;
        Ok(free + factors.solve(&DVector::from_column_slice(efforts)))
    }

    /// The efforts (n) that hold the tree at rest against gravity alone [N m or N]: `τ_i = −Σ m g · ∂x/∂v_i` with the centres of mass x.
    ///
    /// # Errors
    /// A wrong length of q, and numbers that are not finite.
    pub fn gravity_efforts(&self, q: &[f64]) -> Result<DVector<f64>, Error> {
        let state = self.state_at(q, None)?;
        let mechanism = &self.description().mechanism;
        let mut bodies = vec![WORLD; mechanism.bodies.len()];
        let mut unit = vec![0.0; state.velocity.len()];
        let mut efforts = DVector::zeros(unit.len());
        for freedom in 0..unit.len() {
            unit[freedom] = 1.0;
            forward_kinematics(mechanism, &state.position, &unit, &mut bodies);
            unit[freedom] = 0.0;
            let power: f64 = mechanism
                .bodies
                .iter()
                .zip(&bodies)
                .map(|(body, at)| body.mass * mechanism.gravity.dot(&at.velocity))
                .sum();
            efforts[freedom] = -power;
        }
        Ok(match self.inverse_map(&state) {
            None => efforts,
            Some(inverse) => inverse.tr_mul(&efforts),
        })
    }

    /// A state of q, and of v or at rest.
    fn state_at(&self, q: &[f64], v: Option<&[f64]>) -> Result<State, Error> {
        let rest = vec![0.0; self.coordinates().v_count()];
        self.coordinates().state(self.description(), q, v.unwrap_or(&rest))
    }

    /// T⁻¹; `None` if it is the identity. It always exists, because the blocks of T are products of rotations and shears.
    fn inverse_map(&self, state: &State) -> Option<DMatrix<f64>> {
        self.coordinates().velocity_map(self.description(), &state.position)?.try_inverse()
    }

    fn mass_matrix_at(&self, state: &State) -> DMatrix<f64> {
        let matrix = mass_matrix(&self.description().mechanism, state);
        match self.inverse_map(state) {
            None => matrix,
            Some(inverse) => inverse.tr_mul(&matrix) * inverse,
        }
    }

    /// dv/dt without efforts: `T u̇ + Ṫ u`.
    fn free_accelerations(&self, state: &State) -> DVector<f64> {
        let description = self.description();
        let mut accelerations = vec![0.0; state.velocity.len()];
        ReducedOde::new(&description.mechanism).accelerations(&state.position, &state.velocity, &mut accelerations);
        let accelerations = DVector::from_vec(accelerations);
        let Some(map) = self.coordinates().velocity_map(description, &state.position) else { return accelerations };
        let mut accelerations = map * accelerations;
        for joint in self.coordinates().joints() {
            let record = &description.joints[joint.record];
            if record.kind != UrdfJointKind::Floating {
                continue;
            }
            // The child frame's origin turns about the body's frame origin: ω × (ω × arm). A ball joint's Ṫ u is R (w × w) = 0.
            let at = description.joint_coordinates(joint.record, &state.position, &state.velocity);
            let (q, v) = (at.position(), at.velocity());
            let spin = Vector3::new(v[3], v[4], v[5]);
            let turn = crate::mechanism::description::joint::rotation_from_wxyz(&q[3..7]);
            let arm = -(turn * record.child_link_in_body.inverse().translation.vector);
            let bias = spin.cross(&spin.cross(&arm));
            for axis in 0..3 {
                accelerations[joint.v.start + axis] += bias[axis];
            }
        }
        accelerations
    }
}
