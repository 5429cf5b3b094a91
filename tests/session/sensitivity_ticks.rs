//! Derivatives by the time between the ticks of motors, which move with it.

use crate::sensitivity_events::{difference, scene};
use catena::prelude::*;

/// Carts of 1 kg on rails, whose motors brake them at ticks: v ← v (1 − kd T).
fn carts(name: &str, periods: &[f64]) -> Model {
    let cart = |index: usize| {
        format!(
            "<link name='m{index}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>\
             <joint name='x{index}' type='prismatic'><parent link='base'/><child link='m{index}'/><axis xyz='1 0 0'/>\
             <limit lower='-99' upper='99' effort='99' velocity='99'/></joint>"
        )
    };
    let all: String = (0..periods.len()).map(cart).collect();
    let urdf = scene(&format!("{name}.urdf"), &format!("<robot name='s'><link name='base'/>{all}</robot>"));
    let starts: Vec<String> = (0..periods.len()).map(|index| format!("x{index} = 1.0")).collect();
    let motor = |(index, period): (usize, &f64)| {
        format!("[[motor]]\njoint = \"x{index}\"\nkind = \"velocity\"\ntarget = 0\nkd = 2\nperiod = {period:?}\n")
    };
    let motors: String = periods.iter().enumerate().map(motor).collect();
    let text = format!("[[robot]]\nurdf = {urdf:?}\nvelocities = {{ {} }}\n{motors}", starts.join(", "));
    Model::load(scene(&format!("{name}.toml"), &text)).expect("a model")
}

/// v and x of such a cart at a time.
fn braked(period: f64, time: f64) -> [f64; 2] {
    let (mut v, mut x, mut at) = (1.0, 0.0, 0.0_f64);
    while at < time - 1e-12 {
        let step = period.min(time - at);
        let slower = v * (1.0 - 2.0 * step);
        (x, v, at) = (x + 0.5 * step * (v + slower), slower, at + step);
    }
    [v, x]
}

#[test]
fn ticks_move_with_their_period() {
    let model = carts("braked", &[0.1]);
    for time in [0.73, 0.35] {
        let run = Simulation::new(&model).duration(time).without_figures();
        let run = run.sensitivity(&["motor.x0.period", "start.v.x0"]).expect("derivatives");
        let (last, slopes) =
            (run.times.last().copied(), |row: usize| [&run.dv, &run.dq][row].last().expect("an end")[(0, 0)]);
        assert_eq!(last, Some(time), "the end is there");
        for (row, found) in [slopes(0), slopes(1)].into_iter().enumerate() {
            let wanted = difference(&|by| braked(0.1 + by, time)[row], 1e-3);
            // Differences of order eight over a hundredth, and roundings over it.
            assert!((found - wanted).abs() < 1e-10, "{time}, {row}: {found} and {wanted}");
        }
    }
}

#[test]
fn a_run_that_ends_at_a_tick_has_the_derivatives_of_its_end() {
    let run = Simulation::new(&carts("braked_to_a_tick", &[0.1])).duration(0.5).without_figures();
    let run = run.sensitivity(&["motor.x0.period", "start.v.x0"]).expect("derivatives");
    assert_eq!(run.times.last(), Some(&0.5));
    // v(0.5) = (1 − 2 T)⁴ (1 − 2 (0.5 − 4 T)), of a period that is a little longer.
    let wanted = difference(&|by: f64| (1.0 - 2.0 * (0.1 + by)).powi(4) * (1.0 - 2.0 * (0.1 - 4.0 * by)), 1e-3);
    let found = run.dv.last().expect("an end")[(0, 0)];
    assert!((found - wanted).abs() < 1e-10, "{found} and {wanted}");
    assert!((run.dv.last().expect("an end")[(0, 1)] - 0.8_f64.powi(5)).abs() < 1e-13);
}

#[test]
fn ticks_of_two_motors_that_move_apart_are_refused_with_the_reason() {
    let model = carts("two_braked", &[0.1, 0.2]);
    let run = Simulation::new(&model).duration(0.5).sensitivity(&["motor.x0.period"]);
    let told = run.expect_err("no derivative").to_string();
    assert!(told.contains("ticks of two motors fall together at t = 0.2 s"), "{told}");
    // Before, there is one.
    let run = Simulation::new(&model).duration(0.15).sensitivity(&["motor.x0.period"]).expect("derivatives");
    assert!(run.dv.last().expect("an end")[(0, 0)].abs() > 0.1);
}
