//! Quantities of links, of points on them and of all that moves, at one instant, in the coordinates q, v of
//! [`Coordinates`](crate::session::Coordinates).
//!
//! ```text
//!     ẋ = J(q) v                                     x: velocity of a point on a link, then the link's angular velocity, in the world     (6)
//!     ẍ = J(q) a + J̇(q, v) v                         a = dv/dt
//!     c = Σ m_i c_i / Σ m_i,   ċ = J_c(q) v          centre of mass of all that moves                                                  (3)
//!     p = Σ m_i ċ_i,   L = Σ m_i c_i × ċ_i + I_i ω_i   momentum, about the origin of the world                                         (3 each)
//! ```
//!
//! With the velocities u of a state, v = T u: J = J_u T⁻¹, u̇ = T⁻¹ (a − Ṫ u).

use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::motion::energy::momentum;
use crate::mechanism::motion::kinematics::{body_accelerations, body_states, forward_kinematics};
use crate::mechanism::motion::state::State;
use crate::session::error::Error;
use crate::session::model::Model;
use nalgebra::{DMatrix, DVector, Vector3, Vector6};

impl Model {
    /// The Jacobian of a link (6 × n): velocity of its frame's origin [m/s], then its angular velocity [rad/s], in the world, for v.
    ///
    /// # Errors
    /// An unknown link, a wrong length of q, and numbers that are not finite.
    pub fn jacobian(&self, link: &str, q: &[f64]) -> Result<DMatrix<f64>, Error> {
        self.point_jacobian(link, [0.0; 3], q)
    }

    /// The same for a point on the link, in the link's frame (m).
    ///
    /// # Errors
    /// As of [`Model::jacobian`].
    pub fn point_jacobian(&self, link: &str, point: [f64; 3], q: &[f64]) -> Result<DMatrix<f64>, Error> {
        let link = self.link_index(link)?;
        let point = finite_point(point)?;
        let state = self.state_at(q, None)?;
        let rows = |bodies: &[BodyState]| self.moved(bodies, link, &point);
        Ok(self.by_velocity(&state, 6, |bodies, column| column.copy_from_slice(rows(bodies).as_slice())))
    }

    /// The velocity of a point on a link, given in the link's frame (m), and the link's angular velocity, in the world [m/s, rad/s].
    ///
    /// # Errors
    /// An unknown link, wrong lengths, and numbers that are not finite.
    pub fn point_velocity(&self, link: &str, point: [f64; 3], q: &[f64], v: &[f64]) -> Result<Vector6<f64>, Error> {
        let link = self.link_index(link)?;
        let point = finite_point(point)?;
        let bodies = body_states(&self.description().mechanism, &self.state_at(q, Some(v))?);
        Ok(self.moved(&bodies, link, &point))
    }

    /// The acceleration of that point, and the link's angular acceleration, in the world, for a = dv/dt [m/s², rad/s²].
    ///
    /// # Errors
    /// As of [`Model::point_velocity`].
    pub fn point_acceleration(
        &self,
        link: &str,
        point: [f64; 3],
        q: &[f64],
        v: &[f64],
        a: &[f64],
    ) -> Result<Vector6<f64>, Error> {
        let link = self.link_index(link)?;
        let point = finite_point(point)?;
        let state = self.state_at(q, Some(v))?;
        self.coordinates().check("a", a, v.len(), |joint| &joint.v)?;
        let own = self.state_accelerations(&state, &DVector::from_column_slice(a));
        let mechanism = &self.description().mechanism;
        let bodies = body_states(mechanism, &state);
        let mut accelerations = vec![Default::default(); bodies.len()];
        body_accelerations(mechanism, &bodies, &state.velocity, own.as_slice(), &mut accelerations);
        let body = self.description().links[link].body;
        let (linear, angular) = body.map_or_else(Default::default, |body| accelerations[body]);
        let (at, seen) = (body.map_or(WORLD, |body| bodies[body]), self.description().link_state(&bodies, link));
        let arm = seen.position + seen.rotation * point - at.position;
        let spin = at.angular_velocity;
        let linear = linear + angular.cross(&arm) + spin.cross(&spin.cross(&arm));
        Ok(stacked(&linear, &angular))
    }

