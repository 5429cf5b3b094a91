//! The nonsmooth elements of a mechanism: limits of joints and their impacts, dry friction, and motors whose effort is bounded or sampled.
//!
//! All of it is constant data; the state of each element at an instant belongs to the run. Limits are [`JointLimit`]s of
//! [`crate::description::closure`], because the assembly of closed loops respects them, too.

use crate::description::closure::{Attachment, Coordinate, JointLimit};
use crate::description::contact::Collider;
use crate::description::contact_pairs::{ContactPairs, PairRun};
use crate::description::target::Target;

/// Dry (Coulomb) friction along one scalar joint coordinate: the effort `τ` on the child is
/// `−effort · sign(q̇)` while it slides, and whatever holds it, up to `|τ| ≤ effort`, while it sticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DryFriction {
    /// The coordinate.
    pub coordinate: Coordinate,
    /// N m or N, greater than zero.
    pub effort: f64,
}

/// How a motor follows its target `r(t)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotorLaw {
    /// `τ = kp (r − q) + kd (ṙ − q̇)`.
    Position {
        /// N m/rad or N/m, not negative.
        kp: f64,
        /// N m s/rad or N s/m, not negative.
        kd: f64,
    },
    /// `τ = kd (r − q̇)`.
    Velocity {
        /// N m s/rad or N s/m, not negative.
        kd: f64,
    },
    /// `τ = r`.
    Effort,
}

/// A motor in a joint of one degree of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct Motor {
    /// The coordinate that it drives.
    pub coordinate: Coordinate,
    /// The law of the motor.
    pub law: MotorLaw,
    /// Its target: rad or m, rad/s or m/s, N m or N.
    pub target: Target,
    /// Its effort is never larger [N m or N]; infinite where it has no bound.
    pub max_effort: f64,
    /// Time between two computations of its effort (s), which is held in between; zero: at every instant.
    pub period: f64,
    /// What it holds where a run goes on between two of its ticks.
    pub held: Option<HeldEffort>,
}

/// The effort that a sampled motor holds from a tick before the start of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldEffort {
    /// The start of the run (s).
    pub since: f64,
    /// N m or N.
    pub effort: f64,
}

/// An instant that is off a tick by less than this part of the period is the tick.
const ON_TICK: f64 = 1e-9;

impl MotorLaw {
    /// Stiffness `kp` and damping `kd` of its effort.
    pub fn gains(&self) -> (f64, f64) {
        match *self {
            MotorLaw::Position { kp, kd } => (kp, kd),
            MotorLaw::Velocity { kd } => (0.0, kd),
            MotorLaw::Effort => (0.0, 0.0),
        }
    }
}

impl Motor {
    /// The part of its unbounded effort that depends on time alone, as if the coordinate were at rest at zero [N m or N], with the target
    /// of the piece that begins at or before `since` (s).
    pub fn drive(&self, since: f64, time: f64) -> f64 {
        let (value, rate) = self.target.piece(since, time);
        match self.law {
            MotorLaw::Position { kp, kd } => kp * value + kd * rate,
            MotorLaw::Velocity { kd } => kd * value,
            MotorLaw::Effort => value,
        }
    }

    /// Its effort without bound at an instant [N m or N], with that piece of the target.
    pub fn unbounded(&self, since: f64, time: f64, position: f64, rate: f64) -> f64 {
        let (value, slope) = self.target.piece(since, time);
        match self.law {
            MotorLaw::Position { kp, kd } => kp * (value - position) + kd * (slope - rate),
            MotorLaw::Velocity { kd } => kd * (value - rate),
            MotorLaw::Effort => value,
        }
    }

    /// Its effort at an instant [N m or N]: what it holds from the run before, or else what is worked out there.
    pub fn effort(&self, time: f64, position: f64, rate: f64) -> f64 {
        self.held_at(time).unwrap_or_else(|| self.bounded(self.unbounded(time, time, position, rate)))
    }

    /// The effort that it holds from the run before at an instant of this one [N m or N]: until the first tick.
    pub fn held_at(&self, time: f64) -> Option<f64> {
        let held = self.held.filter(|held| self.period > 0.0 && time >= held.since)?;
        let rest = self.next_instant(held.since) - time;
        (rest > ON_TICK * self.period).then(|| self.bounded(held.effort))
    }

