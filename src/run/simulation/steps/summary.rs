//! The figures of a run, collected step by step.

use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::closure::Coordinate;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::MotorLaw;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::contact_point::ContactFigures;
use crate::mechanism::motion::energy::{Energy, Violation, energy_with_forces, violation};
use crate::mechanism::motion::event::EventCounts;
use crate::mechanism::motion::gaps::worse;
use crate::mechanism::motion::integrator::{Cost, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::simulation::steps::observer::{Counts, StepEnd};
use crate::stepping::watching::unseen::Pushes;

/// The figures of a whole run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Accepted steps.
    pub steps: usize,
    /// The work for them: iterations, and attempts that were thrown away.
    pub cost: Cost,
    /// Accepted steps whose equations the exact Newton method solved: all with closed loops, and steps in which no other iteration converges.
    pub exact_steps: usize,
    /// CPU time in the integrator alone (s): the time of the thread, divided in proportion to wall-clock time. A reading of the thread's own time is
    /// a system call, which would take as long as a small step.
    pub solve_cpu_seconds: f64,
    /// Energy at the start.
    pub initial_energy: Energy,
    /// Energy at the end.
    pub final_energy: Energy,
    /// Energy dissipated over the run, and work put in by forces without a potential (J).
    pub exchange: Exchange,
    /// Largest deviation of the total energy, plus the dissipated energy, less the work put in, from its start, relative to the largest kinetic
    /// energy seen. What dampers, friction and impacts give in a step explains no energy, because they can only take some.
    pub max_relative_energy_error: f64,
    /// That deviation (J).
    pub max_energy_error: f64,
    /// The largest kinetic energy seen (J).
    pub largest_kinetic: f64,
    /// The most that all forces have pushed with, added up [N or N m].
    pub pushes: f64,
    /// The most that the springs of motors, `½ kp (r − q)²` up to their bounds, had stored at the end of any step (J).
    pub held: f64,
    /// The most that these springs pulled with at the end of any step, added up [N or N m].
    pub pulled: f64,
    /// Largest violation of any constraint at the end of any step.
    pub max_violation: Violation,
    /// How many events there were of each kind.
    pub events: EventCounts,
    /// The worst of the contacts at the end of any step.
    pub contact: ContactFigures,
    /// When shapes overlapped most (s).
    pub deepest_at: f64,
}

/// Kinetic energies below this part of the others belong to a robot at rest.
const AT_REST: f64 = 1e-9;

/// Energies below this part of the kinetic one, or below this part of what is stored, which dampers, friction and impacts seem to give in a step, are
/// roundings.
const GIVEN: f64 = 1e-12;
const ROUNDED: f64 = 1e-13;

/// Events of a run that are kept, the first ones.
pub(crate) const KEPT_EVENTS: usize = 1000;

impl Summary {
    /// The figures before the first step from a state.
    pub(crate) fn at_start(mechanism: &Mechanism, state: &State, bodies: &[BodyState]) -> Self {
        let initial = energy_with_forces(mechanism, &state.position, bodies);
        let mut summary = Summary {
            initial_energy: initial,
            final_energy: initial,
            max_violation: violation(mechanism, state, bodies),
            ..Summary::default()
        };
        summary.see_forces(mechanism, state, initial.spring);
        summary
    }

    /// Takes what forces push and motors hold with in a state with this energy of springs (J).
    fn see_forces(&mut self, mechanism: &Mechanism, state: &State, stored: f64) {
        let (held, pulled) = held(mechanism, state);
        self.pushes = self.pushes.max(pushes(mechanism, state, stored));
        (self.held, self.pulled) = (self.held.max(held), self.pulled.max(pulled));
    }

    /// Counts an accepted step, with the constraint errors at its end.
    pub(crate) fn count(&mut self, outcome: &StepOutcome, violation: Violation) {
        self.steps += 1;
        self.cost.add(&outcome.cost);
        self.exact_steps += usize::from(outcome.exact);
        self.max_violation.position = worse(self.max_violation.position, violation.position);
        self.max_violation.velocity = worse(self.max_violation.velocity, violation.velocity);
    }

