//! The equations of motion of a model at one instant, in the coordinates q, v of [`Coordinates`](crate::session::Coordinates).
//!
//! ```text
//!     M(q) a = τ + f(q, v)          a = dv/dt,  f: gravity, springs, dampers, loads, centrifugal and Coriolis forces
//!     a = a₀(q, v) + Y(q) τ         with closed loops and mimic relations
//! ```
//!
//! The mass matrix is that of the tree. Limits, dry friction, motors and contacts are left out: a run computes their forces. With the velocities u of
//! a state, v = T u: M = T⁻ᵀ H T⁻¹, Y = T Y_u Tᵀ. Links and points are in [`crate::session::quantities`].
//!
//! Source: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapters 5 to 7.

use crate::instant::dynamics::mass_matrix::mass_matrix;
use crate::instant::dynamics::response::Response;
use crate::mechanism::description::body_state::WORLD;
use crate::mechanism::motion::kinematics::forward_kinematics;
use crate::mechanism::motion::state::State;
use crate::reduced::ReducedOde;
use crate::scene::UrdfJointKind;
use crate::session::error::Error;
use crate::session::model::Model;
use nalgebra::{DMatrix, DVector, Vector3};

/// Eigenvalues of `C Cᵀ` below this part of the largest are zero: loops leave exact zeros and roundings.
const RANK: f64 = 1e-14;
/// Residuals are worked off this many times, because eigenvalues of `C Cᵀ` are squares.
const REFINEMENTS: usize = 3;
/// Accelerations that efforts leave unreached by more than this part of the largest are not possible.
const FITTING: f64 = 1e-7;

impl Model {
    /// The mass matrix M (n × n), symmetric [kg, kg m, kg m²].
    ///
    /// # Errors
    /// A wrong length of q, and numbers that are not finite.
    pub fn mass_matrix(&self, q: &[f64]) -> Result<DMatrix<f64>, Error> {
        let state = self.state_at(q, None)?;
        Ok(self.mass_matrix_at(&state))
    }

    /// The efforts τ (n) that give the accelerations a = dv/dt (n) besides gravity, springs, dampers and loads [N m or N]. If there are closed loops
    /// or joints that mimic others, several efforts do, and these are the least.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, and accelerations that the loops do not allow.
    pub fn inverse_dynamics(&self, q: &[f64], v: &[f64], a: &[f64]) -> Result<DVector<f64>, Error> {
        let every: Vec<usize> = (0..v.len()).collect();
        self.inverse_dynamics_along(&every, q, v, a)
    }

    /// The same with efforts on these joints alone, zero on all others: on the motors of a robot with loops.
    ///
    /// # Errors
    /// As of [`Model::inverse_dynamics`], unknown joints, and accelerations that these joints cannot give.
    pub fn inverse_dynamics_by(&self, joints: &[&str], q: &[f64], v: &[f64], a: &[f64]) -> Result<DVector<f64>, Error> {
        let mut along = Vec::new();
        for joint in joints {
            let place = self.coordinates().joint(joint).ok_or_else(|| self.unknown_joint(joint))?;
            along.extend(place.v.clone());
        }
        self.inverse_dynamics_along(&along, q, v, a)
    }

    fn inverse_dynamics_along(&self, along: &[usize], q: &[f64], v: &[f64], a: &[f64]) -> Result<DVector<f64>, Error> {
        let state = self.state_at(q, Some(v))?;
        let count = state.velocity.len();
        self.coordinates().check("a", a, count, |joint| &joint.v)?;
        let a = DVector::from_column_slice(a);
        let mechanism = &self.description().mechanism;
        if !mechanism.has_closures() && along.len() == count {
            return Ok(self.mass_matrix_at(&state) * (a - self.free_accelerations(&state)));
        }
        // Accelerations per unit of each effort: they are linear in the efforts.
        let mut response = Response::new(mechanism);
        let mut of_state = vec![0.0; count];
        let mut under = |unit: Option<usize>| {
            let mut efforts = vec![0.0; count];
            unit.into_iter().for_each(|freedom| efforts[freedom] = 1.0);
            self.coordinates().efforts_of_state(self.description(), &state.position, &efforts, &mut of_state);
            self.closed_accelerations(&mut response, &state, &of_state)
        };
        let free = under(None);
        let columns: Vec<DVector<f64>> = along.iter().map(|&freedom| under(Some(freedom)) - &free).collect();
        let columns = DMatrix::from_fn(count, along.len(), |row, column| columns[column][row]);
        let missing = &a - free;
        let found = least_norm(&columns, &missing);
        let left = (&columns * &found - &missing).amax();
        if left > FITTING * (1.0 + a.amax() + missing.amax()) {
            return Err(Error::ImpossibleAcceleration { left });
        }
        let mut efforts = DVector::zeros(count);
        along.iter().zip(found.iter()).for_each(|(&freedom, effort)| efforts[freedom] = *effort);
        Ok(efforts)
    }

