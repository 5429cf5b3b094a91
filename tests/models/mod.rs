//! The mechanisms that tests and benches share, each with an initial state and, where there is one, an answer.
//!
//! Published and converged answers are those of the project's page of benchmark problems (`benchmarks.md`: sections
//! "Heavy top", "Free box / Dzhanibekov" and "Chains and double pendula"), which names its own sources. Lengths are in
//! metres, masses in kg, angles in radians, times in seconds; gravity is 9.81 m/s² downwards unless a line says otherwise.

// Every program of tests and every bench compiles its own copy of this module and uses some of it.
#![allow(dead_code)]

use catena::forces::total::scalar_coordinate;
use catena::forces::{Forces, JointDamper, JointLoad, JointSpring, PointSpring, Wrench};
use catena::kinematics::body_states;
use catena::model::{Attachment, Body, FreeRotation, Joint, JointKind, Mechanism, Pose};
use catena::state::{BodyState, State};
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};

/// A mechanism and the state a run starts from.
pub struct Model {
    pub mechanism: Mechanism,
    pub state: State,
}

impl Model {
    /// The maximal-coordinate state at the start.
    pub fn bodies(&self) -> Vec<BodyState> {
        body_states(&self.mechanism, &self.state)
    }
}

/// Standard gravity of these models.
pub fn gravity() -> Vector3<f64> {
    Vector3::new(0.0, 0.0, -9.81)
}

/// A frame at `place` whose z axis, the joint's axis, points along `axis`.
pub fn frame(place: Vector3<f64>, axis: Vector3<f64>) -> Pose {
    let turn = Rotation3::rotation_between(&Vector3::z(), &axis)
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    Pose::from_parts(Translation3::from(place), turn)
}

/// A frame at `place` turned by the rotation vector `turn`.
pub fn turned_frame(place: Vector3<f64>, turn: Vector3<f64>) -> Pose {
    Pose::from_parts(Translation3::from(place), Rotation3::new(turn))
}

/// Principal moments of a uniform box about its centre: `m/12 (b² + c²)` and so on.
pub fn box_inertia(mass: f64, size: Vector3<f64>) -> Vector3<f64> {
    let square = size.component_mul(&size);
    Vector3::new(square.y + square.z, square.z + square.x, square.x + square.y) * (mass / 12.0)
}

/// A body from its parts.
pub fn body(name: &str, parent: Option<usize>, mass: f64, inertia: Vector3<f64>, joint: Joint) -> Body {
    Body { name: name.to_string(), parent, mass, inertia, joint }
}

/// A model at rest at zero displacement.
fn model(name: &str, gravity: Vector3<f64>, bodies: Vec<Body>) -> Model {
    let mechanism = Mechanism::new(name, gravity, bodies).expect("the models of this module are well formed");
    let state = State::zero(&mechanism);
    Model { mechanism, state }
}

/// Gives every joint a displacement and a rate of order one half, all different and none special.
fn set_generic_state(model: &mut Model) {
    let wave = |index: usize, phase: f64| 0.5 * (1.7 * index as f64 + phase).sin();
    for body in &model.mechanism.bodies {
        let joint = &body.joint;
        let position = &mut model.state.position[joint.position_range()];
        let first = joint.position_index;
        for (offset, entry) in position.iter_mut().enumerate() {
            *entry += wave(first + offset, 0.6);
        }
        if joint.kind.rotation() == FreeRotation::Ball {
            let quaternion = &mut position[joint.kind.translation_axes().len()..];
            let norm = quaternion.iter().map(|component| component * component).sum::<f64>().sqrt();
            quaternion.iter_mut().for_each(|component| *component /= norm);
        }
    }
    for (index, entry) in model.state.velocity.iter_mut().enumerate() {
        *entry = 2.0 * wave(index, 2.1);
    }
}

/// Two 1 m boxes: a revolute joint about y, then one about x, off the centre lines, released at rest from
/// (1.2, −0.7) rad. The smallest truly spatial mechanism: the two rotations do not commute.
pub fn double_pendulum() -> Model {
    let size = Vector3::new(0.06, 0.12, 1.0);
    let inertia = box_inertia(1.0, size);
    let centre = [Vector3::new(0.01, 0.02, -0.5), Vector3::new(0.03, -0.01, -0.5)];
    let elbow = Vector3::new(0.04, 0.09, -1.0);
    let shoulder_joint = Joint::new(
        "shoulder",
        JointKind::Revolute,
        frame(Vector3::zeros(), Vector3::y()),
        frame(-centre[0], Vector3::y()),
    );
    let elbow_joint = Joint::new(
        "elbow",
        JointKind::Revolute,
        frame(elbow - centre[0], Vector3::x()),
        frame(-centre[1], Vector3::x()),
    );
    let mut model = model(
        "double_pendulum",
        gravity(),
        vec![body("upper", None, 1.0, inertia, shoulder_joint), body("lower", Some(0), 1.0, inertia, elbow_joint)],
    );
    model.state.position = vec![1.2, -0.7];
    model
}

