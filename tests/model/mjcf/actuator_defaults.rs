//! Defaults of actuators: one set for all kinds of a class.

use crate::common::command;
use catena::session::Model;
use std::fmt::Write;

/// Classes of defaults.
const CLASSES: &str = "<motor gear='2'/><general gainprm='3'/>
  <default class='servo'><position kp='5' kv='0.5' forcerange='-9 9'/>
   <default class='speed'><velocity kv='7' gear='3'/><default class='plain'><motor gear='4'/></default></default></default>
  <default class='lag'><position kp='5' kv='0.5'/><general gainprm='6' biasprm='0.1'/></default>
  <default class='both'><velocity kv='7'/><position kp='4' dampratio='1'/></default>
  <default class='brake'><damper kv='2' ctrlrange='0 1'/></default>
  <default class='piston'><cylinder timeconst='0.3' area='2' bias='1 -2 -3'/></default>
  <default class='range'><intvelocity kp='6' inheritrange='0.5'/></default>";

/// Actuators of these classes, and their efforts (N) in MuJoCo 4.0.0 at 0.3 m and 0.2 m/s with the control 0.5 and the activation 0.25.
const EFFORTS: [(&str, f64); 30] = [
    ("position", -0.6),
    ("velocity", 0.6),
    ("motor", 1.0),
    ("general", 3.0),
    ("position class='servo'", -1.4),
    ("velocity class='servo'", 0.6),
    ("general class='servo'", -1.4),
    ("motor class='servo'", 1.0),
    ("position class='servo' kp='2'", -0.8),
    ("position class='speed'", -6.9),
    ("velocity class='speed'", -2.1),
    ("general class='speed'", -2.1),
    ("position class='plain'", -15.6),
    ("velocity class='plain'", -8.4),
    ("general class='plain'", 2.0),
    ("position class='lag'", -1.6),
    ("velocity class='lag'", 1.2),
    ("velocity class='both'", 0.6),
    ("position class='both'", -3.062741699796952),
    ("general class='both'", -3.062741699796952),
    ("damper class='brake'", -0.8),
    ("general class='brake'", -0.8),
    ("motor class='brake'", 1.0),
    ("velocity class='brake'", 0.6),
    ("cylinder class='piston'", -1.8),
    ("general class='piston'", -1.8),
    ("position class='piston'", -0.6),
    ("intvelocity class='range'", -4.2),
    ("position class='range'", -0.6),
    ("general class='lag' biastype='none'", 6.0),
];

#[test]
fn defaults_of_any_kind_of_actuator_reach_all_kinds_of_their_class_as_in_mujoco() {
    let (mut bodies, mut actuators) = (String::new(), String::new());
    for (index, (actuator, _)) in EFFORTS.iter().enumerate() {
        let joint = format!("<joint name='j{index}' type='slide' axis='1 0 0' range='-2 4'/>");
        write!(bodies, "<body>{joint}<geom size='.1' mass='2' contype='0' conaffinity='0'/></body>").expect("a text");
        write!(actuators, "<{actuator} joint='j{index}'/>").expect("a text");
    }
    let all = |number: &str| vec![number; EFFORTS.len()].join(" ");
    let (at, rates, controls) = (all("0.3"), all("0.2"), all("0.5"));
    let text = format!(
        "<mujoco><option gravity='0 0 0'/><default>{CLASSES}</default><worldbody>{bodies}</worldbody><actuator>{actuators}</actuator>
         <keyframe><key name='k' qpos='{at}' qvel='{rates}' ctrl='{controls}' act='0.25 0.25 0.25'/></keyframe></mujoco>"
    );
    let folder = command::folder("mjcf_actuator_defaults");
    std::fs::write(folder.join("model.xml"), text).expect("written");
    let model = Model::loader().keyframe("k").load(folder.join("model.xml")).expect("a model");
    let motors = &model.description().mechanism.nonsmooth.motors;
    assert_eq!(motors.len(), EFFORTS.len(), "{:#?}", model.warnings());
    for (index, (actuator, wanted)) in EFFORTS.iter().enumerate() {
        let ending = format!("/j{index}");
        let joint = model.joint_names().iter().position(|name| name.ends_with(&ending)).expect("a joint");
        let motor = motors.iter().find(|motor| motor.coordinate.freedom == joint).expect("a motor");
        let effort = motor.effort(0.0, 0.3, 0.2);
        // Some roundings of sums of numbers below 40.
        assert!((effort - wanted).abs() < 1e-13, "{actuator}: {effort} {wanted}");
    }
}

#[test]
fn defaults_of_equalities_are_one_set_for_all_constraints() {
    let text = "<mujoco><default><equality active='false'/></default><worldbody><body name='a'><joint name='j'/><geom size='.1'/></body></worldbody>
      <equality><joint joint1='j'/>
      <connect body1='a' anchor='1 0 0' active='true'/></equality></mujoco>";
    let scene = super::read("mjcf_equality_defaults", text).expect("a scene");
    let told: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
    assert!(
        told.iter().any(|line| line.contains("model.xml:2: a constraint that is not active is left out")),
        "{told:#?}"
    );
    assert_eq!(scene.loops.len(), 1);
}