    /// The accelerations dv/dt (n) under efforts τ (n), gravity, springs, dampers and loads, with closed loops and joints that mimic others.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, and a mass matrix that is singular.
    pub fn forward_dynamics(&self, q: &[f64], v: &[f64], efforts: &[f64]) -> Result<DVector<f64>, Error> {
        let state = self.state_at(q, Some(v))?;
        self.coordinates().check("efforts", efforts, v.len(), |joint| &joint.v)?;
        let mechanism = &self.description().mechanism;
        if mechanism.has_closures() {
            let mut of_state = vec![0.0; efforts.len()];
            self.coordinates().efforts_of_state(self.description(), &state.position, efforts, &mut of_state);
            return Ok(self.closed_accelerations(&mut Response::new(mechanism), &state, &of_state));
        }
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
    pub fn state_at(&self, q: &[f64], v: Option<&[f64]>) -> Result<State, Error> {
        let rest = vec![0.0; self.coordinates().v_count()];
        self.coordinates().state(self.description(), q, v.unwrap_or(&rest))
    }

    /// T⁻¹; `None` if it is the identity. It always exists, because the blocks of T are products of rotations and shears.
    pub(crate) fn inverse_map(&self, state: &State) -> Option<DMatrix<f64>> {
        self.coordinates().velocity_map(self.description(), &state.position)?.try_inverse()
    }

    fn mass_matrix_at(&self, state: &State) -> DMatrix<f64> {
        let matrix = mass_matrix(&self.description().mechanism, state);
        match self.inverse_map(state) {
            None => matrix,
            Some(inverse) => inverse.tr_mul(&matrix) * inverse,
        }
    }

    /// dv/dt of the tree without efforts.
    fn free_accelerations(&self, state: &State) -> DVector<f64> {
        let mut accelerations = vec![0.0; state.velocity.len()];
        let mut ode = ReducedOde::new(&self.description().mechanism);
        ode.accelerations(&state.position, &state.velocity, &mut accelerations);
        self.accelerations_of_v(state, DVector::from_vec(accelerations))
    }

    /// dv/dt with the loops, under efforts along the velocities of the state.
    fn closed_accelerations(&self, response: &mut Response, state: &State, efforts: &[f64]) -> DVector<f64> {
        let mut accelerations = vec![0.0; state.velocity.len()];
        response.accelerations(state, efforts, &mut accelerations);
        self.accelerations_of_v(state, DVector::from_vec(accelerations))
    }

    /// dv/dt from du/dt: `T u̇ + Ṫ u`.
    fn accelerations_of_v(&self, state: &State, accelerations: DVector<f64>) -> DVector<f64> {
        match self.coordinates().velocity_map(self.description(), &state.position) {
            None => accelerations,
            Some(map) => map * accelerations + self.turning(state),
        }
    }

    /// du/dt from dv/dt: `T⁻¹ (a − Ṫ u)`.
    pub(crate) fn state_accelerations(&self, state: &State, a: &DVector<f64>) -> DVector<f64> {
        match self.inverse_map(state) {
            None => a.clone(),
            Some(inverse) => inverse * (a - self.turning(state)),
        }
    }

    /// Ṫ u.
    fn turning(&self, state: &State) -> DVector<f64> {
        let description = self.description();
        let mut accelerations = DVector::zeros(state.velocity.len());
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

/// The least x with `C x = b`, or nearest to it: `x = Cᵀ (C Cᵀ)⁺ b`, with its residuals worked off.
fn least_norm(columns: &DMatrix<f64>, wanted: &DVector<f64>) -> DVector<f64> {
    let eigen = (columns * columns.transpose()).symmetric_eigen();
    let least = RANK * eigen.eigenvalues.amax();
    let mut found = DVector::zeros(columns.ncols());
    for _ in 0..=REFINEMENTS {
        let mut along = eigen.eigenvectors.tr_mul(&(wanted - columns * &found));
        for (part, &value) in along.iter_mut().zip(eigen.eigenvalues.iter()) {
            *part = if value > least { *part / value } else { 0.0 };
        }
        found += columns.tr_mul(&(&eigen.eigenvectors * along));
    }
    found
}
