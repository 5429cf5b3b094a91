//! Measures the cost of a controller at 1 kHz: a second of motion in steps of 1 ms, with three stages, with and without one that brakes every joint a
//! little.
//!
//! Both take turns; the fastest of each is printed, in CPU time of the process, and the iterations of a step: efforts that jump cost some.

use catena::prelude::*;
use cpu_time::ProcessTime;

const ROUNDS: usize = 60;

/// CPU time (s), and iterations of a step.
fn cost(model: &Model, controlled: bool) -> Result<(f64, f64), Error> {
    let start = vec![0.3; model.coordinates().q_count()];
    let still = vec![0.0; start.len()];
    let mut simulation = Simulation::new(model).fixed(3, 1e-3).duration(1.0).start_from(&start, &still)?;
    if controlled {
        simulation.set_controller(1e-3, |now, efforts| {
            efforts.iter_mut().zip(&now.v).for_each(|(effort, rate)| *effort = -0.01 * rate);
        })?;
    }
    let clock = ProcessTime::now();
    simulation.run()?;
    let taken = clock.elapsed().as_secs_f64();
    let report = simulation.finish()?;
    Ok((taken, report.iterations as f64 / report.steps as f64))
}

fn main() -> Result<(), Error> {
    for name in ["arm7", "double_pendulum"] {
        let model = Model::loader().without(Left::Limits).load(format!("robots/{name}.urdf"))?;
        let mut fastest = [(f64::INFINITY, 0.0); 2];
        for _ in 0..ROUNDS {
            for (controlled, best) in [false, true].into_iter().zip(&mut fastest) {
                let (seconds, iterations) = cost(&model, controlled)?;
                *best = (best.0.min(seconds), iterations);
            }
        }
        let [(without, free), (with, driven)] = fastest.map(|(seconds, iterations)| (1e3 * seconds, iterations));
        println!(
            "{name}: {without:.2} ms without a controller ({free:.2} iterations a step), {with:.2} ms with ({driven:.2}): {:.2} times",
            with / without
        );
    }
    Ok(())
}
