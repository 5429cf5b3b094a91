//! The cost of events: attempts that end a step at an event are told from those that were thrown away, and each problem at an event is counted with the
//! solver that has solved it.

use crate::contacts::{ball, placed};
use crate::mechanisms::{GRAVITY, of_kind, run};
use catena::mechanism::motion::contact_solvers::{ContactSolver, ContactSolvers};
use catena::mechanism::motion::event::EventKind;
use catena::simulation::{Finished, StepChoice};
use nalgebra::Vector3;

/// A ball that falls 0.6 m onto a floor without friction, in steps for a tolerance of 1e-6 m.
fn fall(restitution: f64, duration: f64) -> Finished {
    let mechanism = ball(0.05, Vector3::new(0.0, 0.0, -GRAVITY), 0.0, restitution);
    let start = placed(&mechanism, Vector3::new(0.0, 0.0, 0.65), Vector3::zeros(), Vector3::zeros());
    run(&mechanism, &start, duration, StepChoice::Tolerance(1e-6))
}

/// These counts and no others.
fn solved(counts: &[(ContactSolver, usize)]) -> ContactSolvers {
    let mut all = ContactSolvers::default();
    for &(by, count) in counts {
        (0..count).for_each(|_| all.count(by));
    }
    all
}

#[test]
fn a_step_that_is_shortened_to_end_at_an_impact_is_not_a_rejected_one() {
    // It lands after 0.35 s. The fall is a parabola, which every step solves at once, and which the dense output gives exactly: one attempt ends the
    // step there.
    let finished = fall(0.0, 0.5);
    let cost = finished.summary.cost;
    assert_eq!(of_kind(&finished, EventKind::ContactImpact).len(), 1);
    assert_eq!((cost.rejected.total(), cost.located), (0, 1), "{cost:?}");
    // The impact is a problem, and the forces of the contact that stays closed are another.
    assert_eq!(finished.method.contact_solvers, solved(&[(ContactSolver::Cold, 2)]));
}

#[test]
fn every_impact_with_a_rebound_is_solved_once_without_it_and_once_more_from_that_answer() {
    // Impacts at 0.35, 0.84 and 1.18 s; the next one would be at 1.42 s.
    let finished = fall(0.7, 1.3);
    assert_eq!(of_kind(&finished, EventKind::ContactImpact).len(), 3);
    let counts = [(ContactSolver::Cold, 3), (ContactSolver::Warm, 3)];
    assert_eq!(finished.method.contact_solvers, solved(&counts));
}
