//! Starts at which the derivatives of a run hold on one side alone, or on none.
//!
//! Dry friction turns with the sign of a rate. A joint or contact that starts to slide in the direction σ, at the rate r, goes another way if a parameter
//! turns it:
//!
//! ```text
//!     |δθ| = |r| / |∂r/∂θ|             at rest, r = 0: δθ σ ∂r/∂θ > 0 alone
//!     v = σ a t + δ (F − μ)/(F + μ)    of a joint that a force F pulls, thrown against its way by δ; thrown along it v = σ a t + δ
//! ```
//!
//! A contact at rest that a parameter also turns aside has a derivative on no side.

use crate::derivatives::equations::closed::ClosedContacts;
use crate::derivatives::equations::closed::across;
use crate::derivatives::equations::residual::still;
use crate::derivatives::events::instant::Instant;
use crate::derivatives::events::walk::Walk;
use crate::derivatives::forward::step::{Part, WIDTH};
use crate::derivatives::forward::tangent::with;
use crate::derivatives::numbers::number::Number;
use crate::events::trace::{JointMode, TracedStep};
use crate::instant::holding::elements::ElementJoint;
use crate::mechanism::motion::event::Side;
use nalgebra::Vector3;

/// A start this close to a limit is on it (rad or m): assembly leaves as much. Smaller derivatives of rates are none.
const ON_LIMIT: f64 = 1e-9;
/// A start this slow is at rest [rad/s or m/s].
const AT_REST: f64 = 1e-12;
/// A contact is turned aside by this part of a derivative.
const ASIDE: f64 = 1e-6;

impl Walk<'_> {
    /// Notes limits that the start is on, if it leaves them with a parameter: such a start is put back on one side, and on the other it is not. And
    /// joints that friction holds from the start on, if they begin to move with a parameter, or that it brakes, if they go another way with one.
    pub(super) fn see_start(&mut self, traced: &TracedStep) {
        let (mechanism, elements) = (self.subject.mechanism, self.subject.elements);
        for (body, _) in mechanism.bodies.iter().zip(&traced.held).filter(|(_, held)| **held) {
            let what = format!("joint {:?} starts at rest and is held", body.joint.name);
            for column in 0..self.tangent.times.len() {
                let rates = self.tangent.velocities.column(column);
                if rates.rows_range(body.joint.velocity_range()).amax() > ON_LIMIT {
                    self.validity.none(column, &what);
                }
            }
        }
        for (index, joint) in elements.joints.iter().enumerate().filter(|(_, joint)| !joint.is_locked()) {
            for side in joint.sides().filter(|&side| joint.gap(side, joint.position(&self.state)).abs() <= ON_LIMIT) {
                let slopes = self.varied.slopes();
                let bound = |column: usize| {
                    let laws = slopes[column].as_ref().map(|slopes| &slopes.laws.joints[index]);
                    laws.map_or(0.0, |laws| if side == Side::Lower { laws.lower } else { laws.upper })
                };
                let row = joint.coordinate.freedom;
                let leaves = (0..slopes.len()).filter(|&column| {
                    let off = self.tangent.positions[(row, column)] - bound(column);
                    off.abs() > ON_LIMIT
                });
                let what = format!("joint {:?} starts on its limit", mechanism.bodies[joint.owner(side)].joint.name);
                leaves.collect::<Vec<usize>>().into_iter().for_each(|column| self.validity.none(column, &what));
            }
        }
        self.see_braked_joints(traced);
        self.see_braked_contacts(traced);
    }

    fn see_braked_joints(&mut self, traced: &TracedStep) {
        let elements = self.subject.elements;
        let braked = |(joint, mode): (&'_ ElementJoint, &JointMode)| match mode {
            JointMode::Free { sliding } if joint.friction > 0.0 && *sliding != 0 => Some(f64::from(*sliding)),
            _ => None,
        };
        for pair in elements.joints.iter().zip(&traced.mode.joints) {
            let (joint, Some(way)) = (pair.0, braked(pair)) else { continue };
            let rate = joint.rate(&self.state).abs();
            let name = self.subject.mechanism.joint_of_freedom(joint.coordinate.freedom).to_string();
            for column in 0..self.tangent.times.len() {
                let by = way * self.tangent.velocities[(joint.coordinate.freedom, column)];
                self.see_braked(column, rate, Some(by), by.abs(), &format!("joint {name:?}"));
            }
        }
    }

    fn see_braked_contacts(&mut self, traced: &TracedStep) {
        let n = self.state.velocity.len();
        let none = ClosedContacts::default();
        let mut seen: Vec<(usize, f64, Option<f64>, f64, String)> = Vec::new();
        for (chunk, figures) in self.varied.chunks().iter().enumerate() {
            let first = chunk * WIDTH;
            let offsets: Vec<Part> = (0..n).map(|row| with(0.0, &self.tangent.positions, row, first)).collect();
            let velocities = (0..n).map(|row| with(self.state.velocity[row], &self.tangent.velocities, row, first));
            let velocities: Vec<Part> = velocities.collect();
            let at = Instant { figures, state: &self.state, offsets: &offsets, closed: &none };
            let moves = at.placed(&velocities);
            let bodies = still(&moves);
            for closed in &traced.mode.contacts {
                let pair = closed.contact.pair;
                let (Some(way), Some(touch)) = (closed.slides, self.touch(&closed.contact, &figures.laws)) else {
                    continue;
                };
                if figures.laws.pairs[pair].friction.value() <= 0.0 {
                    continue;
                }
                let found = touch.at(&bodies);
                let slip = across(found.normal, touch.slip(&moves, found.point));
                let speed = Vector3::from(slip.0.map(Number::value)).norm();
                let what = format!("the contact {}", self.names("on", pair));
                for part in 0..WIDTH.min(self.tangent.times.len() - first) {
                    let by = Vector3::from(slip.0.map(|entry| entry.parts[part]));
                    let along = by.dot(&way);
                    let aside = (by - way * along).norm() > ASIDE * by.norm();
                    seen.push((first + part, speed, Some(along).filter(|_| !aside), by.norm(), what.clone()));
                }
            }
        }
        for (column, rate, along, size, what) in seen {
            self.see_braked(column, rate, along, size, &what);
        }
    }

    /// Something that starts to slide at a rate, whose change with a parameter has this part along its way, if it is along it, and this size.
    fn see_braked(&mut self, column: usize, rate: f64, along: Option<f64>, size: f64, what: &str) {
        if size <= ON_LIMIT {
            return;
        }
        if rate > AT_REST {
            let cause = format!("{what} starts to slide another way");
            return self.validity.within_of(column, rate / size, &cause);
        }
        let side = match along {
            Some(along) if along > 0.0 => "for a larger value alone",
            Some(_) => "for a smaller value alone",
            None => "on no side, because the slip turns",
        };
        self.validity.none(column, &format!("{what} starts to slide from rest: the derivative holds {side}"));
    }
}
