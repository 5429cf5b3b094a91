//! A spring with a damper between two points, each fixed in a body or in the world.
//!
//! ```text
//!     d = P_b − P_a [m],   ℓ = |d|,   u = d/ℓ,   ℓ̇ = u·ḋ
//!     T = k (ℓ − ℓ₀) + c ℓ̇          [N]      tension; k [N/m], c [N s/m], ℓ₀ [m]
//!     F_b = −T u,   F_a = T u        [N]
//!     V = ½ k (ℓ − ℓ₀)²              [J]      P = c ℓ̇² ≥ 0  [W], turned into heat
//!
//!     ∂F_b/∂ḋ = −c u uᵀ
//!     ∂F_b/∂d = −k u uᵀ − (T/ℓ) Π − (c/ℓ) u (Π ḋ)ᵀ,      Π = 1 − u uᵀ
//! ```
//!
//! The second term is the geometric stiffness: a taut spring resists turning. If the points meet, u has no direction. The force is taken to be zero
//! there, which is right for a spring of rest length zero. Any other has no force there that is defined, so no run starts there
//! ([`PointSpring::is_undirected`]).
//!
//! Source: E. J. Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), section 6.1.4
//! (translational spring-damper-actuators).

use crate::description::body_state::BodyState;
use crate::description::forces::PointSpring;
use nalgebra::{Matrix3, Vector3};

/// Added to ℓ² (m²), so that u is zero, and not undefined, where the points meet; below the rounding of every other ℓ.
pub const NO_LENGTH: f64 = 1e-300;

/// Points coincide within this part of their distances from the origin: some roundings of the sums that place them.
const COINCIDENCE: f64 = 1e-14;

/// The line from a to b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// `d` (m).
    pub separation: Vector3<f64>,
    /// `ℓ` (m).
    pub length: f64,
    /// `u`.
    pub direction: Vector3<f64>,
    /// `ℓ̇` [m/s].
    pub rate: f64,
}

impl Line {
    /// The line of a separation (m) and its rate [m/s].
    pub fn new(separation: Vector3<f64>, separation_rate: &Vector3<f64>) -> Self {
        let length = (separation.norm_squared() + NO_LENGTH).sqrt();
        let direction = separation / length;
        Line { separation, length, direction, rate: direction.dot(separation_rate) }
    }
}

impl PointSpring {
    /// The line between its ends.
    pub fn line(&self, bodies: &[BodyState]) -> Line {
        let ((from, from_rate), (to, to_rate)) = (self.a.point(bodies), self.b.point(bodies));
        Line::new(to - from, &(to_rate - from_rate))
    }

    /// Whether its ends coincide to some roundings of their places though it pushes them apart, with no direction to do so.
    pub fn is_undirected(&self, bodies: &[BodyState]) -> bool {
        let places = [&self.a, &self.b].map(|end| end.point(bodies).0.norm());
        let nothing = COINCIDENCE * (self.rest_length + places[0] + places[1]);
        self.stiffness * self.rest_length > 0.0 && self.line(bodies).length <= nothing
    }

    /// `T` (N).
    pub fn tension(&self, length: f64, rate: f64) -> f64 {
        self.stiffness * (length - self.rest_length) + self.damping * rate
    }

    /// The force on b (N); the force on a is its opposite.
    pub fn force(&self, line: &Line) -> Vector3<f64> {
        line.direction * -self.tension(line.length, line.rate)
    }

    /// The energy it stores (J).
    pub fn energy(&self, length: f64) -> f64 {
        0.5 * self.stiffness * (length - self.rest_length).powi(2)
    }

    /// The power turned into heat (W).
    pub fn dissipated_power(&self, rate: f64) -> f64 {
        self.damping * rate * rate
    }

    /// `∂F_b/∂d` [N/m] and `∂F_b/∂ḋ` [N s/m].
    pub fn derivative(&self, line: &Line, separation_rate: &Vector3<f64>) -> (Matrix3<f64>, Matrix3<f64>) {
        let u = line.direction;
        let along = u * u.transpose();
        let across = Matrix3::identity() - along;
        let by_rate = -self.damping * along;
        let by_separation = -self.stiffness * along
            - across * (self.tension(line.length, line.rate) / line.length)
            - u * (across * separation_rate).transpose() * (self.damping / line.length);
        (by_separation, by_rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::closure::Attachment;
    use crate::description::joint::Pose;
    use crate::forces::differences::central_vector;

    fn spring() -> PointSpring {
        let end = Attachment { body: None, frame: Pose::identity() };
        PointSpring { name: String::new(), a: end, b: end, stiffness: 50.0, damping: 3.0, rest_length: 0.6 }
    }

    #[test]
    fn derivatives_are_those_of_the_force_with_the_geometric_part() {
        let spring = spring();
        let (separation, rate) = (Vector3::new(0.3, -0.5, 0.8), Vector3::new(-0.4, 0.9, 0.2));
        let (by_separation, by_rate) = spring.derivative(&Line::new(separation, &rate), &rate);
        let numeric = central_vector(|d| spring.force(&Line::new(d, &rate)), separation);
        // Central differences of steps 1e-5 on numbers of order 100: 1e-8 at best.
        assert!((by_separation - numeric).amax() < 1e-6, "{by_separation} {numeric}");
        let numeric = central_vector(|w| spring.force(&Line::new(separation, &w)), rate);
        assert!((by_rate - numeric).amax() < 1e-6, "{by_rate} {numeric}");
    }

    #[test]
    fn force_is_minus_the_slope_of_the_energy_and_heat_is_what_the_damper_takes() {
        let spring = PointSpring { damping: 0.0, ..spring() };
        let separation = Vector3::new(0.3, -0.5, 0.8);
        let energy = |d: Vector3<f64>| Vector3::repeat(spring.energy(Line::new(d, &Vector3::zeros()).length));
        let slope = central_vector(energy, separation).row(0).transpose();
        let force = spring.force(&Line::new(separation, &Vector3::zeros()));
        assert!((slope + force).amax() < 1e-7, "{slope} {force}");
        let damper = PointSpring { stiffness: 0.0, damping: 3.0, ..spring };
        let rate = Vector3::new(-0.4, 0.9, 0.2);
        let line = Line::new(separation, &rate);
        assert!((damper.dissipated_power(line.rate) + damper.force(&line).dot(&rate)).abs() < 1e-14);
    }

    #[test]
    fn a_spring_whose_ends_coincide_has_no_direction_unless_it_has_no_rest_length() {
        assert!(spring().is_undirected(&[]));
        assert!(!PointSpring { rest_length: 0.0, ..spring() }.is_undirected(&[]));
        let beside = Attachment { body: None, frame: Pose::translation(1e-9, 0.0, 0.0) };
        assert!(!PointSpring { b: beside, ..spring() }.is_undirected(&[]));
    }

    #[test]
    fn force_is_finite_and_zero_where_the_points_meet() {
        let line = Line::new(Vector3::zeros(), &Vector3::new(1.0, 2.0, 3.0));
        assert_eq!(spring().force(&line), Vector3::zeros());
    }
}
