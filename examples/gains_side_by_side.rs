//! A batch of controllers: arms side by side, each held by gains of its own, on all cores. The highest gains are too high for ticks of a millisecond.
//!
//! `cargo run --release --example gains_side_by_side`

use catena::prelude::*;
use catena::session::Batch;

fn main() -> Result<(), Error> {
    let model = Model::load("robots/arm7.urdf")?;
    let (goal, _) = model.start()?;
    let holding = model.gravity_efforts(&goal)?;
    let (runs, n) = (16, goal.len());
    let gain = |run: usize| 10.0 * 2.0_f64.powf(run as f64 / 2.0);
    let mut batch = Batch::new(&mut Simulation::new(&model).tolerance(1e-5).duration(10.0), runs, 0)?;
    let (mut q, mut v) = (vec![0.0; runs * n], vec![0.0; runs * n]);
    for run in 0..runs {
        let start: Vec<f64> = goal.iter().map(|angle| angle + 0.2).collect();
        batch.place(run, &start, &vec![0.0; n])?;
    }
    for _ in 0..2000 {
        batch.write_coordinates(&mut q, &mut v)?;
        let law = |entry: usize| {
            let (run, joint) = (entry / n, entry % n);
            let (kp, kd) = (gain(run), 0.2 * gain(run).sqrt());
            holding[joint] + kp * (goal[joint] - q[entry]) - kd * v[entry]
        };
        let efforts: Vec<f64> = (0..runs * n).map(law).collect();
        for (run, error) in batch.step(1e-3, &efforts, &[])? {
            println!("run {run} has failed: {error}");
        }
    }
    batch.write_coordinates(&mut q, &mut v)?;
    for run in 0..runs {
        let off = (0..n).map(|joint| (q[run * n + joint] - goal[joint]).abs()).fold(0.0, f64::max);
        println!("gain {:7.1} N m/rad: {off:.4} rad off after 2 s", gain(run));
    }
    Ok(())
}
