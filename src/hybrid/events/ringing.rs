//! Sign changes that are no events: rates and efforts ring where hard dampers hold joints.
//!
//! ```text
//!     c Y h > 40:    the scheme keeps the transient of a joint that moves as an oscillation
//!     S = {moving joints with hard dampers} ∪ {held joints}
//!     D f = −a_S,    q̇_s = q̇ − f / c                     the transient is over, and S does not accelerate
//!     D g = q̈_s − a_S,    q̇_t = q̇ − g / c,    λ_t = g    and a slow motion goes on, q̈_s = dq̇_s/dt
//! ```
//!
//! c is the damping of a joint by its own damper and motors [N m s/rad], Y its mobility [1/(kg m²)], h the length of the step (s), a the accelerations
//! under all efforts except at held joints, and D = W Y Wᵀ the mobility of S. q̇_t are the rates and λ_t the efforts of held joints [N m] without the
//! transient. The bound of c Y h is 2 s (s − 1) for s = 5 stages ([`crate::stepping::watching::watch`]). A joint whose q̇_t goes on, or whose λ_t holds it,
//! from there to the end of the step, has no event where q̇ or λ are zero: it would stop and slip, or part from its limit and meet it, in step after step.
//! f changes its sign within the step where rates ring, and keeps it where a slow motion lags behind. The first step of a mode may have a transient of the
//! motion: a damper that gets a blow of 100 N lets friction slip. Trees without contacts are looked at.

use crate::events::finding::watched::Watched;
use crate::events::integrator::Eventful;
use crate::events::modes::instants::Inside;
use crate::events::modes::mode::{JointMode, MotorMode};
use crate::instant::dynamics::dampings::dampings;
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::inputs::Inputs;
use nalgebra::{Cholesky, DVector, Dyn};

/// Steps over the time constant of a hard damper.
const HARD: f64 = 40.0;

/// Instants of a step at which it is looked for what rings.
const SAMPLES: usize = 9;

/// A freedom that moves against a hard damper, with c, or one that is held.
struct Member {
    freedom: usize,
    damping: Option<f64>,
}

/// The motion of members once the transient is over.
struct Settled {
    /// q̇_s, zero of held members [rad/s, m/s].
    rates: DVector<f64>,
    /// f [N m or N].
    forces: DVector<f64>,
    /// D, factorised.
    mobility: Cholesky<f64, Dyn>,
}

impl Eventful {
    /// Whether a function whose sign changes at a time (s) in a step from `since` only rings there.
    pub(super) fn rings(&mut self, inputs: Inputs, since: f64, time: f64, number: usize) -> bool {
        let watched = self.trial.watched[number];
        let (Watched::Slide(index) | Watched::Bears(index, _)) = watched else { return false };
        let whole = &self.model.whole;
        if !(whole.loops.is_empty() && whole.mimics.is_empty() && self.mode.contacts.is_empty()) {
            return false;
        }
        let length = self.workspaces.active().small.time - since;
        let members = self.members(time, length);
        let joint = &self.model.elements.joints[index];
        let (own, (low, high)) = (joint.coordinate.freedom, self.mode.joints[index].holding(joint));
        let mode = self.mode.joints[index];
        let Some(place) = members.iter().position(|member| member.freedom == own) else { return false };
        let spacing = length / (SAMPLES - 1) as f64;
        let samples: Option<Vec<Settled>> =
            (0..SAMPLES).map(|sample| self.settled(inputs, since, since + spacing * sample as f64, &members)).collect();
        let (Some(samples), Some(there)) = (samples, self.settled(inputs, since, time, &members)) else {
            return false;
        };
        if since == self.progress.entered && self.begins_with_a_transient(&members, &samples[0].forces) {
            return false;
        }
        // Whether it goes on, between or beside these two samples.
        let goes_on = |Settled { rates, forces, mobility }: &Settled, [before, after]: [usize; 2]| {
            let apart = spacing * (after - before) as f64;
            let slow = mobility.solve(&((&samples[after].rates - &samples[before].rates) / apart));
            match (watched, mode, members[place].damping) {
                (Watched::Slide(_), JointMode::Free { sliding }, Some(damping)) => {
                    f64::from(sliding) * (rates[place] - slow[place] / damping) > 0.0
                }
                (Watched::Bears(_, Side::Lower), _, None) => forces[place] + slow[place] > low,
                (Watched::Bears(_, Side::Upper), _, None) => forces[place] + slow[place] < high,
                _ => false,
            }
        };
        let next = (((time - since) / spacing) as usize + 1).min(SAMPLES - 1);
        let goes_on = goes_on(&there, [next - 1, next])
            && (next..SAMPLES).all(|sample| goes_on(&samples[sample], [sample - 1, (sample + 1).min(SAMPLES - 1)]));
        // A slow motion lags behind its settled rates with one sign.
        let mut damped = (0..members.len()).filter(|&member| members[member].damping.is_some());
        let turns = |member| samples.iter().any(|sample| sample.forces[member] * there.forces[member] < 0.0);
        goes_on && damped.any(turns)
    }

