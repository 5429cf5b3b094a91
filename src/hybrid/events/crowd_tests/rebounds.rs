//! Blows that pass through contacts, and ropes, in steps of crowds.

use super::{boxes, put, run};
use crate::events::integrator::Eventful;
use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::Integrator;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::stepping::length::stage_choice::StageChoice;
use crate::stepping::recipe::{Recipe, Steps};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

#[test]
fn a_blow_passes_through_boxes_in_touch_as_event_by_event() {
    for (friction, restitution) in [(0.0, 1.0), (0.0, 0.7), (0.0, 0.3), (0.4, 0.7), (0.0, 0.0)] {
        let mut mechanism = boxes(4, Vector3::repeat(0.1), friction, restitution);
        mechanism.gravity = Vector3::zeros();
        let mut start = State::zero(&mechanism);
        // Three in touch, high above the floor, and one that strikes them at 0.03 s.
        for (body, x) in [(0, -0.29), (1, 0.0), (2, 0.2), (3, 0.4)] {
            put(&mut start, body, [x, 0.0, 5.0], [0.0; 3]);
        }
        start.velocity[0] = 3.0;
        let mut stepped = start.clone();
        run(&mechanism, &mut stepped, 1e-3, 0.1, |_, _, _| {});
        let steps = Steps::Chosen { tolerance: 1e-7, stop: 1e-11, stages: StageChoice::Many };
        let recipe = Recipe::new(steps, vec![Rule::Crowds]);
        let mut eventful = Eventful::new(&mechanism, recipe).expect("possible steps");
        while start.time < 0.1 {
            eventful.step(&mechanism, Inputs::constant(&[0.0; 24]), &mut start, 0.1).expect("a step");
        }
        let speeds = |state: &State| [0, 1, 2, 3].map(|body| state.velocity[6 * body]);
        for (one, other) in speeds(&stepped).into_iter().zip(speeds(&start)) {
            // Laws are solved to 5e-9 of the largest impulse.
            let all = (speeds(&stepped), speeds(&start));
            assert!((one - other).abs() < 1e-6, "friction {friction}, restitution {restitution}: {all:?}");
        }
    }
}

#[test]
fn a_ball_on_a_rope_swings_in_steps_of_a_crowd_wherever_the_rope_hangs() {
    // Far from the origin of the world, balls about a rope's ends are far apart, and the rope is taut.
    for far in [0.0, 100.0] {
        let mut mechanism = boxes(1, Vector3::repeat(0.05), 0.0, 0.7);
        let nonsmooth = &mut mechanism.nonsmooth;
        let hook = Pose::from_parts(Translation3::new(far, 0.0, 3.0), UnitQuaternion::identity().to_rotation_matrix());
        nonsmooth.colliders.push(Collider::still("rope", None, hook, Shape::Hollow { radius: 1.0 }));
        nonsmooth.colliders.push(Collider::still("end", Some(0), Pose::identity(), Shape::Point));
        let number = nonsmooth.pairs.len();
        nonsmooth.pairs.push(ContactPair::without_moments(number, [2, 3], 0.0, 0.0));
        let mut state = State::zero(&mechanism);
        put(&mut state, 0, [far + 0.6, 0.0, 3.0 - 0.8], [0.0; 3]);
        let (mut longest, mut lowest) = (0.0_f64, 10.0_f64);
        run(&mechanism, &mut state, 1e-3, 1.0, |_, state, _| {
            let place = body_states(&mechanism, state)[0].position - Vector3::new(far, 0.0, 3.0);
            longest = longest.max(place.norm());
            lowest = lowest.min(place.z);
        });
        assert!(longest < 1.0 + 1e-8, "{far}: {longest}");
        // It passes below the hook, with steps of 2 mm, and rises to its height, but for what steps of first order lose.
        assert!((lowest + 1.0).abs() < 1e-4, "{far}: {lowest}");
        let speed = state.velocity[..3].iter().map(|rate| rate * rate).sum::<f64>();
        let height = body_states(&mechanism, &state)[0].position.z - 3.0 + 0.5 * speed / 9.81;
        assert!((height + 0.8).abs() < 1e-2, "{far}: {height}");
    }
}
