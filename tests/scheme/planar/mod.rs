//! Planar motion: three coordinates a body say the same as six, step by step.

mod loops;
mod planes;
mod rule;
mod trees;

use crate::common::Numbers;
use crate::in_plane::{place, random_tree};
use crate::models::Model;
use catena::instant::start::assembly::assemble;
use catena::mechanism::description::closure::{Attachment, LoopJoint, LoopKind};
use catena::mechanism::description::joint::Pose;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::mechanism::structure::plane::Plane;
use nalgebra::{Rotation3, Translation3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Largest difference of positions and velocities.
fn apart(a: &State, b: &State) -> f64 {
    let differences = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    differences(&a.position, &b.position).max(differences(&a.velocity, &b.velocity))
}

/// How a joint frame lies in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lies {
    /// z along the normal, either way.
    Along,
    /// z in the plane.
    Across,
    /// Neither.
    Oblique,
}

/// A closure between two bodies where they are, or between a body and the world, which says nothing there yet: for some kinds with its
/// points at different heights.
fn closure(model: &Model, kind: LoopKind, lies: Lies, ends: [Option<usize>; 2], numbers: &mut Numbers) -> LoopJoint {
    let plane = Plane::of(&model.mechanism).expect("a plane");
    let bodies = body_states(&model.mechanism, &model.state);
    let upright = Rotation3::from_matrix(&nalgebra::Matrix3::from_columns(&plane.axes));
    let about_z = |angle| Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
    let tilted = |angle| Rotation3::from_axis_angle(&Vector3::x_axis(), angle);
    let tilt = match lies {
        Lies::Along => {
            if numbers.next(-1.0, 1.0) > 0.0 {
                0.0
            } else {
                PI
            }
        }
        Lies::Across => FRAC_PI_2,
        Lies::Oblique => 0.6,
    };
    let on_a = upright * about_z(numbers.next(-3.0, 3.0)) * tilted(tilt) * about_z(numbers.next(-3.0, 3.0));
    let on_b = match (kind, lies) {
        // z_b across z_a: in the plane too, or along the normal.
        (LoopKind::Universal, Lies::Across) => upright * about_z(FRAC_PI_2) * upright.inverse() * on_a,
        (LoopKind::Universal, _) => on_a * tilted(FRAC_PI_2) * about_z(0.3),
        // What only aligns the axes does not mind how the frames are turned about them.
        (LoopKind::Revolute | LoopKind::Cylindrical | LoopKind::Planar, _) => on_a * about_z(numbers.next(-3.0, 3.0)),
        (LoopKind::Spherical | LoopKind::Distance(_), _) => on_a * tilted(0.7),
        _ => on_a,
    };
    let at_a =
        ends.iter().flatten().map(|&body| bodies[body].position).sum::<Vector3<f64>>() * 0.5 + place(numbers, 0.3);
    let slid = match kind {
        LoopKind::Prismatic | LoopKind::Cylindrical => on_a * Vector3::new(0.0, 0.0, 0.4),
        LoopKind::Planar => on_a * Vector3::new(0.3, -0.2, 0.0),
        LoopKind::Distance(_) => upright * Vector3::new(0.5, 0.4, 0.3),
        _ => Vector3::zeros(),
    };
    let kind = if let LoopKind::Distance(_) = kind { LoopKind::Distance(slid.norm()) } else { kind };
    let attach = |body: Option<usize>, point: Vector3<f64>, frame: Rotation3<f64>| {
        let Some(body) = body else {
            return Attachment { body: None, frame: Pose::from_parts(point.into(), frame) };
        };
        let turned = Rotation3::from_matrix_unchecked(bodies[body].rotation);
        let point = turned.inverse() * (point - bodies[body].position);
        Attachment { body: Some(body), frame: Pose::from_parts(Translation3::from(point), turned.inverse() * frame) }
    };
    let (a, b) = (attach(ends[0], at_a, on_a), attach(ends[1], at_a + slid, on_b));
    LoopJoint { name: format!("{kind:?} {lies:?}"), kind, a, b }
}

/// All kinds, each as it allows motions in a plane, and the number of equations that it has there.
const KINDS: [(LoopKind, Lies, usize); 15] = [
    (LoopKind::Revolute, Lies::Along, 2),
    (LoopKind::Revolute, Lies::Across, 3),
    (LoopKind::Prismatic, Lies::Along, 3),
    (LoopKind::Prismatic, Lies::Across, 2),
    (LoopKind::Cylindrical, Lies::Along, 2),
    (LoopKind::Cylindrical, Lies::Across, 2),
    (LoopKind::Universal, Lies::Along, 2),
    (LoopKind::Universal, Lies::Across, 3),
    (LoopKind::Spherical, Lies::Oblique, 2),
    (LoopKind::Planar, Lies::Along, 0),
    (LoopKind::Planar, Lies::Across, 2),
    (LoopKind::Fixed, Lies::Along, 3),
    (LoopKind::Fixed, Lies::Across, 3),
    (LoopKind::Fixed, Lies::Oblique, 3),
    (LoopKind::Distance(1.0), Lies::Oblique, 1),
];

/// A tree in an inclined plane with closures in it, the first of them of this kind; on its closures in position and velocity.
fn random_loops(seed: u64, kind: LoopKind, lies: Lies) -> Model {
    let mut numbers = Numbers::new(seed + 1000);
    let mut model = random_tree(seed, 11, Vector3::new(0.3, -0.5, 0.7));
    // The closures are where zero displacement is not.
    let ends = [[Some(10), Some(4)], [Some(8), None], [Some(6), Some(9)]];
    let kinds = [(kind, lies), (LoopKind::Distance(1.0), Lies::Oblique), (LoopKind::Cylindrical, Lies::Across)];
    for ((kind, lies), ends) in kinds.into_iter().zip(ends) {
        let joint = closure(&model, kind, lies, ends, &mut numbers);
        model.mechanism.loops.push(joint);
    }
    assemble(&model.mechanism, &mut model.state).expect("closed where it was made");
    model
}
