//! A block that rocks from edge to edge (Housner), and a box on four feet.

use crate::contacts::over_floor;
use crate::exact::{answer, near};
use crate::loose::{DOWN, cuboid, loose, on_floor, put, resting};
use crate::mechanisms::{fixed, of_kind, run};
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::state::State;
use nalgebra::Vector3;

/// Half the width and half the height of the block (m).
const WIDTH: f64 = 0.1;
const HEIGHT: f64 = 0.3;

/// The block of C8, at rest and tilted by 0.15 about its lower edge.
fn rocking() -> (Mechanism, State) {
    let mut block = loose(DOWN, &[(1.0, cuboid(WIDTH, 0.15, HEIGHT))]);
    on_floor(&mut block, 0.8, 0.0);
    let (sine, cosine) = 0.15_f64.sin_cos();
    // It stands on the edge with +x.
    let at = Vector3::new(0.0, 0.0, WIDTH * sine + HEIGHT * cosine);
    let mut start = State::zero(&block);
    put(&block, &mut start, 0, [at, Vector3::y() * 0.15, Vector3::zeros(), Vector3::zeros()]);
    (block, start)
}

#[test]
fn a_rocking_block_lands_when_and_as_fast_as_housner_says() {
    let Some(lines) = answer("C8") else { return };
    let (block, start) = rocking();
    let finished = run(&block, &start, 1.6, fixed(9, 0.02));
    let impacts = of_kind(&finished, EventKind::ContactImpact);
    assert_eq!(impacts.len(), 6, "{:?}", finished.events);
    for (line, impact) in lines[1..7].iter().zip(&impacts) {
        near(impact.time, line[1], 1e-10);
        // The centre falls with b ω⁻ and rises with b ω⁺ = 0.85 b ω⁻.
        near(impact.impulse.expect("an impulse"), 1.85 * WIDTH * line[2], 1e-10);
    }
    assert!(finished.summary.contact.penetration <= 1e-12, "{:?}", finished.summary.contact);
    assert!(finished.summary.contact.cone_violation <= 1e-10, "{:?}", finished.summary.contact);
}

#[test]
fn a_box_on_four_feet_stands_and_its_forces_press_and_balance_the_load() {
    let Some(lines) = answer("C10") else { return };
    for line in &lines {
        let (x, y) = (line[0], line[1]);
        let shape = (cuboid(1.0, 1.0, 0.2), Pose::translation(-x, -y, 0.0));
        let inertia = Vector3::new(0.4, 0.4, 0.7);
        let feet = over_floor(1.0, inertia, vec![shape], -Vector3::z(), 0.5, 0.0);
        let start = resting(&feet, &[Vector3::new(x, y, 0.2)]);
        let finished = run(&feet, &start, 10.0, fixed(5, 0.05));
        assert_eq!((&finished.state.position, &finished.state.velocity), (&start.position, &start.velocity));
        assert_eq!(finished.contacts.len(), 4);
        let mut sums = [0.0; 3];
        for point in &finished.contacts {
            let force = point.force.dot(&point.normal);
            assert!(force >= 0.0 && point.cone_violation(0.5) == 0.0, "{point:?}");
            sums[0] += force;
            sums[1] += force * point.position.x;
            sums[2] += force * point.position.y;
        }
        for (sum, wanted) in sums.into_iter().zip([1.0, x, y]) {
            near(sum, wanted, 1e-12);
        }
    }
}
