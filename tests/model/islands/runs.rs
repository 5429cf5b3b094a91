//! A run of islands: every one moves as if it were alone, whatever the number of threads, and the figures, ends and failures
//! are those of the whole.

use super::{Seen, Way, parts, pendulum, run_islands, side_by_side};
use crate::models::Model;
use crate::{closed, common, models};
use catena::mechanism::description::joint::JointKind;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::mechanism::structure::islands::islands;
use catena::simulation::parallel::islands::Islands;
use catena::simulation::parallel::partition::Plan;
use catena::simulation::parallel::threads::Threads;
use catena::simulation::{Observer, ObserverError, RunError, RunOptions, Sample, Summary, run};
use catena::stepping::integrator::Lobatto;
use std::sync::atomic::{AtomicBool, Ordering};

/// Trees, a tree with every force, and two four-bars with a loop each.
fn zoo() -> Model {
    let forced = models::floating_tree();
    let every = models::every_force(&forced.mechanism).pop().expect("all forces").1;
    side_by_side(vec![
        parts(models::double_pendulum()),
        parts(models::with_forces(forced, every)),
        closed::four_bars(1, 5),
        parts(models::chain(6)),
        parts(models::one_joint(JointKind::Spherical)),
    ])
}

#[test]
fn every_island_moves_as_if_it_were_alone_bit_for_bit_on_any_number_of_threads() {
    let model = zoo();
    for way in [Way::Fixed(5, 0.01), Way::Tolerance(1e-6)] {
        let options = RunOptions { duration: 1.0, rate: Some(37.0), interrupt: None };
        let (state, summary, seen) = run_islands(&model, way, &options, 1);
        for threads in [2, 5] {
            assert_eq!(
                (state.clone(), summary, seen.clone()),
                run_islands(&model, way, &options, threads),
                "{threads}"
            );
        }
        let (mut steps, mut iterations) = (0, 0);
        for island in islands(&model.mechanism) {
            let (mut alone, mut seen_alone) = (island.state(&model.state), Seen::default());
            let mut integrator = way.integrator(&island.mechanism, &alone, 1.0);
            let (figures, ended) =
                run(&island.mechanism, &mut alone, &mut integrator, &options, &mut [&mut seen_alone]);
            ended.expect("a run");
            assert_eq!(alone, island.state(&state), "{:?}", island.roots().collect::<Vec<_>>());
            assert_eq!(seen.samples.len(), seen_alone.samples.len());
            for (whole, own) in seen.samples.iter().zip(&seen_alone.samples) {
                let mut expected = whole.clone();
                island.put(&own.1, &mut expected.1, |piece| &piece.positions);
                island.put(&own.2, &mut expected.2, |piece| &piece.velocities);
                assert_eq!(own.0, whole.0);
                assert_eq!(*whole, expected, "t = {}", whole.0);
            }
            (steps, iterations) = (steps + figures.steps, iterations + figures.cost.iterations);
        }
        assert_eq!((steps, iterations), (summary.steps, summary.cost.iterations));
    }
}

#[test]
fn the_figures_of_a_run_of_islands_are_those_of_the_whole() {
    let model = zoo();
    let options = RunOptions { duration: 1.0, rate: None, interrupt: None };
    let (_, apart, seen) = run_islands(&model, Way::Fixed(6, 0.01), &options, 2);
    assert_eq!(seen.samples.len(), 2, "without a rate only both ends are shown");
    let mut whole = model.state.clone();
    let mut lobatto = Lobatto::fixed(&model.mechanism, 6, 0.01).expect("six stages");
    let together = common::run_until(&model.mechanism, &mut whole, &mut lobatto, 1.0);
    assert_eq!(apart.steps, 5 * together.steps);
    // The same scheme solved to rounding; energies are of order 10 J.
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} is not {b}");
    near(apart.initial_energy.total(), together.initial_energy.total());
    near(apart.final_energy.total(), together.final_energy.total());
    near(apart.exchange.dissipated, together.exchange.dissipated);
    near(apart.exchange.work, together.exchange.work);
    assert!(together.exchange.dissipated > 1e-3, "the zoo dissipates");
    // What is not accounted for is the error of the quadrature of the damping in both; kinetic energies are of common times.
    let ratio = apart.max_relative_energy_error / together.max_relative_energy_error;
    assert!((0.5..2.0).contains(&ratio), "{apart:?} {together:?}");
    assert!(apart.max_violation.position < 1e-12, "{apart:?}");
}