/// One box on a spherical joint, with a spin: a pendulum that leaves every plane.
pub fn spatial_pendulum() -> Model {
    let joint = Joint::new(
        "pivot",
        JointKind::Spherical,
        turned_frame(Vector3::new(0.1, -0.2, 0.3), Vector3::new(0.4, -0.3, 0.2)),
        turned_frame(Vector3::new(0.03, 0.05, 0.6), Vector3::new(-0.2, 0.5, 0.1)),
    );
    let inertia = box_inertia(2.0, Vector3::new(0.2, 0.3, 1.0));
    let mut model = model("spatial_pendulum", gravity(), vec![body("bob", None, 2.0, inertia, joint)]);
    set_generic_state(&mut model);
    model
}

/// A floating base with every other kind of joint on it: a slider that carries a hinge, a ball and a hinge.
pub fn floating_tree() -> Model {
    let x = Vector3::x();
    let base = Joint::new(
        "base",
        JointKind::Floating,
        turned_frame(Vector3::new(0.2, 0.1, 1.0), Vector3::new(0.3, 0.2, -0.1)),
        turned_frame(Vector3::new(0.05, -0.02, 0.03), Vector3::new(-0.1, 0.2, 0.3)),
    );
    let rail = Joint::new(
        "rail",
        JointKind::Prismatic,
        turned_frame(Vector3::new(0.3, 0.0, 0.1), Vector3::new(0.2, 1.1, 0.0)),
        turned_frame(Vector3::new(-0.1, 0.02, 0.0), Vector3::new(0.3, -0.4, 0.5)),
    );
    let wrist = Joint::new(
        "wrist",
        JointKind::Revolute,
        turned_frame(Vector3::new(0.15, 0.0, 0.05), Vector3::new(-0.6, 0.3, 0.2)),
        turned_frame(Vector3::new(-0.12, 0.0, 0.01), Vector3::new(0.1, 0.8, 0.0)),
    );
    let ball = Joint::new(
        "ball",
        JointKind::Spherical,
        turned_frame(Vector3::new(-0.3, 0.1, 0.0), Vector3::new(0.0, 0.4, 0.9)),
        turned_frame(Vector3::new(0.0, 0.2, 0.0), Vector3::new(0.5, 0.0, -0.3)),
    );
    let hip = Joint::new(
        "hip",
        JointKind::Revolute,
        frame(Vector3::new(0.0, -0.2, -0.1), x),
        turned_frame(Vector3::new(0.02, 0.0, 0.25), Vector3::new(0.2, 0.9, -0.4)),
    );
    let block = |mass: f64, a: f64, b: f64, c: f64| box_inertia(mass, Vector3::new(a, b, c));
    let mut model = model(
        "floating_tree",
        gravity(),
        vec![
            body("base", None, 5.0, block(5.0, 0.6, 0.4, 0.2), base),
            body("slider", Some(0), 1.0, block(1.0, 0.3, 0.1, 0.1), rail),
            body("hand", Some(1), 0.5, block(0.5, 0.25, 0.05, 0.1), wrist),
            body("club", Some(0), 0.8, block(0.8, 0.1, 0.4, 0.15), ball),
            body("leg", Some(0), 1.2, block(1.2, 0.1, 0.12, 0.5), hip),
        ],
    );
    set_generic_state(&mut model);
    model
}

/// A pose at an instant, as the benchmark page prints it.
pub struct PoseReference {
    /// Time [s].
    pub time: f64,
    /// Centre of mass [m].
    pub position: [f64; 3],
    /// Quaternion w, x, y, z from body to world.
    pub quaternion: [f64; 4],
}

impl PoseReference {
    /// Largest error of a body's pose: metres, or entries of the rotation matrix.
    pub fn error(&self, body: &BodyState) -> f64 {
        let rotation = catena::model::joint::rotation_from_wxyz(&self.quaternion);
        (body.position - Vector3::from(self.position)).amax().max((body.rotation - rotation).amax())
    }
}

