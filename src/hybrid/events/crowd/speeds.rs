//! The speeds for which the candidates of a step are enough: the larger of those at its start and at its middle, where impacts have changed them.
//!
//! Bodies that fly together come near as fast as each of them moves: an impact on one of them within the step may stop it. With their speeds against
//! each other candidates came late, and steps were made again: a limp g1 took 9594 iterations instead of 5945, talos_reduced 18287 instead of 12973.

use crate::instant::holding::pairs::Pair;
use crate::mechanism::description::body_state::BodyState;

/// Speeds that have grown by this factor in a step make all pairs be looked at again.
const GROWN: f64 = 1.25;

/// The larger speed and angular speed of each body [m/s, rad/s].
#[derive(Clone)]
pub(crate) struct Speeds(Vec<(f64, f64)>);

impl Speeds {
    /// Of this number of bodies at rest.
    pub fn new(bodies: usize) -> Self {
        Speeds(vec![(0.0, 0.0); bodies])
    }

    /// Takes the bodies where a step begins.
    pub fn begin(&mut self, bodies: &[BodyState]) {
        self.0.iter_mut().zip(bodies).for_each(|(rate, body)| *rate = speeds(body));
    }

    /// Takes them at its middle, too.
    pub fn go_on(&mut self, bodies: &[BodyState]) {
        for (rate, body) in self.0.iter_mut().zip(bodies) {
            let now = speeds(body);
            *rate = (rate.0.max(now.0), rate.1.max(now.1));
        }
    }

    /// The larger speed and angular speed of each body [m/s, rad/s].
    pub fn rates(&self) -> &[(f64, f64)] {
        &self.0
    }

    /// The speed of the points of a body within a reach (m) [m/s].
    pub fn of(&self, body: usize, reach: f64) -> f64 {
        let (speed, turning) = self.0[body];
        speed + turning * reach
    }

    /// The speeds of the points of both bodies of a pair together [m/s].
    pub fn closing(&self, of: &Pair) -> f64 {
        let speed = |side: usize| of.bodies[side].map_or(0.0, |body| self.of(body, of.reach[side]));
        speed(0) + speed(1)
    }

    /// Whether a body is faster than that by a factor, and by what is gained in a step [m/s, rad/s].
    pub fn have_grown(&self, bodies: &[BodyState], gained: f64) -> bool {
        let grown = |(body, rate): (&BodyState, &(f64, f64))| {
            let now = speeds(body);
            now.0 > GROWN * rate.0 + gained || now.1 > GROWN * rate.1 + gained
        };
        bodies.iter().zip(&self.0).any(grown)
    }
}

fn speeds(body: &BodyState) -> (f64, f64) {
    (body.velocity.norm(), body.angular_velocity.norm())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::body_state::WORLD;
    use nalgebra::Vector3;

    #[test]
    fn speeds_are_those_at_the_start_or_at_the_middle_and_have_grown_by_a_quarter_and_what_a_step_gains() {
        let mut speeds = Speeds::new(1);
        let moves = |speed: f64, turning: f64| {
            let (velocity, angular_velocity) = (Vector3::x() * speed, Vector3::z() * turning);
            [BodyState { velocity, angular_velocity, ..WORLD }]
        };
        speeds.begin(&moves(2.0, 1.0));
        speeds.go_on(&moves(1.0, 3.0));
        assert_eq!(speeds.of(0, 0.5), 3.5);
        assert!(!speeds.have_grown(&moves(2.5, 3.75), 0.01) && speeds.have_grown(&moves(2.52, 0.0), 0.01));
    }
}
