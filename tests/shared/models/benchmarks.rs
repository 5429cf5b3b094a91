//! Benchmark problems: heavy tops, a thrown box and a chain of rods, each with its answers.
//!
//! Published and converged answers are those of the project's page of benchmark problems (`benchmarks.md`: sections
//! "Heavy top", "Free box / Dzhanibekov" and "Chains and double pendula"), which names its own sources.

use super::{Model, body, box_inertia, frame, gravity, model};
use catena::model::{Joint, JointKind, Pose};
use catena::state::BodyState;
use nalgebra::Vector3;

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
