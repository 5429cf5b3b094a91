//! The inside of the last step: states, and functions of them, at its instants.
//!
//! Functions are asked one by one at the samples of a step, and at one instant again and again. The latest results are kept: where the bodies are,
//! and the forces that hold joints and contacts.

use crate::events::finding::watched::{Seen, Watched};
use crate::events::integrator::Eventful;
use crate::events::modes::instants::{Evaluated, Inside};
use crate::events::modes::present::Present;
use crate::events::modes::tolerances::slip_at_rest;
use crate::events::parts::model::HybridModel;
use crate::events::parts::trial::StepTrial;
use crate::events::parts::workspaces::Workspaces;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::inputs::Inputs;

/// An instant that ends a step is approached to this part of its time, or of a second: further than instants are told apart.
const BEFORE: f64 = 4e-12;

/// Whether forces or moved joints of a mechanism change their law at the instant (s) that ends a step from `since` (s).
fn changes_at(whole: &Mechanism, since: f64, time: f64) -> bool {
    whole.changes() && time >= whole.next_instant(since) - BEFORE * time.abs().max(1.0)
}

impl Eventful {
    /// Whether forces or moved joints change their law at the instant (s) that ends a step from `since` (s).
    pub(super) fn ends_at_change(&self, since: f64, time: f64) -> bool {
        changes_at(&self.model.whole, since, time)
    }

    /// Places the sample and its bodies at an instant of the last step.
    pub(crate) fn place(&mut self, instant: Inside) {
        self.go_to(instant);
        if !self.trial.evaluated.bodies {
            self.trial.placed.place(&self.model.whole, &self.trial.sample, &mut self.trial.bodies);
            self.trial.evaluated.bodies = true;
        }
    }

    /// The number of an instant of the last step among those whose bodies are known. The sample stays where it is, if they were known before.
    pub(crate) fn look_at(&mut self, instant: Inside) -> usize {
        let current = self.workspaces.current;
        let of = (current, self.workspaces.pieces[current].instants.makings());
        if let Some(known) = self.trial.inside.find(of, instant) {
            return known;
        }
        self.place(instant);
        self.trial.inside.keep(of, instant, &self.trial.bodies)
    }

    /// Puts the sample there.
    pub(super) fn go_to(&mut self, instant: Inside) {
        let Eventful {
            model: HybridModel { whole, .. },
            workspaces: Workspaces { pieces, current, .. },
            trial: StepTrial { sample, origin, evaluated, .. },
            ..
        } = self;
        let piece = &mut pieces[*current];
        let at = Some((instant, piece.instants.makings()));
        if evaluated.at != at {
            sample.copy_from(origin);
            piece.place(whole, instant.time, instant.roughly, sample);
            *evaluated = Evaluated { at, ..Evaluated::default() };
        }
    }

    /// The values of some functions at an instant of the last step.
    pub(crate) fn evaluate(
        &mut self,
        inputs: Inputs,
        since: f64,
        instant: Inside,
        which: &[usize],
        values: &mut [f64],
    ) {
        self.go_to(instant);
        self.evaluate_at_sample(inputs, since, instant.time, which, values);
    }

    /// The same at the sample, at a time (s).
    pub(super) fn evaluate_at_sample(
        &mut self,
        inputs: Inputs,
        since: f64,
        time: f64,
        which: &[usize],
        values: &mut [f64],
    ) {
        let Eventful {
            model: HybridModel { whole, elements, touching, .. },
            workspaces: Workspaces { response, pieces, current, .. },
            trial: StepTrial { holding, sample, evaluated, watched, efforts, bodies, placed, slips, turns, .. },
            mode,
            memory,
            ..
        } = self;
        if !evaluated.efforts && which.iter().any(|&index| watched[index].needs_efforts()) {
            mode.efforts_at(elements, inputs, since, sample, efforts);
            let (moving, rest) = (&pieces[*current].moving, slip_at_rest(memory.fastest));
            let present = Present { whole, elements, touching, mode, moving, rest };
            // The forces of the step are those before the instant that ends it.
            let end = sample.time;
            if changes_at(whole, since, time) {
                sample.time -= BEFORE * end.abs().max(1.0);
            }
            holding.evaluate(&present, response, sample, efforts);
            sample.time = end;
            evaluated.efforts = true;
        }
        if !evaluated.margin && which.iter().any(|&index| watched[index] == Watched::Margin) {
            holding.evaluate_margin(|contact| mode.contacts[contact].shares(touching));
            evaluated.margin = true;
        }
        if !evaluated.bodies && which.iter().any(|&index| watched[index].needs_bodies()) {
            placed.place(whole, sample, bodies);
            evaluated.bodies = true;
        }
        let seen = Seen { elements, touching, mode, holding, since, time, state: sample, bodies, slips, turns };
        for (value, &index) in values.iter_mut().zip(which) {
            *value = watched[index].value(&seen);
        }
    }
}
