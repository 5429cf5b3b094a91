//! Stops of joints that creep against a hard damper: roots that are no events.
//!
//! ```text
//!     c q̇ = τ − τ_f,     c Y h > 1:     the rate q̇ follows the excess of the effort τ over dry friction τ_f, and its transient is
//!     shorter than the step h. The scheme keeps it as an oscillation about q̇, through zero.
//!     q̇ = 0 and τ > τ_f: the joint has not stopped.
//! ```
//!
//! c is the damping of the joint's own damper and motors [N m s/rad], Y its mobility [1/(kg m²)]. An event there would stop the joint and let it slip
//! again, in step after step.

use crate::events::effects::decision::Scene;
use crate::events::effects::memory::Found;
use crate::events::effects::transition::transit;
use crate::events::finding::watched::Watched;
use crate::events::integrator::Eventful;
use crate::events::modes::instants::Inside;
use crate::events::modes::mode::{Mode, MotorMode};
use crate::events::parts::workspaces::Workspaces;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::state::State;

impl Eventful {
    /// Whether a function whose sign changes at a time (s) in a step from `since` is the rate of a joint that creeps on.
    pub(super) fn creeps_on(&mut self, inputs: Inputs, since: f64, time: f64, number: usize) -> bool {
        let Watched::Slide(index) = self.trial.watched[number] else { return false };
        let freedom = self.model.elements.joints[index].coordinate.freedom;
        let damping = self.damping_of(freedom);
        if damping == 0.0 {
            return false;
        }
        let length = self.workspaces.active().small.time - since;
        self.evaluate(inputs, since, Inside::at(time), &[number], &mut [0.0]);
        let mut state = self.trial.sample.clone();
        let mobility = self.workspaces.response.diagonal(&state, std::iter::once(freedom));
        if damping * mobility[0] * length <= 1.0 {
            return false;
        }
        state.velocity[freedom] = 0.0;
        let mut mode = self.mode.clone();
        self.try_transit(inputs, &mut mode, &mut state, &[Watched::Slide(index)]);
        mode.joints[index] == self.mode.joints[index]
    }

    /// The damping of a degree of freedom by dampers, and by motors that are not at their bounds [N m s/rad or N s/m].
    fn damping_of(&self, freedom: usize) -> f64 {
        let dampers = self.model.whole.forces.joint_dampers.iter().filter(|damper| damper.freedom == freedom);
        let motors = self.model.elements.motors.iter().zip(&self.mode.motors);
        let motors =
            motors.filter(|(motor, mode)| motor.coordinate.freedom == freedom && **mode == MotorMode::Unbounded);
        let of_motors = motors.map(|(motor, _)| motor.law.gains().1);
        dampers.map(|damper| damper.coefficient).sum::<f64>() + of_motors.sum::<f64>()
    }

    /// The mode after an event that does not take place.
    fn try_transit(&mut self, inputs: Inputs, mode: &mut Mode, state: &mut State, triggers: &[Watched]) {
        let Eventful { model, workspaces, tally, trial, memory, .. } = self;
        let Workspaces { response, .. } = workspaces;
        let (elements, touching, whole) = (&model.elements, &model.touching, &model.whole);
        let efforts = |mode: &Mode, state: &State| mode.driving_efforts(elements, inputs, state);
        let mut solvers = tally.solvers;
        let mut scene = Scene { whole, elements, touching, near: trial.near.pairs(), response, solvers: &mut solvers };
        let found = Found { triggers, height: model.height, anew: false, brief: false };
        transit(&mut scene, mode, state, &mut memory.clone(), &found, efforts);
    }
}
