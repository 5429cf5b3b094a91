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
pub fn rocking() -> (Mechanism, State) {
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

/// A box of four feet at (±1, ±1) has one family of normal forces: those of least norm of the reference and any multiple of (1, −1, −1, 1) more. Reported
/// are those of least Σ w |r|² with the mean mobility w of each foot.
#[test]
fn the_forces_of_a_box_on_four_feet_are_the_least_that_balance_its_load_each_weighed_by_how_easily_its_foot_moves() {
    let Some(mut lines) = answer("C10") else { return };
    // Under a load in the middle all feet are alike, and the least norm is theirs.
    lines.push(vec![0.0, 0.0, 0.25, 0.25, 0.25, 0.25]);
    for line in &lines {
        let (x, y) = (line[0], line[1]);
        let inertia = Vector3::new(0.4, 0.4, 0.7);
        let shape = (cuboid(1.0, 1.0, 0.2), Pose::translation(-x, -y, 0.0));
        let feet = over_floor(1.0, inertia, vec![shape], -Vector3::z(), 0.5, 0.0);
        let start = resting(&feet, &[Vector3::new(x, y, 0.2)]);
        let finished = run(&feet, &start, 1.0, fixed(5, 0.05));
        let corners = [(-1.0, -1.0, 1.0), (-1.0, 1.0, -1.0), (1.0, -1.0, -1.0), (1.0, 1.0, 1.0)];
        // The trace of D = 1/m + [r]ᵀ J⁻¹ [r], with the arm r from the centre of mass.
        let mobility = |(at_x, at_y, _): (f64, f64, f64)| {
            let square = Vector3::new(at_x - x, at_y - y, -0.2).map(|arm| arm * arm);
            let across = Vector3::repeat(square.sum()) - square;
            (3.0 + across.component_div(&inertia).sum()) / 3.0
        };
        let weights = corners.map(mobility);
        let sum = |of: &dyn Fn(usize) -> f64| (0..4).map(|foot| weights[foot] * of(foot)).sum::<f64>();
        let more = -sum(&|foot| corners[foot].2 * line[2 + foot]) / sum(&|_| 1.0);
        let largest_force = finished.contacts.iter().map(|point| point.force.norm()).fold(0.0, f64::max);
        for (foot, corner) in corners.into_iter().enumerate() {
            let near_corner = |at: &Vector3<f64>| (at.x - corner.0).hypot(at.y - corner.1) < 1e-9;
            let point = finished.contacts.iter().find(|point| near_corner(&point.position)).expect("a foot");
            let wanted = line[2 + foot] + more * corner.2;
            assert!(wanted > 0.0, "no foot is at its bound, so that the law leaves the choice: {wanted}");
            // What a compliance of 1e-6 leaves, in parts of the largest force.
            near(point.force.dot(&point.normal), wanted, 1e-5 * largest_force);
            assert!(
                (point.force - point.normal * wanted).norm() < 1e-5 * largest_force,
                "it does not pinch: {point:?}"
            );
        }
    }
}
