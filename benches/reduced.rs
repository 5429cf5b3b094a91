//! Measures an evaluation of the comparator: the articulated-body algorithm alone, and inside DOP853.
//!
//! `articulated_body/N` is one evaluation of a chain of N revolute links; divide by N for the time per link.
//! `dop853/N` is one step with a fixed length, which is 12 evaluations; its excess over 12 × N links of the first is
//! the cost of the vector operations.

use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::state::State;
use catena::reduced::{ArticulatedBody, Dop853};
use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Rotation3, Translation3, Vector3};
use std::hint::black_box;

/// Links of 0.1 kg and 0.1 m that hang along −z and turn about y and x by turns.
fn chain(count: usize) -> Mechanism {
    let bodies = (0..count).map(|index| {
        let axis = if index % 2 == 0 { Vector3::y() } else { Vector3::x() };
        let turn = Rotation3::rotation_between(&Vector3::z(), &axis).expect("not antiparallel");
        let frame = |z: f64| Pose::from_parts(Translation3::new(0.0, 0.0, z), turn);
        let on_parent = frame(if index == 0 { 0.0 } else { -0.05 });
        Body {
            name: format!("link{index}"),
            parent: index.checked_sub(1),
            mass: 0.1,
            inertia: Vector3::new(8.7e-5, 8.7e-5, 6.7e-6),
            joint: Joint::new(&format!("joint{index}"), JointKind::Revolute, on_parent, frame(0.05)),
        }
    });
    Mechanism::new("chain", Vector3::new(0.0, 0.0, -9.81), bodies.collect()).expect("depth first")
}

fn bent(mechanism: &Mechanism) -> State {
    let mut state = State::zero(mechanism);
    for (index, angle) in state.position.iter_mut().enumerate() {
        *angle = 0.3 * (index as f64).sin();
    }
    state
}

fn evaluation(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("articulated_body");
    for count in [10, 100, 1000] {
        let mechanism = chain(count);
        let mut state = bent(&mechanism);
        state.velocity.iter_mut().enumerate().for_each(|(index, rate)| *rate = (index as f64).cos());
        let mut dynamics = ArticulatedBody::new(&mechanism);
        let mut acceleration = vec![0.0; count];
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::from_parameter(count), |bencher| {
            bencher.iter(|| {
                dynamics.accelerations(black_box(&state.position), &state.velocity, None, &mut acceleration);
                acceleration[count - 1]
            });
        });
    }
    group.finish();
}

fn step(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("dop853");
    for count in [10, 100, 1000] {
        let mechanism = chain(count);
        let mut integrator = Dop853::with_fixed_step(&mechanism, 1e-4);
        let mut state = bent(&mechanism);
        integrator.advance(&mechanism, &mut state, 1.0).expect("a step");
        // Twelve evaluations of every link, the first slope being known from the step before.
        group.throughput(Throughput::Elements(12 * count as u64));
        group.bench_function(BenchmarkId::from_parameter(count), |bencher| {
            bencher.iter_batched_ref(
                || {
                    let mut fresh = (integrator.clone(), bent(&mechanism));
                    fresh.0.advance(&mechanism, &mut fresh.1, 1.0).expect("a step");
                    fresh
                },
                |(integrator, state)| integrator.advance(&mechanism, state, 1.0).expect("a step"),
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, evaluation, step);
criterion_main!(benches);
