//! Accepts or rejects an attempt at a step, and chooses the length of the next one by the rules of [`crate::length::control`].

use crate::length::control::{Control, Decision, KINK, Kink};
use crate::length::energies::Energies;
use crate::watching::unseen::unseen;
use catena_lobatto::stages::attempt::{Attempt, Guess};
use catena_lobatto::stages::pose::MAX_TURN;
use catena_mechanism::motion::integrator::Rejected;

/// The number of iterations the controller steers for.
const WANTED_ITERATIONS: f64 = 12.0;

/// The share of the tolerance by which one step may change the energy, relative to the largest kinetic energy: the
/// changes of some hundred steps, of either sign, then stay below the tolerance.
const ENERGY_SHARE: f64 = 0.03;

/// A step is to be by this factor shorter than one that would change the energy by its share.
const CAUTION: f64 = 0.9;

/// No joint is to turn further in the next step (rad): a little less than [`MAX_TURN`].
const REPRESENTED: f64 = 0.97 * MAX_TURN;

/// Below this share of the wanted E the error of a step is the error of its iteration.
const NEGLIGIBLE: f64 = 0.1;
/// This does not hold for this number of steps after one that changed the energy too much.
const WARY: usize = 20;

/// For this number of steps the iteration goes on to rounding after a step with dampers that changed the energy too much.
const POLISHED: usize = 20;

/// An E of some roundings: the step is too short for anything to be seen of its shape.
const FLAT: f64 = 1e-14;

/// No rounding changes the energy by a larger part of the kinetic energy in a step.
const ROUNDED: f64 = 1e-6;
/// The part of a rounding that is expected to come again after each step.
const FORGOTTEN: f64 = 0.9;

impl Control {
    /// Judges an attempt of length `step`, which began from a `guess`, and sets the next one.
    pub fn judge(&mut self, attempt: &Attempt, energies: Option<Energies>, step: f64, guess: Guess) -> Decision {
        match *attempt {
            Attempt::Failed { .. } => {
                if guess != Guess::Plain {
                    return Decision::Retry { guess: Guess::Plain, why: Rejected::NotConverged };
                }
                self.memory.halvings += 1;
                self.retry(0.5 * step);
                Decision::Retry { guess: Guess::Past, why: Rejected::NotConverged }
            }
            Attempt::TurnedTooFar { .. } => {
                self.retry(0.7 * step);
                Decision::Retry { guess: Guess::Past, why: Rejected::TurnedTooFar }
            }
            Attempt::Inaccurate { legendre, .. } => {
                // E of early iterates is too uncertain.
                let smoothest = if self.rule().early { None } else { self.see_kink(step, legendre) };
                self.memory.broken_off += 1;
                self.shorten(step, legendre, smoothest)
            }
            Attempt::Converged { iterations, legendre, turn, .. } => {
                // Values below this are rounding, and their ratio to the E of the step before is meaningless.
                let error = legendre.max(1e-16);
                if error > self.limit && self.memory.kink != Kink::Seen {
                    let smoothest = self.see_kink(step, error);
                    if !self.is_kink(step, error) {
                        return self.shorten(step, error, smoothest);
                    }
                }
                let kinetic = self.memory.kinetic;
                let by_energy = energies.map_or(Ok(f64::INFINITY), |energies| self.heed(energies, step, error));
                match by_energy {
                    Ok(by_energy) => {
                        self.largest = self.largest.max(error);
                        self.go_on(step, error, iterations, by_energy, REPRESENTED / turn)
                    }
                    Err(_) if self.memory.polished == 0 && energies.is_some_and(|energies| energies.damping > 0.0) => {
                        self.memory.polished = POLISHED;
                        (self.memory.kinetic, self.memory.refused) = (kinetic, None);
                        self.memory.step = step;
                        return Decision::Retry { guess: Guess::Longer(step), why: Rejected::EnergyJump };
                    }
                    Err(by_energy) => {
                        if self.memory.polished > 0 {
                            self.memory.polished = POLISHED;
                        }
                        self.retry(step * by_energy.exp().clamp(0.2, 0.9));
                        self.memory.wary = WARY;
                        // It may have found another motion, behind a singular position.
                        return Decision::Retry { guess: Guess::Past, why: Rejected::EnergyJump };
                    }
                }
                Decision::Accept
            }
        }
    }

