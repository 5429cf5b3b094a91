//! How time and memory grow with the number of bodies: chains of 10 to 10 000 links.
//!
//! For every length the same steps from the same kind of start are timed, the lengths taking turns round by round so that other programs disturb all
//! of them alike, and the fastest round counts. Printed are the time per body and step, the exponent p of cost ∝ links^p fitted through all lengths
//! (least squares of the logarithms), and the resident memory per body, measured in a process of its own for every length because freed memory is
//! used again.

use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::state::State;
use catena::stepping::integrator::Lobatto;
use cpu_time::ThreadTime;
use std::process::Command;

use catena::mechanism;
#[path = "../tests/shared/models/mod.rs"]
mod models;

const STAGES: usize = 5;
const STEP: f64 = 1e-3;
const WARM_UP: usize = 4;
const STEPS: usize = 12;
/// Short chains are timed over enough runs to make at least this number of bodies: a clock needs something to measure.
const BODIES_TO_TIME: usize = 1000;
const ROUNDS: usize = 7;
/// Tells the process to measure the memory of a chain with this number of links.
const MEMORY: &str = "CATENA_BENCH_MEMORY_LINKS";

struct Length {
    model: models::Model,
    lobatto: Lobatto,
    /// Fastest round so far, per step [s].
    fastest: f64,
    iterations: f64,
}

impl Length {
    fn new(links: usize) -> Self {
        let model = models::chain(links);
        let lobatto = Lobatto::fixed(&model.mechanism, STAGES, STEP).expect("a number of stages from 2 to 16");
        Length { model, lobatto, fastest: f64::INFINITY, iterations: 0.0 }
    }

    fn links(&self) -> usize {
        self.model.mechanism.bodies.len()
    }

    fn round(&mut self) {
        let repeats = BODIES_TO_TIME.div_ceil(self.links());
        let mut state = self.model.state.clone();
        let (mut seconds, mut iterations) = (0.0, 0);
        for _ in 0..repeats {
            state.copy_from(&self.model.state);
            let mut step = || self.lobatto.advance(&self.model.mechanism, &mut state, f64::INFINITY).expect("a step");
            for _ in 0..WARM_UP {
                step();
            }
            let clock = ThreadTime::now();
            for _ in 0..STEPS {
                iterations += step().cost.iterations;
            }
            seconds += clock.elapsed().as_secs_f64();
        }
        let steps = (repeats * STEPS) as f64;
        self.fastest = self.fastest.min(seconds / steps);
        self.iterations = iterations as f64 / steps;
    }
}

/// Slope of the line through the points, least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let (mean_x, mean_y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
    let products = |f: fn(f64, f64) -> f64| points.iter().map(|(x, y)| f(x - mean_x, y - mean_y)).sum::<f64>();
    products(|x, y| x * y) / products(|x, _| x * x)
}

/// Resident memory of this process [bytes], where the system tells it.
fn resident() -> Option<f64> {
    // A page has 4096 bytes on every machine that has this file and that we run on.
    let pages = std::fs::read_to_string("/proc/self/statm").ok()?;
    Some(4096.0 * pages.split_whitespace().nth(1)?.parse::<f64>().ok()?)
}

/// A chain after its first steps, with everything it keeps.
fn stepped(links: usize) -> (Length, State) {
    let mut length = Length::new(links);
    let mut state = length.model.state.clone();
    for _ in 0..WARM_UP {
        length.lobatto.advance(&length.model.mechanism, &mut state, f64::INFINITY).expect("a step");
    }
    (length, state)
}

/// Prints the resident memory that building and stepping a chain adds [bytes].
fn print_memory(links: usize) {
    // Code and tables come into memory when they are first used; they belong to the program.
    let small = stepped(2);
    let before = resident();
    let large = stepped(links);
    if let (Some(before), Some(after)) = (before, resident()) {
        println!("{}", after - before);
    }
    drop((small, large));
}

fn memory(links: usize) -> Option<f64> {
    let program = std::env::current_exe().ok()?;
    let output = Command::new(program).env(MEMORY, links.to_string()).output().ok()?;
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}

fn main() {
    if let Some(links) = std::env::var(MEMORY).ok().and_then(|links| links.parse().ok()) {
        return print_memory(links);
    }
    // Without this word cargo is testing that benches run, not measuring.
    let measuring = std::env::args().any(|argument| argument == "--bench");
    let links: &[usize] = if measuring { &[10, 30, 100, 300, 1000, 3000, 10_000] } else { &[10, 30] };
    let rounds = if measuring { ROUNDS } else { 1 };
    let mut lengths: Vec<Length> = links.iter().map(|&links| Length::new(links)).collect();
    for _ in 0..rounds {
        lengths.iter_mut().for_each(Length::round);
    }
    println!("chains of revolute joints, {STAGES} stages, step {STEP} s, fastest of {rounds} rounds");
    println!(
        "{:>7} {:>14} {:>19} {:>11} {:>13}",
        "links", "ns/body/step", "ns/body/iteration", "iterations", "bytes/body"
    );
    for length in &lengths {
        let per_body = 1e9 * length.fastest / length.links() as f64;
        let bytes = memory(length.links())
            .map_or_else(|| "unknown".to_string(), |bytes| format!("{:.0}", bytes / length.links() as f64));
        println!(
            "{:>7} {per_body:>14.1} {:>19.1} {:>11.2} {bytes:>13}",
            length.links(),
            per_body / length.iterations,
            length.iterations
        );
    }
    let exponent = |cost: fn(&Length) -> f64| {
        slope(&lengths.iter().map(|length| ((length.links() as f64).ln(), cost(length).ln())).collect::<Vec<_>>())
    };
    println!(
        "cost of a step grows as links^{:.3}, of an iteration as links^{:.3}",
        exponent(|length| length.fastest),
        exponent(|length| length.fastest / length.iterations)
    );
}
