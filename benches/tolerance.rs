//! Measures the cost of a wanted accuracy: a run with a tolerance, from setting it up to its report, over the steps of the run that was accepted.
//!
//! ```text
//!     ms              CPU time of the accepted run's steps alone, without estimate and figures
//!     whole/steps     CPU time of `Simulation::new … finish`, over that
//!     + companion     what a companion adds to those steps, if it goes along to their end, over them
//!     + making        what making the integrator takes, over them
//! ```
//!
//! The runs are made in turns and the fastest of each counts, so that a loaded machine changes the ratios little. Models are read before, and limits
//! are left out. Arguments select scenes: `cargo bench --bench tolerance -- arm7`.

use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::state::State;
use catena::prelude::*;
use catena::session::Left;
use catena::simulation::{Accuracy, SimulationOptions, StepChoice};
use catena::stepping::integrator::Lobatto;
use catena::stepping::step_maker::StepMaker;
use cpu_time::ThreadTime;
use std::fmt::Write;
use std::path::{Path, PathBuf};

const TOLERANCES: [f64; 3] = [1e-3, 1e-6, 1e-9];
/// Least CPU time of all turns of a ratio (s), and least number of turns.
const BUDGET: f64 = 0.7;
const TURNS: usize = 2;

struct Scene {
    name: &'static str,
    file: PathBuf,
    /// Whether the file is removed after the runs.
    temporary: bool,
    duration: f64,
    tolerances: &'static [f64],
}

/// Writes a chain of `links` links of 0.1 m and 0.1 kg whose axes alternate, as `robots/make_chain.py` does.
fn chain(links: usize) -> PathBuf {
    let mut urdf = String::from("<robot name=\"chain\"><link name=\"base\"/>");
    for link in 1..=links {
        let (parent, at) = if link == 1 { ("base".to_string(), 0.0) } else { (format!("link{}", link - 1), 0.1) };
        let axis = if link % 2 == 1 { "0 1 0" } else { "1 0 0" };
        write!(
            urdf,
            "<link name=\"link{link}\"><inertial><origin xyz=\"0.05 0 0\"/><mass value=\"0.1\"/><inertia ixx=\"{0}\" iyy=\"{1}\" izz=\"{1}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>\
             <joint name=\"joint{link}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"link{link}\"/><origin xyz=\"{at} 0 0\"/><axis xyz=\"{axis}\"/></joint>",
            0.1 / 12.0 * 2.0 * 0.02 * 0.02,
            0.1 / 12.0 * (0.1 * 0.1 + 0.02 * 0.02),
        )
        .expect("text");
    }
    urdf.push_str("</robot>");
    let file = std::env::temp_dir().join(format!("catena_chain_{links}_{}.urdf", std::process::id()));
    std::fs::write(&file, urdf).expect("a file");
    file
}

fn scenes() -> Vec<Scene> {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
    let second = |name, file| Scene { name, file, temporary: false, duration: 1.0, tolerances: &TOLERANCES };
    vec![
        second("arm7", robots.join("arm7.urdf")),
        second("chain_10", robots.join("chain_10.urdf")),
        Scene { temporary: true, ..second("chain_100", chain(100)) },
        second("heavy_tip", robots.join("chain_20_heavy_tip.urdf")),
        second("quadruped", robots.join("quadruped.urdf")),
        Scene { duration: 300.0, tolerances: &[1e-6], ..second("arm7_300", robots.join("arm7.urdf")) },
    ]
}

/// CPU time of a call (s).
fn timed<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let clock = ThreadTime::now();
    let done = work();
    (clock.elapsed().as_secs_f64(), done)
}

/// The steps of a run, to its end; how many.
fn steps(lobatto: &mut Lobatto, model: &catena::model::Model, start: &State, duration: f64) -> usize {
    let (mechanism, mut state) = (&model.mechanism, start.clone());
    let mut steps = 0;
    while state.time < duration {
        lobatto.advance(mechanism, &mut state, duration).expect("a step");
        steps += 1;
    }
    steps
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    let named: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    println!("scene       tolerance  stop    begun steps     ms  whole/steps  + companion  + making");
    let mut ratios = Vec::new();
    for Scene { name, file, temporary, duration, tolerances } in scenes() {
        let model = Model::loader().without(Left::Limits).load(&file).expect("a model");
        if temporary {
            std::fs::remove_file(&file).expect("a file");
        }
        if !named.is_empty() && !named.iter().any(|wanted| wanted == name) {
            continue;
        }
        for &tolerance in tolerances {
            let description = model.description();
            let mechanism = &description.mechanism;
            let start = model.loaded().assembled(&[], &[], None).expect("a start").state;
            let told: Accuracy = {
                let steps = StepChoice::Tolerance(tolerance);
                let options = SimulationOptions::new(duration, steps);
                let mut run =
                    catena::simulation::Simulation::new(mechanism, start.clone(), options).expect("a simulation");
                run.run().expect("a run");
                run.finish().accuracy[0].clone().expect("an accuracy")
            };
            let [mut whole, mut alone, mut carrying, mut making] = [f64::INFINITY; 4];
            let (mut spent, mut turns, mut count) = (0.0, 0, 0);
            while spent < BUDGET || turns < TURNS {
                let (time, _) = timed(|| {
                    let mut run = Simulation::new(&model).tolerance(tolerance).duration(duration);
                    run.run().expect("a run");
                    run.finish().expect("a report")
                });
                whole = f64::min(whole, time);
                let mut lobatto = Lobatto::adaptive_with_stages(mechanism, tolerance, told.stop, told.stages);
                let (time, made) = timed(|| steps(&mut lobatto, description, &start, duration));
                (alone, count) = (f64::min(alone, time), made);
                let mut lobatto = Lobatto::adaptive_with_stages(mechanism, tolerance, told.stop, told.stages);
                lobatto.accompany(mechanism);
                let (time, _) = timed(|| steps(&mut lobatto, description, &start, duration));
                carrying = f64::min(carrying, time);
                let (time, _) = timed(|| Lobatto::adaptive_with_stages(mechanism, tolerance, told.stop, told.stages));
                making = f64::min(making, time);
                spent += whole + alone + carrying;
                turns += 1;
            }
            println!(
                "{name:<11} {tolerance:<9.0e} {:<7.0e} {:>5} {count:>5} {:>6.3}  {:>11.2}  {:>11.2}  {:>8.3}",
                told.stop,
                told.begun,
                1e3 * alone,
                whole / alone,
                carrying / alone - 1.0,
                making / alone
            );
            if duration == 1.0 {
                ratios.push(whole / alone);
            }
        }
    }
    if !ratios.is_empty() {
        let worst = ratios.iter().copied().fold(0.0, f64::max);
        println!("whole/steps of one second: median {:.2}, worst {worst:.2}", median(ratios));
    }
}
