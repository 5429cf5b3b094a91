//! Rolling and spinning friction of a closed contact at all stages: moments that brake a turning, and equations that hold it.
//!
//! The turning is `ω = ω_b − ω_a` [rad/s], with its parts `ω_n` along the normal n and `ω_T` across it, at the columns' (i) and the rows' (k) stages:
//!
//! ```text
//!     brakes        the multiplier of the gap pushes with the torque −(ρ t_k + σ s n_k) on b        t = ± ω_T/|ω_T|,  s = ± 1
//!     holds         h Σ_j a_ij e_j · ω_j = 0,  e of both tangents or n              gradient and push: the torque e on b
//!     as it turns   R_k = ρ λ_k / h |t_k · ω_k|   of torques along n × t     in the matrix alone, as of slips
//!     change        δ(e · ω) = e · η̇ + η_b · (ω_b × e) − η_a · (ω_a × e)           for turns η of the bodies
//!     dissipated    h Σ_k b_k Λ_k (ρ t_k · ω_k + σ s n_k · ω_k)   [J]
//! ```
//!
//! The direction t keeps the sign of its turning at the start of the step and follows it ([`crate::equations::braking`]), and s is the sign there, so
//! that a step which goes on beyond the end of a turning stays smooth. Moments that brake take the angular velocities of slips, equations those of the
//! scheme ([`crate::equations::slips`]).
//!
//! Source: [`catena_mechanism::description::contact`].

use crate::equations::braking::{Braking, Lean, Slipping};
use crate::equations::slips::StageMixing;
use crate::numbers::algebra::Vector;
use crate::numbers::euclidean::Euclidean;
use crate::numbers::lanes::Lanes;
use catena_mechanism::description::contact::{Moment, Moments};
use nalgebra::Vector3;

/// A turning below this part of the angular velocities of the bodies is rounding.
const NO_TURNING: f64 = 1e-9;
/// So is one below this [rad/s].
const NO_SPIN: f64 = 1e-12;

/// The moments of friction of a contact in a step.
#[derive(Clone)]
pub(crate) struct FrictionMoments<V> {
    moments: Moments,
    /// ρ t.
    rolling: Braking<V>,
    /// σ s.
    spinning: f64,
    /// The normal and ω at the columns' and the rows' stages, of rates for slips.
    turning: [Slipping<V>; 2],
    /// Of the directions that are held, `h Σ_j a_ij e_j · ω_j` (rad), with their changes for turns of a and of b, and the directions.
    held: Vec<HeldTurn<V>>,
}

/// One direction in which a turning is held.
#[derive(Clone, Copy)]
struct HeldTurn<V> {
    creep: V,
    change: [[V; 6]; 2],
    /// At the columns' and the rows' stages.
    along: [Vector<V>; 2],
}

impl<V: Lanes> FrictionMoments<V> {
    /// The moments, under gravity of this size [m/s²]; `None` if there are none.
    pub fn new(moments: Moments, gravity: f64) -> Option<Box<Self>> {
        if moments == Moments::default() {
            return None;
        }
        let zero = Vector::zero();
        let length = match moments.rolling {
            Moment::Brakes { length, .. } => length,
            _ => 0.0,
        };
        let nothing = HeldTurn { creep: V::zero(), change: [[V::zero(); 6]; 2], along: [zero; 2] };
        Some(Box::new(FrictionMoments {
            moments,
            rolling: Braking::new(length, gravity),
            spinning: 0.0,
            turning: [Slipping { normal: zero, slip: zero }; 2],
            held: vec![nothing; moments.rows()],
        }))
    }

    /// The kinds of rates that they take: of the scheme, and of slips.
    pub fn kinds_of_rates(&self) -> [bool; 2] {
        [self.moments.rows() > 0, self.brake()]
    }

    /// Whether they brake.
    pub fn brake(&self) -> bool {
        self.moments.brake()
    }

    /// Takes the normal and the angular velocities of a and b at the start of a step [rad/s].
    pub fn begin(&mut self, normal: &Vector3<f64>, spins: [Vector3<f64>; 2]) {
        let turning = spins[1] - spins[0];
        let (spin, fastest) = (normal.dot(&turning), spins[0].norm() + spins[1].norm());
        if let Moment::Brakes { direction, .. } = self.moments.rolling {
            self.rolling.begin(&(turning - normal * spin), fastest, direction);
        }
        if let Moment::Brakes { length, direction } = self.moments.spinning {
            let rests = spin.abs() <= (NO_TURNING * fastest).max(NO_SPIN);
            self.spinning = length * if rests { normal.dot(&direction) } else { spin }.signum();
        }
    }

    /// Takes the directions of the held turnings at one configuration: both tangents, and the normal. A step finds them at its stages
    /// ([`FrictionMoments::follow`]).
    pub fn hold(&mut self, normals: [Vector<V>; 2], tangents: [[Vector<V>; 2]; 2]) {
        let across = self.across_rows();
        for (index, held) in self.held.iter_mut().enumerate() {
            held.along = if index < across { tangents[index] } else { normals };
        }
    }

