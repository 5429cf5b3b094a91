//! Positions and velocities at an instant inside the last step: the rule of [`catena_lobatto::tableau::dense`], joint by joint.
//!
//! Scalars are interpolated as they are. The rotation of a ball joint since the start of the step is a rotation vector θ, whose
//! rate belongs to the angular velocity ω in the child's frame by `ω = (1 − k₁ θ̂ + k₂ θ̂²) θ̇`, with
//! `k₁ = (1 − cos |θ|)/|θ|²`, `k₂ = (|θ| − sin |θ|)/|θ|³`. Loops are not closed by the interpolation: [`catena_lobatto::coupled::closing`]
//! does that.

use catena_lobatto::coupled::system::One;
use catena_lobatto::numbers::algebra::Vector;
use catena_lobatto::numbers::arithmetic::Arithmetic;
use catena_lobatto::numbers::rotations::Tilt;
use catena_lobatto::step::interface::Step;
use catena_lobatto::tableau::dense::DenseWeights;
use catena_mechanism::description::joint::FreeRotation;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::state::{State, quaternion_exponential, quaternion_product};

/// The last step, as far as its inside is concerned.
#[derive(Clone)]
pub(crate) struct LastStep<'s> {
    /// Holds the displacements at the stages.
    pub kernel: &'s dyn Step,
    /// Number of stages after the first.
    pub inner: usize,
    /// The state at its start.
    pub origin: &'s State,
    /// The state at its end.
    pub end: &'s State,
    /// Its length (s).
    pub length: f64,
}

/// A polynomial at a point of a step.
#[derive(Clone)]
pub(crate) struct Interpolation<'s> {
    weights: DenseWeights,
    /// The weighted sums over the stages, for each degree of freedom.
    sums: &'s [[f64; 2]],
}

impl<'s> Interpolation<'s> {
    /// Sums the displacements of a step with these weights; `sums` is room for two numbers for each degree of freedom.
    pub fn new(step: &LastStep, weights: DenseWeights, sums: &'s mut [[f64; 2]]) -> Self {
        step.kernel.weigh_displacements(weights.of_stages(step.inner), sums);
        Interpolation { weights, sums }
    }

    /// Displacement and its derivative by x of a degree of freedom, from `h v` at both ends.
    fn apply(&self, freedom: usize, start: f64, end: f64) -> (f64, f64) {
        self.weights.apply(self.sums[freedom], start, end)
    }
}

