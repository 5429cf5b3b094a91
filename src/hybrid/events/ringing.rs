//! Sign changes that are no events: rates and efforts ring where hard dampers hold joints.
//!
//! ```text
//!     c Y h > 10:    the transient of a joint that moves is shorter than the step h, and the scheme keeps it as an oscillation
//!     S = {moving joints with hard dampers} ∪ {held joints},     D f = −a_S,     q̇_s = q̇ − f / c,     λ_s = f
//! ```
//!
//! c is the damping of a joint by its own damper and motors [N m s/rad], Y its mobility [1/(kg m²)], a the accelerations under all efforts except at
//! held joints, and D = W Y Wᵀ the mobility of S. q̇_s are the rates and λ_s the efforts of held joints [N m] once the transient is over. A joint whose q̇_s
//! goes on, or whose λ_s holds it, from there to the end of the step, has no event where q̇ or λ are zero: it would stop and slip, or part from its limit and meet it, in step after step.
//! f changes its sign within the step where rates ring, and keeps it where a slow motion lags behind. Trees without contacts are looked at.

use crate::events::finding::watched::Watched;
use crate::events::integrator::Eventful;
use crate::events::modes::instants::Inside;
use crate::events::modes::mode::{JointMode, MotorMode};
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::inputs::Inputs;
use nalgebra::DVector;

/// Steps over the time constant of a hard damper.
const HARD: f64 = 10.0;

/// Instants of a step at which it is looked for what rings.
const SAMPLES: usize = 9;

/// A freedom that moves against a hard damper, with c, or one that is held.
struct Member {
    freedom: usize,
    damping: Option<f64>,
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
        let Some(forces) = self.settled(inputs, since, time, &members) else { return false };
        let joint = &self.model.elements.joints[index];
        let (own, (low, high)) = (joint.coordinate.freedom, self.mode.joints[index].holding(joint));
        let Some(place) = members.iter().position(|member| member.freedom == own) else { return false };
        let (mode, damping) = (self.mode.joints[index], members[place].damping);
        let goes_on = |forces: &DVector<f64>, rate: f64| match (watched, mode, damping) {
            (Watched::Slide(_), JointMode::Free { sliding }, Some(damping)) => {
                f64::from(sliding) * (rate - forces[place] / damping) > 0.0
            }
            (Watched::Bears(_, Side::Lower), _, None) => forces[place] > low,
            (Watched::Bears(_, Side::Upper), _, None) => forces[place] < high,
            _ => false,
        };
        if !goes_on(&forces, self.trial.sample.velocity[own]) {
            return false;
        }
        // A slow motion lags behind its settled rates with one sign.
        let turns = |there: &DVector<f64>| {
            let pairs = members.iter().zip(forces.iter().zip(there));
            pairs.into_iter().any(|(member, (force, there))| member.damping.is_some() && force * there < 0.0)
        };
        let mut turned = false;
        for sample in 0..SAMPLES {
            let at = since + length * sample as f64 / (SAMPLES - 1) as f64;
            let Some(there) = self.settled(inputs, since, at, &members) else { continue };
            // It does not go on to the end of the step.
            if at > time && !goes_on(&there, self.trial.sample.velocity[own]) {
                return false;
            }
            turned |= turns(&there);
        }
        turned
    }

    /// S at a time (s) in a step of this length (s); empty if no damper is hard.
    fn members(&mut self, time: f64, length: f64) -> Vec<Member> {
        let dampings = self.dampings();
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

    /// f of these members at a time (s) in a step from `since` [N m or N]; `None` if there are none, or D is singular.
    fn settled(&mut self, inputs: Inputs, since: f64, time: f64, members: &[Member]) -> Option<DVector<f64>> {
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
        square.cholesky().map(|factor| factor.solve(&wanted))
    }

    /// The freedoms that dampers or motors within their bounds damp, with c [N m s/rad or N s/m].
    fn dampings(&self) -> Vec<(usize, f64)> {
        let dampers = self.model.whole.forces.joint_dampers.iter().map(|damper| (damper.freedom, damper.coefficient));
        let motors = self.model.elements.motors.iter().zip(&self.mode.motors);
        let motors = motors.filter(|(_, mode)| **mode == MotorMode::Unbounded);
        let motors = motors.map(|(motor, _)| (motor.coordinate.freedom, motor.law.gains().1));
        let damped = dampers.chain(motors).filter(|(_, damping)| *damping > 0.0);
        let mut all: Vec<(usize, f64)> = Vec::new();
        for (freedom, damping) in damped {
            match all.iter_mut().find(|(known, _)| *known == freedom) {
                Some((_, sum)) => *sum += damping,
                None => all.push((freedom, damping)),
            }
        }
        all
    }
}
