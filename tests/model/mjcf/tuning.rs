//! Damping and stiffness that follow from inertia, inherited ranges, and actuators on joints that follow one another.

use catena::mechanism::description::nonsmooth::MotorLaw;
use catena::session::{Model, Simulation};

/// A body that floats, an arm with two fingers, and a tail on a ball joint.
const BEAST: &str = "<mujoco><compiler angle='radian'/><worldbody>
  <body name='base' pos='0 0 1' euler='0.1 0.2 0.3'><freejoint/><geom type='box' size='.2 .1 .05' mass='3' pos='0.02 0 0'/>
   <body name='arm' pos='0.2 0 0' euler='0.3 0.2 0.1'><joint name='a' axis='0 1 0.5' armature='0.03' springdamper='0.2 0.7' pos='0.1 0 0'/><geom type='capsule' fromto='0 0 0 0.1 0.2 -.5' size='.03' mass='1'/>
    <body name='fore' pos='0 0.1 -.5' euler='0.4 0 0.7'><joint name='b' axis='0 1 0' ref='0.2' range='-1 1.5'/><geom type='box' pos='0.1 0 0' size='.1 .2 .03' mass='2'/>
     <body name='f1' pos='0 0.1 -.3'><joint name='s1' type='slide' axis='0 1 0' range='0 0.04'/><geom type='box' size='.01 .01 .03' mass='.1'/></body>
     <body name='f2' pos='0 -0.1 -.3'><joint name='s2' type='slide' axis='0 -1 0' range='0 0.04' ref='0.01'/><geom type='box' size='.01 .01 .03' mass='.2'/></body></body></body>
   <body name='tail' pos='-0.2 0 0'><joint name='ball' type='ball'/><geom type='capsule' fromto='0 0 0 -.3 0 0' size='.03' mass='0.5'/>
    <body name='tip' pos='-0.3 0 0'><joint name='c' axis='0 0 1'/><geom size='.04' mass='.1' pos='-.1 0 0'/></body></body></body>
  </worldbody>
  <tendon><fixed name='split'><joint joint='s1' coef='.5'/><joint joint='s2' coef='.5'/></fixed></tendon>
  <equality><joint joint1='s2' joint2='s1' polycoef='0.001 3'/></equality>
  <actuator><position joint='a' kp='30' dampratio='0.9' gear='2'/><position joint='b' kp='10' dampratio='1' inheritrange='0.8'/>
   <general joint='c' gainprm='4' biastype='affine' biasprm='0 -4 0.5'/>
   <general tendon='split' forcerange='-100 100' ctrlrange='0 255' gainprm='0.01568627451 0 0' biastype='affine' biasprm='0 -100 -10'/></actuator>
</mujoco>";

#[test]
fn damping_ratios_and_time_constants_give_what_mujoco_computes_from_the_inertia_at_the_start() {
    let folder = crate::common::command::folder("mjcf_tuning");
    std::fs::write(folder.join("model.xml"), BEAST).expect("written");
    let model = Model::load(folder.join("model.xml")).expect("a model");
    let mechanism = &model.description().mechanism;
    // Both sum some ten terms and invert a matrix of 14 rows whose entries differ by 1e4: rounding of 1e-12 of each number.
    let near =
        |found: f64, known: f64, what: &str| assert!((found - known).abs() < 1e-11 * known, "{what}: {found} {known}");
    // MuJoCo 4.0.0.
    near(mechanism.forces.joint_springs[0].stiffness, 8.944752889325088, "a");
    near(mechanism.forces.joint_dampers[0].coefficient, 1.7531715663077174, "a");
    let motors = &mechanism.nonsmooth.motors;
    // The actuators of a (with the gear 2), b and c, and the one of both fingers on the finger that leads: a stiffness of 100 N/m at half of the sum
    // of both positions, 2 q + 0.0055 m with the offset and the reference: a gear of 2.
    let known =
        [(120.0, 2.0640268666196557 * 4.0), (10.0, 1.1702112392328667), (4.0, 0.046328942904404695), (400.0, 40.0)];
    assert_eq!(motors.len(), known.len());
    for (motor, (stiffness, damping)) in motors.iter().zip(known) {
        let MotorLaw::Position { kp, kd } = motor.law else { panic!("{motor:?}") };
        near(kp, stiffness, "stiffness");
        near(kd, damping, "damping");
    }
    let target = |index: usize| motors[index].effort(0.0, 0.0, 0.0) / known[index].0;
    assert!((target(3) + 0.00275).abs() < 1e-15, "{}", target(3));
    // The control 0 is in the inherited range from −0.75 to 1.25, and the joint is at 0.2 where it is counted as zero here.
    assert!((target(1) + 0.2).abs() < 1e-15, "{}", target(1));
    let narrow = BEAST.replace("range='-1 1.5'", "range='0.5 1.5'");
    std::fs::write(folder.join("model.xml"), narrow).expect("written");
    let model = Model::load(folder.join("model.xml")).expect("a model");
    // 0.8 of half a radian below the middle of 1.
    let target = model.description().mechanism.nonsmooth.motors[1].effort(0.0, 0.0, 0.0) / 10.0;
    assert!((target - 0.4).abs() < 1e-15, "{target}");
}

#[test]
fn an_actuator_that_depends_on_a_tendon_of_independent_joints_is_said_to_be_left_out() {
    let folder = crate::common::command::folder("mjcf_independent");
    let text = BEAST.replace("<equality><joint joint1='s2' joint2='s1' polycoef='0.001 3'/></equality>", "");
    std::fs::write(folder.join("model.xml"), text).expect("written");
    let model = Model::load(folder.join("model.xml")).expect("a model");
    assert_eq!(model.description().mechanism.nonsmooth.motors.len(), 3);
    let warnings = model.warnings();
    assert!(warnings.iter().any(|line| line.contains("tendon of independent joints")), "{warnings:?}");
}

#[test]
fn damping_of_a_free_joint_is_drag_and_gravcomp_a_force_against_the_weight() {
    let folder = crate::common::command::folder("mjcf_free");
    let text = "<mujoco><worldbody><body name='ball' pos='0 0 5'><joint type='free' damping='3'/><geom size='0.1' mass='2' pos='0 0 0'/></body>
      <body name='held' pos='1 0 5' gravcomp='0.5'><freejoint/><geom size='0.1' mass='2' pos='0.1 0 0'/></body></worldbody></mujoco>";
    std::fs::write(folder.join("model.xml"), text).expect("written");
    let mut simulation = Simulation::new(&Model::load(folder.join("model.xml")).expect("a model")).duration(1.0);
    simulation.run().expect("a run");
    let height = |link: &str| simulation.pose(link).expect("a link").translation.z;
    // With drag v = −g/k (1 − e^(−kt)), k = 3/2 per second; with half of the weight held a fall of g t²/4. The tolerance is 1e-6 m.
    let k = 1.5_f64;
    let fallen = 9.81 / k * (1.0 - (1.0 - (-k).exp()) / k);
    assert!((height("ball/ball") - (5.0 - fallen)).abs() < 1e-6, "{}", height("ball/ball"));
    assert!((height("held/held") - (5.0 - 9.81 / 4.0)).abs() < 1e-12, "{}", height("held/held"));
    let unknown = text.replace("damping='3'", "class='none'");
    std::fs::write(folder.join("model.xml"), unknown).expect("written");
    let error = Model::load(folder.join("model.xml")).expect_err("an error").to_string();
    assert!(
        error.contains("model.xml:1: <joint class=\"none\">: there is no class \"none\" among the defaults"),
        "{error}"
    );
}
