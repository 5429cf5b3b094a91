//! What a run tells of its accuracy while it goes on, and when it is interrupted.

use crate::assessed::{options, told};
use crate::closed;
use crate::models;
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::integrator::MethodDescription;
use catena::mechanism::motion::state::State;
use catena::simulation::{
    AccuracySoFar, Finished, Observer, ObserverError, RunError, Sample, Simulation, SimulationOptions, UnknownAccuracy,
};
use std::sync::atomic::{AtomicBool, Ordering};

/// Interrupts a run at its first sample after some time (s).
struct Interrupting<'f>(&'f AtomicBool, f64);

impl Observer for Interrupting<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        if sample.time >= self.1 {
            self.0.store(true, Ordering::Relaxed);
        }
        Ok(())
    }
}

#[test]
fn a_run_that_is_interrupted_tells_its_accuracy_up_to_there_and_nothing_if_it_has_not_begun() {
    let model = models::double_pendulum();
    for after in [0.0, 1.0] {
        let flag = AtomicBool::new(false);
        let mut observer = Interrupting(&flag, after);
        let options = SimulationOptions { interrupt: Some(&flag), ..options(10.0, 1e-6) };
        let mut simulation = Simulation::new(&model.mechanism, model.state.clone(), options).expect("a simulation");
        simulation.sample_at(10.0);
        simulation.observe(&mut observer);
        assert!(matches!(simulation.run(), Err(RunError::Interrupted { .. })));
        let finished = simulation.finish();
        if after == 0.0 {
            assert!(matches!(finished.accuracy[0], Err(UnknownAccuracy::NotYet)), "{:?}", finished.accuracy);
            continue;
        }
        let told = told(&finished);
        assert_eq!(told.holds_until, finished.state.time);
        assert!(told.estimate > 0.0 && told.estimate < 1e-6, "{told:?}");
    }
}

/// Keeps the accuracies that a run tells, and interrupts it in the step after `until` is true of one.
struct Listening<'f> {
    flag: &'f AtomicBool,
    until: fn(&AccuracySoFar) -> bool,
    is_due: bool,
    told: Vec<AccuracySoFar>,
}

impl<'f> Listening<'f> {
    fn new(flag: &'f AtomicBool, until: fn(&AccuracySoFar) -> bool) -> Self {
        Listening { flag, until, is_due: false, told: Vec::new() }
    }
}

impl Observer for Listening<'_> {
    fn begin_again(&mut self, _: &MethodDescription) -> Result<(), ObserverError> {
        self.told.clear();
        Ok(())
    }

    fn accuracy(&mut self, so_far: &AccuracySoFar) {
        self.told.push(*so_far);
        self.is_due = (self.until)(so_far);
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        if self.is_due && self.told.last().is_some_and(|told| sample.time > told.time) {
            self.flag.store(true, Ordering::Relaxed);
        }
        Ok(())
    }
}

/// Runs a model until it is interrupted; returns the run and the accuracies that it told.
fn interrupted(
    model: &models::Model,
    duration: f64,
    until: fn(&AccuracySoFar) -> bool,
) -> (Finished, Vec<AccuracySoFar>) {
    let flag = AtomicBool::new(false);
    let mut listening = Listening::new(&flag, until);
    let options = SimulationOptions { interrupt: Some(&flag), ..options(duration, 1e-6) };
    let mut simulation = Simulation::new(&model.mechanism, model.state.clone(), options).expect("a simulation");
    simulation.sample_at(20.0);
    simulation.observe(&mut listening);
    assert!(matches!(simulation.run(), Err(RunError::Interrupted { .. })));
    (simulation.finish(), listening.told)
}

#[test]
fn a_chaotic_run_tells_while_it_goes_on_until_when_its_accuracy_holds_and_so_does_its_report_if_it_is_interrupted_later()
 {
    let (finished, so_far) = interrupted(&models::chain(6), 1000.0, |so_far| !so_far.holds());
    let (told, here) = (told(&finished), finished.state.time);
    println!("{told:?} at t = {here} s, {} times", so_far.len());
    // The run was interrupted long before its end. It told the growth of the error from below the tolerance to above it.
    assert!(here < 100.0, "interrupted at t = {here} s");
    let held = so_far.iter().filter(|so_far| so_far.holds()).count();
    assert!(held >= 10, "{held} times held");
    assert!(so_far.windows(2).all(|two| two[0].time < two[1].time && two[0].estimate <= two[1].estimate));
    assert!(so_far.iter().all(|so_far| so_far.holds() == (so_far.estimate <= so_far.wanted)), "{so_far:?}");
    let last = so_far.last().expect("something told");
    assert!(last.holds_until > 1.0 && last.holds_until < last.time && last.time <= here, "{last:?}");
    // A separate run was asked before the accuracy was said to end, and does not catch up once it is interrupted.
    assert_eq!((told.holds_until, told.told_until), (last.holds_until, last.time));
}

#[test]
fn a_run_beside_another_does_not_catch_up_once_that_is_interrupted_and_the_report_says_up_to_when_it_tells() {
    let (mechanism, state) = closed::four_bars(1, 5);
    let model = models::Model { mechanism, state };
    // The interruption is between two estimates, which are four or more steps apart. The separate run is at the earlier one.
    let (finished, so_far) = interrupted(&model, 40.0, |so_far| so_far.time > 2.0);
    let (told, here) = (told(&finished), finished.state.time);
    println!("{told:?} at t = {here} s");
    let last = so_far.last().expect("something told");
    assert_eq!((told.told_until, told.holds_until), (last.time, last.time), "interrupted at t = {here} s");
    assert!(told.told_until < here && told.estimate > 0.0 && told.estimate < 1e-6, "{told:?}");
}

#[test]
fn parts_that_nothing_connects_tell_together_what_each_tells_and_twice_the_same() {
    let flag = AtomicBool::new(false);
    let chain = |name: &str| {
        let Mechanism { mut bodies, .. } = models::chain(12).mechanism;
        bodies.iter_mut().for_each(|body| body.joint.name = format!("{name} {}", body.joint.name));
        bodies
    };
    let (mut bodies, second) = (chain("first"), chain("second"));
    let first = bodies.len();
    bodies.extend(second.into_iter().map(|body| Body { parent: body.parent.map(|parent| parent + first), ..body }));
    let mechanism = Mechanism::new("two", models::gravity(), bodies).expect("a mechanism");
    let mut start = State::zero(&mechanism);
    // The two chains move differently, so that they take different steps.
    (start.velocity[0], start.velocity[first + 2]) = (1.0, 3.0);
    let tell = || {
        let mut listening = Listening::new(&flag, |_| false);
        let mut simulation = Simulation::new(&mechanism, start.clone(), options(0.3, 1e-6)).expect("a simulation");
        simulation.sample_at(20.0);
        simulation.observe(&mut listening);
        simulation.run().expect("a run");
        let all = simulation.finish().accuracy;
        (listening.told, all)
    };
    let (so_far, all) = tell();
    assert_eq!(all.len(), 2, "of each part");
    let worst = all.iter().flatten().map(|told| told.estimate).fold(0.0, f64::max);
    let last = so_far.last().expect("something told");
    assert_eq!((last.time, last.holds_until, last.estimate), (0.3, 0.3, worst), "{all:?}");
    assert_eq!(tell().0, so_far, "once more");
}
