//! The inside of the last step: states, and functions of them, at its instants.
//!
//! Functions are asked one by one at the samples of a step, and at one instant again and again. What was worked out there last is kept: where the bodies are,
//! and the forces that hold joints and contacts.

use crate::events::integrator::Eventful;
use crate::events::present::Present;
use crate::events::watched::Seen;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::kinematics::place_bodies;

/// An instant of the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Inside {
    /// s.
    pub time: f64,
    /// Whether the state is as interpolated, so that closures are off by as much as interpolation errs. Bringing it on them takes ten times as long.
    pub roughly: bool,
}

impl Inside {
    /// With a state on all closures.
    pub fn at(time: f64) -> Self {
        Inside { time, roughly: false }
    }

    /// With a state as interpolated.
    pub fn roughly(time: f64) -> Self {
        Inside { time, roughly: true }
    }
}

/// What is known of the sample of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Evaluated {
    /// Where it is, in which making of the step; `None` if nothing is known.
    at: Option<(Inside, u64)>,
    /// Whether the bodies are placed there,
    bodies: bool,
    /// and the forces are those of this instant.
    efforts: bool,
}

impl Eventful {
    /// Places the sample and its bodies at an instant of the last step.
    pub(super) fn place(&mut self, instant: Inside) {
        self.go_to(instant);
        if !self.evaluated.bodies {
            place_bodies(&self.whole, &self.sample, &mut self.bodies);
            self.evaluated.bodies = true;
        }
    }

    /// Puts the sample there.
    fn go_to(&mut self, instant: Inside) {
        let Eventful { whole, pieces, current, sample, origin, evaluated, .. } = self;
        let piece = &mut pieces[*current];
        let at = Some((instant, piece.instants.makings()));
        if evaluated.at != at {
            sample.copy_from(origin);
            piece.place(whole, instant.time, instant.roughly, sample);
            *evaluated = Evaluated { at, bodies: false, efforts: false };
        }
    }

    /// The values of some functions at an instant of the last step.
    pub(super) fn evaluate(
        &mut self,
        inputs: Inputs,
        since: f64,
        instant: Inside,
        which: &[usize],
        values: &mut [f64],
    ) {
        self.go_to(instant);
        let Eventful {
            whole,
            elements,
            touching,
            mode,
            response,
            pieces,
            current,
            holding,
            sample,
            evaluated,
            watched,
            efforts,
            bodies,
            slips,
            ..
        } = self;
        if !evaluated.efforts && which.iter().any(|&index| watched[index].needs_efforts()) {
            mode.efforts_at(elements, inputs, since, sample, efforts);
            let present = Present { whole, elements, touching, mode, moving: &pieces[*current].moving };
            holding.evaluate(&present, response, sample, efforts);
            evaluated.efforts = true;
        }
        if !evaluated.bodies && which.iter().any(|&index| watched[index].needs_bodies()) {
            place_bodies(whole, sample, bodies);
            evaluated.bodies = true;
        }
        let seen = Seen { elements, touching, mode, holding, since, time: instant.time, state: sample, bodies, slips };
        for (value, &index) in values.iter_mut().zip(which) {
            *value = watched[index].value(&seen);
        }
    }
}
