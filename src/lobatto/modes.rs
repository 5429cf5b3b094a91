//! What steers the steps knows of the motion at an instant: its fastest mode and its pace.
//!
//! A tree under gravity has both from its geometric stiffness ([`super::dynamics`]); with forces or closures the mode comes from
//! differences of accelerations ([`super::linearised`]), and the pace is not available.

use super::dynamics::Dynamics;
use super::fastest::Fastest;
use super::linearised::Linearised;
use super::plan::Plan;
use super::reversible::Pace;
use super::start::Start;
use super::watch::{Mode, Transient};
use crate::model::Mechanism;
use crate::state::State;

/// The workspace of all looks at one mechanism.
pub struct Modes {
    /// Of a tree under gravity.
    dynamics: Option<Dynamics>,
    fastest: Fastest,
    /// Of all others.
    linearised: Option<Box<Linearised>>,
    jerks: Vec<f64>,
}

impl Modes {
    /// Nothing known yet.
    pub fn new(mechanism: &Mechanism, plan: &Plan) -> Self {
        let freedoms = mechanism.velocity_count;
        let plain = mechanism.is_plain_tree();
        Modes {
            dynamics: plain.then(|| Dynamics::new(plan, freedoms)),
            fastest: Fastest::new(freedoms),
            linearised: (!plain).then(|| Box::new(Linearised::new(mechanism))),
            jerks: vec![0.0; freedoms],
        }
    }

    /// Forgets the motion: the next look is at another.
    pub fn forget(&mut self) {
        self.fastest.forget();
        if let Some(linearised) = &mut self.linearised {
            linearised.forget();
        }
    }

    /// The fastest mode at a state, which `start` has taken, after some power iterations.
    pub fn fastest(
        &mut self,
        mechanism: &Mechanism,
        plan: &Plan,
        start: &Start,
        state: &State,
        iterations: usize,
    ) -> Mode {
        let (fastest, gravity) = (&mut self.fastest, mechanism.gravity.into());
        let of_tree = self.dynamics.as_mut().map(|dynamics| Mode {
            frequency: fastest.estimate(dynamics, plan, start, &gravity, iterations),
            damping: 0.0,
        });
        let of_others = || self.linearised.as_mut().map(|linearised| linearised.estimate(mechanism, state, iterations));
        of_tree.or_else(of_others).unwrap_or_default()
    }

    /// What dampers are about to stop at a state, if there is any to speak of.
    pub fn transient(&mut self, mechanism: &Mechanism, state: &State) -> Option<Transient> {
        self.linearised.as_mut().and_then(|linearised| linearised.transient(mechanism, state))
    }

    /// The pace at an instant; `None` where forces and closures play a part that it does not know.
    pub fn pace(&mut self, mechanism: &Mechanism, plan: &Plan, start: &Start) -> Option<Pace> {
        let (jerks, gravity) = (&mut self.jerks, mechanism.gravity.into());
        self.dynamics.as_mut().map(|dynamics| Pace::at(dynamics, plan, start, &gravity, jerks))
    }
}
