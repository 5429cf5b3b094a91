//! A step allocates nothing on the heap.

mod closed;
mod models;

use catena::lobatto::Lobatto;
use catena::model::JointKind;
use catena::simulation::Integrator;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

// One test in this file: another one on another thread would be counted too.
#[test]
fn a_step_allocates_nothing_with_fixed_or_chosen_steps_any_joint_any_force_and_loops() {
    let mut all =
        vec![models::double_pendulum(), models::floating_tree(), models::slow_heavy_top(), models::free_body()];
    // In a plane, with a kernel of their own.
    all.push(models::planar_chain(4));
    all.extend([JointKind::Planar, JointKind::Prismatic].map(models::one_joint));
    all.extend([models::floating_tree(), models::one_joint(JointKind::Planar), models::planar_chain(4)].map(|model| {
        let every_force = models::every_force(&model.mechanism).pop().unwrap().1;
        models::with_forces(model, every_force)
    }));
    all.extend(
        [closed::four_bars(2, 5), closed::bricard()].map(|(mechanism, state)| models::Model { mechanism, state }),
    );
    for model in all {
        let mechanism = &model.mechanism;
        for stages in [Some(2), Some(5), Some(9), None] {
            let allocations = || {
                let mut lobatto = match stages {
                    Some(stages) => Lobatto::fixed(mechanism, stages, 0.01).unwrap(),
                    None => Lobatto::adaptive(mechanism, 1e-6),
                };
                let mut state = model.state.clone();
                // The first step sets up the controller.
                lobatto.advance(mechanism, &mut state, f64::INFINITY).unwrap();
                let region = Region::new(ALLOCATOR);
                for _ in 0..50 {
                    lobatto.advance(mechanism, &mut state, f64::INFINITY).unwrap();
                }
                let change = region.change();
                change.allocations + change.reallocations + change.deallocations
            };
            // The test harness has a thread of its own, which is seen here once in a hundred runs; a step that allocates does so every time.
            let free = (0..3).any(|_| allocations() == 0);
            assert!(free, "{}, {stages:?} stages", mechanism.name);
        }
    }
}