    /// Takes the worst contacts of a step, or of a run, that overlapped most at a time (s).
    pub(crate) fn see_contacts(&mut self, contact: &ContactFigures, deepest_at: f64) {
        if contact.penetration > self.contact.penetration {
            self.deepest_at = deepest_at;
        }
        self.contact.include(contact);
    }

    /// Takes the worst contacts of a part of the run, and what its motors held, if that is the most of all parts.
    pub(crate) fn see_part(&mut self, part: &Summary) {
        self.see_contacts(&part.contact, part.deepest_at);
        self.pushes = self.pushes.max(part.pushes);
        (self.held, self.pulled) = (self.held.max(part.held), self.pulled.max(part.pulled));
    }

    /// Steps and their cost so far.
    pub(crate) fn counts(&self) -> Counts {
        let Cost { iterations, rejected, .. } = self.cost;
        Counts { steps: self.steps, iterations, rejected: rejected.total() }
    }
}

/// Collects the figures of the run.
pub(crate) struct Bookkeeper {
    pub summary: Summary,
    pub last: StepEnd,
    largest_kinetic: f64,
    largest_deviation: f64,
    /// Whether there are motors.
    driven: bool,
    /// What dampers, friction and impacts have given in steps (J).
    given: f64,
    /// The rounding errors of the sums of dissipated energy and work.
    rest: Exchange,
}

impl Bookkeeper {
    pub fn new(mechanism: &Mechanism, state: &State, bodies: &[BodyState]) -> Self {
        let summary = Summary::at_start(mechanism, state, bodies);
        let initial = summary.initial_energy;
        Bookkeeper {
            summary,
            last: StepEnd {
                time: state.time,
                energy: initial,
                exchange: Exchange::default(),
                deviation: 0.0,
                violation: summary.max_violation,
                outcome: StepOutcome::default(),
                so_far: Counts::default(),
            },
            largest_kinetic: initial.kinetic,
            largest_deviation: 0.0,
            driven: !mechanism.nonsmooth.motors.is_empty(),
            given: 0.0,
            rest: Exchange::default(),
        }
    }

    pub fn record(&mut self, mechanism: &Mechanism, state: &State, bodies: &[BodyState], outcome: StepOutcome) {
        let energy = energy_with_forces(mechanism, &state.position, bodies);
        let violation = violation(mechanism, state, bodies);
        let summary = &mut self.summary;
        add(&mut summary.exchange.dissipated, &mut self.rest.dissipated, outcome.exchange.dissipated);
        add(&mut summary.exchange.work, &mut self.rest.work, outcome.exchange.work);
        add(&mut summary.exchange.friction, &mut self.rest.friction, outcome.exchange.friction);
        add(&mut summary.exchange.impacts, &mut self.rest.impacts, outcome.exchange.impacts);
        let exchange = summary.exchange;
        summary.count(&outcome, violation);
        let so_far = summary.counts();
        summary.final_energy = energy;
        // Energy that impacts took was kinetic before, also if the step ends with them.
        self.largest_kinetic = self.largest_kinetic.max(energy.kinetic + outcome.exchange.impacts.max(0.0));
        summary.largest_kinetic = self.largest_kinetic;
        summary.see_forces(mechanism, state, energy.spring);
        self.given += given(&outcome.exchange, &Energy { kinetic: self.largest_kinetic, ..energy });
        let deviation = energy.total() - summary.initial_energy.total() + exchange.lost() + self.given;
        self.last = StepEnd { time: state.time, energy, exchange, deviation, violation, outcome, so_far };
        self.largest_deviation = worse(self.largest_deviation, deviation.abs());
        summary.max_energy_error = self.largest_deviation;
        let moved = if self.driven { moved_by_motors(&exchange, &energy) } else { 0.0 };
        let scale = self.largest_kinetic.max(moved);
        summary.max_relative_energy_error =
            if scale > 0.0 { self.largest_deviation / scale } else { self.largest_deviation };
    }
}