#[test]
fn a_run_taken_up_again_goes_on_as_if_it_had_not_stopped() {
    let model = zoo();
    let make = |part: &Mechanism, _: &State| Lobatto::fixed(part, 4, 0.01).map(|lobatto| (lobatto, ()));
    let ends = [vec![1.0], vec![0.25, 0.75]].map(|durations| {
        let plan = Plan::new(&model.mechanism, &model.state, &[]);
        let (mut all, _) = Islands::new(plan, &model.state, Threads::Exactly(2), make).expect("integrators");
        let mut state = model.state.clone();
        for duration in durations {
            let options = RunOptions { duration, rate: None, interrupt: None };
            all.run(&model.mechanism, &mut state, &options, &mut []).1.expect("a run");
        }
        state
    });
    assert_eq!(ends[0], ends[1]);
}

/// Sets the flag at a sample.
struct Stopper<'f> {
    flag: &'f AtomicBool,
    at: f64,
    last: f64,
}

impl Observer for Stopper<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        self.flag.store(sample.time >= self.at, Ordering::Relaxed);
        self.last = sample.time;
        Ok(())
    }
}

#[test]
fn an_interrupted_run_ends_at_a_sample_that_all_islands_have_reached() {
    let model = zoo();
    let flag = AtomicBool::new(false);
    let plan = Plan::new(&model.mechanism, &model.state, &[]);
    let make = |part: &Mechanism, _: &State| Lobatto::fixed(part, 5, 0.01).map(|lobatto| (lobatto, ()));
    let (mut all, _) = Islands::new(plan, &model.state, Threads::Exactly(2), make).expect("integrators");
    let mut state = model.state.clone();
    let mut stopper = Stopper { flag: &flag, at: 0.3, last: 0.0 };
    let options = RunOptions { duration: 1e6, rate: Some(20.0), interrupt: Some(&flag) };
    let (summary, ended) = all.run(&model.mechanism, &mut state, &options, &mut [&mut stopper]);
    assert!(matches!(ended, Err(RunError::Interrupted { time }) if time == state.time), "{ended:?}");
    assert!(state.time >= 0.3 && state.time == stopper.last, "{} {}", state.time, stopper.last);
    assert!(state.time < 1e6 && summary.steps > 0);
    // All islands are at that instant: the zoo run to there by itself agrees as well as dense output does at this step.
    let mut exact = model.state.clone();
    let mut lobatto = Lobatto::fixed(&model.mechanism, 5, 0.01).expect("five stages");
    let _ = common::run_until(&model.mechanism, &mut exact, &mut lobatto, state.time);
    let distance =
        models::pose_distance(&body_states(&model.mechanism, &state), &body_states(&model.mechanism, &exact));
    assert!(distance < 1e-6, "{distance:.1e}");
}

