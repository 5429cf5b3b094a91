//! Slips that pass near their stop inside a step: they turn faster there than the polynomials through the stages can follow.
//!
//! The slip goes from u₀ to u₁ [m/s] over the step. With the times τ from 0 to 1 along the straight line between them,
//!
//! ```text
//!     d = u₁ − u₀,   |u₀ + τ d|² = 0:   τ* = (−u₀ · d ± i |u₀ × d|)/|d|²,   z = 2 τ* − 1
//!     ρ = |z + √(z² − 1)| ≥ 1           the ellipse about the step in which the direction u/|u| is analytic
//!     error ≈ |d| ρ^(2 − 2s) sin θ  [m/s]     of s stages, whose order is 2s − 2, for a turning by θ; sin θ = 1 from a right angle on
//! ```
//!
//! The step is made again, shorter, while the error is more than a hundredth of the tolerance a second, or in given steps more than 1e-6 m/s. A slip that
//! only turns, as fast as before, has no stop nearby, and is left to the other measures.
//!
//! A pass that was seen is known until the slip is away from it: with u̇ = d/h of the last step, the next one is the longest h whose error between u and
//! u + h u̇ is allowed, so that it need not be made to be shortened.
//!
//! Source: L. N. Trefethen, Approximation Theory and Approximation Practice, SIAM 2013, chapters 8 and 19, for the convergence of polynomials and
//! quadratures by the Bernstein ellipse.

use crate::events::integrator::Eventful;
use crate::events::modes::instants::{Evaluated, Inside};
use crate::events::modes::mode::Closed;
use crate::events::modes::tolerances::{STOPPED_SLIP, slip_at_rest};
use crate::events::parts::progress::Pass;
use crate::instant::holding::touching::Contact;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;
use nalgebra::Vector3;

/// The part of the tolerance that a slip may be off by after a second [1/s].
const PART: f64 = 0.01;
/// The same in a given step [m/s].
const GIVEN: f64 = 1e-6;
/// A step beside a known pass is off by this part of what is allowed, because the slip may change faster than before.
const SURELY: f64 = 0.3;
/// It is found by lengths that fall by this factor.
const SHORTENED: f64 = 0.8;
/// A slip is away from its stop once a step that is longer by this factor would be accurate.
const FARTHER: f64 = 2.0;
/// No step is made shorter than this for it (s).
const SHORTEST: f64 = 1e-6;
/// A slip that is never slower than this part of its largest speed only turns.
const SLOWER: f64 = 0.7;
/// The instant of the step that tells whether the slip is slower inside.
const MIDDLE: f64 = 0.5;

/// The error of a slip between these two in a step of a number of stages [m/s].
fn error([from, to]: [&Vector3<f64>; 2], stages: usize) -> f64 {
    let change = to - from;
    let square = change.norm_squared();
    let (along, across) = (from.dot(to), from.cross(to).norm());
    if square == 0.0 || across == 0.0 && along >= 0.0 {
        return 0.0;
    }
    let turned = if along > 0.0 { across / across.hypot(along) } else { 1.0 };
    let (x, y) = (-2.0 * from.dot(&change) / square - 1.0, 2.0 * from.cross(&change).norm() / square);
    // √(z² − 1), on the side that makes the sum larger.
    let (real, imaginary) = (x * x - y * y - 1.0, 2.0 * x * y);
    let size = real.hypot(imaginary);
    let root = [(0.5 * (size + real)).max(0.0).sqrt(), (0.5 * (size - real)).max(0.0).sqrt().copysign(imaginary)];
    let ellipse = (x + root[0]).hypot(y + root[1]).max((x - root[0]).hypot(y - root[1])).max(1.0);
    square.sqrt() * turned * ellipse.powi(2 - 2 * stages as i32)
}

/// The longest step (s), up to a length, in which a slip that changes at this rate is off by no more than is allowed [m/s].
fn longest(from: &Vector3<f64>, rate: &Vector3<f64>, (allowed, stages): (f64, usize), at_most: f64) -> f64 {
    let mut length = at_most;
    while length > SHORTEST && error([from, &(from + rate * length)], stages) > allowed {
        length *= SHORTENED;
    }
    length
}

impl Eventful {
    /// How much a slip may be off by in a step [m/s], and the stages of a step.
    fn allowed_of_slips(&self) -> Option<(f64, usize)> {
        let recipe = &self.model.recipe;
        let chosen = recipe.chosen().map(|(tolerance, stages)| (PART * tolerance, stages));
        chosen.or_else(|| recipe.given().map(|stages| (GIVEN, stages)))
    }

