//! The friction of a contact that slides, at all stages: its direction, and how it follows the slip from iterate to iterate.
//!
//! The slip velocity is u [m/s], the normal n, both at the columns' (i) and the rows' (k) stages; the force of the contact is N and its friction μ:
//!
//! ```text
//!     direction             t = ± u_T/|u_T|,    u_T = u − (n·u) n            the multiplier of a row pushes along n_k − μ t_k
//!     as the slip turns     R_k = μ λ_k / h |t_k · u_k|                       [kg], λ = h² Λ
//!     dissipated            h Σ_k b_k Λ_k μ t_k · u_k                         [J]
//! ```
//!
//! The sign of t is the sign of u_T along the direction at the stage before. So the friction of a step that goes on beyond the stop of a slip stays
//! smooth, and an event finds the stop as a zero of `u_T · t` with the direction at the start of the step. A slip that turns by a right angle and more
//! keeps its friction: along the direction at the start, the sign would be a rounding where a step ends on that zero. A step that starts without slip has
//! the direction that [`Grip::Slides`](catena_mechanism::description::contact::Grip::Slides) gives. The slip of its first stage would not do: it differs from zero by
//! the error of a stage, and its direction is arbitrary. The direction t follows such a slip from iterate to iterate by
//! [`crate::equations::turning`]. A slip below a thousandth of the largest of the step counts as one that stops. It has the direction of the stage
//! before, and at the end of the step the direction of the polynomial through the stages.
//!
//! Source: Coulomb's law in the forced scheme, L. O. Jay, SIAM J. Sci. Comput. 20 (1998).

use crate::equations::slips::StageMixing;
use crate::equations::turning::Followed;
use crate::numbers::algebra::Vector;
use crate::numbers::lanes::{Lanes, MAX_LANES};
use nalgebra::Vector3;

/// A slip of this part of the speeds at the point of contact is rounding.
const NO_SLIP: f64 = 1e-9;
/// So is a slip below this [m/s].
const NO_SPEED: f64 = 1e-12;

/// A slip that gravity makes in less than this (s) is slow: friction under a weight turns it sooner than steps end.
const SLOW: f64 = 1e-5;

/// A slip at a stage that is this part of the largest of the step stops there: its direction is mostly rounding, so it takes the direction of the
/// stage before.
const STOPS: f64 = 1e-3;

/// Friction of a contact at the end of a step: the multiplier pushes along `n − μ t`, with a torque of rolling and spinning friction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lean {
    /// `μ t` in the world.
    pub along: [f64; 3],
    /// `ρ t + σ s n` of the turning, in the world (m).
    pub torque: [f64; 3],
    /// `μ t · u` with the slip velocity u at the end of the step, and `(ρ t + σ s n) · ω`: the dissipation of an impulse [m/s].
    pub slip: f64,
    /// `μ t · w` with the velocity w of belts there: the work of their drives for an impulse [m/s].
    pub belt: f64,
}

/// The slip of a contact at the columns' or the rows' stages.
#[derive(Clone, Copy)]
pub(crate) struct Slipping<V> {
    /// n.
    pub normal: Vector<V>,
    /// u [m/s].
    pub slip: Vector<V>,
}

/// The friction of a contact in a step.
#[derive(Clone)]
pub(crate) struct Braking<V> {
    /// μ; zero if it does not slide.
    pub friction: f64,
    /// Acceleration of gravity [m/s²].
    gravity: f64,
    /// The direction of the slip at the start, or the given one if the contact does not slip yet.
    reference: Vector3<f64>,
    /// Whether there is no slip at the start, or a slow one.
    rests: bool,
    slow: bool,
    /// t at the columns' and the rows' stages.
    directions: [Vector<V>; 2],
    /// How t follows the slips, at the columns' and the rows' stages.
    followed: [[Followed; MAX_LANES]; 2],
    /// Iterations since the step began.
    iterations: usize,
    /// Number of stages coupled.
    active: usize,
}

