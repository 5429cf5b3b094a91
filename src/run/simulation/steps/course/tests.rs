//! Forces of contacts that last, and of contacts that do not.

use super::*;
use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
use crate::mechanism::description::joint::{Joint, JointKind, Pose};
use crate::mechanism::description::mechanism::Body;
use crate::mechanism::motion::integrator::MethodDescription;
use nalgebra::Vector3;

/// Makes steps of given lengths (s), with a contact at the end of each whose force pulls (N); those from a number on are of first order.
struct Pulling {
    steps: Vec<(f64, f64)>,
    made: usize,
    exact: usize,
}

impl Integrator for Pulling {
    fn step(&mut self, _: &Mechanism, _: Inputs, state: &mut State, until: f64) -> Result<StepOutcome, StepError> {
        let (step, _) = self.steps[self.made];
        self.made += 1;
        state.time = if self.made == self.steps.len() { until } else { state.time + step };
        Ok(StepOutcome { step, ..StepOutcome::default() })
    }

    fn dense(&mut self, _: &Mechanism, _: f64, _: &mut [f64], _: &mut [f64]) {}

    fn description(&self) -> MethodDescription {
        let first_order_steps = self.made.saturating_sub(self.exact);
        MethodDescription { first_order_steps, ..MethodDescription::fixed("pulling", 2, 2, 0.1) }
    }

    fn contacts(&self, _: &Mechanism, _: &State, out: &mut Vec<ContactPoint>) {
        let force = Vector3::z() * -self.steps[self.made - 1].1;
        let (position, normal) = (Vector3::zeros(), Vector3::z());
        out.push(ContactPoint { pair: 0, position, normal, force, gap: -1e-9, sticks: true });
    }
}

#[test]
fn forces_of_what_was_closed_for_no_time_or_before_a_step_of_first_order_do_not_count_and_those_at_the_end_do() {
    let joint = Joint::new("ball", JointKind::Floating, Pose::identity(), Pose::identity());
    let body = Body { name: "ball".into(), parent: None, mass: 1.0, inertia: Vector3::repeat(1.0), joint };
    let mut mechanism = Mechanism::new("ball", Vector3::zeros(), vec![body]).expect("a free body");
    for (body, shape) in [(Some(0), Shape::Sphere { radius: 0.1 }), (None, Shape::HalfSpace)] {
        let collider = Collider::still("one", body, Pose::identity(), shape);
        mechanism.nonsmooth.colliders.push(collider);
    }
    mechanism.nonsmooth.pairs.push(ContactPair::without_moments(0, [0, 1], 0.5, 0.0));
    // Each step with the pull at its end; the one that follows says whether that has lasted.
    let worst_of = |steps: &[(f64, f64)], exact: usize| {
        let mut state = State::zero(&mechanism);
        let mut integrator = Pulling { steps: steps.to_vec(), made: 0, exact };
        let options = RunOptions { duration: 1.0, rate: None, interrupt: None };
        let (summary, ended) = run(&mechanism, &mut state, &mut integrator, &options, &mut []);
        ended.expect("to the end");
        assert_eq!(summary.contact.penetration, 1e-9);
        summary.contact.cone_violation
    };
    let worst = |steps: &[(f64, f64)]| worst_of(steps, steps.len());
    assert_eq!(worst(&[(0.5, 7.0), (0.0, 0.0), (0.5, 0.0)]), 0.0);
    assert_eq!(worst(&[(0.5, 7.0), (0.1, 0.0), (0.4, 0.0)]), 7.0);
    assert_eq!(worst(&[(0.5, 7.0), (0.0, 3.0), (0.5, 1.0)]), 3.0);
    assert_eq!(worst(&[(0.5, 0.0), (0.5, 2.0)]), 2.0);
    // A step of first order follows, and does not make one that follows it less exact.
    assert_eq!(worst_of(&[(0.5, 7.0), (0.1, 0.0), (0.4, 0.0)], 1), 0.0);
    assert_eq!(worst_of(&[(0.1, 0.0), (0.5, 7.0), (0.4, 0.0)], 2), 0.0);
    assert_eq!(worst_of(&[(0.5, 7.0), (0.1, 3.0), (0.4, 0.0)], 2), 7.0);
}
