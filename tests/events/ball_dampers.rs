//! Damping of a ball joint brakes all turning alike, `τ = −c ω`, in free flight of a body about its centre.
//!
//! ```text
//!     I ω̇ = −c ω,   J = I 1:     ω(t) = ω₀ exp(−c t/I),    φ(t) = (I/c) |ω₀| (1 − exp(−c t/I)) about ω₀
//! ```

use crate::common::scratch;
use crate::scene_files::report;
use catena::report::Numbers;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// Two times the tolerance that is asked for.
const BOUND: f64 = 2e-9;

#[test]
fn a_damped_ball_turns_about_the_axis_of_its_rate_until_the_rate_has_decayed() {
    let (moment, coefficient, time) = (0.02, 0.03, 1.5);
    let folder = scratch("ball_dampers");
    let robot = format!(
        "<robot name='r'><link name='base'/><link name='body'><inertial><mass value='1.3'/><inertia ixx='{moment}' iyy='{moment}' izz='{moment}' ixy='0' \
         ixz='0' iyz='0'/></inertial></link><joint name='ball' type='spherical'><parent link='base'/><child link='body'/>\
         <origin xyz='0.1 0 0' rpy='0.3 -0.4 0.9'/><dynamics damping='{coefficient}'/></joint></robot>"
    );
    std::fs::write(folder.join("r.urdf"), robot).expect("a robot");
    let file = folder.join("scene.toml");
    let rate = Vector3::new(1.7, -3.1, 2.3);
    let scene = format!("[[robot]]\nurdf = \"r.urdf\"\nvelocities = {{ ball = {:?} }}\n", rate.as_slice());
    std::fs::write(&file, scene).expect("a scene");
    let end = report(&file, &[], &[], Some(time), 1e-9);
    let (_, joint) = end.joints.iter().find(|(name, _)| name == "ball").expect("the ball");
    let (Numbers::Many(position), Numbers::Many(velocity)) = (&joint.position, &joint.velocity) else {
        panic!("four and three numbers: {joint:?}")
    };
    let decayed = (-coefficient * time / moment).exp();
    let turned = UnitQuaternion::from_scaled_axis(rate * (moment / coefficient) * (1.0 - decayed));
    let reached = UnitQuaternion::from_quaternion(Quaternion::new(position[0], position[1], position[2], position[3]));
    assert!(reached.angle_to(&turned) < BOUND, "{reached} instead of {turned}");
    let off = Vector3::from_column_slice(velocity) - rate * decayed;
    assert!(off.norm() < BOUND, "off by {off}");
    let heat = 0.5 * moment * rate.norm_squared() * (1.0 - decayed * decayed);
    assert!((end.energy.dissipated - heat).abs() < BOUND, "{} J instead of {heat}", end.energy.dissipated);
}