    /// The next attempt after one whose E was too large: a shorter one, or where there is a kink the `smoothest` once more.
    fn shorten(&mut self, step: f64, error: f64, smoothest: Option<f64>) -> Decision {
        self.memory.too_long += 1;
        if let Some(smoothest) = smoothest {
            self.memory.kink = Kink::Seen;
            self.memory.step = smoothest;
            return Decision::Retry { guess: Guess::Past, why: Rejected::NotSmooth };
        }
        let order = (self.stages - 1) as f64;
        self.retry(step * (self.wanted / error).powf(1.0 / order).clamp(0.2, 0.9));
        Decision::Retry { guess: Guess::Longer(step), why: Rejected::NotSmooth }
    }

    /// The next attempt, a shorter one: it passes no kink.
    fn retry(&mut self, step: f64) {
        self.memory.step = step;
        if self.memory.kink == Kink::Seen {
            self.memory.kink = Kink::Refused;
        }
    }

    /// The logarithm of the factor by which the next step may be longer for its energy, or, as an error, by which this one has to be shorter.
    fn heed(&mut self, energies: Energies, step: f64, error: f64) -> Result<f64, f64> {
        if !energies.change.is_finite() {
            return Err(f64::NEG_INFINITY);
        }
        let mut by_energy = f64::INFINITY;
        // Attempts that are thrown away count, too: a motion that begins at rest has no other measure.
        self.memory.kinetic = self.memory.kinetic.max(energies.kinetic);
        // Each of the two is rounded, also where they cancel.
        let rounding = self.memory.rounding.max(1e-13 * (energies.kinetic + energies.potential));
        // A motor near its target has hardly any kinetic energy, and a displacement of the size of the tolerance changes the energy of its springs.
        let (pull, stiffness) = energies.pull;
        let stored = pull + 0.5 * stiffness * self.tolerance;
        let share = ENERGY_SHARE * self.tolerance * (self.memory.kinetic + stored);
        // At rest this share is a part of roundings.
        let seen = share.max(unseen(energies.pushes));
        // What rates by the tolerance in a second take from dampers: roundings of places leave rates, too.
        let dragged = energies.damping * self.tolerance.powi(2) * step;
        let allowed = if self.memory.polished > 0 { seen.max(dragged) } else { seen };
        // The change by rounding does not fall with the step.
        let change = (energies.change.abs() - rounding).max(0.0);
        // At rest the allowed change is zero, and so is the change.
        if change > 0.0 && (error > NEGLIGIBLE * self.wanted || self.memory.wary > 0 || change > allowed) {
            let order = (2 * self.stages - 1) as f64;
            by_energy = CAUTION.ln() + (allowed / change).ln() / order;
        }
        self.memory.ringing = if change > seen && change <= allowed { energies.change } else { 0.0 };
        let refused = change > allowed && !self.is_rounding(step, error, change + rounding);
        if refused { Err(by_energy) } else { Ok(by_energy) }
    }

    /// The next step after one that is kept, by how much its energy (the logarithm) and its turns allow it to be longer.
    fn go_on(&mut self, step: f64, error: f64, iterations: usize, by_energy: f64, by_turns: f64) {
        let order = (self.stages - 1) as f64;
        let memory = &mut self.memory;
        let previous = memory.previous.unwrap_or(error);
        let by_error = (0.7 * (self.wanted / error).ln() + 0.3 * (previous / error).ln()) / order;
        let by_iterations = ((WANTED_ITERATIONS + 1.0) / (iterations as f64 + 1.0)).sqrt();
        let growth = if memory.rejected { 1.0 } else { 2.0 };
        let factor = by_error.min(by_energy).exp().min(by_iterations).min(by_turns).clamp(0.3, growth);
        memory.rejected = false;
        (memory.halvings, memory.too_long, memory.broken_off) = (0, 0, 0);
        memory.wary = memory.wary.saturating_sub(1);
        memory.polished = memory.polished.saturating_sub(1);
        memory.previous = Some(error);
        (memory.refused, memory.unresolved, memory.smoothest, memory.kink) = (None, None, None, Kink::Unseen);
        memory.rounding *= FORGOTTEN;
        // A truncated last step must not shorten the steps after it.
        memory.step = if step < 0.999 * memory.step { memory.step.max(step * factor) } else { step * factor };
    }

