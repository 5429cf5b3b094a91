//! Measures a step of the scheme: by number of stages, by kind of joint, by length of chain, and in a plane.
//!
//! The throughput that criterion prints is bodies per second, so its inverse is the cost of a step per body. The line below each measurement says the
//! same in nanoseconds, the fastest sample counting, and divides it by the number of iterations as well: the cost per body and iteration is the
//! property of the kernel, while the number of iterations belongs to the motion and the step.

use catena::mechanism::description::joint::JointKind;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::state::State;
use catena::stepping::integrator::Lobatto;
use cpu_time::ThreadTime;
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use std::time::Duration;

use catena::mechanism;
#[path = "../tests/shared/models/mod.rs"]
mod models;

/// Steps between two looks at the clock.
const STEPS: usize = 8;
/// Steps before the first look: the predictor needs a past.
const WARM_UP: usize = 8;
/// The run starts over after this number of steps, so that every sample sees the same motion.
const STEPS_OF_A_RUN: usize = 104;

/// A run that starts over at its end, and counts its iterations.
struct Run<'m> {
    mechanism: &'m Mechanism,
    start: &'m State,
    state: State,
    lobatto: Lobatto,
    /// Steps since the start.
    steps: usize,
    counted_steps: usize,
    iterations: usize,
    rejected: usize,
    /// The fastest sample so far, per step.
    fastest: f64,
}

impl<'m> Run<'m> {
    fn new(model: &'m models::Model, stages: usize, step: f64, kept: &[Rule]) -> Self {
        let lobatto = Lobatto::fixed(&model.mechanism, stages, step).expect("a number of stages from 2 to 16");
        Run {
            mechanism: &model.mechanism,
            start: &model.state,
            state: model.state.clone(),
            lobatto: lobatto.keeping(&model.mechanism, kept),
            steps: STEPS_OF_A_RUN,
            counted_steps: 0,
            iterations: 0,
            rejected: 0,
            fastest: f64::INFINITY,
        }
    }

    /// CPU time of some steps; going back to the start is not in it. On a shared machine the wall clock would measure the
    /// others as well.
    fn sample(&mut self) -> Duration {
        if self.steps + STEPS > STEPS_OF_A_RUN {
            self.state.copy_from(self.start);
            for _ in 0..WARM_UP {
                self.lobatto.advance(self.mechanism, &mut self.state, f64::INFINITY).expect("a step");
            }
            self.steps = WARM_UP;
        }
        let clock = ThreadTime::now();
        for _ in 0..STEPS {
            let outcome = self.lobatto.advance(self.mechanism, &mut self.state, f64::INFINITY).expect("a step");
            self.iterations += outcome.cost.iterations;
            self.rejected += outcome.cost.rejected.total();
        }
        let elapsed = clock.elapsed();
        self.steps += STEPS;
        self.counted_steps += STEPS;
        elapsed
    }

    fn report(&self, name: &str) {
        if self.counted_steps == 0 {
            return; // filtered out on the command line
        }
        let per_body = 1e9 * self.fastest / self.mechanism.bodies.len() as f64;
        let iterations = self.iterations as f64 / self.counted_steps as f64;
        println!(
            "{name}: {per_body:.0} ns per body and step, {:.0} per body and iteration, {iterations:.2} iterations per step, \
             {} attempts thrown away",
            per_body / iterations,
            self.rejected
        );
    }
}

fn measure(group: &mut BenchmarkGroup<WallTime>, name: &str, model: &models::Model, stages: usize, step: f64) {
    measure_keeping(group, name, model, stages, step, &[]);
}

fn measure_keeping(
    group: &mut BenchmarkGroup<WallTime>,
    name: &str,
    model: &models::Model,
    stages: usize,
    step: f64,
    kept: &[Rule],
) {
    let mut run = Run::new(model, stages, step, kept);
    group.throughput(Throughput::Elements((STEPS * model.mechanism.bodies.len()) as u64));
    group.bench_function(name, |bencher| {
        bencher.iter_custom(|count| {
            let total: Duration = (0..count).map(|_| run.sample()).sum();
            run.fastest = run.fastest.min(total.as_secs_f64() / (count as usize * STEPS) as f64);
            total
        });
    });
    run.report(name);
}

fn short(group: &mut BenchmarkGroup<WallTime>) {
    group.sample_size(15).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_millis(1500));
}

/// A chain of 100 links; the step grows with the order as it does in use.
fn by_stages(criterion: &mut Criterion) {
    let model = models::chain(100);
    let mut group = criterion.benchmark_group("step_by_stages");
    short(&mut group);
    for (stages, step) in [(2, 2.5e-4), (3, 5e-4), (5, 2e-3), (9, 5e-3)] {
        measure(&mut group, &format!("{stages}"), &model, stages, step);
    }
}

/// Two bodies with the same kind of joint twice.
fn by_joint(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step_by_joint");
    short(&mut group);
    for kind in models::JOINT_KINDS {
        let model = models::one_joint(kind);
        // Free bodies fall and turn smoothly; the others swing.
        let step = if kind == JointKind::Floating { 0.02 } else { 0.01 };
        measure(&mut group, kind.name(), &model, 5, step);
    }
}

/// Rods in a plane, as bodies in that plane and as bodies in space.
fn in_a_plane(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step_in_a_plane");
    short(&mut group);
    for links in [1, 2, 5, 10, 40, 100] {
        let model = models::planar_chain(links);
        for (name, kept) in [("plane", &[][..]), ("space", &[Rule::Planar])] {
            measure_keeping(&mut group, &format!("{links}_{name}"), &model, 9, 0.01, kept);
        }
    }
}

fn by_length(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step_by_length");
    short(&mut group);
    for links in [1, 10, 100, 1000] {
        let model = models::chain(links);
        measure(&mut group, &format!("{links}"), &model, 5, 2e-3);
    }
}

criterion_group!(benches, by_stages, by_joint, by_length, in_a_plane);
criterion_main!(benches);
