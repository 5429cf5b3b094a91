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

// A program of its own, without the test harness, whose own thread would be counted too.
fn main() {
    a_step_allocates_nothing_with_fixed_or_chosen_steps_any_joint_any_force_and_loops();
    println!("test a_step_allocates_nothing_with_fixed_or_chosen_steps_any_joint_any_force_and_loops ... ok");
}

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
        let integrators = [2, 5, 9]
            .map(|stages| Lobatto::fixed(mechanism, stages, 0.01).unwrap())
            .into_iter()
            .chain([Lobatto::adaptive(mechanism, 1e-6)]);
        for mut lobatto in integrators {
            let mut state = model.state.clone();
            // The first step sets up the controller.
            lobatto.advance(mechanism, &mut state, f64::INFINITY).unwrap();
            let region = Region::new(ALLOCATOR);
            for _ in 0..50 {
                lobatto.advance(mechanism, &mut state, f64::INFINITY).unwrap();
            }
            let change = region.change();
            let count = change.allocations + change.reallocations + change.deallocations;
            assert_eq!(count, 0, "{}, {:?}: {change:?}", mechanism.name, lobatto.description());
        }
    }
}
