//! Many runs: how far a small uncertainty of the start spreads, over a thousand runs on all cores.
//!
//! `cargo run --release --example many_runs`

use catena::prelude::*;
use catena::session::Rollout;

fn main() -> Result<(), Error> {
    let model = Model::load("robots/double_pendulum.urdf")?;
    let runs = 1000;
    // Evenly spread over 2.0 ± 0.001 rad.
    let q0: Vec<f64> =
        (0..runs).flat_map(|run| [2.0 + 0.002 * (f64::from(run) / f64::from(runs) - 0.5), 0.0]).collect();
    let options = Rollout { duration: Some(5.0), rate: Some(2.0), ..Rollout::default() };
    let done = model.rollout(&q0, &vec![0.0; q0.len()], &options)?;
    let samples = done.times.len();
    for (sample, time) in done.times.iter().enumerate() {
        let angles = (0..done.runs).map(|run| done.q[2 * (run * samples + sample)]);
        let (least, most) = angles.fold((f64::MAX, f64::MIN), |(a, b), angle| (a.min(angle), b.max(angle)));
        println!("{time:.1} s: first joint from {least:+.4} to {most:+.4} rad");
    }
    println!("{} of {} runs failed", done.failures.len(), done.runs);
    Ok(())
}