/// Answers of [`slow_heavy_top`], computed to all digits ("Heavy top", slow).
pub const SLOW_HEAVY_TOP: [PoseReference; 2] = [
    PoseReference {
        time: 0.5,
        position: [0.0072227982418607084, 0.40584229862183535, -0.9139145801632133],
        quaternion: [0.7791721819634324, -0.5049365138962945, 0.3095349094456719, -0.20522662503520242],
    },
    PoseReference {
        time: 1.0,
        position: [-0.03116864706262382, -0.9833836814196768, -0.1788436483573548],
        quaternion: [0.05545611908768885, -0.7325720465167228, 0.07233794402589604, -0.6745591429757207],
    },
];

/// Answers of [`heavy_top`], computed to all digits ("Heavy top", fast).
pub const HEAVY_TOP: [PoseReference; 2] = [
    PoseReference {
        time: 0.1,
        position: [0.421296658925402, 0.894571974345593, -0.1491647004818996],
        quaternion: [0.3318229126083008, 0.17733805666693703, 0.9149751591387278, -0.14582601443088863],
    },
    PoseReference {
        time: 0.5,
        position: [-0.7024682970565856, -0.021165184701923325, -0.7114002576517344],
        quaternion: [0.5845606240694147, -0.7006628954122065, 0.3843257530228944, 0.1401930788004352],
    },
];

/// The heavy top of the benchmark page with its centre of mass 1 m along y from the fixed point, spun with the body
/// angular velocity `spin`. Its second-moment matrix is singular (Σ₂ = 0): it is as flat as a body can be.
fn heavy_top_with_spin(spin: [f64; 3]) -> Model {
    let joint = Joint::new("pivot", JointKind::Spherical, Pose::identity(), Pose::translation(0.0, -1.0, 0.0));
    let inertia = Vector3::new(0.234375, 0.46875, 0.234375);
    let mut model = model("heavy_top", gravity(), vec![body("top", None, 15.0, inertia, joint)]);
    model.state.velocity = spin.to_vec();
    model
}

/// The fast heavy top, 150 rad/s; answers in [`HEAVY_TOP`].
pub fn heavy_top() -> Model {
    heavy_top_with_spin([0.0, 150.0, -4.61538])
}

/// The slow heavy top, 1.5 rad/s; answers in [`SLOW_HEAVY_TOP`].
pub fn slow_heavy_top() -> Model {
    heavy_top_with_spin([0.0, 1.5, -0.0461538])
}

/// Answers of [`free_body`]: time, quaternion w, x, y, z and body angular velocity ("Free box", complex).
pub const FREE_BODY: [(f64, [f64; 4], [f64; 3]); 2] = [
    (
        1.0,
        [-0.7131099965285805, 0.35235939104587477, 0.5251841908883688, -0.3024872857389507],
        [3.4237984415545983, 2.8191854383979655, 3.9283844494670332],
    ),
    (
        2.0,
        [0.014628222352809942, -0.995446416875774, -0.027380467565805464, 0.0901263348631108],
        [0.3366497607839556, -4.98493293518989, 0.3821818813045565],
    ),
];

/// The box of the benchmark page, 0.1 × 0.4 × 0.9 m and 10 kg, thrown with a spin near its intermediate axis under
/// 9.8 m/s²; the centre follows `(−2, 2, 8) t + ½ g t²` and the rotation [`FREE_BODY`].
pub fn free_body() -> Model {
    let joint = Joint::new("free", JointKind::Floating, Pose::identity(), Pose::identity());
    let inertia = box_inertia(10.0, Vector3::new(0.1, 0.4, 0.9));
    let mut model = model("free_body", Vector3::new(0.0, 0.0, -9.8), vec![body("box", None, 10.0, inertia, joint)]);
    model.state.velocity = vec![-2.0, 2.0, 8.0, 0.1, 5.0, 0.1];
    model
}

