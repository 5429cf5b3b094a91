//! Benchmark problems: heavy tops, a thrown box and a chain of rods, each with its answers.
//!
//! Each answer is published (its source is named beside it) or computed with 19 digits and more, until finer steps changed no printed digit.

#![allow(clippy::excessive_precision, reason = "reference values stand as their source prints them")]

use super::{Model, body, box_inertia, frame, gravity, model};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::joint::{Joint, JointKind, Pose};
use nalgebra::Vector3;

/// A pose at an instant, as the tables print it.
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
        let rotation = crate::mechanism::description::joint::rotation_from_wxyz(&self.quaternion);
        (body.position - Vector3::from(self.position)).amax().max((body.rotation - rotation).amax())
    }
}

/// Answers of [`slow_heavy_top`], computed to all digits ("Heavy top", slow; Géradin and Cardona 2001).
pub const SLOW_HEAVY_TOP: [PoseReference; 2] = [
    PoseReference {
        time: 0.5,
        position: [0.0072227982418607084, 0.40584229862183535, -0.91391458016321325],
        quaternion: [0.77917218196325344, -0.50493651389629446, 0.30953490944567191, -0.20522662503520242],
    },
    PoseReference {
        time: 1.0,
        position: [-0.03116864706262382, -0.9833836814196768, -0.17884364835735481],
        quaternion: [0.055456119087688847, -0.73257204651672281, 0.072337944025896037, -0.67455914297572073],
    },
];

/// Answers of [`heavy_top`], computed to all digits ("Heavy top", fast; StHante/heavy_top, Géradin and Cardona 2001).
pub const HEAVY_TOP: [PoseReference; 4] = [
    PoseReference {
        time: 0.1,
        position: [0.42129665892540202, 0.89457197434559299, -0.14916470056189962],
        quaternion: [0.33182291260830082, 0.17733805666693703, 0.91497515913872796, -0.14582601443088863],
    },
    PoseReference {
        time: 0.2,
        position: [0.60555056137711982, 0.59895768179491915, -0.52398302743000313],
        quaternion: [-0.70827915297431254, 0.4387810881265819, 0.54572839614541768, 0.089399752824005016],
    },
    PoseReference {
        time: 0.5,
        position: [-0.70246829705658564, -0.021165184701923325, -0.71140025765173442],
        quaternion: [0.58456062406941467, -0.7006628954122065, 0.3843257530228944, 0.14019307880043519],
    },
    PoseReference {
        time: 1.0,
        position: [0.17334396409838604, 0.64008859207056878, -0.7484907911335813],
        quaternion: [0.73294398067966371, -0.2782857193376127, 0.53182461133416259, -0.32017614273624928],
    },
];

/// The heavy top of M. Géradin and A. Cardona, "Flexible Multibody Dynamics", Wiley 2001, with its centre of mass 1 m along y from the fixed point, spun with the body
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

/// Answers of [`free_body`]: time, quaternion w, x, y, z and body angular velocity ("Free box", complex; scpeters/benchmark, boxes.cc).
pub const FREE_BODY: [(f64, [f64; 4], [f64; 3]); 4] = [
    (
        1.0,
        [-0.71310999652858054, 0.35235939104587477, 0.52518419088836876, -0.30248728573895067],
        [3.4237984415545983, 2.8191854383979655, 3.9283844494670332],
    ),
    (
        2.0,
        [0.014628222352809942, -0.99544641687577395, -0.027380467565805464, 0.090126334863110794],
        [0.33664976078395559, -4.9849329351898994, 0.38218188130455649],
    ),
    (
        5.0,
        [0.89569873178568193, -0.015154650511098407, -0.44323508372896231, 0.032199052737421179],
        [0.3749907796859408, 4.9809468810095403, -0.42660324532220523],
    ),
    (
        10.0,
        [0.22516456341395816, -0.61992756249945247, -0.27702915068719458, 0.69874572364031018],
        [2.7558404051468495, -3.7359635192162197, -3.1618090034675181],
    ),
];

/// The box of scpeters/benchmark (`boxes.cc`), 0.1 × 0.4 × 0.9 m and 10 kg, thrown with a spin near its intermediate axis under
/// 9.8 m/s²; the centre follows `(−2, 2, 8) t + ½ g t²` and the rotation [`FREE_BODY`].
pub fn free_body() -> Model {
    let joint = Joint::new("free", JointKind::Floating, Pose::identity(), Pose::identity());
    let inertia = box_inertia(10.0, Vector3::new(0.1, 0.4, 0.9));
    let mut model = model("free_body", Vector3::new(0.0, 0.0, -9.8), vec![body("box", None, 10.0, inertia, joint)]);
    model.state.velocity = vec![-2.0, 2.0, 8.0, 0.1, 5.0, 0.1];
    model
}

/// Time; x and z of the tip; absolute angles of the first and of the last link.
pub type ChainAnswer = (f64, [f64; 4]);

/// Answers of [`planar_chain`] by number of links ("Chains and double pendula", slender; after the chains of ConstrainedDynamics.jl,
/// WAFR2020_experiments, 05performance_pendulum.jl).
pub const PLANAR_CHAIN: [(usize, [ChainAnswer; 4]); 4] = [
    (
        1,
        [
            (1.0, [-0.62349713511687688, -0.78182563433354313, -0.67320780539353942, -0.67320780539353942]),
            (2.0, [0.35628337030018781, -0.93437795353247677, 0.36428721055668184, 0.36428721055668184]),
            (5.0, [0.66150140209431196, -0.74994392792212106, 0.72281901675303095, 0.72281901675303095]),
            (10.0, [0.51702394091770754, -0.85597093672502855, 0.54337046260010369, 0.54337046260010369]),
        ],
    ),
    (
        2,
        [
            (1.0, [-1.2996809166734178, -1.5072258765296855, -0.6125616956342993, -0.81062163357961547]),
            (2.0, [0.83942797435755978, -1.7713187475301466, 0.24260660519116292, 0.6424943183729056]),
            (5.0, [1.3380917082706478, -1.48101396536259, 0.67124206207065662, 0.79824554273679504]),
            (10.0, [1.0728298206051816, -1.640155336197975, 0.37858173341930484, 0.77992601145540785]),
        ],
    ),
    (
        5,
        [
            (1.0, [-0.21699630894211752, -4.991797466010115, -0.051530946855297764, 0.01218625370849539]),
            (2.0, [-3.6374514624764447, -3.3943677007073396, -0.69101559408934143, -0.88959614197250192]),
            (5.0, [-1.3538795002007806, -4.7742193706472147, -0.11201596070207195, -0.46574613751962157]),
            (10.0, [-3.1795454449721978, -3.7776517651265764, -0.5110801520296443, -0.88273147387081841]),
        ],
    ),
    (
        10,
        [
            (1.0, [3.9378119839602022, -8.8552619087095543, 0.15958326092100203, 0.75910259562780391]),
            (2.0, [-5.9098898320242403, -7.427284524160787, -0.30976053016588384, -1.2638631560824334]),
            (5.0, [6.9048458233608327, -6.8949335987114964, 0.45783075463145578, 1.2410173314883801]),
            (10.0, [4.5987504311334506, -8.4776573542354932, 0.18741170489991965, 0.96512204856672235]),
        ],
    ),
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
