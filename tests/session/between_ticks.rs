//! Runs that begin between the ticks of sampled motors.

use crate::states::driven_pendulum;
use catena::prelude::*;

#[test]
fn a_run_that_begins_between_the_ticks_of_a_motor_says_so_unless_it_knows_the_effort() {
    let motor = "kind = \"velocity\"\ntarget = 1.0\nkd = 0.5\nperiod = 0.1";
    let (model, ..) = driven_pendulum("between_ticks", motor);
    let told = |simulation: Simulation| {
        let report = simulation.finish().expect("a report");
        report.warnings.iter().filter(|line| line.contains("between its ticks, at t = 0.25 s")).count()
    };
    let begins = |time: f64| {
        let mut simulation = Simulation::new(&model).begin_at(time).duration(0.1);
        simulation.run().expect("it runs");
        simulation
    };
    assert_eq!([0.0, 0.2, 0.25, 0.3].map(|time| told(begins(time))), [0, 0, 1, 0]);
    let mut simulation = Simulation::new(&model).tolerance(1e-9);
    simulation.step_to(0.25).expect("it runs");
    let (state, mut other) = (simulation.state().expect("a state"), Simulation::new(&model).tolerance(1e-9));
    other.set_state(&state).expect("the same model");
    other.step_to(0.3).expect("it runs");
    simulation.step_to(0.3).expect("it runs");
    assert_eq!(simulation.coordinates().expect("q, v"), other.coordinates().expect("q, v"));
    assert_eq!(told(other), 0);
}
