//! A ball, a capsule, a can and a ball that meet on a slope: the slip of the can falls by half within a given step, because the ball pushes it onto the
//! slope. The scene is seed 163 of `benches/random_scenes.py`.

use crate::loose::{DOWN, loose, on_floor, put, slope};
use crate::mechanisms::{fixed, run};
use catena::mechanism::description::contact::Shape;
use catena::mechanism::motion::state::State;
use nalgebra::Vector3;

#[test]
fn a_given_step_in_which_friction_changes_fast_is_made_in_shorter_ones_and_keeps_the_energy() {
    let bodies = [
        (0.24096613269469863, Shape::Sphere { radius: 0.06714491534935253 }),
        (1.0654029130465585, Shape::Capsule { radius: 0.16085513077230318, half: 0.5 * 0.2822849345437374 }),
        (0.8312577625280754, Shape::Cylinder { radius: 0.2949715900193511, half: 0.5 * 0.42509674223416916 }),
        (2.8475542508805813, Shape::Sphere { radius: 0.23169435426200696 }),
    ];
    let mut mechanism = loose(DOWN, &bodies);
    on_floor(&mut mechanism, 0.1, 0.0);
    slope(&mut mechanism, Vector3::new(-0.06757594229309481, 0.12117395811008484, 0.9903284121437371));
    let mut start = State::zero(&mechanism);
    for (body, (at, velocity)) in [
        ([0.06714491534935253, 0.02335682577309703, 0.5681449153493525], [-0.06982352524501079, -0.2586525830138166]),
        ([0.2961449614710082, 0.02896592180751935, 0.8029975980441718], [-0.35229139587867686, -0.09159652373940019]),
        ([0.7529716822626624, 0.012337664531244921, 0.7135483711170846], [0.026641549232724104, 0.18730374541599648]),
        ([1.3296376265440204, -0.03796859440695734, 0.7326943542620069], [0.32037569574029856, 0.26012376759437755]),
    ]
    .into_iter()
    .enumerate()
    {
        let velocity = Vector3::new(velocity[0], velocity[1], 0.0);
        put(&mechanism, &mut start, body, [at.into(), Vector3::zeros(), velocity, Vector3::zeros()]);
    }
    for step in [0.01, 0.005, 0.0025] {
        let finished = run(&mechanism, &start, 0.4, fixed(5, step));
        let (summary, method) = (&finished.summary, &finished.method);
        println!("{step}: {} steps, {:e}", summary.steps, summary.max_relative_energy_error);
        // The ball takes 20 J down, and a step may be off by 1e-4 of what friction takes in it, 0.3 J at most: 1.5e-6. It was 1.1e-4 with all of these steps.
        assert!(summary.max_relative_energy_error <= 5e-6, "{step}: {:e}", summary.max_relative_energy_error);
        assert_eq!(method.first_order_steps, 0);
    }
}
