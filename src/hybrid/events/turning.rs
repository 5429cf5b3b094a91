//! Roots that are no events: slips that have turned instead of stopping, and contacts without a load that others do not part.
//!
//! ```text
//!     u_T · t₀ = 0 at the end of a step:   |u_T| > ½ of before: it has turned;   ≤ 1e-5 of the largest speed: it has stopped
//! ```
//!
//! A slip between the two has passed near its stop. It turns there within about |u_T|/|u̇_T|, and a longer step does not follow it.

use crate::events::finding::watched::Watched;
use crate::events::integrator::Eventful;
use crate::events::modes::instants::Inside;
use crate::instant::holding::moments::Turning;
use crate::instant::holding::touching::Contact;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::touches::touch_motion;

/// A slip that keeps this part of its speed has turned.
const TURNED: f64 = 0.5;
/// A slip that keeps less of its speed, but more than this part of the largest speed, has passed near its stop. It turns in less time than the step
/// has taken, so that the step is too long for it.
const PASSED: f64 = 1e-5;
/// Such a step ends at this part of its length.
pub(super) const BEFORE_IT: f64 = 0.7;

/// How a slip has turned.
#[derive(Clone, Copy, PartialEq)]
pub enum Turned {
    /// It is about as fast as before.
    Fast,
    /// It has become slow, and turned near its stop.
    Slowly,
}

impl Eventful {
    /// Leaves out contacts that are unloaded at both ends of the step: others that meet do not part them.
    pub fn leave_unloaded(&mut self, inputs: Inputs, since: f64, located: usize, all: &mut Vec<Watched>) {
        let located = self.trial.watched[located];
        let unloaded = |this: &Self, watched: &Watched| match *watched {
            Watched::Presses(contact) if *watched != located => this.trial.holding.is_unloaded(contact),
            _ => false,
        };
        let ends: Vec<Watched> = all.iter().copied().filter(|watched| unloaded(self, watched)).collect();
        if ends.is_empty() {
            return;
        }
        let which: Vec<usize> =
            (0..self.trial.watched.len()).filter(|&index| ends.contains(&self.trial.watched[index])).collect();
        self.evaluate(inputs, since, Inside::at(since), &which, &mut vec![0.0; which.len()]);
        all.retain(|watched| !(ends.contains(watched) && unloaded(self, watched)));
    }

    /// How a slip has turned that has no part along its old direction any more, if it has not stopped.
    pub(crate) fn turns(&mut self, since: f64, watched: Watched) -> Option<Turned> {
        let rolls = matches!(watched, Watched::Turns(_, false));
        let contacts: Vec<usize> = match watched {
            Watched::Turns(contact, false) => vec![contact],
            Watched::Slips(contact) => vec![contact],
            Watched::SlipsTogether(pair) => {
                let own = |contact: &usize| self.mode.contacts[*contact].contact.pair == pair;
                (0..self.mode.contacts.len()).filter(own).collect()
            }
            _ => return None,
        };
        let end = self.workspaces.active().small.time;
        if end <= since {
            return None;
        }
        let mut speed = |part: f64| {
            self.place(Inside::at(since + part * (end - since)));
            let of = |contact: &usize| {
                let Contact { pair, joint, .. } = &self.mode.contacts[*contact].contact;
                let motion = touch_motion(joint, &self.trial.bodies);
                if rolls {
                    let turning = Turning::of(joint, &self.trial.bodies, &motion.normal);
                    return self.model.touching.pairs[*pair].arm() * turning.across.norm();
                }
                motion.slip.norm()
            };
            contacts.iter().map(of).fold(0.0, f64::max)
        };
        let before = [0.0, 0.25, 0.5, 0.75].map(&mut speed).into_iter().fold(0.0, f64::max);
        let after = speed(1.0);
        if after > TURNED * before {
            Some(Turned::Fast)
        } else {
            (after > PASSED * self.memory.fastest).then_some(Turned::Slowly)
        }
    }
}