/// The energy that dampers, friction and impacts have given in a step of this exchange (J), beyond roundings of the energies there. Each of them takes
/// energy, and belts and motors that move joints do work.
fn given(exchange: &Exchange, energy: &Energy) -> f64 {
    let given = -(exchange.dissipated + exchange.friction + exchange.impacts);
    let rounding =
        GIVEN * energy.kinetic + ROUNDED * (energy.potential.abs() + energy.spring.abs() + energy.load.abs());
    if given > rounding { given } else { 0.0 }
}

/// The energy that motors have moved (J). They hold a robot with next to no motion: the balance is one of the energies that they move, too.
pub(crate) fn moved_by_motors(exchange: &Exchange, energy: &Energy) -> f64 {
    let exchanged = exchange.dissipated.abs() + exchange.work.abs() + exchange.friction + exchange.impacts;
    exchanged.max(AT_REST * (energy.potential.abs() + energy.spring))
}

/// The energy that springs of motors store in a state, up to their bounds (J), and what they pull with, added up [N or N m].
fn held(mechanism: &Mechanism, state: &State) -> (f64, f64) {
    let motors = mechanism.nonsmooth.motors.iter().filter(|motor| matches!(motor.law, MotorLaw::Position { .. }));
    motors.fold((0.0, 0.0), |(stored, pulled), motor| {
        let stretch = (motor.target.value(state.time) - state.position[motor.coordinate.position]).abs();
        let pull = (motor.law.gains().0 * stretch).min(motor.max_effort);
        (stored + 0.5 * stretch * pull, pulled + pull)
    })
}

/// Sum of the sizes of all forces of a mechanism in a state [N or N m]; `stored` is the energy of its springs (J).
fn pushes(mechanism: &Mechanism, state: &State, stored: f64) -> f64 {
    let motors = mechanism.nonsmooth.motors.iter().map(|motor| {
        let Coordinate { position, freedom, .. } = motor.coordinate;
        motor.effort(state.time, state.position[position], state.velocity[freedom]).abs()
    });
    Pushes::of(mechanism).with(stored, motors.sum())
}

/// `sum += term`, compensated (Kahan).
fn add(sum: &mut f64, rest: &mut f64, term: f64) {
    let wanted = term + *rest;
    let next = *sum + wanted;
    *rest = wanted - (next - *sum);
    *sum = next;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::Body;
    use crate::mechanism::motion::kinematics::body_states;
    use nalgebra::Vector3;

    /// The largest error of the energy balance (J) if a body of 2 kg passes from 1 m/s to this speed (m/s) in a step with this exchange.
    fn error_behind(speed: f64, exchange: Exchange) -> f64 {
        let joint = Joint::new("body", JointKind::Floating, Pose::identity(), Pose::identity());
        let body = Body { name: "body".into(), parent: None, mass: 2.0, inertia: Vector3::repeat(0.01), joint };
        let mechanism = Mechanism::new("body", Vector3::zeros(), vec![body]).expect("a body");
        let mut state = State::zero(&mechanism);
        state.velocity[0] = 1.0;
        let mut bookkeeper = Bookkeeper::new(&mechanism, &state, &body_states(&mechanism, &state));
        state.velocity[0] = speed;
        let outcome = StepOutcome::new(0.01, 1, exchange);
        bookkeeper.record(&mechanism, &state, &body_states(&mechanism, &state), outcome);
        bookkeeper.summary.max_energy_error
    }

    #[test]
    fn energy_that_an_impact_gives_is_an_error_of_the_balance_and_what_it_takes_or_a_belt_gives_is_not() {
        // From 1 J to 4 J, or to 0.25 J.
        let of_impacts = |impacts: f64| Exchange { impacts, ..Exchange::default() };
        assert_eq!(error_behind(2.0, of_impacts(-3.0)), 3.0);
        assert_eq!(error_behind(0.5, of_impacts(0.75)), 0.0);
        assert_eq!(error_behind(2.0, Exchange { work: 3.0, ..Exchange::default() }), 0.0);
        // An impact upon a belt: it does work, and friction takes some of it.
        assert_eq!(error_behind(2.0, Exchange { work: 3.5, friction: 0.25, ..of_impacts(0.25) }), 0.0);
        // Roundings are no gain.
        assert!(error_behind(1.0, of_impacts(-1e-16)) < 1e-15);
    }
}
