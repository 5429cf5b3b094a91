//! Crowds in which trees fall asleep, sleep and wake, and their contacts as reports name them.

use crate::events::crowd::contacts::Scene;
use crate::events::crowd::step::{Crowd, Forces};
use crate::instant::holding::touching::Touching;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;

/// A contact is held by friction where it needs less than this part of what there is.
const STICKS: f64 = 1.0 - 1e-9;

impl Crowd {
    /// From now on no tree falls asleep.
    pub fn keep_awake(&mut self) {
        self.resting.keep_awake();
    }

    /// Lets trees fall asleep at the end of a step whose bodies had these speeds; says whether some do.
    pub(super) fn let_sleep(
        &mut self,
        scene: Scene,
        forces: Forces,
        state: &mut State,
        step: f64,
        speeds: &[(f64, f64)],
    ) -> bool {
        let Crowd { resting, trees, now, next, began, bodies, efforts, acceleration, .. } = self;
        let mut at_rest = |at: &State, accelerations: &mut [f64]| forces(at, accelerations, efforts);
        let of_step = (acceleration.as_slice(), &mut at_rest as &mut dyn FnMut(&State, &mut [f64]));
        // The candidates of the start have changed places with those of the end.
        let any = resting.settle(scene.whole, [began, bodies], speeds, (next, now), (state, step), of_step);
        if any {
            now.fill_rows(scene, &resting.asleep, trees, bodies, 0);
            self.end = Some((state.clone(), step));
        }
        any
    }

    /// Wakes the groups of these trees; their contacts are looked for anew where the step begins.
    pub(super) fn wake(&mut self, trees: &[usize]) {
        let length = self.end.as_ref().map_or(1.0, |(_, length)| *length);
        self.resting.wake(trees, &mut self.now.list, length);
        self.woken = true;
    }

    /// Whether the last step ended in a state, at whatever time.
    pub(super) fn goes_on(&self, state: &State) -> bool {
        let same = |end: &State| {
            end.position == state.position && end.compensation == state.compensation && end.velocity == state.velocity
        };
        self.end.as_ref().is_some_and(|(end, _)| same(end))
    }

    /// Whether all bodies rest in a state, and go on resting under the forces in it.
    pub fn sleeps(&mut self, state: &State, forces: Forces) -> bool {
        if !self.resting.is_all() || !self.goes_on(state) {
            return false;
        }
        forces(state, &mut self.acceleration, &mut self.efforts);
        let reached = self.resting.loaded(&self.acceleration);
        if !reached.is_empty() {
            self.wake(&reached);
        }
        reached.is_empty()
    }

    /// Adds the contacts that pressed in the last step, with their mean forces.
    pub fn pressing(&self, touching: &Touching, out: &mut Vec<ContactPoint>) {
        let Some((_, step)) = &self.end else { return };
        let first = out.len();
        let awake = self.now.list.iter().map(|candidate| (candidate, step));
        let asleep = self.resting.candidates().iter().map(|(candidate, step)| (candidate, step));
        for (candidate, step) in awake.chain(asleep) {
            let Some(contact) = candidate.contact.as_ref().filter(|_| candidate.settling.x > 0.0) else { continue };
            let touch = touch_motion(&contact.joint, &self.bodies);
            let [normal, first, second] = candidate.frame;
            let force =
                (normal * candidate.settling.x + first * candidate.settling.y + second * candidate.settling.z) / *step;
            let across = candidate.settling.y.hypot(candidate.settling.z);
            let sticks = across < STICKS * candidate.friction * candidate.settling.x;
            out.push(touching.reported(contact, &touch, &force, sticks));
        }
        out[first..].sort_by_key(|point| point.pair);
    }
}