    /// Number of the held turnings across the normal, which come first.
    fn across_rows(&self) -> usize {
        if self.moments.rolling == Moment::Holds { 2 } else { 0 }
    }

    /// Finds them in a step of this length (s), for the normals and both tangents at the columns' and the rows' stages, and the angular velocities of a
    /// and b there: of the scheme, and of slips.
    #[inline(always)]
    pub fn follow(
        &mut self,
        mixing: &StageMixing<V>,
        step: f64,
        normals: [Vector<V>; 2],
        tangents: [[Vector<V>; 2]; 2],
        spins: [[[Vector<V>; 2]; 2]; 2],
    ) {
        let [scheme, slips] = spins;
        if self.brake() {
            for side in 0..2 {
                let [a, b] = slips[side];
                self.turning[side] = Slipping { normal: normals[side], slip: b.minus(a) };
                if matches!(self.moments.rolling, Moment::Brakes { .. }) {
                    self.rolling.follow(side, self.turning[side], mixing.active);
                }
            }
        }
        self.hold(normals, tangents);
        for held in &mut self.held {
            let rate = [0, 1].map(|side: usize| held.along[side].dot(scheme[side][1].minus(scheme[side][0])));
            held.creep = mixing.integrate(rate) * V::splat(step);
            let [of_a, of_b] = scheme[0].map(|spin| spin.cross(held.along[0]));
            let zero = Vector::zero();
            held.change = [zero.joined(zero.minus(of_a)), zero.joined(of_b)];
        }
    }

    /// The torque on b that a multiplier of the gap pushes with at the rows' stages (m).
    #[inline(always)]
    pub fn of_rows(&self) -> Vector<V> {
        let spinning = self.turning[1].normal.times(V::splat(-self.spinning));
        match self.moments.rolling {
            Moment::Brakes { .. } => spinning.minus(self.rolling.of_rows()),
            _ => spinning,
        }
    }

    /// The changes of the rates of the held turnings, for twists of a and of b.
    pub fn changes(&self) -> impl Iterator<Item = [[V; 6]; 2]> {
        self.held.iter().map(|held| held.change)
    }

    /// Writes the creeps and the gradients and pushes of the held turnings.
    #[inline(always)]
    pub fn write(&self, gaps: &mut [V], gradients: &mut [[[V; 6]; 2]]) {
        for (held, (gap, gradient)) in self.held.iter().zip(gaps.iter_mut().zip(gradients)) {
            *gap = held.creep;
            *gradient = held.along.map(|along| Vector::zero().joined(along));
        }
    }

    /// Whether rolling friction brakes.
    pub fn brakes_rolling(&self) -> bool {
        self.moments.brakes_rolling()
    }

    /// The torque across the rolling, `n × t`, at the columns' and the rows' stages.
    #[inline(always)]
    pub fn across(&self) -> [[V; 6]; 2] {
        [0, 1].map(|side: usize| {
            let across = self.turning[side].normal.cross(self.rolling.directions()[side]);
            Vector::zero().joined(across)
        })
    }

    /// How rolling friction resists that the rolling turns, and where it lags behind, for the multiplier of the gap ([`Braking::turning`]).
    pub fn turning_friction(&self, step: f64, multiplier: V) -> [V; 2] {
        self.rolling.turning(self.turning[1], step, multiplier)
    }

    /// Counts an iteration; whether the direction of the rolling lagged behind in it.
    pub fn iterated(&mut self) -> bool {
        self.brakes_rolling() && self.rolling.iterated()
    }

    /// Adds them to the friction at the end of the step.
    pub fn lean(&self, mixing: &StageMixing<V>, lean: &mut Lean) {
        if !self.brake() {
            return;
        }
        let [columns, _] = self.turning;
        let end = |vector: Vector<V>| {
            Vector3::from(vector.0.map(|component| component.to_array().as_ref()[mixing.active - 1]))
        };
        let (normal, turning) = (end(columns.normal), end(columns.slip));
        let mut torque = normal * self.spinning;
        lean.slip += torque.dot(&turning);
        if matches!(self.moments.rolling, Moment::Brakes { .. }) {
            let Lean { along, slip, .. } = self.rolling.lean(mixing, self.turning, Vector::zero());
            torque += Vector3::from(along);
            lean.slip += slip;
        }
        lean.torque = torque.into();
    }

    /// `Σ_k b_k λ_k (ρ t_k · ω_k + σ s n_k · ω_k)` over the rows, for the multipliers of the gap.
    #[inline(always)]
    pub fn dissipated(&self, mixing: &StageMixing<V>, multiplier: V) -> f64 {
        if !self.brake() {
            return 0.0;
        }
        let torque = Vector::zero().minus(self.of_rows());
        (multiplier * mixing.weights * torque.dot(self.turning[1].slip)).sum()
    }
}