impl<V: Lanes> Braking<V> {
    /// A contact with a coefficient of friction, under gravity of this size [m/s²].
    pub fn new(friction: f64, gravity: f64) -> Self {
        Braking {
            friction,
            gravity,
            reference: Vector3::zeros(),
            rests: false,
            slow: false,
            directions: [Vector::zero(); 2],
            followed: [[Followed::default(); MAX_LANES]; 2],
            iterations: 0,
            active: 0,
        }
    }

    /// Takes the slip at the start of a step, the speeds of both bodies at the point of contact added up [m/s], and the direction of a contact that
    /// does not slip yet.
    pub fn begin(&mut self, slip: &Vector3<f64>, speeds: f64, given: Vector3<f64>) {
        let speed = slip.norm();
        self.rests = speed <= (NO_SLIP * speeds).max(NO_SPEED);
        self.slow = self.rests || speed < SLOW * self.gravity;
        self.reference = if self.rests { given } else { slip / speed };
        self.iterations = 0;
    }

    /// Finds t at the columns' stages (0), or at the rows' (1), of which the last lane is the start.
    #[inline(always)]
    pub fn follow(&mut self, side: usize, at: Slipping<V>, active: usize) {
        self.active = active;
        let iterations = self.iterations;
        let Slipping { normal, slip } = at;
        let slip = normal.times_minus(normal.dot(slip), slip).0.map(|component| component.to_array());
        let normal = normal.0.map(|component| component.to_array());
        let mut direction = self.directions[side].0.map(|component| component.to_array());
        let of = |lane: usize| Vector3::from([0, 1, 2].map(|axis: usize| slip[axis].as_ref()[lane]));
        let largest = (0..active).map(|lane| of(lane).norm()).fold(0.0, f64::max);
        let mut before = self.reference;
        for lane in 0..active {
            let (slip, starts) = (of(lane), side == 1 && lane + 1 == active);
            let length = slip.norm();
            let followed = &mut self.followed[side][lane];
            followed.lags = self.slow && iterations == 0 && !starts;
            let along = if self.rests && starts || self.slow && iterations == 0 {
                self.reference
            } else if length <= STOPS * largest {
                if starts { self.reference } else { before }
            } else {
                let [normal, latest] = [&normal, &direction]
                    .map(|lanes| Vector3::from([0, 1, 2].map(|axis: usize| lanes[axis].as_ref()[lane])));
                let turned = if self.slow { followed.turn(iterations, &latest, &normal, &slip) } else { None };
                let since = if starts { self.reference } else { before };
                turned.unwrap_or_else(|| slip / if slip.dot(&since) < 0.0 { -length } else { length })
            };
            followed.speed = along.dot(&slip);
            before = along;
            for (component, lanes) in direction.iter_mut().enumerate() {
                lanes.as_mut()[lane] = along[component];
            }
        }
        self.directions[side] = Vector(direction.map(V::from_array));
    }

    /// t at the columns' and the rows' stages.
    #[inline(always)]
    pub fn directions(&self) -> [Vector<V>; 2] {
        self.directions
    }

    /// `μ t` of the rows.
    #[inline(always)]
    pub fn of_rows(&self) -> Vector<V> {
        self.directions[1].times(V::splat(self.friction))
    }

    /// `R = μ λ / h |t · u|` of the rows: the resistance of friction to the turning of the slip, zero for a multiplier that pulls; and, if t lags
    /// behind the slip, `R h (n × t) · u`.
    pub fn turning(&self, rows: Slipping<V>, step: f64, multiplier: V) -> [V; 2] {
        let Slipping { normal, slip } = rows;
        let speed = self.directions[1].dot(slip);
        let across = normal.cross(self.directions[1]).dot(slip).to_array();
        let (multiplier, speed) = (multiplier.to_array(), speed.to_array());
        let (mut friction, mut behind) = (V::zero_array(), V::zero_array());
        let largest = speed.as_ref()[..self.active].iter().fold(NO_SPEED, |most, speed| most.max(speed.abs()));
        for (lane, (friction, behind)) in friction.as_mut().iter_mut().zip(behind.as_mut()).enumerate() {
            let (multiplier, speed) = (multiplier.as_ref()[lane], speed.as_ref()[lane].abs());
            if multiplier > 0.0 && speed > STOPS * largest && !(self.rests && lane + 1 == self.active) {
                *friction = self.friction * multiplier / (step * speed);
                if self.followed[1][lane].lags {
                    *behind = *friction * step * across.as_ref()[lane];
                }
            }
        }
        [friction, behind].map(V::from_array)
    }

