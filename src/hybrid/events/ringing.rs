//! Sign changes that are no events: rates and efforts ring where hard dampers hold joints.
//!
//! ```text
//!     c Y h > 10:    the transient of a joint that moves is shorter than the step h, and the scheme keeps it as an oscillation
//!     S = {moving joints with hard dampers} ∪ {held joints},     D f = −a_S,     q̇_s = q̇ − f / c,     λ_s = f
//! ```
//!
//! c is the damping of a joint by its own damper and motors [N m s/rad], Y its mobility [1/(kg m²)], a the accelerations under all efforts except at
//! held joints, and D = W Y Wᵀ the mobility of S. q̇_s are the rates and λ_s the efforts of held joints [N m] once the transient is over. A joint whose q̇_s
//! goes on, or whose λ_s holds it, has no event where q̇ or λ are zero: it would stop and slip, or part from its limit and meet it, in step after step.
//! f changes its sign within the step where rates ring, and keeps it where a slow motion lags behind. Trees without contacts are looked at.

use crate::events::finding::watched::Watched;
use crate::events::integrator::Eventful;
use crate::events::modes::instants::Inside;
use crate::events::modes::mode::{JointMode, MotorMode};
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::state::State;
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
        let dampings = self.dampings();
        if dampings.iter().all(|(_, damping)| *damping == 0.0) {
            return false;
        }
        let end = self.workspaces.active().small.time;
        let length = end - since;
        let at = |this: &mut Self, time: f64| {
            this.evaluate(inputs, since, Inside::at(time), &[number], &mut [0.0]);
            let state = this.trial.sample.clone();
            this.settled(inputs, &state, length, &dampings).map(|settled| (state, settled))
        };
        let Some((state, settled)) = at(self, time) else { return false };
        // A slow motion lags behind its settled rates with one sign.
        let others: [_; SAMPLES] =
            std::array::from_fn(|sample| at(self, since + length * sample as f64 / (SAMPLES - 1) as f64));
        let rings = |number: usize, force: f64| {
            others.iter().flatten().any(|(_, other)| other.get(number).is_some_and(|(_, there)| there * force < 0.0))
        };
        let hard = settled.iter().enumerate().filter(|(_, (member, _))| member.damping.is_some());
        if !hard.clone().any(|(number, (_, force))| rings(number, *force)) {
            return false;
        }
        let joint = &self.model.elements.joints[index];
        let (own, (low, high)) = (joint.coordinate.freedom, self.mode.joints[index].holding(joint));
        let Some((member, force)) = settled.iter().find(|(member, _)| member.freedom == own) else { return false };
        match (watched, self.mode.joints[index], member.damping) {
            (Watched::Slide(_), JointMode::Free { sliding }, Some(damping)) => {
                f64::from(sliding) * (state.velocity[own] - force / damping) > 0.0
            }
            (Watched::Bears(_, Side::Lower), _, None) => *force > low,
            (Watched::Bears(_, Side::Upper), _, None) => *force < high,
            _ => false,
        }
    }

    /// S with f [N m or N]; `None` if no damper is hard in a step of this length (s), or D is singular.
    fn settled(
        &mut self,
        inputs: Inputs,
        state: &State,
        length: f64,
        dampings: &[(usize, f64)],
    ) -> Option<Vec<(Member, f64)>> {
        let elements = &self.model.elements;
        let mut efforts = self.mode.driving_efforts(elements, inputs, state);
        let mut held = Vec::new();
        for (joint, mode) in elements.joints.iter().zip(&self.mode.joints) {
            let freedom = joint.coordinate.freedom;
            match mode {
                JointMode::Free { sliding } => efforts[freedom] -= f64::from(*sliding) * joint.friction,
                JointMode::Held { .. } => held.push(freedom),
            }
        }
        let response = &mut self.workspaces.response;
        let mobilities = response.diagonal(state, dampings.iter().map(|(freedom, _)| *freedom));
        let hard = dampings
            .iter()
            .zip(mobilities)
            .filter(|((freedom, damping), mobility)| damping * mobility * length > HARD && !held.contains(freedom));
        let hard = hard.map(|(&(freedom, damping), _)| Member { freedom, damping: Some(damping) });
        let mut members: Vec<Member> = hard.collect();
        if members.is_empty() {
            return None;
        }
        members.extend(held.into_iter().map(|freedom| Member { freedom, damping: None }));
        let freedoms: Vec<usize> = members.iter().map(|member| member.freedom).collect();
        let mut accelerations = vec![0.0; efforts.len()];
        response.accelerations(state, &efforts, &mut accelerations);
        let (_, square) = response.matrix(state, &freedoms);
        let wanted = DVector::from_iterator(freedoms.len(), freedoms.iter().map(|&freedom| -accelerations[freedom]));
        let forces = square.cholesky()?.solve(&wanted);
        Some(members.into_iter().zip(forces.iter().copied()).collect())
    }

    /// The freedoms that dampers or motors within their bounds damp, with c [N m s/rad or N s/m].
    fn dampings(&self) -> Vec<(usize, f64)> {
        let dampers = self.model.whole.forces.joint_dampers.iter().map(|damper| (damper.freedom, damper.coefficient));
        let motors = self.model.elements.motors.iter().zip(&self.mode.motors);
        let motors = motors.filter(|(_, mode)| **mode == MotorMode::Unbounded);
        let motors = motors.map(|(motor, _)| (motor.coordinate.freedom, motor.law.gains().1));
        let mut all: Vec<(usize, f64)> = Vec::new();
        for (freedom, damping) in dampers.chain(motors) {
            match all.iter_mut().find(|(known, _)| *known == freedom) {
                Some((_, sum)) => *sum += damping,
                None => all.push((freedom, damping)),
            }
        }
        all
    }
}
