//! The closed contacts in a state of the last step, as reports name them.

use crate::events::integrator::Eventful;
use crate::events::modes::mode::Mode;
use crate::events::modes::present::Present;
use crate::events::modes::tolerances::slip_at_rest;
use crate::events::parts::model::HybridModel;
use crate::events::parts::previous::PreviousStep;
use crate::events::parts::trial::StepTrial;
use crate::events::parts::workspaces::Workspaces;
use crate::instant::cone::problem::outside_cone;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::{tangents, touch_motion};

/// Forces outside their cones by more than this part of the largest force violate the law.
const FAR_OUT: f64 = 1e-6;

impl Eventful {
    /// Whether the forces of the mode in a state are far outside their cones: a law that was solved inaccurately may have chosen the wrong closed
    /// contacts.
    pub(super) fn is_far_out(&self, inputs: Inputs, state: &State) -> bool {
        let Eventful {
            model: HybridModel { whole, elements, touching, .. },
            workspaces: Workspaces { pieces, current, .. },
            previous: PreviousStep { reporting, .. },
            trial: StepTrial { holding, .. },
            mode,
            memory,
            ..
        } = self;
        let mut efforts = vec![0.0; whole.velocity_count];
        mode.efforts_at(elements, inputs, state.time, state, &mut efforts);
        let (moving, rest) = (&pieces[*current].moving, slip_at_rest(memory.fastest));
        let present = Present { whole, elements, touching, mode, moving, rest };
        let mut reporting = reporting.borrow_mut();
        let forces = reporting.forces(&present, state, &efforts, holding.is_unique());
        let largest = forces.iter().flatten().fold(0.0_f64, |most, force| most.max(force.abs()));
        mode.contacts.iter().zip(forces).any(|(closed, &force)| {
            let friction = touching.pairs[closed.contact.pair].friction;
            outside_cone(friction, force).max(-force[0]) > FAR_OUT * largest
        })
    }

    /// The efforts of a mode in a state of the last step: from outside, of friction and of motors.
    fn efforts_in(&self, mode: &Mode, state: &State) -> Vec<f64> {
        let mut efforts = vec![0.0; self.model.whole.velocity_count];
        efforts[..self.previous.outside.len()].copy_from_slice(&self.previous.outside);
        self.previous.felt.add(state.time, &mut efforts);
        mode.add_constant_efforts(&self.model.elements, &mut efforts);
        // A mode that follows at the end of a step was decided with the efforts after a jump of a target, the one before with those before it.
        let is_next = self.previous.stepped_in.as_ref().is_some_and(|before| !before.is_like(mode));
        let since = if is_next { state.time } else { self.trial.origin.time };
        mode.add_motor_efforts(&self.model.elements, since, state.time, state, &mut efforts);
        efforts
    }

    /// Whether it is known of the end of the last step that forces inside their cones hold all closed contacts, which is asked where several forces
    /// do: to work out the reported ones takes as long as a step.
    pub fn holds_all(&self, state: &State) -> bool {
        let sticks = self.mode.contacts.iter().all(|closed| closed.slides.is_none());
        let at_end = self.previous.left.as_ref().is_some_and(|left| left == state);
        at_end
            && sticks
            && !self.progress.undecided
            && (self.trial.holding.foreseen.holds_all_at(state.time)
                || self.trial.holding.holds_all(state, &self.efforts_in(&self.mode, state)))
    }

    /// Adds the closed contacts in a state of the last step: at its end, or inside it.
    pub(crate) fn report_contacts(&self, state: &State, out: &mut Vec<ContactPoint>) {
        let inside = self.previous.left.as_ref().is_some_and(|left| state.time < left.time);
        let mode = self.previous.stepped_in.as_ref().filter(|_| inside).unwrap_or(&self.mode);
        // At an undecided instant contacts press with impulses: the forces of that instant do not apply to them.
        if mode.contacts.is_empty() || (self.progress.undecided && !inside) {
            return;
        }
        let Eventful {
            model: HybridModel { whole, elements, touching, .. },
            workspaces: Workspaces { pieces, current, .. },
            previous: PreviousStep { reporting, .. },
            trial: StepTrial { holding, .. },
            memory,
            ..
        } = self;
        let efforts = self.efforts_in(mode, state);
        let (moving, rest) = (&pieces[*current].moving, slip_at_rest(memory.fastest));
        let present = Present { whole, elements, touching, mode, moving, rest };
        let mut reporting = reporting.borrow_mut();
        let unique = holding.is_unique() && !inside;
        let known = if unique { holding.recall(state, &efforts) } else { None };
        let forces = known.unwrap_or_else(|| reporting.forces(&present, state, &efforts, unique));
        let bodies = body_states(whole, state);
        out.extend(mode.contacts.iter().zip(forces).map(|(closed, &[pressure, along, across])| {
            let touch = touch_motion(&closed.contact.joint, &bodies);
            let [first, second] = tangents(&touch.normal);
            let on_second = touch.normal * pressure + first * along + second * across;
            touching.reported(&closed.contact, &touch, &on_second, closed.slides.is_none())
        }));
    }
}