impl LastStep<'_> {
    /// Calls `look` with each degree of freedom and the slopes `h v` of its displacement at both ends.
    pub fn for_each_freedom(&self, mechanism: &Mechanism, mut look: impl FnMut(usize, f64, f64)) {
        let (start_rates, end_rates) = (&self.origin.velocity, &self.end.velocity);
        for body in &mechanism.bodies {
            let joint = &body.joint;
            let ball = joint.kind.rotation() == FreeRotation::Ball;
            let first_of_ball = joint.velocity_index + joint.kind.velocity_count() - if ball { 3 } else { 0 };
            for freedom in joint.velocity_index..first_of_ball {
                look(freedom, self.length * start_rates[freedom], self.length * end_rates[freedom]);
            }
            if ball {
                for (axis, end) in self.end_slope_of_turn(first_of_ball).into_iter().enumerate() {
                    let freedom = first_of_ball + axis;
                    look(freedom, self.length * start_rates[freedom], self.length * end);
                }
            }
        }
    }

    /// The slope of the rotation vector of a ball joint at the end, by time, which belongs to the angular velocity there (rad/s).
    fn end_slope_of_turn(&self, first: usize) -> [f64; 3] {
        let last = [0, 1, 2].map(|axis| self.kernel.last_displacement(first + axis));
        inverse_tangent(&last, &[0, 1, 2].map(|axis| self.end.velocity[first + axis]))
    }

    /// Writes positions and velocities at a point of the step, from the polynomial `both` through stages and end velocities; freedoms marked by
    /// `alone` come from the polynomial through the stages alone. Does not allocate.
    pub fn sample(
        &self,
        mechanism: &Mechanism,
        both: &Interpolation,
        alone: Option<(&Interpolation, &[bool])>,
        position: &mut [f64],
        velocity: &mut [f64],
    ) {
        let apply = |freedom: usize, start: f64, end: f64| match alone {
            Some((stages, alone)) if alone[freedom] => stages.apply(freedom, start, end),
            _ => both.apply(freedom, start, end),
        };
        let (start_rates, end_rates) = (&self.origin.velocity, &self.end.velocity);
        position.copy_from_slice(&self.origin.position);
        for body in &mechanism.bodies {
            let joint = &body.joint;
            let ball = joint.kind.rotation() == FreeRotation::Ball;
            let scalars = joint.kind.velocity_count() - if ball { 3 } else { 0 };
            for offset in 0..scalars {
                let freedom = joint.velocity_index + offset;
                let (start, end) = (self.length * start_rates[freedom], self.length * end_rates[freedom]);
                let (displacement, slope) = apply(freedom, start, end);
                position[joint.position_index + offset] += displacement;
                velocity[freedom] = slope / self.length;
            }
            if ball {
                let first = joint.velocity_index + scalars;
                let mut turn = [0.0; 3];
                let mut rate = [0.0; 3];
                let end = self.end_slope_of_turn(first);
                for axis in 0..3 {
                    let ends = (self.length * start_rates[first + axis], self.length * end[axis]);
                    (turn[axis], rate[axis]) = apply(first + axis, ends.0, ends.1);
                }
                let slot = joint.position_index + scalars;
                let turned = quaternion_product(&self.origin.position[slot..slot + 4], &quaternion_exponential(&turn));
                position[slot..slot + 4].copy_from_slice(&turned);
                let spin = tangent(&turn, &rate);
                for axis in 0..3 {
                    velocity[first + axis] = spin[axis] / self.length;
                }
            }
        }
    }
}

/// Body-frame angular velocity of `exp(θ)` for the rate of θ: `(1 − k₁ θ̂ + k₂ θ̂²) θ̇`.
fn tangent(theta: &[f64; 3], rate: &[f64; 3]) -> [f64; 3] {
    let [theta, rate] = [theta, rate].map(Vector::<One>::splat);
    Tilt::of(theta).of_axis(rate).0.map(|entry| entry.lane(0))
}

/// The rate of θ for a body-frame angular velocity of `exp(θ)`: the inverse of [`tangent`].
fn inverse_tangent(theta: &[f64; 3], spin: &[f64; 3]) -> [f64; 3] {
    let (theta, spin) = (nalgebra::Vector3::from(*theta), nalgebra::Vector3::from(*spin));
    let angle = theta.norm();
    let factor = if angle < 1e-3 {
        1.0 / 12.0 + angle * angle / 720.0
    } else {
        (1.0 - 0.5 * angle / (0.5 * angle).tan()) / (angle * angle)
    };
    let once = theta.cross(&spin);
    (spin + 0.5 * once + factor * theta.cross(&once)).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spin_of_an_interpolated_ball_joint_is_right_to_rounding_at_any_angle() {
        for angle in [1e-9, 1.1e-4, 3e-4, 1e-2, 0.7, 2.0, 3.1] {
            // About z, with a rate of one along x: (1 − k₂ φ², −k₁ φ, 0).
            let spin = tangent(&[0.0, 0.0, angle], &[1.0, 0.0, 0.0]);
            let half: f64 = (0.5 * angle).sin();
            let sine: f64 = angle.sin();
            let expected = [sine / angle, -2.0 * half * half / angle, 0.0];
            for (own, expected) in spin.into_iter().zip(expected) {
                assert!((own - expected).abs() < 4e-16, "{angle} rad: {spin:?}, not {expected:?}");
            }
            // And back.
            for (own, expected) in inverse_tangent(&[0.0, 0.0, angle], &spin).into_iter().zip([1.0, 0.0, 0.0]) {
                assert!((own - expected).abs() < 3e-15, "{angle} rad, back: {own}");
            }
        }
    }
}