/// `n` links of 0.1 m and 0.1 kg hanging out along x, their joints about y and x in turn, so that every second joint
/// twists a link about its own axis, whose inertia is tiny; released at rest with the twist joints at 0.4 rad.
pub fn chain(n: usize) -> Model {
    let half = Vector3::new(0.05, 0.0, 0.0);
    // Twisting this box takes thirteen times less than turning it about the other axes.
    let inertia = box_inertia(0.1, Vector3::new(0.1, 0.02, 0.02));
    let bodies = (0..n)
        .map(|index| {
            let axis = if index % 2 == 0 { Vector3::y() } else { Vector3::x() };
            let on_parent = if index == 0 { Vector3::zeros() } else { half };
            let joint = Joint::new(
                &format!("joint{}", index + 1),
                JointKind::Revolute,
                frame(on_parent, axis),
                frame(-half, axis),
            );
            body(&format!("link{}", index + 1), index.checked_sub(1), 0.1, inertia, joint)
        })
        .collect();
    let mut model = model(&format!("chain_{n}"), gravity(), bodies);
    for (index, angle) in model.state.position.iter_mut().enumerate() {
        *angle = if index % 2 == 0 { 0.0 } else { 0.4 };
    }
    model
}

/// Tip of [`planar_chain`]: number of links, time, x and z ("Chains and double pendula", slender).
pub const PLANAR_CHAIN_TIP: [(usize, f64, f64, f64); 6] = [
    (1, 1.0, -0.6234971351168769, -0.7818256343335431),
    (1, 5.0, 0.661501402094312, -0.7499439279221211),
    (2, 1.0, -1.2996809166734178, -1.5072258765296855),
    (2, 5.0, 1.3380917082706478, -1.48101396536259),
    (5, 1.0, -0.21699630894211752, -4.991797466010115),
    (10, 1.0, 3.937811983960202, -8.855261908709554),
];

/// `n` uniform rods of 1 m and 1 kg hinged about y in one plane, straight, 45° from hanging, at rest. The inertia about
/// a rod's own axis never acts; it is 0.01 kg m² instead of zero so that the second moments are positive.
pub fn planar_chain(n: usize) -> Model {
    let half = Vector3::new(0.0, 0.0, -0.5);
    let bodies = (0..n)
        .map(|index| {
            let on_parent = if index == 0 { Vector3::zeros() } else { half };
            let joint = Joint::new(
                &format!("joint{}", index + 1),
                JointKind::Revolute,
                frame(on_parent, Vector3::y()),
                frame(-half, Vector3::y()),
            );
            let inertia = Vector3::new(1.0 / 12.0, 1.0 / 12.0, 0.01);
            body(&format!("rod{}", index + 1), index.checked_sub(1), 1.0, inertia, joint)
        })
        .collect();
    let mut model = model(&format!("planar_chain_{n}"), gravity(), bodies);
    model.state.position[0] = -std::f64::consts::FRAC_PI_4;
    model
}

/// The lower end of the last rod of a [`planar_chain`]: x and z.
pub fn planar_chain_tip(bodies: &[BodyState]) -> (f64, f64) {
    let last = bodies[bodies.len() - 1];
    let tip = last.position + last.rotation * Vector3::new(0.0, 0.0, -0.5);
    (tip.x, tip.z)
}

/// Every joint kind.
pub const JOINT_KINDS: [JointKind; 5] =
    [JointKind::Revolute, JointKind::Prismatic, JointKind::Planar, JointKind::Spherical, JointKind::Floating];

/// A chain of two bodies with the same kind of joint twice, on frames that are aligned with nothing, in a generic state.
pub fn one_joint(kind: JointKind) -> Model {
    let first = Joint::new(
        "first",
        kind,
        turned_frame(Vector3::new(0.2, -0.1, 0.3), Vector3::new(0.5, -0.4, 0.3)),
        turned_frame(Vector3::new(0.1, 0.2, 0.4), Vector3::new(-0.3, 0.6, 0.7)),
    );
    let second = Joint::new(
        "second",
        kind,
        turned_frame(Vector3::new(-0.1, 0.15, -0.5), Vector3::new(0.9, 0.2, -0.5)),
        turned_frame(Vector3::new(0.05, -0.1, 0.35), Vector3::new(-0.7, -0.2, 0.4)),
    );
    let mut model = model(
        kind.name(),
        gravity(),
        vec![
            body("inner", None, 2.0, box_inertia(2.0, Vector3::new(0.3, 0.5, 0.9)), first),
            body("outer", Some(0), 1.0, box_inertia(1.0, Vector3::new(0.4, 0.3, 0.7)), second),
        ],
    );
    set_generic_state(&mut model);
    model
}

/// Largest distance between two states: metres, rotation-matrix entries.
pub fn pose_distance(a: &[BodyState], b: &[BodyState]) -> f64 {
    let of_body =
        |(a, b): (&BodyState, &BodyState)| (a.position - b.position).amax().max((a.rotation - b.rotation).amax());
    a.iter().zip(b).map(of_body).fold(0.0, f64::max)
}