    /// Whether E belongs to a kink: a shorter step has as large a one, while truncation would fall to zero. Joint coordinates have one where a motion
    /// passes a gimbal lock, which is best passed in one step: the more ends of steps come near, the more rates are rounded. The energy decides on
    /// such a step.
    fn is_kink(&mut self, step: f64, error: f64) -> bool {
        let (longer, larger) = *self.memory.unresolved.get_or_insert((step, error));
        if step > 0.8 * longer {
            return false;
        }
        // The first of them may have been too long for more reasons than one.
        self.memory.unresolved = Some((step, error));
        error >= 0.5 * larger && error <= KINK * self.limit
    }

    /// The length with the least E, if E belongs to a kink for certain: a step half as long has as large a one. Whether it was solved or not, that is
    /// the one to try again. (With forces E does not tell: hard dampers leave much in any step.)
    fn see_kink(&mut self, step: f64, error: f64) -> Option<f64> {
        let memory = &mut self.memory;
        let (smoothest, least) = *memory.smoothest.get_or_insert((step, error));
        if error < least {
            memory.smoothest = Some((step, error));
        }
        let stays = step <= 0.5 * smoothest && error >= least;
        let kink = self.telling && stays && memory.kink == Kink::Unseen && least <= KINK * self.limit;
        kink.then_some(smoothest)
    }

