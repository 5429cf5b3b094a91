//! Measures the gain of simulating unconnected bodies apart, and the cost of the search for such bodies in scenes without them.
//!
//! Each scene is run as a whole and by its islands, in turns, and the median of each is printed: CPU time of the process and
//! wall time, On a shared machine the CPU time is the one to look at for one thread, and the ratio
//! of wall times, with two threads, tells as much as the load leaves of it.

use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::state::State;
use catena::simulation::parallel::islands::Islands;
use catena::simulation::parallel::partition::Plan;
use catena::simulation::parallel::threads::Threads;
use catena::simulation::{RunOptions, run};
use catena::stepping::integrator::Lobatto;
use catena::stepping::length::stage_choice::StageChoice;
use cpu_time::ProcessTime;
use std::time::Instant;

use catena::mechanism;
#[path = "../tests/shared/models/mod.rs"]
mod models;

const ROUNDS: usize = 31;

#[derive(Clone, Copy)]
enum Way {
    Fixed(usize, f64),
    Tolerance(f64),
}

fn integrator(mechanism: &Mechanism, way: Way) -> Lobatto {
    match way {
        Way::Fixed(stages, step) => Lobatto::fixed(mechanism, stages, step).expect("a number of stages from 2 to 16"),
        Way::Tolerance(tolerance) => {
            // The steps that a run begins with.
            let stages = StageChoice::of(mechanism, tolerance);
            Lobatto::adaptive_with_stages(mechanism, tolerance, 1e-2 * tolerance, stages)
        }
    }
}

/// Runs a scene once; returns CPU and wall time (s).
fn once(
    model: &models::Model,
    duration: f64,
    way: Way,
    kept: Option<&[Rule]>,
    smallest: usize,
    threads: Threads,
) -> [f64; 2] {
    let (clock, cpu) = (Instant::now(), ProcessTime::now());
    let (mechanism, mut state) = (&model.mechanism, model.state.clone());
    let options = RunOptions { duration, rate: None, interrupt: None };
    // Without a plan at all it is the run as it was before there were rules.
    let plan = kept
        .map(|kept| Plan::new(mechanism, &state, kept).grouped(mechanism, smallest))
        .filter(|plan| !plan.is_whole());
    let ended = match plan {
        None => {
            let mut whole = integrator(mechanism, way);
            run(mechanism, &mut state, &mut whole, &options, &mut []).1
        }
        Some(plan) => {
            let make = |part: &Mechanism, _: &State| Ok::<_, ()>((integrator(part, way), ()));
            let (mut islands, _) = Islands::new(plan, &state, threads, make).expect("integrators");
            islands.run(mechanism, &mut state, &options, &mut []).1
        }
    };
    ended.expect("a run to the end");
    [cpu.elapsed().as_secs_f64(), clock.elapsed().as_secs_f64()]
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// `count` robots side by side, each started a little differently.
fn several(robot: &models::Model, count: usize) -> models::Model {
    let mut bodies = Vec::new();
    let mut state = State { time: 0.0, position: vec![], compensation: vec![], velocity: vec![] };
    for number in 0..count {
        let first = bodies.len();
        bodies.extend(robot.mechanism.bodies.iter().cloned().map(|mut body| {
            body.parent = body.parent.map(|parent| parent + first);
            body
        }));
        let turned = robot.state.position.iter().map(|angle| angle * (1.0 - 0.07 * number as f64));
        state.position.extend(turned);
        state.velocity.extend(&robot.state.velocity);
    }
    state.compensation = vec![0.0; state.position.len()];
    let mechanism = Mechanism::new("several", robot.mechanism.gravity, bodies).expect("depth first");
    models::Model { mechanism, state }
}

fn main() {
    // cargo test runs benches too, to see that they work; only cargo bench says so.
    let rounds = if std::env::args().any(|argument| argument == "--bench") { ROUNDS } else { 1 };
    println!(
        "medians of {rounds}; whole [ms CPU], islands on one thread over it, [ms wall] whole, islands on two threads over it"
    );
    let robots = [
        ("double pendulum", models::double_pendulum(), 20.0),
        ("chain of 10 links", models::chain(10), 1.0),
        ("chain of 40 links", models::chain(40), 1.0),
    ];
    for (name, robot, duration) in robots {
        for (label, way) in [("tolerance 1e-6", Way::Tolerance(1e-6)), ("9 stages, 10 ms", Way::Fixed(9, 0.01))] {
            for count in [1, 2, 10] {
                let model = several(&robot, count);
                let grouped = if let Way::Tolerance(_) = way { 10 } else { 20 };
                let ways = [
                    (None, 1, Threads::Exactly(1)),
                    (Some(&[][..]), 1, Threads::Exactly(1)),
                    (Some(&[][..]), grouped, Threads::Exactly(1)),
                    (Some(&[][..]), grouped, Threads::WherePaid),
                ];
                let mut times = vec![Vec::new(); ways.len()];
                for round in 0..rounds {
                    for turn in 0..ways.len() {
                        let index = (turn + round) % ways.len();
                        let (kept, smallest, threads) = ways[index];
                        times[index].push(once(&model, duration, way, kept, smallest, threads));
                    }
                }
                let paired = |index: usize, clock: usize| {
                    median(times[index].iter().zip(&times[0]).map(|(own, whole)| own[clock] / whole[clock]).collect())
                };
                println!(
                    "{count:>2} × {name}, {label}: {:.3} ms, {:.3}, {:.3}; wall {:.3}",
                    1e3 * median(times[0].iter().map(|pair| pair[0]).collect()),
                    paired(1, 0),
                    paired(2, 0),
                    paired(3, 1)
                );
            }
        }
    }
}