/// Largest distance between the velocities of two states: m/s, rad/s.
pub fn velocity_distance(a: &[BodyState], b: &[BodyState]) -> f64 {
    let of_body = |(a, b): (&BodyState, &BodyState)| {
        (a.velocity - b.velocity).amax().max((a.angular_velocity - b.angular_velocity).amax())
    };
    a.iter().zip(b).map(of_body).fold(0.0, f64::max)
}

/// The second-moment matrix `Σ = ½ tr(J) 1 − J` of a body.
pub fn second_moments(body: &Body) -> Matrix3<f64> {
    Matrix3::from_diagonal(&(Vector3::repeat(0.5 * body.inertia.sum()) - body.inertia))
}

/// Dampers in every freedom, each with its own coefficient.
pub fn joint_dampers(mechanism: &Mechanism) -> Forces {
    let damper = |freedom: usize| JointDamper { freedom, coefficient: 0.06 + 0.02 * (freedom % 4) as f64 };
    Forces { joint_dampers: (0..mechanism.velocity_count).map(damper).collect(), ..Forces::default() }
}

/// Springs along every scalar coordinate.
pub fn joint_springs(mechanism: &Mechanism) -> Forces {
    let coordinates = (0..mechanism.velocity_count).filter_map(|freedom| scalar_coordinate(mechanism, freedom));
    let spring = |coordinate| JointSpring { coordinate, stiffness: 4.0, rest: 0.2 };
    Forces { joint_springs: coordinates.map(spring).collect(), ..Forces::default() }
}

/// Constant efforts in every freedom.
pub fn joint_loads(mechanism: &Mechanism) -> Forces {
    let load = |freedom: usize| JointLoad { freedom, effort: 0.1 - 0.06 * (freedom % 3) as f64 };
    Forces { joint_loads: (0..mechanism.velocity_count).map(load).collect(), ..Forces::default() }
}

/// A point off the centre of a body, or of the world.
pub fn point_of(body: Option<usize>, place: [f64; 3]) -> Attachment {
    Attachment { body, frame: Pose::translation(place[0], place[1], place[2]) }
}

/// Springs with dampers from the world to the first body and from there to the last.
pub fn point_springs(mechanism: &Mechanism) -> Forces {
    let spring = |name: &str, a, b| PointSpring {
        name: name.to_string(),
        a,
        b,
        stiffness: 15.0,
        damping: 0.8,
        rest_length: 0.6,
    };
    let first = point_of(Some(0), [0.1, -0.2, 0.05]);
    let mut springs = vec![spring("outer", point_of(None, [0.9, 0.4, 1.1]), first)];
    if mechanism.bodies.len() > 1 {
        let last = point_of(Some(mechanism.bodies.len() - 1), [-0.1, 0.1, -0.2]);
        springs.push(spring("inner", last, point_of(Some(0), [0.05, 0.3, 0.1])));
    }
    Forces { point_springs: springs, ..Forces::default() }
}

/// A constant force and torque on the last body.
pub fn wrenches(mechanism: &Mechanism) -> Forces {
    let wrench = Wrench {
        body: mechanism.bodies.len() - 1,
        point: Vector3::new(0.1, 0.2, -0.1),
        force: Vector3::new(1.5, -0.7, 2.0),
        torque: Vector3::new(0.2, 0.4, -0.3),
    };
    Forces { wrenches: vec![wrench], ..Forces::default() }
}

/// Every kind of force alone, then all together; with their names.
pub fn every_force(mechanism: &Mechanism) -> Vec<(&'static str, Forces)> {
    let parts = [joint_dampers, joint_springs, joint_loads, point_springs, wrenches].map(|build| build(mechanism));
    let [dampers, springs, loads, lines, wrenches] = parts.clone();
    let all = Forces {
        joint_dampers: dampers.joint_dampers,
        joint_springs: springs.joint_springs,
        joint_loads: loads.joint_loads,
        point_springs: lines.point_springs,
        wrenches: wrenches.wrenches,
    };
    let names = ["joint dampers", "joint springs", "joint loads", "point springs", "wrenches"];
    names.into_iter().zip(parts).chain([("all forces", all)]).collect()
}

/// The model with forces.
pub fn with_forces(mut model: Model, forces: Forces) -> Model {
    model.mechanism.forces = forces;
    model
}