    /// J̇ v of a point on a link: its acceleration, and the link's, for dv/dt = 0 [m/s², rad/s²].
    ///
    /// # Errors
    /// As of [`Model::point_velocity`].
    pub fn point_bias(&self, link: &str, point: [f64; 3], q: &[f64], v: &[f64]) -> Result<Vector6<f64>, Error> {
        self.point_acceleration(link, point, q, v, &vec![0.0; v.len()])
    }

    /// The centre of mass of all that moves, in the world (m).
    ///
    /// # Errors
    /// A wrong length of q, and numbers that are not finite.
    pub fn center_of_mass(&self, q: &[f64]) -> Result<Vector3<f64>, Error> {
        let mechanism = &self.description().mechanism;
        let bodies = body_states(mechanism, &self.state_at(q, None)?);
        let moments = mechanism.bodies.iter().zip(&bodies).map(|(body, at)| body.mass * at.position);
        Ok(moments.sum::<Vector3<f64>>() / mechanism.total_mass().max(f64::MIN_POSITIVE))
    }

    /// The Jacobian of the centre of mass (3 × n) for v.
    ///
    /// # Errors
    /// As of [`Model::center_of_mass`].
    pub fn center_of_mass_jacobian(&self, q: &[f64]) -> Result<DMatrix<f64>, Error> {
        let mechanism = &self.description().mechanism;
        let mass = mechanism.total_mass().max(f64::MIN_POSITIVE);
        let state = self.state_at(q, None)?;
        Ok(self.by_velocity(&state, 3, |bodies, column| {
            column.copy_from_slice((momentum(mechanism, bodies).0 / mass).as_slice());
        }))
    }

    /// The momentum of all that moves [kg m/s], and its angular momentum about the origin of the world [kg m²/s].
    ///
    /// # Errors
    /// Wrong lengths, and numbers that are not finite.
    pub fn momentum(&self, q: &[f64], v: &[f64]) -> Result<Vector6<f64>, Error> {
        let mechanism = &self.description().mechanism;
        let (linear, angular) = momentum(mechanism, &body_states(mechanism, &self.state_at(q, Some(v))?));
        Ok(stacked(&linear, &angular))
    }

    /// A matrix (rows × n) whose columns a function works out from the bodies that move with one entry of v at rate one.
    fn by_velocity(&self, state: &State, rows: usize, column: impl Fn(&[BodyState], &mut [f64])) -> DMatrix<f64> {
        let (mechanism, count) = (&self.description().mechanism, state.velocity.len());
        let mut bodies = vec![WORLD; mechanism.bodies.len()];
        let mut unit = vec![0.0; count];
        let mut matrix = DMatrix::zeros(rows, count);
        for freedom in 0..count {
            unit[freedom] = 1.0;
            forward_kinematics(mechanism, &state.position, &unit, &mut bodies);
            unit[freedom] = 0.0;
            column(&bodies, matrix.column_mut(freedom).as_mut_slice());
        }
        match self.inverse_map(state) {
            None => matrix,
            Some(inverse) => matrix * inverse,
        }
    }

    /// The velocity of a point on a link, and the link's angular velocity.
    fn moved(&self, bodies: &[BodyState], link: usize, point: &Vector3<f64>) -> Vector6<f64> {
        let seen = self.description().link_state(bodies, link);
        let arm = seen.position + seen.rotation * point - seen.center_of_mass;
        stacked(&(seen.linear_velocity + seen.angular_velocity.cross(&arm)), &seen.angular_velocity)
    }
}

fn stacked(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

fn finite_point(point: [f64; 3]) -> Result<Vector3<f64>, Error> {
    match point.into_iter().find(|number| !number.is_finite()) {
        None => Ok(Vector3::from(point)),
        Some(value) => Err(Error::Option { option: "the point", value, wanted: "give finite numbers" }),
    }
}
