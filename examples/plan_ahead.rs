//! Model predictive control with copies of the state: a pendulum swings up with a weak motor.
//!
//! Every tenth of a second the program tries random efforts on the state as it is, keeps the best, and goes back: a state is a value.
//!
//! `cargo run --release --example plan_ahead`

use catena::prelude::*;
use catena::session::Noise;
use std::f64::consts::PI;

/// Ticks of a plan, the length of a tick (s), and the plans that are tried.
const AHEAD: usize = 12;
const TICK: f64 = 0.1;
const PLANS: usize = 60;

fn main() -> Result<(), Error> {
    let model = Model::load("robots/pendulum.urdf")?;
    let weight = model.gravity_efforts(&[0.5 * PI])?[0].abs().max(model.gravity_efforts(&[0.0])?[0].abs());
    let strongest = 0.4 * weight;
    let mut simulation = Simulation::new(&model).tolerance(1e-5).duration(100.0).without_figures();
    let mut random = Noise::new(0.0, strongest, 1);
    let mut plan = vec![0.0; AHEAD];
    for tick in 0..60 {
        let state = simulation.state()?;
        let mut best = (f64::NEG_INFINITY, plan.clone());
        for number in 0..PLANS {
            // The first is the rest of the last plan.
            let mut tried = plan.clone();
            if number > 0 {
                random.add(&mut tried);
            }
            tried.iter_mut().for_each(|effort| *effort = effort.clamp(-strongest, strongest));
            simulation.set_state(&state)?;
            let mut value = 0.0;
            for effort in &tried {
                simulation.set_efforts(&[*effort])?;
                simulation.step_to(simulation.time() + TICK)?;
                value += simulation.energy()?.potential;
            }
            if value > best.0 {
                best = (value, tried);
            }
        }
        simulation.set_state(&state)?;
        simulation.set_efforts(&[best.1[0]])?;
        simulation.step_to(state.time() + TICK)?;
        if tick % 5 == 4 {
            let energy = simulation.energy()?;
            println!(
                "{:.1} s: potential {:+.2} J, kinetic {:.2} J",
                simulation.time(),
                energy.potential,
                energy.kinetic
            );
        }
        plan = best.1[1..].to_vec();
        plan.push(0.0);
    }
    Ok(())
}