    /// Whether it is sampled, and this is no instant of a tick (s).
    pub fn is_between_ticks(&self, time: f64) -> bool {
        self.period > 0.0 && time - (self.next_instant(time) - self.period) > ON_TICK * self.period
    }

    /// An effort within its bound [N m or N].
    pub fn bounded(&self, effort: f64) -> f64 {
        effort.min(self.max_effort).max(-self.max_effort)
    }

    /// Whether it is sampled in a step between two times (s) that ends at its next tick at the latest.
    pub fn ticks(&self, from: f64, to: f64) -> bool {
        self.period > 0.0 && self.next_instant(from) <= to
    }

    /// The next instant after `time` at which its effort may change its law: a tick, or a given instant of its target (s).
    pub fn next_instant(&self, time: f64) -> f64 {
        let tick = if self.period > 0.0 {
            (time / self.period + ON_TICK).floor().mul_add(self.period, self.period)
        } else {
            f64::INFINITY
        };
        // A held effort sees its target at the ticks alone.
        if self.period > 0.0 { tick } else { self.target.next_knot(time) }
    }
}

/// The largest speed that the description of a joint names: watched, not enforced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLimit {
    /// The coordinate.
    pub coordinate: Coordinate,
    /// rad/s or m/s.
    pub speed: f64,
}

/// Everything nonsmooth of a mechanism besides its [`JointLimit`]s.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Nonsmooth {
    /// Limits that stop a motion: the simulated limits of the mechanism.
    pub limits: Vec<JointLimit>,
    /// Dry friction in joints.
    pub friction: Vec<DryFriction>,
    /// Motors, at most one a coordinate.
    pub motors: Vec<Motor>,
    /// Speeds to be watched.
    pub speeds: Vec<SpeedLimit>,
    /// Shapes that may touch.
    pub colliders: Vec<Collider>,
    /// Which of them may, and how.
    pub pairs: ContactPairs,
    /// The ropes among the colliders that go through more than two points.
    pub reevings: Vec<Reeving>,
}

/// The course of a rope through more than two points.
#[derive(Clone, Debug, PartialEq)]
pub struct Reeving {
    /// The collider that is the rope: the first of its pair.
    pub collider: usize,
    /// Its points in their order.
    pub points: Vec<Attachment>,
}

impl Nonsmooth {
    /// Whether the motion is smooth: the mechanism has no limits, friction, motors and pairs.
    pub fn is_empty(&self) -> bool {
        self.limits.is_empty() && self.friction.is_empty() && self.motors.is_empty() && self.pairs.is_empty()
    }

    /// Whether a motor is sampled.
    pub fn samples(&self) -> bool {
        self.motors.iter().any(|motor| motor.period > 0.0)
    }

    /// Keeps the colliders of the world and of bodies that have a new number, and their pairs.
    pub fn keep_bodies(&mut self, number: impl Fn(usize) -> Option<usize>) {
        let mut places = Vec::with_capacity(self.colliders.len());
        let mut kept = 0;
        self.colliders.retain_mut(|collider| {
            let stays = match collider.body {
                None => true,
                Some(body) => {
                    collider.body = number(body);
                    collider.body.is_some()
                }
            };
            places.push(stays.then_some(kept));
            kept += usize::from(stays);
            stays
        });
        let colliders = &self.colliders;
        let moves = |[a, b]: [usize; 2]| colliders[a].body.or(colliders[b].body).is_some();
        let same = places.iter().enumerate().all(|(number, place)| *place == Some(number));
        // Pairs that stay as they are stay shared with the copies of this.
        let all_move =
            |run: &PairRun| colliders[run.first.a].body.is_some() || run.pairs().all(|pair| moves([pair.a, pair.b]));
        if !(same && self.pairs.runs().iter().all(all_move)) {
            self.pairs.retain_mut(|pair| match (places[pair.a], places[pair.b]) {
                (Some(a), Some(b)) if moves([a, b]) => {
                    (pair.a, pair.b) = (a, b);
                    true
                }
                _ => false,
            });
        }
        self.reevings.retain_mut(|rope| {
            let Some(collider) = places[rope.collider] else { return false };
            rope.collider = collider;
            rope.points.iter_mut().all(|point| {
                let own = point.body.map(&number);
                point.body = own.flatten();
                own != Some(None)
            })
        });
    }
}