    /// Counts an iteration; whether t lagged behind the slips in it.
    pub fn iterated(&mut self) -> bool {
        self.iterations += 1;
        self.followed.iter().flat_map(|lanes| &lanes[..self.active]).any(|followed| followed.lags)
    }

    /// The largest speed of the slip at the rows' stages [m/s].
    pub fn fastest(&self, rows: Slipping<V>) -> f64 {
        let speed = self.directions[1].dot(rows.slip).to_array();
        speed.as_ref()[..self.active].iter().fold(0.0, |most, speed| most.max(speed.abs()))
    }

    /// Its friction at the end of the step, from the slips at the columns' and the rows' stages, and the velocity of belts at the columns' [m/s].
    pub fn lean(&self, mixing: &StageMixing<V>, [columns, rows]: [Slipping<V>; 2], belt: Vector<V>) -> Lean {
        let lane = |vector: Vector<V>, lane: usize| {
            Vector3::from(vector.0.map(|component| component.to_array().as_ref()[lane]))
        };
        let slip = lane(columns.slip, self.active - 1);
        let largest = (0..self.active).map(|row| lane(rows.slip, row).norm()).fold(0.0, f64::max);
        let direction = if slip.norm() > STOPS * largest {
            lane(self.directions[0], self.active - 1)
        } else {
            let ahead = self.directions[1].0.map(|component| (component * mixing.ahead).sum());
            Vector3::from(ahead).try_normalize(0.5).unwrap_or(self.reference)
        };
        let along = direction * self.friction;
        let belt = along.dot(&lane(belt, self.active - 1));
        Lean { along: along.into(), torque: [0.0; 3], slip: along.dot(&slip), belt }
    }

    /// `Σ_k b_k λ_k μ t_k · u_k` over the rows, for the multipliers of the gap.
    #[inline(always)]
    pub fn dissipated(&self, rows: Slipping<V>, mixing: &StageMixing<V>, multiplier: V) -> f64 {
        (multiplier * mixing.weights * self.of_rows().dot(rows.slip)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vectors::portable::Portable;

    type V = Portable<4>;

    /// The directions at three stages after a start with the slip e_x, for slips in the plane [m/s].
    fn directions(slips: [[f64; 2]; 3]) -> [[f64; 2]; 3] {
        let mut braking = Braking::<V>::new(0.3, 9.81);
        braking.begin(&Vector3::x(), 1.0, Vector3::zeros());
        let component = |axis: usize| V::from_slice(&slips.map(|slip| slip[axis]));
        let normal = Vector([V::zero(), V::zero(), V::splat(1.0)]);
        let slip = Vector([component(0), component(1), V::zero()]);
        braking.follow(0, Slipping { normal, slip }, 3);
        let [x, y, _] = braking.directions()[0].0.map(|component| component.to_array());
        [0, 1, 2].map(|lane| [x.as_ref()[lane], y.as_ref()[lane]])
    }

    #[test]
    fn a_slip_that_turns_by_a_right_angle_or_more_keeps_the_direction_of_its_friction() {
        for last in [[1e-17, 1.0], [-1e-17, 1.0], [-0.6, 0.8]] {
            let turned = directions([[0.8, 0.6], [0.6, 0.8], last]);
            assert_eq!(turned[2], last.map(|part| part / last[0].hypot(last[1])));
        }
    }

    #[test]
    fn friction_goes_on_as_before_beyond_the_stop_of_a_slip() {
        let stopped = directions([[0.5, 0.0], [-0.1, 0.0], [-0.4, 0.0]]);
        assert_eq!(stopped.map(|along| along[0]), [1.0; 3]);
    }
}