#[test]
fn the_first_failure_ends_the_run_there_whatever_the_number_of_threads() {
    // A spring beyond what the step is stable for: the second island fails after some steps, the first would go on.
    let mut stiff = models::one_joint(JointKind::Prismatic);
    stiff.mechanism.forces = models::point_springs(&stiff.mechanism);
    stiff.mechanism.forces.point_springs[0].stiffness = 3e5;
    let model = side_by_side(vec![parts(models::chain(5)), parts(stiff)]);
    let ends: Vec<(State, Summary, String, usize)> = [1, 2]
        .map(|threads| {
            let plan = Plan::new(&model.mechanism, &model.state, &[]);
            let make = |part: &Mechanism, _: &State| Lobatto::fixed(part, 2, 0.02).map(|lobatto| (lobatto, ()));
            let (mut all, _) = Islands::new(plan, &model.state, Threads::Exactly(threads), make).expect("made");
            let (mut state, mut seen) = (model.state.clone(), Seen::default());
            let options = RunOptions { duration: 20.0, rate: Some(1000.0), interrupt: None };
            let (summary, ended) = all.run(&model.mechanism, &mut state, &options, &mut [&mut seen]);
            let error = ended.expect_err("too stiff").to_string();
            (state, Summary { solve_cpu_seconds: 0.0, ..summary }, error, seen.samples.len())
        })
        .into();
    println!("{}, {} samples", ends[0].2, ends[0].3);
    // What grew beyond all bounds is not a number, and equal to nothing but in print.
    assert_eq!(format!("{:?}", ends[0]), format!("{:?}", ends[1]));
    assert!(ends[0].0.time < 20.0 && ends[0].3 > 0);
}

#[test]
fn small_islands_are_run_together_and_move_as_if_they_were_one_mechanism() {
    let model = side_by_side(vec![
        parts(models::double_pendulum()),
        parts(models::chain(9)),
        pendulum(0.0),
        parts(models::chain(3)),
        parts(models::one_joint(JointKind::Revolute)),
    ]);
    let plan = || Plan::new(&model.mechanism, &model.state, &[]);
    let sizes = |smallest: usize| {
        let grouped = plan().grouped(&model.mechanism, smallest);
        grouped.islands.iter().map(|(island, _)| island.mechanism.bodies.len()).collect::<Vec<_>>()
    };
    assert_eq!(sizes(1), [2, 9, 1, 3, 2]);
    assert_eq!(sizes(4), [7, 9, 1], "two and three, and the two left over");
    assert_eq!(sizes(100), [16, 1], "what sleeps stays apart");
    let grouped = plan().grouped(&model.mechanism, 4);
    let fixed = |part: &Mechanism, _: &State| Lobatto::fixed(part, 5, 0.01).map(|lobatto| (lobatto, ()));
    let group = &grouped.islands[0].0;
    let (mechanism, mut alone) = (group.mechanism.clone(), group.state(&model.state));
    let group = group.clone();
    let (mut all, _) = Islands::new(grouped, &model.state, Threads::Exactly(2), fixed).expect("integrators");
    let mut state = model.state.clone();
    let options = RunOptions { duration: 1.0, rate: None, interrupt: None };
    all.run(&model.mechanism, &mut state, &options, &mut []).1.expect("a run");
    let mut lobatto = Lobatto::fixed(&mechanism, 5, 0.01).expect("five stages");
    common::run_until(&mechanism, &mut alone, &mut lobatto, 1.0);
    assert_eq!(group.state(&state), alone);
    // The whole makes the same steps until one of them fails: then all of it halves, and here only the group that has to.
    let (mut apart, mut whole) = (model.state.clone(), model.state.clone());
    let options = RunOptions { duration: 0.3, rate: None, interrupt: None };
    let plan = plan().grouped(&model.mechanism, 4);
    let (mut all, _) = Islands::new(plan, &apart, Threads::Exactly(1), fixed).expect("integrators");
    all.run(&model.mechanism, &mut apart, &options, &mut []).1.expect("a run");
    let mut lobatto = Lobatto::fixed(&model.mechanism, 5, 0.01).expect("five stages");
    assert_eq!(common::run_until(&model.mechanism, &mut whole, &mut lobatto, 0.3).cost.rejected.total(), 0);
    let distance =
        models::pose_distance(&body_states(&model.mechanism, &apart), &body_states(&model.mechanism, &whole));
    // Roundings, which this fall amplifies a hundredfold.
    assert!(distance < 1e-11, "{distance:.1e}");
}
