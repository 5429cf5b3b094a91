//! What closed contacts add to the elimination of a step.

use super::*;
use crate::models;
use catena::lobatto::plan::elimination::{Elimination, Operation};

/// The work of a step, and the largest number of unknowns that a freedom is eliminated beside.
fn planned(touches: &[TouchJoint], in_steps: bool) -> (usize, usize) {
    let mut mechanism = models::floating_tree().mechanism;
    mechanism.touches = touches.to_vec();
    let rows: Vec<usize> = touches.iter().map(|joint| joint.touch.rows()).collect();
    let plan = Elimination::new(&mechanism, 6, &rows, in_steps);
    let beside = |operation: &Operation| match operation {
        Operation::Freedom { columns, .. } => columns.len(),
        _ => 0,
    };
    (plan.work(), plan.operations.iter().map(beside).max().unwrap_or(0))
}

#[test]
fn contacts_with_the_world_go_at_their_bodies_and_fill_nothing() {
    // Four points that stick on the leg, one that slides on the hand, one on the base.
    let point = |body: usize, x: f64, grip: Grip| on_floor(body, Vector3::new(x, 0.0, 0.0), 0.0, grip);
    let mut touches: Vec<TouchJoint> = (0..4).map(|number| point(4, 0.1 * f64::from(number), Grip::Rolls)).collect();
    touches.extend([point(2, 0.0, slides(0.5)), point(0, 0.0, slides(0.0))]);
    let (alone, six) = planned(&[], true);
    let (work, beside) = planned(&touches, true);
    // 12 + 1 + 1 equations, and how the friction of one turns: each goes beside the six components of the twist of its body.
    assert_eq!((work, beside), (alone + 15 * 7 * 7, six));
    assert_eq!(six, 6);
    // Projections at one configuration measure how the equations depend on each other, and carry them to the world.
    assert_eq!(planned(&touches, false).1, 6 + 14);
    // So does a step with contacts between two bodies, as far as where their branches meet.
    let between = touch([Feature::Plane, Feature::Point { radius: 0.1 }], slides(0.0), touches[4].b, touches[0].b);
    assert_eq!(planned(&[between], true).1, 6 + 1);
}
