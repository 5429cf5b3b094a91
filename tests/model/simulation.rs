//! A run as an object: what it does is what the loop does that it is made of, whoever halts it and whatever drives it.

use crate::models;
use catena::mechanism::description::joint::JointKind;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::state::State;
use catena::simulation::{Observer, ObserverError, RunOptions, Sample, Simulation, SimulationOptions, StepChoice, run};
use catena::stepping::Lobatto;
use nalgebra::Vector3;

const FIXED: StepChoice = StepChoice::Fixed { stages: 5, step: 0.02 };

fn options(duration: f64, steps: StepChoice) -> SimulationOptions<'static> {
    SimulationOptions::new(duration, steps)
}

/// Keeps all samples.
#[derive(Default)]
struct Kept(Vec<(f64, Vec<f64>, Vec<f64>)>);

impl Observer for Kept {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        self.0.push((sample.time, sample.position.to_vec(), sample.velocity.to_vec()));
        Ok(())
    }
}

/// Two pendulums that nothing connects: one moves, one hangs still.
fn one_moves_and_one_hangs() -> (Mechanism, State) {
    let rod = |name: &str, at: f64| {
        let frame = models::frame(Vector3::new(at, 0.0, 0.0), Vector3::y());
        let joint = catena::mechanism::description::joint::Joint::new(
            name,
            JointKind::Revolute,
            frame,
            models::frame(Vector3::new(0.0, 0.0, 0.5), Vector3::y()),
        );
        models::body(name, None, 1.0, Vector3::new(0.1, 0.1, 0.01), joint)
    };
    let mechanism = Mechanism::new("two", models::gravity(), vec![rod("moving", 0.0), rod("hanging", 2.0)]).unwrap();
    let mut state = State::zero(&mechanism);
    state.velocity[0] = 1.0;
    (mechanism, state)
}

#[test]
fn a_simulation_has_the_bits_of_the_loop_that_it_is_made_of() {
    let model = models::double_pendulum();
    let (mut expected, mut kept) = (model.state.clone(), Kept::default());
    let mut lobatto = Lobatto::fixed(&model.mechanism, 5, 0.02).unwrap();
    let run_options = RunOptions { duration: 1.5, rate: Some(40.0), interrupt: None };
    let (summary, ended) = run(&model.mechanism, &mut expected, &mut lobatto, &run_options, &mut [&mut kept]);
    ended.unwrap();
    let mut watched = Kept::default();
    let mut simulation = Simulation::new(&model.mechanism, model.state.clone(), options(1.5, FIXED)).unwrap();
    simulation.sample_at(40.0);
    simulation.observe(&mut watched);
    simulation.run().unwrap();
    let finished = simulation.finish();
    assert_eq!(finished.state, expected);
    assert_eq!((finished.summary.steps, finished.summary.final_energy), (summary.steps, summary.final_energy));
    assert_eq!(watched.0, kept.0);
}

#[test]
fn a_run_that_is_halted_at_ends_of_steps_has_the_bits_of_one_that_is_not_and_lands_exactly_elsewhere() {
    let whole = models::double_pendulum();
    let apart = one_moves_and_one_hangs();
    for (mechanism, start) in [(&whole.mechanism, &whole.state), (&apart.0, &apart.1)] {
        let mut straight = Simulation::new(mechanism, start.clone(), options(1.0, FIXED)).unwrap();
        straight.run().unwrap();
        let mut halted = Simulation::new(mechanism, start.clone(), options(1.0, FIXED)).unwrap();
        for part in 1..=10 {
            let time = 0.02 * f64::from(5 * part);
            halted.step_to(time).unwrap();
            assert_eq!(halted.state().time, time, "{}", mechanism.name);
        }
        let (straight, halted) = (straight.finish().state, halted.finish().state);
        // Ends of steps are sums of steps, which round otherwise than products.
        let off = straight.position.iter().zip(&halted.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-12, "{}: {off:e}", mechanism.name);
        let mut between = Simulation::new(mechanism, start.clone(), options(1.0, FIXED)).unwrap();
        for time in [0.013, 0.35, 0.3501, 0.9] {
            between.step_to(time).unwrap();
            assert_eq!(between.state().time, time, "{}", mechanism.name);
        }
    }
}