    /// Whether a change of energy is one of rounding alone: either E is rounding, too (hard dampers change much in a slow motion), or a step half as
    /// long changes the energy as much, where truncation would fall to zero. Joint rates near a gimbal lock are thousands of times the rates of the
    /// bodies, and so are their roundings.
    fn is_rounding(&mut self, step: f64, error: f64, change: f64) -> bool {
        let (first_step, first_change) = *self.memory.refused.get_or_insert((step, change));
        let stays = step <= 0.5 * first_step && change >= 0.1 * first_change;
        let flat = self.telling && error <= FLAT;
        let rounding = (stays || flat) && change <= ROUNDED * self.memory.kinetic;
        if rounding {
            self.memory.rounding = 3.0 * change;
        }
        rounding
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::Lobatto;
    use crate::length::beside_dampers::DAMPED_STOP;
    use crate::length::stage_choice::StageChoice;
    use catena_mechanism::description::joint::{Joint, JointKind, Pose};
    use catena_mechanism::description::mechanism::{Body, Mechanism};
    use catena_mechanism::motion::inputs::Inputs;
    use catena_mechanism::motion::integrator::{Integrator, StepError};
    use catena_mechanism::motion::state::State;
    use nalgebra::Vector3;

    fn pendulum() -> Mechanism {
        let joint = Joint::new("hinge", JointKind::Revolute, Pose::identity(), Pose::translation(0.0, 0.0, 0.5));
        let body = Body { name: "rod".into(), parent: None, mass: 1.0, inertia: Vector3::repeat(0.1), joint };
        Mechanism::new("pendulum", Vector3::new(0.0, 9.81, 0.0), vec![body]).unwrap()
    }

    fn control() -> Control {
        Control::new(&pendulum(), 1e-3, 1e-7, StageChoice::Few)
    }

    #[test]
    fn a_step_that_cannot_be_solved_is_halved_to_the_length_at_which_it_is_given_up_and_no_further() {
        let mechanism = pendulum();
        let least = 1e-5;
        let mut lobatto = Lobatto::adaptive(&mechanism, 1e-6);
        lobatto.give_up_below(least);
        let mut state = State::zero(&mechanism);
        // No step has a solution.
        let error = lobatto.step(&mechanism, Inputs::constant(&[f64::NAN]), &mut state, 1.0).expect_err("a failure");
        let StepError::NotConverged { step, .. } = error else { panic!("{error:?}") };
        assert!(step <= least && step > 0.5 * least, "{step:e}");
    }

    #[test]
    fn the_cost_of_a_step_that_fails_is_kept_for_one_who_goes_on() {
        let mechanism = pendulum();
        let mut lobatto = Lobatto::fixed(&mechanism, 3, 0.1).expect("stages");
        let mut state = State::zero(&mechanism);
        let failed = lobatto.step(&mechanism, Inputs::constant(&[f64::NAN]), &mut state, 1.0);
        assert!(matches!(failed, Err(StepError::NotConverged { .. })), "{failed:?}");
        // The step and its fourteen halves: there is no past to do without.
        let cost = lobatto.take_abandoned();
        assert_eq!((cost.rejected.of(Rejected::NotConverged), cost.rejected.total()), (15, 15));
        assert!(cost.iterations >= 15, "{cost:?}");
        assert_eq!(lobatto.take_abandoned(), Default::default());
    }

    #[test]
    fn a_step_with_a_large_e_is_likely_kept_unless_one_of_the_last_changed_the_energy_too_much() {
        let mut control = control();
        let (wanted, limit) = (control.wanted, control.limit);
        assert!(control.is_likely_kept(limit) && !control.is_likely_kept(1.01 * limit));
        let solved = Attempt::Converged { iterations: 5, legendre: wanted, turn: 0.0, exact: false };
        let energies =
            Energies { change: 1.0, kinetic: 1.0, potential: 1.0, pull: (0.0, 0.0), pushes: 0.0, damping: 0.0 };
        assert!(matches!(control.judge(&solved, Some(energies), 0.1, Guess::Past), Decision::Retry { .. }));
        assert!(control.is_likely_kept(0.4 * wanted) && !control.is_likely_kept(wanted));
    }

    #[test]
    fn an_attempt_whose_energy_is_not_finite_is_thrown_away_and_allows_no_more_later() {
        let mut control = control();
        let solved = Attempt::Converged { iterations: 5, legendre: 1e-9, turn: 0.0, exact: false };
        let mut decision = |change, kinetic| {
            let energies = Energies { change, kinetic, potential: 1.0, pull: (0.0, 0.0), pushes: 0.0, damping: 0.0 };
            control.judge(&solved, Some(energies), 0.1, Guess::Past)
        };
        let refused = Decision::Retry { guess: Guess::Past, why: Rejected::EnergyJump };
        // 3e-5 of the largest kinetic energy so far.
        assert_eq!(decision(1e-5, 1.0), Decision::Accept);
        assert_eq!(decision(1e-4, 1.0), refused);
        for (change, kinetic) in [(f64::INFINITY, f64::INFINITY), (f64::NAN, f64::NAN)] {
            assert_eq!(decision(change, kinetic), refused, "{change}, {kinetic}");
            assert_eq!(decision(1e-4, 1.0), refused, "after {change}, {kinetic}");
        }
        assert_eq!(decision(1e-4, 10.0), Decision::Accept);
        assert_eq!(decision(1e-4, 1.0), Decision::Accept, "of a motion that has been that fast");
    }

    #[test]
    fn where_nothing_moves_a_step_may_change_the_energy_by_what_forces_do_over_roundings_of_places() {
        let solved = Attempt::Converged { iterations: 5, legendre: 1e-9, turn: 0.0, exact: true };
        let is_kept = |change, pushes| {
            let energies = Energies { change, kinetic: 1e-20, potential: 0.0, pull: (0.0, 0.0), pushes, damping: 0.0 };
            control().judge(&solved, Some(energies), 0.1, Guess::Past) == Decision::Accept
        };
        // 7 N over 1e-13 m.
        assert!(is_kept(5e-13, 7.0) && is_kept(-5e-13, 7.0));
        assert!(!is_kept(1e-12, 7.0) && !is_kept(5e-13, 0.0));
    }

    #[test]
    fn a_kink_is_passed_in_the_smoothest_step_where_the_energy_allows_it_and_approached_where_not() {
        for change in [1e-9, 1e-2] {
            let mut control = control();
            let limit = control.limit;
            let mut attempt = |step, large: f64| {
                let legendre = large * limit;
                let solved = Attempt::Converged { iterations: 5, legendre, turn: 0.0, exact: false };
                let broken_off = Attempt::Inaccurate { iterations: 4, legendre };
                let energies =
                    Energies { change, kinetic: 1.0, potential: 1.0, pull: (0.0, 0.0), pushes: 0.0, damping: 0.0 };
                let decision = if large <= 2.0 {
                    control.judge(&solved, Some(energies), step, Guess::Past)
                } else {
                    control.judge(&broken_off, None, step, Guess::Past)
                };
                (decision, control.step())
            };
            // An E that does not fall with the step, after one that did.
            for (step, large) in [(0.2, 9.0), (0.1, 2.0), (0.08, 3.0)] {
                let (decision, next) = attempt(step, large);
                assert_eq!(decision, Decision::Retry { guess: Guess::Longer(step), why: Rejected::NotSmooth });
                assert!(next < step, "{next} after {step}");
            }
            assert_eq!(attempt(0.04, 4.0), (Decision::Retry { guess: Guess::Past, why: Rejected::NotSmooth }, 0.1));
            let (decision, next) = attempt(0.1, 2.0);
            if change < 1e-3 {
                assert_eq!(decision, Decision::Accept);
            } else {
                let refused = Decision::Retry { guess: Guess::Past, why: Rejected::EnergyJump };
                assert!(decision == refused && next < 0.1, "{decision:?}, {next}");
                let (decision, next) = attempt(0.03, 5.0);
                let shorter = Decision::Retry { guess: Guess::Longer(0.03), why: Rejected::NotSmooth };
                assert!(decision == shorter && next < 0.03, "{decision:?}, {next}");
            }
        }
    }

    #[test]
    fn a_change_of_energy_is_rounding_where_e_is_or_where_half_the_step_changes_as_much() {
        let judge = |control: &mut Control, step, legendre| {
            let solved = Attempt::Converged { iterations: 5, legendre, turn: 0.0, exact: false };
            // Ten times the allowed change of a step, and no more than roundings.
            let energies =
                Energies { change: 3e-7, kinetic: 1.0, potential: 1.0, pull: (0.0, 0.0), pushes: 0.0, damping: 0.0 };
            control.judge(&solved, Some(energies), step, Guess::Past) == Decision::Accept
        };
        let tight = || Control { tolerance: 1e-6, ..control() };
        let mut shape = tight();
        assert!([0.1, 0.06, 0.04].map(|step| judge(&mut shape, step, 1e-9)) == [false, false, true]);
        assert!(judge(&mut tight(), 0.1, 1e-15));
    }

    #[test]
    fn a_step_with_dampers_that_changes_the_energy_too_much_is_solved_to_rounding_before_it_is_made_shorter() {
        let mut control = control();
        let solved = Attempt::Converged { iterations: 5, legendre: 1e-9, turn: 0.0, exact: false };
        let judge = |control: &mut Control, change, step, damping| {
            let energies = Energies { change, kinetic: 1.0, potential: 1.0, pull: (0.0, 0.0), pushes: 0.0, damping };
            control.judge(&solved, Some(energies), step, Guess::Past)
        };
        let again = |guess| Decision::Retry { guess, why: Rejected::EnergyJump };
        let stop = |control: &Control| control.beside_dampers(control.rule(), 1.0, 0.1).increment;
        // The stop of this control is 1e-7. 3e-5 of the kinetic energy is allowed.
        assert!(stop(&control) == 1e-7);
        assert_eq!(judge(&mut control, 1e-3, 0.1, 1.0), again(Guess::Longer(0.1)));
        assert!(stop(&control) == DAMPED_STOP && control.step() == 0.1);
        // Solved to rounding, it is truncation, and the step too long.
        assert_eq!(judge(&mut control, 1e-3, 0.1, 1.0), again(Guess::Past));
        assert!(control.step() < 0.1 && stop(&control) == DAMPED_STOP);
        assert_eq!(judge(&mut control, 1e-6, 0.05, 1.0), Decision::Accept);
        assert_eq!(control.memory.ringing, 0.0);
        // Rates of 1e-3 in a second take 0.05 J from a damper of 1e6 N s/m in 0.05 s: these are no energy of the motion.
        assert_eq!(judge(&mut control, 0.04, 0.05, 1e6), Decision::Accept);
        assert_eq!(control.memory.ringing, 0.04);
        assert_eq!(judge(&mut control, 0.06, 0.05, 1e6), again(Guess::Past));
        // Springs alone get a shorter step at once, and roundings of their energy are no work of dampers.
        let mut sprung = Control { tolerance: 1e-6, ..self::control() };
        assert_eq!(judge(&mut sprung, 3e-7, 0.1, 0.0), again(Guess::Past));
        assert_eq!(judge(&mut sprung, 3e-7, 0.04, 0.0), Decision::Accept);
        assert_eq!(sprung.memory.ringing, 0.0);
    }
}