    /// Whether a mode begins with a transient of the motion itself, by f there: the rates differ from the slow motion by more than the tolerance in a
    /// second. Steps of a tolerance become short enough for it.
    fn begins_with_a_transient(&self, members: &[Member], forces: &DVector<f64>) -> bool {
        let Some(tolerance) = self.model.recipe.tolerance() else { return false };
        let exceeds = |damping: f64, force: f64| force.abs() > tolerance * damping;
        let mut pairs = members.iter().zip(forces.iter());
        pairs.any(|(member, force)| member.damping.is_some_and(|damping| exceeds(damping, *force)))
    }

    /// S at a time (s) in a step of this length (s); empty if no damper is hard.
    fn members(&mut self, time: f64, length: f64) -> Vec<Member> {
        let motors = self.model.elements.motors.iter().zip(&self.mode.motors);
        let motors = motors.filter(|(_, mode)| **mode == MotorMode::Unbounded).map(|(motor, _)| motor);
        let dampings = dampings(&self.model.whole, motors);
        if dampings.is_empty() {
            return Vec::new();
        }
        self.go_to(Inside::at(time));
        let held = self.model.elements.joints.iter().zip(&self.mode.joints);
        let held = held.filter(|(_, mode)| matches!(mode, JointMode::Held { .. }));
        let held: Vec<usize> = held.map(|(joint, _)| joint.coordinate.freedom).collect();
        let freedoms = dampings.iter().map(|(freedom, _)| *freedom);
        let mobilities = self.workspaces.response.diagonal(&self.trial.sample, freedoms);
        let hard = dampings
            .into_iter()
            .zip(mobilities)
            .filter(|((freedom, damping), mobility)| damping * mobility * length > HARD && !held.contains(freedom));
        let mut members: Vec<Member> =
            hard.map(|((freedom, damping), _)| Member { freedom, damping: Some(damping) }).collect();
        if !members.is_empty() {
            members.extend(held.into_iter().map(|freedom| Member { freedom, damping: None }));
        }
        members
    }

    /// The motion of these members at a time (s) in a step from `since` once the transient is over; `None` without members, or if D is singular.
    fn settled(&mut self, inputs: Inputs, since: f64, time: f64, members: &[Member]) -> Option<Settled> {
        if members.is_empty() {
            return None;
        }
        self.go_to(Inside::at(time));
        let (state, response) = (&self.trial.sample, &mut self.workspaces.response);
        let mut efforts = vec![0.0; state.velocity.len()];
        self.mode.efforts_at(&self.model.elements, inputs, since, state, &mut efforts);
        let mut accelerations = vec![0.0; efforts.len()];
        response.accelerations(state, &efforts, &mut accelerations);
        let freedoms: Vec<usize> = members.iter().map(|member| member.freedom).collect();
        let (_, square) = response.matrix(state, &freedoms);
        let wanted = DVector::from_iterator(freedoms.len(), freedoms.iter().map(|&freedom| -accelerations[freedom]));
        let mobility = square.cholesky()?;
        let forces = mobility.solve(&wanted);
        let rates = members.iter().zip(forces.iter()).map(|(member, force)| {
            member.damping.map_or(0.0, |damping| state.velocity[member.freedom] - force / damping)
        });
        Some(Settled { rates: DVector::from_iterator(members.len(), rates), forces, mobility })
    }
}