#[test]
fn a_part_that_sleeps_is_woken_by_an_effort_and_samples_stay_in_step() {
    let (mechanism, start) = one_moves_and_one_hangs();
    let mut kept = Kept::default();
    let mut simulation = Simulation::new(&mechanism, start.clone(), options(1.0, FIXED)).unwrap();
    assert_eq!(simulation.parts(), (2, 1));
    simulation.sample_at(50.0);
    simulation.observe(&mut kept);
    simulation.step_to(0.4).unwrap();
    assert_eq!(simulation.state().position[1], 0.0, "nothing has moved it");
    simulation.set_efforts(&[0.0, 2.0]).unwrap();
    simulation.step_to(0.6).unwrap();
    simulation.set_efforts(&[0.0, 0.0]).unwrap();
    simulation.run().unwrap();
    let finished = simulation.finish();
    // The same by one integrator for both.
    let mut driven = mechanism.clone();
    driven.forces.driven = true;
    let mut lobatto = Lobatto::fixed(&driven, 9, 0.01).unwrap();
    let mut expected = start;
    for (until, effort) in [(0.4, 0.0), (0.6, 2.0), (1.0, 0.0)] {
        while expected.time < until {
            use catena::mechanism::motion::inputs::Inputs;
            use catena::mechanism::motion::integrator::Integrator;
            lobatto.step(&driven, Inputs::constant(&[0.0, effort]), &mut expected, until).unwrap();
        }
    }
    let off = finished.state.position.iter().zip(&expected.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // Truncation of order 8 at steps of 0.02 s.
    assert!(off < 1e-9 && expected.position[1].abs() > 0.05, "{off:e}, {expected:?}");
    let times: Vec<f64> = kept.0.iter().map(|(time, ..)| *time).collect();
    let wanted: Vec<f64> = (0..=50).map(|sample| f64::from(sample) / 50.0).collect();
    assert_eq!(times, wanted);
    assert!(kept.0.iter().all(|(time, position, _)| (*time > 0.4) == (position[1] != 0.0)), "it moves from 0.4 s on");
}

#[test]
fn efforts_of_another_number_or_that_are_not_finite_are_refused_with_the_joint() {
    let (mechanism, start) = one_moves_and_one_hangs();
    let mut simulation = Simulation::new(&mechanism, start, options(1.0, FIXED)).unwrap();
    let message =
        |efforts: &[f64], simulation: &mut Simulation| simulation.set_efforts(efforts).unwrap_err().to_string();
    assert!(message(&[1.0], &mut simulation).contains("1 efforts for 2 degrees of freedom"));
    assert!(message(&[1.0, f64::NAN], &mut simulation).contains("\"hanging\""));
}

#[test]
fn the_work_of_efforts_balances_the_energy_of_the_run() {
    let (mechanism, start) = one_moves_and_one_hangs();
    for steps in [StepChoice::Fixed { stages: 9, step: 0.02 }, StepChoice::Tolerance(1e-9)] {
        let mut simulation = Simulation::new(&mechanism, start.clone(), options(2.0, steps)).unwrap();
        for part in 0..20 {
            simulation.set_efforts(&[(0.7 * f64::from(part)).sin(), (0.4 * f64::from(part)).cos()]).unwrap();
            simulation.step_to(0.1 * f64::from(part + 1)).unwrap();
        }
        let summary = simulation.finish().summary;
        assert!(summary.exchange.work.abs() > 0.1, "{summary:?}");
        assert!(summary.max_relative_energy_error < 1e-8, "{steps:?}: {summary:?}");
    }
}