    /// The end of a step from a time to another (s) that known passes allow.
    pub(super) fn before_passes(&mut self, since: f64, until: f64) -> f64 {
        if self.progress.passes.is_empty() {
            return until;
        }
        let contacts = &self.mode.contacts;
        let slides = |pass: &Pass, closed: &Closed| closed.contact.pair == pass.pair && closed.slides.is_some();
        let lasts = |pass: &Pass| contacts.get(pass.contact).is_some_and(|closed| slides(pass, closed));
        self.progress.passes.retain(lasts);
        let Some((allowed, stages)) = self.allowed_of_slips() else { return until };
        let passes = self.progress.passes.iter();
        passes.fold(until, |until, Pass { contact, rate, .. }| {
            let from = &self.trial.begins[*contact];
            since + longest(from, rate, (SURELY * allowed, stages), until - since)
        })
    }

    /// Whether a slip passes near its stop in the step to this end, of which the bodies are placed, so that it is to be made again, shorter.
    pub(super) fn passes_a_stop(&mut self, end: &State) -> bool {
        let since = self.trial.origin.time;
        let length = end.time - since;
        let Some((allowed, stages)) = self.allowed_of_slips().filter(|_| length > SHORTEST) else { return false };
        let rest = slip_at_rest(self.memory.fastest);
        let mut suspects = 0;
        for (index, closed) in self.mode.contacts.iter().enumerate() {
            let Contact { pair, joint, .. } = &closed.contact;
            if closed.slides.is_none() || self.model.touching.pairs[*pair].friction == 0.0 {
                continue;
            }
            let (from, to) = (self.trial.begins[index], touch_motion(joint, &self.trial.bodies).slip);
            let slips = from.norm() > rest && to.norm() > STOPPED_SLIP * rest;
            if slips && error([&from, &to], stages) > allowed {
                self.trial.begins.push(to);
                self.trial.suspects.push(index);
                suspects += 1;
            }
            if let Some(place) = self.progress.passes.iter().position(|pass| pass.contact == index) {
                let rate = (to - from) / length;
                self.progress.passes[place].rate = rate;
                let away = to.dot(&rate) >= 0.0 && error([&to, &(to + rate * (FARTHER * length))], stages) <= allowed;
                if away {
                    self.progress.passes.swap_remove(place);
                }
            }
        }
        let known = self.mode.contacts.len();
        let mut passes = false;
        if suspects > 0 {
            self.trial.evaluated = Evaluated::default();
            self.place(Inside::at(since + MIDDLE * length));
            for number in 0..suspects {
                let contact = self.trial.suspects[number];
                let Contact { pair, joint, .. } = &self.mode.contacts[contact].contact;
                let middle = touch_motion(joint, &self.trial.bodies).slip.norm();
                let [from, to] = [self.trial.begins[contact], self.trial.begins[known + number]];
                let ends = [from.norm(), to.norm()];
                if ends[0].min(middle).min(ends[1]) < SLOWER * ends[0].max(middle).max(ends[1]) {
                    passes = true;
                    self.progress.passes.retain(|pass| pass.contact != contact);
                    self.progress.passes.push(Pass { contact, pair: *pair, rate: (to - from) / length });
                }
            }
        }
        self.trial.begins.truncate(known);
        self.trial.suspects.clear();
        passes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_that_of_the_scheme_for_a_slip_that_passes_its_stop() {
        let of = |from: [f64; 3], to: [f64; 3], stages| error([&from.into(), &to.into()], stages);
        // From (−1, δ) to (1, δ) the zeros are at z = ± i δ: ρ = δ + √(1 + δ²).
        for near in [0.1_f64, 0.5, 2.0] {
            let ellipse = near + near.hypot(1.0);
            let is = of([-1.0, near, 0.0], [1.0, near, 0.0], 5);
            let turned = if near > 1.0 { (2.0 * near.recip().atan()).sin() } else { 1.0 };
            assert!((is - 2.0 * turned * ellipse.powi(-8)).abs() <= 1e-12 * is, "{near}: {is}");
        }
        // Through the stop nothing is resolved; straight towards a stop behind the end everything is.
        assert_eq!(of([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 5), 2.0);
        assert_eq!(of([1.0, 0.0, 0.0], [0.01, 0.0, 0.0], 5), 0.0);
        assert!(of([1.0, 0.0, 0.0], [0.9, 0.1, 0.0], 5) < 1e-8);
        assert_eq!(of([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 5), 0.0);
        // Nine stages follow twice as many orders.
        let five = of([-1.0, 0.5, 0.0], [1.0, 0.5, 0.0], 5);
        assert!((of([-1.0, 0.5, 0.0], [1.0, 0.5, 0.0], 9) - 0.5 * five * five).abs() <= 1e-12 * five);
    }
}
