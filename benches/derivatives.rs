//! Measures what derivatives cost, in runs of the same scene without derivatives: forward by one number and by many, and a gradient by many.
//!
//! All take turns; the fastest of each is printed, in CPU time of the process, with everything from the model on: the run, its trace, and the
//! derivatives of the numbers themselves.

use catena::prelude::*;
use catena::session::{Backward, Lost, Samples};
use cpu_time::ProcessTime;

const ROUNDS: usize = 12;

/// A scene, what happens to its start, and its parameters.
struct Case {
    name: &'static str,
    file: &'static str,
    start: &'static [(&'static str, f64)],
    duration: f64,
    one: &'static str,
}

const ARM: &[(&str, f64)] = &[("joint2", 0.3), ("joint4", 0.6)];
const CASES: [Case; 8] = [
    Case { name: "arm, free", file: "arm7.urdf", start: ARM, duration: 1.0, one: "link.forearm.mass" },
    Case { name: "arm, limits", file: "arm7.urdf", start: &[], duration: 3.0, one: "link.forearm.mass" },
    Case { name: "arm, motors", file: "arm7_held.toml", start: &[], duration: 4.8, one: "link.forearm.mass" },
    Case { name: "bouncing ball", file: "ball_dropped.toml", start: &[], duration: 3.5, one: "floor.restitution" },
    Case {
        name: "pendulum, limits",
        file: "bouncing_pendulum.toml",
        start: &[],
        duration: 2.9,
        one: "hinge.restitution",
    },
    Case {
        name: "double pendulum",
        file: "double_pendulum.urdf",
        start: &[("shoulder", 1.0)],
        duration: 10.0,
        one: "lower_arm.mass",
    },
    Case { name: "four-bar", file: "four_bar_1.toml", start: &[], duration: 2.0, one: "scene.gravity.z" },
    Case { name: "sliding block", file: "block_on_incline.toml", start: &[], duration: 1.0, one: "scene.gravity.z" },
];

fn timed<T>(fastest: &mut f64, work: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    let clock = ProcessTime::now();
    let done = work()?;
    *fastest = fastest.min(1e3 * clock.elapsed().as_secs_f64());
    Ok(done)
}

fn main() -> Result<(), Error> {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    println!(
        "{:18} {:>9} {:>5} {:>14} {:>22} {:>22}",
        "", "run [ms]", "steps", "one number", "many, forward", "many, gradient"
    );
    for case in CASES.iter().filter(|case| wanted.is_empty() || wanted.iter().any(|word| case.name.contains(word))) {
        let model = Model::load(format!("robots/{}", case.file))?;
        let run = || Simulation::new(&model).duration(case.duration).start(case.start.iter().copied());
        // Every mass, centre and moment that a file gives, and is not zero.
        let params = model.params()?;
        let own = |key: &str| key.starts_with("link.") && !key.contains(".rpy.") && !key.contains("base.");
        let given = params.iter().filter(|(key, value)| own(key) && value.is_some_and(|value| value != 0.0));
        let many: Vec<&str> = given.map(|(key, _)| key.as_str()).take(100).collect();
        let n = model.coordinates().v_count();
        let (mut plain, mut one, mut all, mut back) = (f64::INFINITY, f64::INFINITY, f64::INFINITY, f64::INFINITY);
        let mut steps = 0;
        let times = [case.duration];
        let loss = |samples: &Samples| Lost {
            value: samples.q[0][0],
            by_q: vec![(0..n).map(|freedom| f64::from(u8::from(freedom == 0))).collect()],
            by_v: vec![vec![0.0; n]],
            by_events: Vec::new(),
        };
        for _ in 0..ROUNDS {
            steps = timed(&mut plain, || {
                let mut run = run()?;
                run.run()?;
                run.finish()
            })?
            .steps;
            timed(&mut one, || run()?.sensitivity(&[case.one]))?;
            timed(&mut all, || run()?.sensitivity(&many))?;
            // Corners that stick have no derivatives against time.
            let asked = Backward { keys: &many, times: &times, every: 1 };
            if timed(&mut back, || run()?.gradient(&asked, loss)).is_err() {
                back = f64::NAN;
            }
        }
        let told = |of: f64| format!("{of:9.2} ms {:6.2}", of / plain);
        println!(
            "{:18} {plain:9.2} {steps:5} {} {:4} {} {:4} {}",
            case.name,
            told(one),
            many.len(),
            told(all),
            many.len(),
            told(back)
        );
    }
    Ok(())
}
